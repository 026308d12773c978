"""Cells in sight beside cells that have pixels; ten thousand views by ``tests.visibility``."""

from __future__ import annotations

import json
import sys
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("embreex", reason="ray casting needs embreex (pip install 'belvedere[model]')")

from belvedere.scene import Camera
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough import OUTSIDE, CellGraph, Visibility
from tests import visibility
from tests.oracles.ids import NOWHERE, IdBuffer

SIZE = (80, 64)


@pytest.fixture(scope="module")
def flat() -> tuple[Mesh, CellGraph]:
    return visibility.opened("built-in:flat")


@pytest.fixture(scope="module")
def ids(flat: tuple[Mesh, CellGraph]) -> IdBuffer:
    mesh, graph = flat
    return IdBuffer(mesh, graph)


def test_no_cell_with_a_pixel_is_missed_and_few_are_found_in_vain(flat) -> None:
    """Of 300 views of the flat; in 10,000 of each house and the Duplex none was missed either."""
    mesh, graph = flat
    tally = visibility.compared(mesh, graph, range(300), size=SIZE)
    assert tally.views == 300
    assert tally.reasons["missed"] == tally.reasons["leak"] == 0, tally.told
    assert tally.excess_percent() <= 25.0
    assert all(len(shares) > 10 for shares in tally.excess.values())


def test_a_portal_that_is_not_looked_through_is_told_as_missed(flat, ids, monkeypatch) -> None:
    look = Visibility.look
    closed = np.ones(len(flat[1].portals), dtype=bool)
    monkeypatch.setattr(
        Visibility, "look", lambda self, camera, cell: look(self, camera, cell, closed=closed)
    )
    tally = visibility.Tally()
    for number in range(100):
        view = visibility.random_view(flat[1], 0, number, SIZE)
        visibility.compare(ids, Visibility(flat[1]), view, tally)
    assert tally.reasons["missed"] > 0
    assert "portals lead to" in "".join(tally.told)


def test_a_hole_without_a_portal_is_told_as_a_leak(flat) -> None:
    mesh, graph = flat
    between = next(k for k, portal in enumerate(graph.portals) if OUTSIDE not in portal.cells)
    walled = CellGraph(graph.cells, (*graph.portals[:between], *graph.portals[between + 1 :]))
    tally = visibility.compared(mesh, walled, range(100), size=SIZE)
    assert tally.reasons["leak"] > 0
    assert "entered at" in "".join(tally.told)


def test_a_surface_before_its_cells_portal_is_on_the_threshold(flat) -> None:
    """The outline reaches through the portal, as an attic's may into the well of a skylight."""
    mesh, graph = flat
    portal = next(p for p in graph.portals if OUTSIDE not in p.cells)
    moved = replace(portal, corners=portal.corners + 0.4 * portal.normal)
    graph = CellGraph(graph.cells, tuple(moved if p is portal else p for p in graph.portals))
    foot = portal.center * [1, 1, 0] + [0.0, 0.0, portal.corners[:, 2].min()]
    eye = foot - 0.4 * portal.normal + [0.0, 0.0, 1.0]
    camera = Camera.look_at(eye, foot + 0.2 * portal.normal, fov_deg=8.0, width=16, height=16)
    tally = visibility.Tally()
    view = visibility.View(0, "room", portal.cells[1], camera)
    visibility.compare(IdBuffer(mesh, graph), Visibility(graph), view, tally)
    assert dict(tally.reasons) == {"threshold": 1}, tally.told
    assert tally.excess_percent() == 0.0  # what is seen belongs to the eye's own cell


def test_a_pixel_that_no_ray_confirms_is_told_as_such(flat, ids, monkeypatch) -> None:
    """A crack between two surfaces that meet without sharing corners shows the sky."""
    draw = IdBuffer.draw

    def cracked(self, camera):
        labels, t = draw(self, camera)
        labels[3, 5] = OUTSIDE
        return labels, t

    monkeypatch.setattr(IdBuffer, "draw", cracked)
    room = flat[1].cells[0]
    eye = (room.low + room.high) / 2.0
    camera = Camera.look_at(eye, eye - [0.0, 0.01, 1.0], fov_deg=20.0, width=8, height=8)
    tally = visibility.Tally()
    view = visibility.View(0, "room", 0, camera)
    visibility.compare(ids, Visibility(flat[1]), view, tally)
    assert dict(tally.reasons) == {"unconfirmed": 1}
    assert tally.excess_percent() == 0.0


def test_pixels_show_the_cell_of_the_air_before_their_surface(ids) -> None:
    graph = ids.graph
    cell = 0
    eye = (graph.cells[cell].low + graph.cells[cell].high) / 2.0
    down = Camera.look_at(eye, eye - [0.0, 0.01, 1.0], fov_deg=20.0, width=8, height=8)
    labels, t = ids.draw(down)
    assert (labels == cell).all()
    v, u = np.indices(labels.shape).reshape(2, -1)
    again, along = ids.cast(down, u, v)
    assert (again == labels.ravel()).all()
    np.testing.assert_allclose(along, t.ravel(), rtol=1e-4)


def test_points_outdoors_in_doorways_and_under_the_floor_are_told_apart(ids) -> None:
    portal = next(p for p in ids.graph.portals if OUTSIDE not in p.cells)
    steps = np.array([[0.02], [-0.02]]) * portal.normal
    assert ids.cells_at(portal.center + steps).tolist() == list(portal.cells)
    far = ids.caster.mesh.bounds[1] + 50.0
    room = ids.graph.cells[0]
    under = np.array([*(room.low + room.high)[:2] / 2.0, room.floor - 0.05])
    assert ids.cells_at(np.array([far, under])).tolist() == [OUTSIDE, NOWHERE]


def test_a_view_comes_from_its_number_alone(flat) -> None:
    graph = flat[1]
    first, again = (visibility.random_view(graph, 3, 17, SIZE) for _ in range(2))
    np.testing.assert_array_equal(first.camera.center, again.camera.center)
    np.testing.assert_array_equal(first.camera.matrix, again.camera.matrix)
    other = visibility.random_view(graph, 4, 17, SIZE)
    assert not np.array_equal(first.camera.center, other.camera.center)


def test_the_command_tells_its_figures(flat, monkeypatch, capsys) -> None:
    monkeypatch.setattr(visibility, "opened", lambda model: flat)
    line = ["visibility", "built-in:flat", "--views", "20", "--size", "40x32"]
    monkeypatch.setattr(sys, "argv", line)
    assert visibility.main() == 0
    assert "20 views, 0 missed, 0 leak" in capsys.readouterr().out
    monkeypatch.setattr(sys, "argv", [*line, "--json"])
    assert visibility.main() == 0
    told = json.loads(capsys.readouterr().out)["built-in:flat"]
    assert told["views"] == 20
    assert told["missed"] == 0
