"""The recorded walk through a built-in house.

The floor of each storey is a grid of places; a place is free where a ray from head height meets
the floor and nothing else. Ways between rooms are the shortest over free places that keep off
things, rounded as a person rounds corners, with the eyes turned to where the way leads.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from belvedere.model.charts import F8
from belvedere.model.plan import HousePlan, RoomPlan
from belvedere.model.raycast import RayCaster
from belvedere.scene import Camera, CameraPath

EYE_M = 1.6
"""Height of the eye above the floor."""
PLACE_M = 0.05
"""Between places of the grid."""
HEAD_M = 1.9
"""What hangs higher is no obstacle."""
STEP_M = 0.06
"""Rugs and thresholds are lower than this."""
BODY_M = 0.28
"""Half the width of a walker."""
COMFORT_M = 0.65
"""Things nearer than this are kept off where there is room."""
STRIDE_M = 0.05
"""Between points of the way while it is rounded."""
KEY_M = 0.30
"""Metres, and turns counted in metres, between keyframes."""
PACE_M_S = 1.2
"""An easy walk."""
TURN_M = 0.7
"""Metres that one radian of turning counts for: nobody whirls round."""
AHEAD_M = 1.4
"""How far ahead a walker looks."""
TURNING_M = 0.55
"""Standard deviation of the window over which the gaze is turned."""
DOWN = 0.07
"""Eyes look this much below the horizon, a slope."""
SIZE = (640, 512)
FOV_DEG = 60.0


class _Floor:
    """The free places of one storey."""

    def __init__(self, plan: HousePlan, z: float, caster: RayCaster) -> None:
        from scipy import ndimage
        from scipy.sparse import csr_array

        x0, y0, x1, y1 = plan.outline()
        self.z, self.origin = z, np.array([x0, y0])
        nx, ny = int((x1 - x0) / PLACE_M), int((y1 - y0) / PLACE_M)
        x, y = np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij")
        start = np.stack([x.ravel(), y.ravel(), np.zeros(nx * ny)], axis=1) * PLACE_M
        start += [x0, y0, z + HEAD_M]
        reach = caster.cast(start, np.broadcast_to([0.0, 0.0, -1.0], start.shape)).t
        free = (np.abs(reach - HEAD_M) < STEP_M).reshape(nx, ny)
        free[[0, -1]] = free[:, [0, -1]] = False
        self.far = np.asarray(ndimage.distance_transform_edt(free)) * PLACE_M
        index = np.arange(nx * ny).reshape(nx, ny)
        fits = self.far >= BODY_M
        a, b, cost = [], [], []
        for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1)):
            one = (slice(0, nx - dx), slice(max(-dy, 0), ny - max(dy, 0)))
            two = (slice(dx, nx), slice(max(dy, 0), ny - max(-dy, 0)))
            ok = fits[one] & fits[two]
            near = np.minimum(self.far[one], self.far[two])[ok]
            tight = np.maximum(COMFORT_M - near, 0.0) / COMFORT_M
            a.append(index[one][ok])
            b.append(index[two][ok])
            cost.append(PLACE_M * np.hypot(dx, dy) * (1.0 + 4.0 * tight))
        ends = np.concatenate(a), np.concatenate(b)
        self._ways = csr_array((np.concatenate(cost), ends), shape=(nx * ny, nx * ny))

    def clearance(self, points: F8) -> F8:
        """(N,) metres from (N, 2) points to the nearest thing."""
        from scipy import ndimage

        at = ((points - self.origin) / PLACE_M).T
        return np.asarray(ndimage.map_coordinates(self.far, at, order=1, mode="nearest"))

    def stop(self, room: RoomPlan) -> F8:
        """(2,) a roomy place near the middle of a room."""
        low = np.ceil((np.array(room.rect[:2]) - self.origin) / PLACE_M).astype(int)
        high = np.floor((np.array(room.rect[2:]) - self.origin) / PLACE_M).astype(int)
        far = self.far[low[0] : high[0], low[1] : high[1]]
        x, y = np.meshgrid(*(np.arange(n) + 0.5 for n in far.shape), indexing="ij")
        off = np.hypot(x - far.shape[0] / 2.0, y - far.shape[1] / 2.0) * PLACE_M
        best = np.argmin(off - 3.0 * np.minimum(far, COMFORT_M))
        place = np.array(np.unravel_index(best, far.shape)) + low
        return np.asarray(place * PLACE_M + self.origin, np.float64)

    def way(self, start: F8, end: F8) -> F8:
        """(N, 2) the way between two points that stand on free places."""
        from scipy.sparse.csgraph import dijkstra

        ny = self.far.shape[1]
        first, last = (int(i) * ny + int(j) for i, j in (self._near(start), self._near(end)))
        before = dijkstra(self._ways, directed=False, indices=first, return_predecessors=True)[1]
        way = [last]
        while way[-1] != first:
            way.append(int(before[way[-1]]))
            if way[-1] < 0:
                raise AssertionError(f"no way leads from {start} to {end}")
        places = np.array(way[::-1])
        inner = np.stack([places // ny, places % ny], axis=1) * PLACE_M + self.origin
        return np.concatenate([start[None], inner[1:-1], end[None]])

    def _near(self, point: F8) -> F8:
        fits = np.argwhere(self.far >= BODY_M)
        place = (point - self.origin) / PLACE_M
        return np.asarray(fits[np.argmin(((fits - place) ** 2).sum(axis=1))], dtype=np.float64)

    def rounded(self, way: F8) -> F8:
        """(M, 2) the way at even steps, its corners cut where nothing stands near."""
        line = _even(way, STRIDE_M)
        for _ in range(150):
            eased = line.copy()
            eased[1:-1] = 0.25 * line[:-2] + 0.5 * line[1:-1] + 0.25 * line[2:]
            now, then = self.clearance(line), self.clearance(eased)
            keep = then >= np.minimum(now, BODY_M + 0.07)
            line = np.where(keep[:, None], eased, line)
        return line


def recorded_walk(plan: HousePlan, tour: Sequence[str], caster: RayCaster) -> CameraPath:
    """The walk from room to room, at an even pace.

    Args:
        plan: the house.
        tour: names of rooms in the order of the visits.
        caster: of the furnished house.
    """
    storeys = sorted({plan.base(room) for room in plan.rooms})
    floors = [_Floor(plan, z, caster) for z in storeys]
    eyes: list[F8] = []
    rooms = [plan.room(name) for name in tour]
    stops = [(room.storey, floors[room.storey].stop(room)) for room in rooms]
    leg: list[F8] = []
    for (level, start), (next_level, end) in pairwise(stops):
        if level == next_level:
            leg.append(floors[level].way(start, end))
            continue
        stair = _stair_line(plan)
        ends = stair if next_level > level else stair[::-1]
        leg.append(floors[level].way(start, ends[0, :2]))
        eyes += [_lifted(floors[level].rounded(np.concatenate(leg)), storeys[level]), ends]
        leg = [floors[next_level].way(ends[-1, :2], end)]
    last = rooms[-1].storey
    eyes.append(_lifted(floors[last].rounded(np.concatenate(leg)), storeys[last]))
    return _walked(np.concatenate(eyes) + np.array([0.0, 0.0, EYE_M]))


def _lifted(line: F8, z: float) -> F8:
    return np.column_stack([line, np.full(len(line), z)])


def _stair_line(plan: HousePlan) -> F8:
    """(4, 3) feet on the way up: before the stair, on its ends, on the gallery."""
    void, stair = plan.void(), plan.stair
    assert void is not None
    assert stair is not None
    y, top = void[3] - stair.width / 2.0, plan.level_above
    return np.array(
        [
            [stair.foot + 0.45, y, 0.0],
            [stair.foot + 0.10, y, 0.0],
            [void[0] - 0.10, y, top],
            [void[0] - 0.45, y, top],
        ]
    )


def _even(line: F8, step: float) -> F8:
    """A polyline with points at even distances, both ends kept."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    wanted = np.linspace(0.0, along[-1], max(int(along[-1] / step), 1) + 1)
    return np.stack([np.interp(wanted, along, column) for column in line.T], axis=1)


def _walked(eyes: F8) -> CameraPath:
    """The camera path of a walker whose eyes go along a polyline."""
    from scipy.ndimage import gaussian_filter1d

    line = _even(eyes, STRIDE_M)
    line[:, 2] = gaussian_filter1d(line[:, 2], 0.25 / STRIDE_M, mode="nearest")
    far = round(AHEAD_M / STRIDE_M)
    padded = np.concatenate(
        [line, line[-1] + (line[-1] - line[-2]) * np.arange(1, far + 1)[:, None]]
    )
    ahead = padded[far:] - line
    flat = np.linalg.norm(ahead[:, :2], axis=1)
    step = np.gradient(line[:, :2], axis=0)
    use = (flat > 0.5 * AHEAD_M)[:, None]  # where the way turns back: along the way itself
    look = np.where(use, ahead[:, :2], step)
    yaw = np.unwrap(np.arctan2(look[:, 1], look[:, 0]))
    slope = np.where(use[:, 0], ahead[:, 2] / np.maximum(flat, 0.1), 0.0) * 0.6 - DOWN
    yaw, slope = (gaussian_filter1d(a, TURNING_M / STRIDE_M, mode="nearest") for a in (yaw, slope))
    pace = np.linalg.norm(np.diff(line, axis=0), axis=1) + TURN_M * np.abs(np.diff(yaw))
    along = np.concatenate([[0.0], np.cumsum(pace)])
    wanted = np.linspace(0.0, along[-1], max(int(along[-1] / KEY_M), 1) + 1)
    poses = np.column_stack([line, yaw, slope])
    keys = np.stack([np.interp(wanted, along, column) for column in poses.T], axis=1)
    cameras = [
        Camera.look_at(
            (x, y, z), (x + np.cos(a), y + np.sin(a), z + s), fov_deg=FOV_DEG,
            width=SIZE[0], height=SIZE[1],
        )
        for x, y, z, a, s in keys
    ]  # fmt: skip
    return CameraPath.of(cameras, [float(t) for t in wanted / PACE_M_S])
