"""How long jobs tell how far they are, without knowing who listens."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Called as ``progress(done, total, what)`` from the thread that started the job.

    ``done`` counts from 0 to ``total``; a new ``what`` begins a new stage, whose ``total`` may
    differ. An exception raised inside ends the job as Ctrl-C would: nothing half-written stays.
    """

    def __call__(self, done: int, total: int, what: str, /) -> None:
        """Tell that ``done`` of ``total`` steps of the stage ``what`` are behind us."""
        ...


def silent(done: int, total: int, what: str, /) -> None:
    """The listener nobody listens to."""
    del done, total, what
