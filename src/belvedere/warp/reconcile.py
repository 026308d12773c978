"""What to do about references that do not agree: captures whose poses and exposures are not exact.

Two references are compared on the surfaces that both see: by how many pixels does the other show
them beside the place that depth and poses tell, and how much brighter? A shift is a projective
map near the identity plus a step along one direction for each unit of disparity, which is what
small errors of orientation, position, focal length and clock (rolling shutter) make of a picture.
Such maps compose with the warp matrix, so a frame does not take longer. Each reference is moved
onto the mean of all, wherever the desired eye is: what is seen does not swim as one walks. Its
colours are scaled to the mean exposure. What is below the errors of comparing is left alone, so
that exact references stay as they are, to the last bit.

Source: lucas1981registration for least squares, here over surfaces instead of windows; that
pictures are registered before they are blended is the idea of eisemann2008floating.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import numpy.typing as npt

from belvedere.scene import Camera
from belvedere.warp.prepare import PreparedView

F4 = npt.NDArray[np.float32]
F8 = npt.NDArray[np.float64]

SMALLEST = 64
"""Samples along the shorter side of a picture that can be compared with another."""


@dataclass(frozen=True, slots=True, eq=False)
class Correction:
    """What brings one reference to the mean of all."""

    place: F8
    """(4, 4) where (column, row, 1, disparity) of a geometry without errors is in the picture."""
    gain: float
    """Factor of its linear colours."""

    def forward(self, matrix: F8) -> F8:
        """(3, 4) warp matrix from the reference, with the correction."""
        return matrix if self is UNCHANGED else matrix @ np.linalg.inv(self.place)

    def backward(self, matrix: F8) -> F8:
        """(3, 4) warp matrix to the reference, with the correction."""
        if self is UNCHANGED:
            return matrix
        return (self.place @ np.vstack([matrix, [0.0, 0.0, 0.0, 1.0]]))[:3]


UNCHANGED = Correction(np.eye(4), 1.0)


def corrections(
    views: Sequence[PreparedView], shares: Sequence[float] | None, threads: int | None
) -> list[Correction]:
    """What brings each reference to the mean of all; `UNCHANGED` itself where they agree.

    Args:
        views: the references.
        shares: (n,) how much each counts in the mean, above 0; None for equally.
        threads: how many to use. The result does not depend on it.
    """
    if len(views) < 2 or not all(_comparable(one) for one in views):
        return [UNCHANGED] * len(views)
    pairs = combinations(views, 2)
    missing = [(a, b) for a, b in pairs if a is not b and a not in b.compared]
    if missing:
        from belvedere.warp.disagreement import measure

        for view in views:
            view.brightness(threads)  # now, and not in threads, which must not start more
        for (a, b), (second, first) in zip(missing, measure(missing, threads), strict=True):
            b.compared[a], a.compared[b] = second, first
    part = np.ones(len(views)) if shares is None else np.asarray(shares, np.float64)
    part = part / part.sum()
    return [_correction(view, views, part) for view in views]


def _comparable(view: PreparedView) -> bool:
    return isinstance(view.camera, Camera) and min(view.disparity.shape) >= SMALLEST


def _correction(view: PreparedView, views: Sequence[PreparedView], part: F8) -> Correction:
    from belvedere.warp.disagreement import NONE, UNKNOWN

    asked = [(share, NONE if own is view else view.compared[own])
             for share, own in zip(part, views, strict=True)]  # fmt: skip
    # who has nothing in common with it has no say in where it belongs
    asked = [(share, one) for share, one in asked if one is not UNKNOWN]
    if all(one.is_none for _, one in asked):
        return UNCHANGED
    whole = sum(share for share, _ in asked)
    place = np.eye(4)
    for share, one in asked:
        place[:3] += share / whole * one.shift
    exposure = sum(share / whole * one.exposure for share, one in asked)
    # what is scaled is all channels of a colour, and alpha must stay
    gain = math.exp(-exposure) if view.color.shape[2] == 3 else 1.0
    return Correction(place, gain)
