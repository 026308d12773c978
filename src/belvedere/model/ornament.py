"""Rounded shapes with crisp edges: lathe work, bent bars, balls, rings, mouldings.

Their corners lie on the surface and carry its normals, so that a `SmoothBuilder` can cut them as
finely as it likes; at a crease the surface is split, so that the crease stays sharp.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from belvedere.model.charts import F8, Builder, Rect
from belvedere.model.shapes import grid

CREASE_RAD = 0.75
"""A profile that turns by more than this at a corner has a crease there."""


def lathe(
    b: Builder,
    profile: Sequence[tuple[float, float]],
    material: int,
    sides: int = 8,
    center: Sequence[float] = (0.0, 0.0, 0.0),
    scale: float = 1.0,
    crisp: bool = True,
) -> None:
    """A body turned about +z from a profile of (radius, height), listed upwards on its outside.

    Unless it is ``crisp``, shading runs on over the creases of the profile.
    """
    line = np.asarray(profile, dtype=np.float64)
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)
    around = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    repeats = max(round(2.0 * np.pi * float(line[:, 0].max()) * scale), 1)
    for first, last in smooth_runs(line) if crisp else [(0, len(line) - 1)]:
        run = line[first : last + 1]
        slope = _tangents(run) if crisp else np.gradient(run, axis=0)
        up = np.array([0.0, 0.0, 1.0])
        points = run[:, None, :1] * around + run[:, None, 1:] * up
        normals = slope[:, None, 1:] * around - slope[:, None, :1] * up
        u, v = np.meshgrid(angle / (2 * np.pi) * repeats, length[first : last + 1] * scale)
        bends = np.broadcast_to(around, points.shape)
        grid(b, points + np.asarray(center), material, np.stack([u, v], axis=2), normals, bends)


def smooth_runs(line: F8) -> list[tuple[int, int]]:
    """(first, last) corners of the parts of a polyline between its creases."""
    step = np.diff(line, axis=0)
    step = step / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-12)
    turn = np.arccos(np.clip((step[1:] * step[:-1]).sum(axis=1), -1.0, 1.0))
    ends = [0, *(np.flatnonzero(turn > CREASE_RAD) + 1).tolist(), len(line) - 1]
    return list(pairwise(ends))


def _tangents(line: F8) -> F8:
    """Unit tangents of a smooth polyline: at each corner those of the circle through three."""
    step = np.diff(line, axis=0)
    length = np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-12)
    unit = step / length
    inner = unit[:-1] * length[1:] + unit[1:] * length[:-1]
    ends = np.concatenate([unit[:1], inner, unit[-1:]])
    if len(line) > 2:  # mirror the second tangent in the first chord: an arc goes on as an arc
        for end, chord, beside in ((0, unit[0], inner[0]), (-1, unit[-1], inner[-1])):
            near = beside / max(float(np.linalg.norm(beside)), 1e-12)
            ends[end] = 2.0 * (near @ chord) * chord - near
    return ends / np.maximum(np.linalg.norm(ends, axis=1, keepdims=True), 1e-12)


def ball(
    b: Builder,
    center: Sequence[float],
    radius: float,
    material: int,
    sides: int = 6,
    squash: float = 1.0,
) -> None:
    """A ball; ``squash`` is its height by its width."""
    rise = np.linspace(-np.pi / 2.0, np.pi / 2.0, sides // 2 + 1)
    profile = [(max(radius * np.cos(a), 1e-4), radius * squash * np.sin(a)) for a in rise]
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)
    around = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    line, up = np.array(profile), np.array([0.0, 0.0, 1.0])
    points = line[:, None, :1] * around + line[:, None, 1:] * up
    normals = points / np.array([1.0, 1.0, squash**2])
    u, v = np.meshgrid(angle / (2 * np.pi), rise / np.pi + 0.5)
    bends = np.broadcast_to(around, points.shape)
    grid(b, points + np.asarray(center), material, np.stack([u, v], axis=2), normals, bends)


def bar(
    b: Builder,
    path: Sequence[Sequence[float]],
    radius: float | Sequence[float],
    material: int,
    sides: int = 6,
    scale: float = 2.0,
) -> None:
    """A round bar bent along a smooth path of three points or more; ``radius`` may vary along."""
    line = np.asarray(path, dtype=np.float64)
    along = _tangents(line)
    side = np.cross(along[0], [0.0, 0.0, 1.0] if abs(along[0, 2]) < 0.9 else [1.0, 0.0, 0.0])
    sides_ = []
    for tangent in along:  # carried along without twisting
        side = side - (side @ tangent) * tangent
        side = side / np.linalg.norm(side)
        sides_.append(side)
    first = np.array(sides_)
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)[:, None]
    other = np.cross(along, first)
    around = np.cos(angle) * first[:, None] + np.sin(angle) * other[:, None]
    thick = np.broadcast_to(np.asarray(radius, dtype=np.float64), (len(line),))
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    u, v = np.meshgrid(angle[:, 0] / 20.0, length * scale)
    points = line[:, None] + thick[:, None, None] * around
    grid(b, points, material, np.stack([v, u], axis=2), around)


def ring(
    b: Builder,
    center: Sequence[float],
    radius: float,
    thick: float,
    material: int,
    sides: int = 12,
    squash: float = 1.0,
) -> None:
    """A level ring of a bar ``thick`` in radius; ``squash`` is its y extent by its x extent."""
    a = np.linspace(0.0, 2.0 * np.pi, sides + 1)
    c = np.linspace(0.0, 2.0 * np.pi, 7)
    out = np.stack([np.cos(a), np.sin(a), np.zeros_like(a)], axis=1)
    normals = np.cos(c)[None, :, None] * out[:, None] + np.sin(c)[None, :, None] * np.array(
        [0.0, 0.0, 1.0]
    )
    points = radius * out[:, None] + thick * normals
    points = points * np.array([1.0, squash, 1.0])
    u, v = np.meshgrid(c / 20.0, a * radius * 2.0)
    uv = np.stack([v, u], axis=2)
    grid(b, (points + np.asarray(center))[:, ::-1], material, uv[:, ::-1], normals[:, ::-1])


CORNICE = (
    (0.0, -0.155), (0.014, -0.152), (0.018, -0.135), (0.018, -0.125), (0.022, -0.112),
    (0.038, -0.088), (0.062, -0.062), (0.088, -0.044), (0.094, -0.043), (0.094, -0.028),
    (0.108, -0.024), (0.118, -0.012), (0.120, 0.0),
)  # fmt: skip
"""(out of the wall, up from the ceiling) of a moulding with a fillet, a cove and a bead."""
DADO = (
    (0.0, -0.030), (0.010, -0.028), (0.014, -0.018), (0.026, -0.010), (0.030, 0.0),
    (0.026, 0.010), (0.012, 0.016), (0.008, 0.026), (0.0, 0.028),
)  # fmt: skip
"""A rail along the wall, at the height of a chair's back."""


def cornice(
    b: Builder, area: Rect, height: float, material: int,
    profile: Sequence[tuple[float, float]] = CORNICE,
) -> None:  # fmt: skip
    """A moulding round a room under its ceiling, mitred in the corners."""
    x0, y0, x1, y1 = area
    line = np.asarray(profile)
    corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    inward = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    for k in range(4):
        ends = [(k + 1) % 4, k]
        flat = corners[ends][None] + line[:, :1, None] * inward[ends][None]
        z = np.broadcast_to(height + line[:, 1:, None], (len(line), 2, 1))
        points = np.concatenate([flat, z], axis=2)
        _strip(b, points, line, material)


def rail(
    b: Builder, start: Sequence[float], end: Sequence[float], out: Sequence[float], material: int,
    profile: Sequence[tuple[float, float]] = DADO,
) -> None:  # fmt: skip
    """A straight moulding from ``start`` to ``end``; ``out`` is the unit way off the wall."""
    line, off = np.asarray(profile), np.asarray(out, dtype=np.float64)
    foot = np.array([start, end], dtype=np.float64)
    if np.cross(foot[1] - foot[0], [0.0, 0.0, 1.0]) @ off < 0.0:
        foot = foot[::-1]
    points = foot[None] + line[:, :1, None] * off
    points = points + line[:, 1:, None] * np.array([0.0, 0.0, 1.0])
    _strip(b, points, line, material)


def _strip(b: Builder, points: F8, line: F8, material: int) -> None:
    """(n, 2, 3) points of a profile swept between two ends, split at its creases."""
    along = points[:, 1] - points[:, 0]
    unit = along / np.linalg.norm(along, axis=1, keepdims=True)
    for first, last in smooth_runs(line):
        part = points[first : last + 1]
        up = np.stack([_tangents(part[:, k]) for k in range(2)], axis=1)
        normals = np.cross(unit[first : last + 1, None], up)
        length = np.linalg.norm(along[first : last + 1], axis=1)
        v, u = np.meshgrid(np.array([0.0, 1.0]), np.arange(len(part)) * 0.02)
        uv = np.stack([v * length[:, None] * 0.5, u], axis=2).astype(np.float64)
        grid(b, part, material, uv, normals)
