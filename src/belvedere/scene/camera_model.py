"""What every camera can do, whatever its image manifold (plane, cylinder, sphere, parallel rays).

The image of a world point is a pixel ``(u, v)`` and a generalised disparity ``delta``::

    X = origin(u, v) + ray(u, v) / delta        delta = 1 / t; 0 is infinitely far, NaN no sample

so that projecting and unprojecting are inverse to each other for every camera. Central cameras
have one origin, their center; an orthographic camera has one a pixel.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
import numpy.typing as npt

F8 = npt.NDArray[np.float64]

NEAREST = 1e-100
"""Metres. What is nearer to a camera than this has no image: its disparity could overflow."""


class CameraModel(ABC):
    """A camera of any kind. World units are metres, pixel centres lie at integers."""

    __slots__ = ()

    width: int
    height: int
    center: F8
    """(3,) world position: of the eye, or of the image's middle for an orthographic camera."""

    @property
    def size(self) -> tuple[int, int]:
        """``(height, width)``, the shape of an image of this camera."""
        return (self.height, self.width)

    @abstractmethod
    def rays(self, u: npt.ArrayLike, v: npt.ArrayLike) -> F8:
        """World direction of each pixel, scaled so that ``X = origin + ray / delta``.

        Args:
            u: (...) columns, pixel centres at integers.
            v: (...) rows, broadcast against ``u``.

        Returns:
            (..., 3) directions, not of unit length in general.
        """

    @abstractmethod
    def project(self, points: npt.ArrayLike) -> tuple[F8, F8, F8]:
        """Image of world points.

        Args:
            points: (..., 3) world positions.

        Returns:
            ``u``, ``v``, ``delta``, each (...); all NaN where a point has no image (behind the
            camera, at its center, or not finite). ``u, v`` may lie outside the image.
        """

    @abstractmethod
    def resized(self, width: int, height: int) -> Any:
        """The same field of view on another grid of pixels."""

    def origins(self, u: npt.ArrayLike, v: npt.ArrayLike) -> F8:
        """(..., 3) where each pixel's ray starts: the center, for a central camera."""
        shape = np.broadcast_shapes(np.shape(u), np.shape(v))
        return np.broadcast_to(self.center, (*shape, 3))

    def unproject(self, u: npt.ArrayLike, v: npt.ArrayLike, delta: npt.ArrayLike) -> F8:
        """World position of pixels with known disparity.

        Args:
            u: (...) columns.
            v: (...) rows.
            delta: (...) disparities. 0 gives points at infinity (``inf`` or NaN coordinates).

        Returns:
            (..., 3) positions.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            t = 1.0 / np.asarray(delta, dtype=np.float64)
            return self.origins(u, v) + self.rays(u, v) * t[..., None]

    def pixel_grid(self) -> tuple[F8, F8]:
        """``u`` of shape (1, width) and ``v`` of shape (height, 1): every pixel's centre."""
        return np.arange(self.width, dtype=np.float64)[None, :], np.arange(
            self.height, dtype=np.float64
        )[:, None]


def frozen(array: npt.ArrayLike) -> F8:
    """A private float64 copy that cannot be written to."""
    copy = np.array(array, dtype=np.float64)
    copy.setflags(write=False)
    return copy
