"""Eight float32 at once in kernels, written with the ordinary operators.

An `Eight` is a value type for kernels (LLVM's ``<8 x float>``): eight neighbouring pixels, or two
colours side by side. ``+ - * /`` work between two of them and between one and a float32. Loops
that Numba does not turn into vector instructions by itself, because they write many arrays or end
after a dozen pixels, are written with these.

Each function here is plain Python, which runs with ``NUMBA_DISABLE_JIT=1`` (an `Eight` is then an
array), and at the end what kernels compile instead (`_eights`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from numba.extending import overload

from belvedere.ground import _eights as ops
from belvedere.ground.jit import Real

F4 = npt.NDArray[np.float32]
Eight = Any
"""Eight float32: the type in a kernel's signature."""


def eight(value: Real) -> Eight:
    """One number eight times."""
    return np.full(8, value, np.float32)


def ramp8() -> Eight:
    """0, 1, 2, ... 7."""
    return np.arange(8, dtype=np.float32)


def load8(array: F4, start: Real) -> Eight:
    """Eight floats of a C-contiguous array, from ``array.flat[start]`` on."""
    return array.reshape(-1)[start : start + 8].copy()


def whole8(array: npt.NDArray[np.uint16], start: Real) -> Eight:
    """Eight uint16 as floats, from ``array.flat[start]`` on."""
    return array.reshape(-1)[start : start + 8].astype(np.float32)


def store8(array: F4, start: Real, value: Eight) -> None:
    """Write eight floats from ``array.flat[start]`` on."""
    array.reshape(-1)[start : start + 8] = value


def store_whole8(array: npt.NDArray[np.int32], start: Real, value: Eight) -> None:
    """Write eight floats without their fractions into an int32 array."""
    array.reshape(-1)[start : start + 8] = value.astype(np.int32)


def floor8(a: Eight) -> Eight:
    """The whole number below each."""
    return np.floor(a)


def sqrt8(a: Eight) -> Eight:
    """Square root of each."""
    return np.sqrt(a)


def abs8(a: Eight) -> Eight:
    """Each without its sign."""
    return np.abs(a)


def max8(a: Eight, b: Eight | Real) -> Eight:
    """The larger of each two; that of b where a is NaN."""
    return np.where(a > b, a, np.float32(b))


def min8(a: Eight, b: Eight | Real) -> Eight:
    """The smaller of each two; that of b where a is NaN."""
    return np.where(a < b, a, np.float32(b))


def where8(a: Eight, b: Eight, yes: Eight, no: Eight) -> Eight:
    """``yes`` where a > b, elsewhere ``no``."""
    return np.where(a > b, yes, no)


def log2_8(a: Eight) -> Eight:
    """Logarithm of positive normal floats to base 2, good to 1e-4."""
    return np.log2(a)


def mix8(a: Eight, b: Eight, share: Real) -> Eight:
    """``a + share * (b - a)``."""
    return a + np.float32(share) * (b - a)


def fold8(a: Eight, share: Real) -> Any:
    """A `simd.Four`: the first four, mixed with the last four by their share."""
    return a[:4] + np.float32(share) * (a[4:] - a[:4])


def max_keys8(
    keys: npt.NDArray[np.int64], start: Real, value: Eight, count: Real, low: Real
) -> None:
    """Replace each of eight keys, from ``keys.flat[start]`` on, by a new one that is larger.

    A new key is the bits of a float >= 0, and below them the 32 bits of ``low``; from lane
    ``count`` on the float is 0.
    """
    shown = np.where(np.arange(8) < count, value, np.float32(0.0)).astype(np.float32)
    new = (shown.view(np.uint32).astype(np.int64) << 32) | np.int64(low)
    place = keys.reshape(-1)[start : start + 8]
    np.maximum(place, new, out=place)


def _compiled(function: Callable[..., Any], implementation: Callable[..., Any]) -> None:
    overload(function, jit_options={"forceinline": True})(implementation)


# Numba compiles what each of these returns: it must be a function with the names of the original.
# ruff: noqa: PLW0108
_compiled(eight, lambda value: lambda value: ops.eight(value))
_compiled(ramp8, lambda: lambda: ops.ramp8())
_compiled(load8, lambda array, start: lambda array, start: ops.load8(array, start))
_compiled(whole8, lambda array, start: lambda array, start: ops.whole8(array, start))
_compiled(
    store8, lambda array, start, value: lambda array, start, value: ops.store8(array, start, value)
)
_compiled(
    store_whole8,
    lambda array, start, value: lambda array, start, value: ops.store_whole8(array, start, value),
)
_compiled(floor8, lambda a: lambda a: ops.floor8(a))
_compiled(sqrt8, lambda a: lambda a: ops.sqrt8(a))
_compiled(abs8, lambda a: lambda a: ops.abs8(a))
_compiled(max8, lambda a, b: lambda a, b: ops.max8(a, b))
_compiled(min8, lambda a, b: lambda a, b: ops.min8(a, b))
_compiled(where8, lambda a, b, yes, no: lambda a, b, yes, no: ops.where8(a, b, yes, no))
_compiled(log2_8, lambda a: lambda a: ops.log2_8(a))
_compiled(mix8, lambda a, b, share: lambda a, b, share: ops.mix8(a, b, share))
_compiled(fold8, lambda a, share: lambda a, share: ops.fold8(a, share))
_compiled(
    max_keys8,
    lambda keys, start, value, count, low: (
        lambda keys, start, value, count, low: ops.max_keys8(keys, start, value, count, low)
    ),
)
