"""Slow twin of comparing two references: float64, every pixel at once, from the definition."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import ndimage

F4 = npt.NDArray[np.float32]
F8 = npt.NDArray[np.float64]


def blocks(image: npt.NDArray[np.floating], size: int) -> F8:
    """(H // size, W // size) means of squares."""
    height, width = (side // size * size for side in image.shape)
    cut = image[:height, :width].astype(float)
    return cut.reshape(height // size, size, width // size, size).mean(axis=(1, 3))


def differences(
    matrix: F8, own: F8, own_disparity: F4, other: F8, size: int, frame: F8, guess: F8
) -> tuple[F8, F8, F8]:
    """What is apart between two pictures of one smooth surface that both see.

    Args:
        matrix: (3, 4) from the own reference to the other.
        own: (h, w) brightness, blocks of ``size`` samples.
        own_disparity: (H, W).
        other: brightness of the other, as coarse.
        size: even.
        frame: (4,) middle column and row, factors of places and of disparity.
        guess: (12,) shifts along u, along v, by perspective, gain, offset.

    Returns:
        (n,) ``gain * own + offset - other`` where the block's centre is in the other picture; (n,)
        brightness of the other there; and (n, 2) the shift.
    """
    j, i = (grid.ravel() for grid in np.mgrid[: own.shape[0], : own.shape[1]])
    x, y = (size * k + (size - 1) / 2 for k in (i, j))
    delta = ndimage.map_coordinates(own_disparity.astype(float), [y, x], order=1)
    r, s, t = matrix @ np.stack([x, y, np.ones_like(x), delta])
    u, v, landed = r / t, s / t, delta / t
    terms = np.stack(
        [np.ones_like(u), (u - frame[0]) * frame[2], (v - frame[1]) * frame[2],
         landed * frame[3] - 1]
    )  # fmt: skip
    tilt = guess[8:10] @ terms[1:3]
    shift = np.stack(
        [guess[:4] @ terms + tilt * terms[1], guess[4:8] @ terms + tilt * terms[2]], axis=1
    )
    p, q = ((k - (size - 1) / 2) / size for k in (u + shift[:, 0], v + shift[:, 1]))
    height, width = (side * size for side in other.shape)
    inside = (u >= 0) & (v >= 0) & (u < width - 1) & (v < height - 1)
    inside &= (p >= 0) & (q >= 0) & (p < other.shape[1] - 1) & (q < other.shape[0] - 1)
    found = ndimage.map_coordinates(other, [q, p], order=1, mode="nearest")
    apart = guess[10] * own.ravel() + guess[11] - found
    return apart[inside], found[inside], shift[inside]
