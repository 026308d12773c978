"""Kernels that compare how two references show the surfaces that both see."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import add4, lane4, load4
from belvedere.warp._edges import SMOOTH

F4 = npt.NDArray[np.float32]
F8 = npt.NDArray[np.float64]
U1 = npt.NDArray[np.uint8]

ZERO, QUARTER, HALF, ONE = np.float32(0.0), np.float32(0.25), np.float32(0.5), np.float32(1.0)
NAN = np.float32(np.nan)

TERMS = 4
"""Of a shift along one axis: constant, by column, by row, by disparity."""
PLACES = 2 * TERMS + 2
"""Unknowns that shift places: along u, along v, and the two of the perspective."""
UNKNOWNS = PLACES + 2
"""And gain and offset of the brightness."""
WIDE = 16
"""Numbers in a row of equations, with a right side and zeros: whole vectors."""

COUNT, APART, COST, SHIFTED, OWN, FOUND, OWN_OWN, FOUND_FOUND, OWN_FOUND, WEIGHT = range(10)
"""Sums that `compare` makes: pixels; differences; their squares, those beyond the limit counting
the limit's at most; squared shifts along one axis; then, as much as each pixel counts, brightness
of the own reference and of the other, their squares and product; and what they count."""
SUMS = 10
PATCHES = 6
"""Patches across and down in which texture is looked for."""


@kernel
def halve_color(color: F4, links: U1, out: F4) -> None:
    """Brightness of 2 x 2 pixels: the root of their mean radiance, in steps that look alike.

    Args:
        color: (H, W, 4) linear.
        links: (H, W) bits of `_edges`.
        out: (H // 2, W // 2), NaN where an edge is near: what is mixed there moves with the edge.
    """
    share, width = np.float32(1.0 / 12.0), color.shape[1]
    for v in range(out.shape[0]):
        above, below, row = links[2 * v], links[2 * v + 1], out[v]
        for u in range(out.shape[1]):
            at = 2 * v * width + 2 * u
            upper = add4(load4(color, at), load4(color, at + 1))
            lower = add4(load4(color, at + width), load4(color, at + width + 1))
            total = add4(upper, lower)
            row[u] = lane4(total, 0) + lane4(total, 1) + lane4(total, 2)
        for u in range(out.shape[1]):
            left, right = np.uint64(2 * u), np.uint64(2 * u + 1)
            whole = above[left] & above[right] & below[left] & below[right] & SMOOTH
            row[u] = np.sqrt(max(row[u] * share, ZERO)) if whole else NAN


@kernel
def halve(image: F4, out: F4) -> None:
    """Means of 2 x 2 pixels: (H, W) to (H // 2, W // 2), NaN where one of them is."""
    for v in range(out.shape[0]):
        for u in range(out.shape[1]):
            above = image[2 * v, 2 * u] + image[2 * v, 2 * u + 1]
            below = image[2 * v + 1, 2 * u] + image[2 * v + 1, 2 * u + 1]
            out[v, u] = (above + below) * QUARTER


@inner
def between(image: F4, p: Real, q: Real) -> tuple[Real, Real, Real]:
    """Bilinear value at column p, row q, and how it changes along both."""
    left, top = int(p), int(q)
    f, g = p - np.float32(left), q - np.float32(top)
    a, b = image[top, left], image[top, left + 1]
    c, d = image[top + 1, left], image[top + 1, left + 1]
    along_p = (b - a) * (ONE - g) + (d - c) * g
    along_q = (c - a) * (ONE - f) + (d - b) * f
    return a + (b - a) * f + ((c - a) * (ONE - f) + (d - b) * f) * g, along_p, along_q


@kernel
def compare(
    matrix: F4, own_image: F4, own_disparity: F4, image: F4, disparity: F4, links: U1, size: int,
    stride: int, tolerance: Real, frame: F4, guess: F4, limit: Real,
    out_system: F8, out_sums: F8, out_texture: F8,
) -> None:  # fmt: skip
    """Add up what a better guess of another reference's shift and exposure follows from.

    The other reference shows at ``x + shift`` what geometry says is at x, and its brightness there
    is ``gain * own + offset``: linearised round the guess, one equation for each pixel of the own
    image that lies on a surface which both see, far from edges.

    Args:
        matrix: (12,) from the own reference to the other.
        own_image: (h, w) brightness, each the mean of ``size`` x ``size`` samples; NaN where an
            edge is near.
        own_disparity: (H, W).
        image: brightness of the other, as coarse.
        disparity: of the other.
        links: of the other, bits of `_edges`.
        size: samples along the side of a pixel of the images, even.
        stride: pixels from one that is compared to the next, along both axes.
        tolerance: relative difference in disparity that is one surface.
        frame: (4,) column and row of the other's middle, one over half its longer side, and one
            over its typical disparity: a shift's terms are measured in these.
        guess: (UNKNOWNS,) shift along u, along v, by perspective, gain, offset.
        limit: difference in brightness from which on a pixel counts less and less.
        out_system: (UNKNOWNS, WIDE) normal equations of the change of the guess, their right side,
            and zeros; added to.
        out_sums: (SUMS,), added to.
        out_texture: (PATCHES * PATCHES, 2) of each patch of the own image how many pixels are
            compared, and their squared gradients; added to.
    """
    tall, wide = image.shape
    height, width = disparity.shape
    step, middle = ONE / np.float32(size), HALF * np.float32(size - 1)
    base, row = np.ones(TERMS, np.float32), np.zeros(WIDE, np.float64)
    for j in range(stride // 2, own_image.shape[0], stride):
        for i in range(stride // 2, own_image.shape[1], stride):
            own = own_image[j, i]
            if np.isnan(own):
                continue
            x, y = np.float32(i * size) + middle, np.float32(j * size) + middle
            left, top = int(x), int(y)
            above = own_disparity[top, left] + own_disparity[top, left + 1]
            below = own_disparity[top + 1, left] + own_disparity[top + 1, left + 1]
            delta = (above + below) * QUARTER
            t = matrix[8] * x + matrix[9] * y + matrix[10] + matrix[11] * delta
            if not t > ZERO:
                continue
            scale = ONE / t
            u = (matrix[0] * x + matrix[1] * y + matrix[2] + matrix[3] * delta) * scale
            v = (matrix[4] * x + matrix[5] * y + matrix[6] + matrix[7] * delta) * scale
            if not (u >= ZERO and v >= ZERO and u < width - 1 and v < height - 1):
                continue
            landed, left, top = delta * scale, int(u), int(v)
            unsure = abs(disparity[top, left] - landed) > tolerance * landed
            if links[top, left] & SMOOTH == 0 or unsure:
                continue
            base[1], base[2] = (u - frame[0]) * frame[2], (v - frame[1]) * frame[2]
            base[3] = landed * frame[3] - ONE
            tilt = guess[2 * TERMS] * base[1] + guess[2 * TERMS + 1] * base[2]
            du, dv = tilt * base[1], tilt * base[2]
            for k in range(TERMS):
                du += guess[k] * base[k]
                dv += guess[TERMS + k] * base[k]
            p, q = (u + du - middle) * step, (v + dv - middle) * step
            if not (p >= ZERO and q >= ZERO and p < wide - 1 and q < tall - 1):
                continue
            found, along_p, along_q = between(image, p, q)
            if np.isnan(found):
                continue
            apart = guess[PLACES] * own + guess[PLACES + 1] - found
            patch = j * PATCHES // own_image.shape[0] * PATCHES + i * PATCHES // own_image.shape[1]
            out_texture[patch, 0] += ONE
            out_texture[patch, 1] += along_p * along_p + along_q * along_q
            ratio = apart / limit
            damped = ONE / (ONE + ratio * ratio)
            weight = damped * damped
            along_p, along_q = along_p * step, along_q * step
            for k in range(TERMS):
                row[k], row[TERMS + k] = along_p * base[k], along_q * base[k]
            outward = along_p * base[1] + along_q * base[2]
            row[2 * TERMS], row[2 * TERMS + 1] = outward * base[1], outward * base[2]
            row[PLACES], row[PLACES + 1], row[UNKNOWNS] = -own, -ONE, apart
            for m in range(UNKNOWNS):
                share = weight * row[m]
                for n in range(WIDE):  # whole vectors, though half of it is known by symmetry
                    out_system[m, n] += share * row[n]
            out_sums[COUNT] += ONE
            out_sums[APART] += abs(apart)
            out_sums[COST] += damped * apart * apart
            out_sums[SHIFTED] += HALF * (du * du + dv * dv)
            out_sums[OWN] += weight * own
            out_sums[FOUND] += weight * found
            out_sums[OWN_OWN] += weight * own * own
            out_sums[FOUND_FOUND] += weight * found * found
            out_sums[OWN_FOUND] += weight * own * found
            out_sums[WEIGHT] += weight
