"""Kernels that look features up backwards, any number of channels at once."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._backward import (
    CHOSEN,
    FAINT,
    HALF,
    NOTHING,
    ONE,
    ZERO,
    closest_sample,
    land,
)
from belvedere.warp._edges import SMOOTH

F4 = npt.NDArray[np.float32]
I8 = npt.NDArray[np.int64]
U1 = npt.NDArray[np.uint8]

TWO, THREE = np.float32(2.0), np.float32(3.0)
FOUR, FIVE = np.float32(4.0), np.float32(5.0)
FEW = HALF
"""Sum of the weights on the surface below which the nearest sample on it is taken."""
NEAREST, LINEAR, CUBIC = 0, 1, 2
"""Filters: one sample, four, sixteen."""
MOST_TAPS = 16


@inner
def along(kind: int, f: Real, weights: F4, row: int) -> None:
    """Weights of the samples at -1, 0, 1, 2 for the place f: Catmull and Rom's, or linear."""
    if kind == CUBIC:
        weights[row, 0] = HALF * f * (f * (TWO - f) - ONE)
        weights[row, 1] = HALF * (f * f * (THREE * f - FIVE) + TWO)
        weights[row, 2] = HALF * f * (f * (FOUR - THREE * f) + ONE)
        weights[row, 3] = HALF * f * f * (f - ONE)
    else:
        weights[row, 0], weights[row, 3] = ZERO, ZERO
        weights[row, 1], weights[row, 2] = ONE - f, f


@inner
def choose_taps(
    kind: int, disparity: F4, links: U1, features: F4, u: Real, v: Real, delta: Real,
    tolerance: Real, weights: F4, out_index: I8, out_share: F4,
) -> int:  # fmt: skip
    """Which samples round (u, v) are mixed and in what shares, which sum to 1.

    Samples without features are left out, and beside edges those of other surfaces.

    Args:
        kind: CUBIC, LINEAR or NEAREST.
        disparity: (H, W).
        links: (H, W) bits of `_edges`.
        features: (H * W, C), NaN where a sample has none.
        u: column.
        v: row.
        delta: disparity of the surface there.
        tolerance: relative difference of samples that lie on it.
        weights: (2, 4) to work in.
        out_index: (MOST_TAPS,) numbers of the samples.
        out_share: (MOST_TAPS,) their shares.

    Returns:
        How many; 0 where no sample on the surface has features.
    """
    height, stride = disparity.shape
    i, j = int(np.floor(u)), int(np.floor(v))
    trusted = i >= 0 and j >= 0 and i < stride and j < height and bool(links[j, i] & SMOOTH)
    along(kind, u - np.float32(i), weights, 0)
    along(kind, v - np.float32(j), weights, 1)
    near = tolerance * delta + FAINT
    count, total, skipped = 0, ZERO, False
    nearest, distance = -1, np.float32(np.inf)
    for row in range(max(j - 1, 0), min(j + 3, height)):
        for column in range(max(i - 1, 0), min(i + 3, stride)):
            index = row * stride + column
            weight = weights[1, row - j + 1] * weights[0, column - i + 1]
            if weight == ZERO and kind != NEAREST:
                continue
            if np.isnan(features[index, 0]) or (
                not trusted and not abs(disparity[row, column] - delta) <= near
            ):
                skipped = True
                continue
            du, dv = u - np.float32(column), v - np.float32(row)
            apart = du * du + dv * dv
            if apart < distance:
                nearest, distance = index, apart
            out_index[count], out_share[count] = index, weight
            total += weight
            count += 1
    if nearest < 0:
        return 0
    cut = skipped or count < (MOST_TAPS if kind == CUBIC else 4)  # by edges, or by the border
    if kind == NEAREST or total < FEW:
        out_index[0], out_share[0] = nearest, ONE
        return 1
    if cut:
        for k in range(count):
            out_share[k] = out_share[k] / total
    return count


@kernel
def drop_unknown(
    kind: int, back: F4, disparity: F4, links: U1, features: F4, front: F4, row_low: int,
    tolerance: Real, out_weight: F4,
) -> None:  # fmt: skip
    """Weights below 0 where a reference sees the surface but has no features on it.

    Arguments as of `gather`; out_weight as from `_backward.weigh`.
    """
    rows, width = front.shape
    near = np.float32(tolerance)
    weights = np.empty((2, 4), np.float32)
    index, share = np.empty(MOST_TAPS, np.int64), np.empty(MOST_TAPS, np.float32)
    for y in range(rows):
        for x in range(width):
            weight = out_weight[y, x]
            if weight in (ZERO, NOTHING):
                continue
            u, v, delta = land(back, np.float32(x), np.float32(y + row_low), front[y, x])
            if weight > ZERO:
                found = choose_taps(
                    kind, disparity, links, features, u, v, delta, near, weights, index, share
                )
                if found > 0:
                    continue
                out_weight[y, x] = -ONE
            sample, _ = closest_sample(disparity, u, v, delta)
            if sample < 0 or np.isnan(features[sample, 0]):
                out_weight[y, x] = NOTHING


@inner
def every_tap(
    kind: int, stride: int, u: Real, v: Real, weights: F4, out_index: I8, out_share: F4
) -> int:
    """As `choose_taps` inside a surface all of whose samples have features."""
    i, j = int(u), int(v)
    if kind == NEAREST or (u == np.float32(i) and v == np.float32(j)):
        out_index[0], out_share[0] = int(v + HALF) * stride + int(u + HALF), ONE
        return 1
    along(kind, u - np.float32(i), weights, 0)
    along(kind, v - np.float32(j), weights, 1)
    low, high = (0, 4) if kind == CUBIC else (1, 3)
    count = 0
    for m in range(low, high):
        for k in range(low, high):
            out_index[count] = (j + m - 1) * stride + i + k - 1
            out_share[count] = weights[1, m] * weights[0, k]
            count += 1
    return count


@inner
def mix(features: F4, index: I8, taps: F4, count: int, share: Real, pixel: F4) -> None:
    """Add the weighted sum of some samples to a pixel, four samples at a time."""
    channels = features.shape[1]
    if count == 1:
        factor, sample = share * taps[0], features[index[0]]
        if factor == ONE:  # alone: to the last bit, the sign of a zero too
            for c in range(channels):
                pixel[c] = sample[c]
        else:
            for c in range(channels):
                pixel[c] += factor * sample[c]
        return
    for k in range(count, (count + 3) // 4 * 4):
        index[k], taps[k] = index[0], ZERO
    for k in range(0, count, 4):
        a, b, d, e = share * taps[k], share * taps[k + 1], share * taps[k + 2], share * taps[k + 3]
        first, second = features[index[k]], features[index[k + 1]]
        third, fourth = features[index[k + 2]], features[index[k + 3]]
        for c in range(channels):
            pixel[c] += a * first[c] + b * second[c] + d * third[c] + e * fourth[c]


@kernel
def gather(
    kind: int, whole: bool, back: F4, disparity: F4, links: U1, features: F4, front: F4,
    row_low: int, shares: F4, tolerance: Real, out: F4,
) -> None:  # fmt: skip
    """Add one reference's features, times its share, in the pixels where it counts.

    Args:
        kind: CUBIC, LINEAR or NEAREST.
        whole: whether every sample has features.
        back: (12,) matrix from the desired view to the reference.
        disparity: (H, W) of the reference.
        links: (H, W) its bits.
        features: (H * W, C).
        front: (rows, width) disparity that the frame shows.
        row_low: desired row of the first.
        shares: (rows, width) of the reference, from `_backward.settle`.
        tolerance: relative difference of samples that may be mixed.
        out: (rows, width, C), added to.
    """
    rows, width = front.shape
    height, stride = disparity.shape
    near = np.float32(tolerance)
    weights = np.empty((2, 4), np.float32)
    index, taps = np.empty(MOST_TAPS, np.int64), np.empty(MOST_TAPS, np.float32)
    for y in range(rows):
        for x in range(width):
            share = shares[y, x]
            if share == ZERO:
                continue
            u, v, delta = land(back, np.float32(x), np.float32(y + row_low), front[y, x])
            count = 0
            if share == CHOSEN:
                share = ONE
            elif (
                whole and u >= ZERO and v >= ZERO and u < np.float32(stride)
                and v < np.float32(height) and links[int(v), int(u)] & SMOOTH
            ):  # fmt: skip
                count = every_tap(kind, stride, u, v, weights, index, taps)
            else:
                count = choose_taps(
                    kind, disparity, links, features, u, v, delta, near, weights, index, taps
                )
            if count == 0:
                index[0], _ = closest_sample(disparity, u, v, delta)
                taps[0], count = ONE, 1
            mix(features, index, taps, count, share, out[y, x])
