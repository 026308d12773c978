"""Which rows of a table are equal: the loop that joins vertices and finds faces given twice."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import kernel

I8 = npt.NDArray[np.int64]


def first_equal(rows: npt.NDArray[Any]) -> I8:
    """(N,) for each row of (N, K) the index of the first row that equals it, bit by bit.

    Floats are compared as float64 with -0 equal to 0; whole numbers as int64.
    """
    if rows.dtype.kind == "f":
        rows = (rows.astype(np.float64) + 0.0).view(np.int64)  # + 0.0 makes 0 of -0
    table = np.ascontiguousarray(rows, dtype=np.int64)
    first = np.empty(len(table), dtype=np.int64)
    slots = np.full(1 << max(int(2 * len(table)).bit_length(), 4), -1, dtype=np.int64)
    _find_first(table, slots, first)
    return first


@kernel
def _find_first(rows: I8, slots: I8, out_first: I8) -> None:
    """Open addressing; ``slots`` is a power of two long, more than twice the rows, preset to -1."""
    mask = np.uint64(slots.shape[0] - 1)
    for i in range(rows.shape[0]):
        key = np.uint64(0xCBF29CE484222325)  # FNV-1a over whole numbers
        for k in range(rows.shape[1]):
            key = (key ^ np.uint64(rows[i, k])) * np.uint64(0x100000001B3)
            key ^= key >> np.uint64(29)
        at = key & mask
        while True:
            other = slots[at]
            if other < 0:
                slots[at] = i
                out_first[i] = i
                break
            same = True
            for k in range(rows.shape[1]):
                if rows[i, k] != rows[other, k]:
                    same = False
                    break
            if same:
                out_first[i] = other
                break
            at = (at + np.uint64(1)) & mask
