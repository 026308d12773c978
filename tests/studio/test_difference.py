"""Pictures for the eye: grey is zero, holes are marked, depth keeps its order."""

from __future__ import annotations

import numpy as np
import pytest

from belvedere.ground.errors import InputError
from belvedere.studio.difference import (
    GREY,
    HOLE_TINT,
    coverage_picture,
    disparity_picture,
    dusk_table,
    picture_with_holes,
    signed_difference,
)


def test_equal_pictures_differ_by_flat_grey(rng: np.random.Generator) -> None:
    picture = rng.integers(0, 256, (6, 7, 3), dtype=np.uint8)
    assert (signed_difference(picture, picture) == GREY).all()


def test_a_lighter_prediction_is_lighter_than_grey_and_a_darker_one_darker() -> None:
    truth = np.full((2, 2, 3), 100, np.uint8)
    light = signed_difference(truth + np.uint8(10), truth, gain=2.0)
    dark = signed_difference(truth - np.uint8(10), truth, gain=2.0)
    assert (light == GREY + 10).all()
    assert (dark == GREY - 10).all()


def test_a_hole_is_not_shown_as_agreement() -> None:
    truth = np.zeros((2, 2, 3), np.uint8)
    known = np.array([[True, False], [True, True]])
    assert tuple(signed_difference(truth, truth, known)[0, 1]) == HOLE_TINT


def test_holes_are_tinted_in_the_coverage_picture_and_known_pixels_are_grey() -> None:
    color = np.full((2, 2, 3), (200, 30, 30), np.uint8)
    coverage = np.array([[1, 0], [1, 1]], np.float32)
    picture = coverage_picture(color, coverage)
    assert tuple(picture[0, 1]) == HOLE_TINT
    assert len(set(picture[0, 0].tolist())) == 1
    assert tuple(picture_with_holes(color, coverage)[0, 1]) == HOLE_TINT
    assert tuple(picture_with_holes(color, coverage)[0, 0]) == (200, 30, 30)


def test_nearer_is_lighter_in_steps_that_print_in_grey() -> None:
    luma = dusk_table() @ np.array([0.2126, 0.7152, 0.0722])
    assert (np.diff(luma) > -1.0).all()  # bytes round; in sixteenths of the table it only rises
    assert (np.diff(luma[::16]) > 0).all()


def test_disparity_without_a_sample_is_grey() -> None:
    picture = disparity_picture(np.array([[0.1, np.nan, 2.0]], np.float32), 0.1, 2.0)
    assert (picture[0, 1] == GREY).all()
    assert tuple(picture[0, 0]) == tuple(dusk_table()[0])
    assert tuple(picture[0, 2]) == tuple(dusk_table()[255])


def test_a_picture_without_any_sample_is_no_error() -> None:
    assert (disparity_picture(np.full((2, 3), np.nan, np.float32)) == GREY).all()


def test_a_gain_of_zero_is_refused() -> None:
    picture = np.zeros((2, 2, 3), np.uint8)
    with pytest.raises(InputError, match=r"signed_difference.gain is 0, expected a finite number"):
        signed_difference(picture, picture, gain=0)
