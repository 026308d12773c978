"""Kernels that bound the disparities of what is drawn of each tile."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import EIGHT, INTACT, MIXED, all_set, joined, list_set
from belvedere.warp._tiles import TILE

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]


@inner
def add_range(
    disparity: F4, links: U1, v: int, first: int, count: int, lows: F4, highs: F4, out_odd: U1
) -> None:
    """Widen the ranges of columns by a run of row v, and flag samples that are drawn beyond.

    Between four intact cells a sample is drawn between samples, never beyond them. Straight-line
    arithmetic on purpose: it vectorises.

    Args:
        disparity: (H, W).
        links: (H, W) bits.
        v: row.
        first: first column of the run.
        count: how many.
        lows: (count,) smallest disparity of each column, widened.
        highs: (count,) largest.
        out_odd: (count,) 1 where a true sample is not between four intact cells.
    """
    row, here = disparity[v, first:], links[v, first:]
    for i in range(count):
        delta, usable_here = row[i], here[i] & MIXED == 0  # NaN is neither less nor more
        lows[i] = delta if usable_here & (delta < lows[i]) else lows[i]
        highs[i] = delta if usable_here & (delta > highs[i]) else highs[i]
        out_odd[i] = np.uint8(usable_here & (delta == delta))  # noqa: PLR0124
    if v == 0:
        return
    start = 1 if first == 0 else 0
    before, after = links[v, first + start - 1 :], links[v, first + start :]
    above_before, above = links[v - 1, first + start - 1 :], links[v - 1, first + start :]
    for i in range(count - start):
        cells = before[i] & after[i] & above_before[i] & above[i]
        out_odd[np.uint64(start + i)] &= np.uint8(cells & INTACT == 0)


@inner
def step_along(disparity: F4, links: U1, v: int, u: int, dv: int, du: int) -> Real:
    """Size of the step in disparity to a linked neighbour; 0 to one that is not."""
    if joined(links, v, u, dv, du):
        return abs(disparity[v + dv, u + du] - disparity[v, u])
    return np.float32(0.0)


@kernel
def surface_range(
    disparity: F4, links: U1, sample_low: F4, sample_high: F4, tile_row_low: int,
    tile_row_high: int, out_low: F4, out_high: F4,
) -> None:  # fmt: skip
    """Smallest and largest disparity of the surface that is drawn of each tile.

    A sample is drawn up to a pixel around it, with the slope of its surface: on a steep one that
    reaches beyond the disparities of the samples themselves.

    Args:
        disparity: (H, W), small gaps bridged.
        links: (H, W) bits.
        sample_low: (ceil(H / TILE), ceil(W / TILE)) smallest disparity of the samples of each tile
            and round it.
        sample_high: the largest.
        tile_row_low: first row of tiles to do.
        tile_row_high: row of tiles after the last.
        out_low: (ceil(H / TILE), ceil(W / TILE)).
        out_high: same; high < low where a tile has no sample.
    """
    height, width = disparity.shape
    flat = links.reshape(-1)
    lows, highs = np.empty(TILE + 1, np.float32), np.empty(TILE + 1, np.float32)
    odd = np.zeros((TILE // EIGHT + 1) * EIGHT, np.uint8)
    places = np.zeros(odd.size, np.int32)
    for tv in range(tile_row_low, tile_row_high):
        for tu in range(out_low.shape[1]):
            unbroken = (tv + 1) * TILE < height and (tu + 1) * TILE < width
            for v in range(tv * TILE, min((tv + 1) * TILE + 1, height)):
                if unbroken:
                    unbroken = all_set(flat, v * width + tu * TILE, TILE + 1, INTACT)
            if unbroken and tv > 0 and tu > 0:  # drawn between samples, never beyond them
                out_low[tv, tu], out_high[tv, tu] = sample_low[tv, tu], sample_high[tv, tu]
                continue
            low, high = np.float32(np.inf), np.float32(-np.inf)
            # the cells of a tile end at the first samples of the next
            first, end = tu * TILE, min((tu + 1) * TILE + 1, width)
            lows.fill(np.inf)
            highs.fill(-np.inf)
            odd.fill(0)
            for v in range(tv * TILE, min((tv + 1) * TILE + 1, height)):
                add_range(disparity, links, v, first, end - first, lows, highs, odd)
                for k in range(list_set(odd, places)):
                    u = first + places[k]
                    # a side that is not linked continues the slope of the other
                    reach = max(
                        step_along(disparity, links, v, u, 0, 1),
                        step_along(disparity, links, v, u, 0, -1),
                    ) + max(
                        step_along(disparity, links, v, u, 1, 0),
                        step_along(disparity, links, v, u, -1, 0),
                    )
                    low = min(low, max(disparity[v, u] - reach, np.float32(0.0)))
                    high = max(high, disparity[v, u] + reach)
            out_low[tv, tu] = min(low, lows.min())
            out_high[tv, tu] = max(high, highs.max())
