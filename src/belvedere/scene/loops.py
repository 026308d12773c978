"""`wobble`: a gentle closed loop about reference views, where they show the scene best."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from belvedere.ground.checks import check_integer, check_number
from belvedere.ground.errors import PathError
from belvedere.scene.camera import Camera
from belvedere.scene.camera_model import F8, CameraModel
from belvedere.scene.moves import KEYS_PER_TURN, check_seconds, even_costs, planar_set
from belvedere.scene.path import CameraPath
from belvedere.scene.pose import look_at_rotation, pose_matrix

GUESSED_DISTANCE = 2.0
"""Metres to what a single view shows, where the caller does not say."""

SINGLE_SWAY = 0.03
"""Radius of the wobble about a single view, in distances to what it shows: small enough that
little comes to light behind things, large enough to be seen."""

MOST_VIEWS = 400
"""Views that a wobble is shaped by; of longer captures, evenly spaced ones."""

CONVERGENCE = math.radians(1.5)
"""Mean angle between optical axes from which on they are taken to meet at one place."""

GENTLE_TURN = math.radians(30.0)
"""Neighbours on a way that differ by less can be averaged direction by direction."""

SAME_WAY = math.radians(25.0)
"""Views that differ by less from their mean direction can be shown by a wobble about one point."""


def wobble(
    cameras: Sequence[CameraModel],
    duration: float | None = None,
    *,
    distance: float | None = None,
    keys: int | None = None,
) -> CameraPath:
    """A gentle closed loop about reference views, looking at what they look at.

    - One view: a small circle about it, in the plane of its picture.
    - Views side by side (a stereo pair, a camera grid, a short sideways slide): an ellipse through
      their midst, as wide as four fifths of their spread.
    - Views along a way (a walk, a ring about a thing, unordered photographs): along the smoothed
      way and back, or round where it closes, slightly off the views themselves.

    Eyes stay within the references' spread; an ellipse about views in one line leaves the line by
    less than half the distance of two neighbours. If the optical axes meet, the loop looks at
    where they meet.

    Args:
        cameras: the references' cameras; the first one's picture size and lens are used.
        duration: seconds of one round; None: 6 for a wobble about one point, longer for ways.
        distance: metres to what the views show (the median depth, say), where axes do not meet.
            It is what a single view is moved by and turned about; 2 m where left out.
        keys: keyframes of the loop, 8 or more; None: 36, or four for each camera of a way.

    Raises:
        PathError: no camera, a number out of range.
    """
    held = planar_set("wobble", cameras)
    far = GUESSED_DISTANCE if distance is None else check_number(
        "wobble", "distance", distance, 0.0, open_low=True, error=PathError
    )  # fmt: skip
    count = None if keys is None else check_integer("wobble", "keys", keys, 8, 10_000, PathError)
    seconds = None if duration is None else check_seconds("wobble", duration)
    rig = _Rig(held[:: math.ceil(len(held) / MOST_VIEWS)])
    ellipse = rig.ellipse(far, count or KEYS_PER_TURN)
    if ellipse is not None:
        loop, period = ellipse, seconds or 6.0
    else:
        loop = rig.way(count or max(4 * len(rig.cameras), KEYS_PER_TURN))
        period = seconds or min(max(0.6 * len(rig.cameras), 8.0), 60.0)
    return CameraPath.of(loop, (period * np.arange(len(loop)) / len(loop)).tolist(), period)


class _Rig:
    """What a set of reference cameras has in common."""

    def __init__(self, cameras: list[Camera]) -> None:
        self.cameras = cameras
        self.lens = cameras[0]
        poses = np.stack([camera.camera_to_world for camera in cameras])
        self.places: F8 = poses[:, :3, 3]
        self.ahead: F8 = poses[:, :3, 2]
        self.above: F8 = -poses[:, :3, 1]

    def pose(self, place: F8, ahead: F8, above: F8) -> Camera:
        """The first camera's lens elsewhere."""
        rotation = look_at_rotation(np.zeros(3), ahead, above)
        return Camera.from_intrinsics(
            self.lens.intrinsics, pose_matrix(rotation, place), self.lens.width, self.lens.height
        )

    def meeting_point(self) -> F8 | None:
        """(3,) where the optical axes meet in front of every camera, or None."""
        across = np.eye(3) - self.ahead[:, :, None] * self.ahead[:, None, :]
        normal = across.sum(axis=0)
        if np.linalg.eigvalsh(normal)[0] < len(self.ahead) * math.sin(CONVERGENCE) ** 2:
            return None
        point = np.linalg.solve(normal, (across @ self.places[:, :, None]).sum(axis=0))[:, 0]
        depth = ((point - self.places) * self.ahead).sum(axis=1)
        return point if bool((depth > 0).all()) else None

    def ellipse(self, distance: float, count: int) -> list[Camera] | None:
        """A loop about the mean place, or None where the views do not stand side by side."""
        ahead, above = self.ahead.mean(axis=0), self.above.mean(axis=0)
        if np.linalg.norm(ahead) < 0.5 or np.linalg.norm(np.cross(ahead, above)) < 0.1:
            return None
        axes = look_at_rotation(np.zeros(3), ahead, above)
        if (self.ahead @ axes[:, 2]).min() < math.cos(SAME_WAY):
            return None
        mean = self.places.mean(axis=0)
        right, down, forward = ((self.places - mean) @ axes).T
        flat = np.stack([right, down], axis=1)
        reach = float(np.linalg.norm(flat, axis=1).max())
        if reach < 1e-9 * max(distance, 1.0) and np.ptp(forward) < 1e-9 * max(distance, 1.0):
            wide, high = np.array([SINGLE_SWAY * distance, 0.0]), np.array([0.0, 1.0])
            high = high * SINGLE_SWAY * distance
        elif reach < np.ptp(forward):
            return None
        else:
            wide, high = _half_axes(flat, _neighbour_distance(self.places))
        phase = 2.0 * math.pi * np.arange(count)[:, None] / count
        offsets = np.sin(phase) * wide + np.cos(phase) * high
        places = mean + offsets @ axes[:, :2].T
        if reach > 0 and not self._near(places, 1.25 * _neighbour_distance(self.places)):
            return None
        point = self.meeting_point()
        if point is None and len(self.cameras) == 1:
            point = mean + distance * axes[:, 2]
        return [
            self.pose(place, axes[:, 2] if point is None else point - place, -axes[:, 1])
            for place in places
        ]

    def way(self, count: int) -> list[Camera]:
        """A loop along the views: there and back, or round where the way closes."""
        poses = np.stack([self.cameras[i].camera_to_world for i in _visiting_order(self.cameras)])
        for index in range(1, len(poses)):  # a rig that hung upside down shows no such video
            if poses[index, :3, 1] @ poses[index - 1, :3, 1] < 0:
                poses[index, :3, :2] *= -1.0
        poses = _with_gentle_turns(poses)
        places, ahead, above = poses[:, :3, 3], poses[:, :3, 2], -poses[:, :3, 1]
        cosine = (ahead * np.roll(ahead, -1, axis=0)).sum(axis=1)
        steps = even_costs(places, np.arccos(np.clip(cosine, -1.0, 1.0)))
        rounds = len(steps) > 3 and steps[-1] <= 1.5 * float(np.median(steps[:-1]))
        at = np.concatenate([[0.0], np.cumsum(steps)])
        whole = at[-1] if rounds else at[-2]
        share = np.arange(count) / count
        along = whole * share if rounds else whole * 0.5 * (1.0 - np.cos(2.0 * math.pi * share))
        apart = along[:, None] - at[:-1]
        if rounds:
            apart = (apart + 0.5 * whole) % whole - 0.5 * whole
        width = 0.7 * float(np.mean(steps if rounds else steps[:-1]))
        weight = np.exp(-0.5 * (apart / width) ** 2)
        weight /= weight.sum(axis=1, keepdims=True)
        return [
            self.pose(*directions)
            for directions in zip(weight @ places, weight @ ahead, weight @ above, strict=True)
        ]

    def _near(self, places: F8, reach: float) -> bool:
        """Whether each place has a reference within ``reach``."""
        gaps = np.linalg.norm(places[:, None] - self.places, axis=2).min(axis=1)
        return bool((gaps <= reach).all())


def _with_gentle_turns(poses: F8) -> F8:
    """(M, 4, 4) poses in order, with more of them where one turns far from the one before."""
    from scipy.spatial.transform import Rotation

    gentle = [poses[0]]
    for before, after in itertools.pairwise(poses):
        turn = Rotation.from_matrix(before[:3, :3].T @ after[:3, :3]).as_rotvec()
        parts = max(math.ceil(float(np.linalg.norm(turn)) / GENTLE_TURN), 1)
        for part in range(1, parts):
            share = part / parts
            rotation = before[:3, :3] @ Rotation.from_rotvec(share * turn).as_matrix()
            place = (1.0 - share) * before[:3, 3] + share * after[:3, 3]
            gentle.append(pose_matrix(rotation, place))
        gentle.append(after)
    return np.stack(gentle)


def _half_axes(flat: F8, neighbour: float) -> tuple[F8, F8]:
    """The half axes (2,) of an ellipse in (N, 2) spread-out places, the longer one first."""
    _, _, directions = np.linalg.svd(flat, full_matrices=False)
    if len(directions) < 2:
        directions = np.array([directions[0], [-directions[0, 1], directions[0, 0]]])
    long, short = directions
    length = 0.8 * float(np.abs(flat @ long).max())
    breadth = 0.8 * float(np.abs(flat @ short).max())
    breadth = min(max(breadth, min(0.15 * length, 0.4 * neighbour)), length)
    return length * long * _sign(long), breadth * short * _sign(short)


def _sign(axis: F8) -> float:
    """+1 or -1, so that an axis points right (or down): the same loop on every machine."""
    return -1.0 if axis[int(np.argmax(np.abs(axis)))] < 0 else 1.0


def _neighbour_distance(places: F8) -> float:
    """Median distance from a place to its nearest neighbour, metres; 0 for one place."""
    if len(places) == 1:
        return 0.0
    gaps = np.linalg.norm(places[:, None] - places, axis=2)
    np.fill_diagonal(gaps, np.inf)
    return float(np.median(gaps.min(axis=1)))


def _visiting_order(cameras: list[Camera]) -> list[int]:
    """The order given where that is a way; else from neighbour to neighbour.

    Photographs come in no order: where going from each to its nearest unvisited neighbour makes a
    way less than two thirds as long, that is taken.
    """
    places = np.stack([camera.center for camera in cameras])
    gaps = np.linalg.norm(places[:, None] - places, axis=2)
    given = list(range(len(cameras)))
    order = [int(np.unravel_index(int(np.argmax(gaps)), gaps.shape)[0])]
    unvisited = np.zeros(len(cameras))  # infinity once visited
    for _ in given[1:]:
        unvisited[order[-1]] = np.inf
        order.append(int(np.argmin(gaps[order[-1]] + unvisited)))

    def length(way: list[int]) -> float:
        return float(sum(gaps[i, j] for i, j in itertools.pairwise(way)))

    return order if length(order) < length(given) * 2 / 3 else given
