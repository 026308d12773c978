"""Where the surfaces of a reference view end, found once, whatever the desired camera.

Source: un-mixing of edge samples is future work of Popescu and Lastra TR99-017, section 5; spec
offset-buffer-warping 7.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.scratch import scratch
from belvedere.ground.threads import row_bands, run_parallel, thread_count


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """The parts of cells that an edge runs through, each a quad between samples."""

    corners: npt.NDArray[np.float32]
    """(12, n) u, v, disparity of each corner: upper left, upper right, lower left, lower right."""
    near: npt.NDArray[np.uint8]
    """(n,) 1 where a part is the near side of its edge."""
    ends: npt.NDArray[np.int32]
    """(tiles down, tiles across) number after the last part of each tile."""


BANDS_PER_THREAD = 4
"""Edges are seldom spread evenly over a picture."""


@dataclass(frozen=True, slots=True, eq=False)
class Silhouettes:
    """What the colours and depths at edges tell about them.

    Memory: 16 bytes a sample, and 49 for each part.
    """

    color: npt.NDArray[np.float32]
    """(H, W, 4) linear, without what the other surface mixed in."""
    parts: Parts


def find_silhouettes(
    color: npt.NDArray[np.float32],
    surface: npt.NDArray[np.float32],
    links: npt.NDArray[np.uint8],
    threads: int | None = None,
) -> Silhouettes:
    """Un-mix the samples at a view's edges and cut its cells there.

    Args:
        color: (H, W, 4) linear; un-mixed in place.
        surface: (H, W) disparity, small gaps bridged.
        links: (H, W) bits of `_edges`.
        threads: how many to use.
    """
    from belvedere.warp import _matte, _straighten

    height, width = surface.shape
    found = np.empty((2, height, width), np.uint8)
    bands = row_bands(height, BANDS_PER_THREAD * thread_count(threads))

    def find(band: tuple[int, int]) -> None:
        _matte.find_edges(color, surface, links, *band, found[0], found[1])

    def straighten(band: tuple[int, int]) -> None:
        _straighten.straighten_edges(found[0], found[1], surface, links, *band, right, down)

    def unmix(band: tuple[int, int]) -> tuple[npt.NDArray[Any], npt.NDArray[Any], int]:
        room = (band[1] - band[0]) * width
        sample, pure = np.empty(room, np.int32), np.empty((room, 4), np.float32)
        where = surface, links, right, down, *band
        return sample, pure, _matte.find_mixed(color, *where, sample, pure)

    run_parallel(find, bands, threads)
    right, down = found.copy()
    run_parallel(straighten, bands, threads)
    mixed = run_parallel(unmix, bands, threads)
    for sample, pure, count in mixed:
        _matte.put(sample, pure, count, color.reshape(-1, 4))
    return Silhouettes(color, cut_parts(surface, links, right, down, threads))


def cut_parts(
    surface: npt.NDArray[np.float32],
    links: npt.NDArray[np.uint8],
    right: npt.NDArray[np.uint8],
    down: npt.NDArray[np.uint8],
    threads: int | None = None,
) -> Parts:
    """Cut the cells of a reference at its edges.

    Args:
        surface: (H, W) disparity, small gaps bridged.
        links: (H, W) bits of `_edges`.
        right: (H, W) where the edge runs from a sample to its right neighbour, 0 to 254; 127 half
            way.
        down: (H, W) to the one below.
        threads: how many to use.
    """
    from belvedere.warp import _parts, _tiles

    across, tall = (-(-side // _tiles.TILE) for side in (surface.shape[1], surface.shape[0]))
    ends = np.empty((tall, across), np.int32)

    def cut(row: int) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.uint8]]:
        room = 4 * _parts.count_broken(links, row)
        corners = scratch("parts corners", (_parts.CORNERS, room), np.float32)
        near = scratch("parts near", (room,), np.uint8)
        count = _parts.cut_tiles(surface, links, right, down, row, corners, near, ends[row])
        return corners[:, :count].copy(), near[:count].copy()

    pieces = run_parallel(cut, range(tall), threads)
    ends[1:] += np.cumsum(ends[:-1, -1], dtype=np.int32)[:, None]
    return Parts(
        np.concatenate([corners for corners, _ in pieces], axis=1),
        np.concatenate([near for _, near in pieces]),
        ends,
    )
