"""Frames of a walk: polygons of the view cell, pictures behind its portals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.ground.errors import CameraError, InputError
from belvedere.model import photograph
from belvedere.scene import Camera, SphereCamera
from belvedere.studio.metrics import psnr
from belvedere.walkthrough import CellGraph, SwitchOptions, Walker, WalkOptions, contents_of
from tests.oracles.drawing import RayDrawer

SIZE = {"width": 160, "height": 128}
AT_ONCE = SwitchOptions(fade=0)


def looking(eye, target) -> Camera:
    return Camera.look_at(eye, target, fov_deg=60, **SIZE)


THROUGH = looking((2.0, 1.6, 1.6), (6.0, 2.4, 1.4))
"""From the living room through the wide opening."""


@pytest.fixture(scope="module")
def drawer(house, graph):
    return RayDrawer(house, contents_of(house.mesh, graph))


@pytest.fixture
def walk(graph, drawer, images):
    def make(**choices: Any) -> Walker:
        merged: Any = {"fill": "none"} | choices
        return Walker(graph, drawer, images, WalkOptions(**merged))

    return make


@pytest.fixture(scope="module")
def truth(house):
    return photograph(house, THROUGH, 1)


def test_culling_draws_what_everything_would(walk, truth) -> None:
    for camera in (THROUGH, looking((7.0, 3.6, 1.6), (6.8, 7.0, 1.5))):
        full, culled = walk(mode="full"), walk(mode="culling")
        a, b = full.frame(camera), culled.frame(camera)
        differing = (a.color != b.color).any(axis=2).mean()
        assert differing < 2e-4  # windows far beyond that no portal of this plan stands for
        assert culled.statistics.cells == 2 < full.statistics.cells
    np.testing.assert_array_equal(walk(mode="full").frame(THROUGH).color, truth.color)


def test_pictures_behind_a_portal_look_like_the_room_behind_it(walk, truth) -> None:
    quality = {}
    for mode in ("textures", "one", "two"):
        walker = walk(mode=mode)
        frame = walker.frame(THROUGH)
        known = frame.coverage > 0
        quality[mode] = psnr(frame.color, truth.color, known)
        assert walker.statistics.portals == 1
        assert walker.statistics.references == (2 if mode == "two" else 1)
        assert walker.statistics.cells == 1
        assert walker.statistics.holes == pytest.approx(1 - known.mean(), abs=1e-6)
    assert quality["two"] > 30.0
    assert quality["one"] > quality["textures"] + 5.0


def test_two_references_leave_fewer_holes_than_one(walk) -> None:
    holes = {"one": 0.0, "two": 0.0}
    for mode in holes:
        walker = walk(mode=mode, switch=AT_ONCE)
        for x in np.linspace(1.2, 3.6, 9):
            walker.frame(looking((x, 1.2 + 0.3 * x, 1.6), (6.0, 2.3, 1.4)))
            holes[mode] += walker.statistics.holes
    assert 0.0 < holes["two"] < holes["one"]


def test_from_a_references_own_eye_a_flat_picture_is_as_good(walk, images, house) -> None:
    eye = images[0, 0].references[1].camera.center
    camera = looking(eye, (5.27, 2.2, 1.2))
    truth = photograph(house, camera, 1)
    switch = SwitchOptions(angle_deg=179.0, widths=0.1, fade=0)
    quality = {}
    for mode in ("textures", "two"):
        frame = walk(mode=mode, switch=switch).frame(camera)
        quality[mode] = psnr(frame.color, truth.color, frame.coverage > 0)
        assert frame.hole_fraction < 0.01
    assert quality["two"] > 26.0  # one ray a pixel here, nine a texel there
    assert quality["textures"] > quality["two"] - 0.5


def test_near_a_portal_geometry_is_drawn(walk, house) -> None:
    camera = looking((4.6, 2.2, 1.6), (6.0, 1.9, 1.4))
    walker = walk(mode="two")
    frame = walker.frame(camera)
    assert (walker.statistics.portals, walker.statistics.cells) == (0, 2)
    truth = photograph(house, camera, 1)
    assert (frame.color != truth.color).any(axis=2).mean() < 1e-3


def test_the_change_to_geometry_fades(walk) -> None:
    """Frame by frame on one spot, the picture moves from one way of drawing to the other."""
    walker = walk(mode="two", switch=SwitchOptions(fade=3))
    far, near = looking((2.0, 2.2, 1.6), (6, 2.2, 1.5)), looking((4.2, 2.2, 1.6), (6, 2.2, 1.5))
    walker.frame(far)
    frames = [walker.frame(near).color.astype(float) for _ in range(5)]
    last = frames[-1]
    apart = [np.abs(frame - last).mean() for frame in frames]
    assert apart[0] > apart[1] > apart[2] > apart[3] == apart[4] == 0.0
    walker.cut()
    np.testing.assert_array_equal(walker.frame(near).color, last)


def test_kept_pixels_fill_holes_but_stay_holes(walk, house) -> None:
    away = {}
    for persist in (False, True):
        walker = walk(mode="one", persist=persist, switch=AT_ONCE)
        error = count = 0.0
        for x in np.linspace(1.0, 3.2, 23):
            camera = looking((x, 1.9, 1.6), (6.0, 2.3, 1.4))
            frame = walker.frame(camera)
            holes = frame.coverage == 0
            assert np.isnan(frame.disparity[holes]).all()
            truth = photograph(house, camera, 1)
            error += np.abs(frame.color[holes].astype(float) - truth.color[holes]).sum()
            count += holes.sum()
        away[persist] = error / count
    assert away[True] < 0.95 * away[False]


def test_traced_holes_are_exact(walk, truth) -> None:
    walker = walk(mode="one", fill="trace", switch=AT_ONCE)
    frame = walker.frame(THROUGH)
    assert frame.hole_fraction == 0.0
    assert 0.0 < walker.statistics.holes == walker.holes.mean()
    np.testing.assert_array_equal(frame.color[walker.holes], truth.color[walker.holes])
    open_ = walk(mode="one", switch=AT_ONCE)
    holes = open_.frame(THROUGH).coverage == 0
    np.testing.assert_array_equal(holes, walker.holes)
    assert (truth.disparity[holes] > 0).all()  # the sky is no hole: it is behind everything


def test_filling_leaves_no_black(walk) -> None:
    frame = walk(mode="one", fill="background").frame(THROUGH)
    assert frame.filled is not None
    assert frame.filled.any()


def test_a_visitor_who_leaves_the_house_is_outside(walk) -> None:
    walker = walk(mode="culling")
    for eye, cell in (((2.6, 1.0, 1.6), 0), ((2.6, -0.3, 1.6), 0), ((2.6, -3.0, 1.6), -1)):
        walker.frame(looking(eye, (2.6, 4.0, 1.5)))
        assert walker.statistics.cell == cell


def test_frames_do_not_depend_on_threads(graph, drawer, images) -> None:
    frames = [
        Walker(graph, drawer, images, WalkOptions(), threads=n).frame(THROUGH) for n in (1, 2, 3)
    ]
    for other in frames[1:]:
        np.testing.assert_array_equal(frames[0].color, other.color)
        np.testing.assert_array_equal(frames[0].disparity, other.disparity)


def test_disparity_goes_on_behind_the_portal(walk, truth) -> None:
    frame = walk(mode="two").frame(THROUGH)
    known = (frame.coverage > 0.5) & (truth.disparity > 0)
    off = np.abs(frame.disparity[known] / truth.disparity[known] - 1.0)
    assert (off > 0.02).mean() < 0.02


def test_what_is_of_no_use_is_refused(walk) -> None:
    with pytest.raises(CameraError, match="planar"):
        walk().frame(SphereCamera.at((1, 1, 1.6), width=32, height=16))
    with pytest.raises(InputError, match="mode"):
        WalkOptions(mode="three")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="reconstruction"):
        WalkOptions(reconstruction="magic")


def test_a_room_without_portals_is_walked_all_the_same(house, graph) -> None:
    alone = CellGraph(graph.cells[:1], ())
    drawer = RayDrawer(house, contents_of(house.mesh, alone))
    walker = Walker(alone, drawer, {})
    camera = looking((2.0, 1.6, 1.6), (0.5, 3.0, 1.2))
    walker.warm()
    frame = walker.frame(camera)
    assert (walker.statistics.cells, walker.statistics.portals) == (1, 0)
    exact = photograph(house, camera, 1).color
    assert (frame.color == exact).all(axis=2).mean() > 0.9  # no portal shows what lies outside
