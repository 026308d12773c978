"""Rays walked from room to room through rectangles: the slow twin of visibility."""

from __future__ import annotations

import numpy as np

from belvedere.walkthrough import CellGraph


def cells_along(
    graph: CellGraph, cell: int, eye: np.ndarray, ray: np.ndarray, reach: float = np.inf
) -> set[int]:
    """The cells that a ray passes, leaving each by the first portal ahead that it meets.

    A ray that meets the wall before a portal would stop there; where rooms are convex, a portal of
    the room that it meets at all is met on the way out. ``reach``, in lengths of the ray, is where
    it ends.
    """
    passed, here, after = {cell}, cell, 0.0
    while True:
        best, where = None, np.inf
        for portal in (p for p in graph.portals if here in p.cells):
            c, normal = portal.corners, portal.normal
            slope = ray @ normal
            if slope == 0.0:
                continue
            t = ((portal.center - eye) @ normal) / slope
            out = -slope if portal.cells[0] == here else slope
            if t <= after or t > reach or out <= 0.0:
                continue
            at = eye + t * ray - c[0]
            along, up = c[1] - c[0], c[3] - c[0]
            s, r = at @ along / (along @ along), at @ up / (up @ up)
            if 0.0 <= s <= 1.0 and 0.0 <= r <= 1.0 and t < where:
                best, where = portal, t
        if best is None:
            return passed
        here, after = best.beyond(here), where
        passed.add(here)
