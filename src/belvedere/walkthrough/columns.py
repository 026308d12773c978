"""A building as columns of solid spans, and the layers of floors between them.

    z |   ______        A column over every square of the plan; what the triangles fill of it is a
      |  |::::::|       short list of spans, sorted and joined. A gap of at least a person's height
      |  |      | gap   above a span is a place on a floor; at one (x, y) there may be several.
      |  |______|
      |  |::::::| span
      +------------ x

Like the voxels it stands for, but with exact heights, and its size follows the surfaces, not the
volume.

Source: spans and their neighbours after Mononen's Recast (2009).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_number
from belvedere.ground.errors import SceneError
from belvedere.scene.mesh import Mesh

A = npt.NDArray[Any]
F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]
Mask = npt.NDArray[np.bool_]

MAX_SIDE_M = 2000.0
"""No building is longer: a larger number is one of millimetres."""
MIN_SIDE_M = 1.0
MAX_COLUMNS = 10_000_000
MAX_SPANS = 60_000_000
"""A gigabyte of them."""
JOIN_M = 0.02
"""Gaps this small between spans are slits of the modelling, no air."""

LEAST_ROOM_M2 = 0.8
"""Any floor smaller than this, and not joined to more, is a shaft, a cupboard or a table."""
LEAST_WIDTH_M = 0.25
"""A room holds a circle of this radius; hollow walls do not."""

__all__ = ["Columns", "Grid", "Layers", "link_layers", "standing_layers", "worth_standing"]


@dataclass(frozen=True, slots=True)
class Grid:
    """Squares over a plan."""

    origin: tuple[float, float, float]
    """World position of the corner; heights inside the room count from its z."""
    spacing: float
    """Side of a square, metres."""
    nx: int
    """Squares along x."""
    ny: int
    """Squares along y."""

    def centers(self, column: A) -> F8:
        """(N, 2) middles of columns, metres from the corner."""
        return (np.stack([column % self.nx, column // self.nx], axis=-1) + 0.5) * self.spacing


@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """Solid spans of every column."""

    grid: Grid
    """The squares."""
    first: npt.NDArray[np.int64]
    """(nx * ny + 1,) where each column's spans begin."""
    low: F8
    """(S,) lower ends, metres above the grid's corner."""
    high: F8
    """(S,) upper ends."""
    up: npt.NDArray[np.bool_]
    """(S,) whether the topmost surface shows its front to the sky."""

    @classmethod
    def of_mesh(cls, mesh: Mesh, spacing: float = 0.05) -> Columns:
        """Cut a mesh into columns.

        Raises:
            SceneError: nothing in it, or it is too large or small for a building in metres.
            InputError: the spacing is not from 1 cm to 1 m.
        """
        spacing = check_number("Columns", "spacing", spacing, 0.01, 1.0)
        grid, local = _place_grid(mesh, spacing)
        normal = np.cross(local[:, 1] - local[:, 0], local[:, 2] - local[:, 0])
        upward = normal[:, 2] > 0.0
        return _fill(grid, local, upward)


def _place_grid(mesh: Mesh, spacing: float) -> tuple[Grid, F8]:
    if not len(mesh.faces):
        raise SceneError("The model has no faces: there is no building in it")
    corners = mesh.vertices[mesh.faces]
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    size = high - low
    if size.max() > MAX_SIDE_M:
        raise SceneError(
            f"The model is {size[0]:.6g} x {size[1]:.6g} x {size[2]:.6g} m large, which is no "
            "building: is it in millimetres? Say so (--units mm) or scale it by 0.001; or leave "
            "out what lies far away"
        )
    if max(size[0], size[1]) < MIN_SIDE_M:
        raise SceneError(
            f"The model is {size[0]:.3g} x {size[1]:.3g} x {size[2]:.3g} m large, too small to "
            "walk in: say what its unit is (--units), or scale it to metres"
        )
    # a corner that no wall on round numbers falls upon
    start = low - np.array([1.37 * spacing, 1.37 * spacing, 0.0])
    nx, ny = (int(n) for n in np.floor((high - start)[:2] / spacing) + 3)
    if nx * ny > MAX_COLUMNS:
        fit = math.sqrt((size[0] + 1) * (size[1] + 1) / MAX_COLUMNS)
        raise SceneError(
            f"The model covers {size[0]:.0f} x {size[1]:.0f} m: {nx * ny:,} columns at "
            f"{spacing:g} m. Give a spacing of {math.ceil(fit * 110) / 100:g} m or more, or cut "
            "the model"
        )
    origin = (float(start[0]), float(start[1]), float(start[2]))
    return Grid(origin, spacing, nx, ny), np.ascontiguousarray(corners - start)


def _fill(grid: Grid, local: F8, upward: A) -> Columns:
    from belvedere.walkthrough._span_kernels import merge_spans, touch_columns

    count = grid.nx * grid.ny
    first = np.zeros(count + 1, dtype=np.int64)
    none, no = np.zeros(0), np.zeros(0, dtype=bool)
    args = (local, upward, grid.spacing, grid.nx, grid.ny)
    touch_columns(*args, False, first, none, none, no)
    np.cumsum(first, out=first)
    if first[-1] > MAX_SPANS:
        raise SceneError(
            f"The model's surfaces cross {first[-1]:,} columns of {grid.spacing:g} m, more than "
            f"{MAX_SPANS:,}: give a larger spacing, or cut the model"
        )
    low, high = np.empty(first[-1]), np.empty(first[-1])
    up = np.empty(first[-1], dtype=bool)
    touch_columns(*args, True, first.copy(), low, high, up)
    kept = np.empty(count, dtype=np.int64)
    merge_spans(first, JOIN_M, low, high, up, kept)
    stay = np.arange(first[-1]) - np.repeat(first[:-1], np.diff(first)) < np.repeat(
        kept, np.diff(first)
    )
    packed = np.concatenate([[0], np.cumsum(kept)])
    return Columns(grid, packed, low[stay], high[stay], up[stay])


@dataclass(frozen=True, slots=True, eq=False)
class Layers:
    """Places on floors, each with its neighbours: a plan with as many storeys as there are."""

    grid: Grid
    """The squares."""
    column: I4
    """(N,) which square; ascending."""
    floor: F8
    """(N,) metres above the grid's corner."""
    ceiling: F8
    """(N,) the next solid above; inf under the open sky."""
    link: I4
    """(N, 4) the places next to it towards -x, +x, -y, +y, or -1 where the way is blocked."""

    @property
    def centers(self) -> F8:
        """(N, 2) middles, metres from the grid's corner."""
        return self.grid.centers(self.column)

    def first(self) -> npt.NDArray[np.int64]:
        """(nx * ny + 1,) where each column's places begin."""
        return np.searchsorted(self.column, np.arange(self.grid.nx * self.grid.ny + 1))

    def distance(self) -> F8:
        """(N,) metres from each place's middle to the nearest thing in the way."""
        from belvedere.walkthrough._span_kernels import nearest_blocks

        far = np.empty(len(self.column))
        block = np.zeros((len(self.column), 2), dtype=np.int32)
        nearest_blocks(self.column, self.link, self.grid.nx, self.grid.spacing, block, far)
        return far

    def label(self, cut: npt.NDArray[np.bool_] | None = None) -> tuple[I4, int]:
        """(N,) number of the connected set each place belongs to, and how many there are.

        Args:
            cut: (N, 4) links that are closed.
        """
        from belvedere.walkthrough._span_kernels import label_floors

        label = np.full(len(self.column), -1, dtype=np.int32)
        closed = np.zeros(self.link.shape, dtype=bool) if cut is None else cut
        count = label_floors(self.link, closed, label, np.empty(len(label), dtype=np.int32))
        return label, count

    def take(self, keep: npt.NDArray[np.bool_]) -> Layers:
        """Only some of the places."""
        place = np.where(keep, np.cumsum(keep) - 1, -1).astype(np.int32)
        link = np.where(self.link >= 0, place[self.link], -1)[keep]
        return Layers(
            self.grid,
            self.column[keep],
            self.floor[keep],
            self.ceiling[keep],
            link.astype(np.int32),
        )


def standing_layers(columns: Columns, head: float, step: float) -> tuple[Layers, A]:
    """Where a person can stand, and for each place whether its floor shows its front.

    Args:
        columns: the building.
        head: free height that a person needs, metres.
        step: height that a person climbs, metres.
    """
    from belvedere.walkthrough._span_kernels import find_floors

    count = columns.grid.nx * columns.grid.ny
    first = np.zeros(count + 1, dtype=np.int64)
    none, no = np.zeros(0), np.zeros(0, dtype=bool)
    spans = (columns.first, columns.low, columns.high, columns.up, head)
    find_floors(*spans, False, first, none, none, no)
    total = int(first[-1])
    floor, ceiling, up = np.empty(total), np.empty(total), np.empty(total, dtype=bool)
    find_floors(*spans, True, first, floor, ceiling, up)
    column = np.repeat(np.arange(count, dtype=np.int32), np.diff(first))
    return link_layers(columns.grid, column, floor, ceiling, step, head), up


def link_layers(grid: Grid, column: A, floor: F8, ceiling: F8, step: float, head: float) -> Layers:
    """Layers of places (sorted by column) joined where a person can step across."""
    from belvedere.walkthrough._span_kernels import link_floors, mend_links

    first = np.searchsorted(column, np.arange(grid.nx * grid.ny + 1)).astype(np.int64)
    link = np.empty((len(column), 4), dtype=np.int32)
    link_floors(column, first, floor, ceiling, grid.nx, grid.ny, step, head, link)
    mend_links(link)
    return Layers(grid, column, floor, ceiling, link)


def worth_standing(layers: Layers, front: Mask) -> Mask:
    """(N,) places that are floors: not table tops, hollow walls and insides of closed solids.

    Args:
        layers: where a person could stand.
        front: (N,) whether the floor shows its front there.
    """
    label, count = layers.label()
    square = layers.grid.spacing**2
    area = (np.bincount(label, minlength=count) * square).astype(np.float64)
    widest = np.zeros(count)
    np.maximum.at(widest, label, layers.distance())
    fronts = np.bincount(label, weights=front, minlength=count) * square / area
    # floors that show their fronts are the rule in a model that minds fronts at all
    minds = (area * fronts).sum() > 0.7 * area.sum()
    good = (area >= LEAST_ROOM_M2) & (widest >= LEAST_WIDTH_M)
    if minds:
        good &= fronts > 0.3
    good &= ~_on_furniture(layers, label, count, area)
    return good[label]


def _on_furniture(layers: Layers, label: I4, count: int, area: F8) -> Mask:
    """(count,) sets of places that look down over their edges on a larger floor close below."""
    grid = layers.grid
    first = layers.first()
    edge, drop = np.zeros(count), np.zeros(count)
    for d, shift in enumerate((-1, 1, -grid.nx, grid.nx)):
        lone = np.flatnonzero(layers.link[:, d] < 0)
        to = np.clip(layers.column[lone] + shift, 0, grid.nx * grid.ny - 1)
        low = np.full(len(lone), -1)
        for k in range(3):  # the places of the column beside, from below
            place = first[to] + k
            there = place < first[to + 1]
            place = np.where(there, place, 0)
            rise = layers.floor[lone] - layers.floor[place]
            falls = there & (rise > 0.05) & (rise < 1.5)
            low = np.where(falls, place, low)
        bigger = (low >= 0) & (area[label[low]] > 2.0 * area[label[lone]])
        edge += np.bincount(label[lone], minlength=count)
        drop += np.bincount(label[lone], weights=bigger, minlength=count)
    return (drop > 0.25 * edge) & (area < 12.0)
