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
    list_lacking,
    list_set,
)

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]

REACH = 2
"""Samples that a rim reaches inward."""


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
def flag_behind(
    own: F4, other: F4, owners: U1, others: U1, bit: int, start: int, count: int, out_flags: U1
) -> None:
    """Flag the samples of a row whose neighbours lie behind an edge, or are missing.

    Straight-line arithmetic on purpose: it vectorises.

    Args:
        own: (count,) disparities.
        other: (count,) those of the neighbours.
        owners: (count,) links of whichever of each two holds the bit of both.
        others: (count,) links of the neighbours.
        bit: RIGHT or DOWN.
        start: place of the first sample among the flags.
        count: how many.
        out_flags: set where it is so, left where not.
    """
    for i in range(count):
        linked = (owners[i] & bit) & ~((others[i] & MIXED) // MIXED * bit)
        behind = np.uint8(not other[i] >= own[i])
        out_flags[np.uint64(start + i)] |= np.uint8(behind & np.uint8(linked == 0))


@inner
def flag_near_sides(disparity: F4, links: U1, v: int, out_flags: U1) -> None:
    """Flag the samples of row v next to an edge, or to nothing, that are its near side."""
    height, width = links.shape
    d, here, next_d, after = disparity[v], links[v], disparity[v, 1:], links[v, 1:]
    out_flags.fill(0)
    flag_behind(d, next_d, here, after, RIGHT, 0, width - 1, out_flags)
    flag_behind(next_d, d, here, here, RIGHT, 1, width - 1, out_flags)
    if v + 1 < height:
        flag_behind(d, disparity[v + 1], here, links[v + 1], DOWN, 0, width, out_flags)
    if v > 0:
        flag_behind(d, disparity[v - 1], links[v - 1], links[v - 1], DOWN, 0, width, out_flags)


@kernel
def mark_rims(
    disparity: F4, tolerance: Real, reach: int, row_low: int, row_high: int, out: U1
) -> None:
    """RIM bits of rows [row_low, row_high), after INTACT is known everywhere.

    A rim is the near side of an edge. Its cells reach so many samples inward: from `REACH` on, no
    pixel of a view of like scale meets the silhouette.
    """
    height, width = disparity.shape
    keep = np.float32(1.0) - np.float32(tolerance)
    near = np.zeros((width + EIGHT - 1) // EIGHT * EIGHT, np.uint8)
    places = np.zeros(near.size, np.int32)
    for v in range(max(row_low - reach, 0), min(row_high + reach + 1, height)):
        flag_near_sides(disparity, out, v, near)
        for k in range(list_set(near, places)):
            u = places[k]
            own = disparity[v, u]
            for j in range(max(v - reach, row_low, 0), min(v + reach, row_high, height - 1)):
                for i in range(max(u - reach, 0), min(u + reach, width - 1)):
                    if out[j, i] & INTACT and disparity[j, i] >= own * keep:
                        out[j, i] |= np.uint8(RIM)
