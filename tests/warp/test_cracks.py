"""What references see together: cracks and exposures as narrow."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.warp import warp
from tests.warp.worlds import straight_camera, view_of

WALL, POST = 0.25, 0.5
HEIGHT, WIDTH = 12, 40


def found_cracks(row: list[float], reference_row: list[float]) -> tuple[Any, Any, Any]:
    """Flat indices, disparities and witnesses of the cracks of one layer, all rows alike.

    The reference has the desired camera, so that its samples are the pixels.
    """
    from belvedere.warp import _cracks

    layer = np.tile(np.array(row, np.float32), (3, 1))[None]
    samples = np.tile(np.array(reference_row, np.float32), (3, 1))
    size = layer[0].size
    front = np.empty(layer.shape[1:], np.float32)
    index, value = np.empty(size, np.int32), np.empty(size, np.float32)
    seen = np.full(size, 7, np.uint8)
    count = _cracks.find_cracks(layer, np.full_like(layer, -1), 0.03, front, index, value, seen)
    np.testing.assert_array_equal(front, layer[0])
    same = np.eye(3, 4).astype(np.float32).ravel()
    _cracks.witness_cracks(same, samples, index, value, count, len(row), 0, 0.03, seen)
    return index[:count], value[:count], seen[:count]


def test_a_hole_between_two_samples_of_a_surface_is_a_crack_if_a_reference_sees_it() -> None:
    index, value, seen = found_cracks([WALL, WALL, -1, WALL], [WALL] * 4)
    assert index.tolist() == [6]
    assert value.tolist() == [WALL]
    assert seen.tolist() == [1]


@pytest.mark.parametrize("sample", [POST, 0.8 * WALL])
def test_a_hole_where_the_reference_sees_something_else_is_an_exposure(sample: float) -> None:
    index, _, seen = found_cracks([WALL, WALL, -1, WALL], [WALL, WALL, sample, WALL])
    assert index.tolist() == [6]
    assert seen.tolist() == [0]


def test_where_the_sample_is_missing_those_beside_it_are_asked() -> None:
    for beside, wanted in ((WALL, 1), (POST, 0)):
        _, _, seen = found_cracks([WALL, WALL, -1, WALL], [WALL, beside, np.nan, beside])
        assert seen.tolist() == [wanted]


def test_between_two_surfaces_the_farther_is_asked_for() -> None:
    _, value, seen = found_cracks([POST, POST, -1, WALL], [POST, POST, WALL, WALL])
    assert value.tolist() == [WALL]
    assert seen.tolist() == [1]


def test_holes_two_pixels_wide_are_no_cracks() -> None:
    index, _, _ = found_cracks([WALL, -1, -1, WALL], [WALL] * 4)
    assert index.size == 0


def test_what_a_post_hides_from_the_only_reference_stays_open_however_narrow() -> None:
    """The eye moves until one column of wall beside the post comes out that nobody has seen."""
    camera = straight_camera(WIDTH, HEIGHT, (0, 0, 0), WIDTH)
    disparity = np.full((HEIGHT, WIDTH), WALL)
    disparity[:, 18:22] = POST
    view = view_of(camera, disparity)
    step = 1.0 / WIDTH / (POST - WALL)  # metres for one pixel of parallax
    frame = warp(view, camera.moved((step, 0, 0)))
    open_columns = np.flatnonzero((frame.coverage[3:-3, 3:-6] == 0).all(axis=0)) + 3
    assert open_columns.size == 1
