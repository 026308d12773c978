"""Hypothesis strategies for the nouns: poses, cameras of every kind, points they see."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from hypothesis import strategies as st

from belvedere.scene import (
    Camera,
    CameraModel,
    CylinderCamera,
    OrthographicCamera,
    SphereCamera,
)
from belvedere.scene.pose import pose_matrix, rotation_from_quaternion

F8 = npt.NDArray[np.float64]


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    """Finite floats in [low, high]."""
    return st.floats(low, high, allow_nan=False, allow_infinity=False, allow_subnormal=False)


@st.composite
def places(draw: st.DrawFn, reach: float = 10.0) -> F8:
    """(3,) positions, metres."""
    return np.array([draw(numbers(-reach, reach)) for _ in range(3)])


@st.composite
def quaternions(draw: st.DrawFn) -> tuple[float, float, float, float]:
    """Unit quaternions (w, x, y, z), half turns and the identity among them."""
    parts = np.array([draw(numbers(-1.0, 1.0)) for _ in range(4)])
    length = float(np.linalg.norm(parts))
    if length < 1e-3:
        parts, length = np.array([1.0, 0.0, 0.0, 0.0]), 1.0
    w, x, y, z = (parts / length).tolist()
    return w, x, y, z


@st.composite
def rotations(draw: st.DrawFn) -> F8:
    """(3, 3) rotations."""
    return rotation_from_quaternion(*draw(quaternions()))


@st.composite
def poses(draw: st.DrawFn) -> F8:
    """(4, 4) camera-to-world poses."""
    return pose_matrix(draw(rotations()), draw(places()))


@st.composite
def sizes(draw: st.DrawFn, largest: int = 64) -> tuple[int, int]:
    """(width, height) of pictures."""
    return draw(st.integers(1, largest)), draw(st.integers(1, largest))


@st.composite
def planar_cameras(draw: st.DrawFn, skewed: bool = True, largest: int = 64) -> Camera:
    """Planar cameras, off-axis ones and oblong and slanted pixels among them."""
    width, height = draw(sizes(largest))
    fx = draw(numbers(0.3, 3.0)) * width
    k = [
        [fx, draw(numbers(-0.2, 0.2)) * fx if skewed else 0.0, draw(numbers(-0.5, 1.5)) * width],
        [0.0, draw(numbers(0.3, 3.0)) * height, draw(numbers(-0.5, 1.5)) * height],
        [0.0, 0.0, 1.0],
    ]
    return Camera.from_intrinsics(k, draw(poses()), width, height)


@st.composite
def cylinder_cameras(draw: st.DrawFn) -> CylinderCamera:
    """Cylinders, turned and tilted."""
    width, height = draw(sizes())
    return CylinderCamera(
        draw(places()),
        width,
        height,
        draw(rotations()),
        draw(numbers(-7.0, 7.0)),
        draw(numbers(-0.5, 1.5)) * height,
        draw(numbers(0.2, 3.0)) * 2.0 * math.pi / width,
    )


@st.composite
def sphere_cameras(draw: st.DrawFn) -> SphereCamera:
    """Spheres, turned and tilted."""
    width, height = draw(sizes())
    return SphereCamera(draw(places()), width, height, draw(rotations()), draw(numbers(-7.0, 7.0)))


@st.composite
def orthographic_cameras(draw: st.DrawFn) -> OrthographicCamera:
    """Orthographic cameras with oblong pixels."""
    width, height = draw(sizes())
    pixel = [draw(numbers(0.01, 0.2)), draw(numbers(0.01, 0.2))]
    return OrthographicCamera(draw(poses()), pixel, width, height)


def any_cameras() -> st.SearchStrategy[CameraModel]:
    """Cameras of every kind."""
    return st.one_of(planar_cameras(), cylinder_cameras(), sphere_cameras(), orthographic_cameras())


@st.composite
def pixels(draw: st.DrawFn, camera: CameraModel, margin: float = 0.45) -> tuple[float, float]:
    """(u, v) inside a camera's picture, ``margin`` of half a pixel away from its edges."""
    return (
        draw(numbers(-margin, camera.width - 1 + margin)),
        draw(numbers(-margin, camera.height - 1 + margin)),
    )
