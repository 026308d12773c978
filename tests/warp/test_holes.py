"""Holes are filled only when asked, from the farther side, and never in secret."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.scene import Frame, ReferenceView
from belvedere.warp import RECONSTRUCTIONS, fill_background, warp
from tests.warp.worlds import grey, noise, straight_camera, view_of


def frame_of(disparity: np.ndarray, color: np.ndarray) -> Frame:
    d = disparity.astype(np.float32)
    camera = straight_camera(d.shape[1], d.shape[0])
    return Frame(camera, color, d, np.where(np.isnan(d), 0, 1).astype(np.float32))


@pytest.mark.parametrize("turn", range(4))
def test_a_hole_between_foreground_and_background_takes_the_background(turn: int) -> None:
    disparity = np.full((20, 30), 0.2)
    disparity[:, 18:] = 1.0
    disparity[:, 14:18] = np.nan
    color = np.where(disparity[..., None] > 0.5, 250, 40).repeat(3, -1).astype(np.uint8)
    disparity, color = np.rot90(disparity, turn), np.ascontiguousarray(np.rot90(color, turn))
    color[np.isnan(disparity)] = 0
    filled = fill_background(frame_of(disparity, color))
    holes = np.isnan(disparity)
    assert filled.filled is not None
    np.testing.assert_array_equal(filled.filled, holes)
    assert np.all(filled.color[holes] == 40)
    np.testing.assert_allclose(filled.disparity[holes], 0.2, rtol=1e-6)
    assert np.all(filled.coverage[holes] == 0)
    np.testing.assert_array_equal(filled.color[~holes], color[~holes])
    np.testing.assert_array_equal(filled.disparity[~holes], disparity.astype(np.float32)[~holes])


def test_every_hole_is_filled_with_something_known_however_large() -> None:
    rng = np.random.default_rng(0)
    for share in (0.2, 0.7, 0.97, 0.998):
        disparity = rng.uniform(0.1, 3, (37, 53))
        disparity[rng.random(disparity.shape) < share] = np.nan
        if np.isnan(disparity).all():
            disparity[3, 50] = 1.0
        color = rng.uniform(0.2, 5, (37, 53, 3)).astype(np.float32)
        filled = fill_background(frame_of(disparity, color))
        known = ~np.isnan(disparity)
        assert filled.filled is not None
        np.testing.assert_array_equal(filled.filled, ~known)
        for before, after in ((disparity.astype(np.float32), filled.disparity),
                              (color, filled.color)):  # fmt: skip
            np.testing.assert_array_equal(after[known], before[known])
            assert after.min() >= before[known].min() * (1 - 1e-5)
            assert after.max() <= before[known].max() * (1 + 1e-5)


def test_a_foreground_that_holes_surround_is_not_continued() -> None:
    disparity = np.full((32, 40), 0.2)
    disparity[8:24, 10:30] = np.nan
    disparity[12:20, 15:25] = 1.0
    filled = fill_background(frame_of(disparity, grey(32, 40)))
    np.testing.assert_allclose(filled.disparity[np.isnan(disparity)], 0.2, rtol=1e-5)


def test_filled_colours_are_averages_of_light() -> None:
    disparity = np.array([[1, np.nan, np.nan, 1]], float)
    color = np.array([[[0] * 3, [0] * 3, [0] * 3, [255] * 3]], np.uint8)
    filled = fill_background(frame_of(disparity, color)).color[0, :, 0]
    assert filled.tolist() == [0, 156, 213, 255]  # a third and two thirds of the light


@pytest.mark.parametrize("kind", ["rgb8", "rgba8", "rgb32", "rgba32"])
def test_every_kind_of_colour_is_filled(kind: str) -> None:
    rng = np.random.default_rng(1)
    disparity = np.full((8, 9), 0.5)
    disparity[2:5, 3:6] = np.nan
    color = np.full_like(noise(rng, 8, 9, kind), 0.25 if "32" in kind else 77)
    filled = fill_background(frame_of(disparity, color))
    assert filled.color.dtype == color.dtype
    np.testing.assert_allclose(filled.color, color, rtol=1e-6)


def test_a_frame_without_holes_and_one_of_holes_only_come_back_as_they_are() -> None:
    for value in (1.0, np.nan):
        frame = frame_of(np.full((5, 6), value), grey(5, 6))
        filled = fill_background(frame)
        assert filled.filled is not None
        assert not filled.filled.any()
        np.testing.assert_array_equal(filled.color, frame.color)
        np.testing.assert_array_equal(filled.disparity, frame.disparity)


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_a_filled_frame_still_says_what_nobody_saw_and_its_view_leaves_it_out(
    reconstruction: Any,
) -> None:
    camera = straight_camera(48, 36)
    disparity = np.full((36, 48), 0.2, np.float32)
    disparity[10:26, 16:32] = 0.8
    view = ReferenceView(camera, noise(np.random.default_rng(2), 36, 48), disparity)
    desired = camera.moved((0.3, 0, 0))
    plain = warp(view, desired, reconstruction=reconstruction)
    filled = warp(view, desired, reconstruction=reconstruction, fill="background")
    assert plain.filled is None
    assert filled.filled is not None
    assert filled.filled.sum() > 50
    np.testing.assert_array_equal(filled.coverage, plain.coverage)
    np.testing.assert_array_equal(filled.holes, plain.holes)
    np.testing.assert_array_equal(filled.filled, plain.holes)
    assert filled.disparity[filled.filled].max() < 0.25
    again = filled.as_view()
    np.testing.assert_array_equal(np.isnan(again.disparity), plain.holes)


def test_filling_an_empty_picture_invents_nothing() -> None:
    camera = straight_camera(10, 8)
    view = view_of(camera, np.full((8, 10), np.nan))
    frame = warp(view, camera, fill="background")
    assert frame.hole_fraction == 1
    assert frame.filled is not None
    assert not frame.filled.any()
    assert not frame.color.any()
