"""The built-in houses: as many rooms, doors and polygons as they say, and people can walk there."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, cast

import numpy as np
import pytest
from scipy import ndimage

from belvedere.ground.errors import InputError
from belvedere.model import (
    HOUSES,
    Building,
    House,
    Opening,
    RayCaster,
    Room,
    build_house,
    photograph,
)
from belvedere.model.house import UnlitHouse, build_unlit_house
from belvedere.model.house_walk import recorded_walk
from belvedere.scene import Camera, CameraPath

F8 = np.ndarray
SLOW = pytest.mark.slow
EACH = ["flat", "villa", pytest.param("bungalow", marks=SLOW)]
COUNTS = {"flat": (2, 4, 80_000), "villa": (7, 12, 214_000), "bungalow": (19, 52, 528_000)}
"""Rooms, openings, polygons."""


@lru_cache(maxsize=4)
def unlit(name: str, seed: int = 0) -> UnlitHouse:
    return build_unlit_house(name, seed)


@lru_cache(maxsize=4)
def rays_in(name: str, seed: int = 0) -> RayCaster:
    return RayCaster(unlit(name, seed).mesh)


def walk_through(name: str) -> CameraPath:
    house = unlit(name)
    return recorded_walk(house.plan, HOUSES[name].tour, RayCaster(house.cage))


@pytest.fixture(scope="module")
def flat() -> House:
    return build_house("flat", rays=8)


def building_of(name: str) -> Building:
    return unlit(name).plan.building()


def room_of(building: Building, name: str | None) -> Room:
    return next(room for room in building.rooms if room.name == name)


def walkable(building: Building) -> list[Opening]:
    return [opening for opening in building.openings if opening.kind != "window"]


@pytest.mark.parametrize("name", EACH)
def test_rooms_openings_and_polygons_are_as_many_as_stated(name: str) -> None:
    rooms, openings, polygons = COUNTS[name]
    building = building_of(name)
    assert len(building.rooms) == rooms
    assert len(building.openings) == openings
    assert len(unlit(name).mesh.faces) == pytest.approx(polygons, rel=0.01)
    assert len({opening.name for opening in building.openings}) == openings
    windows = openings - len(walkable(building))
    assert 0.25 < windows / openings < 0.8


@pytest.mark.parametrize("name", EACH)
def test_one_can_walk_from_every_room_to_every_other(name: str) -> None:
    building = building_of(name)
    reached, found = {building.rooms[0].name}, True
    while found:
        ways = [set(opening.rooms) for opening in walkable(building)]
        more = {str(n) for way in ways if way & reached for n in way} - reached
        reached |= more
        found = bool(more)
    assert reached == {room.name for room in building.rooms}


@pytest.mark.parametrize("name", EACH)
def test_openings_are_holes_in_the_middle_of_walls_between_their_rooms(name: str) -> None:
    building, caster = building_of(name), rays_in(name)
    for opening in building.openings:
        c = opening.corners
        middle, normal = c.mean(axis=0), np.cross(c[1] - c[0], c[3] - c[0])
        normal = normal / np.linalg.norm(normal)
        for sign in (1.0, -1.0):
            beyond = middle + 0.4 * sign * normal
            inside = [
                room.name
                for room in building.rooms
                if (room.rings[0].min(axis=0) < beyond[:2]).all()
                and (beyond[:2] < room.rings[0].max(axis=0)).all()
                and room.floor <= beyond[2] <= room.ceiling
            ]
            assert inside in ([[n] for n in opening.rooms if n] + [[]] * (None in opening.rooms))
        if opening.kind == "window":
            continue
        u, v = np.meshgrid(np.linspace(0.04, 0.96, 9), np.linspace(0.02, 0.97, 9))
        across = c[0] + u.ravel()[:, None] * (c[1] - c[0]) + v.ravel()[:, None] * (c[3] - c[0])
        start = across - 0.08 * normal
        assert not caster.blocked(start, np.broadcast_to(0.16 * normal, start.shape), 1.0).any()
        # and the wall begins at its rim
        for side in (-0.06, 1.06):
            rim = c[0] + side * (c[1] - c[0]) + 0.5 * (c[3] - c[0])
            assert caster.blocked([rim - 0.3 * normal], [normal], 0.6).all()


@pytest.mark.parametrize("name", EACH)
def test_outlines_are_the_inner_faces_of_the_walls(name: str) -> None:
    building, caster = building_of(name), rays_in(name)
    for room in building.rooms:
        low, high = room.rings[0].min(axis=0), room.rings[0].max(axis=0)
        z = room.ceiling - 0.22  # above furniture and doors, below the cornice
        for axis in (0, 1):
            for end, sign in ((low, -1.0), (high, 1.0)):
                start = np.tile([*(low + high) / 2.0, z], (3, 1))
                start[:, 1 - axis] = (
                    low[1 - axis] + np.array([0.2, 0.5, 0.8]) * (high - low)[1 - axis]
                )
                start[:, axis] = end[axis] - sign * 0.03
                way = np.zeros((3, 3))
                way[:, axis] = sign
                t = caster.cast(start, way).t
                np.testing.assert_allclose(np.median(t), 0.03, atol=2e-3)
        up = caster.cast([[*(low + 0.3), room.ceiling - 0.05]], [[0.0, 0.0, 1.0]]).t
        np.testing.assert_allclose(up, 0.05, atol=2e-3)


def free_map(caster: RayCaster, building: Building, floor: float) -> tuple[F8, F8]:
    """Metres from each place of a 5 cm grid to what stands on a floor, and the grid's corner."""
    points = np.concatenate([room.rings[0] for room in building.rooms])
    low, high = points.min(axis=0) - 0.05, points.max(axis=0) + 0.05
    shape = np.ceil((high - low) / 0.05).astype(int)
    x, y = np.meshgrid(np.arange(shape[0]), np.arange(shape[1]), indexing="ij")
    start = np.stack([x.ravel() * 0.05 + low[0], y.ravel() * 0.05 + low[1]], axis=1)
    start = np.column_stack([start, np.full(len(start), floor + 1.85)])
    t = caster.cast(start, np.broadcast_to([0.0, 0.0, -1.0], start.shape)).t
    free = (np.abs(t - 1.85) < 0.07).reshape(shape)
    return np.asarray(ndimage.distance_transform_edt(np.pad(free, 1)))[1:-1, 1:-1] * 0.05, low


def doors_meet(name: str, seed: int) -> None:
    """A body 0.7 m wide gets from every door of a floor to every other."""
    house = unlit(name, seed)
    building = house.plan.building()
    for floor in {room.floor for room in building.rooms}:
        clear, low = free_map(rays_in(name, seed), building, floor)
        label = np.asarray(cast(Any, ndimage.label(clear >= 0.35))[0])
        seen = set()
        for opening in walkable(building):
            if abs(opening.corners[:, 2].min() - floor) > 0.1:
                continue
            i, j = ((opening.corners.mean(axis=0)[:2] - low) / 0.05).round().astype(int)
            near = label[i - 1 : i + 2, j - 1 : j + 2]
            assert near.max() > 0, opening.name
            seen.add(int(near.max()))
        assert len(seen) == 1, f"seed {seed}, floor {floor}: {seen}"


@pytest.mark.parametrize("name", EACH)
def test_ways_between_the_doors_are_free(name: str) -> None:
    doors_meet(name, 0)


@SLOW
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_other_seeds_furnish_otherwise_and_leave_the_ways_free(seed: int) -> None:
    house = unlit("villa", seed)
    assert len(house.mesh.faces) == pytest.approx(214_000, rel=0.01)
    assert house.cage.vertices.shape != unlit("villa").cage.vertices.shape
    doors_meet("villa", seed)


@pytest.mark.parametrize("name", EACH)
def test_the_recorded_walk_passes_through_no_wall_and_no_furniture(name: str) -> None:
    house, caster = unlit(name), rays_in(name)
    cameras = walk_through(name).cameras(520)
    eyes = np.array([camera.center for camera in cameras])
    building = house.plan.building()
    visited = {
        room.name
        for room in building.rooms
        for x, y, z in eyes
        if (room.rings[0].min(axis=0) < (x, y)).all()
        and ((x, y) < room.rings[0].max(axis=0)).all()
        and room.floor < z < room.ceiling
    }
    assert set(HOUSES[name].tour) <= visited
    assert len(visited) > 0.7 * len(building.rooms)
    floors = {room.floor for room in building.rooms}
    level = np.min([np.abs(eyes[:, 2] - 1.6 - floor) for floor in floors], axis=0)
    assert (level < 1e-6).mean() > 0.85  # the rest is on the stair
    k = np.arange(200) + 0.5
    z, angle = 1.0 - 2.0 * k / 200, 2.399963 * k
    ring = np.sqrt(1.0 - z * z)
    sphere = np.stack([ring * np.cos(angle), ring * np.sin(angle), z], axis=1)
    for height in (1.6, 1.0, 0.5):  # the head, the hips, the knees
        body = eyes + np.array([0.0, 0.0, height - 1.6])
        assert not caster.blocked(body[:-1], np.diff(body, axis=0), 1.0).any()
        some = np.repeat(body[::6], 200, axis=0)
        reach = caster.cast(some, np.tile(sphere, (len(body[::6]), 1))).t
        assert reach.min() > 0.24
    assert np.linalg.norm(np.diff(eyes, axis=0), axis=1).max() < 0.16
    look = np.array([camera.rays(319.5, 255.5) for camera in cameras]).reshape(-1, 3)
    look /= np.linalg.norm(look, axis=1, keepdims=True)
    assert np.degrees(np.arccos((look[1:] * look[:-1]).sum(axis=1).clip(-1, 1))).max() < 8.0


@pytest.mark.parametrize("name", EACH)
def test_the_shell_has_no_cracks(name: str) -> None:
    """Rays from inside any room leave the house through windows only."""
    house, caster = unlit(name), rays_in(name)
    rng = np.random.default_rng(5)
    for room in house.plan.building().rooms:
        low, high = room.rings[0].min(axis=0) + 0.02, room.rings[0].max(axis=0) - 0.02
        at = rng.uniform(low, high, (2_000, 2))
        start = np.column_stack([at, np.full(len(at), room.ceiling - 0.25)])
        for up in (1.0, -1.0):
            tilt = np.column_stack([rng.normal(0.0, 0.04, (len(at), 2)), np.full(len(at), up)])
            assert caster.blocked(start, tilt, 9.0).all()


@pytest.mark.parametrize("name", EACH)
def test_nobody_looks_at_the_back_of_a_surface(name: str) -> None:
    """Inverted faces would be lit from the wrong side."""
    house, caster = unlit(name), rays_in(name)
    normals = house.mesh.normals()
    wrong = total = 0
    for eye in (camera.center for camera in walk_through(name).cameras(25)):
        for side in range(4):
            ahead = np.array([np.cos(side * 1.57), np.sin(side * 1.57), -0.25])
            camera = Camera.look_at(eye, eye + ahead, fov_deg=90, width=48, height=48)
            rays = camera.rays(*camera.pixel_grid()).reshape(-1, 3)
            hits = caster.cast(np.broadcast_to(eye, rays.shape), rays)
            facing = np.einsum("ij,ij->i", normals[hits.face], rays)
            wrong += np.count_nonzero((hits.face >= 0) & (facing > 1e-6))
            total += len(rays)
    assert wrong <= 0.004 * total  # open shades, the inside of pots, grazing rims


def test_one_thread_builds_the_same_bytes_and_tells_how_far_it_is(flat: House) -> None:
    told: list[tuple[int, int]] = []
    again = build_house(
        "flat", rays=8, threads=1, progress=lambda done, total, _: told.append((done, total))
    )
    assert told == sorted(told)
    assert told[-1] == (100, 100)
    assert len(told) > 20
    for part in ("vertices", "faces", "uv"):
        np.testing.assert_array_equal(getattr(again.mesh, part), getattr(flat.mesh, part))
    np.testing.assert_array_equal(again.light.soft, flat.light.soft)
    np.testing.assert_array_equal(again.light.sun, flat.light.sun)
    np.testing.assert_array_equal(
        [c.center for c in again.path.cameras(9)], [c.center for c in flat.path.cameras(9)]
    )


def test_finer_houses_look_alike_and_have_the_same_light(flat: House) -> None:
    fine = build_house("flat", rays=8, detail=5)
    assert len(fine.mesh.faces) == pytest.approx(400_000, rel=0.01)
    np.testing.assert_array_equal(fine.light.soft, flat.light.soft)
    for camera in flat.path.cameras(4):
        small = camera.resized(160, 128)
        a, b = (photograph(house, small, samples=2).color.astype(float) for house in (flat, fine))
        assert 10.0 * np.log10(255.0**2 / ((a - b) ** 2).mean()) > 35.0


def test_light_reaches_every_corner_and_is_not_all_alike(flat: House) -> None:
    assert np.isfinite(flat.light.soft).all()
    assert (flat.light.soft >= 0.0).all()
    for room in flat.building.rooms:
        eye = [*room.rings[0].mean(axis=0), room.floor + 1.6]
        for side in range(4):
            ahead = np.array([np.cos(side * 1.57), np.sin(side * 1.57), -0.1])
            camera = Camera.look_at(eye, eye + ahead, fov_deg=80, width=64, height=48)
            view = photograph(flat, camera, samples=1, dtype="float32")
            seen = view.color[view.disparity > 0]
            assert 0.04 < np.median(seen) < 0.75
            assert np.quantile(seen.mean(axis=1), 0.02) > 0.003  # nothing is black
            assert seen.std() > 0.03


def test_light_is_continuous_over_a_turned_body(flat: House) -> None:
    """Charts that meet at a point agree on its light."""
    charts, lattice, light = flat.charts, flat.light.soft_lattice, flat.light.soft
    assert charts.joined is not None
    pieces = np.flatnonzero(charts.joined & (lattice.shape == 2).all(axis=1))
    corner = charts.corners[pieces][:, [0, 1, 3, 2]].reshape(-1, 3)  # as the lattice runs
    normal = charts.normals[pieces][:, [0, 1, 3, 2]].reshape(-1, 3)
    at = (lattice.first[pieces][:, None] + np.arange(4)).ravel()
    key = np.round(np.concatenate([corner * 1e4, normal * 100.0], axis=1)).astype(np.int64)
    _, place = np.unique(key, axis=0, return_inverse=True)
    place = place.ravel()
    low, high = np.full(place.max() + 1, np.inf), np.full(place.max() + 1, -np.inf)
    np.minimum.at(low, place, light[at, 1])
    np.maximum.at(high, place, light[at, 1])
    assert np.quantile(high - low, 0.97) < 1e-4  # but for numbers that round otherwise


@pytest.mark.parametrize(
    ("what", "value", "text"),
    [
        ("name", "palace", r"build_house\.name is 'palace', expected one of"),
        ("seed", -1, r"build_house\.seed is -1, expected a whole"),
        ("detail", 0, r"build_house\.detail is 0, expected a whole"),
        ("seed", 0.5, r"build_house\.seed is 0\.5, expected a whole"),
        ("detail", 21, r"build_house\.detail is 21, expected a whole"),
        ("rays", 5000, r"build_house\.rays is 5000, expected a whole"),
        ("rays", 1, r"build_house\.rays is 1, expected a whole"),
    ],
)
def test_odd_orders_are_refused(what: str, value: object, text: str) -> None:
    with pytest.raises(InputError, match=text):
        build_house(**{what: value})  # type: ignore[arg-type]
