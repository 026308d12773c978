"""What an eye sees of a building: the cells it looks into, and through which portals.

Sight starts in the cell the eye is in. Each portal is cut to the frustum; what is left of it is a
narrower frustum, through which the next cell's portals are looked at in turn, until nothing is
left. The answer holds every cell that has a visible surface, and some that turn out to be hidden
by what stands in the rooms::

    +-------------+-------------+
    |   A         |       B     |        eye in A: A, B through p,
    |  eye  <---- p ----        |        C through p and q
    |             |     '----.  |
    +-------------+----------q--+
                  |        C    |

A straight line crosses a plane once, so no chain of portals passes one twice, and the search ends.

Outlines may reach through a portal, as an attic's do into the well of a skylight. An eye there is
in the attic by its outline and sees the hall below; so an eye behind a portal of its own cell, as
near as a wall is thick, looks into both.

Source: spec portal-walkthrough 3.1; the guard against cycles is derived there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_number
from belvedere.ground.errors import CameraError, InputError
from belvedere.scene import Camera
from belvedere.walkthrough.cells import OUTSIDE, CellGraph

F8 = npt.NDArray[np.float64]

NEAR_M = 0.02
"""An eye this close to a portal's plane sees all that lies beyond: the clipped portal would be a
line, and its planes noise."""
MOST_SIGHTS = 4096
"""Chains of portals in one picture; more of them is no building."""

__all__ = ["Sight", "Visibility", "view_cell"]


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """One cell seen through one chain of portals."""

    cell: int
    """Index, or `OUTSIDE`."""
    portal: int
    """The last portal of the chain; -1 for the cell the eye is in."""
    chain: tuple[int, ...]
    """All portals of the chain, the nearest first."""
    planes: F8
    """(K, 3) normals of planes through the eye, pointing inwards: the frustum that is left."""
    polygon: F8
    """(N, 3) corners of what is left of the portal, relative to the eye; none if the eye stands in
    the portal, or for the cell the eye is in."""


class Visibility:
    """Looks through the portals of one graph; kept arrays make each look quick."""

    def __init__(self, graph: CellGraph) -> None:
        self.graph = graph
        portals = graph.portals
        count = len(portals)
        self.corners = np.array([p.corners for p in portals]).reshape(count, 4, 3)
        self.normals = np.array([p.normal for p in portals]).reshape(count, 3)
        self.joins = np.array([p.cells for p in portals], dtype=np.int32).reshape(count, 2)
        lists = [[k for k, p in enumerate(portals) if cell in p.cells]
                 for cell in (*range(len(graph.cells)), OUTSIDE)]  # fmt: skip
        self._first = np.concatenate([[0], np.cumsum([len(x) for x in lists])]).astype(np.int32)
        self._list = np.array([k for x in lists for k in x], dtype=np.int32)
        self._open = np.zeros(count, dtype=bool)
        self._size = 64

    def look(
        self,
        camera: Camera,
        cell: int | None = None,
        closed: npt.NDArray[np.bool_] | None = None,
        reach: float = np.inf,
    ) -> list[Sight]:
        """Every cell in sight, with its frustum; a cell seen through two doors stands twice.

        Args:
            camera: the eye and the picture.
            cell: the cell the eye is in; None asks `view_cell`.
            closed: (P,) portals that are seen but not followed: there pictures stand for what lies
                beyond.
            reach: portals wholly farther off than this many metres are not followed.

        Returns:
            The eye's own cell first, then breadth first.

        Raises:
            CameraError: not a planar camera.
            InputError: more than `MOST_SIGHTS` chains of portals.
        """
        from belvedere.walkthrough import _sight

        if not isinstance(camera, Camera):
            raise CameraError(
                f"Visibility.look.camera is a {type(camera).__name__}, expected a planar Camera: "
                "a frustum has four planes"
            )
        check_number("Visibility.look", "reach", min(reach, 1e300), 0.0)
        here = view_cell(self.graph, camera.center) if cell is None else cell
        stop = self._open if closed is None else np.asarray(closed, dtype=bool)
        while True:
            n = self._size
            cells, parents, portals, counts, plane_counts = np.empty((5, n), dtype=np.int32)
            polygons, planes = np.empty((2, n, _sight.CORNERS, 3))
            total = _sight.look_through(
                camera.center, here, camera.edge_planes, self.corners, self.normals,
                self.joins, self._first, self._list, stop, NEAR_M, DOORWAY_M, reach, cells, parents,
                portals, counts, polygons, planes, plane_counts, np.empty((n, 4)),
            )  # fmt: skip
            if total <= n:
                break
            if n >= MOST_SIGHTS:
                raise InputError(
                    f"Visibility.look: more than {MOST_SIGHTS} chains of portals are in sight at "
                    f"{camera.center.round(2).tolist()}: merge cells, or give a reach"
                )
            self._size = n * 4
        sights: list[Sight] = []
        for k in range(total):
            portal = int(portals[k])
            chain = () if portal < 0 else (*sights[parents[k]].chain, portal)
            sights.append(
                Sight(int(cells[k]), portal, chain, planes[k, : plane_counts[k]].copy(),
                      polygons[k, : counts[k]].copy())
            )  # fmt: skip
        return sights


def view_cell(graph: CellGraph, eye: npt.ArrayLike) -> int:
    """The cell an eye is in; in a doorway, which is in no cell, the one on its side of the portal.

    Args:
        graph: cells and portals.
        eye: (3,) metres.

    Returns:
        An index, or `OUTSIDE` where no cell and no portal is near.
    """
    point = np.asarray(eye, dtype=np.float64)
    found = int(graph.cells_at(point[None])[0])
    if found != OUTSIDE:
        return found
    best, nearest = OUTSIDE, DOORWAY_M
    for portal in graph.portals:
        c, normal = portal.corners, portal.normal
        off = float((point - portal.center) @ normal)
        if abs(off) >= nearest:
            continue
        flat = point - off * normal
        along, up = c[1] - c[0], c[3] - c[0]
        s = (flat - c[0]) @ along / (along @ along)
        t = (flat - c[0]) @ up / (up @ up)
        if -0.05 <= s <= 1.05 and -0.05 <= t <= 1.05:
            best, nearest = portal.cells[0 if off >= 0.0 else 1], abs(off)
    return best


DOORWAY_M = 0.6
"""Half the thickest wall that a doorway is looked for in, metres."""
