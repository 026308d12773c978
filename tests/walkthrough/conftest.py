"""Shared buildings; everything here casts rays."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("embreex", reason="ray casting needs embreex (pip install 'belvedere[model]')")

from belvedere.model import Building, Interior, Opening, Room, build_interior
from belvedere.scene.mesh import Material, Mesh
from belvedere.walkthrough import CellGraph, PlacementOptions, PortalImages, Side, find_cells
from tests.walkthrough.graphs import three_rooms

LEVEL = {"IfcDoor": "door", "IfcWindow": "window", "IfcOpeningElement": "opening"}


@pytest.fixture(scope="session")
def duplex(shared_data: Path) -> Mesh:
    """The Duplex apartment building, one material for each kind of element."""
    path = shared_data / "arch-duplex" / "derived" / "duplex.obj"
    if not path.is_file():
        pytest.skip("no duplex.obj in the shared data")
    points, faces, index, names, current = [], [], [], [], 0
    for line in path.read_text().splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            points.append([float(w) for w in words[1:4]])
        elif words[0] == "usemtl" and words[1] not in names:
            names.append(words[1])
        elif words[0] == "f":
            faces.append([int(w) - 1 for w in words[1:4]])
            index.append(current)
        if words[0] == "usemtl":
            current = names.index(words[1])
    materials = tuple(Material(name) for name in names)
    uv = np.zeros((len(faces), 3, 2), np.float32)
    return Mesh(np.array(points), np.array(faces), np.array(index), uv, materials)


@pytest.fixture(scope="session")
def duplex_truth(shared_data: Path) -> dict:
    path = shared_data / "arch-duplex" / "derived" / "duplex_cells.json"
    if not path.is_file():
        pytest.skip("no duplex_cells.json in the shared data")
    return json.loads(path.read_text())


@pytest.fixture(scope="session")
def duplex_building(duplex_truth: dict) -> Building:
    rooms = tuple(
        Room(
            f"{cell['name']} {cell['long_name']}", tuple(np.array(r) for r in cell["footprint"]),
            cell["z_floor"], cell["z_ceiling"],
        )
        for cell in duplex_truth["cells"]
    )  # fmt: skip
    openings = tuple(
        Opening(f"{p['type'][3:]} {p['id']}", LEVEL[p["type"]], np.array(p["polygon"]))  # type: ignore[arg-type]
        for p in duplex_truth["portals"]
    )
    return Building(rooms, openings)


@pytest.fixture(scope="session")
def duplex_cells(duplex: Mesh) -> CellGraph:
    return find_cells(duplex)


@pytest.fixture(scope="session")
def house() -> Interior:
    return build_interior(rays=8)


@pytest.fixture(scope="session")
def interior_mesh(house: Interior) -> Mesh:
    return house.mesh


@pytest.fixture(scope="session")
def graph() -> CellGraph:
    return three_rooms()


@pytest.fixture(scope="session")
def images(house: Interior, graph: CellGraph) -> dict[tuple[int, int], PortalImages]:
    options = PlacementOptions(texels=96)
    from belvedere.walkthrough import semicircle_eyes

    taken = {}
    for k, portal in enumerate(graph.portals):
        for cell in portal.cells:
            side = Side(portal, cell, 0.0)
            taken[k, cell] = PortalImages.take(
                house, side, options, semicircle_eyes(side, options, 4)
            )
    return taken
