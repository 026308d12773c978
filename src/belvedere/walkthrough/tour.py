"""Walks through a building that nobody has walked yet: a tour of its rooms, and strolls at random.

Ways lead over the places of the free space by the shortest path that keeps off walls, are rounded
as a person rounds corners, and are walked at an even pace with the eyes a little ahead.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer
from belvedere.ground.errors import SceneError
from belvedere.scene import Camera, CameraPath
from belvedere.walkthrough.cells import CellGraph
from belvedere.walkthrough.free_space import FreeSpace

F8 = npt.NDArray[np.float64]

PACE_M_S = 1.2
"""Metres a second: an easy walk."""
TURN_M = 0.8
"""Metres that one radian of turning counts for, so that nobody whirls round."""
COMFORT_M = 0.5
"""Walls nearer than this are kept off where there is room."""
AHEAD_M = 1.6
"""How far ahead a walker looks."""
ROUNDING_M = 0.45
"""Standard deviation of the window over which corners are rounded."""
KEY_M = 0.35
"""Metres between keyframes."""
FOV_DEG = 60.0
DROP_M = 0.15
"""Eyes look at a point this much below their own height."""

__all__ = ["Routes", "random_walk", "tour"]


class Routes:
    """Shortest ways over a free space that keep off its walls."""

    def __init__(self, space: FreeSpace) -> None:
        from scipy.sparse import csr_array

        self.space = space
        layers, far, body = space.layers, space.far, space.body
        fits = far >= body.radius
        a = np.repeat(np.arange(len(far)), 4)
        b = layers.link.ravel()
        ok = (b >= 0) & fits[a] & fits[b]
        a, b = a[ok], b[ok]
        tight = np.maximum(COMFORT_M - 0.5 * (far[a] + far[b]), 0.0) / COMFORT_M
        rise = np.abs(layers.floor[a] - layers.floor[b])
        cost = layers.grid.spacing * (1.0 + 6.0 * tight) + rise
        self._ways = csr_array((cost, (a, b)), shape=(len(far), len(far)))
        self.places = np.flatnonzero(fits)
        """(K,) places where a body fits."""
        eye = np.append(layers.centers[self.places], layers.floor[self.places, None], axis=1)
        self.eyes = eye + np.array(layers.grid.origin) + [0.0, 0.0, body.eye]
        """(K, 3) eye positions there."""

    def between(self, stops: Sequence[int]) -> F8:
        """(N, 3) eye positions along the way through places given by their place index.

        Raises:
            SceneError: one cannot be reached from the one before.
        """
        from scipy.sparse.csgraph import dijkstra

        way = [stops[0]]
        for start, end in pairwise(stops):
            before = dijkstra(self._ways, indices=start, return_predecessors=True)[1]
            part = [end]
            while part[-1] != start:
                previous = int(before[part[-1]])
                if previous < 0:
                    raise SceneError("no way leads from one stop of the walk to the next")
                part.append(previous)
            way += part[-2::-1]
        layers, grid = self.space.layers, self.space.layers.grid
        eyes = np.append(layers.centers[way], self.space.smooth_floor[way, None], axis=1)
        return eyes + np.array(grid.origin) + [0.0, 0.0, self.space.body.eye]

    def parts(self) -> npt.NDArray[np.int32]:
        """(N,) a number for each place, the same for places that a way joins."""
        from scipy.sparse.csgraph import connected_components

        return connected_components(self._ways, directed=False)[1]

    def reach(self, start: int) -> F8:
        """(N,) cost of the way from one place to every other; inf where none leads."""
        from scipy.sparse.csgraph import dijkstra

        return np.asarray(dijkstra(self._ways, indices=start))


def tour(graph: CellGraph, space: FreeSpace, width: int = 640, height: int = 512) -> CameraPath:
    """A walk that enters every cell that can be reached from the largest.

    Args:
        graph: the cells.
        space: where a visitor can walk.
        width: of the pictures, pixels.
        height: of the pictures.

    Raises:
        SceneError: no cell has a place to stand.
    """
    routes = Routes(space)
    cell_of = graph.cells_at(routes.eyes)
    stops: dict[int, int] = {}
    for cell in range(len(graph.cells)):
        inside = np.flatnonzero(cell_of == cell)
        if len(inside):
            room = space.far[routes.places[inside]]
            stops[cell] = int(routes.places[inside[np.argmax(room)]])
    if not stops:
        raise SceneError("no cell of this building has a place to stand: is +z up?")
    # the part of the building that joins most cells, and the largest cell of it
    part = routes.parts()
    joined = np.bincount([part[place] for place in stops.values()])
    sizes = {cell: int((cell_of == cell).sum()) for cell in stops}
    at = max(stops, key=lambda cell: (joined[part[stops[cell]]], sizes[cell]))
    order, left = [stops[at]], {cell: place for cell, place in stops.items() if cell != at}
    while left:
        cost = routes.reach(order[-1])
        nearest = min(left, key=lambda cell: cost[left[cell]])
        if not np.isfinite(cost[left[nearest]]):
            break  # what is left cannot be reached: another storey, a balcony
        order.append(left.pop(nearest))
    return _walked(routes, order, width, height)


def random_walk(
    space: FreeSpace,
    start: npt.ArrayLike,
    seed: int = 0,
    stops: int = 8,
    width: int = 640,
    height: int = 512,
) -> CameraPath:
    """A stroll from place to place; the same for the same seed.

    Args:
        space: where a visitor can walk.
        start: (3,) eye to begin near.
        seed: chooses the places.
        stops: how many.
        width: of the pictures, pixels.
        height: of the pictures.
    """
    seed = check_integer("random_walk", "seed", seed, 0, 2**32 - 1)
    stops = check_integer("random_walk", "stops", stops, 1, 10_000)
    routes = Routes(space)
    first = space.place(start)
    near = int(routes.places[np.argmin(((routes.eyes - first) ** 2).sum(axis=1))])
    free = np.flatnonzero(np.isfinite(routes.reach(near)))
    chosen = np.random.default_rng(seed).choice(free, stops)
    return _walked(routes, [near, *(int(place) for place in chosen)], width, height)


def _walked(routes: Routes, stops: Sequence[int], width: int, height: int) -> CameraPath:
    """The way through some places as a camera path."""
    eyes = _rounded(routes.space, routes.between(stops))
    if len(eyes) < 2:  # one room, one place: look around from it
        return _look_around(eyes[0], width, height)
    along = _length(eyes)
    ahead = np.stack([np.interp(along + AHEAD_M, along, eyes[:, c]) for c in range(3)], axis=1)
    last = eyes[-1] + AHEAD_M * _unit(eyes[-1] - eyes[max(len(eyes) - 20, 0)])
    over = np.clip((along + AHEAD_M - along[-1]) / AHEAD_M, 0.0, 1.0)[:, None]
    ahead = (1.0 - over) * ahead + over * last
    look = _smoothed(ahead - eyes, 0.6 / max(along[-1] / len(eyes), 1e-6))
    look[:, 2] -= DROP_M
    turn = np.abs(np.diff(np.unwrap(np.arctan2(look[:, 1], look[:, 0]))))
    effort = np.concatenate([[0.0], np.cumsum(np.diff(along) + TURN_M * turn)])
    count = max(int(along[-1] / KEY_M), 2)
    wanted = np.linspace(0.0, effort[-1], count)
    eye, way = (
        np.stack([np.interp(wanted, effort, values[:, c]) for c in range(3)], axis=1)
        for values in (eyes, look)
    )
    cameras = [
        Camera.look_at(e, e + w, fov_deg=FOV_DEG, width=width, height=height)
        for e, w in zip(eye, way, strict=True)
    ]
    return CameraPath.of(cameras, (wanted / PACE_M_S).tolist())


def _look_around(eye: F8, width: int, height: int) -> CameraPath:
    angles = np.linspace(0.0, 2.0 * np.pi, 17)
    looks = np.stack([np.cos(angles), np.sin(angles), np.full(len(angles), -DROP_M)], axis=1)
    cameras = [
        Camera.look_at(eye, eye + look, fov_deg=FOV_DEG, width=width, height=height)
        for look in looks
    ]
    return CameraPath.of(cameras, (angles * TURN_M / PACE_M_S).tolist())


def _rounded(space: FreeSpace, eyes: F8) -> F8:
    """Corners rounded as far as the body's radius allows, nowhere nearer to a wall than that."""
    if len(eyes) < 3:
        return eyes
    spacing = space.layers.grid.spacing
    result = eyes.copy()
    for sigma in (ROUNDING_M, ROUNDING_M / 2.0, ROUNDING_M / 4.0):
        smooth = _smoothed(eyes, sigma / spacing)
        clear = np.array([space.clearance(p) >= 0.8 * space.body.radius for p in smooth])
        if clear.all():
            return smooth
        # where the rounded way comes too near a wall the unrounded one is taken, blended in
        keep = _smoothed(1.0 - clear.astype(np.float64)[:, None], 0.3 / spacing)
        share = np.clip(4.0 * keep, 0.0, 1.0)
        result = (1.0 - share) * smooth + share * eyes
        if all(space.clearance(p) >= 0.8 * space.body.radius for p in result):
            return result
    return _smoothed(result, 1.0)


def _smoothed(values: F8, sigma: float) -> F8:
    from scipy.ndimage import gaussian_filter1d

    return np.asarray(gaussian_filter1d(values, max(sigma, 1e-3), axis=0, mode="nearest"))


def _length(points: F8) -> F8:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def _unit(vector: F8) -> F8:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
