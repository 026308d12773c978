"""The built-in house: a living room, a kitchen and a hall with a stair, from a seed.

      x=0                          5.2  5.34                9.2
y=7.8  +--------------------------------------------------+
       |  gallery above, desk below  |  stair, climbs <-- |
y=6.85 |. . . . . . . . . . . . . . .|. . . . . . . .     |
       |  hall (double height)      <- - - - walk - - -.  |
y=4.54 +---[ door ]-----------------+------[ door ]----|--+
y=4.4  |                            |                  |  |
       |  living room               |   kitchen        |  |
       |                            |                  '  |
       |  start - - - - - - - - - [ wide opening ] - - '  |
y=0    +--[ window ]--[  window  ]--+---[   window   ]----+
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from belvedere.ground.checks import check_integer
from belvedere.model import architecture as arch
from belvedere.model import decor, furniture
from belvedere.model.architecture import Palette
from belvedere.model.charts import Builder, Rect
from belvedere.model.light import Lamp, LightSettings, bake
from belvedere.model.palette import make_palette
from belvedere.model.photograph import LitModel
from belvedere.model.raycast import RayCaster
from belvedere.model.shapes import box, tube
from belvedere.model.walk import Pose, reference_cameras, walk_keyframes
from belvedere.scene import Camera

EYE_M = 1.6
"""Height of the eye above the floor."""
LOW, HIGH = 2.75, 4.9
"""Ceilings: of the living room and the kitchen, and of the hall."""
GALLERY = 14 * 0.175
"""Height of the gallery's floor: fourteen risers."""

ROOMS: dict[str, Rect] = {
    "living room": (0.0, 0.0, 5.2, 4.4),
    "kitchen": (5.34, 0.0, 9.2, 4.4),
    "hall": (0.0, 4.54, 9.2, 7.8),
}
"""(x0, y0, x1, y1) of each room between its walls, metres."""


@dataclass(frozen=True, eq=False)
class Interior(LitModel):
    """The built-in house, lit and ready to be photographed."""

    seed: int = 0
    """What textures, books and plants were drawn from."""

    def reference_cameras(
        self, count: int = 24, width: int = 640, height: int = 512, fov_deg: float = 74.0
    ) -> tuple[Camera, ...]:
        """Cameras along the walk through the rooms; see `belvedere.model.walk`."""
        return reference_cameras(count, width, height, fov_deg)

    def walk_keyframes(self, count: int = 25) -> list[Pose]:
        """(eye, target) poses of a ten-second walk through all three rooms."""
        return walk_keyframes(count)


def build_interior(seed: int = 0, rays: int = 192, threads: int | None = None) -> Interior:
    """Build and light the house; the same bytes for the same seed, whatever the threads.

    Args:
        seed: changes textures, books, pictures and plants, not the plan.
        rays: gathered per light map point; fewer is quicker and blotchier.
        threads: how many to use; None for as many as there are processors.

    Raises:
        InputError: the seed is not a whole number from 0 to 2**31 - 1; rays not 4 to 4096.
        MissingDependencyError: embreex is not installed.
    """
    seed = check_integer("build_interior", "seed", seed, 0, 2**31 - 1)
    rays = check_integer("build_interior", "rays", rays, 4, 4096)
    b = Builder()
    m = make_palette(b, seed, threads)
    rng = np.random.default_rng([seed, 999])
    _shell(b, m)
    lamps = [*_living_room(b, m, rng), *_kitchen(b, m, rng), *_hall(b, m, rng)]
    mesh, charts = b.finish()
    settings = LightSettings(lamps=tuple(lamps), rays=rays)
    caster = RayCaster(mesh)
    light = bake(mesh, charts, caster, settings, threads)
    interior = Interior(mesh, charts, light, seed)
    interior.__dict__["caster"] = caster  # the cached property, made already
    return interior


def _shell(b: Builder, m: Palette) -> None:
    """Floors, ceilings, walls, windows and doors."""
    out = 0.05
    arch.floor(b, (0, 0, 5.2, 4.4), 0.0, m["planks"], 0.5)
    arch.floor(b, (5.34, 0, 9.2, 4.4), 0.0, m["tiles"], 1.0)
    arch.floor(b, (0, 4.54, 9.2, 7.8), 0.0, m["planks"], 0.5)
    arch.ceiling(b, (-out, -out, 5.2 + out, 4.4 + out), LOW, m["ceiling"])
    arch.ceiling(b, (5.34 - out, -out, 9.2 + out, 4.4 + out), LOW, m["ceiling"])
    arch.ceiling(b, (-out, 4.54 - out, 9.2 + out, 7.8 + out), HIGH, m["ceiling"])
    low, high = (0.0, LOW), (0.0, HIGH)
    south = [(0.75, 0.45, 2.05, 2.35), (2.95, 0.45, 4.55, 2.35)]
    west = [(0.9, 0.85, 2.2, 2.35)]
    hall_doors = [(1.15, 0.0, 2.15, 2.12), (6.5, 0.0, 7.5, 2.12)]
    between = [(1.5, 0.0, 2.95, 2.2)]
    arch.wall(b, "south", 0.0, (0, 5.2), low, m["cream_wall"], south)
    arch.wall(b, "west", 0.0, (0, 4.4), low, m["cream_wall"], west)
    arch.wall(b, "north", 4.4, (0, 5.2), low, m["cream_wall"], hall_doors[:1])
    arch.wall(b, "east", 5.2, (0, 4.4), low, m["cream_wall"], between)
    sunny = [(6.1, 0.95, 8.2, 2.3)]
    east = [(1.3, 1.15, 2.7, 2.25)]
    arch.wall(b, "south", 0.0, (5.34, 9.2), low, m["sage_wall"], sunny)
    arch.wall(b, "west", 5.34, (0, 4.4), low, m["sage_wall"], between)
    arch.wall(b, "north", 4.4, (5.34, 9.2), low, m["sage_wall"], hall_doors[1:])
    arch.wall(b, "east", 9.2, (0, 4.4), low, m["sage_wall"], east)
    tall = [(5.0, 0.5, 6.4, 2.2), (5.0, 2.85, 6.4, 4.3)]
    end = [(5.0, 0.9, 6.3, 2.3), (5.0, 2.9, 6.3, 4.2)]
    upper = [(4.9, 3.1, 6.0, 4.3), (6.7, 3.1, 7.8, 4.3)]
    arch.wall(b, "south", 4.54, (0, 9.2), high, m["white_wall"], hall_doors)
    arch.wall(b, "west", 0.0, (4.54, 7.8), high, m["brick"], tall, 1.0)
    arch.wall(b, "north", 7.8, (0, 9.2), high, m["white_wall"], upper)
    arch.wall(b, "east", 9.2, (4.54, 7.8), high, m["white_wall"], end)
    windows: list[tuple[arch.Side, float, list[Rect], tuple[int, int]]] = [
        ("south", 0.0, south[:1], (2, 3)), ("south", 0.0, south[1:], (4, 3)),
        ("west", 0.0, west, (2, 3)), ("south", 0.0, sunny, (4, 2)), ("east", 9.2, east, (2, 2)),
        ("west", 0.0, tall, (2, 3)), ("east", 9.2, end, (2, 2)), ("north", 7.8, upper, (2, 2)),
    ]  # fmt: skip
    for side, at, holes, panes in windows:
        for hole in holes:
            arch.window(b, m, side, at, hole, panes)
    for hole in hall_doors:
        arch.doorway(b, m, "x", (4.4, 4.54), (hole[0], hole[2]), hole[3])
    arch.doorway(b, m, "y", (5.2, 5.34), (1.5, 2.95), 2.2)
    _skirtings(b, m)


def _skirtings(b: Builder, m: Palette) -> None:
    first, second, wide = (1.06, 2.24), (6.41, 7.59), (1.41, 3.04)
    arch.skirting(b, m, "south", 0.0, (0, 5.2))
    arch.skirting(b, m, "west", 0.0, (0, 4.4))
    arch.skirting(b, m, "north", 4.4, (0, 5.2), [first])
    arch.skirting(b, m, "east", 5.2, (0, 4.4), [wide])
    arch.skirting(b, m, "south", 0.0, (5.34, 9.2))
    arch.skirting(b, m, "west", 5.34, (0, 4.4), [wide])
    arch.skirting(b, m, "north", 4.4, (5.34, 9.2), [second])
    arch.skirting(b, m, "south", 4.54, (0, 9.2), [first, second])
    arch.skirting(b, m, "west", 0.0, (4.54, 7.8))
    arch.skirting(b, m, "north", 7.8, (0, 9.2))
    arch.skirting(b, m, "east", 9.2, (4.54, 7.8))


def _lamp(b: Builder, height: float, power: float, shade: float) -> Lamp:
    x, y, z = (float(c) for c in b.to_world((0.0, 0.0, height)))
    return Lamp((x, y, z), (power, power * 0.70, power * 0.40), 0.07, shade)


def _living_room(b: Builder, m: Palette, rng: np.random.Generator) -> list[Lamp]:
    lamps = []
    with b.placed(3.5, 2.95):
        decor.rug(b, m["rug"], m["rug_edge"], 2.7, 1.8)
    with b.placed(3.62, 3.9):
        furniture.sofa(b, m, 2.1)
        for x, name in ((-0.72, "pillow_a"), (0.68, "pillow_b")):
            with b.placed(x, 0.10, 0.47, 12.0 if x < 0 else -14.0):
                furniture.pillow(b, m[name])
    with b.placed(3.5, 2.85, 0.012):
        furniture.table(b, m["walnut"], m["dark"], (1.1, 0.55), 0.40)
        with b.placed(-0.28, 0.05, 0.40, 12.0):
            box(b, (-0.13, -0.1, 0.0), (0.13, 0.1, 0.028), m["book1"])
            box(b, (-0.11, -0.085, 0.028), (0.12, 0.08, 0.05), m["book6"])
        with b.placed(0.26, 0.0, 0.40):
            decor.bouquet(b, m, rng, 0.20)
    with b.placed(4.55, 0.75, 0.0, -35.0 + 180.0):
        furniture.sofa(b, m, 0.86, "armchair")
    with b.placed(2.5, 0.35):
        furniture.table(b, m["oak"], m["dark"], (0.44, 0.44), 0.52, 0.02)
        with b.placed(0.0, 0.0, 0.52):
            furniture.desk_lamp(b, m)
            lamps.append(_lamp(b, 0.41, 0.35, 0.19))
    with b.placed(4.94, 4.1):
        decor.floor_lamp(b, m)
        lamps.append(_lamp(b, 1.50, 0.85, 0.26))
    with b.placed(0.0, 3.3, 0.0, 90.0), b.placed(0.0, -0.30):
        furniture.bookcase(b, m, rng, 1.7, 2.1, 6)
    with b.placed(0.5, 0.5):
        decor.plant(b, m, rng, 1.35, 15)
    for x, width, picture in ((3.62, 0.96, "seascape"),):
        with b.placed(x, 4.4, 1.62):
            furniture.framed(b, m, picture, width, width * 2 / 3, "brass")
    with b.placed(2.62, 4.4, 1.55):
        furniture.framed(b, m, "fern", 0.32, 0.46, "dark", 0.03)
    with b.placed(5.2, 3.75, 1.6, -90.0):
        furniture.framed(b, m, "orchard", 0.52, 0.65, "walnut", 0.0)
    for at, width in ((1.4, 1.3), (3.75, 1.6)):
        with b.placed(at, 0.09, 2.50):
            decor.curtain_rod(b, m, width + 0.75)
        for sign in (-1, 1):
            with b.placed(at + sign * (width / 2 + 0.13), 0.09):
                decor.curtain(b, m, 0.30, 2.48, 4)
    return lamps


def _kitchen(b: Builder, m: Palette, rng: np.random.Generator) -> list[Lamp]:
    lamps = []
    with b.placed(7.05, 1.12):
        furniture.table(b, m["oak"], m["oak"], (1.5, 0.85), 0.75, 0.032)
        with b.placed(0.05, 0.02, 0.75):
            decor.fruit_bowl(b, m, rng)
        for x, y, yaw in ((-0.42, -0.24, 0.0), (0.42, -0.24, 0.0), (-0.42, 0.24, 180.0),
                          (0.42, 0.24, 180.0)):  # fmt: skip
            with b.placed(x, y, 0.75, yaw):
                decor.crockery(b, m)
        for x, y, yaw in ((-0.40, -0.56, 180.0), (0.40, -0.56, 186.0), (-0.40, 0.58, 4.0),
                          (0.42, 0.62, -10.0)):  # fmt: skip
            with b.placed(x, y, 0.0, yaw):
                furniture.chair(b, m)
        with b.placed(0.0, 0.0, LOW):
            decor.pendant(b, m, 1.02)
            lamps.append(_lamp(b, -1.02, 0.8, 0.30))
    with b.placed(9.2, 2.2, 0.0, -90.0):
        furniture.cabinet(b, m, 4.2, 0.92, 0.60, 7, "cupboard", "marble")
        box(b, (-2.2, -0.008, 0.92), (2.2, 0.0, 1.10), m["subway"], 1.6, "+y")
        for x in (-1.25, 1.55):
            with b.placed(x, 0.0, 1.48):
                furniture.shelf(b, m, 0.95)
                for k in range(5):
                    with b.placed(-0.36 + 0.18 * k, -0.11):
                        decor.vase(b, m, ("celadon", "porcelain", "glaze", "terracotta")[k % 4],
                                   0.12 + 0.035 * ((k * 3) % 5))  # fmt: skip
            with b.placed(x, 0.0, 1.86):
                furniture.shelf(b, m, 0.95)
                for k in range(4):
                    with b.placed(-0.3 + 0.2 * k, -0.11):
                        decor.pot(b, m, 0.055, 0.10 + 0.03 * (k % 3),
                                  ("porcelain", "glaze", "celadon")[k % 3])  # fmt: skip
        with b.placed(-0.2, -0.30, 0.92):
            decor.vase(b, m, "glaze", 0.30)
        with b.placed(1.4, -0.32, 0.92, 20.0):
            box(b, (-0.2, -0.13, 0.0), (0.2, 0.13, 0.025), m["walnut"], 1.5)
        with b.placed(-1.5, -0.30, 0.92):
            for k in range(3):
                with b.placed(0.16 * k, 0.0):
                    decor.pot(b, m, 0.06, 0.16 - 0.03 * k, "porcelain")
    with b.placed(5.34, 3.75, 1.55, 90.0):
        furniture.framed(b, m, "rings", 0.6, 0.6, "dark")
    with b.placed(5.34, 0.75, 1.55, 90.0):
        furniture.framed(b, m, "fern", 0.42, 0.62, "oak", 0.04)
    with b.placed(5.84, 3.9):
        decor.plant(b, m, rng, 1.1, 11)
    with b.placed(7.15, 0.0, 0.95):
        for x in (-0.7, 0.75):
            with b.placed(x, -0.06):
                decor.pot(b, m, 0.06, 0.11)
    return lamps


def _hall(b: Builder, m: Palette, rng: np.random.Generator) -> list[Lamp]:
    lamps = []
    arch.stair(b, m, (7.9, 6.85), 0.95, 14, 0.175, 0.26)
    top = 7.9 - 13 * 0.26
    box(b, (0.0, 6.85, GALLERY - 0.14), (top, 7.8, GALLERY - 0.03), m["trim"], 0.5, "-x +y")
    box(b, (0.0, 6.82, GALLERY - 0.03), (top, 7.8, GALLERY), m["oak"], 0.6, "-x +y")
    arch.railing(b, m, (0.06, 6.895), (top - 0.06, 6.895), GALLERY)
    for x in (2.0, top - 0.05):
        box(b, (x - 0.05, 6.86, 0.0), (x + 0.05, 6.96, GALLERY - 0.14), m["oak"], 0.8, "-z +z")
    for x in (1.5, 3.6, 5.7, 7.8):
        box(b, (x - 0.07, 4.54, HIGH - 0.2), (x + 0.07, 7.8, HIGH), m["walnut"], 0.7, "-y +y +z")
    with b.placed(4.3, 5.72):
        decor.rug(b, m["kilim"], m["rug_edge"], 4.4, 1.05)
    with b.placed(3.9, 4.54, 0.0, 180.0), b.placed(0.0, -0.2):
        furniture.table(b, m["walnut"], m["dark"], (1.3, 0.34), 0.80, 0.018)
        with b.placed(0.45, 0.0, 0.80):
            furniture.desk_lamp(b, m)
            lamps.append(_lamp(b, 0.41, 0.4, 0.19))
        with b.placed(-0.42, 0.0, 0.80):
            decor.bouquet(b, m, rng, 0.26)
    with b.placed(3.9, 4.54, 1.75, 180.0):
        furniture.framed(b, m, "composition", 0.72, 0.72, "iron")
    with b.placed(2.75, 4.54, 1.6, 180.0):
        furniture.framed(b, m, "orchard", 0.4, 0.5, "brass")
    with b.placed(5.5, 4.54, 1.65, 180.0):
        furniture.framed(b, m, "rings", 0.66, 0.66, "walnut")
    with b.placed(2.2, 7.8, 3.75):
        furniture.framed(b, m, "seascape", 1.2, 0.8, "brass")
    with b.placed(0.85, 7.46):
        furniture.table(b, m["oak"], m["dark"], (1.3, 0.6), 0.74, 0.022)
        with b.placed(-0.45, 0.1, 0.74):
            furniture.desk_lamp(b, m)
            lamps.append(_lamp(b, 0.41, 0.45, 0.19))
        box(b, (0.0, -0.14, 0.74), (0.22, 0.16, 0.742), m["paper"], 1.0, "-z")
        box(b, (0.34, -0.1, 0.74), (0.52, 0.14, 0.775), m["book0"])
    with b.placed(0.9, 6.95, 0.0, 176.0):
        furniture.chair(b, m)
    with b.placed(2.95, 7.49):
        furniture.bookcase(b, m, rng, 1.6, 2.1, 6)
    with b.placed(0.52, 5.06):
        decor.plant(b, m, rng, 1.7, 17)
    with b.placed(8.66, 7.25):
        decor.plant(b, m, rng, 1.5, 15)
    with b.placed(4.6, 6.2, HIGH):
        decor.pendant(b, m, 1.7)
        lamps.append(_lamp(b, -1.7, 1.1, 0.30))
    with b.placed(8.9, 5.0):
        tube(b, (0, 0, 0.0), (0, 0, 1.75), 0.016, m["dark"], 8)
        for k in range(4):
            a = k * np.pi / 2.0
            tube(b, (0, 0, 0.18), (0.2 * np.cos(a), 0.2 * np.sin(a), 0.0), 0.012, m["dark"], 6)
            tube(b, (0, 0, 1.6), (0.13 * np.cos(a), 0.13 * np.sin(a), 1.72), 0.008, m["dark"], 6)
    return lamps
