"""What an eye sees of a building."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from belvedere.ground.errors import CameraError, InputError
from belvedere.scene import Camera, SphereCamera
from belvedere.walkthrough import OUTSIDE, Cell, CellGraph, Portal, Visibility, view_cell
from tests.oracles.sight import cells_along
from tests.walkthrough.graphs import grid_of_rooms, ring, three_rooms, upright


def camera_at(eye, yaw: float, pitch: float = 0.0, fov: float = 60.0) -> Camera:
    ahead = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)])
    return Camera.look_at(eye, np.asarray(eye) + ahead, fov_deg=fov, width=40, height=32)


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_no_cell_that_a_ray_gets_to_is_missed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    graph = grid_of_rooms(4, 3, rng)
    here = int(rng.integers(len(graph.cells)))
    low, high = graph.cells[here].low, graph.cells[here].high
    eye = low + rng.uniform(0.02, 0.98, 3) * (high - low)
    camera = camera_at(eye, rng.uniform(0, 2 * np.pi), rng.uniform(-0.5, 0.5), 75.0)
    found = {sight.cell for sight in Visibility(graph).look(camera)}
    u, v = np.meshgrid(np.arange(40), np.arange(32))
    passed = set()
    for ray in camera.rays(u, v).reshape(-1, 3):
        passed |= cells_along(graph, here, eye, ray)
    assert passed <= found


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_a_cell_is_found_only_if_a_ray_gets_near_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    graph = grid_of_rooms(4, 3, rng)
    here = int(rng.integers(len(graph.cells)))
    low, high = graph.cells[here].low, graph.cells[here].high
    eye = low + rng.uniform(0.1, 0.9, 3) * (high - low)
    camera = camera_at(eye, rng.uniform(0, 2 * np.pi))
    for sight in Visibility(graph).look(camera):
        if len(sight.polygon):  # the middle of what is left is a ray that gets there
            ray = sight.polygon.mean(axis=0)
            assert sight.cell in cells_along(graph, here, eye, ray)
            assert (sight.planes @ ray >= -1e-9).all()


def test_sight_names_its_chain_of_portals() -> None:
    graph = three_rooms()
    camera = Camera.look_at((1.0, 1.2, 1.6), (7.0, 2.6, 1.6), width=64, height=48)
    sights = Visibility(graph).look(camera)
    assert [s.cell for s in sights] == [0, 1]
    assert [s.chain for s in sights] == [(), (0,)]
    assert sights[0].portal == -1
    assert len(sights[0].polygon) == 0


def test_a_closed_portal_is_seen_but_not_followed() -> None:
    rooms = [Cell(f"{k}", ring(4 * k, 0, 4 * k + 3.8, 3), 0, 2.6) for k in range(4)]
    doors = [upright(f"d{k}", "x", 4 * k + 3.9, (1, 2), (0, 2), (k, k + 1)) for k in range(3)]
    graph = CellGraph(tuple(rooms), tuple(doors))
    camera = camera_at((1.0, 1.5, 1.6), 0.0)
    look = Visibility(graph)
    assert [s.cell for s in look.look(camera)] == [0, 1, 2, 3]
    closed = np.array([False, True, False])
    assert [s.cell for s in look.look(camera, closed=closed)] == [0, 1, 2]
    assert [s.cell for s in look.look(camera, reach=5.0)] == [0, 1]


def test_an_eye_in_a_doorway_sees_both_rooms() -> None:
    graph = three_rooms()
    for x in (5.21, 5.265, 5.27, 5.275, 5.33):
        for yaw in (0.0, np.pi):
            found = {s.cell for s in Visibility(graph).look(camera_at((x, 2.2, 1.6), yaw, fov=90))}
            assert (1 if yaw == 0.0 else 0) in found


@settings(max_examples=60)
@given(st.floats(-3.0, -1.0), st.floats(-2.0, -0.5), st.floats(0.9, 1.6))
def test_an_eye_beside_a_portal_between_rooms_without_a_wall_sees_through_it(
    before: float, beside: float, yaw: float
) -> None:
    """However near its plane it stands: there is air, where in a doorway there would be wall."""
    rooms = (Cell("kitchen", ring(0, 0, 4, 4), 0, 2.6), Cell("hall", ring(4, 0, 8, 4), 0, 2.6))
    graph = CellGraph(rooms, (upright("contact", "x", 4.0, (1.5, 3), (0, 2.6), (0, 1)),))
    eye = np.array([4.0 - 10.0**before, 1.5 - 10.0**beside, 1.3])
    camera = camera_at(eye, yaw, fov=90.0)
    u, v = np.meshgrid(np.arange(40), np.arange(32))
    passed = set()
    for ray in camera.rays(u, v).reshape(-1, 3):
        passed |= cells_along(graph, 0, eye, ray)
    found = {sight.cell for sight in Visibility(graph).look(camera, 0)}
    assert passed <= found


def test_a_portal_leads_outside() -> None:
    graph = CellGraph(
        (Cell("room", ring(0, 0, 4, 4), 0, 2.6),),
        (upright("window", "x", 4.1, (1, 3), (0.8, 2.0), (0, OUTSIDE), "window"),),
    )
    look = Visibility(graph)
    assert [s.cell for s in look.look(camera_at((1, 2, 1.5), 0.0))] == [0, OUTSIDE]
    assert [s.cell for s in look.look(camera_at((8, 2, 1.5), np.pi))] == [OUTSIDE, 0]
    assert [s.cell for s in look.look(camera_at((8, 2, 1.5), 0.0))] == [OUTSIDE]


def test_a_portal_in_a_floor_is_looked_through() -> None:
    rooms = (Cell("below", ring(0, 0, 4, 4), 0, 2.5), Cell("above", ring(0, 0, 4, 4), 2.8, 5.3))
    well = np.array([[1, 1, 2.65], [3, 1, 2.65], [3, 3, 2.65], [1, 3, 2.65]], dtype=float)
    portal = Portal("well", "opening", well, (1, 0))  # its normal is +z, into "above"
    look = Visibility(CellGraph(rooms, (portal,)))
    assert {s.cell for s in look.look(camera_at((2, 0.5, 1.6), np.pi / 2, 0.8))} == {0, 1}
    assert {s.cell for s in look.look(camera_at((2, 0.5, 1.6), np.pi / 2, -0.8))} == {0}


def test_the_view_cell_of_a_doorway_is_that_on_the_eyes_side() -> None:
    graph = three_rooms()
    assert view_cell(graph, (1, 1, 1.6)) == 0
    assert view_cell(graph, (5.25, 2, 1.6)) == 0
    assert view_cell(graph, (5.29, 2, 1.6)) == 1
    assert view_cell(graph, (5.27, 4.47, 1.6)) == OUTSIDE  # in the wall's corner
    assert view_cell(graph, (20, 20, 1.6)) == OUTSIDE


def test_an_eye_where_an_outline_reaches_through_a_portal_looks_into_both_cells() -> None:
    """In the well of a skylight the attic's prism begins, but the hall's air goes on."""
    rooms = (Cell("hall", ring(0, 0, 4, 4), 0, 2.6), Cell("attic", ring(0, 0, 4, 4), 2.6, 5))
    corners = np.array([[1, 1, 2.9], [2, 1, 2.9], [2, 2, 2.9], [1, 2, 2.9]])
    skylight = Portal("skylight", "window", corners, (1, 0))  # its normal is +z, into the attic
    look = Visibility(CellGraph(rooms, (skylight,)))
    found = {
        z: [sight.cell for sight in look.look(camera_at((1.5, 1.5, z), 0.0, -0.7))]
        for z in (2.5, 2.7, 2.89, 2.91, 4.0)
    }
    assert found == {2.5: [0], 2.7: [1, 0], 2.89: [1, 0], 2.91: [1, 0], 4.0: [1, 0]}
    beside = camera_at((3.0, 3.0, 2.7), 0.0, -0.7)  # there the outline is believed
    assert [sight.cell for sight in look.look(beside)] == [1]


def test_only_planar_cameras_have_a_frustum() -> None:
    graph = three_rooms()
    around = SphereCamera.at((1, 1, 1.6), width=32, height=16)
    with pytest.raises(CameraError, match="planar"):
        Visibility(graph).look(around)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="reach"):
        Visibility(graph).look(camera_at((1, 1, 1), 0.0), reach=float("nan"))
