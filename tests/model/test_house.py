"""The built-in houses: counts that are promised, ways that are free, light that is repeatable."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

from belvedere.ground.errors import InputError
from belvedere.model import House, RayCaster, UnlitHouse, build_house, build_unlit_house, photograph
from belvedere.model.building import Building
from belvedere.model.house import HOUSES
from belvedere.model.house_walk import recorded_walk

RAYS = 4
PROMISED = {"flat": (2, 4, 80_000), "bungalow": (19, 52, 528_000), "villa": (7, 12, 214_000)}


@pytest.fixture(scope="module")
def flat() -> House:
    return build_house("flat", rays=RAYS)


def digest(house: House) -> str:
    total = hashlib.sha256()
    for array in (house.mesh.vertices, house.mesh.uv, house.light.soft, house.light.sun):
        total.update(np.ascontiguousarray(array).tobytes())
    return total.hexdigest()


def reachable(building: Building) -> set[str]:
    """Rooms that can be walked to from the first."""
    found, edge = {building.rooms[0].name}, [building.rooms[0].name]
    while edge:
        here = edge.pop()
        for opening in building.openings:
            if opening.kind != "window" and here in opening.rooms:
                for name in opening.rooms:
                    if name is not None and name not in found:
                        found.add(name)
                        edge.append(name)
    return found


def sphere(count: int) -> np.ndarray:
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, 2.399963 * k
    ring = np.sqrt(1.0 - z * z)
    return np.stack([ring * np.cos(angle), ring * np.sin(angle), z], axis=1)


def check_plan(name: str, building: Building, polygons: int) -> None:
    rooms, openings, wanted = PROMISED[name]
    assert len(building.rooms) == rooms
    assert len(building.openings) == openings
    assert abs(polygons - wanted) <= 0.01 * wanted
    assert reachable(building) == {room.name for room in building.rooms}
    for opening in building.openings:
        assert opening.rooms[0] != opening.rooms[1]
        assert opening.kind == "window" or None not in opening.rooms
    assert min(room.floor for room in building.rooms) == 0.0


def check_openings(unlit: UnlitHouse, caster: RayCaster) -> None:
    """Every opening is a hole: a short ray through its middle meets nothing."""
    for opening in unlit.plan.building().openings:
        a, b, _, d = opening.corners
        across = np.cross(b - a, d - a)
        across /= np.linalg.norm(across)
        middle = opening.corners.mean(axis=0) + np.array([0.003, 0.003, 0.0])
        if opening.kind == "window":  # beside the glazing bars, which cross in the middle
            middle = middle + 0.07 * (b - a) / np.linalg.norm(b - a) + [0.0, 0.0, 0.07]
        start, along = middle - 0.2 * across, 0.4 * across
        assert not caster.blocked([start], [along], 1.0)[0], opening.name


def check_walk(unlit: UnlitHouse, name: str, caster: RayCaster) -> None:
    path = recorded_walk(unlit.plan, HOUSES[name].tour, caster)
    cameras = path.cameras(400)
    eyes = np.array([c.camera_to_world[:3, 3] for c in cameras])
    step = np.diff(eyes, axis=0)
    assert not caster.blocked(eyes[:-1], np.where(step == 0.0, 1e-6, step), 1.0).any()
    ways = sphere(150)
    starts = np.repeat(eyes, len(ways), axis=0)
    near = caster.cast(starts, np.tile(ways, (len(eyes), 1))).t.reshape(len(eyes), -1).min(axis=1)
    assert near.min() > 0.2
    down = caster.cast(eyes, np.broadcast_to([0.0, 0.0, -1.0], eyes.shape)).t
    assert down.min() > 1.35  # a step more or less on the stair
    assert down.max() < 1.85
    assert np.median(np.abs(down - 1.6)) < 0.02
    looks = np.array([c.camera_to_world[:3, 2] for c in cameras])
    turn = np.degrees(np.arccos(np.clip((looks[1:] * looks[:-1]).sum(axis=1), -1.0, 1.0)))
    pace = np.linalg.norm(step, axis=1) * (len(eyes) - 1) / path.duration
    assert turn.max() < 20.0
    assert pace.max() < 2.0
    visited = {
        room.name
        for room in unlit.plan.building().rooms
        if (
            (eyes[:, :2] > room.rings[0].min(axis=0)).all(axis=1)
            & (eyes[:, :2] < room.rings[0].max(axis=0)).all(axis=1)
            & (eyes[:, 2] > room.floor)
            & (eyes[:, 2] < room.ceiling)
        ).any()
    }
    assert set(HOUSES[name].tour) <= visited
    assert len(visited) >= 0.7 * len(unlit.plan.rooms)


def test_the_flat_has_what_it_promises(flat: House) -> None:
    check_plan("flat", flat.building, len(flat.mesh.faces))
    unlit = build_unlit_house("flat")
    caster = RayCaster(unlit.cage)
    check_openings(unlit, caster)
    check_walk(unlit, "flat", caster)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bungalow", "villa"])
def test_the_large_houses_have_what_they_promise(name: str) -> None:
    unlit = build_unlit_house(name)
    check_plan(name, unlit.plan.building(), len(unlit.mesh.faces))
    caster = RayCaster(unlit.cage)
    check_openings(unlit, caster)
    check_walk(unlit, name, caster)
    assert np.array_equal(unlit.charts.corners, unlit.cage_charts.corners)


@pytest.mark.slow
def test_another_seed_furnishes_otherwise_and_leaves_the_ways_free() -> None:
    unlit = build_unlit_house("villa", 3)
    check_plan("villa", unlit.plan.building(), len(unlit.mesh.faces))
    check_walk(unlit, "villa", RayCaster(unlit.cage))
    first = build_unlit_house("villa", 0)
    assert unlit.cage.vertices.shape != first.cage.vertices.shape


def test_one_thread_builds_the_same_bytes_and_tells_how_far_it_is(flat: House) -> None:
    told: list[tuple[int, int]] = []
    again = build_house(
        "flat", rays=RAYS, threads=1, progress=lambda done, total, _: told.append((done, total))
    )
    assert digest(again) == digest(flat)
    assert told == sorted(told)
    assert told[-1] == (100, 100)
    assert len(told) > 20


def test_ten_times_the_polygons_look_alike(flat: House) -> None:
    fine = build_house("flat", rays=RAYS, detail=10)
    assert abs(len(fine.mesh.faces) - 800_000) <= 8_000
    assert np.array_equal(fine.light.soft, flat.light.soft)
    for camera in flat.path.resized(96, 80).cameras(3):
        a, b = (photograph(h, camera, 2).color.astype(float) for h in (flat, fine))
        assert 10.0 * np.log10(255.0**2 / np.mean((a - b) ** 2)) > 35.0


def test_rooms_are_lit(flat: House) -> None:
    for camera in flat.path.resized(64, 48).cameras(6):
        color = photograph(flat, camera, 1).color
        assert 60.0 < color.mean() < 220.0
        assert (color.max(axis=2) < 6).mean() < 0.05  # hardly anything is black


@pytest.mark.parametrize(
    "arguments",
    [
        {"name": "castle"}, {"name": 3}, {"seed": -1}, {"seed": 0.5}, {"detail": 0},
        {"detail": 21}, {"rays": 3}, {"rays": 5000},
    ],
)  # fmt: skip
def test_houses_that_cannot_be_built_are_refused(arguments: dict[str, object]) -> None:
    with pytest.raises(InputError, match="build_house"):
        build_house(**arguments)  # type: ignore[arg-type]
