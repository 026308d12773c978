"""``belvedere evaluate``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from belvedere.cli.arguments import (
    AxesOption,
    DepthKindOption,
    DepthScaleOption,
    ForceOption,
    FormatOption,
    JsonOption,
    PixelCentersOption,
    PoseOption,
    ReferencesOption,
    SceneArgument,
    ThreadsOption,
    Visibility,
    VisibilityOption,
    look_option,
    output_option,
    stated,
)
from belvedere.cli.console import progress_bar, say, say_json, say_table
from belvedere.ground.wording import counted

if TYPE_CHECKING:
    from rich.table import Table

    from belvedere.studio.scores import Evaluation


def evaluate(
    scene: SceneArgument,
    output: Annotated[
        Path | None,
        output_option(
            "--output", "-o", help="Folder of the report. By default the scene's name and -report."
        ),
    ] = None,
    hold_out: Annotated[int, look_option(min=1, help="Hold out every n-th view.")] = 4,
    reconstruction: Annotated[
        str,
        look_option(
            "--reconstruction",
            "-r",
            help="point, splat, gaussian, mesh, offset, inverse, several with commas, or all.",
        ),
    ] = "all",
    visibility: VisibilityOption = Visibility.ORDER,
    references: ReferencesOption = 2,
    repeats: Annotated[int, look_option(min=1, max=100, help="Timed renders of each view.")] = 3,
    threads: ThreadsOption = None,
    force: ForceOption = False,
    as_json: JsonOption = False,
    layout: FormatOption = None,
    depth_scale: DepthScaleOption = None,
    depth_kind: DepthKindOption = None,
    pose: PoseOption = None,
    axes: AxesOption = None,
    pixel_centers: PixelCentersOption = None,
) -> None:
    """Hold views out, predict each from the others, and report how far off the pictures are.

    Writes report.html (one page with every picture: truth, prediction, signed difference,
    coverage) and report.json, and prints the table.

    Example: belvedere evaluate capture/ -o report
    """
    from belvedere.studio.evaluate import reconstruction_names
    from belvedere.studio.report import evaluate_to_report
    from belvedere.studio.scenes import read_capture

    names = reconstruction_names(reconstruction.split(","))
    asked = stated(depth_scale, depth_kind, pose, axes, pixel_centers)
    views = read_capture(scene, asked, layout)
    name = scene.resolve().name
    target = output or Path(f"{name}-report")
    with progress_bar(quiet=as_json) as tell:
        result = evaluate_to_report(
            views, target, title=name, command=["belvedere", *sys.argv[1:]], hold_out=hold_out,
            references=references, reconstructions=names, visibility=visibility.value,
            repeats=repeats, threads=threads, force=force, progress=tell,
        )  # fmt: skip
    if as_json:
        say_json(result.as_dict() | {"output": str(target)})
        return
    say_table(score_table(result))
    say(f"{target / 'report.html'}: {counted(len(result.held_out), 'view')} predicted")


def score_table(result: Evaluation) -> Table:
    """The table that `evaluate` and `demo` print."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("")
    for heading in ("PSNR dB\ncovered", "\ncommon", "\nwhole", "SSIM\ncovered", "\nwhole",
                    "holes\n%", "ms\na view"):  # fmt: skip
        table.add_column(heading, justify="right")
    for row in result.summaries:
        table.add_row(
            row.reconstruction,
            f"{row.psnr_covered:.2f}",
            f"{row.psnr_common:.2f}",
            f"{row.psnr_whole:.2f}",
            f"{row.ssim_covered:.4f}",
            f"{row.ssim_whole:.4f}",
            f"{100 * row.hole_fraction:.1f}",
            f"{row.ms:.1f}",
        )
    return table
