"""Kernels that close small gaps of samples inside a surface."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, kernel

F4 = npt.NDArray[np.float32]


@kernel
def step_to_sample(d: F4, v: int, u: int, dv: int, du: int, most: int) -> int:
    """Steps from (v, u) to the next sample in a direction, or 0 if ``most`` do not reach one."""
    for step in range(1, most + 1):
        v2, u2 = v + step * dv, u + step * du
        if v2 < 0 or u2 < 0 or v2 >= d.shape[0] or u2 >= d.shape[1]:
            return 0
        if not np.isnan(d[v2, u2]):
            return step
    return 0


@kernel
def bridge_gaps(
    disparity: F4, widest: int, tolerance: Real, row_low: int, row_high: int, out: F4
) -> None:
    """Give missing samples the disparity of the surface that goes on at both sides of the gap.

    Sensors leave seams and specks without depth in the middle of a surface. Where the samples on
    two opposite sides of a gap agree, the surface is taken to run through; where they do not, there
    is an edge, and nothing is made up.

    Args:
        disparity: (H, W), NaN where missing.
        widest: missing samples in a row or column that are bridged at most.
        tolerance: relative difference in disparity of samples that agree.
        row_low: first row to do.
        row_high: row after the last.
        out: (H, W), written in those rows.
    """
    width = disparity.shape[1]
    for v in range(row_low, row_high):
        for u in range(width):
            out[v, u] = disparity[v, u]
            if not np.isnan(disparity[v, u]):
                continue
            total, weights = np.float32(0.0), np.float32(0.0)
            for axis in range(2):
                dv, du = axis, 1 - axis
                back = step_to_sample(disparity, v, u, -dv, -du, widest)
                ahead = step_to_sample(disparity, v, u, dv, du, widest)
                if back == 0 or ahead == 0 or back + ahead - 1 > widest:
                    continue
                a = disparity[v - back * dv, u - back * du]
                b = disparity[v + ahead * dv, u + ahead * du]
                if abs(a - b) <= tolerance * max(a, b):
                    span = np.float32(back + ahead)
                    value = (a * np.float32(ahead) + b * np.float32(back)) / span
                    total += value / span
                    weights += np.float32(1.0) / span
            if weights > 0:
                out[v, u] = total / weights
