"""COLMAP's models: both encodings, its conventions, and what can be wrong."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from belvedere import Camera
from belvedere.ground.errors import (
    FileFormatError,
    MissingFileError,
    SceneError,
    UnsafePathError,
)
from belvedere.scene.io import read_views, write_color
from belvedere.scene.io.colmap import (
    MODELS,
    ColmapCamera,
    ColmapImage,
    ColmapModel,
    read_model,
    write_model,
)
from belvedere.scene.io.depth import encode_colmap_depth
from belvedere.scene.io.lens import Lens, undistorted
from belvedere.scene.io.rotations import quaternion_of, rotation_of
from belvedere.scene.pose import invert_pose, look_at_rotation, pose_matrix

WIDTH, HEIGHT = 16, 12
PINHOLE = ColmapCamera(3, "PINHOLE", WIDTH, HEIGHT, (20.0, 21.0, 8.25, 5.5))
WORLD_TO_CAMERA = invert_pose(
    pose_matrix(look_at_rotation((1, 2, 3), (0, 0, 0), (0, 0, 1)), (1, 2, 3))
)


def workspace(folder: Path, camera: ColmapCamera = PINHOLE, binary: bool = True) -> Path:
    model = ColmapModel({camera.id: camera}, (
        ColmapImage(7, "left/a.png", camera.id, WORLD_TO_CAMERA),
        ColmapImage(9, "b.png", camera.id, np.eye(4)),
    ))  # fmt: skip
    (folder / "sparse" / "0").mkdir(parents=True)
    write_model(folder / "sparse" / "0", model, binary=binary)
    for name in ("left/a.png", "b.png"):
        write_color(folder / "images" / name, np.zeros((HEIGHT, WIDTH, 3), np.uint8))
    return folder


@pytest.mark.parametrize("binary", [True, False])
def test_a_model_comes_back_to_the_last_bit(tmp_path: Path, binary: bool) -> None:
    rng = np.random.default_rng(5)
    cameras = {
        i: ColmapCamera(i, name, 640 + i, 480, tuple(rng.uniform(1, 900, count).tolist()))
        for i, (name, count) in enumerate(MODELS, start=1)
    }
    images = tuple(
        ColmapImage(i, f"folder with blanks/ü{i}.png", i, WORLD_TO_CAMERA) for i in cameras
    )
    write_model(tmp_path, ColmapModel(cameras, images), binary=binary)
    back = read_model(tmp_path)
    assert back.cameras == cameras
    assert [(i.id, i.name, i.camera_id) for i in back.images] == [
        (i.id, i.name, i.camera_id) for i in images
    ]
    np.testing.assert_allclose(back.images[0].world_to_camera, WORLD_TO_CAMERA, atol=1e-15)


@pytest.mark.parametrize("binary", [True, False])
def test_a_world_point_falls_where_colmaps_formula_puts_it(tmp_path: Path, binary: bool) -> None:
    views = read_views(workspace(tmp_path, binary=binary))
    assert views.names == ("a", "b")
    x, y, z = (WORLD_TO_CAMERA @ [0.3, -0.2, 0.1, 1.0])[:3]
    u, v, delta = views.cameras[0].project([0.3, -0.2, 0.1])
    assert u == pytest.approx(20.0 * x / z + 8.25 - 0.5)  # COLMAP's first pixel centre is at 0.5
    assert v == pytest.approx(21.0 * y / z + 5.5 - 0.5)
    assert delta == pytest.approx(1 / z)


@given(st.integers(0, 2**32 - 1))
def test_quaternions_and_rotations_are_inverse_to_each_other(seed: int) -> None:
    q = np.random.default_rng(seed).normal(size=4)
    q /= np.linalg.norm(q)
    rotation = rotation_of("test", *q)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(rotation) == pytest.approx(1)
    np.testing.assert_allclose(rotation_of("test", *quaternion_of(rotation)), rotation, atol=1e-14)


def test_half_turns_have_quaternions_too() -> None:
    for axis in np.eye(3):
        rotation = 2 * np.outer(axis, axis) - np.eye(3)
        np.testing.assert_allclose(rotation_of("t", *quaternion_of(rotation)), rotation, atol=1e-15)


def test_dense_depth_maps_are_found_and_read(tmp_path: Path) -> None:
    workspace(tmp_path)
    depth = np.full((HEIGHT, WIDTH), 4.0, np.float32)
    depth[0, 0] = 0
    for name, scale in (("left/a.png.photometric", 1), ("left/a.png.geometric", 2),
                        ("b.png.photometric", 1)):  # fmt: skip
        file = tmp_path / "stereo" / "depth_maps" / f"{name}.bin"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(encode_colmap_depth(depth * scale))
    views = read_views(tmp_path)
    assert views[0].disparity[5, 5] == 0.125  # geometric before photometric
    assert views[1].disparity[5, 5] == 0.25
    assert np.isnan(views[1].disparity[0, 0])


@pytest.mark.parametrize(
    ("model", "params", "coefficients", "fisheye"),
    [
        ("SIMPLE_RADIAL", (20.0, 8.25, 5.5, -0.1), (-0.1, 0, 0, 0), False),
        ("RADIAL", (20.0, 8.25, 5.5, -0.1, 0.01), (-0.1, 0.01, 0, 0), False),
        ("OPENCV", (20.0, 20.0, 8.25, 5.5, -0.1, 0.01, 0.001, 0.002),
         (-0.1, 0.01, 0.001, 0.002), False),
        ("FULL_OPENCV", (20.0, 20.0, 8.25, 5.5, -0.1, 0.01, 0.001, 0.002, 0.01, 0.1, 0.0, 0.0),
         (-0.1, 0.01, 0.001, 0.002, 0.01, 0.1, 0.0, 0.0), False),
        ("OPENCV_FISHEYE", (20.0, 20.0, 8.25, 5.5, 0.01, 0.0, 0.001, 0.0),
         (0.01, 0.0, 0.001, 0.0), True),
        ("RADIAL_FISHEYE", (20.0, 8.25, 5.5, 0.01, 0.002), (0.01, 0.002, 0, 0), True),
    ],
)  # fmt: skip
def test_every_distortion_becomes_a_lens_and_is_taken_out(
    tmp_path: Path, model: str, params: Any, coefficients: Any, fisheye: bool
) -> None:
    views = read_views(workspace(tmp_path, ColmapCamera(1, model, WIDTH, HEIGHT, params)))
    crop = undistorted(Lens(WIDTH, HEIGHT, 20.0, 20.0, 7.75, 5.0, coefficients, fisheye))
    assert views.facts["undistorted"]["a"] == crop.as_fact()
    assert views.color(0).shape == (crop.height, crop.width, 3)


def test_zero_distortion_needs_no_undistorting(tmp_path: Path) -> None:
    camera = ColmapCamera(1, "SIMPLE_RADIAL", WIDTH, HEIGHT, (20.0, 8.0, 6.0, 0.0))
    views = read_views(workspace(tmp_path, camera))
    assert "undistorted" not in views.facts
    planar = views.cameras[0]
    assert isinstance(planar, Camera)
    np.testing.assert_allclose(planar.intrinsics[:2, 2], [7.5, 5.5])


@pytest.mark.parametrize("model", ["FOV", "THIN_PRISM_FISHEYE"])
def test_models_that_we_cannot_undistort_are_refused(tmp_path: Path, model: str) -> None:
    params = (20.0, 20.0, 8.0, 6.0, *[0.1] * (dict(MODELS)[model] - 4))
    with pytest.raises(SceneError, match=f"camera model {model}, which is not read"):
        read_views(workspace(tmp_path, ColmapCamera(1, model, WIDTH, HEIGHT, params)))


def spoil_text(name: str, old: str, new: str) -> Any:
    def change(folder: Path) -> None:
        file = folder / "sparse" / "0" / name
        text = file.read_text()
        assert old in text
        file.write_text(text.replace(old, new, 1))

    return change


@pytest.mark.parametrize(
    ("spoil", "error", "message"),
    [
        (spoil_text("cameras.txt", "PINHOLE", "PINHOLES"), FileFormatError,
         r"cameras\.txt: line 2 is '3 PINHOLES .*expected CAMERA_ID"),
        (spoil_text("cameras.txt", " 5.5", ""), FileFormatError, "has 3 values, expected 4"),
        (spoil_text("cameras.txt", "20.0", "nan"), FileFormatError, "expected a finite number"),
        (spoil_text("cameras.txt", "20.0", "0.0"), SceneError, "they must be positive"),
        (spoil_text("images.txt", " 3 left/a.png", ""), FileFormatError, "expected IMAGE_ID"),
        (spoil_text("images.txt", " 3 left", " 4 left"), FileFormatError,
         "has camera 4, which cameras does not list"),
        (spoil_text("images.txt", "left/a.png", "../a.png"), UnsafePathError, "leads out"),
        (spoil_text("images.txt", "left/a.png", "left/c.png"), MissingFileError,
         "COLMAP image 7: no file 'left/c.png'"),
        (lambda f: (f / "sparse/0/images.txt").write_text("# none\n"), FileFormatError,
         "lists no images"),
        (lambda f: (f / "sparse/0/images.txt").write_text(""), FileFormatError, "is empty"),
        (lambda f: (f / "images").rename(f / "photos"), MissingFileError, "no folder images"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_text_is_named_with_its_line(
    tmp_path: Path, spoil: Any, error: type[Exception], message: str
) -> None:
    spoil(workspace(tmp_path, binary=False))
    with pytest.raises(error, match=message):
        read_views(tmp_path)


@pytest.mark.parametrize("name", ["cameras.bin", "images.bin"])
@pytest.mark.parametrize("keep", [0, 5, 30, -3])
def test_truncated_binaries_are_named(tmp_path: Path, name: str, keep: int) -> None:
    file = workspace(tmp_path) / "sparse" / "0" / name
    file.write_bytes(file.read_bytes()[:keep])
    with pytest.raises(FileFormatError, match=rf"{name}: ends too early, it is truncated"):
        read_views(tmp_path)


@pytest.mark.parametrize(
    ("name", "at", "data", "message"),
    [
        ("cameras.bin", 0, struct.pack("<Q", 2**60), "promises 1152921504606846976 entries"),
        ("cameras.bin", 12, struct.pack("<i", 99), "has the unknown model 99"),
        ("cameras.bin", 32, struct.pack("<d", float("nan")), "expected finite numbers"),
        ("images.bin", 12, struct.pack("<d", float("inf")), "expected finite numbers"),
        ("images.bin", 12, struct.pack("<d", 40.0), "quaternion of length"),
        ("images.bin", 83, struct.pack("<Q", 2**60), "keypoints: corrupt"),
    ],
)
def test_corrupt_binaries_are_named(
    tmp_path: Path, name: str, at: int, data: bytes, message: str
) -> None:
    file = workspace(tmp_path) / "sparse" / "0" / name
    content = bytearray(file.read_bytes())
    content[at : at + len(data)] = data
    file.write_bytes(bytes(content))
    with pytest.raises(FileFormatError, match=message):
        read_views(tmp_path)


def test_keypoints_are_skipped(tmp_path: Path) -> None:
    """Both encodings list them; a real model has thousands."""
    workspace(tmp_path / "b")
    file = tmp_path / "b" / "sparse" / "0" / "images.bin"
    data = file.read_bytes()
    cut = data.index(b"left/a.png\x00") + 11
    points = struct.pack("<Q", 2) + struct.pack("<ddq", 1.0, 2.0, -1) * 2
    file.write_bytes(data[:cut] + points + data[cut + 8 :])
    assert len(read_views(tmp_path / "b")) == 2
    workspace(tmp_path / "t", binary=False)
    spoil_text("images.txt", "left/a.png\n\n", "left/a.png\n1.0 2.0 -1 3.0 4.0 5\n")(tmp_path / "t")
    assert read_views(tmp_path / "t").names == ("a", "b")


def test_no_model_is_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"no cameras\.bin with images\.bin"):
        read_model(tmp_path)
    with pytest.raises(MissingFileError, match="no COLMAP model in"):
        read_views(tmp_path, format="colmap")
