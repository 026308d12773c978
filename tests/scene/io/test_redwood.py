"""Open3D's RGB-D layout."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from belvedere import Camera
from belvedere.ground.errors import FileFormatError, MissingFileError, SceneError
from belvedere.scene.io import read_views, write_color, write_depth
from belvedere.scene.pose import look_at_rotation, pose_matrix

POSE = pose_matrix(look_at_rotation((1, 2, 3), (0, 0, 0), (0, 0, 1)), (1, 2, 3))


def log(count: int) -> str:
    rows = "\n".join(" ".join(map(repr, row)) for row in POSE.tolist())
    return "".join(f"{i} {i} {i + 1}\n{rows}\n" for i in range(count))


def scene(folder: Path, size: tuple[int, int] = (12, 16)) -> Path:
    for index in (2, 10):  # by value 2 comes before 10, by letters after
        write_color(folder / "color" / f"{index}.png", np.full((*size, 3), index, np.uint8))
        write_depth(folder / "depth" / f"{index}.png", np.full(size, 2000, np.uint16))
    (folder / "trajectory.log").write_text(log(2))
    camera = {"width": size[1], "height": size[0],
              "intrinsic_matrix": [20.0, 0, 0, 0, 21.0, 0, 7.5, 5.5, 1]}  # fmt: skip
    (folder / "camera_primesense.json").write_text(json.dumps(camera))
    return folder


def test_matrices_are_column_major_and_poses_camera_to_world(tmp_path: Path) -> None:
    views = read_views(scene(tmp_path))
    assert views.names == ("2", "10")
    camera = views.cameras[0]
    assert isinstance(camera, Camera)
    np.testing.assert_allclose(camera.intrinsics, [[20, 0, 7.5], [0, 21, 5.5], [0, 0, 1]])
    np.testing.assert_allclose(camera.camera_to_world, POSE, atol=1e-12)
    assert np.unique(views[0].disparity).tolist() == [0.5]
    assert np.unique(views[1].color).tolist() == [10]


def test_without_a_camera_file_640_x_480_is_primesenses(tmp_path: Path) -> None:
    scene(tmp_path, (480, 640))
    (tmp_path / "camera_primesense.json").unlink()
    camera = read_views(tmp_path).cameras[0]
    assert isinstance(camera, Camera)
    assert camera.intrinsics[0, 0] == pytest.approx(525.0)


def write(name: str, text: str) -> Any:
    return lambda folder: (folder / name).write_text(text)


@pytest.mark.parametrize(
    ("spoil", "error", "message"),
    [
        (write("trajectory.log", ""), FileFormatError, "is empty"),
        (write("trajectory.log", log(1)), SceneError, "2 pictures for 1 poses in trajectory.log"),
        (write("trajectory.log", log(2)[:-40]), FileFormatError, "line 9 has 2 values, expected 4"),
        (write("trajectory.log", "\n".join(log(2).splitlines()[:8])), FileFormatError,
         "ends within pose 1: it is truncated"),
        (write("trajectory.log", log(2).replace("0 0 1\n", "0 0\n", 1)), FileFormatError,
         "line 1 has 2 values, expected 3"),
        (write("trajectory.log", log(2).replace("1.0", "nan", 1)), FileFormatError,
         "expected a finite number"),
        (lambda f: (f / "depth" / "2.png").unlink(), SceneError, "1 depth maps for 2 poses"),
        (lambda f: (f / "color").rename(f / "views"), MissingFileError, "no folder color or"),
        (write("camera_primesense.json", "{}"), SceneError, "has no 'intrinsic_matrix'"),
        (lambda f: (f / "camera_primesense.json").unlink(), MissingFileError,
         "the pictures are 16 x 12, not 640 x 480: add a camera file"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named(
    tmp_path: Path, spoil: Any, error: type[Exception], message: str
) -> None:
    spoil(scene(tmp_path))
    with pytest.raises(error, match=message):
        read_views(tmp_path)


def test_an_empty_folder_of_pictures_is_named(tmp_path: Path) -> None:
    scene(tmp_path)
    for path in (tmp_path / "color").iterdir():
        path.unlink()
    with pytest.raises(MissingFileError, match="holds no pictures"):
        read_views(tmp_path)
