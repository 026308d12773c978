"""cameras.json: the plain layout, and real captures in it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from belvedere import Camera
from belvedere.ground.errors import MissingFileError, SceneError, UnsafePathError
from belvedere.scene.io import read_views, write_color, write_depth

K = [[20.0, 0.0, 7.5], [0.0, 21.0, 5.5], [0.0, 0.0, 1.0]]
POSE = np.array([[1.0, 0, 0, 5], [0, 0, 1.0, 6], [0, -1.0, 0, 7], [0, 0, 0, 1]])


def scene(folder: Path, **changes: Any) -> dict[str, Any]:
    write_color(folder / "images" / "a.png", np.zeros((12, 16, 3), np.uint8))
    write_depth(folder / "depth" / "a.png", np.full((12, 16), 2000, np.uint16))
    frame = {"image": "images/a.png", "depth": "depth/a.png", "camera_to_world": POSE.tolist()}
    return {"width": 16, "height": 12, "K": K, "frames": [frame]} | changes


def save(folder: Path, root: dict[str, Any]) -> Path:
    (folder / "cameras.json").write_text(json.dumps(root))
    return folder


def test_its_conventions_are_ours(tmp_path: Path) -> None:
    views = read_views(save(tmp_path, scene(tmp_path)))
    camera = views.cameras[0]
    assert isinstance(camera, Camera)
    np.testing.assert_allclose(camera.intrinsics, K, atol=1e-12)
    np.testing.assert_allclose(camera.camera_to_world, POSE, atol=1e-12)
    assert np.unique(views[0].disparity).tolist() == [0.5]


def test_the_inverse_pose_may_be_given(tmp_path: Path) -> None:
    root = scene(tmp_path)
    root["frames"][0]["world_to_camera"] = np.linalg.inv(POSE).tolist()
    del root["frames"][0]["camera_to_world"]
    views = read_views(save(tmp_path / "", root))
    np.testing.assert_allclose(views.cameras[0].center, [5, 6, 7], atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "disparity"),
    [({"depth_unit": "millimetres (uint16 PNG), 0 = none"}, 0.5), ({"depth_unit": "mm"}, 0.5),
     ({"depth_unit": "Centimeters"}, 0.05), ({"depth_scale": 0.0002}, 2.5),
     ({"depth_unit": "metres"}, 0.0005), ({"depth_unit": "m"}, 0.0005)],
)  # fmt: skip
def test_the_depth_unit_is_read(tmp_path: Path, changes: dict[str, Any], disparity: float) -> None:
    views = read_views(save(tmp_path, scene(tmp_path, **changes)))
    np.testing.assert_allclose(views[0].disparity, disparity, rtol=1e-6)


def frame(**changes: Any) -> Any:
    return lambda root: root["frames"][0].update(changes)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        (lambda r: r.pop("K"), SceneError, "cameras.json has no 'K'"),
        (lambda r: r.update(K=[[1, 0, 0]] * 3), SceneError, r"frames\[0\]: .*K.*projection"),
        (lambda r: r.update(K=np.diag([0.0, 20, 1]).tolist()), SceneError, r"fx is 0"),
        (lambda r: r.update(depth_unit="furlongs"), SceneError, "depth_unit is 'furlongs'"),
        (lambda r: r.update(depth_scale=-1), SceneError, "depth_scale is -1"),
        (frame(image=None), SceneError, r"frames\[0\] has no 'image' \(or 'file'\)"),
        (frame(image="b.png"), MissingFileError, r"frames\[0\]\.image: no file 'b\.png'"),
        (frame(depth="../a.png"), UnsafePathError, r"frames\[0\]\.depth leads out"),
        (frame(camera_to_world=None), SceneError, "has no 'camera_to_world'"),
        (lambda r: r["frames"].append(dict(r["frames"][0])), SceneError,
         r"frames\[1\]: the name 'images/a\.png' is that of cameras\.json: frames\[0\] already"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_with_its_frame_and_key(
    tmp_path: Path, change: Any, error: type[Exception], message: str
) -> None:
    root = scene(tmp_path)
    change(root)
    with pytest.raises(error, match=message):
        read_views(save(tmp_path, root))


# ---- real captures -----------------------------------------------------------------------------


def agreement(views: Any, first: int, second: int) -> float:
    """Share of the first view's samples whose depth in the second agrees within 5 %."""
    a, b = views[first], views[second]
    v, u = np.nonzero(a.disparity > 0)
    points = a.camera.unproject(u, v, a.disparity[v, u])
    x, y, delta = b.camera.project(points)
    ok = (x > 0) & (y > 0) & (x < b.camera.width - 1) & (y < b.camera.height - 1)
    seen = b.disparity[np.rint(y[ok]).astype(int), np.rint(x[ok]).astype(int)]
    known = seen > 0
    return float(np.mean(np.abs(delta[ok][known] / seen[known] - 1) < 0.05))


def test_an_rgbd_capture_agrees_with_itself(shared_data: Path) -> None:
    views = read_views(shared_data / "rgbd-hololens-office")
    assert len(views) == 20
    assert views.has_depth
    assert views[0].color.shape == (360, 540, 3)
    assert agreement(views, 0, 1) > 0.95  # its collectors measured 0.977 or more


def test_photographs_with_a_camera_each_are_read(shared_data: Path) -> None:
    views = read_views(shared_data / "posed-castle-p19")
    assert len(views) == 19
    assert not views.has_depth
    assert views.color(3).shape == (512, 768, 3)


def test_open3ds_layout_agrees_with_itself(shared_data: Path) -> None:
    views = read_views(shared_data / "rgbd-icl-livingroom-synth")
    assert views.facts["format"] == "redwood"
    assert views.names == ("00000", "00001", "00002", "00003", "00004")
    assert agreement(views, 0, 4) > 0.95  # its collectors measured 0.977


def test_a_stereo_pair_agrees_with_itself(shared_data: Path) -> None:
    views = read_views(shared_data / "stereo-middlebury-cones")
    assert views.names == ("left", "right")
    assert views.has_depth
    assert "assumed" in views.facts["calibration_from"]
    assert agreement(views, 0, 1) > 0.75  # a quarter is hidden from the other eye
    assert agreement(views, 1, 0) > 0.75
