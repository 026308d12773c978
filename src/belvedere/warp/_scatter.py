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
from belvedere.warp._tiles import TILE, rows_that_land

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
STRETCH = 512
"""Samples of a row that are moved in one go; beside what they are read from and written to, they
stay in the first-level cache."""
SPARE = 32
"""Cells behind a layer that take the samples that land nowhere: several, so that no two stores in a
row wait for one another. A power of two."""


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
    w: F4, v: int, u_low: int, disparity: F4, carried: U4, tops: F4, bottoms: F4, halo: int,
    y_low: int, columns: int, none: int, out_cell: U4, out_word: I8, out_place: U4 | None,
) -> None:  # fmt: skip
    """Cells, words and places of a stretch of a row, (count,) each.

    A sample that does not land between its top and its bottom gets one of the cells from ``none``
    on. Places are rounded before ``y_low`` comes in: they are the same for every band.
    """
    v4, base = np.float32(v), np.float32(u_low)
    r, s, t = w[1] * v4 + w[2], w[5] * v4 + w[6], w[9] * v4 + w[10]
    r_step, s_step, t_step, r_near, s_near, t_near = w[0], w[4], w[8], w[3], w[7], w[11]
    shift = HALF + np.float32(halo)
    right, last = np.float32(columns), np.int32(SPARE - 1)
    row_low, across, spare = np.int32(y_low + halo), np.int32(columns), np.int32(none)
    if out_place is not None:
        for i in range(disparity.shape[0]):
            lane = np.int32(i)
            out_cell[i], out_word[i], out_place[i] = land(
                base + np.float32(lane), disparity[i], carried[i], r, s, t, r_step, s_step, t_step,
                r_near, s_near, t_near, shift, right, tops[i], bottoms[i], row_low, across,
                np.int32(spare + (lane & last)),
            )  # fmt: skip
        return
    for i in range(disparity.shape[0]):
        lane = np.int32(i)
        out_cell[i], out_word[i], _ = land(
            base + np.float32(lane), disparity[i], carried[i], r, s, t, r_step, s_step, t_step,
            r_near, s_near, t_near, shift, right, tops[i], bottoms[i], row_low, across,
            np.int32(spare + (lane & last)),
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


@inner
def stretch(
    tiles: I4, spans: I4, begin: int, n: int, end: int, v: int, longest: int
) -> tuple[int, int, int]:
    """The next samples of one row that are moved in one go, from tile ``n`` of a run on.

    Returns the tile to go on with, and columns [low, end): of tiles that follow one another, all
    with this row in their span; none if tile ``n`` has not.
    """
    if v < spans[n - begin, 0] or v >= spans[n - begin, 1]:
        return n + 1, 0, 0
    low, high = tiles[n, 0], tiles[n, 1]
    n += 1
    while n < end and spans[n - begin, 0] <= v < spans[n - begin, 1]:
        beside = tiles[n, 1] == low or tiles[n, 0] == high
        if not beside or high - low + tiles[n, 1] - tiles[n, 0] > longest:
            break
        low, high = min(low, tiles[n, 0]), max(high, tiles[n, 1])
        n += 1
    return n, low, high


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
    cells, words = np.empty(STRETCH, np.uint32), np.empty(STRETCH, np.int64)
    places = None if out_place is None else np.empty(STRETCH, np.uint32)
    spans = np.empty((low.shape[1] + 2, 2), np.int32)
    clip = np.empty((2, disparity.shape[1]), np.float32)
    tops, bottoms = clip[0], clip[1]
    longest = STRETCH if by_order else TILE  # of equals the first stays: tile by tile, as listed
    for run in range(runs.shape[0]):
        begin, end, step = runs[run, 0], runs[run, 1], tiles[runs[run, 0], 2]
        if runs[run, 2] >= y_end or runs[run, 3] <= y_low:
            continue
        for n in range(begin, end):
            span = rows_that_land(w, tiles, n, low, high, y_low, y_end)
            spans[n - begin, 0], spans[n - begin, 1] = span
            # what float32 lands outside the tile's float64 bounds is noise: the same for every band
            top = max(tiles[n, 6], y_low) if tiles[n, 6] > 0 else y_low
            bottom = min(tiles[n, 7], y_end) if tiles[n, 7] < height else y_end
            tops[tiles[n, 0] : tiles[n, 1]] = top + halo
            bottoms[tiles[n, 0] : tiles[n, 1]] = bottom + halo
        for j in range(tiles[begin, 4] - tiles[begin, 3]):
            v = tiles[begin, 3] + j if tiles[begin, 5] > 0 else tiles[begin, 4] - 1 - j
            n = begin
            while n < end:
                n, u_low, u_end = stretch(tiles, spans, begin, n, end, v, longest)
                if u_low == u_end:
                    continue
                land_row(
                    w, v, u_low, disparity[v, u_low:u_end], carried[v, u_low:u_end],
                    tops[u_low:u_end], bottoms[u_low:u_end], halo, y_low, columns, none, cells,
                    words, places,
                )  # fmt: skip
                if by_order:
                    keep_last(cells, words, places, u_end - u_low, step, out_word, out_place)
                else:
                    keep_nearest(cells, words, places, u_end - u_low, out_word, out_place)
