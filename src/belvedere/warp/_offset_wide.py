"""Which cells of the reference have wide sub-samples, and which need a fine lattice all the same.

Where a surface goes on all round, one sub-sample in each output pixel tells all: what the pixel
sees, and where in the reference its centre comes from. So a lattice needs to be only as fine as the
picture there, and as fine as the warp buffer beside edges and where the picture is the coarser of
the two.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner
from belvedere.warp._edges import SMOOTH

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]
U8 = npt.NDArray[np.uint64]

LEAST = np.float32(0.5**2)
"""Square of the growth along the direction that shrinks most, below which a pixel needs a filter
over more than the samples round its centre."""
AMPLE = np.float32(0.6**2)
"""The same, below which the fine lattice is laid too: there must be no gap where it begins."""
APART = 2
"""Cells between one with an edge round it and the first that needs no fine lattice: an output pixel
may reach as far."""


@inner
def grows(area: Real, squares: Real, least: Real) -> bool:
    """Whether a cell shrinks in no direction to less than the root of ``least``.

    With s and t the least and the greatest growth, the area is s t and the squares of the sides'
    lengths add up to s^2 + t^2; at a given area that sum falls with s up to t. One that is turned
    over does not grow.
    """
    return (area >= least) & (squares * least <= least * least + area * area)


@inner
def read_wide(
    flags: U1, xa: F4, ya: F4, xb: F4, yb: F4, count: int, out_wide: U8, out_ample: U1
) -> bool:  # fmt: skip
    """Which cells of a run have wide sub-samples, and which amply; whether any has.

    Args:
        flags: (count,) bits of `_edges`.
        xa: where the upper corners land, pixels.
        ya: ...
        xb: and the lower ones.
        yb: ...
        count: cells.
        out_wide: (count,) 1 or 0.
        out_ample: (count,) 1 or 0.
    """
    some = np.uint64(0)
    for i in range(count):
        ux, uy, vx, vy = xa[i + 1] - xa[i], ya[i + 1] - ya[i], xb[i] - xa[i], yb[i] - ya[i]
        area, squares = ux * vy - uy * vx, ux * ux + uy * uy + vx * vx + vy * vy
        out_ample[i] = np.uint8(1 if grows(area, squares, AMPLE) else 0)
        wide = np.uint64(1 if (flags[i] & SMOOTH != 0) & grows(area, squares, LEAST) else 0)
        out_wide[i] = wide
        some |= wide
    return some != np.uint64(0)


@inner
def fine_part(
    links: U1, v: int, u_low: int, count: int, ample: U1, out_column: U1
) -> tuple[int, int]:
    """First and end of the cells of a run that need the fine lattice.

    The first is not below the end where none does.

    Args:
        links: (H, W) bits of `_edges`.
        v: row of cells.
        u_low: the run's first column.
        count: cells.
        ample: (count,) from `read_wide`.
        out_column: (count + 2 APART,) to work in.
    """
    rows, stride = links.shape
    if v < APART or v + APART >= rows:
        return 0, count
    start, end = max(u_low - APART, 0), min(u_low + count + APART, stride)
    shift = start - (u_low - APART)
    if shift > 0 or end < u_low + count + APART:
        out_column[:] = np.uint8(0)
    for i in range(end - start):
        column = links[v, start + i]
        for k in range(1, APART + 1):
            column &= links[v - k, start + i] & links[v + k, start + i]
        out_column[shift + i] = column
    first, last = np.int32(count), np.int32(-1)
    for i in range(count):
        bits = out_column[i] & out_column[i + 1] & out_column[i + 2]
        bits &= out_column[i + 3] & out_column[i + 4] & SMOOTH
        place = np.int32(i)
        deep = (bits != 0) & (ample[i] != np.uint8(0))
        low = np.int32(count) if deep else place
        high = np.int32(-1) if deep else place
        first = np.int32(low if low < first else first)
        last = np.int32(high if high > last else last)
    return int(first), int(last) + 1
