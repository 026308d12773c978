"""Lit models as files: what was written comes back, and nothing else is believed."""

from __future__ import annotations

import json
import zlib
from pathlib import Path

import numpy as np
import pytest

from belvedere.ground.errors import FileFormatError, MissingFileError, OutputError
from belvedere.model import (
    House,
    LightSettings,
    LitModel,
    build_house,
    light_model,
    load_lit_model,
    photograph,
    save_lit_model,
)
from belvedere.model.lit_file import ALIGN, HEAD, MAGIC
from belvedere.scene import Camera
from belvedere.scene.mesh import Material, Mesh

TEXTURE = np.linspace(0.0, 1.0, 48, dtype=np.float32).reshape(4, 4, 3)


@pytest.fixture(scope="module")
def small() -> LitModel:
    """A tetrahedron with everything that a model may have."""
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    materials = (Material("a", (0.5, 0.4, 0.3), TEXTURE), Material("b", emission=(1.0, 0.0, 2.0)))
    uv = np.random.default_rng(0).random((4, 3, 2)).astype(np.float32)
    colors = np.random.default_rng(1).random((4, 3, 3)).astype(np.float32)
    mesh = Mesh(vertices, faces, np.array([0, 1, 0, 1]), uv, materials, colors)
    return light_model(mesh, settings=LightSettings(rays=4, bounces=1))


@pytest.fixture(scope="module")
def flat() -> House:
    return build_house("flat", rays=4)


def same(a: LitModel, b: LitModel) -> None:
    pairs = [
        (a.mesh.vertices, b.mesh.vertices), (a.mesh.faces, b.mesh.faces), (a.mesh.uv, b.mesh.uv),
        (a.mesh.material_index, b.mesh.material_index), (a.charts.corners, b.charts.corners),
        (a.charts.normals, b.charts.normals), (a.charts.of_face, b.charts.of_face),
        (a.charts.material, b.charts.material), (a.charts.st, b.charts.st),
        (a.charts.cutouts, b.charts.cutouts), (a.charts.curved, b.charts.curved),
        (a.light.soft, b.light.soft), (a.light.sun, b.light.sun),
        (a.light.sun_color, b.light.sun_color),
    ]  # fmt: skip
    for one, other in pairs:
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
    for one, other in ((a.mesh.colors, b.mesh.colors), (a.charts.two_sided, b.charts.two_sided)):
        assert (one is None) == (other is None)
        if one is not None:
            np.testing.assert_array_equal(one, other)
    assert a.charts.covered == b.charts.covered
    for one, other in zip(a.mesh.materials, b.mesh.materials, strict=True):
        assert one.name == other.name
        assert one.base_color == other.base_color
        assert one.emission == other.emission
        assert (one.texture is None) == (other.texture is None)
        if one.texture is not None:
            np.testing.assert_array_equal(one.texture, other.texture)


def test_what_was_written_comes_back(small: LitModel, flat: House, tmp_path: Path) -> None:
    for model in (small, flat):
        path = save_lit_model(tmp_path / "model.lit", model)
        same(load_lit_model(path), model)


def test_a_loaded_model_takes_the_same_photograph(flat: House, tmp_path: Path) -> None:
    camera = flat.path.resized(80, 64).cameras(3)[1]
    loaded = load_lit_model(save_lit_model(tmp_path / "model.lit", flat))
    one, other = photograph(flat, camera, 1), photograph(loaded, camera, 1)
    np.testing.assert_array_equal(one.color, other.color)
    np.testing.assert_array_equal(one.disparity, other.disparity)


def test_the_same_model_gives_the_same_bytes(small: LitModel, tmp_path: Path) -> None:
    first = save_lit_model(tmp_path / "a.lit", small).read_bytes()
    loaded = load_lit_model(tmp_path / "a.lit")
    assert save_lit_model(tmp_path / "b.lit", loaded).read_bytes() == first
    assert first.startswith(MAGIC)


def test_changes_stay_in_memory(small: LitModel, tmp_path: Path) -> None:
    path = save_lit_model(tmp_path / "model.lit", small)
    before = path.read_bytes()
    load_lit_model(path).light.soft[:] = 7.0
    assert path.read_bytes() == before


def test_materials_that_share_a_texture_store_it_once(flat: House, tmp_path: Path) -> None:
    textures = {id(m.texture): m.texture for m in flat.mesh.materials if m.texture is not None}
    arrays = sum(t.nbytes for t in textures.values())
    charts, light = flat.charts, flat.light
    arrays += sum(a.nbytes for a in (charts.corners, charts.normals, charts.st, flat.mesh.vertices))
    arrays += sum(a.nbytes for a in (flat.mesh.faces, flat.mesh.uv, light.soft, light.sun))
    assert save_lit_model(tmp_path / "model.lit", flat).stat().st_size < 1.2 * arrays


def test_nothing_is_replaced_without_force(small: LitModel, tmp_path: Path) -> None:
    path = save_lit_model(tmp_path / "model.lit", small)
    with pytest.raises(OutputError, match="exists"):
        save_lit_model(path, small, force=False)


def test_bad_files_are_refused(small: LitModel, tmp_path: Path) -> None:
    good = save_lit_model(tmp_path / "good.lit", small).read_bytes()
    bad = tmp_path / "bad.lit"
    newer = bytearray(good)
    newer[8:12] = (9).to_bytes(4, "little")
    cases = {
        b"": "no lit model", b"BELVLIT2": "no lit model", b"\x89PNG" + good[4:]: "no lit model",
        bytes(newer): "version 9", good[:-1]: "cut off", good[: len(good) // 2]: "cut off",
        good[:50]: "cut off", good + b"\0" * 64: "cut off",
    }  # fmt: skip
    for at in (HEAD.size + 5, len(good) // 2, len(good) - 70):
        damaged = bytearray(good)
        damaged[at] ^= 0xFF
        cases[bytes(damaged)] = "damaged"
    for content, message in cases.items():
        bad.write_bytes(content)
        with pytest.raises(FileFormatError, match=message):
            load_lit_model(bad)
    with pytest.raises(MissingFileError):
        load_lit_model(tmp_path / "none.lit")


def forged(good: bytes, change: object) -> bytes:
    """A file whose checksums are right and whose header is not."""
    _, version, length, size, _, check = HEAD.unpack(good[: HEAD.size])
    start = -(-(HEAD.size + length) // ALIGN) * ALIGN
    header = json.loads(good[HEAD.size : HEAD.size + length])
    change(header)  # type: ignore[operator]
    text = json.dumps(header, separators=(",", ":")).encode()
    place = -(-(HEAD.size + len(text)) // ALIGN) * ALIGN
    total = place + size - start
    head = HEAD.pack(MAGIC, version, len(text), total, zlib.crc32(text), check)
    return (head + text).ljust(place, b"\0") + good[start:]


@pytest.mark.parametrize(
    "change",
    [
        lambda h: h["arrays"][0].update(offset=10**9),
        lambda h: h["arrays"][0].update(offset=-64),
        lambda h: h["arrays"][0].update(shape=[-1, 3]),
        lambda h: h["arrays"][0].update(type="|O"),
        lambda h: h["arrays"][1].update(shape=[1, 3]),
        lambda h: h["arrays"].pop(5),
        lambda h: h.update(materials=[]),
        lambda h: h["materials"][0].update(texture=4),
        lambda h: h["materials"][0].update(base_color=[1.0]),
        lambda h: h["materials"][0].update(base_color=[1.0, float("nan"), 0.0]),
        lambda h: h.update(arrays={}),
        lambda h: [a.update(shape=[1, 3]) for a in h["arrays"] if a["name"] == "soft"],
        lambda h: [a.update(name="soft_shape") for a in h["arrays"] if a["name"] == "sun_shape"],
    ],
)
def test_forged_headers_are_refused(small: LitModel, tmp_path: Path, change: object) -> None:
    good = save_lit_model(tmp_path / "good.lit", small).read_bytes()
    assert forged(good, lambda _: None) == good
    (tmp_path / "bad.lit").write_bytes(forged(good, change))
    with pytest.raises(FileFormatError):
        load_lit_model(tmp_path / "bad.lit")


def test_a_camera_sees_the_small_model(small: LitModel) -> None:
    camera = Camera.look_at((2.0, 2.0, 2.0), (0.2, 0.2, 0.2), width=32, height=32)
    assert photograph(small, camera, 1).disparity.max() > 0.0
