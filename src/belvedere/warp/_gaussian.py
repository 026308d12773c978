"""Kernels of the Gaussian reconstructor: each sample an ellipse, weighted over the pixels it holds.

A sample's footprint is a round Gaussian in the reference, carried over by the Jacobian of the warp
(EWA). The Jacobian knows the slope of the sample's surface, so that on a plane neighbouring
footprints overlap in the desired view as they do in the reference, however it is stretched.

Two passes over the samples. The first finds the front surface of each pixel from the footprints'
cores, which leave no gap between neighbours of one surface; the second adds up what lies within a
band of disparity round that front.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import Four, add4, load4, scale4, store4
from belvedere.warp._edges import DOWN, MIXED, RIGHT
from belvedere.warp._tiles import TILE

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
HALF = np.float32(0.5)
NOWHERE = np.float32(-1.0)

CORE = np.float32(0.7072)
"""Radius of a core, reference pixels: half the diagonal between four samples, and a rounding more.
Cores of one surface leave no gap, however the surface has turned and grown."""

LARGEST_REACH = np.float32(64.0)
"""Pixels along an axis that a footprint may reach. More is a guess from one sample, and would let a
sample near the eye paint the whole view."""

FARTHEST = np.float32(1e6)
"""Pixels from the first one beyond which no center is followed: whole numbers end soon after."""

LEAST_WEIGHT, FULL_WEIGHT = np.float32(0.2), np.float32(0.8)
"""Accumulated weight, 1 inside a surface, from which on a pixel is covered, and wholly. At the
straight edge of a surface, half a reference pixel beyond its last samples, it is 0.49."""

FIELDS = 13
X, Y, DELTA, SLOPE_X, SLOPE_Y, SPAN, ROOT_Y, SHEAR, ROOT_X, PER_Y, PER_X, AREA, RIM = (
    field * TILE for field in range(FIELDS)
)
"""Where the fields of the table of footprints begin, each of one row of a tile's samples. X, Y:
center. DELTA, SLOPE_X, SLOPE_Y, SPAN: its warped disparity, how that changes per pixel along its
surface, and at most a reference pixel away. ROOT_Y, SHEAR, ROOT_X: half height of the ellipse whose
radius is one reference pixel, how far its rows shift per row, and half the width of its middle row.
PER_Y, PER_X: one over the squares of the two. AREA: what a weight of 1 counts, 0 for no footprint.
RIM: above 0 if a neighbour is missing or on another surface. (One flat array, so that rows of known
distance tell the compiler that they do not overlap.)"""

WEIGHTS = 1024
"""Entries of the table of weights, over the square of the radius."""
LAST_WEIGHT = np.float32(WEIGHTS)
"""The entry beyond them, which is 0."""


@inner
def slope(before: Real, own: Real, after: Real, tied_before: bool, tied_after: bool) -> Real:
    """Change of disparity per sample along an axis, from the neighbours on the same surface."""
    total = (after - own if tied_after else ZERO) + (own - before if tied_before else ZERO)
    return HALF * total if tied_before and tied_after else total


@inner
def measure_slopes(disparity: F4, links: U1, v: int, u_low: int, u_end: int, out_table: F4) -> None:
    """DELTA, SLOPE_X, SLOPE_Y and RIM of a row, still in the reference; DELTA is NaN for none."""
    height, width = disparity.shape
    above, below = max(v - 1, 0), min(v + 1, height - 1)
    for u in range(u_low, u_end):
        left, right, i = max(u - 1, 0), min(u + 1, width - 1), u - u_low
        own, bits = disparity[v, u], links[v, u]
        tied_left = (u > 0) & (links[v, left] & (RIGHT | MIXED) == RIGHT)
        tied_right = (bits & RIGHT != 0) & (links[v, right] & MIXED == 0)
        tied_above = (v > 0) & (links[above, u] & (DOWN | MIXED) == DOWN)
        tied_below = (bits & DOWN != 0) & (links[below, u] & MIXED == 0)
        out_table[DELTA + i] = own if bits & MIXED == 0 else np.float32(np.nan)
        out_table[SLOPE_X + i] = slope(
            disparity[v, left], own, disparity[v, right], tied_left, tied_right
        )
        out_table[SLOPE_Y + i] = slope(
            disparity[above, u], own, disparity[below, u], tied_above, tied_below
        )
        out_table[RIM + i] = ZERO if tied_left & tied_right & tied_above & tied_below else ONE


@inner
def measure_row(
    w: F4, disparity: F4, links: U1, v: int, u_low: int, u_end: int, low_pass: Real, most: Real,
    out_table: F4,
) -> None:  # fmt: skip
    """Footprints of the samples [u_low, u_end) of reference row ``v``, into the first columns.

    ``most`` is the largest variance along an axis. Straight-line arithmetic: it vectorises.

    Source: spec image-warping 3.7, its slope-aware J and equation 25.
    """
    measure_slopes(disparity, links, v, u_low, u_end, out_table)
    v4 = np.float32(v)
    r0, s0, t0 = w[1] * v4 + w[2], w[5] * v4 + w[6], w[9] * v4 + w[10]
    for i in range(u_end - u_low):
        u4 = np.float32(u_low + i)
        delta, slope_u, slope_v = (
            out_table[DELTA + i],
            out_table[SLOPE_X + i],
            out_table[SLOPE_Y + i],
        )
        t = w[8] * u4 + t0 + w[11] * delta
        scale = ONE / t
        x = (w[0] * u4 + r0 + w[3] * delta) * scale
        y = (w[4] * u4 + s0 + w[7] * delta) * scale
        moved = delta * scale
        t_u, t_v = w[8] + w[11] * slope_u, w[9] + w[11] * slope_v
        x_u = (w[0] + w[3] * slope_u - x * t_u) * scale
        x_v = (w[1] + w[3] * slope_v - x * t_v) * scale
        y_u = (w[4] + w[7] * slope_u - y * t_u) * scale
        y_v = (w[5] + w[7] * slope_v - y * t_v) * scale
        moved_u, moved_v = (slope_u - moved * t_u) * scale, (slope_v - moved * t_v) * scale
        det = x_u * y_v - x_v * y_u
        xx = x_u * x_u + x_v * x_v + low_pass
        yy = y_u * y_u + y_v * y_v + low_pass
        xy = x_u * y_u + x_v * y_v
        spread = det * det + low_pass * (xx + yy - low_pass)  # xx yy - xy xy, without cancelling
        drawn = (t > ZERO) & (det > ZERO) & (xx <= most) & (yy <= most)
        drawn = drawn & (abs(x) < FARTHEST) & (abs(y) < FARTHEST)
        per_y = ONE / yy
        out_table[X + i] = x
        out_table[Y + i] = y
        out_table[DELTA + i] = moved
        out_table[SLOPE_X + i] = (moved_u * y_v - moved_v * y_u) / det
        out_table[SLOPE_Y + i] = (moved_v * x_u - moved_u * x_v) / det
        out_table[SPAN + i] = np.sqrt(moved_u * moved_u + moved_v * moved_v)
        out_table[ROOT_Y + i] = np.sqrt(yy)
        out_table[SHEAR + i] = xy * per_y
        out_table[ROOT_X + i] = np.sqrt(spread * per_y)
        out_table[PER_Y + i] = per_y
        out_table[PER_X + i] = yy / spread
        out_table[AREA + i] = det / np.sqrt(spread) if drawn else ZERO


@inner
def raise_front(
    table: F4, i: int, radius: Real, row_low: int, first: int, end: int, out_front: F4
) -> None:
    """Let sample ``i``'s tangent plane bring the pixels within a radius to the front.

    It may rise no more than within the true footprint, which the low pass makes larger.
    """
    width = out_front.shape[1]
    square = radius * radius
    x0, y0, own, most = table[X + i], table[Y + i], table[DELTA + i], table[SPAN + i] * radius
    half = radius * table[ROOT_Y + i]
    top, bottom = max(int(np.ceil(y0 - half)), first), min(int(np.floor(y0 + half)), end - 1)
    for y in range(top, bottom + 1):
        dy = np.float32(y) - y0
        half = table[ROOT_X + i] * np.sqrt(max(square - dy * dy * table[PER_Y + i], ZERO))
        middle = x0 + table[SHEAR + i] * dy
        left = max(int(np.ceil(middle - half)), 0)
        right = min(int(np.floor(middle + half)), width - 1)
        for x in range(left, right + 1):
            change = table[SLOPE_X + i] * (np.float32(x) - x0) + table[SLOPE_Y + i] * dy
            delta = max(own + min(change, most), ZERO)
            out_front[y - row_low, x] = max(out_front[y - row_low, x], delta)


@kernel
def find_front(
    w: F4, disparity: F4, links: U1, tiles: I4, row_low: int, row_high: int, low_pass: Real,
    cut: Real, out_front: F4, out_rim: F4,
) -> None:  # fmt: skip
    """Disparity of the front surface at each pixel's center.

    The cores of the footprints say it; where none reaches, beyond the last samples of a surface,
    the tails of those samples do.

    Args:
        w: (12,) warp matrix.
        disparity: (H, W), small gaps bridged.
        links: (H, W) bits of `_edges`.
        tiles: (n, FIELDS).
        row_low: first row of the band.
        row_high: row after its last.
        low_pass: squared pixels that every footprint is blurred by.
        cut: radius of a whole footprint, reference pixels.
        out_front: (rows, width), preset to -1.
        out_rim: the same, working memory.
    """
    cut4, low4 = np.float32(cut), np.float32(low_pass)
    most = (LARGEST_REACH / cut4) ** 2
    table = np.empty(FIELDS * TILE, np.float32)
    for n in range(tiles.shape[0]):
        if tiles[n, 7] <= row_low or tiles[n, 6] >= row_high:
            continue
        first, end = max(tiles[n, 6], row_low), min(tiles[n, 7], row_high)
        for v in range(tiles[n, 3], tiles[n, 4]):
            measure_row(w, disparity, links, v, tiles[n, 0], tiles[n, 1], low4, most, table)
            for i in range(tiles[n, 1] - tiles[n, 0]):
                if not table[AREA + i] > ZERO:
                    continue
                raise_front(table, i, CORE, row_low, first, end, out_front)
                if table[RIM + i] > ZERO:
                    raise_front(table, i, cut4, row_low, first, end, out_rim)
    for y in range(row_high - row_low):
        for x in range(out_front.shape[1]):
            if out_front[y, x] < ZERO:
                out_front[y, x] = out_rim[y, x]


@inner
def add_footprint(
    table: F4, i: int, paint: Four, weights: F4, cut: Real, keep: Real, row_low: int, first: int,
    end: int, width: int, front: F4, out_color: F4, out_weight: F4,
) -> None:  # fmt: skip
    """Add sample ``i``, of colour ``paint``, to the pixels whose front it may lie on."""
    square, step = cut * cut, np.float32(WEIGHTS) / (cut * cut)
    x0, y0, shear, root_x = table[X + i], table[Y + i], table[SHEAR + i], table[ROOT_X + i]
    per_x, per_y, area = table[PER_X + i], table[PER_Y + i], table[AREA + i]
    spread = table[SPAN + i] * cut
    lowest = max((table[DELTA + i] - spread) * keep, ZERO)  # where nothing is in front, nothing is
    highest = table[DELTA + i] + spread
    half = cut * table[ROOT_Y + i]
    top, bottom = max(int(np.ceil(y0 - half)), first), min(int(np.floor(y0 + half)), end - 1)
    for y in range(top, bottom + 1):
        dy = np.float32(y) - y0
        below = dy * dy * per_y
        half = root_x * np.sqrt(max(square - below, ZERO))
        middle = x0 + shear * dy
        left = max(int(np.ceil(middle - half)), 0)
        right = min(int(np.floor(middle + half)), width - 1)
        row = np.uint64((y - row_low) * width)  # unsigned: nothing is asked about negative ones
        for x in range(left, right + 1):
            at: Any = row + np.uint64(x)
            shown = front[at]
            if shown < lowest or shown * keep > highest:
                continue
            off = np.float32(x) - middle
            place = np.uint32(min((below + off * off * per_x) * step, LAST_WEIGHT))
            weight = weights[place] * area
            store4(out_color, at, add4(load4(out_color, at), scale4(paint, weight)))
            out_weight[at] += weight


@kernel
def accumulate(
    w: F4, color: F4, disparity: F4, links: U1, tiles: I4, row_low: int, row_high: int,
    low_pass: Real, weights: F4, cut: Real, tolerance: Real, front: F4,
    out_color: F4, out_weight: F4,
) -> None:  # fmt: skip
    """Add up the footprints that lie on the front surface.

    Args:
        w: (12,) warp matrix.
        color: (H, W, 4) linear.
        disparity: (H, W), small gaps bridged.
        links: (H, W) bits of `_edges`.
        tiles: (n, FIELDS).
        row_low: first row of the band.
        row_high: row after its last.
        low_pass: squared pixels that every footprint is blurred by.
        weights: (WEIGHTS + 1,) of `footprint_weights`.
        cut: radius of a footprint, reference pixels.
        tolerance: relative difference in disparity of what is one surface.
        front: (rows * width,) from `find_front`.
        out_color: (rows, width, 4) sums, preset to 0.
        out_weight: (rows * width,) sums, preset to 0.
    """
    cut4, low4, keep = np.float32(cut), np.float32(low_pass), np.float32(1.0 - tolerance)
    most = (LARGEST_REACH / cut4) ** 2
    stride, width = disparity.shape[1], out_color.shape[1]
    table = np.empty(FIELDS * TILE, np.float32)
    for n in range(tiles.shape[0]):
        if tiles[n, 7] <= row_low or tiles[n, 6] >= row_high:
            continue
        first, end = max(tiles[n, 6], row_low), min(tiles[n, 7], row_high)
        for v in range(tiles[n, 3], tiles[n, 4]):
            measure_row(w, disparity, links, v, tiles[n, 0], tiles[n, 1], low4, most, table)
            for i in range(tiles[n, 1] - tiles[n, 0]):
                if not table[AREA + i] > ZERO:
                    continue
                paint = load4(color, v * stride + tiles[n, 0] + i)
                add_footprint(
                    table, i, paint, weights, cut4, keep, row_low, first, end, width, front,
                    out_color, out_weight,
                )  # fmt: skip


@kernel
def resolve(weight: F4, front: F4, out_color: F4, out_disparity: F4, out_coverage: F4) -> None:
    """Divide by the weights; what too little reaches is a hole.

    Args:
        weight: (rows, width) sums.
        front: (rows, width).
        out_color: (rows, width, 4) sums, divided in place.
        out_disparity: (rows, width), -1 in holes.
        out_coverage: (rows, width).
    """
    rows, width = weight.shape
    for y in range(rows):
        for x in range(width):
            held = weight[y, x]
            covered = held > LEAST_WEIGHT
            scale = ONE / held if covered else ZERO
            for k in range(4):
                out_color[y, x, k] *= scale
            out_disparity[y, x] = front[y, x] if covered else NOWHERE
            share = (held - LEAST_WEIGHT) / (FULL_WEIGHT - LEAST_WEIGHT)
            out_coverage[y, x] = min(share, ONE) if covered else ZERO
