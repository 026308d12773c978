"""``belvedere bench``."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from belvedere.cli.arguments import JsonOption
from belvedere.cli.console import progress_bar, say, say_json, say_table


class Suite(StrEnum):
    """What is timed."""

    WARP = "warp"
    STARTUP = "startup"


def bench(
    suite: Annotated[Suite, typer.Argument(help="What to time.")] = Suite.WARP,
    size: Annotated[int, typer.Option(min=16, max=8192, help="Pixels a side.")] = 512,
    repeats: Annotated[int, typer.Option(min=1, help="Warm runs of each.")] = 30,
    peers: Annotated[
        bool, typer.Option(help="Time other libraries in the same run, where installed.")
    ] = True,
    as_json: JsonOption = False,
) -> None:
    """Time the engine on this machine, against other libraries in the same run.

    Medians of warm runs in one process; ratios are to a named baseline of the same run.
    """
    from belvedere.studio.bench import bench as measure

    with progress_bar(quiet=as_json) as tell:
        result = measure(suite.value, size=size, repeats=repeats, peers=peers, progress=tell)
    if as_json:
        say_json(result.as_dict())
        return
    say_table(result.table())
    say(result.machine.summary())
