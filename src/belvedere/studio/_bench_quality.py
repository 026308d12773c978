"""How good a warp's picture is, against what the desired camera truly shows.

Every contestant is judged on the same pixels: those whose surface some reference truly saw. What no
reference saw, nobody can know; there only painting all the same is counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.scene.view import Color
from belvedere.studio._bench_stations import Station
from belvedere.studio.metrics import Mask, psnr, ssim_map

WRONG_DEPTH = 0.02
"""Relative error of disparity from which on a pixel shows another surface."""
FAR_DISPARITY = 0.002
"""1/metre; errors below it do not count: half a kilometre away is as good as infinitely far."""


@dataclass(frozen=True, slots=True)
class Quality:
    """What is right and wrong with one picture, or the means over several."""

    psnr: float
    """Decibels, of sRGB values in truly seen pixels, holes filled by the nearest covered pixel."""
    ssim: float
    """Mean of the SSIM map over the same pixels of the same picture."""
    cracks: float
    """Per cent of the truly seen pixels that are uncovered."""
    ghosts: float
    """Per cent of all pixels that are covered though no reference saw what is there."""
    wrong_depth: float
    """Per cent of the covered, truly seen pixels whose disparity is off by over `WRONG_DEPTH`."""


def quality(
    color: Color,
    disparity: npt.NDArray[np.floating],
    coverage: npt.NDArray[np.floating] | Mask,
    station: Station,
    count: int,
) -> Quality:
    """Judge a prediction of a station's desired view from its ``count`` nearest references.

    Args:
        color: (H, W, 3) ``uint8`` sRGB or ``float32`` linear.
        disparity: (H, W) 1/metre; NaN (or anything) where uncovered.
        coverage: (H, W) above 0 where the picture claims to know.
        station: the truth.
        count: how many references it was made from.
    """
    seen, covered = station.seen(count), np.asarray(coverage) > 0
    filled = fill_nearest(color, covered)
    index = ssim_map(filled, station.color, seen)
    known = seen & covered
    error = np.abs(np.where(covered, disparity, 0.0) - station.disparity)
    allowed = np.maximum(WRONG_DEPTH * station.disparity, FAR_DISPARITY)
    wrong = known & ~(error <= allowed)  # NaN is wrong
    return Quality(
        psnr=psnr(filled, station.color, seen),
        ssim=float(index[seen].mean()),
        cracks=_percent(seen & ~covered, seen),
        ghosts=100.0 * float(np.mean(covered & ~seen)),
        wrong_depth=_percent(wrong, known),
    )


def mean_quality(each: Sequence[Quality]) -> Quality:
    """The mean of every number, decibels too."""
    return Quality(
        *(float(np.mean([getattr(one, field.name) for one in each])) for field in fields(Quality))
    )


def fill_nearest(color: Color, covered: Mask) -> Color:
    """The picture with each uncovered pixel showing the nearest covered one; as it is if none is.

    Pixels equally near are told apart by the distance transform's scan, alike for everybody.
    """
    from scipy.ndimage import distance_transform_edt

    if covered.all() or not covered.any():
        return color
    nearest: Any = distance_transform_edt(~covered, return_distances=False, return_indices=True)
    return color[nearest[0], nearest[1]]


def _percent(part: Mask, whole: Mask) -> float:
    """Of the pixels in ``whole``, how many are in ``part``; 0 if there are none."""
    total = int(whole.sum())
    return 100.0 * int(part.sum()) / total if total else 0.0
