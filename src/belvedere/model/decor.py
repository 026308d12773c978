"""The small things that make rooms lived in: plants, curtains, rugs, lamps, crockery."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from belvedere.model.architecture import Palette
from belvedere.model.charts import F8, Builder
from belvedere.model.furniture import shade
from belvedere.model.ornament import lathe
from belvedere.model.shapes import box, grid, panel, tube


def rug(b: Builder, material: int, edge: int, width: float, depth: float) -> None:
    """A rug 12 mm thick, its middle at the origin; the picture's top lies towards +y."""
    x, y = width / 2.0, depth / 2.0
    panel(b, (-x, -y, 0.0), (x, y, 0.012), "+z", material)
    box(b, (-x, -y, 0.0), (x, y, 0.012), edge, 1.0, "-z +z")


def floor_lamp(b: Builder, m: Palette) -> None:
    """A standing lamp; its bulb hangs at z = 1.48."""
    lathe(b, [(0.15, 0.0), (0.15, 0.015), (0.03, 0.03), (0.012, 0.05)], m["brass"], 20, crisp=False)
    tube(b, (0, 0, 0.04), (0, 0, 1.42), 0.010, m["brass"], 8)
    shade(b, m, 1.36, 1.64, 0.22, 0.16, 24)


def pendant(b: Builder, m: Palette, drop: float) -> None:
    """A lamp that hangs ``drop`` below the origin: a cable and a glowing drum."""
    tube(b, (0, 0, -drop + 0.12), (0, 0, 0.0), 0.004, m["iron"], 5)
    lathe(b, [(0.05, -0.03), (0.05, 0.0)], m["iron"], 12, crisp=False)
    shade(b, m, -drop - 0.14, -drop + 0.14, 0.25, 0.20, 24)


def curtain(b: Builder, m: Palette, width: float, height: float, folds: int) -> None:
    """Hanging cloth in folds, 2 * ``folds`` waves, in the plane y = 0; its top at z = height."""
    n = folds * 8 + 1
    x = np.linspace(-width / 2.0, width / 2.0, n)
    wave = np.linspace(0.0, 2.0 * np.pi * folds, n)
    z = np.array([0.02, height * 0.5, height])
    depth = 0.035 * np.array([1.25, 1.0, 0.8])[:, None] * np.sin(wave + 0.25 * np.sin(wave * 0.5))
    points = np.stack([np.broadcast_to(x, depth.shape), depth, np.repeat(z[:, None], n, 1)], axis=2)
    uv = np.stack(np.meshgrid(wave * 0.05, z), axis=2) * 5.0
    grid(b, points, m["curtain"], uv)  # fronts look towards -y
    grid(b, points[:, ::-1] + np.array([0.0, 0.004, 0.0]), m["curtain"], uv)


def curtain_rod(b: Builder, m: Palette, width: float) -> None:
    """A rod along x at the origin with knobs at its ends."""
    tube(b, (-width / 2, 0, 0), (width / 2, 0, 0), 0.011, m["brass"], 8)
    for x in (-width / 2, width / 2):
        lathe(b, [(0.004, -0.022), (0.02, -0.012), (0.02, 0.012), (0.004, 0.022)], m["brass"], 8,
              (x, 0, 0), crisp=False)  # fmt: skip


def pot(b: Builder, m: Palette, radius: float, height: float, glaze: str = "terracotta") -> None:
    """A plant pot with earth in it."""
    r, h = radius, height
    lathe(b, [(r * 0.72, 0.0), (r * 0.96, h * 0.84), (r * 1.04, h * 0.85), (r * 1.04, h),
              (r * 0.92, h), (r * 0.9, h * 0.86)], m[glaze], 18, crisp=False)  # fmt: skip
    lathe(b, [(r * 0.92, h * 0.88), (0.001, h * 0.9)], m["earth"], 18, crisp=False)


def _leaf(b: Builder, m: Palette, root: F8, tip: F8, width: float, droop: float, name: str) -> None:
    """A blade from root to tip, folded along its rib, seen from above and below."""
    along = tip - root
    side = np.cross(along, [0.0, 0.0, 1.0])
    side = side / max(float(np.linalg.norm(side)), 1e-9) * width / 2.0
    s = np.linspace(0.0, 1.0, 6)[:, None]
    rib = root + along * s - np.array([0.0, 0.0, droop]) * s**2
    wide = np.sin(np.pi * s**0.75) * 0.98 + 0.02
    lift = np.array([0.0, 0.0, width * 0.16]) * wide
    points = np.stack([rib - side * wide + lift, rib, rib + side * wide + lift], axis=1)
    uv = np.stack(np.meshgrid(np.array([0.0, 0.5, 1.0]), s[:, 0]), axis=2)
    grid(b, points[:, ::-1], m[name], uv)
    grid(b, points - np.array([0.0, 0.0, 0.0015]), m[name], uv)


def plant(
    b: Builder,
    m: Palette,
    rng: np.random.Generator,
    height: float,
    leaves: int,
    leaf: Callable[[Builder, Palette, F8, F8, float, float, str], None] = _leaf,
) -> None:
    """Long leaves on stems that fan out from a pot 0.3 m high; ``leaf`` makes each."""
    pot(b, m, 0.19, 0.32)
    for k in range(leaves):
        angle = k * 2.399963 + rng.uniform(-0.2, 0.2)
        reach = rng.uniform(0.18, 0.36) * min(height, 1.2) * 0.62
        top = 0.32 + (height - 0.32) * rng.uniform(0.45, 1.0)
        direction = np.array([np.cos(angle), np.sin(angle), 0.0])
        root = np.array([0.0, 0.0, 0.29]) + direction * 0.04
        knee = root + direction * reach * 0.45 + np.array([0.0, 0.0, top - 0.3])
        tube(b, tuple(root), tuple(knee), (0.008, 0.005), m["stem"], 5)
        tip = knee + direction * reach * 0.95 + np.array([0.0, 0.0, 0.06])
        leaf(b, m, knee, tip, rng.uniform(0.10, 0.17), rng.uniform(0.05, 0.18), f"leaf{k % 3}")


def vase(b: Builder, m: Palette, glaze: str, height: float) -> None:
    """A turned vase, taller than wide."""
    h = height
    lathe(b, [(h * 0.16, 0.0), (h * 0.27, h * 0.22), (h * 0.30, h * 0.42), (h * 0.20, h * 0.70),
              (h * 0.10, h * 0.84), (h * 0.11, h * 0.93), (h * 0.15, h)],
          m[glaze], 18, crisp=False)  # fmt: skip
    lathe(b, [(h * 0.14, h * 0.995), (h * 0.09, h * 0.86), (0.001, h * 0.84)], m["earth"], 18,
          crisp=False)  # fmt: skip


def bouquet(b: Builder, m: Palette, rng: np.random.Generator, height: float) -> None:
    """A vase with flowers on thin stems."""
    vase(b, m, "celadon", height)
    for k in range(11):
        angle, lean = k * 2.399963, rng.uniform(0.02, 0.13)
        foot = np.array([0.0, 0.0, height * 0.9])
        out = np.array([np.cos(angle), np.sin(angle), 0.0])
        head = foot + out * lean + np.array([0.0, 0.0, rng.uniform(0.16, 0.30)])
        tube(b, tuple(foot), tuple(head), 0.003, m["stem"], 4)
        r = rng.uniform(0.020, 0.032)
        petals = m[("petal_a", "petal_b", "petal_c")[k % 3]]
        lathe(b, [(0.003, -r * 0.7), (r * 0.8, -r * 0.3), (r, r * 0.3), (r * 0.6, r * 0.7),
                  (0.003, r * 0.8)], petals, 8, tuple(head), crisp=False)  # fmt: skip
        _leaf(b, m, foot + (head - foot) * 0.5, foot + (head - foot) * 0.5 + out * 0.09, 0.03,
              0.02, "leaf1")  # fmt: skip


def fruit_bowl(b: Builder, m: Palette, rng: np.random.Generator) -> None:
    """A bowl of oranges and apples."""
    lathe(b, [(0.06, 0.0), (0.065, 0.012), (0.13, 0.05), (0.165, 0.10), (0.17, 0.105),
              (0.158, 0.10), (0.12, 0.055), (0.001, 0.03)], m["glaze"], 22,
          crisp=False)  # fmt: skip
    for k in range(7):
        ring = 0.0 if k == 0 else 0.085
        angle = k * 1.0472 + 0.2
        r = float(rng.uniform(0.034, 0.041))
        at = (ring * np.cos(angle), ring * np.sin(angle), 0.085 if k else 0.125)
        ball = [(r * np.cos(a) + 1e-4, r * np.sin(a)) for a in np.linspace(-1.57, 1.57, 8)]
        lathe(b, ball, m["orange" if k % 3 else "apple"], 12, at, crisp=False)


def crockery(b: Builder, m: Palette) -> None:
    """A plate, a bowl and a cup set for one."""
    lathe(b, [(0.09, 0.0), (0.125, 0.012), (0.13, 0.018), (0.085, 0.008), (0.001, 0.007)],
          m["porcelain"], 22, crisp=False)  # fmt: skip
    lathe(b, [(0.028, 0.0), (0.036, 0.03), (0.040, 0.085), (0.037, 0.085), (0.03, 0.02),
              (0.001, 0.015)], m["celadon"], 14, (0.17, 0.11, 0.0), crisp=False)  # fmt: skip
    box(b, (-0.172, -0.09, 0.0), (-0.160, 0.10, 0.003), m["iron"], 1.0, "-z")
