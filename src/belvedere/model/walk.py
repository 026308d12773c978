"""Where to walk through the built-in house, and where its reference views stand.

The walk follows a smooth curve through the doorways. Reference views stand on that curve, so that
a walker is always between two of them: the one behind saw the edges of what comes, the one ahead
saw behind the things on the way.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer
from belvedere.scene import Camera

F8 = npt.NDArray[np.float64]
Pose = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Eye and target, world positions in metres."""

_WAY = np.array(
    # eye x, y, z          target x, y, z
    [
        [0.95, 1.35, 1.60, 4.20, 2.75, 1.20],
        [1.75, 1.65, 1.60, 4.60, 2.65, 1.20],
        [2.75, 1.95, 1.60, 5.60, 2.35, 1.25],
        [3.75, 2.05, 1.60, 6.60, 2.05, 1.25],
        [4.60, 2.15, 1.60, 7.40, 1.75, 1.20],
        [5.35, 2.25, 1.60, 8.20, 1.75, 1.15],
        [6.05, 2.50, 1.60, 8.70, 2.75, 1.20],
        [6.60, 2.95, 1.60, 8.10, 5.40, 1.35],
        [6.92, 3.60, 1.60, 7.05, 6.60, 1.50],
        [7.00, 4.40, 1.60, 6.35, 7.20, 1.65],
        [6.85, 5.10, 1.60, 4.90, 7.20, 1.75],
        [6.35, 5.55, 1.60, 3.80, 6.95, 1.75],
        [5.55, 5.72, 1.60, 2.60, 6.55, 1.65],
        [4.60, 5.74, 1.60, 1.60, 6.10, 1.55],
        [3.60, 5.72, 1.60, 0.60, 5.85, 1.50],
        [2.75, 5.70, 1.60, -0.25, 5.75, 1.50],
    ]
)
"""Waypoints; between them a cubic spline through equal parameters."""

TURN_M = 0.9
"""Metres that one radian of turning counts for, when poses are spread along the walk."""


def _curve(samples: int = 801) -> tuple[F8, F8]:
    """(n, 6) eye and target along the walk, and (n,) how far each lies, in metres and turns."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(np.arange(len(_WAY)), _WAY, axis=0)
    poses = np.asarray(spline(np.linspace(0.0, len(_WAY) - 1.0, samples)), dtype=np.float64)
    look = poses[:, 3:5] - poses[:, :2]
    turn = np.abs(np.diff(np.unwrap(np.arctan2(look[:, 1], look[:, 0]))))
    step = np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1) + TURN_M * turn
    return poses, np.concatenate([[0.0], np.cumsum(step)])


def _spread(count: int) -> F8:
    """(count, 6) poses at equal distances along the walk, both ends included."""
    poses, along = _curve()
    wanted = np.linspace(0.0, along[-1], count)
    return np.stack([np.interp(wanted, along, poses[:, k]) for k in range(6)], axis=1)


def walk_keyframes(count: int = 25) -> list[Pose]:
    """(eye, target) poses at an even pace, from the living room through the kitchen to the hall.

    Raises:
        InputError: count is not from 2 to 10000.
    """
    count = check_integer("walk_keyframes", "count", count, 2, 10_000)
    return [
        ((float(p[0]), float(p[1]), float(p[2])), (float(p[3]), float(p[4]), float(p[5])))
        for p in _spread(count)
    ]


def reference_cameras(
    count: int, width: int, height: int, fov_deg: float = 74.0
) -> tuple[Camera, ...]:
    """Cameras that together see nearly all that the walk sees.

    They stand on the walk and look its way, with a wider field of view than a walker's (60
    degrees upright), so that turning and stepping aside stay inside what was seen.

    Raises:
        InputError: count is not from 2 to 10000.
        CameraError: the size or the field of view is of no use.
    """
    count = check_integer("reference_cameras", "count", count, 2, 10_000)
    return tuple(
        Camera.look_at(p[:3], p[3:], fov_deg=fov_deg, width=width, height=height)
        for p in _spread(count)
    )
