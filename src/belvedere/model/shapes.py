"""Shapes that furniture is made of: boxes, cushions, tubes and sheets of cloth.

Every shape is closed or one-sided with its front outwards, in the builder's current place.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from belvedere.model.charts import F8, UNIT, Builder

_FACES = {  # corner signs of a box's faces, counter-clockwise from outside
    "-x": [(-1, 1, -1), (-1, -1, -1), (-1, -1, 1), (-1, 1, 1)],
    "+x": [(1, -1, -1), (1, 1, -1), (1, 1, 1), (1, -1, 1)],
    "-y": [(-1, -1, -1), (1, -1, -1), (1, -1, 1), (-1, -1, 1)],
    "+y": [(1, 1, -1), (-1, 1, -1), (-1, 1, 1), (1, 1, 1)],
    "-z": [(-1, 1, -1), (1, 1, -1), (1, -1, -1), (-1, -1, -1)],
    "+z": [(-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)],
}


def box(
    b: Builder,
    low: Sequence[float],
    high: Sequence[float],
    material: int,
    scale: float = 1.0,
    without: str = "",
    inside: bool = False,
) -> None:
    """A box from corner ``low`` to corner ``high``.

    The texture's u runs along each face's longer side (the grain of wood follows a board), with an
    offset that depends on the place so that no two boards look alike.

    Args:
        b: where to add it.
        low: smallest corner, metres.
        high: largest corner, metres.
        material: index.
        scale: texture repeats per metre.
        without: faces to leave out, such as ``"-z +z"``.
        inside: fronts inwards: the lining of an opening.
    """
    low_, high_ = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    middle, half = (low_ + high_) / 2.0, (high_ - low_) / 2.0
    signs = np.array([_FACES[name] for name in _FACES if name not in without.split()])
    corners = middle + (signs[:, ::-1] if inside else signs) * half
    side = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)[:, None, None]
    rise = np.linalg.norm(corners[:, 3] - corners[:, 0], axis=1)[:, None, None]
    metres = UNIT * np.concatenate([side, rise], axis=2)
    metres = np.where(side >= rise, metres, metres[..., ::-1])
    shift = (7.31 * middle[0] + 3.77 * middle[1] + 5.13 * middle[2]) * np.array([1.0, 1.618])
    b.patches(corners, material, metres * scale + shift)


def panel(
    b: Builder,
    low: Sequence[float],
    high: Sequence[float],
    face: str,
    material: int,
    turn: bool = False,
) -> None:
    """One face of a box, showing its texture exactly once: a picture, a rug, a book's spine.

    Row 0 of the texture lies at the face's upper edge; ``turn`` lays the texture's u upwards.
    """
    low_, high_ = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    corners = (low_ + high_) / 2.0 + np.array([_FACES[face]]) * (high_ - low_) / 2.0
    uv = np.array([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
    b.patches(corners, material, (uv[:, ::-1] if turn else uv)[None])


def grid(
    b: Builder,
    points: F8,
    material: int,
    uv: F8,
    normals: F8 | None = None,
    bends: F8 | None = None,
) -> None:
    """A smooth surface through (m, n, 3) points; its front is (d/dn) x (d/dm).

    ``bends`` (m, n, 3): see `Builder.patches`.
    """
    if normals is None:
        normals = np.cross(np.gradient(points, axis=1), np.gradient(points, axis=0))

    def corners(a: F8) -> F8:
        quads = np.stack([a[:-1, :-1], a[:-1, 1:], a[1:, 1:], a[1:, :-1]], axis=2)
        return quads.reshape(-1, 4, a.shape[2])

    bent = None if bends is None else corners(bends)
    b.patches(corners(points), material, corners(uv), corners(normals), bent)


def tube(
    b: Builder,
    start: Sequence[float],
    end: Sequence[float],
    radius: float | tuple[float, float],
    material: int,
    sides: int = 6,
    scale: float = 2.0,
) -> None:
    """A round bar between two points; ``radius`` may taper from start to end. Ends stay open."""
    p, q = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    r0, r1 = radius if isinstance(radius, tuple) else (radius, radius)
    axis = (q - p) / np.linalg.norm(q - p)
    side = np.cross(axis, [1.0, 0.0, 0.0] if abs(axis[0]) < 0.8 else [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)[:, None]
    around = np.cos(angle) * side + np.sin(angle) * np.cross(axis, side)
    points = np.stack([p + r0 * around, q + r1 * around])
    length = float(np.linalg.norm(q - p)) * scale
    v, u = np.meshgrid([0.0, 0.13], np.linspace(0.0, 1.0, sides + 1), indexing="ij")
    uv = np.stack([np.where(v > 0.0, length, 0.0), u * 0.13], axis=2)
    grid(b, points, material, uv + p[0] * 3.1 + p[1], np.stack([around, around]))


def cushion(
    b: Builder,
    low: Sequence[float],
    high: Sequence[float],
    material: int,
    radius: float = 0.06,
    scale: float = 4.0,
    bulge: float = 0.0,
    steps: int = 2,
) -> None:
    """A box with rounded edges; ``bulge`` swells its faces by that many metres."""
    low_, high_ = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    middle, half = (low_ + high_) / 2.0, (high_ - low_) / 2.0
    radius = min(radius, float(half.min()) * 0.98)
    bend = np.tan(np.linspace(0.0, np.pi / 4.0, steps + 1))  # along one face of a cube
    for face in _FACES.values():
        signs = np.array(face, dtype=np.float64)
        along, up = (signs[1] - signs[0]) / 2.0, (signs[3] - signs[0]) / 2.0
        out = np.cross(along, up)
        w = np.concatenate([-bend[::-1], bend])  # two halves; their middle is the flat part
        flat = np.concatenate([-np.ones(steps + 1), np.ones(steps + 1)])
        a, c = np.meshgrid(np.arange(len(w)), np.arange(len(w)), indexing="xy")
        normal = out + w[a][..., None] * along + w[c][..., None] * up
        normal /= np.linalg.norm(normal, axis=2, keepdims=True)
        inner = out + flat[a][..., None] * along + flat[c][..., None] * up
        points = middle + inner * (half - radius) + normal * radius
        if bulge:
            local = (points - middle) / half
            swell = np.prod(np.cos(np.clip(local, -1, 1) * np.pi / 2) ** 2 + 1e-9, axis=2) ** 0.5
            points = points + out * swell[..., None] * bulge
        uv = np.stack([(points - middle) @ along, (points - middle) @ up], axis=2)
        grid(b, points, material, uv * scale + middle[:2] * 1.7, normal)
