"""Rectified pairs: disparity in pixels becomes 1/Z, and the two views agree."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from belvedere import Camera
from belvedere.ground.errors import FileFormatError, InputError, MissingFileError, SceneError
from belvedere.scene.io import read_stereo, read_views, write_color, write_depth

WIDTH, HEIGHT = 40, 20
CALIB = """cam0=[30.0 0 18.5; 0 30.0 9.5; 0 0 1]
cam1=[30.0 0 20.5; 0 30.0 9.5; 0 0 1]
doffs=2.0
baseline=100.0
width=40
height=20
ndisp=8
"""


def pair(folder: Path, calib: str | None = CALIB, right_disparity: bool = True) -> Path:
    """A wall 0.6 m away: d = f B / Z - doffs = 30 * 0.1 / 0.6 - 2 = 3 pixels."""
    for name in ("im0", "im1"):
        write_color(folder / f"{name}.png", np.zeros((HEIGHT, WIDTH, 3), np.uint8))
    disparity = np.full((HEIGHT, WIDTH), 3.0, np.float32)
    disparity[0, :2] = np.inf
    disparity[1, :2] = 0.0
    write_depth(folder / "disp0.pfm", disparity)
    if right_disparity:
        write_depth(folder / "disp1.pfm", disparity)
    if calib is not None:
        (folder / "calib.txt").write_text(calib)
    return folder


def test_depth_follows_from_focal_length_baseline_and_doffs(tmp_path: Path) -> None:
    views = read_views(pair(tmp_path))
    for view in views:
        np.testing.assert_allclose(1 / view.disparity[2:], 0.6, rtol=1e-6)
        assert np.isnan(view.disparity[:2, :2]).all()
    assert views.facts["baseline_m"] == pytest.approx(0.1)


def test_a_point_of_the_left_view_falls_d_pixels_to_the_left_in_the_right_one(
    tmp_path: Path,
) -> None:
    views = read_views(pair(tmp_path))
    left, right = views
    point = left.camera.unproject(20.0, 7.0, left.disparity[7, 20])
    u, v, delta = right.camera.project(point)
    assert u == pytest.approx(20.0 - 3.0, abs=1e-5)
    assert v == pytest.approx(7.0)
    assert delta == pytest.approx(1 / 0.6)


def test_the_pair_stands_upright_in_our_world(tmp_path: Path) -> None:
    left, right = read_views(pair(tmp_path)).cameras
    assert isinstance(left, Camera)
    np.testing.assert_allclose(left.forward, [0, 1, 0])
    np.testing.assert_allclose(right.center - left.center, [0.1, 0, 0])
    assert left.unproject(0, 0, 1.0)[2] > left.unproject(0, HEIGHT - 1, 1.0)[2]


def test_without_its_disparity_the_right_view_has_no_depth(tmp_path: Path) -> None:
    views = read_views(pair(tmp_path, right_disparity=False))
    assert [entry.has_depth for entry in views.entries] == [True, False]


def test_an_uncalibrated_pair_is_read_with_a_stated_assumption_or_given_numbers(
    tmp_path: Path,
) -> None:
    pair(tmp_path, calib=None)
    views = read_views(tmp_path)
    assert views.facts["focal_px"] == pytest.approx(WIDTH * 3740 / 1800)
    assert views.facts["baseline_m"] == 0.16
    assert "assumed" in views.facts["calibration_from"]
    views = read_stereo(tmp_path, focal_px=50.0, baseline=0.2)
    np.testing.assert_allclose(1 / views[0].disparity[2:], 50 * 0.2 / 3, rtol=1e-6)
    assert views.facts["calibration_from"] == "the caller"
    choices: tuple[dict[str, Any], ...] = ({"focal_px": 0.0}, {"baseline": -1.0})
    for wrong in choices:
        with pytest.raises(InputError, match=r"read_stereo\.(focal_px|baseline)"):
            read_stereo(tmp_path, **wrong)


def test_given_numbers_replace_those_of_the_file(tmp_path: Path) -> None:
    views = read_stereo(pair(tmp_path), focal_px=60.0)
    assert views.facts["focal_px"] == 60.0
    assert views.facts["baseline_m"] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("calib", "error", "message"),
    [
        ("", FileFormatError, "is empty"),
        ("hello\n", FileFormatError, r"calib\.txt: line 1 is 'hello', expected key=value"),
        (CALIB.replace("cam1", "camX"), FileFormatError, "has no 'cam1'"),
        (CALIB.replace("baseline=100.0", "baseline=0"), FileFormatError, "must be positive"),
        (CALIB.replace("[30.0 0 18.5", "[0 0 18.5"), FileFormatError, "must be positive"),
        (CALIB.replace("0 0 1]", "0 0]", 1), FileFormatError, "cam0 has 8 values, expected 9"),
        (CALIB.replace("doffs=2.0", "doffs=nan"), FileFormatError, "expected a finite number"),
        (CALIB.replace("width=40", "width=80"), SceneError, "width is 80, but the pictures have"),
    ],
)
def test_a_bad_calibration_is_named(tmp_path: Path, calib: str, error: Any, message: str) -> None:
    with pytest.raises(error, match=message):
        read_views(pair(tmp_path, calib))


def test_half_a_pair_is_no_pair(tmp_path: Path) -> None:
    pair(tmp_path)
    (tmp_path / "im1.png").unlink()
    with pytest.raises(MissingFileError, match="no rectified pair: expected im0"):
        read_stereo(tmp_path)
