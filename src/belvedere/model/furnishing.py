"""What stands and hangs in each kind of room.

Every kind is a list of wishes in order of importance. A `Space` grants a wish if there is room for
it that leaves the ways between the doors free.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from belvedere.model import decor, fixtures, private_rooms, sitting_rooms
from belvedere.model.architecture import Palette, Side
from belvedere.model.charts import Builder
from belvedere.model.furnisher import Furnisher, picture
from belvedere.model.light import Lamp
from belvedere.model.ornament import cornice, rail
from belvedere.model.plan import SIDES, HousePlan, RoomPlan, span_of
from belvedere.model.space import YAW, Space


def furnish(
    b: Builder, m: Palette, plan: HousePlan, room: RoomPlan, rng: np.random.Generator
) -> list[Lamp]:
    """Fill one room; gives its lamps."""
    with b.placed(0.0, 0.0, plan.base(room)):
        f = Furnisher(b, m, rng, plan, room, Space(plan, room, rng))
        _mouldings(f)
        _KINDS[room.kind](f)
        _windows(f)
        _hang(f)
    return f.lamps


def _mouldings(f: Furnisher) -> None:
    cornice(f.b, f.room.rect, f.plan.rise(f.room), f.m["trim"])
    if f.room.kind in ("library", "dining", "hall", "corridor", "study"):
        _dado(f)


def _dado(f: Furnisher) -> None:
    """A rail round the room at the height of a chair's back, between doors and windows."""
    x0, y0, x1, y1 = f.room.rect
    off: dict[Side, tuple[float, float, float]] = {
        "north": (0, -1, 0), "south": (0, 1, 0), "east": (-1, 0, 0), "west": (1, 0, 0)
    }  # fmt: skip
    for side in SIDES:
        low, high = span_of(f.room, side)
        gaps = [
            (a - 0.10, c + 0.10) for a, z0, c, _, _ in f.plan.openings_of(f.room, side) if z0 < 1.0
        ]
        if f.plan.entrance is not None and f.plan.entrance[:2] == (f.room.name, side):
            gaps.append((f.plan.entrance[2] - 0.64, f.plan.entrance[2] + 0.64))
        stair = f.plan.stair
        if stair is not None and side == "north" and f.room.name == stair.room:
            gaps.append((low, high))
        start = low
        for a, c in [*sorted(gaps), (high, high)]:
            if a - start > 0.05:
                fixed = {"north": y1, "south": y0, "east": x1, "west": x0}[side]
                ends = [(start, fixed), (a, fixed)]
                if side in ("east", "west"):
                    ends = [(y, x) for x, y in ends]
                p, q = ((*end, 0.92) for end in ends)
                rail(f.b, p, q, off[side], f.m["trim"])
            start = max(start, c)


def _windows(f: Furnisher) -> None:
    """Radiators under windows, curtains beside them where people sit and sleep."""
    cloth = f.room.kind in (
        "living",
        "bedroom",
        "chamber",
        "dining",
        "library",
        "music",
        "study",
        "guest",
    )
    wet = f.room.kind in ("kitchen", "bath")
    for side, low, high, window in f.space.windows():
        width = min(high - low - 0.1, 1.3)
        middle = (low + high) / 2.0
        a, c = middle - width / 2.0 - 0.1, middle + width / 2.0 + 0.1
        if window.sill > 0.6 and not wet and f.space.take_under_window(side, a, c, 0.22):
            x, y = f.space.point_on(side, middle)
            with f.b.placed(x, y, 0.0, YAW[side]):
                fixtures.radiator(f.b, f.m, width, window.sill - 0.22)
        if cloth:
            _curtains(f, side, low, high, window.top)


def _curtains(f: Furnisher, side: Side, low: float, high: float, top: float) -> None:
    first, last = span_of(f.room, side)
    wide = 0.30
    if low - wide - 0.05 < first or high + wide + 0.05 > last:
        return
    drop = top + 0.18
    f.space.cover(side, low - wide - 0.05, high + wide + 0.05)
    for at in (low - wide / 2.0 + 0.02, high + wide / 2.0 - 0.02):
        if not f.space.take_under_window(side, at - wide / 2.0, at + wide / 2.0, 0.14):
            return
        x, y = f.space.point_on(side, at)
        with f.b.placed(x, y, 0.0, YAW[side]), f.b.placed(0.0, -0.09):
            decor.curtain(f.b, f.m, wide, drop - 0.02, 4)
    x, y = f.space.point_on(side, (low + high) / 2.0)
    with f.b.placed(x, y, drop, YAW[side]), f.b.placed(0.0, -0.09):
        decor.curtain_rod(f.b, f.m, high - low + 0.7)


def _hang(f: Furnisher) -> None:
    """Pictures, and sconces in passages."""
    if f.room.kind in ("corridor", "hall"):
        for _ in range(3 if f.room.kind == "corridor" else 1):
            spot = f.space.on_wall(0.18, where="any")
            if spot is not None:
                with f.b.placed(spot.x, spot.y, 1.62, spot.yaw):
                    fixtures.sconce(f.b, f.m)
                    f.lamp(0.10, 0.22, 0.10, 0.0, -0.17)
    if f.room.kind in ("kitchen", "bath", "store", "dressing"):
        return
    pictures = ("seascape", "orchard", "composition", "fern", "rings")
    count = 4 if f.room.kind == "corridor" else 3
    for k in range(count):
        name = pictures[int(f.rng.integers(5))]
        width = {"seascape": 0.9, "orchard": 0.5, "composition": 0.6, "fern": 0.4, "rings": 0.6}[
            name
        ]
        tall = {"seascape": 0.6, "orchard": 0.62, "composition": 0.6, "fern": 0.58, "rings": 0.6}[
            name
        ]
        spot = f.space.on_wall(width + 0.16, where="middle" if k == 0 else "any")
        if spot is None:
            continue
        with f.b.placed(spot.x, spot.y, 1.62, spot.yaw):
            picture(f, name, width, tall)


_KINDS: dict[str, Callable[[Furnisher], None]] = {
    "living": sitting_rooms.living,
    "library": sitting_rooms.library,
    "dining": sitting_rooms.dining,
    "kitchen": private_rooms.kitchen,
    "bedroom": private_rooms.bedroom,
    "guest": private_rooms.bedroom,
    "chamber": private_rooms.chamber,
    "bath": private_rooms.bath,
    "study": sitting_rooms.study,
    "music": sitting_rooms.music,
    "nursery": private_rooms.nursery,
    "store": private_rooms.store,
    "dressing": private_rooms.dressing,
    "corridor": sitting_rooms.corridor,
    "hall": sitting_rooms.hall,
    "conservatory": sitting_rooms.conservatory,
    "flat": sitting_rooms.flat,
}
"""How each kind of room is furnished."""
