from __future__ import annotations

import warnings

import numpy as np
import pytest

from belvedere.ground.errors import SceneError
from belvedere.model import Building, Opening, Room
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough import OUTSIDE, CellGraph, cells_of_building, check_cells, leak_percent
from tests.walkthrough import plans


def rectangle(x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])


A = Room("a", (rectangle(0.075, 0.075, 3.925, 3.925),), 0.0, 2.6)
B = Room("b", (rectangle(4.075, 0.075, 6.925, 3.925),), 0.0, 2.6)
DOOR = np.array([[4.0, 1.5, 0.0], [4.0, 2.4, 0.0], [4.0, 2.4, 2.05], [4.0, 1.5, 2.05]])


@pytest.fixture(scope="module")
def stated(duplex: Mesh, duplex_building: Building) -> CellGraph:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # cupboards' doors are openings too
        return cells_of_building(duplex_building, duplex)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("rooms", [(None, None), ("a", None), (None, "b"), ("b", "a")])
def test_the_rooms_beside_an_opening_are_looked_up(turned: bool, rooms: tuple) -> None:
    door = Opening("door", "door", DOOR[::-1] if turned else DOOR, rooms)
    graph = cells_of_building(Building((A, B), (door,)), plans.two_rooms())
    (portal,) = graph.portals
    assert sorted(portal.cells) == [0, 1]
    sign = -1.0 if portal.cells[0] == 0 else 1.0
    assert portal.normal @ [1.0, 0.0, 0.0] == pytest.approx(sign)
    np.testing.assert_array_equal(np.sort(portal.corners, axis=0), np.sort(DOOR, axis=0))


def test_an_opening_that_nobody_stated_is_found() -> None:
    graph = cells_of_building(Building((A, B)), plans.two_rooms())
    (portal,) = graph.portals
    assert portal.kind == "opening"  # a leaf would make it a door; a hole is a hole
    low, high = portal.corners.min(axis=0), portal.corners.max(axis=0)
    assert (low <= [4.1, 1.5, 0.0]).all()  # never smaller than the hole
    assert (high >= [3.9, 2.4, 2.05]).all()
    np.testing.assert_allclose(low[1:], [1.5, 0.0], atol=0.12)
    np.testing.assert_allclose(high[1:], [2.4, 2.05], atol=0.12)
    assert cells_of_building(Building((A, B)), plans.two_rooms(), complete=False).portals == ()


def test_a_boundary_that_is_only_drawn_is_an_opening() -> None:
    halves = (
        Room("west", (rectangle(0.075, 0.075, 2.0, 3.925),), 0.0, 2.6),
        Room("east", (rectangle(2.0, 0.075, 3.925, 3.925),), 0.0, 2.6),
        B,
    )
    door = Opening("door", "door", DOOR)
    graph = cells_of_building(Building(halves, (door,)), plans.two_rooms())
    assert len(graph.portals) == 2
    drawn = next(p for p in graph.portals if p.name != "door")
    assert (drawn.kind, sorted(drawn.cells)) == ("opening", [0, 1])
    assert np.ptp(drawn.corners, axis=0)[1] == pytest.approx(3.85, abs=0.35)
    assert check_cells(graph, plans.two_rooms()) == []


def test_all_rooms_and_inner_doors_of_the_duplex(stated: CellGraph, duplex_truth: dict) -> None:
    assert len(stated.cells) == 21
    doors = [p for p in stated.portals if p.kind == "door"]
    assert len([p for p in doors if OUTSIDE not in p.cells]) == 10
    assert len(doors) == 14
    names = [cell["name"] for cell in duplex_truth["cells"]]
    ids = {cell["id"]: names.index(cell["name"]) for cell in duplex_truth["cells"]}
    for entry in duplex_truth["portals"]:
        if entry["type"] == "IfcDoor":
            truth = sorted(OUTSIDE if c is None else ids[c] for c in entry["cells"])
            door = next(p for p in doors if p.name == f"Door {entry['id']}")
            assert sorted(door.cells) == truth


def test_open_plan_and_stairs_of_the_duplex_are_joined(stated: CellGraph) -> None:
    joined = {
        frozenset(stated.cells[c].name[:4] for c in p.cells)
        for p in stated.portals
        if p.kind == "opening" and OUTSIDE not in p.cells
    }
    for flat in "AB":
        for pair in (
            ("102", "103"),
            ("101", "102"),
            ("101", "103"),
            ("101", "105"),
            ("105", "201"),
        ):
            assert frozenset(flat + room for room in pair) in joined, pair


def test_what_can_be_seen_in_the_duplex_is_seen_through_portals(
    stated: CellGraph, duplex: Mesh
) -> None:
    assert leak_percent(stated, duplex).max() < 0.5
    assert [f for f in check_cells(stated, duplex) if f.severity == "error"] == []


def test_openings_that_join_nothing_are_named_in_a_warning(duplex: Mesh) -> None:
    hatch = Opening("cupboard", "opening", DOOR - [2.0, 0.0, 0.0])
    with pytest.warns(UserWarning, match="1 openings have the same room, or none.*'cupboard'"):
        cells_of_building(Building((A, B), (hatch,)), plans.two_rooms())


def test_names_that_come_twice_are_told_apart() -> None:
    doors = (
        Opening("door", "door", DOOR),
        Opening("door", "window", DOOR + np.array([0, 0, 0.01])),
    )
    graph = cells_of_building(Building((A, B), doors), plans.two_rooms())
    assert [p.name for p in graph.portals] == ["door", "door (2)"]


def test_buildings_that_do_not_fit_their_mesh_are_refused() -> None:
    with pytest.raises(SceneError, match="states no rooms"):
        cells_of_building(Building(()), plans.two_rooms())
    far = plans.moved(plans.two_rooms(), 0.0, (500.0, 0.0, 0.0))
    with pytest.raises(SceneError, match="must be in the same coordinates"):
        cells_of_building(Building((A, B)), far)
    with pytest.raises(SceneError, match="no faces"):
        cells_of_building(Building((A, B)), Mesh.concatenate([]))
