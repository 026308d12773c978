"""Parts of the floors as upright prisms: outlines, floors, ceilings, storeys, names."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.walkthrough.cells import Cell
from belvedere.walkthrough.columns import Layers
from belvedere.walkthrough.outlines import outline_rings
from belvedere.walkthrough.parts import Parts
from belvedere.walkthrough.rooms import RoomLayer

Mask = npt.NDArray[np.bool_]

__all__ = ["prisms"]


def prisms(rooms: RoomLayer, parts: Parts) -> list[Cell]:
    """Prisms over the parts, lowest storey first; none overlaps another in plan and height."""
    from scipy import ndimage

    layers, grid = rooms.layers, rooms.layers.grid
    raw, masks, heights = [], [], []
    for k in range(parts.count):
        own = np.flatnonzero(parts.label == k)
        mask = np.zeros(grid.nx * grid.ny, dtype=bool)
        mask[layers.column[own]] = True
        shape = ndimage.binary_closing(
            np.pad(mask.reshape(grid.ny, grid.nx), 4), np.ones((3, 3)), iterations=3
        )[4:-4, 4:-4]
        masks.append(np.asarray(ndimage.binary_fill_holes(shape), dtype=bool))
        raw.append(mask.reshape(grid.ny, grid.nx))
        heights.append(_rise(layers, own, k in parts.stairs))
    taken = _settle(raw, masks, heights, parts.stairs)
    floors = sorted(heights[k][0] for k in range(parts.count) if k not in parts.stairs)
    levels = [floors[0]] if floors else [0.0]
    for floor in floors:
        if floor - levels[-1] > 1.5:
            levels.append(floor)
    cells = []
    for k, mask in enumerate(taken):
        rings = outline_rings(mask, grid.spacing, 1.1 * grid.spacing)
        low, high = heights[k]
        storey = int(np.argmin(np.abs(np.array(levels) - low)))
        kind = "stair" if k in parts.stairs else "room"
        number = 1 + sum(cell.name.startswith(kind) for cell in cells)
        cells.append(Cell(f"{kind} {number}", rings, low, high, storey))
    return cells


def _rise(layers: Layers, own: npt.NDArray[np.intp], stair: bool) -> tuple[float, float]:
    """Floor and ceiling of a part, less a ceiling over a mere edge, beside a stairwell."""
    low = float(layers.floor[own].min())
    if stair:
        beside = layers.link[own]
        low = min(low, float(layers.floor[beside[beside >= 0]].min()))
    tops = np.sort(layers.ceiling[own][np.isfinite(layers.ceiling[own])])
    top = tops[-1] if stair else tops[min(int(0.96 * len(tops)), len(tops) - 1)]
    return low, float(top)


def _settle(
    raw: list[Mask], masks: list[Mask], heights: list[tuple[float, float]], stairs: frozenset[int]
) -> list[Mask]:
    """Grow each plan by the square that a wall takes on its edge, and let stairs keep theirs.

    What lies under a stair is the stair's; above it only what has no floor of its own.
    """
    from scipy import ndimage

    count = len(masks)
    meet = [
        [b for b in range(count) if b != a and _overlap(heights[a], heights[b])]
        for a in range(count)
    ]
    core = []
    for a, mask in enumerate(masks):
        own = mask.copy()
        if a not in stairs:
            for b in meet[a]:
                if b in stairs:
                    over = heights[a][0] > heights[b][0] + 0.5
                    own &= ~(masks[b] & ~raw[a] if over else masks[b])
        core.append(own)
    grown: list[Mask] = []
    for a, mask in enumerate(core):
        wide = np.asarray(ndimage.binary_dilation(mask, np.ones((3, 3))), dtype=bool)
        for b in meet[a]:
            wide &= ~(core[b] & ~mask)
            if b < a:
                wide &= ~(grown[b] & ~mask)
        grown.append(wide)
    return grown


def _overlap(a: tuple[float, float], b: tuple[float, float]) -> bool:
    return min(a[1], b[1]) - max(a[0], b[0]) > 0.5
