"""Loops that find out which triangles of a frame may show, and where their corners are.

Private. Clusters are culled by their boxes, corners moved to the screen, triangles that reach out
of it cut. Screen positions are whole numbers of `SUB`-ths of a pixel, so that the edge functions of
`_raster_fill` are exact.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import floor4, four, lane4, load4, max4, min4, scale4, store4

A = npt.NDArray[Any]
F = np.float32

SHIFT = 8
SUB = 1 << SHIFT
"""Steps of a pixel that corners are rounded to."""
NEAR_M = 0.01
"""What is nearer than this to the eye, in depth, is cut away."""
GUARD_PX = 4096.0
"""Triangles are cut this far outside the picture, so that whole numbers do not overflow."""
MOST_CORNERS = 12
"""Of a triangle cut by five planes: eight, and some to spare."""
MOST_PIECES = 6
"""Triangles that a cut one becomes."""
RECORD = 10
"""Numbers of a triangle that may show: x, y of three corners, face, three disparities."""
TILE = 16
"""Side of the squares of pixels whose least disparity is known."""
STEP = F(1.0 / SUB)
ALL = F(1e9)
JUST = 1.0001
"""More than disparities are wrong by."""


@kernel
def cull_clusters(
    low: A, high: A, eye: A, planes: A, inverse: A, rect: A, out_rect: A, out_near: A, out_cut: A
) -> None:  # fmt: skip
    """Where on the picture each cluster of triangles may be.

    Args:
        low: (C, 3) smallest corner of each cluster's box.
        high: (C, 3) largest.
        eye: (3,) in the same frame.
        planes: (K, 3) through the eye, pointing inwards; a box outside one is not seen.
        inverse: (3, 3) world to pixels times depth.
        rect: (4,) first and last column, first and last row that may be drawn.
        out_rect: (C, 4) the same for each cluster; last before first where it is not seen.
        out_near: (C,) disparity that none of its corners exceeds.
        out_cut: (C,) whether triangles may have to be cut.
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
        out_near[k], out_cut[k] = 0.0, False
        if not seen:
            continue
        x0, x1, y0, y1 = math.inf, -math.inf, math.inf, -math.inf
        behind, before, nearest = 0, 0, math.inf
        for corner in range(8):
            dx = (high[k, 0] if corner & 1 else low[k, 0]) - eye[0]
            dy = (high[k, 1] if corner & 2 else low[k, 1]) - eye[1]
            dz = (high[k, 2] if corner & 4 else low[k, 2]) - eye[2]
            z = inverse[2, 0] * dx + inverse[2, 1] * dy + inverse[2, 2] * dz
            if z < 1.01 * NEAR_M:
                behind += 1
                continue
            nearest = min(nearest, z)
            before += 1
            u = (inverse[0, 0] * dx + inverse[0, 1] * dy + inverse[0, 2] * dz) / z
            v = (inverse[1, 0] * dx + inverse[1, 1] * dy + inverse[1, 2] * dz) / z
            x0, x1, y0, y1 = min(x0, u), max(x1, u), min(y0, v), max(y1, v)
        if before == 0:
            continue
        out_near[k], out_cut[k] = JUST / nearest, False
        if behind > 0:
            out_near[k], out_cut[k] = math.inf, True
            out_rect[k, 0], out_rect[k, 1], out_rect[k, 2], out_rect[k, 3] = (
                rect[0], rect[1], rect[2], rect[3],
            )  # fmt: skip
            continue
        least, most = min(x0 - rect[0], y0 - rect[2]), max(x1 - rect[1], y1 - rect[3])
        out_cut[k] = least < 1.0 - GUARD_PX or most > GUARD_PX - 1.0
        # a step of rounding on either side
        out_rect[k, 0] = max(rect[0], math.ceil(max(x0, -1e6) - 0.01))
        out_rect[k, 1] = min(rect[1], math.floor(min(x1, 1e6) + 0.01))
        out_rect[k, 2] = max(rect[2], math.ceil(max(y0, -1e6) - 0.01))
        out_rect[k, 3] = min(rect[3], math.floor(min(y1, 1e6) + 0.01))


@inner
def is_hidden(near: Real, x0: int, x1: int, y0: int, y1: int, tiles: A) -> bool:
    """Whether all that is seen in a rectangle is nearer."""
    for j in range(y0 // TILE, y1 // TILE + 1):
        for i in range(x0 // TILE, x1 // TILE + 1):
            if tiles[j, i] <= near:
                return False
    return True


@inner
def project(
    start: Real, count: Real, vertices: A, eye: A, inverse: A, width: int, height: int, out_held: A,
    out_box: A,
) -> bool:  # fmt: skip
    """Move a cluster's vertices to the screen; whether all of them are there.

    ``out_held`` gets, from every 256th number on: x z, y z, z, x, y, disparity, and 1 for a vertex
    that is not on the screen. ``out_box`` gets x, y, -x, -y, and more than all where it is not.
    """
    ex, ey, ez = eye[0], eye[1], eye[2]
    low_x, high_x = -GUARD_PX, width + GUARD_PX
    low_y, high_y = -GUARD_PX, height + GUARD_PX
    for i in range(count):
        dx = vertices[0, start + i] - ex
        dy = vertices[1, start + i] - ey
        dz = vertices[2, start + i] - ez
        out_held[i] = inverse[0, 0] * dx + inverse[0, 1] * dy + inverse[0, 2] * dz
        out_held[i + 256] = inverse[1, 0] * dx + inverse[1, 1] * dy + inverse[1, 2] * dz
        out_held[i + 512] = inverse[2, 0] * dx + inverse[2, 1] * dy + inverse[2, 2] * dz
    off = 0.0
    for i in range(count):
        z = out_held[i + 512]
        delta = 1.0 / max(z, NEAR_M)
        u, v = out_held[i] * delta, out_held[i + 256] * delta
        here = (z >= NEAR_M) & (u >= low_x) & (u <= high_x) & (v >= low_y) & (v <= high_y)
        out_held[i + 768] = np.floor(min(max(u, low_x), high_x) * SUB + 0.5)
        out_held[i + 1024] = np.floor(min(max(v, low_y), high_y) * SUB + 0.5)
        out_held[i + 1280] = delta
        out_held[i + 1536] = 0.0 if here else 1.0
    for i in range(count):
        x, y = F(out_held[i + 768]), F(out_held[i + 1024])
        store4(out_box, i, four(x, y, -x, -y))
        if out_held[i + 1536] > 0.0:
            off += 1.0
            store4(out_box, i, four(ALL, ALL, ALL, ALL))
    return off == 0.0


@kernel
def set_up(
    positions: A, clusters: A, rects: A, near: A, room: A, first_vertex: A, vertices: A,
    first_face: A, corners: A, faces: A, eye: A, inverse: A, width: int, height: int, tiles: A,
    out_count: A, out_record: A, out_delta: A,
) -> None:  # fmt: skip
    """Find out which triangles of some clusters may show, and where their corners are.

    Args:
        positions: (N,) places of the clusters in the arrays of a frame.
        clusters: (P,) of a frame: each cluster's number in the arrays of its list.
        rects: (P, 4) of a frame, see `cull_clusters`.
        near: (P,) of a frame.
        room: (P,) of a frame: where each cluster's records begin.
        first_vertex: (C + 1,) of a list: where each cluster's vertices begin.
        vertices: (3, V) float32.
        first_face: (C + 1,) where its triangles begin.
        corners: (F, 3) uint8 vertex of the cluster.
        faces: (F,) the number that stands for each triangle.
        eye: (3,) in the frame of the vertices.
        inverse: (3, 3) world to pixels times depth.
        width: of the picture.
        height: of the picture.
        tiles: least disparity of each square of `TILE` pixels.
        out_count: (P,) how many records each cluster has.
        out_record: (R, RECORD) int32.
        out_delta: (R, RECORD) float32, the same memory.
    """
    held, box, shows = np.empty(7 * 256), np.empty((256, 4), np.float32), np.empty(256, np.int32)
    polygon, spare = np.empty((MOST_CORNERS, 3)), np.empty((MOST_CORNERS, 3))
    low_x, high_x = -GUARD_PX, width + GUARD_PX
    low_y, high_y = -GUARD_PX, height + GUARD_PX
    for n in range(positions.shape[0]):
        at = positions[n]
        k = clusters[at]
        x0, x1, y0, y1 = rects[at, 0], rects[at, 1], rects[at, 2], rects[at, 3]
        out_count[at] = 0
        if is_hidden(near[at], x0, x1, y0, y1, tiles):
            continue
        start = first_vertex[k]
        whole = project(
            start, first_vertex[k + 1] - start, vertices, eye, inverse, width, height, held, box
        )
        begin, count = first_face[k], 0
        rect = four(F(x1), F(y1), F(-x0), F(-y0))
        for i in range(first_face[k + 1] - begin):
            f = np.uint64(begin + i)
            a, b, c = corners[f, 0], corners[f, 1], corners[f, 2]
            # the last column and row whose centers can be inside, and the first ones negated
            reach = scale4(max4(max4(load4(box, a), load4(box, b)), load4(box, c)), STEP)
            reach = min4(floor4(reach), rect)
            shows[np.uint64(count)] = i
            columns, rows = lane4(reach, 0) + lane4(reach, 2), lane4(reach, 1) + lane4(reach, 3)
            count += np.int64(min(columns, rows) >= F(0.0))
        r = np.uint64(room[at])
        for i in range(count):
            f = np.uint64(begin + shows[i])
            a, b, c = (
                np.int64(corners[f, 0]), np.int64(corners[f, 1]), np.int64(corners[f, 2]),
            )  # fmt: skip
            if whole or held[a + 1536] + held[b + 1536] + held[c + 1536] == 0.0:
                reach = scale4(max4(max4(load4(box, a), load4(box, b)), load4(box, c)), STEP)
                reach = min4(floor4(reach), rect)
                v, u = np.int64(lane4(reach, 1)), np.int64(lane4(reach, 0))
                nearest = max(held[a + 1280], held[b + 1280], held[c + 1280])
                small = (-np.int64(lane4(reach, 3)) // TILE == v // TILE) & (
                    -np.int64(lane4(reach, 2)) // TILE == u // TILE
                )
                if small and tiles[v // TILE, u // TILE] > nearest * JUST:
                    continue
                for place, corner in enumerate((a, b, c)):
                    out_record[r, 2 * place] = np.int32(held[corner + 768])
                    out_record[r, 2 * place + 1] = np.int32(held[corner + 1024])
                    out_delta[r, 7 + place] = F(held[corner + 1280])
                out_record[r, 6] = faces[f]
                r += np.uint64(1)
                continue
            for j, corner in enumerate((a, b, c)):
                polygon[j, 0], polygon[j, 1] = held[corner], held[corner + 256]
                polygon[j, 2] = held[corner + 512]
            left_over = cut_polygon(polygon, 3, low_x, high_x, low_y, high_y, spare)
            for j in range(1, left_over - 1):
                for place, corner in enumerate((0, j, j + 1)):
                    d = 1.0 / polygon[corner, 2]
                    u, v = polygon[corner, 0] * d * SUB, polygon[corner, 1] * d * SUB
                    out_record[r, 2 * place] = math.floor(u + 0.5)
                    out_record[r, 2 * place + 1] = math.floor(v + 0.5)
                    out_delta[r, 7 + place] = d
                out_record[r, 6] = faces[f]
                r += np.uint64(1)
        out_count[at] = np.int64(r) - room[at]


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
