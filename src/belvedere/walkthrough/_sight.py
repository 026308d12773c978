"""The loop that looks through portals. Private."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import kernel

A = npt.NDArray[Any]

CORNERS = 64
"""Most corners of a narrowed frustum; one that would need more stays as wide as it was."""


@kernel
def clip(polygon: A, count: int, planes: A, plane_count: int, out: A, spare: A) -> int:
    """Cut a convex polygon, seen from the origin, by planes through the origin.

    Args:
        polygon: (CORNERS, 3) its corners relative to the eye.
        count: how many.
        planes: (CORNERS, 3) normals that point into the frustum.
        plane_count: how many.
        out: (CORNERS, 3) takes the corners that are left.
        spare: (CORNERS, 3) working memory.

    Returns:
        How many are left; -1 where they would be too many.

    Source: Sutherland and Hodgman 1974, with planes through the eye instead of edges.
    """
    for i in range(count):
        for c in range(3):
            out[i, c] = polygon[i, c]
    for k in range(plane_count):
        nx, ny, nz = planes[k, 0], planes[k, 1], planes[k, 2]
        kept = 0
        for i in range(count):
            j = i + 1 if i + 1 < count else 0
            here = nx * out[i, 0] + ny * out[i, 1] + nz * out[i, 2]
            after = nx * out[j, 0] + ny * out[j, 1] + nz * out[j, 2]
            if kept + 2 > spare.shape[0]:
                return -1
            if here >= 0.0:
                for c in range(3):
                    spare[kept, c] = out[i, c]
                kept += 1
            if (here < 0.0 < after) or (after < 0.0 < here):
                share = here / (here - after)
                for c in range(3):
                    spare[kept, c] = out[i, c] + share * (out[j, c] - out[i, c])
                kept += 1
        count = kept
        if count < 3:
            return 0
        for i in range(count):
            for c in range(3):
                out[i, c] = spare[i, c]
    return count


@kernel
def planes_of(polygon: A, count: int, out_planes: A) -> int:
    """The planes through the eye and a polygon's edges, pointing inwards; how many there are.

    Edges too short for a direction are left out, which can only widen the frustum.
    """
    middle = np.zeros(3)
    for i in range(count):
        for c in range(3):
            middle[c] += polygon[i, c]
    made = 0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        x = polygon[i, 1] * polygon[j, 2] - polygon[i, 2] * polygon[j, 1]
        y = polygon[i, 2] * polygon[j, 0] - polygon[i, 0] * polygon[j, 2]
        z = polygon[i, 0] * polygon[j, 1] - polygon[i, 1] * polygon[j, 0]
        size = np.sqrt(x * x + y * y + z * z)
        far = np.sqrt(polygon[i, 0] ** 2 + polygon[i, 1] ** 2 + polygon[i, 2] ** 2)
        far *= np.sqrt(polygon[j, 0] ** 2 + polygon[j, 1] ** 2 + polygon[j, 2] ** 2)
        if size <= 1e-12 * far:
            continue
        if x * middle[0] + y * middle[1] + z * middle[2] < 0.0:
            size = -size
        out_planes[made, 0], out_planes[made, 1], out_planes[made, 2] = x / size, y / size, z / size
        made += 1
    return made


@kernel
def look_through(
    eye: A, view_cell: int, view_planes: A, corners: A, normals: A, joins: A, first: A, list_of: A,
    closed: A, near: float, reach: float, out_cell: A, out_parent: A, out_portal: A, out_count: A,
    out_polygon: A, planes: A, plane_count: A,
) -> int:  # fmt: skip
    """Follow sight from cell to cell; see `belvedere.walkthrough.visibility`.

    Args:
        eye: (3,).
        view_cell: where it is; -1 is outside.
        view_planes: (4, 3) of the picture's edges, pointing inwards.
        corners: (P, 4, 3) of the portals.
        normals: (P, 3) into ``joins[:, 0]``.
        joins: (P, 2) cells.
        first: (cells + 2,) where each cell's portals begin in ``list_of``; the last cell is
            outside.
        list_of: portal indices.
        closed: (P,) bool: seen, but not followed.
        near: an eye this close to a portal's plane, inside its rectangle, sees all beyond.
        reach: what lies farther off than this is not followed.
        out_cell: (N,) of each sight.
        out_parent: (N,) the sight it was seen from; -1 for the first.
        out_portal: (N,) the portal it was seen through; -1 for the first.
        out_count: (N,) corners of the portal that are left to see.
        out_polygon: (N, CORNERS, 3) these corners, relative to the eye.
        planes: (N, CORNERS, 3) of the frustum that leads on, written too.
        plane_count: (N,) how many.

    Returns:
        How many sights; N + 1 where there are more than N.
    """
    most = out_cell.shape[0]
    outside = first.shape[0] - 2
    out_cell[0], out_parent[0], out_portal[0], out_count[0] = view_cell, -1, -1, 0
    for k in range(view_planes.shape[0]):
        for c in range(3):
            planes[0, k, c] = view_planes[k, c]
    plane_count[0] = view_planes.shape[0]
    spare, quad, at = np.empty((CORNERS, 3)), np.empty((CORNERS, 3)), np.empty(3)
    total, done = 1, 0
    while done < total:
        here = out_cell[done]
        if out_portal[done] >= 0 and closed[out_portal[done]]:
            done += 1
            continue
        row = outside if here < 0 else here
        for index in range(first[row], first[row + 1]):
            p = list_of[index]
            if p == out_portal[done]:
                continue
            side = 1.0 if joins[p, 0] == here else -1.0
            off, inside = 0.0, True
            for c in range(3):
                at[c] = corners[p, 0, c] - eye[c]
                off -= at[c] * normals[p, c] * side
            if off < -near:  # seen from its other side: nothing can be reached through it
                continue
            nearest = 0.0
            for i in range(4):
                length = 0.0
                for c in range(3):
                    quad[i, c] = corners[p, i, c] - eye[c]
                    length += quad[i, c] ** 2
                nearest = length if i == 0 else min(nearest, length)
            if nearest > reach * reach and off > reach:
                continue
            if off <= near:  # the eye stands in the doorway, or beside it in the wall's plane
                for i in range(4):
                    j = i + 1 if i < 3 else 0
                    beside, edge = 0.0, 0.0
                    for c in range(3):
                        along = corners[p, j, c] - corners[p, i, c]
                        beside -= along * quad[i, c]
                        edge += along * along
                    if beside < -near * np.sqrt(edge):
                        inside = False
                if not inside:
                    continue
            if total == most:
                return most + 1
            if off <= near:
                left = plane_count[done]
                for k in range(left):
                    for c in range(3):
                        planes[total, k, c] = planes[done, k, c]
                plane_count[total], out_count[total] = left, 0
            else:
                left = clip(quad, 4, planes[done], plane_count[done], out_polygon[total], spare)
                if left == 0:
                    continue
                if left < 0:
                    for k in range(plane_count[done]):
                        for c in range(3):
                            planes[total, k, c] = planes[done, k, c]
                    plane_count[total], out_count[total] = plane_count[done], 0
                else:
                    plane_count[total] = planes_of(out_polygon[total], left, planes[total])
                    out_count[total] = left
            out_cell[total] = joins[p, 1] if joins[p, 0] == here else joins[p, 0]
            out_parent[total], out_portal[total] = done, p
            total += 1
        done += 1
    return total
