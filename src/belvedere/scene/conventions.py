"""How a capture's numbers are to be read: scale, kind of depth, pose, axes, pixel centres.

Data sets disagree on all five and rarely say so. A reader takes a `Conventions`, turns the stored
numbers into our camera and disparity with `read_camera` and `read_disparity`, and nothing else in
the library ever sees a foreign convention.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import as_array, check_choice, check_number, check_pose, check_shape
from belvedere.ground.errors import CameraError, InputError
from belvedere.scene.camera import Camera
from belvedere.scene.pose import OPENCV_FROM_OPENGL, invert_pose

DepthKind = Literal["z", "ray", "disparity"]
PoseKind = Literal["camera_to_world", "world_to_camera"]
Axes = Literal["opencv", "opengl"]
PixelCenters = Literal["integer", "half"]

DEPTH_KINDS = ("z", "ray", "disparity")
POSES = ("camera_to_world", "world_to_camera")
AXES = ("opencv", "opengl")
PIXEL_CENTERS = ("integer", "half")


@dataclass(frozen=True, slots=True)
class Conventions:
    """How a capture's numbers are to be read. The defaults are this library's own."""

    depth_scale: float | None = None
    """Metres per stored unit (0.001 for millimetres), or 1/metre per stored unit of disparity.
    None: what the file format says."""
    depth_kind: DepthKind = "z"
    """``z``: along the camera's axis; ``ray``: length of the ray; ``disparity``: 1 / z."""
    pose: PoseKind = "camera_to_world"
    """Which way the 4x4 matrices map."""
    axes: Axes = "opencv"
    """Camera axes: ``opencv`` x right, y down, z forward; ``opengl`` x right, y up, z backward."""
    pixel_centers: PixelCenters = "integer"
    """Where K puts the centre of the first pixel: at 0 (``integer``) or at 0.5 (``half``)."""

    def __post_init__(self) -> None:
        owner = "Conventions"
        if self.depth_scale is not None:
            scale = check_number(owner, "depth_scale", self.depth_scale, 0.0, open_low=True)
            object.__setattr__(self, "depth_scale", scale)
        check_choice(owner, "depth_kind", self.depth_kind, DEPTH_KINDS)
        check_choice(owner, "pose", self.pose, POSES)
        check_choice(owner, "axes", self.axes, AXES)
        check_choice(owner, "pixel_centers", self.pixel_centers, PIXEL_CENTERS)

    def resolved(self, depth_scale: float) -> Conventions:
        """These conventions with ``depth_scale`` where none was stated."""
        return self if self.depth_scale is not None else replace(self, depth_scale=depth_scale)

    def read_camera(self, K: npt.ArrayLike, pose: npt.ArrayLike, width: int, height: int) -> Camera:
        """The planar camera that stored intrinsics and a stored pose mean.

        Args:
            K: (3, 3) as stored, pixels.
            pose: (4, 4) as stored; rigid.
            width: pixels across.
            height: pixels down.

        Raises:
            CameraError: see `Camera.from_intrinsics`.
        """
        k = as_array("Camera", "K", K).copy()
        check_shape("Camera", "K", k, (3, 3), error=CameraError)
        if self.pixel_centers == "half":
            k[:2, 2] -= 0.5
        return Camera.from_intrinsics(k, self.read_pose(pose), width, height)

    def read_pose(self, pose: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """(4, 4) camera-to-world with our camera axes, from a stored (4, 4) pose.

        Raises:
            CameraError: the pose is not rigid (see `check_pose`).
        """
        matrix = check_pose("Camera", "pose", pose)
        if self.pose == "world_to_camera":
            matrix = invert_pose(matrix)
        return matrix @ OPENCV_FROM_OPENGL if self.axes == "opengl" else matrix

    def read_disparity(self, depth: npt.ArrayLike, camera: Camera) -> npt.NDArray[np.float32]:
        """Generalised disparity from a stored depth map.

        Args:
            depth: (H, W) stored units, integers or floating point. 0, NaN, infinity and negative
                values mean "no sample", for every kind of depth.
            camera: of `read_camera`; ``ray`` depth needs its rays.

        Returns:
            (H, W) float32 ``1 / Z`` in 1/metre; NaN where there is no sample.

        Raises:
            InputError: ``depth_scale`` is None, or the map has another size than the camera.
        """
        if self.depth_scale is None:
            raise InputError(
                "Conventions.depth_scale is None, expected metres per stored unit: pass "
                "depth_scale=0.001 for millimetres, or use Conventions.resolved"
            )
        values: npt.NDArray[Any] = as_array("Conventions", "depth", depth)
        check_shape("Conventions", "depth", values, camera.size, "resize it to its camera")
        with np.errstate(all="ignore"):
            known = np.isfinite(values) & (values > 0)
            metres = np.where(known, values, np.nan) * self.depth_scale
            if self.depth_kind == "disparity":
                return metres.astype(np.float32)
            if self.depth_kind == "ray":
                metres /= ray_lengths(camera.intrinsics, camera.width, camera.height)
            return (1.0 / metres).astype(np.float32)


def ray_lengths(K: npt.NDArray[Any], width: int, height: int) -> npt.NDArray[np.float64]:
    """(height, width) length of the rays that reach unit depth: range divided by z-depth."""
    v, u = np.mgrid[0:height, 0:width].astype(np.float64)
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(K).T
    return np.linalg.norm(rays, axis=-1)
