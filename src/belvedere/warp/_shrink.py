"""Kernels of the inverse pass for where the desired view shrinks a reference.

There a pixel covers many samples, and the sixteen round its centre do not stand for them. Colours
are then looked up in smaller copies of the reference. A sample of a copy is the mean of four of the
next finer one, of one surface only: that of most, of the nearer in doubt. Surfaces at different
depths so never mix, and what a copy leaves out of one is looked up in the finer ones.

Source: williams1983pyramidal, for copies by halves and places between two of them.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import (
    Four,
    add4,
    add_weighted16,
    fold16,
    four,
    kept4,
    lane4,
    load4,
    load16,
    scale4,
    store4,
    sum4,
    zero4,
    zero16,
)
from belvedere.warp._edges import SMOOTH
from belvedere.warp._landing import land_flat
from belvedere.warp._lookup import EDGE_WEIGHT, FAINT
from belvedere.warp._tiles import TILE

F4 = npt.NDArray[np.float32]
F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO, THREE = np.float32(2.0), np.float32(3.0)
NAN = np.float32(np.nan)

BEGIN = np.float32(np.sqrt(2.0))
"""Samples along the side of a pixel from which on their mean is shown: up to twice as many, which
four in a row hold, of the reference itself, and so on."""
WHOLLY = np.float32(2.0)
"""Samples from which on the mean alone is; in between, what is at the centre has some part."""
FINEST = np.float32(1e-3)
"""The least part of what is at the centre: it is all where the copies leave a surface out."""
NONE = 255
"""Instead of a copy, where the centre tells all."""


@kernel
def largest_shrink(w: F8, tiles: I4, low: F4, high: F4, view_width: int, view_height: int) -> float:
    """How many samples along its side a pixel covers at most, where the middles of tiles land.

    Those that land outside the view do not count: it does not depend on how many are listed.

    Args:
        w: (3, 4) warp matrix.
        tiles: (n, FIELDS), whole ones.
        low: (tiles down, tiles across) smallest disparities.
        high: the largest.
        view_width: of the desired view.
        view_height: of the desired view.
    """
    least = np.inf
    for n in range(tiles.shape[0]):
        row, column = tiles[n, 3] // TILE, tiles[n, 0] // TILE
        delta = 0.5 * (np.float64(low[row, column]) + np.float64(high[row, column]))
        u, v = 0.5 * (tiles[n, 0] + tiles[n, 1]), 0.5 * (tiles[n, 3] + tiles[n, 4])
        t = w[2, 0] * u + w[2, 1] * v + w[2, 2] + w[2, 3] * delta
        if t > 0.0:
            x = (w[0, 0] * u + w[0, 1] * v + w[0, 2] + w[0, 3] * delta) / t
            y = (w[1, 0] * u + w[1, 1] * v + w[1, 2] + w[1, 3] * delta) / t
            if not (-0.5 <= x <= view_width - 0.5 and -0.5 <= y <= view_height - 0.5):
                continue
            area = (w[0, 0] - x * w[2, 0]) * (w[1, 1] - y * w[2, 1])
            area -= (w[0, 1] - x * w[2, 1]) * (w[1, 0] - y * w[2, 0])
            least = min(least, abs(area) / (t * t))
    return 1.0 / np.sqrt(max(least, 1e-12))


@kernel
def halve_surfaces(
    color: F4, disparity: F4, tolerance: Real, out_color: F4, out_disparity: F4
) -> None:
    """Make a copy of half the size.

    Args:
        color: (H, W, 4) linear.
        disparity: (H, W), NaN where nothing is known.
        tolerance: relative difference in disparity up to which two samples are one surface.
        out_color: (ceil(H / 2), ceil(W / 2), 4).
        out_disparity: (ceil(H / 2), ceil(W / 2)), NaN where none of the four samples is known.
    """
    height, width = disparity.shape
    flat, reach = disparity.reshape(-1), np.float32(tolerance)
    for y in range(out_disparity.shape[0]):
        for x in range(out_disparity.shape[1]):
            best, most, nearest = 0, 0, ZERO
            for k in range(4):
                v, u = 2 * y + (k >> 1), 2 * x + (k & 1)
                if v >= height or u >= width or not disparity[v, u] >= ZERO:
                    continue
                own, alike = disparity[v, u], 0
                for m in range(4):
                    v2, u2 = min(2 * y + (m >> 1), height - 1), min(2 * x + (m & 1), width - 1)
                    alike += int(abs(disparity[v2, u2] - own) <= reach * own + FAINT)
                if alike > most or (alike == most and own > nearest):
                    best, most, nearest = v * width + u, alike, own
            total, count, depth = zero4(), ZERO, ZERO
            for k in range(4):
                v, u = 2 * y + (k >> 1), 2 * x + (k & 1)
                if v >= height or u >= width or most == 0:
                    continue
                at = v * width + u
                own = flat[np.uint64(best)]
                if abs(flat[np.uint64(at)] - own) <= reach * own + FAINT:
                    total = add4(total, load4(color, at))
                    depth += flat[np.uint64(at)]
                    count += ONE
            share = ONE / count if count > ZERO else ZERO
            store4(out_color, y * out_disparity.shape[1] + x, scale4(total, share))
            out_disparity[y, x] = depth * share if count > ZERO else NAN


@inner
def box4(from_first: Real, half: Real) -> Four:
    """Shares that four samples in a row have in a box, each being one wide.

    from_first is the way from the first to the box's middle, half its width from 1/2 to 3/2.
    """
    reach, share = half + HALF, HALF / half
    return four(
        min(max(reach - abs(from_first), ZERO), ONE) * share,
        min(max(reach - abs(from_first - ONE), ZERO), ONE) * share,
        min(max(reach - abs(from_first - TWO), ZERO), ONE) * share,
        min(max(reach - abs(from_first - THREE), ZERO), ONE) * share,
    )


@inner
def mean_in_box(
    color: F4, disparity: F4, u: Real, v: Real, half_u: Real, half_v: Real, delta: Real, near: Real
) -> tuple[Four, Real]:
    """Mean colour of one surface in a box, and how much of the box it fills.

    Args:
        color: (H, W, 4), at least 4 x 4.
        disparity: (H, W).
        u: column of the box's middle.
        v: row.
        half_u: half its width.
        half_v: half its height.
        delta: disparity of the surface.
        near: how far a sample's may be from it.
    """
    height, stride = disparity.shape
    i = min(max(int(np.floor(u)) - 1, 0), stride - 4)
    j = min(max(int(np.floor(v)) - 1, 0), height - 4)
    across, along = box4(u - np.float32(i), half_u), box4(v - np.float32(j), half_v)
    first = j * stride + i
    row0 = scale4(kept4(disparity, first, delta, near, across), lane4(along, 0))
    row1 = scale4(kept4(disparity, first + stride, delta, near, across), lane4(along, 1))
    row2 = scale4(kept4(disparity, first + 2 * stride, delta, near, across), lane4(along, 2))
    row3 = scale4(kept4(disparity, first + 3 * stride, delta, near, across), lane4(along, 3))
    filled = sum4(add4(add4(row0, row1), add4(row2, row3)))
    if not filled > ZERO:
        return zero4(), ZERO
    total = add_weighted16(zero16(), load16(color, first), row0)
    total = add_weighted16(total, load16(color, first + stride), row1)
    total = add_weighted16(total, load16(color, first + 2 * stride), row2)
    total = add_weighted16(total, load16(color, first + 3 * stride), row3)
    return scale4(fold16(total), ONE / filled), filled


@inner
def pixel_box(back: F4, x: Real, y: Real, delta: Real) -> tuple[Real, Real, Real]:
    """Samples of a reference that a pixel covers across and down, and the root of its area there.

    back is the (12,) matrix from the desired view to the reference; delta the disparity shown.
    """
    u, v, scale = land_flat(back, x, y, delta)
    ux, uy = (back[0] - u * back[8]) * scale, (back[1] - u * back[9]) * scale
    vx, vy = (back[4] - v * back[8]) * scale, (back[5] - v * back[9]) * scale
    return np.sqrt(ux * ux + uy * uy), np.sqrt(vx * vx + vy * vy), np.sqrt(abs(ux * vy - uy * vx))


@inner
def half_box(wide: Real, size: Real) -> Real:
    """Half the width, in samples of a copy, of the box for so many samples of the reference.

    The copy is blurred already by as much as its samples are wider: the box is narrower by that.
    """
    rest = wide * wide * size * size - ONE + size * size
    return min(np.sqrt(max(rest, ONE)), THREE) * HALF


@kernel
def find_levels(
    back: F4, index: I4 | None, delta: F4, sees: U1 | None, width: int, row_low: int,
    column_low: int, column_end: int, count: int, out_level: U1, out_part: F4,
) -> None:  # fmt: skip
    """Which copy of a reference is to tell what each pixel shows, and what its centre does.

    Args:
        back: (12,) matrix from the desired view to the reference.
        index: (n,) pixels, ``y * width + x``; None for all in order.
        delta: (n,) disparities there, -1 = none.
        sees: (n,) 1 where the reference sees that surface, else nothing is asked; None: everywhere.
        width: of the desired view.
        row_low: desired row of pixel 0.
        column_low: first desired column that the reference can reach.
        column_end: the one after the last, or more.
        count: copies there are, the reference itself included.
        out_level: (n,) which copy, 0 the reference itself, `NONE` for none.
        out_part: (n,) what the samples round the pixel's centre count beside that.
    """
    for k in range(delta.size):
        out_level[k], out_part[k] = NONE, ONE
        if delta[k] < ZERO or (sees is not None and not sees[k]):
            continue
        at = k if index is None else int(index[k])
        x = at % width
        if x < column_low or x >= column_end:
            continue
        x4, y4 = np.float32(x), np.float32(at // width + row_low)
        side = pixel_box(back, x4, y4, delta[k])[2]
        if side > BEGIN:  # refuses NaN too
            out_level[k] = min(int(np.log2(side / BEGIN)), count - 1)
            out_part[k] = max((WHOLLY - side) / (WHOLLY - BEGIN), FINEST)


@kernel
def look_up_copy(
    back: F4, color: F4, disparity: F4, level: int, finest: F4, links: U1, index: I4 | None,
    delta: F4, levels: U1, part: F4, width: int, row_low: int, nearness: Real, gain: Real,
    tap_tolerance: Real, out_color: F4, out_weight: F4,
) -> None:  # fmt: skip
    """Add the mean colours of the pixels that ask a copy of a reference, times their weights.

    Args:
        back: (12,) matrix from the desired view to the reference.
        color: (h, w, 4) linear, of the copy.
        disparity: (h, w) of the copy.
        level: how often it was halved.
        finest: (H, W) disparity of the reference itself.
        links: (H, W) bits of `_edges`.
        index: (n,) pixels, ``y * width + x``; None for all in order.
        delta: (n,) disparities there.
        levels: (n,) of `find_levels`.
        part: (n,) of `find_levels`.
        width: of the desired view.
        row_low: desired row of pixel 0.
        nearness: weight of this reference.
        gain: factor of its colours.
        tap_tolerance: relative difference of samples that may be mixed.
        out_color: (n, 4) sum.
        out_weight: (n,) sum.
    """
    height, stride = links.shape
    own, tap, bright = np.float32(nearness), np.float32(tap_tolerance), np.float32(gain)
    size = ONE / np.float32(1 << level)
    last_u, last_v = np.float32(stride) - HALF, np.float32(height) - HALF
    flat_links, flat = links.reshape(-1), finest.reshape(-1)
    for k in range(delta.size):
        if levels[k] != level:
            continue
        at = k if index is None else int(index[k])
        x4, y4 = np.float32(at % width), np.float32(at // width + row_low)
        u, v, scale = land_flat(back, x4, y4, delta[k])
        if not (u > -HALF and v > -HALF and u < last_u and v < last_v):
            continue
        across, down, _ = pixel_box(back, x4, y4, delta[k])
        landed = delta[k] * scale
        value, filled = mean_in_box(
            color, disparity, (u + HALF) * size - HALF, (v + HALF) * size - HALF,
            half_box(across, size), half_box(down, size),
            landed, tap * np.float32(1 + level) * landed + FAINT,
        )  # fmt: skip
        place = np.uint64(int(v + HALF) * stride + int(u + HALF))
        pure = flat_links[place] & SMOOTH and abs(flat[place] - landed) <= tap * landed + FAINT
        weight = own * (ONE - part[k]) * filled * (ONE if pure else EDGE_WEIGHT)
        store4(out_color, k, add4(load4(out_color, k), scale4(value, weight * bright)))
        out_weight[k] += weight
