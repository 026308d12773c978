"""Floor plans of the built-in houses: rooms, doors and windows, and the shell they make.

A plan is drawn with the middle lines of its walls. Rooms are rectangles; their floors, walls and
ceilings lie half an inner wall inside those lines. Outer walls grow outwards from there.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from belvedere.model import architecture as arch
from belvedere.model.architecture import Palette, Side
from belvedere.model.building import Building, Opening, OpeningKind, Room
from belvedere.model.charts import Builder, Rect
from belvedere.model.shapes import box

HALF_WALL = 0.08
"""Half the thickness of an inner wall, metres."""
OUTER_WALL = 0.30
"""Thickness of an outer wall."""
SLAB = 0.30
"""From a ceiling to the floor above it."""
ROOF = 0.24
"""Thickness of the roof."""
EAVES = 0.35
"""How far the roof reaches past the outer walls."""

WALL_SCALE = {"bath_wall": 1.3}
"""Texture repeats per metre where they are not 0.5."""
STOREYS = ("ground floor", "upper floor")
SIDES: tuple[Side, ...] = ("north", "south", "east", "west")


@dataclass(frozen=True, slots=True)
class Door:
    """A way between two rooms of one storey."""

    rooms: tuple[str, str]
    """Which ones; they share a wall."""
    at: float
    """Middle of the opening along that wall: x or y."""
    width: float = 0.92
    """Metres."""
    height: float = 2.08
    """Metres above the floor."""
    kind: OpeningKind = "door"
    """A wide one without a leaf is an opening."""


@dataclass(frozen=True, slots=True)
class Window:
    """A window in an outer wall."""

    room: str
    """Whose."""
    side: Side
    """Which of its walls."""
    at: float
    """Middle along that wall: x or y."""
    width: float = 1.4
    """Metres."""
    sill: float = 0.85
    """Metres above the floor."""
    top: float = 2.25
    """Metres above the floor."""
    panes: tuple[int, int] = (2, 3)
    """Across and up."""


@dataclass(frozen=True, slots=True)
class RoomPlan:
    """A room on the plan."""

    name: str
    """Unique in its house."""
    kind: str
    """What it is furnished as."""
    lines: Rect
    """(x0, y0, x1, y1) middle lines of its walls."""
    storey: int = 0
    """0 for the lowest."""
    storeys: int = 1
    """How many it is high: 2 for a hall with a gallery."""

    @property
    def rect(self) -> Rect:
        """Inner faces of the walls."""
        x0, y0, x1, y1 = self.lines
        h = HALF_WALL
        return x0 + h, y0 + h, x1 - h, y1 - h


@dataclass(frozen=True, slots=True)
class Stair:
    """A straight stair that climbs towards -x along the north wall of a hall two storeys high.

    It ends on a gallery that runs along the west and the south wall.
    """

    room: str
    """Where it stands."""
    foot: float
    """x of the first riser."""
    gallery: float
    """y of the gallery's edge."""
    width: float = 1.0
    """Metres."""
    going: float = 0.265
    """Depth of a step."""
    riser: float = 0.175
    """Height of a step."""


@dataclass(frozen=True, slots=True)
class HousePlan:
    """All of a house that is fixed before the furniture comes."""

    rooms: tuple[RoomPlan, ...]
    """Together they fill a rectangle on every storey."""
    doors: tuple[Door, ...]
    """Ways between them."""
    windows: tuple[Window, ...]
    """Ways to look out."""
    height: float
    """From floor to ceiling, metres."""
    stair: Stair | None = None
    """Between the first two storeys."""
    entrance: tuple[str, Side, float] | None = None
    """Room, side and place of the front door, which is shut."""
    finishes: dict[str, tuple[str, str, float]] = field(default_factory=dict)
    """Wall, floor and floor texture repeats per metre of each kind of room."""

    def room(self, name: str) -> RoomPlan:
        """The room of that name."""
        return next(room for room in self.rooms if room.name == name)

    def base(self, room: RoomPlan) -> float:
        """Height of a room's floor."""
        return room.storey * (self.height + SLAB)

    def rise(self, room: RoomPlan) -> float:
        """From a room's floor to its ceiling."""
        return room.storeys * (self.height + SLAB) - SLAB

    def level(self, door: Door) -> float:
        """Height of the floor on which one walks through a door."""
        return max(self.base(self.room(name)) for name in door.rooms)

    def door_wall(self, door: Door) -> tuple[Literal["x", "y"], float]:
        """The axis along which a door's wall runs, and where its middle line lies."""
        a, c = (self.room(name).lines for name in door.rooms)
        for k, axis in ((0, "y"), (1, "x")):
            for one, other in ((a, c), (c, a)):
                if abs(one[k + 2] - other[k]) < 1e-9:
                    return ("y", one[k + 2]) if axis == "y" else ("x", one[k + 2])
        raise AssertionError(f"{door.rooms} share no wall")

    def openings_of(
        self, room: RoomPlan, side: Side
    ) -> list[tuple[float, float, float, float, Door | Window]]:
        """(low, z0, high, z1) along one wall with the door or window that is there."""
        found: list[tuple[float, float, float, float, Door | Window]] = []
        for door in self.doors:
            if room.name in door.rooms and self._side_of(room, door) == side:
                half, z0 = door.width / 2.0, self.level(door) - self.base(room)
                found.append((door.at - half, z0, door.at + half, z0 + door.height, door))
        for window in self.windows:
            if window.room == room.name and window.side == side:
                half = window.width / 2.0
                found.append((window.at - half, window.sill, window.at + half, window.top, window))
        return sorted(found, key=lambda hole: hole[0])

    def _side_of(self, room: RoomPlan, door: Door) -> Side:
        axis, at = self.door_wall(door)
        x0, y0, _, _ = room.lines
        if axis == "x":
            return "south" if abs(y0 - at) < 1e-9 else "north"
        return "west" if abs(x0 - at) < 1e-9 else "east"

    def void(self) -> Rect | None:
        """(x0, y0, x1, y1) of the hall that no gallery covers; the stair lies along its north."""
        if self.stair is None:
            return None
        _, _, x1, y1 = self.room(self.stair.room).rect
        return self.stair.foot - (self.steps() - 1) * self.stair.going, self.stair.gallery, x1, y1

    @property
    def level_above(self) -> float:
        """Height of the upper storey's floor."""
        return self.height + SLAB

    def steps(self) -> int:
        """Risers of the stair."""
        assert self.stair is not None
        return round((self.height + SLAB) / self.stair.riser)

    def outline(self) -> Rect:
        """Outer faces of the outer walls."""
        lines = np.array([room.lines for room in self.rooms])
        grow = OUTER_WALL - HALF_WALL
        low, high = lines[:, :2].min(axis=0) - grow, lines[:, 2:].max(axis=0) + grow
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])

    def building(self) -> Building:
        """What the house states about itself."""
        rooms = []
        several = any(room.storey for room in self.rooms)
        for room in self.rooms:
            x0, y0, x1, y1 = room.rect
            ring = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
            z = self.base(room)
            storey = STOREYS[room.storey] if several else ""
            rooms.append(Room(room.name, (ring,), z, z + self.rise(room), storey))
        return Building(tuple(rooms), (*self._door_openings(), *self._window_openings()))

    def _door_openings(self) -> list[Opening]:
        found = []
        for door in self.doors:
            axis, at = self.door_wall(door)
            z0 = self.level(door)
            low, high, z1 = door.at - door.width / 2, door.at + door.width / 2, z0 + door.height
            flat = [(low, at), (high, at), (high, at), (low, at)]
            if axis == "y":
                flat = [(y, x) for x, y in flat]
            corners = np.array([(*p, z) for p, z in zip(flat, (z0, z0, z1, z1), strict=True)])
            found.append(Opening(" - ".join(door.rooms), door.kind, corners, door.rooms))
        return found

    def _window_openings(self) -> list[Opening]:
        found = []
        for k, window in enumerate(self.windows):
            room = self.room(window.room)
            at = _wall_at(room, window.side) + _outwards(window.side) * OUTER_WALL / 2.0
            low, high = window.at - window.width / 2.0, window.at + window.width / 2.0
            z0, z1 = self.base(room) + window.sill, self.base(room) + window.top
            flat = [(low, at), (high, at), (high, at), (low, at)]
            if window.side in ("east", "west"):
                flat = [(y, x) for x, y in flat]
            corners = np.array([(*p, z) for p, z in zip(flat, (z0, z0, z1, z1), strict=True)])
            name = f"{window.room}, {window.side} window {k}"
            found.append(Opening(name, "window", corners, (window.room, None)))
        return found


def _wall_at(room: RoomPlan, side: Side) -> float:
    """Y (north, south) or x (east, west) of a wall's inner face."""
    x0, y0, x1, y1 = room.rect
    return {"north": y1, "south": y0, "east": x1, "west": x0}[side]


def _outwards(side: Side) -> float:
    return 1.0 if side in ("north", "east") else -1.0


def span_of(room: RoomPlan, side: Side) -> tuple[float, float]:
    """Lowest and highest x or y along a wall."""
    x0, y0, x1, y1 = room.rect
    return (x0, x1) if side in ("north", "south") else (y0, y1)


def build_shell(b: Builder, m: Palette, plan: HousePlan) -> None:
    """Floors, walls, ceilings, windows, doorways, stair, roof and facades."""
    for room in plan.rooms:
        with b.placed(0.0, 0.0, plan.base(room)):
            _room_shell(b, m, plan, room)
    for door in plan.doors:
        axis, at = plan.door_wall(door)
        with b.placed(0.0, 0.0, plan.level(door)):
            low, high = door.at - door.width / 2.0, door.at + door.width / 2.0
            faces = (at - HALF_WALL, at + HALF_WALL)
            arch.doorway(b, m, axis, faces, (low, high), door.height)
    _outside(b, m, plan)
    _front_door(b, m, plan)
    _hall(b, m, plan)


def _room_shell(b: Builder, m: Palette, plan: HousePlan, room: RoomPlan) -> None:
    wall, floor, repeats = plan.finishes[room.kind]
    x0, y0, x1, y1 = room.rect
    _level(b, (x0, y0, x1, y1), 0.0, m[floor], repeats)
    grow = HALF_WALL - 1e-3  # ceilings reach into the walls: no light comes in over them
    over = (x0 - grow, y0 - grow, x1 + grow, y1 + grow)
    rise = plan.rise(room)
    _level(b, over, rise, m["ceiling"], 0.5, up=False)
    for side in SIDES:
        at, span, found = _wall_at(room, side), span_of(room, side), plan.openings_of(room, side)
        holes = [hole[:4] for hole in found]
        arch.wall(b, side, at, span, (0.0, rise), m[wall], holes, WALL_SCALE.get(wall, 0.5))
        gaps = [(h[0] - 0.09, h[2] + 0.09) for h in found if h[1] < 0.1]
        if plan.entrance is not None and plan.entrance[:2] == (room.name, side):
            gaps.append((plan.entrance[2] - 0.72, plan.entrance[2] + 0.72))
        arch.skirting(b, m, side, at, span, gaps)
        for low, z0, high, z1, what in found:
            if isinstance(what, Window):
                arch.window(b, m, side, at, (low, z0, high, z1), what.panes, OUTER_WALL)


def _level(
    b: Builder,
    area: Rect,
    z: float,
    material: int,
    scale: float,
    hole: Rect | None = None,
    up: bool = True,
) -> None:
    """A floor (``up``) or a ceiling, with or without a rectangular hole in it."""
    x0, y0, x1, y1 = area
    corners = np.array([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])
    holes: list[Rect] = []
    if hole is not None:
        a, c, e, f = hole
        holes = [(a - x0, c - y0, e - x0, f - y0) if up else (a - x0, y1 - f, e - x0, y1 - c)]
    cells = arch.cells_around(x1 - x0, y1 - y0, holes)
    if not up:
        corners = corners[[3, 2, 1, 0]]
    b.sheet(corners, material, scale, cells, holes, (x0 * scale, y0 * scale))


def _outside(b: Builder, m: Palette, plan: HousePlan) -> None:
    """Facades with holes for the windows, and a flat roof that reaches over them."""
    x0, y0, x1, y1 = plan.outline()
    top = max(plan.base(room) for room in plan.rooms) + plan.height
    faces: tuple[tuple[Side, Side, float, tuple[float, float]], ...] = (
             ("north", "south", y1, (x0, x1)), ("south", "north", y0, (x0, x1)),
             ("east", "west", x1, (y0, y1)), ("west", "east", x0, (y0, y1)))  # fmt: skip
    for side, seen_as, at, span in faces:
        holes = []
        for window in plan.windows:
            if window.side == side:
                z, half = plan.base(plan.room(window.room)), window.width / 2.0
                holes.append((window.at - half, z + window.sill, window.at + half, z + window.top))
        arch.wall(b, seen_as, at, span, (0.0, top + 0.02), m["facade"], holes)
    box(b, (x0 - EAVES, y0 - EAVES, top + 0.02), (x1 + EAVES, y1 + EAVES, top + ROOF), m["roof"])


def _front_door(b: Builder, m: Palette, plan: HousePlan) -> None:
    """A shut door with panels, seen from within."""
    if plan.entrance is None:
        return
    name, side, at = plan.entrance
    room = plan.room(name)
    yaw = {"north": 0.0, "west": 90.0, "south": 180.0, "east": -90.0}[side]
    wall = _wall_at(room, side)
    x, y = (at, wall) if side in ("north", "south") else (wall, at)
    with b.placed(x, y, plan.base(room), yaw):
        box(b, (-0.50, -0.035, 0.0), (0.50, 0.0, 2.1), m["door"], 0.5, "+y")
        for a, c, z0, z1 in ((-0.40, -0.05, 0.15, 0.80), (0.05, 0.40, 0.15, 0.80),
                             (-0.40, -0.05, 0.95, 1.95), (0.05, 0.40, 0.95, 1.95)):  # fmt: skip
            box(b, (a, -0.047, z0), (c, -0.035, z1), m["door"], 0.5, "+y")
        for a, c, z0, z1 in ((-0.62, -0.50, 0.0, 2.2), (0.50, 0.62, 0.0, 2.2),
                             (-0.50, 0.50, 2.1, 2.2)):  # fmt: skip
            box(b, (a, -0.05, z0), (c, 0.0, z1), m["trim"], 0.5, "+y")


def _hall(b: Builder, m: Palette, plan: HousePlan) -> None:
    """The stair, the gallery to which it leads, and the railing along its edges."""
    void, s = plan.void(), plan.stair
    if s is None or void is None:
        return
    room = plan.room(s.room)
    xg, yg, x1, y1 = void
    steps, upper = plan.steps(), plan.height + SLAB
    arch.stair(b, m, (s.foot, y1 - s.width), s.width, steps, upper / steps, s.going)
    grow = HALF_WALL - 1e-3
    _level(b, room.rect, upper, m["planks"], 0.5, void)
    x0, y0, _, _ = room.rect
    under = (x0 - grow, y0 - grow, x1, y1)
    _level(b, under, plan.height, m["ceiling"], 0.5, void, up=False)
    for low, high in (((xg, yg - 0.02), (x1, yg)), ((xg - 0.02, yg - 0.02), (xg, y1))):
        box(b, (*low, plan.height - 0.02), (*high, upper + 0.004), m["oak"], 0.6)
    arch.railing(b, m, (xg - 0.07, yg - 0.07), (x1 - 0.05, yg - 0.07), upper)
    arch.railing(b, m, (xg - 0.07, yg - 0.07), (xg - 0.07, y1 - s.width), upper)
    with b.placed(0.0, 0.0, upper):
        walls: tuple[tuple[Side, tuple[float, float]], ...] = (
            ("west", (y0, y1)), ("south", (x0, x1)), ("east", (y0, yg)), ("north", (x0, xg)),
        )  # fmt: skip
        for side, span in walls:
            gaps = [
                (low - 0.09, high + 0.09)
                for low, z0, high, _, what in plan.openings_of(room, side)
                if isinstance(what, Door) and z0 > 0.1
            ]
            arch.skirting(b, m, side, _wall_at(room, side), span, gaps)
