"""Rooms to cook, wash and sleep in."""

from __future__ import annotations

from belvedere.model import decor, fixtures, furniture, pieces
from belvedere.model.furnisher import (
    GLAZES,
    Furnisher,
    bookcase,
    ceiling,
    dresser,
    floor_lamp,
    pendant,
    plant,
    side_table,
)
from belvedere.model.ornament import ball
from belvedere.model.shapes import box, tube
from belvedere.model.space import Spot


def kitchen(f: Furnisher) -> None:
    """A worktop, a stove with pans above it, a dresser, a table in the middle."""
    run = None
    for width in (3.6, 3.0, 2.4, 1.8):
        run = f.space.against_wall(width, 0.64, 0.92, 0.5, "middle")
        if run is not None:
            worktop(f, run, width)
            break
    spot = f.space.against_wall(0.95, 0.66, 1.0, 0.5)
    if spot is not None:
        with f.at(spot):
            fixtures.stove(f.b, f.m, f.rng)
        with f.b.placed(spot.x, spot.y, 1.85, spot.yaw):
            _pan_rail(f)
    dresser(f)
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
        pendant(f, middle.x, middle.y, 0.85, 0.8, False)
    plant(f)
    ceiling(f, 0.7)


def worktop(f: Furnisher, spot: Spot, width: float) -> None:
    """Cupboards with a sink, jars and a board on them."""
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


def bedroom(f: Furnisher, rug: bool = True) -> None:
    """A bed, small tables, a wardrobe, a chest with a mirror."""
    width = 1.6 if f.room.kind != "guest" else 1.0
    spot = f.space.against_wall(width + 0.2, 2.15, 1.2, 0.0, "middle") or f.space.against_wall(
        1.15, 2.15, 1.2
    )
    if spot is not None:
        with f.at(spot):
            pieces.bed(f.b, f.m, min(width, 1.6), f.pick(("quilt_a", "quilt_b", "sofa")))
    for _ in range(2):
        side_table(f)
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
    plant(f)
    ceiling(f, 0.8)


def chamber(f: Furnisher) -> None:
    """A large bedroom to sit in, too."""
    bedroom(f, False)
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
        pendant(f, middle.x, middle.y, 0.7, 0.8, False)
    bookcase(f, 1.7)
    floor_lamp(f)
    plant(f, True)


def bath(f: Furnisher) -> None:
    """A tub, a basin under a mirror, a closet, towels."""
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
    ceiling(f, 0.8)


def nursery(f: Furnisher) -> None:
    """A child's bed, toys on a rug, low shelves."""
    spot = f.space.against_wall(1.4, 0.75, 0.6, 0.4)
    if spot is not None:
        with f.at(spot):
            pieces.cradle(f.b, f.m)
    bookcase(f, 1.2, 1.5)
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
    plant(f)
    ceiling(f, 0.9)


def store(f: Furnisher) -> None:
    """Shelves of jars, a washing machine, a basin."""
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
    ceiling(f, 0.7)


def dressing(f: Furnisher) -> None:
    """Wardrobes and a tall mirror."""
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
    ceiling(f, 0.8)
