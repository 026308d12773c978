"""What a building says about itself: its rooms, and the openings between them.

IFC files carry this, glTF files may carry it in their extras, the built-in houses know it. It is
what a model *states*; `belvedere.walkthrough` makes cells and portals of it and checks them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import SceneError

F8 = npt.NDArray[np.float64]
OpeningKind = Literal["door", "window", "opening"]
"""A door and a plain opening can be walked through, a window only looked through."""

__all__ = ["Building", "Opening", "OpeningKind", "Room"]


@dataclass(frozen=True, slots=True, eq=False)
class Room:
    """A space that people call by a name: an upright prism."""

    name: str
    """Unique in its building."""
    rings: tuple[F8, ...]
    """(N, 2) outlines of the floor, metres; a point is inside when an odd number of them
    encloses it, so holes are further rings."""
    floor: float
    """Height of the floor, metres."""
    ceiling: float
    """Height of the ceiling, metres."""
    storey: str = ""
    """What the storey is called; empty where there is but one."""

    def __post_init__(self) -> None:
        rings = tuple(_points(f"Room {self.name!r}: ring", r, 3, 2) for r in self.rings)
        object.__setattr__(self, "rings", rings)
        if not rings:
            raise SceneError(f"Room {self.name!r} has no outline: give one ring of corners")
        if not np.isfinite([self.floor, self.ceiling]).all() or self.ceiling <= self.floor:
            raise SceneError(
                f"Room {self.name!r}: the ceiling at {self.ceiling} m must be above the floor at "
                f"{self.floor} m"
            )


@dataclass(frozen=True, slots=True, eq=False)
class Opening:
    """A rectangle in a wall, a floor or a ceiling, through which one room is seen from another."""

    name: str
    """What the building calls it."""
    kind: OpeningKind
    """Whether people walk through."""
    corners: F8
    """(4, 3) world positions, metres, round the rectangle in either sense."""
    rooms: tuple[str | None, str | None] = (None, None)
    """Names of the rooms on its two sides; None for outside or not stated."""

    def __post_init__(self) -> None:
        corners = _points(f"Opening {self.name!r}: corners", self.corners, 4, 3)
        object.__setattr__(self, "corners", corners)
        if len(corners) != 4:
            raise SceneError(f"Opening {self.name!r} has {len(corners)} corners, expected 4")
        if self.kind not in get_args(OpeningKind):
            raise SceneError(
                f"Opening {self.name!r} is a {self.kind!r}, expected one of "
                f"{', '.join(get_args(OpeningKind))}"
            )


@dataclass(frozen=True, slots=True, eq=False)
class Building:
    """Rooms and the openings between them, in world metres, +z up."""

    rooms: tuple[Room, ...]
    """In the order of the source."""
    openings: tuple[Opening, ...] = ()
    """In the order of the source."""

    def __post_init__(self) -> None:
        names = [room.name for room in self.rooms]
        twice = {name for name in names if names.count(name) > 1}
        if twice:
            raise SceneError(
                f"Building: several rooms are called {min(twice)!r}: names must differ"
            )
        for opening in self.openings:
            for name in opening.rooms:
                if name is not None and name not in names:
                    raise SceneError(
                        f"Opening {opening.name!r} leads to {name!r}, which is no room of this "
                        "building"
                    )

    def as_dict(self) -> dict[str, Any]:
        """Plain lists and numbers, as they stand in JSON: see docs/formats.md."""
        return {
            "rooms": [
                {
                    "name": room.name,
                    "rings": [ring.tolist() for ring in room.rings],
                    "floor": room.floor,
                    "ceiling": room.ceiling,
                    "storey": room.storey,
                }
                for room in self.rooms
            ],
            "openings": [
                {
                    "name": opening.name,
                    "kind": opening.kind,
                    "corners": opening.corners.tolist(),
                    "rooms": list(opening.rooms),
                }
                for opening in self.openings
            ],
        }

    @classmethod
    def from_dict(cls, data: Any, where: str = "building") -> Building:
        """Read what `as_dict` wrote.

        Raises:
            SceneError: something is missing or of the wrong kind; the message begins with
                ``where`` and the key.
        """
        rooms = tuple(
            Room(
                _text(entry, "name", at),
                tuple(np.asarray(ring) for ring in _list(entry, "rings", at)),
                _number(entry, "floor", at),
                _number(entry, "ceiling", at),
                str(entry.get("storey", "")),
            )
            for entry, at in _entries(data, "rooms", where)
        )
        openings = []
        for entry, at in _entries(data, "openings", where) if "openings" in data else ():
            sides = entry.get("rooms", [None, None])
            if not isinstance(sides, list) or len(sides) != 2:
                raise SceneError(f"{at}.rooms is {sides!r}, expected two names (null: outside)")
            kind: Any = _text(entry, "kind", at)
            corners = np.asarray(_list(entry, "corners", at))
            openings.append(Opening(_text(entry, "name", at), kind, corners, (sides[0], sides[1])))
        return cls(rooms, tuple(openings))


def _entries(data: Any, key: str, where: str) -> list[tuple[dict[str, Any], str]]:
    if not isinstance(data, dict) or not isinstance(data.get(key), list):
        raise SceneError(f"{where}.{key} is missing or no list")
    for index, entry in enumerate(data[key]):
        if not isinstance(entry, dict):
            raise SceneError(f"{where}.{key}[{index}] is {entry!r}, expected an object")
    return [(entry, f"{where}.{key}[{index}]") for index, entry in enumerate(data[key])]


def _text(entry: dict[str, Any], key: str, at: str) -> str:
    if not isinstance(entry.get(key), str):
        raise SceneError(f"{at}.{key} is {entry.get(key)!r}, expected text")
    return entry[key]


def _number(entry: dict[str, Any], key: str, at: str) -> float:
    value = entry.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise SceneError(f"{at}.{key} is {value!r}, expected a number")
    return float(value)


def _list(entry: dict[str, Any], key: str, at: str) -> list[Any]:
    if not isinstance(entry.get(key), list):
        raise SceneError(f"{at}.{key} is missing or no list")
    return entry[key]


def _points(what: str, value: Any, least: int, axes: int) -> F8:
    try:
        points = np.ascontiguousarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise SceneError(f"{what} is not a list of points") from error
    if points.ndim != 2 or points.shape[1] != axes or len(points) < least:
        raise SceneError(f"{what} has shape {points.shape}, expected ({least} or more, {axes})")
    if not np.isfinite(points).all():
        raise SceneError(f"{what} holds numbers that are not finite")
    return points
