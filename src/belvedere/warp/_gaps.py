"""Kernels that tell cracks from exposures: what could stand in a hole, and did anybody see it?

What a hole hides continues what is beside it. Each pixel of a hole looks left and right, up and
down to the nearest covered pixels and gets up to four guesses of its disparity::

    covered ...|  hole  |... covered      the farthest of the four sides goes on, or the nearest;
         a   a ->      <- b   b           or, where two opposite ones agree, it runs through

Every reference is asked whether it holds an unbroken surface of that disparity at the place where
it would show. If one does, the surface was seen and samples are missing: a crack. Beside its edges
a reference's word proves nothing, since the edge runs somewhere between two samples.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.scene.explanation import Hole
from belvedere.warp._backward import BESIDE, FAINT, ZERO, agreement, inside, land

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]

FAR, NEAR, ACROSS, DOWN = 0, 1, 2, 3
"""Guesses: the farthest and the nearest of the four sides, what runs through along each axis."""
GUESSES = 4
UNDERSAMPLED, UNSEEN, OUTSIDE = int(Hole.UNDERSAMPLED), int(Hole.UNSEEN), int(Hole.OUTSIDE)
FARTHEST = 8
"""Pixels over which a surface is continued with its slope, and beyond which as it is there: what
one step between two pixels says of the slope is too coarse for more."""
WIDE = np.float32(4.0)
"""Pixels whose changes of disparity may add up between two sides that agree."""
NONE = np.float32(-1.0)
REACHED, SEEN = 1, 2
"""Bits: a reference's picture reaches the guess; the reference sees it."""


@kernel
def covered_rows(coverage: F4, out_above: I4, out_below: I4) -> None:
    """(H, W) row of the nearest covered pixel above and below each one; -1 and H for none."""
    height, width = coverage.shape
    for y in range(height):
        for x in range(width):
            before = out_above[y - 1, x] if y > 0 else np.int32(-1)
            out_above[y, x] = np.int32(y) if coverage[y, x] > ZERO else before
    for y in range(height - 1, -1, -1):
        for x in range(width):
            after = out_below[y + 1, x] if y + 1 < height else np.int32(height)
            out_below[y, x] = np.int32(y) if coverage[y, x] > ZERO else after


@inner
def continued(
    disparity: F4, coverage: F4, j: int, i: int, dj: int, di: int, steps: int, tolerance: Real
) -> Real:
    """Disparity of the surface at (j, i), ``steps`` pixels on in the direction (dj, di).

    With the slope it has on the last pixel before, if that belongs to it.
    """
    own = disparity[j, i]
    j2, i2 = j - dj, i - di
    if j2 < 0 or i2 < 0 or j2 >= disparity.shape[0] or i2 >= disparity.shape[1]:
        return own
    other = disparity[j2, i2]
    if not coverage[j2, i2] > ZERO or not abs(other - own) <= tolerance * max(own, other):
        return own
    return max(own + (own - other) * np.float32(min(steps, FARTHEST)), ZERO)


@inner
def look_askew(disparity: F4, coverage: F4, y: int, x: int, out_sides: F4) -> None:
    """Disparities along the diagonals, nearby: up left, up right, down left, down right.

    Samples far apart leave pixels whose rows and columns hold none close by.
    """
    height, width = disparity.shape
    out_sides[:] = NONE
    for n in range(4):
        dj, di = (n >> 1) * 2 - 1, (n & 1) * 2 - 1
        j, i, steps = y + dj, x + di, 1
        while 0 <= j < height and 0 <= i < width and steps <= FARTHEST:
            if coverage[j, i] > ZERO:
                out_sides[n] = disparity[j, i]
                break
            j, i, steps = j + dj, i + di, steps + 1


@kernel
def guess(
    disparity: F4, coverage: F4, above: I4, below: I4, tolerance: Real, row_low: int,
    row_high: int, out_index: I4, out_guess: F4,
) -> None:  # fmt: skip
    """Find the holes of rows [row_low, row_high) and what could be in them.

    Args:
        disparity: (H, W) of the frame.
        coverage: (H, W) of the frame.
        above: (H, W) from `covered_rows`.
        below: (H, W) from `covered_rows`.
        tolerance: relative difference of disparities of one surface.
        row_low: first row.
        row_high: row after the last.
        out_index: (n,) flat index of each hole.
        out_guess: (n, GUESSES) disparities, NONE where there is no such guess.
    """
    height, width = disparity.shape
    share = np.float32(tolerance)
    sides = np.empty(4, np.float32)
    count = 0
    for y in range(row_low, row_high):
        left, right = -1, -1
        for x in range(width):
            if coverage[y, x] > ZERO:
                left = x
                continue
            if right < x:
                right = x
                while right < width and not coverage[y, right] > ZERO:
                    right += 1
            top, bottom = above[y, x], below[y, x]
            sides[:] = NONE
            out_guess[count, :] = NONE
            if left >= 0:
                sides[0] = continued(disparity, coverage, y, left, 0, 1, x - left, share)
            if right < width:
                sides[1] = continued(disparity, coverage, y, right, 0, -1, right - x, share)
            if top >= 0:
                sides[2] = continued(disparity, coverage, top, x, 1, 0, y - top, share)
            if bottom < height:
                sides[3] = continued(disparity, coverage, bottom, x, -1, 0, bottom - y, share)
            for n in range(4):
                if sides[n] >= ZERO:
                    out_guess[count, NEAR] = max(out_guess[count, NEAR], sides[n])
                    if out_guess[count, FAR] < ZERO or sides[n] < out_guess[count, FAR]:
                        out_guess[count, FAR] = sides[n]
            if left >= 0 and right < width:
                out_guess[count, ACROSS] = between(
                    disparity[y, left], disparity[y, right], x - left, right - x, share
                )
            if top >= 0 and bottom < height:
                out_guess[count, DOWN] = between(
                    disparity[top, x], disparity[bottom, x], y - top, bottom - y, share
                )
            if out_guess[count, ACROSS] < ZERO and out_guess[count, DOWN] < ZERO:
                look_askew(disparity, coverage, y, x, sides)
                out_guess[count, ACROSS] = between(sides[0], sides[3], 1, 1, share)
                out_guess[count, DOWN] = between(sides[1], sides[2], 1, 1, share)
            out_index[count] = y * width + x
            count += 1


@inner
def between(first: Real, second: Real, before: int, after: int, tolerance: Real) -> Real:
    """Disparity of a surface that runs through a hole, or NONE if the sides do not agree.

    Affine along the image line, as that of every plane; sides agree if the step a pixel is small.
    """
    span = np.float32(before + after)
    if first < ZERO or second < ZERO:
        return NONE
    if abs(first - second) > tolerance * max(first, second) * min(span, WIDE) + FAINT:
        return NONE
    return (first * np.float32(after) + second * np.float32(before)) / span


@kernel
def ask_guesses(
    back: F4, disparity: F4, links: U1, index: I4, guesses: F4, width: int, tolerance: Real,
    out_answer: U1,
) -> None:  # fmt: skip
    """What one reference says to each guess.

    Args:
        back: (12,) matrix from the desired view to the reference.
        disparity: (H, W) of the reference.
        links: (H, W) its bits.
        index: (n,) from `guess`.
        guesses: (n, GUESSES) from `guess`.
        width: of the desired view.
        tolerance: as for `_backward.agreement`.
        out_answer: (n, GUESSES) bits, added.
    """
    height, stride = disparity.shape
    share, deltas, bits = np.float32(tolerance), disparity.reshape(-1), links.reshape(-1)
    for k in range(index.size):
        x4, y4 = np.float32(index[k] % width), np.float32(index[k] // width)
        for g in range(GUESSES):
            delta = guesses[k, g]
            if delta < ZERO:
                continue
            u, v, wanted = land(back, x4, y4, delta)
            if wanted < ZERO or not inside(u, v, stride, height):
                continue
            out_answer[k, g] |= np.uint8(REACHED)
            if agreement(deltas, bits, stride, height, u, v, wanted, share, ZERO) >= BESIDE:
                out_answer[k, g] |= np.uint8(SEEN)


@kernel
def tell_apart(answer: U1, index: I4, out_hole: U1) -> None:
    """Write the kind of each hole, numbers of `belvedere.scene.Hole`.

    Outside is what the picture shows farthest back, since that is what holes are made of.

    Args:
        answer: (n, GUESSES) what all references said.
        index: (n,) from `guess`.
        out_hole: (H * W,) written in the holes.
    """
    for k in range(index.size):
        if (answer[k, FAR] | answer[k, NEAR] | answer[k, ACROSS] | answer[k, DOWN]) & SEEN:
            out_hole[index[k]] = UNDERSAMPLED
        elif answer[k, FAR] & REACHED:
            out_hole[index[k]] = UNSEEN
        else:
            out_hole[index[k]] = OUTSIDE
