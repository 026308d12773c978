"""Loops that put portal images behind the view cell's geometry. Private."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import inner, kernel

A = npt.NDArray[Any]

NEARER = 0.97
"""Surfaces whose disparities differ by less than this ratio may be one."""


@inner
def row_within(matrix: A, planes: A, y: int, low: int, high: int, out_ends: A) -> None:
    """Columns [out_ends[0], out_ends[1]) of a row, between low and high, whose rays lie in planes.

    Along a row each plane's distance from the ray's tip changes evenly, so each cuts off one end.
    """
    first, end = np.float64(low), np.float64(high)
    for k in range(planes.shape[0]):
        start, slope = 0.0, 0.0
        for c in range(3):
            start += planes[k, c] * (matrix[c, 1] * y + matrix[c, 2])
            slope += planes[k, c] * matrix[c, 0]
        if slope > 0.0:
            first = max(first, np.ceil(-start / slope))
        elif slope < 0.0:
            end = min(end, np.floor(-start / slope) + 1.0)
        elif start < 0.0:
            end = first
    out_ends[0], out_ends[1] = int(first), max(int(end), int(first))


@kernel
def show_through(
    matrix: A, planes: A, normal: A, share: float, u0: int, v0: int, first: int, end: int, color: A,
    disparity: A, coverage: A, weight: float, decode: A, encode: A, merge: bool, persist: bool,
    out_kept: A, out_color: A, out_disparity: A, out_coverage: A,
) -> None:  # fmt: skip
    """Show rows of a warped crop through a portal, where nothing stands before the portal's plane.

    Args:
        matrix: (3, 3) of the window's camera.
        planes: (K, 3) of the frustum through the portal, pointing inwards.
        normal: (3,) of the portal.
        share: ``normal @ ray * share`` is the disparity of the portal's plane.
        u0: column of the crop's first pixel in the window.
        v0: row of it.
        first: row of the crop to begin with.
        end: row after the last.
        color: (h, w, 3) uint8 of the crop.
        disparity: (h, w).
        coverage: (h, w); 0 is a hole.
        weight: of the crop against what is there already; below 1 while a portal fades.
        decode: (256,) linear light of each byte.
        encode: (N,) the byte of linear light ``x`` at ``sqrt(x) * (N - 1)``.
        merge: leave what is there in a hole, and where it is clearly nearer.
        persist: show in a hole what was seen there last; without, the window's color stays.
        out_kept: (H, W, 3) uint8, what was seen last through portals; renewed where ``persist``.
        out_color: (H, W, 3) uint8 of the window, with the geometry drawn.
        out_disparity: (H, W).
        out_coverage: (H, W).
    """
    steps, width = encode.shape[0] - 1, disparity.shape[1]
    ends = np.empty(2, np.int64)
    for v in range(first, end):
        y = v + v0
        row_within(matrix, planes, y, u0, u0 + width, ends)
        start, slope = 0.0, 0.0
        for c in range(3):
            start += normal[c] * (matrix[c, 1] * y + matrix[c, 2]) * share
            slope += normal[c] * matrix[c, 0] * share
        for x in range(ends[0], ends[1]):
            if out_disparity[y, x] >= start + slope * x:
                continue
            u = x - u0
            seen = coverage[v, u] > 0.0
            if merge:
                if not seen:
                    continue
                if out_coverage[y, x] > 0.0 and out_disparity[y, x] * NEARER > disparity[v, u]:
                    continue
            if weight < 1.0:
                if seen:
                    for c in range(3):
                        mixed = weight * decode[color[v, u, c]]
                        mixed += (1.0 - weight) * decode[out_color[y, x, c]]
                        out_color[y, x, c] = encode[int(np.sqrt(mixed) * steps + 0.5)]
                continue
            out_coverage[y, x] = coverage[v, u]
            out_disparity[y, x] = disparity[v, u] if seen else np.nan
            for c in range(3):
                if seen:
                    out_color[y, x, c] = color[v, u, c]
                    if persist:
                        out_kept[y, x, c] = color[v, u, c]
                elif persist:
                    out_color[y, x, c] = out_kept[y, x, c]


@kernel
def list_holes(coverage: A, out_index: A) -> int:
    """Flat indices of the pixels that nothing covers, in order; how many there are.

    Args:
        coverage: (N,).
        out_index: (N,) int32.
    """
    count = 0
    for i in range(coverage.shape[0]):
        out_index[count] = i
        count += coverage[i] == 0.0
    return count
