from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from belvedere.ground.errors import FileFormatError, MissingFileError, OutputError, PathError
from belvedere.scene import Camera, CameraPath, CylinderCamera, Keyframe
from belvedere.scene.pose import pose_matrix
from tests.strategies import F8, numbers, planar_cameras, poses

few = settings(max_examples=40)  # a path of five keyframes is dear to build

K = np.array([[30.0, 0.0, 15.5], [0.0, 32.0, 11.5], [0.0, 0.0, 1.0]])


def camera_at(pose: F8, zoom: float = 1.0) -> Camera:
    return Camera.from_intrinsics(K * [[zoom], [zoom], [1.0]], pose, 32, 24)


def standing(x: float, y: float = 0.0) -> Camera:
    return camera_at(pose_matrix(np.eye(3), [x, y, 0.0]))


@st.composite
def camera_paths(draw: st.DrawFn, least: int = 1) -> CameraPath:
    count = draw(st.integers(least, 5))
    gaps = [draw(numbers(0.1, 3.0)) for _ in range(count)]
    cameras = [camera_at(draw(poses()), draw(numbers(0.5, 2.0))) for _ in range(count)]
    times = draw(numbers(-5.0, 5.0)) + np.cumsum(gaps) - gaps[0]
    period = float(sum(gaps)) if draw(st.booleans()) else None
    return CameraPath.of(cameras, times.tolist(), period)


def assert_same_camera(one: Camera, other: Camera, tolerance: float = 1e-9) -> None:
    np.testing.assert_allclose(one.matrix, other.matrix, atol=tolerance)
    np.testing.assert_allclose(one.center, other.center, atol=tolerance)
    assert one.size == other.size


# ---- laws ----------------------------------------------------------------------------------------


@few
@given(camera_paths())
def test_a_path_goes_through_its_keyframes(path: CameraPath) -> None:
    for key in path.keyframes:
        assert_same_camera(path.camera(key.time), key.camera)


@few
@given(camera_paths(least=2), numbers(0.0, 1.0))
def test_a_path_moves_without_jumps(path: CameraPath, share: float) -> None:
    time = path.start + share * path.duration * 0.999
    step = 1e-7 * path.duration
    here, there = path.cameras_at_times([time, time + step])
    # at most 3 chords a stretch of at least 0.1 s, chords up to 35 m: 1e3 m/s
    assert np.linalg.norm(here.center - there.center) < 1.1e3 * step
    assert np.abs(here.matrix - there.matrix).max() < 1e3 * step


@few
@given(camera_paths(least=2), st.integers(0, 4))
def test_velocity_does_not_jump_at_keyframes(path: CameraPath, which: int) -> None:
    key = path.keyframes[which % len(path.keyframes)]
    if not path.closed and key in (path.keyframes[0], path.keyframes[-1]):
        return
    h = 1e-6
    before, at, after = path.cameras_at_times([key.time - h, key.time, key.time + h])
    for name in ("center", "matrix"):
        left = (getattr(at, name) - getattr(before, name)) / h
        right = (getattr(after, name) - getattr(at, name)) / h
        # differences of O(acceleration * h): accelerations reach 6 * 35 m / (0.1 s)^2 = 2e4
        np.testing.assert_allclose(left, right, atol=0.2)


@few
@given(camera_paths(least=2), numbers(0.0, 1.0))
def test_a_path_never_strays_farther_than_its_stretch_is_long(
    path: CameraPath, share: float
) -> None:
    time = path.start + share * path.duration
    keys = [(key.time, key.camera.center) for key in path.keyframes]
    if path.period is not None:
        keys.append((path.start + path.period, keys[0][1]))
    index = min(int(np.searchsorted([t for t, _ in keys], time, side="right")), len(keys) - 1)
    (_, one), (_, other) = keys[index - 1], keys[index]
    chord = float(np.linalg.norm(one - other))
    here = path.camera(time).center
    nearest = min(np.linalg.norm(here - one), np.linalg.norm(here - other))
    assert nearest <= chord * (1 + 1e-9) + 1e-9


@few
@given(camera_paths(), poses())
def test_moving_the_world_moves_the_path(path: CameraPath, world: F8) -> None:
    moved = CameraPath(
        tuple(
            Keyframe(
                key.time,
                Camera.from_intrinsics(
                    key.camera.intrinsics, world @ key.camera.camera_to_world, 32, 24
                ),
            )
            for key in path.keyframes
        ),
        path.period,
    )
    for one, other in zip(path.cameras(7), moved.cameras(7), strict=True):
        expected = world @ one.camera_to_world
        if np.abs(other.camera_to_world - expected).max() > 1e-6:
            # half turns between neighbours may be taken either way round
            assert any(
                np.trace(a.camera.camera_to_world[:3, :3].T @ b.camera.camera_to_world[:3, :3])
                < -1 + 1e-6
                for a in path.keyframes
                for b in path.keyframes
            )


@given(planar_cameras(), st.integers(1, 5))
def test_one_keyframe_stands_still(camera: Camera, count: int) -> None:
    path = CameraPath.of([camera], [3.0])
    assert path.duration == 0
    assert path.cameras(count) == [camera] * count
    assert path.cameras_at(30) == [camera]
    assert path.camera(99.0) is camera
    looped = CameraPath.of([camera], [0.0], 2.0)
    assert looped.cameras_at(4) == [camera] * 8


def test_a_visitor_who_stops_stands_still() -> None:
    path = CameraPath.of([standing(0), standing(1), standing(1), standing(2)], [0, 1, 2, 3])
    for camera in path.cameras_at_times(np.linspace(1, 2, 11)):
        np.testing.assert_allclose(camera.center, [1, 0, 0], atol=1e-15)


def test_a_straight_walk_at_one_speed_stays_so() -> None:
    path = CameraPath.of([standing(x) for x in (0.0, 1.0, 3.0, 4.0)], [0, 1, 3, 4])
    for time in np.linspace(0, 4, 17):
        np.testing.assert_allclose(path.camera(time).center, [time, 0, 0], atol=1e-12)


def test_turning_at_one_speed_stays_so() -> None:
    def turned(angle: float) -> Camera:
        c, s = math.cos(angle), math.sin(angle)
        return camera_at(pose_matrix([[c, 0, s], [0, 1, 0], [-s, 0, c]], np.zeros(3)))

    path = CameraPath.of([turned(0.7 * t) for t in (0, 1, 3, 4)], [0, 1, 3, 4])
    for time in np.linspace(0, 4, 9):
        assert_same_camera(path.camera(time), turned(0.7 * time))


def test_zooming_is_even_to_the_eye() -> None:
    one = camera_at(np.eye(4))
    path = CameraPath.of([one, camera_at(np.eye(4), 4.0)], [0, 2])
    middle = path.camera(1.0).intrinsics
    np.testing.assert_allclose([middle[0, 0], middle[1, 1]], [60.0, 64.0])


def test_a_closed_path_comes_round_and_its_video_loops() -> None:
    square = [standing(0, 0), standing(1, 0), standing(1, 1), standing(0, 1)]
    path = CameraPath.of(square, [0, 1, 2, 3], period=4.0)
    assert path.closed
    assert path.duration == 4.0
    assert_same_camera(path.camera(5.5), path.camera(1.5))
    assert_same_camera(path.camera(-0.5), path.camera(3.5))
    cameras = path.cameras(8)
    gaps = [np.linalg.norm(a.center - b.center) for a, b in zip(cameras, cameras[1:] + cameras[:1],
                                                                strict=True)]  # fmt: skip
    np.testing.assert_allclose(gaps, gaps[0])  # the last gap, back to the start, like the others


def test_frames_are_counted_with_both_ends_on_an_open_path_and_one_on_a_closed_one() -> None:
    two = [standing(0), standing(1)]
    assert len(CameraPath.of(two, [0, 2]).cameras_at(30)) == 61
    assert len(CameraPath.of(two, [0, 1], 2.0).cameras_at(30)) == 60
    assert len(CameraPath.of(two, [0, 0.1]).cameras_at(30)) == 4
    open_path = CameraPath.of(two, [5, 7]).cameras(3)
    np.testing.assert_allclose([camera.center[0] for camera in open_path], [0, 0.5, 1])
    np.testing.assert_allclose(CameraPath.of(two, [5, 7]).cameras(1)[0].center, 0)


def test_a_resized_path_keeps_its_movement() -> None:
    path = CameraPath.of([standing(0), standing(1)], [0, 2])
    small = path.resized(16, 12)
    assert small.size == (12, 16)
    assert_same_camera(small.camera(0.7), path.camera(0.7).resized(16, 12))


# ---- refusals ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("times", "period", "message"),
    [
        ([0, 1, 1], None, r"keyframes\[2\].time is 1 s, the same as keyframes\[1\]: give them"),
        ([0, 2, 1], None, r"keyframes\[2\].time is 1 s, before the 2 s of keyframes\[1\]: sort"),
        ([0, math.nan, 1], None, r"keyframes\[1\].time is nan, expected a finite number"),
        ([0, 1], None, r"CameraPath.times has 2 times for 3 cameras"),
        ([0, 1, 2], 2.0, r"CameraPath.period is 2 s, expected more than the 2 s between"),
        ([0, 1, 2], math.nan, r"CameraPath.period is nan"),
    ],
)
def test_times_that_no_clock_shows_are_refused(
    times: list[float], period: float | None, message: str
) -> None:
    with pytest.raises(PathError, match=message):
        CameraPath.of([standing(0), standing(1), standing(2)], times, period)


def test_keyframes_that_do_not_fit_together_are_refused() -> None:
    with pytest.raises(PathError, match=r"CameraPath.keyframes is empty"):
        CameraPath(())
    with pytest.raises(PathError, match=r"keyframes\[1\].camera is 8 x 8 pixels, the first is 32"):
        CameraPath.of([standing(0), standing(1).resized(8, 8)], [0, 1])
    cylinder: Any = CylinderCamera((0, 0, 0), 32, 24)
    with pytest.raises(
        PathError, match=r"keyframes\[0\].camera is a CylinderCamera, expected a pl"
    ):
        CameraPath.of([cylinder], [0])
    with pytest.raises(PathError, match=r"keyframes\[0\] is a Camera, expected a Keyframe"):
        CameraPath((standing(0),))  # type: ignore[arg-type]


def test_moments_off_the_path_are_refused() -> None:
    path = CameraPath.of([standing(0), standing(1)], [0, 2])
    with pytest.raises(PathError, match=r"time 2.5 s is outside the path, which runs from 0 to 2"):
        path.camera(2.5)
    with pytest.raises(PathError, match=r"not a finite number of seconds"):
        path.camera(math.nan)
    with pytest.raises(PathError, match=r"CameraPath.fps is 0, expected"):
        path.cameras_at(0)
    with pytest.raises(PathError, match=r"expected at most 1000000"):
        path.cameras_at(1e9)
    with pytest.raises(PathError, match=r"CameraPath.count is 0, expected a whole number from 1"):
        path.cameras(0)


# ---- files ---------------------------------------------------------------------------------------


@few
@given(path=camera_paths())
def test_a_path_survives_the_round_trip_through_its_file(
    path: CameraPath, tmp_path_factory: pytest.TempPathFactory
) -> None:
    file = tmp_path_factory.mktemp("paths") / "path.json"
    path.save(file)
    again = CameraPath.load(file)
    assert again.period == path.period
    assert [key.time for key in again.keyframes] == [key.time for key in path.keyframes]
    for one, other in zip(again.keyframes, path.keyframes, strict=True):
        assert_same_camera(one.camera, other.camera, 1e-12)


def test_a_path_can_be_written_by_hand(tmp_path: Path) -> None:
    file = tmp_path / "walk.json"
    file.write_text(
        '{"belvedere_path": 1, "width": 64, "height": 48, "keyframes": ['
        '{"time": 0, "eye": [2, -3, 1.6], "target": [0, 0, 1]},'
        '{"time": 4, "eye": [2, 3, 1.6], "target": [0, 0, 1], "up": [0, 1, 1], "fov_deg": 40}]}'
    )
    path = CameraPath.load(file)
    assert (path.duration, path.closed, path.size) == (4.0, False, (48, 64))
    assert_same_camera(path.camera(0), Camera.look_at((2, -3, 1.6), (0, 0, 1), width=64, height=48))
    assert path.camera(4).fov == pytest.approx(math.radians(40))


def test_saving_does_not_overwrite_unless_allowed(tmp_path: Path) -> None:
    path, file = CameraPath.of([standing(0)], [0]), tmp_path / "path.json"
    path.save(file, force=False)
    with pytest.raises(OutputError):
        path.save(file, force=False)
    path.save(file)


GOOD: dict[str, Any] = {
    "belvedere_path": 1,
    "width": 64,
    "height": 48,
    "keyframes": [
        {"time": 0, "eye": [0, 0, 0], "target": [0, 1, 0]},
        {"time": 1, "eye": [1, 0, 0], "target": [1, 1, 0]},
    ],
}


def _with(key: str, value: Any, frame: int | None = None) -> dict[str, Any]:
    data = json.loads(json.dumps(GOOD))
    (data if frame is None else data["keyframes"][frame])[key] = value
    return data


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (_with("belvedere_path", 2), r"belvedere_path is 2, this program reads up to 1: use a new"),
        (_with("belvedere_path", None), r"has no 'belvedere_path': it is no camera path of ours"),
        (_with("speed", 3), r"has the unknown key 'speed', expected belvedere_path, width"),
        (_with("width", 0), r"width is 0, expected a whole number from 1"),
        (_with("width", None), r"has no 'width'"),
        (_with("keyframes", []), r"keyframes is \[\], expected a list of objects"),
        (_with("period", 0.5), r"period is 0.5 s, expected more than the 1 s"),
        (_with("time", 0, 1), r"keyframes\[1\].time is 0 s, the same as keyframes\[0\]"),
        (_with("time", -1, 1), r"keyframes\[1\].time is -1 s, before the 0 s of keyframes\[0\]"),
        (_with("time", "soon", 1), r'keyframes\[1\].time is "soon", expected a number'),
        (_with("eye", [0, 0], 1), r"keyframes\[1\].eye has shape \(2,\), expected \(3,\)"),
        (_with("eye", [1, 1, 0], 1), r"keyframes\[1\]: look_at.eye and look_at.target are the sa"),
        (_with("target", None, 0), r"keyframes\[0\] has no 'target'"),
        (_with("fov_deg", 200, 0), r"keyframes\[0\]: Camera.fov_deg is 200"),
        (_with("fovdeg", 60, 0), r"keyframes\[0\] has the unknown key 'fovdeg', expected time, ey"),
        (_with("camera_to_world", 1, 0), r"keyframes\[0\] has both 'eye' and 'camera_to_world'"),
    ],
)
def test_a_bad_path_file_is_refused_with_file_key_and_index(
    data: dict[str, Any], message: str, tmp_path: Path
) -> None:
    file = tmp_path / "walk.json"
    file.write_text(json.dumps(data))
    with pytest.raises(PathError, match=r"walk.json\b.*" + message):
        CameraPath.load(file)


def test_a_file_that_is_missing_or_no_json_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "walk.json"
    with pytest.raises(MissingFileError, match=r"walk.json"):
        CameraPath.load(file)
    file.write_text("")
    with pytest.raises(FileFormatError, match=r"walk.json: is empty"):
        CameraPath.load(file)
    file.write_text(json.dumps(GOOD)[:-9])
    with pytest.raises(FileFormatError, match=r"walk.json: ends too early"):
        CameraPath.load(file)
    file.write_text(json.dumps(GOOD).replace("48", "NaN"))
    with pytest.raises(FileFormatError, match=r"walk.json: height is NaN"):
        CameraPath.load(file)
