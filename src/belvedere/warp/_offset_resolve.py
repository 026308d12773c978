"""The kernel that filters the offset buffer's visible sub-samples into a picture.

The filter is two output pixels wide, so all the cells of a block of b x b between the centres of
four pixels count in these four: a block adds the colours of its cells once, with four weights each,
and passes the sums on.

::

     pixel (x-1, y-1)      pixel (x, y-1)
             +---------------+
             |   block (x,y) |        its cells' colours are looked up here and nowhere else,
             +---------------+        in the reference, at the place that their words hold
     pixel (x-1, y)        pixel (x, y)

A pixel whose front is a wide sub-sample needs no filter: it shows the reference at its own centre,
and so do all its cells to filters nearby. Blocks between four of them are passed over.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import (
    add4,
    add16,
    lane4,
    load4,
    max4,
    outer16,
    part16,
    scale4,
    store4,
    zero4,
    zero16,
)
from belvedere.warp._edges import SMOOTH
from belvedere.warp._offset_color import edge_color, smooth_color
from belvedere.warp._offset_pixels import (
    BEHIND,
    BEYOND,
    CHUNK,
    WHOLE,
    find_centers,
    find_wide,
    look_up_centers,
    show_centers,
    take_cells,
)
from belvedere.warp._offset_word import EMPTY, cell_in, disparity_in, place_in

F4 = npt.NDArray[np.float32]
I8 = npt.NDArray[np.int64]
U1 = npt.NDArray[np.uint8]
U8 = npt.NDArray[np.uint64]

ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
INFINITY = np.float32(np.inf)
SETTLED = np.uint8(WHOLE | BEYOND)
"""Bits of pixels that need no filter."""


@inner
def lends(kind: Real, own: Real, least: Real) -> bool:
    """Whether a cell shows its pixel's wide sub-sample instead of what it sees itself.

    Args:
        kind: of the pixel.
        own: disparity of what the cell sees, -1 if nothing.
        least: disparity below which that is behind the wide sub-sample.
    """
    return (kind & WHOLE) != 0 or ((kind & BEHIND) != 0 and own < least)


@inner
def seen_in_cell(
    words: U8, at: int, kind: Real, behind: Real, keep: Real, layout: Any
) -> tuple[Real, bool]:
    """Disparity of what a cell sees, -1 if nothing; whether it is its pixel's wide sub-sample.

    Args:
        words: flat.
        at: the cell's word.
        kind: of its pixel.
        behind: disparity of the pixel's wide sub-sample.
        keep: share of a disparity down to which another is of the same surface.
        layout: of words.
    """
    held = words[np.uint64(at)]
    own = disparity_in(held, layout) if held != EMPTY else -ONE
    wide = lends(kind, own, behind * keep)
    return (behind if wide else own), wide


@inner
def front_disparity(
    words: U8, start: int, columns: int, kinds: U1, behind: F4, slots: I8, left: int, weights: F4,
    middles: F4, layout: Any, scale_b: int, keep: Real,
) -> Real:  # fmt: skip
    """Disparity of the surface with more weight in a pixel that may see two; -1 without one.

    The surface in front is what the pixel's own cells see nearest.

    Args:
        words: flat.
        start: the first word that the pixel's filter reaches.
        columns: of the buffer.
        kinds: of pixels.
        behind: disparities of their wide sub-samples.
        slots: (3,) where rows of pixels begin in those two: the row above, its own, the one below.
        left: the pixel left of it in its row.
        weights: see `resolve_offset_buffer`.
        middles: (b b, 4) the mean weights of each cell.
        layout: of words.
        scale_b: cells per pixel and axis.
        keep: share of a disparity down to which another is of the same surface.
    """
    half = scale_b >> 1
    front, near, far, near_delta, far_delta = -ONE, ZERO, ZERO, ZERO, ZERO
    for step in range(2):  # first the surface in front, then what weighs more
        low, high = (half, half + scale_b) if step == 0 else (0, 2 * scale_b)
        for j in range(low, high):
            for i in range(low, high):
                at = start + j * columns + i
                pixel = slots[(j + half) // scale_b] + left + (i + half) // scale_b
                delta, wide = seen_in_cell(words, at, kinds[pixel], behind[pixel], keep, layout)
                if step == 0:
                    front = max(front, delta)
                if step == 0 or delta < ZERO:
                    continue
                # the pixel lies right of and below blocks that begin before its own
                lane = 2 * (1 if j < scale_b else 0) + (1 if i < scale_b else 0)
                cell = (j % scale_b) * scale_b + i % scale_b
                weight = middles[cell, lane]
                if not wide:
                    place = int(place_in(words[at], layout))
                    weight = weights[(cell << (2 * layout.bits)) + place, lane]
                if delta >= front * keep:
                    near += weight
                    near_delta += weight * delta
                else:
                    far += weight
                    far_delta += weight * delta
        if front < ZERO:
            return front
    return near_delta / near if near >= far else far_delta / far


@inner
def lay_block(scale_b: int, columns: int, out_offset: U8, out_hit: U8) -> None:
    """Of each cell of a block: where its word is, from the block's first, and what a hit counts.

    Hits of the four corners of a block go to four bytes: each corner lies in another pixel.
    """
    half = scale_b >> 1
    for j in range(scale_b):
        for i in range(scale_b):
            out_offset[j * scale_b + i] = j * columns + i
            corner = 2 * (1 if j >= half else 0) + (1 if i >= half else 0)
            out_hit[j * scale_b + i] = 1 << (8 * corner)


@inner
def lay_pixels(scale_b: int, upper: int, lower: int, out_pixel: U8) -> None:
    """Of each cell of a row's first block: its pixel, from those left of it above and below."""
    half = scale_b >> 1
    for j in range(scale_b):
        for i in range(scale_b):
            left = lower if j >= half else upper
            out_pixel[j * scale_b + i] = left + (1 if i >= half else 0)


@inner
def find_middles(weights: F4, cells: int, places: int, out: F4) -> None:
    """The mean weights of each cell, for what fills the whole of it."""
    share = ONE / np.float32(places)
    for n in range(cells):
        for lane in range(4):
            total = ZERO
            for place in range(places):
                total += weights[n * places + place, lane]
            out[n, lane] = total * share


@inner
def hits_at(hits: Real, corner: int) -> Real:
    """Cells hit in one corner of a block."""
    return np.float32(np.uint32(np.uint32(hits >> np.uint64(8 * corner)) & np.uint32(255)))


@kernel
def resolve_offset_buffer(
    w: F4, disparity: F4, words: U8, color: F4, links: U1, weights: F4, spread: F4, cubic: F4,
    layout: Any, scale_b: int, tolerance: Real, adaptive: bool, row_low: int, above_color: F4,
    above: F4, wide_color: F4, wide_delta: F4, out_color: F4, out_disparity: F4, out_coverage: F4,
) -> None:  # fmt: skip
    """Filter the visible sub-samples into output pixels.

    Args:
        w: (12,) warp matrix.
        disparity: (H, W) of the reference.
        words: ((rows + 2) b, (width + 2) b), a pixel of margin on every side.
        color: (H, W, 4) of the reference, linear.
        links: (H, W) bits of `_edges`.
        weights: (b b 2^2o, 4) weight of each place of each cell of a block in the pixels above
            left, above right, below left and below right.
        spread: (2^IN_CELL, 16) weights of four samples in a row, each four times.
        cubic: (2^IN_CELL, 4) the same, each once.
        layout: of words.
        scale_b: cells per pixel and axis.
        tolerance: relative difference in disparity up to which cells are one surface.
        adaptive: whether some words may be wide.
        row_low: of the first output pixel in the desired view.
        above_color: (width, 4) to work in: what the blocks above gave to a row of pixels.
        above: (width, 4) likewise: weight, weighted disparity, least and greatest disparity.
        wide_color: (3, width + 2, 4) likewise: what wide sub-samples show of three rows of pixels.
        wide_delta: (3, width + 2) likewise: their disparities.
        out_color: (rows, width, 4), not below 0.
        out_disparity: (rows, width), the surface with more weight; -1 = uncovered.
        out_coverage: (rows, width), share of the pixel's own cells that were hit.
    """
    rows, width = out_disparity.shape
    stride, columns, cells = color.shape[1], words.shape[1], scale_b * scale_b
    half, line = scale_b >> 1, width + 2
    places = np.uint64(2 * layout.bits)
    share, keep = ONE / np.float32(cells), np.float32(1.0 - tolerance)
    offset, hit = np.empty(cells, np.uint64), np.empty(cells, np.uint64)
    pixel_at = np.empty(cells, np.uint64)
    middles = np.empty((cells, 4), np.float32)
    lay_block(scale_b, columns, offset, hit)
    find_middles(weights, cells, 1 << (2 * layout.bits), middles)
    all_words, flags, deltas = words.reshape(-1), links.reshape(-1), disparity.reshape(-1)
    cubics, behind = cubic.reshape(-1), wide_delta.reshape(-1)
    kinds, slots = np.zeros(3 * line, np.uint8), np.zeros(3, np.int64)
    pixel, held_by = np.empty(line, np.uint32), np.empty(line, np.uint64)
    place, step = np.empty(line, np.uint32), np.empty(line, np.uint32)
    center, front = np.empty(line, np.float32), np.empty(line, np.uint64)
    places_at, corner = np.empty(3 * CHUNK, np.uint32), np.empty(4 * CHUNK, np.float32)
    for block_y in range(-1, rows + 1):
        # of each row of pixels first what wide sub-samples show, then the blocks above it
        slots[0], slots[1], slots[2] = slots[1], slots[2], (block_y + 1) % 3 * line
        y, slot = block_y - 1, slots[2]
        listed = 0
        kinds[slot : slot + line] = np.uint8(0)
        if adaptive:
            listed = find_wide(
                all_words, (block_y + 1) * scale_b * columns, columns, scale_b, line, keep, layout,
                front, kinds[slot:], pixel, held_by,
            )  # fmt: skip
        for first in range(0, listed, int(CHUNK)):
            count = min(listed - first, int(CHUNK))
            take_cells(deltas, np.uint32(stride), count, held_by[first:], layout, places_at, corner)
            find_centers(
                w, np.uint32(stride), -ONE, np.float32(row_low + block_y), count, pixel[first:],
                places_at, corner, place[first:], step[first:], center[first:],
            )  # fmt: skip
        look_up_centers(
            color, links, flags, spread, cubics, listed, pixel, place, step, center, slot,
            wide_color, behind,
        )  # fmt: skip
        if block_y < 0 or block_y == rows:
            for i in range(line):
                kinds[slot + i] |= BEYOND
        else:
            kinds[slot] |= BEYOND
            kinds[slot + width + 1] |= BEYOND
            if listed > 0:
                show_centers(
                    wide_color, behind, slot + 1, block_y, out_color, out_disparity, out_coverage
                )
        if block_y < 0:
            continue
        lay_pixels(scale_b, slots[1], slot, pixel_at)
        above_at, below_at = np.uint64(slots[1]), np.uint64(slot)
        first_word = (block_y * scale_b + half) * columns + half
        left_total, left_weight, left_delta = zero16(), zero4(), zero4()
        left_low, left_high, left_hits = INFINITY, -ONE, np.uint64(0)
        done = True
        for block_x in range(width + 1):
            right = np.uint64(block_x + 1)
            kind_above, kind_below = kinds[above_at + right], kinds[below_at + right]
            left_done = done
            done = (kind_above & SETTLED != 0) & (kind_below & SETTLED != 0)
            total, weight, delta = zero16(), zero4(), zero4()
            low, high, hits = INFINITY, -ONE, np.uint64(0)
            if left_done and done:
                continue
            block = np.uint64(first_word + scale_b * block_x)
            for n in range(np.uint64(cells)):
                held, at = all_words[block + offset[n]], pixel_at[n] + np.uint64(block_x)
                own = disparity_in(held, layout) if held != EMPTY else -ONE
                if adaptive and lends(kinds[at], own, behind[at] * keep):
                    own = behind[at]
                    four, value = load4(middles, n), load4(wide_color, at)
                elif held == EMPTY:
                    continue
                else:
                    four = load4(weights, (n << places) + np.uint64(place_in(held, layout)))
                    v, u, step_v, step_u = cell_in(held, layout)
                    # one beyond the border has the number of another that is not smooth either
                    sample = v * stride + u
                    if flags[np.uint64(max(sample, 0))] & SMOOTH:
                        sample -= stride + 1
                        value = smooth_color(color, stride, spread, cubics, sample, step_v, step_u)
                    else:
                        value = edge_color(color, links, v, u, step_v, step_u)
                low, high = own if own < low else low, own if own > high else high
                hits += hit[n]
                total = add16(total, outer16(four, value))
                weight = add4(weight, four)
                delta = add4(delta, scale4(four, own))
            if block_x > 0:
                x = np.uint64(block_x - 1)
                pair_low, pair_high = min(left_low, low), max(left_high, high)
                if not kinds[above_at + np.uint64(block_x)] & SETTLED:
                    own_hits = out_coverage[y, x] + hits_at(left_hits, 1) + hits_at(hits, 0)
                    out_coverage[y, x] = own_hits * share
                    paint = add4(part16(left_total, 1), part16(total, 0))
                    weighed = above[x, 0] + (lane4(left_weight, 1) + lane4(weight, 0))
                    summed = above[x, 1] + (lane4(left_delta, 1) + lane4(delta, 0))
                    scale = ONE / weighed if own_hits > ZERO else ZERO
                    paint = scale4(add4(load4(above_color, x), paint), scale)
                    store4(out_color, y * width + x, max4(paint, zero4()))
                    seen = -ONE
                    if own_hits > ZERO:
                        seen = summed * scale
                        if not min(above[x, 2], pair_low) >= max(above[x, 3], pair_high) * keep:
                            seen = front_disparity(
                                all_words, (block_y * scale_b - half) * columns
                                + scale_b * (block_x - 1) + half,
                                columns, kinds, behind, slots, block_x - 1, weights, middles,
                                layout, scale_b, keep,
                            )  # fmt: skip
                    out_disparity[y, x] = seen
                if not kinds[below_at + np.uint64(block_x)] & SETTLED:
                    store4(above_color, x, add4(part16(left_total, 3), part16(total, 2)))
                    above[x, 0] = lane4(left_weight, 3) + lane4(weight, 2)
                    above[x, 1] = lane4(left_delta, 3) + lane4(delta, 2)
                    above[x, 2], above[x, 3] = pair_low, pair_high
                    out_coverage[block_y, x] = hits_at(left_hits, 3) + hits_at(hits, 2)
            left_total, left_weight, left_delta = total, weight, delta
            left_low, left_high, left_hits = low, high, hits
