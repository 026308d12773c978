"""Loops that put portal images behind the view cell's geometry. Private."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import kernel

A = npt.NDArray[Any]


@kernel
def show_through(
    matrix: A, planes: A, normal: A, share: float, u0: int, v0: int, color: A, disparity: A,
    coverage: A, weight: float, decode: A, encode: A, persist: bool, kept: A, out_color: A,
    out_disparity: A, out_coverage: A,
) -> int:  # fmt: skip
    """Show a warped crop through a portal, where nothing stands before the portal's plane.

    Args:
        matrix: (3, 3) of the window's camera.
        planes: (K, 3) of the frustum through the portal, pointing inwards.
        normal: (3,) of the portal.
        share: ``normal @ ray * share`` is the disparity of the portal's plane.
        u0: column of the crop's first pixel in the window.
        v0: row of it.
        color: (h, w, 3) uint8 of the crop.
        disparity: (h, w).
        coverage: (h, w); 0 is a hole.
        weight: of the crop against what is there already; below 1 while a portal fades.
        decode: (256,) linear light of each byte.
        encode: (N,) the byte of linear light ``x`` at ``sqrt(x) * (N - 1)``.
        persist: show in a hole what was seen there last; without, the window's color stays.
        kept: (H, W, 3) uint8, what was seen last through portals; renewed where ``persist``.
        out_color: (H, W, 3) uint8 of the window, with the geometry drawn.
        out_disparity: (H, W).
        out_coverage: (H, W).

    Returns:
        How many pixels show the portal.
    """
    shown, steps = 0, encode.shape[0] - 1
    height, width = disparity.shape
    for v in range(height):
        for u in range(width):
            x, y = u + u0, v + v0
            rx = matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2]
            ry = matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2]
            rz = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
            inside = True
            for k in range(planes.shape[0]):
                if planes[k, 0] * rx + planes[k, 1] * ry + planes[k, 2] * rz < 0.0:
                    inside = False
                    break
            if not inside:
                continue
            plane = (normal[0] * rx + normal[1] * ry + normal[2] * rz) * share
            if out_disparity[y, x] >= plane:
                continue
            shown += 1
            seen = coverage[v, u] > 0.0
            if weight < 1.0:
                if seen:
                    for c in range(3):
                        mixed = weight * decode[color[v, u, c]]
                        mixed += (1.0 - weight) * decode[out_color[y, x, c]]
                        out_color[y, x, c] = encode[int(np.sqrt(mixed) * steps + 0.5)]
                continue
            out_coverage[y, x] = coverage[v, u]
            out_disparity[y, x] = disparity[v, u] if seen else np.nan
            for c in range(3):
                if seen:
                    out_color[y, x, c] = color[v, u, c]
                    if persist:
                        kept[y, x, c] = color[v, u, c]
                elif persist:
                    out_color[y, x, c] = kept[y, x, c]
    return shown
