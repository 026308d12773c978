"""Kernels of the inverse pass: merge what references see, then look colours up backwards.

Once every desired pixel knows its disparity, it knows where each reference shows its surface: the
colour is read there, with taps that stay on that surface, instead of being pushed forward.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba.extending import overload

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import Four, add4, load4, scale4, store4, zero4
from belvedere.warp._edges import INTACT, SMOOTH
from belvedere.warp._landing import Geometry, bend_back, is_flat, land
from belvedere.warp._surface import UNSURE, is_unsure, marked

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]
U2 = npt.NDArray[np.uint16]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO, THREE = np.float32(2.0), np.float32(3.0)
FOUR, FIVE = np.float32(4.0), np.float32(5.0)
HOLE = np.float32(-1.0)
EIGHT = 8
"""Flags that are passed over at once where all are 0."""
CHUNK = 64
"""Pixels of a row that are looked up together."""
FAINT = np.float32(1e-12)
"""A disparity as good as 0: a mark of unsureness makes one of infinitely far surfaces."""
EDGE_WEIGHT = np.float32(0.05)
"""What a reference's word counts where its pixels mix two surfaces."""
FEW = np.float32(0.5)
"""Sum of the bicubic weights on the surface below which the nearest sample on it is taken."""


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


@kernel
def reject_seen_through(
    back: Geometry, disparity: F4, links: U1, own: int, row_low: int, tolerance: Real, centers: F4,
    edges: F4,
) -> None:  # fmt: skip
    """Take back what was drawn where this reference looks through that place.

    Between the last sample of a near surface and the first of the one behind nobody knows where the
    edge runs, and a surface seen at a slant can bridge what is a gap. A reference that sees
    something farther right through such a guess proves it wrong. Where all agree nothing is asked.

    Args:
        back: (12,) matrix from the desired view to this reference.
        disparity: (H, W) of this reference.
        links: (H, W) its bits.
        own: number of its own layer, which is left alone.
        row_low: desired row of the first row of layers.
        tolerance: relative difference in disparity from which on it sees something farther.
        centers: (n, rows, width) disparities, -1 where nothing was drawn; changed in place.
        edges: (n, rows, width) those near edges.
    """
    count, rows, width = centers.shape
    nearer = np.float32(1.0) - np.float32(tolerance)
    asked = np.zeros((width + EIGHT - 1) // EIGHT * EIGHT, np.uint8)
    eights = asked.view(np.uint64)
    for n in range(count):
        if n == own:
            continue
        for y in range(rows):
            y4 = np.float32(y + row_low)
            mine, theirs, rims = centers[own, y], centers[n, y], edges[n, y]
            for x in range(width):
                asked[x] = np.uint8((rims[x] >= ZERO) | (mine[x] < theirs[x] * nearer))
            for x_low in range(0, width, EIGHT):
                if eights[x_low // EIGHT] == 0:
                    continue
                for x in range(x_low, min(x_low + EIGHT, width)):
                    if not asked[x]:
                        continue
                    delta, edge, x4 = theirs[x], rims[x], np.float32(x)
                    if edge >= ZERO and looks_all_through(
                        back, disparity, links, x4, y4, edge, nearer
                    ):
                        edges[n, y, x] = HOLE
                    if (
                        delta >= ZERO and mine[x] < delta * nearer
                        and looks_through(back, disparity, links, x4, y4, delta, nearer)
                    ):  # fmt: skip
                        centers[n, y, x] = HOLE


@kernel
def keep_nearest_reference(centers: F4, edges: F4) -> None:
    """Leave each pixel to the first layer that covers its centre, whatever the depths."""
    count, rows, width = centers.shape
    for y in range(rows):
        for x in range(width):
            taken = False
            for n in range(count):
                if taken:
                    centers[n, y, x] = HOLE
                    edges[n, y, x] = HOLE
                taken |= centers[n, y, x] >= ZERO


@inner
def across_crack(centers: F4, n: int, y: int, x: int, dy: int, dx: int, keep: Real) -> Real:
    """The disparity on both sides of a pixel in one layer, or -1 if that is no crack."""
    a, b = centers[n, y - dy, x - dx], centers[n, y + dy, x + dx]
    low, high = min(a, b), max(a, b)
    if low < ZERO:
        return HOLE
    return HALF * (a + b) if low >= high * keep else low


@inner
def close_cracks(centers: F4, front: F4, tolerance: Real, out_index: I4, out_value: F4) -> None:
    """Cover holes one pixel wide."""
    count, rows, width = centers.shape
    keep = ONE - np.float32(tolerance)
    found = 0
    open_pixels = np.zeros((width + EIGHT - 1) // EIGHT * EIGHT, np.uint8)
    eights = open_pixels.view(np.uint64)
    for y in range(1, rows - 1):
        for x in range(1, width - 1):
            open_pixels[x] = np.uint8(front[y, x] < ZERO)
        for x_low in range(0, width, EIGHT):
            if eights[x_low // EIGHT] == 0:
                continue
            for x in range(x_low, min(x_low + EIGHT, width)):
                if not open_pixels[x]:
                    continue
                best = HOLE
                for n in range(count):
                    best = max(best, across_crack(centers, n, y, x, 0, 1, keep))
                    best = max(best, across_crack(centers, n, y, x, 1, 0, keep))
                if best >= ZERO:
                    out_index[found] = y * width + x
                    out_value[found] = best
                    found += 1
    for k in range(found):
        y, x = out_index[k] // width, out_index[k] % width
        front[y, x] = marked(out_value[k], UNSURE)
        for n in range(count):
            centers[n, y, x] = marked(out_value[k], UNSURE)


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
    if behind < ZERO:
        for j in range(max(y - 1, 0), min(y + 2, rows)):
            for i in range(max(x - 1, 0), min(x + 2, width)):
                for n in range(count):
                    other = centers[n, j, i]
                    if other < limit:
                        behind = max(behind, other)
    if behind < ZERO:  # nothing to mix with: the pixel belongs to what is at its centre
        alpha = max(alpha, HALF) if center >= limit else ZERO
    return alpha, behind


@kernel
def merge_layers(
    centers: F4, edges: F4, masks: U2, nearness: F4, tolerance: Real, out_front: F4,
    out_alpha: F4, out_index: I4, out_behind: F4,
) -> int:  # fmt: skip
    """What each pixel shows: the nearest surface, how much of the pixel it covers, what is behind.

    Args:
        centers: (n, rows, width) disparity each reference sees at the pixel's centre, -1 = none.
        edges: (n, rows, width) that of its nearest surface near an edge, -1 = none.
        masks: (n, rows, width) sixteenths of the pixel that surface covers.
        nearness: (n,) weights of the references.
        tolerance: relative difference of disparities that are one surface.
        out_front: (rows, width) disparity of the nearest surface, -1 = none.
        out_alpha: (rows, width) how much it covers.
        out_index: (rows * width,) flat indices of the pixels it does not cover whole.
        out_behind: (rows * width,) disparity of what is behind it in those, -1 = unknown.

    Returns:
        How many those are.
    """
    count, rows, width = centers.shape
    keep = ONE - np.float32(tolerance)
    out_front.fill(HOLE)
    for n in range(count):
        for y in range(rows):
            for x in range(width):
                out_front[y, x] = max(out_front[y, x], centers[n, y, x])
    close_cracks(centers, out_front, tolerance, out_index, out_behind)
    partial = 0
    out_alpha.fill(ONE)
    rims = np.zeros((width + EIGHT - 1) // EIGHT * EIGHT, np.uint8)
    eights = rims.view(np.uint64)
    for y in range(rows):
        rims.fill(0)
        for n in range(count):
            for x in range(width):
                edge = edges[n, y, x]
                cut = is_unsure(edge) & (edge >= ZERO) & (edge >= out_front[y, x] * keep)
                rims[x] |= np.uint8(cut)
        for x_low in range(0, width, EIGHT):
            if eights[x_low // EIGHT] == 0:
                continue
            for x in range(x_low, min(x_low + EIGHT, width)):
                if not rims[x]:
                    continue
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


@inner
def cubic_weights(f: Real) -> tuple[Real, Real, Real, Real]:
    """Catmull and Rom's weights of the samples at -1, 0, 1, 2 for the place f in [0, 1]."""
    return (
        HALF * f * (f * (TWO - f) - ONE),
        HALF * (f * f * (THREE * f - FIVE) + TWO),
        HALF * f * (f * (FOUR - THREE * f) + ONE),
        HALF * f * f * (f - ONE),
    )


@inner
def mix_row(color: F4, first: int, a: Real, b: Real, c: Real, d: Real) -> Four:
    """Weighted sum of four samples in a row."""
    left = add4(scale4(load4(color, first), a), scale4(load4(color, first + 1), b))
    right = add4(scale4(load4(color, first + 2), c), scale4(load4(color, first + 3), d))
    return add4(left, right)


@inner
def land_back(
    back: Geometry, y4: Real, x_low: int, front: F4, count: int, ramp: F4, taps: F4, out_corner: I4,
    stride: int, height: int,
) -> None:  # fmt: skip
    """Where ``count`` pixels of a row show in a reference, and the bicubic weights there.

    Straight-line arithmetic on purpose: it vectorises.

    Args:
        back: (12,) matrix from the desired view.
        y4: desired row.
        x_low: first column.
        front: disparities, front[0] in column x_low.
        count: pixels.
        ramp: 0, 1, 2, ...
        taps: (11, CHUNK), written: u, v, disparity in the reference, four weights along u, four
            along v.
        out_corner: (CHUNK,) number of the sample to the upper left, -1 outside the picture.
        stride: of the reference, its width.
        height: of the reference.
    """
    r0, s0, t0 = back[1] * y4 + back[2], back[5] * y4 + back[6], back[9] * y4 + back[10]
    x0, last_u, last_v = np.float32(x_low), np.float32(stride - 1), np.float32(height - 1)
    for i in range(count):
        x4, delta = x0 + ramp[i], front[i]
        scale = ONE / (back[8] * x4 + t0 + back[11] * delta)
        u = (back[0] * x4 + r0 + back[3] * delta) * scale
        v = (back[4] * x4 + s0 + back[7] * delta) * scale
        inside = (u >= ZERO) & (v >= ZERO) & (u < last_u) & (v < last_v)
        left, top = np.floor(u if inside else ZERO), np.floor(v if inside else ZERO)
        fu, fv = u - left, v - top
        taps[0, i], taps[1, i], taps[2, i] = u, v, delta * scale
        corner = np.int32(np.int32(top) * np.int32(stride) + np.int32(left))
        out_corner[i] = corner if inside else np.int32(-1)
        taps[3, i] = HALF * fu * (fu * (TWO - fu) - ONE)
        taps[4, i] = HALF * (fu * fu * (THREE * fu - FIVE) + TWO)
        taps[5, i] = HALF * fu * (fu * (FOUR - THREE * fu) + ONE)
        taps[6, i] = HALF * fu * fu * (fu - ONE)
        taps[7, i] = HALF * fv * (fv * (TWO - fv) - ONE)
        taps[8, i] = HALF * (fv * fv * (THREE * fv - FIVE) + TWO)
        taps[9, i] = HALF * fv * (fv * (FOUR - THREE * fv) + ONE)
        taps[10, i] = HALF * fv * fv * (fv - ONE)


def land_pixels(
    back: Geometry, y4: Real, x_low: int, front: F4, count: int, ramp: F4, taps: F4,
    out_corner: I4, stride: int, height: int,
) -> None:  # fmt: skip
    """As `land_back`, or `bend_back` where the geometry is not that of planes."""
    if back.dtype == np.float32:
        land_back(back, y4, x_low, front, count, ramp, taps, out_corner, stride, height)
    else:
        bend_back(back, y4, x_low, front, count, taps, out_corner, stride, height)


# Numba compiles what is returned: it must be a function with the names of the original.
# ruff: noqa: PLW0108
@overload(land_pixels, jit_options={"forceinline": True}, strict=False)
def _land_pixels(
    back: Any, y4: Any, x_low: Any, front: Any, count: Any, ramp: Any, taps: Any, out_corner: Any,
    stride: Any, height: Any,
) -> Any:  # fmt: skip
    if is_flat(back):
        return lambda back, y4, x_low, front, count, ramp, taps, out_corner, stride, height: (
            land_back(back, y4, x_low, front, count, ramp, taps, out_corner, stride, height)
        )
    return lambda back, y4, x_low, front, count, ramp, taps, out_corner, stride, height: bend_back(
        back, y4, x_low, front, count, taps, out_corner, stride, height
    )


@inner
def bicubic(color: F4, corner: int, stride: int, taps: F4, i: int) -> Four:
    """Colour of pixel i of a chunk, in the cell whose upper left sample is number ``corner``."""
    a, b, c, d = taps[3, i], taps[4, i], taps[5, i], taps[6, i]
    first = corner - stride - 1
    upper = add4(
        scale4(mix_row(color, first, a, b, c, d), taps[7, i]),
        scale4(mix_row(color, first + stride, a, b, c, d), taps[8, i]),
    )
    lower = add4(
        scale4(mix_row(color, first + 2 * stride, a, b, c, d), taps[9, i]),
        scale4(mix_row(color, first + 3 * stride, a, b, c, d), taps[10, i]),
    )
    return add4(upper, lower)


@inner
def on_surface(found: Real, delta: Real, tolerance: Real) -> bool:
    """Whether a sample's disparity is that of the surface."""
    return abs(found - delta) <= tolerance * delta + FAINT


@inner
def guarded_row(
    color: F4, disparity: F4, first: int, delta: Real, near: Real, a: Real, b: Real, c: Real,
    d: Real,
) -> tuple[Real, Four]:  # fmt: skip
    """As `mix_row` without the samples of other surfaces; first the sum of the weights left."""
    at = np.uint64(first)
    a = a if abs(disparity[at] - delta) <= near else ZERO
    b = b if abs(disparity[at + np.uint64(1)] - delta) <= near else ZERO
    c = c if abs(disparity[at + np.uint64(2)] - delta) <= near else ZERO
    d = d if abs(disparity[at + np.uint64(3)] - delta) <= near else ZERO
    return a + b + c + d, mix_row(color, first, a, b, c, d)


@inner
def careful(
    color: F4, disparity: F4, u: Real, v: Real, delta: Real, tolerance: Real, weights: F4
) -> tuple[Four, Real]:
    """Colour at (u, v) from taps on one surface only, and 1, or 0 where no sample is on it.

    Args:
        color: (H, W, 4).
        disparity: (H, W).
        u: column.
        v: row.
        delta: disparity of the surface there.
        tolerance: relative difference of samples that lie on it.
        weights: (2, 4) to work in.
    """
    height, stride = disparity.shape
    if u >= ONE and v >= ONE and u < np.float32(stride - 2) and v < np.float32(height - 2):
        i, j = int(u), int(v)
        a, b, c, d = cubic_weights(u - np.float32(i))
        e, f, g, h = cubic_weights(v - np.float32(j))
        first = (j - 1) * stride + i - 1
        flat = disparity.reshape(-1)
        near = tolerance * delta + FAINT
        sum0, row0 = guarded_row(color, flat, first, delta, near, a, b, c, d)
        sum1, row1 = guarded_row(color, flat, first + stride, delta, near, a, b, c, d)
        sum2, row2 = guarded_row(color, flat, first + 2 * stride, delta, near, a, b, c, d)
        sum3, row3 = guarded_row(color, flat, first + 3 * stride, delta, near, a, b, c, d)
        sum_weight = e * sum0 + f * sum1 + g * sum2 + h * sum3
        if sum_weight >= FEW:
            total = add4(
                add4(scale4(row0, e), scale4(row1, f)), add4(scale4(row2, g), scale4(row3, h))
            )
            return scale4(total, ONE / sum_weight), ONE
    i, j = int(np.floor(u)), int(np.floor(v))
    fu, fv = u - np.float32(i), v - np.float32(j)
    weights[0, 0], weights[0, 1], weights[0, 2], weights[0, 3] = cubic_weights(fu)
    weights[1, 0], weights[1, 1], weights[1, 2], weights[1, 3] = cubic_weights(fv)
    total, sum_weight = zero4(), ZERO
    nearest, distance = -1, np.float32(1e9)
    for m in range(4):
        row = j + m - 1
        if row < 0 or row >= height:
            continue
        for k in range(4):
            column = i + k - 1
            if column < 0 or column >= stride:
                continue
            if not on_surface(disparity[row, column], delta, tolerance):
                continue
            weight = weights[1, m] * weights[0, k]
            index = row * stride + column
            total = add4(total, scale4(load4(color, index), weight))
            sum_weight += weight
            du, dv = u - np.float32(column), v - np.float32(row)
            apart = du * du + dv * dv
            if apart < distance:
                nearest, distance = index, apart
    if nearest < 0:
        return zero4(), ZERO
    if sum_weight < FEW:
        return load4(color, nearest), ONE
    return scale4(total, ONE / sum_weight), ONE


@kernel
def look_up(
    back: Geometry, color: F4, disparity: F4, links: U1, center: F4, edge: F4, front: F4,
    row_low: int, nearness: Real, surface_tolerance: Real, tap_tolerance: Real, out_color: F4,
    out_weight: F4,
) -> None:  # fmt: skip
    """Add one reference's colours, times their weights, in the pixels whose surface it sees.

    Args:
        back: (12,) matrix from the desired view to this reference.
        color: (H, W, 4) linear.
        disparity: (H, W).
        links: (H, W) bits of `_edges`.
        center: (rows, width) disparity this reference sees in each desired pixel, -1 = none.
        edge: (rows, width) that of its nearest surface near an edge.
        front: (rows, width) disparity that is shown, -1 = none.
        row_low: desired row of the first.
        nearness: weight of this reference.
        surface_tolerance: relative difference of layer and front that are one surface.
        tap_tolerance: relative difference of samples that may be mixed.
        out_color: (rows, width, 4) sum.
        out_weight: (rows, width) sum.
    """
    rows, width = front.shape
    height, stride = disparity.shape
    keep = np.float32(1.0) - np.float32(surface_tolerance)
    tap = np.float32(tap_tolerance)
    own = np.float32(nearness)
    weights = np.empty((2, 4), np.float32)
    taps, corners = np.zeros((11, CHUNK), np.float32), np.zeros(CHUNK, np.int32)
    ramp = np.arange(CHUNK).astype(np.float32)
    flat_links = links.reshape(-1)
    for y in range(rows):
        y4 = np.float32(y + row_low)
        for x_low in range(0, width, CHUNK):
            count = min(CHUNK, width - x_low)
            land_pixels(
                back, y4, x_low, front[y, x_low:], count, ramp, taps, corners, stride, height
            )
            for i in range(count):
                x = x_low + i
                delta = front[y, x]
                if delta < ZERO or max(center[y, x], edge[y, x]) < delta * keep:
                    continue
                corner = corners[i]
                if corner >= 0 and flat_links[np.uint32(corner)] & SMOOTH:
                    value, weight = bicubic(color, corner, stride, taps, i), own
                else:
                    u, v = taps[0, i], taps[1, i]
                    if not (u > -TWO and v > -TWO and u < stride + ONE and v < height + ONE):
                        continue
                    value, sees = careful(color, disparity, u, v, taps[2, i], tap, weights)
                    weight = own * EDGE_WEIGHT * sees
                index = y * width + x
                store4(out_color, index, add4(load4(out_color, index), scale4(value, weight)))
                out_weight[y, x] += weight


@kernel
def look_up_behind(
    back: Geometry, color: F4, disparity: F4, index: I4, behind: F4, count: int, width: int,
    row_low: int, nearness: Real, tap_tolerance: Real, out_color: F4, out_weight: F4,
) -> None:  # fmt: skip
    """As `look_up`, for what is behind the nearest surface in some pixels.

    index and behind are (count,) as from `merge_layers`; out_color (count, 4), out_weight (count,).
    """
    height, stride = disparity.shape
    tap = np.float32(tap_tolerance)
    weights = np.empty((2, 4), np.float32)
    for k in range(count):
        delta = behind[k]
        if delta < ZERO:
            continue
        x4, y4 = np.float32(index[k] % width), np.float32(index[k] // width + row_low)
        u, v, scale = land(back, x4, y4, delta)
        if not (u > -TWO and v > -TWO and u < stride + ONE and v < height + ONE):
            continue
        value, sees = careful(color, disparity, u, v, delta * scale, tap, weights)
        weight = np.float32(nearness) * sees
        store4(out_color, k, add4(load4(out_color, k), scale4(value, weight)))
        out_weight[k] += weight


@inner
def plain(delta: Real) -> Real:
    """The disparity as a frame has it: 0 where only the mark of unsureness is left of it."""
    return delta if delta > FAINT else ZERO


@kernel
def divide(total: F4, total_weight: F4, out_color: F4, out_disparity: F4, out_coverage: F4) -> None:
    """Means of what was added; a pixel that no reference gave a colour is uncovered.

    out_disparity holds what is shown, -1 = none.
    """
    rows, width = out_disparity.shape
    for y in range(rows):
        for x in range(width):
            weight, index = total_weight[y, x], y * width + x
            known = weight > ZERO
            scale = ONE / weight if known else ZERO
            store4(out_color, index, scale4(load4(total, index), scale))
            out_disparity[y, x] = plain(out_disparity[y, x]) if known else HOLE
            out_coverage[y, x] = ONE if known else ZERO


@kernel
def blend_behind(
    index: I4, behind: F4, count: int, first: int, alpha: F4, total: F4, total_weight: F4,
    out_color: F4, out_disparity: F4, out_coverage: F4,
) -> None:  # fmt: skip
    """Let what is behind show in the part of a pixel that the nearest surface leaves free.

    Args:
        index: (count,) pixels, counted with the halo.
        behind: (count,) what is behind.
        count: how many.
        first: rows of the halo above the first row of the outputs.
        alpha: (rows with halo, width) what the nearest surface covers.
        total: (count, 4) from `look_up_behind`.
        total_weight: (count,).
        out_color: (rows, width, 4) linear.
        out_disparity: (rows, width).
        out_coverage: (rows, width).
    """
    rows, width = out_disparity.shape
    for k in range(count):
        y, x = index[k] // width - first, index[k] % width
        if y < 0 or y >= rows:
            continue
        share, weight, place = alpha[y + first, x], total_weight[k], y * width + x
        if weight > ZERO:
            below = scale4(load4(total, k), (ONE - share) / weight)
            if out_coverage[y, x] > ZERO:
                store4(out_color, place, add4(scale4(load4(out_color, place), share), below))
            else:
                store4(out_color, place, scale4(load4(total, k), ONE / weight))
            if share < HALF or not out_coverage[y, x] > ZERO:
                out_disparity[y, x] = plain(behind[k])
            out_coverage[y, x] = ONE
        elif share < HALF:
            out_coverage[y, x], out_disparity[y, x] = ZERO, HOLE
            store4(out_color, place, zero4())
        elif out_coverage[y, x] > ZERO:
            out_coverage[y, x] = share
