"""Charts for any mesh, so that models from anywhere can be lit as the built-in houses are.

Faces that lie in one plane, touch and are of one material share a chart: the rectangle round them
in their plane. Every other face has one of its own, with normals that turn smoothly where its
neighbours do. Which side of a surface is lit is not asked of its winding, which models often have
wrong, but of the free space before it.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.model.charts import Charts
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
PROBES = 12
"""Rays on each side of a chart that ask which side is open."""
PROBE_M = 4.0
"""What is farther off than this is open."""
OPEN_ALIKE = 0.5
"""A surface whose darker side is at least this open, beside the other, is seen from both."""
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
    normals = mesh.normals()
    welded = _welded(corners.reshape(-1, 3)).reshape(-1, 3)
    pair_a, pair_b = _across_edges(welded)
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
    charts, st = _rectangles(corners, normals, order, starts)
    alone = order[starts][~together[order[starts]]]
    _own_charts(charts, st, of_face, alone, corners, smooth)
    chart_corners, chart_normals = charts
    material = mesh.material_index[order[starts]]
    turned, both = _open_sides(chart_corners, chart_normals, caster, of_face, corners, threads)
    flip = np.flatnonzero(turned)
    # seen from the other side the corners run the other way: 0 1 2 3 becomes 1 0 3 2
    chart_corners[flip] = chart_corners[flip][:, [1, 0, 3, 2]]
    chart_normals[flip] = -chart_normals[flip][:, [1, 0, 3, 2]]
    st[..., 0] = np.where(turned[of_face][:, None], 1.0 - st[..., 0], st[..., 0])
    return Charts(
        chart_corners, chart_normals, material.astype(np.int32), of_face,
        st.astype(np.float32), np.zeros((0, 5)), covered=False, two_sided=both,
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
    corners: F8, normals: F8, order: npt.NDArray[np.int64], starts: npt.NDArray[np.int64]
) -> tuple[tuple[F8, F8], F8]:
    """The rectangle round each group of faces, along its longest edge; chart coordinates."""
    count = len(starts)
    size = np.diff(np.append(starts, len(order)))
    group = np.repeat(np.arange(count), size)
    points = corners[order]
    edges = np.roll(points, -1, axis=1) - points
    length = np.linalg.norm(edges, axis=2)
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


def _own_charts(
    charts: tuple[F8, F8], st: F8, of_face: I4, alone: npt.NDArray[np.int64], corners: F8,
    smooth: F8,
) -> None:  # fmt: skip
    """Charts of single faces: the parallelogram over their corners, which share their normals."""
    if not len(alone):
        return
    rectangle, normals = charts
    a, b, c = corners[alone, 0], corners[alone, 1], corners[alone, 2]
    k = of_face[alone]
    rectangle[k] = np.stack([a, b, b + c - a, c], axis=1)
    n = smooth[alone]
    fourth = n[:, 1] + n[:, 2]
    fourth /= np.maximum(np.linalg.norm(fourth, axis=1, keepdims=True), 1e-12)
    normals[k] = np.stack([n[:, 0], n[:, 1], fourth, n[:, 2]], axis=1)
    st[alone] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]


def _open_sides(
    chart_corners: F8, chart_normals: F8, caster: RayCaster, of_face: I4, corners: F8,
    threads: int | None,
) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:  # fmt: skip
    """Which charts are open on their back rather than their front, and which on both sides.

    Rays leave the middle of each chart's first face; how far they get, up to `PROBE_M`, tells.
    """
    _, first = np.unique(of_face, return_index=True)
    middle = corners[first].mean(axis=1)
    normal = chart_normals.mean(axis=1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    k = np.arange(PROBES) + 0.5
    z, angle = 1.0 - 0.9 * k / PROBES, 2.399963 * k
    ring = np.sqrt(1.0 - z * z)
    side = np.cross(normal, np.where(np.abs(normal[:, 2:]) < 0.9, [[0, 0, 1.0]], [[1.0, 0, 0]]))
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-12)
    other = np.cross(normal, side)
    reach = np.zeros((2, len(normal)))
    for j in range(PROBES):
        across = ring[j] * (np.cos(angle[j]) * side + np.sin(angle[j]) * other)
        for way, sign in enumerate((1.0, -1.0)):
            along = z[j] * sign * normal + across
            along[~along.any(axis=1)] = [0.0, 0.0, 1.0]  # a chart without area: any way
            start = middle + 1e-3 * sign * normal
            hit = caster.cast(start, along, threads)
            reach[way] += np.minimum(hit.t, PROBE_M)
    front, back = reach / (PROBES * PROBE_M)
    turned = back > 1.5 * front + 0.02
    both = np.minimum(front, back) > OPEN_ALIKE * np.maximum(front, back)
    return turned, both
