from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.ground.errors import InputError, ViewError
from belvedere.scene import Camera, Frame, ReferenceView, SphereCamera

CAMERA = Camera.look_at((0, 0, 0), (0, 1, 0), width=4, height=3)
COLOR = np.full((3, 4, 3), 100, np.uint8)
ONES = np.ones((3, 4), np.float32)


def test_disparity_is_one_over_depth_and_what_has_no_depth_is_missing() -> None:
    depth = np.full((3, 4), 2.0)
    depth[0] = [0.0, np.nan, np.inf, 0.5]
    view = ReferenceView.from_depth(CAMERA, COLOR, depth)
    np.testing.assert_array_equal(view.disparity[0], [np.nan, np.nan, np.nan, 2.0])
    np.testing.assert_array_equal(view.disparity[1:], 0.5)
    assert view.disparity.dtype == np.float32


def test_depth_too_small_or_large_for_float32_is_missing() -> None:
    depth = np.full((3, 4), 1.0)
    depth[0] = [1e-60, 1e-42, 1e300, 1e-30]
    view = ReferenceView.from_depth(CAMERA, COLOR, depth)
    np.testing.assert_array_equal(np.isnan(view.disparity[0]), [True, True, True, False])


def test_the_callers_depth_is_not_written_to() -> None:
    depth = ONES * 0
    ReferenceView.from_depth(CAMERA, COLOR, depth)
    np.testing.assert_array_equal(depth, 0)


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("kind", [np.uint8, np.float32, np.float64, np.float16])
def test_colour_is_bytes_or_float32(channels: int, kind: Any) -> None:
    view = ReferenceView(CAMERA, np.ones((3, 4, channels), kind), ONES)
    assert view.color.dtype == (np.uint8 if kind == np.uint8 else np.float32)
    assert view.color.shape == (3, 4, channels)


def test_a_view_may_be_a_panorama() -> None:
    view = ReferenceView(SphereCamera.at((0, 0, 0), width=4, height=3), COLOR, ONES)
    assert view.camera.size == (3, 4)


def test_views_that_do_not_fit_their_camera_are_refused() -> None:
    cases: list[tuple[Any, Any, str]] = [
        (COLOR[:, :3], ONES, r"ReferenceView.color has shape \(3, 3, 3\), expected \(3, 4, 3\)"),
        (COLOR[..., 0], ONES, r"color has shape \(3, 4\), expected .*repeat a grey image three"),
        (COLOR.astype(np.int32), ONES, r"color is int32, expected uint8 \(sRGB\) or float32"),
        (COLOR, ONES[:2], r"disparity has shape \(2, 4\), expected \(3, 4\): resize it"),
        (COLOR, -ONES, r"disparity has negative or infinite values, expected 1/Z >= 0"),
        (COLOR, ONES * np.inf, r"disparity has negative or infinite values"),
        (COLOR, ONES.astype(np.int32), r"disparity is int32, expected floating point"),
    ]
    for color, disparity, message in cases:
        with pytest.raises(ViewError, match=message):
            ReferenceView(CAMERA, color, disparity)


def test_depth_that_is_no_depth_is_refused() -> None:
    for depth, message in (
        (-ONES, r"depth has negative values.*looking along -z \(OpenGL\)\?"),
        (ONES.astype(np.uint16), r"depth is uint16.*16-bit millimetres: depth \* 0.001"),
        (ONES[None], r"ReferenceView.depth has shape \(1, 3, 4\), expected \(3, 4\)"),
    ):
        with pytest.raises(ViewError, match=message):
            ReferenceView.from_depth(CAMERA, COLOR, depth)
    sphere: Any = SphereCamera.at((0, 0, 0), width=4, height=3)
    with pytest.raises(ViewError, match=r"camera is a SphereCamera, expected a planar Camera"):
        ReferenceView.from_depth(sphere, COLOR, ONES)


def test_ragged_lists_and_strange_cameras_are_refused() -> None:
    ragged: Any = [[[1, 2, 3], [1, 2]], [[1]]]
    with pytest.raises(InputError, match=r"ReferenceView.color is not an array of numbers"):
        ReferenceView(CAMERA, ragged, ONES)
    pose: Any = np.eye(4)
    with pytest.raises(ViewError, match=r"camera is a ndarray, expected a camera such as belved"):
        ReferenceView(pose, COLOR, ONES)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_colour_that_is_not_finite_is_refused_where_it_first_stands(value: float) -> None:
    color = np.ones((3, 4, 3), np.float32)
    color[1, 2, 0] = color[2, 3, 1] = value
    with pytest.raises(
        ViewError, match=r"ReferenceView\.color\[1, 2, 0\] is -?(nan|inf), expected a"
    ):
        ReferenceView(CAMERA, color, ONES)


def test_colour_too_large_for_float32_is_refused() -> None:
    with pytest.raises(ViewError, match=r"ReferenceView\.color\[0, 0, 0\] is inf"):
        ReferenceView(CAMERA, np.full((3, 4, 3), 1e300), ONES)


def test_masked_arrays_are_refused_with_advice_that_works() -> None:
    mask = np.zeros((3, 4), bool)
    mask[0, 0] = True
    ones = np.ma.MaskedArray(ONES, mask)
    color = np.ma.MaskedArray(COLOR, np.repeat(mask[..., None], 3, axis=2))
    with pytest.raises(ViewError, match=r"disparity is a masked.*disparity\.filled\(np\.nan\)"):
        ReferenceView(CAMERA, COLOR, ones)
    with pytest.raises(ViewError, match=r"depth is a masked array.*depth\.filled\(np\.nan\)"):
        ReferenceView.from_depth(CAMERA, COLOR, ones)
    with pytest.raises(ViewError, match=r"color is a masked array.*disparity NaN"):
        ReferenceView(CAMERA, color, ONES)
    view = ReferenceView.from_depth(CAMERA, color.filled(0), ones.filled(np.nan))
    np.testing.assert_array_equal(np.isnan(view.disparity), mask)


def frame(**changes: Any) -> Frame:
    coverage = ONES.copy()
    coverage[0, :2] = 0
    disparity = np.where(coverage > 0, ONES, np.nan).astype(np.float32)
    return Frame(**{"camera": CAMERA, "color": COLOR, "disparity": disparity,
                    "coverage": coverage, **changes})  # fmt: skip


def test_a_frame_knows_its_holes() -> None:
    assert frame().hole_fraction == pytest.approx(2 / 12)
    np.testing.assert_array_equal(np.argwhere(frame().holes), [[0, 0], [0, 1]])


def test_a_frame_is_a_reference_view_again() -> None:
    view = frame().as_view()
    assert isinstance(view, ReferenceView)
    assert view.camera is CAMERA
    np.testing.assert_array_equal(np.isnan(view.disparity), frame().holes)


def test_invented_pixels_do_not_pass_on() -> None:
    filled = frame(disparity=ONES, filled=frame().holes)
    np.testing.assert_array_equal(np.isnan(filled.as_view().disparity), filled.holes)
