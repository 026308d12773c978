"""What kernels need of the processor and Numba does not offer by itself.

Four ``float32`` at once: an RGBA sample is one vector register, but left alone each channel is
worked on by itself. `Four` is a value type for kernels (LLVM's ``<4 x float>``) with the few
operations that colours need, and `Sixteen` is four of them that lie next to each other, as the taps
of a bicubic look-up do. `bits_of` and `float_of` look at a float's bits.

Each function here is plain Python, which runs with ``NUMBA_DISABLE_JIT=1`` (a `Four` or a `Sixteen`
is then an array), and below it what kernels compile instead.
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

from belvedere.ground.jit import Real

F4 = npt.NDArray[np.float32]
Four = Any
"""Four float32: the type of a colour in a kernel's signature."""
Sixteen = Any
"""Four neighbouring colours: sixteen float32."""


def load4(array: F4, index: int) -> Four:
    """The ``index``-th four of a C-contiguous array."""
    return array.reshape(-1, 4)[index].copy()


def store4(array: F4, index: int, value: Four) -> None:
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


def lane4(a: Four, lane: int) -> Real:
    """One of the four."""
    return a[lane]


def four(a: Real, b: Real, c: Real, d: Real) -> Four:
    """Four numbers as one."""
    return np.array([a, b, c, d], np.float32)


def sum4(a: Four) -> Real:
    """Sum of the four."""
    return (a[0] + a[1]) + (a[2] + a[3])


def kept4(array: F4, start: int, middle: Real, reach: Real, a: Four) -> Four:
    """``a`` where the four floats from ``array.flat[start]`` on are within reach of middle, else 0.

    NaN is out of reach.
    """
    near = np.abs(array.reshape(-1)[start : start + 4] - np.float32(middle)) <= np.float32(reach)
    return np.where(near, a, np.float32(0.0))


def zero16() -> Sixteen:
    """Sixteen zeros."""
    return np.zeros(16, np.float32)


def load16(array: F4, index: int) -> Sixteen:
    """The ``index``-th four of a C-contiguous array and the three after it."""
    return array.reshape(-1)[4 * index : 4 * index + 16].copy()


def scale16(a: Sixteen, factor: Real) -> Sixteen:
    """Each times one number."""
    return a * np.float32(factor)


def add_scaled16(total: Sixteen, a: Sixteen, factor: Real) -> Sixteen:
    """``total + factor * a``; in one rounding where the processor can."""
    return total + a * np.float32(factor)


def add_weighted16(total: Sixteen, a: Sixteen, weights: Four) -> Sixteen:
    """``total`` plus a's four fours, each times its own weight."""
    return total + a * np.repeat(weights, 4)


def fold16(a: Sixteen, w: Real, x: Real, y: Real, z: Real) -> Four:
    """Sum of the four fours, each times its own number."""
    return np.array([w, x, y, z], np.float32) @ a.reshape(4, 4)


def bits_of(value: Real) -> Real:
    """A float32's bits as a uint32; of values >= 0 in the same order."""
    return np.float32(value).view(np.uint32)


def float_of(bits: Real) -> Real:
    """The float32 that has these bits."""
    return np.uint32(bits).view(np.float32)


intrinsic: Any = numba_intrinsic  # a call of one gives no typing context: that is Numba's part


class _FourType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Four")


class _SixteenType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Sixteen")


_FOUR, _SIXTEEN = _FourType(), _SixteenType()
_VECTOR, _LONG = ir.VectorType(ir.FloatType(), 4), ir.VectorType(ir.FloatType(), 16)


@register_model(_FourType)
class _FourModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


@register_model(_SixteenType)
class _SixteenModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _LONG)


def _compiled(function: Callable[..., Any], implementation: Callable[..., Any]) -> None:
    overload(function, jit_options={"forceinline": True})(implementation)


def _address(context: Any, builder: Any, kind: Any, array: Any, index: Any, what: Any) -> Any:
    """Pointer to the vector of floats from ``array.flat[4 * index]`` on."""
    start = context.make_array(kind)(context, builder, array).data
    four = builder.gep(start, [builder.mul(index, ir.Constant(index.type, 4))])
    return builder.bitcast(four, what.as_pointer())


def _every(context: Any, builder: Any, number: Any, kind: Any, what: Any) -> Any:
    """A vector with one number in every lane."""
    scalar = context.cast(builder, number, kind, types.float32)
    nothing = ir.Constant(what, ir.Undefined)
    first = builder.insert_element(nothing, scalar, ir.IntType(32)(0))
    lanes = ir.Constant(ir.VectorType(ir.IntType(32), what.count), None)
    return builder.shuffle_vector(first, nothing, lanes)


def _multiplied_and_added(builder: Any, a: Any, b: Any, total: Any) -> Any:
    """``a * b + total`` of vectors, fused where the processor can."""
    kind = a.type
    name = f"llvm.fmuladd.v{kind.count}f32"
    function = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(kind, [kind, kind, kind]), name
    )
    return builder.call(function, [a, b, total])


def _picked(builder: Any, vector: Any, lanes: list[int]) -> Any:
    """Some lanes of a vector."""
    kind = ir.VectorType(ir.IntType(32), len(lanes))
    return builder.shuffle_vector(vector, vector, ir.Constant(kind, lanes))


def _refuse_other_than_contiguous(array: Any) -> None:
    if not isinstance(array, types.Array) or array.dtype != types.float32 or array.layout != "C":
        raise TypeError(f"Four needs C-contiguous float32 arrays, not {array}")


@intrinsic
def _load4(typing: Any, array: Any, index: Any) -> Any:
    _refuse_other_than_contiguous(array)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = context.cast(builder, args[1], index, types.int64)
        value = builder.load(_address(context, builder, array, args[0], place, _VECTOR))
        value.align = 4
        return value

    return _FOUR(array, index), generate


@intrinsic
def _store4(typing: Any, array: Any, index: Any, value: Any) -> Any:
    _refuse_other_than_contiguous(array)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = context.cast(builder, args[1], index, types.int64)
        done = builder.store(args[2], _address(context, builder, array, args[0], place, _VECTOR))
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
        return builder.fmul(args[0], _every(context, builder, args[1], factor, _VECTOR))

    return _FOUR(a, factor), generate


@intrinsic
def _lane4(typing: Any, a: Any, lane: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.extract_element(args[0], context.cast(builder, args[1], lane, types.int32))

    return types.float32(a, lane), generate


@intrinsic
def _four(typing: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        vector = ir.Constant(_VECTOR, ir.Undefined)
        for n, kind in enumerate((a, b, c, d)):
            scalar = context.cast(builder, args[n], kind, types.float32)
            vector = builder.insert_element(vector, scalar, ir.IntType(32)(n))
        return vector

    return _FOUR(a, b, c, d), generate


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
        data = context.make_array(array)(context, builder, args[0]).data
        at = builder.gep(data, [context.cast(builder, args[1], start, types.int64)])
        values = builder.load(builder.bitcast(at, _VECTOR.as_pointer()))
        values.align = 4
        apart = builder.fsub(values, _every(context, builder, args[2], middle, _VECTOR))
        # no sign, no distance: the bits of a float without its first are its size
        whole = ir.VectorType(ir.IntType(32), 4)
        size = builder.and_(builder.bitcast(apart, whole), ir.Constant(whole, [0x7FFFFFFF] * 4))
        size = builder.bitcast(size, _VECTOR)
        near = builder.fcmp_ordered("<=", size, _every(context, builder, args[3], reach, _VECTOR))
        return builder.select(near, args[4], cgutils.get_null_value(_VECTOR))

    return _FOUR(array, start, middle, reach, a), generate


@intrinsic
def _zero16(typing: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return cgutils.get_null_value(_LONG)

    return _SIXTEEN(), generate


@intrinsic
def _add_weighted16(typing: Any, total: Any, a: Any, weights: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        every = _picked(builder, args[2], [n // 4 for n in range(16)])
        return _multiplied_and_added(builder, args[1], every, args[0])

    return _SIXTEEN(total, a, weights), generate


@intrinsic
def _load16(typing: Any, array: Any, index: Any) -> Any:
    _refuse_other_than_contiguous(array)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = context.cast(builder, args[1], index, types.int64)
        value = builder.load(_address(context, builder, array, args[0], place, _LONG))
        value.align = 4
        return value

    return _SIXTEEN(array, index), generate


@intrinsic
def _scale16(typing: Any, a: Any, factor: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.fmul(args[0], _every(context, builder, args[1], factor, _LONG))

    return _SIXTEEN(a, factor), generate


@intrinsic
def _add_scaled16(typing: Any, total: Any, a: Any, factor: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        every = _every(context, builder, args[2], factor, _LONG)
        return _multiplied_and_added(builder, args[1], every, args[0])

    return _SIXTEEN(total, a, factor), generate


@intrinsic
def _fold16(typing: Any, a: Any, w: Any, x: Any, y: Any, z: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        total = cgutils.get_null_value(_VECTOR)
        for n, kind in enumerate((w, x, y, z)):
            four = _picked(builder, args[0], list(range(4 * n, 4 * n + 4)))
            every = _every(context, builder, args[n + 1], kind, _VECTOR)
            total = _multiplied_and_added(builder, four, every, total)
        return total

    return _FOUR(a, w, x, y, z), generate


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
_compiled(four, lambda a, b, c, d: lambda a, b, c, d: _four(a, b, c, d))
_compiled(sum4, lambda a: lambda a: _sum4(a))
_compiled(
    kept4,
    lambda array, start, middle, reach, a: (
        lambda array, start, middle, reach, a: _kept4(array, start, middle, reach, a)
    ),
)
_compiled(zero16, lambda: lambda: _zero16())
_compiled(
    add_weighted16,
    lambda total, a, weights: lambda total, a, weights: _add_weighted16(total, a, weights),
)
_compiled(load16, lambda array, index: lambda array, index: _load16(array, index))
_compiled(scale16, lambda a, factor: lambda a, factor: _scale16(a, factor))
_compiled(
    add_scaled16, lambda total, a, factor: lambda total, a, factor: _add_scaled16(total, a, factor)
)
_compiled(fold16, lambda a, w, x, y, z: lambda a, w, x, y, z: _fold16(a, w, x, y, z))
_compiled(bits_of, lambda value: lambda value: _bits_of(value))
_compiled(float_of, lambda bits: lambda bits: _float_of(bits))
