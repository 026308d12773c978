"""The page of a walk: times by mode, and the figures of the paper made anew.

At the frame where one reference leaves most holes: one reference (A), two (B), the polygons (C),
and the signed difference of B and C (D).

Source: Rafferty, Aliaga and Lastra 1998, figures A to D; spec portal-walkthrough 6.2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import color_to_srgb8
from belvedere.ground.progress import Progress, silent
from belvedere.scene import Camera
from belvedere.scene.io.atomic import check_replaceable, staged_folder, write_bytes
from belvedere.scene.io.json_files import write_json
from belvedere.scene.view import Color
from belvedere.studio._chart import Line, legend
from belvedere.studio._page_frame import PageFrame, framed_page
from belvedere.studio._pictures import data_uri
from belvedere.studio._times_chart import times_chart
from belvedere.studio.difference import picture_with_holes, signed_difference
from belvedere.studio.machine import describe_machine
from belvedere.studio.metrics import Mask
from belvedere.studio.walkthrough import WalkResult, walk
from belvedere.walkthrough import Mode, WalkOptions
from belvedere.walkthrough.walkthrough import Walkthrough

U1 = npt.NDArray[np.uint8]

SCHEMA = "belvedere.walk"
SHOWN: tuple[Mode, ...] = ("culling", "one", "two")
"""Modes of the page."""
MOST_BYTES = 400_000
"""Of one picture of the page."""
LEAD_IN = 12
"""Frames made before one that is shown."""

__all__ = ["paper_figures", "report_walk"]


def report_walk(
    scene: Walkthrough,
    cameras: Sequence[Camera],
    output: str | Path,
    options: WalkOptions | None = None,
    *,
    title: str = "A walk",
    force: bool = False,
    progress: Progress = silent,
) -> dict[Mode, WalkResult]:
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
    results: dict[Mode, WalkResult] = {
        mode: walk(
            scene, cameras, replace(chosen, mode=mode), compare=mode != "culling",
            progress=progress,
        )
        for mode in SHOWN
    }  # fmt: skip
    compared = results["one"].compared
    assert compared is not None
    worst = compared.worst
    page = _page(title, results, paper_figures(scene, cameras, worst, chosen), worst, scene)
    numbers = {
        "schema": SCHEMA, "version": 1, "title": title, "worst_frame": worst,
        "machine": describe_machine(scene.threads).as_dict(),
        "modes": {mode: result.as_dict() for mode, result in results.items()},
        "ms": {mode: [round(t, 3) for t in result.times.tolist()]
               for mode, result in results.items()},
    }  # fmt: skip
    with staged_folder(target, force=force, owned_by="report.json") as folder:
        write_bytes(folder / "report.html", page.encode())
        write_json(folder / "report.json", numbers)
    return results


def paper_figures(
    scene: Walkthrough, cameras: Sequence[Camera], index: int, options: WalkOptions | None = None
) -> dict[str, U1]:
    """The four figures of the paper, from one frame of a walk.

    Args:
        scene: the prepared building.
        cameras: of the walk.
        index: the frame to show; a few before it are made too, since what is a picture and what
            polygons depends on where one comes from.
        options: all but the mode.

    Returns:
        (H, W, 3) pictures by caption. What no reference saw is rose, in D no difference is grey.
    """
    shown: dict[Mode, tuple[Color, Mask]] = {}
    for mode in SHOWN:
        walker = scene.walker(replace(options or scene.options, mode=mode))
        for camera in cameras[max(index - LEAD_IN, 0) : index]:
            walker.frame(camera)
        shown[mode] = walker.frame(cameras[index]).color, ~walker.holes
    (one, seen), (two, known), (exact, _) = (shown[mode] for mode in ("one", "two", "culling"))
    return {
        "A  one reference": picture_with_holes(one, seen.astype(np.float32)),
        "B  two references": picture_with_holes(two, known.astype(np.float32)),
        "C  polygons": color_to_srgb8(exact),
        "D  signed difference of B and C": signed_difference(two, exact, known),
    }


def _page(
    title: str, results: Mapping[Mode, WalkResult], figures: Mapping[str, U1], worst: int,
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
        "pictures": _pictures(figures),
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


def _table(results: Mapping[Mode, WalkResult]) -> str:
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


def _pictures(figures: Mapping[str, U1]) -> str:
    return "".join(
        f'<figure><img alt="{escape(caption)}" src="{data_uri(picture, MOST_BYTES)}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
        for caption, picture in figures.items()
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
