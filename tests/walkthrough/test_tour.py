"""Walks through a building that nobody has walked yet."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from belvedere.ground.errors import InputError
from belvedere.walkthrough.free_space import FreeSpace
from belvedere.walkthrough.tour import Routes, random_walk, tour


@pytest.fixture(scope="module")
def space(house) -> FreeSpace:
    return FreeSpace.of_mesh(house.mesh, spacing=0.08)


def eyes_of(path, count: int = 200) -> np.ndarray:
    times = path.start + np.linspace(0.0, path.duration, count)
    return np.array([path.camera(float(t)).center for t in times])


def test_a_tour_enters_every_room_and_touches_no_wall(space, graph) -> None:
    eyes = eyes_of(tour(graph, space))
    assert set(graph.cells_at(eyes)) - {-1} == {0, 1, 2}
    assert min(space.clearance(eye) for eye in eyes) > 0.15
    assert np.abs(eyes[:, 2] - 1.6).max() < 0.05


def test_a_walker_looks_where_he_goes(space, graph) -> None:
    path = tour(graph, space)
    times = path.start + np.linspace(0.05, 0.9, 60) * path.duration
    cameras = [path.camera(float(t)) for t in times]
    ahead = [np.array(path.camera(float(t + 0.5)).center) for t in times]
    facing = [
        c.forward @ (a - c.center) / np.linalg.norm(a - c.center)
        for c, a in zip(cameras, ahead, strict=True)
        if np.linalg.norm(a - c.center) > 0.1
    ]
    assert np.median(facing) > 0.9
    turns = [a.forward @ b.forward for a, b in pairwise(cameras)]
    assert min(turns) > np.cos(np.radians(35))


def test_a_random_walk_is_the_same_for_the_same_seed(space) -> None:
    first, again, other = (eyes_of(random_walk(space, (1, 1.5, 1.6), seed)) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert first.shape != other.shape or np.abs(first - other).max() > 0.5
    assert min(space.clearance(eye) for eye in first) > 0.15


def test_ways_do_not_lead_through_walls(space) -> None:
    routes = Routes(space)
    ends = [
        int(routes.places[np.argmin(((routes.eyes - np.array(p)) ** 2).sum(axis=1))])
        for p in ((4.6, 3.4, 1.6), (6.0, 3.4, 1.6))  # on either side of a wall
    ]
    way = routes.between(ends)
    length = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
    assert length > 2.0  # round by the opening, though they are 1.4 m apart
    assert (np.linalg.norm(np.diff(way, axis=0)[:, :2], axis=1) < 0.081).all()


def test_seeds_of_no_use_are_refused(space) -> None:
    with pytest.raises(InputError, match="seed"):
        random_walk(space, (1, 1, 1.6), seed=-1)
    with pytest.raises(InputError, match="stops"):
        random_walk(space, (1, 1, 1.6), stops=0)
