"""Which polygons belong to which cell."""

from __future__ import annotations

import numpy as np
import pytest

from belvedere.ground.errors import InputError
from belvedere.scene.mesh import Material, Mesh
from belvedere.walkthrough import OUTSIDE, Cell, CellGraph, contents_of
from tests.walkthrough.graphs import ring, three_rooms


def small_triangles(rng: np.random.Generator, count: int, size: float) -> Mesh:
    middle = rng.uniform((-2, -2, -1), (11, 10, 6), (count, 1, 3))
    corners = middle + rng.uniform(-size, size, (count, 3, 3))
    faces = np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
    return Mesh(corners.reshape(-1, 3), faces, np.zeros(count, np.int32),
                np.zeros((count, 3, 2), np.float32), (Material("m"),))  # fmt: skip


def points_on(mesh: Mesh, face: int, rng: np.random.Generator) -> np.ndarray:
    weights = rng.dirichlet(np.ones(3), 40)
    return weights @ mesh.vertices[mesh.faces[face]]


L_SHAPE = np.array([[0, 0], [6, 0], [6, 2], [2, 2], [2, 6], [0, 6]], dtype=np.float64)
TURNED = np.array([[4.0, 4.0], [8.0, 6.0], [7.0, 8.0], [3.0, 6.0]])


@pytest.mark.parametrize("outline", [ring(0, 0, 5, 4)[0], L_SHAPE, TURNED])
def test_a_face_with_a_point_in_a_cell_belongs_to_it(outline, rng) -> None:
    graph = CellGraph((Cell("room", (outline,), 0.0, 3.0),), ())
    mesh = small_triangles(rng, 300, 1.5)
    held = set(contents_of(mesh, graph, margin=0.0).faces(0).tolist())
    outside = set(contents_of(mesh, graph).faces(OUTSIDE).tolist())
    inside_count = 0
    for face in range(len(mesh.faces)):
        inside = graph.cells[0].contains(points_on(mesh, face, rng))
        inside_count += bool(inside.any())
        assert face in held or not inside.any()
        assert face in outside or inside.all()
    assert inside_count > 10
    assert len(held) < 0.6 * len(mesh.faces)  # and most of what is elsewhere does not


def test_what_comes_within_the_margin_belongs_too(rng) -> None:
    graph = CellGraph((Cell("room", (L_SHAPE,), 0.0, 3.0),), ())
    mesh = small_triangles(rng, 400, 0.05)
    held = set(contents_of(mesh, graph, margin=0.4).faces(0).tolist())
    for face in range(len(mesh.faces)):
        x, y, z = mesh.vertices[mesh.faces[face]].mean(axis=0)
        around = np.array([[x + 0.3 * np.cos(a), y + 0.3 * np.sin(a), z] for a in range(7)])
        if graph.cells[0].contains(around).any():
            assert face in held
        far = np.array([[x + 0.8 * np.cos(a), y + 0.8 * np.sin(a), z] for a in range(7)])
        near = graph.cells[0].contains(np.vstack([far, around, [[x, y, z]]]))
        if not near.any() and not (-0.5 < z < 3.5):
            assert face not in held


def test_a_box_gives_the_same_as_any_outline(rng) -> None:
    mesh = small_triangles(rng, 500, 0.6)
    box = three_rooms().cells[0]
    slanted = Cell("same", (np.vstack([box.rings[0], [[0.0, 2.0]]]),), box.floor, box.ceiling)
    for margin in (0.0, 0.3):
        exact, looked_up = (
            set(contents_of(mesh, CellGraph((cell,), ()), margin).faces(0).tolist())
            for cell in (box, slanted)
        )
        # beyond the corners a square margin reaches farther than a round one
        assert len(exact - looked_up) <= (2 if margin else 0)
        assert len(looked_up) <= 1.15 * len(exact)


def test_a_margin_must_be_a_number(rng) -> None:
    with pytest.raises(InputError, match="margin"):
        contents_of(small_triangles(rng, 3, 1.0), three_rooms(), margin=-1.0)
