"""transforms.json: nerfstudio's, instant-ngp's and Blender's conventions, and what can be wrong."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from belvedere import Camera
from belvedere.ground.errors import (
    FileFormatError,
    MissingFileError,
    SceneError,
    UnsafePathError,
)
from belvedere.scene.conventions import Conventions
from belvedere.scene.io import format_conventions, read_views, write_color, write_depth
from belvedere.scene.io.lens import Lens, undistorted

WIDTH, HEIGHT = 16, 12
POSE = np.array([[0.8, 0.0, 0.6, 1.0], [0.6, 0.0, -0.8, 2.0], [0.0, 1.0, 0.0, 3.0], [0, 0, 0, 1]])
"""Camera-to-world with OpenGL axes: columns right, up, backward."""


def scene(folder: Path, frames: int = 2, **changes: Any) -> dict[str, Any]:
    """The JSON of a good scene whose files lie in ``folder``."""
    rng = np.random.default_rng(1)
    root: dict[str, Any] = {
        "fl_x": 20.0, "fl_y": 21.0, "cx": 8.25, "cy": 5.5, "w": WIDTH, "h": HEIGHT, "frames": [],
    }  # fmt: skip
    for index in range(frames):
        pixels = rng.integers(0, 256, (HEIGHT, WIDTH, 3), dtype=np.uint8)
        write_color(folder / "images" / f"f{index}.png", pixels)
        depth = rng.integers(1000, 4000, (HEIGHT, WIDTH), dtype=np.uint16)
        write_depth(folder / "depth" / f"f{index}.png", depth)
        root["frames"].append(
            {"file_path": f"images/f{index}.png", "depth_file_path": f"depth/f{index}.png",
             "transform_matrix": POSE.tolist()}
        )  # fmt: skip
    return root | changes


def save(folder: Path, root: dict[str, Any]) -> Path:
    (folder / "transforms.json").write_text(json.dumps(root))
    return folder


def planar(camera: object) -> Camera:
    assert isinstance(camera, Camera)
    return camera


# ---- conventions -------------------------------------------------------------------------------


def test_a_world_point_falls_where_nerfstudios_formula_puts_it(tmp_path: Path) -> None:
    views = read_views(save(tmp_path, scene(tmp_path)))
    assert views.names == ("f0", "f1")
    point = POSE @ [0.4, -0.3, -2.5, 1.0]  # right, up, backward: in front is negative
    u, v, delta = views.cameras[0].project(point[:3])
    # nerfstudio shoots the ray of pixel i through i + 0.5
    assert u == pytest.approx(20.0 * 0.4 / 2.5 + 8.25 - 0.5)
    assert v == pytest.approx(-21.0 * -0.3 / 2.5 + 5.5 - 0.5)
    assert delta == pytest.approx(1 / 2.5)


def test_a_picture_whose_middle_is_the_principal_point_is_symmetric(tmp_path: Path) -> None:
    root = scene(tmp_path)
    del root["cx"], root["cy"]
    k = planar(read_views(save(tmp_path, root)).cameras[0]).intrinsics
    np.testing.assert_allclose(k[:2, 2], [(WIDTH - 1) / 2, (HEIGHT - 1) / 2])


@pytest.mark.parametrize(
    ("changes", "scale"),
    [({}, 0.001), ({"depth_unit_scale_factor": 0.0002}, 0.0002),
     ({"integer_depth_scale": 0.01}, 0.01)],
)  # fmt: skip
def test_the_depth_unit_is_millimetres_unless_the_file_says(
    tmp_path: Path, changes: dict[str, Any], scale: float
) -> None:
    views = read_views(save(tmp_path, scene(tmp_path, **changes)))
    assert views.facts["depth_scale"] == scale
    from belvedere.scene.io import read_depth_values

    stored = read_depth_values(tmp_path / "depth" / "f1.png")
    np.testing.assert_allclose(1 / views[1].disparity, stored * scale, rtol=1e-6)


def test_instant_ngps_word_for_depth_is_known_too(tmp_path: Path) -> None:
    root = scene(tmp_path, frames=1, integer_depth_scale=0.0005)
    frame = root["frames"][0]
    frame["depth_path"] = frame.pop("depth_file_path")
    views = read_views(save(tmp_path, root))
    assert views.has_depth
    assert views.facts["depth_scale"] == 0.0005


def test_float_depth_is_in_metres(tmp_path: Path) -> None:
    root = scene(tmp_path, frames=1)
    write_depth(tmp_path / "d.npy", np.full((HEIGHT, WIDTH), 2.0, np.float32))
    root["frames"][0]["depth_file_path"] = "d.npy"
    views = read_views(save(tmp_path, root))
    assert np.unique(views[0].disparity).tolist() == [0.5]


def test_given_conventions_replace_the_files_own(tmp_path: Path) -> None:
    save(tmp_path, scene(tmp_path))
    own = format_conventions(tmp_path)
    assert own == Conventions(axes="opengl", pixel_centers="half")
    base = read_views(tmp_path)
    for change in ({"axes": "opencv"}, {"pose": "world_to_camera"}, {"pixel_centers": "integer"}):
        views = read_views(tmp_path, replace(own, **change))
        assert np.abs(planar(views.cameras[0]).matrix - planar(base.cameras[0]).matrix).max() > 1e-3
    feet = read_views(tmp_path, replace(own, depth_scale=0.002))
    np.testing.assert_allclose(feet[0].disparity, base[0].disparity / 2, rtol=1e-6)
    assert feet.facts["depth_scale_from"] == "given by the caller"
    ray = read_views(tmp_path, replace(own, depth_kind="ray"))
    assert (ray[0].disparity >= base[0].disparity).all()


def test_intrinsics_may_stand_in_each_frame(tmp_path: Path) -> None:
    root = scene(tmp_path)
    for index, frame in enumerate(root["frames"]):
        frame |= {"fl_x": 30.0 + index, "fl_y": 31.0, "cx": 8.0, "cy": 6.0, "w": WIDTH, "h": HEIGHT}
    for key in ("fl_x", "fl_y", "cx", "cy", "w", "h"):
        del root[key]
    views = read_views(save(tmp_path, root))
    assert [planar(c).intrinsics[0, 0] for c in views.cameras] == pytest.approx([30.0, 31.0])


def test_blenders_scenes_have_an_angle_and_names_without_suffix(tmp_path: Path) -> None:
    root = scene(tmp_path)
    frames = [{"file_path": "./images/f0", "transform_matrix": POSE.tolist()}]
    angle = 0.6911112070083618
    (tmp_path / "transforms_train.json").write_text(
        json.dumps({"camera_angle_x": angle, "frames": frames})
    )
    del root
    views = read_views(tmp_path / "transforms_train.json")
    k = planar(views.cameras[0]).intrinsics
    assert k[0, 0] == pytest.approx(0.5 * WIDTH / math.tan(0.5 * angle))
    assert k[1, 1] == pytest.approx(k[0, 0])
    assert not views.has_depth
    assert views.color(0).shape == (HEIGHT, WIDTH, 3)


def test_three_rows_of_a_pose_are_enough(tmp_path: Path) -> None:
    root = scene(tmp_path, frames=1)
    root["frames"][0]["transform_matrix"] = POSE[:3].tolist()
    np.testing.assert_allclose(read_views(save(tmp_path, root)).cameras[0].center, [1, 2, 3])


def test_equal_stems_make_names_of_whole_paths(tmp_path: Path) -> None:
    root = scene(tmp_path, frames=1)
    write_color(tmp_path / "other" / "f0.png", np.zeros((HEIGHT, WIDTH, 3), np.uint8))
    root["frames"].append({"file_path": "other/f0.png", "transform_matrix": POSE.tolist()})
    assert read_views(save(tmp_path, root)).names == ("images/f0.png", "other/f0.png")


# ---- distortion --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("keys", "coefficients", "fisheye"),
    [
        ({"k1": -0.1, "k2": 0.02, "p1": 0.001, "p2": -0.002},
         (-0.1, 0.02, 0.001, -0.002, 0), False),
        ({"k1": 0.01, "k2": 0.0, "k3": 0.002, "camera_model": "OPENCV"}, (0.01, 0, 0, 0, 0.002),
         False),
        ({"k1": 0.01, "k4": 0.001, "camera_model": "OPENCV_FISHEYE"}, (0.01, 0, 0, 0.001), True),
    ],
)  # fmt: skip
def test_distorted_pictures_are_undistorted_and_the_crop_is_reported(
    tmp_path: Path, keys: dict[str, Any], coefficients: tuple[float, ...], fisheye: bool
) -> None:
    views = read_views(save(tmp_path, scene(tmp_path, **keys)))
    lens = Lens(WIDTH, HEIGHT, 20.0, 21.0, 7.75, 5.0, coefficients, fisheye)
    crop = undistorted(lens)
    assert views.facts["undistorted"] == {"f0": crop.as_fact(), "f1": crop.as_fact()}
    view = views[0]
    assert view.color.shape == (crop.height, crop.width, 3)
    assert view.disparity.shape == (crop.height, crop.width)
    k = planar(view.camera).intrinsics
    np.testing.assert_allclose(k[:2, 2], [7.75 - crop.left, 5.0 - crop.top], atol=1e-9)
    from belvedere.scene.io import read_depth_values

    stored = read_depth_values(tmp_path / "depth" / "f0.png")
    np.testing.assert_allclose(1 / view.disparity, crop.depth(stored) * 0.001, rtol=1e-6)


def test_zero_coefficients_need_no_opencv(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "cv2", None)
    keys = {"k1": 0.0, "k2": 0.0, "p1": 0, "p2": 0, "camera_model": "OPENCV"}
    views = read_views(save(tmp_path, scene(tmp_path, **keys)))
    assert views[0].color.shape == (HEIGHT, WIDTH, 3)
    assert "undistorted" not in views.facts


# ---- what can be wrong -------------------------------------------------------------------------


def frame_change(**changes: Any) -> Any:
    def change(root: dict[str, Any]) -> None:
        root["frames"][1] |= changes

    return change


def drop(*keys: str) -> Any:
    def change(root: dict[str, Any]) -> None:
        for key in keys:
            root.pop(key, None)
            root.get("frames", [{}, {}])[1].pop(key, None)

    return change


def bad_pose(row: int, column: int, value: float) -> npt.NDArray[np.float64]:
    pose = POSE.copy()
    pose[row, column] = value
    return pose


WHERE = r"transforms\.json: frames\[1\]"


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        (drop("frames"), SceneError, "transforms.json has no 'frames': add it"),
        (lambda r: r.update(frames=[]), SceneError, r"frames is \[\], expected a list of objects"),
        (lambda r: r.update(frames=[1]), SceneError, r"frames\[0\] is 1, expected an object"),
        (drop("file_path"), SceneError, WHERE + " has no 'file_path'"),
        (drop("transform_matrix"), SceneError, WHERE + " has no 'transform_matrix'"),
        (drop("fl_x", "fl_y"), SceneError, r"frames\[0\] has no focal length: add 'fl_x'"),
        (frame_change(file_path="images/no.png"), MissingFileError,
         WHERE + r"\.file_path: no file 'images/no\.png' in"),
        (frame_change(depth_file_path="depth/no.png"), MissingFileError,
         WHERE + r"\.depth_file_path: no file 'depth/no\.png' in"),
        (frame_change(file_path="../f0.png"), UnsafePathError,
         WHERE + r"\.file_path leads out of the scene's folder"),
        (frame_change(file_path="/etc/passwd"), UnsafePathError,
         WHERE + r"\.file_path is the absolute path '/etc/passwd'"),
        (frame_change(depth_file_path="..\\d.png"), UnsafePathError, "has a backslash"),
        (frame_change(file_path=7), SceneError, WHERE + r"\.file_path is 7, expected text"),
        (frame_change(file_path="images/f0.png"), SceneError,
         WHERE + r": the name 'images/f0\.png' is that of transforms\.json: frames\[0\] already"),
        (frame_change(transform_matrix=np.eye(3).tolist()), SceneError,
         WHERE + r"\.transform_matrix has shape \(3, 3\), expected \(4, 4\)"),
        (frame_change(transform_matrix=[[1, 2], [3]]), SceneError, "a row is ragged or has text"),
        (frame_change(transform_matrix=(2 * POSE).tolist()), SceneError,
         WHERE + ": .*last row"),
        (frame_change(transform_matrix=bad_pose(0, 0, 0.1).tolist()), SceneError,
         WHERE + ": .*is not rigid"),
        (frame_change(transform_matrix=np.diag([1.0, 1, -1, 1]).tolist()), SceneError,
         WHERE + ": .*mirrors space"),
        (lambda r: r.update(fl_x=0), SceneError, r"fl_x is 0, expected .* above 0"),
        (lambda r: r.update(fl_x=-20.0), SceneError, "fl_x is -20, expected a number above 0"),
        (lambda r: r.update(fl_x="20"), SceneError, 'fl_x is "20", expected a number'),
        (lambda r: r.update(w=0), SceneError, "w is 0, expected a whole number from 1"),
        (lambda r: r.update(w=15.5), SceneError, "w is 15.5, expected a whole number"),
        (lambda r: r.update(camera_model="EQUIRECTANGULAR"), SceneError,
         "camera_model is 'EQUIRECTANGULAR', expected one of"),
        (lambda r: r.update(k4=0.1), SceneError, "k4 is 0.1, which only 'OPENCV_FISHEYE' has"),
        (lambda r: r.update(depth_unit_scale_factor=0), SceneError,
         "depth_unit_scale_factor is 0, expected a number above 0"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_with_its_frame_and_key(
    tmp_path: Path, change: Any, error: type[Exception], message: str
) -> None:
    root = scene(tmp_path)
    change(root)
    with pytest.raises(error, match=message):
        read_views(save(tmp_path, root))


def test_a_nan_in_a_pose_is_named_with_its_place(tmp_path: Path) -> None:
    root = scene(tmp_path)
    root["frames"][1]["transform_matrix"][0][3] = math.nan
    with pytest.raises(FileFormatError, match=r"frames\[1\]\.transform_matrix\[0\]\[3\] is NaN"):
        read_views(save(tmp_path, root))


def test_pictures_of_another_size_than_their_camera_are_named_when_looked_at(
    tmp_path: Path,
) -> None:
    root = scene(tmp_path)
    write_depth(tmp_path / "depth" / "f0.png", np.ones((6, 8), np.uint16))
    write_color(tmp_path / "images" / "f1.png", np.zeros((6, 8, 3), np.uint8))
    views = read_views(save(tmp_path, root))
    with pytest.raises(FileFormatError, match=r"depth/f0\.png: is 8 x 6 pixels, but its camera"):
        _ = views[0]
    with pytest.raises(FileFormatError, match=r"images/f1\.png: is 8 x 6 .* has 16 x 12"):
        views.color(1)


def test_a_view_without_depth_says_so(tmp_path: Path) -> None:
    root = scene(tmp_path, frames=1)
    del root["frames"][0]["depth_file_path"]
    views = read_views(save(tmp_path, root))
    with pytest.raises(SceneError, match="view 'f0' has no depth"):
        _ = views[0]
