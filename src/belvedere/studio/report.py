"""The report of an evaluation: ``report.json`` for programs, ``report.html`` for people.

The page is one file that needs nothing else, neither network nor server: pictures are embedded,
the chart is drawn by us, and it reads well on a phone, in the dark and without JavaScript.

``report.json``::

    {"schema": "belvedere.report", "version": 1, "title", "created" (UTC, ISO 8601), "command",
     "machine": {...}, "facts": {...}, "evaluation": {"options", "view_count", "size", "seconds",
     "summary": [a reconstruction each], "views": [a prediction each]}}

PSNR in dB on sRGB-encoded values, fractions 0 to 1, times in milliseconds. A number that could not
be measured is null; the PSNR of identical pictures is "Infinity".
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from belvedere.ground.progress import Progress, silent
from belvedere.scene.io.atomic import check_replaceable, staged_folder, write_bytes
from belvedere.scene.io.json_files import write_json
from belvedere.scene.views import ViewSet
from belvedere.studio._page import render_page
from belvedere.studio._pictures import PictureCollector
from belvedere.studio.evaluate import evaluate, plan_hold_out, reconstruction_names
from belvedere.studio.machine import Machine, describe_machine
from belvedere.studio.scores import Evaluation

SCHEMA = "belvedere.report"
VERSION = 1


@dataclass(frozen=True, slots=True, eq=False)
class Report:
    """Everything a report says."""

    title: str
    """What was evaluated, as its heading."""
    evaluation: Evaluation
    pictures: PictureCollector
    """What the evaluation observed."""
    machine: Machine
    created: str
    """UTC, ISO 8601."""
    command: str
    """The command line or Python that makes it again."""
    facts: Mapping[str, Any]
    """What else is worth telling about the views (format, depth scale ...), JSON values."""

    def as_dict(self) -> dict[str, Any]:
        """The content of report.json."""
        return {
            "schema": SCHEMA,
            "version": VERSION,
            "title": self.title,
            "created": self.created,
            "command": self.command,
            "machine": self.machine.as_dict(),
            "facts": dict(self.facts),
            "evaluation": self.evaluation.as_dict(),
        }


def evaluate_to_report(
    views: ViewSet,
    output: str | Path,
    *,
    title: str,
    command: str | Sequence[str] = "",
    hold_out: int | Sequence[int] = 4,
    references: int = 2,
    reconstructions: Sequence[str] | str = ("inverse",),
    visibility: str = "order",
    repeats: int = 3,
    threads: int | None = None,
    force: bool = False,
    progress: Progress = silent,
) -> Evaluation:
    """Evaluate a set of views and write the report folder.

    Args:
        views: the set; see `belvedere.studio.evaluate.evaluate` for it and the options.
        output: folder to make, with ``report.json`` and ``report.html``.
        title: heading of the page, usually the scene's name.
        command: what makes it again: a line, or the words of one (quoted as a shell needs it).
        hold_out: every n-th view, or the held-out views' indices.
        references: how many of the best references predict a view.
        reconstructions: names, or "all".
        visibility: "order" or "zbuffer".
        repeats: timed renders of each view.
        threads: for the warp.
        force: replace an existing report.
        progress: told after each prediction.

    Returns:
        The evaluation the report was made from.

    Raises:
        OutputError: the folder exists without ``force``, is not a report, or cannot be written;
            found before the long work begins where that is possible.
        InputError, SceneError: as `evaluate`.

    Memory: that of `evaluate`, and some 15 MB for the page.
    """
    names = reconstruction_names(reconstructions)
    target = Path(output).absolute()
    check_replaceable(target, force, "report.json")
    held = [views.names[index] for index, _ in plan_hold_out(views, hold_out, references)]
    pictures = PictureCollector(held, len(names))
    evaluation = evaluate(
        views,
        hold_out=hold_out,
        references=references,
        reconstructions=names,
        visibility=visibility,
        repeats=repeats,
        threads=threads,
        observe=pictures,
        progress=progress,
    )
    report = Report(
        title=title,
        evaluation=evaluation,
        pictures=pictures,
        machine=describe_machine(threads),
        created=datetime.now(UTC).isoformat(timespec="seconds"),
        command=command if isinstance(command, str) else shlex.join(command),
        facts=views.facts,
    )
    write_report(report, target, force=force)
    return evaluation


def write_report(report: Report, output: str | Path, *, force: bool = False) -> Path:
    """Write ``report.json`` and ``report.html`` into a new folder, both or neither.

    Returns:
        The page.

    Raises:
        OutputError: the folder exists without ``force``, is not a report, or cannot be written.
    """
    target = Path(output).absolute()
    with staged_folder(target, force=force, owned_by="report.json") as folder:
        write_bytes(folder / "report.html", render_page(report.as_dict(), report.pictures).encode())
        write_json(folder / "report.json", report.as_dict())
    return target / "report.html"
