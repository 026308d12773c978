"""Poses: where a camera stands and how it is turned. Camera axes x right, y down, z forward."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import as_array, check_finite, check_pose, check_shape
from belvedere.ground.errors import CameraError

F8 = npt.NDArray[np.float64]

OPENCV_FROM_OPENGL: F8 = np.diag([1.0, -1.0, -1.0, 1.0])
"""(4, 4) flips y and z. ``camera_to_world @ OPENCV_FROM_OPENGL`` turns a pose with OpenGL's camera
axes (x right, y up, z backward) into ours, and back: it is its own inverse."""


def pose_matrix(rotation: npt.ArrayLike, position: npt.ArrayLike) -> F8:
    """(4, 4) camera-to-world from a (3, 3) rotation and a (3,) position."""
    pose = np.eye(4)
    pose[:3, :3] = rotation
    pose[:3, 3] = position
    return pose


def invert_pose(pose: npt.ArrayLike) -> F8:
    """The inverse of a rigid (4, 4) transform, without a general matrix inverse."""
    matrix: F8 = np.asarray(pose, dtype=np.float64)
    rotation = matrix[:3, :3].T
    return pose_matrix(rotation, np.negative(rotation @ matrix[:3, 3]))


def look_at_rotation(eye: npt.ArrayLike, target: npt.ArrayLike, up: npt.ArrayLike) -> F8:
    """(3, 3) rotation whose columns are right, down, forward.

    Raises:
        CameraError: ``eye`` and ``target`` coincide, or ``up`` is parallel to the line of sight.
    """
    vectors: dict[str, F8] = {}
    for name, value in (("eye", eye), ("target", target), ("up", up)):
        vectors[name] = as_array("look_at", name, value)
        check_shape("look_at", name, vectors[name], (3,), error=CameraError)
        check_finite("look_at", name, vectors[name], CameraError)
    forward = vectors["target"] - vectors["eye"]
    distance = float(np.linalg.norm(forward))
    if distance == 0:
        raise CameraError(
            f"look_at.eye and look_at.target are the same point {vectors['eye'].tolist()}: "
            "the direction of sight is undefined"
        )
    forward = forward / distance
    right = np.cross(forward, vectors["up"])
    sine = float(np.linalg.norm(right))
    if sine <= 1e-9 * float(np.linalg.norm(vectors["up"])) or sine == 0:
        raise CameraError(
            f"look_at.up {vectors['up'].tolist()} is parallel to the line of sight: "
            "pass another up, such as (0, 1, 0)"
        )
    right = right / sine
    return np.column_stack([right, np.cross(forward, right), forward])


# ---- quaternions: COLMAP writes (w, x, y, z), TUM (x, y, z, w); ours are (w, x, y, z) -----------

QUATERNION_TOLERANCE = 0.02
"""How far a quaternion's length may be from 1. Files round to 4 decimals or so; a length further
off is not rounding: the columns of the file are not the ones we think."""


def rotation_from_quaternion(w: float, x: float, y: float, z: float) -> F8:
    """(3, 3) rotation of a unit quaternion ``w + xi + yj + zk``. q and -q give the same.

    TUM trajectories write ``qx qy qz qw``: ``rotation_from_quaternion(qw, qx, qy, qz)``.

    Raises:
        CameraError: NaN, or a length that is not 1 within `QUATERNION_TOLERANCE`; what is off by
            less is normalised.
    """
    quaternion = as_array("pose", "quaternion", [w, x, y, z])
    check_finite("pose", "quaternion", quaternion, CameraError)
    length = float(np.linalg.norm(quaternion))
    if abs(length - 1.0) > QUATERNION_TOLERANCE:
        raise CameraError(
            f"pose.quaternion (w, x, y, z) = {quaternion.tolist()} has length {length:.4g}, "
            "expected 1: are these the right columns?"
        )
    w, x, y, z = (quaternion / length).tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_from_rotation(rotation: npt.ArrayLike) -> tuple[float, float, float, float]:
    """``(w, x, y, z)`` of a (3, 3) rotation, unit length, ``w >= 0``.

    TUM's order is ``(x, y, z, w)``: ``w, x, y, z = quaternion_from_rotation(R)``.

    Raises:
        CameraError: the matrix is not (3, 3), not finite, or no rotation (see `check_pose`).
    """
    matrix = as_array("pose", "rotation", rotation)
    check_shape("pose", "rotation", matrix, (3, 3), error=CameraError)
    r = check_pose("pose", "rotation", pose_matrix(matrix, np.zeros(3)))[:3, :3]
    # Bar-Itzhack: 4 q q^T has the components' products; its longest row loses no digits.
    trace = r.trace()
    products = np.empty((4, 4))
    products[0, 0] = 1.0 + trace
    products[0, 1:] = products[1:, 0] = (
        r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    )  # fmt: skip
    products[1:, 1:] = r + r.T + (1.0 - trace) * np.eye(3)
    row = products[int(np.argmax(np.diag(products)))]
    w, x, y, z = (row / np.linalg.norm(row)).tolist()
    negative = next((c < 0 for c in (w, x, y, z) if c != 0), False)
    return (-w, -x, -y, -z) if negative else (w, x, y, z)
