"""Kernels of the inverse pass that look colours up backwards.

Once every desired pixel knows its disparity, it knows where each reference shows its surface: the
colour is read there, with taps that stay on that surface, instead of being pushed forward.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba.extending import overload

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import (
    Four,
    add4,
    add_scaled16,
    add_weighted16,
    cubic4,
    fold16,
    kept4,
    lane4,
    load4,
    load16,
    max4,
    min4,
    scale4,
    scale16,
    store4,
    sum4,
    weigh16,
    zero4,
    zero16,
)
from belvedere.warp._compose import write_row
from belvedere.warp._edges import SMOOTH
from belvedere.warp._landing import Geometry, bend_back, is_flat, land

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO, THREE = np.float32(2.0), np.float32(3.0)
FOUR, FIVE = np.float32(4.0), np.float32(5.0)
HOLE, NAN = np.float32(-1.0), np.float32(np.nan)
CHUNK = 64
"""Pixels of a row that are looked up together."""
FAINT = np.float32(1e-12)
"""A disparity as good as 0: a mark of unsureness makes one of infinitely far surfaces."""
EDGE_WEIGHT = np.float32(0.05)
"""What a reference's word counts where its pixels mix two surfaces."""
FEW = np.float32(0.5)
"""Sum of the bicubic weights on the surface below which the nearest sample on it is taken."""


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
    first = corner - stride - 1
    rows = scale16(load16(color, first), taps[7, i])
    rows = add_scaled16(rows, load16(color, first + stride), taps[8, i])
    rows = add_scaled16(rows, load16(color, first + 2 * stride), taps[9, i])
    rows = add_scaled16(rows, load16(color, first + 3 * stride), taps[10, i])
    value = weigh16(rows, taps[3, i], taps[4, i], taps[5, i], taps[6, i])
    a, b = load4(color, corner), load4(color, corner + 1)
    c, d = load4(color, corner + stride), load4(color, corner + stride + 1)
    low, high = min4(min4(a, b), min4(c, d)), max4(max4(a, b), max4(c, d))
    return max4(min4(value, high), low)


@inner
def on_surface(found: Real, delta: Real, tolerance: Real) -> bool:
    """Whether a sample's disparity is that of the surface."""
    return abs(found - delta) <= tolerance * delta + FAINT


@inner
def within(
    color: F4, disparity: F4, corner: int, stride: int, right: int, down: int, delta: Real,
    near: Real, value: Four,
) -> Four:  # fmt: skip
    """A colour kept between those of the samples of the surface round its place, if there are any.

    Those are sample ``corner``, the one to its right and those below; right and down are 0 where
    the picture ends.
    """
    flat, found = disparity.reshape(-1), 0
    low, high = value, value
    for k in range(4):
        at = corner + (k & 1) * right + (k >> 1) * down * stride
        if abs(flat[np.uint64(at)] - delta) <= near:
            one = load4(color, at)
            low = min4(low, one) if found > 0 else one
            high = max4(high, one) if found > 0 else one
            found += 1
    return max4(min4(value, high), low)


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
        across, along = cubic4(u - np.float32(i)), cubic4(v - np.float32(j))
        first, near = (j - 1) * stride + i - 1, tolerance * delta + FAINT
        row0 = scale4(kept4(disparity, first, delta, near, across), lane4(along, 0))
        row1 = scale4(kept4(disparity, first + stride, delta, near, across), lane4(along, 1))
        row2 = scale4(kept4(disparity, first + 2 * stride, delta, near, across), lane4(along, 2))
        row3 = scale4(kept4(disparity, first + 3 * stride, delta, near, across), lane4(along, 3))
        sum_weight = sum4(add4(add4(row0, row1), add4(row2, row3)))
        if sum_weight >= FEW:
            taps = add_weighted16(zero16(), load16(color, first), row0)
            taps = add_weighted16(taps, load16(color, first + stride), row1)
            taps = add_weighted16(taps, load16(color, first + 2 * stride), row2)
            taps = add_weighted16(taps, load16(color, first + 3 * stride), row3)
            value = scale4(fold16(taps), ONE / sum_weight)
            return within(color, disparity, j * stride + i, stride, 1, 1, delta, near, value), ONE
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
    corner, near = max(j, 0) * stride + max(i, 0), tolerance * delta + FAINT
    right, down = int(0 <= i < stride - 1), int(0 <= j < height - 1)
    value = scale4(total, ONE / sum_weight)
    return within(color, disparity, corner, stride, right, down, delta, near, value), ONE


@kernel
def look_up(
    back: Geometry, color: F4, disparity: F4, links: U1, center: F4, edge: F4, front: F4,
    row_low: int, nearness: Real, gain: Real, part: F4 | None, surface_tolerance: Real,
    tap_tolerance: Real, first: bool, column_low: int, column_end: int, out_color: F4,
    out_weight: F4,
) -> None:  # fmt: skip
    """Add one reference's colours, times their weights, in the pixels whose surface it sees.

    Args:
        back: geometry from the desired view to this reference; between planes its (12,) matrix.
        color: (H, W, 4) linear.
        disparity: (H, W).
        links: (H, W) bits of `_edges`.
        center: (rows, width) disparity this reference sees in each desired pixel, -1 = none.
        edge: (rows, width) that of its nearest surface near an edge.
        front: (rows, width) disparity that is shown, -1 = none.
        row_low: desired row of the first.
        nearness: weight of this reference.
        gain: factor of its colours.
        part: (rows, width) share of that weight, where copies of it have the rest; None for all.
        surface_tolerance: relative difference of layer and front that are one surface.
        tap_tolerance: relative difference of samples that may be mixed.
        first: whether sums begin here, whatever the outputs hold.
        column_low: first desired column that the reference can reach.
        column_end: the one after the last, or more.
        out_color: (rows, width, 4) sum.
        out_weight: (rows, width) sum.
    """
    rows, width = front.shape
    end = min(column_end, width)
    height, stride = links.shape
    keep, own = ONE - np.float32(surface_tolerance), np.float32(nearness)
    tap, weights = np.float32(tap_tolerance), np.empty((2, 4), np.float32)
    bright = np.float32(gain)
    last_u, last_v = np.float32(stride + 1), np.float32(height + 1)
    taps, corners = np.zeros((11, CHUNK), np.float32), np.zeros(CHUNK, np.int32)
    ramp, shown = np.arange(CHUNK).astype(np.float32), np.zeros(CHUNK, np.uint8)
    flat_links, flat_weight = links.reshape(-1), out_weight.reshape(-1)
    flat = disparity.reshape(-1)
    for y in range(rows):
        y4 = np.float32(y + row_low)
        if first:
            for i in range(y * width, (y + 1) * width):
                flat_weight[np.uint64(i)] = ZERO
                store4(out_color, i, zero4())
        for x_low in range(column_low, end, CHUNK):
            count = min(CHUNK, end - x_low)
            shows, ends, at = front[y, x_low:], edge[y, x_low:], center[y, x_low:]
            land_pixels(back, y4, x_low, shows, count, ramp, taps, corners, stride, height)
            for i in range(count):
                delta = shows[i]
                shown[i] = np.uint8((delta >= ZERO) & (max(at[i], ends[i]) >= delta * keep))
            begin = y * width + x_low
            for i in range(count):
                if not shown[i]:
                    continue
                corner, landed = corners[i], taps[2, i]
                at = np.uint32(max(corner, 0))
                smooth = corner >= 0 and flat_links[at] & SMOOTH != 0
                # smooth it may be, but another surface, which hides this one or lies behind it
                if smooth and abs(flat[at] - landed) <= tap * landed + FAINT:
                    value, weight = bicubic(color, corner, stride, taps, i), own
                else:
                    u, v = taps[0, i], taps[1, i]
                    if not (u > -TWO and v > -TWO and u < last_u and v < last_v):
                        continue
                    value, sees = careful(color, disparity, u, v, landed, tap, weights)
                    weight = own * EDGE_WEIGHT * sees
                if part is not None:
                    weight = weight * part[y, x_low + i]
                index = begin + i
                value = scale4(value, weight * bright)
                store4(out_color, index, add4(load4(out_color, index), value))
                flat_weight[np.uint64(index)] += weight


@kernel
def look_up_behind(
    back: Geometry, color: F4, disparity: F4, index: I4, delta: F4, count: int, width: int,
    row_low: int, nearness: Real, gain: Real, part: F4 | None, tap_tolerance: Real, out_color: F4,
    out_weight: F4,
) -> None:  # fmt: skip
    """As `look_up`, for what is behind the nearest surface in some pixels.

    Args:
        back: geometry from the desired view to this reference; between planes its (12,) matrix.
        color: (H, W, 4) linear.
        disparity: (H, W).
        index: (count,) pixels, ``y * width + x``.
        delta: (count,) disparities there, -1 = unknown.
        count: how many.
        width: of the desired view.
        row_low: desired row of pixel 0.
        nearness: weight of this reference.
        gain: factor of its colours.
        part: (count,) share of that weight, where copies of it have the rest; None for all.
        tap_tolerance: relative difference of samples that may be mixed.
        out_color: (count, 4) sum.
        out_weight: (count,) sum.
    """
    height, stride = disparity.shape
    tap, weights = np.float32(tap_tolerance), np.empty((2, 4), np.float32)
    bright = np.float32(gain)
    last_u, last_v = np.float32(stride + 1), np.float32(height + 1)
    for k in range(count):
        own = delta[k]
        if own < ZERO:
            continue
        x4, y4 = np.float32(index[k] % width), np.float32(index[k] // width + row_low)
        u, v, scale = land(back, x4, y4, own)
        if not (u > -TWO and v > -TWO and u < last_u and v < last_v):
            continue
        value, sees = careful(color, disparity, u, v, own * scale, tap, weights)
        weight = np.float32(nearness) * sees
        if part is not None:
            weight = weight * part[k]
        store4(out_color, k, add4(load4(out_color, k), scale4(value, weight * bright)))
        out_weight[k] += weight


@inner
def plain(delta: Real) -> Real:
    """The disparity as a frame has it: 0 where only the mark of unsureness is left of it."""
    return delta if delta > FAINT else ZERO


@inner
def blend_partly(
    k: int, place: int, share: Real, behind: F4, below: F4, below_weight: F4, color: F4,
    disparity: F4, coverage: F4,
) -> None:  # fmt: skip
    """Let what is behind show in the part of a pixel that the nearest surface leaves free.

    Arguments as of `finish_rows`; color, disparity and coverage are one row's, and hold what the
    nearest surface shows.
    """
    weight = below_weight[k]
    if weight > ZERO:
        if coverage[place] > ZERO:
            rest = scale4(load4(below, k), (ONE - share) / weight)
            store4(color, place, add4(scale4(load4(color, place), share), rest))
        else:
            store4(color, place, scale4(load4(below, k), ONE / weight))
        if share < HALF or not coverage[place] > ZERO:
            disparity[place] = plain(behind[k])
        coverage[place] = ONE
    elif share < HALF:
        coverage[place], disparity[place] = ZERO, HOLE
        store4(color, place, zero4())
    elif coverage[place] > ZERO:
        coverage[place] = share


@kernel
def finish_rows(
    total: F4, total_weight: F4, front: F4, alpha: F4, index: I4, behind: F4, count: int,
    halo: int, below: F4, below_weight: F4, table: U1, out_color: Any, out_disparity: F4,
    out_coverage: F4,
) -> None:  # fmt: skip
    """Make the frame's rows of what was added up.

    Args:
        total: (rows, width, 4) sum of colours times weights, written over.
        total_weight: (rows, width) sum of the weights; 0 where nothing is known.
        front: (rows, width) disparity of the nearest surface.
        alpha: (rows with halo, width) how much of the pixel it covers.
        index: (count,) pixels that it does not cover whole, in order, counted with the halo.
        behind: (count,) disparity of what is behind it there.
        count: how many.
        halo: rows above the first.
        below: (count, 4) sum of colours times weights of what is behind.
        below_weight: (count,) sum of the weights.
        table: bytes of linear radiance, `ground.color.LINEAR_TO_SRGB8`.
        out_color: (rows, width, 3|4) ``uint8`` sRGB or ``float32`` linear.
        out_disparity: (rows, width), NaN where nothing is known.
        out_coverage: (rows, width).
    """
    rows, width = front.shape
    steps = np.empty(4 * width, np.int32)
    k = 0
    while k < count and index[k] < halo * width:
        k += 1
    for y in range(rows):
        end = (y + halo + 1) * width
        color, disparity, coverage = total[y], out_disparity[y], out_coverage[y]
        for x in range(width):
            weight = total_weight[y, x]
            known = weight > ZERO
            store4(color, x, scale4(load4(color, x), ONE / weight if known else ZERO))
            disparity[x] = plain(front[y, x]) if known else HOLE
            coverage[x] = ONE if known else ZERO
        while k < count and index[k] < end:
            x = index[k] % width
            share = alpha[y + halo, x]
            blend_partly(k, x, share, behind, below, below_weight, color, disparity, coverage)
            k += 1
        for x in range(width):
            disparity[x] = disparity[x] if disparity[x] >= ZERO else NAN
        write_row(color, table, steps, out_color[y])
