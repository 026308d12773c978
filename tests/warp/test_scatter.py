"""Point and splat: samples as small squares."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import belvedere as bv
from belvedere.scene import Camera, ReferenceView
from belvedere.warp import SplatOptions, warp, warp_matrix, warp_points
from tests.oracles.warp import nearest_samples
from tests.warp.worlds import (
    VISIBILITIES,
    boards,
    noise,
    plane_disparity,
    random_camera,
    random_rotation,
    same,
    straight_camera,
    view_of,
)


def numbered(height: int, width: int) -> np.ndarray:
    """(H, W, 3) bytes that tell every sample from every other."""
    index = np.arange(height * width).reshape(height, width) + 1
    return np.stack([index % 256, index // 256, np.full_like(index, 7)], -1).astype(np.uint8)


def test_points_are_the_slow_twins_points() -> None:
    rng = np.random.default_rng(3)
    flipped = total = 0
    for _ in range(12):
        a, b = random_camera(rng, 30, 22, reach=0.1), random_camera(rng, 25, 27, reach=0.3)
        disparity, _ = boards(rng, 22, 30, 3)
        disparity[rng.random(disparity.shape) < 0.1] = np.nan
        frame = warp(
            ReferenceView(a, numbered(22, 30), disparity),
            b,
            reconstruction="point",
            visibility="zbuffer",
        )
        front, sample = nearest_samples(a, b, disparity)
        got = frame.color[..., 0].astype(int) + 256 * frame.color[..., 1].astype(int) - 1
        other = got != sample
        flipped += int(other.sum())
        total += int((sample >= 0).sum())
        alike = ~other & (sample >= 0)
        np.testing.assert_allclose(frame.disparity[alike], front[alike], rtol=1e-4)
        assert np.all(frame.color[..., 2][got >= 0] == 7)
    assert total > 1000
    assert flipped <= 0.005 * total  # float32 rounds a place on a pixel's edge to either side


def landings(halo: int, begin: int, rows: int, middle: float) -> list[set[tuple[int, int]]]:
    """(row, sample) pairs of one band, for places at every float32 next to ``middle``."""
    from belvedere.warp import _scatter
    from belvedere.warp.prepare import sample_range
    from belvedere.warp.scatter import runs_of

    width = 4096
    step = np.spacing(np.float32(middle)) / 2
    w = np.zeros(12, np.float32)
    w[4], w[6], w[10] = step, middle - step * width / 2, 1.0
    disparity, number = np.zeros((1, width), np.float32), np.arange(width, dtype=np.uint32)[None]
    seen, bounds = [], sample_range(disparity)
    for u in range(0, width, 32):  # one tile at a time, or they hide one another
        tile = np.array([[u, u + 32, 1, 0, 1, 1, 0, 64]], np.int32)
        shape = (rows + 2 * halo, 1 + 2 * halo)
        word = np.empty(shape[0] * shape[1] + _scatter.SPARE, np.int64)
        _scatter.scatter(
            w, disparity, number, tile, runs_of(tile), *bounds, halo, begin - halo, shape[1],
            shape[0], 64, True, word, None,
        )  # fmt: skip
        held = word[: shape[0] * shape[1]].reshape(shape)
        v, x = np.nonzero(held != _scatter.EMPTY)
        sample = held[v, x] & _scatter.CARRIED
        seen.append({(int(y) + begin - halo, int(n)) for y, n in zip(v, sample, strict=True)})
    return seen


@pytest.mark.parametrize("halo", [0, 3])
@pytest.mark.parametrize("middle", [0.5, 1.5, 2.5, 4.5, 12.5, 28.5, 31.5, 60.5])
def test_the_cell_a_sample_lands_in_does_not_depend_on_where_its_band_begins(
    halo: int, middle: float
) -> None:
    whole = landings(halo, 0, 64, middle)
    assert {row for seen in whole for row, _ in seen} == {int(middle), int(middle) + 1}
    for begin in (1, int(middle) - 1, int(middle), int(middle) + 1):
        held = range(max(begin, 0) - halo, max(begin, 0) + 4 + halo)
        for got, wanted in zip(landings(halo, max(begin, 0), 4, middle), whole, strict=True):
            assert got == {(row, sample) for row, sample in wanted if row in held}


def scattered(
    matrix: np.ndarray, disparity: np.ndarray, size: tuple[int, int], rows: tuple[int, int],
    by_order: bool,
) -> np.ndarray:  # fmt: skip
    """Words of some rows of a desired view of (height, width) pixels."""
    from belvedere.warp import _scatter, _tiles
    from belvedere.warp.prepare import sample_range
    from belvedere.warp.scatter import runs_of

    low, high = sample_range(disparity)
    tiles = np.empty((200, _tiles.FIELDS), np.int32)
    sheets = [(0, 41, 1, 0, 23, -1), (41, 100, -1, 0, 23, -1), (0, 100, -1, 23, 60, 1)]
    count = _tiles.list_tiles(
        np.array(sheets, np.int32), low, high, matrix, size[1], size[0], 2, tiles
    )
    tiles = tiles[:count]
    number = np.arange(disparity.size, dtype=np.uint32).reshape(disparity.shape)
    word = np.empty((rows[1] - rows[0]) * size[1] + _scatter.SPARE, np.int64)
    _scatter.scatter(
        matrix.astype(np.float32).ravel(), disparity, number, tiles, runs_of(tiles), low, high, 0,
        rows[0], size[1], rows[1] - rows[0], size[0], by_order, word, None,
    )  # fmt: skip
    return word[: -_scatter.SPARE].reshape(-1, size[1])


@pytest.mark.parametrize("by_order", [True, False])
def test_a_band_holds_the_rows_of_the_whole_whatever_float32_makes_of_them(by_order: bool) -> None:
    """No band may skip a sample that another would have kept."""
    rng, width, height, landed = np.random.default_rng(9), 70, 90, 0
    straight = np.array([[1.0, 0.1, -9.0, 30.0], [-0.1, 1.2, 3.0, -20.0], [2e-3, 1e-3, 0.8, -0.3]])
    for trial in range(60):
        disparity = rng.uniform(0.2, 0.4, (60, 100)).astype(np.float32)
        matrix = straight + 0.03 * np.abs(straight) * rng.normal(size=(3, 4))
        if trial % 2:  # places are the difference of large numbers, off by pixels
            disparity[:] = 0.3
            large = rng.normal(size=3) * 10.0 ** rng.uniform(3, 7.5)
            matrix[:, 3] += large
            matrix[:, 2] -= large * np.float64(np.float32(0.3))
        whole = scattered(matrix, disparity, (height, width), (0, height), by_order)
        landed += int((whole >= 0).sum())
        cuts = [0, *sorted(rng.choice(np.arange(1, height), 5, replace=False).tolist()), height]
        for rows in pairwise(cuts):
            band = scattered(matrix, disparity, (height, width), rows, by_order)
            np.testing.assert_array_equal(band, whole[slice(*rows)])
    assert landed > 5000


@pytest.mark.parametrize("visibility", VISIBILITIES)
def test_a_splat_of_one_pixel_is_a_point(visibility: Any) -> None:
    rng = np.random.default_rng(4)
    disparity, _ = boards(rng, 61, 97)
    view = view_of(random_camera(rng, 97, 61, 0.1), disparity, noise(rng, 61, 97))
    desired = random_camera(rng, 80, 70, 0.3)
    one = warp(view, desired, reconstruction="splat", visibility=visibility,
               splat=SplatOptions(size=1))  # fmt: skip
    assert same(one, warp(view, desired, reconstruction="point", visibility=visibility))


@pytest.mark.parametrize(("size", "growth"), [(3, 2.0), (3, 2.9), (5, 4.8), (7, 6.5)])
def test_a_splat_as_large_as_the_growth_leaves_no_crack(size: Any, growth: float) -> None:
    view = view_of(straight_camera(64, 48), np.full((48, 64), 0.25))
    desired = straight_camera(64, 48, (0.013, 4 - 4 / growth, 0.021))
    frame = warp(view, desired, reconstruction="splat", splat=SplatOptions(size=size))
    assert frame.coverage.all()
    assert not warp(view, desired, reconstruction="point").coverage.all()


@pytest.mark.parametrize("growth", [0.5, 1.0, 1.7, 3.3, 5.0, 6.9])
def test_splats_sized_by_the_jacobian_leave_no_crack_and_paint_no_more_than_needed(
    growth: float,
) -> None:
    view = view_of(straight_camera(64, 48), np.full((48, 64), 0.25))
    desired = straight_camera(64, 48, (0.013, 4 - 4 / growth, 0.021))
    frame = warp(view, desired, reconstruction="splat")
    u, v = np.meshgrid(np.arange(64.0), np.arange(48.0))
    x, y, _ = warp_points(warp_matrix(straight_camera(64, 48), desired), u, v, 0.25)
    reach = max(np.ceil((growth - 1) / 2 - 1e-6), 0) + 0.5
    inside = np.zeros((48, 64), bool)
    for px, py in zip(x.ravel(), y.ravel(), strict=True):
        left, right = int(np.floor(px + 0.5) - reach + 0.5), int(np.floor(px + 0.5) + reach + 0.5)
        top, bottom = int(np.floor(py + 0.5) - reach + 0.5), int(np.floor(py + 0.5) + reach + 0.5)
        inside[max(top, 0) : max(bottom, 0), max(left, 0) : max(right, 0)] = True
    np.testing.assert_array_equal(frame.coverage > 0, inside)
    assert frame.coverage.all() == (growth >= 1)


@pytest.mark.parametrize("visibility", VISIBILITIES)
def test_no_background_leaks_through_the_cracks_of_a_foreground(visibility: Any) -> None:
    rng = np.random.default_rng(6)
    camera = straight_camera(97, 61)
    disparity = np.full((61, 97), 0.1, np.float32)
    disparity[15:45, 25:70] = 0.5  # 2 m away; the wall 10 m
    color = np.full((61, 97, 3), 250, np.uint8)
    color[15:45, 25:70] = 20
    for _ in range(5):
        desired = Camera(
            random_rotation(rng, 0.1) @ camera.matrix,
            np.array([rng.uniform(-0.2, 0.2), 0.9, 0.05]),
            97,
            61,
        )
        corners = np.array([(25, 15), (69, 15), (69, 44), (25, 44)], float)
        u, v = np.meshgrid(np.arange(97.0), np.arange(61.0))
        back = warp_points(
            np.linalg.inv(np.vstack([warp_matrix(camera, desired), [0, 0, 0, 1]]))[:3],
            u, v, 0.5 / warp_depth(camera, desired, u, v),
        )  # fmt: skip
        inside = (
            (back[0] > corners[0, 0]) & (back[0] < corners[1, 0])
            & (back[1] > corners[0, 1]) & (back[1] < corners[2, 1])
        )  # fmt: skip
        assert inside.sum() > 1000
        for size in (3, "jacobian"):
            frame = warp(
                [ReferenceView(camera, color, disparity)],
                desired,
                reconstruction="splat",
                visibility=visibility,
                splat=SplatOptions(size=size),
            )
            assert np.all(frame.color[inside] == 20), size
        points = warp(ReferenceView(camera, color, disparity), desired, reconstruction="point")
        assert np.any(points.color[inside] != 20)  # cracks were there to leak through


def warp_depth(camera: Camera, desired: Camera, u: Any, v: Any) -> np.ndarray:
    """t of the frontal plane 2 m before ``camera`` at each desired pixel."""
    normal = camera.forward
    rays = desired.rays(u, v) @ normal
    depth = (2.0 - normal @ (desired.center - camera.center)) / rays
    return depth / 2.0


def test_a_nearer_neighbour_of_one_surface_does_not_push_a_sample_aside() -> None:
    """Splats of one surface share by nearness of their centers, so textures stay in place."""
    rng = np.random.default_rng(7)
    camera = straight_camera(64, 48)
    disparity = plane_disparity(camera, (0.1, 1.0, 0.05), 4.0)
    view = view_of(camera, disparity, noise(rng, 48, 64))
    frame = warp(view, camera, reconstruction="splat", splat=SplatOptions(size=5))
    np.testing.assert_array_equal(frame.color, view.color)


def test_a_sample_at_the_eye_grows_no_further_than_the_largest_splat() -> None:
    view = view_of(straight_camera(9, 9), np.full((9, 9), 1.0))
    for gap in (1e-3, 1e-6, 1e-7, 1e-12, 1e-30):
        desired = straight_camera(31, 31, (0, 1 - gap, 0), focal=9)
        frame = warp(view, desired, reconstruction="splat", splat=SplatOptions(largest=5))
        assert (frame.coverage > 0).sum() <= 25


@pytest.mark.parametrize("size", ["jacobian", 3])
def test_a_picture_magnified_by_splats_is_not_shifted(size: Any) -> None:
    """Colour is the coordinate, so that its mean error is the shift, in desired pixels."""
    growth, height, width = 2.2, 48, 64
    camera = bv.Camera.look_at((0, 0, 0), (1, 0, 0), width=width, height=height)
    intrinsics = camera.intrinsics
    intrinsics[0, 0] *= growth
    intrinsics[1, 1] *= growth
    closer = bv.Camera.from_intrinsics(intrinsics, camera.camera_to_world, width, height)
    v, u = np.mgrid[:height, :width].astype(np.float32)
    disparity = np.full((height, width), 0.5, np.float32)
    view = bv.ReferenceView(camera, np.stack([u, v, 0 * u], axis=-1), disparity)
    frame = warp(view, closer, reconstruction="splat", splat=SplatOptions(size=size))
    true_u, true_v, _ = camera.project(closer.unproject(*closer.pixel_grid(), disparity))
    assert (frame.coverage == 1).all()
    assert abs(float((frame.color[..., 0] - true_u).mean()) * growth) < 0.02
    assert abs(float((frame.color[..., 1] - true_v).mean()) * growth) < 0.02
