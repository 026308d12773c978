"""Cells and portals: the rooms of a building and the rectangles through which they see each other.

A cell is an upright prism of space; a portal is a rectangle that joins two cells, or a cell and the
outside. Together they are a graph, and everything the walkthrough does follows its edges.

Source: Rafferty, Aliaga and Lastra 1998; spec portal-walkthrough 2.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import SceneError
from belvedere.model.building import OpeningKind

F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]

OUTSIDE = -1
"""The index that stands for everything outside all cells."""

__all__ = ["OUTSIDE", "Cell", "CellGraph", "Portal"]


@dataclass(frozen=True, slots=True, eq=False)
class Cell:
    """A room, as visibility knows it."""

    name: str
    """Shown on plans and in reports; unique in its graph."""
    rings: tuple[F8, ...]
    """(N, 2) outlines, metres; inside is where an odd number of rings encloses a point."""
    floor: float
    """Height of the lowest floor, metres."""
    ceiling: float
    """Height of the highest ceiling, metres."""
    storey: int = 0
    """0 for the lowest; where its floor plan is drawn."""

    @property
    def low(self) -> F8:
        """(3,) smallest x, y, z."""
        return np.array([*np.concatenate(self.rings).min(axis=0), self.floor])

    @property
    def high(self) -> F8:
        """(3,) largest x, y, z."""
        return np.array([*np.concatenate(self.rings).max(axis=0), self.ceiling])

    def contains(self, points: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Which of (N, 3) points lie in the cell."""
        p = np.asarray(points, dtype=np.float64)
        return (
            enclosed(self.rings, p[:, 0], p[:, 1])
            & (p[:, 2] >= self.floor)
            & (p[:, 2] <= self.ceiling)
        )


@dataclass(frozen=True, slots=True, eq=False)
class Portal:
    """A rectangle between two cells."""

    name: str
    """Shown on plans and in reports; unique in its graph."""
    kind: OpeningKind
    """Windows are looked through, doors and openings walked through too."""
    corners: F8
    """(4, 3) world positions, metres, counter-clockwise when seen from ``cells[0]``."""
    cells: tuple[int, int]
    """The two cells; the second may be `OUTSIDE`."""

    def __post_init__(self) -> None:
        corners = np.ascontiguousarray(self.corners, dtype=np.float64)
        object.__setattr__(self, "corners", corners)
        if corners.shape != (4, 3) or not np.isfinite(corners).all():
            raise SceneError(f"Portal {self.name!r}: corners must be four finite points")
        sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
        if sides.min() < 1e-3:
            raise SceneError(f"Portal {self.name!r} is a line, not a rectangle: {corners.tolist()}")
        off = np.abs((corners - self.center) @ self.normal).max()
        if off > 0.02 * sides.max():
            raise SceneError(f"Portal {self.name!r} is not flat: a corner lies {off:.3f} m off")

    @property
    def center(self) -> F8:
        """(3,) the middle."""
        return self.corners.mean(axis=0)

    @property
    def normal(self) -> F8:
        """(3,) unit normal, into ``cells[0]``."""
        c = self.corners
        normal = np.cross(c[2] - c[0], c[3] - c[1])
        return normal / np.linalg.norm(normal)

    @property
    def walkable(self) -> bool:
        """Whether people walk through it."""
        return self.kind != "window"

    def beyond(self, cell: int) -> int:
        """The cell on the other side."""
        return self.cells[1] if self.cells[0] == cell else self.cells[0]


@dataclass(frozen=True, eq=False)
class CellGraph:
    """All cells and portals of a building."""

    cells: tuple[Cell, ...]
    """At least one."""
    portals: tuple[Portal, ...]
    """Every portal names one or two cells of the graph."""

    def __post_init__(self) -> None:
        for what, members in (("cells", self.cells), ("portals", self.portals)):
            names = [member.name for member in members]
            twice = sorted({name for name in names if names.count(name) > 1})
            if twice:
                raise SceneError(f"CellGraph: several {what} are called {twice[0]!r}")
        for portal in self.portals:
            first, second = portal.cells
            inside = range(len(self.cells))
            if first not in inside or (second not in inside and second != OUTSIDE):
                raise SceneError(
                    f"Portal {portal.name!r} joins cells {first} and {second}, but there are "
                    f"{len(self.cells)} (the second may be {OUTSIDE} for outside)"
                )
            if first == second:
                raise SceneError(f"Portal {portal.name!r} joins cell {first} with itself")

    @cached_property
    def portals_of(self) -> tuple[tuple[int, ...], ...]:
        """For each cell the indices of its portals."""
        return tuple(
            tuple(k for k, portal in enumerate(self.portals) if cell in portal.cells)
            for cell in range(len(self.cells))
        )

    @cached_property
    def _boxes(self) -> tuple[F8, F8]:
        """(C, 3) smallest and largest coordinates of the cells."""
        return np.array([c.low for c in self.cells]), np.array([c.high for c in self.cells])

    def neighbours(self, cell: int, walking: bool = False) -> Iterator[tuple[int, int]]:
        """(portal, cell beyond) for each portal of a cell; ``walking``: doors and openings only."""
        for index in self.portals_of[cell]:
            portal = self.portals[index]
            if portal.walkable or not walking:
                yield index, portal.beyond(cell)

    def cells_at(self, points: npt.ArrayLike) -> I4:
        """(N,) which cell each of (N, 3) points lies in, or `OUTSIDE`.

        Where cells overlap (a stair under a landing) the one whose floor is next below wins.
        """
        p = np.atleast_2d(np.asarray(points, dtype=np.float64))
        found = np.full(len(p), OUTSIDE, dtype=np.int32)
        height = np.full(len(p), -np.inf)
        low, high = self._boxes
        near = np.ones((len(low), len(p)), dtype=bool)
        for c in range(3):
            near &= (p[:, c] >= low[:, c, None]) & (p[:, c] <= high[:, c, None])
        for index in np.flatnonzero(near.any(axis=1)):
            cell, some = self.cells[index], np.flatnonzero(near[index])
            better = some[cell.contains(p[some]) & (cell.floor > height[some])]
            found[better] = index
            height[better] = cell.floor
        return found


def enclosed(rings: tuple[F8, ...], x: F8, y: F8) -> npt.NDArray[np.bool_]:
    """Which of the points (x, y) an odd number of rings encloses (the crossing count)."""
    inside = np.zeros(np.shape(x), dtype=bool)
    for ring in rings:
        after = np.roll(ring, -1, axis=0)
        for (x0, y0), (x1, y1) in zip(ring, after, strict=True):
            if y0 == y1:
                continue
            crosses = (y0 <= y) != (y1 <= y)
            share = np.divide(y - y0, y1 - y0, out=np.zeros(np.shape(y)), where=crosses)
            inside ^= crosses & (x < x0 + share * (x1 - x0))
    return inside
