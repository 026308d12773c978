from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from belvedere.ground.errors import CameraError, InputError
from belvedere.scene import Camera, CameraModel
from belvedere.scene.pose import pose_matrix
from tests.strategies import (
    F8,
    any_cameras,
    numbers,
    pixels,
    places,
    planar_cameras,
    poses,
    rotations,
)

K = np.array([[500.0, 0.0, 319.5], [0.0, 510.0, 239.5], [0.0, 0.0, 1.0]])


# ---- laws of every kind of camera ----------------------------------------------------------------


@given(st.data())
def test_projecting_what_was_unprojected_gives_the_pixel_back(data: st.DataObject) -> None:
    camera = data.draw(any_cameras())
    u, v = data.draw(pixels(camera))
    delta = data.draw(numbers(0.02, 10.0))
    point = camera.unproject(u, v, delta)
    back = camera.project(point)
    # positions are within 60 m, so rounding leaves 1e-14 m: 1e-9 px with a thousand to spare
    np.testing.assert_allclose(back, (u, v, delta), atol=1e-9, rtol=1e-9)


@given(any_cameras(), places())
def test_unprojecting_what_was_projected_gives_the_point_back(
    camera: CameraModel, point: F8
) -> None:
    u, v, delta = camera.project(point)
    if np.isnan(delta) or delta > 1e3 or max(abs(u), abs(v)) > 1e5:
        return  # no image, or seen at so flat an angle that digits are lost
    np.testing.assert_allclose(camera.unproject(u, v, delta), point, atol=1e-8)


@given(st.data())
def test_a_resized_camera_keeps_the_edges_of_its_picture(data: st.DataObject) -> None:
    camera = data.draw(any_cameras())
    width, height = data.draw(st.integers(1, 64)), data.draw(st.integers(1, 64))
    resized: CameraModel = camera.resized(width, height)
    assert resized.size == (height, width)
    across, down = data.draw(numbers(0.0, 1.0)), data.draw(numbers(0.0, 1.0))
    old = across * camera.width - 0.5, down * camera.height - 0.5
    new = across * width - 0.5, down * height - 0.5
    np.testing.assert_allclose(resized.rays(*new), camera.rays(*old), atol=1e-12)
    np.testing.assert_allclose(resized.origins(*new), camera.origins(*old), atol=1e-12)


@given(any_cameras())
def test_rays_of_all_pixels_are_the_rays_of_each(camera: CameraModel) -> None:
    u, v = camera.pixel_grid()
    rays = camera.rays(u, v)
    assert rays.shape == (camera.height, camera.width, 3)
    last = camera.rays(camera.width - 1, camera.height - 1)
    np.testing.assert_allclose(rays[-1, -1], last, rtol=1e-13, atol=1e-13)


@given(any_cameras())
def test_a_camera_cannot_be_changed_by_writing_into_its_arrays(camera: CameraModel) -> None:
    with pytest.raises(ValueError, match="read-only"):
        camera.center[0] = 1.0


# ---- planar: builders both ways ------------------------------------------------------------------


@given(planar_cameras(), rotations(), places())
def test_intrinsics_and_pose_come_back_as_they_were_given(
    camera: Camera, rotation: F8, center: F8
) -> None:
    k = camera.intrinsics
    again = Camera.from_intrinsics(k, pose_matrix(rotation, center), camera.width, camera.height)
    np.testing.assert_allclose(again.intrinsics, k, rtol=1e-9, atol=1e-9 * k[0, 0])
    np.testing.assert_allclose(again.camera_to_world, pose_matrix(rotation, center), atol=1e-12)


@given(planar_cameras())
def test_a_camera_is_its_intrinsics_and_pose(camera: Camera) -> None:
    again = Camera.from_intrinsics(
        camera.intrinsics, camera.camera_to_world, camera.width, camera.height
    )
    np.testing.assert_allclose(again.matrix, camera.matrix, atol=1e-11)
    np.testing.assert_array_equal(again.center, camera.center)
    np.testing.assert_allclose(camera.world_to_camera @ camera.camera_to_world, np.eye(4),
                               atol=1e-12)  # fmt: skip


@given(poses(), places())
def test_projection_is_the_textbooks(pose: F8, point: F8) -> None:
    camera = Camera.from_intrinsics(K, pose, 640, 480)
    local = pose[:3, :3].T @ (point - pose[:3, 3])
    u, v, delta = camera.project(point)
    if local[2] <= 1e-3:
        assert local[2] > 0 or np.isnan([u, v, delta]).all()
        return
    image = K @ local
    np.testing.assert_allclose(delta, 1.0 / local[2], rtol=1e-9)
    np.testing.assert_allclose([u, v], image[:2] / image[2], rtol=1e-7, atol=1e-7)


@given(planar_cameras(), numbers(0.01, 100.0))
def test_a_matrix_with_its_plane_anywhere_is_the_same_camera(camera: Camera, plane: float) -> None:
    again = Camera.from_matrix(
        camera.matrix * plane, camera.center, width=camera.width, height=camera.height
    )
    np.testing.assert_allclose(again.matrix, camera.matrix, rtol=1e-12, atol=1e-13)


def test_what_is_looked_at_is_in_the_middle_and_up_is_above() -> None:
    camera = Camera.look_at((1, 2, 3), (4, 6, 3), fov_deg=60, width=641, height=481)
    u, v, delta = camera.project([(4.0, 6.0, 3.0), (4.0, 6.0, 3.5)])
    np.testing.assert_allclose(u, 320.0)
    np.testing.assert_allclose(v[0], 240.0)
    assert v[1] < 240.0
    np.testing.assert_allclose(delta, 1 / 5)


@pytest.mark.parametrize("fov_deg", [1.0, 60.0, 150.0])
def test_the_field_of_view_reaches_from_edge_to_edge(fov_deg: float) -> None:
    camera = Camera.look_at((0, 0, 0), (1, 0, 0), fov_deg=fov_deg, width=30, height=20)
    top, bottom = camera.rays(14.5, -0.5), camera.rays(14.5, 19.5)
    cosine = top @ bottom / np.linalg.norm(top) / np.linalg.norm(bottom)
    assert math.acos(cosine) == pytest.approx(math.radians(fov_deg))
    assert camera.fov == pytest.approx(math.radians(fov_deg))
    assert Camera.from_fov(fov_deg, camera.camera_to_world, 30, 20).fov == pytest.approx(camera.fov)


@given(rotations(), places(), numbers(0.2, 3.0), numbers(0.2, 3.0), places(3.0))
def test_the_corners_of_a_portal_are_the_corners_of_its_picture(
    rotation: F8, corner: F8, wide: float, high: float, shift: F8
) -> None:
    right, down, ahead = rotation[:, 0] * wide, rotation[:, 1] * high, rotation[:, 2]
    eye = corner + rotation @ [shift[0], shift[1], -1.0 - abs(shift[2])]
    camera = Camera.through_rectangle(eye, corner, right, down, width=40, height=30)
    corners = np.stack([corner, corner + right, corner + down, corner + right + down])
    u, v, delta = camera.project(corners)
    np.testing.assert_allclose(u, [-0.5, 39.5, -0.5, 39.5], atol=1e-9)
    np.testing.assert_allclose(v, [-0.5, -0.5, 29.5, 29.5], atol=1e-9)
    np.testing.assert_allclose(delta, 1.0 / (1.0 + abs(shift[2])), rtol=1e-9)
    np.testing.assert_allclose(camera.forward, ahead, atol=1e-9)


def test_a_crop_shows_what_its_pixels_showed() -> None:
    camera = Camera.from_intrinsics(K, np.eye(4), 640, 480)
    crop = camera.cropped(-10, 20, 100, 50)
    assert crop.size == (50, 100)
    np.testing.assert_allclose(crop.rays(13, 7), camera.rays(3, 27))


def test_a_moved_camera_looks_the_same_way() -> None:
    camera = Camera.look_at((0, 0, 0), (1, 1, 0))
    moved = camera.moved((1, 2, 3))
    np.testing.assert_array_equal(moved.matrix, camera.matrix)
    np.testing.assert_array_equal(moved.center, [1, 2, 3])


def test_points_behind_or_at_the_camera_have_no_image() -> None:
    camera = Camera.from_intrinsics(K, np.eye(4), 640, 480)
    for values in camera.project([[0, 0, -1.0], [0, 0, 0], [1, 0, 0]]):
        assert np.isnan(values).all()


def test_disparity_zero_is_infinitely_far() -> None:
    camera = Camera.from_intrinsics(K, np.eye(4), 640, 480)
    assert np.isinf(camera.unproject(0, 0, 0.0)).all()


# ---- refusals ------------------------------------------------------------------------------------


def _k(**entries: float) -> F8:
    k = K.copy()
    for name, value in entries.items():
        k[{"fx": (0, 0), "fy": (1, 1), "bottom": (2, 1), "slant": (1, 0)}[name]] = value
    return k


@pytest.mark.parametrize(
    ("k", "message"),
    [
        (_k(fx=0.0), r"Camera.K.fx is 0, expected a finite number above 0"),
        (_k(fy=-510.0), r"Camera.K.fy is -510, expected a finite number above 0"),
        (_k(fx=math.nan), r"Camera.K\[0, 0\] is nan, expected a finite number"),
        (_k(bottom=2.0), r"is it transposed or a projection matrix\?"),
        (_k(slant=1.0), r"expected \[0, fy, cy\] and \[0, 0, 1\]"),
        (K.T, r"is it transposed or a projection matrix\?"),
        (np.eye(4), r"Camera.K has shape \(4, 4\), expected \(3, 3\)"),
    ],
)
def test_intrinsics_that_no_camera_has_are_refused(k: F8, message: str) -> None:
    with pytest.raises(CameraError, match=message):
        Camera.from_intrinsics(k, np.eye(4), 640, 480)


def test_a_pose_that_is_not_rigid_is_refused() -> None:
    for pose, message in (
        (np.diag([2.0, 2.0, 2.0, 1.0]), r"is not rigid.*scale about 2"),
        (np.diag([1.0, 1.0, -1.0, 1.0]), r"mirrors space \(determinant -1\)"),
        (pose_matrix(np.eye(3), [1, 2, 3]).T, r"has the last row \[1.0, 2.0, 3.0, 1.0\]"),
        (np.full((4, 4), math.nan), r"camera_to_world\[0, 0\] is nan"),
        (np.eye(3), r"has shape \(3, 3\), expected \(4, 4\)"),
    ):
        with pytest.raises(CameraError, match=message):
            Camera.from_intrinsics(K, pose, 640, 480)


def test_a_picture_without_pixels_is_refused() -> None:
    for width, message in (
        (0, "Camera.width is 0, expected a whole number from 1"),
        (-3, "Camera.width is -3"),
        (2.5, "Camera.width is 2.5"),
        (1 << 21, "expected a whole number from 1 to 1048576"),
        (True, "Camera.width is True"),
    ):
        with pytest.raises(CameraError, match=message):
            Camera.from_intrinsics(K, np.eye(4), width, 480)  # type: ignore[arg-type]


def test_a_matrix_with_its_plane_elsewhere_is_refused_with_the_remedy() -> None:
    with pytest.raises(CameraError, match=r"image plane at depth 0.1, expected 1.*from_matrix"):
        Camera(0.1 * np.eye(3), np.zeros(3), 4, 4)


def test_singular_and_mirrored_matrices_are_refused() -> None:
    with pytest.raises(CameraError, match=r"Camera.matrix is singular"):
        Camera(np.diag([1.0, 0.0, 1.0]), np.zeros(3), 4, 4)
    with pytest.raises(CameraError, match="mirrors the picture or looks backwards"):
        Camera(np.diag([1.0, -1.0, 1.0]), np.zeros(3), 4, 4)


def test_an_impossible_field_of_view_is_refused() -> None:
    for fov_deg in (0.0, 180.0, -10.0, math.nan):
        with pytest.raises(CameraError, match=r"Camera.fov_deg is .*above 0 up to 179.99"):
            Camera.look_at((0, 0, 0), (1, 0, 0), fov_deg=fov_deg)


def test_a_portal_seen_from_behind_or_out_of_shape_is_refused() -> None:
    for eye, right, message in (
        ((0, 5, 0), (1, 0, 0), "mirrors the picture or looks backwards"),
        ((0, 0, 0.3), (1, 0, 0), "is singular"),
        ((0, -5, 0), (1, 0, 1), "perpendicular edges of a rectangle"),
    ):
        with pytest.raises(CameraError, match=message):
            Camera.through_rectangle(eye, (0, 0, 1), right, (0, 0, -1), width=8, height=8)


def test_text_in_a_position_is_refused() -> None:
    with pytest.raises(InputError, match=r"Camera.center is not an array of numbers"):
        Camera(np.eye(3), ["a", "b", "c"], 4, 4)  # type: ignore[arg-type]
