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
    MARGIN,
    bounds,
    even_need,
    land_corners,
    lay_columns,
    longest_sides,
    may_meet,
    nearest_step,
    rows_of_run,
    run_need,
)
from belvedere.warp._offset_quarters import fill_broken
from belvedere.warp._offset_wide import APART, fine_part, read_wide
from belvedere.warp._offset_word import IN_CELL, back_word, front_word, mark
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
def leave_out_broken(count: int, whole: U4, cell: U4, out: F4) -> None:
    """NaN for the disparity of each sub-sample of a broken cell."""
    for m in range(count):
        out[m] = out[m] if whole[cell[m]] != np.uint32(0) else NAN


@inner
def even_row(row: F4, whole: U4, fu: Real, out: F4) -> None:
    """Disparities at one place in every cell of a run along a row of samples; NaN in broken ones.

    Cells beyond the run's end are landed too, and claimed by nobody.
    """
    for m in range(TILE):
        left = row[m]
        value = left + fu * (row[m + 1] - left)
        out[m] = value if whole[m] != np.uint32(0) else NAN


@inner
def spread_row(row: F4, count: int, cell: U4, fu: F4, out: F4) -> None:
    """Disparities of ``count`` sub-samples along a row of samples, linear between them."""
    for m in range(count):
        left = row[cell[m]]
        out[m] = left + fu[m] * (row[np.uint32(cell[m] + np.uint32(1))] - left)


@inner
def land_row(
    w: F4, u_first: Real, v4: Real, fv: Real, upper: F4, lower: F4, at: F4, layout: Any,
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
    right, top, bottom = np.float32(columns) * places, first * places, end * places
    r0, s0, t0 = w[1] * v4 + w[2], w[5] * v4 + w[6], w[9] * v4 + w[10]
    for m in range(count):
        u = u_first + at[m]
        delta = upper[m] + fv * (lower[m] - upper[m])
        t = w[8] * u + t0 + w[11] * delta
        scale = ONE / t
        x = ((w[0] * u + r0 + w[3] * delta) * scale + MARGIN) * fine
        y = ((w[4] * u + s0 + w[7] * delta) * scale + MARGIN) * fine
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
def spread_wide(count: int, wide: U8, cell: U4, out: U8) -> None:
    """Whether each of some sub-samples is wide, from its cell."""
    for m in range(count):
        out[m] = wide[cell[m]]


@inner
def complete_words(
    count: int, fronts: U4, number: U8, wide: U8, base: Real, shift: Real, out: U8
) -> None:
    """Words from what is above and below their middle."""
    for m in range(count):
        out[m] = (np.uint64(fronts[m]) << shift) | (base + number[m]) | wide[m]


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


@inner
def fill_tile(
    w: F4, disparity: F4, links: U1, v_low: int, v_high: int, u_low: int, u_high: int,
    density: int, most: Real, b4: Real, layout: Any, row_first: int, first4: Real, end4: Real,
    columns: int, lanes: F4, corners: F4, column_cell: U4, cells: U4, fronts: U4, number: U8,
    words: U8, wides: U8, whole: U4, wide: U8, ample: U1, column: U1, places: F4, cell_numbers: U8,
    out_word: U8,
) -> None:  # fmt: skip
    """Sub-samples of the intact cells of a tile: rows of cells one by one, down it.

    Args:
        w: (12,) warp matrix.
        disparity: (H, W).
        links: (H, W) bits of `_edges`.
        v_low: the tile's first row of samples.
        v_high: row after its last.
        u_low: its first column.
        u_high: column after its last.
        density: sub-samples per pixel and axis, even; 0: what each run needs.
        most: upper bound of what a run may need.
        b4: cells per output pixel and axis.
        layout: of words.
        row_first: first row of cells of the band.
        first4: first row of the buffer's cells that the tile may land in.
        end4: row after the last.
        columns: cells across.
        lanes: (4, room) to work in, and so are those that follow.
        corners: (6, TILE + 1).
        column_cell: (room,).
        cells: (room,).
        fronts: (room,).
        number: (room,).
        words: (room,).
        wides: (room,), 0.
        whole: (TILE,).
        wide: (TILE,).
        ample: (TILE,).
        column: (TILE + 2 APART,).
        places: (TILE,) 0, 1, 2 and so on.
        cell_numbers: (TILE,) the same as words have them.
        out_word: see `fill_offset_buffer`.
    """
    rows, stride = disparity.shape
    nowhere, low_bits = out_word.size - 1, np.uint64(layout.low)
    at, fus, upper, lower = lanes[0], lanes[1], lanes[2], lanes[3]
    xa, ya, da = corners[0], corners[1], corners[2]
    xb, yb, db = corners[3], corners[4], corners[5]
    laid, laid_across = 0, 0
    across = min(u_high, stride - 1) - u_low
    # sub-samples from here to the next row of them, of either lattice
    ahead, wide_ahead = HALF, HALF
    if across <= 0:
        return
    land_corners(w, disparity[v_low, u_low:], v_low, u_low, across + 1, xb, yb, db)
    left_b, right_b = bounds(xb, across + 1)
    top_b, bottom_b = bounds(yb, across + 1)
    last = min(v_high, rows - 1) - 1
    for v in range(v_low, last + 1):
        xa, ya, da, xb, yb, db = xb, yb, db, xa, ya, da
        left_a, right_a, top_a, bottom_a = left_b, right_b, top_b, bottom_b
        land_corners(w, disparity[v + 1, u_low:], v + 1, u_low, across + 1, xb, yb, db)
        left_b, right_b = bounds(xb, across + 1)
        top_b, bottom_b = bounds(yb, across + 1)
        all_whole, any_whole = read_whole(links[v, u_low:], across, whole)
        if not any_whole:
            ahead, wide_ahead = HALF, HALF
            continue
        ux, uy, vx, vy = longest_sides(xa, ya, xb, yb, across, whole)
        meets = may_meet(
            min(left_a, left_b), max(right_a, right_b), min(top_a, top_b),
            max(bottom_a, bottom_b), ux + uy + vx + vy, b4, first4, end4, np.float32(columns),
        )  # fmt: skip
        fine, fine_end, some_wide = 0, across, False
        if density == 0:
            some_wide = read_wide(links[v, u_low:], xa, ya, xb, yb, across, wide, ample)
            if some_wide:
                fine, fine_end = fine_part(links, v, u_low, across, ample, column)
        # sub-samples at the same places in every cell, for wide ones
        slots, start, nv = 0, ZERO, ZERO
        if some_wide:
            slots, nv = even_need(ux, uy, vx, vy, most)
            nv, wide_next = rows_of_run(wide_ahead, nv, v == last)
            start = wide_ahead if meets else nv
            wide_ahead = wide_next
        else:
            wide_ahead = HALF
        for slot in range(slots):
            fu = (np.float32(np.int32(slot)) + HALF) / np.float32(np.int32(slots))
            at_row, step_u = start, nearest_step(fu)
            if at_row >= nv:
                break
            even_row(da, whole, fu, upper)
            even_row(db, whole, fu, lower)
            while at_row < nv:
                fv = at_row / nv
                base = back_word(v, u_low, nearest_step(fv), step_u, layout)
                land_row(
                    w, np.float32(u_low) + fu, np.float32(v) + fv, fv, upper, lower, places,
                    layout, b4, row_first, first4, end4, columns, nowhere, TILE, cells, fronts,
                )  # fmt: skip
                complete_words(TILE, fronts, cell_numbers, wide, base, low_bits, words)
                claim_row(across, cells, words, out_word)
                at_row += ONE
        if fine >= fine_end:
            ahead = HALF
            continue
        nu, nv = run_need(ux, uy, vx, vy, b4, most)
        if density > 0:
            nu, nv = np.float32(density), np.float32(density)
        start = ahead
        nv, ahead = rows_of_run(start, nv, v == last)
        if not meets or start >= nv:
            continue
        part, from_u = fine_end - fine, u_low + fine
        count = int(np.ceil(nu * np.float32(part)))
        padded = -(-count // LANES) * LANES
        if count != laid or part != laid_across:
            lay_columns(count, padded, part, column_cell, at, fus, number)
            laid, laid_across = count, part
        spread_row(da[fine:], padded, column_cell, fus, upper)
        spread_row(db[fine:], padded, column_cell, fus, lower)
        if not all_whole:
            leave_out_broken(count, whole[fine:], column_cell, upper)
        if density == 0:
            spread_wide(count, wide[fine:], column_cell, wides)
        while start < nv:
            fv = start / nv
            base = back_word(v, from_u, nearest_step(fv), 0, layout)
            land_row(
                w, np.float32(from_u), np.float32(v) + fv, fv, upper, lower, at, layout, b4,
                row_first, first4, end4, columns, nowhere, padded, cells, fronts,
            )  # fmt: skip
            complete_words(padded, fronts, number, wides, base, low_bits, words)
            claim_row(count, cells, words, out_word)
            start += ONE


@kernel
def fill_offset_buffer(
    w: F4, disparity: F4, links: U1, tiles: I4, row_first: int, height: int, density: int,
    largest: int, scale_b: int, layout: Any, columns: int, out_word: U8,
) -> None:  # fmt: skip
    """Warp every sub-sample that can reach the band into its warp buffer.

    Rows of cells count from `MARGIN` above the whole desired view, and positions are rounded before
    the band comes in, so that they are the same for every band.

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
    row_end = row_first + (out_word.size - 1) // columns
    room = max(density, largest) * TILE + LANES
    column_cell, number = np.zeros(room, np.uint32), np.zeros(room, np.uint64)
    cells, fronts = np.empty(room, np.uint32), np.empty(room, np.uint32)
    words, wides = np.empty(room, np.uint64), np.zeros(room, np.uint64)
    lanes, corners = np.zeros((4, room), np.float32), np.zeros((6, TILE + 1), np.float32)
    whole, wide = np.zeros(TILE, np.uint32), np.zeros(TILE, np.uint64)
    places, cell_numbers = np.arange(TILE).astype(np.float32), np.empty(TILE, np.uint64)
    for m in range(TILE):
        cell_numbers[m] = np.uint64(m) << np.uint64(2 * IN_CELL + 1)
    ample = np.zeros(TILE, np.uint8)
    column = np.zeros(TILE + 2 * APART, np.uint8)
    for n in range(tiles.shape[0]):
        # what float32 lands outside the tile's float64 bounds is noise: the same for every band
        first = max((tiles[n, 6] + 1) * scale_b if tiles[n, 6] > 0 else 0, row_first)
        end = min(tiles[n, 7] * scale_b, row_end) if tiles[n, 7] < height else row_end
        if first >= end:
            continue
        first4, end4 = np.float32(first), np.float32(end)
        u_low, u_high = tiles[n, 0], tiles[n, 1]
        fill_tile(
            w, disparity, links, tiles[n, 3], tiles[n, 4], u_low, u_high, density, most, b4, layout,
            row_first, first4, end4, columns, lanes, corners, column_cell, cells, fronts, number,
            words, wides, whole, wide, ample, column, places, cell_numbers, out_word,
        )  # fmt: skip
        fill_broken(
            w, disparity, links, tiles[n, 3], tiles[n, 4], u_low, u_high, density, most, b4,
            layout, row_first, first4, end4, columns, out_word,
        )  # fmt: skip
