"""Numbers that spec image-warping promises, section 6. The laws themselves: tests/warp."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.warp import plane_homography, prepare, warp, warp_matrix, warp_points
from tests.oracles.city import City
from tests.oracles.warp import project_samples
from tests.warp.test_order import PLACES, wrong_share
from tests.warp.worlds import plane_disparity, random_camera, straight_camera

pytestmark = pytest.mark.slow


def test_6_1_a_hundred_thousand_points_land_where_they_are_projected_to() -> None:
    rng = np.random.default_rng(61)
    worst, count = 0.0, 0
    for _ in range(1000):
        a, b = (random_camera(rng, 64, 48, turn=0.6) for _ in range(2))
        u, v, delta = rng.uniform(0, 63, 100), rng.uniform(0, 47, 100), rng.uniform(0.05, 2, 100)
        x, y, d = project_samples(a, b, u, v, delta)
        near = (d < 20) & (np.hypot(x, y) < 1e3)  # 5 cm before the eye, and about in the picture
        u2, v2, _ = warp_points(warp_matrix(a, b), u[near], v[near], delta[near])
        worst = max(worst, float(np.hypot(u2 - x[near], v2 - y[near]).max(initial=0)))
        count += int(near.sum())
    assert count > 30_000
    assert worst < 1e-9


def test_6_2_a_plane_warps_as_its_homography() -> None:
    rng = np.random.default_rng(62)
    worst = 0.0
    for _ in range(300):
        a, b = (random_camera(rng, 32, 24, reach=0.3) for _ in range(2))
        normal = np.array([0.0, 1.0, 0.0]) + rng.normal(0, 0.05, 3)
        delta = plane_disparity(a, normal, 6.0)
        u, v = np.broadcast_arrays(*a.pixel_grid())
        x, y, d = warp_points(warp_matrix(a, b), u, v, delta)
        r, s, t = np.moveaxis(
            np.stack([u, v, np.ones_like(u)], -1) @ plane_homography(a, b, normal, 6.0).T, -1, 0
        )
        ask = (d < 20) & (delta > 0) & (np.hypot(x, y) < 1e3)
        worst = max(worst, float(np.hypot(x - r / t, y - s / t)[ask].max(initial=0)))
    assert worst < 1e-9


@pytest.mark.parametrize(("e", "sign"), PLACES)
def test_6_4_order_shows_no_pixel_of_a_wrong_surface(
    e: tuple[float, float, float], sign: float
) -> None:
    assert wrong_share(e, sign, scenes=40) == 0.0


def hole_and_false_shares(reconstruction: Any, edge_tolerance: float) -> tuple[float, float]:
    """Shares of the picture: holes, and surface that is nowhere near the truth."""
    holes = wrong = count = 0
    for seed in range(3):
        city = City(seed)
        camera = straight_camera(120, 90, (0, -14, 1.6))
        truth = city.photograph(camera.moved((0.5, -13.6, 1.9)), rays=1)
        view = prepare(city.photograph(camera, rays=1), edge_tolerance=edge_tolerance)
        frame = warp(view, truth.camera, reconstruction=reconstruction)
        d = truth.disparity
        around = np.stack([np.roll(d, (j, i), (0, 1)) for j in (-1, 0, 1) for i in (-1, 0, 1)])
        near = (np.abs(around - frame.disparity) <= 0.05 * d + 0.002).any(axis=0)
        holes += int((frame.coverage == 0).sum())
        wrong += int((~near & (frame.coverage > 0)).sum())
        count += d.size
    return holes / count, wrong / count


@pytest.mark.parametrize(
    ("reconstruction", "edge_tolerance", "holes", "wrong"),
    [
        ("point", 0.05, 0.204, 0.0062),
        ("splat", 0.05, 0.120, 0.0),
        ("mesh", 0.05, 0.130, 0.0),
        ("offset", 0.05, 0.115, 0.0009),
        ("mesh", 1.0, 0.036, 0.0905),
    ],
)
def test_6_6_splats_leave_holes_an_uncut_mesh_hangs_skins_and_a_cut_one_does_not(
    reconstruction: Any, edge_tolerance: float, holes: float, wrong: float
) -> None:
    """Fig. 16's analogue: the shares measured when this was written, and no more than a bit off."""
    measured = hole_and_false_shares(reconstruction, edge_tolerance)
    assert measured[0] == pytest.approx(holes, abs=0.01)
    assert measured[1] == pytest.approx(wrong, abs=0.002)


def test_6_8_rectified_stereo_is_disparity_times_baseline() -> None:
    left = straight_camera(60, 40)
    delta = np.linspace(0, 2, 1001)
    u2, v2, _ = warp_points(warp_matrix(left, left.moved((0.3, 0, 0))), 31.0, 17.0, delta)
    assert np.abs((31.0 - u2) - 60 * 0.3 * delta).max() < 1e-12
    assert np.abs(v2 - 17.0).max() < 1e-12
