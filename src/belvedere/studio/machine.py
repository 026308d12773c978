"""What a measurement was made on: every report and benchmark carries this."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from belvedere.ground.threads import thread_count

PACKAGES = ("belvedere", "numpy", "numba", "scipy", "pillow", "av")
"""Distributions whose versions are worth telling."""


@dataclass(frozen=True, slots=True)
class Machine:
    """A machine as far as speed depends on it. Names no host, user or path."""

    cpu: str
    """The processor's model as the system gives it."""
    cores: int
    """Logical processors of the machine."""
    threads: int
    """How many of them this process may use."""
    memory_gib: float | None
    """Main memory, GiB; None if the system does not tell."""
    system: str
    """Operating system and its release."""
    python: str
    """Implementation and version."""
    packages: dict[str, str]
    """Versions of `PACKAGES`; "none" if one is not installed."""

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)

    def summary(self) -> str:
        """One line: processor, processors used, memory, system, Python, NumPy and Numba."""
        memory = f"{self.memory_gib:g} GiB, " if self.memory_gib is not None else ""
        return (
            f"{self.cpu}, {self.threads} of {self.cores} processors, {memory}{self.system}, "
            f"{self.python}, NumPy {self.packages['numpy']}, Numba {self.packages['numba']}"
        )


def describe_machine(threads: int | None = None) -> Machine:
    """This machine, and the number of threads a job uses on it (all it may use if None)."""
    memory = _memory_bytes()
    return Machine(
        cpu=_cpu_model(),
        cores=os.cpu_count() or 1,
        threads=thread_count(threads),
        memory_gib=None if memory is None else round(memory / 2**30, 1),
        system=f"{platform.system()} {platform.release()}",
        python=f"{platform.python_implementation()} {platform.python_version()}",
        packages={name: _version(name) for name in PACKAGES},
    )


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "none"


def _cpu_model() -> str:
    """The processor's name; Linux, macOS and Windows each keep it elsewhere."""
    info = Path("/proc/cpuinfo")
    if info.is_file():
        for line in info.read_text(errors="replace").splitlines():
            if line.lower().startswith(("model name", "hardware")):
                return line.partition(":")[2].strip()
    if sys.platform == "darwin":
        try:
            answer = subprocess.run(
                ["sysctl", "-n", "machdep.cpu.brand_string"],
                capture_output=True, text=True, timeout=5, check=True,
            )  # fmt: skip
            return answer.stdout.strip()
        except (OSError, subprocess.SubprocessError):
            return platform.machine()
    return platform.processor() or platform.machine() or "unknown processor"


def _memory_bytes() -> int | None:
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return None
