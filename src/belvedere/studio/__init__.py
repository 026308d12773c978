"""Judging scenes and showing them: checks of conventions, evaluation, reports, walks, the demo.

Views are held out and predicted, predictions are measured (PSNR; SSIM of Wang et al. 2004) and
shown beside the truth, paths are walked into videos. Only the `Scene` protocol, sets of views and
the warp are known here, never the kind of a scene. Names load when first used; the functions
`evaluate` and `demo` are called as their modules are, so they are imported from those
(``from belvedere.studio.evaluate import evaluate``).
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from belvedere.studio.demo import DemoResult
    from belvedere.studio.difference import (
        coverage_picture,
        disparity_picture,
        picture_with_holes,
        signed_difference,
    )
    from belvedere.studio.evaluate import plan_hold_out
    from belvedere.studio.explained import (
        add_legend,
        error_picture,
        explained_pictures,
        hole_picture,
        source_picture,
    )
    from belvedere.studio.machine import Machine, describe_machine
    from belvedere.studio.metrics import psnr, ssim
    from belvedere.studio.report import Report, evaluate_to_report, write_report
    from belvedere.studio.scores import Evaluation, Summary, ViewScore
    from belvedere.studio.walk import RenderResult, render_path

_HOME = {
    "DemoResult": "demo",
    "coverage_picture": "difference", "disparity_picture": "difference",
    "picture_with_holes": "difference", "signed_difference": "difference",
    "plan_hold_out": "evaluate",
    "add_legend": "explained", "error_picture": "explained", "explained_pictures": "explained",
    "hole_picture": "explained", "source_picture": "explained",
    "Machine": "machine", "describe_machine": "machine",
    "psnr": "metrics", "ssim": "metrics",
    "Report": "report", "evaluate_to_report": "report", "write_report": "report",
    "Evaluation": "scores", "Summary": "scores", "ViewScore": "scores",
    "RenderResult": "walk", "render_path": "walk",
}  # fmt: skip
"""Public name -> its file."""


def __getattr__(name: str) -> Any:
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{home}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})


__all__ = [
    "DemoResult",
    "Evaluation",
    "Machine",
    "RenderResult",
    "Report",
    "Summary",
    "ViewScore",
    "add_legend",
    "coverage_picture",
    "describe_machine",
    "disparity_picture",
    "error_picture",
    "evaluate_to_report",
    "explained_pictures",
    "hole_picture",
    "picture_with_holes",
    "plan_hold_out",
    "psnr",
    "render_path",
    "signed_difference",
    "source_picture",
    "ssim",
    "write_report",
]
