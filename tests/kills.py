"""Preparations killed at random moments: ``python -m tests.kills built-in:bungalow --kills 5``.

One preparation runs undisturbed. Another is killed, by the signal that no process can catch, and
repeated, until it has been killed often enough and is let finish: both folders must hold the same
bytes, and nothing may be left beside them. One that is done before its moment has come is compared
as well, and begun anew. Options that are not named here go to ``belvedere prepare``.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

POLL_S = 0.005
"""Between looks whether the moment has come."""


class PreparationError(RuntimeError):
    """A preparation that nobody killed has failed."""


def preparation(model: str, output: Path, options: Sequence[str] = ()) -> list[str]:
    """The words of ``belvedere prepare``."""
    return [sys.executable, "-m", "belvedere", "prepare", model, "-o", str(output), *options]


@contextlib.contextmanager
def running(
    command: Sequence[str], stderr: int = subprocess.DEVNULL
) -> Iterator[subprocess.Popen[str]]:
    """A process that is gone, with all it started, when the block ends, however it ends."""
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=stderr, text=True, start_new_session=True
    ) as process:
        try:
            yield process
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)


def finishes(command: Sequence[str], moment: Callable[[], bool] | None = None) -> bool:
    """Whether a preparation ends by itself, before ``moment`` says that it is to be killed.

    Raises:
        PreparationError: it failed.
    """
    with running(command, subprocess.PIPE) as process:
        while moment is not None and process.poll() is None:
            if moment():
                return False
            time.sleep(POLL_S)
        _, told = process.communicate()
    if process.returncode:
        raise PreparationError(f"{' '.join(command)}: {told.strip()[-2000:]}")
    return True


def files(folder: Path) -> set[Path]:
    """All files below a folder, by their names in it."""
    return {path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}


def differences(one: Path, other: Path) -> list[str]:
    """Names of files that one of two folders lacks, or holds with other bytes."""
    here, there = files(one), files(other)
    both = {
        name for name in here & there if (one / name).read_bytes() == (other / name).read_bytes()
    }
    return sorted(map(str, (here | there) - both))


def later(seconds: float) -> Callable[[], bool]:
    """The moment when so many seconds have passed."""
    end = time.perf_counter() + seconds
    return lambda: time.perf_counter() >= end


def once_there(folder: Path, count: int) -> Callable[[], bool]:
    """The moment when so many files are there."""

    def reached() -> bool:
        with contextlib.suppress(FileNotFoundError):  # one folder became another while we counted
            return len(files(folder)) >= count
        return False

    return reached


def kill_and_compare(
    model: str, folder: Path, kills: int, seed: int, options: Sequence[str] = ()
) -> list[str]:
    """What differs between preparations that were killed and one that was not; tells each step.

    Every other moment is drawn from the seconds, every other from the files, most of which are
    written within few of the seconds.

    Args:
        model: see ``belvedere prepare``.
        folder: an empty one, for the scenes.
        kills: how many.
        seed: of the moments.
        options: of all preparations.

    Raises:
        PreparationError: one failed that was not killed.
    """
    calm, work = folder / "calm", folder / "work"
    torn = work / "torn"
    work.mkdir()
    began = time.perf_counter()
    finishes(preparation(model, calm, options))
    whole, total = time.perf_counter() - began, len(files(calm))
    print(f"prepared in {whole:.1f} s, {total} files", flush=True)
    rng, left, wrong = np.random.default_rng(seed), kills, list[str]()
    while True:
        there = len(files(work))
        seconds, count = rng.uniform(0.0, whole), rng.integers(there, max(total, there + 1)) + 1
        moment = once_there(work, int(count)) if left % 2 else later(seconds)
        began = time.perf_counter()
        if not finishes(preparation(model, torn, options), moment if left else None):
            left -= 1
            spent, there = time.perf_counter() - began, len(files(work))
            print(f"killed after {spent:.1f} s, {there} files there", flush=True)
            continue
        other = differences(calm, torn) + [p.name for p in work.iterdir() if p != torn]
        print(f"done: {', '.join(other) + ' differ' if other else 'the same bytes'}", flush=True)
        wrong += other
        if not left:
            return wrong
        shutil.rmtree(torn)


def main() -> int:
    """Kill, resume, compare; gives 1 if any byte differs."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("model", nargs="?", default="built-in:bungalow", metavar="MODEL")
    parser.add_argument("--kills", type=int, default=5)
    parser.add_argument("--seed", type=int, default=0, help="of the moments")
    told, options = parser.parse_known_args()
    with tempfile.TemporaryDirectory() as folder:
        wrong = kill_and_compare(told.model, Path(folder), told.kills, told.seed, options)
    print(f"{told.model}: {told.kills} kills, {len(wrong)} files differ")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
