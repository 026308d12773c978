"""Which polygons belong to which cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_number
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough.cells import OUTSIDE, Cell, CellGraph, enclosed

F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]

MARGIN_M = 0.3
"""A cell owns what reaches into it or comes this near: its walls, and the linings of its doors."""
STEP_M = 0.05
"""Width of the squares in which outlines are looked up."""
MOST_SQUARES = 1 << 24
"""Squares of one cell's look-up at most; a larger cell gets larger squares."""

__all__ = ["CellContents", "contents_of"]


@dataclass(frozen=True, slots=True, eq=False)
class CellContents:
    """Face indices by cell."""

    of_cell: tuple[I4, ...]
    """For each cell its faces in rising order; one face may belong to several cells."""
    outside: I4
    """The faces that can be seen from outside: all but those wholly within one cell."""

    def faces(self, cell: int) -> I4:
        """Those of a cell, or of `OUTSIDE`."""
        return self.outside if cell == OUTSIDE else self.of_cell[cell]


def contents_of(mesh: Mesh, graph: CellGraph, margin: float = MARGIN_M) -> CellContents:
    """Hand out the faces of a mesh to the cells they reach into.

    No face that can be seen inside a cell is missing from it: a face counts by the box round it,
    so a large slanting one may be in too many cells, never in too few.

    Args:
        mesh: all of the building.
        graph: its cells.
        margin: metres beyond the outline, the floor and the ceiling that still belong.

    Raises:
        InputError: the margin is negative or not finite.

    Memory: 56 bytes a face while it runs, 4 for each cell that a face belongs to.
    """
    margin = check_number("contents_of", "margin", margin, 0.0)
    corners = mesh.vertices[mesh.faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    del corners
    lists, inner = [], np.zeros(len(mesh.faces), dtype=bool)
    for cell in graph.cells:
        near = _overlapping(low, high, cell.low - margin, cell.high + margin)
        if not _is_box(cell):
            near = near[_touches(cell, margin, low[near], high[near])]
        lists.append(near.astype(np.int32))
        held = near[np.all(low[near] >= cell.low, axis=1) & np.all(high[near] <= cell.high, axis=1)]
        if not _is_box(cell):
            held = held[~_reaches_out(cell, low[held], high[held])]
        inner[held] = True
    return CellContents(tuple(lists), np.flatnonzero(~inner).astype(np.int32))


def _overlapping(low: F8, high: F8, box_low: F8, box_high: F8) -> npt.NDArray[np.int64]:
    apart = np.zeros(len(low), dtype=bool)
    for c in range(3):
        apart |= low[:, c] > box_high[c]
        apart |= high[:, c] < box_low[c]
    return np.flatnonzero(~apart)


def _is_box(cell: Cell) -> bool:
    """Whether the cell's outline is one upright rectangle along the axes."""
    if len(cell.rings) != 1 or len(cell.rings[0]) != 4:
        return False
    ring = cell.rings[0]
    return all(len(np.unique(ring[:, c])) == 2 for c in range(2))


def _touches(cell: Cell, margin: float, low: F8, high: F8) -> npt.NDArray[np.bool_]:
    """Which boxes come within ``margin`` of the outline or what it encloses."""
    from scipy.ndimage import distance_transform_edt

    grid, origin, step = _squares(cell, margin + 2.0 * STEP_M)
    away = np.asarray(distance_transform_edt(~grid)) * step
    # a point of a square lies at most half a diagonal from its middle, on both ends
    return _any_within(away <= margin + 1.5 * step, origin, step, low, high)


def _reaches_out(cell: Cell, low: F8, high: F8) -> npt.NDArray[np.bool_]:
    """Which boxes hold a point that the outline does not enclose."""
    grid, origin, step = _squares(cell, STEP_M)
    return _any_within(~grid, origin, step, low, high)


def _squares(cell: Cell, border: float) -> tuple[npt.NDArray[np.bool_], F8, float]:
    """The outline on a grid [y, x] of squares: whether their middles are inside."""
    low, high = cell.low[:2] - border, cell.high[:2] + border
    step = max(STEP_M, float(np.sqrt(np.prod(high - low) / MOST_SQUARES)))
    nx, ny = (int(n) + 1 for n in np.ceil((high - low) / step))
    x = low[0] + (np.arange(nx) + 0.5) * step
    y = low[1] + (np.arange(ny) + 0.5) * step
    inside = np.stack([enclosed(cell.rings, x, np.full(nx, value)) for value in y])
    return inside, low, step


def _any_within(
    marked: npt.NDArray[np.bool_], origin: F8, step: float, low: F8, high: F8
) -> npt.NDArray[np.bool_]:
    """Which boxes hold a marked square, by the sums of all squares up to each corner."""
    ny, nx = marked.shape
    sums = np.zeros((ny + 1, nx + 1), dtype=np.int64)
    np.cumsum(np.cumsum(marked, axis=0), axis=1, out=sums[1:, 1:])
    first = np.floor((low[:, :2] - origin) / step).astype(np.int64)
    last = np.floor((high[:, :2] - origin) / step).astype(np.int64) + 1
    x0, x1 = (np.clip(value[:, 0], 0, nx) for value in (first, last))
    y0, y1 = (np.clip(value[:, 1], 0, ny) for value in (first, last))
    return sums[y1, x1] - sums[y0, x1] - sums[y1, x0] + sums[y0, x0] > 0
