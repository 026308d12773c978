"""Several references become one picture, in linear light."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.ground.color import (
    LINEAR_TO_SRGB8,
    SRGB8_TO_LINEAR,
    color_to_linear,
    color_to_srgb8,
    decode_srgb8,
    encode_srgb8,
)
from belvedere.ground.errors import ViewError
from belvedere.scene import ReferenceView
from belvedere.warp import RECONSTRUCTIONS, prepare, warp
from belvedere.warp.warp import nearest_order, nearness_weights
from tests.oracles.warp import merge_layers
from tests.warp.worlds import grey, noise, straight_camera, view_of

CENTER = straight_camera(24, 18)


def beside(distance: float, value: int = 0, disparity: float = 0.25) -> ReferenceView:
    """A wall of one grey, seen from a place beside the middle."""
    camera = straight_camera(24, 18, (distance, 0, 0))
    return view_of(camera, np.full((18, 24), disparity), grey(18, 24, value))


MIDDLE = np.s_[4:-4, 8:-8]


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_black_and_white_blend_to_half_the_light_not_half_the_byte(reconstruction: Any) -> None:
    # 24 * 0.25 * (1/3) = 2 whole pixels either way
    frame = warp([beside(-1 / 3, 0), beside(1 / 3, 255)], CENTER, reconstruction=reconstruction)
    assert np.all(frame.color[MIDDLE] == 188)
    np.testing.assert_allclose(decode_srgb8(frame.color[MIDDLE]), 0.5, atol=0.005)
    np.testing.assert_allclose(frame.disparity[MIDDLE], 0.25, rtol=1e-5)


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_the_nearer_reference_weighs_more_by_the_square_of_the_distance(
    reconstruction: Any,
) -> None:
    frame = warp([beside(2 / 3, 255), beside(1 / 3, 0)], CENTER, reconstruction=reconstruction)
    floor = (0.05 * 0.5) ** 2
    white = 1 / (4 / 9 + floor)
    share = white / (white + 1 / (1 / 9 + floor))
    np.testing.assert_allclose(decode_srgb8(frame.color[MIDDLE]), share, atol=0.004)
    first = warp([beside(2 / 3, 255), beside(1 / 3, 0)], CENTER, reconstruction=reconstruction,
                 composite="nearest")  # fmt: skip
    assert np.all(first.color[MIDDLE] == 0)


def test_weights_sum_to_one_and_stay_finite_where_the_eye_is_a_reference() -> None:
    for places in ([0.0], [0.0, 0.0], [0.0, 1.0], [0.0, 1e-9, 5.0], [1e6, 2e6], [3.0] * 5):
        views = [prepare(beside(p)) for p in places]
        weights = nearness_weights(views, CENTER)
        assert weights.sum() == pytest.approx(1.0, abs=1e-6)
        assert np.isfinite(weights).all()
        assert np.argmax(weights) == int(np.argmin(places))
    held = [prepare(beside(p)) for p in (3, 1, 2)]
    ordered = [held[n] for n in nearest_order(held, CENTER)]
    assert [one.camera.center[0] for one in ordered] == [1, 2, 3]


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_a_nearer_object_seen_only_by_the_second_reference_survives_a_blend(
    reconstruction: Any,
) -> None:
    """With ``nearest``, as in the portal paper, the first's background overwrites it."""
    wall = beside(1 / 3, 100)
    board = np.full((18, 24), 0.25, np.float32)
    board[6:12, 12:18] = 0.75
    color = grey(18, 24, 100)
    color[6:12, 12:18] = 250
    second = ReferenceView(straight_camera(24, 18, (-2 / 3, 0, 0)), color, board)
    blended = warp([wall, second], CENTER, reconstruction=reconstruction)
    at = np.s_[7:11, 3:5]  # moved left by 24 * 2/3 * 0.75 = 12 pixels: columns 0 to 6
    assert np.all(blended.color[at] == 250)
    np.testing.assert_allclose(blended.disparity[at], 0.75, rtol=1e-5)
    first = warp([wall, second], CENTER, reconstruction=reconstruction, composite="nearest")
    seen = warp(wall, CENTER, reconstruction=reconstruction).coverage == 1
    assert seen[at].any()
    assert np.all(first.color[seen] == 100)


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
@pytest.mark.parametrize("composite", ["blend", "nearest"])
def test_what_one_reference_lacks_another_fills(composite: Any, reconstruction: Any) -> None:
    left, right = beside(-1 / 3, 50), beside(1 / 3, 50)
    torn = np.array(left.disparity)
    torn[:, :12] = np.nan
    torn_right = np.array(right.disparity)
    torn_right[:, 12:] = np.nan
    views = [
        ReferenceView(left.camera, left.color, torn),
        ReferenceView(right.camera, right.color, torn_right),
    ]
    both = warp(views, CENTER, reconstruction=reconstruction, composite=composite)
    each = [warp(v, CENTER, reconstruction=reconstruction).coverage > 0 for v in views]
    np.testing.assert_array_equal(both.coverage > 0, each[0] | each[1])
    assert (each[0] ^ each[1]).any()
    assert np.all(both.color[both.coverage > 0] == 50)


@pytest.mark.parametrize("kind", ["rgb8", "rgba8", "rgb32", "rgba32"])
@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_a_view_blended_with_itself_is_itself(reconstruction: Any, kind: str) -> None:
    rng = np.random.default_rng(1)
    camera = straight_camera(24, 18)
    view = view_of(camera, np.full((18, 24), 0.5), noise(rng, 18, 24, kind))
    once = warp(view, camera.moved((0.11, 0.2, 0)), reconstruction=reconstruction)
    thrice = warp([view] * 3, camera.moved((0.11, 0.2, 0)), reconstruction=reconstruction)
    assert thrice.color.dtype == view.color.dtype
    np.testing.assert_allclose(
        thrice.color.astype(float), once.color.astype(float), atol=1 if "8" in kind else 1e-5
    )
    np.testing.assert_allclose(thrice.disparity, once.disparity, rtol=1e-5)
    np.testing.assert_array_equal(thrice.coverage, once.coverage)


def test_surfaces_within_the_tolerance_are_averaged_and_beyond_it_the_front_one_wins() -> None:
    views = [beside(0, 0, 0.25), beside(0, 255, 0.25 * 1.02)]
    near = warp(views, CENTER, reconstruction="point")
    assert np.all(near.color == 188)
    strict = warp(views, CENTER, reconstruction="point", surface_tolerance=0.01)
    assert np.all(strict.color == 255)
    np.testing.assert_allclose(strict.disparity, 0.255, rtol=1e-5)
    far = warp([beside(0, 0, 0.25), beside(0, 255, 0.5)], CENTER, reconstruction="point")
    assert np.all(far.color == 255)


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_fuzzy_keeps_the_nearest_reference_unless_another_is_clearly_in_front(
    reconstruction: Any,
) -> None:
    def shown(second: float, tolerance: float = 0.03) -> int:
        # 24 x 0.25 x 1/3 is 2 pixels; the others are seen from there too, a hair farther away
        views = [beside(1 / 3, 50, 0.25), beside(1 / 3 + 1e-6, 200, second)]
        frame = warp(views[::-1], CENTER, reconstruction=reconstruction, composite="fuzzy",
                     surface_tolerance=tolerance)  # fmt: skip
        inside = frame.color[MIDDLE]
        assert np.all(inside == inside[0, 0])
        return int(inside[0, 0, 0])

    assert shown(0.2) == 50  # farther never replaces
    assert shown(0.25 * 1.02) == 50  # a little nearer neither
    assert shown(0.25 * 1.04) == 200
    assert shown(0.25 * 1.02, 0.01) == 200
    assert shown(0.25 * 1.0001, 0.0) == 200  # tolerance 0: the hard z-buffer
    assert shown(0.25 / 1.0001, 0.0) == 50


@pytest.mark.parametrize("kind", ["rgb8", "rgba8", "rgb32", "rgba32"])
def test_fuzzy_asks_later_references_against_what_is_there_already(kind: str) -> None:
    """2 % steps: the second does not replace the first, the third replaces the first; 6 % does."""
    rng = np.random.default_rng(3)
    colors = [noise(rng, 18, 24, kind) for _ in range(4)]
    cases = (((1.0, 1.02, 1.04, 1.06), 2), ((1.0, 1.04, 1.06, 1.08), 3), ((1.0, 1.04, 1.06), 1))
    for steps, winner in cases:
        views = [
            view_of(
                straight_camera(24, 18, (n * 1e-7, 0, 0)), np.full((18, 24), 0.25 * step), color
            )
            for n, (step, color) in enumerate(zip(steps, colors, strict=False))
        ]
        frame = warp(views, CENTER, reconstruction="point", composite="fuzzy")
        np.testing.assert_array_equal(frame.color, colors[winner])
        np.testing.assert_allclose(frame.disparity, 0.25 * steps[winner], rtol=1e-6)
        assert (frame.coverage == 1).all()


@pytest.mark.parametrize("kind", ["rgb8", "rgba8", "rgb32", "rgba32"])
@pytest.mark.parametrize("count", [1, 2, 3, 5])
@pytest.mark.parametrize("composite", ["blend", "nearest", "fuzzy"])
def test_what_pixels_show_of_several_layers_is_what_the_slow_twin_says(
    composite: Any, count: int, kind: str
) -> None:
    """Every layer is warped alone, and the layers are merged in float64, pixel by pixel."""
    rng = np.random.default_rng(count)
    views, layers = [], []
    for n in range(count):
        camera = straight_camera(24, 18, (0.02 * (n + 1), 0, 0))
        disparity = 0.25 * rng.choice([1.0, 1.01, 1.02, 1.2, 1.7, np.nan], (18, 24))
        views.append(view_of(camera, disparity, noise(rng, 18, 24, kind)))
        layers.append(warp(views[-1], CENTER, reconstruction="point", visibility="zbuffer"))
    weights = nearness_weights([prepare(view) for view in views], CENTER)
    frame = warp(views, CENTER, reconstruction="point", visibility="zbuffer", composite=composite)
    color, disparity = merge_layers(
        [color_to_linear(one.color) for one in layers],
        [one.disparity for one in layers], weights, composite, 0.03,
    )  # fmt: skip
    np.testing.assert_array_equal(frame.coverage, np.isfinite(disparity))
    np.testing.assert_allclose(frame.disparity, disparity, rtol=1e-5)
    if "8" in kind:
        wanted = color_to_srgb8(color.astype(np.float32))
        assert np.abs(frame.color.astype(int) - wanted).max() <= 1
        assert (frame.color == wanted).mean() > 0.99
    else:
        np.testing.assert_allclose(frame.color, color, rtol=1e-5, atol=1e-6)


def test_bytes_mix_in_a_table_as_their_radiances_do() -> None:
    from belvedere.warp import _join

    table = np.empty(65536, np.uint8)
    for first in (0.5, 0.9, 0.03):
        _join.pair_table(
            np.float32(first), np.float32(1 - first), SRGB8_TO_LINEAR, LINEAR_TO_SRGB8, table
        )
        linear = SRGB8_TO_LINEAR.astype(float)
        mean = encode_srgb8(first * linear[:, None] + (1 - first) * linear[None, :])
        difference = np.abs(table.reshape(256, 256).astype(int) - mean)
        assert difference.max() <= 1
        assert (difference == 0).mean() > 0.97  # the table of encoding has 4096 entries
        np.testing.assert_array_equal(table[:: 256 + 1], np.arange(256))


def test_colours_of_different_types_are_not_mixed() -> None:
    rng = np.random.default_rng(2)
    held = {k: view_of(CENTER, np.ones((18, 24)), noise(rng, 18, 24, k))
            for k in ("rgb8", "rgba8", "rgb32")}  # fmt: skip
    with pytest.raises(ViewError, match="mix colours of type float32 x 3 and uint8 x 3: convert"):
        warp([held["rgb8"], held["rgb32"]], CENTER)
    with pytest.raises(ViewError, match="mix colours of type uint8 x 3 and uint8 x 4"):
        warp([held["rgb8"], held["rgba8"]], CENTER)
