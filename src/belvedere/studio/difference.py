"""Pictures of what a number hides: signed differences, holes and depth, as ``uint8`` for the eye.

All functions return (H, W, 3) ``uint8`` sRGB and need a few times that in float32.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_number, check_shape
from belvedere.ground.color import color_to_srgb8, encode_srgb8
from belvedere.scene.view import Color
from belvedere.studio.metrics import Mask, shown_values

U1 = npt.NDArray[np.uint8]

HOLE_TINT: tuple[int, int, int] = (214, 71, 99)
"""sRGB of holes in every picture of this room: a rose that photographs seldom hold."""
GREY = 128
"""The byte of "no difference"."""


def signed_difference(
    prediction: Color, truth: Color, known: Mask | None = None, gain: float = 2.0
) -> U1:
    """``prediction - truth`` of encoded values, grey where they agree.

    A colour is ``1/2 + gain/2 * (prediction - truth)``, clipped: lighter than grey where the
    prediction is too light. The default gain of 2 shows a difference of 1/4 of the range as 1/4 of
    the range; differences beyond a half saturate.

    Args:
        prediction: (H, W, 3|4) ``uint8`` sRGB or ``float32`` linear.
        truth: the same size.
        known: (H, W) False where there is no prediction; painted in `HOLE_TINT`, since grey
            would claim that it is right.
        gain: how much differences are enlarged, above 0.

    Returns:
        (H, W, 3) ``uint8``; `GREY` exactly where the pictures agree.
    """
    check_number("signed_difference", "gain", gain, 0.0, open_low=True)
    first, second = shown_values(prediction), shown_values(truth)
    check_shape("signed_difference", "truth", second, first.shape, "compare pictures of one size")
    picture = np.clip(np.rint(GREY + 127.5 * gain * (first - second)), 0, 255).astype(np.uint8)
    if known is not None:
        check_shape("signed_difference", "known", np.asarray(known), first.shape[:2])
        picture[~known] = HOLE_TINT
    return picture


def coverage_picture(color: Color, coverage: npt.NDArray[np.float32]) -> U1:
    """What is known and what is not: the picture in pale grey, its holes in `HOLE_TINT`.

    Pixels covered in part are mixed in proportion, in linear light.

    Args:
        color: (H, W, 3|4) picture.
        coverage: (H, W) in [0, 1].
    """
    from belvedere.ground.color import SRGB8_TO_LINEAR

    luma = shown_values(color) @ np.array([0.299, 0.587, 0.114])
    check_shape("coverage_picture", "coverage", coverage, luma.shape, "one value a pixel")
    grey = SRGB8_TO_LINEAR[np.rint(255 * (0.25 + 0.6 * luma)).astype(np.uint8)]
    tint = SRGB8_TO_LINEAR[np.array(HOLE_TINT)]
    share = np.clip(coverage, 0.0, 1.0)[..., None]
    return encode_srgb8(grey[..., None] * share + tint * (1 - share))


def picture_with_holes(color: Color, coverage: npt.NDArray[np.float32]) -> U1:
    """The picture as it is, with uncovered pixels painted in `HOLE_TINT`."""
    picture = color_to_srgb8(color)[..., :3].copy()
    check_shape("picture_with_holes", "coverage", coverage, picture.shape[:2], "one value a pixel")
    picture[coverage == 0] = HOLE_TINT
    return picture


def disparity_picture(
    disparity: npt.NDArray[np.floating],
    low: float | None = None,
    high: float | None = None,
) -> U1:
    """Depth for the eye: near is light and warm, far is dark and blue, no sample is grey.

    (`HOLE_TINT` would pass for a depth here: the table goes through rose, never through grey.)

    Args:
        disparity: (H, W) generalised disparity, 1/metre; NaN where there is no sample.
        low: the disparity of the table's dark end; None takes the picture's 1st percentile.
        high: that of its light end; None takes the 99th percentile. Values beyond are clipped.
    """
    values = np.asarray(disparity, dtype=np.float32)
    known = np.isfinite(values)
    start = low if low is not None else _percentile(values[known], 1.0)
    stop = high if high is not None else _percentile(values[known], 99.0)
    span = max(float(stop) - float(start), 1e-12)
    index = np.clip((np.where(known, values, start) - start) / span, 0.0, 1.0) * 255.0
    picture = dusk_table()[np.rint(index).astype(np.uint8)]
    picture[~known] = GREY
    return picture


@lru_cache(maxsize=1)
def dusk_table() -> U1:
    """(256, 3) ``uint8`` sRGB: a table of even steps from night blue over rose to pale yellow.

    Lightness rises evenly from 0.20 to 0.95 in Oklab while the hue turns from blue (265 degrees)
    through rose to yellow (100 degrees), so that equal steps of depth look equal and it prints in
    grey. Chroma is a low arch, drawn in where sRGB ends.

    Source: Ottosson 2020, "A perceptual color space for image processing" (Oklab to linear sRGB).
    """
    x = np.linspace(0.0, 1.0, 256)
    lightness = 0.20 + 0.75 * x
    hue = np.radians(265.0 + 195.0 * x)
    chroma = 0.05 + 0.12 * np.sin(np.pi * np.clip(0.08 + 0.92 * x, 0, 1)) ** 0.8
    for _ in range(40):
        linear = _linear_from_oklab(lightness, chroma * np.cos(hue), chroma * np.sin(hue))
        outside = (linear < 0).any(axis=1) | (linear > 1).any(axis=1)
        chroma = np.where(outside, 0.96 * chroma, chroma)
    return encode_srgb8(_linear_from_oklab(lightness, chroma * np.cos(hue), chroma * np.sin(hue)))


def _linear_from_oklab(
    lightness: npt.NDArray[np.float64], a: npt.NDArray[np.float64], b: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    roots = np.stack([lightness, a, b], axis=-1) @ np.array(
        [
            [1.0, 1.0, 1.0],
            [0.3963377774, -0.1055613458, -0.0894841775],
            [0.2158037573, -0.0638541728, -1.2914855480],
        ]
    )
    return roots**3 @ np.array(
        [
            [4.0767416621, -1.2684380046, -0.0041960863],
            [-3.3077115913, 2.6097574011, -0.7034186147],
            [0.2309699292, -0.3413193965, 1.7076147010],
        ]
    )


def _percentile(values: npt.NDArray[np.float32], share: float) -> float:
    return float(np.percentile(values, share)) if values.size else 0.0
