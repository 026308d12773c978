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
