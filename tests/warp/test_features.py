"""Features follow the surfaces that a frame shows, whatever made the frame."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest

import belvedere as bv
from belvedere.ground.errors import BelvedereError
from belvedere.warp import FEATURE_FILTERS, RECONSTRUCTIONS, prepare
from belvedere.warp.warp import nearest_order
from tests.oracles.features import look_up_features
from tests.warp.worlds import (
    boards,
    grey,
    noise,
    plane_disparity,
    random_camera,
    straight_camera,
    view_of,
)

RNG = np.random.default_rng
SIZE = 48, 40


def board_views(channels: int, seed: int = 3, count: int = 2) -> list[bv.ReferenceView]:
    """References side by side before their own boards, with smooth features."""
    rng = RNG(seed)
    views = []
    for n in range(count):
        camera = straight_camera(*SIZE).moved((0.25 * n, 0, 0.05 * n))
        u, v = camera.pixel_grid()
        phase = np.arange(channels) * 0.7 + 1
        waves = np.sin((u / 9 + v / 7)[..., None] * phase / channels + phase)
        disparity = boards(rng, SIZE[1], SIZE[0])[0]
        views.append(
            bv.ReferenceView(camera, noise(rng, SIZE[1], SIZE[0]), disparity, waves.astype("f4"))
        )
    return views


def between(views: list[bv.ReferenceView]) -> bv.Camera:
    return straight_camera(44, 38).moved((0.1, 0.03, 0.02))


@pytest.mark.parametrize("feature_filter", FEATURE_FILTERS)
@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_a_view_warped_to_its_own_camera_keeps_its_features_to_the_last_bit(
    reconstruction: Any, feature_filter: Any
) -> None:
    view = board_views(5)[0]
    assert view.features is not None
    features = view.features.copy()
    features[::3, ::2] = -0.0
    disparity = view.disparity.copy()
    disparity[RNG(1).random(disparity.shape) < 0.1] = np.nan
    own = bv.ReferenceView(view.camera, view.color, disparity, features)
    frame = bv.warp(own, view.camera, reconstruction=reconstruction, feature_filter=feature_filter)
    assert frame.features is not None
    known = ~np.isnan(disparity)
    assert frame.features[known].tobytes() == features[known].tobytes()
    assert np.isnan(frame.features[~known]).all()


@pytest.mark.parametrize("feature_filter", FEATURE_FILTERS)
@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_features_are_those_of_the_slow_twin(reconstruction: Any, feature_filter: Any) -> None:
    views = board_views(3, seed=8)
    camera = between(views)
    options = bv.WarpOptions(reconstruction=reconstruction, feature_filter=feature_filter)
    frame = bv.warp(views, camera, options=options)
    prepared = [prepare(view) for view in views]
    ordered = [prepared[n] for n in nearest_order(prepared, camera)]
    wanted = look_up_features(frame, ordered, options.surface_tolerance, feature_filter)
    asked = ~np.isnan(wanted[..., 0])
    assert asked.mean() > 0.8
    assert frame.features is not None
    off = abs(frame.features - wanted).max(axis=-1)[asked]
    # float32 and float64 may fall on two sides of a cell's border or of a tolerance
    assert (off < 1e-4).mean() > 0.998, np.sort(off)[-10:]


@pytest.mark.parametrize("feature_filter", ["cubic", "linear"])
@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_what_is_affine_on_the_picture_of_a_plane_comes_back_exactly(
    reconstruction: Any, feature_filter: Any
) -> None:
    rng = RNG(11)
    normal, offset = np.array([0.2, 1.0, -0.15]), 4.0
    views = []
    for x in (0.0, 0.3):
        camera = straight_camera(64, 48).moved((x, 0, 0))
        u, v = np.broadcast_arrays(*camera.pixel_grid())
        # three coordinates of the plane's point, each times disparity: affine in (u, v)
        delta = plane_disparity(camera, normal, offset)
        features = np.stack([0.3 * u - 0.2 * v + 1, delta, u * 0 + 2], -1).astype(np.float32)
        views.append(bv.ReferenceView(camera, noise(rng, 48, 64), delta.astype("f4"), features))
    desired = straight_camera(40, 30, focal=52).moved((0.12, 0.2, 0.05))
    frame = bv.warp(views[0], desired, reconstruction=reconstruction, feature_filter=feature_filter)
    assert frame.features is not None
    inner = np.s_[6:-6, 6:-6]
    x, y = np.broadcast_arrays(*desired.pixel_grid())
    points = desired.unproject(x, y, frame.disparity.astype(float))
    assert isinstance(views[0].camera, bv.Camera)
    u, v, delta = views[0].camera.project(points)
    wanted = np.stack([0.3 * u - 0.2 * v + 1, delta, u * 0 + 2], -1)
    assert (frame.coverage[inner] > 0).mean() > 0.9
    # what samples show is the disparity of one beside the pixel
    exact = reconstruction not in ("point", "splat", "offset")
    tolerance = [2e-4, 2e-6 if exact else 2e-3, 1e-6]
    off = abs(frame.features - wanted)[inner][frame.coverage[inner] > 0]
    assert (off <= tolerance).all(), off.max(axis=0)


@pytest.mark.parametrize("composite", ["blend", "nearest"])
def test_colours_given_as_features_are_the_colours_inside_surfaces(composite: Any) -> None:
    views = []
    v, u = np.mgrid[0 : SIZE[1], 0 : SIZE[0]] / np.array([SIZE[1], SIZE[0]])[:, None, None]
    for n, view in enumerate(board_views(3)):
        # it grows along both axes, so that no cubic leaves the range that colours are kept in
        rise = (1.0 + n) * u**2 + v**3
        color = np.stack([0.1 + rise, 0.2 + 2 * rise, 0.3 + 0.5 * rise], -1).astype(np.float32)
        delta = np.full(view.disparity.shape, 0.2 + 0.0 * n, np.float32)
        views.append(bv.ReferenceView(view.camera, color, delta, color))
    frame = bv.warp(views, between(views), composite=composite)
    assert frame.features is not None
    inside = np.zeros(frame.coverage.shape, bool)
    inside[5:-5, 5:-5] = frame.coverage[5:-5, 5:-5] == 1
    assert inside.mean() > 0.5
    np.testing.assert_allclose(frame.features[inside], frame.color[inside], atol=1e-5)


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_nearest_never_mixes_labels(reconstruction: Any) -> None:
    views = []
    for n, view in enumerate(board_views(1)):
        labels = RNG(n).choice([3, 17, 1000], (*view.disparity.shape, 1))
        views.append(bv.ReferenceView(view.camera, view.color, view.disparity, labels))
    frame = bv.warp(views, between(views), reconstruction=reconstruction, feature_filter="nearest")
    assert frame.features is not None
    shown = frame.features[frame.coverage > 0]
    assert set(np.unique(shown)) == {3, 17, 1000}


@pytest.mark.parametrize("feature_filter", FEATURE_FILTERS)
@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_covered_pixels_have_features_and_holes_have_none(
    reconstruction: Any, feature_filter: Any
) -> None:
    for seed in range(4):
        views = board_views(2, seed)
        camera = random_camera(RNG(seed), 40, 36, reach=0.3, turn=0.2)
        for fill in ("none", "background"):
            frame = bv.warp(
                views, camera, reconstruction=reconstruction, feature_filter=feature_filter,
                fill=fill,
            )  # fmt: skip
            assert frame.features is not None
            np.testing.assert_array_equal(
                ~np.isnan(frame.features), np.repeat(frame.coverage[..., None] > 0, 2, axis=2)
            )


def test_surfaces_do_not_mix() -> None:
    disparity, label = boards(RNG(4), SIZE[1], SIZE[0], count=6)
    view = bv.ReferenceView(
        straight_camera(*SIZE), grey(SIZE[1], SIZE[0]), disparity, (label > 0)[..., None]
    )
    frame = bv.warp(view, straight_camera(*SIZE).moved((0.05, 0, 0.02)), feature_filter="linear")
    assert frame.features is not None
    values = frame.features[frame.coverage > 0]
    assert ((abs(values) < 1e-5) | (abs(values - 1) < 1e-5)).all()
    near = frame.disparity > 0.25
    assert ((frame.features[..., 0] > 0.5) == near)[frame.coverage > 0].all()


def test_a_sample_without_features_is_never_mixed_into_others() -> None:
    views = []
    for n, view in enumerate(board_views(2)):
        assert view.features is not None
        features = np.full_like(view.features, 7.0)
        features[RNG(n).random(view.disparity.shape) < 0.3] = np.nan
        views.append(bv.ReferenceView(view.camera, view.color, view.disparity, features))
    for feature_filter in FEATURE_FILTERS:
        frame = bv.warp(views, between(views), feature_filter=feature_filter)
        assert frame.features is not None
        covered = frame.features[frame.coverage > 0]
        known = ~np.isnan(covered)
        np.testing.assert_allclose(covered[known], 7.0, rtol=1e-6)
        assert known.mean() > 0.99
    last, nothing = views[-1], np.full((SIZE[1], SIZE[0], 2), np.nan)
    none = bv.ReferenceView(last.camera, last.color, last.disparity, nothing)
    frame = bv.warp(none, between(views))
    assert frame.features is not None
    assert np.isnan(frame.features).all()


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_features_are_the_same_bytes_for_any_number_of_threads(reconstruction: Any) -> None:
    views = [
        view_of(straight_camera(190, 170).moved((x, 0, 0)), boards(RNG(1), 170, 190)[0])
        for x in (0.0, 0.1)
    ]
    rng = RNG(6)
    given = [
        bv.ReferenceView(v.camera, v.color, v.disparity, rng.normal(size=(170, 190, 3)))
        for v in views
    ]
    camera = straight_camera(200, 180).moved((0.04, 0, 0.01))
    frames = [
        bv.warp(given, camera, reconstruction=reconstruction, threads=n) for n in (1, 2, 3, 4)
    ]
    held = [frame.features for frame in frames]
    assert held[0] is not None
    assert all(one is not None and one.tobytes() == held[0].tobytes() for one in held)


def test_frames_chain_with_their_features_and_a_warper_gives_the_same() -> None:
    views = board_views(4)
    camera = between(views)
    frame = bv.warp(views, camera, fill="background")
    again = bv.warp(frame.as_view(), camera)
    assert frame.features is not None
    assert again.features is not None
    known = frame.coverage > 0
    np.testing.assert_array_equal(again.features[known], frame.features[known])
    warper = bv.Warper(camera.width, camera.height)
    first = warper.warp(views, camera).features
    assert first is not None
    np.testing.assert_array_equal(first, frame.features)
    second = warper.warp(views, camera.moved((0.2, 0, 0))).features
    assert second is not None
    assert np.shares_memory(first, second)
    assert warper.warp([bv.ReferenceView(v.camera, v.color, v.disparity) for v in views],
                       camera).features is None  # fmt: skip


def test_views_without_features_give_frames_without() -> None:
    assert bv.warp(view_of(straight_camera(8, 6), np.full((6, 8), 0.5)),
                   straight_camera(8, 6)).features is None  # fmt: skip


def test_hundreds_of_channels_need_little_beside_their_own_memory() -> None:
    views = [prepare(view) for view in board_views(200)]
    camera = between([])
    bv.warp(views, camera, threads=1)
    tracemalloc.start()
    frame = bv.warp(views, camera, threads=1)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert frame.features is not None
    assert peak < 1.2 * frame.features.nbytes + 400_000


def _with(features: Any) -> bv.ReferenceView:
    return bv.ReferenceView(
        straight_camera(4, 3), grey(3, 4), np.ones((3, 4), np.float32), features
    )


SOME = np.zeros((3, 4, 2))
BAD = SOME.copy()
BAD[1, 2, 0] = np.nan


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: _with(np.zeros((3, 4))), "ReferenceView.features has shape (3, 4), expected "
         "(3, 4, n) with n from 1 up: one vector for each pixel (features[..., None]"),
        (lambda: _with(np.zeros((4, 4, 1))), "features has shape (4, 4, 1), expected (3, 4, n)"),
        (lambda: _with(np.zeros((3, 4, 0))), "features has shape (3, 4, 0)"),
        (lambda: _with(np.full((3, 4, 1), "x")), "features is <U1, expected real numbers"),
        (lambda: _with(np.full((3, 4, 1), 1j)), "features is complex128, expected real numbers"),
        (lambda: _with(np.full((3, 4, 1), 2**24 + 1)), "the whole number 16777217, but float32"),
        (lambda: _with(BAD), "features[1, 2] is infinite or NaN in some of its channels"),
        (lambda: _with(np.full((3, 4, 1), 1e300)), "features[0, 0] is infinite or NaN"),
        (lambda: _with(np.ma.masked_array(SOME)), "features is a masked array"),
        (lambda: bv.warp([_with(SOME), _with(None)], straight_camera(4, 3)),
         "warp.views[0] has features of 2 channels and warp.views[1] has no features, expected"),
        (lambda: bv.warp([_with(SOME), _with(SOME[..., :1])], straight_camera(4, 3)),
         "views[1] has features of 1 channel, expected the same of all"),
        (lambda: bv.warp(_with(SOME), straight_camera(4, 3), feature_filter="bicubic"),
         "WarpOptions.feature_filter is 'bicubic', expected one of 'cubic', 'linear', 'nearest'"),
    ],
)  # fmt: skip
def test_bad_features_are_refused(make: Any, text: str) -> None:
    with pytest.raises(BelvedereError) as refusal:
        make()
    assert text in str(refusal.value)


def test_whole_numbers_and_truths_are_features_too() -> None:
    for kind in (bool, np.uint8, np.int16, np.int64, np.float64):
        held = _with(np.ones((3, 4, 2), kind)).features
        assert held is not None
        assert held.dtype == np.float32
        assert (held == 1).all()
