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


def most_memory() -> str:
    """How much this process has held at most, "" where the system does not tell."""
    try:
        import resource
    except ImportError:  # Windows
        return ""
    held = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    held *= 1 if sys.platform == "darwin" else 1024
    return f"memory {held / 1e9:.1f} GB"


@contextmanager
def progress_bar(*, quiet: bool = False, memory: bool = False) -> Iterator[Progress]:
    """A bar with the time left on the error stream; where that is no terminal, a line a stage.

    ``memory`` adds the most that this process has held.
    """
    if quiet:
        yield lambda done, total, what: None
    elif sys.stderr.isatty():
        with _rich_bar(memory) as tell:
            yield tell
    else:
        yield _plain_lines(memory)


@contextmanager
def _rich_bar(memory: bool) -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        ProgressColumn,
        Task,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.progress import Progress as RichProgress
    from rich.text import Text

    class Memory(ProgressColumn):
        def render(self, task: Task) -> Text:
            return Text("" if task.finished else most_memory())

    with RichProgress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        *([Memory()] if memory else []),
        console=Console(stderr=True),
        transient=True,
    ) as bar:
        tasks: dict[str, Any] = {}

        def tell(done: int, total: int, what: str, /) -> None:
            if what not in tasks:
                tasks[what] = bar.add_task(what, total=total, completed=done)
            bar.update(tasks[what], completed=done, total=total)

        yield tell


def _plain_lines(memory: bool) -> Progress:
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
            held = most_memory() if memory else ""
            seconds = f"{time.monotonic() - began[what]:.1f} s"
            note(f"{what}: done in {seconds}" + (f", {held}" if held else ""))

    return tell
