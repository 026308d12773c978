"""The Mesh noun: what it keeps and what it refuses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.ground.errors import SceneError
from belvedere.scene.mesh import Material, Mesh


def triangle(shift: float = 0.0, **changes: Any) -> Mesh:
    parts: dict[str, Any] = {
        "vertices": np.array([[0, 0, shift], [1, 0, shift], [0, 1, shift]]),
        "faces": np.array([[0, 1, 2]]),
        "material_index": np.zeros(1),
        "uv": np.zeros((1, 3, 2)),
        "materials": (Material("white"),),
    }
    return Mesh(**{**parts, **changes})


def test_a_mesh_keeps_positions_in_double_precision() -> None:
    mesh = triangle(1.0 / 3.0)
    assert mesh.vertices[0, 2] == 1.0 / 3.0
    assert mesh.faces.dtype == np.int32
    np.testing.assert_array_equal(mesh.normals(), [[0, 0, 1]])


def test_joined_meshes_keep_their_faces_and_share_materials() -> None:
    shared = Material("oak", (0.5, 0.3, 0.1))
    first = triangle(0.0, materials=(Material("a"), shared), material_index=np.array([1]))
    second = triangle(2.0, materials=(shared,))
    joined = Mesh.concatenate([first, second])
    assert [m.name for m in joined.materials] == ["a", "oak"]
    np.testing.assert_array_equal(joined.material_index, [1, 1])
    np.testing.assert_array_equal(joined.vertices[joined.faces[1]], second.vertices)


def test_colors_of_corners_survive_joining() -> None:
    red = np.broadcast_to(np.array([1, 0, 0], np.float32), (1, 3, 3))
    joined = Mesh.concatenate([triangle(), triangle(1.0, colors=red)])
    assert joined.colors is not None
    np.testing.assert_array_equal(joined.colors, [np.ones((3, 3)), red[0]])
    assert Mesh.concatenate([triangle(), triangle()]).colors is None


def test_nothing_joined_is_an_empty_mesh() -> None:
    empty = Mesh.concatenate([])
    assert len(empty.faces) == 0
    np.testing.assert_array_equal(empty.bounds, np.zeros((2, 3)))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"faces": np.array([[0, 1, 3]])}, r"Mesh\.faces\[0, 2\] is 3, but there are 3 vertices"),
        ({"material_index": np.array([2])}, r"Mesh\.material_index\[0\] is 2, but there are 1"),
        ({"uv": np.zeros((1, 2))}, r"Mesh\.uv has shape \(1, 2\), expected \(1, 3, 2\)"),
        ({"colors": np.zeros((1, 3))}, r"Mesh\.colors has shape \(1, 3\), expected \(1, 3, 3\)"),
        ({"colors": np.full((1, 3, 3), np.inf)}, r"Mesh\.colors\[0, 0, 0\] is not finite \(9 such"),
        ({"uv": np.full((1, 3, 2), np.nan)}, r"Mesh\.uv\[0, 0, 0\] is not finite \(6 such"),
    ],
)
def test_a_mesh_says_what_is_wrong_with_it(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        triangle(**changes)


def test_a_material_refuses_what_is_no_color() -> None:
    with pytest.raises(SceneError, match=r"Material 'x': base_color is \(1\.0, -1\.0, 0\.0\)"):
        Material("x", (1.0, -1.0, 0.0))
    with pytest.raises(SceneError, match=r"texture has shape \(4, 4\), expected \(H, W, 3\)"):
        Material("x", texture=np.zeros((4, 4), np.uint8))
    with pytest.raises(SceneError, match="texture is int16, expected uint8"):
        Material("x", texture=np.zeros((4, 4, 3), np.int16))  # type: ignore[arg-type]
