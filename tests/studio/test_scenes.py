"""Scenes of every kind are opened, checked and saved by one name."""

from __future__ import annotations

import json
import shutil
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

import belvedere as bv
from belvedere.ground import InputError
from belvedere.scene.io import save_views
from belvedere.studio.scenes import ConventionWarning, open_scene, save_scene, scene_of
from tests.studio.tiny_scenes import row_of_views


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    save_views(row_of_views(5), tmp_path / "capture")
    return tmp_path / "capture"


def test_a_capture_with_depth_opens_as_depth_views_and_renders(capture: Path) -> None:
    scene = open_scene(capture, references=3, reconstruction="point")
    assert isinstance(scene, bv.DepthViews)
    assert isinstance(scene, bv.Scene)
    assert scene.affords.movement == "continuous"
    frame = scene.render(scene.home)
    assert frame.color.shape == (36, 48, 3)
    assert frame.hole_fraction < 0.01


def test_pictures_without_depth_open_as_photographs_to_hop_between(shared_data: Path) -> None:
    scene = open_scene(shared_data / "posed-castle-p19")
    assert isinstance(scene, bv.Photographs)
    assert scene.affords.movement == "discrete"
    assert scene.affords.geometry == "none"
    index = 4
    camera = scene.views.cameras[index]
    frame = scene.render(camera)
    assert np.nanmax(frame.disparity) == 0  # as if infinitely far, and it says so
    difference = frame.color.astype(float) - scene.views.color(index)
    assert np.abs(difference[frame.coverage > 0]).mean() < 4  # the filter's softening only


def test_choices_for_depth_are_refused_where_there_is_none(shared_data: Path) -> None:
    with pytest.raises(InputError, match="none of the 19 pictures has any"):
        open_scene(shared_data / "posed-castle-p19", reconstruction="mesh")


def test_a_wrong_convention_is_refused_before_any_file_is_read(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="depth_kind"):
        open_scene(tmp_path / "nothing", depth_kind="deep")


def test_an_unknown_choice_is_refused_by_name(capture: Path) -> None:
    with pytest.raises(InputError, match="no option 'sharpness'"):
        open_scene(capture, sharpness=3)


def test_a_scene_saved_and_opened_again_renders_the_same_bytes(
    capture: Path, tmp_path: Path
) -> None:
    scene = open_scene(capture)
    save_scene(scene, tmp_path / "again")
    again = open_scene(tmp_path / "again")
    for camera in scene.views.cameras[1:3]:  # type: ignore[attr-defined]
        ours, theirs = scene.render(camera), again.render(camera)
        np.testing.assert_array_equal(ours.color, theirs.color)
        np.testing.assert_array_equal(ours.disparity, theirs.disparity)


def test_what_has_no_file_format_is_not_saved(tmp_path: Path) -> None:
    from tests.studio.tiny_scenes import Painted

    with pytest.raises(InputError, match="Painted has no file format"):
        save_scene(Painted(), tmp_path / "scene")


def test_pictures_without_depth_are_left_out_of_depth_views() -> None:
    from belvedere.scene import ViewEntry, ViewSet

    views = row_of_views(3)
    first = views.entries[0]
    bare = ViewEntry(first.name, first.camera, False, first.load_color, None)
    scene = scene_of(ViewSet((bare, *views.entries[1:])))
    assert isinstance(scene, bv.DepthViews)
    assert len(scene.views) == 2


Plant = tuple[str, dict[str, object]]


def plant(source: Path, target: Path, mistake: str) -> dict[str, object]:
    """Copy an RGB-D capture to ``target`` as someone with a wrong convention would write it.

    Returns:
        The options that mend it, besides the scale of disparity.
    """
    data = json.loads((source / "cameras.json").read_text())
    k = np.array(data["K"])
    (target / "depth").mkdir(parents=True)
    shutil.copytree(source / "images", target / "images")
    v, u = np.mgrid[: data["height"], : data["width"]]
    x, y = (u - k[0, 2]) / k[0, 0], (v - k[1, 2]) / k[1, 1]
    for frame in data["frames"]:
        with Image.open(source / frame["depth"]) as image:
            depth = np.asarray(image).astype(np.float64)
        pose = np.array(frame["camera_to_world"])
        if mistake == "5000":
            depth *= 5
        elif mistake == "ray":
            depth *= np.sqrt(x * x + y * y + 1)
        elif mistake == "disparity":
            depth = np.divide(2e7, depth, out=np.zeros_like(depth), where=depth > 0)
        elif mistake == "world_to_camera":
            pose = np.linalg.inv(pose)
        elif mistake == "opengl":
            pose = pose @ np.diag([1, -1, -1, 1])
        stored: npt.NDArray[np.uint16] = np.rint(np.minimum(depth, 65535)).astype(np.uint16)
        Image.fromarray(stored).save(target / frame["depth"])
        frame["camera_to_world"] = pose.tolist()
    if mistake == "metres":
        data["depth_unit"] = "metres"
    if mistake == "half":
        k[:2, 2] += 0.5
        data["K"] = k.tolist()
    (target / "cameras.json").write_text(json.dumps(data))
    return {
        "true": {},
        "metres": {"depth_scale": 0.001},
        "5000": {"depth_scale": 0.0002},
        "ray": {"depth_kind": "ray"},
        "disparity": {"depth_kind": "disparity", "depth_scale": 5e-5},
        "world_to_camera": {"pose": "world_to_camera"},
        "opengl": {"axes": "opengl"},
        "half": {"pixel_centers": "half"},
    }[mistake]


@pytest.mark.slow
@pytest.mark.parametrize(
    "mistake",
    ["true", "metres", "5000", "ray", "disparity", "world_to_camera", "opengl", "half"],
)
def test_each_mistake_planted_in_a_real_capture_is_named_with_the_option_that_mends_it(
    shared_data: Path, tmp_path: Path, mistake: str
) -> None:
    remedy = plant(shared_data / "rgbd-hololens-office", tmp_path / "planted", mistake)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ConventionWarning)
        open_scene(tmp_path / "planted", check=True)
    told = [str(one.message) for one in caught if one.category is ConventionWarning]
    if mistake == "true":
        assert told == []
        return
    assert len(told) == 1
    assert "\n" not in told[0]
    for name, value in remedy.items():
        if isinstance(value, float):  # a fitted scale carries the capture's own noise
            said = float(told[0].split(f"{name}=")[1].split()[0].rstrip(",."))
            assert said == pytest.approx(value, rel=0.05)
        else:
            assert f"{name}={value!r}" in told[0]
    mended = open_scene(tmp_path / "planted", **remedy)  # type: ignore[arg-type]
    straight = open_scene(shared_data / "rgbd-hololens-office")
    # the file rounds rotations to 6 digits, so that inverting one twice costs some
    np.testing.assert_allclose(mended.home.center, straight.home.center, atol=1e-5)


@pytest.mark.parametrize("nothing", [None, 3, b"capture"])
def test_a_scene_that_is_no_path_is_refused(nothing: Any) -> None:
    with pytest.raises(InputError, match=r"open_scene\.path is .*, expected the name of a file or"):
        open_scene(nothing)
