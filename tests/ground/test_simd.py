"""Four floats at once do in kernels what they do in plain Python."""

from __future__ import annotations

import os

import numpy as np
import pytest

from belvedere.ground import simd
from belvedere.ground.jit import kernel


@kernel
def weighted_sum(values: np.ndarray, weights: np.ndarray, out: np.ndarray) -> float:
    """Sum of rows times weights, written to row 1 of ``out``; returns its lane 2."""
    total = simd.zero4()
    for n in range(weights.size):
        total = simd.add4(total, simd.scale4(simd.load4(values, n), weights[n]))
    simd.store4(out, 1, total)
    return simd.lane4(total, 2)


@kernel
def there_and_back(values: np.ndarray, out_bits: np.ndarray, out: np.ndarray) -> None:
    for n in range(values.size):
        out_bits[n] = simd.bits_of(values[n])
        out[n] = simd.float_of(out_bits[n])


@pytest.mark.parametrize("form", [weighted_sum, getattr(weighted_sum, "py_func", weighted_sum)])
def test_a_weighted_sum_of_fours_is_that_of_their_lanes(form: object) -> None:
    rng = np.random.default_rng(0)
    values = rng.normal(size=(9, 4)).astype(np.float32)
    weights = rng.normal(size=9).astype(np.float32)
    out = np.full((3, 4), 7.0, np.float32)
    lane = form(values, weights, out)  # type: ignore[operator]
    np.testing.assert_allclose(out[1], weights @ values, rtol=1e-5, atol=1e-6)
    assert lane == out[1, 2]
    assert np.all(out[[0, 2]] == 7.0)


def test_bits_of_floats_keep_their_order_and_come_back() -> None:
    values = np.array([0.0, 1e-30, 0.5, 1.0, 3e8, -1.0], np.float32)
    bits, back = np.zeros(6, np.uint32), np.zeros(6, np.float32)
    there_and_back(values, bits, back)
    np.testing.assert_array_equal(bits, values.view(np.uint32))
    np.testing.assert_array_equal(back, values)
    assert np.all(np.diff(bits[:5].astype(np.int64)) > 0)
    assert simd.bits_of(1.0) == bits[3]
    assert simd.float_of(int(bits[3])) == 1.0


@pytest.mark.skipif(
    bool(os.environ.get("NUMBA_DISABLE_JIT")), reason="plain Python checks no layouts"
)
def test_only_contiguous_arrays_of_float32_hold_fours() -> None:
    @kernel
    def first(values: np.ndarray) -> float:
        return simd.lane4(simd.load4(values, 0), 0)

    with pytest.raises(Exception, match="Four needs C-contiguous float32 arrays"):
        first(np.zeros((2, 4)))
