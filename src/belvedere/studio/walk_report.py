"""The page of a walk: times by mode, and the figures of the paper made anew.

At the frame where one reference leaves most holes: one reference (A), two (B), the polygons (C),
and the signed difference of B and C (D).

Source: Rafferty, Aliaga and Lastra 1998, figures A to D; spec portal-walkthrough 6.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from belvedere.ground.progress import Progress, silent
from belvedere.scene import Camera, Frame
from belvedere.scene.io.atomic import check_replaceable, staged_folder, write_bytes
from belvedere.scene.io.json_files import write_json
from belvedere.studio._chart import Line, legend
from belvedere.studio._page_frame import PageFrame, framed_page
from belvedere.studio._pictures import data_uri
from belvedere.studio._times_chart import times_chart
from belvedere.studio.difference import picture_with_holes, signed_difference
from belvedere.studio.machine import describe_machine
from belvedere.studio.walkthrough import WalkResult, walk
from belvedere.walkthrough import Mode, WalkOptions
from belvedere.walkthrough.walkthrough import Walkthrough

SCHEMA = "belvedere.walk"
SHOWN: tuple[Mode, ...] = ("culling", "one", "two")
"""Modes of the page."""
MOST_BYTES = 400_000
"""Of one picture of the page."""

__all__ = ["report_walk"]


@dataclass(slots=True)
class _Worst:
    """The frame with most holes that has been shown so far."""

    index: int = -1
    holes: float = -1.0

    def observe(self, index: int, frame: Frame, truth: Frame | None) -> None:
        del truth
        if frame.hole_fraction > self.holes:
            self.index, self.holes = index, frame.hole_fraction


def report_walk(
    scene: Walkthrough,
    cameras: Sequence[Camera],
    output: str | Path,
    options: WalkOptions | None = None,
    *,
    title: str = "A walk",
    force: bool = False,
    progress: Progress = silent,
) -> dict[str, WalkResult]:
    """Walk by every mode of `SHOWN` and write ``report.json`` and ``report.html``.

    Args:
        scene: the prepared building.
        cameras: one a frame.
        output: the folder to make.
        options: all but the mode.
        title: heading of the page.
        force: replace an existing report.
        progress: told after each frame.

    Returns:
        The results by mode.

    Raises:
        OutputError: the folder exists without ``force``, is not a report, or cannot be written.
    """
    target = Path(output).absolute()
    check_replaceable(target, force, "report.json")
    chosen = options or scene.options
    worst = _Worst()
    results: dict[str, WalkResult] = {}
    for mode in SHOWN:
        results[mode] = walk(
            scene, cameras, replace(chosen, mode=mode), compare=mode != "culling",
            observe=worst.observe if mode == "one" else None, progress=progress,
        )  # fmt: skip
    frames = {
        mode: scene.walker(replace(chosen, mode=mode)).frame(cameras[worst.index]) for mode in SHOWN
    }
    page = _page(title, results, frames, worst.index, scene)
    numbers = {
        "schema": SCHEMA, "version": 1, "title": title, "worst_frame": worst.index,
        "machine": describe_machine(scene.threads).as_dict(),
        "modes": {mode: result.as_dict() for mode, result in results.items()},
        "ms": {mode: [round(t, 3) for t in result.times.tolist()]
               for mode, result in results.items()},
    }  # fmt: skip
    with staged_folder(target, force=force, owned_by="report.json") as folder:
        write_bytes(folder / "report.html", page.encode())
        write_json(folder / "report.json", numbers)
    return results


def _page(
    title: str, results: dict[str, WalkResult], frames: dict[str, Frame], worst: int,
    scene: Walkthrough,
) -> str:  # fmt: skip
    machine = describe_machine(scene.threads)
    two = results["two"]
    times = {mode: result.times.tolist() for mode, result in results.items()}
    lines = [Line(mode, tuple(values), k) for k, (mode, values) in enumerate(times.items())]
    width, height = two.size
    frame = PageFrame(
        "walk", title, machine.as_dict()["packages"]["belvedere"],
        f"{len(two.frames)} frames of {width} × {height} through "
        f"{len(scene.graph.cells)} cells and {len(scene.graph.portals)} portals, three times: "
        "the polygons of all cells in sight, and pictures behind portals, one or two of them "
        "warped.",
        _figures(two),
    )  # fmt: skip
    parts = {
        "table": _table(results),
        "table_note": "Variation is the standard deviation of the frame times over their mean. "
        "PSNR and SSIM compare with culling on covered pixels; popping is the largest change "
        "of the error from one frame to the next, in 255ths.",
        "legend": legend(lines),
        "chart_wide": times_chart(times, 1120), "chart_narrow": times_chart(times, 360),
        "pictures_note": f"Frame {worst}, where one reference leaves most holes, marked in rose. "
        "Grey in the difference is no difference.",
        "pictures": _pictures(frames),
        "facts": "".join(f"<dt>{escape(k)}</dt><dd>{escape(str(v))}</dd>"
                      for k, v in _facts(scene, machine.as_dict()).items()),
    }  # fmt: skip
    return framed_page(frame, "walk", parts)


def _figures(two: WalkResult) -> list[tuple[str, str, str]]:
    other = two.compared
    assert other is not None
    holes = 100 * float(np.mean([frame.holes for frame in two.frames]))
    return [
        ("frames a second", f"{1e3 / two.median:.0f}", f"median {two.median:.1f} ms"),
        ("speed-up", f"{two.speedup_overall:.1f}×", f"{two.speedup_best:.1f}× at best"),
        ("PSNR", f"{other.psnr:.1f}", "dB"),
        ("holes", f"{holes:.2f}", "% of the pixels"),
    ]


def _table(results: dict[str, WalkResult]) -> str:
    heads = ("mode", "median ms", "99 % ms", "variation", "speed-up", "best", "holes %",
             "PSNR dB", "SSIM", "popping")  # fmt: skip
    rows = []
    for mode, result in results.items():
        other = result.compared
        holes = 100 * float(np.mean([frame.holes for frame in result.frames]))
        cells = [mode, f"{result.median:.2f}", f"{result.p99:.2f}", f"{result.variation:.2f}"]
        if other is None:
            cells += ["1", "1", "0", "", "", ""]
        else:
            cells += [
                f"{result.speedup_overall:.2f}", f"{result.speedup_best:.1f}", f"{holes:.3f}",
                f"{other.psnr:.2f}", f"{other.ssim:.4f}", f"{other.popping:.2f}",
            ]  # fmt: skip
        rows.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
    head = "".join(f"<th>{name}</th>" for name in heads)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"


def _pictures(frames: dict[str, Frame]) -> str:
    two, exact = frames["two"], frames["culling"]
    shown: list[tuple[str, Any]] = [
        ("A  one reference", picture_with_holes(frames["one"].color, frames["one"].coverage)),
        ("B  two references", picture_with_holes(two.color, two.coverage)),
        ("C  polygons", exact.color),
        ("D  signed difference of B and C", signed_difference(two.color, exact.color,
                                                             two.coverage > 0)),
    ]  # fmt: skip
    return "".join(
        f'<figure><img alt="{escape(caption)}" src="{data_uri(picture, MOST_BYTES)}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
        for caption, picture in shown
    )


def _facts(scene: Walkthrough, machine: dict[str, Any]) -> dict[str, Any]:
    origin = scene.facts.get("provenance", {})
    counts = scene.facts.get("counts", {})
    return {
        "Model": origin.get("model", "in memory"),
        "Polygons": f"{len(scene.model.mesh.faces):,}",
        "References": counts.get("references", len(scene.images)),
        "Processor": machine["cpu"],
        "Threads": machine["threads"],
    }
