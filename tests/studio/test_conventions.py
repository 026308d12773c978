"""Each mistake is planted as a wrong file or option would make it, and must be named."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy import ndimage

from belvedere.ground.errors import InputError
from belvedere.scene import CylinderCamera, ReferenceView
from belvedere.scene.conventions import Conventions, ray_lengths
from belvedere.scene.pose import OPENCV_FROM_OPENGL, invert_pose
from belvedere.studio.conventions import check_conventions, choose_views

Shot = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Colour (H, W, 3), K, camera to world, depth in metres (0 = none): our own conventions."""

MM = Conventions(0.001)
"""What every capture below is rightly read with, unless its files are planted wrong."""

CASES: dict[str, tuple[Conventions, Conventions, dict[str, str | float]]] = {
    # name: (how the files are written, how they are read, the options that mend it)
    "millimetres read as metres": (MM, Conventions(1.0), {"depth_scale": 0.001}),
    "fives read as millimetres": (Conventions(0.0002), MM, {"depth_scale": 0.0002}),
    "millimetres read as fives": (MM, Conventions(0.0002), {"depth_scale": 0.001}),
    "depth along the ray": (replace(MM, depth_kind="ray"), MM, {"depth_kind": "ray"}),
    "z read as along the ray": (MM, replace(MM, depth_kind="ray"), {"depth_kind": "z"}),
    "disparity": (
        Conventions(5e-5, "disparity"),
        MM,
        {"depth_kind": "disparity", "depth_scale": 5e-5},
    ),
    "world to camera": (
        replace(MM, pose="world_to_camera"), MM, {"pose": "world_to_camera"}
    ),
    "OpenGL axes": (replace(MM, axes="opengl"), MM, {"axes": "opengl"}),
    "OpenCV read as OpenGL": (MM, replace(MM, axes="opengl"), {"axes": "opencv"}),
    "half a pixel": (
        replace(MM, pixel_centers="half"), MM, {"pixel_centers": "half"}
    ),
    "half a pixel the other way": (
        MM, replace(MM, pixel_centers="half"), {"pixel_centers": "integer"}
    ),
}  # fmt: skip

PLAIN = [name for name in CASES if " read as along" not in name and "read as O" not in name]
"""Without the reversed twins, which the exact room covers."""

PAIRS: dict[str, tuple[Conventions, Conventions, dict[str, str | float]]] = {
    "scale and pose": (
        replace(MM, pose="world_to_camera"),
        Conventions(1.0),
        {"depth_scale": 0.001, "pose": "world_to_camera"},
    ),
    "pose and axes": (
        replace(MM, pose="world_to_camera", axes="opengl"),
        MM,
        {"pose": "world_to_camera", "axes": "opengl"},
    ),
}


def stored_and_read(
    shots: Sequence[Shot], files: Conventions, read: Conventions
) -> list[ReferenceView]:
    """The capture written to 16-bit files in one convention and read in another."""
    views = []
    for color, K, pose, depth in shots:
        height, width = depth.shape
        with np.errstate(divide="ignore"):
            stored = {
                "z": depth,
                "ray": depth * ray_lengths(K, width, height),
                "disparity": np.where(depth > 0, 1.0 / depth, 0.0),
            }[files.depth_kind]
        stored = np.rint(stored / (files.depth_scale or 1.0))
        assert stored.max() < 65536
        stored_pose = pose @ OPENCV_FROM_OPENGL if files.axes == "opengl" else pose
        if files.pose == "world_to_camera":
            stored_pose = invert_pose(stored_pose)
        shift = 0.5 if files.pixel_centers == "half" else 0.0
        stored_K = K + np.array([[0, 0, shift], [0, 0, shift], [0, 0, 0]])
        camera = read.read_camera(stored_K, stored_pose, width, height)
        disparity = read.read_disparity(stored.astype(np.uint16), camera)
        views.append(ReferenceView(camera, color, disparity))
    return views


def assert_mended(options: dict[str, str | float], expected: dict[str, str | float]) -> None:
    assert options.keys() == expected.keys()
    for key, value in expected.items():
        if isinstance(value, str):
            assert options[key] == value
        elif expected.get("depth_kind") == "disparity":  # fitted, and poses are a little off
            assert options[key] == pytest.approx(value, rel=0.04)
        else:
            assert options[key] == pytest.approx(value, rel=1e-6)


# ---- captures ------------------------------------------------------------------------------------


def read_png(path: Path) -> np.ndarray:
    from PIL import Image

    with Image.open(path) as image:
        return np.asarray(image)


@pytest.fixture(scope="module")
def office(shared_data: Path) -> list[Shot]:
    folder = shared_data / "rgbd-hololens-office"
    if not folder.is_dir():
        pytest.skip(f"no {folder.name} in the test data")
    listing = json.loads((folder / "cameras.json").read_text())
    return [
        (
            read_png(folder / frame["image"])[..., :3],
            np.array(listing["K"]),
            np.array(frame["camera_to_world"]),
            read_png(folder / frame["depth"]) * 0.001,
        )
        for frame in listing["frames"]
    ]


@pytest.fixture(scope="module")
def living_room(shared_data: Path) -> list[Shot]:
    folder = shared_data / "rgbd-icl-livingroom-synth"
    if not folder.is_dir():
        pytest.skip(f"no {folder.name} in the test data")
    K = np.array([[525.0, 0, 319.5], [0, 525.0, 239.5], [0, 0, 1]])
    rows = (folder / "trajectory.log").read_text().splitlines()
    return [
        (
            read_png(folder / f"color/{k:05d}.jpg"),
            K,
            np.array([[float(x) for x in row.split()] for row in rows[5 * k + 1 : 5 * k + 5]]),
            read_png(folder / f"depth/{k:05d}.png") * 0.001,
        )
        for k in range(5)
    ]


K_BOX = np.array([[300.0, 0, 157.3], [0, 300.0, 121.8], [0, 0, 1]])


def look(eye: npt.ArrayLike, forward: npt.ArrayLike, roll: float = 0.0) -> np.ndarray:
    ahead = np.asarray(forward, dtype=np.float64)
    ahead = ahead / np.linalg.norm(ahead)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    down = np.cross(ahead, right)
    pose = np.eye(4)
    c, s = np.cos(roll), np.sin(roll)
    pose[:3, :3] = np.column_stack([c * right + s * down, c * down - s * right, ahead])
    pose[:3, 3] = eye
    return pose


def walk(count: int) -> list[np.ndarray]:
    """A hand-held walk: steps, turns to the side, nods and rolls."""
    out = []
    for k in range(count):
        turn = 0.3 + 0.12 * k
        eye = [-0.8 + 0.12 * k, 0.4 * np.sin(0.7 * k), 0.2 * np.cos(0.9 * k)]
        ahead = [np.cos(turn), np.sin(turn), 0.25 * np.sin(1.1 * k)]
        out.append(look(eye, ahead, 0.15 * np.sin(1.3 * k)))
    return out


def box(poses: Sequence[np.ndarray], K: np.ndarray = K_BOX, contrast: float = 30.0) -> list[Shot]:
    """A 6 x 5 x 3 m room with printed walls, ray-traced from inside: exact depth and poses."""
    rng = np.random.default_rng(3)
    half = np.array([3.0, 2.5, 1.5])
    walls = []
    for _ in range(6):
        layers = [ndimage.gaussian_filter(rng.standard_normal((768, 768)), s, mode="wrap")
                  for s in (1.5, 4.0, 12.0)]  # fmt: skip
        walls.append(np.clip(128 + contrast * sum(x / x.std() for x in layers), 0, 255))
    width, height = 320, 240
    v, u = np.mgrid[0:height, 0:width].astype(np.float64)
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(K).T
    shots = []
    for pose in poses:
        ahead = rays @ pose[:3, :3].T + 1e-12
        reach = (np.sign(ahead) * half - pose[:3, 3]) / ahead
        axis, depth = reach.argmin(axis=-1), reach.min(axis=-1)
        points = pose[:3, 3] + ahead * depth[..., None]
        gray = np.zeros((height, width))
        for a in range(3):
            across = [k for k in range(3) if k != a]
            for side in (0, 1):
                here = (axis == a) & ((ahead[..., a] > 0) == bool(side))
                place = (points[here][:, across].T + 4.0) * 95.0
                gray[here] = ndimage.map_coordinates(walls[2 * a + side], place, order=1,
                                                     mode="wrap")  # fmt: skip
        shots.append((np.repeat(gray.astype(np.uint8)[..., None], 3, axis=2), K, pose, depth))
    return shots


@pytest.fixture(scope="module")
def blank_room() -> list[Shot]:
    return box(walk(8), contrast=0.0)


@pytest.fixture(scope="module")
def room() -> list[Shot]:
    return box(walk(8))


# ---- true data -----------------------------------------------------------------------------------


def test_a_true_office_capture_raises_no_alarm(office: list[Shot]) -> None:
    report = check_conventions(stored_and_read(office, MM, MM), MM)
    assert report.verdict == "agree", report.line
    assert report.options == {}
    assert report.agreement is not None
    assert report.agreement > 0.8  # 0.88 when written
    assert report.basis == "matches"


def test_a_true_living_room_raises_no_alarm(living_room: list[Shot]) -> None:
    report = check_conventions(stored_and_read(living_room, MM, MM), MM)
    assert report.verdict == "agree", report.line


def test_a_few_frames_of_the_office_raise_no_alarm(office: list[Shot]) -> None:
    for part in (office[3:8], office[::2], office[:2]):
        report = check_conventions(stored_and_read(part, MM, MM), MM)
        assert report.verdict == "agree", report.line


# ---- planted mistakes ----------------------------------------------------------------------------


@pytest.mark.parametrize("case", PLAIN)
def test_a_mistake_planted_in_the_office_is_named(office: list[Shot], case: str) -> None:
    files, read, expected = CASES[case]
    report = check_conventions(stored_and_read(office[:8], files, read), read)
    assert report.verdict == "mistake", report.line
    assert_mended(report.options, expected)


def test_millimetres_taken_as_metres_are_named_from_all_twenty_frames(office: list[Shot]) -> None:
    read = Conventions(1.0)
    report = check_conventions(stored_and_read(office, MM, read), read)
    assert report.cli == "--depth-scale 0.001"


@pytest.mark.parametrize("case", PLAIN)
def test_a_mistake_planted_in_the_living_room_is_named(living_room: list[Shot], case: str) -> None:
    files, read, expected = CASES[case]
    report = check_conventions(stored_and_read(living_room, files, read), read)
    assert report.verdict == "mistake", report.line
    assert_mended(report.options, expected)


@pytest.mark.parametrize("case", [*CASES, *PAIRS])
def test_a_mistake_planted_in_an_exact_room_is_named(room: list[Shot], case: str) -> None:
    files, read, expected = {**CASES, **PAIRS}[case]
    report = check_conventions(stored_and_read(room, files, read), read)
    assert report.verdict == "mistake", report.line
    assert_mended(report.options, expected)


@pytest.mark.parametrize("case", PAIRS)
def test_two_mistakes_at_once_are_both_named(office: list[Shot], case: str) -> None:
    files, read, expected = PAIRS[case]
    report = check_conventions(stored_and_read(office[:8], files, read), read)
    assert report.verdict == "mistake", report.line
    assert_mended(report.options, expected)


@pytest.mark.parametrize(
    "case", ["millimetres read as metres", "depth along the ray", "disparity", "world to camera"]
)
def test_blank_walls_are_judged_by_depth_alone(blank_room: list[Shot], case: str) -> None:
    files, read, expected = CASES[case]
    report = check_conventions(stored_and_read(blank_room, files, read), read)
    assert report.basis == "depth"
    assert report.verdict == "mistake", report.line
    assert_mended(report.options, expected)


def test_a_scale_without_a_name_is_estimated(room: list[Shot]) -> None:
    report = check_conventions(stored_and_read(room, Conventions(0.00137), MM), MM)
    assert report.options["depth_scale"] == pytest.approx(0.00137, rel=0.01)


# ---- the line and the report ---------------------------------------------------------------------


def test_the_line_says_what_to_pass(room: list[Shot]) -> None:
    read = Conventions(1.0)
    report = check_conventions(stored_and_read(room, MM, read), read)
    assert re.fullmatch(
        r"neighbouring views disagree \(0% of points match\); they would agree \(\d+%\) if depth "
        r"were in millimetres: pass depth_scale=0\.001",
        report.line,
    )
    assert report.cli == "--depth-scale 0.001"


def test_the_report_is_json_and_the_same_every_time(room: list[Shot]) -> None:
    views = stored_and_read(room[:4], MM, MM)
    first, second = (check_conventions(views, MM).as_dict() for _ in range(2))
    assert json.dumps(first) == json.dumps(second)
    assert first["hypotheses"][0]["changes"] == ()


def test_an_unconfirmed_half_pixel_is_said_to_rest_on_the_numbers(living_room: list[Shot]) -> None:
    files = replace(MM, pixel_centers="half")
    report = check_conventions(stored_and_read(living_room, files, MM), MM)
    assert "cx = 320.00 = 640 / 2" in report.line
    assert "too noisy to confirm or deny" in report.line


# ---- half a pixel --------------------------------------------------------------------------------


def test_a_principal_point_calibrated_to_a_fifth_of_a_pixel_is_no_alarm(room: list[Shot]) -> None:
    shift = np.array([[0, 0, -0.2], [0, 0, -0.2], [0, 0, 0]])  # towards the alarm
    shots = [(color, K + shift, pose, depth) for color, K, pose, depth in room]
    report = check_conventions(stored_and_read(shots, MM, MM), MM)
    assert report.verdict == "agree", report.line


def test_pictures_overrule_how_the_principal_point_is_written() -> None:
    K = np.array([[300.0, 0, 160.0], [0, 300.0, 120.0], [0, 0, 1]])  # true, though it looks "half"
    report = check_conventions(stored_and_read(box(walk(8), K), MM, MM), MM)
    assert report.pixel_centers is not None
    assert report.pixel_centers.written > 0 > report.pixel_centers.pictures
    assert report.verdict == "agree", report.line


# ---- what cannot be told -------------------------------------------------------------------------


def test_a_single_view_says_nothing(room: list[Shot]) -> None:
    report = check_conventions(stored_and_read(room[:1], MM, MM), MM)
    assert report.verdict == "cannot tell"
    assert "single view" in report.line


def test_views_that_share_nothing_say_nothing() -> None:
    shots = box([look([0, 0, 0], [1, 0, 0]), look([0, 0, 0], [-1, 0.1, 0])])
    for read in (MM, Conventions(1.0)):
        report = check_conventions(stored_and_read(shots, MM, read), read)
        assert report.verdict == "cannot tell"
        assert "no two views were found to show the same surfaces" in report.line
        assert report.options == {}


def test_a_camera_that_only_turns_cannot_tell_the_depth_scale() -> None:
    turns = [look([0, 0, 0], [np.cos(0.1 * k), np.sin(0.1 * k), 0.1 * np.sin(k)]) for k in range(5)]
    shots = box(turns)
    for read in (MM, Conventions(1.0)):
        report = check_conventions(stored_and_read(shots, MM, read), read)
        assert report.verdict == "cannot tell", report.line
        assert "at any depth scale" in report.line
    wrong = replace(MM, pose="world_to_camera")
    report = check_conventions(stored_and_read(shots, wrong, MM), MM)
    assert report.options == {"pose": "world_to_camera"}
    report = check_conventions(stored_and_read(shots, Conventions(5e-5, "disparity"), MM), MM)
    assert report.verdict == "cannot tell"
    assert "at which depth scale cannot be told" in report.line


def test_two_views_with_few_matches_leave_a_fine_difference_open(office: list[Shot]) -> None:
    files = replace(MM, depth_kind="ray")
    report = check_conventions(stored_and_read(office[:2], files, MM), MM)
    assert report.verdict == "cannot tell"
    assert "if depth were along the ray, but too few points" in report.line


def test_poses_of_another_scene_are_not_explained_away(room: list[Shot]) -> None:
    rng = np.random.default_rng(8)
    shots = [
        (color, K, look(rng.normal(size=3), rng.normal(size=3)), depth)
        for color, K, _, depth in room
    ]
    report = check_conventions(stored_and_read(shots, MM, MM), MM)
    assert report.verdict == "cannot tell"
    assert "none of the known mistakes explains it" in report.line


def test_two_remedies_that_do_equally_well_are_both_told() -> None:
    # A wall seen square on is as deep everywhere: disparity and depth differ by a scale only.
    shots = box([look([0, 0.1 * k, 0], [1, 0, 0]) for k in range(3)])
    read = Conventions(1.0)
    report = check_conventions(stored_and_read(shots, MM, read), read)
    assert report.verdict == "cannot tell"
    assert "more than one change would mend it" in report.line


def test_views_without_depth_say_nothing(room: list[Shot]) -> None:
    shots = [(color, K, pose, 0 * depth) for color, K, pose, depth in room[:3]]
    report = check_conventions(stored_and_read(shots, MM, MM), MM)
    assert report.verdict == "cannot tell"
    assert "fewer than two views have depth" in report.line


def test_cameras_that_are_not_planar_are_left_alone() -> None:
    camera = CylinderCamera((0, 0, 0), 64, 32)
    view = ReferenceView(
        camera,
        np.zeros((*camera.size, 3), np.uint8),
        np.ones(camera.size, np.float32),
    )
    report = check_conventions([view, view], MM)
    assert report.verdict == "cannot tell"
    assert "only planar cameras are checked" in report.line


def test_an_unknown_scale_is_refused(room: list[Shot]) -> None:
    with pytest.raises(InputError, match="depth_scale is None, expected metres per stored unit"):
        check_conventions(stored_and_read(room[:2], MM, MM), Conventions())


# ---- which views are loaded ----------------------------------------------------------------------


def test_few_views_are_loaded_of_a_long_capture() -> None:
    assert choose_views(20) == list(range(20))
    for count in (21, 30, 1000):
        chosen = choose_views(count)
        assert len(chosen) <= 20
        assert chosen[0] >= 0
        assert chosen[-1] < count
        assert 1 in np.diff(chosen)  # neighbours are among them
