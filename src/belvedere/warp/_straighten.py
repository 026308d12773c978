"""Kernels that correct where an edge runs by where its silhouette does, before and after it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import DOWN, EIGHT, MIXED, RIGHT, all_set

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]

ZERO = np.float32(0.0)
LAST = 254
"""The place of an edge that runs through the next sample."""
ALONG = 3
"""Rows before and after in which a silhouette is followed."""
OWN = 3
"""Weight of an edge's own place in the mean along a silhouette, the others having 1."""


@inner
def is_step(disparity: F4, links: U1, at: int, across: int, bit: int, sign: Real) -> bool:
    """Whether an edge is between a sample and the next, nearer on the side that sign tells."""
    if links[np.uint64(at)] & bit:
        return False
    return (disparity[np.uint64(at)] - disparity[np.uint64(at + across)]) * sign > ZERO


@inner
def turn_at(disparity: F4, links: U1, at: int, across: int, bit: int, sign: Real) -> int:
    """Where a silhouette goes on in a row: 0 straight on, -1 or 1 a sample aside, 2 nowhere."""
    if is_step(disparity, links, at, across, bit, sign):
        return 0
    if is_step(disparity, links, at - across, across, bit, sign):
        return -1
    if is_step(disparity, links, at + across, across, bit, sign):
        return 1
    return 2


@inner
def straightened(
    place: U1, disparity: F4, links: U1, at: int, across: int, along: int, bit: int
) -> int:
    """Where the edge between a sample and the next runs, as its neighbours along it have it.

    A mean over as many rows before as after: a straight line keeps its place. Arrays are flat;
    across and along are the ways in them to the next sample and to the next row of the silhouette.
    """
    sign = disparity[np.uint64(at)] - disparity[np.uint64(at + across)]
    total, weight = OWN * int(place[np.uint64(at)]), OWN
    before, after, aside = at, at, 0
    for _ in range(ALONG):
        first = turn_at(disparity, links, before - along, across, bit, sign)
        second = turn_at(disparity, links, after + along, across, bit, sign)
        if first > 1 or second > 1:
            break
        before, after = before - along + first * across, after + along + second * across
        aside += first + second
        total += int(place[np.uint64(before)]) + int(place[np.uint64(after)]) + LAST * aside
        weight += 2
    return min(max((total + weight // 2) // weight, 0), LAST)


@kernel
def straighten_edges(
    right: U1, down: U1, disparity: F4, links: U1, row_low: int, row_high: int, out_right: U1,
    out_down: U1,
) -> None:  # fmt: skip
    """The places of `find_edges` as the neighbours along the same silhouette have them too.

    What one sample's colours tell is unsure, and where they tell nothing, the stairs that the
    samples make of a silhouette still do: half way up each, a straight line crosses them. Outputs
    come as copies of right and down; next to the picture's border they stay so.
    """
    height, width = disparity.shape
    flat_right, flat_down = right.reshape(-1), down.reshape(-1)
    flat_disparity, flat = disparity.reshape(-1), links.reshape(-1)
    margin = ALONG + 2
    for v in range(row_low, row_high):
        if v < margin or v >= height - margin:
            continue
        for low in range(margin, width - margin, EIGHT):
            count = min(EIGHT, width - margin - low)
            if all_set(flat, v * width + low, count, RIGHT | DOWN):
                continue
            for u in range(low, low + count):
                bits, at = links[v, u], v * width + u
                if bits & MIXED:
                    continue
                if not bits & RIGHT:
                    out_right[v, u] = straightened(
                        flat_right, flat_disparity, flat, at, 1, width, RIGHT
                    )
                if not bits & DOWN:
                    out_down[v, u] = straightened(
                        flat_down, flat_disparity, flat, at, width, 1, DOWN
                    )
