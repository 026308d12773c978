"""GLB written: it comes back as it was, and other tools open it."""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

from belvedere.ground.errors import InputError, OutputError
from belvedere.model import Building, Opening, Room, read_model, write_glb
from belvedere.scene.mesh import Material, Mesh
from tests.strategies import numbers


def document(path: Path) -> dict[str, Any]:
    data = path.read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + size])


@st.composite
def meshes(draw: st.DrawFn) -> Mesh:
    """Meshes whose faces have an area and differ, all materials used."""
    vertices = draw(st.integers(4, 20))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    points = rng.normal(size=(vertices, 3)) * draw(st.sampled_from([1e-2, 1.0, 30.0]))
    points += draw(st.sampled_from([0.0, 0.0, 1.7e6]))
    triples = np.array([(a, b, c) for a in range(4) for b in range(4, vertices) for c in range(a)
                        ] or [(0, 1, 2), (2, 1, 0)])  # fmt: skip
    faces = rng.permutation(triples)[: draw(st.integers(1, 30))]
    count = draw(st.integers(1, min(4, len(faces))))
    more = rng.integers(0, count, len(faces) - count)
    index = rng.permutation(np.concatenate([np.arange(count), more]))
    unit = st.tuples(numbers(0, 1), numbers(0, 1), numbers(0, 1))
    light = st.tuples(numbers(0, 50), numbers(0, 50), numbers(0, 50))
    texture = st.one_of(
        st.none(),
        arrays(np.uint8, st.tuples(st.integers(1, 5), st.integers(1, 5), st.just(3))),
    )
    materials = tuple(
        Material(draw(st.text(min_size=1)), draw(unit), draw(texture), draw(light))
        for _ in range(count)
    )
    uv = rng.normal(size=(len(faces), 3, 2)) * draw(st.sampled_from([0.0, 2.0]))
    colors = rng.uniform(size=(len(faces), 3, 3)) if draw(st.booleans()) else None
    return Mesh(points, faces, index, uv, materials, colors)  # type: ignore[arg-type]


@settings(max_examples=60)
@given(mesh=meshes())
def test_what_is_written_comes_back(tmp_path: Path, mesh: Mesh) -> None:
    assert write_glb(tmp_path / "a.glb", mesh, force=True) == ()
    model = read_model(tmp_path / "a.glb", keep_origin=True)
    again = model.mesh
    shown, expected = again.vertices[again.faces], mesh.vertices[mesh.faces]
    np.testing.assert_allclose(shown, expected, rtol=1e-6, atol=1e-6 * np.ptp(mesh.bounds))
    np.testing.assert_array_equal(again.material_index, mesh.material_index)
    np.testing.assert_array_equal(again.uv, mesh.uv)
    assert (again.colors is None) == (mesh.colors is None)
    if mesh.colors is not None:
        np.testing.assert_array_equal(again.colors, mesh.colors)
    for a, b in zip(again.materials, mesh.materials, strict=True):
        assert a.name == b.name
        np.testing.assert_allclose(a.base_color, b.base_color, rtol=1e-12)
        np.testing.assert_allclose(a.emission, b.emission, rtol=1e-12)
        assert (a.texture is None) == (b.texture is None)
        if b.texture is not None:
            np.testing.assert_array_equal(a.texture, b.texture)


def quad(**changes: Any) -> Mesh:
    """A wall 4 wide, 2 high, seen from -y; its texture stands upright on it."""
    points = np.array([[0, 0, 0], [4, 0, 0], [4, 0, 2], [0, 0, 2]])
    corner_uv = np.array([[0, 1], [1, 1], [1, 0], [0, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    pixels = np.zeros((8, 16, 3), np.uint8)
    pixels[:4, :, 0] = 255  # red above, black below
    parts: dict[str, Any] = {
        "vertices": points, "faces": faces, "material_index": np.zeros(2),
        "uv": corner_uv[faces], "materials": (Material("flag", texture=pixels),),
    }  # fmt: skip
    return Mesh(**{**parts, **changes})


def test_a_building_goes_along(tmp_path: Path) -> None:
    ring = np.array([[0.1, 0.0], [4.0, 0.0], [4.0, 1.0 / 3.0]])
    opening = Opening("W", "window", quad().vertices, ("hall", None))
    building = Building((Room("hall", (ring,), 0.0, 2.0, "ground"),), (opening,))
    write_glb(tmp_path / "a.glb", quad(), building)
    again = read_model(tmp_path / "a.glb").building
    assert again is not None
    assert again.as_dict() == building.as_dict()


def test_other_tools_see_the_texture_the_right_way_up(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    colors = np.linspace(0, 1, 18, dtype=np.float32).reshape(2, 3, 3)
    write_glb(tmp_path / "a.glb", quad(colors=colors))
    (other,) = trimesh.load(tmp_path / "a.glb", process=False).geometry.values()
    assert other.bounds.tolist() == [[0, 0, 0], [4, 2, 0]]  # y up
    np.testing.assert_allclose(other.face_normals, [[0, 0, 1]] * 2)
    image = np.asarray(other.visual.material.baseColorTexture.convert("RGB"))
    top = other.vertices[:, 1] == 2
    v = 1.0 - other.visual.uv[:, 1]  # trimesh turns glTF's v about
    np.testing.assert_array_equal(v[top], 0.0)
    assert image[0, 0, 0] == 255
    np.testing.assert_array_equal(image, quad().materials[0].texture)


def test_corners_are_shared_where_they_agree(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", quad())
    said = document(tmp_path / "a.glb")
    position = said["accessors"][said["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
    assert position["count"] == 4
    assert (position["min"], position["max"]) == ([0, 0, 0], [4, 2, 0])
    split = quad(colors=np.arange(18).reshape(2, 3, 3) / 18)
    write_glb(tmp_path / "b.glb", split)
    assert document(tmp_path / "b.glb")["accessors"][0]["count"] == 6


def test_a_shared_texture_is_written_once_and_may_be_jpeg(tmp_path: Path) -> None:
    pixels = np.full((32, 32, 3), 90, np.uint8)
    pair = (Material("a", texture=pixels), Material("b", (0.5, 0.5, 0.5), pixels))
    mesh = quad(materials=pair, material_index=np.array([0, 1]))
    write_glb(tmp_path / "a.glb", mesh, pictures="jpeg")
    said = document(tmp_path / "a.glb")
    assert len(said["images"]) == 1
    view = said["bufferViews"][said["images"][0]["bufferView"]]
    data = (tmp_path / "a.glb").read_bytes()
    start = 28 + struct.unpack_from("<I", data, 12)[0] + view["byteOffset"]
    with Image.open(io.BytesIO(data[start : start + view["byteLength"]])) as image:
        assert image.format == "JPEG"
    texture = read_model(tmp_path / "a.glb").mesh.materials[1].texture
    assert texture is not None
    np.testing.assert_allclose(texture, 90, atol=2)


def test_what_the_format_cannot_keep_is_said(tmp_path: Path) -> None:
    bright = Material("b", (2.0, 1.0, 1.0), np.full((2, 2, 3), 0.5, np.float32))
    lost = write_glb(tmp_path / "a.glb", quad(materials=(bright,)))
    assert lost == (
        "material 'b': base color above 1 written as 1",
        "material 'b': float texture written as 8 bits",
    )
    texture = read_model(tmp_path / "a.glb").mesh.materials[0].texture
    assert texture is not None
    assert np.unique(texture).tolist() == [188]  # 0.5 linear


def test_nothing_is_replaced_without_being_asked(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", quad())
    before = (tmp_path / "a.glb").read_bytes()
    with pytest.raises(OutputError, match="exists: pass --force"):
        write_glb(tmp_path / "a.glb", quad(materials=(Material("other"),)))
    assert (tmp_path / "a.glb").read_bytes() == before
    write_glb(tmp_path / "a.glb", quad(), force=True)
    assert (tmp_path / "a.glb").read_bytes() == before  # the same bytes each time
    assert [p.name for p in tmp_path.iterdir()] == ["a.glb"]


def test_what_cannot_be_written_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"'a\.obj', expected a name that ends in \.glb"):
        write_glb(tmp_path / "a.obj", quad())
    with pytest.raises(InputError, match="has no faces: there is nothing to write"):
        write_glb(tmp_path / "a.glb", Mesh.concatenate([]))
    with pytest.raises(InputError, match="pictures is 'bmp', expected one of"):
        write_glb(tmp_path / "a.glb", quad(), pictures="bmp")  # type: ignore[arg-type]
