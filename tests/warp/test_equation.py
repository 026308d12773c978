"""The warping equation against the world it stands for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from belvedere.ground.errors import CameraError, InputError
from belvedere.scene import Camera
from belvedere.warp import (
    area_growth,
    epipole,
    homography,
    jacobian,
    plane_homography,
    warp_matrix,
    warp_points,
)
from tests.oracles.warp import project_samples
from tests.strategies import planar_cameras
from tests.warp.worlds import plane_disparity, random_camera, straight_camera

seeds = st.integers(0, 2**32 - 1)


def pixels(rng: np.random.Generator, camera: Camera, count: int = 200):
    u = rng.uniform(-0.5, camera.width - 0.5, count)
    v = rng.uniform(-0.5, camera.height - 0.5, count)
    return u, v, rng.uniform(0.05, 2.0, count)


def seen(reference: Camera, desired: Camera, u, v, delta):
    """Those samples at least 5 cm in front of the desired camera: what a test can ask about."""
    depth = 1.0 / project_samples(reference, desired, u, v, delta)[2]
    keep = np.nan_to_num(depth) > 0.05
    return u[keep], v[keep], delta[keep]


@given(seeds)
def test_a_warp_lands_where_projecting_the_point_does(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = (random_camera(rng, 64, 48, turn=0.6) for _ in range(2))
    u, v, delta = seen(a, b, *pixels(rng, a))
    u2, v2, delta2 = warp_points(warp_matrix(a, b), u, v, delta)
    x, y, d = project_samples(a, b, u, v, delta)
    scale = np.maximum(1.0, np.hypot(x, y))
    assert np.all(np.abs(u2 - x) <= 1e-9 * scale)
    assert np.all(np.abs(v2 - y) <= 1e-9 * scale)
    np.testing.assert_allclose(delta2, d, rtol=1e-9)


@given(planar_cameras(), planar_cameras(), seeds)
def test_points_in_front_of_one_camera_are_those_with_positive_t(
    a: Camera, b: Camera, seed: int
) -> None:
    u, v, delta = pixels(np.random.default_rng(seed), a)
    points = a.unproject(u, v, delta)
    depth = (points - b.center) @ b.forward
    clear = np.abs(depth) > 1e-6
    u2, _, _ = warp_points(warp_matrix(a, b), u, v, delta)
    np.testing.assert_array_equal(np.isfinite(u2)[clear], depth[clear] > 0)


@given(seeds)
def test_warping_on_from_a_warp_is_warping_there_at_once(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b, c = (random_camera(rng, 64, 48, reach=0.5) for _ in range(3))
    u, v, delta = seen(a, c, *seen(a, b, *pixels(rng, a)))
    through = warp_points(warp_matrix(b, c), *warp_points(warp_matrix(a, b), u, v, delta))
    at_once = warp_points(warp_matrix(a, c), u, v, delta)
    for got, expected in zip(through, at_once, strict=True):
        np.testing.assert_allclose(got, expected, rtol=1e-9, atol=1e-9)


@given(seeds)
def test_around_one_center_a_warp_is_a_homography_whatever_the_depth(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a = random_camera(rng, 64, 48)
    b = random_camera(rng, 50, 70, turn=0.5).moved(a.center)
    u, v, delta = pixels(rng, a)
    u2, v2, _ = warp_points(warp_matrix(a, b), u, v, delta)
    image = homography(a, b) @ np.stack([u, v, np.ones_like(u)])
    front = image[2] > 0.01
    np.testing.assert_allclose(u2[front], (image[0] / image[2])[front], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(v2[front], (image[1] / image[2])[front], rtol=1e-9, atol=1e-9)


@given(seeds)
def test_a_plane_warps_as_its_homography(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = (random_camera(rng, 32, 24, reach=0.4) for _ in range(2))
    normal = np.array([0.0, 1.0, 0.0]) + rng.normal(0, 0.1, 3)
    offset = float(rng.uniform(4, 8))
    delta = plane_disparity(a, normal, offset)
    u, v = np.broadcast_arrays(*a.pixel_grid())
    kept = seen(a, b, u[delta > 0.01], v[delta > 0.01], delta[delta > 0.01])
    u2, v2, _ = warp_points(warp_matrix(a, b), *kept)
    matrix = plane_homography(a, b, normal, offset)
    r, s, t = matrix @ np.stack([kept[0], kept[1], np.ones_like(kept[0])])
    np.testing.assert_allclose(u2, r / t, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(v2, s / t, rtol=1e-9, atol=1e-9)


def test_rectified_stereo_moves_by_disparity_times_baseline_along_its_row() -> None:
    left, right = straight_camera(60, 40), straight_camera(60, 40, (0.3, 0, 0))
    delta = np.linspace(0, 2, 50)
    u2, v2, delta2 = warp_points(warp_matrix(left, right), 31.0, 17.0, delta)
    np.testing.assert_allclose(31.0 - u2, 60 * 0.3 * delta, atol=1e-12)
    np.testing.assert_allclose(v2, 17.0, atol=1e-12)
    np.testing.assert_allclose(delta2, delta, atol=1e-12)


@given(seeds)
def test_the_epipole_is_the_signed_image_of_the_desired_eye(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = (random_camera(rng, 64, 48, turn=3.0) for _ in range(2))
    e = epipole(a, b)
    depth = float((b.center - a.center) @ a.forward)
    np.testing.assert_allclose(e[2], depth, atol=1e-12)
    if depth > 1e-3:
        u, v, _ = a.project(b.center)
        np.testing.assert_allclose(e[:2] / e[2], [u, v], rtol=1e-9)
    np.testing.assert_allclose(a.matrix @ e + a.center, b.center, atol=1e-12)


@given(seeds)
def test_the_jacobian_is_the_slope_of_the_warp_and_its_determinant_the_growth(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = (random_camera(rng, 64, 48, reach=0.3) for _ in range(2))
    u, v, delta = seen(a, b, *pixels(rng, a))
    matrix, step = warp_matrix(a, b), 1e-5
    j = jacobian(matrix, u, v, delta)
    differences = np.empty_like(j)
    for column, (du, dv) in enumerate(((step, 0), (0, step))):
        ahead = warp_points(matrix, u + du, v + dv, delta)
        back = warp_points(matrix, u - du, v - dv, delta)
        for row in range(2):
            differences[:, row, column] = (ahead[row] - back[row]) / (2 * step)
    scale = 1.0 + np.abs(j).max(axis=(1, 2))
    assert np.all(np.abs(j - differences) <= 1e-4 * scale[:, None, None])
    t = matrix[2, 0] * u + matrix[2, 1] * v + matrix[2, 2] + matrix[2, 3] * delta
    growth = area_growth(matrix, delta, t)
    np.testing.assert_allclose(growth, np.linalg.det(j), rtol=1e-6, atol=1e-9)


@given(seeds)
def test_with_the_surface_slope_the_jacobian_is_exact_on_planes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = (random_camera(rng, 64, 48, reach=0.3) for _ in range(2))
    normal = np.array([0.0, 1.0, 0.0]) + rng.normal(0, 0.3, 3)
    slope = normal @ a.matrix / (6.0 - normal @ a.center)  # delta = slope . (u, v, 1)
    u, v, _ = pixels(rng, a)
    delta = slope[0] * u + slope[1] * v + slope[2]
    u, v, delta = seen(a, b, u[delta > 0.02], v[delta > 0.02], delta[delta > 0.02])
    matrix, step = warp_matrix(a, b), 1e-5
    j = jacobian(matrix, u, v, delta, (slope[0], slope[1]))
    for column, (du, dv) in enumerate(((step, 0), (0, step))):
        change = slope[0] * du + slope[1] * dv
        ahead = warp_points(matrix, u + du, v + dv, delta + change)
        back = warp_points(matrix, u - du, v - dv, delta - change)
        for row in range(2):
            difference = (ahead[row] - back[row]) / (2 * step)
            np.testing.assert_allclose(j[:, row, column], difference, rtol=1e-4, atol=1e-4)


def test_a_camera_that_comes_nearer_sees_an_area_grow_by_the_square() -> None:
    a, b = straight_camera(64, 48), straight_camera(64, 48, (0, 1, 0))  # a wall 2 m away, to 1 m
    np.testing.assert_allclose(area_growth(warp_matrix(a, b), 0.5, 0.5), 4.0)


def test_points_behind_the_desired_camera_have_no_image() -> None:
    a, b = straight_camera(8, 6), straight_camera(8, 6, (0, 3, 0))
    u2, v2, delta2 = warp_points(warp_matrix(a, b), 4.0, 3.0, [0.5, 0.25])
    assert np.isnan([u2[0], v2[0], delta2[0]]).all()
    assert np.isfinite([u2[1], v2[1], delta2[1]]).all()


def test_what_is_infinitely_far_stays_so() -> None:
    a, b = straight_camera(8, 6), straight_camera(8, 6, (5, 1, 2))
    assert warp_points(warp_matrix(a, b), 2.0, 3.0, 0.0) == (2.0, 3.0, 0.0)


def test_equations_refuse_what_they_cannot_mean() -> None:
    a, b = straight_camera(8, 6), straight_camera(8, 6, (1, 0, 0))
    with pytest.raises(InputError, match=r"warp_points.matrix has shape \(3, 3\), expected \(3, 4"):
        warp_points(np.eye(3), 0, 0, 0)
    with pytest.raises(CameraError, match="the plane passes through the reference's center"):
        plane_homography(a, b, (0, 1, 0), 0.0)
    with pytest.raises(InputError, match=r"plane_homography.normal has shape \(2,\)"):
        plane_homography(a, b, (0, 1), 1.0)
