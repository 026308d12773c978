"""What kernels need of the processor and Numba does not offer by itself.

Four ``float32`` at once: an RGBA sample is one vector register, but left alone each channel is
worked on by itself. `Four` is a value type for kernels (LLVM's ``<4 x float>``) with the few
operations that colours need; `bits_of` and `float_of` look at a float's bits.

A `Sixteen` is four of those side by side (``<16 x float>``): a row of taps, or what one colour
gives to four pixels. Whole numbers of 32 bits stay so in `shl32`, `shr32` and `mul32`.

Each function here is plain Python, which runs with ``NUMBA_DISABLE_JIT=1`` (a `Four` is then an
array), and at the end what kernels compile instead (`_vectors`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from numba.extending import overload
from numba.misc.special import literally

from belvedere.ground import _vectors as ops
from belvedere.ground.jit import Real

F4 = npt.NDArray[np.float32]
Four = Any
"""Four float32: the type of a colour in a kernel's signature."""
Sixteen = Any
"""Sixteen float32: four colours."""


def load4(array: F4, index: Real) -> Four:
    """The ``index``-th four of a C-contiguous array."""
    return array.reshape(-1, 4)[index].copy()


def store4(array: F4, index: Real, value: Four) -> None:
    """Write the ``index``-th four."""
    array.reshape(-1, 4)[index] = value


def zero4() -> Four:
    """Four zeros."""
    return np.zeros(4, np.float32)


def add4(a: Four, b: Four) -> Four:
    """Sum."""
    return a + b


def scale4(a: Four, factor: Real) -> Four:
    """Each times one number."""
    return a * np.float32(factor)


def mul4(a: Four, b: Four) -> Four:
    """Product of each two."""
    return a * b


def max4(a: Four, b: Four) -> Four:
    """The larger of each two; that of b where a is NaN."""
    return np.where(a > b, a, b)


def four(a: Real, b: Real, c: Real, d: Real) -> Four:
    """Four numbers as one."""
    return np.array([a, b, c, d], np.float32)


def cubic4(f: Real) -> Four:
    """Catmull and Rom's weights of the samples at -1, 0, 1, 2 for the place f in [0, 1]."""
    a, b, c, d = np.array(ops.CUBIC, np.float32)
    return ((a * np.float32(f) + b) * np.float32(f) + c) * np.float32(f) + d


def sum4(a: Four) -> Real:
    """Sum of the four."""
    return (a[0] + a[1]) + (a[2] + a[3])


def kept4(array: F4, start: int, middle: Real, reach: Real, a: Four) -> Four:
    """``a`` where the four floats from ``array.flat[start]`` on are within reach of middle, else 0.

    NaN is out of reach.
    """
    near = np.abs(array.reshape(-1)[start : start + 4] - np.float32(middle)) <= np.float32(reach)
    return np.where(near, a, np.float32(0.0))


def min4(a: Four, b: Four) -> Four:
    """The smaller of each two; that of b where a is NaN."""
    return np.where(a < b, a, b)


def floor4(a: Four) -> Four:
    """The whole number below each."""
    return np.floor(a)


def load16(array: F4, index: Real) -> Sixteen:
    """Four fours in a row, from the ``index``-th four of a C-contiguous array on."""
    return array.reshape(-1)[4 * index : 4 * index + 16].copy()


def zero16() -> Sixteen:
    """Sixteen zeros."""
    return np.zeros(16, np.float32)


def add16(a: Sixteen, b: Sixteen) -> Sixteen:
    """Sum."""
    return a + b


def mul16(a: Sixteen, b: Sixteen) -> Sixteen:
    """Product of each two."""
    return a * b


def scale16(a: Sixteen, factor: Real) -> Sixteen:
    """Each times one number."""
    return a * np.float32(factor)


def add_scaled16(total: Sixteen, a: Sixteen, factor: Real) -> Sixteen:
    """``total + factor * a``; in one rounding where the processor can."""
    return total + a * np.float32(factor)


def add_weighted16(total: Sixteen, a: Sixteen, weights: Four) -> Sixteen:
    """``total`` plus a's four fours, each times its own weight."""
    return total + a * np.repeat(weights, 4)


def weigh16(a: Sixteen, w: Real, x: Real, y: Real, z: Real) -> Four:
    """Sum of the four fours, each times its own number."""
    return np.array([w, x, y, z], np.float32) @ a.reshape(4, 4)


def outer16(weights: Four, color: Four) -> Sixteen:
    """The four times each of the weights: ``weights[i] * color`` is part i."""
    return np.outer(weights, color).ravel()


def part16(a: Sixteen, part: int) -> Four:
    """The part-th four; ``part`` is a literal."""
    return a[4 * part : 4 * part + 4]


def fold16(a: Sixteen) -> Four:
    """The sum of the four fours, as ``(0 + 2) + (1 + 3)``."""
    return (a[0:4] + a[8:12]) + (a[4:8] + a[12:16])


def bits16(a: Sixteen, limit: Real) -> Real:
    """A uint32 whose bit k says whether lane k is at least ``limit``; NaN is not."""
    return np.uint32(sum(1 << k for k in range(16) if a[k] >= np.float32(limit)))


def lane4(a: Four, lane: int) -> Real:
    """One of the four."""
    return a[lane]


def prefetch(array: npt.NDArray[Any], index: Real) -> None:
    """Have the memory of ``array.flat[index]`` fetched, of a C-contiguous array, for later.

    An index outside the array does no harm.
    """


def bits_of(value: Real) -> Real:
    """A float32's bits as a uint32; of values >= 0 in the same order."""
    return np.float32(value).view(np.uint32)


def float_of(bits: Real) -> Real:
    """The float32 that has these bits."""
    return np.uint32(bits).view(np.float32)


def shl32(a: Real, count: Real) -> Real:
    """A uint32 shifted to the left by 0 to 31 bits, on 32 bits: Numba's own operators widen."""
    return np.uint32((int(a) << int(count)) & 0xFFFFFFFF)


def shr32(a: Real, count: Real) -> Real:
    """A uint32 shifted to the right by 0 to 31 bits."""
    return np.uint32(int(a) >> int(count))


def mul32(a: Real, b: Real) -> Real:
    """Product of two uint32, modulo 2^32."""
    return np.uint32((int(a) * int(b)) & 0xFFFFFFFF)


def _compiled(function: Callable[..., Any], implementation: Callable[..., Any]) -> None:
    overload(function, jit_options={"forceinline": True})(implementation)


# Numba compiles what each of these returns: it must be a function with the names of the original.
# ruff: noqa: PLW0108
_compiled(load4, lambda array, index: lambda array, index: ops.load4(array, index))
_compiled(
    store4, lambda array, index, value: lambda array, index, value: ops.store4(array, index, value)
)
_compiled(zero4, lambda: lambda: ops.zero4())
_compiled(four, lambda a, b, c, d: lambda a, b, c, d: ops.four(a, b, c, d))
_compiled(add4, lambda a, b: lambda a, b: ops.add(a, b))
_compiled(scale4, lambda a, factor: lambda a, factor: ops.scale(a, factor))
_compiled(mul4, lambda a, b: lambda a, b: ops.mul(a, b))
_compiled(max4, lambda a, b: lambda a, b: ops.max4(a, b))
_compiled(min4, lambda a, b: lambda a, b: ops.min4(a, b))
_compiled(floor4, lambda a: lambda a: ops.floor4(a))
_compiled(cubic4, lambda f: lambda f: ops.cubic4(f))
_compiled(sum4, lambda a: lambda a: ops.sum4(a))
_compiled(
    kept4,
    lambda array, start, middle, reach, a: (
        lambda array, start, middle, reach, a: ops.kept4(array, start, middle, reach, a)
    ),
)
_compiled(load16, lambda array, index: lambda array, index: ops.load16(array, index))
_compiled(zero16, lambda: lambda: ops.zero16())
_compiled(add16, lambda a, b: lambda a, b: ops.add(a, b))
_compiled(mul16, lambda a, b: lambda a, b: ops.mul(a, b))
_compiled(scale16, lambda a, factor: lambda a, factor: ops.scale(a, factor))
_compiled(
    add_scaled16,
    lambda total, a, factor: lambda total, a, factor: ops.add_scaled16(total, a, factor),
)
_compiled(
    add_weighted16,
    lambda total, a, weights: lambda total, a, weights: ops.add_weighted16(total, a, weights),
)
_compiled(weigh16, lambda a, w, x, y, z: lambda a, w, x, y, z: ops.weigh16(a, w, x, y, z))
_compiled(outer16, lambda weights, color: lambda weights, color: ops.outer16(weights, color))
_compiled(part16, lambda a, part: lambda a, part: ops.part16(a, literally(part)))
_compiled(fold16, lambda a: lambda a: ops.fold16(a))
_compiled(bits16, lambda a, limit: lambda a, limit: ops.bits16(a, limit))
_compiled(lane4, lambda a, lane: lambda a, lane: ops.lane4(a, lane))
_compiled(prefetch, lambda array, index: lambda array, index: ops.prefetch(array, index))
_compiled(bits_of, lambda value: lambda value: ops.bits_of(value))
_compiled(float_of, lambda bits: lambda bits: ops.float_of(bits))
_compiled(shl32, lambda a, count: lambda a, count: ops.shl32(a, count))
_compiled(shr32, lambda a, count: lambda a, count: ops.shr32(a, count))
_compiled(mul32, lambda a, b: lambda a, b: ops.mul32(a, b))
