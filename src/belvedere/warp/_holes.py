"""Kernels that fill holes from the farther side."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, kernel

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]

SIDES = 8
"""Directions looked into: left, right, up, down and the four diagonals."""


@kernel
def nearest_covered(disparity: F4, out_steps: I4) -> None:
    """Steps to the nearest covered pixel in each of the eight directions; -1 where there is none.

    disparity is (H, W) with NaN in holes; out_steps is (SIDES, H, W). Two sweeps of the picture.
    """
    height, width = disparity.shape
    for j in range(2 * height):
        down = j < height
        y = j if down else 2 * height - 1 - j
        dy = -1 if down else 1  # the rows already visited lie this way
        base = 0 if down else 4
        for i in range(width):
            x = i if down else width - 1 - i
            for side in range(4):
                # west, north-west, north, north-east on the way down; their opposites on the way up
                sx = (-1, -1, 0, 1)[side] if down else (1, 1, 0, -1)[side]
                sy = 0 if side == 0 else dy
                y2, x2 = y + sy, x + sx
                steps = -1
                if 0 <= y2 < height and 0 <= x2 < width:
                    if not np.isnan(disparity[y2, x2]):
                        steps = 1
                    elif out_steps[base + side, y2, x2] > 0:
                        steps = out_steps[base + side, y2, x2] + 1
                out_steps[base + side, y, x] = steps


@kernel
def fill_from_background(
    color: F4, disparity: F4, steps: I4, tolerance: Real, out_color: F4, out_disparity: F4
) -> None:
    """Give each hole the colour of the farthest surface that borders it.

    Args:
        color: (H, W, C) linear.
        disparity: (H, W), NaN in holes.
        steps: (SIDES, H, W) from `nearest_covered`.
        tolerance: relative difference in disparity up to which borders are one surface.
        out_color: (H, W, C) copy of color, holes to be filled.
        out_disparity: (H, W) copy of disparity.
    """
    height, width, channels = color.shape
    total = np.empty(channels, np.float32)
    for y in range(height):
        for x in range(width):
            if not np.isnan(disparity[y, x]):
                continue
            far = np.float32(np.inf)
            for side in range(SIDES):
                count = steps[side, y, x]
                if count > 0:
                    y2, x2 = border(side, count, y, x)
                    far = min(far, disparity[y2, x2])
            if far == np.float32(np.inf):
                continue  # nothing is known in any direction
            limit = far * np.float32(1.0 + tolerance) + np.float32(1e-6)
            weight_sum, delta_sum = np.float32(0.0), np.float32(0.0)
            total[:] = np.float32(0.0)
            for side in range(SIDES):
                count = steps[side, y, x]
                if count <= 0:
                    continue
                y2, x2 = border(side, count, y, x)
                if disparity[y2, x2] > limit:
                    continue
                length = np.float32(count) * np.float32(1.0 if side % 2 == 0 else 1.41421356)
                weight = np.float32(1.0) / (length * length)
                weight_sum += weight
                delta_sum += weight * disparity[y2, x2]
                for k in range(channels):
                    total[k] += weight * color[y2, x2, k]
            out_disparity[y, x] = delta_sum / weight_sum
            for k in range(channels):
                out_color[y, x, k] = total[k] / weight_sum


@kernel
def border(side: int, count: int, y: int, x: int) -> tuple[int, int]:
    """The pixel ``count`` steps from (y, x) in direction ``side`` of `nearest_covered`."""
    sign = -1 if side < 4 else 1
    index = side % 4
    dx = (-1, -1, 0, 1)[index] * (1 if side < 4 else -1)
    dy = 0 if index == 0 else sign
    return y + dy * count, x + dx * count
