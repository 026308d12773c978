"""The floors of a building cut at its doors: which part of them is which cell.

A neck that is no door never cuts, so a furnished room or a long corridor stays whole however many
basins the watershed sees in it. What lies under the open sky, or has nothing round it, is outdoors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.walkthrough.cells import OUTSIDE
from belvedere.walkthrough.columns import LEAST_ROOM_M2, LEAST_WIDTH_M, Columns, Layers
from belvedere.walkthrough.necks import Neck
from belvedere.walkthrough.rooms import RoomLayer

I4 = npt.NDArray[np.int32]
Mask = npt.NDArray[np.bool_]

SKY_SHARE = 0.3
"""A place with more open sky than this is outdoors."""
OPEN_EDGE = 0.4
"""As is one that has nothing round more than so much of its edge."""
DROPPED = -2
"""Label of what belongs to no cell."""

__all__ = ["Parts", "cut_floors"]


@dataclass(frozen=True, eq=False)
class Parts:
    """Which part of the floors is which cell."""

    label: I4
    """(N,) cell, `OUTSIDE` or `DROPPED`."""
    count: int
    """Cells."""
    doors: list[tuple[Neck, int, int]]
    """Necks with the cells on their sides."""
    stairs: frozenset[int]
    """Cells that are stairs."""


def cut_floors(columns: Columns, rooms: RoomLayer, necks: list[Neck]) -> Parts:
    """Cut the floors at their doors, at the edges of roofs, and at stairs between storeys."""
    layers = rooms.layers
    square = layers.grid.spacing**2
    sides = [_sides(layers, neck) for neck in necks]
    live = [k for k, (links, _, _) in enumerate(sides) if len(links)]
    flights = _flights(rooms)
    while True:
        cut = np.zeros(layers.link.shape, dtype=bool)
        for k in live:
            cut[tuple(sides[k][0].T)] = True
        label, count = layers.label(cut)
        area = np.bincount(label, minlength=count) * square
        # a door joins two rooms; what is cut off and no room is given back
        bad = [
            k
            for k in live
            if _same(label, sides[k])
            or min(area[a] for a in _around(label, sides[k])) < LEAST_ROOM_M2
        ]
        if not bad:
            break
        smallest = min(
            bad, key=lambda k: (not _same(label, sides[k]), necks[k].lintel, -necks[k].width)
        )
        live.remove(smallest)
    # a house ends where its roof does, door or not
    sky = np.isinf(layers.ceiling)
    cut |= (layers.link >= 0) & (sky[:, None] != sky[layers.link])
    cut, stairs = _split_stairs(layers, flights, cut)
    label, count = layers.label(cut)
    area = np.bincount(label, minlength=count) * square
    number = np.full(count, DROPPED, dtype=np.int32)
    number[_outdoors(columns, rooms, label, count)] = OUTSIDE
    room = (number == DROPPED) & (area >= LEAST_ROOM_M2)
    number[room] = np.arange(room.sum())
    final = number[label]
    doors = []
    for k in live:
        a, b = _around(final, sides[k])
        if not _can_be_walked(rooms, sides[k][0]):
            continue  # a window whose sill was crossed like furniture: found again with its sill
        if a != b and max(a, b) >= 0 and min(a, b) > DROPPED:
            doors.append((necks[k], max(a, b), min(a, b)) if min(a, b) < 0 else (necks[k], a, b))
    flat = frozenset(int(final[n]) for n in stairs if final[n] >= 0)
    return Parts(final, int(room.sum()), doors, flat)


def _outdoors(columns: Columns, rooms: RoomLayer, label: I4, count: int) -> Mask:
    """(count,) parts under the open sky, or a ledge or porch round a house: open at their edges."""
    layers, grid = rooms.layers, rooms.layers.grid
    size = np.bincount(label, minlength=count)
    sky = np.bincount(label, weights=np.isinf(layers.ceiling), minlength=count) / size
    widest = np.zeros(count)
    np.maximum.at(widest, label, rooms.far)
    high = np.full(grid.nx * grid.ny, -np.inf)
    filled = np.flatnonzero(np.diff(columns.first))
    high[filled] = columns.high[columns.first[filled + 1] - 1]
    edge, bare = np.zeros(count), np.zeros(count)
    for d, shift in enumerate((-1, 1, -grid.nx, grid.nx)):
        to = layers.link[:, d]
        lone = np.flatnonzero((to < 0) | np.isinf(layers.ceiling[to]))
        beside = np.clip(layers.column[lone] + shift, 0, grid.nx * grid.ny - 1)
        edge += np.bincount(label[lone], minlength=count)
        open_edge = (high[beside] < layers.floor[lone] + 0.3) | (to[lone] >= 0)
        bare += np.bincount(label[lone], weights=open_edge, minlength=count)
    return (sky > SKY_SHARE) | (bare > OPEN_EDGE * np.maximum(edge, 1.0)) | (widest < LEAST_WIDTH_M)


def _can_be_walked(rooms: RoomLayer, links: I4) -> bool:
    to = rooms.layers.link[links[:, 0], links[:, 1]]
    both = rooms.walkable[links[:, 0]] & rooms.walkable[to]
    return bool(both.sum() * rooms.layers.grid.spacing >= 0.3)


def _sides(layers: Layers, neck: Neck) -> tuple[I4, I4, I4]:
    """Links that cross a neck's plane, and places on its two sides."""
    center, along = (neck.left + neck.right) / 2.0, neck.right - neck.left
    length = float(np.hypot(*along))
    along = along / length
    through = np.array([-along[1], along[0]])
    off = layers.centers - center
    s, t = off @ along, off @ through
    reach = length / 2.0 + 3.0 * layers.grid.spacing
    near = (np.abs(s) < reach) & (np.abs(t) < 0.5) & (np.abs(layers.floor - neck.floor) < 0.6)
    place = np.flatnonzero(near)
    to = layers.link[place]
    crosses = (to >= 0) & ((t[place] >= 0.0)[:, None] != (t[to] >= 0.0)) & near[to]
    which, direction = np.nonzero(crosses)
    links = np.stack([place[which], direction], axis=1).astype(np.int32)
    before = np.unique(links[t[links[:, 0]] >= 0.0, 0])
    behind = np.unique(links[t[links[:, 0]] < 0.0, 0])
    return links, before.astype(np.int32), behind.astype(np.int32)


def _around(label: I4, sides: tuple[I4, I4, I4]) -> tuple[int, int]:
    """The labels on both sides of a neck: the commonest."""
    values = []
    for places in sides[1:]:
        kinds, count = np.unique(label[places], return_counts=True)
        values.append(int(kinds[np.argmax(count)]))
    return values[0], values[1]


def _same(label: I4, sides: tuple[I4, I4, I4]) -> bool:
    a, b = _around(label, sides)
    return a == b


def _flights(rooms: RoomLayer) -> list[I4]:
    """The places of each flight of stairs."""
    layers = rooms.layers
    cut = (layers.link >= 0) & (rooms.stair[:, None] != rooms.stair[layers.link])
    label, count = layers.label(cut)
    on = np.flatnonzero(rooms.stair)
    return [on[label[on] == k].astype(np.int32) for k in np.unique(label[on])] if count else []


def _split_stairs(layers: Layers, flights: list[I4], cut: Mask) -> tuple[Mask, list[int]]:
    """Cut off the flights that join two storeys which nothing else joins; a place on each.

    A gallery in a high hall belongs to the hall: there the lower floor rises beyond the upper
    over a good part of it, and the stair stays in the hall's cell.
    """
    stair = np.zeros(len(layers.column), dtype=bool)
    for flight in flights:
        stair[flight] = True
    border = (layers.link >= 0) & (stair[:, None] != stair[layers.link])
    label, _ = layers.label(cut | border)
    places: list[int] = []
    for flight in flights:
        beside = layers.link[flight]
        beside = beside[(beside >= 0) & ~stair[beside]]
        if not len(beside):
            continue
        high, low = beside[np.argmax(layers.floor[beside])], beside[np.argmin(layers.floor[beside])]
        upper, lower = label[high], label[low]
        below = label == lower
        tall = below & (layers.ceiling > layers.floor[high] + 1.0)
        least = min(below.sum(), (label == upper).sum())
        gallery = tall.sum() > 0.25 * least and not _lies_over_others(
            layers, label, flight, high, low
        )
        if upper == lower or gallery:
            continue
        marked = np.zeros(len(stair), dtype=bool)
        marked[flight] = True
        cut = cut | ((layers.link >= 0) & (marked[:, None] != marked[layers.link]))
        places.append(int(flight[0]))
    return cut, places


def _lies_over_others(layers: Layers, label: I4, flight: I4, high: int, low: int) -> bool:
    """Whether there are other rooms under an upper floor: one prism cannot leave them out."""
    plan = np.zeros(layers.grid.nx * layers.grid.ny, dtype=bool)
    plan[layers.column[label == label[high]]] = True
    rest = (label != label[high]) & (label != label[low]) & (label != label[flight[0]])
    rest &= layers.floor < layers.floor[high] - 1.5
    return bool((rest & plan[layers.column]).sum() * layers.grid.spacing**2 > LEAST_ROOM_M2)
