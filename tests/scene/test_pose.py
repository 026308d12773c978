from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from scipy.spatial.transform import Rotation

from belvedere.ground.errors import CameraError
from belvedere.scene.pose import (
    OPENCV_FROM_OPENGL,
    invert_pose,
    look_at_rotation,
    quaternion_from_rotation,
    rotation_from_quaternion,
)
from tests.strategies import F8, poses, quaternions, rotations


@given(poses())
def test_a_pose_times_its_inverse_is_the_identity(pose: F8) -> None:
    np.testing.assert_allclose(invert_pose(pose) @ pose, np.eye(4), atol=1e-13)


@given(quaternions())
def test_a_quaternion_gives_the_rotation_that_scipy_gives(
    quaternion: tuple[float, float, float, float],
) -> None:
    w, x, y, z = quaternion
    np.testing.assert_allclose(
        rotation_from_quaternion(w, x, y, z),
        Rotation.from_quat([x, y, z, w]).as_matrix(),
        atol=1e-14,
    )


@given(rotations())
def test_a_rotation_survives_the_round_trip_through_its_quaternion(rotation: F8) -> None:
    quaternion = quaternion_from_rotation(rotation)
    assert quaternion[0] >= 0
    assert math.hypot(*quaternion) == pytest.approx(1.0, abs=1e-14)
    np.testing.assert_allclose(rotation_from_quaternion(*quaternion), rotation, atol=1e-14)


@pytest.mark.parametrize("axis", np.eye(3).tolist())
def test_half_turns_keep_every_digit(axis: list[float]) -> None:
    rotation = 2.0 * np.outer(axis, axis) - np.eye(3)
    assert quaternion_from_rotation(rotation) == (0.0, *axis)


def test_a_quarter_turn_about_z_takes_x_to_y() -> None:
    half = math.sqrt(0.5)
    turned = rotation_from_quaternion(half, 0.0, 0.0, half) @ [1.0, 0.0, 0.0]
    np.testing.assert_allclose(turned, [0.0, 1.0, 0.0], atol=1e-15)


def test_a_quaternion_that_is_not_of_unit_length_is_refused() -> None:
    with pytest.raises(CameraError, match=r"has length 5.477, expected 1: are these the right"):
        rotation_from_quaternion(1.0, 2.0, 3.0, 4.0)
    with pytest.raises(CameraError, match=r"pose.quaternion\[2\] is nan"):
        rotation_from_quaternion(1.0, 0.0, math.nan, 0.0)


def test_a_matrix_that_is_no_rotation_has_no_quaternion() -> None:
    with pytest.raises(CameraError, match=r"pose.rotation is not rigid"):
        quaternion_from_rotation(2.0 * np.eye(3))
    with pytest.raises(CameraError, match=r"pose.rotation mirrors space"):
        quaternion_from_rotation(np.diag([1.0, 1.0, -1.0]))
    with pytest.raises(CameraError, match=r"has shape \(4, 4\), expected \(3, 3\)"):
        quaternion_from_rotation(np.eye(4))


def test_changing_axes_to_opengl_twice_changes_nothing() -> None:
    np.testing.assert_array_equal(OPENCV_FROM_OPENGL @ OPENCV_FROM_OPENGL, np.eye(4))


def test_looking_north_has_east_on_the_right_and_up_above() -> None:
    rotation = look_at_rotation((1, 1, 1), (1, 5, 1), (0, 0, 1))
    np.testing.assert_allclose(rotation.T, [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-15)


def test_looking_at_oneself_or_along_up_is_refused() -> None:
    with pytest.raises(CameraError, match=r"are the same point \[1.0, 2.0, 3.0\]"):
        look_at_rotation((1, 2, 3), (1, 2, 3), (0, 0, 1))
    with pytest.raises(CameraError, match=r"is parallel to the line of sight: pass another up"):
        look_at_rotation((0, 0, 0), (0, 0, 5), (0, 0, 1))
    with pytest.raises(CameraError, match=r"look_at.up\[0\] is nan"):
        look_at_rotation((0, 0, 0), (0, 1, 0), (math.nan, 0, 1))
    with pytest.raises(CameraError, match=r"look_at.eye has shape \(2,\), expected \(3,\)"):
        look_at_rotation((0, 0), (0, 1, 0), (0, 0, 1))
