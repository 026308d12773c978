"""Kernels of the inverse pass that merge what references see at each desired pixel.

References check one another, cracks are told from exposures, and at silhouettes each pixel learns
how much of it the nearest surface covers and what is behind.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import EIGHT, INTACT, list_set
from belvedere.warp._landing import Geometry, land
from belvedere.warp._quads import UNSURE, is_cut, is_unsure, marked

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]
U2 = npt.NDArray[np.uint16]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
HOLE = np.float32(-1.0)
SPARSE = np.float32(2.5)
"""Samples of one reference in a cell of another from which on the other sees a surface sparsely.
From 2.5 to 3, pictures differ by 0.03 dB; from 2 on down, true edges are lost."""
FAINT = np.float32(1e-12)
"""A disparity as good as 0: a mark of unsureness makes one of infinitely far surfaces."""


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
    other_disparity: F4, other_links: U1, other: int, row_low: int, tolerance: Real, centers: F4,
    edges: F4,
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
        row_low: desired row of the first row of layers.
        tolerance: relative difference in disparity from which on it sees something farther.
        centers: (n, rows, width) disparities, -1 where nothing was drawn; changed in place.
        edges: (n, rows, width) those near edges.
    """
    _, rows, width = centers.shape
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
        for x in range(width):  # where it shows that surface itself it cannot look through
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


@inner
def part_covered(
    centers: F4, edges: F4, masks: U2, nearness: F4, y: int, x: int, keep: Real, front: F4
) -> tuple[Real, Real]:
    """How much of a pixel its nearest surface covers, and the disparity behind it, -1 if unknown.

    Each reference for which the surface ends here says how much; one that sees it go on settles the
    matter. Arguments as of `merge_layers`; front holds what is at the centres.
    """
    count, rows, width = centers.shape
    nearest, center = HOLE, front[y, x]
    for n in range(count):
        nearest = max(nearest, edges[n, y, x])
    limit = max(nearest, center) * keep
    total, total_weight = ZERO, ZERO
    for n in range(count):
        edge = edges[n, y, x]
        if edge >= limit and is_unsure(edge):
            total += nearness[n] * covered(masks[n, y, x])
            total_weight += nearness[n]
        elif max(centers[n, y, x], edge) >= limit:
            return ONE, HOLE
    alpha, behind = total / total_weight, HOLE
    if alpha >= ONE:
        return ONE, HOLE
    for n in range(count):
        mine = centers[n, y, x]
        if mine < limit:
            behind = max(behind, mine)
    if behind < ZERO and center >= limit:  # a hole stays one: its neighbours do not tell
        for j in range(max(y - 1, 0), min(y + 2, rows)):
            for i in range(max(x - 1, 0), min(x + 2, width)):
                for n in range(count):
                    other = centers[n, j, i]
                    if other < limit:
                        behind = max(behind, other)
    if behind < ZERO:  # nothing to mix with: the pixel belongs to what is at its centre
        alpha = max(alpha, HALF) if center >= limit else alpha
    return alpha, behind


@kernel
def merge_layers(
    centers: F4, edges: F4, masks: U2, nearness: F4, tolerance: Real, seen: U1, cracks: int,
    out_front: F4, out_alpha: F4, out_index: I4, out_behind: F4,
) -> int:  # fmt: skip
    """What each pixel shows: the nearest surface, how much of the pixel it covers, what is behind.

    Args:
        centers: (n, rows, width) disparity each reference sees at the pixel's centre, -1 = none.
        edges: (n, rows, width) that of its nearest surface near an edge, -1 = none.
        masks: (n, rows, width) sixteenths of the pixel that surface covers.
        nearness: (n,) weights of the references.
        tolerance: relative difference of disparities that are one surface.
        seen: (cracks,) which of the holes that are listed in the outputs to close.
        cracks: how many are listed.
        out_front: (rows, width) disparity of the nearest surface, -1 = none.
        out_alpha: (rows, width) how much it covers.
        out_index: (rows * width,) flat indices of the pixels it does not cover whole.
        out_behind: (rows * width,) disparity of what is behind it in those, -1 = unknown.

    Returns:
        How many those are.
    """
    count, rows, width = centers.shape
    keep = ONE - np.float32(tolerance)
    for k in range(cracks):
        if seen[k]:
            y, x = out_index[k] // width, out_index[k] % width
            out_front[y, x] = marked(out_behind[k], UNSURE)
            for n in range(count):
                centers[n, y, x] = marked(out_behind[k], UNSURE)
    rims = np.zeros((width + EIGHT - 1) // EIGHT * EIGHT, np.uint8)
    places = np.empty(rims.size, np.int32)
    partial = 0
    out_alpha.fill(ONE)
    for y in range(rows):
        rims.fill(0)
        for n in range(count):
            for x in range(width):
                edge = edges[n, y, x]
                cut = is_unsure(edge) & (edge >= ZERO) & (edge >= out_front[y, x] * keep)
                rims[x] |= np.uint8(cut)
        for k in range(list_set(rims, places)):
            x = places[k]
            alpha, behind = part_covered(centers, edges, masks, nearness, y, x, keep, out_front)
            if alpha < ONE:
                out_alpha[y, x] = alpha
                out_index[partial] = y * width + x
                out_behind[partial] = behind
                partial += 1
    # only now: the loop above looks at centres next to each pixel
    for k in range(partial):
        y, x = out_index[k] // width, out_index[k] % width
        front = out_front[y, x]
        for n in range(count):
            front = max(front, edges[n, y, x])
        out_front[y, x] = front
    return partial


@inner
def covered(mask: int) -> Real:
    """Share of sixteen bits that are set."""
    bits = np.uint32(mask)
    bits = bits - ((bits >> np.uint32(1)) & np.uint32(0x5555))
    bits = (bits & np.uint32(0x3333)) + ((bits >> np.uint32(2)) & np.uint32(0x3333))
    bits = (bits + (bits >> np.uint32(4))) & np.uint32(0x0F0F)
    bits = (bits + (bits >> np.uint32(8))) & np.uint32(0x1F)
    return np.float32(bits) * np.float32(1.0 / 16.0)
