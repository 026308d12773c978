"""Kernels of the inverse pass that merge what references see at each desired pixel.

At silhouettes each pixel learns how much of it the nearest surface covers and what is behind.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import EIGHT, list_set
from belvedere.warp._quads import UNSURE, is_unsure, marked

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]
U2 = npt.NDArray[np.uint16]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
HOLE = np.float32(-1.0)


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
