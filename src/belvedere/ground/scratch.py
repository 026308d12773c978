"""Working memory that a thread keeps between calls.

Fresh memory costs more than the work done in it: the system hands it out page by page, each one
cleared and entered in a table (a quarter to two microseconds per 4 KiB), and takes it back when
it is freed.
"""

from __future__ import annotations

import math
import threading
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

Blocks = dict[str, npt.NDArray[np.uint8]]


class _Held(threading.local):
    """Each thread's blocks by name: those in use, and those that wait for the next work."""

    def __init__(self) -> None:
        self.using: Blocks = {}
        self.spare: Blocks | None = None


_held = _Held()
_returned: list[npt.NDArray[np.uint8]] = []

SMALLEST_LOAN = 1 << 22
"""Bytes from which the allocator asks the system for memory, and gives it back, each time."""
LARGEST_LOAN = 1 << 28
"""Bytes that are kept at most."""


def scratch(name: str, shape: tuple[int, ...], dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """An array of this thread's own, with whatever it held before.

    It is overwritten when the same work asks for the same name again: use it up before, and never
    let a caller of the library see it. Ask inside `own_memory` (all work that `run_parallel` hands
    out is): what interrupts it then works elsewhere.

    Args:
        name: what it is for; each purpose has its own.
        shape: of the array.
        dtype: of its elements.

    Memory: the largest block asked for under each name stays with the thread.
    """
    kept = _held.using
    kind = np.dtype(dtype)
    size = math.prod(shape) * kind.itemsize
    block = kept.get(name)
    if block is None or block.size < size:
        block = kept[name] = np.empty(size, np.uint8)
    return block[:size].view(kind).reshape(shape)


class own_memory:  # noqa: N801  # read as the statement it is for
    """``with own_memory():`` - within it, `scratch` gives memory that no other live work has.

    Between any two steps of Python a thread may be made to run something else: a signal handler, a
    finaliser, a profiler's callback. Where that warps too, it finds the thread's blocks taken and
    gets others. One set of them is kept when all is done.
    """

    __slots__ = ("_mine", "_outer")

    def __enter__(self) -> None:
        spare, _held.spare = _held.spare, None
        self._mine: Blocks = {} if spare is None else spare
        self._outer = _held.using
        _held.using = self._mine

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        _held.using = self._outer
        _held.spare = self._mine


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
