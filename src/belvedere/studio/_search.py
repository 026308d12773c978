"""The search over readings: every kind, pose and axes with a free scale, simplest first."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
import numpy.typing as npt

from belvedere.scene.conventions import (
    AXES,
    DEPTH_KINDS,
    POSES,
    Axes,
    Conventions,
    DepthKind,
    PoseKind,
)
from belvedere.studio._hypotheses import DEPTH_TOLERANCE, Evidence, Reading

F8 = npt.NDArray[np.float64]

COARSE_PX = 0.006
"""Tolerance of the first search as a share of the picture's width: 4 px of 640."""
GAINS = np.geomspace(1e-4, 1e4, 161)
"""Gains tried, around the one that keeps the median depth; neighbours differ by 12 %."""
COMMON_FACTORS = (1000.0, 100.0, 10.0, 5.0, 2.0, 5000.0)
COMMON_SCALES = (1.0, 0.001, 0.0002, 0.01, 0.0001, 0.00025)
SNAP = 0.08
"""A fitted scale this near to a common one is taken to be it, and this near to the current one no
mistake: sensors and poses of good captures are off by a few per cent."""


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One way to read the capture, and how well it explains the pictures."""

    changes: tuple[str, ...]
    """Options that differ from the current ones; empty for the current reading."""
    depth_scale: float
    depth_kind: DepthKind
    pose: PoseKind
    axes: Axes
    score: float
    """Mean over points, 0 to 1; 1 is exactly."""
    agreement: float
    """Share of points within twice the tolerances of `Search`, for people to read."""

    @property
    def reading(self) -> Reading:
        """The reading, its gain aside."""
        return Reading(self.depth_kind, self.pose, self.axes)


@dataclass(frozen=True, slots=True)
class Search:
    """What the search found: the current reading first, then by number of changes and score."""

    hypotheses: tuple[Hypothesis, ...]
    tolerance_px: float
    depth_tolerance: float

    @property
    def current(self) -> Hypothesis:
        """The reading in force."""
        return self.hypotheses[0]


def search(evidence: Evidence, current: Conventions, width: int) -> Search:
    """Try every reading; see `Hypothesis`.

    Args:
        evidence: matched points.
        current: the reading in force, with its ``depth_scale``.
        width: pixels across of the pictures the points are measured in.
    """
    coarse_px = max(2.0, COARSE_PX * width)
    scale = float(current.depth_scale or 1.0)
    found: dict[Reading, float] = {}
    coarse: dict[Reading, float] = {}
    for reading in _readings():
        gains = GAINS * evidence.typical_gain(reading.depth_kind)
        if _same_unit(reading.depth_kind, current.depth_kind):
            gains = np.append(gains, evidence.gain(reading.depth_kind, scale))
        scores = evidence.scores(reading, gains, coarse_px).mean(axis=1)
        found[reading] = float(gains[int(scores.argmax())])
        coarse[reading] = float(scores.max())
    best = max(coarse, key=lambda reading: coarse[reading])
    found[best] = _refine(evidence, best, found[best], coarse_px / 2, DEPTH_TOLERANCE)
    px, depth = _noise(evidence, best, found[best], coarse_px)
    table: list[Hypothesis] = []
    for reading, gain in found.items():
        table += _hypotheses(evidence, current, reading, gain, px, depth)
    table.sort(key=lambda h: (len(h.changes), -h.score))
    return Search(tuple(table), px, depth)


def _readings() -> list[Reading]:
    return [
        Reading(cast(DepthKind, kind), cast(PoseKind, pose), cast(Axes, axes))
        for kind, pose, axes in itertools.product(DEPTH_KINDS, POSES, AXES)
    ]


def _same_unit(a: str, b: str) -> bool:
    """Whether two kinds of depth share a scale: both lengths, or both disparities."""
    return (a == "disparity") == (b == "disparity")


def _refine(evidence: Evidence, reading: Reading, gain: float, px: float, depth: float) -> float:
    for reach in (1.13, 1.02):
        gains = np.append(gain * np.geomspace(1 / reach, reach, 25), gain)
        scores = evidence.scores(reading, gains, px, depth).mean(axis=1)
        gain = float(gains[int(scores.argmax())])
    return gain


def _noise(
    evidence: Evidence, reading: Reading, gain: float, coarse_px: float
) -> tuple[float, float]:
    """Tolerances that suit the capture: 2.5 times the median errors of the best reading."""
    distance, ratio = evidence.errors(reading, gain)
    near = distance[distance < 3 * coarse_px]
    px = 2.5 * float(np.median(near)) if near.size else coarse_px
    close = ratio[(distance < 3 * coarse_px) & (ratio < 0.2)]
    depth = 2.5 * float(np.median(close)) if close.size else DEPTH_TOLERANCE
    return float(np.clip(px, 0.75, 2 * coarse_px)), float(np.clip(depth, 0.005, DEPTH_TOLERANCE))


def _hypotheses(
    evidence: Evidence,
    current: Conventions,
    reading: Reading,
    gain: float,
    px: float,
    depth: float,
) -> list[Hypothesis]:
    """The reading with the current scale, where it has the same unit, and with the fitted one."""
    changes = tuple(
        name
        for name, new, old in (
            ("depth_kind", reading.depth_kind, current.depth_kind),
            ("pose", reading.pose, current.pose),
            ("axes", reading.axes, current.axes),
        )
        if new != old
    )
    scale = float(current.depth_scale or 1.0)
    same = _same_unit(reading.depth_kind, current.depth_kind)

    def judged(depth_scale: float, changes: tuple[str, ...]) -> Hypothesis:
        gain = evidence.gain(reading.depth_kind, depth_scale)
        score = float(evidence.scores(reading, gain, px, depth).mean())
        agreement = evidence.agreement(reading, gain, 2 * px, 2 * depth)
        return Hypothesis(changes, depth_scale, reading.depth_kind, reading.pose, reading.axes,
                          score, agreement)  # fmt: skip

    out = [judged(scale, changes)] if same else []
    gain = _refine(evidence, reading, gain, px, depth)
    fitted = judged(gain if reading.depth_kind != "disparity" else 1 / gain, changes)
    if not same:  # one change: a disparity's scale says nothing about a depth's
        return [fitted]
    if abs(np.log(fitted.depth_scale / scale)) < np.log1p(SNAP):
        return out
    named = judged(_snapped(fitted.depth_scale, scale), changes)
    # Poses and sensors are off by a few per cent themselves: prefer what people write in files.
    chosen = named if named.agreement > fitted.agreement - 0.1 else fitted
    out.append(replace(chosen, changes=("depth_scale", *changes)))
    return out


def _snapped(scale: float, current: float) -> float:
    """The common scale, or common factor of the current one, next to ``scale`` if within 8 %."""
    factors = [*COMMON_FACTORS, *(1 / factor for factor in COMMON_FACTORS)]
    common = [*COMMON_SCALES, *(current * factor for factor in factors)]
    nearest = min(common, key=lambda value: abs(np.log(value / scale)))
    near = abs(np.log(nearest / scale)) < np.log1p(SNAP)
    return float(f"{nearest if near else scale:.6g}") if near else float(f"{scale:.4g}")
