"""Numbers that spec image-warping promises, section 6, line by line.

1: here and tests/warp/test_equation.py. 2: here. 3: here. 4: here; that reversed order fails,
tests/warp/test_order.py. 5: the Jacobian and its determinant, tests/warp/test_equation.py; the box
of the ellipse, here. 6: here. 7: here, but for panoramic references. 8: here.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.scene import Camera
from belvedere.warp import (
    homography,
    jacobian,
    plane_homography,
    prepare,
    warp,
    warp_matrix,
    warp_points,
)
from tests.oracles.balls import Balls, grown, shrunk
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


def test_6_2_around_one_center_a_warp_is_the_homography() -> None:
    rng = np.random.default_rng(63)
    worst = 0.0
    for _ in range(300):
        a = random_camera(rng, 32, 24, reach=0.3)
        b = Camera(random_camera(rng, 32, 24).matrix, a.center, 32, 24)
        u, v = np.broadcast_arrays(*a.pixel_grid())
        x, y, _ = warp_points(warp_matrix(a, b), u, v, rng.uniform(0, 2, u.shape))
        r, s, t = np.moveaxis(np.stack([u, v, np.ones_like(u)], -1) @ homography(a, b).T, -1, 0)
        ask = (t > 0.05) & (np.hypot(x, y) < 1e3)
        worst = max(worst, float(np.hypot(x - r / t, y - s / t)[ask].max(initial=0)))
    assert worst < 1e-9


def test_6_3_warps_chain_point_by_point() -> None:
    """A to B to C is A to C, places and disparities: relative 1e-9 of 30,000 points and more."""
    rng = np.random.default_rng(64)
    count = 0
    for _ in range(300):
        a, b, c = (random_camera(rng, 64, 48, reach=0.3) for _ in range(3))
        u, v, delta = rng.uniform(0, 63, 200), rng.uniform(0, 47, 200), rng.uniform(0.05, 2, 200)
        x, y, d = warp_points(warp_matrix(a, b), u, v, delta)
        chained = warp_points(warp_matrix(b, c), x, y, d)
        straight = warp_points(warp_matrix(a, c), u, v, delta)
        near = (d < 20) & (straight[2] < 20) & (np.hypot(*straight[:2]) < 1e3)
        near &= np.hypot(x, y) < 1e3
        for one, other in zip(chained, straight, strict=True):
            np.testing.assert_allclose(one[near], other[near], rtol=1e-9, atol=1e-8)
        count += int(near.sum())
    assert count > 30_000


def test_6_5_the_box_of_equation_26_is_the_true_extent_of_the_ellipse() -> None:
    """``dr |row of J|`` along each axis, against the outermost of 10,000 points of the circle."""
    rng = np.random.default_rng(65)
    angle = np.linspace(0, 2 * np.pi, 10_000)
    circle = np.stack([np.cos(angle), np.sin(angle)])
    for _ in range(200):
        a, b = (random_camera(rng, 64, 48, reach=0.3) for _ in range(2))
        u, v, delta = rng.uniform(0, 63), rng.uniform(0, 47), rng.uniform(0.05, 0.5)
        stretch = jacobian(warp_matrix(a, b), u, v, delta)
        if not np.isfinite(stretch).all():
            continue
        ellipse = stretch @ circle
        np.testing.assert_allclose(np.hypot(*stretch.T), np.abs(ellipse).max(axis=1), rtol=1e-6)
        # and the ellipse is the level set of equation 25
        det = float(np.linalg.det(stretch))
        (j11, j12), (j21, j22) = stretch
        x, y = ellipse
        form = (j21**2 + j22**2) * x**2 - 2 * (j11 * j21 + j12 * j22) * x * y
        form += (j11**2 + j12**2) * y**2
        np.testing.assert_allclose(form / det**2, 1.0, rtol=1e-6)


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
        ("gaussian", 0.05, 0.115, 0.001),
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


def silhouette_shares(scene: Balls, move: Any, **choices: Any) -> tuple[float, float]:
    """Shares of what is hidden from the reference that is painted, and of what it saw that is not.

    Next to the border between the two, either is right.
    """
    camera = straight_camera(160, 120)
    tolerance = choices.pop("edge_tolerance", 0.05)
    there = camera.moved(move)
    inside, seen = scene.seen(there, camera)
    frame = warp(prepare(scene.photograph(camera), edge_tolerance=tolerance), there, **choices)
    unseen, known = inside & ~grown(seen), shrunk(seen)
    assert unseen.sum() > 150
    covered = frame.coverage > 0
    return float(covered[unseen].mean()), float((~covered)[known].mean())


SPHERE = Balls(((0.0, 4.0, 0.0),), 1.0)


@pytest.mark.parametrize("reconstruction", ["splat", "gaussian", "mesh", "offset", "inverse"])
def test_6_7_a_spheres_silhouette_exposes_what_no_reference_saw(reconstruction: Any) -> None:
    """Figures 17 and 18: the shadow of a light at the reference is a hole, and nothing else is."""
    painted, missing = silhouette_shares(SPHERE, (0.5, 0.2, 0.2), reconstruction=reconstruction)
    assert painted <= 0.005
    assert missing <= 0.001


def test_6_7_a_mesh_that_is_not_cut_stretches_a_skin_over_it() -> None:
    move = (0.5, 0.2, 0.2)
    painted, _ = silhouette_shares(SPHERE, move, reconstruction="mesh", edge_tolerance=1.0)
    assert painted > 0.99


def test_6_7_what_is_outside_the_frustum_hides_nothing_until_a_reference_sees_it() -> None:
    """Figure 20: an object beside the reference's picture ought to hide the wall, and does not."""
    scene = Balls(((3.0, 4.0, 0.0),), 0.8)
    camera = straight_camera(160, 120)
    there = camera.moved((1.5, 0, 0))
    ball = scene.look(there, *np.broadcast_arrays(*there.pixel_grid()))[2] >= 0
    assert ball.sum() > 500
    outside = scene.photograph(camera)
    assert not (scene.look(camera, *np.broadcast_arrays(*camera.pixel_grid()))[2] >= 0).any()
    blind = warp(outside, there)
    wrong = ball & (blind.coverage > 0) & (blind.disparity < 0.15)
    assert wrong.sum() > 0.2 * ball.sum()  # the wall shines through where the ball is
    both = warp([outside, scene.photograph(camera.moved((3.0, 0, 0)))], there)
    assert (both.disparity[shrunk(ball)] > 0.2).mean() > 0.95


def test_6_8_rectified_stereo_is_disparity_times_baseline() -> None:
    left = straight_camera(60, 40)
    delta = np.linspace(0, 2, 1001)
    u2, v2, _ = warp_points(warp_matrix(left, left.moved((0.3, 0, 0))), 31.0, 17.0, delta)
    assert np.abs((31.0 - u2) - 60 * 0.3 * delta).max() < 1e-12
    assert np.abs(v2 - 17.0).max() < 1e-12
