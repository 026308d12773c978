"""Polygons cut into triangles."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

F8 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int64]


def triangulated(points: F8, corners: I8, starts: I8) -> tuple[I8, I8]:
    """Cut polygons into triangles with the same fronts.

    Args:
        points: (N, 3) positions.
        corners: (C,) index into ``points`` of each corner, polygon by polygon.
        starts: (P + 1,) where each polygon's corners begin.

    Returns:
        (T,) which polygon each triangle is of, ascending, and (T, 3) indices into ``corners``.
        Polygons of fewer than three corners give none.
    """
    count = np.diff(starts)
    per_polygon = np.maximum(count - 2, 0)
    polygon = np.repeat(np.arange(len(count)), per_polygon)
    first = np.repeat(np.cumsum(per_polygon) - per_polygon, per_polygon)
    step = np.arange(len(polygon)) - first
    base = starts[polygon]
    triangles = np.stack([base, base + step + 1, base + step + 2], axis=1).astype(np.int64)
    for k in np.flatnonzero(_hollow(points, corners, triangles, polygon, len(count))):
        ring = points[corners[starts[k] : starts[k + 1]]]
        triangles[polygon == k] = starts[k] + cut_ears(ring)
    return polygon, triangles


def _hollow(
    points: F8, corners: I8, triangles: I8, polygon: I8, count: int
) -> npt.NDArray[np.bool_]:
    """(P,) polygons whose fan of triangles folds over itself: they are not convex."""
    a, b, c = (points[corners[triangles[:, k]]] for k in range(3))
    with np.errstate(over="ignore", invalid="ignore"):
        normal = np.cross(b - a, c - a)
        total = np.zeros((count, 3))
        for k in range(3):
            total[:, k] = np.bincount(polygon, normal[:, k], minlength=count)
        return np.bincount(polygon, (normal * total[polygon]).sum(axis=1) < 0.0, count) > 0


def cut_ears(ring: F8) -> I8:
    """(n - 2, 3) triangles of a simple polygon (n, 3), by cutting off ears.

    Source: Meisters 1975; where no ear is left (the polygon crosses itself), a fan of the rest.
    """
    normal = np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
    drop = int(np.abs(normal).argmax())
    flat = np.delete(ring, drop, axis=1)
    if (normal[drop] < 0.0) != (drop == 1):
        flat = flat * np.array([1.0, -1.0])
    left = list(range(len(ring)))
    out: list[tuple[int, int, int]] = []
    while len(left) > 3:
        for at in range(len(left)):
            ear = (left[at - 1], left[at], left[(at + 1) % len(left)])
            if _is_ear(flat, ear, left):
                out.append(ear)
                del left[at]
                break
        else:
            out.extend((left[0], left[k], left[k + 1]) for k in range(1, len(left) - 1))
            return np.array(out, np.int64)
    out.append((left[0], left[1], left[2]))
    return np.array(out, np.int64)


def _is_ear(flat: F8, ear: tuple[int, int, int], left: list[int]) -> bool:
    a, b, c = flat[list(ear)]
    if _side(a, b, c) <= 0.0:
        return False
    others = flat[[k for k in left if k not in ear]]
    inside = (
        (_side(a, b, others) >= 0.0) & (_side(b, c, others) >= 0.0) & (_side(c, a, others) >= 0.0)
    )
    same = (others == a).all(axis=1) | (others == b).all(axis=1) | (others == c).all(axis=1)
    return not bool((inside & ~same).any())


def _side(a: F8, b: F8, p: F8) -> F8:
    """Twice the area of a, b, p: above 0 where p lies left of a to b."""
    return (b[0] - a[0]) * (p[..., 1] - a[1]) - (b[1] - a[1]) * (p[..., 0] - a[0])
