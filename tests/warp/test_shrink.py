"""A desired view that shrinks a reference shows means of samples, each of one surface only."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from belvedere.ground.color import color_to_linear, color_to_srgb8
from belvedere.ground.errors import ViewError
from belvedere.scene import Camera, ReferenceView
from belvedere.studio.metrics import psnr
from belvedere.warp import PreparedView, halved, prepare, warp
from tests.warp.worlds import noise, plane_disparity, same, straight_camera, view_of

F4 = npt.NDArray[np.float32]

BOARDS = ((4.0, -9.0, 9.0, -9.0, 9.0), (2.5, -0.9, -0.2, -0.8, 0.6), (2.0, 0.3, 0.8, -0.5, 0.9))
"""Distance, left, right, bottom, top: a wall and two boards before it."""
CELLS = ((8.0, 0.5), (40.0, 0.8), (150.0, 1.0))
"""Squares of colour a metre, and how loud they are: down to about a pixel of the reference."""


def paper(x: Any, z: Any, board: int) -> Any:
    """(..., 3) linear colour: squares of random colours in three sizes."""
    table = np.random.default_rng(board).random((3, 211, 211, 3))
    total = np.zeros((*x.shape, 3))
    for layer, (cells, loud) in zip(table, CELLS, strict=True):
        i, j = np.floor(x * cells).astype(int) % 211, np.floor(z * cells).astype(int) % 211
        total += loud / sum(loud for _, loud in CELLS) * layer[j, i]
    return total


def look(camera: Camera, u: Any, v: Any) -> tuple[Any, Any]:
    """Linear colour and disparity at places of the picture."""
    rays = camera.rays(u, v)
    color, nearest = np.zeros(rays.shape), np.full(u.shape, np.inf)
    for board, (y, left, right, bottom, top) in enumerate(BOARDS):
        t = (y - camera.center[1]) / rays[..., 1]
        x, _, z = np.moveaxis(camera.center + t[..., None] * rays, -1, 0)
        hit = (x > left) & (x < right) & (z > bottom) & (z < top) & (t < nearest)
        color[hit], nearest[hit] = paper(x, z, board)[hit], t[hit]
    return color, 1 / nearest


def photograph(camera: Camera, side: int) -> ReferenceView:
    """Pixels are means of side x side places; the disparity is that of their middle."""
    u, v = np.broadcast_arrays(*camera.pixel_grid())
    steps = (np.arange(side) + 0.5) / side - 0.5
    places = [look(camera, u + du, v + dv)[0] for du in steps for dv in steps]
    color = np.sum(places, axis=0) / side**2
    disparity = look(camera, u, v)[1].astype(np.float32)
    return ReferenceView(camera, color_to_srgb8(color.astype(np.float32)), disparity)


@pytest.fixture(scope="module")
def reference() -> PreparedView:
    return prepare(photograph(straight_camera(320, 320, (-0.15, 0, 0)), 3))


@pytest.mark.parametrize("shrink", [2, 3, 4, 8])
def test_a_fine_texture_shrunk_is_as_true_as_offsets_make_it(
    reference: PreparedView, shrink: int
) -> None:
    camera = straight_camera(320 // shrink, 320 // shrink, (0.03, 0.04, 0.02))
    truth = photograph(camera, 3 * shrink).color
    ours, theirs = (warp(reference, camera, reconstruction=r) for r in ("inverse", "offset"))
    both = (ours.coverage > 0) & (theirs.coverage > 0)
    assert both.mean() > 0.85
    close, other = (psnr(one.color, truth, both) for one in (ours, theirs))
    assert close > 30
    assert close > other


@pytest.mark.parametrize("shrink", [4, 8])
def test_silhouettes_shrunk_are_as_true_as_the_rest(reference: PreparedView, shrink: int) -> None:
    """What is behind them has its copies too, and all that a pixel has of the near side counts."""
    camera = straight_camera(320 // shrink, 320 // shrink, (-0.14, 0.04, 0.02))  # little is exposed
    truth, frame = photograph(camera, 3 * shrink), warp(reference, camera)
    depth = truth.disparity
    step = np.zeros(depth.shape, bool)
    step[:, 1:] |= abs(np.diff(depth, axis=1)) > 0.1
    step[:, :-1] |= step[:, 1:]
    step[1:] |= abs(np.diff(depth, axis=0)) > 0.1
    step[:-1] |= step[1:]
    assert 0.05 < step.mean() < 0.5
    whole = frame.coverage == 1
    assert whole[step].mean() > 0.9
    assert psnr(frame.color, truth.color, step & whole) > 33


def test_what_is_as_large_asks_no_copies(
    reference: PreparedView, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(PreparedView, "copies", lambda *_: pytest.fail("asked"))
    warp(reference, straight_camera(320, 320, (0.1, 0.05, 0.02)))
    warp(reference, straight_camera(240, 240, (0.1, 0.05, 0.02)))


def test_what_is_as_large_keeps_its_bytes_beside_what_is_shrunk(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A wall that recedes from one side of the picture to the other."""
    from belvedere.warp import _shrink

    rng = np.random.default_rng(1)
    near = straight_camera(160, 120)
    disparity = np.linspace(1.0, 0.1, 160, dtype=np.float32) * np.ones((120, 1), np.float32)
    view = ReferenceView(near, noise(rng, 120, 160), disparity)
    camera = straight_camera(160, 120, (0.0, -0.9, 0.0))  # the near end shrinks by nearly 2
    frame = warp(view, camera)
    with monkeypatch.context() as patch:
        patch.setattr(_shrink, "largest_shrink", lambda *_: 1.0)
        plain = warp(view, camera)
    known = frame.coverage > 0
    np.testing.assert_array_equal(known, plain.coverage > 0)
    changed = (frame.color != plain.color).any(axis=-1) & known
    delta = frame.disparity / (1 - 0.9 * frame.disparity)  # in the reference
    shrunk = delta / frame.disparity > _shrink.BEGIN
    assert changed[known & shrunk].mean() > 0.9
    assert not changed[known & ~shrunk].any()


def slow_halves(color: Any, disparity: Any, tolerance: float) -> tuple[Any, Any]:
    """Slow twin of `_shrink.halve_surfaces`."""
    height, width = (-(-side // 2) for side in disparity.shape)
    out_color, out = np.zeros((height, width, 4)), np.full((height, width), np.nan)
    for y in range(height):
        for x in range(width):
            four = disparity[2 * y : 2 * y + 2, 2 * x : 2 * x + 2].ravel().astype(float)
            colors = color[2 * y : 2 * y + 2, 2 * x : 2 * x + 2].reshape(-1, 4)
            sets = [np.abs(four - own) <= tolerance * own for own in four if own >= 0]
            owns = [own for own in four if own >= 0]
            if sets:
                ranks = [(s.sum(), own) for s, own in zip(sets, owns, strict=True)]
                chosen = sets[ranks.index(max(ranks))]
                out_color[y, x], out[y, x] = colors[chosen].mean(0), four[chosen].mean()
    return out_color, out


@pytest.mark.parametrize("size", [(8, 12), (7, 9), (1, 5)])
def test_a_copy_holds_means_of_one_surface_each(size: tuple[int, int]) -> None:
    from belvedere.warp import _shrink

    rng = np.random.default_rng(2)
    disparity = rng.choice([0.5, 1.0, np.nan], size, p=[0.4, 0.4, 0.2]).astype(np.float32)
    disparity *= rng.uniform(0.999, 1.001, size).astype(np.float32)
    color = rng.random((*size, 4)).astype(np.float32)
    wanted_color, wanted = slow_halves(color, disparity, 0.05)
    found_color, found = (
        np.empty(wanted_color.shape, np.float32),
        np.empty(wanted.shape, np.float32),
    )
    # even counts of two surfaces are for the nearer, whichever of its samples is taken as its own
    _shrink.halve_surfaces(color, disparity, 0.05, found_color, found)
    np.testing.assert_allclose(found, wanted, rtol=1e-6)
    np.testing.assert_allclose(found_color, wanted_color, atol=1e-6)


@pytest.mark.parametrize("shrink", [1.7, 2.0, 2.6, 4.0, 5.5, 9.0])
def test_a_pixel_shows_the_mean_of_what_it_covers(shrink: float) -> None:
    """Of slow waves, which no copy blurs, and to the mean of every picture."""
    size = 192
    here = straight_camera(size, size)
    u, v = np.broadcast_arrays(*here.pixel_grid())
    waves = 0.5 + 0.2 * np.cos(u / (1.5 * shrink)) + 0.2 * np.sin(v / (1.7 * shrink) + 0.3)
    color = np.repeat(waves[..., None], 3, 2).astype(np.float32)
    view = ReferenceView(here, color, np.full((size, size), 0.5, np.float32))
    count = int(size / shrink)
    there = straight_camera(count, count, focal=size / shrink)
    frame = warp(view, there)
    x, y = np.broadcast_arrays(*there.pixel_grid())
    place_u = (x - (count - 1) / 2) * shrink + (size - 1) / 2
    place_v = (y - (count - 1) / 2) * shrink + (size - 1) / 2

    def faded(length: float) -> float:
        return float(np.sinc(shrink / length / (2 * np.pi)))  # of a wave's mean over a pixel

    mean = 0.5 + 0.2 * faded(1.5 * shrink) * np.cos(place_u / (1.5 * shrink))
    mean += 0.2 * faded(1.7 * shrink) * np.sin(place_v / (1.7 * shrink) + 0.3)
    inside = (slice(2, -2), slice(2, -2))
    worst = np.abs(frame.color[..., 0] - mean)[inside].max()
    assert worst < 0.02  # measured 0.013; the waves alone fade by 0.008
    assert frame.coverage[inside].all()


def test_a_dark_board_keeps_out_of_a_bright_wall() -> None:
    """Nor does the wall brighten it: what a pixel shows is in proportion to what it covers."""
    here = straight_camera(256, 256)
    disparity, color = np.full((256, 256), 0.25, np.float32), np.ones((256, 256, 3), np.float32)
    disparity[:, 96:160], color[:, 96:160] = 0.5, 0.0
    frame = warp(ReferenceView(here, color, disparity), straight_camera(32, 32, (0.01, 0, 0)))
    row = frame.color[16, :, 0]
    assert row[frame.coverage[16] > 0].sum() == pytest.approx(24, abs=1.2)
    mixed = (row > 0.02) & (row < 0.98)
    assert mixed.sum() <= 4
    assert (row[13:19] == 0).all()
    assert (row[:10] > 0.999).all()


def test_shrunk_views_do_not_depend_on_threads() -> None:
    rng = np.random.default_rng(3)
    views = [
        ReferenceView(
            straight_camera(400, 300, (0.1 * n, 0, 0)), noise(rng, 300, 400),
            np.kron(rng.choice([0.4, 0.8], (15, 20)), np.ones((20, 20))).astype(np.float32),
        )
        for n in range(2)
    ]  # fmt: skip
    camera = straight_camera(230, 170, (0.05, 0.02, 0.03), focal=160)
    frames = [warp(views, camera, threads=n) for n in (1, 2, 3, 4)]
    assert all(same(frames[0], one) for one in frames[1:])
    again = [prepare(view) for view in views]
    warp(again, straight_camera(40, 30, (0.05, 0.02, 0.03)))  # wider rims, more copies
    assert same(frames[0], warp(again, camera))


@pytest.mark.parametrize("side", [1, 2, 3, 4, 5, 9])
def test_the_smallest_pictures_shrink_too(side: int) -> None:
    rng = np.random.default_rng(side)
    camera = straight_camera(side, side)
    view = view_of(camera, np.full((side, side), 0.5, np.float32), noise(rng, side, side))
    frame = warp(view, straight_camera(1, 1, (0.01, 0, 0), focal=side / 6))
    assert np.isfinite(color_to_linear(frame.color)).all()


# ---- half of a view ------------------------------------------------------------------------------


def test_half_of_a_view_shows_the_same_planes() -> None:
    """Disparity is linear across a plane's picture: the mean of four is the one in their middle."""
    camera = Camera.look_at((0, 0, 1.5), (3.0, 0.4, 1.0), width=360, height=243, fov_deg=70)
    disparity = plane_disparity(camera, (0.2, 0.1, 1.0), 0.0)  # the floor, sloping
    view = view_of(camera, np.where(disparity > 0, disparity, np.nan))
    half = halved(prepare(view))
    assert half.disparity.shape == (121, 180)
    assert isinstance(half.camera, Camera)
    exact = plane_disparity(half.camera, (0.2, 0.1, 1.0), 0.0)
    known = np.isfinite(half.disparity) & (exact > 0.2)  # where steps are those of one surface
    assert known.sum() > 300
    np.testing.assert_allclose(half.disparity[known], exact[known], rtol=2e-3)


def test_half_of_a_view_never_mixes_surfaces() -> None:
    camera = Camera.look_at((0, 0, 0), (1, 0, 0), width=40, height=24, fov_deg=60)
    near = (np.indices((24, 40)).sum(axis=0) % 5) < 2
    color = np.where(near[..., None], np.uint8(250), np.uint8(10)).repeat(3, axis=2)
    view = ReferenceView(camera, color, np.where(near, 0.9, 0.1).astype(np.float32))
    half = halved(prepare(view))
    assert set(np.unique(half.color)) == {10, 250}
    np.testing.assert_array_equal(half.color[..., 0] == 250, half.disparity > 0.5)


def test_a_view_of_few_samples_is_not_halved() -> None:
    camera = Camera.look_at((0, 0, 0), (1, 0, 0), width=7, height=5, fov_deg=60)
    view = ReferenceView(camera, np.zeros((5, 7, 3), np.uint8), np.ones((5, 7), np.float32))
    with pytest.raises(ViewError, match="7 x 5 samples is too small"):
        halved(prepare(view))
