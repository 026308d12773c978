"""Kernels that measure how far a frame can be trusted: what its pixels' errors grow with."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._backward import FAINT, HALF, ONE, ZERO, held
from belvedere.warp._edges import INTACT, SMOOTH

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]
U4 = npt.NDArray[np.uint32]
I2 = npt.NDArray[np.int16]
I4 = npt.NDArray[np.int32]

THIRD = np.float32(1.0 / 3.0)
BYTE = np.float32(1.0 / 255.0)
SHIFT = np.float32(0.01)
"""Relative error of disparity whose shift is measured."""
MOST = np.float32(100.0)
"""Bound of a stretch or shift, squared: beyond ten pixels nothing gets worse."""
WEIGHTS, WHOLES, APART, SHIFTED, STRETCHED = 0, 1, 2, 3, 4
"""What `question` adds up."""
SUMS = 5
CHUNK = 64
"""Pixels of a row that are worked on together."""
FLOOR, DISAGREEMENT, CONTRAST, ACROSS, STRETCH, EDGE, EDGE_CONTRAST, UNSEEN, UNSEEN_CONTRAST = (
    range(9)
)
"""Factors of `add_up`."""


@kernel
def name_sources(weights: F4, order: I4, out_source: I2, out_seen: U4) -> None:
    """Which references see each pixel, and which of them counts most.

    Args:
        weights: (n, rows, width) of `_backward.weigh`.
        order: (n,) number of each reference as the caller gave them.
        out_source: (rows, width) number, -1 in holes.
        out_seen: (rows, width) a bit for each that sees it.
    """
    count, rows, width = weights.shape
    for y in range(rows):
        for x in range(width):
            best, most, seen = -1, np.float32(-np.inf), np.uint32(0)
            for n in range(count):
                weight = weights[n, y, x]
                if weight > ZERO:
                    seen |= np.uint32(1) << np.uint32(order[n])
                if weight > most and weight != ZERO:
                    best, most = order[n], weight
            out_source[y, x] = np.int16(best)
            out_seen[y, x] = seen


@inner
def compare(
    color: U1, disparity: F4, coverage: F4, share: Real, first: int, second: int, count: int,
    out: F4,
) -> None:  # fmt: skip
    """Compare runs of ``count`` pixels that begin at two places of the flat arrays.

    out is (4, count): 1 for pairs on one surface; their mean square difference in colour; their
    step in disparity; the difference in colour of pairs on two surfaces. 0 where not.
    """
    for i in range(count):
        a, b = np.uint64(first + i), np.uint64(second + i)
        total = ZERO
        for c in range(np.uint64(3)):
            step = np.float32(color[a, c]) - np.float32(color[b, c])
            total += step * step
        out[1, i] = total * (THIRD * BYTE * BYTE)
    for i in range(count):
        own, other = disparity[first + i], disparity[second + i]
        both = (coverage[first + i] > ZERO) & (coverage[second + i] > ZERO)
        larger = own if own > other else other
        same = both & (abs(other - own) <= share * larger + FAINT)
        step = out[1, i]
        out[0, i] = ONE if same else ZERO
        out[1, i] = step if same else ZERO
        out[2, i] = other - own if same else ZERO
        out[3, i] = step if both & (not same) else ZERO


@kernel
def survey(
    color: U1, disparity: F4, coverage: F4, tolerance: Real, row_low: int, out_slope: F4,
    out_contrast: F4,
) -> None:  # fmt: skip
    """What the frame itself tells about each pixel of a band.

    Args:
        color: (H, W, 3|4) encoded colours of the frame.
        disparity: (H, W) of the frame.
        coverage: (H, W) of the frame.
        tolerance: relative difference of disparities of one surface.
        row_low: first row of the band.
        out_slope: (2, rows, W) change of disparity per pixel along u and v, on the surface.
        out_contrast: (2, rows, W) mean square difference in colour to the neighbours on the same
            surface, and the largest to one on another.
    """
    height, width = disparity.shape
    rows, share = out_slope.shape[1], np.float32(tolerance)
    pixels, deltas = color.reshape(height * width, color.shape[2]), disparity.reshape(-1)
    known = coverage.reshape(-1)
    beside = np.zeros((4, width + 1), np.float32)  # pixel i stands between pairs i and i + 1
    above, below = np.zeros((4, width), np.float32), np.zeros((4, width), np.float32)
    if row_low > 0:
        start = (row_low - 1) * width
        compare(pixels, deltas, known, share, start, start + width, width, above)
    for y in range(rows):
        start = (y + row_low) * width
        compare(pixels, deltas, known, share, start, start + 1, width - 1, beside[:, 1:])
        if y + row_low + 1 < height:
            compare(pixels, deltas, known, share, start, start + width, width, below)
        else:
            below[:] = ZERO
        for i in range(width):
            along, down = beside[0, i] + beside[0, i + 1], above[0, i] + below[0, i]
            right, lower = beside[2, i] + beside[2, i + 1], above[2, i] + below[2, i]
            out_slope[0, y, i] = right / (along if along > ZERO else ONE)
            out_slope[1, y, i] = lower / (down if down > ZERO else ONE)
            total = beside[1, i] + beside[1, i + 1] + above[1, i] + below[1, i]
            out_contrast[0, y, i] = total / (along + down if along + down > ZERO else ONE)
            p, q, r, s = beside[3, i], beside[3, i + 1], above[3, i], below[3, i]
            p, r = p if p > q else q, r if r > s else s
            out_contrast[1, y, i] = p if p > r else r
        above, below = below, above


@inner
def corner_of(u: Real, v: Real, stride: int, height: int) -> tuple[int, int]:
    """Column and row of the upper left sample of the cell that holds a place in the picture."""
    return min(int(u), max(stride - 2, 0)), min(int(v), max(height - 2, 0))


@inner
def off_by(
    encoded: U1, disparity: F4, stride: int, height: int, trusted: bool, u: Real, v: Real,
    delta: Real, shown: U1, pixel: int,
) -> Real:  # fmt: skip
    """Mean square difference between a pixel and what a reference shows of its surface.

    Between four samples where ``trusted``, else the one of them that fits the surface best. Colours
    and disparities are flat.
    """
    i, j = corner_of(u, v, stride, height)
    fu, fv = u - np.float32(i), v - np.float32(j)
    a = np.uint64(j * stride + i)
    if trusted:
        b, c = a + np.uint64(1), a + np.uint64(stride)
        d = c + np.uint64(1)
    else:
        right, down = min(i + 1, stride - 1) - i, (min(j + 1, height - 1) - j) * stride
        best, least = a, abs(disparity[a] - delta)
        for step in (right, down, down + right):
            other = a + np.uint64(step)
            off = abs(disparity[other] - delta)
            if not off >= least:
                best, least = other, off
        a = b = c = d = best
    total, at = ZERO, np.uint64(pixel)
    for k in range(np.uint64(3)):
        left, right4 = np.float32(encoded[a, k]), np.float32(encoded[b, k])
        lower, corner = np.float32(encoded[c, k]), np.float32(encoded[d, k])
        upper = left + (right4 - left) * fu
        lower += (corner - lower) * fu
        step4 = upper + (lower - upper) * fv - np.float32(shown[at, k])
        total += step4 * step4
    return total * (THIRD * BYTE * BYTE)


@inner
def measure(
    back: F4, y4: Real, x_low: int, front: F4, slope_x: F4, slope_y: F4, count: int, out: F4
) -> None:
    """Where ``count`` pixels of a row lie in a reference, and how their samples are stretched.

    Straight-line arithmetic on purpose: it vectorises.

    Args:
        back: (12,) matrix from the desired view.
        y4: desired row.
        x_low: first column; front, slope_x and slope_y begin there.
        front: disparities.
        slope_x: change of disparity a pixel to the right.
        slope_y: and down.
        count: pixels.
        out: (5, CHUNK): u, v, disparity, stretch and shift, both squared.
    """
    r0, s0, t0 = back[1] * y4 + back[2], back[5] * y4 + back[6], back[9] * y4 + back[10]
    x0, four, tiny = np.float32(x_low), np.float32(4.0), np.float32(1e-6)
    for i in range(count):
        x4, delta, sx, sy = x0 + np.float32(i), front[i], slope_x[i], slope_y[i]
        scale = ONE / (back[8] * x4 + t0 + back[11] * delta)
        u = (back[0] * x4 + r0 + back[3] * delta) * scale
        v = (back[4] * x4 + s0 + back[7] * delta) * scale
        tx, ty = back[8] + back[11] * sx, back[9] + back[11] * sy
        ux, uy = back[0] + back[3] * sx - u * tx, back[1] + back[3] * sy - u * ty
        vx, vy = back[4] + back[7] * sx - v * tx, back[5] + back[7] * sy - v * ty
        size = (ux * ux + uy * uy + vx * vx + vy * vy) * scale * scale
        area = (ux * vy - uy * vx) * scale * scale
        under = size * size - four * area * area
        least = HALF * (size - np.sqrt(under if under > ZERO else ZERO))  # singular value, squared
        stretch = ONE / (least if least > tiny else tiny)
        stretch = stretch if stretch < MOST else MOST
        du, dv, far = back[3] - u * back[11], back[7] - v * back[11], SHIFT * delta * scale
        shift = far * far * (du * du + dv * dv) * stretch
        out[0, i], out[1, i], out[2, i], out[3, i] = u, v, delta * scale, stretch
        out[4, i] = shift if shift < MOST else MOST


@kernel
def question(
    back: F4, disparity: F4, links: U1, encoded: U1, front: F4, shown: U1, slope: F4, row_low: int,
    weight: F4, out_sums: F4,
) -> None:  # fmt: skip
    """Add what one reference tells about the pixels it sees, times its weight.

    Args:
        back: (12,) matrix from the desired view to the reference.
        disparity: (H, W) of the reference.
        links: (H, W) its bits.
        encoded: (H, W, 3|4) its colours, sRGB.
        front: (rows, width) disparity that the frame shows.
        shown: (rows, width, 3|4) the frame's colours, sRGB.
        slope: (2, rows, width) from `survey`.
        row_low: desired row of the first.
        weight: (rows, width) of `_backward.weigh`.
        out_sums: (SUMS, rows, width), added to: weights; weights of those away from edges; mean
            square differences in colour; squared shifts, desired pixels, that an error of disparity
            by `SHIFT` makes; squared stretches of a sample, in the direction it grows most.
    """
    rows, width = front.shape
    height, stride = disparity.shape
    colors, deltas = encoded.reshape(height * stride, encoded.shape[2]), disparity.reshape(-1)
    bits, pixels = links.reshape(-1), shown.reshape(rows * width, shown.shape[2])
    found = np.empty((5, CHUNK), np.float32)
    last_u, last_v = np.float32(stride - 1), np.float32(height - 1)
    for y in range(rows):
        for x_low in range(0, width, CHUNK):
            count = min(CHUNK, width - x_low)
            measure(
                back, np.float32(y + row_low), x_low, front[y, x_low:], slope[0, y, x_low:],
                slope[1, y, x_low:], count, found,
            )  # fmt: skip
            for i in range(count):
                x = x_low + i
                own = weight[y, x]
                if not own > ZERO:
                    continue
                u, v = held(found[0, i], last_u), held(found[1, i], last_v)
                i2, j2 = corner_of(u, v, stride, height)
                # no cells surround those of the border, so that none of them is SMOOTH
                border = i2 < 1 or j2 < 1 or i2 >= stride - 2 or j2 >= height - 2
                wanted = INTACT if border else SMOOTH
                whole = bits[np.uint64(j2 * stride + i2)] & wanted > 0
                off = off_by(
                    colors, deltas, stride, height, whole, u, v, found[2, i], pixels, y * width + x
                )
                out_sums[WEIGHTS, y, x] += own
                out_sums[WHOLES, y, x] += own if whole else ZERO
                out_sums[APART, y, x] += own * off
                out_sums[SHIFTED, y, x] += own * found[4, i]
                out_sums[STRETCHED, y, x] += own * found[3, i]


@kernel
def add_up(
    sums: F4, contrast: F4, coverage: F4, factors: F4, disparity_error: Real, out_error: F4
) -> None:
    """The expected error of each pixel's colour, NaN in holes.

    Args:
        sums: (SUMS, rows, width) from `question`.
        contrast: (2, rows, width) from `survey`.
        coverage: (rows, width).
        factors: (9,) of the mean squares that add up.
        disparity_error: relative error of the references' disparities, in units of `SHIFT`.
        out_error: (rows, width).
    """
    rows, width = coverage.shape
    doubt = np.float32(disparity_error) * np.float32(disparity_error)
    for y in range(rows):
        for x in range(width):
            if not coverage[y, x] > ZERO:
                out_error[y, x] = np.float32(np.nan)
                continue
            inner, across = contrast[0, y, x], contrast[1, y, x]
            square, weight = factors[FLOOR], sums[WEIGHTS, y, x]
            if weight > ZERO:
                scale = ONE / weight
                growth = max(sums[STRETCHED, y, x] * scale - ONE, ZERO)
                square += factors[DISAGREEMENT] * sums[APART, y, x] * scale
                square += (factors[CONTRAST] + factors[STRETCH] * growth) * inner
                square += factors[ACROSS] * across
                square += doubt * sums[SHIFTED, y, x] * scale * inner
                if not sums[WHOLES, y, x] > ZERO:
                    square += factors[EDGE] + factors[EDGE_CONTRAST] * (inner + across)
            else:
                square += factors[UNSEEN] + factors[UNSEEN_CONTRAST] * (inner + across)
            out_error[y, x] = np.sqrt(square)
