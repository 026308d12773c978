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
def weighted_block(
    values: np.ndarray, depths: np.ndarray, start: int, middle: float, reach: float,
    out: np.ndarray, out_kept: np.ndarray,
) -> float:  # fmt: skip
    """Two rows of four fours, the second only where its depths are near; returns their weights."""
    across = simd.four(np.float32(0.1), np.float32(0.2), np.float32(0.3), np.float32(0.4))
    kept = simd.scale4(simd.kept4(depths, start, middle, reach, across), np.float32(2.0))
    rows = simd.scale16(simd.load16(values, 1), np.float32(0.5))
    rows = simd.add_scaled16(rows, simd.load16(values, 5), np.float32(3.0))
    simd.store4(
        out, 0,
        simd.weigh16(rows, np.float32(1.0), np.float32(2.0), np.float32(4.0), np.float32(8.0)),
    )  # fmt: skip
    near = simd.add_weighted16(simd.zero16(), simd.load16(values, 5), kept)
    simd.store4(out, 1, simd.fold16(near))
    simd.store4(out_kept, 0, kept)
    return simd.sum4(kept)


@kernel
def cubic(place: np.float32, out: np.ndarray) -> None:
    """Weights of four samples, written to row 0 of ``out``."""
    simd.store4(out, 0, simd.cubic4(place))


@kernel
def there_and_back(values: np.ndarray, out_bits: np.ndarray, out: np.ndarray) -> None:
    for n in range(values.size):
        out_bits[n] = simd.bits_of(values[n])
        out[n] = simd.float_of(out_bits[n])


@kernel
def sixteen_steps(values: np.ndarray, out: np.ndarray) -> None:
    """Rows of out: of a sum, of a product, of a multiple, of an outer product, maximum."""
    a, b = simd.load16(values, 0), simd.load16(values, 1)
    simd.store4(out, 0, simd.part16(simd.add16(simd.zero16(), simd.add16(a, b)), 2))
    simd.store4(out, 1, simd.fold16(simd.mul16(a, b)))
    simd.store4(out, 2, simd.part16(simd.scale16(a, values[0, 1]), 1))
    outer = simd.outer16(simd.load4(values, 2), simd.load4(values, 3))
    simd.store4(out, 3, simd.part16(outer, 3))
    simd.store4(out, 4, simd.max4(simd.load4(values, 0), simd.load4(values, 1)))


@kernel
def shifts(value: int, count: int, out: np.ndarray) -> None:
    a, n = np.uint32(value), np.uint32(count)
    out[0], out[1], out[2] = simd.shl32(a, n), simd.shr32(a, n), simd.mul32(a, a)


@pytest.mark.parametrize("form", [sixteen_steps, getattr(sixteen_steps, "py_func", sixteen_steps)])
def test_sixteen_floats_are_four_fours(form: object) -> None:
    values = np.random.default_rng(1).normal(size=(5, 4)).astype(np.float32)
    out = np.zeros((5, 4), np.float32)
    form(values, out)  # type: ignore[operator]
    a, b = values[:4], values[1:]
    np.testing.assert_array_equal(out[0], (a + b)[2])
    np.testing.assert_allclose(out[1], (a * b).sum(axis=0), rtol=1e-5)
    np.testing.assert_array_equal(out[2], a[1] * values[0, 1])
    np.testing.assert_array_equal(out[3], values[2, 3] * values[3])
    np.testing.assert_array_equal(out[4], np.maximum(values[0], values[1]))


@pytest.mark.parametrize("form", [shifts, getattr(shifts, "py_func", shifts)])
def test_whole_numbers_of_32_bits_lose_what_leaves_them(form: object) -> None:
    out = np.zeros(3, np.uint32)
    form(0x80000003, 5, out)  # type: ignore[operator]
    assert out.tolist() == [0x60, 0x04000000, 9]


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


@pytest.mark.parametrize(
    "form", [weighted_block, getattr(weighted_block, "py_func", weighted_block)]
)
def test_sums_of_sixteens_are_those_of_their_fours(form: object) -> None:
    rng = np.random.default_rng(1)
    values = rng.normal(size=(9, 4)).astype(np.float32)
    depths = np.array([[9.0, 0.5, 0.7], [np.nan, 0.4, 9.0]], np.float32)
    out, kept = np.zeros((2, 4), np.float32), np.zeros((1, 4), np.float32)
    total = form(values, depths, 1, 0.55, 0.16, out, kept)  # type: ignore[operator]
    near = np.array([0.2, 0.4, 0.0, 0.8], np.float32)  # 0.5, 0.7, NaN, 0.4
    np.testing.assert_allclose(kept[0], near)
    np.testing.assert_allclose(total, 1.4, rtol=1e-6)
    rows = 0.5 * values[1:5] + 3 * values[5:9]
    np.testing.assert_allclose(out[0], np.array([1, 2, 4, 8], np.float32) @ rows, rtol=1e-5)
    np.testing.assert_allclose(out[1], near @ values[5:9], rtol=1e-5)


@kernel
def flags(values: np.ndarray, limit: float) -> int:
    return simd.bits16(simd.load16(values, 0), limit)


@pytest.mark.parametrize("form", [flags, getattr(flags, "py_func", flags)])
def test_bits_of_sixteen_say_which_reach_a_limit(form: object) -> None:
    values = np.array([[1, -1, 2, np.nan], [0, 0.5, 3, 3], [-2, 1, 0, 0], [0, 0, 0, 1]], np.float32)
    wanted = sum(1 << k for k, value in enumerate(values.ravel()) if value >= 0.5)
    assert form(values, 0.5) == wanted  # type: ignore[operator]


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


@kernel
def between(values: np.ndarray, out: np.ndarray) -> None:
    low = simd.min4(simd.load4(values, 0), simd.load4(values, 1))
    simd.store4(out, 0, low)
    simd.store4(out, 1, simd.max4(simd.load4(values, 0), simd.load4(values, 1)))


@pytest.mark.parametrize("form", [between, getattr(between, "py_func", between)])
def test_the_smaller_and_the_larger_of_two_fours_are_taken_lane_by_lane(form: object) -> None:
    values = np.array([[1, 5, -2, 0], [3, 4, -3, 0]], np.float32)
    out = np.zeros((2, 4), np.float32)
    form(values, out)  # type: ignore[operator]
    np.testing.assert_array_equal(out, [[1, 4, -3, 0], [3, 5, -2, 0]])


@pytest.mark.parametrize("place", [0.0, 0.25, 0.5, 0.875, 1.0])
def test_cubic_weights_reproduce_quadratics(place: float) -> None:
    out = np.zeros((1, 4), np.float32)
    cubic(np.float32(place), out)
    steps = np.arange(-1.0, 3.0)
    for power in range(3):
        assert np.isclose(out[0] @ steps**power, place**power, atol=1e-6)
    np.testing.assert_allclose(out[0], simd.cubic4(place), atol=1e-6)


@kernel
def first_after_fetching(values: np.ndarray, index: int) -> float:
    """The first of the values; another one is asked for."""
    simd.prefetch(values, index)
    return values[0]


@pytest.mark.parametrize("index", [0, 7, 10**9, -(10**9)])
def test_asking_for_memory_changes_nothing_wherever_it_is(index: int) -> None:
    values = np.arange(8, dtype=np.uint16) + np.uint16(3)
    assert first_after_fetching(values, index) == 3
    np.testing.assert_array_equal(values, np.arange(8) + 3)
