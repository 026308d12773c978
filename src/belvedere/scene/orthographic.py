"""The orthographic camera: parallel rays that start on an image plane of true size.

::

    X = origin(u, v) + t forward       t = 1 / delta: metres in front of the image plane
    origin(u, v) = center + (u - (width - 1) / 2) pixel_size[0] right
                          + (v - (height - 1) / 2) pixel_size[1] down

What plans, elevations, sprites and impostors are drawn with. There is no eye: `center` is the
middle of the image plane.
"""

from __future__ import annotations

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
from belvedere.scene.pose import look_at_rotation, pose_matrix


@dataclass(frozen=True, slots=True, eq=False, init=False)
class OrthographicCamera(CameraModel):
    """A camera with parallel rays. Build one from a pose, or with `look_at` or `along`."""

    camera_to_world: F8
    """(4, 4) pose; axes x right, y down, z forward; origin at the picture's middle."""
    pixel_size: F8
    """(2,) metres across and down one pixel."""
    width: int
    """Pixels across."""
    height: int
    """Pixels down."""
    center: F8
    """(3,) world position of the picture's middle, on the image plane."""

    def __init__(
        self,
        camera_to_world: npt.ArrayLike,
        pixel_size: npt.ArrayLike,
        width: int,
        height: int,
    ) -> None:
        """Fields as described; ``pixel_size`` may be one number for square pixels.

        Raises:
            CameraError: a pose that is not rigid, a pixel size that is not positive.
        """
        owner = "OrthographicCamera"
        width, height = check_image_size(owner, width, height)
        pose = check_pose(owner, "camera_to_world", camera_to_world)
        size = as_array(owner, "pixel_size", pixel_size)
        size = np.repeat(size, 2) if size.shape == () else size
        check_shape(owner, "pixel_size", size, (2,), "one number, or across and down", CameraError)
        for number in size.tolist():
            check_number(owner, "pixel_size", number, 0.0, open_low=True, error=CameraError)
        for name, value in (
            ("camera_to_world", frozen(pose)),
            ("pixel_size", frozen(size)),
            ("width", width),
            ("height", height),
            ("center", frozen(pose[:3, 3])),
        ):
            object.__setattr__(self, name, value)

    @classmethod
    def look_at(
        cls,
        eye: npt.ArrayLike,
        target: npt.ArrayLike,
        up: npt.ArrayLike = (0.0, 0.0, 1.0),
        *,
        view_height: float,
        width: int,
        height: int,
    ) -> OrthographicCamera:
        """A camera whose image plane goes through ``eye`` and faces ``target``.

        Args:
            eye: (3,) the picture's middle; what lies behind its plane is not seen.
            target: (3,) point shown in the picture's middle.
            up: (3,) direction shown upwards; for a plan, looking straight down, (0, 1, 0).
            view_height: metres that the picture shows from its upper to its lower edge.
            width: pixels across; pixels are square.
            height: pixels down.

        Raises:
            CameraError: eye and target coincide, ``up`` is parallel to the line of sight, the
                height is not positive.
        """
        position = as_array("OrthographicCamera", "eye", eye)
        rotation = look_at_rotation(position, target, up)
        return cls._facing(rotation, position, view_height, width, height)

    @classmethod
    def along(
        cls,
        direction: npt.ArrayLike,
        center: npt.ArrayLike = (0.0, 0.0, 0.0),
        up: npt.ArrayLike = (0.0, 0.0, 1.0),
        *,
        view_height: float,
        width: int,
        height: int,
    ) -> OrthographicCamera:
        """A camera that looks along ``direction``, its image plane through ``center``.

        Arguments and errors otherwise as in `look_at`.
        """
        position = as_array("OrthographicCamera", "center", center)
        ahead = as_array("OrthographicCamera", "direction", direction)
        check_shape("OrthographicCamera", "center", position, (3,), error=CameraError)
        check_shape("OrthographicCamera", "direction", ahead, (3,), error=CameraError)
        check_finite("OrthographicCamera", "direction", ahead, CameraError)
        length = float(np.linalg.norm(ahead))
        if length == 0:
            raise CameraError("OrthographicCamera.direction is the zero vector")
        rotation = look_at_rotation(np.zeros(3), ahead, up)
        return cls._facing(rotation, position, view_height, width, height)

    @classmethod
    def _facing(
        cls, rotation: F8, position: F8, view_height: float, width: int, height: int
    ) -> OrthographicCamera:
        _, rows = check_image_size("OrthographicCamera", width, height)
        shown = check_number("OrthographicCamera", "view_height", view_height, 0.0,
                             open_low=True, error=CameraError)  # fmt: skip
        return cls(pose_matrix(rotation, position), shown / rows, width, height)

    @property
    def direction(self) -> F8:
        """(3,) unit vector along which every ray runs."""
        return self.camera_to_world[:3, 2]

    @property
    def view_size(self) -> tuple[float, float]:
        """Metres that the picture shows across and down, edge to edge."""
        return (
            self.width * float(self.pixel_size[0]),
            self.height * float(self.pixel_size[1]),
        )

    def rays(self, u: npt.ArrayLike, v: npt.ArrayLike) -> F8:
        """See `CameraModel.rays`; every ray is `direction`."""
        shape = np.broadcast_shapes(np.shape(u), np.shape(v))
        return np.broadcast_to(self.direction, (*shape, 3))

    def origins(self, u: npt.ArrayLike, v: npt.ArrayLike) -> F8:
        """(..., 3) where each pixel's ray starts: its centre, on the image plane."""
        u8, v8 = np.asarray(u, dtype=np.float64), np.asarray(v, dtype=np.float64)
        right, down = self.camera_to_world[:3, 0], self.camera_to_world[:3, 1]
        x = (u8 - (self.width - 1) / 2) * self.pixel_size[0]
        y = (v8 - (self.height - 1) / 2) * self.pixel_size[1]
        return self.center + x[..., None] * right + y[..., None] * down

    def project(self, points: npt.ArrayLike) -> tuple[F8, F8, F8]:
        """See `CameraModel.project`; ``delta = 1 / t``, t metres in front of the image plane."""
        with np.errstate(invalid="ignore", over="ignore"):  # points that are not finite
            offset = np.asarray(points, dtype=np.float64) - self.center
            local = offset @ self.camera_to_world[:3, :3]
        seen = (local[..., 2] > NEAREST) & np.isfinite(local).all(axis=-1)
        delta = 1.0 / np.where(seen, local[..., 2], np.nan)
        x, y = np.where(seen, local[..., 0], np.nan), np.where(seen, local[..., 1], np.nan)
        return (
            x / self.pixel_size[0] + (self.width - 1) / 2,
            y / self.pixel_size[1] + (self.height - 1) / 2,
            delta,
        )

    def resized(self, width: int, height: int) -> OrthographicCamera:
        """The same part of the world on another grid of pixels (edges stay, centres move)."""
        check_image_size("OrthographicCamera", width, height)
        scale = np.array([self.width / width, self.height / height])
        return OrthographicCamera(self.camera_to_world, self.pixel_size * scale, width, height)

    def moved(self, center: npt.ArrayLike) -> OrthographicCamera:
        """The same camera with its picture's middle at another place, looking the same way."""
        position = as_array("OrthographicCamera", "center", center)
        check_shape("OrthographicCamera", "center", position, (3,), error=CameraError)
        pose = pose_matrix(self.camera_to_world[:3, :3], position)
        return OrthographicCamera(pose, self.pixel_size, self.width, self.height)
