"""Cells and portals of any mesh: no names, no semantics, only triangles.

    mesh -> columns -> floors -> rooms, furniture crossed -> necks -> doors fitted with rays
         -> the floors cut at the doors -> what hangs together is a cell -> windows, stairs

Necks come from the watershed of the distance to the walls, and from the ends of walls that face
something. A neck that is no door never cuts, so a furnished room or a long corridor stays whole
however many basins the watershed sees in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import SceneError
from belvedere.model.raycast import RayCaster
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough.cells import OUTSIDE, Cell, CellGraph, Portal
from belvedere.walkthrough.columns import LEAST_ROOM_M2, LEAST_WIDTH_M, Columns, Layers
from belvedere.walkthrough.contacts import Contact, Passages, add_contacts, facing
from belvedere.walkthrough.free_space import Body
from belvedere.walkthrough.leaves import named_doors, named_panes, without
from belvedere.walkthrough.necks import DOOR_M, Neck, fit_neck, wall_ends
from belvedere.walkthrough.outlines import outline_rings
from belvedere.walkthrough.rooms import (
    RoomLayer,
    beside_walls,
    find_rooms,
    neck_places,
)

F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]
Mask = npt.NDArray[np.bool_]

SKY_SHARE = 0.3
"""A place with more open sky than this is outdoors."""
OPEN_EDGE = 0.4
"""As is one that has nothing round more than so much of its edge."""
DROPPED = -2
"""Label of what belongs to no cell."""

__all__ = ["find_cells"]


def find_cells(
    mesh: Mesh,
    *,
    spacing: float = 0.05,
    body: Body | None = None,
    closed_doors: npt.NDArray[np.bool_] | None = None,
    panes: npt.NDArray[np.bool_] | None = None,
) -> CellGraph:
    """Find the rooms of a mesh and what joins them.

    Args:
        mesh: a building, metres, +z up.
        spacing: of the grid that rooms are found on, metres.
        body: who must be able to stand in a room; an adult by default.
        closed_doors: (M,) faces of door leaves that stand closed, to be looked through; by
            default those whose material is named as a door.
        panes: (M,) faces of windows and glass, likewise by default.

    Raises:
        SceneError: an empty mesh, one not in metres, no floor, no ceiling anywhere, or no room
            large enough.
        MissingDependencyError: embreex is not installed.

    Source: cells and portals, spec portal-walkthrough 2; how they are found is our own.
    """
    if not len(mesh.faces):
        raise SceneError("find_cells: the model has no faces: there is no building in it")
    doors = named_doors(mesh) if closed_doors is None else np.asarray(closed_doors, dtype=bool)
    glass = named_panes(mesh) if panes is None else np.asarray(panes, dtype=bool)
    for name, faces in (("closed_doors", doors), ("panes", glass)):
        if faces.shape != (len(mesh.faces),):
            raise SceneError(
                f"find_cells.{name} has shape {faces.shape}, expected ({len(mesh.faces)},): one "
                "mark for each face"
            )
    body = body or Body()
    turn = _turn_of_walls(mesh)
    mesh = _turned(mesh, turn)
    solid = without(mesh, doors)
    columns = Columns.of_mesh(solid, spacing)
    origin = np.array(columns.grid.origin)
    rooms = find_rooms(columns, body)
    caster = RayCaster(_moved(solid, origin))
    necks = _doors(caster, rooms, body)
    parts = _cut(columns, rooms, necks)
    if not parts.count:
        raise SceneError(
            "find_cells: no floor lies under a ceiling: a model without ceilings has no rooms. "
            "State its cells in a side file (see docs/formats.md), or add the ceilings"
        )
    cells = _cells(rooms, parts)
    known = [Contact(n.corners, a, b, "door" if n.lintel else "opening") for n, a, b in parts.doors]
    clear = RayCaster(_moved(without(mesh, doors | glass), origin)) if glass.any() else caster
    passages = Passages.of_layers(rooms.layers.take(rooms.walkable), parts.label[rooms.walkable])
    contacts = add_contacts(cells, clear, caster, known, _seeds(rooms, parts, body), passages)
    return _graph(cells, contacts, origin, turn)


def _turn_of_walls(mesh: Mesh) -> F8:
    """(2, 2) the turn about z that brings most of the walls onto the axes.

    On a grid along its walls a room's outline is a few straight sides, not a staircase.
    """
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    upright = (np.abs(normal[:, 2]) < 0.05 * size) & (size > 0.0)
    if not upright.any():
        return np.eye(2)
    angle = np.degrees(np.arctan2(normal[upright, 1], normal[upright, 0])) % 90.0
    weight = size[upright]
    count, _ = np.histogram(angle, bins=180, range=(0.0, 90.0), weights=weight)
    peak = (int(np.argmax(count + np.roll(count, 1))) * 0.5) % 90.0
    off = (angle - peak + 45.0) % 90.0 - 45.0
    near = np.abs(off) < 1.0
    best = peak + float((off[near] * weight[near]).sum() / weight[near].sum())
    best = (best + 45.0) % 90.0 - 45.0
    if abs(best) < 0.05:
        return np.eye(2)
    t = np.radians(best)
    return np.array([[np.cos(t), np.sin(t)], [-np.sin(t), np.cos(t)]])


def _turned(mesh: Mesh, turn: F8) -> Mesh:
    if (turn == np.eye(2)).all():
        return mesh
    points = mesh.vertices.copy()
    points[:, :2] = points[:, :2] @ turn.T
    return Mesh(points, mesh.faces, mesh.material_index, mesh.uv, mesh.materials)


def _moved(mesh: Mesh, origin: F8) -> Mesh:
    """The mesh near the origin, where float32 is fine enough for Embree."""
    return Mesh(mesh.vertices - origin, mesh.faces, mesh.material_index, mesh.uv, mesh.materials)


def _doors(caster: RayCaster, rooms: RoomLayer, body: Body) -> list[Neck]:
    """All door-like necks, each once."""
    layers, found = rooms.layers, []
    place, way = beside_walls(rooms)
    which, middle, along = wall_ends(
        caster, layers.centers[place], layers.floor[place], way, body.head
    )
    for k, at, across in zip(which, middle, along, strict=True):
        floor = float(layers.floor[place[k]])
        neck = fit_neck(caster, at, floor, body.head, across)
        if neck is not None:
            found.append(neck)
    for n in neck_places(rooms):
        at, floor = layers.centers[n], float(layers.floor[n])
        if any(
            n.lintel and np.hypot(*(at - n.center)) < 0.3 and abs(floor - n.floor) < 0.6
            for n in found
        ):
            continue
        neck = fit_neck(caster, at, floor, body.head)
        if neck is not None and neck.width <= DOOR_M:
            found.append(neck)
    best: list[Neck] = []
    for neck in sorted(found, key=lambda n: (not n.lintel, round(n.width, 2), n.floor)):
        if all(
            np.hypot(*(neck.center - other.center)) > 0.5 or abs(neck.floor - other.floor) > 0.6
            for other in best
        ):
            best.append(neck)
    return best


@dataclass(frozen=True, eq=False)
class _Parts:
    """Which part of the floors is which cell."""

    label: I4
    """(N,) cell, `OUTSIDE` or `DROPPED`."""
    count: int
    """Cells."""
    doors: list[tuple[Neck, int, int]]
    """Necks with the cells on their sides."""
    stairs: frozenset[int]
    """Cells that are stairs."""


def _cut(columns: Columns, rooms: RoomLayer, necks: list[Neck]) -> _Parts:
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
    return _Parts(final, int(room.sum()), doors, flat)


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


def _cells(rooms: RoomLayer, parts: _Parts) -> list[Cell]:
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


def _seeds(rooms: RoomLayer, parts: _Parts, body: Body) -> list[F8]:
    """Eyes spread over each cell, at different heights where the room is high."""
    layers, seeds = rooms.layers, []
    for k in range(parts.count):
        own = np.flatnonzero((parts.label == k) & rooms.walkable)
        if not len(own):
            own = np.flatnonzero(parts.label == k)
        some = own[np.linspace(0, len(own) - 1, min(24, len(own))).astype(int)]
        eye = layers.floor[some] + body.eye
        high = layers.floor[some] + 0.8 * np.minimum(layers.ceiling[some] - layers.floor[some], 8.0)
        both = np.concatenate([eye, np.maximum(eye, high)])
        seeds.append(np.column_stack([np.tile(layers.centers[some], (2, 1)), both]))
    return seeds


def _graph(cells: list[Cell], contacts: list[Contact], origin: F8, turn: F8) -> CellGraph:
    """Names given, and everything moved to where it stands in the world."""
    placed = tuple(
        Cell(
            cell.name, tuple((ring + origin[:2]) @ turn for ring in cell.rings),
            float(cell.floor + origin[2]), float(cell.ceiling + origin[2]), cell.storey,
        )
        for cell in cells
    )  # fmt: skip
    portals: list[Portal] = []
    count: dict[str, int] = {}
    for contact in contacts:
        inner = contact.kind == "window" and contact.second != OUTSIDE
        word = "view" if inner else contact.kind  # over a railing, through a serving hatch
        count[word] = count.get(word, 0) + 1
        corners = facing(contact.corners, cells[contact.first]) + origin
        corners[:, :2] = corners[:, :2] @ turn
        sides = (contact.first, contact.second)
        portals.append(Portal(f"{word} {count[word]}", contact.kind, corners, sides))
    return CellGraph(placed, tuple(portals))
