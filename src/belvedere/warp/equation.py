"""The warping equation between two planar cameras, and what follows from it.

::

    x2 ~ delta P2^-1 (C1 - C2) + P2^-1 P1 x1          one homography plus a step along the epipole
    (r, s, t) = W (u, v, 1, delta)                    W is (3, 4); u2 = r/t, v2 = s/t
    delta2 = delta / t                                so that warps chain

Index 1 is the reference view, 2 the desired one. A sample is in front of the desired camera where
``t > 0``.

Source: McMillan's course notes, eq. 10-18; spec image-warping 3.2-3.6.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import as_array, check_shape
from belvedere.ground.errors import CameraError
from belvedere.scene import Camera

F8 = npt.NDArray[np.float64]


def warp_matrix(reference: Camera, desired: Camera) -> F8:
    """W, (3, 4): reference ``(u, v, 1, delta)`` to desired ``(r, s, t)`` (McMillan eq. 12)."""
    matrix = np.empty((3, 4))
    matrix[:, :3] = homography(reference, desired)
    matrix[:, 3] = _inverse(desired) @ (reference.center - desired.center)
    return matrix


@lru_cache(maxsize=64)
def _inverse(camera: Camera) -> F8:
    """Pixels from rays. Cameras never change, and each is asked for several times a warp."""
    inverse: F8 = np.linalg.inv(camera.matrix).astype(np.float64)
    inverse.setflags(write=False)
    return inverse


def warp_points(
    matrix: F8, u: npt.ArrayLike, v: npt.ArrayLike, delta: npt.ArrayLike
) -> tuple[F8, F8, F8]:
    """Where samples land in the desired view, in float64.

    Args:
        matrix: (3, 4) from `warp_matrix`.
        u: (...) reference columns.
        v: (...) reference rows.
        delta: (...) generalised disparities.

    Returns:
        ``u2``, ``v2``, ``delta2``, each (...); NaN where a sample is not in front of the desired
        camera.
    """
    check_shape("warp_points", "matrix", as_array("warp_points", "matrix", matrix), (3, 4))
    u8, v8, d8 = np.broadcast_arrays(*(np.asarray(x, dtype=np.float64) for x in (u, v, delta)))
    r, s, t = (row[0] * u8 + row[1] * v8 + row[2] + row[3] * d8 for row in matrix)
    t = np.where(t > 0, t, np.nan)
    return r / t, s / t, d8 / t


def epipole(reference: Camera, desired: Camera) -> F8:
    """e, (3,): the desired center of projection seen in the reference image (eq. 18).

    Homogeneous and signed: ``e[2] > 0`` when the desired eye is in front of the reference plane,
    so that ``e[:2] / e[2]`` is its image; negative gives the antipode. Zero when the eye lies in
    the plane through the reference center.
    """
    return _inverse(reference) @ (desired.center - reference.center)


def homography(reference: Camera, desired: Camera) -> F8:
    """(3, 3) map of points at infinity, or of everything when both cameras share a center.

    Exactly the identity between cameras of one matrix, so that a view warped to its own camera
    comes back to the last bit.
    """
    if reference.matrix.tolist() == desired.matrix.tolist():
        return np.eye(3)
    return _inverse(desired) @ reference.matrix


def plane_homography(
    reference: Camera, desired: Camera, normal: npt.ArrayLike, offset: float
) -> F8:
    """(3, 3) map of the plane ``normal . X = offset`` in world coordinates (eq. 15).

    Raises:
        CameraError: the plane passes through the reference center, which sees it edge on.
    """
    n = as_array("plane_homography", "normal", normal)
    check_shape("plane_homography", "normal", n, (3,))
    distance = float(offset) - float(n @ reference.center)
    if distance == 0:
        raise CameraError("plane_homography: the plane passes through the reference's center")
    step = np.outer(reference.center - desired.center, n) / distance
    return np.linalg.inv(desired.matrix) @ (np.eye(3) + step) @ reference.matrix


def jacobian(
    matrix: F8,
    u: npt.ArrayLike,
    v: npt.ArrayLike,
    delta: npt.ArrayLike,
    gradient: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
) -> F8:
    """How a pixel's neighbourhood is stretched: d(u2, v2) / d(u, v), (..., 2, 2).

    Args:
        matrix: (3, 4) from `warp_matrix`.
        u: (...) reference columns.
        v: (...) reference rows.
        delta: (...) disparities.
        gradient: d(delta)/du and d(delta)/dv of the surface; none takes each sample as facing
            the reference plane. With it the result is exact on planes.

    Source: eq. 21-24 with the second row mended; spec image-warping 3.7.
    """
    u8, v8, d8 = np.broadcast_arrays(*(np.asarray(x, dtype=np.float64) for x in (u, v, delta)))
    r, s, t = (row[0] * u8 + row[1] * v8 + row[2] + row[3] * d8 for row in matrix)
    slopes = (0.0, 0.0) if gradient is None else gradient
    out = np.empty((*u8.shape, 2, 2))
    for row, value in enumerate((r / t, s / t)):
        for column in range(2):
            slope = np.asarray(slopes[column], dtype=np.float64)
            step = matrix[row, column] + matrix[row, 3] * slope
            out[..., row, column] = (step - value * (matrix[2, column] + matrix[2, 3] * slope)) / t
    return out


def area_growth(matrix: F8, delta: npt.ArrayLike, t: npt.ArrayLike) -> F8:
    """How much larger the area of a sample facing the reference plane becomes, det J.

    ``det J = (det H + delta det G) / t^3`` with H and G the columns 1, 2, 3 and 1, 2, 4 of W.
    Negative where the picture folds over.
    """
    return (
        np.linalg.det(matrix[:, :3]) + np.asarray(delta) * np.linalg.det(matrix[:, [0, 1, 3]])
    ) / np.asarray(t) ** 3
