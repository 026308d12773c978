from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given

from belvedere.ground.errors import CameraError
from belvedere.scene import CylinderCamera, SphereCamera
from belvedere.scene.panoramic import Panoramic
from tests.strategies import F8, cylinder_cameras, places, rotations, sphere_cameras

KINDS = [CylinderCamera, SphereCamera]


@pytest.mark.parametrize("kind", KINDS)
def test_the_middle_looks_ahead_and_u_grows_to_the_right(kind: type[Panoramic]) -> None:
    camera = kind(np.zeros(3), 361, 181)
    np.testing.assert_allclose(camera.rays(180, 90), [1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(camera.rays(180 + 361 / 4, 90), [0, -1, 0], atol=1e-15)
    np.testing.assert_allclose(camera.rays(180 - 361 / 4, 90), [0, 1, 0], atol=1e-15)
    assert camera.rays(180, 0)[2] > 0 > camera.rays(180, 180)[2]


@pytest.mark.parametrize("kind", KINDS)
def test_a_panorama_taken_somewhere_shows_forward_in_its_middle(kind: type[Panoramic]) -> None:
    forward, up = np.array([1.0, 2.0, 0.5]), np.array([0.1, 0.0, 2.0])
    camera = kind.at((1, 2, 3), forward, up, width=101, height=51)
    u, v, _ = camera.project([camera.center + forward, camera.center + up + 0.01 * forward])
    assert u[0] == pytest.approx(50)
    assert u[1] == pytest.approx(50)
    assert v[1] < v[0] < 25  # forward leans up a little
    np.testing.assert_array_equal(camera.center, [1, 2, 3])


@given(cylinder_cameras(), places())
def test_a_cylinders_disparity_is_one_over_the_horizontal_distance(
    camera: CylinderCamera, point: F8
) -> None:
    local = camera.rotation.T @ (point - camera.center)
    distance = math.hypot(local[0], local[1])
    if distance < 1e-3:
        return
    u, v, delta = camera.project(point)
    assert delta == pytest.approx(1.0 / distance)
    assert -0.5 <= u < camera.width - 0.5
    height_on_cylinder = local[2] / distance
    assert camera.horizon - v == pytest.approx(height_on_cylinder / camera.row_step, abs=1e-9)


@given(sphere_cameras(), places())
def test_a_spheres_disparity_is_one_over_the_range(camera: SphereCamera, point: F8) -> None:
    distance = float(np.linalg.norm(point - camera.center))
    if distance < 1e-3:
        return
    u, v, delta = camera.project(point)
    assert delta == pytest.approx(1.0 / distance)
    assert -0.5 <= u < camera.width - 0.5
    assert -0.5 <= v <= camera.height - 0.5


@given(sphere_cameras())
def test_a_spheres_rays_have_unit_length(camera: SphereCamera) -> None:
    rays = camera.rays(*camera.pixel_grid())
    np.testing.assert_allclose(np.linalg.norm(rays, axis=-1), 1.0, atol=1e-13)


def test_a_sphere_reaches_from_zenith_to_nadir() -> None:
    camera = SphereCamera.at((0, 0, 0), width=8)
    assert camera.size == (4, 8)
    np.testing.assert_allclose(camera.rays(3, -0.5), [0, 0, 1], atol=1e-15)
    np.testing.assert_allclose(camera.rays(3, 3.5), [0, 0, -1], atol=1e-15)
    _, v, delta = camera.project([(0, 0, 2.0), (0, 0, -4.0)])
    np.testing.assert_allclose(v, [-0.5, 3.5])
    np.testing.assert_allclose(delta, [0.5, 0.25])


@pytest.mark.parametrize("kind", KINDS)
def test_columns_wrap_round(kind: type[Panoramic]) -> None:
    camera = kind(np.zeros(3), 16, 8)
    for u in (-0.5, -0.25, 0.0, 7.5, 15.0, 15.49):
        for turns in (-2, 1, 3):
            found, _, _ = camera.project(camera.unproject(u + 16 * turns, 3.0, 0.5))
            assert found == pytest.approx(u, abs=1e-9) or found == pytest.approx(u + 16, abs=1e-9)
            assert -0.5 <= found < 15.5


@pytest.mark.parametrize("kind", KINDS)
def test_the_seam_never_falls_out_of_the_picture(kind: type[Panoramic]) -> None:
    camera = kind(np.zeros(3), 7, 4, azimuth=0.0)
    angles = math.pi / 7 + np.array([0.0, 1e-16, -1e-16, 1e-15, -1e-15, 2 * math.pi])
    u, _, _ = camera.project(np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1))
    assert ((u >= -0.5) & (u < 6.5)).all()


def test_the_center_and_the_axis_of_a_cylinder_have_no_image() -> None:
    cylinder = CylinderCamera.at((1, 2, 3), width=8, height=4)
    sphere = SphereCamera.at((1, 2, 3), width=8)
    for camera, points in (
        (cylinder, [[1, 2, 3], [1, 2, 9], [math.inf, 0, 0], [math.nan, 0, 0]]),
        (sphere, [[1, 2, 3], [0, -math.inf, 0]]),
    ):
        for values in camera.project(points):
            assert np.isnan(values).all()


def test_square_pixels_are_the_default() -> None:
    camera = CylinderCamera(np.zeros(3), 400, 100)
    middle, right, below = camera.rays(200, 50), camera.rays(201, 50), camera.rays(200, 51)
    across, down = np.linalg.norm(right - middle), np.linalg.norm(below - middle)
    assert across == pytest.approx(float(down), rel=1e-4)


def test_the_vertical_field_of_view_reaches_from_edge_to_edge() -> None:
    camera = CylinderCamera.at((0, 0, 0), fov_deg=70, width=400, height=100)
    assert camera.fov == pytest.approx(math.radians(70))
    top = camera.rays(0, -0.5)
    assert math.atan2(top[2], math.hypot(top[0], top[1])) == pytest.approx(math.radians(35))


@given(cylinder_cameras(), rotations())
def test_turning_a_cylinder_turns_its_rays(camera: CylinderCamera, turn: F8) -> None:
    turned = CylinderCamera(
        camera.center, camera.width, camera.height, turn @ camera.rotation, camera.azimuth,
        camera.horizon, camera.row_step,
    )  # fmt: skip
    np.testing.assert_allclose(turned.rays(1, 2), turn @ camera.rays(1, 2), atol=1e-11)


@pytest.mark.parametrize("kind", KINDS)
def test_a_moved_panorama_looks_the_same_way(kind: type[Panoramic]) -> None:
    camera = kind.at((0, 0, 0), (1, 1, 0), width=16, height=8)
    moved = camera.moved((1, 2, 3))
    np.testing.assert_array_equal(moved.rays(2, 3), camera.rays(2, 3))
    np.testing.assert_array_equal(moved.center, [1, 2, 3])


@pytest.mark.parametrize("kind", KINDS)
def test_panoramas_that_cannot_be_are_refused(kind: type[Panoramic]) -> None:
    name = kind.__name__
    for arguments, message in (
        ({"width": 0}, rf"{name}.width is 0"),
        ({"center": [0, math.nan, 0]}, rf"{name}.center\[1\] is nan"),
        ({"center": [0, 0]}, rf"{name}.center has shape \(2,\), expected \(3,\)"),
        ({"rotation": np.diag([1, 1, -1])}, rf"{name}.rotation mirrors space"),
        ({"rotation": 2 * np.eye(3)}, rf"{name}.rotation is not rigid"),
        ({"azimuth": math.inf}, rf"{name}.azimuth is inf"),
    ):
        values = {"center": [0, 0, 0], "width": 8, "height": 4, **arguments}
        with pytest.raises(CameraError, match=message):
            kind(**values)
    with pytest.raises(CameraError, match=rf"{name}.forward .* is parallel to up"):
        kind.at((0, 0, 0), (0, 0, 1), width=8, height=4)
    with pytest.raises(CameraError, match=rf"{name}.up is the zero vector"):
        kind.at((0, 0, 0), up=(0, 0, 0), width=8, height=4)


def test_a_cylinder_with_rows_of_no_height_is_refused() -> None:
    with pytest.raises(CameraError, match=r"CylinderCamera.row_step is 0, expected"):
        CylinderCamera((0, 0, 0), 8, 4, row_step=0.0)
    with pytest.raises(CameraError, match=r"CylinderCamera.horizon is nan"):
        CylinderCamera((0, 0, 0), 8, 4, horizon=math.nan)
    with pytest.raises(CameraError, match=r"CylinderCamera.fov_deg is 180"):
        CylinderCamera.at((0, 0, 0), fov_deg=180, width=8, height=4)
