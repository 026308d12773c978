from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

from belvedere.ground.errors import FileFormatError, InputError, MissingFileError, SceneError
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough import Body, FreeSpace
from tests.walkthrough import plans

EYE = 1.6


@pytest.fixture(scope="module")
def rooms() -> FreeSpace:
    return FreeSpace.of_mesh(plans.two_rooms())


@pytest.fixture(scope="module")
def house() -> FreeSpace:
    return FreeSpace.of_mesh(plans.two_storeys())


def go(space: FreeSpace, start: np.ndarray, goal: tuple[float, float], stride: float = 0.02):
    """Straight towards a goal, as long as that leads anywhere; all positions."""
    path = [start]
    for _ in range(2000):
        way = np.array(goal) - path[-1][:2]
        length = float(np.hypot(*way))
        if length < stride:
            break
        path.append(space.walk(path[-1], way / length * min(stride, length)))
        if np.linalg.norm(path[-1] - path[-2]) < 1e-6:
            break
    return np.array(path)


def test_a_wall_stops_the_visitor_at_arm_s_length(rooms: FreeSpace) -> None:
    end = rooms.walk((2.0, 3.0, EYE), (10.0, 0.0))
    surface = 4.0 - 0.075
    assert surface - 0.25 - 0.06 < end[0] <= surface - 0.25 + 1e-6
    assert end[1] == pytest.approx(3.0, abs=0.03)
    assert end[2] == pytest.approx(EYE, abs=0.02)


def test_he_slides_along_it(rooms: FreeSpace) -> None:
    end = rooms.walk((3.0, 0.6, EYE), (1.5, 0.5))
    assert 3.6 < end[0] < 3.7
    assert end[1] > 0.9


def test_he_passes_the_door_and_no_wall(rooms: FreeSpace) -> None:
    assert rooms.walk((2.0, 1.95, EYE), (4.0, 0.0))[0] == pytest.approx(6.0, abs=0.02)
    path = go(rooms, np.array([2.0, 3.5, EYE]), (6.0, 3.5))
    assert path[:, 0].max() < 4.0


@pytest.mark.parametrize("pieces", [2, 7, 50, 400])
def test_how_often_frames_come_does_not_matter(rooms: FreeSpace, pieces: int) -> None:
    step = np.array([2.2, -1.4])
    once = rooms.walk((2.4, 2.6, EYE), step)
    at = np.array([2.4, 2.6, EYE])
    for _ in range(pieces):
        at = rooms.walk(at, step / pieces)
    np.testing.assert_allclose(at, once, atol=0.03)


def test_nowhere_does_a_random_walk_come_too_near(
    rooms: FreeSpace, rng: np.random.Generator
) -> None:
    at = rooms.place((2.0, 2.0, EYE))
    for _ in range(3000):
        at = rooms.walk(at, rng.normal(0.0, 0.15, 2))
        assert rooms.clearance(at) > 0.24
        assert -0.0 < at[0] < 7.0
        assert 0.0 < at[1] < 4.0


def test_stairs_are_climbed_up_and_down_smoothly(house: FreeSpace) -> None:
    start = house.place((0.8, 4.45, EYE))
    up = go(house, start, (6.2, 4.45))
    assert up[-1][2] == pytest.approx(2.8 + EYE, abs=0.05)
    assert np.abs(np.diff(up[:, 2])).max() < 0.03  # no jolt at a step: 2 cm on, 3 cm up at most
    down = go(house, up[-1], (0.8, 4.45))
    assert down[-1][2] == pytest.approx(EYE, abs=0.05)


def test_nobody_falls_down_the_stairwell(house: FreeSpace) -> None:
    above = house.place((3.0, 3.2, 2.8 + EYE))
    assert above[2] == pytest.approx(2.8 + EYE, abs=0.02)
    path = go(house, above, (3.0, 4.6))
    assert path[:, 2].min() > 2.7 + EYE
    assert path[-1][1] < 3.9


def test_storeys_are_told_apart_by_the_eye_s_height(house: FreeSpace) -> None:
    for level in (0.0, 2.8):
        at = house.place((5.0, 1.2, level + EYE))
        assert at[2] == pytest.approx(level + EYE, abs=0.02)
        assert house.standable(at)
    assert not house.standable((5.0, 1.2, 9.0))
    assert house.clearance((50.0, 1.2, 1.6)) == 0.0


def test_a_lost_visitor_is_put_on_the_nearest_floor(rooms: FreeSpace) -> None:
    at = rooms.walk((4.0, 3.5, EYE), (0.0, 0.0))  # inside the wall
    assert rooms.clearance(at) >= 0.24
    assert np.hypot(at[0] - 4.0, at[1] - 3.5) < 0.6


def test_furniture_and_low_beams_stand_in_the_way() -> None:
    space = FreeSpace.of_mesh(plans.flat())
    assert not space.standable((1.0, 3.0, EYE))  # in the bed
    assert space.clearance((3.5, 1.9, EYE)) < 0.5 - 0.04  # 0.5 m from the table top's edge
    low = Mesh.concatenate([plans.two_rooms(), plans.box((1.5, -0.1, 1.7), (1.8, 4.1, 2.0))])
    assert FreeSpace.of_mesh(low).walk((0.8, 2.0, EYE), (2.0, 0.0))[0] < 1.5
    assert FreeSpace.of_mesh(low, Body(head=1.6, eye=1.5)).walk((0.8, 2, 1.5), (2, 0))[0] > 2.7


def test_it_comes_back_from_a_file(house: FreeSpace, tmp_path: Path) -> None:
    file = tmp_path / "free.npz"
    house.save(file)
    again = FreeSpace.load(file)
    assert again.body == house.body
    step = house.walk((2.0, 1.0, EYE), (1.0, 0.3))
    np.testing.assert_array_equal(again.walk((2.0, 1.0, EYE), (1.0, 0.3)), step)


def test_files_that_are_none_are_refused(house: FreeSpace, tmp_path: Path) -> None:
    file = tmp_path / "free.npz"
    with pytest.raises(MissingFileError, match="no such file"):
        FreeSpace.load(file)
    house.save(file)
    whole = file.read_bytes()
    for content in (b"", b"no zip", whole[: len(whole) // 2]):
        file.write_bytes(content)
        with pytest.raises(FileFormatError, match=r"free\.npz"):
            FreeSpace.load(file)
    with np.load(io.BytesIO(whole)) as d:
        parts = {name: d[name] for name in d.files}
    for name, value in (
        ("link", parts["link"] + 7), ("far", parts["far"][:-1]), ("version", np.int64(99)),
        ("column", parts["column"][::-1]), ("body", np.array([0.25, np.nan, 0.2, 1.6])),
    ):  # fmt: skip
        np.savez(file, **{**parts, name: value})
        with pytest.raises(FileFormatError, match=r"free\.npz"):
            FreeSpace.load(file)


def test_bad_steps_and_bodies_are_refused(rooms: FreeSpace) -> None:
    with pytest.raises(InputError, match="expected a finite number"):
        rooms.walk((1.0, 1.0, np.nan), (1.0, 0.0))
    with pytest.raises(InputError, match=r"step has shape \(1,\)"):
        rooms.walk((1.0, 1.0, EYE), (1.0,))
    with pytest.raises(InputError, match="over 100 m"):
        rooms.walk((1.0, 1.0, EYE), (1e9, 0.0))
    with pytest.raises(InputError, match=r"expected \(3,\)"):
        rooms.place((1.0, 1.0))
    with pytest.raises(InputError, match=r"Body\.radius"):
        Body(radius=-1.0)
    with pytest.raises(InputError, match="above its head"):
        Body(head=1.5)


def test_without_a_floor_there_is_nowhere_to_stand() -> None:
    walls = Mesh.concatenate(plans.wall((0, 0), (4, 0), thickness=0.02))
    with pytest.raises(SceneError, match="no floor"):
        FreeSpace.of_mesh(walls)


def test_a_hundred_million_metres_away_he_walks_the_same() -> None:
    shift = np.array([1e8, -1e8, 1e5])
    near = FreeSpace.of_mesh(plans.two_rooms())
    far = FreeSpace.of_mesh(plans.moved(plans.two_rooms(), 0.0, tuple(shift)))
    one = near.walk((2.0, 1.95, EYE), (1.5, 0.4))
    two = far.walk(np.array([2.0, 1.95, EYE]) + shift, (1.5, 0.4))
    np.testing.assert_allclose(two - shift, one, atol=1e-3)
