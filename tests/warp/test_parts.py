"""Cells cut at edges: together with the intact ones they tile the reference plane."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.warp import prepare
from belvedere.warp.silhouettes import Parts, cut_parts
from tests.oracles.surface import half_plane_area, inside_quad
from tests.warp.worlds import straight_camera, view_of

INTACT, MIXED, RIM, MIDDLE, TILE = 8, 4, 32, 127, 32


def steps(rng: np.random.Generator, height: int, width: int, block: int) -> Any:
    """Random terraces, ``block`` samples a side, of four depths."""
    coarse = rng.choice(
        np.array([0.1, 0.2, 0.4, 0.8], np.float32), (height // block + 1, width // block + 1)
    )
    return np.kron(coarse, np.ones((block, block), np.float32))[:height, :width].copy()


def cut(disparity: Any, right: Any = None, down: Any = None, threads: int = 1) -> Any:
    """Parts and links of a map, edges half way unless told."""
    height, width = disparity.shape
    held = prepare(view_of(straight_camera(width, height), disparity), bridge=0)
    links = held.links()
    middle = np.full(disparity.shape, MIDDLE, np.uint8)
    parts = cut_parts(
        disparity, links, middle if right is None else right, middle if down is None else down,
        threads,
    )  # fmt: skip
    return parts, links


def owners(parts: Parts, links: Any, u: float, v: float) -> tuple[int, list[int], float]:
    """Intact cells and parts that hold a point, and its distance from the nearest border."""
    height, width = links.shape
    i, j = int(np.floor(u)), int(np.floor(v))
    cell = 0 <= i < width - 1 and 0 <= j < height - 1 and bool(links[j, i] & INTACT)
    border = min(abs(u - round(u)), abs(v - round(v)))
    places = parts.corners[[0, 1, 3, 4, 6, 7, 9, 10]].astype(float)
    us, vs = places[0::2], places[1::2]
    close = np.flatnonzero((us.min(0) <= u + 1e-3) & (us.max(0) >= u - 1e-3)
                           & (vs.min(0) <= v + 1e-3) & (vs.max(0) >= v - 1e-3))  # fmt: skip
    held = []
    for n in close:
        inward = inside_quad(places[:, n], u, v)
        border = min(border, abs(inward))
        if inward > 0:
            held.append(int(n))
    return int(cell), held, border


def points(rng: np.random.Generator, height: int, width: int, count: int) -> Any:
    return zip(rng.uniform(-0.4, width - 0.6, count), rng.uniform(-0.4, height - 0.6, count),
               strict=True)  # fmt: skip


@pytest.mark.parametrize("block", [1, 2, 5])
def test_intact_cells_and_parts_tile_the_reference_plane(block: int) -> None:
    rng = np.random.default_rng(block)
    disparity = steps(rng, 37, 67, block)
    parts, links = cut(disparity)
    mixed = (links & MIXED) != 0
    tested = 0
    for u, v in points(rng, 37, 67, 3500):
        cell, held, border = owners(parts, links, u, v)
        if border < 1e-4 or abs(u % 1 - 0.5) < 1e-4 or abs(v % 1 - 0.5) < 1e-4:
            continue
        # half way, every point belongs to the sample nearest to it
        row, column = round(v), round(u)
        expected = 0 if mixed[row, column] and not cell else 1
        assert cell + len(held) == expected, (u, v)
        if held:
            low, high = parts.corners[2::3, held[0]].min(), parts.corners[2::3, held[0]].max()
            assert low <= disparity[row, column] * 1.0001
            assert high >= disparity[row, column] * 0.9999
        tested += 1
    assert tested > 3000


def test_two_parts_of_a_cell_meet_wherever_the_edge_runs() -> None:
    """Upright or level edges cut a cell in two halves, which share the edge."""
    rng = np.random.default_rng(2)
    for upright in (True, False):
        size = (40, 70)
        disparity = np.full(size, 0.2, np.float32)
        if upright:
            disparity[:, 20:45] = 0.8
        else:
            disparity[11:31] = 0.8
        right = rng.integers(0, 255, size).astype(np.uint8)
        down = rng.integers(0, 255, size).astype(np.uint8)
        right[:, -1], down[-1] = MIDDLE, MIDDLE
        parts, links = cut(disparity, right, down)
        for u, v in points(rng, *size, 1500):
            if not (0 < u < size[1] - 1 and 0 < v < size[0] - 1):
                continue  # beyond the outermost samples their own edges are cut off square
            cell, held, border = owners(parts, links, u, v)
            if border > 1e-4:
                assert cell + len(held) == 1, (u, v)


@pytest.mark.parametrize("degrees", [30, 45, 60])
def test_slanted_silhouettes_leave_hardly_a_gap_between_parts(degrees: float) -> None:
    """Known limit: where the edges of a cell's sides disagree, its parts are rectangles."""
    from belvedere.warp import _matte

    angle = np.deg2rad(degrees)
    normal = (float(np.cos(angle)), float(np.sin(angle)))
    offset = normal[0] * 20.2 + normal[1] * 19.7
    share = half_plane_area(40, 40, normal, offset)
    u, v = np.meshgrid(np.arange(40), np.arange(40))
    disparity = np.where(normal[0] * u + normal[1] * v < offset, 0.8, 0.2).astype(np.float32)
    color = np.zeros((40, 40, 4), np.float32)
    color[..., :3] = 0.1 + 0.8 * share[..., None]
    right, down = np.zeros((40, 40), np.uint8), np.zeros((40, 40), np.uint8)
    _, links = cut(disparity)
    _matte.find_edges(color, disparity, links, 0, 40, right, down)
    parts, _ = cut(disparity, right, down)
    rng = np.random.default_rng(8)
    broken = np.argwhere((links[:-1, :-1] & INTACT) == 0)
    places = broken[rng.integers(0, len(broken), 1500)] + rng.random((1500, 2))
    held = [len(owners(parts, links, float(x), float(y))[1]) for y, x in places]
    assert np.mean(np.array(held) == 0) < 0.02
    assert np.mean(np.array(held) > 1) < 0.2


def test_the_nearer_part_at_an_edge_is_marked_and_its_neighbour_is_not() -> None:
    disparity = np.full((20, 40), 0.2, np.float32)
    disparity[:, 12:25] = 0.8
    parts, _ = cut(disparity)
    inner = (parts.corners[1] >= 0) & (parts.corners[10] <= 19)
    inner &= (parts.corners[0] >= 0) & (parts.corners[3] <= 39)
    delta = parts.corners[2]
    assert inner.sum() == 2 * 2 * 19
    np.testing.assert_array_equal(parts.near[inner] == 1, delta[inner] == np.float32(0.8))


def test_near_and_far_are_told_apart_on_terraces() -> None:
    rng = np.random.default_rng(4)
    disparity = steps(rng, 40, 70, 6)
    parts, links = cut(disparity)
    centers = parts.corners[0::3].mean(0), parts.corners[1::3].mean(0)
    near_marked = 0
    for n, (u, v) in enumerate(zip(*centers, strict=True)):
        if not (0 < u < 69 and 0 < v < 39):
            continue
        j, i = int(v), int(u)
        cell = disparity[j : j + 2, i : i + 2]
        own = parts.corners[2, n]
        if np.unique(cell).size == 2 and own == cell.max():
            assert parts.near[n], "of two surfaces in a cell, all parts of the nearer one are near"
            near_marked += 1
        if own == cell.min() and not links[round(v), round(u)] & RIM:
            assert not parts.near[n]
    assert near_marked > 100


@pytest.mark.parametrize("corner", range(4))
def test_a_concave_corner_is_near_from_all_four_sides(corner: int) -> None:
    disparity = np.full((12, 12), 0.8, np.float32)
    disparity[np.s_[:6] if corner < 2 else np.s_[6:], np.s_[:6] if corner % 2 else np.s_[6:]] = 0.2
    parts, _ = cut(disparity)
    u, v = parts.corners[0::3].mean(0), parts.corners[1::3].mean(0)
    cell = (u > 5) & (u < 6) & (v > 5) & (v < 6)
    assert cell.sum() == 4
    np.testing.assert_array_equal(parts.near[cell] != 0, parts.corners[2, cell] > 0.5)


def test_the_ends_of_tiles_say_which_parts_are_whose() -> None:
    rng = np.random.default_rng(5)
    for height, width in ((70, 40), (32, 32), (33, 65), (5, 7), (1, 1), (2, 3), (64, 1)):
        disparity = steps(rng, height, width, 3)
        parts, _ = cut(disparity)
        tall, across = -(-height // TILE), -(-width // TILE)
        assert parts.ends.shape == (tall, across)
        count = parts.near.size
        assert parts.corners.shape == (12, count)
        ends = parts.ends.ravel()
        assert ends[-1] == count
        assert np.all(np.diff(ends) >= 0)
        begin = 0
        for tile, end in enumerate(ends):
            tv, tu = divmod(tile, across)
            u, v = parts.corners[0::3, begin:end], parts.corners[1::3, begin:end]
            # cells go by their upper left sample and end at the next tile's first
            assert np.all(u >= (tu * TILE if tu else -0.5))
            assert np.all(u <= min((tu + 1) * TILE, width - 0.5))
            assert np.all(v >= (tv * TILE if tv else -0.5))
            assert np.all(v <= min((tv + 1) * TILE, height - 0.5))
            begin = end


def test_parts_do_not_depend_on_the_threads() -> None:
    rng = np.random.default_rng(6)
    disparity = steps(rng, 150, 90, 4)
    disparity[rng.random(disparity.shape) < 0.05] = np.nan
    one, _ = cut(disparity)
    for threads in (2, 3, 4):
        many, _ = cut(disparity, threads=threads)
        for name in ("corners", "near", "ends"):
            assert getattr(one, name).tobytes() == getattr(many, name).tobytes()


def test_slanted_surfaces_go_on_into_their_parts() -> None:
    """A part's disparity is that of its surface's plane, up to the very edge."""
    rng = np.random.default_rng(7)
    u, v = np.meshgrid(np.arange(30, dtype=float), np.arange(24, dtype=float))
    for _ in range(10):
        a, b = rng.uniform(-2e-3, 2e-3, 2)
        near, far = 0.8 + a * u + b * v, 0.2 + b * u * 0.1 - a * v * 0.1
        mask = (u >= 9) & (u < 21) & (v >= 6) & (v < 18)
        disparity = np.where(mask, near, far).astype(np.float32)
        right = rng.integers(0, 255, u.shape).astype(np.uint8)
        parts, _ = cut(disparity, right)
        for corner in range(4):
            x, y, delta = parts.corners[3 * corner : 3 * corner + 3].astype(float)
            plane = np.where(delta > 0.5, 0.8 + a * x + b * y, 0.2 + b * x * 0.1 - a * y * 0.1)
            np.testing.assert_allclose(delta, plane, atol=2e-5)
