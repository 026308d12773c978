"""Tiles reach where their bounds say, and nowhere else."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.scene import Camera, Frame, ReferenceView
from belvedere.warp import RECONSTRUCTIONS, WarpOptions, prepare, warp, warp_matrix, warp_points
from belvedere.warp.reconstruct import SplatOptions
from tests.warp.worlds import (
    VISIBILITIES,
    noise,
    random_camera,
    same,
    straight_camera,
    view_of,
)

SIZES = ((97, 61), (33, 70), (64, 32), (40, 33))


def test_a_tile_knows_the_range_of_its_samples_and_their_neighbours() -> None:
    rng = np.random.default_rng(0)
    disparity = rng.uniform(0, 1, (61, 97)).astype(np.float32)
    disparity[rng.random(disparity.shape) < 0.3] = np.nan
    disparity[30:, 60:] = np.nan
    held = prepare(ReferenceView(straight_camera(97, 61), noise(rng, 61, 97), disparity))
    assert held.tile_low.shape == (2, 4)
    for row in range(2):
        for column in range(4):
            v, u = 32 * row, 32 * column
            part = disparity[max(v - 1, 0) : v + 33, max(u - 1, 0) : u + 33]
            if np.isnan(part).all():
                assert held.tile_low[row, column] > held.tile_high[row, column]
            else:
                assert held.tile_low[row, column] == np.nanmin(part)
                assert held.tile_high[row, column] == np.nanmax(part)


def test_no_point_of_a_tile_lands_outside_the_rows_it_is_listed_for() -> None:
    from belvedere.warp import _tiles

    rng = np.random.default_rng(1)
    landed = bounded = 0
    for _ in range(400):
        a, b = (random_camera(rng, 80, 60, reach=0.6, turn=0.8) for _ in range(2))
        u0, v0 = (int(x) for x in rng.integers(0, 60, 2))
        u1, v1 = u0 + int(rng.integers(1, 33)), v0 + int(rng.integers(1, 33))
        low = rng.uniform(0, 1)
        high = low + rng.uniform(0, 1)
        matrix = warp_matrix(a, b)
        pad = int(rng.integers(0, 5))
        first, end = _tiles.landing_rows(matrix, u0, u1, v0, v1, low, high, 80, 60, pad)
        assert 0 <= first <= 60
        assert 0 <= end <= 60
        u = rng.uniform(u0 - 1, u1 + 0.5, 300)
        v = rng.uniform(v0 - 1, v1 + 0.5, 300)
        delta = rng.choice([low, high, 0.5 * (low + high)], 300)
        x, y, _ = warp_points(matrix, u, v, delta)
        inside = (x >= -pad) & (x <= 79 + pad) & (y >= 0) & (y <= 59)
        landed += int(inside.sum())
        bounded += end - first < 60
        if inside.any():
            assert y[inside].min() - pad >= first or first == 0
            assert y[inside].max() + pad <= end - 1 or end == 60
    assert landed > 10_000  # the test looked at something
    assert bounded > 100


def steep_world(rng: np.random.Generator, width: int, height: int) -> np.ndarray:
    """Slanted and steep surfaces with gaps that mesh and offset bridge."""
    v, u = np.mgrid[:height, :width]
    disparity = 0.1 + rng.uniform(0, 0.05) * u + rng.uniform(0, 0.05) * v
    disparity[v > u] = 0.4 + 0.01 * u[v > u]
    for _ in range(3):
        at, low = rng.integers(0, width), rng.integers(0, height)
        disparity[low : low + 9, at : at + 7] = rng.uniform(0.5, 3)
    disparity[:, 30:33] = np.nan
    disparity[rng.random(disparity.shape) < 0.03] = np.nan
    return disparity.astype(np.float32)


def assert_bounds_cut_nothing(
    view: ReferenceView, desired: Camera, options: WarpOptions, monkeypatch: pytest.MonkeyPatch
) -> Frame:
    """The frame, after comparing it with one where every tile is tried for every row."""
    from belvedere.warp import _tiles

    listed = _tiles.list_tiles

    def every_tile_everywhere(*arguments: Any) -> int:
        assert arguments[-2] < 20  # the pad
        widened: Any = (*arguments[:-2], 1_000_000, arguments[-1])
        return listed(*widened)

    bounded = warp(view, desired, options=options, threads=1)
    with monkeypatch.context() as patch:
        patch.setattr(_tiles, "list_tiles", every_tile_everywhere)
        unbounded = warp(view, desired, options=options, threads=1)
    assert same(bounded, unbounded)
    return bounded


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_tiles_left_out_and_rows_not_listed_would_have_painted_nothing(
    reconstruction: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(2)
    for n in range(40):
        width, height = SIZES[n % len(SIZES)]
        a = random_camera(rng, width, height, reach=0.1)
        b = random_camera(rng, int(rng.integers(20, 90)), int(rng.integers(20, 90)), reach=0.5)
        disparity = steep_world(rng, width, height)
        view = ReferenceView(a, noise(rng, height, width), disparity)
        options = WarpOptions(
            reconstruction=reconstruction,
            visibility=VISIBILITIES[n % 2],
            splat=SplatOptions(size=(1, 3, 7, "jacobian")[n % 4]),
        )
        assert_bounds_cut_nothing(view, b, options, monkeypatch)


@pytest.mark.parametrize("reconstruction", ["mesh", "offset"])
@pytest.mark.parametrize("world", ["steep edge", "bridged gap"])
def test_what_is_drawn_between_and_beyond_samples_lies_within_the_bounds_too(
    reconstruction: Any, world: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One column a tile of its own, a large step upwards: half a pixel of slope is many rows."""
    reference = straight_camera(33 if world == "steep edge" else 40, 8, focal=70)
    u = np.broadcast_to(np.arange(reference.width), reference.size)
    disparity = (0.1 + 0.08 * u).astype(np.float32)
    if world == "bridged gap":
        disparity = np.where(u < 32, 2.0, 2.09).astype(np.float32)
        disparity[:, 31:34] = np.nan
    view = view_of(reference, disparity, noise(np.random.default_rng(3), *reference.size))
    middle = float(np.nanmax(disparity)) * 70 * 1.5
    desired = straight_camera(reference.width, 8, (0, 0, 1.5), 70)
    desired = desired.cropped(0, int(middle) - 30, reference.width, 60)
    options = WarpOptions(reconstruction=reconstruction)
    frame = assert_bounds_cut_nothing(view, desired, options, monkeypatch)
    assert (frame.coverage > 0).sum() > 30


def test_tiles_come_in_the_order_of_their_sheets() -> None:
    from belvedere.warp import _tiles

    sheets = np.array([(0, 50, 1, 0, 40, 1), (50, 97, -1, 0, 40, 1)], np.int32)
    low, high = np.full((2, 4), 0.1, np.float32), np.full((2, 4), 0.2, np.float32)
    high[0, 3] = -1  # no sample there
    tiles = np.empty((15, _tiles.FIELDS), np.int32)
    same_camera = np.hstack([np.eye(3), np.zeros((3, 1))])
    count = _tiles.list_tiles(sheets, low, high, same_camera, 97, 61, 2, tiles)
    assert tiles[:count, :6].tolist() == [
        [0, 32, 1, 0, 32, 1],
        [32, 50, 1, 0, 32, 1],
        [0, 32, 1, 32, 40, 1],
        [32, 50, 1, 32, 40, 1],
        [64, 96, -1, 0, 32, 1],
        [50, 64, -1, 0, 32, 1],
        [96, 97, -1, 32, 40, 1],
        [64, 96, -1, 32, 40, 1],
        [50, 64, -1, 32, 40, 1],
    ]


def listed(reference: Camera, desired: Camera, low: float, high: float) -> int:
    """Tiles of a reference with disparities from ``low`` to ``high`` that may reach the view."""
    from belvedere.warp import _tiles

    across, down = -(-reference.width // 32), -(-reference.height // 32)
    least, most = (np.full((down, across), value, np.float32) for value in (low, high))
    sheets = np.array([(0, reference.width, 1, 0, reference.height, 1)], np.int32)
    tiles = np.empty((across * down, _tiles.FIELDS), np.int32)
    matrix = warp_matrix(reference, desired)
    return _tiles.list_tiles(sheets, least, most, matrix, desired.width, desired.height, 2, tiles)


def turned(camera: Camera, angle: float) -> Camera:
    """The camera turned about the world's vertical axis, radians."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    return Camera(turn @ camera.matrix, camera.center, camera.width, camera.height)


def test_a_reference_that_looks_elsewhere_has_no_tiles_and_one_that_looks_along_has_all() -> None:
    """53 degrees across: beyond that angle nothing at infinity is shared; near things may be."""
    camera = straight_camera(512, 512)
    assert listed(camera, camera, 0.1, 1.0) == 256
    for angle in (1.0, 2.0, np.pi):
        assert listed(turned(camera, angle), camera, 0.1, 1.0) == 0
    half = listed(turned(camera, 0.45), camera, 0.1, 1.0)
    assert 96 <= half <= 160
    aside = camera.moved((0.4, -0.5, 0))
    assert listed(turned(aside, np.pi / 2), camera, 0.0, 0.2) < 32


def test_tiles_that_reach_through_the_plane_of_the_eye_are_bounded_too() -> None:
    """A metre ahead, with things at half a metre to two: what is in view at two metres was within
    a quarter of the picture's width of its middle, and nearer things are behind or aside."""
    camera = straight_camera(512, 512)
    assert listed(camera, camera.moved((0.0, 1.0, 0.0)), 0.5, 2.0) == 10 * 10
    assert listed(camera, camera.moved((3.0, 1.0, 0.0)), 0.5, 2.0) == 0
