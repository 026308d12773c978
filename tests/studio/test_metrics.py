"""PSNR and SSIM against slow direct implementations and values known by hand."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from belvedere.ground.color import decode_srgb8, srgb_to_linear
from belvedere.ground.errors import InputError
from belvedere.studio.metrics import json_number, psnr, ssim


def slow_ssim_map(a: np.ndarray, b: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Wang 2004, eq. 13, one window at a time; unknown pixels have no weight."""
    luma = np.array([0.299, 0.587, 0.114])
    x, y = (a[..., :3] / 255.0) @ luma, (b[..., :3] / 255.0) @ luma
    r = np.arange(-5, 6)
    g = np.exp(-(r[:, None] ** 2 + r[None, :] ** 2) / (2 * 1.5**2))
    g /= g.sum()
    out = np.full(x.shape, np.nan)
    for v in range(5, x.shape[0] - 5):
        for u in range(5, x.shape[1] - 5):
            window = np.s_[v - 5 : v + 6, u - 5 : u + 6]
            w = g * mask[window]
            if w.sum() == 0:
                continue
            w = w / w.sum()
            p, q = x[window], y[window]
            mp, mq = (w * p).sum(), (w * q).sum()
            vp, vq = (w * (p - mp) ** 2).sum(), (w * (q - mq) ** 2).sum()
            c = (w * (p - mp) * (q - mq)).sum()
            out[v, u] = ((2 * mp * mq + 1e-4) * (2 * c + 9e-4)) / (
                (mp**2 + mq**2 + 1e-4) * (vp + vq + 9e-4)
            )
    return out


@pytest.fixture
def pair(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    a = rng.integers(0, 256, (24, 31, 3), dtype=np.uint8)
    b = np.clip(a.astype(int) + rng.integers(-30, 31, a.shape), 0, 255).astype(np.uint8)
    return a, b


def test_psnr_is_minus_ten_log_of_the_mean_square_of_encoded_values(pair) -> None:
    a, b = pair
    total = sum(
        (float(p) / 255 - float(q) / 255) ** 2 for p, q in zip(a.ravel(), b.ravel(), strict=True)
    )
    assert psnr(a, b) == pytest.approx(-10 * math.log10(total / a.size), abs=1e-9)


def test_a_tenth_of_the_range_everywhere_is_twenty_decibels() -> None:
    black = np.zeros((4, 5, 3), np.float32)
    tenth = np.full((4, 5, 3), srgb_to_linear(0.1), np.float32)
    assert psnr(black, tenth) == pytest.approx(20.0, abs=1e-4)


def test_psnr_in_linear_space_compares_radiance() -> None:
    black = np.zeros((4, 5, 3), np.float32)
    assert psnr(black, np.full_like(black, 0.1), space="linear") == pytest.approx(20.0, abs=1e-5)


def test_bytes_and_the_linear_values_they_stand_for_are_the_same_picture(pair) -> None:
    a, b = pair
    assert psnr(decode_srgb8(a), b) == pytest.approx(psnr(a, b), abs=1e-3)
    assert ssim(decode_srgb8(a), b) == pytest.approx(ssim(a, b), abs=1e-5)


def test_identical_pictures_have_infinite_psnr_and_an_ssim_of_one(pair) -> None:
    a, _ = pair
    assert psnr(a, a) == math.inf
    assert ssim(a, a) == 1.0


def test_masked_psnr_sees_only_the_known_pixels(pair, rng: np.random.Generator) -> None:
    a, b = pair
    mask = rng.random(a.shape[:2]) < 0.4
    ruined = b.copy()
    ruined[~mask] = 0
    assert psnr(a, ruined, mask) == psnr(a, b, mask)
    assert psnr(a, b, mask) == pytest.approx(
        -10 * math.log10((((a / 255.0 - b / 255.0) ** 2)[mask]).mean()), abs=1e-9
    )


def test_ssim_equals_the_direct_sum_over_windows(pair) -> None:
    a, b = pair
    slow = slow_ssim_map(a, b, np.ones(a.shape[:2]))
    assert ssim(a, b) == pytest.approx(np.nanmean(slow), abs=1e-12)


def test_masked_ssim_equals_the_direct_sum_over_known_pixels(pair, rng) -> None:
    a, b = pair
    mask = rng.random(a.shape[:2]) < 0.7
    slow = slow_ssim_map(a, b, mask)
    inner = np.zeros_like(mask)
    inner[5:-5, 5:-5] = mask[5:-5, 5:-5]
    assert ssim(a, b, mask) == pytest.approx(slow[inner].mean(), abs=1e-9)


def test_what_lies_in_a_hole_does_not_change_masked_ssim(pair, rng) -> None:
    a, b = pair
    mask = np.ones(a.shape[:2], bool)
    mask[8:14, 10:20] = False
    ruined = b.copy()
    ruined[~mask] = rng.integers(0, 256, ruined[~mask].shape)
    assert ssim(a, ruined, mask) == pytest.approx(ssim(a, b, mask), abs=1e-12)


def test_ssim_of_two_flat_pictures_is_the_luminance_term_alone() -> None:
    a, b = np.full((16, 16, 3), 51, np.uint8), np.full((16, 16, 3), 102, np.uint8)
    x, y = 0.2, 0.4
    assert ssim(a, b) == pytest.approx((2 * x * y + 1e-4) / (x * x + y * y + 1e-4), abs=1e-9)


def test_a_negative_has_a_negative_ssim(pair) -> None:
    a, _ = pair
    assert ssim(a, 255 - a) < -0.5


def test_nothing_known_gives_no_number(pair) -> None:
    a, b = pair
    nothing = np.zeros(a.shape[:2], bool)
    assert math.isnan(psnr(a, b, nothing))
    assert math.isnan(ssim(a, b, nothing))


def test_alpha_is_ignored(pair) -> None:
    a, b = pair
    layered = np.dstack([a, np.full(a.shape[:2], 7, np.uint8)])
    assert psnr(layered, b) == psnr(a, b)


def test_metrics_do_not_depend_on_the_order_of_the_pictures(pair) -> None:
    a, b = pair
    assert psnr(a, b) == psnr(b, a)
    assert ssim(a, b) == pytest.approx(ssim(b, a), abs=1e-12)


@pytest.mark.parametrize(
    ("value", "written"),
    [(math.inf, '"Infinity"'), (math.nan, "null"), (None, "null"), (1 / 3, "0.3333")],
)
def test_json_holds_every_measured_number(value: float | None, written: str) -> None:
    assert json.dumps(json_number(value), allow_nan=False) == written


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda a: psnr(a, a[:-1]), "expected the same size: resize one of them"),
        (lambda a: psnr(a, a, space="rgb"), "psnr.space is 'rgb', expected one of 'srgb'"),
        (lambda a: psnr(a, a, np.ones(a.shape[:2])), "mask is float64, expected bool"),
        (lambda a: psnr(a, a, np.ones((2, 2), bool)), "psnr.mask has shape (2, 2)"),
        (lambda a: ssim(a[:10], a[:10]), "expected at least 11 x 11 pixels"),
        (lambda a: psnr(a[..., 0], a[..., 0]), "expected (height, width, 3 or 4)"),
    ],
)
def test_pictures_that_cannot_be_compared_are_refused(pair, call, message: str) -> None:
    with pytest.raises(InputError) as refusal:
        call(pair[0])
    assert message in str(refusal.value)
