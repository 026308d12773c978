"""Charts for any mesh: where light is stored on polygons that somebody else made.

Coplanar faces that touch share one flat chart, the rectangle round them in their plane. Faces of
curved surfaces get one chart each, a parallelogram of which the face is half, and share the light
of their corners with their neighbours. The front of a chart is the side that people see: files
often have faces turned the wrong way, and light belongs on the other side of those.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.model.charts import F8, Charts
from belvedere.model.raycast import RayCaster
from belvedere.scene.mesh import Mesh

I8 = npt.NDArray[np.int64]
B1 = npt.NDArray[np.bool_]

WELD_M = 1e-4
"""Corners nearer than this are one."""
COPLANAR = 0.999999
"""Cosine between the normals of faces of one plane."""
SMOOTH = 0.77
"""Cosine between the normals of neighbouring faces of one curved surface: 40 degrees."""
BUMP_M = 0.004
"""A flat chart's faces lie this near to its plane."""
SMALL_M2 = 0.05
"""A flat part of a curved surface is a facet where it is smaller than this."""
CLOSE_M = 0.6
"""Fronts that mostly look at something nearer than this may look into a solid."""
LOOKS = 12
"""Rays cast on either side of a face to find out which side people see."""
SPEAKER_M2 = 0.05
"""Of a piece of a mesh for each point that speaks for it,"""
LEAST, MOST = 3, 40
"""so many points at least and at most."""

__all__ = ["charts_of"]


def charts_of(mesh: Mesh, caster: RayCaster | None = None, threads: int | None = None) -> Charts:
    """Charts of a mesh, as `bake` takes them with ``LightSettings(two_sided=True)``.

    Args:
        mesh: any polygons: holes, soup and faces without area do no harm.
        caster: of that mesh, if there is one already.
        threads: how many to use; None for as many as there are processors.

    Raises:
        MissingDependencyError: embreex is not installed.
    """
    count = len(mesh.faces)
    if not count:
        return Charts(
            np.zeros((0, 4, 3)), np.zeros((0, 4, 3)), np.zeros(0, np.int32),
            np.zeros(0, np.int32), np.zeros((0, 3, 2), np.float32), np.zeros((0, 5)),
        )  # fmt: skip
    corners = mesh.vertices[mesh.faces]
    normal = mesh.normals()
    double = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    pairs = _neighbours(mesh, double > 0.0)
    normal = normal * _turned(mesh, caster, pairs, normal, double, threads)[:, None]
    same = mesh.material_index[pairs.one] == mesh.material_index[pairs.two]
    cosine = np.einsum("ij,ij->i", normal[pairs.one], normal[pairs.two])
    plane = _groups(pairs, same & (cosine > COPLANAR), count)
    skin = _groups(pairs, same & (cosine > SMOOTH), count)
    flat = _flat_groups(corners, normal, double, plane, skin)
    return _joined(mesh, corners, pairs.corner, normal, double, skin, flat)


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Faces that share an edge."""

    corner: I8
    """(M, 3) welded vertex of each face's corners."""
    one: I8
    """(E,) a face."""
    two: I8
    """(E,) its neighbour."""
    opposed: B1
    """(E,) whether both are wound alike, so that they run along the edge in opposite ways."""


def _welded(mesh: Mesh) -> I8:
    """(M, 3) corners of the faces by number; those at one place have one number."""
    grid = np.rint((mesh.vertices - mesh.bounds[0]) / WELD_M).astype(np.int64)
    size = grid.max(axis=0) + 1
    if float(np.prod(size.astype(np.float64))) < 2.0**62:
        key = (grid[:, 0] * size[1] + grid[:, 1]) * size[2] + grid[:, 2]
        number = np.unique(key, return_inverse=True)[1]
    else:
        number = np.unique(grid, axis=0, return_inverse=True)[1]
    return number.reshape(-1)[mesh.faces].astype(np.int64)


def _neighbours(mesh: Mesh, solid: B1) -> _Pairs:
    corner = _welded(mesh)
    start = corner[:, [0, 1, 2]].ravel()
    end = corner[:, [1, 2, 0]].ravel()
    face = np.repeat(np.arange(len(corner)), 3)
    ok = (start != end) & solid[face]
    start, end, face = start[ok], end[ok], face[ok]
    low, high = np.minimum(start, end), np.maximum(start, end)
    order = np.lexsort((face, high, low))
    low, high, face, start = low[order], high[order], face[order], start[order]
    touch = (low[1:] == low[:-1]) & (high[1:] == high[:-1]) & (face[1:] != face[:-1])
    at = np.flatnonzero(touch)
    return _Pairs(corner, face[at], face[at + 1], start[at] != start[at + 1])


def _groups(pairs: _Pairs, joined: B1, count: int) -> I8:
    """(M,) number of the group of each face, groups being joined by pairs."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    ends = pairs.one[joined], pairs.two[joined]
    links = csr_array((np.ones(len(ends[0]), dtype=np.int8), ends), shape=(count, count))
    return connected_components(links, directed=False)[1].astype(np.int64)


# ---- which side is the front ---------------------------------------------------------------------


def _turned(
    mesh: Mesh, caster: RayCaster | None, pairs: _Pairs, normal: F8, double: F8,
    threads: int | None,
) -> F8:  # fmt: skip
    """(M,) 1, or -1 where a face's front is the other side than its winding says."""
    from belvedere.model import _chart_kernels

    count = len(normal)
    sign = np.ones(count)
    piece = np.arange(count, dtype=np.int64)
    # neighbours on a common piece are wound alike; folds in thin sheets are no neighbours
    usual = np.bincount(np.concatenate([pairs.one, pairs.two]), minlength=count) <= 3
    use = usual[pairs.one] & usual[pairs.two]
    _chart_kernels.wind_alike(pairs.one[use], pairs.two[use], pairs.opposed[use], piece, sign)
    kept = np.bincount(piece, double * sign, count)
    sign *= np.where(kept < 0.0, -1.0, 1.0)[piece]
    if caster is None:
        caster = RayCaster(mesh)
    face, point = _spread(mesh, piece, double)
    vote = _looks_inwards(caster, face, point, normal, sign, piece, threads)
    return sign * np.where(np.bincount(piece[face], vote, count) > 0.0, -1.0, 1.0)[piece]


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


def _looks_inwards(
    caster: RayCaster, face: I8, point: F8, normal: F8, sign: F8, piece: I8, threads: int | None
) -> F8:
    """(S,) 1 where a point's front looks into a solid and its back does not, -1 for the reverse."""
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
        seen = np.where(hits.face >= 0, hits.face, 0)
        itself = (hits.face >= 0) & (piece[seen] == np.repeat(piece[face], LOOKS))
        near.append(np.median(hits.t.reshape(-1, LOOKS), axis=1))
        own.append(itself.reshape(-1, LOOKS).mean(axis=1))

    def inside(front: int) -> B1:
        rear = 1 - front
        narrow = (near[front] < CLOSE_M) & (near[rear] > 2.0 * near[front])
        room = (near[rear] > CLOSE_M) & np.isfinite(near[rear])
        hollow = (own[rear] > 0.5) & (near[rear] < 2.0 * CLOSE_M)  # the rear is the solid
        return (narrow | room) & ~hollow

    return inside(0).astype(np.float64) - inside(1)


# ---- which faces share a chart -------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class _Flat:
    """Groups of coplanar faces that get one chart each."""

    corners: F8
    """(G, 4, 3) rectangles."""
    normal: F8
    """(G, 3)."""
    chart_of: I8
    """(M,) row of these, or -1 for faces that get a chart of their own."""
    st: F8
    """(M, 3, 2) where the faces' corners lie on the rectangles."""


def _flat_groups(corners: F8, normal: F8, double: F8, plane: I8, skin: I8) -> _Flat:
    count = int(plane.max()) + 1
    area = np.bincount(plane, double, count) / 2.0
    size = np.bincount(plane, minlength=count)
    whole = np.bincount(skin, minlength=int(skin.max()) + 1)
    first = np.unique(plane, return_index=True)[1]
    facet = (whole[skin[first]] > size) & (area < SMALL_M2)
    mean = np.stack([np.bincount(plane, double * normal[:, k], count) for k in range(3)], axis=1)
    mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-12)
    edge = np.roll(corners, -1, axis=1) - corners
    length = np.linalg.norm(edge, axis=2)
    longest = length.argmax(axis=1)
    order = np.lexsort((-length.max(axis=1), plane))
    lead = order[np.flatnonzero(np.diff(plane[order], prepend=-1))]  # the group's longest edge
    along = edge[lead, longest[lead]]
    along = along - np.einsum("ij,ij->i", along, mean)[:, None] * mean
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    up = np.cross(mean, along)
    origin = corners[first, 0]
    off = corners - origin[plane][:, None]
    axes = np.stack([along, up, mean], axis=1)[plane]
    local = np.einsum("fkc,fac->fka", off, axes)
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, plane, local.min(axis=1))
    np.maximum.at(high, plane, local.max(axis=1))
    good = ~facet & (area > 0.0) & (high[:, 2] - low[:, 2] < BUMP_M)
    spread = np.maximum(high - low, 1e-9)
    st = (local[..., :2] - low[plane][:, None, :2]) / spread[plane][:, None, :2]
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    level = 0.5 * (low[:, 2] + high[:, 2])
    place = low[:, None, :2] + square * spread[:, None, :2]
    rect = origin[:, None] + place[..., :1] * along[:, None] + place[..., 1:] * up[:, None]
    rect = rect + (level[:, None] * mean)[:, None]
    row = np.where(good, np.cumsum(good) - 1, -1)
    return _Flat(rect[good], mean[good], row[plane], st)


def _joined(
    mesh: Mesh, corners: F8, corner: I8, normal: F8, double: F8, skin: I8, flat: _Flat
) -> Charts:
    """Flat charts first, then one for each face that has none."""
    own = np.flatnonzero(flat.chart_of < 0)
    own = own[double[own] > 0.0]
    smooth = _corner_normals(corner, normal, double, skin, own)
    a, b, c = (corners[own, k] for k in range(3))
    away = np.einsum("ij,ij->i", np.cross(b - a, c - a), normal[own]) < 0.0
    order = np.where(away[:, None], [[0, 2, 1]], [[0, 1, 2]])  # counter-clockwise from the front
    p = np.take_along_axis(corners[own], order[..., None], axis=1)
    n = np.take_along_axis(smooth, order[..., None], axis=1)
    last = n[:, 1] + n[:, 2] - n[:, 0]
    last /= np.maximum(np.linalg.norm(last, axis=1, keepdims=True), 1e-12)
    quads = np.stack([p[:, 0], p[:, 1], p[:, 1] + p[:, 2] - p[:, 0], p[:, 2]], axis=1)
    quad_normals = np.stack([n[:, 0], n[:, 1], last, n[:, 2]], axis=1)
    base, total = len(flat.corners), len(flat.corners) + len(own)
    of_face = np.where(flat.chart_of >= 0, flat.chart_of, total)
    of_face[own] = base + np.arange(len(own))
    st = np.where((flat.chart_of >= 0)[:, None, None], flat.st, 0.0)
    half = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    turned = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]])
    st[own] = np.where(away[:, None, None], turned, half)
    first = np.full(total, -1, dtype=np.int64)
    seen = of_face < total
    first[of_face[seen][::-1]] = np.flatnonzero(seen)[::-1]
    parts = [flat.corners, quads]
    normals = [np.repeat(flat.normal[:, None], 4, axis=1), quad_normals]
    material = mesh.material_index[first]
    if not seen.all():  # faces without area: one chart without size for all of them
        odd = int(np.flatnonzero(~seen)[0])
        parts.append(np.repeat(corners[odd, :1], 4, axis=0)[None])
        normals.append(np.broadcast_to([0.0, 0.0, 1.0], (1, 4, 3)))
        material = np.append(material, mesh.material_index[odd])
    return Charts(
        np.concatenate(parts), np.concatenate(normals), material.astype(np.int32),
        of_face.astype(np.int32), st.astype(np.float32), np.zeros((0, 5)),
    )  # fmt: skip


def _corner_normals(corner: I8, normal: F8, double: F8, skin: I8, own: I8) -> F8:
    """(F, 3, 3) mean normals at the corners of faces: of the faces of one skin round a corner."""
    key = corner * (int(skin.max()) + 1) + skin[:, None]
    unique, place = np.unique(key.ravel(), return_inverse=True)
    place = place.reshape(-1)
    total = np.zeros((len(unique), 3))
    for k in range(3):
        weighted = np.repeat(double * normal[:, k], 3)
        total[:, k] = np.bincount(place, weighted, len(unique))
    total /= np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)
    mean = total[place.reshape(-1, 3)[own]]
    away = np.einsum("fkc,fc->fk", mean, normal[own]) < 0.3
    return np.where(away[..., None], normal[own][:, None], mean)
