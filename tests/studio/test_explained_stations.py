"""What `explain` says of frames, held against the truth of the benchmark's stations.

Stations of the house on which the error's factors were fitted, and of another house on which
nothing was. Two references, 256 x 256 pixels; cracks, exposures and the outside are counted over
three stations together.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pytest
from scipy.stats import spearmanr

import belvedere as bv
from belvedere.studio._bench_stations import Station, make_stations
from belvedere.warp import RECONSTRUCTIONS

pytestmark = pytest.mark.slow

SIZE, COUNT = 256, 2


class Judged(NamedTuple):
    """All pixels of three stations, end to end."""

    hole: npt.NDArray[np.uint8]
    """What `explain` said."""
    true_hole: npt.NDArray[np.uint8]
    """What a pixel would be as a hole: seen by some reference, by none, or outside all."""
    error: npt.NDArray[np.float32]
    true_error: npt.NDArray[np.float64]
    source_saw: npt.NDArray[np.bool_]
    """Whether the reference named as source truly saw the pixel's surface."""
    seen: npt.NDArray[np.bool_]
    """Whether any did."""


@lru_cache(maxsize=2)
def stations(held_out: bool) -> list[Station]:
    return make_stations(SIZE, held_out)


@lru_cache(maxsize=16)
def judged(reconstruction: Any, held_out: bool) -> Judged:
    return Judged(*map(np.concatenate, zip(*_each(reconstruction, held_out), strict=True)))


def _each(reconstruction: Any, held_out: bool) -> Iterator[tuple[Any, ...]]:
    for station in stations(held_out):
        views = station.views(COUNT)
        frame = bv.warp(views, station.camera, reconstruction=reconstruction, explain=True)
        why = frame.explanation
        assert why is not None
        off = (frame.color.astype(float) - station.color) / 255
        saw = np.take_along_axis(station.seen_by, np.maximum(why.source, 0)[None], 0)[0]
        yield (
            why.hole.ravel(), true_kinds(station).ravel(), why.error.ravel(),
            np.sqrt((off**2).mean(-1)).ravel(), saw.ravel(), station.seen(COUNT).ravel(),
        )  # fmt: skip


def true_kinds(station: Station) -> npt.NDArray[np.uint8]:
    """(H, W) what each pixel is if it is a hole."""
    camera, outside = station.camera, np.ones(station.disparity.shape, bool)
    rays = camera.rays(*camera.pixel_grid())
    for view in station.views(COUNT):
        other = view.camera
        assert isinstance(other, bv.Camera)
        delta = station.disparity[..., None].astype(float)
        image = (rays + delta * (camera.center - other.center)) @ np.linalg.inv(other.matrix).T
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = image[..., 0] / image[..., 2], image[..., 1] / image[..., 2]
        inside = (image[..., 2] > 0) & (abs(x - (other.width - 1) / 2) <= other.width / 2)
        outside &= ~(inside & (abs(y - (other.height - 1) / 2) <= other.height / 2))
    unseen = np.where(outside, bv.Hole.OUTSIDE, bv.Hole.UNSEEN)
    return np.where(station.seen(COUNT), bv.Hole.UNDERSAMPLED, unseen).astype(np.uint8)


def precision_and_recall(found: Judged, kind: bv.Hole) -> tuple[float, float, int]:
    said = found.hole == kind
    true = (found.hole != bv.Hole.COVERED) & (found.true_hole == kind)
    both = int((said & true).sum())
    return both / max(int(said.sum()), 1), both / max(int(true.sum()), 1), int(true.sum())


LEAST: dict[str, tuple[float, float]] = {
    # precision and recall of cracks on the stations that are shown
    "point": (0.95, 0.80),  # 0.99 and 0.86 of 5575 when this was written; at 512 0.97 and 0.92
    "splat": (0.80, 0.30),  # 0.90 and 0.38 of 450; at 512 0.79 and 0.61
}
"""What is left in the others are cracks along silhouettes, which nobody proves: of 640 in ``mesh``,
31 in ``offset`` and 261 in ``inverse`` 1 in 50, none and 1 in 25 are named."""


@pytest.mark.parametrize("held_out", [False, True], ids=["shown", "held out"])
@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_kinds_of_holes_are_the_true_ones(reconstruction: str, held_out: bool) -> None:
    found = judged(reconstruction, held_out)
    holes = found.hole != bv.Hole.COVERED
    right = float((found.hole == found.true_hole)[holes].mean())
    assert right > 0.78, right  # 0.86 to 0.97 on the shown stations, 0.82 to 0.87 held out
    _, recall, _ = precision_and_recall(found, bv.Hole.UNSEEN)
    assert recall > 0.94  # 0.97 to 0.98, and 0.99 to 1.00
    precision, recall, _ = precision_and_recall(found, bv.Hole.OUTSIDE)
    assert precision > 0.65  # 0.74 to 0.77, and 1.00
    assert recall > 0.65  # 0.95 to 0.96, and 0.71 to 0.75


@pytest.mark.parametrize("reconstruction", sorted(LEAST))
def test_cracks_are_told_from_exposures(reconstruction: str) -> None:
    precision, recall, count = precision_and_recall(
        judged(reconstruction, False), bv.Hole.UNDERSAMPLED
    )
    assert count > 300
    assert precision > LEAST[reconstruction][0]
    assert recall > LEAST[reconstruction][1]


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_an_exposure_is_hardly_ever_called_a_crack(reconstruction: str) -> None:
    for held_out in (False, True):
        found = judged(reconstruction, held_out)
        exposed = (found.hole != bv.Hole.COVERED) & ~found.seen
        wrong = (found.hole == bv.Hole.UNDERSAMPLED)[exposed].mean()
        assert wrong < 0.05  # at most 0.03 when this was written


@pytest.mark.parametrize("held_out", [False, True], ids=["shown", "held out"])
@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_the_error_expected_goes_with_the_true_one(reconstruction: str, held_out: bool) -> None:
    found = judged(reconstruction, held_out)
    covered = found.hole == bv.Hole.COVERED
    expected, true = found.error[covered], found.true_error[covered]
    rank = float(spearmanr(expected, true).statistic)  # type: ignore[attr-defined]
    assert rank > 0.6, rank  # 0.70 to 0.78, held out as well
    ratio = rms(true) / rms(expected)
    assert 1 / 1.5 < ratio < 1.5, ratio  # 0.77 to 1.06
    # the same in each half of the tenths that expect most: below, errors are a byte or less
    tenths = np.array_split(np.argsort(expected), 10)[5:]
    for tenth in tenths:
        assert 1 / 2 < rms(true[tenth]) / rms(expected[tenth]) < 2  # 0.72 to 1.41


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_the_source_truly_saw_the_pixel(reconstruction: str) -> None:
    found = judged(reconstruction, False)
    shown = (found.hole == bv.Hole.COVERED) & found.seen
    assert found.source_saw[shown].mean() > 0.98  # 0.99


def rms(values: npt.NDArray[Any]) -> float:
    return float(np.sqrt(np.mean(np.asarray(values, np.float64) ** 2)))
