"""The record of a preparation: which job the pieces in a work folder belong to.

Pieces are written whole or not at all, and each has a name of its own; so whatever an interrupted
call completed is found by its name, and the next call of the same job makes only the rest.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from belvedere.ground.errors import BelvedereError, OutputError
from belvedere.scene.io.atomic import (
    PARTIAL,
    check_replaceable,
    staging_path,
    swap_folder,
    sync_folder,
    writing,
)
from belvedere.scene.io.json_files import read_json, write_json

RECORD = "job.json"
"""Name of the record in the work folder."""
MANIFEST = "belvedere.json"
"""Marks a finished folder that we wrote, and may therefore replace."""
LOCK = "job.lock"
"""Held by the call that works in the folder."""


@dataclass(frozen=True, slots=True)
class PrepareJob:
    """A work folder and the job it belongs to."""

    folder: Path
    """Where the pieces are."""
    description: dict[str, Any]
    """Everything that the result depends on, JSON values."""

    @classmethod
    @contextlib.contextmanager
    def working_on(
        cls, target: Path, description: dict[str, Any], force: bool
    ) -> Iterator[PrepareJob]:
        """Make the work folder beside ``target``, or take up what an interrupted call left.

        When the block ends without an exception, the folder becomes ``target``; after any
        exception it stays, to be taken up again, if a piece is there.

        Raises:
            OutputError: ``target`` exists without ``force`` or is not ours; the work folder
                belongs to another job, or another process works in it; the disk is full.
        """
        check_replaceable(target, force, MANIFEST)
        folder = staging_path(target)
        plain = json.loads(json.dumps(description))
        with writing(target):
            if folder.exists():
                _take_up(folder, plain, target, force)
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except FileNotFoundError:  # as in /proc, where nothing can be made
                raise OutputError(f"{folder.parent}: no folder can be made there") from None
            with _locked(folder / LOCK, target):
                write_json(folder / RECORD, plain)
                try:
                    yield cls(folder, plain)
                except BaseException:
                    _drop_if_empty(folder)
                    raise
                _tidy(folder)
                sync_folder(folder)
                swap_folder(folder, target)
            sync_folder(target.parent)


def _take_up(folder: Path, description: dict[str, Any], target: Path, force: bool) -> None:
    """Keep the folder if it belongs to this job; start anew with ``force``; refuse otherwise."""
    earlier: dict[str, Any] | None = None
    with contextlib.suppress(BelvedereError):
        earlier = read_json(folder / RECORD).data
    if earlier == description:
        return
    if earlier is None or force:
        shutil.rmtree(folder)
        return
    keys = sorted({*earlier, *description})
    other = [key for key in keys if earlier.get(key) != description.get(key)]
    raise OutputError(
        f"{target}: an interrupted preparation with another {', '.join(other)} waits to be "
        "resumed: prepare with the same model and options, choose another name, or pass --force "
        "(force=True) to start anew"
    )


@contextlib.contextmanager
def _locked(path: Path, target: Path) -> Iterator[None]:
    """One call at a time; the system lets go of the lock when a process dies, however it dies."""
    with path.open("a+b") as file:
        if os.name == "posix":
            import fcntl

            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise OutputError(
                    f"{target}: another process is preparing it: wait for it, or choose another "
                    "name"
                ) from None
        yield


def _drop_if_empty(folder: Path) -> None:
    """Leave nothing behind where no piece was made: a model that was refused at once."""
    if {path.name for path in folder.iterdir()} <= {RECORD, LOCK}:
        shutil.rmtree(folder, ignore_errors=True)


def _tidy(folder: Path) -> None:
    """Remove the record, and what killed processes left half-written."""
    for leftover in sorted(folder.rglob(f"*{PARTIAL}*")):
        if leftover.is_dir():
            shutil.rmtree(leftover, ignore_errors=True)
        else:
            leftover.unlink(missing_ok=True)
    (folder / RECORD).unlink(missing_ok=True)
    (folder / LOCK).unlink(missing_ok=True)
