"""The stations stand as they say, and what a reference truly saw is what geometry says."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from belvedere.ground.errors import InputError
from belvedere.model import RayCaster
from belvedere.scene import Camera
from belvedere.scene.mesh import Material, Mesh
from belvedere.studio import _bench_stations
from belvedere.studio._bench_stations import (
    HELD_OUT_PLACES,
    PLACES,
    Place,
    Station,
    make_stations,
    station_cameras,
    truly_seen,
)
from belvedere.warp import warp

SIZE = 64


@pytest.fixture(scope="module")
def stations() -> list[Station]:
    return make_stations(SIZE)


def boards(*corners: list[list[float]]) -> Any:
    """Rectangles in space that rays can meet."""
    vertices = np.array(corners, float).reshape(-1, 3)
    first = 4 * np.arange(len(corners))[:, None, None]
    faces = (first + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3).astype(np.int32)
    plain = np.zeros(len(faces), np.int32), np.zeros((len(faces), 3, 2), np.float32)
    mesh = Mesh(vertices, faces, *plain, (Material("wood"),))
    return SimpleNamespace(mesh=mesh, caster=RayCaster(mesh))


def upright(x: float, y0: float, y1: float) -> list[list[float]]:
    """A board across the x axis, 10 metres high."""
    return [[x, y0, -5], [x, y1, -5], [x, y1, 5], [x, y0, 5]]


def looking_along_x(y: float = 0.0) -> Camera:
    return Camera.look_at((0, y, 0), (1, y, 0), fov_deg=60, width=32, height=32)


@pytest.mark.parametrize("place", [*PLACES, *HELD_OUT_PLACES], ids=lambda place: place.name)
def test_references_stand_round_the_desired_eye_the_nearest_first(place: Place) -> None:
    desired, others = station_cameras(place, SIZE)
    offsets = np.array([one.center - desired.center for one in others])
    away = np.linalg.norm(offsets, axis=1)
    assert (np.diff(away) > 0).all()
    assert (away[:2] >= 0.25).all()
    assert (away[:2] <= 0.45).all()
    assert (away[2:] >= 0.4).all()
    assert (away[2:] <= 0.8).all()
    assert offsets[0] @ offsets[1] < 0  # on either side
    turns = [np.degrees(np.arccos(one.forward @ desired.forward)) for one in others]
    assert 0.5 < min(turns) < max(turns) < 15


def test_stations_are_photographed_whole(stations: list[Station]) -> None:
    assert len(stations) == 3
    for station in stations:
        assert station.color.shape == (SIZE, SIZE, 3)
        assert len(station.views(5)) == 5
        assert station.views(2) == station.references[:2]
        assert np.isfinite(station.disparity).all()
        shares = [station.seen(n).mean() for n in (1, 2, 5)]
        assert 0.6 < shares[0] < shares[1] < shares[2] < 1


def test_more_references_than_there_are_are_refused(stations: list[Station]) -> None:
    with pytest.raises(InputError, match=r"Station\.count is 6"):
        stations[0].views(6)
    with pytest.raises(InputError, match="count"):
        stations[0].seen(0)


def test_what_a_reference_saw_is_where_its_samples_land(stations: list[Station]) -> None:
    for station in stations:
        frame = warp(station.references[0], station.camera, reconstruction="mesh")
        covered, seen = frame.coverage > 0, station.seen(1)
        assert np.mean(covered[seen]) > 0.9
        assert np.mean(covered[~seen]) < 0.4  # at this size a third lies at an edge


def test_a_camera_sees_all_that_it_sees(stations: list[Station]) -> None:
    house = _bench_stations._house(False)
    station = stations[1]
    behind = Camera.look_at(
        station.camera.center,
        station.camera.center - station.camera.forward,
        width=SIZE,
        height=SIZE,
    )
    seen = truly_seen(house, station.camera, station.disparity, [station.camera, behind])
    assert seen[0].mean() > 0.9999
    assert not seen[1].any()


def test_what_stands_between_hides() -> None:
    world = boards(upright(4.0, -9, 9), upright(2.0, 0.5, 1.5))
    desired, other = looking_along_x(3.0), looking_along_x(1.0)
    wall = np.full((32, 32), 0.25, np.float32)
    seen = truly_seen(world, desired, wall, [other])[0]
    v, u = np.mgrid[0:32, 0:32]
    y = desired.unproject(u, v, wall.astype(float))[..., 1]
    column, _, _ = other.project(desired.unproject(u, v, wall.astype(float)))
    inside = (column >= -0.5) & (column <= 31.5)
    free = abs(y - 1.0) > 1.0  # the board is a metre wide, half way from an eye at its middle
    np.testing.assert_array_equal(seen, inside & free)
    assert seen.any()
    assert (inside & ~free).any()


def test_a_boards_back_is_not_its_front() -> None:
    world = boards(upright(2.0, -9, 9))
    desired = looking_along_x()
    behind = Camera.look_at((4, 0, 0), (3, 0, 0), fov_deg=60, width=32, height=32)
    before = looking_along_x(0.1)
    board = np.full((32, 32), 0.5, np.float32)
    seen = truly_seen(world, desired, board, [behind, before])
    assert not seen[0].any()
    assert seen[1].mean() > 0.8


def test_the_sky_is_seen_in_a_direction_where_nothing_stands() -> None:
    world = boards(upright(3.0, 0.0, 9.0))  # hides the left half from an eye at 0
    sky = np.zeros((32, 32), np.float32)
    desired = looking_along_x(-20.0)
    seen = truly_seen(world, desired, sky, [looking_along_x()])[0]
    assert seen[:, 16:].all()
    assert not seen[:, :16].any()


def test_kept_stations_are_the_same_and_those_of_other_cameras_are_not_taken(
    tmp_path: Path, stations: list[Station]
) -> None:
    file = tmp_path / "station.npz"
    _bench_stations._save(file, stations[0])
    again = _bench_stations._load(file, PLACES[0], SIZE)
    assert again is not None
    np.testing.assert_array_equal(again.color, stations[0].color)
    np.testing.assert_array_equal(again.disparity, stations[0].disparity)
    np.testing.assert_array_equal(again.seen_by, stations[0].seen_by)
    for one, two in zip(again.references, stations[0].references, strict=True):
        np.testing.assert_array_equal(one.color, two.color)
    assert _bench_stations._load(file, PLACES[1], SIZE) is None
    assert _bench_stations._load(file, PLACES[0], SIZE + 1) is None
    assert _bench_stations._load(tmp_path / "none.npz", PLACES[0], SIZE) is None


def test_a_size_that_no_picture_has_is_refused() -> None:
    with pytest.raises(InputError, match=r"make_stations\.size is 8"):
        make_stations(8)
