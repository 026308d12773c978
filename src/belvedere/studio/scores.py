"""What an evaluation finds: one score a held-out view and way of predicting it, and their means."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from belvedere.studio.metrics import json_number

COLUMNS: tuple[tuple[str, str, str, str, int], ...] = (
    ("psnr_covered", "PSNR, covered", "dB", "db", 1),
    ("psnr_common", "PSNR, common", "dB", "db", 1),
    ("psnr_whole", "PSNR, whole", "dB, filled", "db", 1),
    ("psnr_unfilled", "PSNR, whole", "dB, black holes", "db", 1),
    ("ssim_covered", "SSIM, covered", "", "index", 1),
    ("ssim_whole", "SSIM, whole", "filled", "index", 1),
    ("hole_fraction", "Holes", "%", "percent", -1),
    ("ms", "Render", "ms a view", "ms", -1),
    ("fill_ms", "Filling", "ms more", "ms", 0),
)
"""Key, name, unit, format, and whether more (1) or less (-1) is better (0: neither), of each
column of a table."""


@dataclass(frozen=True, slots=True)
class ViewScore:
    """One held-out view predicted in one way. Decibels are on sRGB-encoded values."""

    view: str
    """Name of the held-out view."""
    reconstruction: str
    references: tuple[str, ...]
    """Names of the views it was predicted from, best first."""
    nearest_m: float
    """Distance from its center of projection to the nearest of theirs, metres."""
    psnr_covered: float
    """On pixels this prediction covers, dB; NaN if there are none."""
    psnr_common: float
    """On pixels that every compared reconstruction covers, dB."""
    psnr_whole: float
    """On every pixel, holes filled from the background beside them, dB."""
    psnr_unfilled: float
    """On every pixel, holes left black, dB."""
    ssim_covered: float
    """Structural similarity on the covered pixels, at most 1."""
    ssim_whole: float
    """Structural similarity on every pixel, holes filled."""
    hole_fraction: float
    """Share of pixels no reference saw, 0 to 1."""
    common_fraction: float
    """Share of pixels that every compared reconstruction covers, 0 to 1."""
    ms: float
    """Median time of a warp without filling, milliseconds; reading files is not in it."""
    fill_ms: float
    """What filling the holes adds, milliseconds."""

    def as_dict(self) -> dict[str, Any]:
        """For JSON: NaN is null, infinite PSNR "Infinity"."""
        return _json_fields(self)


@dataclass(frozen=True, slots=True)
class Summary:
    """One reconstruction over all held-out views: means, and medians of the times."""

    reconstruction: str
    views: int
    """Held-out views."""
    measured: int
    """Those of them with any covered pixel; the others have no PSNR to take a mean of."""
    psnr_covered: float
    psnr_common: float
    psnr_whole: float
    psnr_unfilled: float
    ssim_covered: float
    ssim_whole: float
    hole_fraction: float
    common_fraction: float
    ms: float
    fill_ms: float

    @classmethod
    def of(cls, scores: Sequence[ViewScore]) -> Summary:
        """The means and medians of one reconstruction's scores (of one view each)."""
        return cls(
            scores[0].reconstruction,
            len(scores),
            sum(not math.isnan(score.psnr_covered) for score in scores),
            *(_mean([getattr(score, name) for score in scores]) for name in _AVERAGED),
            ms=statistics.median(score.ms for score in scores),
            fill_ms=statistics.median(score.fill_ms for score in scores),
        )

    def as_dict(self) -> dict[str, Any]:
        """For JSON: NaN is null, infinite PSNR "Infinity"."""
        return _json_fields(self)


_AVERAGED = ("psnr_covered", "psnr_common", "psnr_whole", "psnr_unfilled", "ssim_covered",
             "ssim_whole", "hole_fraction", "common_fraction")  # fmt: skip


@dataclass(frozen=True, slots=True)
class Evaluation:
    """The whole comparison: what was asked, every score, and the summary of each way."""

    scores: tuple[ViewScore, ...]
    """View after view, and within a view in the order of ``options["reconstructions"]``."""
    options: dict[str, Any]
    """What was asked for, as JSON values."""
    view_count: int
    """Views in the set."""
    size: tuple[int, int]
    """(width, height) of the first held-out view."""
    seconds: float
    """The whole comparison, reading files and measuring included."""

    @property
    def reconstructions(self) -> tuple[str, ...]:
        """The compared ways, in the order asked for."""
        return tuple(dict.fromkeys(score.reconstruction for score in self.scores))

    @property
    def held_out(self) -> tuple[str, ...]:
        """Names of the predicted views."""
        return tuple(dict.fromkeys(score.view for score in self.scores))

    @property
    def summaries(self) -> tuple[Summary, ...]:
        """One a reconstruction, in the order asked for."""
        return tuple(
            Summary.of([score for score in self.scores if score.reconstruction == name])
            for name in self.reconstructions
        )

    def as_dict(self) -> dict[str, Any]:
        """For report.json; see `belvedere.studio.report`."""
        return {
            "options": self.options,
            "view_count": self.view_count,
            "size": list(self.size),
            "seconds": round(self.seconds, 2),
            "summary": [summary.as_dict() for summary in self.summaries],
            "views": [score.as_dict() for score in self.scores],
        }


def shown_number(value: float | str | None, kind: str) -> str:
    """A number of report.json for people's eyes; kind as in `COLUMNS`."""
    if value is None:
        return "–"
    if isinstance(value, str):
        return "∞"
    match kind:
        case "db":
            return f"{value:.2f}"
        case "index":
            return f"{value:.4f}"
        case "percent":
            return f"{100 * value:.2f}"
        case _:
            return f"{value:.1f}" if value >= 10 else f"{value:.2f}"


def _json_fields(numbers: ViewScore | Summary) -> dict[str, Any]:
    return {
        name: json_number(value, 6 if name.endswith("fraction") else 4)
        if isinstance(value, float)
        else value
        for name, value in asdict(numbers).items()
    }


def _mean(values: Sequence[float]) -> float:
    """The mean of those that are numbers (a view without covered pixels has no PSNR)."""
    known = [value for value in values if not math.isnan(value)]
    return statistics.fmean(known) if known else math.nan
