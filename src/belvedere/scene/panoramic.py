"""Cameras that look all round: the cylinder and the sphere (equirectangular).

Both are central: ``X = center + D(u, v) / delta``. In the camera's local frame, z up and x toward
the picture's middle, a pixel's azimuth is ``psi = azimuth - 2 pi u / width``, so that u grows to
the right as seen from inside::

    seen from above          psi = pi/2 (left)
                                 y
                                 |            u runs clockwise:
              psi = pi  ---------+--------- x   psi = 0, the middle of the picture
                                 |
                                              psi = -pi/2 (right)

    cylinder  D = (cos psi, sin psi, row_step (horizon - v))         delta = 1 / horizontal distance
    sphere    D = (cos lat cos psi, cos lat sin psi, sin lat)        delta = 1 / range

Source: spec image-warping 3.5; McMillan & Bishop 1995.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import (
    as_array,
    check_finite,
    check_image_size,
    check_number,
    check_pose,
    check_shape,
)
from belvedere.ground.errors import CameraError
from belvedere.scene.camera_model import F8, NEAREST, CameraModel, frozen
from belvedere.scene.pose import pose_matrix

FULL_TURN = 2.0 * math.pi


@dataclass(frozen=True, slots=True, eq=False, init=False)
class CylinderCamera(CameraModel):
    """A cylindrical panorama, a full turn wide. `at` builds one from directions."""

    center: F8
    """(3,) world position of the eye, metres."""
    width: int
    """Pixels round the full turn."""
    height: int
    """Pixels down."""
    rotation: F8
    """(3, 3) world_from_local: its columns are the directions of the picture's middle (x), of its
    left (y) and of the cylinder's axis, upwards (z)."""
    azimuth: float
    """Azimuth psi of the centre of column 0, radians. ``pi (width - 1) / width`` puts psi = 0 in
    the picture's middle."""
    horizon: float
    """Row, in pixels, that looks horizontally (at a right angle to the axis)."""
    row_step: float
    """Height on the cylinder of radius 1 from one row to the one above it; ``2 pi / width`` makes
    pixels square at the horizon."""

    def __init__(
        self,
        center: npt.ArrayLike,
        width: int,
        height: int,
        rotation: npt.ArrayLike | None = None,
        azimuth: float | None = None,
        horizon: float | None = None,
        row_step: float | None = None,
    ) -> None:
        """Fields as described; None stands for unturned, centred and square.

        Raises:
            CameraError: a size, position, rotation or number that no camera has.
        """
        _set_common(self, "CylinderCamera", center, width, height, rotation, azimuth)
        owner = "CylinderCamera"
        middle = (self.height - 1) / 2 if horizon is None else horizon
        step = FULL_TURN / self.width if row_step is None else row_step
        middle = check_number(owner, "horizon", middle, error=CameraError)
        step = check_number(owner, "row_step", step, 0.0, open_low=True, error=CameraError)
        object.__setattr__(self, "horizon", middle)
        object.__setattr__(self, "row_step", step)

    @classmethod
    def at(
        cls,
        center: npt.ArrayLike,
        forward: npt.ArrayLike = (1.0, 0.0, 0.0),
        up: npt.ArrayLike = (0.0, 0.0, 1.0),
        fov_deg: float | None = None,
        *,
        width: int,
        height: int,
    ) -> CylinderCamera:
        """A panorama taken at ``center`` about the axis ``up``.

        Args:
            center: (3,) position of the eye.
            forward: (3,) shown in the picture's middle; only its part across ``up`` counts.
            up: (3,) the cylinder's axis, upwards.
            fov_deg: vertical field of view in degrees, below 180; None makes pixels square.
            width: pixels round the full turn.
            height: pixels down.

        Raises:
            CameraError: ``forward`` is parallel to ``up``; a value out of range.
        """
        _, rows = check_image_size("CylinderCamera", width, height)
        step = None
        if fov_deg is not None:
            angle = check_number("CylinderCamera", "fov_deg", fov_deg, 0.0, 179.99,
                                 open_low=True, error=CameraError)  # fmt: skip
            step = 2.0 * math.tan(math.radians(angle) / 2) / rows
        turned = _upright_rotation("CylinderCamera", forward, up)
        return cls(center, width, height, turned, row_step=step)

    @property
    def fov(self) -> float:
        """Vertical field of view in radians, from the upper to the lower edge of the picture."""
        above, below = self.horizon + 0.5, self.height - 0.5 - self.horizon
        return math.atan(above * self.row_step) + math.atan(below * self.row_step)

    def rays(self, u: npt.ArrayLike, v: npt.ArrayLike) -> F8:
        """See `CameraModel.rays`; the rays reach to the cylinder of radius 1 m."""
        u8, v8 = np.broadcast_arrays(np.asarray(u, np.float64), np.asarray(v, np.float64))
        psi = self.azimuth - u8 * (FULL_TURN / self.width)
        local = np.stack([np.cos(psi), np.sin(psi), self.row_step * (self.horizon - v8)], axis=-1)
        return local @ self.rotation.T

    def project(self, points: npt.ArrayLike) -> tuple[F8, F8, F8]:
        """See `CameraModel.project`; ``delta = 1 / horizontal distance``.

        ``u`` is in [-0.5, width - 0.5). Points on the axis have no image: all NaN.
        """
        x, y, z = _local(self, points)
        delta = _reciprocal(np.hypot(x, y))
        u = _wrapped_column(self, np.arctan2(y, x)) + 0.0 * delta  # NaN wherever delta is
        return u, self.horizon - z * delta / self.row_step, delta

    def resized(self, width: int, height: int) -> CylinderCamera:
        """The same field of view on another grid of pixels (edges stay, centres move)."""
        check_image_size("CylinderCamera", width, height)
        scale = height / self.height
        return CylinderCamera(
            self.center,
            width,
            height,
            self.rotation,
            _resized_azimuth(self, width),
            (self.horizon + 0.5) * scale - 0.5,
            self.row_step / scale,
        )

    def moved(self, center: npt.ArrayLike) -> CylinderCamera:
        """The same camera at another place, turned the same way."""
        return CylinderCamera(
            center, self.width, self.height, self.rotation, self.azimuth, self.horizon,
            self.row_step,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False, init=False)
class SphereCamera(CameraModel):
    """A full equirectangular panorama: 360 x 180 degrees. `at` builds one from directions.

    The upper edge of the picture (row -0.5) is straight up, the lower edge straight down.
    """

    center: F8
    """(3,) world position of the eye, metres."""
    width: int
    """Pixels round the full turn."""
    height: int
    """Pixels from straight up to straight down."""
    rotation: F8
    """(3, 3) world_from_local: its columns are the directions of the picture's middle (x), of its
    left (y) and of its top (z)."""
    azimuth: float
    """Azimuth psi of the centre of column 0, radians. ``pi (width - 1) / width`` puts psi = 0 in
    the picture's middle."""

    def __init__(
        self,
        center: npt.ArrayLike,
        width: int,
        height: int,
        rotation: npt.ArrayLike | None = None,
        azimuth: float | None = None,
    ) -> None:
        """Fields as described; None stands for unturned and centred.

        Raises:
            CameraError: a size, position, rotation or number that no camera has.
        """
        _set_common(self, "SphereCamera", center, width, height, rotation, azimuth)

    @classmethod
    def at(
        cls,
        center: npt.ArrayLike,
        forward: npt.ArrayLike = (1.0, 0.0, 0.0),
        up: npt.ArrayLike = (0.0, 0.0, 1.0),
        *,
        width: int,
        height: int | None = None,
    ) -> SphereCamera:
        """A panorama taken at ``center``, its top toward ``up``.

        Args:
            center: (3,) position of the eye.
            forward: (3,) shown in the picture's middle column; only its part across ``up`` counts.
            up: (3,) direction of the picture's upper edge.
            width: pixels round the full turn.
            height: pixels down; None is half the width, which makes pixels square.

        Raises:
            CameraError: ``forward`` is parallel to ``up``; a value out of range.
        """
        columns, _ = check_image_size("SphereCamera", width, 1 if height is None else height)
        rows = max(columns // 2, 1) if height is None else height
        return cls(center, width, rows, _upright_rotation("SphereCamera", forward, up))

    def rays(self, u: npt.ArrayLike, v: npt.ArrayLike) -> F8:
        """See `CameraModel.rays`; the rays have unit length."""
        u8, v8 = np.broadcast_arrays(np.asarray(u, np.float64), np.asarray(v, np.float64))
        psi = self.azimuth - u8 * (FULL_TURN / self.width)
        lat = math.pi * (0.5 - (v8 + 0.5) / self.height)
        flat = np.cos(lat)
        return np.stack([flat * np.cos(psi), flat * np.sin(psi), np.sin(lat)], -1) @ self.rotation.T

    def project(self, points: npt.ArrayLike) -> tuple[F8, F8, F8]:
        """See `CameraModel.project`; ``delta = 1 / range``.

        ``u`` is in [-0.5, width - 0.5), ``v`` in [-0.5, height - 0.5]; straight above and below,
        where u could be anything, it is the middle column. The center itself has no image.
        """
        x, y, z = _local(self, points)
        flat = np.hypot(x, y)
        delta = _reciprocal(np.hypot(flat, z))
        lat = np.arctan2(z, flat)  # asin(z / range) would lose half the digits near the poles
        nan = 0.0 * delta  # NaN wherever delta is
        u = _wrapped_column(self, np.arctan2(y, x)) + nan
        return u, self.height * (0.5 - lat / math.pi) - 0.5 + nan, delta

    def resized(self, width: int, height: int) -> SphereCamera:
        """The same sphere on another grid of pixels (edges stay, centres move)."""
        check_image_size("SphereCamera", width, height)
        return SphereCamera(
            self.center, width, height, self.rotation, _resized_azimuth(self, width)
        )

    def moved(self, center: npt.ArrayLike) -> SphereCamera:
        """The same camera at another place, turned the same way."""
        return SphereCamera(center, self.width, self.height, self.rotation, self.azimuth)


Panoramic = CylinderCamera | SphereCamera


def _set_common(
    camera: Panoramic,
    owner: str,
    center: npt.ArrayLike,
    width: int,
    height: int,
    rotation: npt.ArrayLike | None,
    azimuth: float | None,
) -> None:
    """Check and set the fields both kinds share."""
    width, height = check_image_size(owner, width, height)
    place = as_array(owner, "center", center)
    check_shape(owner, "center", place, (3,), error=CameraError)
    check_finite(owner, "center", place, CameraError)
    turn = np.eye(3) if rotation is None else as_array(owner, "rotation", rotation)
    check_shape(owner, "rotation", turn, (3, 3), "its columns are world directions", CameraError)
    turn = check_pose(owner, "rotation", pose_matrix(turn, np.zeros(3)))[:3, :3]
    start = math.pi * (width - 1) / width if azimuth is None else azimuth
    start = check_number(owner, "azimuth", start, error=CameraError)
    for name, value in (
        ("center", frozen(place)),
        ("width", width),
        ("height", height),
        ("rotation", frozen(turn)),
        ("azimuth", start),
    ):
        object.__setattr__(camera, name, value)


def _upright_rotation(owner: str, forward: npt.ArrayLike, up: npt.ArrayLike) -> F8:
    """(3, 3) whose z is ``up`` and whose x is the part of ``forward`` across it."""
    vectors: list[F8] = []
    for name, value in (("forward", forward), ("up", up)):
        vector = as_array(owner, name, value)
        check_shape(owner, name, vector, (3,), error=CameraError)
        check_finite(owner, name, vector, CameraError)
        length = float(np.linalg.norm(vector))
        if length == 0:
            raise CameraError(f"{owner}.{name} is the zero vector, expected a direction")
        vectors.append(vector / length)
    ahead, top = vectors
    left = np.cross(top, ahead)
    sine = float(np.linalg.norm(left))
    if sine < 1e-9:
        raise CameraError(
            f"{owner}.forward {ahead.tolist()} is parallel to up: pass a direction to the side, "
            "it is what the picture's middle shows"
        )
    left = left / sine
    return np.column_stack([np.cross(left, top), left, top])


def _wrapped_column(camera: Panoramic, psi: F8) -> F8:
    """The column of azimuth ``psi``, in [-0.5, width - 0.5)."""
    turned = (camera.azimuth - psi) / FULL_TURN * camera.width + 0.5
    u = np.mod(turned, camera.width)
    return np.where(u >= camera.width, 0.0, u) - 0.5  # mod(-1e-20, w) rounds up to w


def _resized_azimuth(camera: Panoramic, width: int) -> float:
    """Azimuth of column 0 of a grid ``width`` wide with the same left edge."""
    return camera.azimuth + math.pi / camera.width - math.pi / width


def _local(camera: Panoramic, points: npt.ArrayLike) -> tuple[F8, F8, F8]:
    """x, y, z of world points in the camera's frame; NaN where a point is not finite."""
    with np.errstate(invalid="ignore", over="ignore"):
        local = (np.asarray(points, dtype=np.float64) - camera.center) @ camera.rotation
    finite = np.isfinite(local).all(axis=-1)
    x, y, z = (np.where(finite, local[..., axis], np.nan) for axis in range(3))
    return x, y, z


def _reciprocal(distance: F8) -> F8:
    """``1 / distance``; NaN where there is no distance to speak of."""
    return 1.0 / np.where(distance > NEAREST, distance, np.nan)
