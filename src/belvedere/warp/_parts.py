"""Kernels that cut the cells of a reference at its edges, once, whatever the desired view.

A cell of four samples with an edge through it is no quad any more: each sample owns what lies on
its side, up to where the edge runs. Two linked samples own a half together, a lonely one its
quarter. Such parts are quads too, with corners between the samples.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import (
    DOWN,
    INTACT,
    MIXED,
    RIGHT,
    RIM,
    all_set,
    beyond,
    joined,
    slope_toward,
    usable,
)
from belvedere.warp._matte import reach_toward
from belvedere.warp._tiles import TILE

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
CORNERS = 12
"""Rows of a table of parts: u, v, disparity of the upper left corner, the upper right, the lower
left, the lower right."""


@inner
def put(parts: F4, n: int, corner: int, u: Real, v: Real, delta: Real) -> None:
    """Write a corner of part n."""
    parts[3 * corner, n] = u
    parts[3 * corner + 1, n] = v
    parts[3 * corner + 2, n] = max(delta, ZERO)


@inner
def cut_half(
    disparity: F4, links: U1, right: U1, down: U1, v: int, u: int, lv: int, lu: int, ev: int,
    eu: int, n: int, out_parts: F4, out_near: U1,
) -> None:  # fmt: skip
    """Part n: what the linked samples (v, u), (v + lv, u + lu) own toward the edge (ev, eu)."""
    near = False
    # corners 0 and 1 above, 2 and 3 below; a side of the half is a row or a column of the quad
    step, start = (2, 1) if lv > 0 else (1, 2)
    inside, outside = (0, start) if eu + ev > 0 else (start, 0)
    for side in range(2):
        vs, us = v + side * lv, u + side * lu
        reach = reach_toward(right, down, vs, us, ev, eu)
        own = disparity[vs, us]
        near |= own > disparity[vs + ev, us + eu]
        slope = ZERO
        if joined(links, vs, us, -ev, -eu):
            slope = own - disparity[vs - ev, us - eu]
        u4, v4 = np.float32(us), np.float32(vs)
        put(out_parts, n, side * step + inside, u4, v4, own)
        u4, v4 = u4 + reach * np.float32(eu), v4 + reach * np.float32(ev)
        put(out_parts, n, side * step + outside, u4, v4, own + reach * slope)
    out_near[n] = np.uint8(near)


@inner
def cut_quarter(
    disparity: F4, links: U1, right: U1, down: U1, v: int, u: int, dv: int, du: int, n: int,
    out_parts: F4, out_near: U1,
) -> None:  # fmt: skip
    """Part n: the quarter that sample (v, u) owns of the cell toward (dv, du), each +-1."""
    across = slope_toward(disparity, links, v, u, 0, du)
    along = slope_toward(disparity, links, v, u, dv, 0)
    # where linked, the neighbour owns the other half; at the corner both agree on the edge
    reach_u = reach_toward(right, down, v, u, 0, du)
    reach_v = reach_toward(right, down, v, u, dv, 0)
    corner_u, corner_v = reach_u, reach_v
    if joined(links, v, u, 0, du):
        reach_u = corner_u = HALF
        if not joined(links, v, u + du, dv, 0):
            corner_v = HALF * (reach_v + reach_toward(right, down, v, u + du, dv, 0))
    if joined(links, v, u, dv, 0):
        reach_v = corner_v = HALF
        if not joined(links, v + dv, u, 0, du):
            corner_u = HALF * (reach_u + reach_toward(right, down, v + dv, u, 0, du))
    for corner in range(4):
        # a corner seen from the sample: is it away from it along u, along v?
        away_u = (corner & 1) == (1 if du > 0 else 0)
        away_v = (corner >> 1) == (1 if dv > 0 else 0)
        far_u = (corner_u if away_v else reach_u) if away_u else ZERO
        far_v = (corner_v if away_u else reach_v) if away_v else ZERO
        u4 = np.float32(u) + far_u * np.float32(du)
        v4 = np.float32(v) + far_v * np.float32(dv)
        put(out_parts, n, corner, u4, v4, disparity[v, u] + far_u * across + far_v * along)
    near = beyond(disparity, links, v, u, dv, 0) or beyond(disparity, links, v, u, 0, du)
    if joined(links, v, u, 0, du):
        near = near or beyond(disparity, links, v, u + du, dv, 0)
    if joined(links, v, u, dv, 0):
        near = near or beyond(disparity, links, v + dv, u, 0, du)
    out_near[n] = np.uint8(near or (links[v, u] & RIM) != 0)


@inner
def cut_cell(
    disparity: F4, links: U1, right: U1, down: U1, v: int, u: int, n: int, out_parts: F4,
    out_near: U1,
) -> int:  # fmt: skip
    """Parts of the broken cell at (v, u), from number n on; returns the number after the last."""
    rows, stride = disparity.shape
    if 0 <= v < rows - 1 and 0 <= u < stride - 1:
        here, beside, below = links[v, u], links[v, u + 1], links[v + 1, u]
        mixed = (here | beside | below | links[v + 1, u + 1]) & MIXED
        upright = here & beside & DOWN and not (here | below) & RIGHT
        level = here & below & RIGHT and not (here | beside) & DOWN
        if not mixed and (upright or level):
            lv, lu = (1, 0) if upright else (0, 1)
            for side in range(2):
                away = 1 - 2 * side
                cut_half(
                    disparity, links, right, down, v + side * lu, u + side * lv, lv, lu,
                    away * lu, away * lv, n + side, out_parts, out_near,
                )  # fmt: skip
            return n + 2
    for corner in range(4):
        dv, du = corner >> 1, corner & 1
        if usable(disparity, links, v + dv, u + du):
            cut_quarter(
                disparity, links, right, down, v + dv, u + du, 1 - 2 * dv, 1 - 2 * du, n,
                out_parts, out_near,
            )  # fmt: skip
            n += 1
    return n


@kernel
def count_broken(links: U1, tile_row: int) -> int:
    """Cells of a row of tiles that are not intact, those along the picture's border included."""
    height, width = links.shape
    count = 0
    for v in range(tile_row * TILE, min((tile_row + 1) * TILE, height)):
        for u in range(width):
            count += 0 if links[v, u] & INTACT else 1
    border = 2 * TILE + (width + 1 if tile_row == 0 else 0)
    return count + border


@kernel
def cut_tiles(
    disparity: F4, links: U1, right: U1, down: U1, tile_row: int, out_parts: F4, out_near: U1,
    out_end: I4,
) -> int:  # fmt: skip
    """Parts of all broken cells of a row of tiles, tile by tile; returns how many.

    Cells go by their upper left sample; those left of the first column and above the first row of
    samples belong to the first tiles.

    Args:
        disparity: (H, W), small gaps bridged.
        links: (H, W) bits of `_edges`.
        right: (H, W) where edges run, of `_matte`.
        down: (H, W).
        tile_row: which.
        out_parts: (CORNERS, n) with room for four parts of each of `count_broken` cells.
        out_near: (n,) 1 where a part is the near side of its edge.
        out_end: (tiles across,) number after the last part of each tile.
    """
    height, width = disparity.shape
    flat, n = links.reshape(-1), 0
    for tu in range(out_end.size):
        last = min((tu + 1) * TILE, width)
        for v in range(tile_row * TILE - (tile_row == 0), min((tile_row + 1) * TILE, height)):
            if v >= 0 and tu > 0 and all_set(flat, v * width + tu * TILE, last - tu * TILE, INTACT):
                continue
            for u in range(tu * TILE - (tu == 0), last):
                if v < 0 or u < 0 or not links[v, u] & INTACT:
                    n = cut_cell(disparity, links, right, down, v, u, n, out_parts, out_near)
        out_end[tu] = n
    return n
