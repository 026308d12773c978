"""Slow twins of the inverse pass: scan conversion in float64, area coverage of straight edges."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from belvedere.scene import Camera
from tests.oracles.warp import project_samples

F8 = npt.NDArray[np.float64]
B1 = npt.NDArray[np.bool_]


def scan_convert(
    reference: Camera, desired: Camera, disparity: npt.NDArray[np.float32], near: float
) -> tuple[F8, B1]:
    """What each desired pixel's centre sees of the cells whose four samples all exist.

    A cell is two triangles, each a plane of disparity; those seen from behind are not drawn.

    Returns:
        (rows, columns) disparity, -1 where nothing is; and where a centre is within ``near`` pixels
        of a triangle's side, so that either answer is right.
    """
    height, width = disparity.shape
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    x, y, z = project_samples(reference, desired, u, v, disparity.astype(float))
    out, doubt = np.full(desired.size, -1.0), np.zeros(desired.size, bool)
    for j in range(height - 1):
        for i in range(width - 1):
            cell = [(j, i), (j, i + 1), (j + 1, i), (j + 1, i + 1)]
            if not all(np.isfinite(z[at]) for at in cell):
                continue
            a, b, c, d = (np.array([x[at], y[at], z[at]]) for at in cell)
            for triangle in ((a, b, c), (d, c, b)):
                _fill_triangle(*triangle, near, out, doubt)
    return out, doubt


def _fill_triangle(a: F8, b: F8, c: F8, near: float, out: F8, doubt: B1) -> None:
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    if area <= 0:
        return
    low = np.ceil(np.min([a, b, c], axis=0)[:2] - 1).astype(int)
    high = np.floor(np.max([a, b, c], axis=0)[:2] + 1).astype(int)
    plane = np.linalg.solve([[*p[:2], 1.0] for p in (a, b, c)], [a[2], b[2], c[2]])
    for y in range(max(low[1], 0), min(high[1] + 1, out.shape[0])):
        for x in range(max(low[0], 0), min(high[0] + 1, out.shape[1])):
            distance = min(_inward(a, b, x, y), _inward(b, c, x, y), _inward(c, a, x, y))
            doubt[y, x] |= abs(distance) < near
            if distance >= 0:
                out[y, x] = max(out[y, x], plane @ (x, y, 1.0))


def _inward(p: F8, q: F8, x: float, y: float) -> float:
    """Distance of (x, y) from the line p q, positive on its inner side."""
    dx, dy = q[0] - p[0], q[1] - p[1]
    return float((dx * (y - p[1]) - dy * (x - p[0])) / math.hypot(dx, dy))


def half_plane_area(
    height: int, width: int, normal: tuple[float, float], offset: float, steps: int = 64
) -> F8:
    """(H, W) share of each pixel's square where ``normal . (u, v) < offset``.

    Exact across the edge, the midpoint rule along it: exact for edges along rows or columns, and
    wherever the edge crosses only the sides it is steep to.
    """
    u, v = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
    a, b = normal
    if abs(a) < abs(b):
        return half_plane_area(width, height, (b, a), offset, steps).T
    total = np.zeros((height, width))
    for step in range(steps):
        along = v + (step + 0.5) / steps - 0.5
        edge = (offset - b * along) / a
        left = np.clip(edge - (u - 0.5), 0.0, 1.0)
        total += left if a > 0 else 1.0 - left
    return total / steps


def interval_share(count: int, low: float, high: float) -> F8:
    """(count,) share of each unit interval round 0, 1, 2 ... that lies in [low, high]."""
    middle = np.arange(count, dtype=float)
    return np.clip(np.minimum(middle + 0.5, high) - np.maximum(middle - 0.5, low), 0.0, 1.0)


def inside_quad(corners: F8, u: float, v: float) -> float:
    """Distance by which (u, v) is inside a quad (8,) of u, v: upper left, right, lower left, right.

    Negative outside; a quad without an area has no inside.
    """
    a, b, c, d = corners.reshape(4, 2)
    sides = ((a, b), (b, d), (d, c), (c, a))
    lengths = [math.hypot(*(q - p)) for p, q in sides]
    inward = [
        _inward(p, q, u, v) for (p, q), size in zip(sides, lengths, strict=True) if size > 1e-9
    ]
    return min(inward) if len(inward) >= 3 else -math.inf
