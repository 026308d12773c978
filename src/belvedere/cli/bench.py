"""``belvedere bench``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from belvedere.cli.arguments import ForceOption, JsonOption, option_under, output_option
from belvedere.cli.console import progress_bar, say, say_json, say_table
from belvedere.ground.errors import InputError


class Suite(StrEnum):
    """What is measured."""

    SPEED = "speed"
    WARP = "warp"
    STARTUP = "startup"
    DRAWING = "drawing"


warp_option = option_under("Suite warp")


def bench(
    suite: Annotated[
        Suite,
        typer.Argument(
            help="speed: every reconstructor in every use. warp: the picture beside the time, "
            "against the truth. startup: whole processes. drawing: polygons of two houses."
        ),
    ] = Suite.SPEED,
    size: Annotated[int, typer.Option(min=16, max=8192, help="Pixels a side.")] = 512,
    repeats: Annotated[
        int | None,
        typer.Option(min=1, help="Warm runs of each; by default 30, of suite warp 12."),
    ] = None,
    peers: Annotated[
        bool, typer.Option(help="Measure other libraries in the same run, where installed.")
    ] = True,
    refs: Annotated[
        str,
        warp_option(metavar="N,N,...", help="References that each picture is made from, 1 to 5."),
    ] = "2",
    held_out: Annotated[
        bool,
        warp_option(
            "--held-out", help="Judge at other stations, in a house that nothing was tuned on."
        ),
    ] = False,
    scene: Annotated[
        Path | None,
        warp_option(
            help="Judge on posed pictures with depth: each is held out and predicted from its "
            "best neighbours."
        ),
    ] = None,
    output: Annotated[
        Path | None,
        output_option(
            "--output",
            "-o",
            help="Suite warp: folder for every picture, its difference from the truth (grey: "
            "none) and its coverage.",
        ),
    ] = None,
    force: ForceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Measure the engine on this machine, beside other libraries in the same run.

    Medians of warm runs in one process; ratios are to a named baseline of the same run. Suite warp
    shows the built-in house from where nobody stood and compares with what is truly there, or
    predicts the held-out views of a scene.

    Examples: belvedere bench; belvedere bench warp --refs 1,2,5 -o pictures; belvedere bench warp
    --scene capture/
    """
    from belvedere.studio.bench import bench as measure

    numbers = parse_numbers(refs)
    with progress_bar(quiet=as_json) as tell:
        result = measure(
            suite.value, size=size, repeats=repeats, peers=peers, progress=tell,
            references=numbers, held_out=held_out, scene=scene, output=output, force=force,
        )  # fmt: skip
    if as_json:
        say_json(result.as_dict() | ({} if output is None else {"output": str(output)}))
        return
    say_table(result.table())
    say(result.machine.summary())
    if output is not None:
        say(f"{output}: the pictures, and bench.json")


def parse_numbers(text: str) -> tuple[int, ...]:
    """The whole numbers of ``1,2,5``.

    Raises:
        InputError: another form.
    """
    words = [word.strip() for word in text.split(",")]
    if not all(word.isdecimal() for word in words):
        raise InputError(f"--refs is {text!r}, expected numbers of references such as 1,2,5")
    return tuple(int(word) for word in words)
