"""How two references differ in what they show of the surfaces that both see."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.scene import Camera
from belvedere.warp._compare import (
    APART,
    COST,
    COUNT,
    FOUND,
    FOUND_FOUND,
    OWN,
    OWN_FOUND,
    OWN_OWN,
    SHIFTED,
    SUMS,
    TERMS,
    UNKNOWNS,
    WEIGHT,
    compare,
)
from belvedere.warp.equation import warp_matrix
from belvedere.warp.prepare import PreparedView

F8 = npt.NDArray[np.float64]

PLACES = 2 * TERMS
"""Unknowns that shift places; the rest are about brightness."""
ROUNDS = ((8, 3), (4, 2), (2, 4))
"""Samples along the side of the images' pixels, and how often a guess is mended on each."""
POINTS = 2000
"""Pixels that are compared in one round, about: a thousandth of their noise is left."""
AGREE_SIZE = 4
"""Samples along the side of a pixel after whose rounds a small shift is called none."""
ENOUGH = 100
"""Pixels below which nothing is concluded."""
SAME_SURFACE = 0.03
"""Relative difference in disparity up to which both see one surface."""
RIDGE = 1e-3
"""Weight of the guess that nothing is amiss, beside what is measured: decides where pictures tell
nothing."""
FLOOR = 0.02
"""Difference in brightness, relative to its mean, below which every pixel counts in full."""

LEAST_PX = 0.3
"""Root mean square of a shift that is believed, samples. Between exact pictures of the built-in
house up to 0.2 are measured, between captures by hand 0.4 to 3."""
LEAST_GAIN = 0.03
"""Share of the difference in brightness that a believed shift must take away. The captures' take
4 to 30 %, those of exact pictures below 2 %, with one exception of 7."""
LARGEST_PX = 16.0
"""Shift at the picture's corners beyond which something else is wrong."""

LEAST_EXPOSURE = 0.05
"""Logarithm of a difference in exposure that is believed. Between exact pictures of the built-in
house 0.01 is measured."""
LARGEST_EXPOSURE = math.log(4.0)
ALIKE = 0.7
"""Correlation of brightness from which on two pictures show the same texture."""


@dataclass(frozen=True, slots=True, eq=False)
class Disagreement:
    """How another reference shows what one sees."""

    shift: F8
    """(2, 4) factors of column, row, 1 and disparity of a place in the other: how far to the right
    and how far below it the other shows what should be there, samples."""
    exposure: float
    """Natural logarithm of how many times brighter it is there."""

    @property
    def is_none(self) -> bool:
        """Whether the two agree."""
        return self.exposure == 0.0 and not self.shift.any()


NONE = Disagreement(np.zeros((2, 4)), 0.0)


def measure(own: PreparedView, other: PreparedView) -> Disagreement:
    """How another reference shows the surfaces that one sees.

    Both are planar and prepared. On one thread it takes 1 ms between pictures of 512 x 512 that
    agree, 2 ms between others.
    """
    comparison = _Comparison(own, other)
    for size, rounds in ROUNDS:
        for _ in range(rounds):
            if not comparison.improve(size):
                return NONE
        if size == AGREE_SIZE and comparison.shift_px < LEAST_PX:
            return Disagreement(NONE.shift, comparison.exposure)
    return Disagreement(comparison.believed_shift(), comparison.exposure)


class _Comparison:
    """A guess of how one reference shows another's surfaces, and what it is improved from."""

    def __init__(self, own: PreparedView, other: PreparedView) -> None:
        assert isinstance(own.camera, Camera)  # `corrections` sees to it
        assert isinstance(other.camera, Camera)
        self._matrix = warp_matrix(own.camera, other.camera).astype(np.float32).ravel()
        self._own, self._other = own, other
        height, width = other.disparity.shape
        known = other.surface()[::8, ::8]
        known = known[known > 0]
        typical = float(known.mean()) if known.size else 1.0
        self._frame = np.array(
            [(width - 1) / 2, (height - 1) / 2, 2 / max(width, height), 1 / typical], np.float32
        )
        self._guess = np.zeros(UNKNOWNS)
        self._guess[2 * TERMS] = 1.0
        self._limit = math.inf
        self._sums = np.zeros(0)

    def improve(self, size: int) -> bool:
        """Mend the guess on images of so many samples a pixel; False where they tell nothing."""
        system, sums = self._compare(size, self._guess)
        if sums[COUNT] < ENOUGH or not np.isfinite(system).all():
            return False
        normal = system[:, :-1] + np.triu(system[:, :-1], 1).T
        prior = np.zeros(UNKNOWNS)
        prior[2 * TERMS] = 1.0
        ridge = np.repeat(
            RIDGE * np.array([np.trace(normal[:PLACES, :PLACES]) / PLACES, sums[COUNT]]),
            [PLACES, UNKNOWNS - PLACES],
        )
        if not ridge.all():  # no pixel differs from its neighbours
            return False
        right = system[:, -1] + ridge * (prior - self._guess)
        self._guess = self._guess + np.linalg.solve(normal + np.diag(ridge), right)
        count = sums[COUNT]
        self._limit = max(2.0 * sums[APART] / count, FLOOR * sums[OWN] / sums[WEIGHT])
        self._sums = sums
        return True

    @property
    def shift_px(self) -> float:
        """Root mean square of the last guess's shift along one axis, samples."""
        return math.sqrt(self._sums[SHIFTED] / self._sums[COUNT])

    @property
    def exposure(self) -> float:
        """Logarithm of how many times brighter the other is; 0 where that is not sure."""
        weight, own, found, own_own, found_found, own_found = self._sums[
            [WEIGHT, OWN, FOUND, OWN_OWN, FOUND_FOUND, OWN_FOUND]
        ]
        spread = (weight * own_own - own * own) * (weight * found_found - found * found)
        together = weight * own_found - own * found
        if not (spread > 0 and together >= ALIKE * math.sqrt(spread)):
            return 0.0
        exposure = math.log(found_found / own_own)  # brightness is the root of radiance
        return exposure if LEAST_EXPOSURE <= abs(exposure) <= LARGEST_EXPOSURE else 0.0

    def believed_shift(self) -> F8:
        """(2, 4) as in `Disagreement`; 0 unless the pictures agree clearly better with it."""
        size, nothing = ROUNDS[-1][0], self._guess.copy()
        nothing[:PLACES] = 0.0
        before, after = (self._compare(size, guess)[1] for guess in (nothing, self._guess))
        if min(before[COUNT], after[COUNT]) < ENOUGH:
            return NONE.shift
        self._sums = after
        gain = 1.0 - after[COST] * before[COUNT] / (before[COST] * after[COUNT])
        if self.shift_px < LEAST_PX or gain < LEAST_GAIN:
            return NONE.shift
        u, v, scale, per_disparity = self._frame.astype(np.float64)
        terms = self._guess[:PLACES].reshape(2, TERMS)
        if (abs(terms) @ (1.0, u * scale, v * scale, 1.0)).max() > LARGEST_PX:
            return NONE.shift
        shift = np.empty((2, 4))
        shift[:, 0], shift[:, 1] = terms[:, 1] * scale, terms[:, 2] * scale
        shift[:, 2] = terms[:, 0] - terms[:, 3] - shift[:, 0] * u - shift[:, 1] * v
        shift[:, 3] = terms[:, 3] * per_disparity
        return shift

    def _compare(self, size: int, guess: F8) -> tuple[F8, F8]:
        """The normal equations and the sums of `compare`."""
        image = self._own.brightness()[size]
        stride = max(math.ceil(math.sqrt(image.size / POINTS)), 1)
        system, sums = np.zeros((UNKNOWNS, UNKNOWNS + 1)), np.zeros(SUMS)
        own, other = self._own, self._other
        compare(
            self._matrix, image, own.surface(), own.links(), other.brightness()[size],
            other.surface(), other.links(), size, stride, SAME_SURFACE, self._frame,
            guess.astype(np.float32), np.float32(self._limit), system, sums,
        )  # fmt: skip
        return system, sums
