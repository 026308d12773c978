"""LLVM's vectors of eight floats as values that kernels can hold; `ground.eight` tells what for."""

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.datamodel import models
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import lower_builtin, register_model

from belvedere.ground._vectors import _FOUR, _every, _fused, _loaded, intrinsic


class _EightType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Eight")


_EIGHT = _EightType()
_VECTOR, _WHOLE = ir.VectorType(ir.FloatType(), 8), ir.VectorType(ir.IntType(32), 8)
_SHORT = ir.VectorType(ir.IntType(16), 8)

LOG2 = (3.1168458, -3.3279253, 2.6040245, -1.2350762, 0.3194097, -0.03459521)
"""Coefficients of log2(m) / (m - 1) for m in [1, 2), lowest power of m first."""


@register_model(_EightType)
class _EightModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


def _operate(symbol: Any, name: str) -> None:
    """Let kernels write ``symbol`` between eights, and between an eight and a float32."""
    pairs = [(_EIGHT, _EIGHT), (_EIGHT, types.float32), (types.float32, _EIGHT)]

    class _Operator(ConcreteTemplate):
        cases = [signature(_EIGHT, *pair) for pair in pairs]  # noqa: RUF012

    typed: Any = infer_global(symbol)
    typed(_Operator)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        a, b = (
            value if kind == _EIGHT else _every(context, builder, value, kind, _VECTOR)
            for value, kind in zip(args, signature.args, strict=True)
        )
        return getattr(builder, name)(a, b)

    for pair in pairs:
        lower_builtin(symbol, *pair)(generate)


_operate(operator.add, "fadd")
_operate(operator.sub, "fsub")
_operate(operator.mul, "fmul")
_operate(operator.truediv, "fdiv")


def _constant(value: Any) -> Any:
    return ir.Constant(_VECTOR, [value] * 8)


def _place(array: Any, kind: Any, dtype: Any, context: Any, builder: Any, start: Any) -> Any:
    """Pointer to eight elements from ``array.flat[start]`` on."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [start]), dtype.as_pointer())


def _check(array: Any, dtype: Any) -> None:
    if not isinstance(array, types.Array) or array.dtype != dtype or array.layout != "C":
        raise TypeError(f"Eight needs C-contiguous {dtype} arrays, not {array}")


@intrinsic
def eight(typing: Any, value: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _every(context, builder, args[0], value, _VECTOR)

    return _EIGHT(value), generate


@intrinsic
def ramp8(typing: Any) -> Any:
    return _EIGHT(), lambda context, builder, signature, args: ir.Constant(
        _VECTOR, [float(n) for n in range(8)]
    )


@intrinsic
def load8(typing: Any, array: Any, start: Any) -> Any:
    _check(array, types.float32)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = context.cast(builder, args[1], start, types.int64)
        return _loaded(context, builder, array, args[0], place, _VECTOR)

    return _EIGHT(array, start), generate


@intrinsic
def whole8(typing: Any, array: Any, start: Any) -> Any:
    _check(array, types.uint16)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = context.cast(builder, args[1], start, types.int64)
        short = builder.load(_place(args[0], array, _SHORT, context, builder, place))
        short.align = 2
        return builder.sitofp(builder.zext(short, _WHOLE), _VECTOR)

    return _EIGHT(array, start), generate


@intrinsic
def store8(typing: Any, array: Any, start: Any, value: Any) -> Any:
    _check(array, types.float32)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = context.cast(builder, args[1], start, types.int64)
        done = builder.store(args[2], _place(args[0], array, _VECTOR, context, builder, place))
        done.align = 4
        return context.get_dummy_value()

    return types.void(array, start, value), generate


@intrinsic
def store_whole8(typing: Any, array: Any, start: Any, value: Any) -> Any:
    _check(array, types.int32)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = context.cast(builder, args[1], start, types.int64)
        whole = builder.fptosi(args[2], _WHOLE)
        done = builder.store(whole, _place(args[0], array, _WHOLE, context, builder, place))
        done.align = 4
        return context.get_dummy_value()

    return types.void(array, start, value), generate


def _of_one(name: str) -> Any:
    @intrinsic
    def _operate(typing: Any, a: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            kind = ir.FunctionType(_VECTOR, [_VECTOR])
            function = builder.module.globals.get(name) or ir.Function(builder.module, kind, name)
            return builder.call(function, args)

        return _EIGHT(_EIGHT), generate

    return _operate


floor8, sqrt8 = _of_one("llvm.floor.v8f32"), _of_one("llvm.sqrt.v8f32")
abs8 = _of_one("llvm.fabs.v8f32")


def _of_two(sign: str) -> Any:
    @intrinsic
    def _operate(typing: Any, a: Any, b: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            other = args[1] if b == _EIGHT else _every(context, builder, args[1], b, _VECTOR)
            return builder.select(builder.fcmp_ordered(sign, args[0], other), args[0], other)

        return _EIGHT(a, b), generate

    return _operate


max8, min8 = _of_two(">"), _of_two("<")


@intrinsic
def where8(typing: Any, a: Any, b: Any, yes: Any, no: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", args[0], args[1]), args[2], args[3])

    return _EIGHT(_EIGHT, _EIGHT, _EIGHT, _EIGHT), generate


@intrinsic
def log2_8(typing: Any, a: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        def whole(value: int) -> Any:
            return ir.Constant(_WHOLE, [value] * 8)

        bits = builder.bitcast(args[0], _WHOLE)
        power = builder.sub(builder.lshr(bits, whole(23)), whole(127))
        m = builder.or_(builder.and_(bits, whole(0x7FFFFF)), whole(0x3F800000))
        m = builder.bitcast(m, _VECTOR)
        *others, value = (_constant(each) for each in LOG2)
        for other in reversed(others):
            value = _fused(builder, value, m, other)
        value = builder.fmul(value, builder.fsub(m, _constant(1.0)))
        return builder.fadd(value, builder.sitofp(power, _VECTOR))

    return _EIGHT(_EIGHT), generate


@intrinsic
def mix8(typing: Any, a: Any, b: Any, share: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        every = _every(context, builder, args[2], share, _VECTOR)
        return _fused(builder, builder.fsub(args[1], args[0]), every, args[0])

    return _EIGHT(_EIGHT, _EIGHT, share), generate


@intrinsic
def fold8(typing: Any, a: Any, share: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        def half(first: int) -> Any:
            lanes = ir.Constant(ir.VectorType(ir.IntType(32), 4), list(range(first, first + 4)))
            return builder.shuffle_vector(args[0], args[0], lanes)

        low, high = half(0), half(4)
        every = _every(context, builder, args[1], share, low.type)
        return _fused(builder, builder.fsub(high, low), every, low)

    return _FOUR(_EIGHT, share), generate


@intrinsic
def max_keys8(typing: Any, keys: Any, start: Any, value: Any, count: Any, low: Any) -> Any:
    _check(keys, types.int64)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        long = ir.VectorType(ir.IntType(64), 8)
        every = _every(context, builder, args[3], count, _VECTOR)
        ramp = ir.Constant(_VECTOR, [float(n) for n in range(8)])
        value = builder.select(builder.fcmp_ordered("<", ramp, every), args[2], _constant(0.0))
        bits = builder.zext(builder.bitcast(value, _WHOLE), long)
        first = builder.insert_element(ir.Constant(long, ir.Undefined), args[4], ir.IntType(32)(0))
        lows = builder.shuffle_vector(first, first, ir.Constant(_WHOLE, [0] * 8))
        new = builder.or_(builder.shl(bits, ir.Constant(long, [32] * 8)), lows)
        place = context.cast(builder, args[1], start, types.int64)
        place = _place(args[0], keys, long, context, builder, place)
        old = builder.load(place)
        old.align = 8
        done = builder.store(builder.select(builder.icmp_signed(">", new, old), new, old), place)
        done.align = 8
        return context.get_dummy_value()

    return types.void(keys, start, _EIGHT, types.float32, types.int64), generate
