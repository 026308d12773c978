"""Furniture, each piece around its own origin on the floor, its front towards -y."""

from __future__ import annotations

import numpy as np

from belvedere.model.architecture import Palette
from belvedere.model.charts import Builder
from belvedere.model.ornament import lathe
from belvedere.model.shapes import box, cushion, panel, tube


def sofa(b: Builder, m: Palette, width: float = 2.1, cloth: str = "sofa") -> None:
    """A sofa on short tapered legs; ``width`` 0.85 makes it an armchair."""
    half, depth = width / 2.0, 0.88
    fabric = m[cloth]
    for x in (-half + 0.1, half - 0.1):
        for y in (-depth / 2 + 0.1, depth / 2 - 0.1):
            tube(b, (x, y, 0.0), (x, y, 0.15), (0.016, 0.026), m["dark"], 8)
    cushion(b, (-half, -depth / 2 + 0.03, 0.14), (half, depth / 2, 0.30), fabric, 0.03)
    for sign in (-1, 1):
        x0, x1 = sorted((sign * half, sign * (half - 0.17)))
        cushion(b, (x0, -depth / 2, 0.14), (x1, depth / 2, 0.62), fabric, 0.07)
    seats = max(int(width / 0.75), 1)
    room = (width - 0.36) / seats
    for k in range(seats):
        x = -half + 0.18 + k * room
        cushion(b, (x, -depth / 2 - 0.01, 0.29), (x + room - 0.01, 0.22, 0.45), fabric, 0.055,
                bulge=0.02)  # fmt: skip
        with b.placed(x + room / 2, 0.27, 0.44, 0.0, -10.0):
            cushion(b, (-room / 2, -0.09, 0.0), (room / 2 - 0.01, 0.09, 0.42), fabric, 0.08,
                    bulge=0.02)  # fmt: skip
    cushion(b, (-half + 0.1, 0.28, 0.14), (half - 0.1, depth / 2, 0.78), fabric, 0.07)


def pillow(b: Builder, material: int, size: float = 0.42) -> None:
    """A loose cushion leaning back."""
    with b.placed(0.0, 0.0, 0.0, 0.0, -22.0):
        cushion(b, (-size / 2, -0.05, 0.0), (size / 2, 0.05, size), material, 0.045, 5.0, 0.035)


def table(
    b: Builder, top: int, leg: int, size: tuple[float, float], height: float, taper: float = 0.024
) -> None:
    """A table with an apron and four thin legs."""
    x, y = size[0] / 2.0, size[1] / 2.0
    box(b, (-x, -y, height - 0.03), (x, y, height), top, 0.8)
    box(b, (-x + 0.07, -y + 0.07, height - 0.11), (x - 0.07, y - 0.07, height - 0.03), leg, 1.0,
        "+z")  # fmt: skip
    for sx in (-1, 1):
        for sy in (-1, 1):
            start = (sx * (x - 0.05), sy * (y - 0.05), 0.0)
            end = (sx * (x - 0.085), sy * (y - 0.085), height - 0.03)
            tube(b, start, end, (taper * 0.6, taper), leg, 8)


def chair(b: Builder, m: Palette) -> None:
    """A chair of thin sticks: tapered legs, stretchers, a back of six spindles. Faces -y."""
    seat = m["oak"]
    cushion(b, (-0.21, -0.21, 0.43), (0.21, 0.21, 0.465), seat, 0.016, 1.5)
    for sx in (-1, 1):
        for sy in (-1, 1):
            tube(b, (sx * 0.20, sy * 0.20, 0.0), (sx * 0.155, sy * 0.155, 0.44), (0.010, 0.016),
                 m["dark"], 6)  # fmt: skip
        tube(b, (sx * 0.182, -0.182, 0.17), (sx * 0.182, 0.182, 0.17), 0.008, m["dark"], 6)
        tube(b, (sx * 0.185, 0.185, 0.44), (sx * 0.205, 0.25, 0.90), (0.013, 0.010), m["dark"], 6)
    tube(b, (-0.182, 0.0, 0.17), (0.182, 0.0, 0.17), 0.008, m["dark"], 6)
    for k in range(6):
        x = -0.13 + 0.052 * k
        tube(b, (x, 0.18, 0.45), (x * 1.14, 0.248, 0.87), 0.0055, m["dark"], 5)
    with b.placed(0.0, 0.25, 0.865, 0.0, -8.0):
        cushion(b, (-0.225, -0.011, 0.0), (0.225, 0.011, 0.07), m["dark"], 0.010, 1.5)


def bookcase(
    b: Builder,
    m: Palette,
    rng: np.random.Generator,
    width: float,
    height: float,
    shelves: int,
    depth: float = 0.30,
) -> None:
    """An open bookcase full of books, with a gap or an ornament here and there."""
    half, t = width / 2.0, 0.022
    w = m["walnut"]
    box(b, (-half, 0.0, 0.0), (-half + t, depth, height), w)
    box(b, (half - t, 0.0, 0.0), (half, depth, height), w)
    box(b, (-half + t, depth - 0.012, 0.0), (half - t, depth, height), w)
    step = (height - 0.09) / shelves
    for k in range(shelves + 1):
        z = 0.07 + k * step
        box(b, (-half + t, 0.0, z - t), (half - t, depth - 0.012, z), w)
        if k < shelves:
            _books(b, m, rng, -half + t + 0.004, half - t - 0.004, z, step - t - 0.02, depth)
    box(b, (-half + t, 0.02, 0.0), (half - t, 0.03, 0.05), w)


def _books(
    b: Builder,
    m: Palette,
    rng: np.random.Generator,
    x: float,
    end: float,
    z: float,
    room: float,
    depth: float,
) -> None:
    """A row of books from ``x`` to ``end``, standing at ``z`` with ``room`` above."""
    while True:
        if rng.random() < 0.04:
            x += rng.uniform(0.05, 0.16)
        thick = float(rng.uniform(0.018, 0.048))
        if x + thick > end:
            return
        tall = float(min(rng.uniform(0.60, 0.98) * 0.30, room))
        front = float(rng.uniform(0.025, 0.07))
        back = min(front + tall * 0.72, depth - 0.015)
        low, high = (x, front, z), (x + thick - 0.0015, back, z + tall)
        box(b, low, high, m[f"book{rng.integers(8)}"], 1.0, "-y -z +y +z")
        box(b, low, high, m["paper"], 1.0, "-x +x -y -z +y")
        corners = np.array([[[x, front, z], [high[0], front, z], [high[0], front, high[2]],
                             [x, front, high[2]]]])  # fmt: skip
        spine = int(rng.integers(32))
        u0, u1 = (spine + 0.04) / 32.0, (spine + 0.96) / 32.0
        b.patches(corners, m["spines"], np.array([[[u0, 1], [u1, 1], [u1, 0], [u0, 0]]]))
        x += thick


def cabinet(
    b: Builder, m: Palette, width: float, height: float, depth: float, doors: int, base: str,
    top: str = "",
) -> None:  # fmt: skip
    """A cupboard with panelled doors and thin handles; its back lies at y = 0, front at -depth."""
    half = width / 2.0
    over = 0.035 if top else 0.0
    box(b, (-half, -depth, 0.08), (half, 0.0, height - over), m[base])
    box(b, (-half + 0.01, -depth + 0.05, 0.0), (half - 0.01, 0.0, 0.08), m["dark"], 1.0, "-z +z")
    room = width / doors
    for k in range(doors):
        x0, x1 = -half + k * room + 0.006, -half + (k + 1) * room - 0.006
        z0, z1 = 0.10, height - over - 0.02
        box(b, (x0, -depth - 0.018, z0), (x1, -depth, z1), m[base], 1.0, "+y")
        for a, c, low, high in ((x0, x0 + 0.06, z0, z1), (x1 - 0.06, x1, z0, z1),
                                (x0 + 0.06, x1 - 0.06, z0, z0 + 0.06),
                                (x0 + 0.06, x1 - 0.06, z1 - 0.06, z1)):  # fmt: skip
            box(b, (a, -depth - 0.028, low), (c, -depth - 0.018, high), m[base], 1.0, "+y")
        grip = x1 - 0.03 if k % 2 == 0 else x0 + 0.03
        z = z1 - 0.22 if height < 1.2 else z0 + 0.1
        tube(b, (grip, -depth - 0.045, z), (grip, -depth - 0.045, z + 0.14), 0.006, m["brass"], 6)
    if top:
        box(b, (-half, -depth - 0.03, height - over), (half, 0.0, height), m[top], 0.9)


def shelf(b: Builder, m: Palette, width: float, depth: float = 0.22) -> None:
    """A board on two brackets; its back lies at y = 0, its top at z = 0."""
    box(b, (-width / 2, -depth, -0.028), (width / 2, 0.0, 0.0), m["oak"])
    for x in (-width / 2 + 0.15, width / 2 - 0.15):
        box(b, (x - 0.012, -depth * 0.8, -0.045), (x + 0.012, 0.0, -0.028), m["iron"])
        box(b, (x - 0.012, -0.016, -0.2), (x + 0.012, 0.0, -0.045), m["iron"])


def desk_lamp(b: Builder, m: Palette) -> None:
    """A brass table lamp with a cloth shade; the bulb hangs at z = 0.40."""
    lathe(b, [(0.085, 0.0), (0.085, 0.012), (0.05, 0.028), (0.0, 0.03)], m["brass"], 16,
          crisp=False)  # fmt: skip
    lathe(b, [(0.02, 0.02), (0.045, 0.08), (0.055, 0.13), (0.03, 0.20), (0.010, 0.24),
              (0.010, 0.34)], m["glaze"], 14, crisp=False)  # fmt: skip
    shade(b, m, 0.30, 0.52, 0.16, 0.10)


def shade(
    b: Builder, m: Palette, z0: float, z1: float, r0: float, r1: float, sides: int = 20
) -> None:
    """A glowing cloth lampshade, open above and below."""
    lathe(b, [(r0, z0), (r1, z1)], m["shade"], sides, scale=2.0, crisp=False)
    lathe(b, [(r1 - 0.004, z1), (r0 - 0.004, z0)], m["shade_inside"], sides, scale=2.0, crisp=False)


def framed(
    b: Builder, m: Palette, picture: str, width: float, height: float, frame: str = "dark",
    mount: float = 0.0,
) -> None:  # fmt: skip
    """A picture in a frame, its back at y = 0, its middle at the origin."""
    x, z, edge = width / 2.0, height / 2.0, 0.028
    for low, high in (
        ((-x - edge, -0.03, -z - edge), (-x, 0.0, z + edge)),
        ((x, -0.03, -z - edge), (x + edge, 0.0, z + edge)),
        ((-x, -0.03, -z - edge), (x, 0.0, -z)),
        ((-x, -0.03, z), (x, 0.0, z + edge)),
    ):
        box(b, low, high, m[frame], 1.0, "+y")
    if mount:
        panel(b, (-x, -0.012, -z), (x, 0.0, z), "-y", m["paper"])
    panel(b, (-x + mount, -0.014, -z + mount), (x - mount, 0.0, z - mount), "-y", m[picture])
