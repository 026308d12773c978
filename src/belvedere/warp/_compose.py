"""Kernels that join the layers of several references, and turn linear radiance into bytes."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import types
from numba.extending import overload

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import four, store4

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)


@kernel
def decode(color: U1, table: F4, out_linear: F4) -> None:
    """Linear RGBA of (rows, width, 3|4) bytes; alpha is scaled to [0, 1], 0 where there is none.

    out_linear is (rows, width, 4).
    """
    rows, width, channels = color.shape
    for y in range(rows):
        for x in range(width):
            alpha = np.float32(color[y, x, 3]) / np.float32(255.0) if channels == 4 else ZERO
            red, green, blue = table[color[y, x, 0]], table[color[y, x, 1]], table[color[y, x, 2]]
            store4(out_linear, y * width + x, four(red, green, blue, alpha))


def write_row(linear: F4, table: U1, steps: I4, out_row: Any) -> None:
    """A row of linear RGBA as a frame has it.

    ``float32`` colours stay linear but for what cubics overshoot below 0 and alpha above 1.

    Args:
        linear: (width, 4).
        table: see `ground.color.LINEAR_TO_SRGB8`.
        steps: (4 width,) to work in.
        out_row: (width, 3|4) ``uint8`` sRGB or ``float32`` linear.
    """
    if out_row.dtype == np.uint8:
        encode_row(linear, table, steps, out_row)
    else:
        copy_row(linear, steps, out_row)


@inner
def encode_row(linear: F4, table: U1, steps: I4, out_row: U1) -> None:
    """Bytes of a row; see `write_row`."""
    width, channels = out_row.shape
    flat, top = linear.reshape(-1), np.float32(table.shape[0] - 1)
    for i in range(flat.size):
        value = min(max(flat[i], ZERO), ONE)
        steps[i] = np.int32(np.sqrt(value) * top + HALF)
    for x in range(width):
        at = np.uint64(4 * x)
        for k in range(3):
            out_row[x, k] = table[np.uint32(steps[at + np.uint64(k)])]
        if channels == 4:
            value = min(max(flat[at + np.uint64(3)], ZERO), ONE)
            out_row[x, 3] = np.uint8(value * np.float32(255.0) + HALF)


@inner
def copy_row(linear: F4, steps: I4, out_row: F4) -> None:
    """Linear radiance of a row; see `write_row`."""
    width, channels = out_row.shape
    for x in range(width):
        for k in range(3):
            out_row[x, k] = max(linear[x, k], ZERO)
        if channels == 4:
            out_row[x, 3] = min(max(linear[x, 3], ZERO), ONE)


# what kernels compile instead: the one that suits the frame's colours
# ruff: noqa: PLW0108
overload(write_row, jit_options={"forceinline": True})(
    lambda linear, table, steps, out_row: (
        (lambda linear, table, steps, out_row: encode_row(linear, table, steps, out_row))
        if out_row.dtype == types.uint8
        else (lambda linear, table, steps, out_row: copy_row(linear, steps, out_row))
    )
)


@kernel
def encode(linear: F4, table: U1, out_color: U1) -> None:
    """Bytes (rows, width, 3|4) of linear RGBA; see `ground.color.LINEAR_TO_SRGB8`."""
    steps = np.empty(4 * linear.shape[1], np.int32)
    for y in range(linear.shape[0]):
        encode_row(linear[y], table, steps, out_color[y])


@kernel
def overlay(
    colors: F4, disparities: F4, coverages: F4, ratio: Real,
    out_color: F4, out_disparity: F4, out_coverage: F4,
) -> None:  # fmt: skip
    """One layer for each pixel: the first, unless a later one is clearly nearer.

    Args:
        colors: (n, rows, width, 4), the preferred layer first.
        disparities: (n, rows, width), -1 = uncovered.
        coverages: (n, rows, width).
        ratio: how many times larger a later layer's disparity must be to replace what is there;
            infinity: only where nothing is.
        out_color: (rows, width, 4).
        out_disparity: (rows, width), -1 = uncovered.
        out_coverage: (rows, width).

    Source: Popescu and Lastra's fuzzy z-buffer; spec offset-buffer-warping 3.4.
    """
    count, rows, width, _ = colors.shape
    factor = np.float32(ratio)
    for y in range(rows):
        for x in range(width):
            shown, held = 0, disparities[0, y, x]
            for n in range(1, count):
                delta = disparities[n, y, x]
                if delta >= ZERO and (held < ZERO or delta > held * factor):
                    shown, held = n, delta
            out_disparity[y, x] = held
            out_coverage[y, x] = coverages[shown, y, x] if held >= ZERO else ZERO
            for k in range(4):
                out_color[y, x, k] = colors[shown, y, x, k] if held >= ZERO else ZERO


@kernel
def blend(
    colors: F4, disparities: F4, coverages: F4, weights: F4, tolerance: Real,
    out_color: F4, out_disparity: F4, out_coverage: F4,
) -> None:  # fmt: skip
    """The surface in front, averaged over every reference that sees it, over the one behind it.

    Where the front surface covers a pixel only in part, as at a silhouette, the rest shows the next
    surface that any reference saw there.

    Args:
        colors: (n, rows, width, 4) linear.
        disparities: (n, rows, width), -1 = uncovered.
        coverages: (n, rows, width).
        weights: (n,) one per reference.
        tolerance: relative difference in disparity up to which two layers show one surface.
        out_color: (rows, width, 4) colour of the surfaces, each a weighted mean.
        out_disparity: (rows, width) of the surface that covers more, -1 = uncovered.
        out_coverage: (rows, width) what the surfaces cover together.
    """
    count, rows, width, _ = colors.shape
    keep = np.float32(1.0 - tolerance)
    for y in range(rows):
        for x in range(width):
            shown = np.float32(-1.0)
            covered, most = ZERO, ZERO
            ceiling = np.float32(np.inf)
            c0, c1, c2, c3 = ZERO, ZERO, ZERO, ZERO
            for _surface in range(2):
                front = np.float32(-1.0)
                for n in range(count):
                    delta = disparities[n, y, x]
                    front = max(front, delta if delta < ceiling else np.float32(-1.0))
                if front < ZERO:
                    break
                limit = front * keep
                total, depth, best = ZERO, ZERO, ZERO
                m0, m1, m2, m3 = ZERO, ZERO, ZERO, ZERO
                for n in range(count):
                    delta = disparities[n, y, x]
                    if delta < ZERO or delta < limit or delta >= ceiling:
                        continue
                    weight = weights[n] * max(coverages[n, y, x], np.float32(1e-3))
                    total += weight
                    depth += weight * delta
                    best = max(best, coverages[n, y, x])
                    m0 += weight * colors[n, y, x, 0]
                    m1 += weight * colors[n, y, x, 1]
                    m2 += weight * colors[n, y, x, 2]
                    m3 += weight * colors[n, y, x, 3]
                share = (ONE - covered) * best
                each = share / total
                c0 += each * m0
                c1 += each * m1
                c2 += each * m2
                c3 += each * m3
                covered += share
                if share > most:
                    most, shown = share, depth / total
                ceiling = limit
                if covered >= ONE:
                    break
            scale = ONE / covered if covered > ZERO else ZERO
            out_color[y, x, 0] = c0 * scale
            out_color[y, x, 1] = c1 * scale
            out_color[y, x, 2] = c2 * scale
            out_color[y, x, 3] = c3 * scale
            out_disparity[y, x] = shown
            out_coverage[y, x] = min(covered, ONE)


@kernel
def finish(disparity: F4, coverage: F4) -> None:
    """Turn uncovered disparity, -1, into NaN, with coverage 0."""
    rows, width = disparity.shape
    for y in range(rows):
        for x in range(width):
            if not disparity[y, x] >= ZERO:
                disparity[y, x] = np.float32(np.nan)
                coverage[y, x] = ZERO
