"""Eight floats at once: what kernels compile does what the plain functions say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.ground import eight as e
from belvedere.ground.jit import kernel

RNG = np.random.default_rng(5)
A = RNG.normal(0, 3, 8).astype(np.float32)
B = RNG.normal(0, 3, 8).astype(np.float32)


@kernel
def arithmetic(a, b, out):
    x, y = e.load8(a, 0), e.load8(b, 0)
    two = np.float32(2.0)
    e.store8(out, 0, x + y)
    e.store8(out, 8, x - two)
    e.store8(out, 16, two * y)
    e.store8(out, 24, x / y)
    e.store8(out, 32, e.floor8(x))
    e.store8(out, 40, e.sqrt8(e.abs8(x)))
    e.store8(out, 48, e.max8(x, y))
    e.store8(out, 56, e.min8(x, two))
    e.store8(out, 64, e.where8(x, y, e.ramp8(), e.eight(two)))
    e.store8(out, 72, e.mix8(x, y, np.float32(0.25)))
    e.store8(out, 80, e.log2_8(e.abs8(x)))


def test_compiled_and_plain_agree() -> None:
    ours, plain = np.zeros((2, 88), np.float32)
    arithmetic(A, B, ours)
    plainly: Any = getattr(arithmetic, "py_func", arithmetic)
    plainly(A, B, plain)
    np.testing.assert_allclose(ours[:80], plain[:80], rtol=1e-6)
    np.testing.assert_allclose(ours[80:], plain[80:], atol=2e-5)


@kernel
def extremes(a, b, out):
    e.store8(out, 0, e.max8(e.load8(a, 0), e.load8(b, 0)))
    e.store8(out, 8, e.min8(e.load8(a, 0), e.load8(b, 0)))


def test_of_what_is_no_number_and_a_number_the_second_is_taken() -> None:
    nan, out = np.full(8, np.nan, np.float32), np.zeros(16, np.float32)
    extremes(nan, B, out)
    np.testing.assert_array_equal(out, np.concatenate([B, B]))


@kernel
def wholes(values, floats, out, out_whole):
    e.store8(out, 0, e.whole8(values, 4))
    e.store_whole8(out_whole, 1, e.load8(floats, 0))


def test_whole_numbers_come_and_go() -> None:
    values = RNG.integers(0, 65536, 16).astype(np.uint16)
    out, whole = np.zeros(8, np.float32), np.zeros(10, np.int32)
    wholes(values, A, out, whole)
    np.testing.assert_array_equal(out, values[4:12])
    np.testing.assert_array_equal(whole, [0, *A.astype(np.int32), 0])


@kernel
def win(keys, values, count, low):
    e.max_keys8(keys, 1, e.load8(values, 0), count, low)


@pytest.mark.parametrize("count", [1, 5, 8])
def test_the_larger_key_stays(count: int) -> None:
    values = np.abs(A)
    keys = (RNG.permutation(values).view(np.uint32).astype(np.int64) << 32) | 7
    keys = np.concatenate([[3], keys, [3]])
    plain = keys.copy()
    win(keys, values, np.float32(count), np.int64(9))
    e.max_keys8(plain, 1, values, np.float32(count), np.int64(9))
    np.testing.assert_array_equal(keys, plain)
    assert (keys != 3).sum() == 8
