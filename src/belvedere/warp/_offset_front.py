"""The kernel that takes leaked background out of the warp buffer."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._offset_word import EMPTY, disparity_in

F4 = npt.NDArray[np.float32]
U8 = npt.NDArray[np.uint64]

BEHIND_ALL = np.float32(-1.0)


@inner
def read_row(words: U8, layout: Any, out: F4) -> None:
    """Disparities of a row of cells, -1 where one is empty."""
    for i in range(words.size):
        held = words[i]
        out[i] = disparity_in(held, layout) if held != EMPTY else BEHIND_ALL


@kernel
def drop_leaks(words: U8, layout: Any, tolerance: Real, work: F4) -> None:
    """Empty the cells that see a surface clearly behind what two opposite neighbours see.

    A lattice too coarse for a surface leaves single cells and lines of cells between its
    sub-samples, and what lies behind shows through them. Two cells or more of background in a row,
    as beside a silhouette, stay.

    Args:
        words: (rows, columns), changed in place but for the outermost rows and columns.
        layout: of words.
        tolerance: relative difference in disparity up to which cells are one surface.
        work: (3, columns) to work in.

    Source: spec offset-buffer-warping 3.6 (front filter).
    """
    keep = np.float32(1.0 - tolerance)
    columns = words.shape[1]
    read_row(words[0], layout, work[0])
    read_row(words[1], layout, work[1])
    for row in range(1, words.shape[0] - 1):
        above, here, below = work[(row - 1) % 3], work[row % 3], work[(row + 1) % 3]
        read_row(words[row + 1], layout, below)
        for i in range(1, columns - 1):
            straight = max(min(here[i - 1], here[i + 1]), min(above[i], below[i]))
            slanted = max(min(above[i - 1], below[i + 1]), min(above[i + 1], below[i - 1]))
            if here[i] < max(straight, slanted) * keep:
                words[row, i] = EMPTY
