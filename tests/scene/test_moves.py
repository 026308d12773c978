from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from belvedere.ground.errors import PathError
from belvedere.scene import (
    Camera,
    CameraPath,
    CylinderCamera,
    OrthographicCamera,
    SphereCamera,
    dolly,
    orbit,
    through,
    wobble,
)
from belvedere.scene.moves import planar_like
from tests.strategies import F8

NORTH = Camera.look_at((0, 0, 0), (0, 1, 0), width=64, height=48)


def centers(cameras: list[Camera]) -> F8:
    return np.stack([camera.center for camera in cameras])


def ring(count: int, radius: float = 5.0, share: float = 1.0) -> list[Camera]:
    angles = 2 * math.pi * share * np.arange(count) / count
    eyes = radius * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    return [Camera.look_at(eye, (0, 0, 0), width=64, height=48) for eye in eyes]


def walk(count: int = 20) -> list[Camera]:
    """Round a corner, as people walk, a little unsteadily."""
    rng = np.random.default_rng(5)
    angle = np.linspace(0, math.pi / 2, count)
    eyes = 4 * np.stack([np.sin(angle), 1 - np.cos(angle), 0 * angle], axis=1)
    eyes += rng.normal(0, 0.02, eyes.shape)
    ahead = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    return [Camera.look_at(e, e + a, width=64, height=48) for e, a in zip(eyes, ahead, strict=True)]


# ---- orbit, dolly, through -----------------------------------------------------------------------


def test_an_orbit_keeps_its_distance_and_looks_at_its_target() -> None:
    path = orbit((1, 2, 3), 4.0, rise=3.0, duration=8, width=64, height=48)
    assert (path.closed, path.duration, path.size) == (True, 8.0, (48, 64))
    for camera in path.cameras(50):
        distance = np.linalg.norm(camera.center - [1, 2, 3])
        assert distance == pytest.approx(5.0, rel=1e-4)
        u, v, _ = camera.project((1.0, 2.0, 3.0))
        assert (float(u), float(v)) == pytest.approx((31.5, 23.5), abs=0.05)


def test_an_orbit_starts_south_and_goes_counter_clockwise() -> None:
    path = orbit((0, 0, 0), 1.0, duration=4)
    np.testing.assert_allclose(path.camera(0).center, [0, -1, 0], atol=1e-12)
    np.testing.assert_allclose(path.camera(1).center, [1, 0, 0], atol=1e-12)
    half = orbit((0, 0, 0), 1.0, turns=-0.5, duration=4)
    assert not half.closed
    np.testing.assert_allclose(half.camera(2).center, [-1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(half.camera(4).center, [0, 1, 0], atol=1e-12)


def test_a_dolly_goes_from_start_to_end_and_eases() -> None:
    end = Camera.look_at((2, 0, 0), (2, 1, 0.5), fov_deg=40, width=32, height=24)
    for ease, quarter in ((True, 2 * 0.15625), (False, 0.5)):
        path = dolly(NORTH, end, 4.0, ease=ease)
        np.testing.assert_allclose(path.camera(0).matrix, NORTH.matrix, atol=1e-12)
        last = path.camera(4)
        np.testing.assert_allclose(last.center, end.center, atol=1e-12)
        assert last.fov == pytest.approx(end.fov)
        assert last.size == NORTH.size
        np.testing.assert_allclose(path.camera(1).center, [quarter, 0, 0], atol=1e-9)
        np.testing.assert_allclose(path.camera(2).center, [1, 0, 0], atol=1e-9)


def test_a_path_through_cameras_meets_each_at_an_even_pace() -> None:
    cameras = [NORTH.moved((x, 0, 0)) for x in (0, 1, 2, 6)]
    path = through(cameras, 6.0)
    for key, camera in zip(path.keyframes, cameras, strict=True):
        np.testing.assert_allclose(key.camera.center, camera.center)
    times = [key.time for key in path.keyframes]
    np.testing.assert_allclose(times, [0, 1, 2, 6], atol=0.06)
    assert through(cameras, 6.0, closed=True).closed


def test_a_path_goes_through_cameras_twice_in_one_place_and_of_other_sizes() -> None:
    path = through([NORTH, NORTH, NORTH.resized(32, 24), NORTH.moved((1, 0, 0))])
    assert path.size == NORTH.size
    assert path.duration == 4.0
    assert through([NORTH, NORTH], 3.0).duration == 3.0
    assert through([NORTH], 3.0).cameras_at(10) == [NORTH] * 30


@pytest.mark.parametrize(
    "camera",
    [
        CylinderCamera.at((1, 2, 3), (0, 1, 0), width=64, height=48),
        SphereCamera.at((1, 2, 3), (0, 1, 0), width=96),
        OrthographicCamera.along((0, 1, 0), (1, 2, 3), view_height=2, width=64, height=48),
    ],
    ids=["cylinder", "sphere", "orthographic"],
)
def test_cameras_of_other_kinds_lend_their_place_and_direction(camera: Any) -> None:
    planar = planar_like(camera)
    np.testing.assert_allclose(planar.forward, [0, 1, 0], atol=1e-6)
    np.testing.assert_allclose(planar.center, [1, 2, 3])
    np.testing.assert_allclose(planar.camera_to_world[:3, 1], [0, 0, -1], atol=1e-6)
    assert planar.size == (48, 64)
    assert isinstance(wobble([camera]), CameraPath)
    assert planar_like(NORTH) is NORTH


# ---- wobble --------------------------------------------------------------------------------------


SETS = {
    "one view": [NORTH],
    "one view twice": [NORTH, NORTH],
    "stereo pair": [NORTH, NORTH.moved((0.16, 0, 0))],
    "stereo pair upright": [NORTH, NORTH.moved((0, 0, 0.16))],
    "two views in line": [NORTH, NORTH.moved((0, 0.5, 0))],
    "two views back to back": [NORTH, Camera.look_at((0, 0, 0), (0, -1, 0), width=64, height=48)],
    "slide": [NORTH.moved((0.1 * i, 0, 0)) for i in range(20)],
    "corridor": [NORTH.moved((0, 0.3 * i, 0)) for i in range(20)],
    "grid": [NORTH.moved((0.1 * i, 0, 0.1 * j)) for j in range(5) for i in range(5)],
    "walk": walk(),
    "ring": ring(16),
    "half ring": ring(10, share=0.5),
    "shuffled ring": [ring(16)[i] for i in np.random.default_rng(3).permutation(16)],
    "turn on the spot": [
        Camera.look_at((0, 0, 0), (math.cos(a), math.sin(a), 0), width=64, height=48)
        for a in np.linspace(0, 2, 9)
    ],
}


@pytest.mark.parametrize("name", SETS)
def test_a_wobble_is_a_smooth_loop_within_the_references_spread(name: str) -> None:
    references = SETS[name]
    path = wobble(references, distance=3.0)
    assert path.closed
    assert path.size == NORTH.size
    cameras = path.cameras(200)
    places, seen = centers(cameras), centers(references)
    middle = seen.mean(axis=0)
    spread = float(np.linalg.norm(seen - middle, axis=1).max())
    strayed = float(np.linalg.norm(places - middle, axis=1).max())
    sway = 0.03 * 3.0 * (1 + 1e-3) if spread == 0 else 0.0
    assert strayed <= max(spread, sway) + 1e-12
    # no frame is far from the next one, the last and the first included
    step = np.linalg.norm(places - np.roll(places, -1, axis=0), axis=1)
    assert step.max() <= 4.0 * step.mean() + 1e-12
    ahead = np.stack([camera.forward for camera in cameras])
    turn = np.degrees(np.arccos(np.clip((ahead * np.roll(ahead, -1, axis=0)).sum(axis=1), -1, 1)))
    assert turn.max() < 8
    # and nobody is turned upside down
    assert all(camera.camera_to_world[2, 1] < 0 for camera in cameras)


@pytest.mark.parametrize("name", ["walk", "ring", "half ring", "corridor", "shuffled ring"])
def test_a_wobble_along_a_way_keeps_to_the_way_and_covers_it(name: str) -> None:
    references = SETS[name]
    places, seen = centers(wobble(references).cameras(300)), centers(references)
    gaps = np.linalg.norm(places[:, None] - seen, axis=2)
    neighbour = np.sort(np.linalg.norm(seen[:, None] - seen, axis=2), axis=1)[:, 1].max()
    assert gaps.min(axis=1).max() < 0.75 * neighbour
    assert gaps.min(axis=0).max() < 0.75 * neighbour


@pytest.mark.parametrize("name", ["walk", "ring", "half ring", "stereo pair", "grid", "one view"])
def test_a_wobble_looks_where_the_nearest_reference_looks(name: str) -> None:
    references = SETS[name]
    seen = centers(references)
    for camera in wobble(references).cameras(100):
        nearest = references[int(np.argmin(np.linalg.norm(seen - camera.center, axis=1)))]
        assert camera.forward @ nearest.forward > math.cos(math.radians(15))


def test_a_wobble_about_converging_views_keeps_its_eye_on_their_subject() -> None:
    references = ring(24, share=0.4)[:4]
    for camera in wobble(references).cameras(50):
        u, v, _ = camera.project((0.0, 0.0, 0.0))
        assert (float(u), float(v)) == pytest.approx((31.5, 23.5), abs=0.1)


def test_a_wobble_about_one_view_turns_about_what_it_shows() -> None:
    for camera in wobble([NORTH], distance=5.0).cameras(50):
        assert np.linalg.norm(camera.center) == pytest.approx(0.15, rel=1e-3)
        u, v, _ = camera.project((0.0, 5.0, 0.0))
        assert (float(u), float(v)) == pytest.approx((31.5, 23.5), abs=0.01)


def test_a_wobble_about_a_stereo_pair_moves_between_its_eyes() -> None:
    places = centers(wobble(SETS["stereo pair"]).cameras(100))
    assert places[:, 0].min() == pytest.approx(0.016, abs=1e-3)
    assert places[:, 0].max() == pytest.approx(0.144, abs=1e-3)
    assert np.abs(places[:, 1]).max() < 1e-12
    assert 0.001 < np.abs(places[:, 2]).max() < 0.02


def test_a_ring_that_closes_is_gone_round() -> None:
    path = wobble(SETS["ring"])
    angles = np.unwrap([math.atan2(c.center[1], c.center[0]) for c in path.cameras(100)])
    assert abs(angles[-1] - angles[0]) > 1.9 * math.pi


def test_a_rig_that_hung_upside_down_shows_no_such_video() -> None:
    references = ring(16)
    over = np.diag([-1.0, -1.0, 1.0, 1.0])
    for index in (3, 4, 9):
        camera = references[index]
        references[index] = Camera.from_intrinsics(
            camera.intrinsics, camera.camera_to_world @ over, 64, 48
        )
    assert all(camera.camera_to_world[2, 1] < 0 for camera in wobble(references).cameras(100))


def test_a_wobble_of_a_long_capture_is_quick_and_small() -> None:
    references = [NORTH.moved((0, 0.01 * i, 0)) for i in range(1200)]
    path = wobble(references)
    assert len(path.keyframes) <= 4 * 400
    assert path.duration == 60.0
    path = wobble(references, 7.5, keys=50)
    assert (len(path.keyframes), path.duration) == (50, 7.5)


# ---- refusals ------------------------------------------------------------------------------------


def test_moves_that_cannot_be_are_refused() -> None:
    not_a_camera: Any = np.eye(4)
    cylinder: Any = CylinderCamera((0, 0, 0), 8, 4)
    for move, message in (
        (lambda: orbit((0, 0, 0), 0.0), r"orbit.radius is 0, expected"),
        (lambda: orbit((0, 0), 1.0), r"orbit.target has shape \(2,\)"),
        (lambda: orbit((0, 0, math.nan), 1.0), r"orbit.target\[2\] is nan"),
        (lambda: orbit((0, 0, 0), 1.0, turns=0), r"orbit.turns is 0"),
        (lambda: orbit((0, 0, 0), 1.0, duration=-1), r"orbit.duration is -1"),
        (lambda: dolly(NORTH, cylinder), r"dolly.end is a CylinderCamera, expected a planar"),
        (lambda: dolly(NORTH, NORTH, 0.0), r"dolly.duration is 0"),
        (lambda: through([]), r"through.cameras is empty"),
        (lambda: through([NORTH, not_a_camera]), r"through.cameras\[1\] is a ndarray"),
        (lambda: through([NORTH], math.inf), r"through.duration is inf"),
        (lambda: wobble([]), r"wobble.cameras is empty"),
        (lambda: wobble([NORTH], distance=0.0), r"wobble.distance is 0"),
        (lambda: wobble([NORTH], keys=3), r"wobble.keys is 3, expected a whole number from 8"),
    ):
        with pytest.raises(PathError, match=message):
            move()
