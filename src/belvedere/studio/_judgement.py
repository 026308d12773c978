"""The verdict on a capture's conventions, from the scores of the readings, in words.

See `belvedere.studio.conventions` for what counts as evidence and how strong it must be.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from belvedere.scene.conventions import Conventions
from belvedere.studio._hypotheses import Evidence
from belvedere.studio._principal_point import WRITTEN_TOLERANCE_PX, ShiftEvidence
from belvedere.studio._search import Hypothesis, Search

MARGIN = 0.08
"""Score by which another reading must beat the current one."""
DENSE_MARGIN = 0.15
"""The same for depth maps alone, which agree by chance more often."""
ENOUGH = 0.4
"""Share of points that a reading must explain."""
RIVAL = 0.03
"""Another remedy whose score is this near to the best one's is a rival to it."""
FLAT = 0.9
"""Share of its score that a reading may keep at half or twice the scale before the scale counts as
unobservable."""
HALF_PRIOR = 5.0
"""Log odds against half a pixel before looking."""

Verdict = Literal["agree", "mistake", "cannot tell"]


@dataclass(frozen=True, slots=True)
class ConventionReport:
    """What the check found, in a line for people and in numbers for programs."""

    verdict: Verdict
    line: str
    """One line: what is wrong, how sure, and the option to pass; or that all is well."""
    options: dict[str, str | float] = field(default_factory=dict)
    """Options of `Conventions` that mend it, absolute values; empty unless a mistake is named."""
    agreement: float | None = None
    """Share of matched points that agree as now read, 0 to 1; None when nothing was compared."""
    best_agreement: float | None = None
    """The same for the best reading."""
    views: int = 0
    points: int = 0
    basis: Literal["matches", "depth", "nothing"] = "nothing"
    """What was compared: matched corners, or depth maps alone."""
    hypotheses: tuple[Hypothesis, ...] = ()
    """Every reading tried, with its scores; the current one first."""
    pixel_centers: ShiftEvidence | None = None
    """Evidence about half a pixel; None when the check did not get that far."""

    @property
    def cli(self) -> str:
        """The options as the command line takes them: ``--depth-scale 0.001``."""
        return " ".join(f"--{k.replace('_', '-')} {_text(v)}" for k, v in self.options.items())

    def as_dict(self) -> dict[str, Any]:
        """Everything, as JSON values."""
        return {**asdict(self), "cli": self.cli}


def judge(evidence: Evidence, result: Search, current: Conventions, views: int) -> ConventionReport:
    now = result.current
    best = _simplest_best(result)
    facts: dict[str, Any] = {
        "agreement": now.agreement, "best_agreement": best.agreement, "views": views,
        "points": len(evidence.matches), "basis": "depth" if evidence.dense else "matches",
        "hypotheses": result.hypotheses,
    }  # fmt: skip
    margin = DENSE_MARGIN if evidence.dense else MARGIN
    better = best.changes and best.score > now.score + margin and best.agreement >= ENOUGH
    if better and _improves(evidence, result, best):
        rivals = [
            h for h in result.hypotheses
            if h is not best and h.changes and len(h.changes) <= len(best.changes)
            and h.score > best.score - RIVAL
        ]  # fmt: skip
        if rivals:
            either = " or ".join(_remedy(h, current)[0] for h in (best, *rivals))
            return ConventionReport(
                "cannot tell",
                f"neighbouring views disagree ({now.agreement:.0%} of points match); more than "
                f"one change would mend it: {either}",
                **facts,
            )
        remedy, options = _remedy(best, current)
        how = "agree poorly" if now.agreement > 0.5 else "disagree"
        line = (
            f"neighbouring views {how} ({now.agreement:.0%} of points match); they would agree "
            f"({best.agreement:.0%}) if {remedy}"
        )
        fitted = best.depth_scale != now.depth_scale
        if fitted and (
            _scale_is_free(evidence, result, best, 2.0, FLAT)
            or _scale_is_free(evidence, result, best, 1.25, 0.95)
        ):
            return ConventionReport(
                "cannot tell",
                f"{line}, but at which depth scale cannot be told: the cameras move too little",
                **facts,
            )
        return ConventionReport("mistake", f"{line}: pass {_keywords(options)}", options, **facts)
    if better:
        return ConventionReport(
            "cannot tell",
            f"neighbouring views agree poorly ({now.agreement:.0%} of points match) and would "
            f"agree better ({best.agreement:.0%}) if {_remedy(best, current)[0]}, but too few "
            "points or pairs of views say so",
            **facts,
        )
    if now.agreement < ENOUGH:
        return ConventionReport(
            "cannot tell",
            f"neighbouring views disagree ({now.agreement:.0%} of points match) and none of the "
            "known mistakes explains it: poses, calibration, or views that do not overlap?",
            **facts,
        )
    if _scale_is_free(evidence, result, now, 2.0, FLAT):
        return ConventionReport(
            "cannot tell",
            f"neighbouring views agree ({now.agreement:.0%} of points match), but they would at "
            "any depth scale: the cameras hardly move",
            **facts,
        )
    line = f"neighbouring views agree ({now.agreement:.0%} of points match)"
    return ConventionReport("agree", line, **facts)


def _simplest_best(result: Search) -> Hypothesis:
    """The best reading with one change, unless one with more is better by `MARGIN`."""
    best = result.current
    for count in range(1, 5):
        group = [h for h in result.hypotheses if len(h.changes) == count]
        top = max(group, key=lambda h: h.score, default=best)
        if top.score > best.score + MARGIN:
            best = top
    return best


def _improves(evidence: Evidence, result: Search, best: Hypothesis) -> bool:
    """Whether most pairs of views are better off, by more than the scatter of points explains."""

    def scores(h: Hypothesis) -> npt.NDArray[np.float64]:
        gain = evidence.gain(h.depth_kind, h.depth_scale)
        return evidence.scores(h.reading, gain, result.tolerance_px, result.depth_tolerance)[0]

    gained = scores(best) - scores(result.current)
    by_pair = np.bincount(evidence.matches.pair, gained)
    strength = gained.sum() / (np.sqrt((gained**2).sum()) + 1e-9)
    return bool(strength > 5.0 and (by_pair > 0).mean() >= 0.7)


def _scale_is_free(
    evidence: Evidence, result: Search, held: Hypothesis, factor: float, share: float
) -> bool:
    """Whether scales ``factor`` away keep ``share`` of a hypothesis's score: it shows no scale."""
    gain = evidence.gain(held.depth_kind, held.depth_scale)
    here, less, more = evidence.scores(
        held.reading,
        [gain, gain / factor, gain * factor],
        result.tolerance_px,
        result.depth_tolerance,
    ).mean(axis=1)
    return bool(max(less, more) > share * here)


def with_shift(
    report: ConventionReport,
    shift: ShiftEvidence,
    current: Conventions,
    center: tuple[float, float],
    size: tuple[int, int],
) -> ConventionReport:
    values = {**_fields(report), "pixel_centers": shift}
    if shift.pictures + shift.written - HALF_PRIOR <= 0:
        return ConventionReport(**values)
    other = "half" if current.pixel_centers == "integer" else "integer"
    options: dict[str, str | float] = {"pixel_centers": other}
    if shift.pictures > HALF_PRIOR and shift.shift is not None:
        why = (
            f"the pictures put the principal point {shift.shift[0]:+.2f}, {shift.shift[1]:+.2f} "
            f"pixels from where K has it (standard error {max(shift.error or (0.0,)):.2f})"
        )
    else:
        why = (
            f"{_nominal(center, size, current)}, as files do whose first pixel has its "
            f"{'corner' if other == 'half' else 'centre'} at 0; the pictures are too noisy to "
            "confirm or deny it"
        )
    values |= {
        "verdict": "mistake", "options": options,
        "line": f"pixel centres look half a pixel off: {why}: pass {_keywords(options)}",
    }  # fmt: skip
    return ConventionReport(**values)


def _nominal(center: tuple[float, float], size: tuple[int, int], current: Conventions) -> str:
    """Which written coordinate stands at the middle of the picture, in words."""
    stored = 0.5 if current.pixel_centers == "half" else 0.0
    for name, value, length in zip(("cx", "cy"), center, size, strict=True):
        written = value + stored
        middle = (length - 1) / 2 if stored else length / 2
        if abs(written - middle) < WRITTEN_TOLERANCE_PX:
            formula = f"({length} - 1) / 2" if stored else f"{length} / 2"
            return f"K is written with {name} = {written:.2f} = {formula}"
    return "K is written with its principal point in the middle of the picture"


# ---- words ---------------------------------------------------------------------------------------


def _fields(report: ConventionReport) -> dict[str, Any]:
    return {name: getattr(report, name) for name in report.__dataclass_fields__}


_UNITS = {
    1.0: "depth were in metres",
    0.001: "depth were in millimetres",
    0.01: "depth were in centimetres",
    0.0002: "depth were divided by 5000",
    0.0001: "depth were divided by 10000",
    0.00025: "depth were divided by 4000",
}


def _remedy(best: Hypothesis, current: Conventions) -> tuple[str, dict[str, str | float]]:
    """What would be true, in words, and the options that say so."""
    options: dict[str, str | float] = {}
    words: list[str] = []
    scale = float(current.depth_scale or 1.0)
    if "depth_kind" in best.changes:
        options["depth_kind"] = best.depth_kind
        words.append(
            {
                "z": "depth were along the camera's axis",
                "ray": "depth were along the ray",
                "disparity": "the depth files held disparity",
            }[best.depth_kind]
        )
    if best.depth_scale != scale:
        options["depth_scale"] = best.depth_scale
        if "depth_scale" in best.changes:
            unit = None if best.depth_kind == "disparity" else _UNITS.get(best.depth_scale)
            factor = best.depth_scale / scale
            kind = "disparity" if best.depth_kind == "disparity" else "depth"
            words.append(unit or f"{kind} were {factor:.4g} times as large")
    if "pose" in best.changes:
        options["pose"] = best.pose
        words.append(f"poses were {best.pose.replace('_', '-')}")
    if "axes" in best.changes:
        options["axes"] = best.axes
        words.append("camera axes were " + {"opencv": "OpenCV's", "opengl": "OpenGL's"}[best.axes])
    return " and ".join(words), options


def _text(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"


def _keywords(options: dict[str, str | float]) -> str:
    return ", ".join(
        f"{key}={value!r}" if isinstance(value, str) else f"{key}={_text(value)}"
        for key, value in options.items()
    )
