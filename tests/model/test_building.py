"""What a building states: kept through JSON, refused where it makes no sense."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from belvedere.ground.errors import SceneError
from belvedere.model import Building, Opening, Room
from tests.strategies import numbers

SQUARE = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]
DOOR = [[4.0, 1.0, 0.0], [4.0, 2.0, 0.0], [4.0, 2.0, 2.0], [4.0, 1.0, 2.0]]


def stated() -> dict[str, Any]:
    return {
        "rooms": [
            {"name": "hall", "rings": [SQUARE], "floor": 0.0, "ceiling": 2.5, "storey": "ground"},
            {"name": "bath", "rings": [SQUARE, SQUARE[:3]], "floor": 0.1, "ceiling": 2.4},
        ],
        "openings": [
            {"name": "D1", "kind": "door", "corners": DOOR, "rooms": ["hall", "bath"]},
            {"name": "W1", "kind": "window", "corners": DOOR, "rooms": ["hall", None]},
            {"name": "O1", "kind": "opening", "corners": DOOR},
        ],
    }


def test_a_building_is_read_as_it_was_written_by_hand() -> None:
    building = Building.from_dict(stated())
    assert [room.name for room in building.rooms] == ["hall", "bath"]
    assert (building.rooms[0].storey, building.rooms[1].storey) == ("ground", "")
    assert [len(room.rings) for room in building.rooms] == [1, 2]
    assert [o.rooms for o in building.openings] == [("hall", "bath"), ("hall", None), (None, None)]
    np.testing.assert_array_equal(building.openings[0].corners, DOOR)


def test_a_building_without_openings_need_not_say_so() -> None:
    assert Building.from_dict({"rooms": stated()["rooms"]}).openings == ()


@st.composite
def buildings(draw: st.DrawFn) -> Building:
    names = draw(st.lists(st.text(min_size=1), min_size=1, max_size=4, unique=True))
    number = numbers(-1e6, 1e6)
    point2, point3 = st.tuples(number, number), st.tuples(number, number, number)
    rooms = []
    for name in names:
        rings = draw(st.lists(st.lists(point2, min_size=3, max_size=6), min_size=1, max_size=3))
        floor = draw(number)
        rooms.append(
            Room(name, tuple(np.array(r) for r in rings), floor, floor + 2.5, draw(st.text()))
        )
    side = st.one_of(st.none(), st.sampled_from(names))
    openings = [
        Opening(
            draw(st.text()),
            draw(st.sampled_from(["door", "window", "opening"])),
            np.array(draw(st.lists(point3, min_size=4, max_size=4))),
            (draw(side), draw(side)),
        )
        for _ in range(draw(st.integers(0, 3)))
    ]
    return Building(tuple(rooms), tuple(openings))


@given(buildings())
def test_json_keeps_a_building_to_the_last_bit(building: Building) -> None:
    text = json.dumps(building.as_dict())
    again = Building.from_dict(json.loads(text))
    assert json.dumps(again.as_dict()) == text
    for a, b in zip(building.rooms, again.rooms, strict=True):
        assert (a.name, a.floor, a.ceiling, a.storey) == (b.name, b.floor, b.ceiling, b.storey)
        for p, q in zip(a.rings, b.rings, strict=True):
            np.testing.assert_array_equal(p, q)


def change(*path: Any, to: Any) -> Callable[[dict[str, Any]], None]:
    def apply(data: dict[str, Any]) -> None:
        place: Any = data
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = to

    return apply


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (change("rooms", to=None), r"side\.rooms is missing or no list"),
        (change("rooms", 1, to="bath"), r"side\.rooms\[1\] is 'bath', expected an object"),
        (change("rooms", 0, "name", to=3), r"side\.rooms\[0\]\.name is 3, expected text"),
        (change("rooms", 0, "rings", to=None), r"side\.rooms\[0\]\.rings is missing or no list"),
        (change("rooms", 0, "rings", to=[]), r"Room 'hall' has no outline: give one ring"),
        (change("rooms", 0, "rings", to=[SQUARE[:2]]), r"Room 'hall': ring has shape \(2, 2\)"),
        (change("rooms", 0, "rings", to=[["a"]]), r"Room 'hall': ring is not a list of points"),
        (change("rooms", 0, "rings", 0, 0, 0, to=float("nan")), r"holds numbers that are not fin"),
        (change("rooms", 0, "floor", to=True), r"rooms\[0\]\.floor is True, expected a number"),
        (change("rooms", 0, "floor", to=2.5), r"the ceiling at 2\.5 m must be above the floor"),
        (change("rooms", 0, "ceiling", to=float("inf")), r"Room 'hall': the ceiling at inf m"),
        (change("rooms", 1, "name", to="hall"), r"several rooms are called 'hall'"),
        (change("openings", to={}), r"side\.openings is missing or no list"),
        (change("openings", 0, "kind", to="hatch"), r"'D1' is a 'hatch', expected one of door, w"),
        (change("openings", 0, "corners", to=[*DOOR, DOOR[0]]), r"'D1' has 5 corners, expected 4"),
        (change("openings", 0, "corners", to=SQUARE), r"'D1': corners has shape \(4, 2\)"),
        (change("openings", 0, "rooms", to=["hall"]), r"openings\[0\]\.rooms is \['hall'\], expec"),
        (change("openings", 0, "rooms", to=["hall", "loft"]), r"'D1' leads to 'loft', which is no"),
    ],
)
def test_a_building_says_what_is_wrong_with_it(
    spoil: Callable[[dict[str, Any]], None], message: str
) -> None:
    data = copy.deepcopy(stated())
    spoil(data)
    with pytest.raises(SceneError, match=message):
        Building.from_dict(data, "side")


def test_what_is_no_object_is_no_building() -> None:
    with pytest.raises(SceneError, match=r"building\.rooms is missing or no list"):
        Building.from_dict([1, 2])
