"""LLVM's vectors of floats as values that kernels can hold, and what is done with them.

Each intrinsic is what `ground.simd` compiles for its function of the same name, which says what it
does.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.extending import intrinsic as numba_intrinsic
from numba.extending import register_model

CUBIC = (-0.5, 1.5, -1.5, 0.5), (1.0, -2.5, 2.0, -0.5), (-0.5, 0.0, 0.5, 0.0), (0.0, 1.0, 0.0, 0.0)
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
def load4(typing: Any, array: Any, index: Any) -> Any:
    _refuse_other_than_contiguous(array)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _fours(context, builder, args[1], index)
        return _loaded(context, builder, array, args[0], place, _NARROW)

    return _FOUR(array, index), generate


@intrinsic
def load16(typing: Any, array: Any, index: Any) -> Any:
    _refuse_other_than_contiguous(array)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _fours(context, builder, args[1], index)
        return _loaded(context, builder, array, args[0], place, _WIDE)

    return _SIXTEEN(array, index), generate


@intrinsic
def store4(typing: Any, array: Any, index: Any, value: Any) -> Any:
    _refuse_other_than_contiguous(array)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _fours(context, builder, args[1], index)
        done = builder.store(args[2], _address(context, builder, array, args[0], place, _NARROW))
        done.align = 4
        return context.get_dummy_value()

    return types.void(array, index, value), generate


@intrinsic
def zero4(typing: Any) -> Any:
    return _FOUR(), lambda context, builder, signature, args: cgutils.get_null_value(_NARROW)


@intrinsic
def zero16(typing: Any) -> Any:
    return _SIXTEEN(), lambda context, builder, signature, args: cgutils.get_null_value(_WIDE)


@intrinsic
def four(typing: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        vector = ir.Constant(_NARROW, ir.Undefined)
        for n, kind in enumerate((a, b, c, d)):
            scalar = context.cast(builder, args[n], kind, types.float32)
            vector = builder.insert_element(vector, scalar, ir.IntType(32)(n))
        return vector

    return _FOUR(a, b, c, d), generate


@intrinsic
def add(typing: Any, a: Any, b: Any) -> Any:
    return a(a, b), lambda context, builder, signature, args: builder.fadd(*args)


@intrinsic
def mul(typing: Any, a: Any, b: Any) -> Any:
    return a(a, b), lambda context, builder, signature, args: builder.fmul(*args)


@intrinsic
def scale(typing: Any, a: Any, factor: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.fmul(args[0], _every(context, builder, args[1], factor, args[0].type))

    return a(a, factor), generate


@intrinsic
def max4(typing: Any, a: Any, b: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", *args), *args)

    return _FOUR(a, b), generate


@intrinsic
def min4(typing: Any, a: Any, b: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered("<", *args), *args)

    return _FOUR(a, b), generate


@intrinsic
def floor4(typing: Any, a: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        function = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(_NARROW, [_NARROW]), "llvm.floor.v4f32"
        )
        return builder.call(function, args)

    return _FOUR(a), generate


@intrinsic
def cubic4(typing: Any, f: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        every = _every(context, builder, args[0], f, _NARROW)
        value, *others = (ir.Constant(_NARROW, list(each)) for each in CUBIC)
        for other in others:
            value = _fused(builder, value, every, other)
        return value

    return _FOUR(f), generate


@intrinsic
def sum4(typing: Any, a: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        lanes = [builder.extract_element(args[0], ir.IntType(32)(n)) for n in range(4)]
        return builder.fadd(builder.fadd(lanes[0], lanes[1]), builder.fadd(lanes[2], lanes[3]))

    return types.float32(a), generate


@intrinsic
def kept4(typing: Any, array: Any, start: Any, middle: Any, reach: Any, a: Any) -> Any:
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
def add_scaled16(typing: Any, total: Any, a: Any, factor: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _fused(builder, args[1], _every(context, builder, args[2], factor, _WIDE), args[0])

    return _SIXTEEN(total, a, factor), generate


@intrinsic
def add_weighted16(typing: Any, total: Any, a: Any, weights: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _fused(builder, args[1], _picked(builder, args[2], _EACH), args[0])

    return _SIXTEEN(total, a, weights), generate


@intrinsic
def weigh16(typing: Any, a: Any, w: Any, x: Any, y: Any, z: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        total = cgutils.get_null_value(_NARROW)
        for n, kind in enumerate((w, x, y, z)):
            every = _every(context, builder, args[n + 1], kind, _NARROW)
            total = _fused(builder, _picked(builder, args[0], _PARTS[n]), every, total)
        return total

    return _FOUR(a, w, x, y, z), generate


@intrinsic
def outer16(typing: Any, weights: Any, color: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        spread = _picked(builder, args[0], _EACH)
        return builder.fmul(spread, _picked(builder, args[1], [0, 1, 2, 3] * 4))

    return _SIXTEEN(weights, color), generate


@intrinsic
def part16(typing: Any, a: Any, part: Any) -> Any:
    if not isinstance(part, types.IntegerLiteral):
        return None  # asked again with the literal

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _picked(builder, args[0], _PARTS[part.literal_value])

    return _FOUR(a, part), generate


@intrinsic
def fold16(typing: Any, a: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        parts = [_picked(builder, args[0], lanes) for lanes in _PARTS]
        return builder.fadd(builder.fadd(parts[0], parts[2]), builder.fadd(parts[1], parts[3]))

    return _FOUR(a), generate


@intrinsic
def bits16(typing: Any, a: Any, limit: Any) -> Any:
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
def lane4(typing: Any, a: Any, lane: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.extract_element(args[0], context.cast(builder, args[1], lane, types.int32))

    return types.float32(a, lane), generate


@intrinsic
def prefetch(typing: Any, array: Any, index: Any) -> Any:
    if not isinstance(array, types.Array) or array.layout != "C":
        raise TypeError(f"prefetch needs C-contiguous arrays, not {array}")

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        data = context.make_array(array)(context, builder, args[0]).data
        place = builder.gep(data, [context.cast(builder, args[1], index, types.int64)])
        place = builder.bitcast(place, cgutils.voidptr_t)
        word = ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [cgutils.voidptr_t, word, word, word])
        function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8")
        # to read; needed again soon; data
        builder.call(function, [place, word(0), word(3), word(1)])
        return context.get_dummy_value()

    return types.void(array, index), generate


@intrinsic
def bits_of(typing: Any, value: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.IntType(32))

    return types.uint32(types.float32), generate


@intrinsic
def float_of(typing: Any, bits: Any) -> Any:
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


shl32, shr32, mul32 = _on_32_bits("shl"), _on_32_bits("lshr"), _on_32_bits("mul")
