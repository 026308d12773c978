"""Kernels that scan-convert a reference's surface: which disparity each desired pixel sees.

Cells of four samples are two small triangles of disparity (`_quads`); cells with an edge through
them are drawn in parts (`_parts`), which also tell how much of a pixel they cover (`_masks`).
Colours are looked up later, backwards through the disparity (`_lookup`).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import INTACT, RIM, list_set
from belvedere.warp._masks import mask_quad
from belvedere.warp._quads import RUN, SURE, UNSURE, draw_large, paint_quads, test_quads
from belvedere.warp._tiles import TILE

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]
U2 = npt.NDArray[np.uint16]

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
NAN = np.float32(np.nan)


@inner
def land_row(
    w: F4, disparity: F4, v: int, u_low: int, count: int, ramp: F4, out_x: F4, out_y: F4, out_z: F4
) -> None:
    """Where ``count`` samples of row v from column u_low on land, and their warped disparities.

    NaN behind the eye. ramp is 0, 1, 2, ...: counting in whole numbers does not vectorise well.
    """
    row = disparity[v, u_low:]
    v4, u4 = np.float32(v), np.float32(u_low)
    r0, s0, t0 = w[1] * v4 + w[2], w[5] * v4 + w[6], w[9] * v4 + w[10]
    for i in range(count):
        u, delta = u4 + ramp[i], row[i]
        t = w[8] * u + t0 + w[11] * delta
        scale = ONE / t if t > ZERO else NAN
        out_x[i] = (w[0] * u + r0 + w[3] * delta) * scale
        out_y[i] = (w[4] * u + s0 + w[7] * delta) * scale
        out_z[i] = delta * scale


@inner
def misses_rows(ya: F4, yb: F4, count: int, first: int, end: int) -> bool:
    """Whether no cell between two rows of samples, which land at ya and yb, meets the rows.

    In whole numbers, whose least and greatest are found many at once.
    """
    low, high, strange = np.int32(1 << 30), np.int32(-(1 << 30)), np.int32(0)
    for i in range(count):
        a, b = ya[i], yb[i]
        good = abs(a) + abs(b) < np.float32(1e9)  # neither behind the eye nor missing
        upper, lower = np.int32(a if good else ZERO), np.int32(b if good else ZERO)
        low = min(low, upper, lower)
        high = max(high, upper, lower)
        strange |= np.int32(not good)
    return bool(strange == 0) and bool(high + 2 < first or low - 2 > end)


@inner
def land_parts(w: F4, parts: F4, begin: int, count: int, out_corners: F4) -> None:
    """Where the corners of ``count`` parts land: (12, RUN) x, y, disparity of each, NaN behind.

    In place, in an array of its own: so it vectorises.
    """
    w0, w1, w2, w3, w4, w5 = w[0], w[1], w[2], w[3], w[4], w[5]
    w6, w7, w8, w9, w10, w11 = w[6], w[7], w[8], w[9], w[10], w[11]
    first = np.uint64(begin)  # a signed sum might be an index from the end
    for k in range(12):
        for i in range(count):
            out_corners[k, i] = parts[k, first + np.uint64(i)]
    for c in range(4):
        for i in range(RUN):
            u, v, delta = (
                out_corners[3 * c, i],
                out_corners[3 * c + 1, i],
                out_corners[3 * c + 2, i],
            )
            t = w8 * u + w9 * v + w10 + w11 * delta
            scale = ONE / t if t > ZERO else NAN
            out_corners[3 * c, i] = (w0 * u + w1 * v + w2 + w3 * delta) * scale
            out_corners[3 * c + 1, i] = (w4 * u + w5 * v + w6 + w7 * delta) * scale
            out_corners[3 * c + 2, i] = delta * scale


@kernel
def draw_parts(
    w: F4, parts: F4, near: U1, ends: I4, tiles: I4, row_low: int, row_high: int, tolerance: Real,
    out: F4, out_edge: F4, out_mask: U2,
) -> None:  # fmt: skip
    """As `draw_surface`, the parts of broken cells.

    parts is (CORNERS, n), near (n,) and ends (tiles down, tiles across), of `_parts`.
    """
    keep = ONE - np.float32(tolerance)
    width = out.shape[1]
    flat, flat_ends = out.reshape(-1), ends.reshape(-1)
    q = np.full((12, RUN), NAN, np.float32)
    corner, zs = np.zeros((2, RUN), np.float32), np.zeros((5, RUN), np.float32)
    places, hits, spans = (
        np.zeros((2, RUN), np.int32), np.zeros(RUN, np.int32), np.zeros(RUN, np.int32)
    )  # fmt: skip
    drawn, more = np.zeros(RUN, np.uint8), np.zeros(RUN, np.uint8)
    listed, steps = np.zeros(RUN, np.int32), np.zeros((4, 16), np.float32)
    for n in range(tiles.shape[0]):
        if tiles[n, 7] <= row_low or tiles[n, 6] >= row_high:
            continue
        first, end = max(tiles[n, 6], row_low), min(tiles[n, 7], row_high)
        tile = tiles[n, 3] // TILE * ends.shape[1] + tiles[n, 0] // TILE
        begin, close = int(flat_ends[tile - 1]) if tile > 0 else 0, int(flat_ends[tile])
        while begin < close:
            count = min(RUN, close - begin)
            land_parts(w, parts, begin, count, q)
            for i in range(RUN):
                drawn[i] = i < count
            test_quads(
                q[0], q[1], q[2], q[3], q[4], q[5], q[6], q[7], q[8], q[9], q[10], q[11], drawn,
                UNSURE, width, row_low, first, end, corner, zs, places, hits, spans,
            )  # fmt: skip
            paint_quads(zs, places, hits, width, more, listed, flat)
            for i in range(count):
                if spans[i] < 0:
                    continue
                if near[begin + i]:
                    mask_quad(
                        q[0, i], q[1, i], q[2, i], q[3, i], q[4, i], q[5, i], q[6, i], q[7, i],
                        q[8, i], q[9, i], q[10, i], width, row_low, first, end, keep, UNSURE,
                        steps, out_edge, out_mask,
                    )  # fmt: skip
                if spans[i] > 2:
                    draw_large(
                        q[0, i], q[1, i], q[2, i], q[3, i], q[4, i], q[5, i], q[6, i], q[7, i],
                        q[8, i], q[9, i], q[10, i], q[11, i], corner[0, i], corner[1, i], spans[i],
                        width, row_low, first, end, UNSURE, out,
                    )  # fmt: skip
            begin += count


@kernel
def draw_surface(
    w: F4, disparity: F4, links: U1, tiles: I4, row_low: int, row_high: int, tolerance: Real,
    out: F4, out_edge: F4, out_mask: U2,
) -> None:  # fmt: skip
    """Disparity that each pixel of the band sees of the intact cells of one reference.

    Args:
        w: (12,) warp matrix.
        disparity: (H, W), small gaps bridged.
        links: (H, W) bits of `_edges`.
        tiles: (n, FIELDS), whole ones, in any order.
        row_low: first row of the band.
        row_high: row after its last.
        tolerance: relative difference in disparity up to which two cells are one surface.
        out: (rows, width) preset to -1.
        out_edge: (rows, width) nearest disparity of what was drawn at rims, preset to -1.
        out_mask: (rows, width) which sixteenths of the pixel it covers; read where out_edge >= 0.
    """
    keep = ONE - np.float32(tolerance)
    rows, stride = disparity.shape
    width = out.shape[1]
    flat = out.reshape(-1)
    ends = np.zeros((6, RUN + 1), np.float32)
    xa, ya, za, xb, yb, zb = ends[0], ends[1], ends[2], ends[3], ends[4], ends[5]
    corner, zs = np.zeros((2, RUN), np.float32), np.zeros((5, RUN), np.float32)
    places, hits, spans = (
        np.zeros((2, RUN), np.int32), np.zeros(RUN, np.int32), np.zeros(RUN, np.int32)
    )  # fmt: skip
    drawn, more = np.zeros(RUN, np.uint8), np.zeros(RUN, np.uint8)
    listed, steps = np.zeros(RUN, np.int32), np.zeros((4, 16), np.float32)
    ramp = np.arange(RUN + 1).astype(np.float32)
    for n in range(tiles.shape[0]):
        if tiles[n, 7] <= row_low or tiles[n, 6] >= row_high:
            continue
        first, end = max(tiles[n, 6], row_low), min(tiles[n, 7], row_high)
        straddles = tiles[n, 6] < row_low or tiles[n, 7] > row_high
        u_low = tiles[n, 0]
        across = min(tiles[n, 1], stride - 1) - u_low
        land_row(w, disparity, tiles[n, 3], u_low, across + 1, ramp, xb, yb, zb)
        for v in range(tiles[n, 3], min(tiles[n, 4], rows - 1)):
            for i in range(RUN + 1):
                xa[i], ya[i], za[i] = xb[i], yb[i], zb[i]
            land_row(w, disparity, v + 1, u_low, across + 1, ramp, xb, yb, zb)
            if straddles and misses_rows(ya, yb, across + 1, first, end):
                continue
            row = links[v, u_low:]
            for i in range(RUN):
                drawn[i] = row[i] & INTACT if i < across else 0
            test_quads(
                xa, ya, za, xa[1:], ya[1:], za[1:], xb, yb, zb, xb[1:], yb[1:], zb[1:], drawn,
                SURE, width, row_low, first, end, corner, zs, places, hits, spans,
            )  # fmt: skip
            paint_quads(zs, places, hits, width, more, listed, flat)
            for i in range(RUN):
                rim = i < across and row[i] & RIM != 0
                more[i] = np.uint8((rim & (spans[i] >= 0)) | (spans[i] > 2))
            for k in range(list_set(more, listed)):
                i = listed[k]
                if row[i] & RIM:
                    mask_quad(
                        xa[i], ya[i], za[i], xa[i + 1], ya[i + 1], za[i + 1], xb[i], yb[i], zb[i],
                        xb[i + 1], yb[i + 1], width, row_low, first, end, keep, SURE, steps,
                        out_edge, out_mask,
                    )  # fmt: skip
                if spans[i] > 2:
                    draw_large(
                        xa[i], ya[i], za[i], xa[i + 1], ya[i + 1], za[i + 1], xb[i], yb[i], zb[i],
                        xb[i + 1], yb[i + 1], zb[i + 1], corner[0, i], corner[1, i], int(spans[i]),
                        width, row_low, first, end, SURE, out,
                    )  # fmt: skip
