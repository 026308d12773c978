"""Turned and upholstered furniture, each piece round its own origin on the floor, front to -y.

What stands in a room lies round its middle; what stands against a wall has its back at y = 0.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from belvedere.model.architecture import Palette
from belvedere.model.charts import Builder
from belvedere.model.ornament import ball, bar, lathe, ring
from belvedere.model.shapes import box, cushion, panel, tube

_LEG = (
    (0.46, 0.0), (0.62, 0.012), (0.70, 0.035), (0.60, 0.06), (0.42, 0.075), (0.50, 0.16),
    (0.62, 0.36), (0.72, 0.52), (0.60, 0.60), (0.46, 0.625), (0.74, 0.64), (0.86, 0.662),
    (0.74, 0.684), (0.48, 0.70), (0.52, 0.715), (0.80, 0.745), (0.96, 0.79), (0.84, 0.84),
    (0.60, 0.865), (0.56, 0.88), (0.78, 0.892), (0.78, 0.905), (0.62, 0.915), (0.62, 1.0),
)  # fmt: skip
"""(radius, height) of a turned leg, in shares of its greatest radius and its height."""


def leg(
    b: Builder, x: float, y: float, height: float, radius: float, material: int, z: float = 0.0,
    sides: int = 6,
) -> None:  # fmt: skip
    """A turned leg with a vase, beads and a square block on top."""
    lathe(b, [(r * radius, h * height) for r, h in _LEG], material, sides, (x, y, z), 2.0)
    s = radius * 0.9
    low, high = (x - s, y - s, z + height * 0.90), (x + s, y + s, z + height)
    box(b, low, high, material, 1.5, "+z")


def table(
    b: Builder, top: int, wood: int, width: float, depth: float, height: float = 0.75,
    radius: float = 0.04,
) -> None:  # fmt: skip
    """A table on four turned legs, its board with a rounded edge."""
    x, y = width / 2.0, depth / 2.0
    cushion(b, (-x, -y, height - 0.035), (x, y, height), top, 0.016, 0.8)
    inset = radius + 0.05
    apron = (-x + inset, -y + inset, height - 0.13), (x - inset, y - inset, height - 0.034)
    box(b, *apron, wood, 1.0, "+z")
    for sx in (-1, 1):
        for sy in (-1, 1):
            leg(b, sx * (x - inset), sy * (y - inset), height - 0.034, radius, wood)


def round_table(b: Builder, top: int, wood: int, radius: float, height: float = 0.74) -> None:
    """A round table on a turned column with three scrolled feet."""
    h = height
    lathe(b, [(radius * 0.6, h - 0.035), (radius - 0.012, h - 0.035), (radius, h - 0.024),
              (radius, h - 0.012), (radius - 0.012, h), (1e-3, h)], top, 12)  # fmt: skip
    f = h / 0.74
    column = ((0.05, 0.20), (0.075, 0.24), (0.085, 0.30), (0.06, 0.36), (0.035, 0.42), (0.04, 0.46),
              (0.03, 0.50), (0.035, 0.60), (0.05, 0.64), (0.03, 0.66), (0.06, 0.68),
              (0.12, 0.704))  # fmt: skip
    lathe(b, [(r, z * f) for r, z in column], wood, 8)
    for k in range(3):
        a = k * 2.0 * np.pi / 3.0 + 0.5
        x, y = np.cos(a), np.sin(a)
        path = [(0.03, 0.27), (0.12, 0.28), (0.21, 0.22), (0.28, 0.11), (0.34, 0.035), (0.40, 0.03)]
        reach = min(radius * 1.8, 1.0)
        line = [(r * x * reach, r * y * reach, z * f) for r, z in path]
        bar(b, line, [0.035, 0.034, 0.032, 0.028, 0.026, 0.03], wood, 8)


def chair(b: Builder, m: Palette, wood: str = "oak", cloth: str = "linen") -> None:
    """A dining chair: turned front legs, bent back posts, an upholstered seat. Faces -y."""
    w = m[wood]
    cushion(b, (-0.22, -0.22, 0.42), (0.22, 0.21, 0.475), m[cloth], 0.025, 5.0, 0.012)
    box(b, (-0.21, -0.21, 0.36), (0.21, 0.20, 0.425), w, 1.0, "+z")
    for sx in (-1, 1):
        leg(b, sx * 0.19, -0.19, 0.38, 0.024, w)
        bar(b, [(sx * 0.19, 0.25, 0.0), (sx * 0.19, 0.20, 0.22), (sx * 0.19, 0.185, 0.44),
                (sx * 0.188, 0.205, 0.66), (sx * 0.185, 0.255, 0.86), (sx * 0.18, 0.30, 1.0)],
            [0.014, 0.018, 0.02, 0.018, 0.016, 0.013], w, 6)  # fmt: skip
        ball(b, (sx * 0.18, 0.30, 1.01), 0.018, w)
        tube(b, (sx * 0.19, -0.18, 0.16), (sx * 0.19, 0.21, 0.16), 0.010, w, 6)
    tube(b, (-0.19, 0.0, 0.16), (0.19, 0.0, 0.16), 0.010, w, 6)
    for z, rise, y in ((0.93, 0.04, 0.275), (0.60, 0.025, 0.197)):
        bar(b, [(-0.185, y, z), (-0.09, y + 0.018, z + rise), (0.0, y + 0.024, z + rise * 1.3),
                (0.09, y + 0.018, z + rise), (0.185, y, z)], 0.016, w, 6)  # fmt: skip
    for k in range(5):
        x = -0.12 + 0.06 * k
        bar(b, [(x, 0.212, 0.62), (x * 1.05, 0.245, 0.78), (x * 1.1, 0.29, 0.95)],
            [0.007, 0.011, 0.007], w, 6)  # fmt: skip


def stool(b: Builder, m: Palette, height: float = 0.46, cloth: str = "armchair") -> None:
    """A round upholstered stool on four splayed legs."""
    h = height
    lathe(b, [(0.13, h - 0.08), (0.165, h - 0.075), (0.18, h - 0.05), (0.175, h - 0.02),
              (0.12, h), (1e-3, h + 0.008)], m[cloth], 10, scale=5.0)  # fmt: skip
    for k in range(4):
        a = (k + 0.5) * np.pi / 2.0
        x, y = np.cos(a), np.sin(a)
        tube(b, (x * 0.20, y * 0.20, 0.0), (x * 0.12, y * 0.12, h - 0.07), (0.012, 0.02),
             m["dark"], 8)  # fmt: skip
    ring(b, (0.0, 0.0, 0.16), 0.172, 0.007, m["brass"])


def bed(b: Builder, m: Palette, width: float, cover: str, wood: str = "walnut") -> None:
    """A bed with its head at y = 0: turned posts, quilt, pillows."""
    half, long = width / 2.0, 2.05
    w = m[wood]
    for sx in (-1, 1):
        for y, top in ((-0.05, 1.15), (-long, 0.72)):
            leg(b, sx * half, y, top, 0.045, w)
            ball(b, (sx * half, y, top + 0.035), 0.042, w)
        box(b, (sx * half - 0.015, -long + 0.03, 0.24), (sx * half + 0.015, -0.08, 0.36), w)
    for y, low, high in ((-0.05, 0.50, 1.0), (-long, 0.28, 0.60)):
        cushion(b, (-half + 0.03, y - 0.018, low), (half - 0.03, y + 0.018, high), w, 0.015, 0.8)
        bar(b, [(-half, y, high), (-half / 2, y, high + 0.10), (0.0, y, high + 0.14),
                (half / 2, y, high + 0.10), (half, y, high)], 0.026, w, 8)  # fmt: skip
    inner = half - 0.03
    cushion(b, (-inner, -long + 0.05, 0.26), (inner, -0.08, 0.48), m["linen"], 0.06, 4.0)
    cushion(b, (-half - 0.05, -long + 0.04, 0.30), (half + 0.05, -0.62, 0.56), m[cover], 0.09, 3.0,
            0.035, 4)  # fmt: skip
    count = 2 if width > 1.2 else 1
    for k in range(count):
        x = 0.0 if count == 1 else (k - 0.5) * width * 0.48
        with b.placed(x, -0.50, 0.47, 4.0 - 8.0 * k, -62.0):
            low, high = (-0.31, -0.06, 0.0), (0.31, 0.06, 0.42)
            cushion(b, low, high, m["white_cloth"], 0.06, 4.0, 0.05, 3)


def cradle(b: Builder, m: Palette) -> None:
    """A child's bed with thin bars all round; its back at y = 0."""
    w, x, y0, y1 = m["white_paint"], 0.62, -0.68, -0.03
    for sx in (-1, 1):
        for y in (y0, y1):
            leg(b, sx * x, y, 0.92, 0.028, w)
            ball(b, (sx * x, y, 0.945), 0.028, w)
    for z in (0.30, 0.86):
        for y in (y0, y1):
            tube(b, (-x, y, z), (x, y, z), 0.016, w, 6)
        for sx in (-1, 1):
            tube(b, (sx * x, y0, z), (sx * x, y1, z), 0.016, w, 6)
    for k in range(1, 14):
        px = -x + 2 * x * k / 14
        for y in (y0, y1):
            tube(b, (px, y, 0.30), (px, y, 0.86), 0.007, w, 6)
    for k in range(1, 7):
        py = y0 + (y1 - y0) * k / 7
        for sx in (-1, 1):
            tube(b, (sx * x, py, 0.30), (sx * x, py, 0.86), 0.007, w, 6)
    cushion(b, (-x + 0.03, y0 + 0.03, 0.30), (x - 0.03, y1 - 0.03, 0.42), m["linen"], 0.04)
    cushion(b, (-0.2, y0 + 0.06, 0.40), (x - 0.05, y1 - 0.06, 0.46), m["quilt_b"], 0.03, 4.0, 0.02)


def piano(b: Builder, m: Palette) -> None:
    """An upright piano with 52 white and 36 black keys; its back at y = 0."""
    k = m["lacquer"]
    box(b, (-0.75, -0.40, 0.0), (0.75, -0.02, 1.22), k, 0.5, "-z")
    cushion(b, (-0.78, -0.43, 1.22), (0.78, 0.0, 1.25), k, 0.014)
    box(b, (-0.75, -0.68, 0.58), (0.75, -0.40, 0.66), k, 0.5, "+y")
    for sx in (-1, 1):
        x0, x1 = sorted((sx * 0.75, sx * 0.69))
        box(b, (x0, -0.66, 0.66), (x1, -0.40, 0.78), k, 0.5, "+y -z")
        leg(b, sx * 0.69, -0.62, 0.58, 0.038, k)
    panel(b, (-0.60, -0.404, 0.86), (0.60, -0.40, 1.16), "-y", m["walnut"])
    wide = 1.36 / 52
    for n in range(52):
        x = -0.68 + n * wide
        box(b, (x + 0.0008, -0.665, 0.66), (x + wide - 0.0008, -0.52, 0.682), m["porcelain"], 1.0,
            "-z +y")  # fmt: skip
        if n % 7 not in (1, 4) and n < 51:
            box(b, (x + wide - 0.006, -0.62, 0.682), (x + wide + 0.006, -0.52, 0.694), k, 1.0,
                "-z +y")  # fmt: skip
    box(b, (-0.69, -0.52, 0.66), (0.69, -0.40, 0.72), k, 0.5, "-z +y")
    box(b, (-0.30, -0.47, 0.86), (0.30, -0.445, 0.87), k)
    for x in (-0.15, 0.01):
        with b.placed(x, -0.45, 0.87, 0.0, -12.0):
            box(b, (0.0, -0.006, 0.0), (0.155, 0.0, 0.23), m["paper"])
    for n in range(2):
        tube(b, (-0.06 + 0.12 * n, -0.50, 0.07), (-0.06 + 0.12 * n, -0.40, 0.07), 0.012, m["brass"],
             8)  # fmt: skip


def globe(b: Builder, m: Palette) -> None:
    """A terrestrial globe in a brass meridian on a turned stand."""
    lathe(b, [(0.17, 0.0), (0.18, 0.02), (0.15, 0.04), (0.05, 0.07), (0.03, 0.12), (0.045, 0.22),
              (0.03, 0.40), (0.04, 0.50), (0.06, 0.54), (0.03, 0.57)], m["walnut"], 8)  # fmt: skip
    ball(b, (0.0, 0.0, 0.84), 0.23, m["globe"], 12)
    turn = np.linspace(-np.pi / 2.0, np.pi / 2.0, 11)
    bar(b, [(0.255 * np.cos(a), 0.0, 0.84 + 0.255 * np.sin(a)) for a in turn], 0.008, m["brass"])
    ring(b, (0.0, 0.0, 0.84), 0.26, 0.010, m["walnut"], 20)


def clock(b: Builder, m: Palette) -> None:
    """A long-case clock; its back at y = 0."""
    w = m["walnut"]
    box(b, (-0.26, -0.28, 0.0), (0.26, 0.0, 0.55), w)
    box(b, (-0.19, -0.23, 0.55), (0.19, 0.0, 1.45), w)
    box(b, (-0.26, -0.28, 1.45), (0.26, 0.0, 1.95), w)
    cushion(b, (-0.30, -0.32, 1.95), (0.30, 0.0, 2.0), w, 0.024)
    for x in (-0.235, 0.235):
        lathe(b, [(0.022, 1.46), (0.022, 1.48), (0.014, 1.50), (0.017, 1.7), (0.014, 1.90),
                  (0.022, 1.92), (0.022, 1.94)], m["brass"], 10, (x, -0.295, 0.0))  # fmt: skip
    for x in (-0.27, 0.0, 0.27):
        lathe(b, [(0.02, 2.0), (0.03, 2.03), (0.012, 2.06), (0.02, 2.08), (1e-3, 2.13)], m["brass"],
              10, (x, -0.2, 0.0))  # fmt: skip
    with b.placed(0.0, -0.285, 1.70, 0.0, 90.0):
        lathe(b, [(0.19, 0.0), (0.19, 0.008), (0.175, 0.012), (1e-3, 0.012)], m["porcelain"], 24)
        ring(b, (0.0, 0.0, 0.012), 0.185, 0.008, m["brass"], 24)
        for n in range(12):
            a = n * np.pi / 6.0
            ball(b, (0.15 * np.cos(a), 0.15 * np.sin(a), 0.012), 0.008, m["iron"], 6, 0.4)
        for a, r in ((0.9, 0.13), (2.6, 0.09)):
            tube(b, (0.0, 0.0, 0.018), (r * np.cos(a), r * np.sin(a), 0.018), 0.003, m["iron"], 5)


def toys(b: Builder, m: Palette, rng: np.random.Generator) -> None:
    """Balls, stacked blocks and a ring pyramid on the floor, within 0.45 m of the origin."""
    for k in range(5):
        a, r = k * 2.4, float(rng.uniform(0.22, 0.40))
        size = float(rng.uniform(0.04, 0.08))
        color = m[("petal_a", "petal_b", "glaze", "leaf1", "apple")[k]]
        ball(b, (r * np.cos(a), r * np.sin(a), size), size, color, 8)
    for k in range(4):
        with b.placed(0.06 * k - 0.1, -0.05, 0.062 * (k % 2), 20.0 * k):
            cushion(b, (-0.03, -0.03, 0.0), (0.03, 0.03, 0.06), m[f"block{k % 3}"], 0.006)
    for k in range(5):
        ring(b, (0.12, 0.14, 0.02 + 0.03 * k), 0.055 - 0.007 * k, 0.015, m[f"block{k % 3}"], 16)


def rows_of(
    count: int, low: float, high: float, rng: np.random.Generator, jitter: float = 0.01
) -> Sequence[float]:
    """``count`` places from ``low`` to ``high``, each a little off its own."""
    places = np.linspace(low, high, count) + rng.uniform(-jitter, jitter, count)
    return [float(x) for x in places]
