"""How two references differ in what they show of the surfaces that both see."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.ground.threads import run_parallel
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
    PATCHES,
    PLACES,
    SHIFTED,
    SUMS,
    TERMS,
    UNKNOWNS,
    WEIGHT,
    WIDE,
    compare,
)
from belvedere.warp.equation import warp_matrix
from belvedere.warp.prepare import PreparedView

F8 = npt.NDArray[np.float64]

ROUNDS = ((8, 3), (4, 2), (2, 3))
"""Samples along the side of the images' pixels, and how often a guess is mended on each."""
POINTS = 2000
"""Pixels that are compared in one round, about."""
AGREE_SIZE = 4
"""Samples along the side of a pixel after whose rounds a small shift is called none."""
GLANCE_SIZE = 2
"""Samples along the side of a pixel of the images that a pair is first glanced at on."""
GLANCE_PX = 0.3
"""Root mean square of the shift that a glance finds, samples, up to which no more is asked. Between
exact pictures of two built-in houses (18 pairs) up to 0.27 is found in the mean of both ways; from
shifts of a sample on, at least 0.4."""
GLANCE_ALIKE = 0.985
"""Correlation of brightness that it then needs before anything is shifted: a glance sees no shift
that is longer than the texture is wide. Exact pictures have 0.992, those shifted by 4 samples up to
0.978."""
ENOUGH = 100
"""Pixels below which nothing is concluded."""
SAME_SURFACE = 0.03
"""Relative difference in disparity up to which both see one surface."""
RIDGE = 1e-2
"""Weight of the guess that nothing is amiss, beside what is measured: decides where pictures tell
nothing."""
FLOOR = 0.02
"""Difference in brightness, relative to its mean, below which every pixel counts in full."""

LEAST_PX = 0.4
"""Root mean square of a shift that is believed, samples. Between exact pictures of two built-in
houses (60 pairs) up to 0.34 are measured, between those of a capture by hand 0.5 to 2.7."""
LEAST_SAVED = 0.04
"""Share of the squared differences in brightness that a believed shift must take away: exact
pictures stay below 0.025, the capture's have 0.05 to 0.39."""
LARGEST_PX = 16.0
"""Shift at the picture's corners beyond which something else is wrong."""

LEAST_EXPOSURE = 0.05
"""Logarithm of a difference in exposure that is believed. Between exact pictures of the built-in
house 0.01 is measured."""
LARGEST_EXPOSURE = math.log(4.0)
LEAST_IN_PATCH = 8
"""Pixels that must be compared in a patch before it is asked for texture."""
LEAST_GRADIENT = 0.02
"""Root mean square of the gradient, relative to the mean brightness, a pixel of the images, from
which on a patch has texture. Of half the patches at least 0.05 is measured in the built-in houses,
0.13 in a capture, 0.01 on plain walls."""
LEAST_TEXTURED = 0.5
"""Share of the patches that must have texture: a few edges hold a shift from one side only."""
ALIKE = 0.7
"""Correlation of brightness from which on two pictures show the same texture."""


@dataclass(frozen=True, slots=True, eq=False)
class Disagreement:
    """How another reference shows what one sees."""

    shift: F8
    """(3, 4) what is added to (column, row, 1) of a place in the other, linear in column, row, 1
    and disparity, to get where the other shows what should be there; homogeneous, samples."""
    exposure: float
    """Natural logarithm of how many times brighter it is there."""

    @property
    def is_none(self) -> bool:
        """Whether the two agree."""
        return self.exposure == 0.0 and not self.shift.any()


NONE = Disagreement(np.zeros((3, 4)), 0.0)
UNKNOWN = Disagreement(np.zeros((3, 4)), 0.0)
"""What two say of each other that have too little in common."""


def measure(
    pairs: Sequence[tuple[PreparedView, PreparedView]], threads: int | None = None
) -> list[tuple[Disagreement, Disagreement]]:
    """How the second of each pair shows the surfaces that the first sees, and the other way round.

    All are planar and have their `PreparedView.brightness`. The two of a pair are judged together,
    so that both move or neither. A pair takes half a millisecond where the two agree and 3 where
    they do not, whatever the size of the pictures.
    """
    found = [(_Comparison(a, b), _Comparison(b, a)) for a, b in pairs]
    run_parallel(_Comparison.glance, [one for both in found for one in both], threads)
    doubtful = [both for both in found if not _agree_at_a_glance(both)]
    run_parallel(_Comparison.begin, [one for both in doubtful for one in both], threads)
    amiss = [both for both in doubtful if _may_be_amiss(both)]
    run_parallel(_Comparison.finish, [one for both in amiss for one in both], threads)
    return [_judged(both) for both in found]


def _agree_at_a_glance(both: Sequence[_Comparison]) -> bool:
    return (
        _may_be_compared(both)
        and all(one.unmoved_correlation >= GLANCE_ALIKE for one in both)
        and sum(one.shift_px for one in both) <= 2 * GLANCE_PX
    )


def _may_be_amiss(both: Sequence[_Comparison]) -> bool:
    return _may_be_compared(both) and max(one.shift_px for one in both) >= LEAST_PX


def _may_be_compared(both: Sequence[_Comparison]) -> bool:
    """Whether two references have enough in common for a word on how they differ."""
    return all(one.sound and one.alike and one.textured >= LEAST_TEXTURED for one in both)


def _judged(both: Sequence[_Comparison]) -> tuple[Disagreement, Disagreement]:
    """What to believe of how two references show each other's surfaces."""
    first, second = both
    if not _may_be_compared(both):
        return UNKNOWN, UNKNOWN
    exposure = _believed_exposure(both)
    if not _shifts_are_believed(both):
        return Disagreement(NONE.shift, exposure), Disagreement(NONE.shift, -exposure)
    return Disagreement(first.shift, exposure), Disagreement(second.shift, -exposure)


def _shifts_are_believed(both: Sequence[_Comparison]) -> bool:
    """Whether the shifts are large enough to matter and the pictures agree clearly better."""
    return (
        sum(one.shift_px for one in both) >= 2 * LEAST_PX
        and sum(one.saved for one in both) >= 2 * LEAST_SAVED
        and all(one.reach_px <= LARGEST_PX for one in both)
    )


def _believed_exposure(both: Sequence[_Comparison]) -> float:
    """Logarithm of how many times brighter the second is; 0 where that is not sure."""
    exposure = 0.5 * (both[0].exposure - both[1].exposure)
    return exposure if LEAST_EXPOSURE <= abs(exposure) <= LARGEST_EXPOSURE else 0.0


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
        self._sums = np.zeros(0)
        self._texture = np.zeros((0, 2))
        self.unmoved_correlation = 0.0
        """Of the brightness in both, before anything is shifted."""
        self.saved = -math.inf
        """Share of the squared differences that the shift takes away, on the finest images."""
        self._forget_guess()

    def _forget_guess(self) -> None:
        self._guess = np.zeros(UNKNOWNS)
        self._guess[PLACES] = 1.0
        self._limit = math.inf
        self.sound = True
        """Whether the images tell anything."""

    def glance(self) -> None:
        """Mend the guess once on fine images: enough to see that nothing is amiss."""
        self.sound = self.improve(GLANCE_SIZE)
        if self.sound:
            self.unmoved_correlation = self.correlation
            self.sound = self.improve(GLANCE_SIZE)

    def begin(self) -> None:
        """Mend the guess on the coarser images, after which a small shift is called none."""
        self._forget_guess()
        for size, rounds in ROUNDS:
            if size >= AGREE_SIZE:
                self.sound = self.sound and all(self.improve(size) for _ in range(rounds))

    def finish(self) -> None:
        """Mend it on the finer ones, and see what the shift saves."""
        for size, rounds in ROUNDS:
            if size < AGREE_SIZE:
                self.sound = self.sound and all(self.improve(size) for _ in range(rounds))
        if self.sound:
            self.saved = self._saved()

    def improve(self, size: int) -> bool:
        """Mend the guess on images of so many samples a pixel; False where they tell nothing."""
        system, sums = self._compare(size, self._guess)
        if sums[COUNT] < ENOUGH or not np.isfinite(system).all():
            return False
        normal = system[:, :UNKNOWNS]
        prior = np.zeros(UNKNOWNS)
        prior[PLACES] = 1.0
        ridge = np.repeat(
            RIDGE * np.array([np.trace(normal[:PLACES, :PLACES]) / PLACES, sums[COUNT]]),
            [PLACES, UNKNOWNS - PLACES],
        )
        if not ridge.all():  # no pixel differs from its neighbours
            return False
        right = system[:, UNKNOWNS] + ridge * (prior - self._guess)
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
    def correlation(self) -> float:
        """Of the brightness in both when the guess was last improved; 0 without texture."""
        weight, own, found, own_own, found_found, own_found = self._sums[
            [WEIGHT, OWN, FOUND, OWN_OWN, FOUND_FOUND, OWN_FOUND]
        ]
        spread = (weight * own_own - own * own) * (weight * found_found - found * found)
        together = weight * own_found - own * found
        return float(together / math.sqrt(spread)) if spread > 0 else 0.0

    @property
    def alike(self) -> bool:
        """Whether both showed the same texture when the guess was last improved."""
        return self.correlation >= ALIKE

    @property
    def textured(self) -> float:
        """Share of the patches with pixels that were compared in which brightness varies."""
        count, square = self._texture.T
        mean = self._sums[OWN] / self._sums[WEIGHT]
        asked = count >= LEAST_IN_PATCH
        varied = square[asked] >= count[asked] * (LEAST_GRADIENT * mean) ** 2
        return float(varied.mean()) if asked.any() else 0.0

    @property
    def exposure(self) -> float:
        """Logarithm of how many times brighter the other is: brightness is radiance's root."""
        return math.log(self._sums[FOUND_FOUND] / self._sums[OWN_OWN])

    def _saved(self) -> float:
        unmoved = self._guess.copy()
        unmoved[:PLACES] = 0.0
        _, before = self._compare(ROUNDS[-1][0], unmoved)
        _, self._sums = self._compare(ROUNDS[-1][0], self._guess)
        if min(before[COUNT], self._sums[COUNT]) < ENOUGH:
            return -math.inf
        if not before[COST] > 0:  # nothing is left to save
            return 0.0
        return 1.0 - self._sums[COST] * before[COUNT] / (before[COST] * self._sums[COUNT])

    @property
    def reach_px(self) -> float:
        """No pixel of typical disparity is shifted along one axis by more than this."""
        along_u, along_v = abs(self._guess[: 2 * TERMS].reshape(2, TERMS))
        ends = np.array([1.0, *(self._frame[:2] * self._frame[2]), 1.0])
        tilt = float(abs(self._guess[2 * TERMS : PLACES]) @ ends[1:3])
        return max(float(along_u @ ends), float(along_v @ ends)) + tilt

    @property
    def shift(self) -> F8:
        """(3, 4) as in `Disagreement`."""
        to_middle = np.eye(3)
        to_middle[:2, 2] = -self._frame[:2]
        scale, per_disparity = self._frame[2:].astype(np.float64)
        terms = self._guess[: 2 * TERMS].reshape(2, TERMS)
        shift = np.zeros((3, 4))
        shift[:2, :2] = terms[:, 1:3] * scale
        shift[:2, 2] = terms[:, 0] - terms[:, 3]
        shift[:2, 3] = terms[:, 3] * per_disparity
        shift[2, :2] = -self._guess[2 * TERMS : PLACES] * scale**2
        shift[:, :3] = np.linalg.inv(to_middle) @ shift[:, :3] @ to_middle
        return shift

    def _compare(self, size: int, guess: F8) -> tuple[F8, F8]:
        """The normal equations and the sums of `compare`."""
        image = self._own.brightness()[size]
        stride = max(math.ceil(math.sqrt(image.size / POINTS)), 1)
        system, sums = np.zeros((UNKNOWNS, WIDE)), np.zeros(SUMS)
        texture = np.zeros((PATCHES * PATCHES, 2))
        own, other = self._own, self._other
        compare(
            self._matrix, image, own.surface(), other.brightness()[size],
            other.surface(), other.links(), size, stride, SAME_SURFACE, self._frame,
            guess.astype(np.float32), np.float32(self._limit), system, sums,
            texture,
        )  # fmt: skip
        self._texture = texture
        return system, sums
