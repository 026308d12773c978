"""The TUM RGB-D layout: association, poses, and what can be wrong in its text files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from belvedere import Camera
from belvedere.ground.errors import (
    FileFormatError,
    MissingFileError,
    SceneError,
    UnsafePathError,
)
from belvedere.scene.io import read_tum, read_views, write_color, write_depth
from belvedere.scene.io.tum import associate


def scene(folder: Path, size: tuple[int, int] = (12, 16), calibration: bool = True) -> Path:
    """Three pictures a tenth of a second apart; depth 5 ms and poses 8 ms later."""
    for index in range(3):
        write_color(folder / "rgb" / f"{index}.png", np.full((*size, 3), index, np.uint8))
        write_depth(folder / "depth" / f"{index}.png", np.full(size, 5000, np.uint16))
    (folder / "rgb.txt").write_text(
        "# color\n" + "".join(f"{100 + 0.1 * i:.4f} rgb/{i}.png\n" for i in range(3))
    )
    (folder / "depth.txt").write_text(
        "".join(f"{100.005 + 0.1 * i:.4f} depth/{i}.png\n" for i in range(3))
    )
    # a quarter turn about x: the camera's forward (z) becomes -y of the world
    (folder / "groundtruth.txt").write_text(
        "".join(f"{100.008 + 0.1 * i:.4f} {i} 2 3 0.7071 0 0 0.7071\n" for i in range(3))
    )
    if calibration:
        (folder / "calibration.txt").write_text("20.0 21.0 7.5 5.5\n")
    return folder


def test_pictures_depth_and_poses_are_associated_and_scaled(tmp_path: Path) -> None:
    views = read_views(scene(tmp_path))
    assert views.names == ("0", "1", "2")
    assert np.unique(views[1].disparity).tolist() == [1.0]  # 5000 is a metre
    camera = views.cameras[1]
    assert isinstance(camera, Camera)
    np.testing.assert_allclose(camera.center, [1, 2, 3])
    np.testing.assert_allclose(camera.forward, [0, -1, 0], atol=1e-12)
    np.testing.assert_allclose(camera.intrinsics, [[20, 0, 7.5], [0, 21, 5.5], [0, 0, 1]])
    assert views.facts["intrinsics_from"] == "calibration.txt"


def test_the_benchmarks_default_serves_where_no_calibration_lies(tmp_path: Path) -> None:
    views = read_views(scene(tmp_path, (480, 640), calibration=False))
    camera = views.cameras[0]
    assert isinstance(camera, Camera)
    np.testing.assert_allclose(camera.intrinsics, [[525, 0, 319.5], [0, 525, 239.5], [0, 0, 1]])
    assert "default" in views.facts["intrinsics_from"]


def test_another_size_needs_a_calibration(tmp_path: Path) -> None:
    with pytest.raises(
        MissingFileError, match=r"no calibration\.txt, and the pictures are 16 x 12"
    ):
        read_views(scene(tmp_path, calibration=False))


def test_pictures_without_a_partner_are_left_out_and_counted(tmp_path: Path) -> None:
    scene(tmp_path)
    lines = (tmp_path / "groundtruth.txt").read_text().splitlines()
    (tmp_path / "groundtruth.txt").write_text("\n".join(lines[:2]))
    views = read_views(tmp_path)
    assert views.names == ("0", "1")
    assert views.facts["pictures_without_partner"] == 1
    assert len(read_tum(tmp_path, max_difference_s=0.2)) == 2  # each pose serves one picture
    with pytest.raises(SceneError, match=r"lies within 0\.001 s of a pose"):
        read_tum(tmp_path, max_difference_s=0.001)


def test_the_nearest_pairs_come_first_and_each_is_used_once() -> None:
    assert associate([0.0, 1.0], [0.9, 0.05], 2.0) == {0: 1, 1: 0}
    assert associate([0.0, 0.01], [0.012], 0.02) == {1: 0}
    assert associate([0.0], [0.03], 0.02) == {}
    assert associate([], [], 0.02) == {}


def test_association_agrees_with_trying_every_pair(rng: np.random.Generator) -> None:
    first, second = (np.sort(rng.uniform(0, 1, n)).tolist() for n in (40, 55))
    pairs = sorted(
        (abs(a - b), i, j)
        for i, a in enumerate(first) for j, b in enumerate(second) if abs(a - b) <= 0.02
    )  # fmt: skip
    want: dict[int, int] = {}
    for _, i, j in pairs:
        if i not in want and j not in want.values():
            want[i] = j
    assert associate(first, second, 0.02) == want


@pytest.mark.parametrize(
    ("file", "text", "error", "message"),
    [
        ("rgb.txt", "", FileFormatError, r"rgb\.txt: is empty"),
        ("rgb.txt", "# nothing\n", FileFormatError, "lists no files"),
        ("rgb.txt", "100.0\n", FileFormatError, r"rgb\.txt: line 1 is '100\.0', expected a time"),
        ("rgb.txt", "soon rgb/0.png\n", FileFormatError, "has 'soon', expected a number"),
        ("rgb.txt", "100.0 rgb/9.png\n", MissingFileError, r"rgb\.txt: line 1: no file"),
        ("rgb.txt", "100.0 ../0.png\n", UnsafePathError, r"rgb\.txt: line 1 leads out"),
        ("depth.txt", "100.0 /tmp/0.png\n", UnsafePathError, r"depth\.txt: line 1 is the absol"),
        ("groundtruth.txt", "100.0 1 2 3\n", FileFormatError, "has 4 values, expected 8"),
        ("groundtruth.txt", "100.0 1 2 nan 0 0 0 1\n", FileFormatError, "expected a finite num"),
        ("groundtruth.txt", "100.0 1 2 3 0 0 0 0\n", FileFormatError, "quaternion of length 0"),
        ("groundtruth.txt", "100.0 1 2 3 1 1 0 1\n", FileFormatError, "are its values in order"),
        ("groundtruth.txt", "# none\n", FileFormatError, "lists no poses"),
        ("calibration.txt", "20 21 7.5\n", FileFormatError, "has 3 values, expected 4"),
        ("calibration.txt", "0 21 7.5 5.5\n", SceneError, "fx is 0"),
        ("calibration.txt", "20 21 7.5 5.5 0.2 -0.9\n", SceneError, "line 1 has distortion"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(
    tmp_path: Path, file: str, text: str, error: Any, message: str
) -> None:
    scene(tmp_path)
    (tmp_path / file).write_text(text)
    with pytest.raises(error, match=message):
        read_views(tmp_path)
