"""Pictures for walls, rugs and book spines, painted in code."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.model.textures import U1, Field, Rng, axes, band, finish, fractal_noise, tint

Color = tuple[float, float, float]


class _Canvas:
    """A picture under way: layers of flat colour laid on with masks."""

    def __init__(self, height: int, width: int, color: Color) -> None:
        self.x, self.y = axes(height, width)
        self.color = np.broadcast_to(np.array(color, np.float32), (height, width, 3)).copy()

    def lay(self, mask: npt.NDArray[Any], color: Color) -> None:
        """Paint ``color`` where ``mask`` (0 to 1) says."""
        paint = np.array(color, dtype=np.float32)
        self.color += mask[..., None].astype(np.float32) * (paint - self.color)

    def finish(self, texture: Field) -> U1:
        """The picture with the brush's or the yarn's texture on it."""
        return finish(self.color * texture[..., None])


def persian_rug(rng: Rng, height: int = 576, width: int = 864) -> U1:
    """A knotted rug: medallion, field of flowers, three borders, fringe."""
    red, navy, ivory = (0.33, 0.045, 0.04), (0.03, 0.045, 0.12), (0.62, 0.52, 0.37)
    gold, teal = (0.48, 0.27, 0.08), (0.06, 0.20, 0.19)
    c = _Canvas(height, width, red)
    x = (c.x - 0.5) * width / height
    y = c.y - 0.5
    half_x = 0.5 * width / height
    edge = np.minimum(half_x - np.abs(x), 0.5 - np.abs(y))
    soft = 1.5 / height

    def motif(step: float, size: float, petals: int, shift: float) -> tuple[Field, Field]:
        u = (x / step + shift) % 1.0 - 0.5
        v = (y / step + shift) % 1.0 - 0.5
        radius, angle = np.hypot(u, v), np.arctan2(v, u)
        flower = radius - size * (0.7 + 0.3 * np.cos(petals * angle))
        return band(flower, 0.0, soft / step), band(radius, size * 0.35, soft / step)

    for shift, petals, paint in ((0.0, 6, gold), (0.5, 4, teal)):
        flower, heart = motif(0.074, 0.30, petals, shift)
        c.lay(flower, paint)
        c.lay(heart, ivory)
    radius, angle = np.hypot(x / 1.25, y), np.arctan2(y, x / 1.25)
    scallop = radius * (1.0 + 0.07 * np.cos(12.0 * angle))
    for size, paint in ((0.30, gold), (0.29, navy), (0.22, ivory), (0.21, red), (0.115, gold)):
        c.lay(band(scallop, size, soft), paint)
    rosette = np.cos(16.0 * angle) * np.cos(radius * 90.0)
    c.lay(band(-rosette, -0.35, 0.15) * band(np.abs(scallop - 0.255), 0.028, soft), gold)
    c.lay(band(-rosette, -0.45, 0.15) * band(np.abs(scallop - 0.16), 0.035, soft), ivory)
    c.lay(band(radius * (1 + 0.2 * np.cos(8 * angle)), 0.075, soft), navy)
    c.lay(band(radius * (1 + 0.25 * np.cos(8 * angle)), 0.04, soft), ivory)
    corner = np.hypot(np.abs(x) - half_x, np.abs(y) - 0.5)
    c.lay(band(corner * (1 + 0.05 * np.cos(20 * angle)), 0.30, soft), gold)
    c.lay(band(corner * (1 + 0.05 * np.cos(20 * angle)), 0.29, soft), teal)
    for depth, paint in ((0.118, gold), (0.112, navy), (0.042, gold), (0.036, red)):
        c.lay(band(edge, depth, soft), paint)
    flower, heart = motif(0.0615, 0.36, 5, 0.25)
    border = band(np.abs(edge - 0.077), 0.028, soft)
    c.lay(flower * border, ivory)
    c.lay(heart * border, red)
    zigzag = np.abs(((x + y) / 0.026) % 1.0 - 0.5)
    c.lay(band(zigzag, 0.14, 0.08) * band(np.abs(edge - 0.024), 0.008, soft), ivory)
    c.lay(band(edge, 0.010, soft), ivory)
    knots = 1.0 + 0.10 * fractal_noise(rng, height, width, 192, 288, 1)
    return c.finish(knots * (1.0 + 0.10 * fractal_noise(rng, height, width, 48, 3, 3)))


def kilim(rng: Rng, height: int = 256, width: int = 1024) -> U1:
    """A flat-woven runner: stepped diamonds between stripes."""
    paints = [(0.42, 0.10, 0.045), (0.05, 0.11, 0.16), (0.50, 0.31, 0.10), (0.09, 0.17, 0.11)]
    c = _Canvas(height, width, (0.60, 0.53, 0.41))
    u = c.x * 12.0
    cell = np.floor(u).astype(int)
    step = 1.0 / 12.0
    du = np.floor(np.abs(u % 1.0 - 0.5) / step) * step
    dv = np.floor(np.abs(c.y - 0.5) / (step * 0.7)) * step * 0.7
    distance = du * 1.05 + dv
    for k, size in enumerate((0.46, 0.34, 0.25, 0.12)):
        for parity in range(4):
            mask = (distance < size) & (cell % 4 == parity)
            c.lay(mask, (0.60, 0.53, 0.41) if k in (1, 3) else paints[(parity + k) % 4])
    edge = np.minimum(c.y, 1.0 - c.y)
    c.lay(edge < 0.085, paints[1])
    c.lay((edge < 0.075) & (edge > 0.035) & ((c.x * 96.0 + edge * 12.0) % 1.0 < 0.5), paints[2])
    c.lay(edge < 0.018, paints[0])
    yarn = 1.0 + 0.16 * fractal_noise(rng, height, width, 128, 24, 2)
    return c.finish(yarn)


def book_spines(rng: Rng, columns: int = 32, height: int = 256, texels: int = 32) -> U1:
    """(height, columns * texels) an atlas of spines: bands, titles in ragged lines, wear."""
    paints = np.array(
        [(0.30, 0.05, 0.04), (0.04, 0.09, 0.18), (0.06, 0.16, 0.09), (0.46, 0.36, 0.20),
         (0.10, 0.06, 0.05), (0.55, 0.48, 0.38), (0.36, 0.17, 0.05), (0.16, 0.20, 0.24),
         (0.50, 0.13, 0.06), (0.05, 0.18, 0.20)]
    )  # fmt: skip
    atlas = np.zeros((height, columns * texels, 3), dtype=np.float32)
    y = (np.arange(height) + 0.5) / height
    for k in range(columns):
        paint = paints[rng.integers(len(paints))] * rng.uniform(0.7, 1.25)
        ink = np.array([0.62, 0.47, 0.18]) if paint.sum() < 0.75 else np.array([0.07, 0.05, 0.05])
        spine = np.broadcast_to(paint, (height, texels, 3)).copy()
        for at in (rng.uniform(0.05, 0.12), rng.uniform(0.86, 0.94), rng.uniform(0.62, 0.7)):
            spine[np.abs(y - at) < rng.uniform(0.004, 0.012)] = ink
        title = (y > 0.2) & (y < rng.uniform(0.42, 0.58))
        letters = rng.uniform(0, 1, height // 4).repeat(4) > 0.4
        low, high = sorted(rng.integers(7, texels - 7, 2) + np.array([-2, 3]))
        spine[title & letters, low:high] = ink
        bulge = 0.72 + 0.28 * np.sin((np.arange(texels) + 0.5) / texels * np.pi) ** 0.5
        atlas[:, k * texels : (k + 1) * texels] = spine * bulge[None, :, None]
    worn = 1.0 + 0.10 * fractal_noise(rng, height, columns * texels, 8, 64, 4)
    return finish(atlas * worn[..., None])


def seascape(rng: Rng, height: int = 288, width: int = 432) -> U1:
    """Evening light over water and far hills."""
    c = _Canvas(height, width, (0.50, 0.33, 0.20))
    c.color = tint(1.0 - c.y, (0.10, 0.22, 0.42)) + tint(c.y, (1.05, 0.55, 0.22))
    cloud = fractal_noise(rng, height, width, 7, 3, 6)
    c.lay(np.clip(cloud * 0.9 - 0.1, 0.0, 0.75) * (c.y < 0.6), (0.88, 0.62, 0.48))
    c.lay(band(np.hypot((c.x - 0.66) * 1.5, c.y - 0.42), 0.055, 0.02), (1.0, 0.86, 0.50))
    for base, tall, paint in ((0.52, 0.10, (0.20, 0.20, 0.30)), (0.57, 0.08, (0.09, 0.11, 0.17))):
        ridge = base - tall * np.abs(fractal_noise(rng, 2, width, 1, 5, 5)[0])
        c.lay(band(ridge[None] - c.y, 0.0, 0.006), paint)
    water = c.y > 0.585
    ripple = fractal_noise(rng, height, width, 72, 10, 3)
    c.lay(water * 1.0, (0.09, 0.16, 0.24))
    glint = np.exp(-(((c.x - 0.66) / (0.05 + 0.25 * (c.y - 0.55))) ** 2))
    c.lay(np.clip(glint * (0.6 + ripple), 0.0, 1.0) * water, (0.98, 0.66, 0.30))
    c.lay(np.clip(ripple * 0.5 - 0.1, 0.0, 1.0) * water, (0.25, 0.34, 0.42))
    return c.finish(1.0 + 0.07 * fractal_noise(rng, height, width, 96, 96, 2))


def orchard(rng: Rng, height: int = 360, width: int = 288) -> U1:
    """A stippled orchard in blossom."""
    c = _Canvas(height, width, (0.35, 0.52, 0.66))
    c.lay(c.y > 0.55, (0.22, 0.34, 0.09))
    blobs = [(0.30, 0.58, 0.07), (0.72, 0.48, 0.10), (0.5, 0.68, 0.05)]
    for bx, by, size in blobs:
        c.lay(
            band(np.abs(c.x - bx) + 0.02 * np.sin(c.y * 40.0), 0.018, 0.01)
            * (c.y > by - 0.2)
            * (c.y < by + 0.3),
            (0.12, 0.07, 0.04),
        )
        for _ in range(520):
            px, py = rng.normal(bx, size * 1.5), rng.normal(by - 0.22, size)
            r = 3 + int(rng.integers(0, 4))
            row, column = int(py * height), int(px * width)
            spot = c.color[max(row - r, 0) : row + r, max(column - r, 0) : column + r]
            if spot.size:
                pink = rng.uniform(0.75, 1.1)
                spot[:] = (
                    np.array([0.85, 0.55, 0.56]) * pink
                    if rng.random() < 0.7
                    else (np.array([0.20, 0.35, 0.12]) * pink)
                )
    for _ in range(900):
        row, column = int(rng.uniform(0.56, 1.0) * height), int(rng.uniform(0, 1) * width)
        tone = rng.uniform(0.5, 1.6)
        c.color[row : row + 3, column : column + 5] = np.array([0.30, 0.36, 0.08]) * tone
    return c.finish(1.0 + 0.10 * fractal_noise(rng, height, width, 90, 72, 2))


def composition(rng: Rng, height: int = 320, width: int = 320) -> U1:
    """Black bars and plain fields of colour."""
    c = _Canvas(height, width, (0.80, 0.78, 0.70))
    fields = [((0.0, 0.0, 0.34, 0.52), (0.60, 0.05, 0.03)), ((0.70, 0.62, 1.0, 1.0), (0.04, 0.09,
              0.33)), ((0.34, 0.80, 0.70, 1.0), (0.80, 0.55, 0.04)),
              ((0.70, 0.0, 1.0, 0.20), (0.80, 0.55, 0.04))]  # fmt: skip
    for (x0, y0, x1, y1), paint in fields:
        c.lay((c.x > x0) & (c.x < x1) & (c.y > y0) & (c.y < y1), paint)
    for at in (0.34, 0.70):
        c.lay(band(np.abs(c.x - at), 0.013, 0.004), (0.015, 0.015, 0.017))
    for at in (0.20, 0.52, 0.62, 0.80):
        side = c.x > 0.34 if at in (0.20, 0.62) else c.x < 0.70
        c.lay(band(np.abs(c.y - at), 0.013, 0.004) * side, (0.015, 0.015, 0.017))
    return c.finish(1.0 + 0.04 * fractal_noise(rng, height, width, 80, 80, 3))


def botanical(rng: Rng, height: int = 384, width: int = 256) -> U1:
    """A fern pressed on old paper, with a caption."""
    c = _Canvas(height, width, (0.74, 0.68, 0.53))
    green = (0.075, 0.15, 0.055)
    stem = 0.5 + 0.06 * np.sin(c.y * 3.0)
    c.lay(band(np.abs(c.x - stem), 0.006, 0.006) * (c.y > 0.1) * (c.y < 0.86), green)
    for k in range(16):
        at = 0.13 + k * 0.043
        reach = 0.30 * np.sin(np.pi * min((k + 1.5) / 15.0, 1.0)) + 0.03
        for sign in (-1.0, 1.0):
            along = (c.x - stem) * sign
            rise = c.y - at + along * 0.45
            width_here = 0.017 * np.clip(1.0 - along / reach, 0.0, 1.0) ** 0.6
            comb = 0.75 + 0.25 * np.sin(along * 190.0)
            c.lay(
                band(np.abs(rise) - width_here * comb, 0.0, 0.006) * (along > 0) * (along < reach),
                green,
            )
    letters = np.sin(c.x * 240.0) + np.sin(c.x * 97.0 + 1.0) > -0.3
    caption = (np.abs(c.y - 0.925) < 0.008) & (np.abs(c.x - 0.5) < 0.22)
    c.lay(caption & letters, (0.10, 0.07, 0.05))
    c.lay(
        np.minimum(np.minimum(c.x, 1 - c.x) * width, np.minimum(c.y, 1 - c.y) * height) < 3,
        (0.55, 0.48, 0.34),
    )
    return c.finish(1.0 + 0.05 * fractal_noise(rng, height, width, 6, 5, 6))


def rings(rng: Rng, height: int = 320, width: int = 320) -> U1:
    """Squares with concentric circles, four by four."""
    c = _Canvas(height, width, (0.7, 0.65, 0.55))
    paints = rng.uniform(0.02, 1.0, (4, 4, 4, 3)) ** 1.6 * np.array([0.8, 0.6, 0.55])
    row, column = np.floor(c.y * 4).astype(int), np.floor(c.x * 4).astype(int)
    radius = np.hypot(c.x * 4 % 1.0 - 0.5, c.y * 4 % 1.0 - 0.5)
    radius = radius + 0.02 * fractal_noise(rng, height, width, 16, 16, 2)
    c.color = paints[row, column, 0].astype(np.float32)
    for k, size in enumerate((0.44, 0.31, 0.17)):
        mask = band(radius, size, 0.02)[..., None]
        c.color = c.color + mask * (paints[row, column, k + 1].astype(np.float32) - c.color)
    return c.finish(1.0 + 0.10 * fractal_noise(rng, height, width, 60, 60, 3))
