"""What every room of a house may wish for: lamps, plants, bookcases, pictures, small tables.

A `Furnisher` is a room under way; a wish asks its `Space` for a place and goes without if there is
none.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from belvedere.model import decor, fixtures, furniture, pieces
from belvedere.model.architecture import Palette
from belvedere.model.charts import Builder
from belvedere.model.light import Lamp
from belvedere.model.ornament import ball, lathe
from belvedere.model.plan import HousePlan, RoomPlan
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


def pendant(f: Furnisher, x: float, y: float, drop: float, power: float, grand: bool) -> None:
    """A lamp that hangs from the ceiling: a chandelier if ``grand``, else a shaded one."""
    with f.b.placed(x, y, f.plan.rise(f.room)):
        if grand:
            fixtures.chandelier(f.b, f.m, drop, 6 + 2 * int(f.rng.integers(2)))
            f.lamp(-drop + 0.12, power, 0.42)
        else:
            decor.pendant(f.b, f.m, drop)
            f.lamp(-drop, power, 0.30)


def ceiling(f: Furnisher, power: float = 0.9, count: int = 1) -> None:
    """Bowls under the ceiling, spread along the room's longer side."""
    x0, y0, x1, y1 = f.room.rect
    for k in range(count):
        t = (k + 0.5) / count
        x, y = ((x0 + (x1 - x0) * t, (y0 + y1) / 2) if x1 - x0 > y1 - y0
                else ((x0 + x1) / 2, y0 + (y1 - y0) * t))  # fmt: skip
        with f.b.placed(x, y, f.plan.height):
            fixtures.ceiling_lamp(f.b, f.m)
            f.lamp(-0.16, power, 0.26)


def floor_lamp(f: Furnisher) -> None:
    """A standing lamp in a corner."""
    spot = f.space.against_wall(0.5, 0.5, 1.7, where="corner")
    if spot is not None:
        with f.at(spot, 0.25):
            decor.floor_lamp(f.b, f.m)
            f.lamp(1.50, 0.8, 0.26)


def plant(f: Furnisher, big: bool = False) -> None:
    """A plant in a corner; a small tree if ``big``."""
    size = 0.62 if big else 0.5
    spot = f.space.against_wall(size, size, 0.5, where="corner")
    if spot is not None:
        with f.at(spot, size / 2.0, float(f.rng.uniform(0, 90))):
            if big:
                fixtures.tree(f.b, f.m, f.rng, float(f.rng.uniform(1.5, 1.9)))
            else:
                decor.plant(f.b, f.m, f.rng, float(f.rng.uniform(0.9, 1.4)), 14, fixtures.long_leaf)


def bookcase(f: Furnisher, width: float, height: float = 2.15) -> bool:
    """A bookcase full of books against a wall; whether there was room."""
    spot = f.space.against_wall(width, 0.32, height, 0.3)
    if spot is not None:
        with f.at(spot, 0.31):
            furniture.bookcase(f.b, f.m, f.rng, width, height, 6)
            for x in (-width / 2.0 + 0.011, width / 2.0 - 0.011):
                lathe(f.b, [(0.02, 0.0), (0.022, 0.02), (0.012, 0.03), (0.02, 0.05), (1e-3, 0.075)],
                      f.m["walnut"], 10, (x, 0.02, height))  # fmt: skip
    return spot is not None


def side_table(f: Furnisher, lamp: bool = True) -> None:
    """A small round table with a lamp or with flowers."""
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


def desk_things(f: Furnisher) -> None:
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


def dresser(f: Furnisher) -> None:
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


def console(f: Furnisher) -> None:
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


def picture(f: Furnisher, name: str, width: float, height: float) -> None:
    """One of the painted pictures in a rounded frame, its middle at the origin."""
    wood = f.m[f.pick(("dark", "walnut", "brass", "oak"))]
    x, z = width / 2.0, height / 2.0
    furniture.framed(f.b, f.m, name, width, height, "dark", 0.04 if name == "fern" else 0.0)
    for a, c in (((-x, -z), (x, -z)), ((x, -z), (x, z)), ((x, z), (-x, z)), ((-x, z), (-x, -z))):
        tube(f.b, (a[0], -0.03, a[1]), (c[0], -0.03, c[1]), 0.014, wood, 6)
    for sx in (-1, 1):
        for sz in (-1, 1):
            ball(f.b, (sx * x, -0.03, sz * z), 0.017, wood, 6)
