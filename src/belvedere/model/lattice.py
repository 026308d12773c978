"""Lattices: where on each chart light is stored, and what it takes to keep it clean there."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from belvedere.ground.threads import run_parallel
from belvedere.model.charts import Charts

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
I8 = npt.NDArray[np.int64]
F8 = npt.NDArray[np.float64]

LIFT_M = 0.002
"""How far above its surface a point gathers."""
INSET_M = 0.012
"""How far from the edges of flat charts the outer points gather."""
NARROW_M = 0.02
"""A flat chart narrower than this has one row of lattice points along its middle."""


@dataclass(frozen=True, slots=True, eq=False)
class Lattice:
    """Points on each chart, row by row: index ``first[k] + j * shape[k, 0] + i``."""

    first: I4
    """(K,) index of each chart's first point."""
    shape: I4
    """(K, 2) points along s and along t."""

    @property
    def size(self) -> int:
        """How many points there are in all."""
        return int(self.shape.astype(np.int64).prod(axis=1).sum())


def make_lattice(
    charts: Charts, spacing: float, most: int, wanted: npt.NDArray[np.bool_] | None = None
) -> Lattice:
    """Points every ``spacing`` metres, two or more each way; one in all where not ``wanted``."""
    c = charts.corners
    along = np.maximum(
        np.linalg.norm(c[:, 1] - c[:, 0], axis=1), np.linalg.norm(c[:, 2] - c[:, 3], axis=1)
    )
    up = np.maximum(
        np.linalg.norm(c[:, 3] - c[:, 0], axis=1), np.linalg.norm(c[:, 2] - c[:, 1], axis=1)
    )
    steps = np.ceil(np.stack([along, up], axis=1) / spacing - 1e-6)
    shape = np.clip(steps, 1, most - 1).astype(np.int32) + 1
    narrow = np.stack([along, up], axis=1) < NARROW_M
    shape[narrow & ~charts.curved[:, None]] = 1
    if wanted is not None:
        shape[~wanted] = 1
    size = shape.astype(np.int64).prod(axis=1)
    first = np.concatenate([[0], np.cumsum(size)[:-1]]).astype(np.int32)
    return Lattice(first, shape)


def lattice_points(charts: Charts, lattice: Lattice) -> tuple[F4, F4, I4]:
    """(P, 3) positions just above the charts, (P, 3) normals, (P,) chart of each point.

    Where faces cover a chart in part only, points off them are moved to the nearest face.
    """
    from belvedere.model import _light_kernels

    points = np.empty((lattice.size, 3), dtype=np.float32)
    normals, chart = np.empty_like(points), np.empty(lattice.size, dtype=np.int32)
    _light_kernels.lattice_points(
        charts.corners, charts.normals, charts.curved, lattice.first, lattice.shape, LIFT_M,
        points, normals, chart,
    )  # fmt: skip
    if not charts.covered:
        s, t, _ = settled(charts, lattice)
        # off the edges of flat charts, where walls meet: a point in a corner would look past both
        inset = np.minimum(INSET_M / np.maximum(_sides(charts), 1e-6), 0.2)
        inset = np.where(charts.curved[:, None], 0.0, inset)[chart]
        s = np.clip(s, inset[:, 0], 1.0 - inset[:, 0])
        t = np.clip(t, inset[:, 1], 1.0 - inset[:, 1])
        weight = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=1)
        normals = np.einsum("pi,pic->pc", weight, charts.normals[chart]).astype(np.float32)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        points = np.einsum("pi,pic->pc", weight, charts.corners[chart]).astype(np.float32)
        points += np.float32(LIFT_M) * normals
    return points, normals, chart


def settled(charts: Charts, lattice: Lattice) -> tuple[F8, F8, npt.NDArray[np.bool_]]:
    """(P,) chart coordinates of each point on the chart's faces, and whether it is wanted at all.

    A point more than a step and a half from every face is never read.
    """
    from belvedere.model import _chart_kernels

    faces = np.argsort(charts.of_face, kind="stable").astype(np.int32)
    first = np.searchsorted(charts.of_face[faces], np.arange(len(charts.corners) + 1))
    sides = _sides(charts)
    s, t = np.empty(lattice.size), np.empty(lattice.size)
    near = np.empty(lattice.size, dtype=bool)
    starts = first.astype(np.int32)

    def settle(part: slice) -> None:
        _chart_kernels.settle_points(
            starts[part.start : part.stop + 1], faces, charts.st, sides[part],
            lattice.first[part], lattice.shape[part], s, t, near,
        )  # fmt: skip

    # pieces of about equal work: points times faces
    size = lattice.shape.prod(axis=1).astype(np.int64) * np.diff(first)
    pieces = np.unique(np.searchsorted(np.cumsum(size), np.linspace(0, size.sum(), 64)))
    edges = [0, *pieces[(pieces > 0) & (pieces < len(size))].tolist(), len(size)]
    run_parallel(settle, [slice(a, b) for a, b in pairwise(edges)], None)
    return s, t, near


def _sides(charts: Charts) -> F8:
    """(K, 2) metres along s and along t."""
    c = charts.corners
    return np.linalg.norm(np.stack([c[:, 1] - c[:, 0], c[:, 3] - c[:, 0]], axis=1), axis=2)


def shared_points(points: F4, normals: F4) -> tuple[I8, I8]:
    """Points that several charts of a curved surface share: one index each, and the way back."""
    grid = np.rint(np.concatenate([points * 2e4, normals * 100.0], axis=1)).astype(np.int64)
    key = np.zeros(len(grid), dtype=np.uint64)
    for k in range(6):  # FNV-1a over whole numbers
        key = (key ^ grid[:, k].view(np.uint64)) * np.uint64(0x100000001B3)
        key ^= key >> np.uint64(29)
    _, one, copies = np.unique(key, return_index=True, return_inverse=True)
    return one, copies


def blended(light: F4, copies: I8, joined: npt.NDArray[np.bool_]) -> F4:
    """(P, 3) light whose ``joined`` points take the mean of all points at the same place.

    Args:
        light: (P, 3).
        copies: (P,) from `shared_points`.
        joined: (P,) whether the point's chart is a piece of a larger surface.
    """
    result = light.copy()
    place = copies[joined]
    count = np.bincount(place)
    for channel in range(3):
        total = np.bincount(place, light[joined, channel])
        result[joined, channel] = (total / np.maximum(count, 1))[place]
    return result


def in_cutouts(charts: Charts, lattice: Lattice, chart: I4, place: I4) -> npt.NDArray[np.bool_]:
    """(P,) whether a point lies where its chart has no surface; ``place`` counts in its chart."""
    ns, nt = lattice.shape[chart, 0], lattice.shape[chart, 1]
    s, t = (place % ns) / np.maximum(ns - 1, 1), (place // ns) / np.maximum(nt - 1, 1)
    inside = np.zeros(len(chart), dtype=bool)
    for k, s0, t0, s1, t1 in charts.cutouts:
        inside |= (chart == int(k)) & (s > s0) & (s < s1) & (t > t0) & (t < t1)
    return inside


def smoothed(lattice: Lattice, valid: npt.NDArray[np.bool_], light: F4) -> F4:
    """(P, 3) light averaged over valid neighbours; points that are not valid take the nearest."""
    from belvedere.model import _light_kernels

    result = np.empty_like(light)
    _light_kernels.smooth_lattice(lattice.first, lattice.shape, valid, light, result)
    _light_kernels.fill_lattice(lattice.first, lattice.shape, result)
    return result
