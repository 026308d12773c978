"""Cells and portals of a building that says what its rooms are: IFC, side files, glTF extras.

What is stated is believed, and completed: the cells on the two sides of an opening are looked up
where they are not named, and where two rooms touch without a wall - an open kitchen, a stair, a
boundary that exists on the drawing only - the free contact surface becomes a portal too, so that
nothing that can be seen is lost.
"""

from __future__ import annotations

import math
import warnings

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import SceneError
from belvedere.model.building import Building, Opening, Room
from belvedere.model.raycast import RayCaster
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough.cells import OUTSIDE, Cell, CellGraph, Portal
from belvedere.walkthrough.columns import Columns, Layers, standing_layers
from belvedere.walkthrough.contacts import (
    WALL_M,
    Contact,
    Passages,
    add_contacts,
    cell_at,
    facing,
)
from belvedere.walkthrough.free_space import Body
from belvedere.walkthrough.leaves import named_doors, named_panes, without

F8 = npt.NDArray[np.float64]

SIDE_M = (0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8)
"""How far from an opening's plane the rooms on its sides are looked for."""

__all__ = ["cells_of_building"]


def cells_of_building(
    building: Building,
    mesh: Mesh,
    *,
    body: Body | None = None,
    closed_doors: npt.NDArray[np.bool_] | None = None,
    panes: npt.NDArray[np.bool_] | None = None,
    complete: bool = True,
) -> CellGraph:
    """Cells and portals from what a building states.

    Args:
        building: rooms and openings, in the mesh's coordinates.
        mesh: its triangles.
        body: who walks; decides which contacts can be walked through.
        closed_doors: (M,) faces of door leaves that stand closed; by default those whose
            material is named as a door.
        panes: (M,) faces of windows and glass, likewise by default.
        complete: also look for contacts that no opening is stated for.

    Raises:
        SceneError: no rooms, an empty mesh, or rooms that lie elsewhere than the mesh.
        MissingDependencyError: embreex is not installed.

    Openings that lie at no room, or have the same room on both sides (a cupboard's door, a roof
    window), are no portals; a warning names them.
    """
    if not building.rooms:
        raise SceneError(
            "The building states no rooms: find them with find_cells, or write a side file (see "
            "docs/formats.md)"
        )
    if not len(mesh.faces):
        raise SceneError("cells_of_building: the model has no faces: there is no building in it")
    origin = np.floor(mesh.bounds.mean(axis=0))
    cells = _cells(building.rooms, origin)
    _check_place(cells, mesh, origin)
    known, names = _stated(building.openings, building.rooms, cells, origin)
    count = len(known)
    contacts = known
    if complete:
        contacts = _completed(cells, known, mesh, origin, body or Body(), closed_doors, panes)
    taken = set(names)
    for contact in contacts[count:]:
        names.append(_new_name(contact, taken))
        taken.add(names[-1])
    portals = tuple(
        Portal(
            name, contact.kind, facing(contact.corners, cells[contact.first]) + origin,
            (contact.first, contact.second),
        )
        for name, contact in zip(names, contacts, strict=True)
    )  # fmt: skip
    return CellGraph(tuple(_moved(cell, origin) for cell in cells), portals)


def _moved(cell: Cell, by: F8) -> Cell:
    return Cell(
        cell.name, tuple(ring + by[:2] for ring in cell.rings), float(cell.floor + by[2]),
        float(cell.ceiling + by[2]), cell.storey,
    )  # fmt: skip


def _cells(rooms: tuple[Room, ...], origin: F8) -> list[Cell]:
    """One cell for each room; storeys are counted from below, by name or by height."""
    by_name: dict[str, float] = {}
    for room in rooms:
        by_name[room.storey] = min(room.floor, by_name.get(room.storey, np.inf))
    if len(by_name) > 1:
        order = sorted(by_name, key=lambda name: by_name[name])
        storeys = [order.index(room.storey) for room in rooms]
    else:
        levels: list[float] = []
        for floor in sorted(room.floor for room in rooms):
            if not levels or floor - levels[-1] > 1.5:
                levels.append(floor)
        storeys = [int(np.argmin(np.abs(np.array(levels) - room.floor))) for room in rooms]
    return [
        _moved(Cell(room.name, room.rings, room.floor, room.ceiling, storey), -origin)
        for room, storey in zip(rooms, storeys, strict=True)
    ]


def _check_place(cells: list[Cell], mesh: Mesh, origin: F8) -> None:
    low = np.min([cell.low for cell in cells], axis=0) + origin
    high = np.max([cell.high for cell in cells], axis=0) + origin
    bounds = mesh.bounds
    apart = (low > bounds[1] + 1.0) | (high < bounds[0] - 1.0)
    if apart.any():
        raise SceneError(
            f"The rooms stated lie at {np.round(low, 1).tolist()} to {np.round(high, 1).tolist()}, "
            f"the model at {np.round(bounds[0], 1).tolist()} to {np.round(bounds[1], 1).tolist()}: "
            "they must be in the same coordinates, metres, +z up"
        )


def _stated(
    openings: tuple[Opening, ...], rooms: tuple[Room, ...], cells: list[Cell], origin: F8
) -> tuple[list[Contact], list[str]]:
    """Openings that join two cells, or one and the outside, with names that differ."""
    index = {room.name: k for k, room in enumerate(rooms)}
    contacts, names, left = [], [], []
    for opening in openings:
        corners = opening.corners - origin
        sides = _sides_of(corners, cells)
        first, second = (
            index[name] if name is not None else found
            for name, found in zip(_match(opening, index, sides), sides, strict=True)
        )
        if first == OUTSIDE:
            first, second = second, first
        if first == second:
            left.append(opening.name)
            continue
        contacts.append(Contact(corners, first, second, opening.kind))
        name, number = opening.name, 2
        while name in names:
            name, number = f"{opening.name} ({number})", number + 1
        names.append(name)
    if left:
        shown = ", ".join(repr(name) for name in left[:4]) + (", ..." if len(left) > 4 else "")
        warnings.warn(
            f"{len(left)} openings have the same room, or none, on both sides and are no portals: "
            f"{shown}",
            stacklevel=3,
        )
    return contacts, names


def _match(
    opening: Opening, index: dict[str, int], sides: tuple[int, int]
) -> tuple[str | None, str | None]:
    """The stated rooms, in the order in which the cells were found on the sides."""
    a, b = opening.rooms
    if a is not None and b is not None:
        return a, b
    if a is None and b is None:
        return None, None
    stated = a if a is not None else b
    assert stated is not None
    return (None, stated) if sides[1] == index[stated] else (stated, None)


def _sides_of(corners: F8, cells: list[Cell]) -> tuple[int, int]:
    """The cell nearest before and behind a rectangle, or `OUTSIDE`."""
    normal = np.cross(corners[2] - corners[0], corners[3] - corners[1])
    normal = normal / np.linalg.norm(normal)
    spread = np.array([[0.5, 0.5], [0.25, 0.5], [0.75, 0.5], [0.5, 0.3], [0.5, 0.7]])
    a, u, v = corners[0], corners[1] - corners[0], corners[3] - corners[0]
    points = a + spread[:, :1] * u + spread[:, 1:] * v
    found = []
    for sign in (1.0, -1.0):
        side = OUTSIDE
        for far in SIDE_M:
            at = cell_at(cells, points + sign * far * normal)
            at = at[at != OUTSIDE]
            if len(at):
                side = int(np.bincount(at).argmax())
                break
        found.append(side)
    return found[0], found[1]


def _completed(
    cells: list[Cell],
    known: list[Contact],
    mesh: Mesh,
    origin: F8,
    body: Body,
    closed_doors: npt.NDArray[np.bool_] | None,
    panes: npt.NDArray[np.bool_] | None,
) -> list[Contact]:
    doors = named_doors(mesh) if closed_doors is None else closed_doors
    glass = named_panes(mesh) if panes is None else panes
    moved = Mesh(mesh.vertices - origin, mesh.faces, mesh.material_index, mesh.uv, mesh.materials)
    open_doors = without(moved, doors)
    solid = RayCaster(open_doors)
    clear = RayCaster(without(moved, doors | glass)) if glass.any() else solid
    columns = Columns.of_mesh(open_doors)
    layers, _ = standing_layers(columns, body.head, body.step)
    shift = np.array(columns.grid.origin)
    feet = np.column_stack([layers.centers, layers.floor]) + shift
    place = cell_at(cells, feet + np.array([0.0, 0.0, 1.2]))
    passages = Passages.of_layers(layers, _carried_through_walls(layers, place))
    passages = Passages(passages.points + shift, passages.cells, passages.spacing)
    return add_contacts(cells, clear, solid, known, _seeds(cells, feet, place, body), passages)


def _carried_through_walls(layers: Layers, place: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """Cells of places, those in doorways, between two rooms' outlines, given to the nearer room."""
    place = place.copy()
    for _ in range(math.ceil(WALL_M / layers.grid.spacing / 2.0)):
        before = place.copy()
        for d in range(4):
            n = np.flatnonzero((before == OUTSIDE) & (layers.link[:, d] >= 0))
            beside = before[layers.link[n, d]]
            n, beside = n[beside != OUTSIDE], beside[beside != OUTSIDE]
            place[n] = np.maximum(place[n], beside)
    return place


def _seeds(cells: list[Cell], feet: F8, place: npt.NDArray[np.int32], body: Body) -> list[F8]:
    """Eyes where people can stand, or on a lattice in cells where nobody can."""
    seeds = []
    for index, cell in enumerate(cells):
        own = feet[place == index]
        if len(own):
            some = own[np.linspace(0, len(own) - 1, min(24, len(own))).astype(int)]
            high = np.maximum(cell.ceiling - 0.4 - some[:, 2], 0.3)
            rise = [np.minimum(body.eye, high), np.minimum(2.4, high), high]
            seeds.append(np.concatenate([some + np.outer(r, [0, 0, 1]) for r in rise]))
            continue
        axis = np.array([0.2, 0.5, 0.8])
        lattice = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
        points = cell.low + lattice * (cell.high - cell.low)
        seeds.append(points[cell.contains(points)])
    return seeds


def _new_name(contact: Contact, taken: set[str]) -> str:
    """What a portal that nobody stated is called; short, for the plan."""
    word = "view" if contact.kind == "window" else contact.kind
    number = 1
    while f"{word} {number}" in taken:
        number += 1
    return f"{word} {number}"
