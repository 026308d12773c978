"""Kernels that bound the disparities of what is drawn of each tile."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import INTACT, all_set, joined, usable
from belvedere.warp._tiles import TILE

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]


@inner
def undisturbed(links: U1, v: int, u: int) -> bool:
    """Whether every cell round a sample is intact."""
    if v < 1 or u < 1:
        return False
    upper, lower = links[v - 1, u - 1] & links[v - 1, u], links[v, u - 1] & links[v, u]
    return bool(upper & lower & INTACT)


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
            for v in range(tv * TILE, min((tv + 1) * TILE + 1, height)):
                for u in range(tu * TILE, min((tu + 1) * TILE + 1, width)):
                    if undisturbed(links, v, u):  # drawn between samples, never beyond them
                        low = min(low, disparity[v, u])
                        high = max(high, disparity[v, u])
                        continue
                    if not usable(disparity, links, v, u):
                        continue
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
            out_low[tv, tu] = low
            out_high[tv, tu] = high
