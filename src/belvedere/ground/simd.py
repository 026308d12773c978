"""What kernels need of the processor and Numba does not offer by itself.

Four ``float32`` at once: an RGBA sample is one vector register, but left alone each channel is
worked on by itself. `Four` is a value type for kernels (LLVM's ``<4 x float>``) with the few
operations that colours need; `bits_of` and `float_of` look at a float's bits.

A `Sixteen` is four of those side by side (``<16 x float>``): a row of taps, or what one colour
gives to four pixels. Whole numbers of 32 bits stay so in `shl32`, `shr32` and `mul32`.

Each function here is plain Python, which runs with ``NUMBA_DISABLE_JIT=1`` (a `Four` is then an
array), and below it what kernels compile instead.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.extending import intrinsic as numba_intrinsic
from numba.extending import overload, register_model
from numba.misc.special import literally

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


def max4(a: Four, b: Four) -> Four:
    """The larger of each two; that of b where a is NaN."""
    return np.where(a > b, a, b)


def four(a: Real, b: Real, c: Real, d: Real) -> Four:
    """Four numbers as one."""
    return np.array([a, b, c, d], np.float32)


def cubic4(f: Real) -> Four:
    """Catmull and Rom's weights of the samples at -1, 0, 1, 2 for the place f in [0, 1]."""
    a, b, c, d = np.array(_CUBIC, np.float32)
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


_CUBIC = (-0.5, 1.5, -1.5, 0.5), (1.0, -2.5, 2.0, -0.5), (-0.5, 0.0, 0.5, 0.0), (0.0, 1.0, 0.0, 0.0)
"""Coefficients of the third, second, first and zeroth power in Catmull and Rom's four weights."""

intrinsic: Any = numba_intrinsic  # a call of one gives no typing context: that is Numba's part


class _FourType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Four")


class _SixteenType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Sixteen")


_FOUR, _SIXTEEN = _FourType(), _SixteenType()
_NARROW, _WIDE = ir.VectorType(ir.FloatType(), 4), ir.VectorType(ir.FloatType(), 16)


@register_model(_FourType)
class _FourModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _NARROW)


@register_model(_SixteenType)
class _SixteenModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _WIDE)


def _compiled(function: Callable[..., Any], implementation: Callable[..., Any]) -> None:
    overload(function, jit_options={"forceinline": True})(implementation)


def _address(context: Any, builder: Any, kind: Any, array: Any, place: Any, what: Any) -> Any:
    """Pointer to the vector of floats from ``array.flat[place]`` on."""
    start = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(start, [place]), what.as_pointer())


def _loaded(context: Any, builder: Any, kind: Any, array: Any, place: Any, what: Any) -> Any:
    value = builder.load(_address(context, builder, kind, array, place, what))
    value.align = 4
    return value


def _fours(context: Any, builder: Any, index: Any, kind: Any) -> Any:
    """The place of the ``index``-th four."""
    return builder.mul(context.cast(builder, index, kind, types.int64), ir.IntType(64)(4))


def _picked(builder: Any, vector: Any, lanes: Sequence[int]) -> Any:
    """Some lanes of a vector, in that order."""
    kind = ir.VectorType(ir.IntType(32), len(lanes))
    return builder.shuffle_vector(vector, vector, ir.Constant(kind, list(lanes)))


def _every(context: Any, builder: Any, number: Any, kind: Any, what: Any) -> Any:
    """A vector with one number in every lane."""
    scalar = context.cast(builder, number, kind, types.float32)
    nothing = ir.Constant(what, ir.Undefined)
    first = builder.insert_element(nothing, scalar, ir.IntType(32)(0))
    return _picked(builder, first, [0] * what.count)


def _fused(builder: Any, a: Any, b: Any, total: Any) -> Any:
    """``a * b + total`` of vectors, in one rounding where the processor can."""
    kind = a.type
    function = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(kind, [kind] * 3), f"llvm.fmuladd.v{kind.count}f32"
    )
    return builder.call(function, [a, b, total])


def _refuse_other_than_contiguous(array: Any) -> None:
    if not isinstance(array, types.Array) or array.dtype != types.float32 or array.layout != "C":
        raise TypeError(f"Four needs C-contiguous float32 arrays, not {array}")


@intrinsic
def _load4(typing: Any, array: Any, index: Any) -> Any:
    _refuse_other_than_contiguous(array)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _fours(context, builder, args[1], index)
        return _loaded(context, builder, array, args[0], place, _NARROW)

    return _FOUR(array, index), generate


@intrinsic
def _load16(typing: Any, array: Any, index: Any) -> Any:
    _refuse_other_than_contiguous(array)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _fours(context, builder, args[1], index)
        return _loaded(context, builder, array, args[0], place, _WIDE)

    return _SIXTEEN(array, index), generate


@intrinsic
def _store4(typing: Any, array: Any, index: Any, value: Any) -> Any:
    _refuse_other_than_contiguous(array)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _fours(context, builder, args[1], index)
        done = builder.store(args[2], _address(context, builder, array, args[0], place, _NARROW))
        done.align = 4
        return context.get_dummy_value()

    return types.void(array, index, value), generate


@intrinsic
def _zero4(typing: Any) -> Any:
    return _FOUR(), lambda context, builder, signature, args: cgutils.get_null_value(_NARROW)


@intrinsic
def _zero16(typing: Any) -> Any:
    return _SIXTEEN(), lambda context, builder, signature, args: cgutils.get_null_value(_WIDE)


@intrinsic
def _four(typing: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        vector = ir.Constant(_NARROW, ir.Undefined)
        for n, kind in enumerate((a, b, c, d)):
            scalar = context.cast(builder, args[n], kind, types.float32)
            vector = builder.insert_element(vector, scalar, ir.IntType(32)(n))
        return vector

    return _FOUR(a, b, c, d), generate


@intrinsic
def _add(typing: Any, a: Any, b: Any) -> Any:
    return a(a, b), lambda context, builder, signature, args: builder.fadd(*args)


@intrinsic
def _mul(typing: Any, a: Any, b: Any) -> Any:
    return a(a, b), lambda context, builder, signature, args: builder.fmul(*args)


@intrinsic
def _scale(typing: Any, a: Any, factor: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.fmul(args[0], _every(context, builder, args[1], factor, args[0].type))

    return a(a, factor), generate


@intrinsic
def _max4(typing: Any, a: Any, b: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", *args), *args)

    return _FOUR(a, b), generate


@intrinsic
def _min4(typing: Any, a: Any, b: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered("<", *args), *args)

    return _FOUR(a, b), generate


@intrinsic
def _cubic4(typing: Any, f: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        every = _every(context, builder, args[0], f, _NARROW)
        value, *others = (ir.Constant(_NARROW, list(each)) for each in _CUBIC)
        for other in others:
            value = _fused(builder, value, every, other)
        return value

    return _FOUR(f), generate


@intrinsic
def _sum4(typing: Any, a: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        lanes = [builder.extract_element(args[0], ir.IntType(32)(n)) for n in range(4)]
        return builder.fadd(builder.fadd(lanes[0], lanes[1]), builder.fadd(lanes[2], lanes[3]))

    return types.float32(a), generate


@intrinsic
def _kept4(typing: Any, array: Any, start: Any, middle: Any, reach: Any, a: Any) -> Any:
    _refuse_other_than_contiguous(array)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = context.cast(builder, args[1], start, types.int64)
        values = _loaded(context, builder, array, args[0], place, _NARROW)
        apart = builder.fsub(values, _every(context, builder, args[2], middle, _NARROW))
        # no sign, no distance: the bits of a float without its first are its size
        whole = ir.VectorType(ir.IntType(32), 4)
        size = builder.and_(builder.bitcast(apart, whole), ir.Constant(whole, [0x7FFFFFFF] * 4))
        size = builder.bitcast(size, _NARROW)
        near = builder.fcmp_ordered("<=", size, _every(context, builder, args[3], reach, _NARROW))
        return builder.select(near, args[4], cgutils.get_null_value(_NARROW))

    return _FOUR(array, start, middle, reach, a), generate


@intrinsic
def _add_scaled16(typing: Any, total: Any, a: Any, factor: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _fused(builder, args[1], _every(context, builder, args[2], factor, _WIDE), args[0])

    return _SIXTEEN(total, a, factor), generate


@intrinsic
def _add_weighted16(typing: Any, total: Any, a: Any, weights: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _fused(builder, args[1], _picked(builder, args[2], _EACH), args[0])

    return _SIXTEEN(total, a, weights), generate


@intrinsic
def _weigh16(typing: Any, a: Any, w: Any, x: Any, y: Any, z: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        total = cgutils.get_null_value(_NARROW)
        for n, kind in enumerate((w, x, y, z)):
            every = _every(context, builder, args[n + 1], kind, _NARROW)
            total = _fused(builder, _picked(builder, args[0], _PARTS[n]), every, total)
        return total

    return _FOUR(a, w, x, y, z), generate


@intrinsic
def _outer16(typing: Any, weights: Any, color: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        spread = _picked(builder, args[0], _EACH)
        return builder.fmul(spread, _picked(builder, args[1], [0, 1, 2, 3] * 4))

    return _SIXTEEN(weights, color), generate


@intrinsic
def _part16(typing: Any, a: Any, part: Any) -> Any:
    if not isinstance(part, types.IntegerLiteral):
        return None  # asked again with the literal

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _picked(builder, args[0], _PARTS[part.literal_value])

    return _FOUR(a, part), generate


@intrinsic
def _fold16(typing: Any, a: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        parts = [_picked(builder, args[0], lanes) for lanes in _PARTS]
        return builder.fadd(builder.fadd(parts[0], parts[2]), builder.fadd(parts[1], parts[3]))

    return _FOUR(a), generate


@intrinsic
def _bits16(typing: Any, a: Any, limit: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        every = _every(context, builder, args[1], limit, _WIDE)
        flags = builder.fcmp_ordered(">=", args[0], every)
        return builder.zext(builder.bitcast(flags, ir.IntType(16)), ir.IntType(32))

    return types.uint32(a, limit), generate


_PARTS = [range(4 * n, 4 * n + 4) for n in range(4)]
"""Lanes of the four fours of a `Sixteen`."""
_EACH = [n // 4 for n in range(16)]
"""Lanes of a `Four`, each four times."""


@intrinsic
def _lane4(typing: Any, a: Any, lane: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.extract_element(args[0], context.cast(builder, args[1], lane, types.int32))

    return types.float32(a, lane), generate


@intrinsic
def _bits_of(typing: Any, value: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.IntType(32))

    return types.uint32(types.float32), generate


@intrinsic
def _float_of(typing: Any, bits: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.FloatType())

    return types.float32(types.uint32), generate


def _on_32_bits(operation: str) -> Any:
    @intrinsic
    def _operate(typing: Any, a: Any, b: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            return getattr(builder, operation)(*args)

        return types.uint32(types.uint32, types.uint32), generate

    return _operate


_shl32, _shr32, _mul32 = _on_32_bits("shl"), _on_32_bits("lshr"), _on_32_bits("mul")


# Numba compiles what each of these returns: it must be a function with the names of the original.
# ruff: noqa: PLW0108
_compiled(load4, lambda array, index: lambda array, index: _load4(array, index))
_compiled(
    store4, lambda array, index, value: lambda array, index, value: _store4(array, index, value)
)
_compiled(zero4, lambda: lambda: _zero4())
_compiled(four, lambda a, b, c, d: lambda a, b, c, d: _four(a, b, c, d))
_compiled(add4, lambda a, b: lambda a, b: _add(a, b))
_compiled(scale4, lambda a, factor: lambda a, factor: _scale(a, factor))
_compiled(max4, lambda a, b: lambda a, b: _max4(a, b))
_compiled(min4, lambda a, b: lambda a, b: _min4(a, b))
_compiled(cubic4, lambda f: lambda f: _cubic4(f))
_compiled(sum4, lambda a: lambda a: _sum4(a))
_compiled(
    kept4,
    lambda array, start, middle, reach, a: (
        lambda array, start, middle, reach, a: _kept4(array, start, middle, reach, a)
    ),
)
_compiled(load16, lambda array, index: lambda array, index: _load16(array, index))
_compiled(zero16, lambda: lambda: _zero16())
_compiled(add16, lambda a, b: lambda a, b: _add(a, b))
_compiled(mul16, lambda a, b: lambda a, b: _mul(a, b))
_compiled(scale16, lambda a, factor: lambda a, factor: _scale(a, factor))
_compiled(
    add_scaled16, lambda total, a, factor: lambda total, a, factor: _add_scaled16(total, a, factor)
)
_compiled(
    add_weighted16,
    lambda total, a, weights: lambda total, a, weights: _add_weighted16(total, a, weights),
)
_compiled(weigh16, lambda a, w, x, y, z: lambda a, w, x, y, z: _weigh16(a, w, x, y, z))
_compiled(outer16, lambda weights, color: lambda weights, color: _outer16(weights, color))
_compiled(part16, lambda a, part: lambda a, part: _part16(a, literally(part)))
_compiled(fold16, lambda a: lambda a: _fold16(a))
_compiled(bits16, lambda a, limit: lambda a, limit: _bits16(a, limit))
_compiled(lane4, lambda a, lane: lambda a, lane: _lane4(a, lane))
_compiled(bits_of, lambda value: lambda value: _bits_of(value))
_compiled(float_of, lambda bits: lambda bits: _float_of(bits))
_compiled(shl32, lambda a, count: lambda a, count: _shl32(a, count))
_compiled(shr32, lambda a, count: lambda a, count: _shr32(a, count))
_compiled(mul32, lambda a, b: lambda a, b: _mul32(a, b))
