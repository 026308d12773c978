"""A warper gives what `warp` gives, and keeps what it can."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import belvedere as bv
from belvedere.ground.errors import BelvedereError
from belvedere.warp import RECONSTRUCTIONS, prepare
from tests.warp.worlds import boards, noise, straight_camera

BAD: list[Any] = [["x"], None]


def two_views() -> list[bv.ReferenceView]:
    rng = np.random.default_rng(5)
    views = []
    for x in (0.0, 0.4):
        camera = straight_camera(40, 30).moved((x, 0, 0))
        views.append(bv.ReferenceView(camera, noise(rng, 30, 40), boards(rng, 30, 40)[0]))
    return views


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_a_warper_gives_the_picture_that_warp_gives(reconstruction: Any) -> None:
    views = two_views()
    warper = bv.Warper(33, 27, reconstruction=reconstruction, threads=2)
    for x in (0.1, 0.2, 0.3):
        camera = straight_camera(33, 27).moved((x, 0.05, 0))
        for given in (views, views[0], [prepare(views[1])]):
            wanted = bv.warp(given, camera, reconstruction=reconstruction)
            frame = warper.warp(given, camera)
            np.testing.assert_array_equal(frame.color, wanted.color)
            np.testing.assert_array_equal(frame.disparity, wanted.disparity)
            np.testing.assert_array_equal(frame.coverage, wanted.coverage)


def test_a_warpers_frame_lasts_until_the_next_and_its_memory_is_used_again() -> None:
    views = two_views()
    warper = bv.Warper(33, 27)
    first = warper.warp(views, straight_camera(33, 27).moved((0.1, 0, 0)))
    kept = first.color.copy()
    second = warper.warp(views, straight_camera(33, 27).moved((0.3, 0, 0)))
    assert np.shares_memory(first.color, second.color)
    assert (kept != first.color).any()


def test_a_warper_prepares_a_view_once_and_forgets_the_one_unused_for_longest() -> None:
    views = two_views()
    warper = bv.Warper(33, 27, kept=1)
    camera = straight_camera(33, 27).moved((0.1, 0, 0))
    warper.warp(views[0], camera)
    remembered = dict(warper._views)
    warper.warp(views[0], camera)
    assert dict(warper._views) == remembered
    warper.warp(views[1], camera)
    assert list(warper._views) == [id(views[1])]


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: bv.Warper(0, 5), "Warper.width is 0, expected a whole number from 1 to 65536"),
        (lambda: bv.Warper(5, 5, kept=0), "Warper.kept is 0, expected"),
        (lambda: bv.Warper(5, 5, threads=0), "threads is 0, expected"),
        (lambda: bv.Warper(5, 5, quality=1), "Warper has no option 'quality'"),
        (
            lambda: bv.Warper(5, 5).warp(two_views(), straight_camera(40, 30)),
            "Warper.warp.camera is 40 x 30, expected 5 x 5: make one warper for each size",
        ),
        (lambda: bv.Warper(5, 5).warp([], straight_camera(5, 5)), "warp.views is empty"),
        (lambda: bv.Warper(5, 5).warp(BAD[0], straight_camera(5, 5)), "warp.views[0] is a str"),
        (lambda: bv.Warper(5, 5).warp(BAD[1], straight_camera(5, 5)), "warp.views is a NoneType"),
    ],
)
def test_a_bad_call_of_a_warper_is_refused(make: Any, text: str) -> None:
    with pytest.raises(BelvedereError) as refusal:
        make()
    assert text in str(refusal.value)
