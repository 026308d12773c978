"""Unit quaternions to rotation matrices and back, for the formats that store them."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import FileFormatError

F8 = npt.NDArray[np.float64]
QUATERNION_TOLERANCE = 1e-2
"""How far a stored quaternion's length may be from 1: data sets write four decimals."""


def rotation_of(where: str, w: float, x: float, y: float, z: float) -> F8:
    """(3, 3) rotation of a quaternion that is of unit length but for rounding.

    Raises:
        FileFormatError: its length is not 1; a quaternion of zeros.
    """
    length = math.sqrt(w * w + x * x + y * y + z * z)
    if abs(length - 1.0) > QUATERNION_TOLERANCE:
        raise FileFormatError(
            f"{where} has a quaternion of length {length:.6g}, expected 1: are its values in order?"
        )
    w, x, y, z = w / length, x / length, y / length, z / length
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_of(rotation: F8) -> tuple[float, float, float, float]:
    """``(w, x, y, z)`` of a (3, 3) rotation, w >= 0."""
    r = rotation
    # the largest of the four squares is divided by, so nothing is lost to cancellation
    squares = np.array(
        [
            1 + r[0, 0] + r[1, 1] + r[2, 2],
            1 + r[0, 0] - r[1, 1] - r[2, 2],
            1 - r[0, 0] + r[1, 1] - r[2, 2],
            1 - r[0, 0] - r[1, 1] + r[2, 2],
        ]
    )
    a, b, c = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    d, e, f = r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1]
    rows = ([0.0, a, b, c], [a, 0.0, d, e], [b, d, 0.0, f], [c, e, f, 0.0])
    largest = int(np.argmax(squares))
    q = np.array(rows[largest])
    q[largest] = squares[largest]
    q /= np.linalg.norm(q)
    if q[0] < 0:
        q = -q
    w, x, y, z = (float(value) for value in q)
    return w, x, y, z
