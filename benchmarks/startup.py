"""What a person waits for before anything happens (asv): whole processes."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from typing import ClassVar

from belvedere.studio._bench_startup import COMMANDS, FIRST_CALL, FIRST_CALLS


def run(arguments: list[str], **environment: str) -> None:
    subprocess.run(
        [sys.executable, *arguments],
        check=True,
        capture_output=True,
        env={**os.environ, **environment},
    )


class Process:
    """Processes that start, import or print help, and end."""

    params: ClassVar = [list(COMMANDS)]
    param_names: ClassVar = ["command"]
    number, repeat = 1, 5

    def time_process(self, name: str) -> None:
        run(COMMANDS[name][1])


class FirstCall:
    """Processes that warp once, with kernels kept on disk and with none."""

    params: ClassVar = [list(FIRST_CALLS)]
    param_names: ClassVar = ["reconstruction"]
    number, repeat, timeout = 1, 1, 600

    def setup(self, reconstruction: str) -> None:
        run(["-c", FIRST_CALL, reconstruction])

    def time_with_kernels_kept(self, reconstruction: str) -> None:
        run(["-c", FIRST_CALL, reconstruction])

    def time_with_kernels_compiled(self, reconstruction: str) -> None:
        with tempfile.TemporaryDirectory() as folder:
            run(["-c", FIRST_CALL, reconstruction], NUMBA_CACHE_DIR=folder)
