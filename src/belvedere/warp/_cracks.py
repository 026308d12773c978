"""Kernels of the inverse pass that tell cracks from exposures."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import EIGHT, list_set
from belvedere.warp._landing import Geometry, land

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
HOLE = np.float32(-1.0)
FAINT = np.float32(1e-12)
"""A disparity as good as 0: a mark of unsureness makes one of infinitely far surfaces."""


@inner
def across_crack(centers: F4, n: int, y: int, x: int, dy: int, dx: int, keep: Real) -> Real:
    """The disparity on both sides of a pixel in one layer, or -1 if that is no crack."""
    a, b = centers[n, y - dy, x - dx], centers[n, y + dy, x + dx]
    low, high = min(a, b), max(a, b)
    if low < ZERO:
        return HOLE
    return HALF * (a + b) if low >= high * keep else low


@inner
def beside_edge(centers: F4, edges: F4, y: int, x: int, keep: Real) -> Real:
    """The nearest surface next to a pixel behind the one whose edge runs through it, -1 if none."""
    count, rows, width = centers.shape
    nearest, best = HOLE, HOLE
    for n in range(count):
        nearest = max(nearest, edges[n, y, x])
    for j in range(max(y - 1, 0), min(y + 2, rows)):
        for i in range(max(x - 1, 0), min(x + 2, width)):
            for n in range(count):
                other = centers[n, j, i]
                if other < nearest * keep:
                    best = max(best, other)
    return best


@kernel
def find_cracks(
    centers: F4,
    edges: F4,
    tolerance: Real,
    out_front: F4,
    out_index: I4,
    out_value: F4,
    out_seen: U1,
) -> int:
    """The nearest surface at each centre, and the holes one pixel wide that may be cracks.

    Args:
        centers: (n, rows, width) disparity each reference sees at the pixel's centre, -1 = none.
        edges: (n, rows, width) that of its nearest surface near an edge, -1 = none.
        tolerance: relative difference of disparities that are one surface.
        out_front: (rows, width) the largest.
        out_index: (rows * width,) flat indices of the holes.
        out_value: (rows * width,) the disparity on both sides of each, the farther if they differ;
            in a pixel that an edge runs through, what is next to it behind the edge.
        out_seen: (rows * width,) set to 0 for each.

    Returns:
        How many holes those are.
    """
    count, rows, width = centers.shape
    keep = ONE - np.float32(tolerance)
    for y in range(rows):
        for x in range(width):
            out_front[y, x] = centers[0, y, x]
        for n in range(1, count):
            for x in range(width):
                out_front[y, x] = max(out_front[y, x], centers[n, y, x])
    found = 0
    open_pixels = np.zeros((width + EIGHT - 1) // EIGHT * EIGHT, np.uint8)
    places = np.empty(open_pixels.size, np.int32)
    for y in range(1, rows - 1):
        above, here, below = out_front[y - 1], out_front[y], out_front[y + 1]
        for x in range(1, width - 1):  # most holes are wider, and no edge runs through them
            narrow = min(here[x - 1], here[x + 1]) >= ZERO or min(above[x], below[x]) >= ZERO
            open_pixels[x] = np.uint8((here[x] < ZERO) & narrow)
        for n in range(count):
            ends = edges[n, y]
            for x in range(1, width - 1):
                open_pixels[x] |= np.uint8((here[x] < ZERO) & (ends[x] >= ZERO))
        for k in range(list_set(open_pixels, places)):
            x, best = places[k], HOLE
            for n in range(count):
                best = max(best, across_crack(centers, n, y, x, 0, 1, keep))
                best = max(best, across_crack(centers, n, y, x, 1, 0, keep))
            if best < ZERO:
                best = beside_edge(centers, edges, y, x, keep)
            if best >= ZERO:
                out_index[found], out_value[found] = y * width + x, best
                out_seen[found] = 0
                found += 1
    return found


@kernel
def witness_cracks(
    back: Geometry, disparity: F4, index: I4, value: F4, count: int, width: int, row_low: int,
    tolerance: Real, out_seen: U1,
) -> None:  # fmt: skip
    """Mark the holes in which this reference has a sample of the surface on their sides.

    That tells a crack, which no sample happened to reach, from an exposure as narrow. The nearest
    sample decides, or those round the place where that one is missing.

    Args:
        back: geometry from the desired view to this reference; between planes its (12,) matrix.
        disparity: (H, W) of this reference.
        index: (count,) holes from `find_cracks`.
        value: (count,) disparities on their sides.
        count: how many.
        width: of the desired view.
        row_low: desired row of the first row of layers.
        tolerance: relative difference of disparities that are one surface.
        out_seen: (count,) 1 where it has one.
    """
    height, stride = disparity.shape
    last_u, last_v = np.float32(stride) - HALF, np.float32(height) - HALF
    for k in range(count):
        x4, y4 = np.float32(index[k] % width), np.float32(index[k] // width + row_low)
        delta = value[k]
        u, v, scale = land(back, x4, y4, delta)
        if not (u >= -HALF and v >= -HALF and u < last_u and v < last_v):
            continue
        own, near = delta * scale, np.float32(tolerance) * delta * scale + FAINT
        nearest = disparity[int(v + HALF), int(u + HALF)]
        if not np.isnan(nearest):
            out_seen[k] |= np.uint8(abs(nearest - own) <= near)
            continue
        for j in range(max(int(v), 0), min(int(v) + 2, height)):
            for i in range(max(int(u), 0), min(int(u) + 2, stride)):
                out_seen[k] |= np.uint8(abs(disparity[j, i] - own) <= near)
