"""Un-mixing: where an edge runs between two samples, told by their colours."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.warp import prepare
from tests.oracles.surface import half_plane_area, interval_share
from tests.warp.worlds import straight_camera, view_of

NEAR, FAR = np.array([0.9, 0.6, 0.1]), np.array([0.1, 0.2, 0.7])
HEIGHT, WIDTH = 18, 22


def two_surfaces(normal: tuple[float, float], offset: float) -> tuple[Any, Any, Any]:
    """Colour box-filtered exactly, disparity of each sample's centre, and which surface it is."""
    share = half_plane_area(HEIGHT, WIDTH, normal, offset)[..., None]
    u, v = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    near = normal[0] * u + normal[1] * v < offset
    disparity = np.where(near, 0.8, 0.2).astype(np.float32)
    color = np.zeros((HEIGHT, WIDTH, 4), np.float32)
    color[..., :3] = share * NEAR + (1 - share) * FAR
    return color, disparity, near


def found_edges(color: Any, disparity: Any) -> tuple[Any, Any, Any]:
    """Places of the edges to the right and below, 0 to 1, and the links."""
    from belvedere.warp import _matte

    links = prepare(view_of(straight_camera(disparity.shape[1], disparity.shape[0]), disparity))
    bits = links.links()
    right, down = np.zeros(disparity.shape, np.uint8), np.zeros(disparity.shape, np.uint8)
    _matte.find_edges(color, disparity, bits, 0, disparity.shape[0], right, down)
    return right / 254.0, down / 254.0, bits


@pytest.mark.parametrize("slant", [0.0, 0.05, -0.12, 0.3])
@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("side", [1, -1])
def test_the_edge_is_found_within_a_twentieth_of_a_sample(
    axis: int, slant: float, side: int
) -> None:
    checked = 0
    for k in range(32):
        offset = side * (9 + (k + 0.5) / 32 + (2 if slant < 0 else 0))
        normal = (side * 1.0, side * slant) if axis == 0 else (side * slant, side * 1.0)
        color, disparity, near = two_surfaces(normal, offset)
        right, down, _ = found_edges(color, disparity)
        found = right if axis == 0 else down.T
        steps = near != np.roll(near, -1, axis=1 - axis)
        steps = steps if axis == 0 else steps.T
        for row, column in np.argwhere(steps):
            if not 2 <= column < steps.shape[1] - 4:
                continue
            truth = (offset - side * slant * row) * side - column
            assert 0 <= truth <= 1
            assert abs(found[row, column] - truth) < 0.05, (k, row, column)
            checked += 1
        # and nothing is said where there is no edge
        apart = ~(steps | np.roll(steps, 1, axis=1))
        assert np.all(found[apart] == 0.5)
    assert checked > 300


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("slant", [0.0, 0.05])
def test_unmixed_colours_are_the_pure_ones(axis: int, slant: float) -> None:
    for k in range(32):
        offset = 9 + (k + 0.5) / 32
        normal = (1.0, slant) if axis == 0 else (slant, 1.0)
        color, disparity, near = two_surfaces(normal, offset)
        view = view_of(straight_camera(WIDTH, HEIGHT), disparity, color[..., :3].copy())
        clean = prepare(view).silhouettes().color
        pure = np.where(near[..., None], NEAR, FAR)
        np.testing.assert_allclose(clean[..., :3], pure, atol=0.02)
        np.testing.assert_allclose(view.color, color[..., :3])  # the view keeps its own


def test_without_contrast_the_edge_is_taken_half_way() -> None:
    color, disparity, _ = two_surfaces((1.0, 0.0), 9.2)
    color[..., :3] = 0.4
    right, down, _ = found_edges(color, disparity)
    assert np.all(right == 0.5)
    assert np.all(down == 0.5)


def test_textures_louder_than_the_contrast_leave_the_edge_half_way() -> None:
    color, disparity, _ = two_surfaces((1.0, 0.0), 9.2)
    stripes = np.where(np.arange(WIDTH) % 2 == 0, 0.0, 1.0)
    color[..., :3] = stripes[None, :, None] + 0.2 * color[..., :3]
    right, _, _ = found_edges(color, disparity)
    assert np.all(right == 0.5)


def test_texture_draws_the_edge_toward_the_middle_and_never_past_it() -> None:
    for k in range(16):
        color, disparity, _ = two_surfaces((1.0, 0.0), 9 + (k + 0.5) / 16)
        plain, _, _ = found_edges(color, disparity)
        loud = color.copy()
        loud[:, 7, :3] += 0.4  # the sample before the pure one
        textured, _, _ = found_edges(loud, disparity)
        clear, drawn = plain[:, 9] - 0.5, textured[:, 9] - 0.5
        assert np.all(np.abs(drawn) <= np.abs(clear) + 1e-6)
        assert np.all(drawn * clear >= 0)
        if abs(clear[0]) > 0.1:
            assert np.all(np.abs(drawn) < 0.9 * np.abs(clear))


def strand(low: float, high: float, axis: int) -> tuple[Any, Any]:
    """Colour and disparity of an upright or level bar from ``low`` to ``high``, samples."""
    share = interval_share(WIDTH, low, high)
    middle = np.arange(WIDTH)
    hit = (middle >= low) & (middle < high)
    color = np.zeros((HEIGHT, WIDTH, 4), np.float32)
    color[..., :3] = share[:, None] * NEAR + (1 - share[:, None]) * FAR
    disparity = np.broadcast_to(np.where(hit, 0.8, 0.2), (HEIGHT, WIDTH)).astype(np.float32)
    if axis:
        return color.transpose(1, 0, 2).copy(), disparity.T.copy()
    return color, disparity


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("width", [1.0, 1.2, 1.5, 1.8])
def test_a_bar_one_sample_wide_is_found_by_its_light(axis: int, width: float) -> None:
    found_any = 0
    for low in np.linspace(9.01, 10.99, 67):
        color, disparity = strand(low, low + width, axis)
        near = disparity > 0.5
        one = near if axis == 0 else near.T
        column = int(one[0].argmax())
        beside = interval_share(WIDTH, low, low + width)[[column - 1, column + 1]]
        if one[0].sum() != 1 or (width > 1.0 and beside.min() < 0.08):
            continue  # two samples wide; or pure or not, nobody can tell
        right, down, _ = found_edges(color, disparity)
        edges = right if axis == 0 else down.T
        np.testing.assert_allclose(edges[2:-2, column - 1] + column - 1, low, atol=0.02)
        np.testing.assert_allclose(edges[2:-2, column] + column, low + width, atol=0.02)
        view = view_of(straight_camera(*near.T.shape), disparity, color[..., :3].copy())
        clean = prepare(view).silhouettes().color[..., :3]
        pure = np.where(near[..., None], NEAR, FAR)
        np.testing.assert_allclose(clean[2:-2, 2:-2], pure[2:-2, 2:-2], atol=0.02)
        found_any += 1
    assert found_any >= 3


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("near", [True, False])
def test_of_two_samples_between_two_edges_the_purer_is_believed(near: bool, axis: int) -> None:
    """A board two samples wide, or a gap between two boards."""
    found_any = 0
    for low in np.linspace(9.01, 9.99, 33):
        high = low + 2.1
        color, disparity = strand(low, high, axis)
        if not near:
            color[..., :3], disparity = NEAR + FAR - color[..., :3], 1.0 - disparity
        inner = np.abs(disparity - np.median(disparity)) > 0.1
        if (inner if axis == 0 else inner.T)[0].sum() != 2:
            continue
        column = int((inner if axis == 0 else inner.T)[0].argmax())
        right, down, _ = found_edges(color, disparity)
        edges = right if axis == 0 else down.T
        np.testing.assert_allclose(edges[2:-2, column - 1] + column - 1, low, atol=0.07)
        np.testing.assert_allclose(edges[2:-2, column + 1] + column + 1, high, atol=0.07)
        found_any += 1
    assert found_any >= 10


@pytest.mark.parametrize("turned", [False, True])
def test_a_surface_that_darkens_toward_its_edge_keeps_it(turned: bool) -> None:
    """The edge is half way; its sample is darker than any mixture that leaves it its centre."""
    row = np.array([0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 0.37, 0.27, 0.23, 0.23, 0.23, 0.23, 0.23])
    near = np.arange(row.size) < 8
    row, near = (row[::-1], near[::-1]) if turned else (row, near)
    color = np.zeros((9, row.size, 4), np.float32)
    color[..., :3] = row[None, :, None]
    disparity = np.broadcast_to(np.where(near, 0.8, 0.2), (9, row.size)).astype(np.float32)
    right, _, _ = found_edges(color, disparity)
    column = int(np.flatnonzero(near[1:] != near[:-1])[0])
    assert np.all(np.abs(right[:, column] - 0.5) < 0.15)


def test_where_depth_reaches_a_sample_too_far_the_edge_is_drawn_back() -> None:
    color, disparity, _ = two_surfaces((1.0, 0.0), 9.5)
    disparity[:, 10] = disparity[:, 9]  # of the near surface, by its depth alone
    right, _, _ = found_edges(color, disparity)
    assert np.all(right[:, 10] < 0.02)


@pytest.mark.parametrize("width", [0.6, 0.8, 1.0, 1.3])
def test_a_thin_bar_keeps_its_light_whatever_width_is_taken(width: float) -> None:
    for low in np.linspace(9.0, 10.0, 23):
        color, disparity = strand(low, low + width, 0)
        columns = np.flatnonzero(disparity[0] > 0.5)
        if columns.size != 1:
            continue
        right, _, _ = found_edges(color, disparity)
        clean = prepare(view_of(straight_camera(WIDTH, HEIGHT), disparity, color[..., :3].copy()))
        pure = clean.silhouettes().color[8, columns[0], :3]
        taken = right[8, columns[0]] + 1.0 - right[8, columns[0] - 1]
        light = taken * (pure - FAR) / (width * (NEAR - FAR))
        np.testing.assert_allclose(light[pure > 0], 1.0, atol=0.03)  # no colour is below 0


def test_before_a_texture_louder_than_it_a_bar_keeps_its_halves_and_its_colour() -> None:
    color, disparity = strand(9.3, 10.3, 0)
    loud = color.copy()
    loud[:, [7, 12], :3] += 1.0
    right, _, _ = found_edges(loud, disparity)
    assert np.all(right == 0.5)
    view = view_of(straight_camera(WIDTH, HEIGHT), disparity, loud[..., :3].copy())
    np.testing.assert_array_equal(prepare(view).silhouettes().color[..., :3], loud[..., :3])


def test_a_lone_sample_is_no_bar() -> None:
    disparity = np.full((9, 15), 0.2, np.float32)
    disparity[4, 7] = 0.8
    color = np.zeros((9, 15, 4), np.float32)
    color[4, 6, :3], color[4, 7, :3] = 0.3, 0.8
    right, down, _ = found_edges(color, disparity)
    assert np.all(right == 0.5)
    assert np.all(down == 0.5)


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (2, 3), (3, 2), (4, 4)])
def test_tiny_pictures_have_no_pure_colours_beyond_their_border(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        disparity = rng.choice(np.array([0.1, 0.4, np.nan], np.float32), shape).astype(np.float32)
        color = rng.uniform(0, 1, (*shape, 3)).astype(np.float32)
        clean = prepare(view_of(straight_camera(shape[1], shape[0]), disparity, color), bridge=0)
        found = clean.silhouettes().color
        assert np.isfinite(found).all()
        assert found.min() >= 0
        if max(shape) < 4:
            np.testing.assert_array_equal(found[..., :3], color)
