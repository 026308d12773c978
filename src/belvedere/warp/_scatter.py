"""Kernels of the scattering reconstructors: which sample each desired pixel sees.

Samples are scattered once, as indices: colour follows afterwards, whatever its type and channels.
Each kernel works on one band of the desired view with a halo round it, cells whose upper left one
is pixel (x_low, y_low). Samples are visited tile by tile in occlusion-compatible order, so the
result does not depend on how the view was cut into bands.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._tiles import TILE

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]

HALF = np.float32(0.5)
ONE = np.float32(1.0)
ZERO = np.float32(0.0)
TURNED = np.float32(0.7072)
"""Half the side, in spacings, of the smallest upright squares that leave no gap round the points of
a square lattice, however it is turned: half the diagonal, and a rounding more."""


@inner
def land_row(
    w: F4, v: int, u_low: int, count: int, disparity: F4, halo: int, y_low: int, columns: int,
    first: int, end: int, out_cell: I4, out_delta: F4,
) -> None:  # fmt: skip
    """Cell (or -1) and warped disparity of ``count`` samples of one reference row.

    w is the warp matrix, (12,) row by row; cell (0, 0) is pixel (-halo, y_low), and samples that
    land in rows of pixels [first, end) count. Straight-line arithmetic on purpose: it vectorises.
    Places are rounded before ``y_low`` comes in, so that they are the same for every band.
    """
    v4 = np.float32(v)
    r0 = w[1] * v4 + w[2]
    s0 = w[5] * v4 + w[6]
    t0 = w[9] * v4 + w[10]
    shift = HALF + np.float32(halo)
    right, top, bottom = np.float32(columns), np.float32(first + halo), np.float32(end + halo)
    row_low = np.int32(y_low + halo)
    for i in range(count):
        u = np.float32(u_low + i)
        delta = disparity[v, u_low + i]
        t = w[8] * u + t0 + w[11] * delta
        scale = ONE / t
        x = (w[0] * u + r0 + w[3] * delta) * scale + shift
        y = (w[4] * u + s0 + w[7] * delta) * scale + shift
        inside = (t > ZERO) & (x >= ZERO) & (x < right) & (y >= top) & (y < bottom)
        x = x if inside else ZERO
        y = y if inside else ZERO
        cell = (np.int32(y) - row_low) * np.int32(columns) + np.int32(x)
        out_cell[i] = cell if inside else np.int32(-1)
        out_delta[i] = delta * scale


@kernel
def scatter(
    w: F4, disparity: F4, tiles: I4, halo: int, y_low: int, columns: int, rows: int, height: int,
    by_order: bool, out_sample: I4, out_disparity: F4,
) -> None:  # fmt: skip
    """Each sample lands in the one cell whose square holds it.

    Args:
        w: (12,) warp matrix.
        disparity: (H, W).
        tiles: (n, FIELDS) from `list_tiles`.
        halo: cells left of the desired view's first column.
        y_low: desired row of the first cell, at least -halo.
        columns: cells across.
        rows: cells down.
        height: of the whole desired view.
        by_order: later samples win (painter's); otherwise the larger disparity wins.
        out_sample: (rows * columns,) ``v * W + u`` of the sample seen, preset to -1.
        out_disparity: (rows * columns,) its warped disparity, preset to -1.
    """
    stride = disparity.shape[1]
    cells = np.empty(TILE, np.int32)
    delta = np.empty(TILE, np.float32)
    for n in range(tiles.shape[0]):
        if tiles[n, 7] <= y_low or tiles[n, 6] >= y_low + rows:
            continue
        u_low, count, u_step = tiles[n, 0], tiles[n, 1] - tiles[n, 0], tiles[n, 2]
        # what float32 lands outside the tile's float64 bounds is noise: the same for every band
        top = max(tiles[n, 6], y_low) if tiles[n, 6] > 0 else y_low
        bottom = min(tiles[n, 7], y_low + rows) if tiles[n, 7] < height else y_low + rows
        for j in range(tiles[n, 4] - tiles[n, 3]):
            v = tiles[n, 3] + j if tiles[n, 5] > 0 else tiles[n, 4] - 1 - j
            land_row(w, v, u_low, count, disparity, halo, y_low, columns, top, bottom, cells, delta)
            first = v * stride + u_low
            if not by_order:
                for i in range(count):
                    cell = cells[i]
                    if cell >= 0 and delta[i] > out_disparity[cell]:
                        out_disparity[cell] = delta[i]
                        out_sample[cell] = first + i
            elif u_step > 0:
                for i in range(count):
                    cell = cells[i]
                    if cell >= 0:
                        out_disparity[cell] = delta[i]
                        out_sample[cell] = first + i
            else:
                for i in range(count - 1, -1, -1):
                    cell = cells[i]
                    if cell >= 0:
                        out_disparity[cell] = delta[i]
                        out_sample[cell] = first + i


@kernel
def gather(color: Any, sample: I4, out_color: Any) -> None:
    """Fetch the colour of the sample each pixel sees; 0 where there is none.

    color is (H * W, C), sample (rows, width), out_color (rows, width, C).
    """
    rows, width = sample.shape
    channels = color.shape[1]
    none = color.dtype.type(0)
    for y in range(rows):
        for x in range(width):
            index = sample[y, x]
            held, index = index >= 0, max(index, 0)
            out_color[y, x, 0] = color[index, 0] if held else none
            out_color[y, x, 1] = color[index, 1] if held else none
            out_color[y, x, 2] = color[index, 2] if held else none
            if channels == 4:
                out_color[y, x, 3] = color[index, 3] if held else none


@inner
def area_scale(t: Real, delta: Real, det_h: Real, det_g: Real) -> Real:
    """Linear growth of a sample facing the reference plane: the square root of ``|det J|``."""
    return np.sqrt(abs(det_h + delta * det_g) / (t * t * t))


@kernel
def measure_growth(
    w: F4, disparity: F4, det_h: Real, det_g: Real, sample: I4, largest: int, out_radius: U1
) -> int:
    """How many cells away each visible sample can still paint; returns the most found.

    Args:
        w: (12,) warp matrix.
        disparity: (H, W) of the reference.
        det_h: determinant of columns 1, 2, 3 of W.
        det_g: determinant of columns 1, 2, 4 of W.
        sample: (rows, columns) from `scatter`.
        largest: upper bound.
        out_radius: (rows, columns).

    Source: spec image-warping 3.7 (determinant), portal-walkthrough 3.6.
    """
    stride = disparity.shape[1]
    h4, g4 = np.float32(det_h), np.float32(det_g)
    found = 0
    for y in range(sample.shape[0]):
        for x in range(sample.shape[1]):
            index = sample[y, x]
            out_radius[y, x] = 0
            if index < 0:
                continue
            v, u = index // stride, index % stride
            delta = disparity[v, u]
            t = w[8] * np.float32(u) + w[9] * np.float32(v) + w[10] + w[11] * delta
            growth = area_scale(t, delta, h4, g4)
            if growth > np.float32(1.001):  # a thousandth is float32's noise, not growth
                cells = TURNED * growth + HALF
                radius = int(cells) if cells < np.float32(largest) else largest
                out_radius[y, x] = radius
                found = max(found, radius)
    return found


@kernel
def spread(
    w: F4, reference: F4, det_h: Real, det_g: Real, size: int, sample: I4, disparity: F4,
    radius: U1, reach: int, halo: int, row_low: int, tolerance: Real,
    out_sample: I4, out_disparity: F4,
) -> None:  # fmt: skip
    """Let each visible sample paint a square: a pixel goes to the front surface that reaches it.

    Squares stand round the places where the samples really landed, and among those of one surface
    the nearest center wins: splats do not push each other aside, textures stay in place, and a
    nearer surface covers what shows through its gaps.

    Args:
        w: (12,) warp matrix.
        reference: (H, W) disparity of the reference.
        det_h: determinant of columns 1, 2, 3 of W.
        det_g: determinant of columns 1, 2, 4 of W.
        size: side of every square, pixels; 0: as large as each sample has grown.
        sample: (rows + 2 halo, width + 2 halo) from `scatter`.
        disparity: same shape, -1 = uncovered.
        radius: same shape: how many cells away each sample can paint at most.
        reach: largest radius present, at most halo.
        halo: cells round the band.
        row_low: the band's first row in the desired view.
        tolerance: relative difference in disparity up to which samples are one surface.
        out_sample: (rows, width).
        out_disparity: (rows, width), -1 = uncovered.
    """
    rows, width = out_sample.shape
    columns = width + 2 * halo
    stride = reference.shape[1]
    h4, g4 = np.float32(det_h), np.float32(det_g)
    front = np.empty(width, np.float32)
    highest = np.empty(columns, np.float32)
    keep = np.float32(1.0 - tolerance)
    for y in range(rows):
        row = y + halo
        # the most that any sample in reach could put in front: mostly the pixel's own
        for x in range(width):
            front[x] = disparity[row, x + halo]
        for r in range(1, reach + 1):
            highest[:] = np.float32(-1.0)
            for dy in range(-r, r + 1):
                for x in range(columns):
                    delta = disparity[row + dy, x]
                    delta = delta if radius[row + dy, x] >= r else np.float32(-1.0)
                    highest[x] = delta if delta > highest[x] else highest[x]
            for dx in range(-r, r + 1):
                for x in range(width):
                    delta = highest[x + halo + dx]
                    front[x] = delta if delta > front[x] else front[x]
        for x in range(width):
            own = disparity[row, x + halo]
            out_sample[y, x] = sample[row, x + halo]
            out_disparity[y, x] = own
            if own >= front[x] * keep or front[x] < ZERO:
                continue
            best, near = np.float32(-1.0), np.float32(np.inf)
            for dy in range(-reach, reach + 1):
                for dx in range(-reach, reach + 1):
                    held = disparity[row + dy, x + halo + dx]
                    if held < best * keep or radius[row + dy, x + halo + dx] < max(
                        abs(dy), abs(dx)
                    ):
                        continue
                    if held < ZERO:
                        continue
                    index = sample[row + dy, x + halo + dx]
                    v, u = index // stride, index % stride
                    v4, u4, delta = np.float32(v), np.float32(u), reference[v, u]
                    t = w[8] * u4 + w[9] * v4 + w[10] + w[11] * delta
                    off_x = (w[0] * u4 + w[1] * v4 + w[2] + w[3] * delta) / t - np.float32(x)
                    off_y = (w[4] * u4 + w[5] * v4 + w[6] + w[7] * delta) / t - np.float32(
                        row_low + y
                    )
                    half = HALF * np.float32(size)
                    if size == 0:
                        half = max(TURNED * area_scale(t, delta, h4, g4), HALF)
                    if abs(off_x) > half or abs(off_y) > half:
                        continue
                    distance = off_x * off_x + off_y * off_y
                    if held * keep > best or distance < near:
                        best, near = held, distance
                        out_sample[y, x] = index
                        out_disparity[y, x] = held
