"""A picture that knows its depth, and a picture that came out of one.

A `Frame` has a camera and disparity too, so it is a reference view again (`Frame.as_view`): warps
chain.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import as_array, check_finite, check_shape, shape_text
from belvedere.ground.errors import ViewError
from belvedere.scene.camera import Camera
from belvedere.scene.camera_model import CameraModel
from belvedere.scene.explanation import Explanation

F4 = npt.NDArray[np.float32]
Color = npt.NDArray[Any]
"""(H, W, 3|4) ``uint8`` sRGB-encoded, or ``float32`` linear radiance. Alpha is premultiplied."""

LARGEST_WHOLE = 1 << 24
"""Up to here ``float32`` holds every whole number."""


@dataclass(frozen=True, slots=True, eq=False)
class ReferenceView:
    """A picture that knows where it was taken and how far each pixel is: input of every warp."""

    camera: CameraModel
    """Where it was taken; ``X = origin + ray(u, v) / disparity``."""
    color: Color
    """(H, W, 3) or (H, W, 4) ``uint8`` sRGB or ``float32`` linear radiance."""
    disparity: F4
    """(H, W) generalised disparity, 1/metre: 0 is infinitely far, larger nearer, NaN no sample."""
    features: npt.NDArray[Any] | None = None
    """(H, W, C) whatever else each sample carries: labels, normals, embeddings, any C from 1 up.
    Kept as ``float32``, whole numbers too. A sample whose channels are all NaN has none."""

    def __post_init__(self) -> None:
        if not isinstance(self.camera, CameraModel):
            raise ViewError(
                f"ReferenceView.camera is a {type(self.camera).__name__}, expected a camera such "
                "as belvedere.Camera"
            )
        color = check_color("ReferenceView", self.color, self.camera.size)
        if color.dtype != np.uint8:
            check_finite("ReferenceView", "color", color, ViewError)
        disparity = _float_map("disparity", self.disparity, self.camera.size)
        if bool((disparity < 0).any()) or bool(np.isinf(disparity).any()):
            raise ViewError(
                "ReferenceView.disparity has negative or infinite values, expected 1/Z >= 0 with "
                "0 for infinitely far and NaN for no sample: ReferenceView.from_depth converts "
                "depth"
            )
        object.__setattr__(self, "color", color)
        object.__setattr__(self, "disparity", disparity)
        if self.features is not None:
            features = check_features("ReferenceView", self.features, self.camera.size)
            object.__setattr__(self, "features", features)

    @property
    def nbytes(self) -> int:
        """Bytes of its pixels."""
        extra = 0 if self.features is None else self.features.nbytes
        return self.color.nbytes + self.disparity.nbytes + extra

    @classmethod
    def from_depth(
        cls,
        camera: Camera,
        color: Color,
        depth: npt.ArrayLike,
        features: npt.ArrayLike | None = None,
    ) -> ReferenceView:
        """A view from z-depth, the distance along the camera's axis.

        Args:
            camera: planar camera.
            color: (H, W, 3|4) ``uint8`` sRGB or ``float32`` linear.
            depth: (H, W) metres as floating point; 0, NaN and infinity mean "no sample".
            features: (H, W, C) what else each pixel carries, or None.

        Raises:
            ViewError: depth of another size, negative, or in whole numbers (millimetres?);
                features of another size, or infinite.
        """
        if not isinstance(camera, Camera):
            raise ViewError(
                f"ReferenceView.from_depth: camera is a {type(camera).__name__}, expected a planar "
                "Camera: z-depth is measured along its axis"
            )
        metres = _float_map("depth", depth, camera.size)
        if bool((metres < 0).any()):
            raise ViewError(
                "ReferenceView.depth has negative values, expected metres in front of the camera: "
                "is the camera looking along -z (OpenGL)?"
            )
        with np.errstate(divide="ignore", over="ignore"):
            disparity = np.float32(1.0) / metres
        disparity[~np.isfinite(disparity) | ~np.isfinite(metres)] = np.nan
        return cls(camera, color, disparity, cast("F4 | None", features))


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """What rendering gives: a picture, its depth, and which of its pixels are known."""

    camera: CameraModel
    """The desired camera it was made for."""
    color: Color
    """(H, W, 3|4), of the references' type; 0 in holes that were not filled."""
    disparity: F4
    """(H, W) generalised disparity of what is seen; NaN in holes that were not filled."""
    coverage: F4
    """(H, W) in [0, 1]: 0 where nothing is known, also in holes that were filled."""
    filled: npt.NDArray[np.bool_] | None = None
    """(H, W) True where colour was invented by hole filling; None when it was not asked for."""
    features: F4 | None = None
    """(H, W, C) the references' features, of the surface that ``disparity`` shows; NaN in holes,
    filled or not. None when the references have none."""
    explanation: Explanation | None = None
    """Where each pixel comes from and how far to trust it; None when it was not asked for."""

    @property
    def holes(self) -> npt.NDArray[np.bool_]:
        """(H, W) True where no reference saw anything."""
        return self.coverage == 0

    @property
    def hole_fraction(self) -> float:
        """Share of pixels that are holes, 0 to 1."""
        return float(np.mean(self.coverage == 0))

    def as_view(self) -> ReferenceView:
        """This frame as a reference view, so that warps chain. Invented pixels are left out."""
        disparity = self.disparity
        if self.filled is not None:
            disparity = np.where(self.coverage > 0, disparity, np.float32(np.nan))
        return ReferenceView(self.camera, self.color, disparity, self.features)


def check_color(owner: str, color: Any, size: tuple[int, int]) -> Color:
    """``color`` as a contiguous (H, W, 3|4) ``uint8`` or ``float32`` array.

    Raises:
        ViewError: another shape, or a type whose meaning we would have to guess.
    """
    _refuse_mask(owner, "color", color, "fill it with a colour (color.filled(0)) and make the "
                 "disparity NaN where there is none")  # fmt: skip
    array = as_array(owner, "color", color, None)
    if array.ndim != 3 or array.shape[2] not in (3, 4):
        raise ViewError(
            f"{owner}.color has shape {shape_text(array.shape)}, expected "
            f"{shape_text((*size, 3))} or 4 channels: repeat a grey image three times"
        )
    check_shape(owner, "color", array, (*size, array.shape[2]), "resize it to its camera",
                ViewError)  # fmt: skip
    if array.dtype in (np.float64, np.float16):
        with np.errstate(over="ignore"):  # what float32 cannot hold is infinite
            array = array.astype(np.float32)
    if array.dtype not in (np.uint8, np.float32):
        raise ViewError(
            f"{owner}.color is {array.dtype}, expected uint8 (sRGB) or float32 (linear radiance)"
        )
    return np.ascontiguousarray(array)


def check_features(owner: str, features: Any, size: tuple[int, int]) -> F4:
    """``features`` as a contiguous (H, W, C) ``float32`` array.

    Raises:
        ViewError: another shape, no numbers, infinite values, samples of which only some channels
            are NaN, or whole numbers that ``float32`` cannot hold.
    """
    _refuse_mask(owner, "features", features, "fill it with NaN, which means no features "
                 "(features.filled(np.nan))")  # fmt: skip
    array = as_array(owner, "features", features, None)
    if array.ndim != 3 or array.shape[2] == 0 or array.shape[:2] != size:
        raise ViewError(
            f"{owner}.features has shape {shape_text(array.shape)}, expected "
            f"{shape_text((*size, None))} with n from 1 up: one vector for each pixel"
            + (" (features[..., None] for one channel)" if array.ndim == 2 else "")
        )
    if not (np.issubdtype(array.dtype, np.floating) or array.dtype.kind in "biu"):
        raise ViewError(f"{owner}.features is {array.dtype}, expected real numbers")
    if array.dtype.kind in "iu" and array.dtype.itemsize > 2:
        largest = max(abs(int(array.min())), abs(int(array.max())))
        if largest > LARGEST_WHOLE:
            raise ViewError(
                f"{owner}.features holds the whole number {largest}, but float32 holds them up to "
                f"{LARGEST_WHOLE}: number the labels anew, or split them into two channels"
            )
    with np.errstate(over="ignore"):  # what float32 cannot hold is infinite
        held = np.ascontiguousarray(array, dtype=np.float32)
    for row, values in enumerate(held):  # row by row: hundreds of channels are large
        if bool(np.isfinite(values).all()):
            continue
        missing = np.isnan(values)
        bad = np.isinf(values).any(axis=1) | (missing.any(axis=1) & ~missing.all(axis=1))
        if bad.any():
            raise ViewError(
                f"{owner}.features[{row}, {int(np.argmax(bad))}] is infinite or NaN in some of its "
                "channels, expected finite numbers, or NaN in all where a pixel has no features"
            )
    return held


def _refuse_mask(owner: str, name: str, values: Any, advice: str) -> None:
    """A masked array's mask would be lost: what is masked must be said in our own words."""
    if isinstance(values, np.ma.MaskedArray):
        raise ViewError(f"{owner}.{name} is a masked array, whose mask would be ignored: {advice}")


def _float_map(name: str, values: npt.ArrayLike, size: tuple[int, int]) -> F4:
    _refuse_mask("ReferenceView", name, values,
                 f"fill it with NaN, which means no sample ({name}.filled(np.nan))")  # fmt: skip
    array = as_array("ReferenceView", name, values, None)
    check_shape("ReferenceView", name, array, size, "resize it to its camera", ViewError)
    if not np.issubdtype(array.dtype, np.floating):
        raise ViewError(
            f"ReferenceView.{name} is {array.dtype}, expected floating point: "
            + (
                "convert stored units to metres first (16-bit millimetres: depth * 0.001)"
                if name == "depth"
                else "disparity is 1/Z in 1/metre"
            )
        )
    with np.errstate(over="ignore"):  # what float32 cannot hold is infinite
        return np.ascontiguousarray(array, dtype=np.float32)
