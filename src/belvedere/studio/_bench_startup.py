"""What a person waits for before anything happens: whole processes, timed from outside."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from belvedere.ground.errors import BelvedereError
from belvedere.ground.progress import Progress
from belvedere.studio._bench_rows import BenchRow

BASELINE = "python"

FIRST_CALL = """
import json, sys, time
from belvedere.studio._bench_scene import make_room
scene = make_room(64)
began = time.perf_counter()
from belvedere.warp import warp
warp(scene.views[0], scene.camera, reconstruction=sys.argv[1])
first = time.perf_counter()
warp(scene.views[0], scene.camera, reconstruction=sys.argv[1])
print(json.dumps([first - began, time.perf_counter() - first]))
"""
"""Prints the seconds of a process's first warp, Numba's import included, and of its second."""

FIRST_CALLS = ("point", "inverse")
"""Reconstructions whose first call is measured: the one with the least to compile and the
default."""


COMMANDS: dict[str, tuple[str, list[str]]] = {
    BASELINE: ("a process that does nothing", ["-c", "pass"]),
    "import numpy": ("what NumPy, on which we stand, takes", ["-c", "import numpy"]),
    "import belvedere": ("a process that imports the library", ["-c", "import belvedere"]),
    "belvedere --help": (
        "the command's own help",
        ["-c", "import sys; sys.argv[:] = ['belvedere', '--help']; "
               "from belvedere.cli import main; main()"],
    ),
}  # fmt: skip
"""Name -> what it is, and the arguments of the interpreter."""


def startup_rows(repeats: int, progress: Progress) -> list[BenchRow]:
    """Processes that start, import, print help and warp for the first time.

    Args:
        repeats: processes of each kind, whose median counts; kernels are compiled from nothing
            once for each of `FIRST_CALLS`, into a temporary folder.
        progress: told how far the run is.

    Raises:
        BelvedereError: a process failed; its last line is quoted.
    """
    taken: dict[str, list[float]] = {name: [] for name in COMMANDS}
    for turn in range(repeats + 1):  # the first fills the disk's cache and is not counted
        progress(turn, repeats + 1, "whole processes")
        for name, (_, arguments) in COMMANDS.items():
            began = time.perf_counter()
            _run(name, arguments, dict(os.environ))
            if turn > 0:
                taken[name].append(1000.0 * (time.perf_counter() - began))
    unit = float(np.median(taken[BASELINE]))
    rows = [_row(name, COMMANDS[name][0], values, unit) for name, values in taken.items()]
    for index, reconstruction in enumerate(FIRST_CALLS):
        progress(index, len(FIRST_CALLS), "first calls")
        rows += _first_calls(reconstruction, repeats, unit)
    progress(len(FIRST_CALLS), len(FIRST_CALLS), "first calls")
    return rows


def _first_calls(reconstruction: str, repeats: int, unit: float) -> list[BenchRow]:
    """Rows of a warp's first call: kernels compiled, kernels loaded from disk, second call."""
    name = f"warp {reconstruction}"
    with tempfile.TemporaryDirectory(prefix="belvedere-bench-") as folder:
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(Path(folder))}

        def seconds() -> tuple[float, float]:
            text = _run(name, ["-c", FIRST_CALL, reconstruction], environment)
            first, second = json.loads(text.splitlines()[-1])
            return first, second

        cold = seconds()[0]
        loaded = [seconds() for _ in range(repeats)]
    return [
        _row(f"{name}, cold kernels", "first call, kernels compiled", [1000.0 * cold], unit),
        _row(f"{name}, kept kernels", "first call, kernels loaded from disk",
             [1000.0 * first for first, _ in loaded], unit),
        _row(f"{name}, warm", "second call (64 x 64)",
             [1000.0 * second for _, second in loaded], unit),
    ]  # fmt: skip


def _run(name: str, arguments: list[str], environment: dict[str, str]) -> str:
    done = subprocess.run(
        [sys.executable, *arguments],
        capture_output=True, text=True, env=environment, check=False,
    )  # fmt: skip
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise BelvedereError(f"bench: the process {name!r} failed: {last}")
    return done.stdout


def _row(name: str, what: str, ms: list[float], unit: float) -> BenchRow:
    median = float(np.median(ms))
    return BenchRow(
        name=name,
        what=what,
        size=None,
        threads=None,
        ms_median=median,
        ms_min=min(ms),
        ms_p90=float(np.percentile(ms, 90)),
        ratio=median / unit,
    )
