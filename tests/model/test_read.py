"""Whatever the format: units, axes, huge coordinates, broken geometry, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from belvedere.ground.errors import (
    BelvedereError,
    FileFormatError,
    InputError,
    MissingFileError,
    SceneError,
)
from belvedere.model import MODEL_SUFFIXES, ImportedModel, read_model
from belvedere.model._plausible import UNITS
from belvedere.model._weld import first_equal
from tests.model.gltf_files import TRIANGLE, Gltf


def house(storeys: int = 2, size: tuple[float, float] = (9.0, 7.0)) -> tuple[Any, Any]:
    """Vertices and quads (1-based) of a house with rooms: z up, metres."""
    points: list[tuple[float, float, float]] = []
    quads: list[list[int]] = []

    def box(x0: float, y0: float, z0: float, x1: float, y1: float, z1: float) -> None:
        first = len(points) + 1
        points.extend(
            (x, y, z) for z in (z0, z1) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
        )
        for face in (
            (3, 2, 1, 0),
            (4, 5, 6, 7),
            (0, 1, 5, 4),
            (1, 2, 6, 5),
            (2, 3, 7, 6),
            (3, 0, 4, 7),
        ):
            quads.append([first + k for k in face])  # noqa: PERF401 - one more level would hide it

    x, y = size
    for storey in range(storeys + 1):
        box(0, 0, 2.8 * storey - 0.3, x, y, 2.8 * storey)
    for storey in range(storeys):
        z0, z1 = 2.8 * storey, 2.8 * storey + 2.5
        for wall in ((0, 0, x, 0.3), (0, y - 0.3, x, y), (0, 0, 0.3, y), (x - 0.3, 0, x, y),
                     (4, 0.3, 4.1, y - 0.3)):  # fmt: skip
            box(wall[0], wall[1], z0, wall[2], wall[3], z1)
        box(1, 1, z0, 2.5, 1.8, z0 + 0.75)  # a table
    return np.array(points), quads


def write_house(path: Path, per_metre: float, turn: bool) -> Path:
    points, quads = house()
    if turn:
        points = points[:, [0, 2, 1]] * [1, 1, -1]  # y up
    lines = [f"v {a:.9g} {b:.9g} {c:.9g}" for a, b, c in points * per_metre]
    path.write_text("\n".join([*lines, *("f " + " ".join(map(str, q)) for q in quads)]))
    return path


def said(model: ImportedModel, words: str) -> bool:
    return any(words in line for line in model.dropped)


@pytest.mark.parametrize("unit", list(UNITS))
@pytest.mark.parametrize("turn", [False, True])
def test_a_house_in_any_unit_and_axis_is_guessed(tmp_path: Path, unit: str, turn: bool) -> None:
    model = read_model(write_house(tmp_path / "house.obj", 1 / UNITS[unit], turn))
    np.testing.assert_allclose(model.mesh.bounds, [[0, 0, -0.3], [9, 7, 5.6]], atol=1e-6)
    assert model.source.metres_per_unit == UNITS[unit]
    assert model.source.up == ("y" if turn else "z")
    assert model.source.guessed == ("up", "units")
    assert said(model, "up axis: taken as")
    assert said(model, "units: taken as")


def test_what_is_said_is_not_guessed(tmp_path: Path) -> None:
    path = write_house(tmp_path / "house.obj", 1000.0, turn=False)
    for units, size in (("mm", 9.0), ("cm", 90.0), (0.002, 18.0)):
        model = read_model(path, units=units, up="z")
        assert np.ptp(model.mesh.bounds[:, 0]) == pytest.approx(size)
        assert model.source.guessed == ()
    turned = read_model(path, units="mm", up="x").mesh
    np.testing.assert_allclose(np.ptp(turned.bounds, axis=0), [7, 5.9, 9], atol=1e-6)
    with pytest.raises(InputError, match="units is 'yard', expected one of 'm', 'ft'"):
        read_model(path, units="yard")
    with pytest.raises(InputError, match="units is 0, expected a finite number above 0"):
        read_model(path, units=0.0)
    with pytest.raises(InputError, match="up is 'w', expected one of 'x', 'y', 'z'"):
        read_model(path, up="w")  # type: ignore[arg-type]


def test_turning_an_axis_up_never_mirrors(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4"
    )
    for up in ("x", "y", "z"):
        mesh = read_model(tmp_path / "a.obj", units="m", up=up).mesh
        a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
        assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(1.0)


def test_a_gltf_of_an_odd_size_is_doubted_but_believed(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.mesh(TRIANGLE * np.float32(9000))
    model = read_model(gltf.glb(tmp_path / "a.glb"))
    assert said(model, "size: the longest side is 1.8e+04 m, odd for a building")
    assert np.ptp(read_model(tmp_path / "a.glb", units="mm").mesh.bounds[:, 0]) == pytest.approx(18)


def test_huge_coordinates_are_recentred_and_said(tmp_path: Path) -> None:
    points, quads = house()
    points = points + np.array([1e8, -3e8, 50.0])
    lines = [f"v {a!r} {b!r} {c!r}" for a, b, c in points.tolist()]
    path = tmp_path / "far.obj"
    path.write_text("\n".join([*lines, *("f " + " ".join(map(str, q)) for q in quads)]))
    room = {"name": "r", "rings": [(points[:4, :2]).tolist()], "floor": 50.0, "ceiling": 52.5}
    (tmp_path / "far.building.json").write_text(json.dumps({"rooms": [room]}))
    model = read_model(path)
    assert np.abs(model.mesh.vertices).max() < 60.0
    np.testing.assert_array_equal(model.origin, np.rint(model.origin))
    assert np.abs(model.origin[:2]).min() > 9e7
    assert model.origin[2] == 0.0
    whole = np.sort(np.unique(model.mesh.vertices + model.origin, axis=0), axis=0)
    np.testing.assert_allclose(whole, np.sort(np.unique(points, axis=0), axis=0), atol=1e-7)
    assert model.building is not None
    np.testing.assert_allclose(
        model.building.rooms[0].rings[0] + model.origin[:2], points[:4, :2], atol=1e-7
    )
    assert said(model, "m subtracted")
    kept = read_model(path, keep_origin=True)
    assert not kept.origin.any()
    assert said(kept, "keep_origin=False would subtract")


def test_a_stray_vertex_does_not_move_the_origin(tmp_path: Path) -> None:
    points, quads = house()
    lines = [f"v {a} {b} {c}" for a, b, c in points] + ["v 1e7 0 0", "v 1e7 1 0", "v 1e7 0 1"]
    faces = ["f " + " ".join(map(str, q)) for q in quads] + ["f -1 -2 -3"]
    (tmp_path / "a.obj").write_text("\n".join([*lines, *faces]))
    model = read_model(tmp_path / "a.obj", units="m", up="z")
    assert not model.origin.any()
    assert said(model, "coordinates: up to 1e+07 m, where single precision has steps of 1e+03 mm")


def test_broken_faces_are_left_out_and_counted(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv 2 0 0\nv inf 1 1\nv 0 0 0\n"
        "f 1 2 3\nf 1 2 4\nf 1 2 5\nf 1 1 2\nf 3 1 2\nf 3 2 1\nf 7 2 3\nf 6 1 2\n"
    )
    model = read_model(tmp_path / "a.obj", units="m", up="z")
    assert model.mesh.faces.tolist() == [[0, 1, 2], [2, 1, 0]]  # the back is not a repeat
    assert len(model.mesh.vertices) == 3
    for words in ("2 vertices with NaN or infinite coordinates: 2 faces", "2 faces without area",
                  "2 faces given twice", "2 faces without a material"):  # fmt: skip
        assert said(model, words), (words, model.dropped)


def test_a_soup_of_faces_is_read_as_it_is(tmp_path: Path, rng: np.random.Generator) -> None:
    points = rng.normal(size=(300, 3)).astype(np.float32)
    faces = np.unique(np.sort(rng.integers(0, 300, (500, 3)), axis=1), axis=0)
    faces = faces[(np.diff(faces, axis=1) > 0).all(axis=1)]
    gltf = Gltf()
    gltf.mesh(points)["indices"] = gltf.add(faces.astype(np.uint32).reshape(-1))
    mesh = read_model(gltf.glb(tmp_path / "a.glb")).mesh
    y_up = points[faces].astype(np.float64)
    np.testing.assert_array_equal(
        mesh.vertices[mesh.faces], np.stack([y_up[..., 0], -y_up[..., 2], y_up[..., 1]], axis=-1)
    )


def test_a_side_file_takes_the_place_of_the_extras(tmp_path: Path) -> None:
    room = {"name": "model's", "rings": [[[0, 0], [1, 0], [0, 1]]], "floor": 0, "ceiling": 2.5}
    gltf = Gltf()
    gltf.mesh()
    gltf.json["scenes"][0]["extras"] = {"belvedere_building": {"rooms": [room]}}
    (tmp_path / "a.building.json").write_text(json.dumps({"rooms": [room | {"name": "mine"}]}))
    model = read_model(gltf.glb(tmp_path / "a.glb"))
    assert model.building is not None
    assert model.building.rooms[0].name == "mine"
    assert said(model, "rooms: taken from a.building.json")
    (tmp_path / "a.building.json").write_text('{"rooms": 5}')
    with pytest.raises(SceneError, match=r"a\.building\.json\.rooms is missing or no list"):
        read_model(tmp_path / "a.glb")


@pytest.mark.parametrize("suffix", MODEL_SUFFIXES)
def test_empty_missing_and_folder_are_refused(tmp_path: Path, suffix: str) -> None:
    (tmp_path / f"empty{suffix}").write_bytes(b"")
    (tmp_path / f"folder{suffix}").mkdir()
    with pytest.raises(FileFormatError, match=r"is empty \(0 bytes\)"):
        read_model(tmp_path / f"empty{suffix}")
    with pytest.raises(FileFormatError, match=r"is a folder, expected a model file \(\.glb, "):
        read_model(tmp_path / f"folder{suffix}")
    with pytest.raises(MissingFileError, match=r"no model file .*none"):
        read_model(tmp_path / f"none{suffix}")


def test_an_unknown_suffix_is_told_what_is_read(tmp_path: Path) -> None:
    (tmp_path / "a.fbx").write_bytes(b"Kaydara")
    with pytest.raises(FileFormatError, match=r"'\.fbx' are not read, only \.glb, \.gltf, \.obj"):
        read_model(tmp_path / "a.fbx")
    with pytest.raises(InputError, match=r"read_model\.path is 7, expected the name of a file"):
        read_model(7)  # type: ignore[arg-type]


@given(arrays(np.int64, st.tuples(st.integers(0, 60), st.just(3)), elements=st.integers(-2, 2)))
def test_equal_rows_are_found_as_a_dictionary_finds_them(rows: np.ndarray) -> None:
    seen: dict[tuple[int, ...], int] = {}
    expected = [seen.setdefault(tuple(row), k) for k, row in enumerate(rows.tolist())]
    np.testing.assert_array_equal(first_equal(rows), np.array(expected, np.int64))


def test_minus_zero_is_zero() -> None:
    np.testing.assert_array_equal(first_equal(np.array([[0.0, 1.0], [-0.0, 1.0]])), [0, 0])


def sample(folder: Path, suffix: str) -> bytes:
    """A small good file with a bit of everything."""
    if suffix == ".obj":
        return (
            b"mtllib a.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 1 1 1 1 1 1\nvt 0 0\n"
            b"vt 1 0\nvt 1 1\no a\nusemtl x\nf 1/1 2/2 3/3\nf -1/-1 -2/-2 -3/-3\nf 1 2 3 4\nl 1 2\n"
        )
    if suffix == ".ply":
        pytest.importorskip("trimesh")
        return (
            b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
            b"property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
            b"element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 2 3\n"
            b"1 0 0 1 2 3\n1 1 0 1 2 3\n0 1 0 1 2 3\n3 0 1 2\n4 0 1 2 3\n"
        )
    gltf = Gltf()
    pixels = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    texture = {
        "index": gltf.picture(pixels),
        "extensions": {"KHR_texture_transform": {"rotation": 1.0}},
    }
    look = {"pbrMetallicRoughness": {"baseColorTexture": texture}, "alphaMode": "BLEND"}
    gltf.mesh(
        TEXCOORD_0=np.zeros((3, 2), np.float32),
        COLOR_0=np.ones((3, 4), np.float32),
        material=gltf.material(name="a", emissiveFactor=[1, 1, 1], **look),
        indices=gltf.add(np.array([0, 1, 2], np.uint16)),
    )
    write = gltf.glb if suffix == ".glb" else gltf.gltf
    return write(folder / f"good{suffix}").read_bytes()


@pytest.mark.parametrize("suffix", [".glb", ".gltf", ".obj", ".ply"])
def test_a_spoilt_file_is_read_or_refused_but_never_a_crash(
    tmp_path: Path, rng: np.random.Generator, suffix: str
) -> None:
    good = sample(tmp_path, suffix)
    read = 0
    for _ in range(150):
        data = bytearray(good)
        for _ in range(int(rng.integers(1, 4))):
            at = int(rng.integers(len(data)))
            choice = int(rng.integers(3))
            if choice == 0:
                data[at] = int(rng.integers(256))
            elif choice == 1:
                del data[at : at + int(rng.integers(1, 9))]
            else:
                data[at:at] = bytes(rng.choice(list(b'0123456789-eE.,:[]{}" \n/na'), 3).tolist())
        (tmp_path / f"bad{suffix}").write_bytes(bytes(data))
        try:
            read += len(read_model(tmp_path / f"bad{suffix}").mesh.faces) > 0
        except BelvedereError:
            continue
    assert read < 150
