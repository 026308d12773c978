"""OBJ and PLY read: indices, polygons, materials, colors, what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from belvedere.ground.color import srgb_to_linear
from belvedere.ground.errors import FileFormatError
from belvedere.model import ImportedModel, read_model

SQUARE = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\n"
PIXELS = np.arange(24, dtype=np.uint8).reshape(2, 4, 3) * 10


def obj(folder: Path, text: str, **files: str) -> ImportedModel:
    for name, content in files.items():
        (folder / f"{name}.mtl").write_text(content)
    (folder / "model.obj").write_text(text)
    return read_model(folder / "model.obj", units="m", up="z")


def corners(model: ImportedModel) -> np.ndarray:
    return model.mesh.vertices[model.mesh.faces]


def said(model: ImportedModel, words: str) -> bool:
    return any(words in line for line in model.dropped)


@pytest.mark.parametrize("text", ["f 1 2 3", "f 1// 2// 3//", "f -4 -3 -2", "f 1//9 2//9 3//9",
                                  "f 1 \\\n 2 3", "f\t1 2 3 # a comment"])  # fmt: skip
def test_every_way_to_write_an_index(tmp_path: Path, text: str) -> None:
    model = obj(tmp_path, SQUARE + text)
    np.testing.assert_array_equal(corners(model), [[[0, 0, 0], [2, 0, 0], [2, 1, 0]]])


def test_negative_indices_count_from_the_line_they_stand_in(tmp_path: Path) -> None:
    model = obj(tmp_path, SQUARE + "f -4 -3 -2\nv 0 0 7\nv 1 0 7\nv 0 1 7\nf -3 -2 -1")
    assert set(corners(model)[0, :, 2]) == {0}
    assert set(corners(model)[1, :, 2]) == {7}


def test_triangles_quads_and_larger_polygons_may_be_mixed(tmp_path: Path) -> None:
    more = "v 0 0 1\nv 2 0 1\nv 3 0.5 1\nv 2 1 1\nv 0 1 1\nv 0 0 2\nv 2 0 2\nv 0 1 2\n"
    model = obj(tmp_path, SQUARE + more + "f 10 11 12\nf 1 2 3 4\nf 5 6 7 8 9\n")
    edges = np.diff(corners(model), axis=1)
    normal = np.cross(edges[:, 0], edges[:, 1])
    assert (normal[:, 2] > 0).all()
    area = [normal[corners(model)[:, 0, 2] == z, 2].sum() / 2 for z in (2, 0, 1)]
    np.testing.assert_allclose(area, [1.0, 2.0, 2.5])


def test_a_hollow_polygon_is_cut_without_folds(tmp_path: Path) -> None:
    # an L: a fan from its first corner would leave the shape
    points = [(3, 1), (1, 1), (1, 3), (0, 3), (0, 0), (3, 0)]
    text = "".join(f"v {x} 0 {y}\n" for x, y in points) + "f 1 2 3 4 5 6"
    model = obj(tmp_path, text)
    edges = np.diff(corners(model), axis=1)
    normal = np.cross(edges[:, 0], edges[:, 1])
    assert np.linalg.norm(normal, axis=1).sum() / 2 == pytest.approx(5.0)
    assert (normal[:, 1] < 0).all()  # counter-clockwise in x and z looks along -y


def test_v_runs_up_in_the_file_and_down_the_picture(tmp_path: Path) -> None:
    Image.fromarray(PIXELS).save(tmp_path / "wood.png")
    model = obj(
        tmp_path,
        "mtllib a.mtl\n" + SQUARE + "vt 0 0\nvt 1 0\nvt 1 1\nusemtl wood\nf 1/1 2/2 3/3",
        a="newmtl wood\nKd 0.5 0.5 0.5\nKe 2 1 0\nmap_Kd wood.png\n",
    )
    (wood,) = model.mesh.materials
    np.testing.assert_array_equal(wood.texture, PIXELS)
    np.testing.assert_array_equal(model.mesh.uv[0], [[0, 1], [1, 1], [1, 0]])
    assert wood.base_color == pytest.approx([float(srgb_to_linear(np.float64(0.5)))] * 3)
    assert wood.emission == (2.0, 1.0, 0.0)


def test_programs_that_write_linear_colors_are_known(tmp_path: Path) -> None:
    text = "mtllib a.mtl\n" + SQUARE + "usemtl w\nf 1 2 3"
    for comment, expected in (
        ("# Blender 4.2.0 MTL File: 'flat.blend'\n", 0.5),
        ("# exported from a CAD program\n", float(srgb_to_linear(np.float64(0.5)))),
    ):
        model = obj(tmp_path, text, a=comment + "newmtl w\nKd 0.5 0.5 0.5\n")
        assert model.mesh.materials[0].base_color == pytest.approx([expected] * 3)


def test_objects_have_their_names(tmp_path: Path) -> None:
    model = obj(tmp_path, SQUARE + "f 1 2 3\no east wall\nf 1 3 4\ng door\nf 3 2 1\n")
    assert model.names == ("model", "east wall", "door")
    np.testing.assert_array_equal(model.object_of_face, [0, 1, 2])


def test_colors_behind_positions_are_decoded(tmp_path: Path) -> None:
    text = "v 0 0 0 1 0.5 0\nv 1 0 0 1 1 1\nv 0 1 0 0 0 0\nf 1 2 3"
    mesh = obj(tmp_path, text).mesh
    assert mesh.colors is not None
    half = float(srgb_to_linear(np.float64(0.5)))
    np.testing.assert_allclose(mesh.colors[0], [[1, half, 0], [1, 1, 1], [0, 0, 0]], atol=1e-6)


def test_glass_is_left_out_and_missing_files_are_said(tmp_path: Path) -> None:
    model = obj(
        tmp_path,
        "mtllib a.mtl gone.mtl\n" + SQUARE + "usemtl glass\nf 1 2 3\nusemtl wall\nf 1 3 4\n"
        "usemtl nowhere\nf 3 2 1\n",
        a="newmtl glass\nd 0.2\nnewmtl wall\nKd 0.1 0.2 0.3\nmap_Kd -s 2 2 2 C:\\t\\no.png\n"
        "bump b.png\n",
    )
    assert [m.name for m in model.mesh.materials] == ["wall", "nowhere"]
    for words in ("'glass': lets light through, its 1 faces", "'gone.mtl': not in the model's",
                  "no.png': not in the model's folder", "texture option -s", "bump textures",
                  "a material that no material file describes"):  # fmt: skip
        assert said(model, words), words


def test_a_texture_named_by_a_path_from_elsewhere_is_found_beside_the_model(tmp_path: Path) -> None:
    Image.fromarray(PIXELS).save(tmp_path / "wood.png")
    text = "mtllib a.mtl\n" + SQUARE + "usemtl w\nf 1 2 3"
    model = obj(tmp_path, text, a="newmtl w\nmap_Kd C:\\work\\wood.png\n")
    assert model.mesh.materials[0].texture is not None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Dear aunt,\nthank you for the cake.\n", "is not an OBJ model"),
        (
            SQUARE + "f 1 2 5\n",
            r"face 1 \(1 2 5\) names a vertex that is not there: the file has 4",
        ),
        (SQUARE + "f 1 2 0\n", r"names a vertex that is not there"),
        (SQUARE + "f 1 2 -9\n", r"names a vertex that is not there"),
        (SQUARE + "vt 0 0\nf 1/1 2/1 3/2\n", r"names a texture coordinate that is not there"),
        (SQUARE + "f 1 2 x\n", r"a face has an index that is no number"),
        ("v 0 0\nv 1 1\nv 2 2\nf 1 2 3\n", r"vertices have 2 numbers, expected 3"),
        ("v 0 0 0\nv 1 one 0\nf 1 2 1\n", r"the v line number 2 is '1 one 0', expected numbers"),
        (SQUARE, r"has no triangles to show"),
        (SQUARE + "f 1 2\nf 1\n", r"has no triangles to show"),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(FileFormatError, match=message):
        obj(tmp_path, text)


PLY = """ply
format ascii 1.0
comment TextureFile wood.png
element vertex 4
property float x
property float y
property float z
{more}element face {faces}
property list uchar int vertex_indices
end_header
"""
COLORS = "property uchar red\nproperty uchar green\nproperty uchar blue\n"


def test_ply_has_polygons_and_colors(tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    path = tmp_path / "a.ply"
    head = PLY.format(more=COLORS, faces=1).replace("comment TextureFile wood.png\n", "")
    path.write_text(head + "0 0 0 255 0 0\n2 0 0 0 255 0\n2 1 0 0 0 128\n0 1 0 9 9 9\n4 0 1 2 3\n")
    model = read_model(path, units="m", up="z")
    np.testing.assert_allclose(model.mesh.normals(), [[0, 0, 1]] * 2)
    assert model.mesh.colors is not None
    blue = float(srgb_to_linear(np.float64(128 / 255)))
    np.testing.assert_allclose(
        model.mesh.colors[0], [[1, 0, 0], [0, 1, 0], [0, 0, blue]], atol=1e-6
    )
    assert [m.name for m in model.mesh.materials] == ["no material"]


def test_a_ply_with_a_texture_shows_it_the_right_way_up(tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    Image.fromarray(PIXELS).save(tmp_path / "wood.png")
    path = tmp_path / "a.ply"
    head = PLY.format(more="property float s\nproperty float t\n", faces=1)
    path.write_text(head + "0 0 0 0 0\n2 0 0 1 0\n2 1 0 1 1\n0 1 0 0 1\n3 0 1 2\n")
    mesh = read_model(path, units="m", up="z").mesh
    np.testing.assert_array_equal(mesh.materials[0].texture, PIXELS)
    np.testing.assert_allclose(mesh.uv[0], [[0, 1], [1, 1], [1, 0]])


def test_a_truncated_ply_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    path = tmp_path / "a.ply"
    points = "0 0 0\n2 0 0\n2 1 0\n"
    for text, message in (
        ("ply\nformat ascii 1.0\n", "its PLY header has no end"),
        (PLY.format(more="", faces=1) + points, r"has 3 lines of data, but its header says 5"),
        ("hello", "is not a PLY model"),
        (
            PLY.format(more="", faces=1).replace("ascii", "binary_little_endian"),
            "truncated or brok",
        ),
        (PLY.format(more="", faces=1) + points + "0 1 0\n3 0 1 9\n", "names vertex 9, but there"),
    ):
        path.write_text(text)
        with pytest.raises(FileFormatError, match=message):
            read_model(path)


def test_a_cloud_of_points_is_no_model(tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    path = tmp_path / "a.ply"
    path.write_text(PLY.format(more="", faces=0) + "0 0 0\n2 0 0\n2 1 0\n0 1 0\n")
    with pytest.raises(FileFormatError, match=r"no triangles to show \(4 points without faces"):
        read_model(path)
