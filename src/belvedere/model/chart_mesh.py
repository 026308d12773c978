"""Charts for any mesh, so that models from anywhere can be lit as the built-in houses are.

Faces that lie in one plane, touch and are of one material share a chart: the rectangle round them
in their plane. Every other face has one of its own, with normals that turn smoothly where its
neighbours do. Which side of a surface is lit is not asked of its winding alone, which models often
have wrong: see `belvedere.model.fronts`.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.model.charts import Charts
from belvedere.model.fronts import find_fronts
from belvedere.model.raycast import RayCaster
from belvedere.scene.mesh import Mesh

F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]

WELD_M = 1e-4
"""Corners nearer than this are one."""
FLAT_COSINE = 0.99996
"""Of half a degree: planes that differ by less are one."""
FLAT_M = 2e-3
"""Metres that two planes may lie apart and still be one."""
CREASE_COSINE = 0.77
"""Of forty degrees: edges that are sharper stay edges, others are shaded round."""
MOST_TOGETHER = 4096
"""Faces of one chart; a plane of more is cut."""

__all__ = ["charts_of"]


def charts_of(mesh: Mesh, caster: RayCaster, threads: int | None = None) -> Charts:
    """Where light is stored on a mesh.

    Args:
        mesh: any triangles.
        caster: of that mesh.
        threads: how many to use; None for as many as there are processors.

    Memory: some 400 bytes a face while it runs, 150 for each chart afterwards.
    """
    from belvedere.model import _chart_kernels

    corners = mesh.vertices[mesh.faces]
    welded = _welded(corners.reshape(-1, 3)).reshape(-1, 3)
    pair_a, pair_b = _across_edges(welded)
    fronts = find_fronts(mesh, welded, pair_a, pair_b, caster, threads)
    normals = mesh.normals() * fronts.sign[:, None]
    heights = np.einsum("ij,ij->i", normals, corners[:, 0])
    kind = np.where(normals.any(axis=1), mesh.material_index, -1 - np.arange(len(normals)))
    root = np.arange(len(normals), dtype=np.int32)
    _chart_kernels.flat_groups(
        pair_a, pair_b, normals, heights, kind.astype(np.int64), FLAT_COSINE, FLAT_M, root
    )
    members = np.bincount(root, minlength=len(root))
    together = members[root] > 1
    smooth = _smooth_normals(welded, corners, normals)
    order = np.argsort(root, kind="stable")
    starts = np.flatnonzero(np.diff(root[order], prepend=-1))
    starts = _cut_long(starts, len(order))
    of_face = np.empty(len(root), dtype=np.int32)
    of_face[order] = np.repeat(np.arange(len(starts)), np.diff(np.append(starts, len(order))))
    charts, st = _rectangles(corners, normals, welded, order, starts)
    alone = order[starts][~together[order[starts]]]
    _own_charts(charts, st, of_face, alone, corners, smooth, fronts.sign[alone] < 0.0)
    chart_corners, chart_normals = charts
    first = order[starts]
    bent = np.abs(chart_normals - chart_normals[:, :1]).max(axis=(1, 2)) > 1e-6
    return Charts(
        chart_corners, chart_normals, mesh.material_index[first].astype(np.int32), of_face,
        st.astype(np.float32), np.zeros((0, 5)), joined=bent, covered=False,
        two_sided=fronts.both[first],
    )  # fmt: skip


def _welded(points: F8) -> npt.NDArray[np.int64]:
    """(N,) the same number for points that lie together."""
    grid = np.rint(points / WELD_M).astype(np.int64)
    key = np.zeros(len(grid), dtype=np.uint64)
    for axis in range(3):  # FNV-1a over whole numbers
        key = (key ^ grid[:, axis].view(np.uint64)) * np.uint64(0x100000001B3)
        key ^= key >> np.uint64(29)
    return np.unique(key, return_inverse=True)[1].ravel()


def _across_edges(welded: npt.NDArray[np.int64]) -> tuple[I4, I4]:
    """Faces on the two sides of every edge; where more than two meet, each beside the next."""
    count = len(welded)
    a = np.concatenate([welded[:, 0], welded[:, 1], welded[:, 2]])
    b = np.concatenate([welded[:, 1], welded[:, 2], welded[:, 0]])
    face = np.tile(np.arange(count, dtype=np.int32), 3)
    low, high = np.minimum(a, b), np.maximum(a, b)
    order = np.lexsort((face, high, low))
    low, high, face = low[order], high[order], face[order]
    same = (low[1:] == low[:-1]) & (high[1:] == high[:-1]) & (face[1:] != face[:-1])
    return face[:-1][same], face[1:][same]


def _smooth_normals(welded: npt.NDArray[np.int64], corners: F8, normals: F8) -> F8:
    """(M, 3, 3) normal at each corner: the mean of the faces round it, unless there is a crease.

    Faces count by area. Those turned away by more than the crease's angle from the corner's own
    face are left out by comparing with the mean: a cheap test that keeps edges of boxes sharp.
    """
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    weighted = normals * area[:, None]
    total = np.zeros((int(welded.max(initial=-1)) + 1, 3))
    for c in range(3):
        for axis in range(3):
            total[:, axis] += np.bincount(welded[:, c], weighted[:, axis], len(total))
    mean = total[welded]
    length = np.linalg.norm(mean, axis=2, keepdims=True)
    mean = np.divide(mean, length, out=np.zeros_like(mean), where=length > 1e-12)
    near = np.einsum("fij,fj->fi", mean, normals) > CREASE_COSINE
    return np.where(near[..., None], mean, normals[:, None])


def _cut_long(starts: npt.NDArray[np.int64], total: int) -> npt.NDArray[np.int64]:
    """The same starts, and more inside groups that hold too many faces."""
    size = np.diff(np.append(starts, total))
    if size.max(initial=0) <= MOST_TOGETHER:
        return starts
    parts = [np.arange(s, s + n, MOST_TOGETHER) for s, n in zip(starts, size, strict=True)]
    return np.concatenate(parts)


def _rectangles(
    corners: F8,
    normals: F8,
    welded: npt.NDArray[np.int64],
    order: npt.NDArray[np.int64],
    starts: npt.NDArray[np.int64],
) -> tuple[tuple[F8, F8], F8]:
    """The rectangle round each group of faces, along its longest outer edge; chart coordinates."""
    count = len(starts)
    size = np.diff(np.append(starts, len(order)))
    group = np.repeat(np.arange(count), size)
    points = corners[order]
    edges = np.roll(points, -1, axis=1) - points
    length = np.linalg.norm(edges, axis=2)
    length = np.where(_inner_edges(welded[order], group), 1e-6 * length, length)
    best = np.argmax(length, axis=1)
    longest = length[np.arange(len(order)), best]
    # the first face of each group that has its longest edge
    top = np.maximum.reduceat(longest, starts)
    is_top = np.flatnonzero(longest >= top[group])
    _, first = np.unique(group[is_top], return_index=True)
    chosen = is_top[first]
    along = edges[chosen, best[chosen]]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    normal = normals[order[chosen]]
    up = np.cross(normal, along)
    base = points[chosen, 0]
    relative = points - base[group][:, None]
    x = np.einsum("fij,fj->fi", relative, along[group])
    y = np.einsum("fij,fj->fi", relative, up[group])
    x0, x1 = np.minimum.reduceat(x.min(1), starts), np.maximum.reduceat(x.max(1), starts)
    y0, y1 = np.minimum.reduceat(y.min(1), starts), np.maximum.reduceat(y.max(1), starts)
    wide, high = np.maximum(x1 - x0, 1e-6), np.maximum(y1 - y0, 1e-6)
    st = np.empty((len(order), 3, 2))
    st[order, :, 0] = (x - x0[group][:, None]) / wide[group][:, None]
    st[order, :, 1] = (y - y0[group][:, None]) / high[group][:, None]
    corner = base + x0[:, None] * along + y0[:, None] * up
    s, t = wide[:, None] * along, high[:, None] * up
    rectangle = np.stack([corner, corner + s, corner + s + t, corner + t], axis=1)
    return (rectangle, np.repeat(normal[:, None], 4, axis=1)), st


def _inner_edges(
    welded: npt.NDArray[np.int64], group: npt.NDArray[np.int64]
) -> npt.NDArray[np.bool_]:
    """(M, 3) whether the edge from each corner to the next lies between two faces of one group."""
    after = np.roll(welded, -1, axis=1)
    low, high = np.minimum(welded, after).ravel(), np.maximum(welded, after).ravel()
    owner = np.repeat(group, 3)
    rank = np.lexsort((high, low, owner))
    key = np.stack([owner, low, high])[:, rank]
    same = (key[:, 1:] == key[:, :-1]).all(axis=0)
    inner = np.zeros(len(rank), dtype=bool)
    inner[rank[1:]] |= same
    inner[rank[:-1]] |= same
    return inner.reshape(-1, 3)


def _own_charts(
    charts: tuple[F8, F8], st: F8, of_face: I4, alone: npt.NDArray[np.int64], corners: F8,
    smooth: F8, turned: npt.NDArray[np.bool_],
) -> None:  # fmt: skip
    """Charts of single faces: the parallelogram over their corners, which share their normals.

    Where ``turned``, the corners run the other way round, so that the front is the front.
    """
    if not len(alone):
        return
    rectangle, normals = charts
    order = np.where(turned[:, None], [[0, 2, 1]], [[0, 1, 2]])[..., None]
    a, b, c = np.take_along_axis(corners[alone], order, axis=1).transpose(1, 0, 2)
    k = of_face[alone]
    rectangle[k] = np.stack([a, b, b + c - a, c], axis=1)
    n = np.take_along_axis(smooth[alone], order, axis=1)
    fourth = n[:, 1] + n[:, 2]
    fourth /= np.maximum(np.linalg.norm(fourth, axis=1, keepdims=True), 1e-12)
    normals[k] = np.stack([n[:, 0], n[:, 1], fourth, n[:, 2]], axis=1)
    half, other = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]
    st[alone] = np.where(turned[:, None, None], other, half)
