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
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import (
    Four,
    add4,
    add16,
    fold16,
    lane4,
    load4,
    load16,
    max4,
    mul16,
    outer16,
    part16,
    scale4,
    scale16,
    store4,
    zero4,
    zero16,
)
from belvedere.warp._edges import INTACT, SMOOTH, joined
from belvedere.warp._offset_word import EMPTY, STEPS, cell_in, disparity_in, place_in

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]
U8 = npt.NDArray[np.uint64]

ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
INFINITY = np.float32(np.inf)


@inner
def smooth_color(
    color: F4, stride: int, spread: F4, cubics: F4, sample: int, step_v: Real, step_u: Real
) -> Four:
    """Bicubic colour between sixteen samples; ``sample`` is the flat index of the first."""
    first, second = load16(color, sample), load16(color, sample + stride)
    third, last = load16(color, sample + 2 * stride), load16(color, sample + 3 * stride)
    at = step_v << np.uint64(2)
    upper = add16(scale16(first, cubics[at]), scale16(second, cubics[at + np.uint64(1)]))
    lower = add16(
        scale16(third, cubics[at + np.uint64(2)]), scale16(last, cubics[at + np.uint64(3)])
    )
    return fold16(mul16(add16(upper, lower), load16(spread, step_u << np.uint64(2))))


@inner
def edge_color(color: F4, links: U1, v: int, u: int, step_v: int, step_u: int) -> Four:
    """Colour in a cell beside an edge or the border: bilinear, with what is of one surface."""
    stride = color.shape[1]
    fu, fv = np.float32(step_u) / STEPS, np.float32(step_v) / STEPS
    whole = v >= 0 and u >= 0 and (links[v, u] & INTACT) != 0
    dv, du = 1, 1
    if not whole and fu >= HALF:  # a broken cell: from the sample whose quarter it is
        u, fu, du = u + 1, ONE - fu, -1
    if not whole and fv >= HALF:
        v, fv, dv = v + 1, ONE - fv, -1
    across = whole or joined(links, v, u, 0, du)
    along = whole or joined(links, v, u, dv, 0)
    sample, product = v * stride + u, fu * fv if whole else ZERO
    share_u, share_v = fu - product if across else ZERO, fv - product if along else ZERO
    value = scale4(load4(color, sample), ONE - product - share_u - share_v)
    # what has no share may lie outside the picture, or be no number: the sample itself instead
    beside = sample + du if across else sample
    below = sample + dv * stride if along else sample
    value = add4(value, scale4(load4(color, beside), share_u))
    value = add4(value, scale4(load4(color, below), share_v))
    return add4(value, scale4(load4(color, sample + stride + 1 if whole else sample), product))


@inner
def front_disparity(
    words: U8, weights: F4, layout: Any, scale_b: int, keep: Real, y: int, x: Real
) -> Real:
    """Disparity of the surface with more weight in a pixel that may see two; -1 without one.

    The surface in front is what the pixel's own cells see nearest.
    """
    half = scale_b >> 1
    front, near, far, near_delta, far_delta = -ONE, ZERO, ZERO, ZERO, ZERO
    for j in range(half, half + scale_b):
        for i in range(half, half + scale_b):
            held = words[y * scale_b + j, x * scale_b + i]
            if held != EMPTY:
                front = max(front, disparity_in(held, layout))
    if front < ZERO:
        return front
    for j in range(2 * scale_b):
        for i in range(2 * scale_b):
            held = words[y * scale_b + j, x * scale_b + i]
            if held == EMPTY:
                continue
            # the pixel lies right of and below blocks that begin before its own
            lane = 2 * (1 if j < scale_b else 0) + (1 if i < scale_b else 0)
            cell = (j % scale_b) * scale_b + i % scale_b
            weight = weights[(cell << (2 * layout.bits)) + int(place_in(held, layout)), lane]
            delta = disparity_in(held, layout)
            if delta >= front * keep:
                near += weight
                near_delta += weight * delta
            else:
                far += weight
                far_delta += weight * delta
    return near_delta / near if near >= far else far_delta / far


@inner
def lay_block(scale_b: int, columns: int, bits: int, out_offset: U8, out_hit: U8) -> None:
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
def hits_at(hits: Real, corner: int) -> Real:
    """Cells hit in one corner of a block."""
    return np.float32(np.uint32(np.uint32(hits >> np.uint64(8 * corner)) & np.uint32(255)))


@kernel
def resolve_offset_buffer(
    words: U8, color: F4, links: U1, weights: F4, spread: F4, cubic: F4, layout: Any, scale_b: int,
    tolerance: Real, above_color: F4, above: F4, out_color: F4, out_disparity: F4,
    out_coverage: F4,
) -> None:  # fmt: skip
    """Filter the visible sub-samples into output pixels.

    Args:
        words: (rows * b + b, width * b + b), half a pixel of margin on every side.
        color: (H, W, 4) of the reference, linear.
        links: (H, W) bits of `_edges`.
        weights: (b b 2^2o, 4) weight of each place of each cell of a block in the pixels above
            left, above right, below left and below right.
        spread: (2^IN_CELL, 16) weights of four samples in a row, each four times.
        cubic: (2^IN_CELL, 4) the same, each once.
        layout: of words.
        scale_b: cells per pixel and axis.
        tolerance: relative difference in disparity up to which cells are one surface.
        above_color: (width, 4) to work in: what the blocks above gave to a row of pixels.
        above: (width, 4) likewise: weight, weighted disparity, least and greatest disparity.
        out_color: (rows, width, 4), not below 0.
        out_disparity: (rows, width), the surface with more weight; -1 = uncovered.
        out_coverage: (rows, width), share of the pixel's own cells that were hit.
    """
    rows, width = out_disparity.shape
    stride, columns, cells = color.shape[1], words.shape[1], scale_b * scale_b
    places = np.uint64(2 * layout.bits)
    share, keep = ONE / np.float32(cells), np.float32(1.0 - tolerance)
    offset, hit = np.empty(cells, np.uint64), np.empty(cells, np.uint64)
    lay_block(scale_b, columns, layout.bits, offset, hit)
    all_words, flags = words.reshape(-1), links.reshape(-1)
    cubics = cubic.reshape(-1)
    for block_y in range(rows + 1):
        y = block_y - 1
        left_total, left_weight, left_delta = zero16(), zero4(), zero4()
        left_low, left_high, left_hits = INFINITY, -ONE, np.uint64(0)
        for block_x in range(width + 1):
            total, weight, delta = zero16(), zero4(), zero4()
            low, high, hits = INFINITY, -ONE, np.uint64(0)
            block = np.uint64(scale_b * (block_y * columns + block_x))
            for n in range(np.uint64(cells)):
                held = all_words[block + offset[n]]
                if held == EMPTY:
                    continue
                own = disparity_in(held, layout)
                low, high = own if own < low else low, own if own > high else high
                hits += hit[n]
                four = load4(weights, (n << places) + np.uint64(place_in(held, layout)))
                v, u, step_v, step_u = cell_in(held, layout)
                # one beyond the border has the number of another that is not smooth either
                sample = v * stride + u
                if flags[np.uint64(max(sample, 0))] & SMOOTH:
                    sample -= stride + 1
                    value = smooth_color(color, stride, spread, cubics, sample, step_v, step_u)
                else:
                    value = edge_color(color, links, v, u, step_v, step_u)
                total = add16(total, outer16(four, value))
                weight = add4(weight, four)
                delta = add4(delta, scale4(four, own))
            if block_x > 0:
                x = np.uint64(block_x - 1)
                pair_low, pair_high = min(left_low, low), max(left_high, high)
                if block_y > 0:
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
                            seen = front_disparity(words, weights, layout, scale_b, keep, y, x)
                    out_disparity[y, x] = seen
                if block_y < rows:
                    store4(above_color, x, add4(part16(left_total, 3), part16(total, 2)))
                    above[x, 0] = lane4(left_weight, 3) + lane4(weight, 2)
                    above[x, 1] = lane4(left_delta, 3) + lane4(delta, 2)
                    above[x, 2], above[x, 3] = pair_low, pair_high
                    out_coverage[block_y, x] = hits_at(left_hits, 3) + hits_at(hits, 2)
            left_total, left_weight, left_delta = total, weight, delta
            left_low, left_high, left_hits = low, high, hits
