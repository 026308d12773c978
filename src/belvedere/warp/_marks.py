"""Kernels that mark samples and cells by how they lie to edges, once `_edges` has linked them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import (
    DOWN,
    EIGHT,
    INTACT,
    MIXED,
    RIGHT,
    RIM,
    SMOOTH,
    beyond,
    list_lacking,
)

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]


@inner
def between(low: Real, middle: Real, high: Real) -> bool:
    """Whether the middle value lies strictly between its neighbours, in either direction."""
    return (low < middle < high) or (low > middle > high)


@kernel
def mark_mixed(disparity: F4, row_low: int, row_high: int, out: U1) -> None:
    """MIXED bits: unlinked on two opposite sides, with a disparity between theirs.

    A thin object also stands unlinked on both sides, but nearer than both, and is kept.
    """
    height, width = disparity.shape
    lacks = np.zeros((width + EIGHT - 1) // EIGHT * EIGHT, np.uint8)
    places = np.zeros(lacks.size, np.int32)
    for v in range(row_low, row_high):
        for k in range(list_lacking(out, v, RIGHT | DOWN, lacks, places)):
            u = places[k]
            d = disparity[v, u]
            if np.isnan(d):
                continue
            across = (
                0 < u < width - 1
                and not out[v, u] & RIGHT
                and not out[v, u - 1] & RIGHT
                and between(disparity[v, u - 1], d, disparity[v, u + 1])
            )
            along = (
                0 < v < height - 1
                and not out[v, u] & DOWN
                and not out[v - 1, u] & DOWN
                and between(disparity[v - 1, u], d, disparity[v + 1, u])
            )
            if across or along:
                out[v, u] |= MIXED


@kernel
def mark_intact(row_low: int, row_high: int, out: U1) -> None:
    """INTACT bits of rows [row_low, row_high), after MIXED is known everywhere."""
    height, width = out.shape
    for v in range(row_low, min(row_high, height - 1)):
        for u in range(width - 1):
            top, right, bottom, last = out[v, u], out[v, u + 1], out[v + 1, u], out[v + 1, u + 1]
            sides = top & (right | RIGHT) & (bottom | DOWN) & (RIGHT | DOWN)
            mixed = (top | right | bottom | last) & MIXED
            whole = (sides == RIGHT | DOWN) & (mixed == 0)
            out[v, u] = top | np.uint8(INTACT if whole else 0)


@kernel
def mark_smooth(row_low: int, row_high: int, out: U1) -> None:
    """SMOOTH bits of rows [row_low, row_high), after INTACT is known everywhere."""
    height, width = out.shape
    column = np.empty(width, np.uint8)
    for v in range(max(row_low, 1), min(row_high, height - 2)):
        for u in range(width):
            column[u] = out[v - 1, u] & out[v, u] & out[v + 1, u] & INTACT
        for u in range(1, width - 2):
            out[v, u] |= np.uint8((column[u - 1] & column[u] & column[u + 1]) << 1)


@inner
def undivided(links: U1, v: int, u: int) -> bool:
    """Whether a sample is linked to all four neighbours, none of them a false one."""
    height, width = links.shape
    if v < 1 or u < 1 or v + 1 >= height or u + 1 >= width:
        return False
    here, left, above = links[v, u], links[v, u - 1], links[v - 1, u]
    mixed = (here | left | above | links[v, u + 1] | links[v + 1, u]) & MIXED
    sides = here & (left | DOWN) & (above | RIGHT) & (RIGHT | DOWN)
    return mixed == 0 and sides == RIGHT | DOWN


@kernel
def mark_rims(disparity: F4, tolerance: Real, row_low: int, row_high: int, out: U1) -> None:
    """RIM bits of rows [row_low, row_high), after SMOOTH is known everywhere.

    A rim is the near side of an edge. Its cells reach two samples inward: further in, no pixel of a
    view of like scale meets the silhouette.
    """
    height, width = disparity.shape
    keep = np.float32(1.0) - np.float32(tolerance)
    lacks = np.zeros((width + EIGHT - 1) // EIGHT * EIGHT, np.uint8)
    places = np.zeros(lacks.size, np.int32)
    for v in range(max(row_low - 2, 0), min(row_high + 3, height)):
        for k in range(list_lacking(out, v, SMOOTH, lacks, places)):
            u = places[k]
            if undivided(out, v, u):
                continue
            own = disparity[v, u]
            near = (
                beyond(disparity, out, v, u, 0, 1) or beyond(disparity, out, v, u, 0, -1)
                or beyond(disparity, out, v, u, 1, 0) or beyond(disparity, out, v, u, -1, 0)
            )  # fmt: skip
            if not near:
                continue
            for j in range(max(v - 2, row_low, 0), min(v + 2, row_high, height - 1)):
                for i in range(max(u - 2, 0), min(u + 2, width - 1)):
                    if out[j, i] & INTACT and disparity[j, i] >= own * keep:
                        out[j, i] |= np.uint8(RIM)
