"""Procedural textures: every surface of the house has detail that a warp can be judged by.

All are (H, W, 3) uint8 sRGB, periodic where the surface repeats them, drawn with edges softened
over a texel so that they are free of jaggies before any filter sees them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import encode_srgb8

Field = npt.NDArray[Any]
"""(H, W) real numbers, one per texel."""
U1 = npt.NDArray[np.uint8]
Rng = np.random.Generator


def value_noise(rng: Rng, height: int, width: int, rows: int, columns: int) -> Field:
    """(height, width) periodic noise in [-1, 1] from a (rows, columns) grid of random values."""
    grid = rng.uniform(-1.0, 1.0, (rows, columns)).astype(np.float32)
    low, high, f = _taps(height, rows)
    tall = grid[low] + f[:, None] * (grid[high] - grid[low])
    low, high, f = _taps(width, columns)
    first = tall[:, low]
    return first + f * (tall[:, high] - first)


def _taps(size: int, cells: int) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], Field]:
    """For each of ``size`` texels: the two grid cells it lies between, and how far along."""
    x = (np.arange(size) + 0.5) * cells / size
    low = np.floor(x).astype(np.intp)
    f = ((x - low) ** 2 * (3.0 - 2.0 * (x - low))).astype(np.float32)
    return low % cells, (low + 1) % cells, f


def fractal_noise(
    rng: Rng, height: int, width: int, rows: int, columns: int, octaves: int = 4
) -> Field:
    """Periodic noise of several scales, about [-1, 1]; each octave doubles the detail."""
    total = np.zeros((height, width), dtype=np.float32)
    for k in range(octaves):
        grid_rows, grid_columns = min(rows << k, height // 2), min(columns << k, width // 2)
        total += value_noise(rng, height, width, grid_rows, grid_columns) * 0.55**k
    return total


def axes(height: int, width: int) -> tuple[Field, Field]:
    """(x, y) of texel centres in [0, 1)."""
    x = (np.arange(width, dtype=np.float32) + 0.5) / width
    y = (np.arange(height, dtype=np.float32) + 0.5) / height
    return np.broadcast_to(x, (height, width)), np.broadcast_to(y[:, None], (height, width))


def band(distance: Field, half_width: float, soft: float) -> Field:
    """1 where ``distance`` < ``half_width``, 0 beyond, softened over ``soft``."""
    return np.clip((half_width - distance) / soft + 0.5, 0.0, 1.0)


def finish(color: npt.NDArray[Any]) -> U1:
    """Linear color in [0, 1], clipped, as sRGB bytes."""
    return encode_srgb8(np.clip(color, 0.0, 1.0).astype(np.float32))


def tint(value: Field, color: tuple[float, float, float]) -> Field:
    """(H, W, 3) a color times a value per texel."""
    return value[..., None] * np.array(color, dtype=np.float32)


def planks(rng: Rng, size: int = 1024, rows: int = 16, boards: int = 2) -> U1:
    """A floor of boards: tone and grain differ per board, dark joints between them."""
    x, y = axes(size, size)
    row = np.floor(y * rows).astype(int)
    shift = (np.arange(rows) * 0.382 + rng.uniform(-0.08, 0.08, rows)).astype(np.float32)[row]
    along = (x + shift) % 1.0 * boards
    board = row * boards + np.floor(along).astype(int)
    count = rows * boards
    grain = fractal_noise(rng, size, size, 128, 4, 4) * 0.6 + fractal_noise(rng, size, size, 24, 3)
    texel = np.arange(size)
    roll_x, roll_y = rng.integers(0, size, count)[board], rng.integers(0, size, count)[board]
    grain = grain[(texel[:, None] + roll_y) % size, (texel[None] + roll_x) % size]
    rings = np.sin((grain * 2.2 + (y * rows % 1.0) * 5.0) * 4.0)
    tone = rng.uniform(0.72, 1.18, count).astype(np.float32)[board]
    warm = rng.uniform(-0.06, 0.06, count).astype(np.float32)[board]
    value = tone * (1.0 + 0.16 * grain + 0.07 * rings)
    edge = np.minimum(y * rows % 1.0, 1.0 - y * rows % 1.0) / rows
    end = np.minimum(along % 1.0, 1.0 - along % 1.0) / boards
    joint = np.maximum(band(edge, 0.0011, 0.0012), band(end, 0.0011, 0.0012))
    value = value * (1.0 - 0.72 * joint)
    color = tint(value, (0.37, 0.205, 0.098))
    color[..., 2] *= 1.0 - warm
    color[..., 0] *= 1.0 + warm
    return finish(color)


def wood(rng: Rng, color: tuple[float, float, float], size: int = 512) -> U1:
    """Sawn wood, grain along u."""
    _, y = axes(size, size)
    bend = fractal_noise(rng, size, size, 3, 2, 3)
    fine = fractal_noise(rng, size, size, 96, 4, 3)
    rings = np.sin((y * 9.0 + bend * 1.1) * 2.0 * np.pi)
    pores = np.clip(value_noise(rng, size, size, 256, 12) - 0.45, 0.0, 1.0)
    return finish(tint(1.0 + 0.13 * rings + 0.16 * fine - 0.5 * pores, color))


def plaster(rng: Rng, size: int = 512) -> U1:
    """White plaster with the trowel's marks: meant to be tinted by a base color."""
    cloud = fractal_noise(rng, size, size, 5, 5, 6)
    return finish(tint(0.86 + 0.022 * cloud, (1.0, 1.0, 1.0)))


def cement_tiles(rng: Rng, size: int = 768, tiles: int = 4) -> U1:
    """Patterned floor tiles, eight-pointed stars in circles, with grout and wear."""
    x, y = axes(size, size)
    u, v = x * tiles % 1.0 - 0.5, y * tiles % 1.0 - 0.5
    soft = 1.5 * tiles / size
    radius, corner = np.hypot(u, v), np.hypot(np.abs(u) - 0.5, np.abs(v) - 0.5)
    square = np.maximum(np.abs(u), np.abs(v))
    diamond = (np.abs(u) + np.abs(v)) / np.sqrt(2.0)
    star = np.minimum(square, diamond)
    cream, blue = np.array([0.66, 0.61, 0.52]), np.array([0.085, 0.17, 0.25])
    rust, sand = np.array([0.42, 0.15, 0.08]), np.array([0.47, 0.40, 0.30])
    color = np.broadcast_to(cream, (size, size, 3)).astype(np.float32)

    def paint(mask: Field, paint_color: npt.NDArray[np.float64]) -> None:
        nonlocal color
        color = color + mask[..., None] * (paint_color.astype(np.float32) - color)

    paint(band(np.abs(corner - 0.31), 0.045, soft), blue)
    paint(band(corner, 0.17, soft), rust)
    paint(band(corner, 0.09, soft), cream)
    paint(band(star, 0.235, soft), blue)
    paint(band(star, 0.19, soft), sand)
    paint(band(radius, 0.12, soft), rust)
    paint(band(radius, 0.055, soft), cream)
    wear = fractal_noise(rng, size, size, 9, 9, 5)
    tile = rng.uniform(0.92, 1.06, (tiles, tiles)).astype(np.float32)
    tone = tile[np.floor(y * tiles).astype(int), np.floor(x * tiles).astype(int)]
    color *= (tone * (1.0 + 0.07 * wear))[..., None]
    paint(band(0.5 - square, 0.008, soft), np.array([0.30, 0.28, 0.25]))
    return finish(color)


def bricks(
    rng: Rng,
    color: tuple[float, float, float],
    grout: tuple[float, float, float],
    rows: int,
    columns: int,
    size: int = 512,
    vary: float = 0.25,
    joint: float = 0.05,
) -> U1:
    """Running bond: bricks or glazed wall tiles. ``joint`` is a share of a brick's height."""
    x, y = axes(size, size)
    row = np.floor(y * rows).astype(int)
    along = (x * columns + 0.5 * (row % 2)) % columns
    tone = 1.0 + vary * rng.uniform(-1.0, 1.0, (rows, columns)).astype(np.float32)
    hue = 1.0 + 0.3 * vary * rng.uniform(-1.0, 1.0, (rows, columns, 3)).astype(np.float32)
    column = np.floor(along).astype(int)
    rough = fractal_noise(rng, size, size, 16, 16, 5)
    value = tone[row, column] * (1.0 + 0.35 * vary * rough)
    face = tint(value, color) * hue[row, column]
    edge = np.minimum(y * rows % 1.0, 1.0 - y * rows % 1.0) / rows
    end = np.minimum(along % 1.0, 1.0 - along % 1.0) / columns
    mask = band(np.minimum(edge, end), joint / rows, 1.5 / size)
    return finish(face + mask[..., None] * (tint(1.0 + 0.2 * rough, grout) - face))


def weave(rng: Rng, size: int = 256, threads: int = 32) -> U1:
    """Plain cloth, nearly white: meant to be tinted by a base color."""
    x, y = axes(size, size)
    u, v = x * threads, y * threads
    over = (np.floor(u) + np.floor(v)) % 2
    round_u = np.sin(np.pi * (u % 1.0)) ** 0.7
    round_v = np.sin(np.pi * (v % 1.0)) ** 0.7
    cloth = np.where(over > 0, round_u * (0.7 + 0.3 * round_v), round_v * (0.7 + 0.3 * round_u))
    slub = fractal_noise(rng, size, size, 8, 8, 4)
    return finish(tint(0.5 + 0.42 * cloth + 0.06 * slub, (1.0, 1.0, 1.0)))


def marble(rng: Rng, size: int = 512) -> U1:
    """A pale stone with grey veins."""
    x, y = axes(size, size)
    bend = fractal_noise(rng, size, size, 4, 4, 6)
    vein = np.abs(np.sin((x + y + 0.35 * bend) * 2.0 * np.pi))
    line = np.clip(1.0 - vein * 4.0, 0.0, 1.0) ** 2
    return finish(tint(0.72 + 0.05 * bend - 0.28 * line, (1.0, 0.98, 0.95)))


def checker(
    rng: Rng, light: tuple[float, float, float], dark: tuple[float, float, float], size: int = 768
) -> U1:
    """Two stones laid in turn, four slabs each way, veined and a little uneven in tone."""
    x, y = axes(size, size)
    column, row = np.floor(x * 4.0).astype(int), np.floor(y * 4.0).astype(int)
    bend = fractal_noise(rng, size, size, 5, 5, 6)
    shift = rng.uniform(0.0, 6.0, (4, 4)).astype(np.float32)[row, column]
    vein = np.clip(1.0 - np.abs(np.sin((x + 1.7 * y + 0.4 * bend + shift) * 6.3)) * 6.0, 0.0, 1.0)
    tone = rng.uniform(0.92, 1.06, (4, 4)).astype(np.float32)[row, column] * (1.0 + 0.05 * bend)
    odd = ((row + column) % 2)[..., None]
    color = tint(tone * (1.0 - 0.30 * vein), light) * (1 - odd)
    color = color + (tint(tone, dark) + tint(vein * 0.08, (1.0, 1.0, 1.0))) * odd
    u, v = x * 4.0 % 1.0, y * 4.0 % 1.0
    edge = np.minimum(np.minimum(u, 1.0 - u), np.minimum(v, 1.0 - v))
    joint = band(edge, 0.006, 0.008)[..., None]
    return finish(color + joint * (np.float32(0.22) - color))


def patchwork(
    rng: Rng, colors: tuple[tuple[float, float, float], ...], size: int = 512, squares: int = 6
) -> U1:
    """A quilt of squares with triangles in them, stitched along the seams."""
    x, y = axes(size, size)
    u, v = x * squares % 1.0, y * squares % 1.0
    cell = np.floor(y * squares).astype(int), np.floor(x * squares).astype(int)
    turn = rng.integers(0, 4, (squares, squares))[cell]
    a = np.where(turn % 2 == 0, u, 1.0 - u)
    first = band(a - v, 0.0, 2.0 * squares / size)
    tone = rng.uniform(0.75, 1.15, (squares, squares)).astype(np.float32)[cell]
    other = rng.uniform(0.75, 1.15, (squares, squares)).astype(np.float32)[cell]
    color = tint(tone * first, colors[0]) + tint(other * (1.0 - first), colors[1])
    edge = np.minimum(np.minimum(u, 1.0 - u), np.minimum(v, 1.0 - v))
    puff = 0.78 + 0.28 * np.clip(edge * 5.0, 0.0, 1.0) ** 0.5
    thread = 1.0 + 0.06 * fractal_noise(rng, size, size, 64, 64, 2)
    return finish(color * (puff * thread)[..., None])


def globe(rng: Rng, height: int = 256, width: int = 512) -> U1:
    """A made-up world: seas, lands by height, ice, and a net of meridians."""
    x, y = axes(height, width)
    land = fractal_noise(rng, height, width, 4, 6, 6) - 0.10
    coast = band(-land, 0.0, 0.03)
    color = tint(1.0 + 0.1 * land, (0.10, 0.22, 0.32))
    ground = tint(1.0 - 0.35 * land, (0.50, 0.42, 0.22)) * np.array([1.0, 1.0, 1.0], np.float32)
    color = color + coast[..., None] * (ground - color)
    ice = band(np.minimum(y, 1.0 - y), 0.07, 0.02)[..., None]
    color = color + ice * (np.float32(0.72) - color)
    u, v = x * 24.0 % 1.0, y * 12.0 % 1.0
    net = band(np.minimum(np.minimum(u, 1 - u), np.minimum(v, 1 - v)), 0.02, 0.03)[..., None]
    return finish(color * (1.0 - 0.35 * net))
