"""Cells and portals of any mesh: no names, no semantics, only triangles.

    mesh -> columns -> floors -> rooms, furniture crossed -> necks -> doors fitted with rays
         -> the floors cut at the doors -> what hangs together is a cell -> windows, stairs

Necks come from the watershed of the distance to the walls, and from the ends of walls that face
something. `parts` cuts, `prisms` gives what is cut its shape.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import SceneError
from belvedere.model.raycast import RayCaster
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough.cells import OUTSIDE, Cell, CellGraph, Portal
from belvedere.walkthrough.columns import Columns
from belvedere.walkthrough.contacts import Contact, Passages, add_contacts, facing
from belvedere.walkthrough.free_space import Body
from belvedere.walkthrough.leaves import named_doors, named_panes, without
from belvedere.walkthrough.necks import DOOR_M, Neck, fit_neck, wall_ends
from belvedere.walkthrough.parts import Parts, cut_floors
from belvedere.walkthrough.prisms import prisms
from belvedere.walkthrough.rooms import (
    RoomLayer,
    beside_walls,
    find_rooms,
    neck_places,
)

F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]
Mask = npt.NDArray[np.bool_]

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
    parts = cut_floors(columns, rooms, necks)
    if not parts.count:
        raise SceneError(
            "find_cells: no floor lies under a ceiling: a model without ceilings has no rooms. "
            "State its cells in a side file (see docs/formats.md), or add the ceilings"
        )
    cells = prisms(rooms, parts)
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


def _seeds(rooms: RoomLayer, parts: Parts, body: Body) -> list[F8]:
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
