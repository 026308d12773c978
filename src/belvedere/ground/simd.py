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

from collections.abc import Callable
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


def outer16(weights: Four, color: Four) -> Sixteen:
    """The four times each of the weights: ``weights[i] * color`` is part i."""
    return np.outer(weights, color).ravel()


def part16(a: Sixteen, part: int) -> Four:
    """The part-th four; ``part`` is a literal."""
    return a[4 * part : 4 * part + 4]


def fold16(a: Sixteen) -> Four:
    """The sum of the four fours, as ``(0 + 2) + (1 + 3)``."""
    return (a[0:4] + a[8:12]) + (a[4:8] + a[12:16])


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


intrinsic: Any = numba_intrinsic  # a call of one gives no typing context: that is Numba's part


class _FourType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Four")


_FOUR = _FourType()
_VECTOR = ir.VectorType(ir.FloatType(), 4)
_LANES = ir.VectorType(ir.IntType(32), 4)


@register_model(_FourType)
class _FourModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


class _SixteenType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Sixteen")


_SIXTEEN = _SixteenType()
_WIDE = ir.VectorType(ir.FloatType(), 16)


@register_model(_SixteenType)
class _SixteenModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _WIDE)


def _lanes(*numbers: int) -> Any:
    """Which elements a shuffle takes."""
    return ir.Constant(ir.VectorType(ir.IntType(32), len(numbers)), list(numbers))


def _compiled(function: Callable[..., Any], implementation: Callable[..., Any]) -> None:
    overload(function, jit_options={"forceinline": True})(implementation)


def _address(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
    """Pointer to the four floats from ``array.flat[4 * index]`` on."""
    start = context.make_array(kind)(context, builder, array).data
    four = builder.gep(start, [builder.mul(index, ir.Constant(index.type, 4))])
    return builder.bitcast(four, _VECTOR.as_pointer())


def _refuse_other_than_contiguous(array: Any) -> None:
    if not isinstance(array, types.Array) or array.dtype != types.float32 or array.layout != "C":
        raise TypeError(f"Four needs C-contiguous float32 arrays, not {array}")


@intrinsic
def _load4(typing: Any, array: Any, index: Any) -> Any:
    _refuse_other_than_contiguous(array)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = context.cast(builder, args[1], index, types.int64)
        value = builder.load(_address(context, builder, array, args[0], place))
        value.align = 4
        return value

    return _FOUR(array, index), generate


@intrinsic
def _store4(typing: Any, array: Any, index: Any, value: Any) -> Any:
    _refuse_other_than_contiguous(array)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = context.cast(builder, args[1], index, types.int64)
        done = builder.store(args[2], _address(context, builder, array, args[0], place))
        done.align = 4
        return context.get_dummy_value()

    return types.void(array, index, value), generate


@intrinsic
def _zero4(typing: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return cgutils.get_null_value(_VECTOR)

    return _FOUR(), generate


@intrinsic
def _add4(typing: Any, a: Any, b: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.fadd(*args)

    return _FOUR(a, b), generate


@intrinsic
def _scale4(typing: Any, a: Any, factor: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        scalar = context.cast(builder, args[1], factor, types.float32)
        nothing = ir.Constant(_VECTOR, ir.Undefined)
        first = builder.insert_element(nothing, scalar, ir.IntType(32)(0))
        every = builder.shuffle_vector(first, nothing, ir.Constant(_LANES, None))
        return builder.fmul(args[0], every)

    return _FOUR(a, factor), generate


@intrinsic
def _lane4(typing: Any, a: Any, lane: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.extract_element(args[0], context.cast(builder, args[1], lane, types.int32))

    return types.float32(a, lane), generate


@intrinsic
def _max4(typing: Any, a: Any, b: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", *args), *args)

    return _FOUR(a, b), generate


@intrinsic
def _load16(typing: Any, array: Any, index: Any) -> Any:
    _refuse_other_than_contiguous(array)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = context.cast(builder, args[1], index, types.int64)
        first = _address(context, builder, array, args[0], place)
        value = builder.load(builder.bitcast(first, _WIDE.as_pointer()))
        value.align = 4
        return value

    return _SIXTEEN(array, index), generate


@intrinsic
def _zero16(typing: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return cgutils.get_null_value(_WIDE)

    return _SIXTEEN(), generate


@intrinsic
def _add16(typing: Any, a: Any, b: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.fadd(*args)

    return _SIXTEEN(a, b), generate


@intrinsic
def _mul16(typing: Any, a: Any, b: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.fmul(*args)

    return _SIXTEEN(a, b), generate


@intrinsic
def _scale16(typing: Any, a: Any, factor: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        scalar = context.cast(builder, args[1], factor, types.float32)
        nothing = ir.Constant(_WIDE, ir.Undefined)
        first = builder.insert_element(nothing, scalar, ir.IntType(32)(0))
        every = builder.shuffle_vector(first, nothing, _lanes(*[0] * 16))
        return builder.fmul(args[0], every)

    return _SIXTEEN(a, factor), generate


@intrinsic
def _outer16(typing: Any, weights: Any, color: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        nothing = ir.Constant(_VECTOR, ir.Undefined)
        spread = builder.shuffle_vector(args[0], nothing, _lanes(*[n // 4 for n in range(16)]))
        repeated = builder.shuffle_vector(args[1], nothing, _lanes(*[n % 4 for n in range(16)]))
        return builder.fmul(spread, repeated)

    return _SIXTEEN(weights, color), generate


def _take_part(builder: Any, value: Any, part: int) -> Any:
    nothing = ir.Constant(_WIDE, ir.Undefined)
    return builder.shuffle_vector(value, nothing, _lanes(*range(4 * part, 4 * part + 4)))


@intrinsic
def _part16(typing: Any, a: Any, part: Any) -> Any:
    if not isinstance(part, types.IntegerLiteral):
        return None  # asked again with the literal

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _take_part(builder, args[0], part.literal_value)

    return _FOUR(a, part), generate


@intrinsic
def _fold16(typing: Any, a: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        parts = [_take_part(builder, args[0], part) for part in range(4)]
        return builder.fadd(builder.fadd(parts[0], parts[2]), builder.fadd(parts[1], parts[3]))

    return _FOUR(a), generate


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
_compiled(add4, lambda a, b: lambda a, b: _add4(a, b))
_compiled(scale4, lambda a, factor: lambda a, factor: _scale4(a, factor))
_compiled(lane4, lambda a, lane: lambda a, lane: _lane4(a, lane))
_compiled(max4, lambda a, b: lambda a, b: _max4(a, b))
_compiled(load16, lambda array, index: lambda array, index: _load16(array, index))
_compiled(zero16, lambda: lambda: _zero16())
_compiled(add16, lambda a, b: lambda a, b: _add16(a, b))
_compiled(mul16, lambda a, b: lambda a, b: _mul16(a, b))
_compiled(scale16, lambda a, factor: lambda a, factor: _scale16(a, factor))
_compiled(outer16, lambda weights, color: lambda weights, color: _outer16(weights, color))
_compiled(part16, lambda a, part: lambda a, part: _part16(a, literally(part)))
_compiled(fold16, lambda a: lambda a: _fold16(a))
_compiled(shl32, lambda a, count: lambda a, count: _shl32(a, count))
_compiled(shr32, lambda a, count: lambda a, count: _shr32(a, count))
_compiled(mul32, lambda a, b: lambda a, b: _mul32(a, b))
_compiled(bits_of, lambda value: lambda value: _bits_of(value))
_compiled(float_of, lambda bits: lambda bits: _float_of(bits))
