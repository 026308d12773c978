from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from belvedere.ground.color import (
    ENCODE_STEPS,
    LINEAR_TO_SRGB8,
    SRGB8_TO_LINEAR,
    color_to_linear,
    color_to_srgb8,
    decode_srgb8,
    encode_srgb8,
    linear_to_srgb,
    srgb_to_linear,
)
from belvedere.ground.errors import InputError
from tests.strategies import numbers

BYTES = np.arange(256, dtype=np.uint8)


def test_every_byte_survives_decoding_and_encoding() -> None:
    np.testing.assert_array_equal(encode_srgb8(decode_srgb8(BYTES)), BYTES)


def test_every_byte_survives_the_tables_that_kernels_use() -> None:
    index = (np.sqrt(SRGB8_TO_LINEAR) * np.float32(ENCODE_STEPS - 1) + np.float32(0.5)).astype(int)
    np.testing.assert_array_equal(LINEAR_TO_SRGB8[index], BYTES)


def test_the_encoding_table_is_never_off_by_more_than_one_byte() -> None:
    linear = np.linspace(0, 1, 100_001, dtype=np.float32)
    index = (np.sqrt(linear) * np.float32(ENCODE_STEPS - 1) + np.float32(0.5)).astype(int)
    off = LINEAR_TO_SRGB8[index].astype(int) - encode_srgb8(linear).astype(int)
    assert np.abs(off).max() <= 1


def test_the_curve_meets_the_standard_at_known_points() -> None:
    # IEC 61966-2-1: black, the end of the straight part, mid grey 188 = 0.5029 linear, white
    np.testing.assert_allclose(
        srgb_to_linear(np.array([0.0, 0.04045, 188 / 255, 1.0])),
        [0.0, 0.0031308, 0.50289, 1.0],
        atol=1e-5,
    )


@given(numbers(0.0, 4.0))
def test_encoding_undoes_decoding(value: float) -> None:
    encoded = np.array(value)
    # the standard's two branches do not meet exactly: they leave 1e-8 at the joint
    np.testing.assert_allclose(linear_to_srgb(srgb_to_linear(encoded)), encoded, atol=1e-7)


def test_the_curve_rises_everywhere() -> None:
    values = np.linspace(-0.1, 1.5, 2000)
    assert (np.diff(srgb_to_linear(values)) > 0).all()
    assert (np.diff(linear_to_srgb(values)) > 0).all()
    assert (np.diff(LINEAR_TO_SRGB8.astype(int)) >= 0).all()


def test_types_stay_float() -> None:
    for kind, expected in ((np.float64, np.float64), (np.float32, np.float32),
                           (np.float16, np.float32)):  # fmt: skip
        assert srgb_to_linear(np.ones(2, kind)).dtype == expected
        assert linear_to_srgb(np.ones(2, kind)).dtype == expected


def test_radiance_outside_the_display_is_clipped_and_nan_is_black() -> None:
    values = np.array([-1.0, np.nan, 2.0, np.inf, -np.inf])
    np.testing.assert_array_equal(encode_srgb8(values), [0, 0, 255, 255, 0])


def test_alpha_is_scaled_and_never_sent_through_the_curve() -> None:
    color = np.zeros((1, 256, 4), np.uint8)
    color[0, :, 0] = color[0, :, 3] = BYTES
    linear = color_to_linear(color)
    np.testing.assert_allclose(linear[0, :, 3], BYTES / 255.0, rtol=1e-6)
    np.testing.assert_array_equal(linear[0, :, 0], SRGB8_TO_LINEAR)
    np.testing.assert_array_equal(color_to_srgb8(linear), color)
    assert color_to_srgb8(color) is color


def test_float_colour_is_linear_already() -> None:
    color = np.full((1, 1, 3), 0.25, np.float32)
    np.testing.assert_array_equal(color_to_linear(color), color)


def test_only_bytes_are_decoded_as_bytes() -> None:
    with pytest.raises(InputError, match=r"decode_srgb8.color is float64, expected uint8"):
        decode_srgb8(np.zeros(3))  # type: ignore[arg-type]
