"""``belvedere walk``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from belvedere.cli.arguments import (
    ForceOption,
    JsonOption,
    Reconstruction,
    ReconstructionOption,
    SizeOption,
    ThreadsOption,
    look_option,
    output_option,
    parse_size,
)
from belvedere.cli.console import progress_bar, say, say_json


class Mode(StrEnum):
    """What stands behind portals."""

    FULL = "full"
    CULLING = "culling"
    TEXTURES = "textures"
    ONE = "one"
    TWO = "two"


class Cells(StrEnum):
    """How cells with pictures from inside are shown."""

    PICTURES = "pictures"
    POLYGONS = "polygons"


class Fill(StrEnum):
    """What becomes of holes."""

    NONE = "none"
    BACKGROUND = "background"
    TRACE = "trace"


class Merge(StrEnum):
    """How two references become one picture."""

    OVER = "over"
    DISPARITY = "disparity"


def walk(
    scene: Annotated[
        Path, typer.Argument(metavar="SCENE", help="A folder that belvedere prepare made.")
    ],
    path: Annotated[
        str,
        look_option(
            "--path",
            "-p",
            help="recorded: the walk that was prepared. random: a stroll with collision. Or a "
            "path file (JSON).",
        ),
    ] = "recorded",
    mode: Annotated[
        Mode,
        look_option(
            "--mode",
            "-m",
            help="two, one: nearest pictures of each portal, warped. textures: painted flat on "
            "it. culling: polygons of the cells in sight. full: all polygons.",
        ),
    ] = Mode.TWO,
    frames: Annotated[int, look_option(min=1, max=1_000_000, help="How many.")] = 520,
    size: SizeOption = "640x512",
    merge: Annotated[
        Merge,
        look_option(
            help="Mode two: the nearer surface wins, or the nearest picture always goes over the "
            "other."
        ),
    ] = Merge.DISPARITY,
    reconstruction: ReconstructionOption = Reconstruction.INVERSE,
    fill: Annotated[
        Fill,
        look_option(
            help="Holes, which no picture saw: trace casts a ray for each, background continues "
            "what is around, none leaves them black."
        ),
    ] = Fill.TRACE,
    cells: Annotated[
        Cells,
        look_option(
            help="Cells with pictures from inside (see prepare --inside) are shown by these, or "
            "drawn all the same."
        ),
    ] = Cells.PICTURES,
    persist: Annotated[
        bool,
        look_option("--persist", help="Show in holes what was seen there in earlier frames."),
    ] = False,
    seed: Annotated[int, look_option(min=0, help="Of --path random.")] = 0,
    compare: Annotated[
        bool,
        output_option(
            "--compare",
            help="Show every frame by culling too: ratios of times, PSNR, SSIM, popping.",
        ),
    ] = False,
    output: Annotated[
        Path | None,
        output_option(
            "--output", "-o", help="A video, NAME.mp4; without it, frames are only measured."
        ),
    ] = None,
    report: Annotated[
        Path | None,
        output_option(
            help="Folder for a page with frame times by mode and the figures of the paper: one "
            "reference, two, geometry, difference."
        ),
    ] = None,
    threads: ThreadsOption = None,
    force: ForceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Walk through a prepared building and measure every frame.

    Examples: belvedere walk house -o walk.mp4;
    belvedere walk house --mode two --compare --json;
    belvedere walk house --path random --frames 300 --report report
    """  # fmt: skip
    from belvedere.studio.walk_report import report_walk
    from belvedere.studio.walkthrough import cameras_of, walk
    from belvedere.walkthrough import WalkOptions, Walkthrough

    opened = Walkthrough.open(scene, threads=threads)
    options = WalkOptions(
        mode=mode.value, merge=merge.value, reconstruction=reconstruction.value, persist=persist,
        fill=fill.value, cells=cells.value,
    )  # fmt: skip
    cameras = cameras_of(opened, path, frames, parse_size(size), seed)
    with progress_bar(quiet=as_json) as tell:
        result = walk(
            opened, cameras, options, compare=compare, video=output, force=force, progress=tell
        )
        if report is not None:
            report_walk(opened, cameras, report, options, title=scene.resolve().name, force=force,
                        progress=tell)  # fmt: skip
    if as_json:
        say_json(result.as_dict())
        return
    for line in result.lines():
        say(line)
    for made in (output, None if report is None else report / "report.html"):
        if made is not None:
            say(f"look at {made}")
