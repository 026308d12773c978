"""Rooms to receive people in, and the ways between rooms."""

from __future__ import annotations

import numpy as np

from belvedere.model import decor, fixtures, furniture, pieces
from belvedere.model.furnisher import (
    Furnisher,
    bookcase,
    ceiling,
    console,
    desk_things,
    dresser,
    floor_lamp,
    pendant,
    picture,
    plant,
    side_table,
)
from belvedere.model.ornament import lathe, ring
from belvedere.model.plan import SLAB
from belvedere.model.private_rooms import worktop
from belvedere.model.space import Spot


def living(f: Furnisher) -> None:
    """A sofa, armchairs, a low table on a rug, books, plants."""
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
    bookcase(f, 1.7)
    floor_lamp(f)
    side_table(f)
    plant(f, True)
    plant(f)
    side_table(f, False)
    x0, y0, x1, y1 = f.room.rect
    pendant(f, (x0 + x1) / 2, (y0 + y1) / 2, 0.75, 0.8, True)


def library(f: Furnisher) -> None:
    """Bookcases on all walls, a table to read at, a globe."""
    for width in (2.0, 1.8, 1.7, 1.5, 1.4, 1.2):
        bookcase(f, width, 2.3)
    middle = f.space.inside(1.5, 0.85, 0.8)
    if middle is not None:
        with f.at(middle):
            decor.rug(f.b, f.m["rug"], f.m["rug_edge"], 2.4, 1.6)
            pieces.table(f.b, f.m["walnut"], f.m["walnut"], 1.4, 0.75, 0.75, 0.042)
            desk_things(f)
    spot = f.space.against_wall(0.6, 0.6, 0.7)
    if spot is not None:
        with f.at(spot, 0.32):
            pieces.globe(f.b, f.m)
    spot = f.space.against_wall(0.95, 0.98, 0.7, 0.3)
    if spot is not None:
        with f.at(spot, 0.52):
            furniture.sofa(f.b, f.m, 0.88, "sofa")
    floor_lamp(f)
    x0, y0, x1, y1 = f.room.rect
    pendant(f, (x0 + x1) / 2, (y0 + y1) / 2, 0.72, 0.8, True)


def dining(f: Furnisher) -> None:
    """A laid table under a chandelier, chairs round it, a sideboard, a clock."""
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
        pendant(f, middle.x, middle.y, 0.95, 0.9, True)
    dresser(f)
    spot = f.space.against_wall(0.62, 0.34, 2.1, 0.3)
    if spot is not None:
        with f.at(spot):
            pieces.clock(f.b, f.m)
    plant(f, True)


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


def music(f: Furnisher) -> None:
    """A piano, a sofa, chairs to listen on."""
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
    floor_lamp(f)
    plant(f, True)
    plant(f)
    x0, y0, x1, y1 = f.room.rect
    pendant(f, (x0 + x1) / 2, (y0 + y1) / 2, 0.75, 0.9, True)


def study(f: Furnisher) -> None:
    """A desk by the wall, bookcases, a globe."""
    spot = f.space.against_wall(1.5, 1.15, 0.78, 0.0, "middle")
    if spot is not None:
        with f.at(spot, 0.40):
            pieces.table(f.b, f.m["oak"], f.m["dark"], 1.4, 0.70, 0.75, 0.04)
            desk_things(f)
            with f.b.placed(0.1, -0.52, 0.0, 184.0):
                pieces.chair(f.b, f.m)
    for width in (1.6, 1.2, 1.0):
        bookcase(f, width, 2.1)
    spot = f.space.against_wall(0.6, 0.6, 0.7)
    if spot is not None:
        with f.at(spot, 0.32):
            pieces.globe(f.b, f.m)
    floor_lamp(f)
    plant(f)
    ceiling(f, 0.7)


def conservatory(f: Furnisher) -> None:
    """A round table among plants."""
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
        pendant(f, middle.x, middle.y, 0.9, 0.7, False)
    for k in range(7):
        plant(f, k % 2 == 0)


def corridor(f: Furnisher) -> None:
    """A runner, narrow tables, lamps under the ceiling."""
    x0, y0, x1, y1 = f.room.rect
    long = max(x1 - x0, y1 - y0)
    console(f)
    if long > 6.0:
        console(f)
    with f.at(Spot((x0 + x1) / 2, (y0 + y1) / 2, 0.0 if x1 - x0 > y1 - y0 else 90.0)):
        decor.rug(f.b, f.m["kilim"], f.m["rug_edge"], min(long - 1.2, 4.6), 0.95)
    ceiling(f, 0.65, max(int(long / 3.4), 1))


def hall(f: Furnisher) -> None:
    """A clock, chairs, umbrellas; in a hall with a gallery also lamps and pictures above."""
    console(f)
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
    plant(f, True)
    x0, y0, x1, y1 = f.room.rect
    void = f.plan.void() if f.plan.stair and f.plan.stair.room == f.room.name else None
    if void is None:
        pendant(f, (x0 + x1) / 2, (y0 + y1) / 2, 0.52, 0.9, True)
        return
    xg, yg, _, _ = void
    pendant(f, (xg + x1) / 2, yg + 0.9, 2.3, 1.6, True)
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
            picture(f, name, width, height)
    with f.b.placed(x0 + 4.6, y0, upper + 1.6, 180.0):
        picture(f, "seascape", 0.9, 0.6)


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


def flat(f: Furnisher) -> None:
    """Living and cooking in one room."""
    run = f.space.against_wall(2.4, 0.64, 0.92, 0.5, "corner")
    if run is not None:
        worktop(f, run, 2.4)
    spot = f.space.against_wall(0.95, 0.66, 1.0, 0.5)
    if spot is not None:
        with f.at(spot):
            fixtures.stove(f.b, f.m, f.rng)
    living(f)
