"""The loop that looks through portals. Private."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import kernel

A = npt.NDArray[Any]

CORNERS = 64
"""Most corners of a narrowed frustum; one that would need more stays as wide as it was."""


THIN = 1e-9
"""A portal with less area than this share of its squared distance is a line."""


@kernel
def cut(out: A, count: int, nx: float, ny: float, nz: float, height: float, spare: A) -> int:
    """Keep the part of a convex polygon where ``n @ x >= height``.

    Args:
        out: (CORNERS, 3) the polygon's corners; takes those that are left.
        count: how many.
        nx: of the plane's normal.
        ny: of it.
        nz: of it.
        height: of the plane along it.
        spare: (CORNERS, 3) working memory.

    Returns:
        How many are left; -1 where they would be too many.

    Source: Sutherland and Hodgman 1974.
    """
    kept = 0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        here = nx * out[i, 0] + ny * out[i, 1] + nz * out[i, 2] - height
        after = nx * out[j, 0] + ny * out[j, 1] + nz * out[j, 2] - height
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
    for i in range(kept):
        for c in range(3):
            out[i, c] = spare[i, c]
    return kept if kept > 2 else 0


@kernel
def clip(polygon: A, planes: A, plane_count: int, beyond: A, out: A, spare: A) -> int:
    """Cut a portal, relative to the eye, to a frustum and to what lies beyond a plane.

    Args:
        polygon: (4, 3).
        planes: (CORNERS, 3) normals of planes through the eye, pointing inwards.
        plane_count: how many.
        beyond: (4,) normal and height of the plane of the portal before.
        out: (CORNERS, 3) takes the corners that are left.
        spare: (CORNERS, 3) working memory.

    Returns:
        How many are left; -1 where they would be too many.
    """
    for i in range(4):
        for c in range(3):
            out[i, c] = polygon[i, c]
    count = cut(out, 4, beyond[0], beyond[1], beyond[2], beyond[3], spare)
    for k in range(plane_count):
        if count <= 0:
            break
        count = cut(out, count, planes[k, 0], planes[k, 1], planes[k, 2], 0.0, spare)
    return count


@kernel
def planes_of(polygon: A, count: int, turn: float, out_planes: A) -> int:
    """The planes through the eye and a polygon's edges, pointing inwards; how many there are.

    Args:
        polygon: (CORNERS, 3) relative to the eye.
        count: of its corners.
        turn: 1 where they run clockwise as the eye sees them, -1 otherwise.
        out_planes: (CORNERS, 3) takes the unit normals.

    Returns:
        How many; 0 for a polygon so thin that no pixel's center lies in it.
    """
    made, sx, sy, sz, far = 0, 0.0, 0.0, 0.0, 0.0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        x = polygon[i, 1] * polygon[j, 2] - polygon[i, 2] * polygon[j, 1]
        y = polygon[i, 2] * polygon[j, 0] - polygon[i, 0] * polygon[j, 2]
        z = polygon[i, 0] * polygon[j, 1] - polygon[i, 1] * polygon[j, 0]
        sx, sy, sz = sx + x, sy + y, sz + z  # twice the area, as a vector
        size = np.sqrt(x * x + y * y + z * z)
        square = polygon[i, 0] ** 2 + polygon[i, 1] ** 2 + polygon[i, 2] ** 2
        far = max(far, square)
        if size <= 1e-12 * square:
            continue  # two corners in one direction: no edge
        size *= turn
        out_planes[made, 0], out_planes[made, 1], out_planes[made, 2] = x / size, y / size, z / size
        made += 1
    return made if sx * sx + sy * sy + sz * sz > (THIN * far) ** 2 else 0


@kernel
def look_through(
    eye: A, view_cell: int, view_planes: A, corners: A, normals: A, joins: A, first: A, list_of: A,
    closed: A, near: float, wall: float, reach: float, out_cell: A, out_parent: A, out_portal: A,
    out_count: A, out_polygon: A, planes: A, plane_count: A, beyond: A,
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
        wall: an eye so close behind a portal of its own cell looks into both cells: the cell's
            outline reaches through the portal there.
        reach: what lies farther off than this is not followed.
        out_cell: (N,) of each sight.
        out_parent: (N,) the sight it was seen from; -1 for the first.
        out_portal: (N,) the portal it was seen through; -1 for the first.
        out_count: (N,) corners of the portal that are left to see.
        out_polygon: (N, CORNERS, 3) these corners, relative to the eye.
        planes: (N, CORNERS, 3) of the frustum that leads on, written too.
        plane_count: (N,) how many.
        beyond: (N, 4) normal and height of the plane that sight has passed: a ray meets the
            portals of its chain one after another, so the next lies beyond it.

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
    beyond[0, 0], beyond[0, 1], beyond[0, 2], beyond[0, 3] = 0.0, 0.0, 0.0, -1.0
    spare, quad, at = np.empty((CORNERS, 3)), np.empty((4, 3)), np.empty(3)
    total, done = 1, 0
    while done < total:
        here = out_cell[done]
        if out_portal[done] >= 0 and closed[out_portal[done]]:
            done += 1
            continue
        row = outside if here < 0 else here
        for index in range(first[row], first[row + 1]):
            p = list_of[index]
            back, passed = done, False
            while back >= 0 and not passed:  # a straight line crosses a plane once
                passed = out_portal[back] == p
                back = out_parent[back]
            if passed:
                continue
            side = 1.0 if joins[p, 0] == here else -1.0
            off = 0.0
            for c in range(3):
                at[c] = corners[p, 0, c] - eye[c]
                off -= at[c] * normals[p, c] * side
            if off < (-wall if done == 0 else -near):  # from its other side it leads nowhere
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
            standing = off <= near  # in the doorway, or beside it in the wall's plane
            if standing:
                for i in range(4):
                    j = i + 1 if i < 3 else 0
                    beside, edge = 0.0, 0.0
                    for c in range(3):
                        along = corners[p, j, c] - corners[p, i, c]
                        beside -= along * quad[i, c]
                        edge += along * along
                    if beside < -near * np.sqrt(edge):
                        standing = False
            if off <= 0.0 and not standing:
                continue
            if total == most:
                return most + 1
            if standing:
                left = plane_count[done]
                for k in range(left):
                    for c in range(3):
                        planes[total, k, c] = planes[done, k, c]
                plane_count[total], out_count[total] = left, 0
            else:
                left = clip(
                    quad, planes[done], plane_count[done], beyond[done], out_polygon[total], spare
                )
                if left == 0:
                    continue
                if left < 0:
                    for k in range(plane_count[done]):
                        for c in range(3):
                            planes[total, k, c] = planes[done, k, c]
                    plane_count[total], out_count[total] = plane_count[done], 0
                else:
                    made = planes_of(out_polygon[total], left, -side, planes[total])
                    if made == 0:
                        continue
                    plane_count[total], out_count[total] = made, left
            for c in range(3):
                beyond[total, c] = -side * normals[p, c]
            beyond[total, 3] = off - near  # a little before it, for portals that share an edge
            out_cell[total] = joins[p, 1] if joins[p, 0] == here else joins[p, 0]
            out_parent[total], out_portal[total] = done, p
            total += 1
        done += 1
    return total
