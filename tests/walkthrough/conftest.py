"""One small lit building for all tests of this room."""

from __future__ import annotations

import pytest

from belvedere.model import Interior, build_interior
from belvedere.walkthrough import CellGraph, PlacementOptions, PortalImages, Side
from tests.walkthrough.plans import three_rooms


@pytest.fixture(scope="session")
def house() -> Interior:
    return build_interior(rays=8)


@pytest.fixture(scope="session")
def graph() -> CellGraph:
    return three_rooms()


@pytest.fixture(scope="session")
def images(house: Interior, graph: CellGraph) -> dict[tuple[int, int], PortalImages]:
    options = PlacementOptions(count=4, texels=96)
    return {
        (k, cell): PortalImages.take(house, Side(portal, cell, 0.0), options)
        for k, portal in enumerate(graph.portals)
        for cell in portal.cells
    }
