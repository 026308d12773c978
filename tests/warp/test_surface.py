"""Scan conversion of intact cells: the disparity that each desired pixel sees."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from belvedere.scene import Camera
from belvedere.warp import WarpOptions, prepare, warp
from belvedere.warp.warp import _passage
from tests.oracles.surface import scan_convert
from tests.warp.worlds import (
    FORWARD_Y,
    plane_disparity,
    random_camera,
    random_rotation,
    straight_camera,
    view_of,
)

TOLERANCE = WarpOptions().surface_tolerance


def layer(shape: tuple[int, int]) -> tuple[Any, Any, Any]:
    """Centres, edges and masks with nothing drawn yet."""
    blank = np.full((2, *shape), -1.0, np.float32)
    return blank[0], blank[1], np.zeros(shape, np.uint16)


def drawn_surface(disparity: Any, reference: Camera, desired: Camera) -> Any:
    """(rows, columns) what `draw_surface` draws of the intact cells, -1 elsewhere."""
    from belvedere.warp import _surface

    held = prepare(view_of(reference, disparity), bridge=0)
    passage = _passage(held, desired, WarpOptions(), 1)
    out = layer(desired.size)
    _surface.draw_surface(
        passage.w, passage.disparity, passage.links, passage.tiles, 0, desired.height, TOLERANCE,
        *out,
    )  # fmt: skip
    return out[0]


def rolled(width: int, height: int, center: Any, angle: float, focal: float) -> Camera:
    """Looks along +y, turned about its axis."""
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0],
                     [0, 0, 1]])  # fmt: skip
    k = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
    return Camera(FORWARD_Y @ turn @ np.linalg.inv(k), np.asarray(center, float), width, height)


def test_the_surface_is_what_a_slow_scan_conversion_draws() -> None:
    rng = np.random.default_rng(0)
    compared = hidden = 0
    for n in range(24):
        reference = straight_camera(40, 26)  # more than a tile across
        bumps = gaussian_filter(rng.normal(size=(26, 40)), 3.0)
        disparity = (0.4 + 0.04 * bumps / np.abs(bumps).max()).astype(np.float32)
        disparity[rng.random(disparity.shape) < 0.02] = np.nan
        growth = (0.5, 1.0, 2.0, 5.0)[n % 4]
        k = np.diag([40.0 * growth, 40.0 * growth, 1.0])
        k[:2, 2] = 24.0, 15.0
        turn = random_rotation(rng, 0.2) @ FORWARD_Y
        angle = rng.uniform(-np.pi, np.pi)
        roll = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0],
                         [0, 0, 1]])  # fmt: skip
        desired = Camera(turn @ roll @ np.linalg.inv(k), rng.normal(0, 0.5, 3), 49, 31)
        wanted, doubt = scan_convert(reference, desired, disparity, 1e-3)
        found = drawn_surface(disparity, reference, desired)
        sure = ~doubt
        assert doubt.mean() < 0.06
        np.testing.assert_array_equal((found >= 0)[sure], (wanted >= 0)[sure])
        np.testing.assert_allclose(found[sure], wanted[sure], rtol=1e-4)
        compared += int((sure & (wanted >= 0)).sum())
        hidden += int((sure & (wanted < 0)).sum())
    assert compared > 8_000
    assert hidden > 2_000


def test_bands_drawn_apart_are_the_surface_drawn_at_once() -> None:
    from belvedere.warp import _surface

    rng = np.random.default_rng(1)
    for _ in range(20):
        reference, desired = straight_camera(70, 45), random_camera(rng, 61, 50, 0.5, 1.0)
        disparity = rng.uniform(0.3, 0.5, (45, 70)).astype(np.float32)
        held = prepare(view_of(reference, gaussian_filter(disparity, 2.0)))
        passage = _passage(held, desired, WarpOptions(), 1)
        given = passage.w, passage.disparity, passage.links, passage.tiles
        whole = layer(desired.size)
        _surface.draw_surface(*given, 0, 50, TOLERANCE, *whole)
        for low, high in ((0, 7), (7, 8), (8, 31), (31, 50)):
            band = layer((high - low, 61))
            _surface.draw_surface(*given, low, high, TOLERANCE, *band)
            for part, all_of_it in zip(band[:2], whole[:2], strict=True):
                np.testing.assert_array_equal(part, all_of_it[low:high])


def test_disparities_drawn_inside_a_surface_are_marked_sure_and_nearly_unchanged() -> None:
    camera = straight_camera(40, 30)
    delta = plane_disparity(camera, (0.1, 1, 0.2), 3.0).astype(np.float32)
    desired = camera.moved((0.1, 0.2, 0.05))
    found = drawn_surface(delta, camera, desired)
    seen = found >= 0
    assert seen.sum() > 600
    assert not (found[seen].view(np.uint32) & 1).any()
    truth = plane_disparity(desired, (0.1, 1, 0.2), 3.0)
    np.testing.assert_allclose(found[seen], truth[seen], rtol=1e-5)


@pytest.mark.parametrize("angle", [0.0, np.pi / 4, 2.0])
@pytest.mark.parametrize("growth", [1.0, 2.0, 3.3, 7.7])
def test_a_plane_that_grows_and_rolls_has_no_hole_and_lets_nothing_through(
    growth: float, angle: float
) -> None:
    """Two references see the wall behind the board too, from either side of it."""
    focal, board, wall = 60.0, 0.5, 0.2
    views = []
    for eye in (-0.2, 0.2):
        camera = straight_camera(60, 60, (eye, 0, 0), focal)
        x = (np.arange(60) - 29.5) / focal / board + eye
        across = np.abs(x) < 0.6
        near = across[None, :] & (np.abs((np.arange(60) - 29.5) / focal / board) < 0.6)[:, None]
        color = np.where(near[..., None], [0.9, 0.5, 0.2], [0.0, 0.1, 1.0]).astype(np.float32)
        views.append(view_of(camera, np.where(near, board, wall), color))
    forward = (1 - 1 / growth) / board
    desired = rolled(64, 64, (0.03, forward, 0.02), angle, focal)
    u, v = np.broadcast_arrays(*desired.pixel_grid())
    points = desired.unproject(u, v, board * growth)
    inside = (np.abs(points[..., 0]) < 0.5) & (np.abs(points[..., 2]) < 0.5)
    assert inside.sum() > 500
    for chosen in (views[:1], views):
        frame = warp(chosen, desired)
        np.testing.assert_array_equal(frame.coverage[inside], 1)
        np.testing.assert_allclose(frame.disparity[inside], board * growth, rtol=1e-4)
        expected = np.broadcast_to(np.array([0.9, 0.5, 0.2], np.float32), (int(inside.sum()), 3))
        np.testing.assert_allclose(frame.color[inside], expected, atol=1e-4)
