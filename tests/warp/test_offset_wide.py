"""Wide sub-samples: where one a pixel tells all, and the look-up at the pixel's own centre."""

from __future__ import annotations

import numpy as np
import pytest

from belvedere.scene import Camera, ReferenceView
from belvedere.warp import OffsetOptions, warp, warp_matrix, warp_points
from belvedere.warp._edges import SMOOTH
from belvedere.warp._offset_lattice import even_need
from belvedere.warp._offset_wide import APART, fine_part, grows, read_wide
from tests.oracles.warp import interpolated
from tests.warp.worlds import plane_disparity, random_rotation, straight_camera


def wave(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    value = 0.5 + 0.4 * np.sin(0.9 * u + 0.3 * v) * np.cos(0.5 * v)
    return np.stack([value, 1 - value, 0.3 + 0.5 * value], -1).astype(np.float32)


@pytest.mark.parametrize("seed", range(6))
def test_a_whole_pixel_shows_the_reference_at_its_own_centre(seed: int) -> None:
    """Cubic colour at the exact place, to the 1/128 of a sample that look-ups know."""
    rng = np.random.default_rng(seed)
    reference = straight_camera(64, 48)
    normal = np.array([rng.normal(0, 0.2), 1.0, rng.normal(0, 0.2)])
    delta = plane_disparity(reference, normal, 4.0)
    color = wave(*np.broadcast_arrays(*reference.pixel_grid()))
    place = rng.uniform(-0.3, 0.3, 3) + np.array([0, 0.5 * (seed % 3), 0])
    desired = Camera(random_rotation(rng, 0.1) @ reference.matrix, place, 64, 48)
    frame = warp(
        ReferenceView(reference, color, delta.astype(np.float32)),
        desired,
        reconstruction="offset",
        offset=OffsetOptions(buffer_scale=2 + 2 * (seed % 2)),
    )
    truth = plane_disparity(desired, normal, 4.0)
    u, v, _ = warp_points(warp_matrix(desired, reference), *desired.pixel_grid(), truth)
    inside = (u > 3) & (v > 3) & (u < 60) & (v < 44)
    assert inside.sum() > 1000
    assert np.all(frame.coverage[inside] == 1)
    np.testing.assert_allclose(frame.disparity[inside], truth[inside], rtol=2e-5)
    wanted = np.array(
        [interpolated(color.astype(float), *at) for at in zip(u[inside], v[inside], strict=True)]
    )
    error = np.abs(frame.color[inside] - wanted)
    assert error.max() < 0.45 * np.sqrt(2) / 128 + 1e-3
    assert error.mean() < 0.002


def test_a_shrunk_picture_is_filtered() -> None:
    """Stripes two pixels wide, seen from so far that three fall in a pixel, come out grey."""
    camera = straight_camera(96, 72)
    u, _ = np.broadcast_arrays(*camera.pixel_grid())
    color = np.repeat((u % 2)[..., None], 3, -1).astype(np.float32)
    view = ReferenceView(camera, color, np.full(camera.size, 0.5, np.float32))
    far = camera.moved((0.01, -4.0, 0.0))  # from two metres to six
    light = warp(view, far, reconstruction="offset").color[30:42, 36:60, 0]
    assert np.abs(light - 0.5).max() < 0.25


def test_one_place_in_every_cell_leaves_no_pixel_out() -> None:
    rng = np.random.default_rng(3)
    for _ in range(60):
        growth, turn = rng.uniform(0.6, 3.0), rng.uniform(0, np.pi)
        along_u = growth * np.array([np.cos(turn), np.sin(turn)])
        along_v = rng.uniform(0.6, 3.0) * np.array([-np.sin(turn + 0.2), np.cos(turn + 0.2)])
        ux, uy, vx, vy = np.abs([*along_u, *along_v]).astype(np.float32)
        slots, rows = even_need(ux, uy, vx, vy, np.float32(32))
        m, n = np.meshgrid(np.arange(-60, 60), np.arange(-60, 60))
        at = (m[..., None] / slots) * along_u + (n[..., None] / float(rows)) * along_v
        at = (at + rng.uniform(0, 1, 2)).reshape(-1, 2)
        at = at[np.all((at >= 0) & (at < 6), axis=1)]
        assert len(set(map(tuple, np.floor(at).astype(int)))) == 36


def test_what_shrinks_or_is_turned_over_is_not_wide() -> None:
    rng = np.random.default_rng(4)
    for _ in range(300):
        cell = rng.normal(0, 1, (2, 2)).astype(np.float32)
        least = np.float32(rng.uniform(0.1, 1.0))
        area, squares = np.float32(np.linalg.det(cell)), np.float32((cell**2).sum())
        smallest = float(np.linalg.svd(cell, compute_uv=False).min())
        if abs(smallest - float(least)) > 1e-3:
            assert bool(grows(area, squares, least**2)) == (area > 0 and smallest > least)


def test_a_fine_lattice_lies_beside_edges_and_where_cells_shrink() -> None:
    links = np.full((40, 60), SMOOTH, np.uint8)
    links[20, 30] = 0
    corners = np.arange(33, dtype=np.float32)
    wide, ample, column = np.zeros(32, np.uint64), np.zeros(32, np.uint8), np.zeros(36, np.uint8)
    flat = np.zeros(33, np.float32)

    def part(v: int, u_low: int, growth: float) -> tuple[int, int]:
        grown = np.float32(growth) * corners
        read_wide(links[v, u_low:], grown, flat, grown, flat + np.float32(growth), 32, wide, ample)
        first, end = fine_part(links, v, u_low, 32, ample, column)
        return (first, end) if first < end else (0, 0)

    for v in range(20 - APART, 20 + APART + 1):
        assert part(v, 20, 1.0) == (10 - APART, 10 + APART + 1)
    assert part(20 - APART - 1, 20, 1.0) == (0, 0)
    assert part(20 + APART + 1, 20, 1.0) == (0, 0)
    assert part(30, 20, 0.55) == (0, 32)  # wide, yet both lattices are laid
    assert wide.all()
    assert part(30, 20, 0.45) == (0, 32)
    assert not wide.any()
    assert part(1, 20, 1.0) == (0, 32)  # beside the border
    assert part(10, 0, 1.0) == (0, APART)
