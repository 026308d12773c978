from __future__ import annotations

import itertools

import numpy as np
import pytest

from belvedere.ground.errors import SceneError
from belvedere.scene.mesh import Material, Mesh
from belvedere.walkthrough import OUTSIDE, CellGraph, Portal, check_cells, find_cells
from belvedere.walkthrough.outlines import area_of
from tests.walkthrough import plans

DOORS = np.array([[1.425, 4.0, 1.015], [4.525, 4.0, 1.015], [7.425, 4.0, 1.015]])
"""Centres of the inner doors of `plans.flat`."""


def width(portal: Portal) -> float:
    return float(np.linalg.norm(portal.corners[1] - portal.corners[0]))


def inner(graph: CellGraph, kind: str = "door") -> list[Portal]:
    return [p for p in graph.portals if p.kind == kind and OUTSIDE not in p.cells]


def cell_of(graph: CellGraph, *points: tuple[float, float, float]) -> list[int]:
    return graph.cells_at(points).tolist()


def test_a_door_is_the_rectangle_between_jambs_lintel_and_floor() -> None:
    graph = find_cells(plans.two_rooms((1.5, 2.4, 0.0, 2.05)))
    assert len(graph.cells) == 2
    (door,) = graph.portals
    assert door.kind == "door"
    low, high = door.corners.min(axis=0), door.corners.max(axis=0)
    # in the middle of a wall 15 cm thick
    np.testing.assert_allclose(low, [4.0, 1.5 - 0.001, 0.0], atol=0.012)
    np.testing.assert_allclose(high, [4.0, 2.4 + 0.001, 2.05], atol=0.012)
    assert cell_of(graph, (1, 1, 1.6), (6, 1, 1.6)) == [door.cells[0], door.cells[1]] or (
        cell_of(graph, (6, 1, 1.6), (1, 1, 1.6)) == [door.cells[0], door.cells[1]]
    )
    assert graph.cells[door.cells[0]].contains([door.center + 0.3 * door.normal])[0]
    assert check_cells(graph, plans.two_rooms()) == []


@pytest.mark.parametrize("turn", [0.0, 30.0, 77.0])
def test_a_furnished_flat_has_its_rooms_and_no_more(turn: float) -> None:
    mesh = plans.moved(plans.flat(), turn)
    graph = find_cells(mesh)
    assert len(graph.cells) == 4  # three rooms and a corridor, whatever stands in them
    a = np.radians(turn)
    rotate = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    centers = np.array([p.center for p in inner(graph)])
    assert len(centers) == 3
    for truth in DOORS @ rotate.T:
        assert np.linalg.norm(centers - truth, axis=1).min() < 0.03
    assert all(abs(width(p) - 0.85) < 0.02 for p in inner(graph))
    outer = [p for p in graph.portals if OUTSIDE in p.cells]
    assert sorted(p.kind for p in outer) == ["door", "window"]
    window = next(p for p in outer if p.kind == "window")
    np.testing.assert_allclose(window.center, rotate @ [1.6, 0.0, 1.55], atol=0.12)
    assert width(window) == pytest.approx(1.2, abs=0.15)
    rooms = sorted(round(area_of(cell.rings), 1) for cell in graph.cells)
    # clear areas, plus half a grid square and a door's depth all round
    for area, truth in zip(rooms, [9.3, 10.9, 11.0, 11.0], strict=True):
        assert area == pytest.approx(truth, abs=0.8)
    assert [f for f in check_cells(graph, mesh) if f.severity == "error"] == []


def test_an_l_shape_is_one_room_without_a_door() -> None:
    graph = find_cells(plans.l_shape())
    assert len(graph.cells) == 1
    assert graph.portals == ()
    assert any("has no door" in f.what for f in check_cells(graph, plans.l_shape()))


def test_a_pillar_or_a_row_of_them_divides_no_room() -> None:
    posts = [plans.box((x, 2.35, 0.0), (x + 0.3, 2.65, 2.6)) for x in (1.3, 2.8, 4.3)]
    mesh = Mesh.concatenate([*plans.shell((6, 5), holes={"s": [(2.5, 3.4, 0, 2.1)]}), *posts])
    graph = find_cells(mesh)
    assert len(graph.cells) == 1
    assert [p.kind for p in graph.portals] == ["door"]


def test_a_beam_on_posts_is_no_wall() -> None:
    posts = [plans.box((x, 2.4, 0.0), (x + 0.2, 2.6, 2.2)) for x in (1.3, 2.8, 4.3)]
    beam = plans.box((0.0, 2.4, 2.2), (6.0, 2.6, 2.6))
    assert len(find_cells(Mesh.concatenate([*plans.shell((6, 5)), *posts, beam])).cells) == 1


@pytest.mark.parametrize(("hole", "cells"), [((1.5, 2.5), 2), ((1.0, 3.6), 2), ((0.0, 4.0), 1)])
def test_an_opening_up_to_the_ceiling_divides_where_walls_end(hole: tuple, cells: int) -> None:
    walls = plans.wall((4, 0), (4, 4.5), holes=[(hole[0], hole[1], 0.0, 2.6)])
    if hole == (0.0, 4.0):
        walls = plans.wall((4, 4.0), (4, 4.5))  # a stub
    mesh = Mesh.concatenate([*plans.shell((7, 4.5)), *walls])
    graph = find_cells(mesh)
    assert len(graph.cells) == cells
    if cells == 2:
        (opening,) = graph.portals
        assert opening.kind == "opening"
        assert width(opening) == pytest.approx(hole[1] - hole[0], abs=0.02)
        assert opening.corners[:, 2].max() == pytest.approx(2.6, abs=0.01)


def test_a_cupboard_makes_no_door() -> None:
    cupboard = plans.box((3.0, 0.1, 0.0), (3.5, 3.0, 2.1))  # a metre from the opposite wall
    graph = find_cells(Mesh.concatenate([*plans.shell((7, 4)), cupboard]))
    assert len(graph.cells) == 1


def test_a_door_as_wide_as_its_corridor_is_found_by_its_lintel() -> None:
    lintel = plans.box((3.0, 0.0, 2.05), (3.12, 1.2, 2.7))
    graph = find_cells(Mesh.concatenate([*plans.shell((7, 1.2)), lintel]))
    assert len(graph.cells) == 2
    assert width(graph.portals[0]) == pytest.approx(1.05, abs=0.02)
    assert graph.portals[0].center[0] == pytest.approx(3.06, abs=0.02)


def test_a_stair_between_storeys_is_a_cell_that_spans_them() -> None:
    mesh = plans.two_storeys()
    graph = find_cells(mesh)
    assert len(graph.cells) == 5
    stair = next(k for k, cell in enumerate(graph.cells) if cell.name.startswith("stair"))
    assert graph.cells[stair].floor == pytest.approx(0.0, abs=0.05)
    assert graph.cells[stair].ceiling == pytest.approx(5.4, abs=0.05)
    assert {cell.storey for cell in graph.cells} == {0, 1}
    below, above = cell_of(graph, (6.0, 3.2, 1.6), (6.0, 3.2, 4.4))
    walked = {beyond for _, beyond in graph.neighbours(stair, walking=True)}
    assert walked == {below, above}
    assert cell_of(graph, (2.0, 4.5, 0.4 + 1.6), (4.5, 4.5, 2.3 + 1.6)) == [stair, stair]
    assert [f for f in check_cells(graph, mesh) if f.severity == "error"] == []


def test_under_a_sloping_roof_the_rooms_are_found() -> None:
    roof = np.array(
        [(x, y, z + up) for up in (0.0, 0.2)
         for x, y, z in ((-0.2, -0.2, 2.0), (6.2, -0.2, 2.0), (6.2, 5.2, 4.0), (-0.2, 5.2, 4.0))]
    )  # fmt: skip
    corners = [(0.0, 0.0), (6.0, 0.0), (6.0, 5.0), (0.0, 5.0)]
    sides = itertools.pairwise([*corners, corners[0]])
    mesh = Mesh.concatenate(
        [
            plans.slab((-0.2, -0.2), (6.2, 5.2), 0.0), plans.solid(roof),
            *(part for a, b in sides for part in plans.wall(a, b, (0.0, 4.2))),
            *plans.wall((3, 0), (3, 5), (0.0, 4.2), holes=[(3.0, 3.9, 0.0, 2.05)]),
        ]
    )  # fmt: skip
    graph = find_cells(mesh)
    assert len(graph.cells) == 2
    assert [p.kind for p in graph.portals] == ["door"]


def test_closed_doors_are_opened_by_their_material_s_name() -> None:
    leaf = plans.box((3.97, 1.5, 0.0), (4.03, 2.4, 2.05), Material("Oak door"))
    unnamed = plans.box((3.97, 1.5, 0.0), (4.03, 2.4, 2.05))
    floor = plans.box((1.0, 1.0, 0.0), (1.5, 1.5, 0.02), Material("outdoor carpet"))
    rooms = plans.two_rooms()
    assert len(find_cells(Mesh.concatenate([rooms, leaf, floor])).portals) == 1
    shut = Mesh.concatenate([rooms, unnamed])
    assert len(find_cells(shut).portals) == 0
    told = np.zeros(len(shut.faces), dtype=bool)
    told[-12:] = True
    assert len(find_cells(shut, closed_doors=told).portals) == 1
    with pytest.raises(SceneError, match="closed_doors has shape"):
        find_cells(shut, closed_doors=told[:-1])


def test_panes_are_looked_through() -> None:
    holes = {"s": [(1.0, 2.2, 0.9, 2.2)]}
    pane = plans.box((1.0, -0.02, 0.9), (2.2, 0.02, 2.2), Material("window glass"))
    graph = find_cells(Mesh.concatenate([*plans.shell((5, 4), holes=holes), pane]))
    assert [p.kind for p in graph.portals] == ["window"]
    plain = plans.box((1.0, -0.02, 0.9), (2.2, 0.02, 2.2))
    assert find_cells(Mesh.concatenate([*plans.shell((5, 4), holes=holes), plain])).portals == ()


def test_the_built_in_house_has_its_three_rooms_and_three_doors(interior_mesh: Mesh) -> None:
    graph = find_cells(interior_mesh)
    assert len(graph.cells) == 3  # the gallery belongs to the high hall
    living, kitchen, hall, gallery = cell_of(
        graph, (2.5, 2, 1.6), (7, 2, 1.6), (3, 6, 1.6), (2, 7.3, 4.0)
    )
    assert len({living, kitchen, hall}) == 3
    assert gallery == hall
    joined = sorted(tuple(sorted(p.cells)) for p in inner(graph))
    assert joined == sorted(
        tuple(sorted(pair)) for pair in ((living, hall), (kitchen, hall), (living, kitchen))
    )
    assert all(p.kind == "window" for p in graph.portals if OUTSIDE in p.cells)
    assert [f for f in check_cells(graph, interior_mesh) if f.severity != "note"] == []


def test_the_duplex_has_nine_tenths_of_its_rooms(
    duplex_cells: CellGraph, duplex_truth: dict
) -> None:
    found: dict[int, list[str]] = {}
    enterable = [cell for cell in duplex_truth["cells"] if cell["long_name"] != "Roof"]
    assert len(enterable) == 20
    for cell in enterable:
        ring = np.array(cell["footprint"][0])
        at = np.array([*(ring.min(axis=0) + ring.max(axis=0)) / 2, cell["z_floor"] + 1.6])
        if cell["long_name"] == "Foyer":  # its outline is an L
            at[:2] = [7.5, -15.5] if cell["name"] == "A101" else [1.3, -2.2]
        (k,) = cell_of(duplex_cells, tuple(at))
        assert k != OUTSIDE, cell["long_name"]
        found.setdefault(k, []).append(cell["name"])
    # the kitchens are open to the living rooms over their whole width
    assert {tuple(names) for names in found.values() if len(names) > 1} == {
        ("A102", "A103"), ("B102", "B103"),
    }  # fmt: skip
    assert len(found) >= 0.9 * len(enterable)


def test_the_duplex_has_all_its_inner_doors_and_no_false_wide_portal(
    duplex_cells: CellGraph, duplex_truth: dict
) -> None:
    doors = inner(duplex_cells)
    centers = np.array([p.center for p in doors])
    truth = [
        p for p in duplex_truth["portals"] if p["type"] == "IfcDoor" and None not in p["cells"]
    ]
    assert len(truth) == 10
    for door in truth:
        polygon = np.array(door["polygon"])
        k = int(np.linalg.norm(centers - polygon.mean(axis=0), axis=1).argmin())
        assert np.linalg.norm(centers[k] - polygon.mean(axis=0)) < 0.05
        assert width(doors[k]) == pytest.approx(np.ptp(polygon, axis=0)[:2].max(), abs=0.03)
    assert len(doors) == len(truth)
    # what is wider than a door is where no wall stands: foyer to living room, stairs over railings
    wide = [p for p in inner(duplex_cells, "opening") if width(p) > 2.0]
    assert len(wide) == 2
    for opening in wide:
        assert width(opening) == pytest.approx(2.805, abs=0.02)


def test_the_duplex_is_closed_and_walkable(duplex: Mesh, duplex_cells: CellGraph) -> None:
    assert check_cells(duplex_cells, duplex) == []


def test_far_from_the_origin_the_same_is_found() -> None:
    shift = (1e8, -1e8, 1e5)
    near, far = find_cells(plans.flat()), find_cells(plans.moved(plans.flat(), 0.0, shift))
    assert [p.name for p in near.portals] == [p.name for p in far.portals]
    for a, b in zip(near.portals, far.portals, strict=True):
        np.testing.assert_allclose(b.corners - shift, a.corners, atol=0.02)


def scaled(factor: float) -> Mesh:
    mesh = plans.two_rooms()
    return Mesh(mesh.vertices * factor, mesh.faces, mesh.material_index, mesh.uv, mesh.materials)


def soup(rng: np.random.Generator) -> Mesh:
    """A building whose faces share no vertex, half of them turned over, some degenerate."""
    mesh = plans.two_rooms()
    corners = mesh.vertices[mesh.faces]
    flip = rng.random(len(corners)) < 0.5
    corners[flip] = corners[flip, ::-1]
    corners = np.concatenate([corners, np.repeat(corners[:20, :1], 3, axis=1)])
    count = len(corners)
    return Mesh(
        corners.reshape(-1, 3), np.arange(3 * count, dtype=np.int32).reshape(-1, 3),
        np.zeros(count, np.int32),
        np.zeros((count, 3, 2), np.float32), mesh.materials,
    )  # fmt: skip


def test_a_soup_of_faces_is_no_obstacle(rng: np.random.Generator) -> None:
    graph = find_cells(soup(rng))
    assert len(graph.cells) == 2
    assert [p.kind for p in graph.portals] == ["door"]


def test_what_cannot_be_a_building_is_refused() -> None:
    with pytest.raises(SceneError, match="no faces"):
        find_cells(Mesh.concatenate([]))
    with pytest.raises(SceneError, match="in millimetres"):
        find_cells(scaled(1000.0))
    with pytest.raises(SceneError, match="no floor"):
        find_cells(Mesh.concatenate(plans.wall((0, 0), (5, 0), thickness=0.05)))
    with pytest.raises(SceneError, match="without ceilings"):
        find_cells(plans.slab((0, 0), (10, 10), 0.0))
