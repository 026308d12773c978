"""Kernels that cut a reference image into tiles and bound where each tile can land."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel

F4 = npt.NDArray[np.float32]
F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]

TILE = 32
"""Pixels along a tile's side: its samples and what they paint stay in the first-level cache."""

FIELDS = 8
"""Columns of the tile table: u_first, u_end, u_step, v_first, v_end, v_step, row_low, row_high."""
RUN = 4
"""Columns of the table of runs; see `list_runs`."""

NOISE = 2.0**-20
"""Bound on what ``float32`` adds to a sum of four products, for each unit of their sizes: eight
roundings, each of half a step of 2^-23."""


@kernel
def disparity_range(disparity: F4, out_low: F4, out_high: F4) -> None:
    """Smallest and largest disparity of each tile and the pixels next to it.

    disparity is (H, W); the outputs are (ceil(H / TILE), ceil(W / TILE)), high < low where a tile
    has no sample. One pixel beyond each side counts too, since cells span two pixels.
    """
    height, width = disparity.shape
    flat = disparity.reshape(-1)
    lows, highs = np.empty(TILE + 2, np.float32), np.empty(TILE + 2, np.float32)
    for tv in range(out_low.shape[0]):
        for tu in range(out_low.shape[1]):
            first, end = max(tu * TILE - 1, 0), min((tu + 1) * TILE + 1, width)
            lows.fill(np.inf)
            highs.fill(-np.inf)
            # column by column, which vectorises; the least of a row does not
            for v in range(max(tv * TILE - 1, 0), min((tv + 1) * TILE + 1, height)):
                start = v * width + first
                for i in range(end - first):
                    delta = flat[np.uint64(start + i)]
                    lows[i] = delta if delta < lows[i] else lows[i]
                    highs[i] = delta if delta > highs[i] else highs[i]
            out_low[tv, tu], out_high[tv, tu] = lows.min(), highs.max()


@inner
def most_of(
    sign: Real, row: F8, far: Real, last: F8, u_low: Real, u_high: Real, v_low: Real, v_high: Real,
    low: Real, high: Real,
) -> Real:  # fmt: skip
    """The largest value in a box of ``sign row + far last``, both rows of the matrix."""
    a, b = sign * row[0] + far * last[0], sign * row[1] + far * last[1]
    c, d = sign * row[2] + far * last[2], sign * row[3] + far * last[3]
    return c + max(a * u_low, a * u_high) + max(b * v_low, b * v_high) + max(d * low, d * high)


@inner
def misses(
    warp: F8, u_low: Real, u_high: Real, v_low: Real, v_high: Real, low: Real, high: Real,
    width: int, height: int, pad: int,
) -> bool:  # fmt: skip
    """Whether no point of a box in (u, v, delta) can land in the desired view.

    What is left of the view has ``r + pad t < 0``, and likewise for its other sides: linear, so
    that a box through the plane of the eye is bounded too, and no division is needed.
    """
    r, s, t = warp[0], warp[1], warp[2]
    right, bottom = float(width - 1 + pad), float(height - 1 + pad)
    return (
        most_of(1.0, t, 0.0, t, u_low, u_high, v_low, v_high, low, high) <= 0.0
        or most_of(1.0, r, float(pad), t, u_low, u_high, v_low, v_high, low, high) < 0.0
        or most_of(-1.0, r, right, t, u_low, u_high, v_low, v_high, low, high) < 0.0
        or most_of(1.0, s, float(pad), t, u_low, u_high, v_low, v_high, low, high) < 0.0
        or most_of(-1.0, s, bottom, t, u_low, u_high, v_low, v_high, low, high) < 0.0
    )


@kernel
def landing_rows(
    warp: F8, u_low: int, u_high: int, v_low: int, v_high: int, low: Real, high: Real,
    width: int, height: int, pad: int,
) -> tuple[int, int]:  # fmt: skip
    """Rows [first, end) of the desired view that a tile can reach; empty when it cannot.

    A tile and its range of disparity form a box in (u, v, delta), and the warp is projective, so
    the image of the box lies in the hull of its eight warped corners, provided all have t > 0.
    """
    if misses(
        warp, u_low - 1.0, u_high + 0.5, v_low - 1.0, v_high + 0.5, low, high, width, height, pad
    ):
        return 0, 0
    y_low, y_high = np.inf, -np.inf
    for corner in range(8):
        u = u_high + 0.5 if corner & 1 else u_low - 1.0
        v = v_high + 0.5 if corner & 2 else v_low - 1.0
        delta = high if corner & 4 else low
        t = warp[2, 0] * u + warp[2, 1] * v + warp[2, 2] + warp[2, 3] * delta
        if t <= 1e-12:  # the box reaches through the eye's plane: no bound
            return 0, height
        y = (warp[1, 0] * u + warp[1, 1] * v + warp[1, 2] + warp[1, 3] * delta) / t
        y_low, y_high = min(y_low, y), max(y_high, y)
    return int(max(np.floor(y_low) - pad, 0)), int(min(np.ceil(y_high) + pad + 1, height))


@kernel
def list_tiles(
    sheets: I4, low: F4, high: F4, warp: F8, width: int, height: int, pad: int, out_tiles: I4
) -> int:
    """Write the tiles that can reach the desired view, in occlusion-compatible order.

    Rows of tiles are asked first whether they miss the view, then the tiles of those that do not:
    a reference that looks elsewhere costs one question for each of its rows.

    Args:
        sheets: (S, 6) u_low, u_high, u_step, v_low, v_high, v_step.
        low: per-tile smallest disparity, from `disparity_range`.
        high: per-tile largest disparity.
        warp: (3, 4) float64.
        width: of the desired view.
        height: of the desired view.
        pad: pixels that a sample paints beyond where it lands.
        out_tiles: (n, FIELDS), large enough for every tile of every sheet.

    Returns:
        How many tiles were written. If A comes before B in both scan directions, so does A's tile
        before B's: going tile by tile keeps the order compatible.
    """
    count = 0
    for sheet in range(sheets.shape[0]):
        u_low, u_high, u_step = sheets[sheet, 0], sheets[sheet, 1], sheets[sheet, 2]
        v_low, v_high, v_step = sheets[sheet, 3], sheets[sheet, 4], sheets[sheet, 5]
        tu_low, tu_high = u_low // TILE, (u_high - 1) // TILE
        tv_low, tv_high = v_low // TILE, (v_high - 1) // TILE
        for i in range(tv_high - tv_low + 1):
            tv = tv_low + i if v_step > 0 else tv_high - i
            v0, v1 = max(v_low, tv * TILE), min(v_high, (tv + 1) * TILE)
            least, most = low[tv, tu_low : tu_high + 1].min(), high[tv, tu_low : tu_high + 1].max()
            if not least <= most or misses(
                warp, u_low - 1.0, u_high + 0.5, v0 - 1.0, v1 + 0.5, least, most, width, height, pad
            ):
                continue
            for j in range(tu_high - tu_low + 1):
                tu = tu_low + j if u_step > 0 else tu_high - j
                if not low[tv, tu] <= high[tv, tu]:
                    continue
                u0, u1 = max(u_low, tu * TILE), min(u_high, (tu + 1) * TILE)
                first, end = landing_rows(
                    warp, u0, u1, v0, v1, low[tv, tu], high[tv, tu], width, height, pad
                )
                if first >= end:
                    continue
                out_tiles[count, 0] = u0
                out_tiles[count, 1] = u1
                out_tiles[count, 2] = u_step
                out_tiles[count, 3] = v0
                out_tiles[count, 4] = v1
                out_tiles[count, 5] = v_step
                out_tiles[count, 6] = first
                out_tiles[count, 7] = end
                count += 1
    return count


@kernel
def landing_columns(
    tiles: I4, low: F4, high: F4, warp: F8, width: int, pad: int
) -> tuple[int, int]:  # fmt: skip
    """Columns [first, end) of the desired view that tiles can reach; see `landing_rows`.

    tiles is (n, FIELDS) from `list_tiles`, and so are the other arguments.
    """
    x_low, x_high = np.inf, -np.inf
    for n in range(tiles.shape[0]):
        tu, tv = tiles[n, 0] // TILE, tiles[n, 3] // TILE
        for corner in range(8):
            u = tiles[n, 1] + 0.5 if corner & 1 else tiles[n, 0] - 1.0
            v = tiles[n, 4] + 0.5 if corner & 2 else tiles[n, 3] - 1.0
            delta = high[tv, tu] if corner & 4 else low[tv, tu]
            t = warp[2, 0] * u + warp[2, 1] * v + warp[2, 2] + warp[2, 3] * delta
            if t <= 1e-12:  # the box reaches through the eye's plane: no bound
                return 0, width
            x = (warp[0, 0] * u + warp[0, 1] * v + warp[0, 2] + warp[0, 3] * delta) / t
            x_low, x_high = min(x_low, x), max(x_high, x)
    if not x_low <= x_high:
        return 0, 0
    return int(max(np.floor(x_low) - pad, 0)), int(min(np.ceil(x_high) + pad + 1, width))


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
