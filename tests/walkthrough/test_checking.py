from __future__ import annotations

import numpy as np
import pytest

from belvedere.ground.errors import InputError, SceneError
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough import (
    OUTSIDE,
    Cell,
    CellGraph,
    Finding,
    Portal,
    check_cells,
    leak_percent,
)
from tests.walkthrough import plans

A = Cell("a", (np.array([[0.075, 0.075], [3.925, 0.075], [3.925, 3.925], [0.075, 3.925]]),), 0, 2.6)
B = Cell("b", (np.array([[4.075, 0.075], [6.925, 0.075], [6.925, 3.925], [4.075, 3.925]]),), 0, 2.6)
DOOR = np.array([[4.0, 2.4, 0.0], [4.0, 1.5, 0.0], [4.0, 1.5, 2.05], [4.0, 2.4, 2.05]])


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    return plans.two_rooms()


def check(mesh: Mesh, *portals: Portal, cells: tuple[Cell, ...] = (A, B)) -> list[Finding]:
    return check_cells(CellGraph(cells, portals), mesh, rays=128)


def door(corners: np.ndarray = DOOR, cells: tuple[int, int] = (0, 1)) -> Portal:
    return Portal("door", "door", corners, cells)


def test_of_two_rooms_with_a_door_there_is_nothing_to_say(mesh: Mesh) -> None:
    assert check(mesh, door()) == []


def test_a_portal_in_the_wrong_plane_lies_between_nothing(mesh: Mesh) -> None:
    findings = check(mesh, door(DOOR - [2.0, 0.0, 0.0]))
    worst = findings[0]
    assert worst.severity == "error"
    assert "no trace of 'b'" in worst.what
    assert "portal 'door'" in str(worst)
    # the door itself now has no portal
    assert any("leave through no portal" in f.what and "'a'" in f.where for f in findings)


def test_a_portal_turned_round_is_told(mesh: Mesh) -> None:
    assert any(f.severity == "error" for f in check(mesh, door(DOOR[::-1])))


def test_a_portal_in_solid_wall_is_walled_up(mesh: Mesh) -> None:
    extra = Portal("blind", "opening", DOOR + np.array([0.0, 1.3, 0.0]), (0, 1))
    assert [f.what for f in check(mesh, door(), extra)] == ["is walled up: no ray passes it"]


def test_a_room_without_a_door_and_one_out_of_reach(mesh: Mesh) -> None:
    what = {f.where: f.what for f in check(mesh, Portal("door", "window", DOOR, (0, 1)))}
    assert "has no door" in what["cell 'a'"]
    far = np.array([20.0, 0.0])
    three = (A, B, *(Cell(n, (A.rings[0] + far,), 0, 2.6) for n in ("c",)))
    out = Portal("out", "door", DOOR[::-1] + np.array([16.0, 0.0, 0.0]), (2, OUTSIDE))
    what = {f.where: f.what for f in check(mesh, door(), out, cells=three)}
    assert "cannot be reached from most other rooms (2" in what["cell 'c'"]


def test_a_leak_is_measured(mesh: Mesh) -> None:
    graph = CellGraph((A, B), ())
    leak = leak_percent(graph, mesh)
    # the door fills that share of the sphere round a point of the room, on average
    assert 1.0 < leak[0] < 6.0
    assert 1.0 < leak[1] < 8.0
    assert leak_percent(CellGraph((A, B), (door(),)), mesh).max() < 0.1


def test_wide_doors_and_overlapping_rooms_are_doubted(mesh: Mesh) -> None:
    wide = np.array([[4.0, 3.6, 0.0], [4.0, 1.0, 0.0], [4.0, 1.0, 2.05], [4.0, 3.6, 2.05]])
    assert any("a door 2.60 m wide" in f.what for f in check(mesh, door(wide)))
    twice = Cell("twin", (A.rings[0] + [1.0, 0.0],), 0.1, 2.5)
    findings = check(mesh, door(), cells=(A, B, twice))
    assert any(f.what.startswith("overlaps 'a' over 1") for f in findings), findings


def test_an_empty_mesh_and_odd_numbers_of_rays_are_refused(mesh: Mesh) -> None:
    graph = CellGraph((A, B), (door(),))
    with pytest.raises(SceneError, match="no faces"):
        check_cells(graph, Mesh.concatenate([]))
    with pytest.raises(InputError, match="rays"):
        check_cells(graph, mesh, rays=1)
