"""An IFC's spaces as rooms."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.model._ifc_shapes import Shape
from belvedere.model.building import Room
from belvedere.model.report import Report

F8 = npt.NDArray[np.float64]

ABOVE_FLOOR_M = 0.05
"""Height above a space's lowest point at which its outline is taken."""
SAME_M = 1e-4
"""Ends of section lines that are this close are one corner."""
STRAIGHT_M = 1e-3
"""Corners that lie this close to the line through their neighbours are left out."""


def rooms_of(spaces: list[Any], shapes: dict[int, Shape], report: Report) -> dict[int, Room]:
    """A room for each space that has a shape, by the space's id."""
    names = _names(spaces)
    found: dict[int, Room] = {}
    flat = 0
    for space in spaces:
        shape = shapes.get(space.id())
        if shape is None or np.ptp(shape.vertices[:, 2]) < 0.1:
            flat += 1
            continue
        low, high = float(shape.vertices[:, 2].min()), float(shape.vertices[:, 2].max())
        rings = section(shape.corners, low + min(ABOVE_FLOOR_M, (high - low) / 4.0))
        if not rings:
            report.note(f"space {names[space.id()]!r}: not closed, its bounding rectangle is taken")
            (x0, y0), (x1, y1) = shape.vertices[:, :2].min(0), shape.vertices[:, :2].max(0)
            rings = [np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])]
        found[space.id()] = Room(names[space.id()], tuple(rings), low, high, _storey(space))
    report.count(flat, "space", "spaces", "without a volume: no room")
    return found


def section(corners: F8, height: float) -> list[F8]:
    """Rings where a closed surface meets a level plane.

    Args:
        corners: (M, 3, 3) triangles; which side is their front does not matter, since the faces
            of a space often look both ways.
        height: z of the plane.

    Returns:
        (N, 2) rings; none where the lines do not close.
    """
    above = corners[..., 2] > height
    crossing = above.any(axis=1) & ~above.all(axis=1)
    lines: list[F8] = []
    for triangle, up in zip(corners[crossing], above[crossing], strict=True):
        lone = int(np.flatnonzero(up == (up.sum() == 1))[0])
        apex = triangle[lone]
        others = (triangle[(lone + 1) % 3], triangle[(lone + 2) % 3])
        ends = [(apex + (height - apex[2]) / (q[2] - apex[2]) * (q - apex))[:2] for q in others]
        lines.append(np.stack(ends))
    return _chained(np.array(lines)) if lines else []


def inside(rings: tuple[F8, ...], points: F8) -> npt.NDArray[np.bool_]:
    """Which of (N, 2) points an odd number of rings encloses."""
    x, y = points[:, 0], points[:, 1]
    odd = np.zeros(len(points), dtype=bool)
    for ring in rings:
        for (x0, y0), (x1, y1) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            if y0 != y1:
                odd ^= ((y0 <= y) != (y1 <= y)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
    return odd


def _chained(lines: F8) -> list[F8]:
    """Rings of (N, 2, 2) lines; none where they do not close."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import KDTree

    ends = lines.reshape(-1, 2)
    pairs = KDTree(ends).query_pairs(SAME_M, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (len(ends),) * 2)
    corner = connected_components(links, directed=False)[1].reshape(-1, 2)
    meeting: dict[int, list[int]] = {}
    for k, (first, second) in enumerate(corner):
        if first != second:
            meeting.setdefault(int(first), []).append(k)
            meeting.setdefault(int(second), []).append(k)
    rings: list[F8] = []
    used = np.zeros(len(lines), dtype=bool)
    for begin in range(len(lines)):
        if used[begin] or corner[begin, 0] == corner[begin, 1]:
            continue
        start = at = int(corner[begin, 0])
        ring: list[F8] = []
        while not ring or at != start:
            k = next((k for k in meeting[at] if not used[k]), -1)
            if k < 0:
                return []
            used[k] = True
            forward = int(corner[k, 0]) == at
            ring.append(lines[k, 0 if forward else 1])
            at = int(corner[k, 1 if forward else 0])
        simple = _simplified(np.array(ring))
        if len(simple) >= 3:
            rings.append(simple)
    return rings


def _simplified(ring: F8) -> F8:
    """Without corners on the line between their neighbours."""
    keep = list(ring)
    at = 0
    while at < len(keep) and len(keep) > 3:
        a, b, c = keep[at - 1], keep[at], keep[(at + 1) % len(keep)]
        along = c - a
        length = float(np.hypot(*along))
        off = abs(along[0] * (b - a)[1] - along[1] * (b - a)[0]) / max(length, 1e-12)
        if off < STRAIGHT_M and (b - a) @ (b - c) <= 0.0:
            del keep[at]
            at = max(at - 1, 0)
        else:
            at += 1
    return np.array(keep)


def _names(spaces: list[Any]) -> dict[int, str]:
    """Long names where they differ, with the short one behind where they do not."""
    long = {s.id(): str(s.LongName or s.Name or "Room").strip() for s in spaces}
    short = {s.id(): str(s.Name or s.id()).strip() for s in spaces}
    often = Counter(long.values())
    both = {
        key: name if often[name] == 1 else f"{name} ({short[key]})" for key, name in long.items()
    }
    often = Counter(both.values())
    return {key: name if often[name] == 1 else f"{name} #{key}" for key, name in both.items()}


def _storey(space: Any) -> str:
    """The name of the storey that the space is a part of."""
    seen = 0
    while space is not None and seen < 20:
        seen += 1
        if space.is_a("IfcBuildingStorey"):
            return str(space.Name or space.LongName or "")
        above = getattr(space, "Decomposes", ()) or ()
        space = above[0].RelatingObject if above else None
    return ""
