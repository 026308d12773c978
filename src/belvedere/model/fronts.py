"""Which side of each face of a mesh people see, whatever the winding says.

Models often have faces turned the wrong way. Faces that share an edge are first wound alike; then
each such piece is asked, at points spread over it, which of its sides looks into the open. A solid
is seen from where its own faces are not met; a wall, from the room; what lies close behind
something else has no say.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.model.raycast import RayCaster
from belvedere.scene.mesh import Mesh

F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]
I8 = npt.NDArray[np.int64]
B1 = npt.NDArray[np.bool_]

CLOSE_M = 0.6
"""A side that mostly looks at something nearer than this may be the inside of a solid."""
THIN_M = 0.15
"""A sheet is seen from both sides where both look farther than this."""
LOOKS = 12
"""Rays cast on either side of a point."""
SPEAKER_M2 = 0.05
"""Of a piece of a mesh for each point that speaks for it,"""
LEAST, MOST = 3, 40
"""so many points at least and at most."""

__all__ = ["Fronts", "find_fronts"]


@dataclass(frozen=True, slots=True, eq=False)
class Fronts:
    """The sides of faces."""

    sign: F8
    """(M,) 1 where the front is what the winding says, -1 where it is the other side."""
    both: B1
    """(M,) faces of sheets, which people see from both sides."""


def find_fronts(
    mesh: Mesh, welded: I8, pair_a: I4, pair_b: I4, caster: RayCaster, threads: int | None = None
) -> Fronts:
    """Find the side of each face that people see.

    Args:
        mesh: any triangles.
        welded: (M, 3) numbers of the faces' corners, the same for corners at one place.
        pair_a: (E,) faces on one side of each edge.
        pair_b: (E,) faces on its other side.
        caster: of the mesh.
        threads: how many to use; None for as many as there are processors.
    """
    from belvedere.model import _chart_kernels

    count = len(mesh.faces)
    normal = mesh.normals()
    corners = mesh.vertices[mesh.faces]
    double = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    # where many faces meet at an edge, nobody knows which of them go on as one surface
    crowd = np.bincount(np.concatenate([pair_a, pair_b]), minlength=count)
    use = (crowd[pair_a] <= 3) & (crowd[pair_b] <= 3) & (double[pair_a] > 0) & (double[pair_b] > 0)
    one, two = pair_a[use].astype(np.int64), pair_b[use].astype(np.int64)
    sign, piece = np.ones(count), np.arange(count, dtype=np.int64)
    _chart_kernels.wind_alike(one, two, _opposed(welded, one, two), piece, sign)
    kept = np.bincount(piece, double * sign, count)
    sign *= np.where(kept < 0.0, -1.0, 1.0)[piece]
    face, point = _spread(mesh, piece, double)
    if not len(face):
        return Fronts(sign, np.zeros(count, dtype=bool))
    vote, sheet = _votes(caster, face, point, normal, sign, piece, threads)
    turned = np.bincount(piece[face], vote, count) > 0.0
    both = np.bincount(piece[face], sheet - 0.5, count) > 0.0
    return Fronts(sign * np.where(turned, -1.0, 1.0)[piece], both[piece])


def _opposed(welded: I8, one: I8, two: I8) -> B1:
    """(E,) whether neighbours run along their common edge in opposite ways, as they should."""
    result = np.zeros(len(one), dtype=bool)
    for i in range(3):
        start, end = welded[one, i], welded[one, (i + 1) % 3]
        for j in range(3):
            result |= (start == welded[two, (j + 1) % 3]) & (end == welded[two, j])
    return result


def _spread(mesh: Mesh, piece: I8, double: F8) -> tuple[I8, F8]:
    """Faces and points on them that speak for their pieces, spread evenly by area."""
    order = np.lexsort((np.arange(len(piece)), piece))
    order = order[double[order] > 0.0]
    if not len(order):
        return np.zeros(0, np.int64), np.zeros((0, 3))
    owner, area = piece[order], double[order] / 2.0
    first = np.flatnonzero(np.diff(owner, prepend=-1))
    whole = np.add.reduceat(area, first)
    count = np.clip(np.ceil(whole / SPEAKER_M2), LEAST, MOST).astype(np.int64)
    end = np.cumsum(area)
    start = end[first] - area[first]
    row = np.repeat(np.arange(len(first)), count)
    k = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    wanted = start[row] + whole[row] * (k + 0.5) / count[row]
    last = np.append(first[1:], len(order)) - 1
    at = np.clip(np.searchsorted(end, wanted), first[row], last[row])
    face = order[at]
    u, v = (0.7548776662 * (k + 0.5)) % 1.0, (0.5698402910 * (k + 0.5)) % 1.0
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u)[:, None], np.where(over, 1.0 - v, v)[:, None]
    a, b, c = (mesh.vertices[mesh.faces[face, n]] for n in range(3))
    return face, a + u * (b - a) + v * (c - a)


def _votes(
    caster: RayCaster, face: I8, point: F8, normal: F8, sign: F8, piece: I8, threads: int | None
) -> tuple[F8, B1]:
    """What each point says: 1 for turning its piece, -1 for leaving it; whether it is a sheet."""
    near, own = [], []
    k = np.arange(LOOKS) + 0.5
    z, angle = np.sqrt(1.0 - k / LOOKS), 2.399963 * k
    ring = np.sqrt(1.0 - z * z)
    for side in (1.0, -1.0):
        up = normal[face] * (side * sign[face])[:, None]
        across = np.cross(up, np.where(np.abs(up[:, :1]) < 0.7, [[1.0, 0, 0]], [[0, 1.0, 0]]))
        across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
        other = np.cross(up, across)
        way = (ring * np.cos(angle))[:, None] * across[:, None]
        way = way + (ring * np.sin(angle))[:, None] * other[:, None] + z[:, None] * up[:, None]
        way = way.reshape(-1, 3)
        hits = caster.cast(np.repeat(point + 1e-3 * up, LOOKS, axis=0), way, threads)
        itself = (hits.face >= 0) & (piece[hits.face] == np.repeat(piece[face], LOOKS))
        near.append(np.median(hits.t.reshape(-1, LOOKS), axis=1))
        own.append(itself.reshape(-1, LOOKS).mean(axis=1))
    hollow = [(own[k] > 0.5) & (near[k] < 2.0 * CLOSE_M) for k in range(2)]

    def turn(front: int) -> B1:
        rear = 1 - front
        # beside the open sky, what is behind must be as wide as a room to be one
        limit, wide = (
            np.where(np.isfinite(near[k]), CLOSE_M, 2.0 * CLOSE_M) for k in (rear, front)
        )
        narrow = (near[front] < limit) & (near[rear] > 2.0 * near[front])
        room = (near[rear] > wide) & np.isfinite(near[rear])
        return (narrow | room) & ~hollow[rear]

    sheet = (near[0] > THIN_M) & (near[1] > THIN_M) & ~hollow[0] & ~hollow[1]
    return turn(0).astype(np.float64) - turn(1), sheet
