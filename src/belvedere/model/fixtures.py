"""What is fixed to a house or hangs in it: lamps, radiators, baths, basins, stoves, jars.

Pieces against a wall have their back at y = 0 and their front towards -y; hanging ones their
fastening at the origin.
"""

from __future__ import annotations

import numpy as np

from belvedere.model.architecture import Palette
from belvedere.model.charts import F8, Builder
from belvedere.model.ornament import ball, bar, lathe, ring
from belvedere.model.shapes import box, cushion, grid, panel, tube


def radiator(b: Builder, m: Palette, width: float, height: float) -> None:
    """A cast-iron column radiator on small feet; its back at y = -0.03."""
    count = max(int(width / 0.062), 3)
    pitch = width / count
    w, r = m["white_paint"], pitch * 0.40
    for k in range(count):
        x = -width / 2.0 + (k + 0.5) * pitch
        rise = ((0.06, 0.6), (0.10, 1.0), (height / 2, 0.8), (height - 0.05, 1.0), (height, 0.6))
        for y in (-0.065, -0.135):
            bar(b, [(x, y, z) for z, _ in rise], [r * t for _, t in rise], w, 6)
        bar(b, [(x, -0.065, height), (x, -0.10, height + 0.018), (x, -0.135, height)], r * 0.6, w)
    for z in (0.12, height - 0.03):
        for y in (-0.065, -0.135):
            tube(b, (-width / 2.0, y, z), (width / 2.0, y, z), 0.022, w, 6)
    for x in (-width / 2 + pitch / 2, width / 2 - pitch / 2):
        for y in (-0.065, -0.135):
            lathe(b, [(0.02, 0.0), (0.022, 0.02), (0.012, 0.06), (0.016, 0.11)], w, 8, (x, y, 0.0))
    bar(b, [(width / 2, -0.1, 0.12), (width / 2 + 0.05, -0.1, 0.12), (width / 2 + 0.07, -0.1, 0.09),
            (width / 2 + 0.07, -0.1, 0.0)], 0.011, m["brass"], 8)  # fmt: skip
    lathe(b, [(0.012, 0.13), (0.025, 0.14), (0.027, 0.17), (0.02, 0.19), (1e-3, 0.195)], m["trim"],
          10, (width / 2 + 0.045, -0.1, 0.0))  # fmt: skip


def chandelier(b: Builder, m: Palette, drop: float, arms: int = 6) -> None:
    """A brass chandelier that hangs ``drop`` below the origin: scrolled arms, candles, beads."""
    tube(b, (0, 0, -drop + 0.15), (0, 0, 0.0), 0.006, m["brass"], 6)
    lathe(b, [(0.02, -0.05), (0.06, -0.03), (0.075, 0.0)], m["brass"], 8)
    lathe(b, [(0.004, -0.26), (0.03, -0.23), (0.015, -0.20), (0.05, -0.15), (0.075, -0.10),
              (0.05, -0.05), (0.02, -0.02), (0.03, 0.02), (0.02, 0.06), (0.035, 0.10),
              (0.006, 0.16)], m["brass"], 8, (0, 0, -drop))  # fmt: skip
    for k in range(arms):
        a = k * 2.0 * np.pi / arms
        x, y = np.cos(a), np.sin(a)
        path = [(0.04, -0.10), (0.12, -0.17), (0.22, -0.17), (0.30, -0.08), (0.33, 0.0)]
        bar(b, [(r * x, r * y, z - drop) for r, z in path], 0.008, m["brass"], 6)
        foot = (0.33 * x, 0.33 * y, -drop)
        lathe(b, [(0.012, -0.01), (0.045, 0.0), (0.05, 0.012), (0.02, 0.014)], m["brass"], 8, foot)
        lathe(b, [(0.011, 0.012), (0.011, 0.09), (0.004, 0.095)], m["porcelain"], 8, foot)
        flame = (foot[0], foot[1], foot[2] + 0.115)
        ball(b, flame, 0.014, m["flame"], 8, 1.7)
        for n in range(3):
            t = (n + 1) / 4.0
            drop_at = (foot[0] * t, foot[1] * t, -drop - 0.02 - 0.16 * (1 - (2 * t - 1) ** 2))
            ball(b, drop_at, 0.011, m["crystal"], 8, 1.5)
    ring(b, (0, 0, -drop - 0.005), 0.33, 0.004, m["brass"], 8)


def ceiling_lamp(b: Builder, m: Palette) -> None:
    """A milk-glass bowl close under the ceiling; its bulb hangs 0.16 m down."""
    lathe(b, [(0.10, -0.05), (0.13, -0.03), (0.13, 0.0)], m["brass"], 8)
    lathe(b, [(1e-3, -0.20), (0.07, -0.19), (0.13, -0.155), (0.165, -0.10), (0.165, -0.06),
              (0.14, -0.045)], m["milk_glass"], 8)  # fmt: skip
    ball(b, (0.0, 0.0, -0.21), 0.014, m["brass"], 8)


def sconce(b: Builder, m: Palette) -> None:
    """A wall lamp on a scrolled arm; its bulb at (0, -0.17, 0.10)."""
    with b.placed(0.0, 0.0, 0.0, 0.0, 90.0):
        lathe(b, [(0.055, 0.0), (0.05, 0.012), (0.02, 0.02), (0.012, 0.035)], m["brass"], 8)
    bar(b, [(0, -0.03, 0.0), (0, -0.09, -0.04), (0, -0.15, -0.03), (0, -0.17, 0.03)], 0.008,
        m["brass"], 8)  # fmt: skip
    lathe(b, [(0.01, 0.02), (0.03, 0.035), (0.02, 0.05)], m["brass"], 8, (0, -0.17, 0))
    lathe(b, [(0.025, 0.05), (0.05, 0.075), (0.062, 0.115), (0.058, 0.15), (0.07, 0.175)],
          m["milk_glass"], 8, (0, -0.17, 0))  # fmt: skip


def tap(b: Builder, m: Palette, reach: float, height: float) -> None:
    """A swan-necked mixer with two handles, standing at the origin, its mouth towards -y."""
    c = m["chrome"]
    lathe(b, [(0.025, 0.0), (0.022, 0.015), (0.014, 0.03)], c, 8)
    bar(b, [(0, 0, 0.02), (0, 0, height * 0.7), (0, -reach * 0.25, height * 0.96),
            (0, -reach * 0.7, height), (0, -reach, height * 0.8), (0, -reach, height * 0.68)],
        0.010, c, 8)  # fmt: skip
    for x in (-0.09, 0.09):
        lathe(b, [(0.02, 0.0), (0.014, 0.02), (0.01, 0.045), (0.016, 0.055), (1e-3, 0.065)], c, 10,
              (x, 0, 0))  # fmt: skip
        tube(b, (x - 0.03, 0, 0.055), (x + 0.03, 0, 0.055), 0.005, c, 6)
        tube(b, (x, -0.03, 0.055), (x, 0.03, 0.055), 0.005, c, 6)


def bathtub(b: Builder, m: Palette) -> None:
    """A free-standing tub on ball feet, 1.65 m long; its long side at y = 0."""
    rise = ((0.60, 0.12), (0.80, 0.14), (0.90, 0.24), (0.95, 0.40), (0.985, 0.55), (1.0, 0.57),
            (1.02, 0.585), (1.0, 0.60), (0.97, 0.592))  # fmt: skip
    inside = ((0.97, 0.592), (0.93, 0.56), (0.89, 0.42), (0.84, 0.26), (0.72, 0.19), (0.4, 0.18),
              (0.01, 0.18))  # fmt: skip
    a = np.linspace(0.0, 2.0 * np.pi, 17)
    shape = np.stack([0.825 * np.sign(np.cos(a)) * np.abs(np.cos(a)) ** 0.75,
                      0.37 * np.sign(np.sin(a)) * np.abs(np.sin(a)) ** 0.8], axis=1)  # fmt: skip
    for line in (rise, inside):
        profile = np.array(line)
        flat = profile[:, None, :1] * shape[None]
        z = np.broadcast_to(profile[:, None, 1:], (*flat.shape[:2], 1))
        points = np.concatenate([flat + np.array([0.0, -0.40]), z], axis=2)
        u, v = np.meshgrid(a, profile[:, 1])
        grid(b, points, m["enamel"], np.stack([u, v], axis=2))
    for sx in (-1, 1):
        for y in (-0.22, -0.58):
            ball(b, (sx * 0.5, y, 0.04), 0.04, m["brass"], 8)
            bar(b, [(sx * 0.5, y, 0.05), (sx * 0.49, y, 0.10), (sx * 0.44, y, 0.15)],
                [0.02, 0.016, 0.024], m["brass"], 8)  # fmt: skip
    with b.placed(0.70, -0.40, 0.58, -90.0):
        tap(b, m, 0.16, 0.22)


def basin(b: Builder, m: Palette) -> None:
    """A washbasin on a column, with its tap; its back at y = 0."""
    e = m["enamel"]
    lathe(b, [(0.12, 0.0), (0.12, 0.03), (0.085, 0.06), (0.07, 0.3), (0.075, 0.55), (0.11, 0.68)],
          e, 8, (0, -0.24, 0))  # fmt: skip
    lathe(b, [(0.09, 0.66), (0.17, 0.70), (0.24, 0.76), (0.265, 0.83), (0.27, 0.85), (0.262, 0.858),
              (0.24, 0.852), (0.21, 0.79), (0.13, 0.735), (1e-3, 0.725)], e, 24,
          (0, -0.28, 0))  # fmt: skip
    box(b, (-0.27, -0.16, 0.80), (0.27, -0.005, 0.855), e, 1.0)
    with b.placed(0.0, -0.08, 0.855):
        tap(b, m, 0.13, 0.16)


def toilet(b: Builder, m: Palette) -> None:
    """A close-coupled water closet; its back at y = 0."""
    e = m["enamel"]
    cushion(b, (-0.19, -0.20, 0.40), (0.19, -0.02, 0.78), e, 0.03)
    cushion(b, (-0.205, -0.215, 0.78), (0.205, -0.01, 0.82), e, 0.018)
    lathe(b, [(0.12, 0.0), (0.125, 0.02), (0.10, 0.10), (0.11, 0.2), (0.165, 0.33), (0.19, 0.385),
              (0.19, 0.40)], e, 8, (0, -0.42, 0))  # fmt: skip
    lathe(b, [(0.20, 0.40), (0.205, 0.412), (0.20, 0.425), (0.12, 0.43), (1e-3, 0.43)],
          m["white_paint"], 20, (0, -0.42, 0))  # fmt: skip
    box(b, (-0.09, -0.34, 0.02), (0.09, -0.06, 0.40), e)
    ball(b, (0.0, -0.11, 0.83), 0.018, m["chrome"], 8, 0.6)


def mirror(b: Builder, m: Palette, width: float, height: float) -> None:
    """A silvered glass in a rounded frame, its middle at the origin."""
    x, z = width / 2.0, height / 2.0
    panel(b, (-x, -0.012, -z), (x, 0.0, z), "-y", m["silver"])
    path = [(-x, -z), (x, -z), (x, z), (-x, z)]
    for k in range(4):
        (x0, z0), (x1, z1) = path[k], path[(k + 1) % 4]
        tube(b, (x0, -0.014, z0), (x1, -0.014, z1), 0.020, m["brass"], 8)
        ball(b, (x0, -0.014, z0), 0.028, m["brass"], 8)


def towel_rail(b: Builder, m: Palette, width: float = 0.6) -> None:
    """A rail with a folded towel, at the height of the origin."""
    for x in (-width / 2, width / 2):
        bar(b, [(x, 0.0, 0.0), (x, -0.04, 0.0), (x, -0.07, 0.0)], 0.009, m["chrome"], 8)
        ball(b, (x, -0.075, 0.0), 0.014, m["chrome"], 8)
    tube(b, (-width / 2, -0.075, 0), (width / 2, -0.075, 0), 0.008, m["chrome"], 8)
    cushion(b, (-width * 0.3, -0.105, -0.42), (width * 0.3, -0.088, 0.012), m["towel"], 0.008, 6.0)
    cushion(b, (-width * 0.3, -0.062, -0.36), (width * 0.3, -0.045, 0.012), m["towel"], 0.008, 6.0)
    cushion(b, (-width * 0.3, -0.105, 0.0), (width * 0.3, -0.045, 0.02), m["towel"], 0.009, 6.0)


def stove(b: Builder, m: Palette, rng: np.random.Generator) -> None:
    """A range with an oven, four rings, knobs and pans; its back at y = 0."""
    box(b, (-0.45, -0.60, 0.06), (0.45, 0.0, 0.90), m["enamel"], 1.0)
    box(b, (-0.43, -0.56, 0.0), (0.43, 0.0, 0.06), m["dark"], 1.0, "-z +z")
    box(b, (-0.46, -0.62, 0.90), (0.46, 0.0, 0.92), m["iron"], 1.0)
    box(b, (-0.38, -0.625, 0.16), (0.38, -0.60, 0.70), m["iron"], 1.0, "+y")
    bar(b, [(-0.34, -0.63, 0.66), (-0.33, -0.665, 0.66), (0.0, -0.67, 0.66), (0.33, -0.665, 0.66),
            (0.34, -0.63, 0.66)], 0.010, m["chrome"], 8)  # fmt: skip
    for k in range(6):
        with b.placed(-0.35 + 0.14 * k, -0.60, 0.80, 0.0, 90.0):
            lathe(b, [(0.026, 0.0), (0.026, 0.012), (0.02, 0.018), (0.018, 0.035), (1e-3, 0.038)],
                  m["iron"], 8)  # fmt: skip
    for k, (x, y) in enumerate(((-0.22, -0.45), (0.22, -0.45), (-0.22, -0.17), (0.22, -0.17))):
        ring(b, (x, y, 0.93), 0.11, 0.009, m["iron"], 8)
        ring(b, (x, y, 0.93), 0.05, 0.007, m["iron"], 8)
        if k != 1:
            with b.placed(x, y, 0.938, float(rng.uniform(-60, 60)) + 90.0 * k):
                pan(b, m, 0.11 + 0.02 * (k % 2), 0.09 + 0.06 * (k == 2), k == 2)


def pan(b: Builder, m: Palette, radius: float, height: float, lid: bool = False) -> None:
    """A copper pan with a long handle; with a lid, a pot with two ears."""
    r, h = radius, height
    lathe(b, [(r * 0.9, 0.0), (r * 0.98, 0.008), (r, h - 0.01), (r * 1.03, h), (r * 0.97, h),
              (r * 0.95, h - 0.01), (r * 0.93, 0.012), (1e-3, 0.010)], m["copper"], 8)  # fmt: skip
    if lid:
        cover = ((1.03 * r, 0.0), (0.9 * r, 0.012), (0.5 * r, 0.026), (0.012, 0.03), (0.01, 0.04),
                 (0.02, 0.05), (1e-3, 0.06))  # fmt: skip
        lathe(b, [(radius, h + z) for radius, z in cover], m["copper"], 8)
        for s in (-1, 1):
            far = s * (r + 0.03)
            ear = [(s * r, -0.03, h * 0.7), (far, -0.02, h * 0.75), (far, 0.02, h * 0.75)]
            bar(b, [*ear, (s * r, 0.03, h * 0.7)], 0.005, m["brass"])
        return
    bar(b, [(r * 0.98, 0.0, h * 0.75), (r + 0.08, 0.0, h * 0.95), (r + 0.19, 0.0, h + 0.01)],
        [0.009, 0.008, 0.011], m["iron"], 8)  # fmt: skip


def sink(b: Builder, m: Palette) -> None:
    """A round enamelled bowl with a tap, standing on a worktop at z = 0."""
    lathe(b, [(0.16, 0.0), (0.2, 0.05), (0.225, 0.11), (0.23, 0.125), (0.222, 0.128), (0.20, 0.10),
              (0.15, 0.03), (1e-3, 0.02)], m["enamel"], 22, (0, -0.30, 0))  # fmt: skip
    with b.placed(0.0, -0.06, 0.0):
        tap(b, m, 0.18, 0.30)


def jar(b: Builder, m: Palette, radius: float, height: float, glaze: str) -> None:
    """A storage jar with a knobbed lid."""
    r, h = radius, height
    lathe(b, [(r * 0.8, 0.0), (r, h * 0.06), (r, h * 0.7), (r * 0.8, h * 0.8), (r * 0.8, h * 0.84)],
          m[glaze], 8)  # fmt: skip
    lathe(b, [(r * 0.88, h * 0.84), (r * 0.88, h * 0.88), (r * 0.5, h * 0.93), (r * 0.14, h * 0.94),
              (r * 0.22, h * 0.98), (1e-3, h)], m["oak"], 8)  # fmt: skip


def bottle(b: Builder, m: Palette, height: float, glaze: str) -> None:
    """A wine bottle."""
    h = height
    lathe(b, [(h * 0.12, 0.0), (h * 0.125, h * 0.02), (h * 0.125, h * 0.55), (h * 0.09, h * 0.68),
              (h * 0.045, h * 0.76), (h * 0.042, h * 0.95), (h * 0.05, h * 0.955),
              (h * 0.05, h)], m[glaze], 8)  # fmt: skip


def teapot(b: Builder, m: Palette, glaze: str = "porcelain") -> None:
    """A teapot 0.14 m high."""
    lathe(b, [(0.045, 0.0), (0.05, 0.006), (0.075, 0.03), (0.085, 0.06), (0.07, 0.095),
              (0.04, 0.11)], m[glaze], 8)  # fmt: skip
    lathe(b, [(0.043, 0.108), (0.03, 0.12), (0.008, 0.126), (0.014, 0.138), (1e-3, 0.146)],
          m[glaze], 8)  # fmt: skip
    bar(b, [(0.075, 0, 0.045), (0.11, 0, 0.06), (0.125, 0, 0.095), (0.15, 0, 0.11)],
        [0.018, 0.014, 0.010, 0.009], m[glaze], 8)  # fmt: skip
    bar(b, [(-0.07, 0, 0.085), (-0.11, 0, 0.095), (-0.13, 0, 0.065), (-0.11, 0, 0.035),
            (-0.078, 0, 0.035)], 0.008, m[glaze], 8)  # fmt: skip


def cup(b: Builder, m: Palette, glaze: str = "porcelain") -> None:
    """A cup on its saucer."""
    lathe(b, [(0.04, 0.0), (0.07, 0.010), (0.075, 0.015), (0.045, 0.006), (1e-3, 0.005)], m[glaze],
          16)  # fmt: skip
    lathe(b, [(0.022, 0.006), (0.032, 0.02), (0.042, 0.05), (0.043, 0.068), (0.039, 0.067),
              (0.028, 0.022), (1e-3, 0.016)], m[glaze], 8)  # fmt: skip
    bar(b, [(0.041, 0, 0.058), (0.062, 0, 0.052), (0.06, 0, 0.034), (0.036, 0, 0.028)], 0.004,
        m[glaze], 6)  # fmt: skip


def candlestick(b: Builder, m: Palette, height: float = 0.26) -> None:
    """A turned brass candlestick with a candle."""
    h = height
    lathe(b, [(0.055, 0.0), (0.06, 0.012), (0.045, 0.022), (0.014, 0.04), (0.02, h * 0.3),
              (0.010, h * 0.4), (0.016, h * 0.6), (0.010, h * 0.75), (0.028, h * 0.86),
              (0.026, h * 0.9), (0.012, h * 0.9)], m["brass"], 8)  # fmt: skip
    lathe(b, [(0.011, h * 0.9), (0.011, h * 1.5), (1e-3, h * 1.51)], m["porcelain"], 8)


def glass(b: Builder, m: Palette) -> None:
    """A goblet."""
    lathe(b, [(0.032, 0.0), (0.030, 0.004), (0.006, 0.010), (0.005, 0.07), (0.02, 0.085),
              (0.034, 0.12), (0.032, 0.16), (0.030, 0.16), (0.03, 0.12), (1e-3, 0.09)],
          m["crystal"], 8)  # fmt: skip


def washing_machine(b: Builder, m: Palette) -> None:
    """A front loader; its back at y = 0."""
    cushion(b, (-0.30, -0.60, 0.01), (0.30, -0.01, 0.85), m["enamel"], 0.02)
    with b.placed(0.0, -0.60, 0.42, 0.0, 90.0):
        lathe(b, [(0.20, 0.0), (0.20, 0.03), (0.17, 0.045), (0.15, 0.035), (0.12, 0.02),
                  (0.06, 0.005), (1e-3, 0.0)], m["chrome"], 12)  # fmt: skip
    for x in (0.10, 0.20):
        with b.placed(x, -0.60, 0.76, 0.0, 90.0):
            lathe(b, [(0.03, 0.0), (0.028, 0.02), (1e-3, 0.024)], m["chrome"], 8)


def tree(b: Builder, m: Palette, rng: np.random.Generator, height: float) -> None:
    """A small indoor tree in a glazed pot: a bent trunk, branches and some 90 leaves."""
    from belvedere.model.decor import pot

    pot(b, m, 0.21, 0.36, "glaze")
    top = height - 0.45
    bend = rng.uniform(-0.05, 0.05, 4)
    low, high = (bend[0], bend[1], 0.32 + top * 0.3), (bend[2], bend[3], 0.32 + top * 0.6)
    trunk = [(0.0, 0.0, 0.32), low, high, (0.0, 0.0, 0.32 + top)]
    bar(b, trunk, [0.024, 0.02, 0.016, 0.01], m["dark"], 8)
    for k in range(9):
        a, up = k * 2.399963, 0.32 + top * float(rng.uniform(0.55, 1.0))
        reach = float(rng.uniform(0.14, 0.30))
        x, y = np.cos(a), np.sin(a)
        tip = np.array([reach * x, reach * y, up + float(rng.uniform(0.10, 0.28))])
        bar(b, [(0.01 * x, 0.01 * y, up), (reach * 0.5 * x, reach * 0.5 * y, (up + tip[2]) / 2.0),
                tuple(tip)], [0.008, 0.006, 0.004], m["dark"], 6)  # fmt: skip
        for n in range(10):
            at = tip * (0.55 + 0.5 * n / 10.0)
            at[2] = up + (tip[2] - up) * (0.55 + 0.5 * n / 10.0)
            way = np.array([*rng.uniform(-1.0, 1.0, 2), float(rng.uniform(-0.35, 0.5))])
            way *= float(rng.uniform(0.09, 0.13)) / np.linalg.norm(way)
            leaf(b, at, at + way, 0.055, m[f"leaf{(k + n) % 3}"])


def leaf(b: Builder, root: F8, tip: F8, width: float, material: int) -> None:
    """A pointed leaf that curls down, with two sides."""
    droop = 0.25 * float(np.linalg.norm(tip - root))
    _blade(b, root, tip, width, droop, material, 0.8)


def long_leaf(
    b: Builder, m: Palette, root: F8, tip: F8, width: float, droop: float, name: str
) -> None:
    """A long leaf for `belvedere.model.decor.plant`."""
    _blade(b, root, tip, width, droop, m[name], 0.75)


def _blade(
    b: Builder, root: F8, tip: F8, width: float, droop: float, material: int, shape: float
) -> None:
    """Two sheets back to back, folded along the rib; each sees only the fronts of others."""
    along = tip - root
    side = np.cross(along, [0.0, 0.0, 1.0])
    side = side / max(float(np.linalg.norm(side)), 1e-9) * width / 2.0
    s = np.linspace(0.0, 1.0, 6)[:, None]
    rib = root + along * s - np.array([0.0, 0.0, droop]) * s**2
    wide = np.sin(np.pi * s**shape) * 0.97 + 0.03
    lift = np.array([0.0, 0.0, width * 0.16]) * wide
    points = np.stack([rib - side * wide + lift, rib, rib + side * wide + lift], axis=1)
    normals = np.cross(np.gradient(points, axis=1), np.gradient(points, axis=0))
    normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-12)
    uv = np.stack(np.meshgrid(np.array([0.0, 0.5, 1.0]), s[:, 0]), axis=2)
    grid(b, points + 0.0008 * normals, material, uv, normals)
    under = (points - 0.0008 * normals)[:, ::-1]
    grid(b, under, material, uv[:, ::-1], -normals[:, ::-1])
