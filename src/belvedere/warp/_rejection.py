"""Kernels of the inverse pass in which references check one another."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import EIGHT, INTACT, list_set
from belvedere.warp._landing import Geometry, land
from belvedere.warp._quads import is_cut, is_unsure

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
HOLE = np.float32(-1.0)
SPARSE = np.float32(2.5)
"""Samples of one reference in a cell of another from which on the other sees a surface sparsely.
From 2.5 to 3, pictures differ by 0.03 dB; from 2 on down, true edges are lost."""


@inner
def looks_through(
    back: Geometry, disparity: F4, links: U1, x4: Real, y4: Real, delta: Real, nearer: Real
) -> bool:
    """Whether a reference sees something farther, on an unbroken surface, through a place."""
    height, stride = disparity.shape
    u, v, scale = land(back, x4, y4, delta)
    if not (u >= ZERO and v >= ZERO and u < np.float32(stride - 1) and v < np.float32(height - 1)):
        return False
    j, i = int(v), int(u)
    if not links[j, i] & INTACT:
        return False
    nearest = max(
        disparity[j, i], disparity[j, i + 1], disparity[j + 1, i], disparity[j + 1, i + 1]
    )
    return nearest < delta * scale * nearer


@inner
def looks_all_through(
    back: Geometry, disparity: F4, links: U1, x4: Real, y4: Real, delta: Real, nearer: Real
) -> bool:
    """As `looks_through`, in all of a pixel: an edge may cover a part that its centre is not in."""
    for n in range(4):
        ox, oy = np.float32(n & 1) - HALF, np.float32(n >> 1) - HALF
        if not looks_through(back, disparity, links, x4 + ox, y4 + oy, delta, nearer):
            return False
    return True


@inner
def carried(onward: Geometry, there: Geometry, u: Real, v: Real, delta: Real) -> tuple[Real, Real]:
    """Where another reference has a sample of this one, by way of the desired view."""
    x, y, scale = land(onward, u, v, delta)
    u2, v2, _ = land(there, x, y, delta * scale)
    return u2, v2


@inner
def samples_in_cell(
    onward: Geometry, back: Geometry, disparity: F4, links: U1, there: Geometry, x4: Real, y4: Real,
    delta: Real,
) -> Real:  # fmt: skip
    """How many samples of another reference the cell of this one at a place covers.

    0 where the cell is not intact: nothing was drawn of it.

    Args:
        onward: geometry from this reference to the desired view.
        back: from the desired view to this reference.
        disparity: (H, W) of this reference.
        links: (H, W) its bits.
        there: geometry from the desired view to the other reference.
        x4: column of the desired view.
        y4: row.
        delta: disparity there.
    """
    height, stride = disparity.shape
    u, v, _ = land(back, x4, y4, delta)
    if not (u >= ZERO and v >= ZERO and u < np.float32(stride - 1) and v < np.float32(height - 1)):
        return ZERO
    j, i = int(v), int(u)
    if not links[j, i] & INTACT:
        return ZERO
    u4, v4 = np.float32(i), np.float32(j)
    u0, v0 = carried(onward, there, u4, v4, disparity[j, i])
    u1, v1 = carried(onward, there, u4 + ONE, v4, disparity[j, i + 1])
    u2, v2 = carried(onward, there, u4, v4 + ONE, disparity[j + 1, i])
    return abs((u1 - u0) * (v2 - v0) - (u2 - u0) * (v1 - v0))


@inner
def misses(back: Geometry, disparity: F4, x4: Real, y4: Real, delta: Real, nearer: Real) -> bool:
    """Whether the sample of a reference that is nearest to a place sees something farther."""
    height, stride = disparity.shape
    u, v, scale = land(back, x4, y4, delta)
    if not (u >= ZERO and v >= ZERO and u < np.float32(stride - 1) and v < np.float32(height - 1)):
        return False
    return disparity[int(v + HALF), int(u + HALF)] < delta * scale * nearer


@inner
def passes_over(delta: Real, edge: Real, cut: Real, nearer: Real) -> bool:
    """Whether one reference sees a surface go on where an edge of it is in another's layer.

    delta and edge are the one's, cut is the edge of the other.
    """
    same = (delta >= cut * nearer) & (cut >= delta * nearer)
    return same & is_cut(cut) & (not is_cut(edge))


@kernel
def reject_seen_through(
    back: Geometry, disparity: F4, links: U1, own: int, onward: Geometry, other_back: Geometry,
    other_disparity: F4, other_links: U1, other: int, column_low: int, column_end: int,
    row_low: int, tolerance: Real, centers: F4, edges: F4,
) -> None:  # fmt: skip
    """Take back what another reference drew where this one looks through that place.

    Between the last sample of a near surface and the first of the one behind nobody knows where the
    edge runs, and a surface seen at a slant can bridge what is a gap. A reference that sees
    something farther right through such a guess proves it wrong. Where the other saw its surface
    much more sparsely, as one does who looks along it, less is enough: that the nearest sample sees
    something farther, or that an edge is where the other's surface goes on. Where all agree nothing
    is asked.

    Args:
        back: geometry from the desired view to this reference; between planes its (12,) matrix.
        disparity: (H, W) of this reference.
        links: (H, W) its bits.
        own: number of its own layer, which is left alone.
        onward: geometry from the other reference to the desired view.
        other_back: from the desired view to the other.
        other_disparity: (H, W) of the other.
        other_links: (H, W) its bits.
        other: number of its layer, not ``own``.
        column_low: first desired column that the other can reach.
        column_end: the one after the last, or more.
        row_low: desired row of the first row of layers.
        tolerance: relative difference in disparity from which on it sees something farther.
        centers: (n, rows, width) disparities, -1 where nothing was drawn; changed in place.
        edges: (n, rows, width) those near edges.
    """
    _, rows, width = centers.shape
    end = min(column_end, width)
    nearer = np.float32(1.0) - np.float32(tolerance)
    asked = np.zeros((width + EIGHT - 1) // EIGHT * EIGHT, np.uint8)
    places = np.empty(asked.size, np.int32)
    for y in range(rows):
        y4 = np.float32(y + row_low)
        mine, cuts, theirs, rims = (
            centers[own, y],
            edges[own, y],
            centers[other, y],
            edges[other, y],
        )
        for x in range(
            column_low, end
        ):  # where it shows that surface itself it cannot look through
            rim = (rims[x] >= ZERO) & (max(mine[x], cuts[x]) < rims[x] * nearer)
            through = (theirs[x] >= ZERO) & (mine[x] < theirs[x] * nearer)
            over = passes_over(theirs[x], rims[x], cuts[x], nearer) & (not is_unsure(theirs[x]))
            asked[x] = np.uint8(rim | through | over)
        for k in range(list_set(asked, places)):
            x = places[k]
            delta, edge, x4 = theirs[x], rims[x], np.float32(x)
            if (
                edge >= ZERO and max(mine[x], cuts[x]) < edge * nearer
                and looks_all_through(back, disparity, links, x4, y4, edge, nearer)
            ):  # fmt: skip
                rims[x] = HOLE
            if delta < ZERO:
                continue
            if mine[x] < delta * nearer and looks_through(
                back, disparity, links, x4, y4, delta, nearer
            ):
                theirs[x] = HOLE
            elif not is_unsure(delta) and (
                passes_over(delta, edge, cuts[x], nearer)
                or (
                    ZERO <= mine[x] < delta * nearer
                    and misses(back, disparity, x4, y4, delta, nearer)
                )
            ):
                covered_there = samples_in_cell(
                    onward, other_back, other_disparity, other_links, back, x4, y4, delta
                )
                if covered_there > SPARSE:
                    theirs[x] = HOLE
                    if not is_cut(edge):
                        rims[x] = HOLE


@kernel
def keep_one_reference(ratio: Real, centers: F4, edges: F4) -> None:
    """Leave each pixel to the first layer that covers its centre, or a later one clearly in front.

    Args:
        ratio: how many times larger a later layer's disparity must be; infinite: none ever is.
        centers: (n, rows, width) disparities, -1 where nothing was drawn; changed in place.
        edges: (n, rows, width) those near edges.
    """
    count, rows, width = centers.shape
    factor = np.float32(ratio)
    for y in range(rows):
        for x in range(width):
            chosen, held = -1, HOLE
            for n in range(count):
                delta = centers[n, y, x]
                if delta >= ZERO and (chosen < 0 or delta > held * factor):
                    chosen, held = n, delta
            if chosen < 0:
                continue
            for n in range(count):
                if n > chosen or (n < chosen and centers[n, y, x] >= ZERO):
                    centers[n, y, x] = HOLE
                    edges[n, y, x] = HOLE
