"""Rooms that touch without a wall between them: open kitchens, stairs that reach a landing.

IFC tells such places by virtual boundaries, where it tells them at all; here they are found by
geometry alone: outlines that run along one another, and nothing in between.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.model.building import Opening, OpeningKind, Room

F8 = npt.NDArray[np.float64]

TOUCH_M = 0.06
"""Outlines closer than this have no wall between them, unless it is a line in both."""
PROBE_M = 0.12
"""How far on both sides of the common plane matter is looked for."""
LEAST_M = 0.5
"""Width and height from which a gap joins two rooms."""
CELL_M = 0.15
"""Spacing of the probes."""
SEEN = 0.25
"""Share of a column's probes that must be free for it to be seen through: above a railing."""
WALKED = 0.6
"""Share of a column's probes up to `STEP_M` above the floor that must be free to walk there."""
STEP_M = 1.2
BETWEEN_M = 0.4
"""Blocked columns narrower than this, a post or a newel, do not part an opening in two."""


def joins_of(rooms: list[Room], corners: F8) -> tuple[Opening, ...]:
    """Openings where two rooms touch and nothing stands between.

    Args:
        rooms: of one building.
        corners: (M, 3, 3) all triangles of the model, metres.
    """
    low, high = corners.min(axis=1), corners.max(axis=1)
    found: list[Opening] = []
    for i, a in enumerate(rooms):
        for b in rooms[i + 1 :]:
            bottom, top = max(a.floor, b.floor), min(a.ceiling, b.ceiling)
            if top - bottom < LEAST_M or not _near(a, b):
                continue
            for start, along, length in _shared_edges(a, b):
                free = _free(start, along, length, bottom, top, corners, low, high)
                for left, right, kind in _gaps(free, length, top - bottom):
                    name = f"{a.name} - {b.name}"
                    number = sum(o.rooms == (a.name, b.name) for o in found)
                    (x0, y0), (x1, y1) = start + left * along, start + right * along
                    rectangle = [[x0, y0, bottom], [x1, y1, bottom], [x1, y1, top], [x0, y0, top]]
                    found.append(
                        Opening(
                            name if not number else f"{name} ({number + 1})",
                            kind,
                            np.array(rectangle),
                            (a.name, b.name),
                        )
                    )
    return tuple(found)


def _near(a: Room, b: Room) -> bool:
    p, q = np.concatenate(a.rings), np.concatenate(b.rings)
    return bool(
        (p.min(axis=0) <= q.max(axis=0) + TOUCH_M).all()
        and (q.min(axis=0) <= p.max(axis=0) + TOUCH_M).all()
    )


def _shared_edges(a: Room, b: Room) -> list[tuple[F8, F8, float]]:
    """(start, unit direction, length) of the lines along which two outlines run together."""
    found: list[tuple[F8, F8, float]] = []
    for p0, p1 in _edges(a):
        length = float(np.hypot(*(p1 - p0)))
        if length < LEAST_M:
            continue
        along = (p1 - p0) / length
        across = np.array([-along[1], along[0]])
        for q0, q1 in _edges(b):
            off = np.array([(q0 - p0) @ across, (q1 - p0) @ across])
            if np.abs(off).max() > TOUCH_M:
                continue
            s0, s1 = sorted((float((q0 - p0) @ along), float((q1 - p0) @ along)))
            s0, s1 = max(s0, 0.0), min(s1, length)
            if s1 - s0 >= LEAST_M:
                found.append((p0 + s0 * along + off.mean() / 2.0 * across, along, s1 - s0))
    return found


def _edges(room: Room) -> list[tuple[F8, F8]]:
    return [
        (p, q) for ring in room.rings for p, q in zip(ring, np.roll(ring, -1, axis=0), strict=True)
    ]


def _free(
    start: F8, along: F8, length: float, bottom: float, top: float, corners: F8, low: F8, high: F8
) -> npt.NDArray[np.bool_]:
    """(columns, rows) where nothing stands between two rooms, from the start and from the floor."""
    columns, rows = max(int(length / CELL_M), 2), max(int((top - bottom) / CELL_M), 2)
    s = (np.arange(columns) + 0.5) / columns * length
    z = bottom + (np.arange(rows) + 0.5) / rows * (top - bottom)
    across = np.array([-along[1], along[0], 0.0])
    flat = start + s[:, None] * along
    points = np.concatenate([np.repeat(flat, rows, axis=0), np.tile(z, columns)[:, None]], axis=1)
    a, b = points - PROBE_M * across, points + PROBE_M * across
    box_low, box_high = np.minimum(a, b).min(axis=0), np.maximum(a, b).max(axis=0)
    near = ((low <= box_high) & (high >= box_low)).all(axis=1)
    return ~segments_blocked(a, b, corners[near]).reshape(columns, rows)


def _gaps(
    free: npt.NDArray[np.bool_], length: float, height: float
) -> list[tuple[float, float, OpeningKind]]:
    """Runs of columns that are seen through, in metres from the start, and whether one walks."""
    columns, rows = free.shape
    wide = length / columns
    low_rows = max(min(round(STEP_M / height * rows), rows), 1)
    walked = free[:, :low_rows].mean(axis=1) >= WALKED
    found: list[tuple[float, float, OpeningKind]] = []
    runs = _runs(free.mean(axis=1) >= SEEN)
    joined: list[list[int]] = []
    for first, last in runs:
        if joined and (first - joined[-1][1]) * wide < BETWEEN_M:
            joined[-1][1] = last
        else:
            joined.append([first, last])
    for first, last in joined:
        if (last - first) * wide >= LEAST_M:
            walk = max((b - a for a, b in _runs(walked[first:last])), default=0) * wide >= LEAST_M
            found.append((first * wide, last * wide, "opening" if walk else "window"))
    return found


def _runs(mask: npt.NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and past-last index of each run of True."""
    steps = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return [(int(a), int(b)) for a, b in steps.reshape(-1, 2)]


def segments_blocked(a: F8, b: F8, corners: F8) -> npt.NDArray[np.bool_]:
    """(N,) whether any of (M, 3, 3) triangles lies between (N, 3) points a and b.

    Source: Moeller and Trumbore 1997.
    """
    blocked = np.zeros(len(a), dtype=bool)
    along = b - a
    for triangle in corners:
        e, f = triangle[1] - triangle[0], triangle[2] - triangle[0]
        p = np.cross(along, f)
        determinant = p @ e
        good = np.abs(determinant) > 1e-14
        inverse = 1.0 / np.where(good, determinant, 1.0)
        h = a - triangle[0]
        u = (h * p).sum(axis=1) * inverse
        q = np.cross(h, e)
        v = (along * q).sum(axis=1) * inverse
        t = (q @ f) * inverse
        blocked |= good & (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0) & (t <= 1)
    return blocked
