"""Cells shown by pictures taken inside them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from belvedere.ground.errors import InputError
from belvedere.model import photograph
from belvedere.scene import Camera, ViewSet
from belvedere.studio.metrics import psnr
from belvedere.walkthrough import (
    CellImageOptions,
    CellImages,
    FreeSpace,
    SwitchOptions,
    Walker,
    WalkOptions,
    contents_of,
)
from belvedere.walkthrough.cell_images import (
    NEAR_M,
    SIDES,
    box_cameras,
    photograph_place,
    places_in,
)
from tests.oracles.drawing import RayDrawer

OPTIONS = CellImageOptions(polygons=0, texels=192)
PLACES = {0: [(1.4, 1.5, 1.6), (3.6, 2.6, 1.6)], 1: [(6.6, 2.2, 1.6)], 2: [(2.0, 6.0, 1.6)]}


@pytest.fixture(scope="module")
def inside(house) -> dict[int, CellImages]:
    return {
        cell: CellImages(
            ViewSet.of([v for eye in eyes for v in photograph_place(house, np.array(eye), OPTIONS)])
        )
        for cell, eyes in PLACES.items()
    }


@pytest.fixture(scope="module")
def drawer(house, graph) -> RayDrawer:
    return RayDrawer(house, contents_of(house.mesh, graph))


def looking(eye, target, **size: Any) -> Camera:
    return Camera.look_at(eye, target, fov_deg=60, **({"width": 240, "height": 192} | size))


# ---- the box -------------------------------------------------------------------------------------


def test_a_box_sees_every_direction() -> None:
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(20_000, 3))
    cameras = box_cameras(np.array([1.0, 2.0, 3.0]), 64)
    assert len(cameras) == SIDES
    seen = [(camera.edge_planes @ directions.T > 0.0).all(axis=0) for camera in cameras]
    assert np.any(seen, axis=0).all()
    assert np.mean(np.sum(seen, axis=0) > 1) < 0.12  # they overlap by a texel or two


def test_neighbours_share_at_least_a_texel() -> None:
    """Samples, not only their squares, reach past the common edge: no seam is left open."""
    ahead, left, *_ = box_cameras(np.zeros(3), 64)
    corner = ahead.rays(np.array([0.0]), np.array([(ahead.height - 1) / 2]))[0]
    u = left.project(corner[None])[0][0]
    assert 1.0 <= left.width - 1 - u <= 4.0


# ---- places --------------------------------------------------------------------------------------


def test_every_standing_eye_sees_a_place_nearby(house) -> None:
    standing = FreeSpace.of_mesh(house.mesh).eyes(0.3)
    places = places_in(house.caster, standing, 1.5)
    assert 3 <= len(places) < len(standing) / 5
    for eye in standing:
        away = np.linalg.norm(places - eye, axis=1)
        if away.min() == 0.0:
            continue
        near = places[away <= 1.5]
        hidden = house.caster.blocked(np.broadcast_to(eye, near.shape), near - eye, 1.0)
        assert len(near)
        assert not hidden.all()


def test_one_eye_is_one_place(house) -> None:
    eye = np.array([[2.0, 2.0, 1.6]])
    np.testing.assert_array_equal(places_in(house.caster, eye, 1.0), eye)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_no_picture_is_left_out_that_shows_something(inside, seed: int) -> None:
    """Whatever lies before the camera beyond `NEAR_M` is in one of the pictures named."""
    rng = np.random.default_rng(seed)
    images = inside[0]
    eye = np.array([rng.uniform(0.5, 4.5), rng.uniform(0.5, 4.0), rng.uniform(0.6, 2.2)])
    camera = Camera.look_at(
        eye, eye + rng.normal(size=3), width=64, height=48, fov_deg=rng.uniform(20, 110)
    )
    rays = camera.rays(rng.uniform(-0.5, 63.5, 400), rng.uniform(-0.5, 47.5, 400))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    points = eye + rays * (NEAR_M * 1.01 * rng.uniform(1.0, 200.0, 400)[:, None])
    for place in range(2):
        shown = np.zeros(len(points), dtype=bool)
        for index in images.in_sight(place, camera):
            planes = images.views.entries[index].camera.edge_planes
            shown |= (planes @ (points - images.places[place]).T > 0.0).all(axis=0)
        assert shown.all()


def test_pictures_of_what_lies_behind_are_left_out(inside) -> None:
    at = inside[0].places[0]
    ahead = Camera.look_at(at, at + np.array([1.0, 0.5, 0.0]), width=640, height=480, fov_deg=70)
    assert {0, 1} <= set(inside[0].in_sight(0, ahead)) <= {0, 1, 4, 5}


# ---- frames --------------------------------------------------------------------------------------


def walker(graph, drawer, images, inside, **choices: Any) -> Walker:
    merged: Any = {"fill": "none", "switch": SwitchOptions(fade=0)} | choices
    return Walker(graph, drawer, images, WalkOptions(**merged), cell_images=inside)


def test_a_cell_of_pictures_looks_like_its_polygons(graph, drawer, images, inside, house) -> None:
    camera = looking((1.8, 1.9, 1.6), (4.0, 0.6, 1.2))
    frame = (one := walker(graph, drawer, images, inside)).frame(camera)
    truth = photograph(house, camera, 2)
    assert one.statistics.pictured_cells == 1
    assert one.statistics.references >= 2
    known = frame.coverage > 0
    assert known.mean() > 0.97
    assert psnr(frame.color, truth.color, known) > 25.0  # 192 texels to the right angle
    drawn = walker(graph, drawer, images, inside, cells="polygons")
    drawn.frame(camera)
    assert drawn.statistics.pictured_cells == 0
    assert drawn.statistics.cells >= 1


def test_what_stands_beyond_an_open_portal_comes_from_the_other_cells_pictures(
    graph, drawer, images, inside, house
) -> None:
    camera = looking((4.6, 2.2, 1.6), (6.5, 1.9, 1.3))  # near the wide opening: no portal images
    one = walker(graph, drawer, images, inside)
    frame = one.frame(camera)
    assert (one.statistics.portals, one.statistics.pictured_cells) == (0, 2)
    truth = photograph(house, camera, 2)
    known = frame.coverage > 0
    assert known.mean() > 0.95
    assert psnr(frame.color, truth.color, known) > 24.0


def test_a_light_cell_beyond_a_heavy_one_is_drawn(graph, drawer, images, inside, house) -> None:
    camera = looking((4.6, 2.2, 1.6), (6.5, 1.9, 1.3))
    only = {0: inside[0]}
    one = walker(graph, drawer, images, only)
    frame = one.frame(camera)
    assert (one.statistics.cells, one.statistics.pictured_cells) == (1, 1)
    truth = photograph(house, camera, 1)
    beyond = frame.color == truth.color  # polygons, ray for ray
    assert beyond.all(axis=2).mean() > 0.15


def test_geometry_modes_know_no_pictures(graph, drawer, images, inside) -> None:
    camera = looking((1.8, 1.9, 1.6), (4.0, 0.6, 1.2))
    for mode in ("full", "culling", "textures"):
        one = walker(graph, drawer, images, inside, mode=mode)
        one.frame(camera)
        assert one.statistics.pictured_cells == 0


def test_frames_do_not_depend_on_threads(graph, drawer, images, inside) -> None:
    camera = looking((4.6, 2.2, 1.6), (6.5, 1.9, 1.3), width=640, height=512)
    frames = [
        Walker(graph, drawer, images, threads=n, cell_images=inside).frame(camera) for n in (1, 3)
    ]
    np.testing.assert_array_equal(frames[0].color, frames[1].color)
    np.testing.assert_array_equal(frames[0].disparity, frames[1].disparity)


# ---- bad input -----------------------------------------------------------------------------------


def test_pictures_come_in_sixes(inside) -> None:
    with pytest.raises(InputError, match="5 pictures, expected 6"):
        CellImages(inside[1].views[:5])


@pytest.mark.parametrize(("name", "value"), [("polygons", -1), ("spacing", 0.0), ("texels", 4)])
def test_options_are_checked(name: str, value: float) -> None:
    with pytest.raises(InputError, match=name):
        CellImageOptions(**{name: value})  # type: ignore[arg-type]
