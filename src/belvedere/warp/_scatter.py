"""Kernels of the scattering reconstructors: which sample each desired pixel sees.

A layer is an array of words, one a cell: a sample's warped disparity and what it carries, which is
its colour where that fits into 32 bits, else its number::

      63 62           32 31            0
      +-+--------------+---------------+
      |0| bits of d    |  carried      |        EMPTY: all bits set, so that any sample is larger
      +-+--------------+---------------+

Moving a sample is then one store, and comparing two of them one comparison of whole numbers: the
bits of floats from 0 on are ordered as the floats are.

Each kernel works on one band of the desired view with a halo round it, cells whose upper left one
is pixel (-halo, y_low). Samples are visited in occlusion-compatible order, row by row through all
tiles that stand side by side, whichever of them the band leaves out: so the result does not depend
on how the view was cut into bands, and memory is read in one go.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import bits_of
from belvedere.warp._tiles import TILE

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
I8 = npt.NDArray[np.int64]
U1 = npt.NDArray[np.uint8]
U4 = npt.NDArray[np.uint32]

HALF = np.float32(0.5)
ONE = np.float32(1.0)
ZERO = np.float32(0.0)

EMPTY = np.int64(-1)
"""The word of a cell without a sample."""
CARRIED = np.int64(0xFFFFFFFF)
"""The part of a word that is carried."""
HIGH = np.int64(32)
"""Bits above which the disparity stands."""

PLACES = np.float32(65536.0)
"""Steps of a place within its cell, per axis: finer than float32 knows it in any large view."""
SPARE = TILE
"""Cells behind a layer that take the samples that land nowhere: one for each column of a tile, so
that no two stores in a row wait for one another."""
RUN = 4
"""Columns of the table of runs; see `list_runs`."""
NOISE = 2.0**-20
"""Bound on what ``float32`` adds to a sum of four products, for each unit of their sizes: eight
roundings, each of half a step of 2^-23."""


@kernel
def pack_bytes(color: U1, out_carried: U4) -> None:
    """Colours (rows, width, 3|4) as one number each, the first channel lowest; no alpha is 0."""
    rows, width, channels = color.shape
    for y in range(rows):
        source, target = color[y], out_carried[y]
        for x in range(width):
            value = np.uint32(source[x, 0])
            value |= np.uint32(source[x, 1]) << np.uint32(8)
            value |= np.uint32(source[x, 2]) << np.uint32(16)
            target[x] = value
        if channels == 4:
            for x in range(width):
                target[x] |= np.uint32(source[x, 3]) << np.uint32(24)


@inner
def land(
    u: Real, delta: Real, carried: Real, r: Real, s: Real, t: Real, r_step: Real, s_step: Real,
    t_step: Real, r_near: Real, s_near: Real, t_near: Real, shift: Real, right: Real, top: Real,
    bottom: Real, row_low: Real, across: Real, spare: Real,
) -> tuple[Real, Real, Real]:  # fmt: skip
    """Cell, word and place of one sample; see `land_row`.

    Straight-line arithmetic on numbers alone on purpose: it vectorises, and what a caller does not
    use costs nothing.
    """
    depth = t_step * u + t + t_near * delta
    scale = ONE / depth
    x = (r_step * u + r + r_near * delta) * scale + shift
    y = (s_step * u + s + s_near * delta) * scale + shift
    inside = (depth > ZERO) & (x >= ZERO) & (x < right) & (y >= top) & (y < bottom)
    x = x if inside else ZERO
    y = y if inside else ZERO
    column, line = np.int32(x), np.int32(y)
    cell = np.int32(np.int32(np.int32(line - row_low) * across) + column)
    word = (np.int64(bits_of(abs(delta * scale))) << HIGH) | np.int64(carried)
    place_x = np.uint32(np.int32((x - np.float32(column)) * PLACES))
    place_y = np.uint32(np.int32((y - np.float32(line)) * PLACES))
    return np.uint32(cell if inside else spare), word, (place_y << np.uint32(16)) | place_x


@inner
def land_row(
    w: F4, v: int, u_low: int, disparity: F4, carried: U4, halo: int, y_low: int, columns: int,
    first: int, end: int, none: int, out_cell: U4, out_word: I8, out_place: U4 | None,
) -> None:  # fmt: skip
    """Cells, words and places of one row of a tile, (count,) each.

    Rows of pixels [first, end) count; a sample that lands outside gets one of the cells from
    ``none`` on. Places are rounded before ``y_low`` comes in: they are the same for every band.
    """
    v4, base = np.float32(v), np.float32(u_low)
    r, s, t = w[1] * v4 + w[2], w[5] * v4 + w[6], w[9] * v4 + w[10]
    r_step, s_step, t_step, r_near, s_near, t_near = w[0], w[4], w[8], w[3], w[7], w[11]
    shift = HALF + np.float32(halo)
    right, top, bottom = np.float32(columns), np.float32(first + halo), np.float32(end + halo)
    row_low, across, spare = np.int32(y_low + halo), np.int32(columns), np.int32(none)
    if out_place is not None:
        for i in range(disparity.shape[0]):
            lane = np.int32(i)
            out_cell[i], out_word[i], out_place[i] = land(
                base + np.float32(lane), disparity[i], carried[i], r, s, t, r_step, s_step, t_step,
                r_near, s_near, t_near, shift, right, top, bottom, row_low, across,
                np.int32(spare + lane),
            )  # fmt: skip
        return
    for i in range(disparity.shape[0]):
        lane = np.int32(i)
        out_cell[i], out_word[i], _ = land(
            base + np.float32(lane), disparity[i], carried[i], r, s, t, r_step, s_step, t_step,
            r_near, s_near, t_near, shift, right, top, bottom, row_low, across,
            np.int32(spare + lane),
        )  # fmt: skip


@inner
def keep_last(cells: U4, words: I8, places: U4 | None, count: int, step: int, out_word: I8,
              out_place: U4 | None) -> None:  # fmt: skip
    """Painter's: what comes later in the direction of scan replaces what is there."""
    if step > 0:
        for i in range(count):
            cell = cells[i]
            out_word[cell] = words[i]
            if out_place is not None and places is not None:
                out_place[cell] = places[i]
        return
    for i in range(count):
        back = np.uint64(count - 1 - i)  # unsigned: Numba would ask whether it counts from the end
        cell = cells[back]
        out_word[cell] = words[back]
        if out_place is not None and places is not None:
            out_place[cell] = places[back]


@inner
def keep_nearest(
    cells: U4, words: I8, places: U4 | None, count: int, out_word: I8, out_place: U4 | None
) -> None:
    """The larger disparity stays; of equals the one that came first."""
    for i in range(count):
        cell = cells[i]
        held = out_word[cell]
        nearer = words[i] > (held | CARRIED)
        out_word[cell] = words[i] if nearer else held
        if out_place is not None and places is not None:
            out_place[cell] = places[i] if nearer else out_place[cell]


@kernel
def list_runs(tiles: I4, out_runs: I4) -> int:
    """Find the tiles that stand side by side in one sheet.

    tiles is (n, FIELDS) from `list_tiles`; out_runs (n, RUN) gets for each run its first tile, the
    one after its last, and the rows [low, high) of the desired view that its tiles can reach.
    Returns how many runs there are.
    """
    count = 0
    for n in range(tiles.shape[0]):
        same = count > 0
        for column in range(2, 6):
            same = same and tiles[n, column] == tiles[max(n - 1, 0), column]
        if not same:
            out_runs[count, 0], out_runs[count, 2], out_runs[count, 3] = n, tiles[n, 6], tiles[n, 7]
            count += 1
        run = out_runs[count - 1]
        run[1] = n + 1
        run[2], run[3] = min(run[2], tiles[n, 6]), max(run[3], tiles[n, 7])
    return count


@inner
def rows_beyond(
    w: F4, bar: float, side: float, u_low: int, u_end: int, v_low: int, v_end: int, low: Real,
    high: Real,
) -> tuple[int, int]:  # fmt: skip
    """Rows [first, end) of a tile from which samples can land on one side of a desired row.

    Beyond the bar is ``side (s - bar t) >= 0``, which is linear: no division, and true on both
    sides of the eye's plane. What ``float32`` may make of it counts as well, so that a sample that
    lands where it should not is kept or lost whatever band it is asked for.

    Args:
        w: (12,) warp matrix.
        bar: the row.
        side: 1 for what is below it, -1 for what is above.
        u_low: the tile's columns [u_low, u_end).
        u_end: the same.
        v_low: and its rows [v_low, v_end).
        v_end: the same.
        low: its smallest disparity.
        high: and its largest.
    """
    reach = abs(bar)
    noise = NOISE * (
        (abs(w[4]) + reach * abs(w[8])) * u_end + (abs(w[5]) + reach * abs(w[9])) * v_end
        + abs(w[6]) + reach * abs(w[10]) + (abs(w[7]) + reach * abs(w[11])) * high
    )  # fmt: skip
    if not noise < np.inf:
        return v_low, v_end
    across, along = side * (w[4] - bar * w[8]), side * (w[5] - bar * w[9])
    near = side * (w[7] - bar * w[11])
    most = side * (w[6] - bar * w[10]) + noise
    most += max(across * u_low, across * (u_end - 1)) + max(near * low, near * high)
    if along > 0.0:
        return int(min(max(np.ceil(-most / along), float(v_low)), float(v_end))), v_end
    if along < 0.0:
        return v_low, int(max(min(np.floor(most / -along) + 1.0, float(v_end)), float(v_low)))
    return v_low, v_end if most >= 0.0 else v_low


@inner
def rows_that_land(
    w: F4, tiles: I4, n: int, low: F4, high: F4, y_low: int, y_end: int
) -> tuple[int, int]:
    """Rows [first, end) of a tile that can land in rows [y_low, y_end) of the desired view."""
    v_low, v_end = tiles[n, 3], tiles[n, 4]
    if tiles[n, 7] <= y_low or tiles[n, 6] >= y_end:
        return v_low, v_low
    if tiles[n, 6] >= y_low and tiles[n, 7] <= y_end:
        return v_low, v_end
    u_low, u_end, tv, tu = tiles[n, 0], tiles[n, 1], v_low // TILE, tiles[n, 0] // TILE
    least, most = np.float64(low[tv, tu]), np.float64(high[tv, tu])
    first, end = rows_beyond(w, y_low - 1.5, 1.0, u_low, u_end, v_low, v_end, least, most)
    above, below = rows_beyond(w, y_end + 0.5, -1.0, u_low, u_end, v_low, v_end, least, most)
    return max(first, above), min(end, below)


@kernel
def scatter(
    w: F4, disparity: F4, carried: U4, tiles: I4, runs: I4, low: F4, high: F4, halo: int,
    y_low: int, columns: int, rows: int, height: int, by_order: bool, out_word: I8,
    out_place: U4 | None,
) -> None:  # fmt: skip
    """Each sample lands in the one cell whose square holds it.

    Args:
        w: (12,) warp matrix.
        disparity: (H, W).
        carried: (H, W) what each sample takes along.
        tiles: (n, FIELDS) from `list_tiles`.
        runs: (n, RUN) from `list_runs`.
        low: smallest disparity of each tile of the reference.
        high: the largest.
        halo: cells left of the desired view's first column.
        y_low: desired row of the first cell, at least -halo.
        columns: cells across.
        rows: cells down.
        height: of the whole desired view.
        by_order: later samples win (painter's); otherwise the larger disparity wins.
        out_word: (rows * columns + SPARE,) words of the samples seen.
        out_place: same length, or None (which makes a kernel of its own): right and down from the
            cell's upper left corner in 1 / PLACES of it, the latter in the upper half; written
            where a sample is seen.
    """
    none, y_end = rows * columns, y_low + rows
    out_word[:none] = EMPTY
    cells = np.empty(TILE, np.uint32)
    words = np.empty(TILE, np.int64)
    places = None if out_place is None else np.empty(TILE, np.uint32)
    spans = np.empty((low.shape[1] + 2, 2), np.int32)
    for run in range(runs.shape[0]):
        begin, end = runs[run, 0], runs[run, 1]
        if runs[run, 2] >= y_end or runs[run, 3] <= y_low:
            continue
        for n in range(begin, end):
            span = rows_that_land(w, tiles, n, low, high, y_low, y_end)
            spans[n - begin, 0], spans[n - begin, 1] = span
        for j in range(tiles[begin, 4] - tiles[begin, 3]):
            v = tiles[begin, 3] + j if tiles[begin, 5] > 0 else tiles[begin, 4] - 1 - j
            for n in range(begin, end):
                if v < spans[n - begin, 0] or v >= spans[n - begin, 1]:
                    continue
                u_low, u_end = tiles[n, 0], tiles[n, 1]
                # what float32 lands outside the tile's float64 bounds is noise: the same for
                # every band
                top = max(tiles[n, 6], y_low) if tiles[n, 6] > 0 else y_low
                bottom = min(tiles[n, 7], y_end) if tiles[n, 7] < height else y_end
                land_row(
                    w, v, u_low, disparity[v, u_low:u_end], carried[v, u_low:u_end], halo, y_low,
                    columns, top, bottom, none, cells, words, places,
                )  # fmt: skip
                if by_order:
                    keep_last(cells, words, places, u_end - u_low, tiles[n, 2], out_word, out_place)
                else:
                    keep_nearest(cells, words, places, u_end - u_low, out_word, out_place)
