from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given

from belvedere.ground.errors import CameraError
from belvedere.scene import OrthographicCamera
from tests.strategies import F8, orthographic_cameras, places


@given(orthographic_cameras(), places())
def test_disparity_is_one_over_the_distance_to_the_image_plane(
    camera: OrthographicCamera, point: F8
) -> None:
    distance = float(camera.direction @ (point - camera.center))
    u, v, delta = camera.project(point)
    if distance < 1e-6:
        assert distance > 0 or np.isnan([u, v, delta]).all()
        return
    assert delta == pytest.approx(1.0 / distance)


@given(orthographic_cameras())
def test_all_rays_are_parallel_and_of_unit_length(camera: OrthographicCamera) -> None:
    rays = camera.rays(*camera.pixel_grid())
    np.testing.assert_array_equal(rays, np.broadcast_to(camera.direction, rays.shape))
    assert np.linalg.norm(camera.direction) == pytest.approx(1.0)


@given(orthographic_cameras())
def test_the_middle_of_the_picture_is_the_poses_origin(camera: OrthographicCamera) -> None:
    middle = camera.origins((camera.width - 1) / 2, (camera.height - 1) / 2)
    np.testing.assert_allclose(middle, camera.center, atol=1e-12)


def test_things_keep_their_size_however_far_they_are() -> None:
    camera = OrthographicCamera.along((0, 1, 0), view_height=2.0, width=200, height=100)
    assert camera.view_size == pytest.approx((4.0, 2.0))
    u, v, delta = camera.project([(-1, 1, 0.5), (1, 1, -0.5), (-1, 9, 0.5), (1, 9, -0.5)])
    np.testing.assert_allclose(u, [49.5, 149.5, 49.5, 149.5])
    np.testing.assert_allclose(v, [24.5, 74.5, 24.5, 74.5])
    np.testing.assert_allclose(delta, [1, 1, 1 / 9, 1 / 9])


def test_a_plan_looks_straight_down_with_north_above() -> None:
    plan = OrthographicCamera.look_at(
        (5, 5, 10), (5, 5, 0), (0, 1, 0), view_height=10, width=10, height=10
    )
    np.testing.assert_allclose(plan.direction, [0, 0, -1], atol=1e-15)
    u, v, delta = plan.project((6.0, 8.0, 2.0))
    assert (float(u), float(v), float(delta)) == pytest.approx((5.5, 1.5, 0.125))


def test_what_lies_on_or_behind_the_image_plane_has_no_image() -> None:
    camera = OrthographicCamera.along((0, 1, 0), view_height=2.0, width=4, height=4)
    for values in camera.project([[0, 0, 0], [0, -1, 0], [0, math.inf, 0], [math.nan, 1, 0]]):
        assert np.isnan(values).all()


def test_resizing_to_another_shape_makes_pixels_oblong() -> None:
    camera = OrthographicCamera(np.eye(4), 0.1, 40, 20).resized(10, 20)
    np.testing.assert_allclose(camera.pixel_size, [0.4, 0.1])
    assert camera.view_size == pytest.approx((4.0, 2.0))


def test_a_moved_camera_looks_the_same_way() -> None:
    camera = OrthographicCamera(np.eye(4), 0.1, 40, 20).moved((1, 2, 3))
    np.testing.assert_array_equal(camera.center, [1, 2, 3])
    np.testing.assert_array_equal(camera.direction, [0, 0, 1])
    with pytest.raises(CameraError, match=r"center has shape \(2,\)"):
        camera.moved((1, 2))


@pytest.mark.parametrize(
    ("pixel_size", "message"),
    [
        (0.0, r"OrthographicCamera.pixel_size is 0, expected"),
        (-1.0, r"pixel_size is -1"),
        (math.nan, r"pixel_size is nan"),
        ([1.0, 2.0, 3.0], r"pixel_size has shape \(3,\), expected \(2,\): one number, or"),
    ],
)
def test_pixels_without_size_are_refused(pixel_size: object, message: str) -> None:
    with pytest.raises(CameraError, match=message):
        OrthographicCamera(np.eye(4), pixel_size, 4, 4)  # type: ignore[arg-type]


def test_views_that_cannot_be_are_refused() -> None:
    with pytest.raises(CameraError, match=r"camera_to_world is not rigid"):
        OrthographicCamera(np.diag([2, 2, 2, 1]), 1.0, 4, 4)
    with pytest.raises(CameraError, match=r"OrthographicCamera.view_height is -1"):
        OrthographicCamera.along((0, 1, 0), view_height=-1, width=4, height=4)
    with pytest.raises(CameraError, match=r"OrthographicCamera.direction is the zero vector"):
        OrthographicCamera.along((0, 0, 0), view_height=1, width=4, height=4)
    with pytest.raises(CameraError, match=r"is parallel to the line of sight"):
        OrthographicCamera.along((0, 0, 1), view_height=1, width=4, height=4)
    with pytest.raises(CameraError, match=r"OrthographicCamera.width is 0"):
        OrthographicCamera(np.eye(4), 1.0, 0, 4)
