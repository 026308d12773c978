"""glTF read: transforms, colors, textures, what is left out, what is refused."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from belvedere.ground.color import srgb_to_linear
from belvedere.ground.errors import FileFormatError, MissingFileError, SceneError, UnsafePathError
from belvedere.model import ImportedModel, read_model
from tests.model.gltf_files import TRIANGLE, Gltf

UP = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
"""World from glTF: its +y is our +z."""
PIXELS = np.arange(24, dtype=np.uint8).reshape(2, 4, 3) * 10


def corners(model: ImportedModel) -> np.ndarray:
    return model.mesh.vertices[model.mesh.faces]


def said(model: ImportedModel, words: str) -> bool:
    return any(words in line for line in model.dropped)


def test_y_up_becomes_z_up(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 3, 5]], np.float32))
    model = read_model(gltf.glb(tmp_path / "a.glb"))
    np.testing.assert_array_equal(corners(model)[0], [[0, 0, 0], [1, 0, 0], [0, -5, 3]])
    assert (model.source.up, model.source.metres_per_unit, model.source.guessed) == ("y", 1.0, ())
    assert model.names == ("thing",)
    np.testing.assert_array_equal(model.object_of_face, [0])


def test_transforms_of_all_nodes_above_are_applied(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.mesh()
    half = math.sqrt(0.5)
    gltf.json["nodes"] = [
        {"children": [1], "translation": [10, 0, 0], "rotation": [0, 0, half, half]},
        {"children": [2], "matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 7, 1]},
        {"mesh": 0, "scale": [1, 3, 1]},
    ]
    found = corners(read_model(gltf.glb(tmp_path / "a.glb")))[0]
    quarter = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    inner = TRIANGLE * np.array([2, 6, 2]) + np.array([0, 0, 7])
    expected = inner @ quarter.T + np.array([10, 0, 0])
    np.testing.assert_allclose(found, expected @ UP.T, atol=1e-12)


@pytest.mark.parametrize("scale", [[-1, 1, 1], [1, -1, -1], [-1, -1, -1], [1, 1, 1]])
def test_a_mirror_keeps_the_fronts_of_faces(tmp_path: Path, scale: list[int]) -> None:
    gltf = Gltf()
    gltf.mesh(TEXCOORD_0=np.array([[0, 0], [1, 0], [0, 1]], np.float32))
    gltf.json["nodes"][0]["scale"] = scale
    model = read_model(gltf.glb(tmp_path / "a.glb"))
    front = np.array([0, 0, 1]) * scale  # a mirrored thing shows its front, mirrored
    np.testing.assert_allclose(model.mesh.normals()[0], UP @ front, atol=1e-12)
    for point, uv in zip(corners(model)[0], model.mesh.uv[0], strict=True):
        np.testing.assert_allclose(UP.T @ point, np.array([2 * uv[0], uv[1], 0]) * scale)


def test_a_mesh_that_several_nodes_show_is_there_several_times(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.mesh()
    gltf.json["nodes"] = [{"mesh": 0, "name": "a"}, {"mesh": 0, "translation": [0, 0, 4]}]
    gltf.json["scenes"] = [{"nodes": [0, 1]}]
    model = read_model(gltf.glb(tmp_path / "a.glb"))
    assert model.names == ("a", "node 1")
    np.testing.assert_array_equal(model.object_of_face, [0, 1])
    np.testing.assert_array_equal(np.unique(corners(model)[..., 1]), [-4, 0])


def test_instances_of_the_instancing_extension_are_drawn(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.mesh()
    places = np.array([[0, 0, 0], [0, 0, 3], [0, 0, 8]], np.float32)
    gltf.json["nodes"][0]["extensions"] = {
        "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": gltf.add(places)}}
    }
    model = read_model(gltf.glb(tmp_path / "a.glb"))
    np.testing.assert_array_equal(np.unique(corners(model)[..., 1]), [-8, -3, 0])


def test_strips_and_fans_are_cut_with_the_same_fronts(tmp_path: Path) -> None:
    quad = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    for mode, order in ((5, [0, 1, 3, 2]), (6, [0, 1, 2, 3])):
        gltf = Gltf()
        primitive = gltf.mesh(quad, mode=mode)
        primitive["indices"] = gltf.add(np.array(order, np.uint16))
        model = read_model(gltf.glb(tmp_path / f"{mode}.glb"))
        assert len(model.mesh.faces) == 2
        np.testing.assert_allclose(model.mesh.normals(), [[0, -1, 0]] * 2, atol=1e-12)


def test_quantised_and_sparse_arrays_are_read(tmp_path: Path) -> None:
    gltf = Gltf()
    points = np.array([[0, 0, 0, 9], [100, 0, 0, 9], [0, 50, 0, 9], [0, 0, 0, 9]], np.int16)
    primitive = gltf.mesh(np.zeros((1, 3), np.float32))
    view = gltf.view(points.tobytes(), byteStride=8)
    replaced = {"bufferView": gltf.view(np.array([[0, 0, 25]], np.int16).tobytes())}
    places = {"bufferView": gltf.view(np.array([3], np.uint8).tobytes()), "componentType": 5121}
    gltf.json["accessors"].append(
        {"bufferView": view, "componentType": 5122, "count": 4, "type": "VEC3",
         "sparse": {"count": 1, "indices": places, "values": replaced}}
    )  # fmt: skip
    primitive["attributes"]["POSITION"] = len(gltf.json["accessors"]) - 1
    primitive["attributes"]["COLOR_0"] = gltf.add(
        np.array([[255, 0, 51, 255]] * 4, np.uint8), normalized=True
    )
    primitive["indices"] = gltf.add(np.array([0, 1, 2, 0, 3, 1], np.uint8))
    gltf.json["extensionsRequired"] = ["KHR_mesh_quantization"]
    model = read_model(gltf.glb(tmp_path / "a.glb"))
    np.testing.assert_array_equal(corners(model)[1], [[0, 0, 0], [0, -25, 0], [100, 0, 0]])
    assert model.mesh.colors is not None
    np.testing.assert_allclose(model.mesh.colors[0, 0], [1, 0, 0.2], atol=1e-6)  # linear as stored


def test_factors_are_linear_and_emission_has_its_strength_and_mean(tmp_path: Path) -> None:
    gltf = Gltf()
    half = np.zeros((2, 2, 3), np.uint8)
    half[0] = 255  # half of it white
    material = gltf.material(
        name="lamp",
        pbrMetallicRoughness={"baseColorFactor": [0.2, 0.4, 0.6, 1.0]},
        emissiveFactor=[1.0, 0.5, 0.0],
        emissiveTexture={"index": gltf.picture(half)},
        extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 8.0}},
    )
    gltf.mesh(material=material)
    model = read_model(gltf.glb(tmp_path / "a.glb"))
    lamp = model.mesh.materials[0]
    assert lamp.base_color == (0.2, 0.4, 0.6)
    np.testing.assert_allclose(lamp.emission, [4.0, 2.0, 0.0], rtol=1e-6)
    assert said(model, "emissive textures: their mean")


def test_the_first_row_of_a_texture_lies_at_v_0(tmp_path: Path) -> None:
    gltf = Gltf()
    texture = {"index": gltf.picture(PIXELS)}
    uv = np.array([[0, 0], [1, 0], [0, 1]], np.float32)
    gltf.mesh(TEXCOORD_0=uv, material=gltf.material(
        pbrMetallicRoughness={"baseColorTexture": texture}))  # fmt: skip
    mesh = read_model(gltf.glb(tmp_path / "a.glb")).mesh
    np.testing.assert_array_equal(mesh.materials[0].texture, PIXELS)
    np.testing.assert_array_equal(mesh.uv[0], uv)


def test_texture_transforms_move_the_coordinates(tmp_path: Path) -> None:
    gltf = Gltf()
    transform = {"offset": [0.5, 0.25], "scale": [2, 3], "rotation": math.pi / 2, "texCoord": 1}
    texture = {
        "index": gltf.picture(PIXELS),
        "extensions": {"KHR_texture_transform": transform},
    }
    uv = np.array([[0, 0], [1, 0], [0, 1]], np.float32)
    gltf.mesh(TEXCOORD_0=uv + 9, TEXCOORD_1=uv, material=gltf.material(
        pbrMetallicRoughness={"baseColorTexture": texture}))  # fmt: skip
    mesh = read_model(gltf.glb(tmp_path / "a.glb")).mesh
    # counter-clockwise for one who sees v run down: u turns to -v
    np.testing.assert_allclose(mesh.uv[0], [[0.5, 0.25], [0.5, -1.75], [3.5, 0.25]], atol=1e-6)


@pytest.mark.parametrize(
    ("look", "left"),
    [
        ({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.3]}}, 1),
        ({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.8]}}, 2),
        ({"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.3]}}, 2),
        ({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.9}}}, 1),
    ],
)
def test_glass_is_left_out(tmp_path: Path, look: dict[str, Any], left: int) -> None:
    gltf = Gltf()
    gltf.mesh(material=gltf.material(name="pane", **look))
    gltf.json["meshes"][0]["primitives"].append(
        {"attributes": {"POSITION": gltf.add(TRIANGLE + np.float32(1))}}
    )
    model = read_model(gltf.glb(tmp_path / "a.glb"))
    assert len(model.mesh.faces) == left
    assert said(model, "material 'pane': lets light through, its 1 faces left out") == (left == 1)


def test_the_report_names_what_is_lost(tmp_path: Path) -> None:
    gltf = Gltf()
    first = gltf.mesh(NORMAL=np.zeros((3, 3), np.float32))
    first["targets"] = [{"POSITION": first["attributes"]["POSITION"]}]
    for mode in (0, 1):
        gltf.json["meshes"][0]["primitives"].append({**first, "mode": mode})
    picture = {"index": gltf.picture(PIXELS)}
    first["material"] = gltf.material(
        name="m", normalTexture=picture, occlusionTexture=picture,
        pbrMetallicRoughness={"metallicRoughnessTexture": picture},
    )  # fmt: skip
    gltf.json["nodes"][0] |= {"skin": 0, "camera": 0}
    gltf.json["animations"] = [{}]
    model = read_model(gltf.glb(tmp_path / "a.glb"))
    for words in ("morph targets", "lines: left out", "points: left out", "normal maps", "skins",
                  "occlusion maps", "metal and roughness maps", "vertex normals", "cameras",
                  "animations"):  # fmt: skip
        assert said(model, words), words


def test_a_missing_texture_leaves_its_base_color(tmp_path: Path) -> None:
    for uri, words in (("none.png", "no such file"), ("../up.png", "outside the model's folder")):
        gltf = Gltf()
        gltf.json["images"] = [{"uri": uri}]
        gltf.json["textures"] = [{"source": 0}]
        look = {"baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 0.5, 0.5, 1]}
        gltf.mesh(material=gltf.material(pbrMetallicRoughness=look))
        model = read_model(gltf.glb(tmp_path / "a.glb"))
        assert model.mesh.materials[0].texture is None
        assert model.mesh.materials[0].base_color == (0.5, 0.5, 0.5)
        assert said(model, words)


def test_buffers_are_found_beside_the_file_and_nowhere_else(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.mesh()
    (tmp_path / "a b.bin").write_bytes(gltf.blob)
    assert len(read_model(gltf.gltf(tmp_path / "a.gltf", "a%20b.bin")).mesh.faces) == 1
    (tmp_path / "in").mkdir()
    for uri in ("../a b.bin", "/etc/hostname", "..%2Fa%20b.bin", "https://example.org/a.bin"):
        with pytest.raises(UnsafePathError, match=r"buffers\[0\]\.uri"):
            read_model(gltf.gltf(tmp_path / "in" / "a.gltf", uri))
    with pytest.raises(MissingFileError, match=r"buffers\[0\]\.uri: no file 'gone\.bin'"):
        read_model(gltf.gltf(tmp_path / "in" / "a.gltf", "gone.bin"))


@pytest.mark.parametrize("extension", ["KHR_draco_mesh_compression", "EXT_meshopt_compression"])
def test_compression_is_refused_by_its_name(tmp_path: Path, extension: str) -> None:
    gltf = Gltf()
    gltf.mesh()
    gltf.json["extensionsRequired"] = [extension]
    with pytest.raises(FileFormatError, match=f"{extension}.*export it without compression"):
        read_model(gltf.glb(tmp_path / "a.glb"))


def test_every_truncation_is_refused(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.mesh(material=gltf.material())
    data = gltf.glb(tmp_path / "a.glb").read_bytes()
    for size in range(1, len(data), 7):
        (tmp_path / "a.glb").write_bytes(data[:size])
        with pytest.raises(FileFormatError):
            read_model(tmp_path / "a.glb")


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda j: j["nodes"][0].update(mesh=7), r"nodes\[0\]\.mesh is 7, but there are 1 meshes"),
        (lambda j: j["nodes"][0].update(children=[0]), r"nodes\[0\] hangs in the scene twice"),
        (lambda j: j["accessors"][0].update(count=99), r"accessors\[0\] needs 1188 bytes, but"),
        (lambda j: j["accessors"][0].update(type="VEC9"), r"accessors\[0\] holds 'VEC9' of 5126"),
        (lambda j: j["accessors"].insert(0, {**j["accessors"].pop(0), "bufferView": 9}),
         r"accessors\[0\].bufferView is 9, but there are 1 bufferViews"),
        (lambda j: j["asset"].update(version="1.0"), r"is glTF 1\.0, only 2\.x is read"),
        (lambda j: j.update(extensionsRequired=["X_new"]), r"requires the extension 'X_new'"),
        (lambda j: j["nodes"][0].update(matrix=[1, 2]), r"holds values that glTF does not allow"),
        (lambda j: j["meshes"][0]["primitives"][0].update(mode=9), r"mode is 9, expected 0 to 6"),
        (lambda j: j["meshes"][0].update(primitives=[]), r"has no triangles to show"),
        (lambda j: j.pop("asset"), r"is JSON but not glTF"),
    ],
)  # fmt: skip
def test_broken_files_say_what_is_broken(tmp_path: Path, spoil: Any, message: str) -> None:
    gltf = Gltf()
    gltf.mesh()
    spoil(gltf.json)
    with pytest.raises(FileFormatError, match=message):
        read_model(gltf.glb(tmp_path / "a.glb"))


def test_an_index_past_the_vertices_is_refused(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.mesh()["indices"] = gltf.add(np.array([0, 1, 3], np.uint16))
    with pytest.raises(FileFormatError, match=r"indices name vertex 3, but there are 3"):
        read_model(gltf.glb(tmp_path / "a.glb"))


def test_a_building_in_the_extras_is_found_and_checked(tmp_path: Path) -> None:
    room = {"name": "r", "rings": [[[0, 0], [1, 0], [0, 1]]], "floor": 0, "ceiling": 2.5}
    gltf = Gltf()
    gltf.mesh()
    gltf.json["scenes"][0]["extras"] = {"belvedere_building": {"rooms": [room]}}
    building = read_model(gltf.glb(tmp_path / "a.glb")).building
    assert building is not None
    assert building.rooms[0].ceiling == 2.5
    room["floor"] = "low"
    with pytest.raises(SceneError, match=r"extras\.belvedere_building\.rooms\[0\]\.floor is 'low'"):
        read_model(gltf.glb(tmp_path / "a.glb"))


def test_trimesh_reads_the_same_triangles(tmp_path: Path, rng: np.random.Generator) -> None:
    trimesh = pytest.importorskip("trimesh")
    gltf = Gltf()
    nodes: list[dict[str, Any]] = [{"children": [1, 2, 3]}]
    gltf.json["nodes"] = nodes
    for k in range(3):
        points = rng.normal(size=(30, 3)).astype(np.float32)
        gltf.mesh(points)["indices"] = gltf.add(rng.permutation(30).astype(np.uint32))
        turn = rng.normal(size=4)
        nodes.append(
            {"mesh": k, "rotation": (turn / np.linalg.norm(turn)).tolist(),
             "translation": rng.normal(size=3).tolist(), "scale": [1, 2, 0.5]}
        )  # fmt: skip
    ours = corners(read_model(gltf.glb(tmp_path / "a.glb"))) @ UP  # back to y up
    scene = trimesh.load(tmp_path / "a.glb", process=False)
    theirs = np.concatenate([m.triangles for m in scene.dump()])
    order = [np.lexsort(np.rint(t.reshape(-1, 9) * 1e4).T) for t in (ours, theirs)]
    np.testing.assert_allclose(ours[order[0]], theirs[order[1]], atol=1e-6)


def test_specular_glossiness_gives_its_diffuse_color(tmp_path: Path) -> None:
    gltf = Gltf()
    look = {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0.1, 0.2, 0.3, 1]}}
    gltf.mesh(material=gltf.material(extensions=look))
    assert read_model(gltf.glb(tmp_path / "a.glb")).mesh.materials[0].base_color == (0.1, 0.2, 0.3)


def test_json_that_is_no_model_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.gltf").write_text(json.dumps({"frames": []}))
    with pytest.raises(FileFormatError, match="is JSON but not glTF"):
        read_model(tmp_path / "a.gltf")
    (tmp_path / "a.glb").write_text("hello, this is a letter to my aunt")
    with pytest.raises(FileFormatError, match="is not glTF"):
        read_model(tmp_path / "a.glb")


def test_colors_of_pictures_are_not_multiplied_by_alpha(tmp_path: Path) -> None:
    gltf = Gltf()
    pixels = np.full((2, 2, 4), 200, np.uint8)
    look = {"baseColorTexture": {"index": gltf.picture(pixels)}}
    gltf.mesh(material=gltf.material(pbrMetallicRoughness=look))
    model = read_model(gltf.glb(tmp_path / "a.glb"))
    np.testing.assert_array_equal(model.mesh.materials[0].texture, pixels[..., :3])
    assert srgb_to_linear(np.float32(200 / 255)) > 0.5


def test_a_view_past_its_buffer_is_refused(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.mesh()
    gltf.json["bufferViews"][0]["byteLength"] = 999
    with pytest.raises(FileFormatError, match=r"bufferViews\[0\] ends at byte 999, but its buffer"):
        read_model(gltf.glb(tmp_path / "a.glb"))


def test_a_claim_without_data_is_not_believed(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.mesh()
    gltf.json["accessors"][0] = {"componentType": 5126, "count": 1 << 40, "type": "VEC3"}
    with pytest.raises(FileFormatError, match="claims 1099511627776 elements without data"):
        read_model(gltf.glb(tmp_path / "a.glb"))
