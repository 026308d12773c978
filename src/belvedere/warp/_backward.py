"""Kernels that ask references backwards: does this one see the surface that a pixel shows?

A frame knows the disparity of each of its pixels, however it was made. That says where the pixel's
surface lies in every reference, and the reference's own disparity there says whether it sees it::

    desired pixel, disparity  ->  place in the reference, disparity it must have there
                                  the same as the reference holds: it sees the surface
                                  less than it holds: something nearer stands before it
                                  more than it holds: it looks through the place
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import INTACT, MIXED, SMOOTH

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]

ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
FAINT = np.float32(1e-12)
"""A disparity as good as 0, so that infinitely far surfaces agree with one another."""
EDGE_WEIGHT = np.float32(0.05)
"""What a reference's word counts beside an edge, as in the inverse pass."""
NOTHING = np.float32(-1e30)
"""Weight of a reference that has nothing to say."""
CHOSEN = np.float32(2.0)
"""Weight that marks the reference to take a sample from where none sees the surface."""
ALL, FIRST, LARGEST = 0, 1, 2
"""Which of the references that see a pixel are kept: see `settle`."""
NOT_SEEN, BROKEN, BESIDE, WHOLE = 0, 1, 2, 3
"""What `agreement` says."""
WINDOW = 2
"""Samples to each side that are asked where no reference sees the surface."""


@inner
def land(back: F4, x: Real, y: Real, delta: Real) -> tuple[Real, Real, Real]:
    """Column, row and disparity of a desired pixel in a reference; disparity -1 behind it."""
    t = back[8] * x + back[9] * y + back[10] + back[11] * delta
    if not t > ZERO:
        return ZERO, ZERO, -ONE
    scale = ONE / t
    return (
        (back[0] * x + back[1] * y + back[2] + back[3] * delta) * scale,
        (back[4] * x + back[5] * y + back[6] + back[7] * delta) * scale,
        delta * scale,
    )


@inner
def inside(u: Real, v: Real, stride: int, height: int) -> bool:
    """Whether a place lies in a picture, the half pixels of its border included."""
    return (
        u >= -HALF
        and v >= -HALF
        and u <= np.float32(stride) - HALF
        and v <= np.float32(height) - HALF
    )


@inner
def outside_by(u: Real, v: Real, stride: int, height: int) -> Real:
    """Pixels by which a place lies outside a picture, 0 inside it; many for no number."""
    if inside(u, v, stride, height):
        return ZERO
    across = max(-HALF - u, u - np.float32(stride) + HALF)
    down = max(-HALF - v, v - np.float32(height) + HALF)
    return max(across, down) if np.isfinite(across + down) else np.float32(1e9)


@inner
def held(u: Real, last: Real) -> Real:
    """A coordinate moved to the nearest sample's range, 0 to last; 0 for no number."""
    return (u if u < last else last) if u > ZERO else ZERO


@inner
def agreement(
    disparity: F4, links: U1, stride: int, height: int, u: Real, v: Real, delta: Real,
    tolerance: Real, edge_tolerance: Real,
) -> int:  # fmt: skip
    """Whether the surface that a reference holds at (u, v), a place inside, has disparity delta.

    Args:
        disparity: (H * W,), small gaps bridged.
        links: (H * W,) bits of `_edges`.
        stride: width of the reference.
        height: of the reference.
        u: column.
        v: row.
        delta: disparity the surface must have there.
        tolerance: relative difference that is the same surface; half of the change across the cell
            comes on top, since a pixel's disparity may be that of a sample beside it.
        edge_tolerance: the same for single samples, in cells that are no piece of surface.

    Returns:
        NOT_SEEN; BROKEN where a sample agrees but the cell is cut by an edge; BESIDE in a cell
        beside one; WHOLE where sixteen samples may be mixed.
    """
    i = min(int(max(u, ZERO)), max(stride - 2, 0))
    j = min(int(max(v, ZERO)), max(height - 2, 0))
    p = np.uint64(j * stride + i)
    q = p + np.uint64(1 if stride > 1 else 0)
    r = p + np.uint64(stride if height > 1 else 0)
    s = q + (r - p)
    a, b, c, d = disparity[p], disparity[q], disparity[r], disparity[s]
    bits = links[p]
    if bits & INTACT:
        fu, fv = u - np.float32(i), v - np.float32(j)
        upper, lower = a + (b - a) * fu, c + (d - c) * fu
        found = upper + (lower - upper) * fv
        spread = max(a, b, c, d) - min(a, b, c, d)
        if abs(found - delta) <= tolerance * delta + HALF * spread + FAINT:
            return WHOLE if bits & SMOOTH else BESIDE
        return NOT_SEEN
    near = edge_tolerance * delta + FAINT
    if (
        (abs(a - delta) <= near and not bits & MIXED)
        or (abs(b - delta) <= near and not links[q] & MIXED)
        or (abs(c - delta) <= near and not links[r] & MIXED)
        or (abs(d - delta) <= near and not links[s] & MIXED)
    ):
        return BROKEN
    return NOT_SEEN


@inner
def closest_sample(disparity: F4, u: Real, v: Real, delta: Real) -> tuple[int, Real]:
    """Number of the sample near (u, v) whose disparity is closest, and by what share it is off.

    -1 where no sample is near. Of samples equally close the first in rows counts. Places outside
    the picture are moved to its border.
    """
    height, stride = disparity.shape
    last_u, last_v = np.float32(stride - 1), np.float32(height - 1)
    i, j = int(held(u, last_u) + HALF), int(held(v, last_v) + HALF)
    best, least = -1, np.float32(np.inf)
    for row in range(max(j - WINDOW, 0), min(j + WINDOW + 1, height)):
        for column in range(max(i - WINDOW, 0), min(i + WINDOW + 1, stride)):
            found = disparity[row, column]
            off = abs(found - delta) / (max(found, delta) + FAINT)
            if off < least:  # refuses NaN too
                best, least = row * stride + column, off
    return best, least


@kernel
def weigh(
    back: F4, disparity: F4, links: U1, front: F4, coverage: F4, row_low: int, nearness: Real,
    tolerance: Real, edge_tolerance: Real, out_weight: F4,
) -> None:  # fmt: skip
    """What one reference's word counts in each pixel of a band.

    Args:
        back: (12,) matrix from the desired view to the reference.
        disparity: (H, W) of the reference, small gaps bridged.
        links: (H, W) its bits.
        front: (rows, width) disparity that the frame shows.
        coverage: (rows, width) of the frame.
        row_low: desired row of the first.
        nearness: weight of the reference, above 0.
        tolerance: as for `agreement`.
        edge_tolerance: as for `agreement`.
        out_weight: (rows, width): above 0 where the reference sees the surface; below where it
            does not, the closer to 0 the better its closest sample fits; 0 in holes.
    """
    rows, width = front.shape
    height, stride = disparity.shape
    own, share, edge = np.float32(nearness), np.float32(tolerance), np.float32(edge_tolerance)
    deltas, bits = disparity.reshape(-1), links.reshape(-1)
    for y in range(rows):
        y4 = np.float32(y + row_low)
        for x in range(width):
            delta = front[y, x]
            if not (coverage[y, x] > ZERO and delta >= ZERO):
                out_weight[y, x] = ZERO
                continue
            u, v, wanted = land(back, np.float32(x), y4, delta)
            if wanted < ZERO:
                out_weight[y, x] = NOTHING
                continue
            beyond = outside_by(u, v, stride, height)
            seen = NOT_SEEN
            if not beyond > ZERO:
                seen = agreement(deltas, bits, stride, height, u, v, wanted, share, edge)
            if seen == WHOLE:
                out_weight[y, x] = own
            elif seen != NOT_SEEN:
                out_weight[y, x] = own * EDGE_WEIGHT
            else:
                sample, off = closest_sample(disparity, u, v, wanted)
                out_weight[y, x] = -ONE - off - beyond if sample >= 0 else NOTHING


@kernel
def settle(rule: int, out_weights: F4) -> None:
    """Weights of `weigh` to shares that sum to 1.

    Where no reference sees what a covered pixel shows, the one whose sample fits best is marked
    CHOSEN. A reference alone has exactly 1, so that what it holds comes back to the last bit.

    Args:
        rule: ALL keeps every reference that sees a pixel, FIRST the first of them, LARGEST the one
            that counts most (the first of equal ones).
        out_weights: (n, rows, width), changed in place: 0 for references that do not count.
    """
    count, rows, width = out_weights.shape
    for y in range(rows):
        for x in range(width):
            total, best, best_weight = ZERO, -1, NOTHING
            for n in range(count):
                weight = out_weights[n, y, x]
                if weight > best_weight and not (rule == FIRST and best_weight > ZERO):
                    best, best_weight = n, weight
                total += max(weight, ZERO)
            for n in range(count):
                weight = out_weights[n, y, x]
                if total > ZERO and rule == ALL:
                    out_weights[n, y, x] = max(weight, ZERO) / total
                else:
                    out_weights[n, y, x] = ZERO
            if best >= 0 and best_weight > ZERO and rule != ALL:
                out_weights[best, y, x] = ONE
            elif best >= 0 and best_weight < ZERO:
                out_weights[best, y, x] = CHOSEN
