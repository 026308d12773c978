"""What stands in each kind of room, and where the light comes from.

Every kind is a list of wishes in order of importance. A `Space` grants a wish if there is room for
it that leaves the ways between the doors free.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from belvedere.model import decor, fixtures, furniture, pieces
from belvedere.model.architecture import Palette, Side
from belvedere.model.charts import Builder
from belvedere.model.light import Lamp
from belvedere.model.ornament import ball, cornice, lathe, rail, ring
from belvedere.model.plan import SIDES, SLAB, HousePlan, RoomPlan, span_of
from belvedere.model.shapes import box, tube
from belvedere.model.space import Space, Spot

WARM = (1.0, 0.72, 0.44)
"""Color of a lamp's light."""
GLAZES = ("celadon", "porcelain", "glaze", "terracotta")


@dataclass(eq=False)
class Furnisher:
    """A room being furnished."""

    b: Builder
    m: Palette
    rng: np.random.Generator
    plan: HousePlan
    room: RoomPlan
    space: Space
    lamps: list[Lamp] = field(default_factory=list)

    @contextmanager
    def at(self, spot: Spot, off: float = 0.0, turn: float = 0.0) -> Iterator[None]:
        """What is added inside stands at a spot, ``off`` metres from the wall."""
        with self.b.placed(spot.x, spot.y, 0.0, spot.yaw), self.b.placed(0.0, -off, 0.0, turn):
            yield

    def lamp(self, height: float, power: float, shade: float, x: float = 0, y: float = 0) -> None:
        """A lamp above the origin of the current place."""
        a, c, z = (float(v) for v in self.b.to_world((x, y, height)))
        r, g, bl = (power * w for w in WARM)
        self.lamps.append(Lamp((a, c, z), (r, g, bl), 0.07, shade))

    def pick(self, names: tuple[str, ...]) -> str:
        """One of several, by the seed."""
        return names[int(self.rng.integers(len(names)))]


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
            x, y = f.space._on_wall(side, middle)
            with f.b.placed(x, y, 0.0, Spot(x, y, 0.0).yaw + _yaw(side)):
                fixtures.radiator(f.b, f.m, width, window.sill - 0.22)
        if cloth:
            _curtains(f, side, low, high, window.top)


def _yaw(side: Side) -> float:
    return {"north": 0.0, "west": 90.0, "south": 180.0, "east": -90.0}[side]


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
        x, y = f.space._on_wall(side, at)
        with f.b.placed(x, y, 0.0, _yaw(side)), f.b.placed(0.0, -0.09):
            decor.curtain(f.b, f.m, wide, drop - 0.02, 4)
    x, y = f.space._on_wall(side, (low + high) / 2.0)
    with f.b.placed(x, y, drop, _yaw(side)), f.b.placed(0.0, -0.09):
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
            _picture(f, name, width, tall)


def _picture(f: Furnisher, name: str, width: float, height: float) -> None:
    wood = f.m[f.pick(("dark", "walnut", "brass", "oak"))]
    x, z = width / 2.0, height / 2.0
    furniture.framed(f.b, f.m, name, width, height, "dark", 0.04 if name == "fern" else 0.0)
    for a, c in (((-x, -z), (x, -z)), ((x, -z), (x, z)), ((x, z), (-x, z)), ((-x, z), (-x, -z))):
        tube(f.b, (a[0], -0.03, a[1]), (c[0], -0.03, c[1]), 0.014, wood, 6)
    for sx in (-1, 1):
        for sz in (-1, 1):
            ball(f.b, (sx * x, -0.03, sz * z), 0.017, wood, 6)


def _pendant(f: Furnisher, x: float, y: float, drop: float, power: float, grand: bool) -> None:
    with f.b.placed(x, y, f.plan.rise(f.room)):
        if grand:
            fixtures.chandelier(f.b, f.m, drop, 6 + 2 * int(f.rng.integers(2)))
            f.lamp(-drop + 0.12, power, 0.42)
        else:
            decor.pendant(f.b, f.m, drop)
            f.lamp(-drop, power, 0.30)


def _ceiling(f: Furnisher, power: float = 0.9, count: int = 1) -> None:
    """Bowls under the ceiling, spread along the room's longer side."""
    x0, y0, x1, y1 = f.room.rect
    for k in range(count):
        t = (k + 0.5) / count
        x, y = ((x0 + (x1 - x0) * t, (y0 + y1) / 2) if x1 - x0 > y1 - y0
                else ((x0 + x1) / 2, y0 + (y1 - y0) * t))  # fmt: skip
        with f.b.placed(x, y, f.plan.height):
            fixtures.ceiling_lamp(f.b, f.m)
            f.lamp(-0.16, power, 0.26)


def _floor_lamp(f: Furnisher) -> None:
    spot = f.space.against_wall(0.5, 0.5, 1.7, where="corner")
    if spot is not None:
        with f.at(spot, 0.25):
            decor.floor_lamp(f.b, f.m)
            f.lamp(1.50, 0.8, 0.26)


def _plant(f: Furnisher, big: bool = False) -> None:
    size = 0.62 if big else 0.5
    spot = f.space.against_wall(size, size, 0.5, where="corner")
    if spot is not None:
        with f.at(spot, size / 2.0, float(f.rng.uniform(0, 90))):
            if big:
                fixtures.tree(f.b, f.m, f.rng, float(f.rng.uniform(1.5, 1.9)))
            else:
                decor.plant(f.b, f.m, f.rng, float(f.rng.uniform(0.9, 1.4)), 14, fixtures.long_leaf)


def _bookcase(f: Furnisher, width: float, height: float = 2.15) -> bool:
    spot = f.space.against_wall(width, 0.32, height, 0.3)
    if spot is not None:
        with f.at(spot, 0.31):
            furniture.bookcase(f.b, f.m, f.rng, width, height, 6)
            for x in (-width / 2.0 + 0.011, width / 2.0 - 0.011):
                lathe(f.b, [(0.02, 0.0), (0.022, 0.02), (0.012, 0.03), (0.02, 0.05), (1e-3, 0.075)],
                      f.m["walnut"], 10, (x, 0.02, height))  # fmt: skip
    return spot is not None


def _side_table(f: Furnisher, lamp: bool = True) -> None:
    spot = f.space.against_wall(0.56, 0.56, 0.6)
    if spot is not None:
        with f.at(spot, 0.28):
            pieces.round_table(f.b, f.m["oak"], f.m["dark"], 0.25, 0.56)
            with f.b.placed(0.0, 0.0, 0.56):
                if lamp:
                    furniture.desk_lamp(f.b, f.m)
                    f.lamp(0.41, 0.35, 0.19)
                else:
                    decor.bouquet(f.b, f.m, f.rng, 0.22)


def _seats_round(f: Furnisher, spot: Spot, width: float, depth: float, count: int) -> None:
    """Chairs along the two long sides of a table, and one at each end."""
    with f.at(spot):
        for k in range(count):
            x = -width / 2.0 + (k + 0.5) * width / count
            for sign, yaw in ((-1, 180.0), (1, 0.0)):
                with f.b.placed(x, sign * (depth / 2.0 + 0.16), 0.0, yaw + f.rng.uniform(-5, 5)):
                    pieces.chair(f.b, f.m)
        for sign, yaw in ((-1, 90.0), (1, -90.0)):
            with f.b.placed(sign * (width / 2.0 + 0.18), 0.0, 0.0, yaw):
                pieces.chair(f.b, f.m)


def _laid(f: Furnisher, width: float, depth: float, count: int, height: float) -> None:
    """Plates, cups and glasses round a table top at ``height``."""
    for k in range(count):
        x = -width / 2.0 + (k + 0.5) * width / count
        for sign, yaw in ((-1, 0.0), (1, 180.0)):
            with f.b.placed(x, sign * (depth / 2.0 - 0.20), height, yaw):
                decor.crockery(f.b, f.m)
                with f.b.placed(-0.17, 0.14):
                    fixtures.glass(f.b, f.m)


def _living(f: Furnisher) -> None:
    long = f.space.against_wall(2.2, 0.95, 0.7, 0.5, "middle")
    if long is not None:
        with f.at(long, 0.50):
            furniture.sofa(f.b, f.m, 2.1)
            for x, name in ((-0.72, "pillow_a"), (0.68, "pillow_b")):
                with f.b.placed(x, 0.10, 0.47, 12.0 if x < 0 else -14.0):
                    furniture.pillow(f.b, f.m[name])
    middle = f.space.inside(1.2, 0.7, 1.0)
    if middle is not None:
        with f.at(middle):
            decor.rug(f.b, f.m["rug"], f.m["rug_edge"], 2.7, 1.8)
            pieces.table(f.b, f.m["walnut"], f.m["dark"], 1.1, 0.6, 0.44, 0.034)
            with f.b.placed(-0.3, 0.0, 0.44):
                fixtures.teapot(f.b, f.m)
                for k in range(3):
                    with f.b.placed(0.22 + 0.02 * k, -0.2 + 0.2 * k, 0.0, 70.0 * k):
                        fixtures.cup(f.b, f.m)
            with f.b.placed(0.28, 0.05, 0.44):
                decor.bouquet(f.b, f.m, f.rng, 0.20)
    for _ in range(2):
        spot = f.space.against_wall(0.95, 0.98, 0.7, 0.4)
        if spot is not None:
            with f.at(spot, 0.52):
                furniture.sofa(f.b, f.m, 0.88, "armchair")
    _bookcase(f, 1.7)
    _floor_lamp(f)
    _side_table(f)
    _plant(f, True)
    _plant(f)
    _side_table(f, False)
    x0, y0, x1, y1 = f.room.rect
    _pendant(f, (x0 + x1) / 2, (y0 + y1) / 2, 0.75, 0.8, True)


def _library(f: Furnisher) -> None:
    for width in (2.0, 1.8, 1.7, 1.5, 1.4, 1.2):
        _bookcase(f, width, 2.3)
    middle = f.space.inside(1.5, 0.85, 0.8)
    if middle is not None:
        with f.at(middle):
            decor.rug(f.b, f.m["rug"], f.m["rug_edge"], 2.4, 1.6)
            pieces.table(f.b, f.m["walnut"], f.m["walnut"], 1.4, 0.75, 0.75, 0.042)
            _desk_things(f)
    spot = f.space.against_wall(0.6, 0.6, 0.7)
    if spot is not None:
        with f.at(spot, 0.32):
            pieces.globe(f.b, f.m)
    spot = f.space.against_wall(0.95, 0.98, 0.7, 0.3)
    if spot is not None:
        with f.at(spot, 0.52):
            furniture.sofa(f.b, f.m, 0.88, "sofa")
    _floor_lamp(f)
    x0, y0, x1, y1 = f.room.rect
    _pendant(f, (x0 + x1) / 2, (y0 + y1) / 2, 0.72, 0.8, True)


def _desk_things(f: Furnisher) -> None:
    """A lamp, books and a candlestick on a table top 0.75 m high."""
    with f.b.placed(-0.45, 0.1, 0.75):
        furniture.desk_lamp(f.b, f.m)
        f.lamp(0.41, 0.4, 0.19)
    with f.b.placed(0.35, 0.02, 0.75, 14.0):
        for k in range(3):
            s = 0.14 - 0.015 * k
            low, high = (-s, -s * 0.75, 0.032 * k), (s, s * 0.75, 0.032 * k + 0.03)
            box(f.b, low, high, f.m[f"book{int(f.rng.integers(8))}"], 1.0, "-z")
    with f.b.placed(0.05, 0.2, 0.75):
        fixtures.candlestick(f.b, f.m)
    box(f.b, (-0.12, -0.22, 0.75), (0.10, 0.06, 0.752), f.m["paper"], 1.0, "-z")


def _dining(f: Furnisher) -> None:
    middle = f.space.inside(2.6, 1.75, 0.55) or f.space.inside(2.0, 1.6, 0.5)
    if middle is not None:
        with f.at(middle):
            decor.rug(f.b, f.m["kilim"], f.m["rug_edge"], 3.0, 1.9)
            pieces.table(f.b, f.m["walnut"], f.m["walnut"], 1.9, 0.95, 0.75, 0.048)
            _laid(f, 1.7, 0.95, 3, 0.75)
            for x in (-0.4, 0.4):
                with f.b.placed(x, 0.0, 0.75):
                    fixtures.candlestick(f.b, f.m, 0.28)
            with f.b.placed(0.0, 0.0, 0.75):
                decor.fruit_bowl(f.b, f.m, f.rng)
        _seats_round(f, middle, 1.7, 0.95, 3)
        _pendant(f, middle.x, middle.y, 0.95, 0.9, True)
    _dresser(f)
    spot = f.space.against_wall(0.62, 0.34, 2.1, 0.3)
    if spot is not None:
        with f.at(spot):
            pieces.clock(f.b, f.m)
    _plant(f, True)


def _dresser(f: Furnisher) -> None:
    """A sideboard with crockery on it and two shelves of plates above."""
    spot = f.space.against_wall(1.7, 0.5, 1.9, 0.4)
    if spot is None:
        return
    with f.at(spot):
        furniture.cabinet(f.b, f.m, 1.6, 0.9, 0.46, 3, "oak", "walnut")
        for k in range(5):
            with f.b.placed(-0.6 + 0.3 * k, -0.25, 0.9):
                if k % 2:
                    fixtures.jar(f.b, f.m, 0.07, 0.22, GLAZES[k % 4])
                else:
                    fixtures.teapot(f.b, f.m, GLAZES[(k + 1) % 4])
        for z in (1.36, 1.74):
            with f.b.placed(0.0, 0.0, z):
                furniture.shelf(f.b, f.m, 1.5)
            for k in range(8):
                with f.b.placed(-0.63 + 0.18 * k, -0.11, z):
                    if z < 1.5:
                        fixtures.cup(f.b, f.m, GLAZES[k % 2])
                    else:
                        decor.vase(f.b, f.m, GLAZES[k % 4], 0.14 + 0.02 * (k % 3))


def _kitchen(f: Furnisher) -> None:
    run = None
    for width in (3.6, 3.0, 2.4, 1.8):
        run = f.space.against_wall(width, 0.64, 0.92, 0.5, "middle")
        if run is not None:
            _worktop(f, run, width)
            break
    spot = f.space.against_wall(0.95, 0.66, 1.0, 0.5)
    if spot is not None:
        with f.at(spot):
            fixtures.stove(f.b, f.m, f.rng)
        with f.b.placed(spot.x, spot.y, 1.85, spot.yaw):
            _pan_rail(f)
    _dresser(f)
    middle = f.space.inside(1.9, 1.3, 0.7) or f.space.inside(1.4, 1.2, 0.6)
    if middle is not None:
        with f.at(middle):
            pieces.table(f.b, f.m["oak"], f.m["oak"], 1.2, 0.7, 0.75, 0.044)
            with f.b.placed(0.05, 0.02, 0.75):
                decor.fruit_bowl(f.b, f.m, f.rng)
            with f.b.placed(-0.38, -0.1, 0.75, 30.0):
                fixtures.teapot(f.b, f.m, "glaze")
            for sign, yaw in ((-1, 180.0), (1, 0.0)):
                with f.b.placed(0.0, sign * 0.48, 0.0, yaw):
                    pieces.chair(f.b, f.m)
        _pendant(f, middle.x, middle.y, 0.85, 0.8, False)
    _plant(f)
    _ceiling(f, 0.7)


def _worktop(f: Furnisher, spot: Spot, width: float) -> None:
    with f.at(spot):
        furniture.cabinet(f.b, f.m, width, 0.92, 0.60, int(width / 0.6), "cupboard", "marble")
        with f.b.placed(-width * 0.22, 0.0, 0.92):
            fixtures.sink(f.b, f.m)
        box(f.b, (-width / 2, -0.008, 0.92), (width / 2, 0.0, 1.04), f.m["subway"], 1.6, "+y")
        for k, x in enumerate(pieces.rows_of(5, 0.0, width / 2 - 0.15, f.rng)):
            with f.b.placed(x, -0.2, 0.92):
                if k % 3 == 2:
                    fixtures.bottle(f.b, f.m, 0.30, "leaf2")
                else:
                    fixtures.jar(f.b, f.m, 0.065, 0.20 - 0.02 * (k % 2), GLAZES[k % 4])
        with f.b.placed(-width / 2 + 0.25, -0.3, 0.92, 20.0):
            box(f.b, (-0.15, -0.2, 0.0), (0.15, 0.2, 0.022), f.m["walnut"], 1.5, "-z")
            for k in range(3):
                ball(f.b, (-0.05 + 0.07 * k, 0.03 * k, 0.055), 0.034, f.m["apple"])


def _pan_rail(f: Furnisher) -> None:
    """A rail on the wall with hanging pans."""
    tube(f.b, (-0.45, -0.06, 0.0), (0.45, -0.06, 0.0), 0.008, f.m["iron"], 8)
    for x in (-0.42, 0.42):
        tube(f.b, (x, -0.06, 0.0), (x, 0.0, 0.0), 0.008, f.m["iron"], 8)
    for k in range(4):
        hung = f.b.placed(-0.33 + 0.22 * k, -0.07, -0.29, 0.0, 90.0)
        with hung, f.b.placed(0.0, 0.0, 0.0, 90.0):
            fixtures.pan(f.b, f.m, 0.07 + 0.006 * k, 0.06)


def _bedroom(f: Furnisher, rug: bool = True) -> None:
    width = 1.6 if f.room.kind != "guest" else 1.0
    spot = f.space.against_wall(width + 0.2, 2.15, 1.2, 0.0, "middle") or f.space.against_wall(
        1.15, 2.15, 1.2
    )
    if spot is not None:
        with f.at(spot):
            pieces.bed(f.b, f.m, min(width, 1.6), f.pick(("quilt_a", "quilt_b", "sofa")))
    for _ in range(2):
        _side_table(f)
    spot = f.space.against_wall(1.5, 0.62, 2.1, 0.6)
    if spot is not None:
        with f.at(spot):
            furniture.cabinet(f.b, f.m, 1.4, 2.1, 0.56, 3, f.pick(("walnut", "oak", "cupboard")))
            for x in (-0.6, 0.6):
                ball(f.b, (x, -0.5, 2.13), 0.035, f.m["walnut"], 10)
    spot = f.space.against_wall(1.0, 0.5, 0.85, 0.5)
    if spot is not None:
        with f.at(spot):
            furniture.cabinet(f.b, f.m, 0.95, 0.84, 0.44, 2, "oak", "walnut")
            with f.b.placed(0.2, -0.2, 0.84):
                decor.bouquet(f.b, f.m, f.rng, 0.22)
        with f.b.placed(spot.x, spot.y, 1.55, spot.yaw):
            fixtures.mirror(f.b, f.m, 0.55, 0.75)
    middle = f.space.inside(0.5, 0.5, 0.9)
    if middle is not None:
        with f.at(middle):
            if rug:
                decor.rug(f.b, f.m["kilim"], f.m["rug_edge"], 1.8, 0.9)
            pieces.stool(f.b, f.m)
    _plant(f)
    _ceiling(f, 0.8)


def _chamber(f: Furnisher) -> None:
    """A large bedroom to sit in, too."""
    _bedroom(f, False)
    spot = f.space.against_wall(2.2, 0.95, 0.7, 0.4)
    if spot is not None:
        with f.at(spot, 0.50):
            furniture.sofa(f.b, f.m, 2.0, "armchair")
    for _ in range(2):
        spot = f.space.against_wall(0.95, 0.98, 0.7, 0.3)
        if spot is not None:
            with f.at(spot, 0.52):
                furniture.sofa(f.b, f.m, 0.88, "sofa")
    middle = f.space.inside(1.2, 0.9, 0.8)
    if middle is not None:
        with f.at(middle):
            decor.rug(f.b, f.m["rug"], f.m["rug_edge"], 2.7, 1.8)
            with f.b.placed(0.0, 0.0, 0.012):
                pieces.round_table(f.b, f.m["walnut"], f.m["dark"], 0.40, 0.7)
            with f.b.placed(0.0, 0.0, 0.712):
                decor.fruit_bowl(f.b, f.m, f.rng)
        _pendant(f, middle.x, middle.y, 0.7, 0.8, False)
    _bookcase(f, 1.7)
    _floor_lamp(f)
    _plant(f, True)


def _bath(f: Furnisher) -> None:
    spot = f.space.against_wall(1.75, 0.82, 0.7, 0.3, "middle")
    if spot is not None:
        with f.at(spot):
            fixtures.bathtub(f.b, f.m)
    for width, depth, piece in ((0.62, 0.58, fixtures.basin), (0.46, 0.68, fixtures.toilet)):
        spot = f.space.against_wall(width, depth, 0.9, 0.4)
        if spot is not None:
            with f.at(spot):
                piece(f.b, f.m)
            if piece is fixtures.basin:
                with f.b.placed(spot.x, spot.y, 1.5, spot.yaw):
                    fixtures.mirror(f.b, f.m, 0.5, 0.7)
    spot = f.space.on_wall(0.7)
    if spot is not None:
        with f.b.placed(spot.x, spot.y, 1.2, spot.yaw):
            fixtures.towel_rail(f.b, f.m)
    spot = f.space.against_wall(0.42, 0.42, 0.5)
    if spot is not None:
        with f.at(spot, 0.21):
            pieces.stool(f.b, f.m, 0.44, "towel")
    _ceiling(f, 0.8)


def _study(f: Furnisher) -> None:
    spot = f.space.against_wall(1.5, 1.15, 0.78, 0.0, "middle")
    if spot is not None:
        with f.at(spot, 0.40):
            pieces.table(f.b, f.m["oak"], f.m["dark"], 1.4, 0.70, 0.75, 0.04)
            _desk_things(f)
            with f.b.placed(0.1, -0.52, 0.0, 184.0):
                pieces.chair(f.b, f.m)
    for width in (1.6, 1.2, 1.0):
        _bookcase(f, width, 2.1)
    spot = f.space.against_wall(0.6, 0.6, 0.7)
    if spot is not None:
        with f.at(spot, 0.32):
            pieces.globe(f.b, f.m)
    _floor_lamp(f)
    _plant(f)
    _ceiling(f, 0.7)


def _music(f: Furnisher) -> None:
    spot = f.space.against_wall(1.65, 1.3, 1.3, 0.0, "middle")
    if spot is not None:
        with f.at(spot):
            pieces.piano(f.b, f.m)
            with f.b.placed(0.0, -1.05):
                pieces.stool(f.b, f.m, 0.5)
            for x in (-0.55, 0.55):
                with f.b.placed(x, -0.2, 1.25):
                    fixtures.candlestick(f.b, f.m, 0.24)
    spot = f.space.against_wall(2.2, 0.95, 0.7, 0.4)
    if spot is not None:
        with f.at(spot, 0.50):
            furniture.sofa(f.b, f.m, 2.0, "armchair")
    middle = f.space.inside(1.0, 1.0, 1.0)
    if middle is not None:
        with f.at(middle):
            decor.rug(f.b, f.m["rug"], f.m["rug_edge"], 2.7, 1.8)
            with f.b.placed(0.0, 0.0, 0.012):
                pieces.round_table(f.b, f.m["walnut"], f.m["dark"], 0.42, 0.7)
            with f.b.placed(0.0, 0.0, 0.712):
                decor.bouquet(f.b, f.m, f.rng, 0.24)
    for _ in range(3):
        spot = f.space.against_wall(0.5, 0.62, 0.9, 0.2)
        if spot is not None:
            with f.at(spot, 0.34):
                pieces.chair(f.b, f.m, "walnut", "armchair")
    _floor_lamp(f)
    _plant(f, True)
    _plant(f)
    x0, y0, x1, y1 = f.room.rect
    _pendant(f, (x0 + x1) / 2, (y0 + y1) / 2, 0.75, 0.9, True)


def _nursery(f: Furnisher) -> None:
    spot = f.space.against_wall(1.4, 0.75, 0.6, 0.4)
    if spot is not None:
        with f.at(spot):
            pieces.cradle(f.b, f.m)
    _bookcase(f, 1.2, 1.5)
    middle = f.space.inside(0.95, 0.95, 0.9)
    if middle is not None:
        with f.at(middle):
            decor.rug(f.b, f.m["kilim"], f.m["rug_edge"], 2.0, 1.3)
            with f.b.placed(0.0, 0.0, 0.012):
                pieces.toys(f.b, f.m, f.rng)
    spot = f.space.against_wall(1.0, 0.5, 0.75, 0.3)
    if spot is not None:
        with f.at(spot):
            furniture.cabinet(f.b, f.m, 0.95, 0.7, 0.44, 2, "cupboard", "oak")
            for k in range(3):
                with f.b.placed(-0.28 + 0.28 * k, -0.22, 0.7):
                    ball(f.b, (0, 0, 0.075), 0.075, f.m[f"block{k}"], 8)
    spot = f.space.against_wall(0.95, 0.98, 0.7, 0.2)
    if spot is not None:
        with f.at(spot, 0.52):
            furniture.sofa(f.b, f.m, 0.85, "pillow_a")
    _plant(f)
    _ceiling(f, 0.9)


def _store(f: Furnisher) -> None:
    for _ in range(2):
        spot = f.space.against_wall(1.3, 0.34, 1.95, 0.4)
        if spot is None:
            continue
        with f.at(spot):
            for z in (0.45, 0.85, 1.25, 1.65):
                with f.b.placed(0.0, 0.0, z):
                    furniture.shelf(f.b, f.m, 1.2, 0.28)
                for k, x in enumerate(pieces.rows_of(7, -0.5, 0.5, f.rng)):
                    with f.b.placed(x, -0.15, z):
                        if (k + round(z * 20)) % 3:
                            tall = float(f.rng.uniform(0.14, 0.24))
                            fixtures.jar(f.b, f.m, 0.06, tall, GLAZES[(k * 3) % 4])
                        else:
                            fixtures.bottle(f.b, f.m, 0.29, f.pick(("leaf2", "dark_glass")))
    spot = f.space.against_wall(0.66, 0.66, 0.86, 0.5)
    if spot is not None:
        with f.at(spot):
            fixtures.washing_machine(f.b, f.m)
    spot = f.space.against_wall(0.62, 0.58, 0.9, 0.4)
    if spot is not None:
        with f.at(spot):
            fixtures.basin(f.b, f.m)
    _ceiling(f, 0.7)


def _dressing(f: Furnisher) -> None:
    for width, doors in ((1.8, 4), (1.2, 2)):
        spot = f.space.against_wall(width, 0.6, 2.2, 0.5)
        if spot is not None:
            with f.at(spot):
                furniture.cabinet(f.b, f.m, width - 0.05, 2.2, 0.56, doors, "walnut")
    spot = f.space.on_wall(0.9)
    if spot is not None:
        with f.b.placed(spot.x, spot.y, 1.35, spot.yaw):
            fixtures.mirror(f.b, f.m, 0.7, 1.3)
    spot = f.space.against_wall(0.42, 0.42, 0.5)
    if spot is not None:
        with f.at(spot, 0.21):
            pieces.stool(f.b, f.m)
    _ceiling(f, 0.8)


def _corridor(f: Furnisher) -> None:
    x0, y0, x1, y1 = f.room.rect
    long = max(x1 - x0, y1 - y0)
    _console(f)
    if long > 6.0:
        _console(f)
    with f.at(Spot((x0 + x1) / 2, (y0 + y1) / 2, 0.0 if x1 - x0 > y1 - y0 else 90.0)):
        decor.rug(f.b, f.m["kilim"], f.m["rug_edge"], min(long - 1.2, 4.6), 0.95)
    _ceiling(f, 0.65, max(int(long / 3.4), 1))


def _console(f: Furnisher) -> None:
    """A narrow table against the wall with a vase or a lamp."""
    spot = f.space.against_wall(1.0, 0.34, 0.85)
    if spot is None:
        return
    with f.at(spot, 0.17):
        pieces.table(f.b, f.m["walnut"], f.m["dark"], 0.95, 0.30, 0.80, 0.026)
        with f.b.placed(-0.28, 0.0, 0.80):
            furniture.desk_lamp(f.b, f.m)
            f.lamp(0.41, 0.35, 0.19)
        with f.b.placed(0.25, 0.0, 0.80):
            decor.bouquet(f.b, f.m, f.rng, 0.24)


def _hall(f: Furnisher) -> None:
    _console(f)
    spot = f.space.against_wall(0.62, 0.34, 2.1, 0.3)
    if spot is not None:
        with f.at(spot):
            pieces.clock(f.b, f.m)
    for _ in range(2):
        spot = f.space.against_wall(0.5, 0.62, 0.9, 0.2)
        if spot is not None:
            with f.at(spot, 0.34):
                pieces.chair(f.b, f.m, "walnut", "armchair")
    _umbrellas(f)
    _plant(f, True)
    x0, y0, x1, y1 = f.room.rect
    void = f.plan.void() if f.plan.stair and f.plan.stair.room == f.room.name else None
    if void is None:
        _pendant(f, (x0 + x1) / 2, (y0 + y1) / 2, 0.52, 0.9, True)
        return
    xg, yg, _, _ = void
    _pendant(f, (xg + x1) / 2, yg + 0.9, 2.3, 1.6, True)
    upper = f.plan.height + SLAB
    for z, x, power in ((f.plan.height, (x0 + x1) / 2, 0.6), (f.plan.rise(f.room), x1 - 1.2, 0.6)):
        with f.b.placed(x, (y0 + yg) / 2, z):
            fixtures.ceiling_lamp(f.b, f.m)
            f.lamp(-0.16, power, 0.26)
    for y, name, width, height in (
        (y0 + 0.75, "orchard", 0.5, 0.62),
        (y1 - 0.7, "fern", 0.4, 0.58),
    ):
        with f.b.placed(x0, y, upper + 1.6, 90.0):
            _picture(f, name, width, height)
    with f.b.placed(x0 + 4.6, y0, upper + 1.6, 180.0):
        _picture(f, "seascape", 0.9, 0.6)


def _umbrellas(f: Furnisher) -> None:
    spot = f.space.against_wall(0.34, 0.34, 0.9, where="corner")
    if spot is None:
        return
    with f.at(spot, 0.17):
        lathe(f.b, [(0.11, 0.0), (0.12, 0.02), (0.10, 0.1), (0.11, 0.4), (0.13, 0.52), (0.12, 0.52),
                    (0.10, 0.4), (0.09, 0.03), (1e-3, 0.03)], f.m["glaze"], 8)  # fmt: skip
        for k in range(3):
            a = k * 2.1
            x, y = 0.05 * np.cos(a), 0.05 * np.sin(a)
            lathe(f.b, [(0.008, 0.05), (0.03, 0.35), (0.022, 0.62), (0.008, 0.66), (0.008, 0.82)],
                  f.m[("dark", "book1", "book0")[k]], 8, (x, y, 0.0))  # fmt: skip
            ring(f.b, (x, y, 0.84), 0.03, 0.008, f.m["oak"], 10)


def _conservatory(f: Furnisher) -> None:
    middle = f.space.inside(1.5, 1.5, 0.7) or f.space.inside(1.2, 1.2, 0.6)
    if middle is not None:
        with f.at(middle):
            pieces.round_table(f.b, f.m["oak"], f.m["iron"], 0.5)
            with f.b.placed(0.0, 0.1, 0.74):
                fixtures.teapot(f.b, f.m)
            for k in range(3):
                a = np.radians(120.0 * k + 90.0)
                with f.b.placed(0.62 * np.cos(a), 0.62 * np.sin(a), 0.0, 120.0 * k):
                    pieces.chair(f.b, f.m)
                with f.b.placed(0.3 * np.cos(a), 0.3 * np.sin(a), 0.74, 120.0 * k):
                    fixtures.cup(f.b, f.m)
        _pendant(f, middle.x, middle.y, 0.9, 0.7, False)
    for k in range(7):
        _plant(f, k % 2 == 0)


def _flat(f: Furnisher) -> None:
    """Living and cooking in one room."""
    run = f.space.against_wall(2.4, 0.64, 0.92, 0.5, "corner")
    if run is not None:
        _worktop(f, run, 2.4)
    spot = f.space.against_wall(0.95, 0.66, 1.0, 0.5)
    if spot is not None:
        with f.at(spot):
            fixtures.stove(f.b, f.m, f.rng)
    _living(f)


_KINDS: dict[str, Callable[[Furnisher], None]] = {
    "living": _living,
    "library": _library,
    "dining": _dining,
    "kitchen": _kitchen,
    "bedroom": _bedroom,
    "guest": _bedroom,
    "chamber": _chamber,
    "bath": _bath,
    "study": _study,
    "music": _music,
    "nursery": _nursery,
    "store": _store,
    "dressing": _dressing,
    "corridor": _corridor,
    "hall": _hall,
    "conservatory": _conservatory,
    "flat": _flat,
}
"""How each kind of room is furnished."""
