"""Working memory that a thread keeps between calls.

Fresh memory costs more than the work done in it: the system hands it out page by page, each one
cleared and entered in a table (a quarter to two microseconds per 4 KiB), and takes it back when
it is freed.
"""

from __future__ import annotations

import math
import threading
from typing import Any

import numpy as np
import numpy.typing as npt

_held = threading.local()
_returned: list[npt.NDArray[np.uint8]] = []

SMALLEST_LOAN = 1 << 22
"""Bytes from which the allocator asks the system for memory, and gives it back, each time."""
LARGEST_LOAN = 1 << 28
"""Bytes that are kept at most."""


def scratch(name: str, shape: tuple[int, ...], dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """An array of this thread's own, with whatever it held before.

    It is overwritten when the thread asks for the same name again: use it up before, and never
    let a caller of the library see it.

    Args:
        name: what it is for; each purpose has its own.
        shape: of the array.
        dtype: of its elements.

    Memory: the largest block asked for under each name stays with the thread.
    """
    kept: dict[str, npt.NDArray[np.uint8]] = _held.__dict__
    kind = np.dtype(dtype)
    size = math.prod(shape) * kind.itemsize
    block = kept.get(name)
    if block is None or block.size < size:
        block = kept[name] = np.empty(size, np.uint8)
    return block[:size].view(kind).reshape(shape)


class _Loan:
    """Memory that comes back when the last array in it is gone."""

    def __init__(self, block: npt.NDArray[np.uint8]) -> None:
        self.block = block
        self.__array_interface__ = block.__array_interface__

    def __del__(self) -> None:
        if self.block.size <= LARGEST_LOAN:
            _returned[:] = [self.block]


def lend(size: int) -> npt.NDArray[np.uint8]:
    """(size,) bytes of memory for a result, with whatever they held before.

    They are the caller's like any array, for as long as it or a view of it lives; what was then
    given up last is lent anew, so that a loop that makes one large result after the other works in
    the same memory.

    Memory: one block of up to `LARGEST_LOAN` bytes stays with the process.
    """
    if size < SMALLEST_LOAN:
        return np.empty(size, np.uint8)
    try:
        block = _returned.pop()
    except IndexError:
        block = np.empty(0, np.uint8)
    if not size <= block.size <= 2 * size:
        block = np.empty(size, np.uint8)
    return np.asarray(_Loan(block))[:size]


def forget_loans() -> None:
    """Give back to the system what `lend` keeps."""
    _returned.clear()
