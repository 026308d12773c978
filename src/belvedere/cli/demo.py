"""``belvedere demo``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from belvedere.cli.arguments import LOOK, OUTPUT, ForceOption, JsonOption, ThreadsOption, parse_size
from belvedere.cli.console import progress_bar, say, say_json, say_table
from belvedere.cli.evaluate import score_table


def demo(
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder to make.", rich_help_panel=OUTPUT)
    ] = Path("belvedere-demo"),
    seconds: Annotated[
        float, typer.Option(min=0.1, help="Length of the video.", rich_help_panel=LOOK)
    ] = 10.0,
    size: Annotated[
        str, typer.Option(metavar="WIDTHxHEIGHT", help="Size of the video.", rich_help_panel=LOOK)
    ] = "640x512",
    seed: Annotated[
        int, typer.Option(min=0, help="Another seed furnishes another house.", rich_help_panel=LOOK)
    ] = 0,
    threads: ThreadsOption = None,
    force: ForceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Build a small furnished house, photograph it, and walk through the photographs.

    Makes a folder with a video, a report of how true its pictures are, the scene itself for you to
    try the other commands on, and a note on what to do next. Needs no network, GPU or display.
    """
    from belvedere.studio.demo import demo as build

    wanted = parse_size(size) or (640, 512)
    with progress_bar(quiet=as_json) as tell:
        result = build(
            output, seed=seed, seconds=seconds, size=wanted, threads=threads, force=force,
            progress=tell,
        )  # fmt: skip
    if as_json:
        say_json(result.as_dict())
        return
    say_table(score_table(result.evaluation))
    say(f"{output}: {result.summary}")
    say(f"look at {output / 'walk.mp4'}, {output / 'report' / 'report.html'} "
        f"and {output / 'README.txt'}")  # fmt: skip
