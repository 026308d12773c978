"""Loops that fill triangles: pixels won by the larger disparity.

Private. Edge functions are exact, so that of two triangles that share an edge exactly one covers
each pixel center on it (the top-left rule), whatever clusters they come from.

A pixel is one whole number, its key: the bits of its disparity (positive floats are ordered as
their bits are), then a number that is larger for a smaller face. The largest key wins, so that the
order in which triangles are drawn changes nothing, where two coincide neither.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.eight import max_keys8, ramp8
from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import bits_of, float_of
from belvedere.model._raster_setup import SHIFT, SUB, TILE

A = npt.NDArray[Any]
F = np.float32

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

    Args as in `_raster_setup.set_up`; ``out_keys`` is (H, W and more) int64.
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
