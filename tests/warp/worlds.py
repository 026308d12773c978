"""Small exact worlds to warp: planes, boxes before walls, noise, cameras anywhere."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.scene import Camera, CameraModel, Frame, ReferenceView

F4 = npt.NDArray[np.float32]
F8 = npt.NDArray[np.float64]
FORWARD_Y = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
"""Columns right, down, forward: looks along +y with +z up."""

VISIBILITIES = ("order", "zbuffer")


def straight_camera(
    width: int, height: int, center: npt.ArrayLike = (0, 0, 0), focal: float | None = None
) -> Camera:
    """Looks along +y; focal length in pixels, by default the width."""
    f = float(focal or width)
    k_inverse = np.linalg.inv([[f, 0, (width - 1) / 2], [0, f, (height - 1) / 2], [0, 0, 1]])
    return Camera(FORWARD_Y @ k_inverse, np.asarray(center, float), width, height)


def rolled(camera: Camera, degrees: float) -> Camera:
    """The camera turned about its axis, through the middle of its picture."""
    a = math.radians(degrees)
    middle = np.array([[1, 0, (camera.width - 1) / 2], [0, 1, (camera.height - 1) / 2], [0, 0, 1]])
    roll = np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])
    matrix = camera.matrix @ middle @ roll @ np.linalg.inv(middle)
    return Camera(matrix, camera.center, camera.width, camera.height)


def random_rotation(rng: np.random.Generator, most: float = np.pi) -> F8:
    """(3, 3) turn about a random axis by up to ``most`` radians."""
    axis = rng.normal(size=3)
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = rng.uniform(-most, most)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def random_camera(
    rng: np.random.Generator,
    width: int,
    height: int,
    reach: float = 1.0,
    turn: float = 0.3,
) -> Camera:
    """Off-axis, oblong pixels, anywhere within ``reach``, turned by up to ``turn`` from +y."""
    k = [
        [width * rng.uniform(0.5, 2), width * rng.uniform(-0.1, 0.1), width * rng.uniform(0, 1)],
        [0, height * rng.uniform(0.5, 2), height * rng.uniform(0, 1)],
        [0, 0, 1],
    ]
    rotation = random_rotation(rng, turn) @ FORWARD_Y
    return Camera(rotation @ np.linalg.inv(k), rng.normal(size=3) * reach, width, height)


def noise(rng: np.random.Generator, height: int, width: int, kind: str = "rgb8") -> Any:
    """Random colours: "rgb8", "rgba8", "rgb32" or "rgba32"."""
    shape = (height, width, 4 if "a" in kind else 3)
    if kind.endswith("8"):
        return rng.integers(0, 256, shape).astype(np.uint8)
    return rng.uniform(0.0, 4.0, shape).astype(np.float32)


def plane_disparity(camera: Camera, normal: npt.ArrayLike, offset: float) -> F8:
    """(H, W) disparity of the plane ``normal . X = offset``: affine in (u, v)."""
    n = np.asarray(normal, float)
    return camera.rays(*camera.pixel_grid()) @ n / (offset - n @ camera.center)


def boards(
    rng: np.random.Generator, height: int, width: int, count: int = 5, wall: float = 0.2
) -> tuple[F4, npt.NDArray[np.int64]]:
    """Frontal boards before a frontal wall: (H, W) disparity and surface, none touching another."""
    disparity = np.full((height, width), wall, np.float32)
    label = np.zeros((height, width), np.int64)
    for surface in range(1, count + 1):
        for _ in range(20):
            u, v = rng.integers(0, width - 2), rng.integers(0, height - 2)
            across, down = rng.integers(2, width // 3), rng.integers(2, height // 3)
            here = np.s_[v : v + down, u : u + across]
            apart = np.s_[max(v - 1, 0) : v + down + 1, max(u - 1, 0) : u + across + 1]
            if not label[apart].any():
                label[here] = surface
                disparity[here] = wall * rng.uniform(1.5, 6.0)
                break
    return disparity, label


def checks(camera: Camera, size: int = 4) -> npt.NDArray[np.uint8]:
    """(H, W, 3) a chequered picture."""
    u, v = camera.pixel_grid()
    dark = (np.floor(u / size) + np.floor(v / size)) % 2 == 0
    return np.where(dark[..., None], 60, 200).repeat(3, axis=-1).astype(np.uint8)


def grey(height: int, width: int, value: int = 128) -> npt.NDArray[np.uint8]:
    """(H, W, 3) one grey."""
    return np.full((height, width, 3), value, np.uint8)


def same(a: Frame, b: Frame) -> bool:
    """Whether two frames agree to the last bit."""
    return (
        a.color.tobytes() == b.color.tobytes()
        and a.disparity.tobytes() == b.disparity.tobytes()
        and a.coverage.tobytes() == b.coverage.tobytes()
    )


def view_of(camera: CameraModel, disparity: npt.ArrayLike, color: Any = None) -> ReferenceView:
    """A reference view, grey unless told."""
    held = grey(*camera.size) if color is None else color
    return ReferenceView(camera, held, np.asarray(disparity, np.float32))
