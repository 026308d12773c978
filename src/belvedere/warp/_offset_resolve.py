"""The kernel that filters the offset buffer's visible sub-samples into a picture."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import add4, float_of, load4, scale4, store4, zero4

F4 = npt.NDArray[np.float32]
U8 = npt.NDArray[np.uint64]

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
PLACE = np.uint64(14)
HIGH = np.uint64(32)


@inner
def disparity_of(word: int) -> Real:
    """The disparity that a cell holds."""
    return float_of(np.uint32(word >> HIGH))


@kernel
def resolve_offset_buffer(
    cell_color: F4, cell_word: U8, weights: F4, scale_b: int, bits: int,
    tolerance: Real, out_color: F4, out_disparity: F4, out_coverage: F4,
) -> None:  # fmt: skip
    """Filter the visible sub-samples into output pixels.

    Args:
        cell_color: (rows * b + b, width * b + b, 4), half a pixel of margin on every side.
        cell_word: same grid; see `_offset.land_run`.
        weights: (2 b 2^bits, 2 b 2^bits) filter at the resolution of the offsets, by v then u.
        scale_b: cells per pixel and axis.
        bits: of a place within a cell, per axis.
        tolerance: relative difference in disparity up to which cells are one surface.
        out_color: (rows, width, 4).
        out_disparity: (rows, width), the surface with more weight; -1 = uncovered.
        out_coverage: (rows, width), share of the pixel's own cells that were hit.
    """
    rows, width = out_disparity.shape
    columns, half = cell_word.shape[1], scale_b // 2
    shift, mask = np.uint32(bits), np.uint32((1 << bits) - 1)
    places = np.uint32((1 << (2 * bits)) - 1)
    share = ONE / np.float32(scale_b * scale_b)
    keep = np.float32(1.0 - tolerance)
    for y in range(rows):
        for x in range(width):
            front, hit = np.float32(-1.0), 0
            for j in range(half, half + scale_b):
                for i in range(half, half + scale_b):
                    delta = disparity_of(cell_word[y * scale_b + j, x * scale_b + i])
                    hit += 1 if delta >= ZERO else 0
                    front = max(front, delta)
            out_coverage[y, x] = np.float32(hit) * share
            out_disparity[y, x] = np.float32(-1.0)
            if hit == 0:
                out_color[y, x, :] = ZERO
                continue
            limit = front * keep
            color = zero4()
            near, far, near_delta, far_delta = ZERO, ZERO, ZERO, ZERO
            for j in range(2 * scale_b):
                row = y * scale_b + j
                for i in range(2 * scale_b):
                    column = x * scale_b + i
                    held = cell_word[row, column]
                    delta = disparity_of(held)
                    if delta < ZERO:
                        continue
                    place = np.uint32(held >> PLACE) & places
                    qv, qu = place >> shift, place & mask
                    weight = weights[(np.uint32(j) << shift) + qv, (np.uint32(i) << shift) + qu]
                    in_front = delta >= limit
                    share_near = weight if in_front else ZERO
                    share_far = ZERO if in_front else weight
                    near += share_near
                    near_delta += share_near * delta
                    far += share_far
                    far_delta += share_far * delta
                    color = add4(color, scale4(load4(cell_color, row * columns + column), weight))
            store4(out_color, y * width + x, scale4(color, ONE / (near + far)))
            out_disparity[y, x] = near_delta / near if near >= far else far_delta / far
