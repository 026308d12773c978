"""Each number that judges a warp's picture counts what it says, on cases made by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from belvedere.scene import Camera
from belvedere.studio._bench_quality import Quality, fill_nearest, mean_quality, quality
from belvedere.studio._bench_stations import Station

SIZE = 20


@pytest.fixture
def station() -> Station:
    """Noise at depth 2 whose lower half no reference saw, and sky in the first row."""
    color = np.random.default_rng(3).integers(0, 200, (SIZE, SIZE, 3)).astype(np.uint8)
    disparity = np.full((SIZE, SIZE), 0.5, np.float32)
    disparity[0] = 0.0
    seen = np.zeros((2, SIZE, SIZE), bool)
    seen[0, : SIZE // 4] = True
    seen[1, SIZE // 4 : SIZE // 2] = True
    camera = Camera.look_at((0, 0, 0), (1, 0, 0), width=SIZE, height=SIZE)
    return Station("hand-made", (), camera, color, disparity, seen[[0, 1, 1, 1, 1]])


@pytest.fixture
def references(station: Station, monkeypatch: pytest.MonkeyPatch) -> int:
    """How many references saw the upper half; the station needs none of their pictures here."""
    monkeypatch.setattr(Station, "seen", lambda self, n: self.seen_by[:n].any(axis=0))
    return 2


def everywhere() -> np.ndarray:
    return np.ones((SIZE, SIZE), bool)


def test_the_truth_itself_has_no_fault_but_ghosts(station: Station, references: int) -> None:
    judged = quality(station.color, station.disparity, everywhere(), station, references)
    assert judged.psnr == math.inf
    assert judged.ssim == pytest.approx(1.0)
    assert (judged.cracks, judged.wrong_depth) == (0.0, 0.0)
    assert judged.ghosts == 50.0


def test_psnr_is_of_what_was_seen_alone(station: Station, references: int) -> None:
    lighter = station.color + np.uint8(51)
    judged = quality(lighter, station.disparity, everywhere(), station, references)
    assert judged.psnr == pytest.approx(-20 * math.log10(0.2))
    below = station.color.copy()
    below[SIZE // 2 :] = 255
    again = quality(below, station.disparity, everywhere(), station, references)
    assert again.psnr == math.inf
    assert again.ssim == pytest.approx(1.0)


def test_ssim_is_of_the_same_pixels_up_to_the_border(station: Station, references: int) -> None:
    other = station.color.copy()
    other[0] = 255 - other[0]
    judged = quality(other, station.disparity, everywhere(), station, references)
    assert judged.ssim < 0.95


def test_a_hole_counts_with_its_neighbours_colour(station: Station, references: int) -> None:
    covered = everywhere()
    covered[4, 4:8] = False
    covered[15, 4:8] = False  # nobody saw those: no crack
    judged = quality(station.color, station.disparity, covered, station, references)
    assert judged.cracks == pytest.approx(100 * 4 / (SIZE * SIZE / 2))
    assert judged.psnr < 60  # the true colour under a hole is nobody's merit
    flat = replace(station, color=np.full_like(station.color, 90))
    assert quality(flat.color, flat.disparity, covered, flat, references).psnr == math.inf


def test_ghosts_are_what_is_painted_where_nobody_saw(station: Station, references: int) -> None:
    covered = station.seen(references).copy()
    assert quality(station.color, station.disparity, covered, station, references).ghosts == 0.0
    covered[-1, :5] = True
    judged = quality(station.color, station.disparity, covered, station, references)
    assert judged.ghosts == pytest.approx(100 * 5 / SIZE**2)
    fewer = quality(station.color, station.disparity, covered, station, 1)
    assert fewer.ghosts == pytest.approx(100 * (5 + SIZE * SIZE / 4) / SIZE**2)


def test_depth_is_wrong_from_two_per_cent_on(station: Station, references: int) -> None:
    disparity = station.disparity.copy()
    disparity[3, :4] *= np.float32(1.03)
    disparity[4, :4] *= np.float32(0.97)
    disparity[5, :4] *= np.float32(1.01)
    disparity[6, :2] = np.nan
    disparity[0, :5] = 0.001  # a kilometre is as far as the sky
    disparity[0, 5:8] = 0.01  # a hundred metres are not
    disparity[15] = 7.0  # nobody saw what is there
    covered = everywhere()
    covered[7] = False
    judged = quality(station.color, disparity, covered, station, references)
    assert judged.wrong_depth == pytest.approx(100 * (4 + 4 + 2 + 3) / (SIZE * SIZE / 2 - SIZE))


def test_a_picture_of_nothing_is_judged_too(station: Station, references: int) -> None:
    nothing = np.zeros((SIZE, SIZE), np.float32)
    judged = quality(np.zeros_like(station.color), nothing, nothing, station, references)
    assert judged.cracks == 100.0
    assert judged.ghosts == judged.wrong_depth == 0.0
    assert math.isfinite(judged.psnr)


def test_holes_show_the_nearest_covered_pixel() -> None:
    color = np.zeros((3, 5, 3), np.uint8)
    color[:, 0], color[:, 4] = 10, 40
    covered = np.zeros((3, 5), bool)
    covered[:, 0] = covered[:, 4] = True
    filled = fill_nearest(color, covered)
    assert (filled[:, 1] == 10).all()
    assert (filled[:, 3] == 40).all()


def test_means_are_of_each_number() -> None:
    mean = mean_quality([Quality(30, 0.9, 1, 2, 3), Quality(32, 0.8, 3, 0, 5)])
    assert (mean.psnr, mean.cracks, mean.ghosts, mean.wrong_depth) == (31, 2, 1, 4)
    assert mean.ssim == pytest.approx(0.85)
