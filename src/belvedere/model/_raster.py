"""Loops that draw triangles: clusters culled, corners moved, pixels won by the larger disparity.

Private. Screen positions are whole numbers of `SUB`-ths of a pixel, so that edge functions are
exact: of two triangles that share an edge exactly one covers each pixel center on it (the top-left
rule), whatever clusters they come from.

A pixel is one whole number, its key: the bits of its disparity (positive floats are ordered as
their bits are), then a number that is larger for a smaller face. The largest key wins, so that the
order in which triangles are drawn changes nothing, where two coincide neither.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.eight import max_keys8, ramp8
from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import (
    bits_of,
    float_of,
    floor4,
    four,
    lane4,
    load4,
    max4,
    min4,
    scale4,
    store4,
)

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
SKY = (1 << 32) - 1
"""Key of a pixel where nothing stands."""
BEYOND = 1 << 62
"""Key of what lies to the right of the picture."""
LAST_FACE = (1 << 31) - 1
NARROW = 4
"""Columns up to which pixels are tried one by one."""
HAIR = 2.0**-32
"""Less than any quotient of edge functions is away from a whole number, if it is none."""


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


@kernel
def clear_keys(row0: int, row1: int, width: int, out_keys: A) -> None:
    """Nothing stands in some rows."""
    for v in range(row0, row1):
        for u in range(width):
            out_keys[v, u] = SKY
        for u in range(width, out_keys.shape[1]):
            out_keys[v, u] = BEYOND


@kernel
def least_disparities(row0: int, row1: int, keys: A, out_tiles: A) -> None:
    """The least disparity of each tile in some rows, of which the first begins a row of tiles."""
    for top in range(row0, row1, TILE):
        for i in range(out_tiles.shape[1]):
            least = np.int64(BEYOND)
            for v in range(top, min(top + TILE, row1)):
                for u in range(TILE):
                    least = min(least, keys[v, i * TILE + u])
            out_tiles[top // TILE, i] = float_of(np.uint32(least >> 32))


@kernel
def draw_records(
    first: int, last: int, rects: A, room: A, count: A, record: A, delta: A, row0: int, row1: int,
    out_keys: A,
) -> None:  # fmt: skip
    """Draw in some rows what the clusters from ``first`` to before ``last`` show.

    Args as in `set_up`; ``out_keys`` is (H, W and more) int64.
    """
    for k in range(first, last):
        x0, x1 = rects[k, 0], rects[k, 1]
        y0, y1 = max(rects[k, 2], row0), min(rects[k, 3], row1 - 1)
        if y1 < y0:
            continue
        for r in range(room[k], room[k] + count[k]):
            draw_triangle(r, record, delta, x0, x1, y0, y1, out_keys)


@inner
def key_of(delta: Real, low: Real) -> Real:
    """The key of a disparity and a face."""
    return (np.int64(bits_of(F(delta))) << 32) | low


@inner
def draw_triangle(
    r: Real, record: A, delta: A, x0: Real, x1: Real, y0: Real, y1: Real, out_keys: A
) -> None:
    """Draw one triangle inside columns x0..x1 and rows y0..y1, whichever way it turns."""
    r = np.uint64(r)
    ay, by, cy = np.int64(record[r, 1]), np.int64(record[r, 3]), np.int64(record[r, 5])
    # the first and last pixel whose center can be inside
    top = max(y0, (min(ay, by, cy) + SUB - 1) >> SHIFT)
    bottom = min(y1, max(ay, by, cy) >> SHIFT)
    if bottom < top:
        return
    ax, bx, cx = np.int64(record[r, 0]), np.int64(record[r, 2]), np.int64(record[r, 4])
    left = max(x0, (min(ax, bx, cx) + SUB - 1) >> SHIFT)
    right = min(x1, max(ax, bx, cx) >> SHIFT)
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    if area == 0:
        return
    ad, bd, cd = np.float64(delta[r, 7]), np.float64(delta[r, 8]), np.float64(delta[r, 9])
    if area < 0:
        bx, cx, by, cy, bd, cd, area = cx, bx, cy, by, cd, bd, -area
    low = np.int64(LAST_FACE) - np.int64(record[r, 6])
    px, py = left * SUB, top * SUB
    # a pixel on an edge belongs to a top or left one
    ab = (bx - ax) * (py - ay) - (by - ay) * (px - ax)
    bc = (cx - bx) * (py - by) - (cy - by) * (px - bx)
    ca = (ax - cx) * (py - cy) - (ay - cy) * (px - cx)
    ab -= 0 if (by < ay or (by == ay and bx > ax)) else 1
    bc -= 0 if (cy < by or (cy == by and cx > bx)) else 1
    ca -= 0 if (ay < cy or (ay == cy and ax > cx)) else 1
    # steps of the edge functions by one pixel
    abx, aby = (ay - by) * SUB, (bx - ax) * SUB
    bcx, bcy = (by - cy) * SUB, (cx - bx) * SUB
    cax, cay = (cy - ay) * SUB, (ax - cx) * SUB
    scale = 1.0 / area
    db, dc = (bd - ad) * scale, (cd - ad) * scale
    step = db * cax + dc * abx
    if right - left < NARROW:
        for v in range(top, bottom + 1):
            e0, e1, e2 = ab, bc, ca
            d = ad + db * ca + dc * ab
            for u in range(left, right + 1):
                if (e0 | e1 | e2) >= 0:
                    key = key_of(d, low)
                    here = np.uint64(u)
                    if key > out_keys[np.uint64(v), here]:  # noqa: PLR1730 - most do not
                        out_keys[np.uint64(v), here] = key
                e0 += abx
                e1 += bcx
                e2 += cax
                d += step
            ab += aby
            bc += bcy
            ca += cay
        return
    draw_spans(
        left, right, top, bottom, float(ab), float(bc), float(ca), float(abx), float(bcx),
        float(cax), float(aby), float(bcy), float(cay), ad, db, dc, step, low, out_keys,
    )  # fmt: skip


@inner
def first_inside(e: float, over: float, a: float) -> float:
    """First column in which e + a k >= 0, where a > 0 and over = 1 / a; else 0, or many."""
    if a > 0.0:
        return -np.floor(e * over + HAIR)
    return 0.0 if a < 0.0 or e >= 0.0 else 1e9


@inner
def last_inside(e: float, over: float, a: float) -> float:
    """Last column in which e + a k >= 0, where a < 0 and over = 1 / a; else many."""
    return np.floor(HAIR - e * over) if a < 0.0 else 1e9


@inner
def draw_spans(
    left: Real, right: Real, top: Real, bottom: Real, ab: float, bc: float, ca: float, abx: float,
    bcx: float, cax: float, aby: float, bcy: float, cay: float, ad: float, db: float, dc: float,
    step: float, low: Real, out_keys: A,
) -> None:  # fmt: skip
    """Draw a triangle row by row, eight pixels at once.

    Edge functions are whole numbers below 2^53 here too; the quotients that say where they change
    sign are away from whole numbers by more than `HAIR` and known to less.
    """
    stride = out_keys.shape[1]
    over_ab = 1.0 / abx if abx != 0.0 else 0.0
    over_bc = 1.0 / bcx if bcx != 0.0 else 0.0
    over_ca = 1.0 / cax if cax != 0.0 else 0.0
    wide = float(right - left)
    for v in range(top, bottom + 1):
        begin = max(first_inside(ab, over_ab, abx), first_inside(bc, over_bc, bcx))
        begin = max(begin, first_inside(ca, over_ca, cax), 0.0)
        end = min(last_inside(ab, over_ab, abx), last_inside(bc, over_bc, bcx))
        end = min(end, last_inside(ca, over_ca, cax), wide)
        if begin <= end:
            d = ad + db * ca + dc * ab + step * begin
            at = v * stride + left + np.int64(begin)
            count = np.int64(end - begin) + 1
            for i in range(0, count, 8):
                max_keys8(out_keys, at + i, ramp8() * F(step) + F(d + step * i), F(count - i), low)
        ab += aby
        bc += bcy
        ca += cay
