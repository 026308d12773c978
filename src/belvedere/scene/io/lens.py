"""Lens distortion, taken out on import: planar cameras have straight rays.

The undistorted picture keeps the focal lengths and the principal point's ray; it is cut to a
rectangle without a single unknown pixel that cannot grow on any side. Colour is resampled
bilinearly in linear light, depth by the nearest sample (depth edges stay edges).

Source: OpenCV's camera model, with which COLMAP's and nerfstudio's coefficients agree.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import color_to_linear, color_to_srgb8
from belvedere.ground.errors import MissingDependencyError, SceneError

F4 = npt.NDArray[np.float32]
BLOCKS = 128
"""Cells a side in which the first guess of the crop is searched, before it grows by pixels."""


@dataclass(frozen=True, slots=True)
class Lens:
    """A distorting lens with its picture. Numbers in pixels, pixel centres at integers."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    coefficients: tuple[float, ...]
    """OpenCV's order: k1 k2 p1 p2 [k3 [k4 k5 k6]], or k1 k2 k3 k4 for a fisheye."""
    fisheye: bool = False
    left: int = 0
    """First column of the crop, in the undistorted picture's pixels; may be negative."""
    top: int = 0
    """First row of the crop."""

    @property
    def straight(self) -> bool:
        """Whether the lens does nothing, so that nothing need be resampled.

        A fisheye with zero coefficients still bends: its radius goes with the angle.
        """
        return not self.fisheye and not any(self.coefficients)

    @property
    def intrinsics(self) -> npt.NDArray[np.float64]:
        """(3, 3) intrinsics of the distorted picture, without its distortion."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1.0]])

    def maps(self, left: int, top: int, width: int, height: int) -> tuple[F4, F4]:
        """(height, width) column and row in the distorted picture of each undistorted pixel."""
        cv2 = _opencv()
        k = self.intrinsics
        shifted = k - np.array([[0, 0, left], [0, 0, top], [0, 0, 0.0]])
        module = cv2.fisheye if self.fisheye else cv2
        coefficients = np.array(self.coefficients, dtype=np.float64)
        return module.initUndistortRectifyMap(
            k, coefficients, np.eye(3), shifted, (width, height), cv2.CV_32FC1
        )


@dataclass(frozen=True, slots=True)
class Crop:
    """What is left of a picture once its lens is taken out."""

    lens: Lens
    left: int
    top: int
    width: int
    height: int

    @property
    def intrinsics(self) -> npt.NDArray[np.float64]:
        """(3, 3) intrinsics of the cropped, undistorted picture; pixel centres at integers."""
        return self.lens.intrinsics - np.array([[0, 0, self.left], [0, 0, self.top], [0, 0, 0.0]])

    def as_fact(self) -> dict[str, Any]:
        """The crop, for a set's facts."""
        return {
            "from": [self.lens.width, self.lens.height],
            "to": [self.width, self.height],
            "left": self.left,
            "top": self.top,
        }

    def color(self, pixels: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """(height, width, channels) colour without the distortion."""
        cv2 = _opencv()
        linear = np.ascontiguousarray(color_to_linear(pixels))
        out = cv2.remap(linear, *self._maps(), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return color_to_srgb8(out) if pixels.dtype == np.uint8 else out

    def depth(self, values: F4) -> F4:
        """(height, width) stored depth without the distortion, by the nearest sample."""
        columns, rows = (np.rint(values_).astype(np.intp) for values_ in self._maps())
        return values[rows.clip(0, values.shape[0] - 1), columns.clip(0, values.shape[1] - 1)]

    def _maps(self) -> tuple[F4, F4]:
        return self.lens.maps(self.left, self.top, self.width, self.height)


@lru_cache(maxsize=64)
def undistorted(lens: Lens, where: str = "camera") -> Crop:
    """The crop of a lens's undistorted picture in which every pixel is known.

    It may reach beyond the distorted picture's size (a barrel lens sees more), up to half of it
    on every side.

    Args:
        lens: the distorted picture.
        where: who says so, for the message.

    Raises:
        SceneError: the coefficients fold the picture so that no usable rectangle is left.
        MissingDependencyError: OpenCV is not installed.
    """
    left, top = -(lens.width // 2), -(lens.height // 2)
    known = _known(lens, left, top, 2 * lens.width, 2 * lens.height)
    x0, y0, x1, y1 = _grow(known, _largest_block(known))
    if (x1 - x0) * (y1 - y0) < 0.05 * lens.width * lens.height:
        raise SceneError(
            f"{where}: the distortion {list(lens.coefficients)} leaves {x1 - x0} x {y1 - y0} of "
            f"{lens.width} x {lens.height} pixels: check the coefficients, their order and the "
            "camera model"
        )
    return Crop(lens, left + x0, top + y0, x1 - x0, y1 - y0)


def _known(lens: Lens, left: int, top: int, width: int, height: int) -> npt.NDArray[np.bool_]:
    """Where the undistorted pixel lies in the picture, and the lens does not fold it over."""
    x, y = lens.maps(left, top, width, height)
    known = np.isfinite(x) & np.isfinite(y)
    known &= (x >= 0) & (x <= lens.width - 1) & (y >= 0) & (y <= lens.height - 1)
    known[:, 1:] &= np.diff(x, axis=1) > 0
    known[1:] &= np.diff(y, axis=0) > 0
    return known


def _largest_block(known: npt.NDArray[np.bool_]) -> tuple[int, int, int, int]:
    """``(x0, y0, x1, y1)`` of the largest rectangle of wholly known cells: a first guess."""
    height, width = known.shape
    side = max(1, math.ceil(max(height, width) / BLOCKS))
    rows, columns = height // side, width // side
    cells = known[: rows * side, : columns * side].reshape(rows, side, columns, side)
    full: npt.NDArray[np.bool_] = np.all(cells, axis=(1, 3))
    heights = np.zeros(columns, dtype=int)
    best, found = 0, (0, 0, 0, 0)
    for row in range(rows):
        heights: npt.NDArray[Any] = np.where(full[row], heights + 1, 0)
        stack: list[int] = []  # columns of rising height: the classic largest rectangle
        for column in range(columns + 1):
            tall = int(heights[column]) if column < columns else 0
            while stack and int(heights[stack[-1]]) >= tall:
                top = int(heights[stack.pop()])
                start = stack[-1] + 1 if stack else 0
                if top * (column - start) > best:
                    best = top * (column - start)
                    found = (start, row + 1 - top, column, row + 1)
            stack.append(column)
    x0, y0, x1, y1 = (value * side for value in found)
    return x0, y0, x1, y1


def _grow(
    known: npt.NDArray[np.bool_], box: tuple[int, int, int, int]
) -> tuple[int, int, int, int]:
    """The rectangle, grown by a row or column at a time while all of it stays known."""
    x0, y0, x1, y1 = box
    height, width = known.shape
    growing = x1 > x0 and y1 > y0
    while growing:
        growing = False
        if x0 > 0 and known[y0:y1, x0 - 1].all():
            x0, growing = x0 - 1, True
        if x1 < width and known[y0:y1, x1].all():
            x1, growing = x1 + 1, True
        if y0 > 0 and known[y0 - 1, x0:x1].all():
            y0, growing = y0 - 1, True
        if y1 < height and known[y1, x0:x1].all():
            y1, growing = y1 + 1, True
    return x0, y0, x1, y1


def shifted_lens(lens: Lens, offset: float) -> Lens:
    """The lens with its principal point moved by ``offset`` pixels on both axes."""
    return replace(lens, cx=lens.cx + offset, cy=lens.cy + offset)


def _opencv() -> Any:
    try:
        import cv2
    except ImportError as error:
        raise MissingDependencyError.for_extra(
            "opencv-python-headless", "undistort", "take the lens distortion out of these pictures"
        ) from error
    return cv2
