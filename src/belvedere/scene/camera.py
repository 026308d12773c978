"""The planar camera, McMillan's ``(P, C)`` with its image plane at unit depth.

::

    X = C + t P (u, v, 1)        t = Z, the depth along the camera's axis
    P = [a b c]                  a: world step of one pixel right, b: one pixel down,
                                 c: from the center of projection to pixel (0, 0)
    delta = 1 / t = 1 / Z        generalised disparity, in 1/metre

Source: McMillan's course notes, eq. 1-2; spec image-warping 2.
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
from belvedere.scene.pose import look_at_rotation, pose_matrix

PLANE_TOLERANCE = 1e-6
"""Relative error of the image plane's depth that float64 camera algebra may leave."""


@dataclass(frozen=True, slots=True, eq=False)
class Camera(CameraModel):
    """A planar pinhole camera. Build one with `from_intrinsics`, `look_at` or another builder."""

    matrix: F8
    """(3, 3) P: ``P @ (u, v, 1)`` is the world ray of pixel (u, v), reaching to unit depth."""
    center: F8
    """(3,) world position of the center of projection, metres."""
    width: int
    """Pixels across."""
    height: int
    """Pixels down."""

    def __post_init__(self) -> None:
        owner = "Camera"
        width, height = check_image_size(owner, self.width, self.height)
        matrix = as_array(owner, "matrix", self.matrix)
        center = as_array(owner, "center", self.center)
        check_shape(owner, "matrix", matrix, (3, 3), error=CameraError)
        check_shape(owner, "center", center, (3,), error=CameraError)
        check_finite(owner, "matrix", matrix, CameraError)
        check_finite(owner, "center", center, CameraError)
        depth = _plane_depth(matrix)
        if abs(depth - 1.0) > PLANE_TOLERANCE:
            raise CameraError(
                f"Camera.matrix has its image plane at depth {depth:.6g}, expected 1 so that "
                "disparity is 1/Z: use Camera.from_matrix, which rescales it, and divide your "
                f"disparities by {depth:.6g}"
            )
        for name, value in (
            ("matrix", frozen(matrix)),
            ("center", frozen(center)),
            ("width", width),
            ("height", height),
        ):
            object.__setattr__(self, name, value)

    # ---- builders ------------------------------------------------------------------------------

    @classmethod
    def from_matrix(
        cls, matrix: npt.ArrayLike, center: npt.ArrayLike, *, width: int, height: int
    ) -> Camera:
        """A camera from rays at any plane distance: ``matrix`` is rescaled to unit depth.

        Args:
            matrix: (3, 3) ``[a b c]``; its sign makes forward rays positive.
            center: (3,) center of projection.
            width: pixels across.
            height: pixels down.

        Raises:
            CameraError: the matrix is singular, mirrors the image or is not finite.
        """
        array = as_array("Camera", "matrix", matrix)
        check_shape("Camera", "matrix", array, (3, 3), error=CameraError)
        check_finite("Camera", "matrix", array, CameraError)
        return cls(array / _plane_depth(array), as_array("Camera", "center", center), width, height)

    @classmethod
    def from_intrinsics(
        cls, K: npt.ArrayLike, camera_to_world: npt.ArrayLike, width: int, height: int
    ) -> Camera:
        """A camera from OpenCV's intrinsics and a pose.

        Args:
            K: (3, 3) ``[[fx, skew, cx], [0, fy, cy], [0, 0, 1]]``, pixels, centres at integers.
            camera_to_world: (4, 4) pose; camera axes x right, y down, z forward.
            width: pixels across.
            height: pixels down.

        Raises:
            CameraError: K is not of that form, a focal length is not positive, the pose is not
                rigid (see `check_pose`).
        """
        k = as_array("Camera", "K", K)
        check_shape("Camera", "K", k, (3, 3), error=CameraError)
        check_finite("Camera", "K", k, CameraError)
        if not (np.allclose(k[2], [0, 0, 1]) and k[1, 0] == 0):
            raise CameraError(
                f"Camera.K has the rows {k[1].tolist()} and {k[2].tolist()}, expected "
                "[0, fy, cy] and [0, 0, 1]: is it transposed or a projection matrix?"
            )
        for name, focal in (("fx", k[0, 0]), ("fy", k[1, 1])):
            check_number("Camera.K", name, focal, 0.0, open_low=True, error=CameraError)
        pose = check_pose("Camera", "camera_to_world", camera_to_world)
        return cls(pose[:3, :3] @ np.linalg.inv(k), pose[:3, 3], width, height)

    @classmethod
    def from_fov(
        cls, fov_deg: float, camera_to_world: npt.ArrayLike, width: int, height: int
    ) -> Camera:
        """A camera with square pixels, a centred axis and a vertical field of view in degrees.

        Raises:
            CameraError: the angle is not between 0 and 180 degrees; the pose is not rigid.
        """
        check_image_size("Camera", width, height)
        angle = check_number("Camera", "fov_deg", fov_deg, 0.0, 179.99, open_low=True,
                             error=CameraError)  # fmt: skip
        focal = 0.5 * height / math.tan(math.radians(angle) / 2)
        k = [[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]]
        return cls.from_intrinsics(k, camera_to_world, width, height)

    @classmethod
    def look_at(
        cls,
        eye: npt.ArrayLike,
        target: npt.ArrayLike,
        up: npt.ArrayLike = (0.0, 0.0, 1.0),
        fov_deg: float = 60.0,
        *,
        width: int = 640,
        height: int = 480,
    ) -> Camera:
        """A camera at ``eye`` that looks at ``target``, its picture's top toward ``up``.

        Args:
            eye: (3,) center of projection, metres.
            target: (3,) point shown in the middle of the picture.
            up: (3,) direction shown upwards; not parallel to the line of sight.
            fov_deg: vertical field of view in degrees.
            width: pixels across.
            height: pixels down.

        Raises:
            CameraError: eye and target coincide, ``up`` is parallel to the line of sight.
        """
        position = as_array("Camera", "eye", eye)
        return cls.from_fov(
            fov_deg, pose_matrix(look_at_rotation(position, target, up), position), width, height
        )

    @classmethod
    def through_rectangle(
        cls,
        eye: npt.ArrayLike,
        corner: npt.ArrayLike,
        right: npt.ArrayLike,
        down: npt.ArrayLike,
        *,
        width: int,
        height: int,
    ) -> Camera:
        """An off-axis camera whose picture is exactly a rectangle in the world (a portal).

        Args:
            eye: (3,) center of projection, off the rectangle's plane.
            corner: (3,) the rectangle's corner at the picture's upper left.
            right: (3,) the rectangle's upper edge, corner to corner.
            down: (3,) its left edge, at a right angle to ``right``.
            width: pixels across.
            height: pixels down.

        Raises:
            CameraError: the eye lies in the rectangle's plane or sees it from behind (the
                picture would be mirrored); the edges are not perpendicular.
        """
        check_image_size("Camera", width, height)
        position, origin, across, along = (
            as_array("Camera", name, value)
            for name, value in (("eye", eye), ("corner", corner), ("right", right), ("down", down))
        )
        for name, vector in (("eye", position), ("corner", origin), ("right", across),
                             ("down", along)):  # fmt: skip
            check_shape("Camera", name, vector, (3,), error=CameraError)
            check_finite("Camera", name, vector, CameraError)
        lengths = float(np.linalg.norm(across) * np.linalg.norm(along))
        if lengths == 0 or abs(across @ along) > 1e-6 * lengths:
            raise CameraError(
                "Camera.through_rectangle: right and down are not the perpendicular edges of a "
                f"rectangle (right {across.tolist()}, down {along.tolist()})"
            )
        a, b = across / width, along / height
        c = origin - position + 0.5 * (a + b)
        return cls.from_matrix(np.column_stack([a, b, c]), position, width=width, height=height)

    # ---- what it is ----------------------------------------------------------------------------

    @property
    def forward(self) -> F8:
        """(3,) unit vector along the camera's axis, the normal of its image plane."""
        normal = np.cross(self.matrix[:, 0], self.matrix[:, 1])
        return normal / np.linalg.norm(normal)

    @property
    def intrinsics(self) -> F8:
        """(3, 3) OpenCV's K, pixels, pixel centres at integers."""
        return self._intrinsics_and_rotation()[0]

    @property
    def camera_to_world(self) -> F8:
        """(4, 4) pose; camera axes x right, y down, z forward."""
        return pose_matrix(self._intrinsics_and_rotation()[1], self.center)

    @property
    def world_to_camera(self) -> F8:
        """(4, 4) inverse of `camera_to_world`."""
        rotation = self._intrinsics_and_rotation()[1].T
        return pose_matrix(rotation, -rotation @ self.center)

    @property
    def fov(self) -> float:
        """Vertical field of view in radians, from the upper to the lower edge of the picture."""
        k = self.intrinsics
        top, bottom = k[1, 2] + 0.5, self.height - 0.5 - k[1, 2]
        return math.atan(top / k[1, 1]) + math.atan(bottom / k[1, 1])

    @property
    def edge_planes(self) -> F8:
        """(4, 3) unit normals of the planes through the eye and the picture's outer edges.

        They point inwards: a direction is in the picture where its product with none is negative.
        """
        u = np.array([-0.5, self.width - 0.5, self.width - 0.5, -0.5])
        v = np.array([-0.5, -0.5, self.height - 0.5, self.height - 0.5])
        rays = self.rays(u, v)
        planes = np.cross(rays, np.roll(rays, -1, axis=0))
        planes *= np.sign(planes @ rays.sum(axis=0))[:, None]
        return planes / np.linalg.norm(planes, axis=1, keepdims=True)

    def _intrinsics_and_rotation(self) -> tuple[F8, F8]:
        """K and R of ``inverse(P) = K R^T``, by an RQ decomposition with positive focals."""
        inverse = np.linalg.inv(self.matrix)
        q, r = np.linalg.qr(inverse[::-1].T)
        k, rotation_t = r.T[::-1, ::-1], q.T[::-1]
        signs = np.sign(np.diag(k))
        k, rotation_t = k * signs, signs[:, None] * rotation_t
        return k / k[2, 2], rotation_t.T

    # ---- what it does --------------------------------------------------------------------------

    def rays(self, u: npt.ArrayLike, v: npt.ArrayLike) -> F8:
        """See `CameraModel.rays`; the rays reach to unit depth."""
        u8, v8 = np.asarray(u, dtype=np.float64), np.asarray(v, dtype=np.float64)
        a, b, c = self.matrix.T
        return u8[..., None] * a + v8[..., None] * b + c

    def project(self, points: npt.ArrayLike) -> tuple[F8, F8, F8]:
        """See `CameraModel.project`; ``delta = 1 / Z``."""
        with np.errstate(invalid="ignore", over="ignore"):  # points that are not finite
            offset = np.asarray(points, dtype=np.float64) - self.center
            image = offset @ np.linalg.inv(self.matrix).T
        seen = (image[..., 2] > NEAREST) & np.isfinite(image).all(axis=-1)
        depth = np.where(seen, image[..., 2], np.nan)
        return image[..., 0] / depth, image[..., 1] / depth, 1.0 / depth

    def resized(self, width: int, height: int) -> Camera:
        """The same field of view on another grid of pixels (edges stay, centres move)."""
        check_image_size("Camera", width, height)
        su, sv = self.width / width, self.height / height
        grid = np.array([[su, 0, 0.5 * su - 0.5], [0, sv, 0.5 * sv - 0.5], [0, 0, 1]])
        return Camera(self.matrix @ grid, self.center, width, height)

    def cropped(self, left: int, top: int, width: int, height: int) -> Camera:
        """The camera of a part of the picture; the part may reach outside it."""
        shift = np.array([[1.0, 0, left], [0, 1.0, top], [0, 0, 1.0]])
        return Camera(self.matrix @ shift, self.center, width, height)

    def moved(self, center: npt.ArrayLike) -> Camera:
        """The same camera at another place, looking the same way."""
        return Camera(self.matrix, as_array("Camera", "center", center), self.width, self.height)


def _plane_depth(matrix: F8) -> float:
    """Distance of the image plane from the center of projection along the plane's normal."""
    normal = np.cross(matrix[:, 0], matrix[:, 1])
    length = float(np.linalg.norm(normal))
    scale = float(np.abs(matrix).max())
    if length == 0 or abs(np.linalg.det(matrix)) <= 1e-14 * scale * length:
        raise CameraError(
            "Camera.matrix is singular: its columns (pixel right, pixel down, to pixel 0,0) must "
            "span space; is a focal length zero or infinite?"
        )
    depth = float(normal @ matrix[:, 2]) / length
    if depth < 0:
        raise CameraError(
            "Camera.matrix mirrors the picture or looks backwards (negative determinant): "
            "its columns must be right, down and toward the scene"
        )
    return depth
