"""Loops that draw triangles: clusters culled, corners moved, pixels won by the larger disparity.

Private. Screen positions are whole numbers of `SUB`-ths of a pixel, so that edge functions are
exact: of two triangles that share an edge exactly one covers each pixel center on it (the top-left
rule), whatever clusters they come from.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import inner, kernel

A = npt.NDArray[Any]

SUB = 256
"""Steps of a pixel that corners are rounded to."""
NEAR_M = 0.01
"""What is nearer than this to the eye, in depth, is cut away."""
GUARD_PX = 4096.0
"""Triangles are cut this far outside the picture, so that whole numbers do not overflow."""
CUT = 1 << 40
"""Column of a corner that lies outside the guard, where no other can be."""
MOST_CORNERS = 12
"""Of a triangle cut by five planes: eight, and some to spare."""


@kernel
def cull_clusters(low: A, high: A, eye: A, planes: A, inverse: A, rect: A, out_rect: A) -> None:
    """Where on the picture each cluster of triangles may be.

    Args:
        low: (C, 3) smallest corner of each cluster's box.
        high: (C, 3) largest.
        eye: (3,) in the same frame.
        planes: (K, 3) through the eye, pointing inwards; a box outside one is not seen.
        inverse: (3, 3) world to pixels times depth.
        rect: (4,) first and last column, first and last row that may be drawn.
        out_rect: (C, 4) the same for each cluster; last before first where it is not seen.
    """
    for k in range(low.shape[0]):
        seen = True
        for p in range(planes.shape[0]):
            reach = 0.0
            for c in range(3):
                n = planes[p, c]
                reach += n * ((high[k, c] if n > 0.0 else low[k, c]) - eye[c])
            if reach < 0.0:
                seen = False
                break
        out_rect[k, 0], out_rect[k, 1], out_rect[k, 2], out_rect[k, 3] = 1, 0, 1, 0
        if not seen:
            continue
        x0, x1, y0, y1 = math.inf, -math.inf, math.inf, -math.inf
        behind, before = 0, 0
        for corner in range(8):
            dx = (high[k, 0] if corner & 1 else low[k, 0]) - eye[0]
            dy = (high[k, 1] if corner & 2 else low[k, 1]) - eye[1]
            dz = (high[k, 2] if corner & 4 else low[k, 2]) - eye[2]
            z = inverse[2, 0] * dx + inverse[2, 1] * dy + inverse[2, 2] * dz
            if z < NEAR_M:
                behind += 1
                continue
            before += 1
            u = (inverse[0, 0] * dx + inverse[0, 1] * dy + inverse[0, 2] * dz) / z
            v = (inverse[1, 0] * dx + inverse[1, 1] * dy + inverse[1, 2] * dz) / z
            x0, x1, y0, y1 = min(x0, u), max(x1, u), min(y0, v), max(y1, v)
        if before == 0:
            continue
        if behind > 0:
            out_rect[k, 0], out_rect[k, 1], out_rect[k, 2], out_rect[k, 3] = (
                rect[0], rect[1], rect[2], rect[3],
            )  # fmt: skip
            continue
        # a step of rounding on either side
        out_rect[k, 0] = max(rect[0], math.ceil(max(x0, -1e6) - 0.01))
        out_rect[k, 1] = min(rect[1], math.floor(min(x1, 1e6) + 0.01))
        out_rect[k, 2] = max(rect[2], math.ceil(max(y0, -1e6) - 0.01))
        out_rect[k, 3] = min(rect[3], math.floor(min(y1, 1e6) + 0.01))


@kernel
def draw_clusters(
    first_vertex: A, vertices: A, first_face: A, corners: A, faces: A, rects: A, eye: A,
    inverse: A, row0: int, row1: int, width: int, height: int, out_face: A, out_disparity: A,
) -> None:  # fmt: skip
    """Draw what clusters show in some rows of the picture.

    Args:
        first_vertex: (C + 1,) where each cluster's vertices begin.
        vertices: (V, 3) float32.
        first_face: (C + 1,) where its triangles begin.
        corners: (F, 3) uint8 vertex of the cluster.
        faces: (F,) the number that stands for each triangle.
        rects: (C, 4) from `cull_clusters`.
        eye: (3,) in the frame of the vertices.
        inverse: (3, 3) world to pixels times depth.
        row0: first row.
        row1: the row after the last.
        width: of the picture.
        height: of the picture.
        out_face: (H, W) int32.
        out_disparity: (H, W) float32; what is drawn must exceed it.
    """
    x, y, z = np.empty(256), np.empty(256), np.empty(256)
    fx, fy = np.empty(256, np.int64), np.empty(256, np.int64)
    held, spare = np.empty((MOST_CORNERS, 3)), np.empty((MOST_CORNERS, 3))
    low_x, high_x = -GUARD_PX, width + GUARD_PX
    low_y, high_y = -GUARD_PX, height + GUARD_PX
    for k in range(rects.shape[0]):
        x0, x1 = rects[k, 0], rects[k, 1]
        y0, y1 = max(rects[k, 2], row0), min(rects[k, 3], row1 - 1)
        if x1 < x0 or y1 < y0:
            continue
        start = first_vertex[k]
        count = first_vertex[k + 1] - start
        inside = True
        for i in range(count):
            dx = vertices[start + i, 0] - eye[0]
            dy = vertices[start + i, 1] - eye[1]
            dz = vertices[start + i, 2] - eye[2]
            x[i] = inverse[0, 0] * dx + inverse[0, 1] * dy + inverse[0, 2] * dz
            y[i] = inverse[1, 0] * dx + inverse[1, 1] * dy + inverse[1, 2] * dz
            z[i] = inverse[2, 0] * dx + inverse[2, 1] * dy + inverse[2, 2] * dz
        for i in range(count):
            # a corner that must be cut away has a disparity no kept corner has
            d = 1.0 / z[i] if z[i] >= NEAR_M else -1.0
            u, v = x[i] * d, y[i] * d
            if d < 0.0 or u < low_x or u > high_x or v < low_y or v > high_y:
                fx[i] = CUT
                inside = False
            else:
                fx[i] = math.floor(u * SUB + 0.5)
                fy[i] = math.floor(v * SUB + 0.5)
        for f in range(first_face[k], first_face[k + 1]):
            a, b, c = corners[f, 0], corners[f, 1], corners[f, 2]
            if inside or (fx[a] < CUT and fx[b] < CUT and fx[c] < CUT):
                draw_triangle(
                    fx[a], fy[a], 1.0 / z[a], fx[b], fy[b], 1.0 / z[b], fx[c], fy[c], 1.0 / z[c],
                    x0, x1, y0, y1, faces[f], out_face, out_disparity,
                )  # fmt: skip
                continue
            for i, corner in enumerate((a, b, c)):
                held[i, 0], held[i, 1], held[i, 2] = x[corner], y[corner], z[corner]
            n = cut_polygon(held, 3, low_x, high_x, low_y, high_y, spare)
            for i in range(1, n - 1):
                u0, v0, d0 = _on_screen(held, 0)
                u1, v1, d1 = _on_screen(held, i)
                u2, v2, d2 = _on_screen(held, i + 1)
                draw_triangle(
                    u0,
                    v0,
                    d0,
                    u1,
                    v1,
                    d1,
                    u2,
                    v2,
                    d2,
                    x0,
                    x1,
                    y0,
                    y1,
                    faces[f],
                    out_face,
                    out_disparity,
                )


@inner
def _on_screen(polygon: A, i: int) -> tuple[int, int, float]:
    d = 1.0 / polygon[i, 2]
    return (
        math.floor(polygon[i, 0] * d * SUB + 0.5),
        math.floor(polygon[i, 1] * d * SUB + 0.5),
        d,
    )


@kernel
def cut_polygon(
    held: A, count: int, low_x: float, high_x: float, low_y: float, high_y: float, spare: A
) -> int:
    """Cut a polygon (x z, y z, z) by the near plane and the guard; how many corners are left.

    Points on a cut edge are counted from the end that is kept, so that two triangles that share
    the edge get the same points.
    """
    for plane in range(5):
        kept = 0
        for i in range(count):
            j = i + 1 if i + 1 < count else 0
            here, after = (
                _inside(held, i, plane, low_x, high_x, low_y, high_y),
                _inside(held, j, plane, low_x, high_x, low_y, high_y),
            )
            if here >= 0.0:
                for c in range(3):
                    spare[kept, c] = held[i, c]
                kept += 1
            if (here >= 0.0) != (after >= 0.0):
                p, q = (i, j) if here >= 0.0 else (j, i)
                share = (here if here >= 0.0 else after) / abs(here - after)
                for c in range(3):
                    spare[kept, c] = held[p, c] + share * (held[q, c] - held[p, c])
                if plane == 0:
                    spare[kept, 2] = NEAR_M
                kept += 1
        count = kept
        for i in range(count):
            for c in range(3):
                held[i, c] = spare[i, c]
    return count


@inner
def _inside(
    held: A, i: int, plane: int, low_x: float, high_x: float, low_y: float, high_y: float
) -> float:
    if plane == 0:
        return held[i, 2] - NEAR_M
    if plane == 1:
        return held[i, 0] - low_x * held[i, 2]
    if plane == 2:
        return high_x * held[i, 2] - held[i, 0]
    if plane == 3:
        return held[i, 1] - low_y * held[i, 2]
    return high_y * held[i, 2] - held[i, 1]


@inner
def draw_triangle(
    ax: int, ay: int, ad: float, bx: int, by: int, bd: float, cx: int, cy: int, cd: float,
    x0: int, x1: int, y0: int, y1: int, face: int, out_face: A, out_disparity: A,
) -> None:  # fmt: skip
    """Draw one triangle inside columns x0..x1 and rows y0..y1, whichever way it turns."""
    # the first and last pixel whose center can be inside
    left = max(x0, -((-min(ax, bx, cx)) // SUB))
    right = min(x1, max(ax, bx, cx) // SUB)
    if right < left:
        return
    top = max(y0, -((-min(ay, by, cy)) // SUB))
    bottom = min(y1, max(ay, by, cy) // SUB)
    if bottom < top:
        return
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    if area == 0:
        return
    if area < 0:
        bx, cx, by, cy, bd, cd, area = cx, bx, cy, by, cd, bd, -area
    # steps of the edge functions by one pixel; a pixel on an edge belongs to a top or left one
    abx, aby = (by - ay) * -SUB, (bx - ax) * SUB
    bcx, bcy = (cy - by) * -SUB, (cx - bx) * SUB
    cax, cay = (ay - cy) * -SUB, (ax - cx) * SUB
    px, py = left * SUB, top * SUB
    ab = (bx - ax) * (py - ay) - (by - ay) * (px - ax)
    bc = (cx - bx) * (py - by) - (cy - by) * (px - bx)
    ca = (ax - cx) * (py - cy) - (ay - cy) * (px - cx)
    ab -= 0 if (by < ay or (by == ay and bx > ax)) else 1
    bc -= 0 if (cy < by or (cy == by and cx > bx)) else 1
    ca -= 0 if (ay < cy or (ay == cy and ax > cx)) else 1
    scale = 1.0 / area
    db, dc = (bd - ad) * scale, (cd - ad) * scale
    if right == left and bottom == top:  # the most common case of all
        if (ab | bc | ca) >= 0:
            d = np.float32(ad + db * ca + dc * ab)
            if d > out_disparity[top, left]:
                out_disparity[top, left] = d
                out_face[top, left] = face
        return
    step = db * cax + dc * abx
    for v in range(top, bottom + 1):
        e0, e1, e2 = ab, bc, ca
        d = ad + db * ca + dc * ab
        for u in range(left, right + 1):
            if (e0 | e1 | e2) >= 0:
                here = np.float32(d)
                if here > out_disparity[v, u]:
                    out_disparity[v, u] = here
                    out_face[v, u] = face
            e0 += abx
            e1 += bcx
            e2 += cax
            d += step
        ab += aby
        bc += bcy
        ca += cay
