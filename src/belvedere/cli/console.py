"""Talking to people: results on the output stream, progress and notes on the error stream."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from belvedere.ground.progress import Progress


def say(text: str) -> None:
    """One line of result."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def note(text: str) -> None:
    """One line beside the result: a warning, a hint."""
    sys.stderr.write(text + "\n")
    sys.stderr.flush()


def say_json(data: dict[str, Any]) -> None:
    """A result for scripts."""
    say(json.dumps(data, indent=2, allow_nan=False))


def say_table(table: Any) -> None:
    """A rich table, as wide as the terminal."""
    from rich.console import Console

    Console(file=sys.stdout).print(table)


@contextmanager
def progress_bar(*, quiet: bool = False) -> Iterator[Progress]:
    """A bar with the time left on the error stream; where that is no terminal, a line a stage."""
    if quiet:
        yield lambda done, total, what: None
    elif sys.stderr.isatty():
        with _rich_bar() as tell:
            yield tell
    else:
        yield _plain_lines()


@contextmanager
def _rich_bar() -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.progress import Progress as RichProgress

    with RichProgress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    ) as bar:
        tasks: dict[str, Any] = {}

        def tell(done: int, total: int, what: str, /) -> None:
            if what not in tasks:
                tasks[what] = bar.add_task(what, total=total, completed=done)
            bar.update(tasks[what], completed=done, total=total)

        yield tell


def _plain_lines() -> Progress:
    began: dict[str, float] = {}

    def tell(done: int, total: int, what: str, /) -> None:
        if what not in began:
            began[what] = time.monotonic()
            if total > 1 and done < total:
                there = f"{done} of {total} are there, " if done else ""
                note(f"{what}: {there}{total - done} to do")
            elif done < total:
                note(f"{what} ...")
        elif done >= total > 1:
            note(f"{what}: done in {time.monotonic() - began[what]:.1f} s")

    return tell
