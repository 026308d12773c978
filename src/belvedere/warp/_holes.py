"""Kernels that continue the background into holes, over a pyramid of ever coarser pictures.

Colours are linear with four channels; a missing disparity is NaN.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, kernel

F4 = npt.NDArray[np.float32]
B1 = npt.NDArray[np.bool_]
I8 = npt.NDArray[np.int64]

ZERO = np.float32(0.0)
TINY = np.float32(1e-6)
"""1/metre: surfaces farther than a thousand kilometres are one surface."""


@kernel
def shrink_background(
    color: F4, disparity: F4, tolerance: Real, out_color: F4, out_disparity: F4
) -> None:
    """Halve a picture, each block of 2 x 2 pixels keeping only the farthest surface it shows.

    Args:
        color: (H, W, 4).
        disparity: (H, W).
        tolerance: relative difference in disparity up to which pixels are one surface.
        out_color: (ceil(H / 2), ceil(W / 2), 4) mean colour of that surface, 0 where none.
        out_disparity: same grid: its mean disparity, NaN where none.
    """
    height, width = disparity.shape
    for y in range(out_disparity.shape[0]):
        for x in range(out_disparity.shape[1]):
            rows, columns = min(2 * y + 2, height), min(2 * x + 2, width)
            far = np.float32(np.inf)
            for v in range(2 * y, rows):
                for u in range(2 * x, columns):
                    far = min(far, disparity[v, u])
            limit = far * np.float32(1.0 + tolerance) + TINY
            count, depth = ZERO, ZERO
            c0, c1, c2, c3 = ZERO, ZERO, ZERO, ZERO
            for v in range(2 * y, rows):
                for u in range(2 * x, columns):
                    if disparity[v, u] <= limit:
                        count += np.float32(1.0)
                        depth += disparity[v, u]
                        c0 += color[v, u, 0]
                        c1 += color[v, u, 1]
                        c2 += color[v, u, 2]
                        c3 += color[v, u, 3]
            share = np.float32(1.0) / max(count, np.float32(1.0))
            out_disparity[y, x] = depth * share if count > ZERO else np.float32(np.nan)
            out_color[y, x, 0] = c0 * share
            out_color[y, x, 1] = c1 * share
            out_color[y, x, 2] = c2 * share
            out_color[y, x, 3] = c3 * share


@kernel
def fill_from_coarser(
    coarse_color: F4, coarse_disparity: F4, tolerance: Real, row_low: int, row_high: int,
    out_color: F4, out_disparity: F4,
) -> None:  # fmt: skip
    """Give each missing pixel the farthest of the coarser pixels round it, interpolated.

    Of the nearest four, if one of them shows the farthest surface of the nearest sixteen; else all
    four belong to the foreground beside the hole, and the sixteen are asked.

    Args:
        coarse_color: (h, w, 4), without holes.
        coarse_disparity: (h, w), without holes.
        tolerance: relative difference in disparity up to which pixels are one surface.
        row_low: first row to fill.
        row_high: row after the last.
        out_color: (H, W, 4), read where disparity is known, written where it is not.
        out_disparity: (H, W) likewise.
    """
    width = out_disparity.shape[1]
    rows, columns = coarse_disparity.shape
    for y in range(row_low, row_high):
        for x in range(width):
            if not np.isnan(out_disparity[y, x]):
                continue
            v0, u0 = (y - 1) // 2 - 1, (x - 1) // 2 - 1  # upper left of them; may lie outside
            fv = np.float32(1.75 if y % 2 == 0 else 1.25)  # from the first row to the pixel
            fu = np.float32(1.75 if x % 2 == 0 else 1.25)
            far = np.float32(np.inf)
            for j in range(4):
                for i in range(4):
                    v = min(max(v0 + j, 0), rows - 1)
                    u = min(max(u0 + i, 0), columns - 1)
                    far = min(far, coarse_disparity[v, u])
            limit = far * np.float32(1.0 + tolerance) + TINY
            reach = np.float32(2.0)
            for j in range(1, 3):
                for i in range(1, 3):
                    v = min(max(v0 + j, 0), rows - 1)
                    u = min(max(u0 + i, 0), columns - 1)
                    if coarse_disparity[v, u] <= limit:
                        reach = np.float32(1.0)
            total, depth = ZERO, ZERO
            for k in range(4):
                out_color[y, x, k] = ZERO
            for j in range(4):
                tall = max(reach - abs(np.float32(j) - fv), ZERO)
                for i in range(4):
                    v = min(max(v0 + j, 0), rows - 1)
                    u = min(max(u0 + i, 0), columns - 1)
                    if coarse_disparity[v, u] > limit:
                        continue
                    weight = tall * max(reach - abs(np.float32(i) - fu), ZERO)
                    total += weight
                    depth += weight * coarse_disparity[v, u]
                    for k in range(4):
                        out_color[y, x, k] += weight * coarse_color[v, u, k]
            out_disparity[y, x] = depth / total
            for k in range(4):
                out_color[y, x, k] /= total


@kernel
def soften_filled(
    color: F4, disparity: F4, hole: B1, rows: I8, columns: I8, tolerance: Real,
    out_color: F4, out_disparity: F4,
) -> None:  # fmt: skip
    """Average filled pixels with their filled neighbours, and with known ones of their surface.

    What was taken from different coarser pixels would otherwise meet in hard, square edges.

    Args:
        color: (H, W, 4), without holes.
        disparity: (H, W), without holes.
        hole: (H, W) where they were filled.
        rows: (n,) rows of the filled pixels.
        columns: (n,) their columns.
        tolerance: relative difference in disparity up to which pixels are one surface.
        out_color: (n, 4).
        out_disparity: (n,).
    """
    height, width = disparity.shape
    for n in range(rows.shape[0]):
        y, x = rows[n], columns[n]
        own = disparity[y, x]
        count, depth = ZERO, ZERO
        c0, c1, c2, c3 = ZERO, ZERO, ZERO, ZERO
        for v in range(max(y - 1, 0), min(y + 2, height)):
            for u in range(max(x - 1, 0), min(x + 2, width)):
                delta = disparity[v, u]
                if hole[v, u] or abs(delta - own) <= np.float32(tolerance) * max(delta, own):
                    count += np.float32(1.0)
                    depth += delta
                    c0 += color[v, u, 0]
                    c1 += color[v, u, 1]
                    c2 += color[v, u, 2]
                    c3 += color[v, u, 3]
        out_disparity[n] = depth / count
        out_color[n, 0] = c0 / count
        out_color[n, 1] = c1 / count
        out_color[n, 2] = c2 / count
        out_color[n, 3] = c3 / count
