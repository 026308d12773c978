from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given

from belvedere.ground.checks import (
    as_array,
    check_choice,
    check_finite,
    check_image_size,
    check_integer,
    check_number,
    check_pose,
    check_shape,
    shape_text,
)
from belvedere.ground.errors import BelvedereError, CameraError, InputError
from belvedere.scene.pose import pose_matrix
from tests.strategies import F8, poses


def test_shapes_read_as_people_write_them() -> None:
    assert shape_text((480, 640, 3)) == "(480, 640, 3)"
    assert shape_text((5,)) == "(5,)"
    assert shape_text((None, 3)) == "(n, 3)"
    assert shape_text(()) == "()"


def test_a_wrong_shape_is_refused_with_both_shapes_and_the_remedy() -> None:
    check_shape("A", "b", np.zeros((2, 3)), (None, 3))
    with pytest.raises(InputError, match=r"A.b has shape \(2, 3\), expected \(n, 4\): crop it"):
        check_shape("A", "b", np.zeros((2, 3)), (None, 4), "crop it")
    with pytest.raises(CameraError, match=r"A.b has shape \(\), expected \(3,\)$"):
        check_shape("A", "b", np.zeros(()), (3,), error=CameraError)


def test_what_is_no_array_of_numbers_is_refused() -> None:
    for value in ("abc", [[1, 2], [3]], object(), {"a": 1}):
        with pytest.raises(InputError, match=r"A.b is not an array of numbers"):
            as_array("A", "b", value)
    assert as_array("A", "b", [1, 2]).dtype == np.float64
    assert as_array("A", "b", np.zeros(2, np.uint8), None).dtype == np.uint8


def test_nan_is_refused_with_its_place() -> None:
    check_finite("A", "b", np.zeros((2, 2)))
    with pytest.raises(InputError, match=r"A.b\[1, 0\] is inf, expected a finite number"):
        check_finite("A", "b", np.array([[0, 0], [math.inf, math.nan]]))
    with pytest.raises(CameraError, match=r"A.b is nan, expected"):
        check_finite("A", "b", math.nan, CameraError)


def test_an_unknown_word_is_refused_with_the_known_ones() -> None:
    check_choice("A", "b", "x", ("x", "y"))
    with pytest.raises(InputError, match=r"A.b is 'z', expected one of 'x', 'y'"):
        check_choice("A", "b", "z", ("x", "y"))
    with pytest.raises(InputError, match=r"A.b is \['x'\], expected one of"):
        check_choice("A", "b", ["x"], iter(("x", "y")))


def test_numbers_keep_to_their_bounds() -> None:
    assert check_number("A", "b", np.float32(0.5), 0, 1) == 0.5
    assert check_number("A", "b", 0, 0, 1) == 0.0
    cases: list[tuple[object, dict[str, Any], str]] = [
        (0, {"low": 0, "open_low": True}, r"A.b is 0, expected a finite number above 0$"),
        (2, {"low": 0, "high": 1}, r"A.b is 2, expected a finite number from 0 up to 1$"),
        (2, {"high": 1}, r"A.b is 2, expected a finite number up to 1$"),
        (math.nan, {}, r"A.b is nan, expected a finite number$"),
        (-math.inf, {}, r"A.b is -inf"),
        ("wide", {}, r"A.b is 'wide', expected a number"),
        (None, {}, r"A.b is None, expected a number"),
        ([1, 2], {}, r"A.b is \[1, 2\], expected a number"),
    ]
    for value, bounds, message in cases:
        with pytest.raises(InputError, match=message):
            check_number("A", "b", value, **bounds)


def test_whole_numbers_are_whole() -> None:
    assert check_integer("A", "b", np.int64(3), 1, 5) == 3
    for value in (0, 6, 2.0, True, "3", None, np.bool_(True), math.nan):
        with pytest.raises(InputError, match=r"A.b is .*, expected a whole number from 1 to 5"):
            check_integer("A", "b", value, 1, 5)


def test_a_size_nobody_has_is_refused() -> None:
    assert check_image_size("A", 16384, 8192) == (16384, 8192)
    with pytest.raises(CameraError, match=r"A.height is 0, expected a whole number from 1 to 1048"):
        check_image_size("A", 1, 0)


@given(poses())
def test_a_rigid_pose_passes_as_it_is(pose: F8) -> None:
    np.testing.assert_allclose(check_pose("A", "b", pose), pose, atol=1e-12)
    np.testing.assert_allclose(check_pose("A", "b", pose[:3]), pose, atol=1e-12)


@given(poses())
def test_a_pose_rounded_by_a_file_becomes_rigid_again(pose: F8) -> None:
    rounded = np.round(pose, 4)
    mended = check_pose("A", "b", rounded)
    np.testing.assert_allclose(mended[:3, :3].T @ mended[:3, :3], np.eye(3), atol=1e-14)
    np.testing.assert_allclose(mended, pose, atol=3e-4)


def test_what_is_no_pose_is_refused_with_what_it_may_be() -> None:
    cases: list[tuple[Any, str]] = [
        (np.eye(2), r"A.b has shape \(2, 2\), expected \(4, 4\): a pose is a 4x4 matrix"),
        (np.diag([3, 3, 3, 1]), r"is not rigid: .* \(scale about 3\): remove scale and shear"),
        (np.diag([1, -1, 1, 1]), r"mirrors space \(determinant -1\): flip one axis"),
        (pose_matrix(np.eye(3), [1, 0, 0]).T, r"is it transposed, or a projection matrix\?"),
        (pose_matrix(np.eye(3), [1, math.nan, 0]), r"A.b\[1, 3\] is nan"),
        (np.zeros((4, 4)), r"has the last row \[0.0, 0.0, 0.0, 0.0\]"),
    ]
    for pose, message in cases:
        with pytest.raises(CameraError, match=message):
            check_pose("A", "b", pose)


def test_our_refusals_are_caught_as_value_errors_too() -> None:
    with pytest.raises(ValueError, match=r"A.b"):
        check_number("A", "b", None)
    assert issubclass(CameraError, BelvedereError)
