"""The layer of rooms: floors carried on under furniture, distance from the walls, necks.

A visitor walks round a table; a room goes on under it. So what stands on a floor is crossed as long
as the air at head height is free, and what remains in the way are walls, tall cupboards among them,
which the look at a neck's jambs (`necks`) tells apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import SceneError
from belvedere.walkthrough.columns import (
    Columns,
    Layers,
    link_layers,
    standing_layers,
    worth_standing,
)
from belvedere.walkthrough.free_space import Body
from belvedere.walkthrough.necks import DOOR_M

F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]
Mask = npt.NDArray[np.bool_]

BAND_M = 0.15
"""Height of the band below the head that must be free to cross what stands on a floor."""
SOFFIT_M = 0.1
"""How much lower than the ceilings beside it the head of a door is, at least."""
DEEPEST_WALL_M = 0.7

__all__ = ["RoomLayer", "beside_walls", "find_rooms", "neck_places"]


@dataclass(frozen=True, eq=False)
class RoomLayer:
    """Floors of rooms, furniture or not."""

    layers: Layers
    """Places and links."""
    walkable: Mask
    """(N,) a person can stand there; False under furniture."""
    far: F8
    """(N,) metres to the nearest wall."""
    stair: Mask
    """(N,) on a flight of stairs."""


def find_rooms(columns: Columns, body: Body) -> RoomLayer:
    """The floors of all rooms.

    Raises:
        SceneError: there is none.
    """
    standing, front = standing_layers(columns, body.head, body.step)
    keep = worth_standing(standing, front)
    if not keep.any():
        raise SceneError(
            f"The model has no floor: nowhere can a person {body.head:g} m high stand. Is +z up, "
            "and is its unit the metre?"
        )
    layers, walkable = _carry_on(columns, standing.take(keep), body)
    return RoomLayer(layers, walkable, layers.distance(), _stairs(layers))


def _carry_on(columns: Columns, kept: Layers, body: Body) -> tuple[Layers, Mask]:
    from belvedere.walkthrough._span_kernels import cross_furniture

    grid, size = columns.grid, len(kept.column)
    room = size + 2 * grid.nx * grid.ny
    column, grown = np.empty(room, dtype=np.int32), np.zeros(room, dtype=bool)
    floor, ceiling = np.empty(room), np.empty(room)
    column[:size], floor[:size], ceiling[:size] = kept.column, kept.floor, kept.ceiling
    top = np.full(grid.nx * grid.ny, -1, dtype=np.int32)
    after = np.full(room, -1, dtype=np.int32)
    for n in range(size):
        after[n], top[kept.column[n]] = top[kept.column[n]], n
    total = cross_furniture(
        grid.nx, grid.ny, columns.first, columns.low, columns.high, body.head - BAND_M, body.head,
        body.step, size, column, floor, ceiling, grown, after, top,
    )  # fmt: skip
    order = np.lexsort((floor[:total], column[:total]))
    column, floor, ceiling = column[:total][order], floor[:total][order], ceiling[:total][order]
    layers = link_layers(grid, column, floor, ceiling, body.step, body.head)
    return layers, ~grown[:total][order]


def _extreme(layers: Layers, value: F8, rounds: int, sign: float) -> F8:
    from belvedere.walkthrough._span_kernels import spread

    one, two = np.empty_like(value), np.empty_like(value)
    spread(layers.link, value, rounds, sign, one, two)
    return one


def _stairs(layers: Layers) -> Mask:
    """Places where the floor keeps rising: at least two steps within 35 cm either way."""
    rounds = max(round(0.35 / layers.grid.spacing), 1)
    rise = _extreme(layers, layers.floor, rounds, 1.0) - _extreme(
        layers, layers.floor, rounds, -1.0
    )
    steep = rise >= 0.3
    cut = (layers.link >= 0) & (steep[:, None] != steep[layers.link])
    label, count = layers.label(cut)
    high, low = np.full(count, -np.inf), np.full(count, np.inf)
    np.maximum.at(high, label, layers.floor)
    np.minimum.at(low, label, layers.floor)
    flight = steep & (high - low >= 1.2)[label]
    # the landings at both ends are floor, not stair
    return flight & (layers.floor > low[label] + 0.05) & (layers.floor < high[label] - 0.05)


def soffits(layers: Layers) -> Mask:
    """Places under a strip of ceiling lower than what lies on both its sides: heads of doors.

    The strip is closed morphologically: the highest ceiling within reach, and of that the lowest.
    """
    rounds = max(round((DEEPEST_WALL_M / 2.0 + 0.1) / layers.grid.spacing), 1)
    ceiling = np.minimum(layers.ceiling, layers.floor + 6.0)
    closed = _extreme(layers, _extreme(layers, ceiling, rounds, 1.0), rounds, -1.0)
    return closed - ceiling >= SOFFIT_M


def neck_places(rooms: RoomLayer) -> I4:
    """The places in the middle of all necks that a door could be in, narrow or low-headed.

    Watershed of the distance to the walls, floods falling from the widest places; where two
    basins meet, the widest place of each stretch of their border is the middle of a neck. A
    soffit counts as half as wide, so that a door as wide as its corridor is a neck too.
    """
    from belvedere.walkthrough._span_kernels import flood_down

    layers = rooms.layers
    depth = np.where(soffits(layers), 0.5 * rooms.far, rooms.far)
    order = np.argsort(-np.round(depth, 4), kind="stable").astype(np.int32)
    basin = np.full(len(order), -1, dtype=np.int32)
    flood_down(order, layers.link, basin)
    border = ((layers.link >= 0) & (basin[:, None] != basin[layers.link])).any(axis=1)
    # stretches: border places of one basin that hang together
    both = border[:, None] & border[layers.link] & (basin[:, None] == basin[layers.link])
    label, _ = layers.label((layers.link >= 0) & ~both)
    on = np.flatnonzero(border & (rooms.far <= DOOR_M / 2.0 + layers.grid.spacing))
    widest = on[np.lexsort((-rooms.far[on], label[on]))]
    if not len(on):
        return np.zeros(0, dtype=np.int32)
    places = widest[np.unique(label[widest], return_index=True)[1]]
    # neighbouring stretches are one neck: keep the narrowest within a quarter of a metre
    bins = np.floor(layers.centers[places] / 0.25).astype(np.int64)
    level = np.round(layers.floor[places] / 0.5).astype(np.int64)
    order = np.lexsort((places, depth[places], level, bins[:, 1], bins[:, 0]))
    kinds = np.column_stack([bins, level])[order]
    fresh = np.concatenate([[True], (np.diff(kinds, axis=0) != 0).any(axis=1)])
    return np.sort(places[order][fresh]).astype(np.int32)


def beside_walls(rooms: RoomLayer) -> tuple[I4, F8]:
    """Places with something in the way on one side: which, and (K, 2) the direction to it."""
    layers = rooms.layers
    blocked = layers.link < 0
    way = np.array([[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]])
    place, direction = np.nonzero(blocked)
    return place.astype(np.int32), way[direction]
