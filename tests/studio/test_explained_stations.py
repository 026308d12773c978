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
