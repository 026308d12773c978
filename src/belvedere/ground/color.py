"""Colour transfer between ``uint8`` sRGB and ``float32`` linear radiance (Rec. 709 primaries).

Whatever averages colours averages linear ones. Kernels decode bytes with `SRGB8_TO_LINEAR` (256
entries) and encode with `LINEAR_TO_SRGB8` (4096 entries over the square root of radiance, exact
for every byte: decode then encode gives the byte back).

Source: IEC 61966-2-1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import InputError


def srgb_to_linear(encoded: npt.ArrayLike) -> npt.NDArray[Any]:
    """Linear radiance of sRGB-encoded values in [0, 1]; values outside continue the curve."""
    value = np.asarray(encoded)
    value = value if value.dtype == np.float64 else value.astype(np.float32)
    low = value <= 0.04045
    return np.where(low, value / 12.92, ((np.maximum(value, 0.04) + 0.055) / 1.055) ** 2.4).astype(
        value.dtype
    )


def linear_to_srgb(linear: npt.ArrayLike) -> npt.NDArray[Any]:
    """The sRGB encoding of linear radiance; 1 is display white, values above continue the curve."""
    value = np.asarray(linear)
    value = value if value.dtype == np.float64 else value.astype(np.float32)
    low = value <= 0.0031308
    return np.where(
        low, value * 12.92, 1.055 * np.maximum(value, 0.003) ** (1.0 / 2.4) - 0.055
    ).astype(value.dtype)


SRGB8_TO_LINEAR: npt.NDArray[np.float32] = srgb_to_linear(np.arange(256) / 255.0).astype(np.float32)
"""(256,) linear radiance of each byte."""


ENCODE_STEPS = 4096
"""Entries of `LINEAR_TO_SRGB8`; fine enough that neighbouring bytes never share an entry."""


def _encode_table() -> npt.NDArray[np.uint8]:
    root = (np.arange(ENCODE_STEPS) / (ENCODE_STEPS - 1.0)) ** 2
    return np.rint(linear_to_srgb(root.astype(np.float64)) * 255.0).astype(np.uint8)


LINEAR_TO_SRGB8: npt.NDArray[np.uint8] = _encode_table()
"""(4096,) byte of linear radiance L at index ``int(sqrt(L) * 4095 + 0.5)``."""


def decode_srgb8(color: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
    """Linear radiance of ``uint8`` sRGB colour, any shape.

    A fourth (alpha) channel is not special here: see `color_to_linear`.

    Raises:
        InputError: the array is not ``uint8``.
    """
    if color.dtype != np.uint8:
        raise InputError(f"decode_srgb8.color is {color.dtype}, expected uint8")
    return SRGB8_TO_LINEAR[color]


def encode_srgb8(linear: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """``uint8`` sRGB of linear radiance, clipped to [0, 1]; NaN becomes 0. Any shape."""
    value = np.clip(np.nan_to_num(np.asarray(linear, dtype=np.float32), nan=0.0), 0.0, 1.0)
    return np.rint(linear_to_srgb(value) * 255.0).astype(np.uint8)


def color_to_linear(color: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """An image's colour, (H, W, 3|4) ``uint8`` sRGB or ``float32`` linear, as linear ``float32``.

    Alpha is a coverage, not a radiance: it is scaled to [0, 1] and never sent through the curve.
    """
    if color.dtype != np.uint8:
        return np.asarray(color, dtype=np.float32)
    linear = SRGB8_TO_LINEAR[color]
    if color.ndim == 3 and color.shape[2] == 4:
        linear[..., 3] = color[..., 3] / np.float32(255.0)
    return linear


def color_to_srgb8(color: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    """An image's colour, (H, W, 3|4), as ``uint8`` sRGB for people's eyes and PNG files."""
    if color.dtype == np.uint8:
        return color
    encoded = encode_srgb8(color)
    if color.ndim == 3 and color.shape[2] == 4:
        encoded[..., 3] = np.rint(np.clip(color[..., 3], 0.0, 1.0) * 255.0).astype(np.uint8)
    return encoded
