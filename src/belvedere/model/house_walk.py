"""The recorded walk through a built-in house: a smooth way through the doors, up the stair.

The free floor is found from the mesh itself: whatever stands between ankle and crown is in the way.
The shortest way that keeps off things is sought from room to room, and rounded.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from belvedere.model.plan import HousePlan, RoomPlan
from belvedere.scene.mesh import Mesh

F8 = npt.NDArray[np.float64]

EYE_M = 1.6
"""Height of the eye above the floor."""
SQUARE = 0.05
"""Metres between the points at which the floor is looked at."""
BAND = (0.10, 1.85)
"""Heights above the floor between which things are in the way."""
NEAREST = 0.27
"""The way keeps this far off everything, metres."""
COMFORT = 0.9
"""Where there is room, the way keeps this far off."""
AHEAD = 1.5
"""A walker looks at what lies this far ahead, metres."""
TURN_M = 1.2
"""Metres that one radian of turning counts for, when poses are spread along the walk."""
STEP = 0.04
"""Metres between the points of the way while it is rounded."""


class _Floor:
    """One storey's floor: how far every point is from what stands there."""

    def __init__(self, mesh: Mesh, base: float, outline: tuple[float, ...]) -> None:
        from scipy import ndimage

        self.low = np.array(outline[:2])
        self.shape = tuple(np.ceil((np.array(outline[2:]) - self.low) / SQUARE).astype(int))
        corners = mesh.vertices[mesh.faces]
        z = corners[:, :, 2] - base
        use = (z.max(axis=1) > BAND[0]) & (z.min(axis=1) < BAND[1])
        flat = (corners[use][:, :, :2] - self.low) / SQUARE
        size = np.array(self.shape)
        first = np.clip(np.floor(flat.min(axis=1)), 0, size).astype(int)
        last = np.clip(np.floor(flat.max(axis=1)) + 1, 0, size).astype(int)
        count = np.zeros(size + 1)  # boxes as steps up and down, summed up along both axes
        for sign, i, j in (
            (1, first, first),
            (-1, first, last),
            (-1, last, first),
            (1, last, last),
        ):
            np.add.at(count, (i[:, 0], j[:, 1]), sign)
        taken = count.cumsum(axis=0).cumsum(axis=1)[:-1, :-1] > 0.5
        self.clear: F8 = ndimage.distance_transform_edt(~taken) * SQUARE

    def clearance(self, points: F8) -> F8:
        """(N,) metres from (N, 2) points to what is nearest."""
        at = np.clip(((points - self.low) / SQUARE).astype(int), 0, np.array(self.shape) - 1)
        return self.clear[at[:, 0], at[:, 1]]

    def open_place(self, room: RoomPlan) -> F8:
        """(2,) the most open point near the middle of a room."""
        x0, y0, x1, y1 = room.rect
        x, y = np.meshgrid(np.arange(x0, x1, 0.1), np.arange(y0, y1, 0.1))
        points = np.column_stack([x.ravel(), y.ravel()])
        off = np.hypot(*(points - [(x0 + x1) / 2.0, (y0 + y1) / 2.0]).T)
        return points[int(np.argmax(np.minimum(self.clearance(points), COMFORT) - 0.12 * off))]

    def way(self, stops: list[F8]) -> F8:
        """(N, 2) the way from stop to stop."""
        from scipy.sparse import csr_array
        from scipy.sparse.csgraph import dijkstra

        coarse = self.clear[::2, ::2]
        place = np.arange(coarse.size).reshape(coarse.shape)
        cost = np.where(
            coarse > NEAREST + 0.03,
            1.0 + 6.0 * np.maximum(1.0 - coarse / COMFORT, 0.0) ** 2,
            np.inf,
        )
        rows, columns, values = [], [], []
        for di, dj in ((1, 0), (0, 1), (1, 1), (1, -1)):
            a = place[: -di or None, max(-dj, 0) : place.shape[1] - max(dj, 0)]
            b = place[di:, max(dj, 0) : place.shape[1] - max(-dj, 0)]
            mean = (cost.ravel()[a] + cost.ravel()[b]) * 0.5 * np.hypot(di, dj)
            free = np.isfinite(mean)
            rows.append(a[free])
            columns.append(b[free])
            values.append(mean[free])
        graph = csr_array(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
            shape=(coarse.size, coarse.size),
        )
        nodes = [self._node(stop, cost) for stop in stops]
        line: list[int] = [nodes[0]]
        for start, end in pairwise(nodes):
            _, before = dijkstra(graph, False, start, return_predecessors=True)
            back = [end]
            while back[-1] != start:
                back.append(int(before[back[-1]]))
            line += back[-2::-1]
        at = np.array(line)
        cells = np.column_stack([at // coarse.shape[1], at % coarse.shape[1]])
        return self.low + (2.0 * cells + 0.5) * SQUARE

    def _node(self, point: F8, cost: F8) -> int:
        """The free square nearest to a point."""
        i, j = np.nonzero(np.isfinite(cost))
        at = (point - self.low) / (2.0 * SQUARE)
        k = int(np.argmin((i - at[0]) ** 2 + (j - at[1]) ** 2))
        return int(i[k]) * cost.shape[1] + int(j[k])


def plan_walk(plan: HousePlan, mesh: Mesh, tour: tuple[str, ...]) -> F8:
    """(N, 6) eye and target along a walk through the rooms of ``tour``, close together."""
    rooms = [plan.room(name) for name in tour]
    storeys = sorted({room.storey for room in rooms})
    step = max(plan.base(room) for room in plan.rooms)
    floors = {s: _Floor(mesh, step if s else 0.0, plan.outline()) for s in storeys}
    parts: list[F8] = []
    for storey in storeys:
        own = [room for room in rooms if room.storey == storey]
        floor = floors[storey]
        stops = [floor.open_place(own[0])]
        for a, c in pairwise(own):
            stops += _through(plan, a, c)
        stops.append(floor.open_place(own[-1]))
        foot, top = _stair_ends(plan)
        if storey == 0 and len(storeys) > 1:
            stops[-1] = foot
        if storey == 1:
            stops[0] = top
        line = floor.way(stops)
        z = np.full((len(line), 1), (step if storey else 0.0) + EYE_M)
        parts.append(np.column_stack([line, z]))
    return _look(_rounded(np.concatenate(parts), floors, step))


def _through(plan: HousePlan, a: RoomPlan, c: RoomPlan) -> list[F8]:
    """Points before, in and behind the door from one room to another."""
    door = next(d for d in plan.doors if {a.name, c.name} == set(d.rooms))
    axis, at = plan.door_wall(door)
    across = 1 if axis == "x" else 0
    sign = 1.0 if c.lines[across] >= at - 1e-9 else -1.0
    points = []
    for off in (-0.4, 0.0, 0.4):
        point = np.array([door.at, door.at])
        point[across] = at + sign * off
        points.append(point)
    return points


def _stair_ends(plan: HousePlan) -> tuple[F8, F8]:
    """(2,) where one stands before climbing, and after."""
    well, stair = plan.well(), plan.stair
    if stair is None or well is None:
        return np.zeros(2), np.zeros(2)
    y = well[3] - stair.width / 2.0
    # the line through the edges of the steps, from floor to floor
    return np.array([stair.foot + stair.going, y]), np.array([well[0], y])


def _rounded(line: F8, floors: dict[int, _Floor], step: float) -> F8:
    """The way with its corners rounded as far as what stands there allows."""
    from scipy.ndimage import gaussian_filter1d

    keep = np.concatenate([[True], np.linalg.norm(np.diff(line, axis=0), axis=1) > 1e-9])
    line = line[keep]
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], int(along[-1] / STEP))
    fine = np.stack([np.interp(at, along, line[:, k]) for k in range(3)], axis=1)
    result = fine
    for sigma in (0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5):
        smooth = gaussian_filter1d(fine, sigma / STEP, axis=0, mode="nearest")
        smooth[0], smooth[-1] = fine[0], fine[-1]
        bad = np.zeros(len(smooth), dtype=bool)
        for storey, floor in floors.items():
            level = (step if storey else 0.0) + EYE_M
            here = np.abs(fine[:, 2] - level) < 1e-6
            bad |= here & (floor.clearance(smooth[:, :2]) < NEAREST)
        # where it comes too near the former, less rounded way stays, blended in gently
        share = gaussian_filter1d(
            np.minimum(gaussian_filter1d(bad.astype(float), 0.3 / STEP) * 20.0, 1.0), 0.12 / STEP
        )[:, None]
        result = smooth * (1.0 - share) + result * share
    return result


def _look(eyes: F8) -> F8:
    """(N, 6) poses that look along the way."""
    from scipy.ndimage import gaussian_filter1d

    ahead = round(AHEAD / STEP)
    tail = (
        eyes[-1] + (eyes[-1] - eyes[-ahead // 2]) / (ahead // 2) * np.arange(1, ahead + 1)[:, None]
    )
    far = np.concatenate([eyes, tail])[ahead:]
    look = far - eyes
    heading = np.unwrap(np.arctan2(look[:, 1], look[:, 0]))
    heading = gaussian_filter1d(heading, 0.35 / STEP, mode="nearest")
    rise = gaussian_filter1d(look[:, 2], 0.5 / STEP, mode="nearest")
    reach = 3.0
    target = eyes + np.column_stack(
        [reach * np.cos(heading), reach * np.sin(heading), 0.9 * rise - 0.25]
    )
    return np.column_stack([eyes, target])


def spread(poses: F8, count: int) -> F8:
    """(count, 6) poses at an even pace along dense ones, both ends included."""
    look = poses[:, 3:5] - poses[:, :2]
    turn = np.abs(np.diff(np.unwrap(np.arctan2(look[:, 1], look[:, 0]))))
    step = np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1) + TURN_M * turn
    along = np.concatenate([[0.0], np.cumsum(step)])
    wanted = np.linspace(0.0, along[-1], count)
    return np.stack([np.interp(wanted, along, poses[:, k]) for k in range(6)], axis=1)
