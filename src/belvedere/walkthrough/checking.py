"""Is a cell graph fit to be walked? Findings that a person understands, not exceptions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer
from belvedere.ground.errors import SceneError
from belvedere.model.raycast import RayCaster
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough.cells import OUTSIDE, Cell, CellGraph, Portal, enclosed
from belvedere.walkthrough.contacts import crossing
from belvedere.walkthrough.leaves import named_doors, named_panes, without
from belvedere.walkthrough.necks import DOOR_M

F8 = npt.NDArray[np.float64]

SIDE_M = (0.03, 0.06, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0)
"""How far from a portal its cells are looked for."""
SLACK_M = 0.65
"""How far beyond its outline a cell's own walls may lie: niches, behind fitted cupboards."""
LEAK_WARNING, LEAK_ERROR = 1.0, 10.0
"""Percent of rays."""

__all__ = ["Finding", "check_cells", "leak_percent"]


@dataclass(frozen=True, slots=True)
class Finding:
    """Something about a cell graph that a person should know."""

    severity: Literal["error", "warning", "note"]
    """error: pictures will be wrong there; warning: probably not meant; note: as it may be."""
    where: str
    """The cell or portal."""
    what: str
    """What is the matter, with numbers."""
    mend: str
    """What to do about it."""

    def __str__(self) -> str:
        return f"{self.severity}: {self.where}: {self.what}. {self.mend}"


def check_cells(graph: CellGraph, mesh: Mesh, rays: int = 256) -> list[Finding]:
    """Everything doubtful about a cell graph, worst first.

    Args:
        graph: cells and portals in the mesh's coordinates.
        mesh: the building; door leaves and panes are told by their materials' names.
        rays: cast from each of up to 12 points of a cell to measure its leak.

    Raises:
        SceneError: the mesh is empty, or lies nowhere near the cells.
        InputError: rays is not a whole number from 16 to 65536.
    """
    rays = check_integer("check_cells", "rays", rays, 16, 65536)
    if not len(mesh.faces):
        raise SceneError("check_cells: the model has no faces")
    origin = np.floor(np.mean([cell.low for cell in graph.cells], axis=0))
    local = _moved(graph, origin)
    clear = without(mesh, named_doors(mesh) | named_panes(mesh))
    if not len(clear.faces):
        raise SceneError("check_cells: the model consists of doors and windows only")
    caster = RayCaster(
        Mesh(clear.vertices - origin, clear.faces, clear.material_index, clear.uv, clear.materials)
    )
    findings = [
        *_check_portals(local, caster),
        *_check_rooms(local),
        *_check_overlap(local),
        *_check_leaks(local, caster, rays),
    ]
    order = ("error", "warning", "note")
    return sorted(findings, key=lambda finding: order.index(finding.severity))


def leak_percent(graph: CellGraph, mesh: Mesh, rays: int = 256) -> F8:
    """(cells,) of all rays from inside a cell, how many leave it other than through a portal."""
    origin = np.floor(np.mean([cell.low for cell in graph.cells], axis=0))
    clear = without(mesh, named_doors(mesh) | named_panes(mesh))
    caster = RayCaster(
        Mesh(clear.vertices - origin, clear.faces, clear.material_index, clear.uv, clear.materials)
    )
    local = _moved(graph, origin)
    return np.array([_leak(local, k, caster, rays) for k in range(len(local.cells))])


def _moved(graph: CellGraph, origin: F8) -> CellGraph:
    cells = tuple(
        Cell(
            c.name, tuple(ring - origin[:2] for ring in c.rings), c.floor - float(origin[2]),
            c.ceiling - float(origin[2]), c.storey,
        )
        for c in graph.cells
    )  # fmt: skip
    portals = tuple(Portal(p.name, p.kind, p.corners - origin, p.cells) for p in graph.portals)
    return CellGraph(cells, portals)


def _title(graph: CellGraph, cell: int) -> str:
    return "the outside" if cell == OUTSIDE else repr(graph.cells[cell].name)


def _check_portals(graph: CellGraph, caster: RayCaster) -> list[Finding]:
    findings = []
    for portal in graph.portals:
        where = f"portal {portal.name!r}"
        joins = f"{_title(graph, portal.cells[0])} and {_title(graph, portal.cells[1])}"
        first, second = (
            _lies_in(graph, portal, cell, sign)
            for cell, sign in zip(portal.cells, (1.0, -1.0), strict=True)
        )
        if not (first and second):
            missing = _title(graph, portal.cells[0] if not first else portal.cells[1])
            findings.append(
                Finding(
                    "error", where,
                    f"does not lie between {joins}: within a metre of its plane there is no trace "
                    f"of {missing} on that side",
                    "Move its corners into the wall between the two, or name the cells it joins",
                )
            )  # fmt: skip
        elif _walled_up(portal, caster):
            findings.append(
                Finding(
                    "error", where, "is walled up: no ray passes it",
                    "Its plane or corners are off, or a door leaf stands closed in the mesh under "
                    "a name that says nothing of a door",
                )
            )  # fmt: skip
        width = float(np.linalg.norm(portal.corners[1] - portal.corners[0]))
        if portal.kind == "door" and width > DOOR_M + 0.01 and abs(portal.normal[2]) < 0.5:
            findings.append(
                Finding(
                    "warning", where, f"is a door {width:.2f} m wide",
                    'Doors are up to 2 m wide: is it an "opening"?',
                )
            )  # fmt: skip
    return findings


def _lies_in(graph: CellGraph, portal: Portal, cell: int, sign: float) -> bool:
    """Whether the cell is found on one side of a portal; a side is outside if no cell is near."""
    spread = np.array([[0.5, 0.5], [0.2, 0.5], [0.8, 0.5], [0.5, 0.2], [0.5, 0.8]])
    a, c = portal.corners[0], portal.corners
    grid = a + spread[:, :1] * (c[1] - a) + spread[:, 1:] * (c[3] - a)
    points = (grid + sign * np.array(SIDE_M)[:, None, None] * portal.normal).reshape(-1, 3)
    if cell == OUTSIDE:
        return bool((graph.cells_at(points) == OUTSIDE).any())
    return bool(graph.cells[cell].contains(points).any())


def _walled_up(portal: Portal, caster: RayCaster) -> bool:
    spread = (np.arange(6) + 0.5) / 6.0
    s, t = (g.ravel() for g in np.meshgrid(spread, spread))
    a, c = portal.corners[0], portal.corners
    points = a + s[:, None] * (c[1] - a) + t[:, None] * (c[3] - a)
    way = np.broadcast_to(portal.normal, points.shape)
    reach = 0.12
    return bool(caster.blocked(points - reach * way, way, 2.0 * reach).all())


def _check_rooms(graph: CellGraph) -> list[Finding]:
    """Rooms without a door, and rooms that no walk from the largest part reaches."""
    findings = []
    group = list(range(len(graph.cells) + 1))  # the last one is the outside

    def root(k: int) -> int:
        while group[k] != k:
            k = group[k]
        return k

    for portal in graph.portals:
        if portal.walkable:
            a, b = (len(graph.cells) if c == OUTSIDE else c for c in portal.cells)
            group[root(a)] = root(b)
    roots = [root(k) for k in range(len(graph.cells))]
    most = max(set(roots), key=lambda r: (roots.count(r), -r))
    for k, cell in enumerate(graph.cells):
        where = f"cell {cell.name!r}"
        if not any(True for _ in graph.neighbours(k, walking=True)):
            findings.append(
                Finding(
                    "warning", where, "has no door: nobody can walk in or out",
                    "Is its door closed in the mesh under a name that says nothing of a door? "
                    "State the door in a side file, or leave the cell out",
                )
            )  # fmt: skip
        elif roots[k] != most:
            findings.append(
                Finding(
                    "warning", where,
                    f"cannot be reached from most other rooms ({roots.count(most)} hang together)",
                    "A door or a stair on the way is missing or closed",
                )
            )  # fmt: skip
        if not graph.portals_of[k]:
            findings.append(
                Finding(
                    "note", where, "has no portal at all: it is never seen from outside",
                    "Fine for a closed void",
                )
            )  # fmt: skip
    return findings


def _check_overlap(graph: CellGraph) -> list[Finding]:
    findings = []
    for a, cell in enumerate(graph.cells):
        for other in graph.cells[:a]:
            low, high = np.maximum(cell.low, other.low), np.minimum(cell.high, other.high)
            if (high - low).min() < 0.3:
                continue
            x, y = np.meshgrid(*(np.linspace(low[k], high[k], 40) for k in (0, 1)))
            both = enclosed(cell.rings, x, y) & enclosed(other.rings, x, y)
            area = float(both.mean() * (high[0] - low[0]) * (high[1] - low[1]))
            # one floor above another is told apart; two on one level are not
            if area > 0.5 and abs(cell.floor - other.floor) < 0.5:
                findings.append(
                    Finding(
                        "warning", f"cell {cell.name!r}",
                        f"overlaps {other.name!r} over {area:.1f} m2 on the same level",
                        "Redraw one outline: a point must lie in one cell",
                    )
                )  # fmt: skip
    return findings


def _check_leaks(graph: CellGraph, caster: RayCaster, rays: int) -> list[Finding]:
    findings = []
    for k, cell in enumerate(graph.cells):
        leak = _leak(graph, k, caster, rays)
        if leak > LEAK_WARNING:
            findings.append(
                Finding(
                    "error" if leak > LEAK_ERROR else "warning", f"cell {cell.name!r}",
                    f"is not closed: {leak:.1f} % of the rays from inside it leave through no "
                    "portal",
                    "A wall is missing, an opening has no portal, or the outline stops short of "
                    "the walls",
                )
            )  # fmt: skip
    return findings


def _leak(graph: CellGraph, index: int, caster: RayCaster, rays: int) -> float:
    cell = graph.cells[index]
    eyes = _eyes(graph, index)
    if not len(eyes):
        return 0.0
    k = np.arange(rays) + 0.5
    z, turn = 1.0 - 2.0 * k / rays, np.pi * (1.0 + np.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z**2)
    ways = np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)
    start, way = np.repeat(eyes, rays, axis=0), np.tile(ways, (len(eyes), 1))
    size = float(np.linalg.norm(cell.high - cell.low)) + 2.0
    t = np.minimum(caster.cast(start, way).t.astype(np.float64), size)
    end = start + np.maximum(t - SLACK_M, 0.0)[:, None] * way
    left = np.flatnonzero(~cell.contains(end))
    through = np.zeros(len(left), dtype=bool)
    for portal in (graph.portals[p] for p in graph.portals_of[index]):
        through |= crossing(portal.corners, start[left], way[left], t[left], 0.06)
    return 100.0 * float((~through).sum()) / len(start)


def _eyes(graph: CellGraph, index: int) -> F8:
    """Up to twelve points spread over a cell, in the air, and in no other cell."""
    cell = graph.cells[index]
    low, high = cell.low, cell.high
    n = 11
    axis = (np.arange(n) + 0.5) / n
    x, y = (g.ravel() for g in np.meshgrid(axis, axis))
    rise = min(1.6, 0.6 * (cell.ceiling - cell.floor))
    points = np.column_stack(
        [low[0] + x * (high[0] - low[0]), low[1] + y * (high[1] - low[1]), 0.0 * x + low[2] + rise]
    )
    inside = graph.cells_at(points) == index
    for way in ((0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.0, -0.2)):  # not within a wall
        inside &= cell.contains(points + np.array([*way, 0.0]))
    points = points[inside]
    if len(points) > 12:
        points = points[np.linspace(0, len(points) - 1, 12).astype(int)]
    return points
