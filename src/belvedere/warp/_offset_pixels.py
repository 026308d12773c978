"""Pixels that a wide sub-sample lands in: one look-up at their own centre instead of a filter.

A sub-sample tells which place of the reference lands where in the pixel; one step of Newton's
method, with the slope of its surface, leads from there to the place that lands on its centre.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner
from belvedere.ground.simd import load4, max4, mul32, shl32, shr32, store4, zero4
from belvedere.warp._edges import SMOOTH
from belvedere.warp._offset_color import edge_color, smooth_color
from belvedere.warp._offset_word import EMPTY, IN_CELL, STEPS, WIDE, disparity_in

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]
U4 = npt.NDArray[np.uint32]
U8 = npt.NDArray[np.uint64]

ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)

CHUNK = np.uint64(64)
"""Pixels that are worked on at once; what belongs to them is a power of two apart in one array, so
that the compiler can tell one from another."""
CHUNK2, CHUNK3 = np.uint64(128), np.uint64(192)

FILTERED = 0
"""No wide sub-sample landed in the pixel: the filter makes its colour."""
WHOLE = 1
"""Bit: one did, and nothing in the pixel lies in front of it: it is the pixel's colour."""
BEHIND = 2
"""Bit: one did, but something lies in front: it fills what that leaves of the pixel."""
BEYOND = 4
"""Bit: the pixel is outside the view, or of another band: needed for the filter only."""


@inner
def nearest_words(
    words: U8, start: int, columns: int, scale_b: int, count: int, out_front: U8, out_wide: U8
) -> None:
    """The largest word of each pixel of a row, and the largest wide one; EMPTY without one."""
    for pixel in range(count):
        front, wide = EMPTY, EMPTY
        first = np.uint64(start) + np.uint64(pixel) * np.uint64(scale_b)
        for j in range(scale_b):
            for i in range(scale_b):
                held = words[first + np.uint64(j * columns + i)]
                front = held if held > front else front
                held = held if held & WIDE else EMPTY
                wide = held if held > wide else wide
        out_front[pixel], out_wide[pixel] = front, wide


@inner
def find_wide(
    words: U8, start: int, columns: int, scale_b: int, count: int, keep: Real, layout: Any,
    front: U8, out_kind: U1, out_pixel: U4, out_held: U8,
) -> int:  # fmt: skip
    """List the pixels of a row in which a wide sub-sample landed, with the nearest such word.

    Args:
        words: flat.
        start: the first of the row of pixels.
        columns: of the buffer.
        scale_b: cells per pixel and axis.
        count: pixels.
        keep: share of a disparity down to which another is of the same surface.
        layout: of words.
        front: (count,) to work in.
        out_kind: (count,) FILTERED, WHOLE or BEHIND.
        out_pixel: (count,) the pixels listed.
        out_held: (count,) their words.

    Returns:
        How many are listed.
    """
    if scale_b == 2:  # the same, but known to the compiler
        nearest_words(words, start, columns, 2, count, front, out_held)
    else:
        nearest_words(words, start, columns, scale_b, count, front, out_held)
    listed = 0
    for pixel in range(count):
        wide, nearest = out_held[pixel], front[pixel]
        out_held[listed], out_pixel[listed] = wide, pixel
        kind = WHOLE
        if wide != nearest:
            in_front = disparity_in(wide, layout) >= disparity_in(nearest, layout) * keep
            kind = FILTERED if wide == EMPTY else WHOLE if in_front else BEHIND
        out_kind[pixel] = kind if wide != EMPTY else FILTERED
        listed += 1 if wide != EMPTY else 0
    return listed


@inner
def take_cells(
    disparity: F4, row: Real, count: int, held: U8, layout: Any, out_place: U4, out_cell: F4
) -> None:
    """Of some words the cells' corners and places, each kind CHUNK numbers after the other.

    Args:
        disparity: flat.
        row: samples in a row of the reference, uint32.
        count: words, up to CHUNK.
        held: (count,) words.
        layout: of words.
        out_place: (3 CHUNK,) row, column and, along u and IN_CELL bits higher along v, place.
        out_cell: (4 CHUNK,) disparities: above left, above right, below left, below right.
    """
    low, across, one = np.uint64(2 * IN_CELL + 1), np.uint32(layout.across), np.uint32(1)
    mask_u = np.uint32((1 << layout.across) - 1)
    mask_v = np.uint32((1 << (layout.low - layout.across - 2 * IN_CELL - 1)) - 1)
    mask_step = np.uint32((1 << (2 * IN_CELL)) - 1)
    for n in range(np.uint64(count)):
        word = held[n]
        cell = np.uint32(word >> low)
        u = np.uint32(np.uint32(cell & mask_u) - one)
        v = np.uint32(np.uint32(shr32(cell, across) & mask_v) - one)
        out_place[n], out_place[n + CHUNK] = v, u
        out_place[n + CHUNK2] = np.uint32(np.uint32(word >> np.uint64(1)) & mask_step)
        at = np.uint64(mul32(v, row) + u)
        below = np.uint64(at + np.uint64(row))
        out_cell[n], out_cell[n + CHUNK] = disparity[at], disparity[at + np.uint64(1)]
        out_cell[n + CHUNK2] = disparity[below]
        out_cell[n + CHUNK3] = disparity[below + np.uint64(1)]


@inner
def find_centers(
    w: F4, row: Real, x_first: Real, y: Real, count: int, pixel: U4, places: U4, cells: F4,
    out_sample: U4, out_step: U4, out_delta: F4,
) -> None:  # fmt: skip
    """Place in the reference, and warped disparity, of the centres of listed pixels.

    Straight-line arithmetic on 32 bits on purpose: it vectorises. Cells round a wide sub-sample's
    are intact, and no place further away is looked for.

    Args:
        w: (12,) warp matrix.
        row: samples in a row of the reference, uint32.
        x_first: column of pixel 0.
        y: row of the pixels.
        count: how many are listed, up to CHUNK.
        pixel: (count,).
        places: from `take_cells`.
        cells: likewise.
        out_sample: (count,) flat index of the sample above left of the place.
        out_step: (count,) place from there, along u and, IN_CELL bits higher, along v.
        out_delta: (count,) warped disparity.
    """
    w0, w1, w2, w3, w4, w5 = w[0], w[1], w[2], w[3], w[4], w[5]
    w6, w7, w8, w9, w10, w11 = w[6], w[7], w[8], w[9], w[10], w[11]
    mask, fine = np.uint32((1 << IN_CELL) - 1), np.uint32(IN_CELL)
    step, near = ONE / STEPS, np.float32(2.0) - ONE / STEPS
    for n in range(np.uint64(count)):
        v4, u4 = np.float32(np.int32(places[n])), np.float32(np.int32(places[n + CHUNK]))
        inside = places[n + CHUNK2]
        fu = np.float32(np.int32(inside & mask)) * step
        fv = np.float32(np.int32(shr32(inside, fine))) * step
        a, b, c, d = cells[n], cells[n + CHUNK], cells[n + CHUNK2], cells[n + CHUNK3]
        slope_u, slope_v = b - a + fv * (d - c - b + a), c - a + fu * (d - b - c + a)
        delta = a + fv * (c - a) + fu * slope_u
        uu, vv = u4 + fu, v4 + fv
        t = w8 * uu + w9 * vv + w10 + w11 * delta
        scale = ONE / t
        x = (w0 * uu + w1 * vv + w2 + w3 * delta) * scale
        y0 = (w4 * uu + w5 * vv + w6 + w7 * delta) * scale
        # how t x, t y and t change along u and v on the surface, less what t alone changes of them
        tu, tv = w8 + w11 * slope_u, w9 + w11 * slope_v
        xu, xv = w0 + w3 * slope_u - x * tu, w1 + w3 * slope_v - x * tv
        yu, yv = w4 + w7 * slope_u - y0 * tu, w5 + w7 * slope_v - y0 * tv
        right, down = x_first + np.float32(np.int32(pixel[n])) - x, y - y0
        share = t / (xu * yv - xv * yu)
        u_new = uu + (right * yv - down * xv) * share
        v_new = vv + (down * xu - right * yu) * share
        u_new = u_new if u_new > u4 - ONE else u4 - ONE
        v_new = v_new if v_new > v4 - ONE else v4 - ONE
        u_new = u_new if u_new < u4 + near else u4 + near
        v_new = v_new if v_new < v4 + near else v4 + near
        fine_u = np.uint32(np.int32(u_new * STEPS + HALF))
        fine_v = np.uint32(np.int32(v_new * STEPS + HALF))
        at_u, at_v = shr32(fine_u, fine), shr32(fine_v, fine)
        out_sample[n] = np.uint32(mul32(at_v, row) + at_u)
        out_step[n] = np.uint32(np.uint32(fine_u & mask) | shl32(np.uint32(fine_v & mask), fine))
        u_new, v_new = u_new - uu, v_new - vv
        # a steep surface, continued, may end beyond infinity or at the eye
        delta = max(delta + slope_u * u_new + slope_v * v_new, ZERO)
        out_delta[n] = delta / max(t + tu * u_new + tv * v_new, HALF * t)


@inner
def look_up_centers(
    color: F4, links: U1, flags: U1, spread: F4, cubics: F4, count: int, pixel: U4, sample: U4,
    step: U4, delta: F4, slot: int, out_color: F4, out_delta: F4,
) -> None:  # fmt: skip
    """Colours and disparities of the listed pixels of a row.

    Args:
        color: (H, W, 4), linear.
        links: (H, W) bits of `_edges`.
        flags: the same, flat.
        spread: see `resolve_offset_buffer`.
        cubics: ...
        count: how many are listed.
        pixel: (count,).
        sample: (count,) from `find_centers`.
        step: (count,) likewise.
        delta: (count,) likewise.
        slot: of the row's first pixel in the outputs.
        out_color: (n, 4), not below 0.
        out_delta: (n,).
    """
    stride, mask = color.shape[1], np.uint64((1 << IN_CELL) - 1)
    for n in range(count):
        at = np.uint64(sample[n])
        step_u = np.uint64(step[n]) & mask
        step_v = np.uint64(step[n]) >> np.uint64(IN_CELL)
        if flags[at] & SMOOTH:
            first = np.int64(at) - (stride + 1)
            value = smooth_color(color, stride, spread, cubics, first, step_v, step_u)
        else:
            v = np.int64(at) // stride
            u = np.int64(at) - v * stride
            value = edge_color(color, links, v, u, np.int64(step_v), np.int64(step_u))
        place = np.uint64(slot) + np.uint64(pixel[n])
        store4(out_color, place, max4(value, zero4()))
        out_delta[place] = delta[n]


@inner
def show_centers(color: F4, delta: F4, slot: int, row: int, out_color: F4, out_disparity: F4,
                 out_coverage: F4) -> None:  # fmt: skip
    """Copy a row of looked-up pixels to the picture; those that are not WHOLE are made later."""
    width = out_disparity.shape[1]
    for x in range(width):
        store4(out_color, row * width + x, load4(color, slot + x))
        out_disparity[row, x] = delta[np.uint64(slot + x)]
        out_coverage[row, x] = ONE
