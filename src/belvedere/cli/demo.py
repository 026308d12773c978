"""``belvedere demo``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from belvedere.cli.arguments import (
    ForceOption,
    JsonOption,
    SizeOption,
    ThreadsOption,
    look_option,
    output_option,
    parse_size,
)
from belvedere.cli.console import progress_bar, say, say_json, say_table
from belvedere.cli.evaluate import score_table


def demo(
    output: Annotated[Path, output_option("--output", "-o", help="Folder to make.")] = Path(
        "belvedere-demo"
    ),
    seconds: Annotated[float, look_option(min=0.1, help="Length of the video.")] = 10.0,
    size: SizeOption = "640x512",
    seed: Annotated[int, look_option(min=0, help="Another seed furnishes another house.")] = 0,
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
