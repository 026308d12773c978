"""How alike two pictures are: PSNR and SSIM, on all pixels or on the known ones.

Both compare pictures as they are shown, that is **sRGB-encoded values in [0, 1]**: ``uint8`` is
divided by 255, linear ``float32`` goes through the sRGB curve and is clipped to what a display can
show. An alpha channel is ignored.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_choice, check_shape, shape_text
from belvedere.ground.color import color_to_linear, linear_to_srgb
from belvedere.ground.errors import InputError
from belvedere.scene.view import Color

F8 = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

LUMA_REC601 = (0.299, 0.587, 0.114)
"""Weights of encoded red, green and blue in the luma SSIM is measured on (as in Wang's code)."""

SSIM_SIGMA = 1.5
"""Standard deviation of SSIM's Gaussian window, pixels."""
SSIM_RADIUS = 5
"""Half the window: 11 x 11 pixels."""
SSIM_C1 = 0.01**2
SSIM_C2 = 0.03**2
"""``(K1 L)^2`` and ``(K2 L)^2`` with K1 = 0.01, K2 = 0.03 and the range L = 1."""


def shown_values(color: Color) -> F8:
    """A picture's three colours as sRGB-encoded float64 values in [0, 1], (H, W, 3).

    Args:
        color: (H, W, 3|4) ``uint8`` sRGB or ``float32`` linear radiance; alpha is dropped, NaN is
            black.
    """
    array = np.asarray(color)
    if array.ndim != 3 or array.shape[2] not in (3, 4):
        raise InputError(
            f"metrics.color has shape {shape_text(array.shape)}, expected (height, width, 3 or 4)"
        )
    if array.dtype == np.uint8:
        return array[..., :3] / 255.0
    linear = np.clip(np.nan_to_num(array[..., :3].astype(np.float64), nan=0.0), 0.0, 1.0)
    return linear_to_srgb(linear)


def psnr(a: Color, b: Color, mask: Mask | None = None, space: str = "srgb") -> float:
    """Peak signal-to-noise ratio in decibels: ``-10 log10(mean squared difference)``, peak 1.

    The mean is over all three colours of the pixels that count.

    Args:
        a: (H, W, 3|4) ``uint8`` sRGB or ``float32`` linear.
        b: the other picture, same height and width; the types may differ.
        mask: (H, W) True where a pixel counts; None counts all.
        space: "srgb" compares encoded values (what people see, what papers print); "linear"
            compares linear radiance clipped to [0, 1].

    Returns:
        Decibels: ``inf`` for identical pictures, ``nan`` if no pixel counts.

    Raises:
        InputError: different sizes, a mask of another size or type, an unknown space.

    Memory: six times the picture in float64.
    """
    check_choice("psnr", "space", space, ("srgb", "linear"))
    known = _checked_mask("psnr", a, b, mask)
    if space == "srgb":
        first, second = shown_values(a), shown_values(b)
    else:
        first, second = (
            np.clip(color_to_linear(np.asarray(x))[..., :3].astype(np.float64), 0.0, 1.0)
            for x in (a, b)
        )
    squares = (first - second) ** 2
    return psnr_of_squares(squares if known is None else squares[known])


def psnr_of_squares(squares: F8) -> float:
    """PSNR in decibels of squared differences of values in [0, 1]: any shape, NaN if empty."""
    if squares.size == 0:
        return math.nan
    error = float(squares.mean())
    return math.inf if error == 0.0 else -10.0 * math.log10(error)


def ssim(a: Color, b: Color, mask: Mask | None = None) -> float:
    """Mean structural similarity of two pictures' luma, at most 1.

    Luma is ``0.299 R + 0.587 G + 0.114 B`` of the encoded values; the window is an 11 x 11 Gaussian
    of sigma 1.5; windows must lie in the picture, so the outer 5 pixels are never centers. Where
    no mask is given this is Wang's index to rounding.

    With a mask, a window that reaches over unknown pixels looks only at the known ones in it: its
    weights are divided by their sum over known pixels, so that a hole neither helps nor hurts its
    neighbours. The mean is over the windows whose center is known.

    Args:
        a: (H, W, 3|4) ``uint8`` sRGB or ``float32`` linear.
        b: the other picture, same height and width.
        mask: (H, W) True where a pixel is known; None knows all.

    Returns:
        The index; 1.0 for identical pictures, ``nan`` if no window has a known center.

    Raises:
        InputError: different sizes, a picture smaller than the window, a wrong mask.

    Memory: some twelve planes of float64 of the picture's size.

    Source: Wang, Bovik, Sheikh and Simoncelli 2004, eq. 13 and section III.C.
    """
    known = _checked_mask("ssim", a, b, mask)
    index = ssim_map(a, b, known)
    inner = index[SSIM_RADIUS:-SSIM_RADIUS, SSIM_RADIUS:-SSIM_RADIUS]
    if known is not None:
        inner = inner[known[SSIM_RADIUS:-SSIM_RADIUS, SSIM_RADIUS:-SSIM_RADIUS]]
    return float(inner.mean()) if inner.size else math.nan


def ssim_map(a: Color, b: Color, mask: Mask | None = None) -> F8:
    """(H, W) structural similarity of the window around each pixel; see `ssim`.

    Windows that leave the picture are cut at its edge (`ssim` leaves those out); centers without
    any known pixel in their window are NaN.
    """
    known = _checked_mask("ssim", a, b, mask)
    side = 2 * SSIM_RADIUS + 1
    if min(np.shape(a)[:2]) < side:
        raise InputError(
            f"ssim.a has shape {shape_text(np.shape(a))}, expected at least {side} x {side} "
            "pixels, the size of its window"
        )
    first, second = _luma(a), _luma(b)
    weight = np.ones(first.shape) if known is None else known.astype(np.float64)
    total = _window(weight)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.where(total > 1e-12, 1.0 / total, np.nan)
    mean_a, mean_b = _window(weight * first) * scale, _window(weight * second) * scale
    variance_a = _window(weight * first * first) * scale - mean_a * mean_a
    variance_b = _window(weight * second * second) * scale - mean_b * mean_b
    covariance = _window(weight * first * second) * scale - mean_a * mean_b
    top = (2 * mean_a * mean_b + SSIM_C1) * (2 * covariance + SSIM_C2)
    bottom = (mean_a**2 + mean_b**2 + SSIM_C1) * (variance_a + variance_b + SSIM_C2)
    return top / bottom


def json_number(value: float | None, digits: int = 4) -> float | str | None:
    """A measured number as JSON can hold it: rounded; NaN is null, infinity "Infinity".

    JSON has no infinity. Python's ``float("Infinity")`` and JavaScript's ``Number("Infinity")``
    both read the word.
    """
    if value is None or math.isnan(value):
        return None
    if math.isinf(value):
        return "Infinity" if value > 0 else "-Infinity"
    return round(value, digits)


def _luma(color: Color) -> F8:
    return shown_values(color) @ np.array(LUMA_REC601)


def _window(plane: F8) -> F8:
    """Gaussian-weighted sums over the 11 x 11 window; nothing outside the picture."""
    from scipy.ndimage import gaussian_filter

    return gaussian_filter(plane, SSIM_SIGMA, radius=SSIM_RADIUS, mode="constant", cval=0.0)


def _checked_mask(owner: str, a: Any, b: Any, mask: Mask | None) -> Mask | None:
    size = np.shape(a)[:2]
    if np.shape(b)[:2] != size:
        raise InputError(
            f"{owner}: the pictures have shapes {shape_text(np.shape(a))} and "
            f"{shape_text(np.shape(b))}, expected the same size: resize one of them"
        )
    if mask is None:
        return None
    known = np.asarray(mask)
    check_shape(owner, "mask", known, size, "it has one value a pixel")
    if known.dtype != np.bool_:
        raise InputError(f"{owner}.mask is {known.dtype}, expected bool: write coverage > 0")
    return known
