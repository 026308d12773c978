"""What references see together: cracks and exposures as narrow."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.ground.color import SRGB8_TO_LINEAR
from belvedere.scene import Camera
from belvedere.warp import warp
from tests.oracles.railing import Railing
from tests.warp.worlds import plane_disparity, straight_camera, view_of

WALL, POST = 0.25, 0.5
HEIGHT, WIDTH = 12, 40


def found_cracks(row: list[float], reference_row: list[float]) -> tuple[Any, Any, Any]:
    """Flat indices, disparities and witnesses of the cracks of one layer, all rows alike.

    The reference has the desired camera, so that its samples are the pixels.
    """
    from belvedere.warp import _layers

    layer = np.tile(np.array(row, np.float32), (3, 1))[None]
    samples = np.tile(np.array(reference_row, np.float32), (3, 1))
    size = layer[0].size
    front = np.empty(layer.shape[1:], np.float32)
    index, value = np.empty(size, np.int32), np.empty(size, np.float32)
    seen = np.full(size, 7, np.uint8)
    count = _layers.find_cracks(layer, np.full_like(layer, -1), 0.03, front, index, value, seen)
    np.testing.assert_array_equal(front, layer[0])
    same = np.eye(3, 4).astype(np.float32).ravel()
    _layers.witness_cracks(same, samples, index, value, count, len(row), 0, 0.03, seen)
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


def railing_and_board(bridging: Camera, period_px: float = 4.0) -> tuple[float, float, float]:
    """How a railing comes out that two references see: gaps and bars, 0 to 1, and its edges' error.

    Shares of the gaps and of the bars that come out right, and by how much pixels that both share
    show too much of the bar.

    The nearer sees bars and gaps, each two samples wide; the other, from ``bridging``, the same
    plane as one unbroken board, as one does who looks along bars that have some thickness.
    """
    camera = straight_camera(160, 60)
    railing = Railing(period_px / 160, 2 * period_px / 160, 0.0)
    plane = np.maximum(plane_disparity(bridging, (0, 1, 0), railing.near), 0)
    board = view_of(bridging, plane, np.full((*bridging.size, 3), 231, np.uint8))
    desired = camera.moved((0.003, 0.02, 0.0))
    frame = warp([railing.photograph(camera), board], desired)
    inside = np.s_[10:-10, 40:-40]
    u, v = np.broadcast_arrays(*desired.pixel_grid())
    bar = railing.on_bar(desired, u, v)[inside]
    nearness = frame.disparity[inside] * (railing.near - desired.center[1])
    share = railing.share(desired)[inside]
    shown = (SRGB8_TO_LINEAR[frame.color[inside][..., 0]] - 0.1) / 0.7
    excess = (shown - share)[(share > 0.1) & (share < 0.9)].mean()
    return float((nearness[~bar] < 0.5).mean()), float((nearness[bar] > 0.9).mean()), float(excess)


def test_who_looks_along_bars_does_not_board_up_the_gaps_that_another_sees() -> None:
    """Measured: 0.88 of the gaps, 0.49 of them if both are believed alike."""
    slanting = Camera.look_at((-3.0, 0.5, 0.0), (0, 2, 0), fov_deg=60, width=160, height=120)
    gaps, bars, excess = railing_and_board(slanting)
    assert gaps > 0.85
    assert bars > 0.99
    assert abs(excess) < 0.05


def test_a_reference_as_dense_is_believed_where_another_has_but_an_edge() -> None:
    gaps, bars, excess = railing_and_board(straight_camera(160, 60, (0.1, 0, 0)))
    assert gaps < 0.6
    assert bars > 0.99
    assert excess > 0.3
