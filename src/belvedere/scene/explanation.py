"""Where a frame's pixels come from, why others are missing, and how far off colours may be."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import numpy.typing as npt

MOST_REFERENCES = 32
"""References that `Explanation.seen_by` has bits for."""


class Hole(IntEnum):
    """Why a pixel is covered or not."""

    COVERED = 0
    """It is."""
    UNDERSAMPLED = 1
    """A crack: a reference saw the surface, but its samples lie too far apart."""
    UNSEEN = 2
    """An exposure: hidden from every reference, or nothing is known to be there."""
    OUTSIDE = 3
    """No reference's picture reaches there."""


@dataclass(frozen=True, slots=True, eq=False)
class Explanation:
    """What is known about a frame's pixels beside their colour. All arrays are (H, W).

    References are numbered in the order in which they were given to the warp.
    """

    source: npt.NDArray[np.int16]
    """The reference that counts most in the pixel; -1 in holes."""
    seen_by: npt.NDArray[np.uint32]
    """Bit n is set where reference n sees the surface shown, for up to 32 references."""
    hole: npt.NDArray[np.uint8]
    """A `Hole`: covered, or the kind of hole."""
    error: npt.NDArray[np.float32]
    """Expected error of the colour: the root of the mean square, over the three channels, of
    sRGB-encoded values in [0, 1]. NaN in holes."""

    @property
    def seen_count(self) -> npt.NDArray[np.uint8]:
        """How many references see the surface shown; 0 in holes and where none confirms it."""
        bits = self.seen_by[..., None].view(np.uint8)
        return np.unpackbits(bits, axis=-1).sum(axis=-1, dtype=np.uint8)

    def share(self, kind: Hole) -> float:
        """Share of the pixels that are of one kind, 0 to 1."""
        return float(np.mean(self.hole == kind))
