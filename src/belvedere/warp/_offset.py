"""The kernel that fills the offset buffer: visibility in a grid finer than the picture.

Sub-samples are taken a row at a time, through all the cells between two rows of samples in a tile,
so that landing them is arithmetic on whole vectors; then each claims its cell of the buffer.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import mul32, shr32
from belvedere.warp._edges import INTACT
from belvedere.warp._offset_lattice import (
    bounds,
    land_corners,
    lay_columns,
    may_meet,
    nearest_step,
    rows_of_run,
    run_need,
)
from belvedere.warp._offset_quarters import fill_broken
from belvedere.warp._offset_word import back_word, front_word, mark
from belvedere.warp._tiles import TILE

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]
U4 = npt.NDArray[np.uint32]
U8 = npt.NDArray[np.uint64]

ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
NAN = np.float32(np.nan)
MOST = np.float32(1e30)
"""Largest warped disparity: beyond, a sub-sample is at the eye."""


LANES = 16
"""Sub-samples that are landed at once, at most; a row is filled up with some that nobody claims."""


@inner
def read_whole(flags: U1, count: int, out_whole: U4) -> tuple[bool, bool]:
    """Which cells of a row of `_edges` bits are intact, as masks; whether all are, and any."""
    every, some = np.uint32(0xFFFFFFFF), np.uint32(0)
    for i in range(count):
        out_whole[i] = np.uint32(0xFFFFFFFF if flags[i] & INTACT else 0)
        every, some = np.uint32(every & out_whole[i]), np.uint32(some | out_whole[i])
    return every != np.uint32(0), some != np.uint32(0)


@inner
def leave_out_broken(count: int, whole: U4, cell: U4, out_gone: F4) -> None:
    """NaN, to be added to a disparity, for each sub-sample of a broken cell, else 0."""
    for m in range(count):
        out_gone[m] = ZERO if whole[cell[m]] != np.uint32(0) else NAN


@inner
def spread_row(row: F4, count: int, cell: U4, fu: F4, out: F4) -> None:
    """Disparities of ``count`` sub-samples along a row of samples, linear between them."""
    for m in range(count):
        left = row[cell[m]]
        out[m] = left + fu[m] * (row[np.uint32(cell[m] + np.uint32(1))] - left)


@inner
def land_row(
    w: F4, u_low: int, v4: Real, fv: Real, upper: F4, lower: F4, gone: F4, at: F4, layout: Any,
    scale_b: Real, row_first: int, first: Real, end: Real, columns: int, nowhere: int, count: int,
    out_cell: U4, out_front: U4,
) -> None:  # fmt: skip
    """Cell (or ``nowhere``) and front of the word of each sub-sample of a row.

    Disparity is linear between upper and lower, those of the sub-samples' columns above and below.
    Straight-line arithmetic on 32 bits on purpose: it vectorises.
    """
    low, wide, none = np.int32(row_first), np.uint32(columns), np.uint32(nowhere)
    places, bits = np.float32(1 << layout.bits), np.uint32(layout.bits)
    fine = scale_b * places
    right, top, bottom, u_first = (
        np.float32(columns) * places,
        first * places,
        end * places,
        np.float32(u_low),
    )
    r0, s0, t0 = w[1] * v4 + w[2], w[5] * v4 + w[6], w[9] * v4 + w[10]
    for m in range(count):
        u = u_first + at[m]
        delta = upper[m] + fv * (lower[m] - upper[m]) + gone[m]
        t = w[8] * u + t0 + w[11] * delta
        scale = ONE / t
        x = ((w[0] * u + r0 + w[3] * delta) * scale + ONE) * fine
        y = ((w[4] * u + s0 + w[7] * delta) * scale + ONE) * fine
        inside = (t > ZERO) & (x >= ZERO) & (y >= top) & (x < right) & (y < bottom)
        fine_u = np.uint32(np.int32(x if inside else ZERO))
        fine_v = np.uint32(np.int32(y if inside else top))
        row, column = shr32(fine_v, bits), shr32(fine_u, bits)
        cell = np.uint32(mul32(np.uint32(np.int32(row) - low), wide) + column)
        warped = delta * scale
        warped = warped if warped < MOST else MOST
        out_front[m] = front_word(warped, mark(fine_u, fine_v, layout), layout)
        out_cell[m] = cell if inside else none


@inner
def complete_words(count: int, fronts: U4, number: U8, base: Real, shift: Real, out: U8) -> None:
    """Words from what is above and below their middle."""
    for m in range(count):
        out[m] = (np.uint64(fronts[m]) << shift) | (base + number[m])


@inner
def claim_row(count: int, cells: U4, words: U8, out_word: U8) -> None:
    """Let the sub-samples of a row claim their cells.

    Every second one first: neighbours may claim one cell, and each would wait for what the other
    has just written there.
    """
    for start in range(2):
        for m in range(start, count, 2):
            cell = cells[m]
            out_word[cell] = max(out_word[cell], words[m])


@kernel
def fill_offset_buffer(
    w: F4, disparity: F4, links: U1, tiles: I4, row_first: int, height: int, density: int,
    largest: int, scale_b: int, layout: Any, columns: int, out_word: U8,
) -> None:  # fmt: skip
    """Warp every sub-sample that can reach the band into its warp buffer.

    Rows of cells count from one output pixel above the whole desired view, and positions are
    rounded before the band comes in, so that they are the same for every band.

    Args:
        w: (12,) warp matrix.
        disparity: (H, W).
        links: (H, W) bits of `_edges`.
        tiles: (n, FIELDS), in any order.
        row_first: first row of cells of the band; nothing lands in rows below 0.
        height: of the desired view.
        density: sub-samples per pixel and axis (the paper's a), even; 0: what each run needs.
        largest: upper bound of what a run may need.
        scale_b: cells per output pixel and axis (b), even.
        layout: of words.
        columns: cells across.
        out_word: (cells_v * cells_u + 1,) preset to EMPTY; the last takes what lands outside.
    """
    b4, most = np.float32(scale_b), np.float32(largest)
    nowhere = out_word.size - 1
    row_end = row_first + nowhere // columns
    rows, stride = disparity.shape
    room = max(density, largest) * TILE + LANES
    column_cell, number = np.zeros(room, np.uint32), np.zeros(room, np.uint64)
    cells, fronts = np.empty(room, np.uint32), np.empty(room, np.uint32)
    words = np.empty(room, np.uint64)
    lanes, corners = np.zeros((5, room), np.float32), np.zeros((6, TILE + 1), np.float32)
    at, fus, gone, upper, lower = lanes[0], lanes[1], lanes[2], lanes[3], lanes[4]
    xa, ya, da = corners[0], corners[1], corners[2]
    xb, yb, db = corners[3], corners[4], corners[5]
    whole = np.zeros(TILE, np.uint32)
    left_b, right_b, top_b, bottom_b = ZERO, ZERO, ZERO, ZERO
    laid, laid_across, holed = 0, 0, False
    for n in range(tiles.shape[0]):
        # what float32 lands outside the tile's float64 bounds is noise: the same for every band
        first = max((tiles[n, 6] + 1) * scale_b if tiles[n, 6] > 0 else 0, row_first)
        end = min(tiles[n, 7] * scale_b, row_end) if tiles[n, 7] < height else row_end
        if first >= end:
            continue
        first4, end4 = np.float32(first), np.float32(end)
        u_low, u_high = tiles[n, 0], tiles[n, 1]
        across = min(u_high, stride - 1) - u_low
        ahead = HALF  # sub-samples from here to the next row of them
        if across > 0:
            land_corners(
                w, disparity[tiles[n, 3], u_low:], tiles[n, 3], u_low, across + 1, xb, yb, db
            )
            left_b, right_b = bounds(xb, across + 1)
            top_b, bottom_b = bounds(yb, across + 1)
        last = min(tiles[n, 4], rows - 1) - 1
        for v in range(tiles[n, 3], last + 1):
            if across <= 0:
                break
            xa, ya, da, xb, yb, db = xb, yb, db, xa, ya, da
            left_a, right_a, top_a, bottom_a = left_b, right_b, top_b, bottom_b
            land_corners(w, disparity[v + 1, u_low:], v + 1, u_low, across + 1, xb, yb, db)
            left_b, right_b = bounds(xb, across + 1)
            top_b, bottom_b = bounds(yb, across + 1)
            all_whole, any_whole = read_whole(links[v, u_low:], across, whole)
            if not any_whole:
                ahead = HALF
                continue
            nu, nv, size = run_need(xa, ya, xb, yb, across, whole, b4, most)
            meets = may_meet(
                min(left_a, left_b), max(right_a, right_b), min(top_a, top_b),
                max(bottom_a, bottom_b), size, b4, first4, end4, np.float32(columns),
            )  # fmt: skip
            if density > 0:
                nu, nv = np.float32(density), np.float32(density)
            start = ahead
            nv, ahead = rows_of_run(start, nv, v == last)
            if not meets or start >= nv:
                continue
            count = int(np.ceil(nu * np.float32(across)))
            if count != laid or across != laid_across:
                lay_columns(count, across, column_cell, at, fus, number)
                laid, laid_across = count, across
            padded = -(-count // LANES) * LANES
            spread_row(da, padded, column_cell, fus, upper)
            spread_row(db, padded, column_cell, fus, lower)
            if not all_whole:
                leave_out_broken(count, whole, column_cell, gone)
                holed = True
            elif holed:
                gone[:] = ZERO
                holed = False
            while start < nv:
                fv = start / nv
                base = back_word(v, u_low, nearest_step(fv), 0, layout)
                land_row(
                    w, u_low, np.float32(v) + fv, fv, upper, lower, gone, at, layout, b4,
                    row_first, first4, end4, columns, nowhere, padded, cells, fronts,
                )  # fmt: skip
                complete_words(padded, fronts, number, base, np.uint64(layout.low), words)
                claim_row(count, cells, words, out_word)
                start += ONE
        fill_broken(
            w, disparity, links, tiles[n, 3], tiles[n, 4], u_low, u_high, density, most, b4,
            layout, row_first, first4, end4, columns, out_word,
        )  # fmt: skip
