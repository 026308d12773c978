"""Each case is a process of its own: Numba settles its settings when it is first imported."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

KERNELS = """
from belvedere.ground.jit import inner, kernel

@inner
def doubled(value):
    return value + value

@kernel
def quadrupled(value):
    return doubled(doubled(value))

@inner
def times(value, factor):
    return value * factor

@kernel
def sextupled(value):
    return times(times(value, 2), 3)

@kernel
def total(values, out_total):
    for i in range(values.shape[0]):
        out_total[0] += values[i]

@kernel
def overrun(values, out_total):
    out_total[0] = values[values.shape[0]]

@kernel
def reciprocal(value):
    return 1.0 / value
"""

SCRIPT = """
import importlib.util, sys
import numpy as np
import belvedere.ground.jit as jit

jit.NOTICE_AFTER_S = {after}
spec = importlib.util.spec_from_file_location({name!r}, {file!r})
kernels = sys.modules[{name!r}] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(kernels)
out = np.zeros(1)
kernels.total(np.arange(5.0), out)
kernels.total(np.arange(5), out)
print(out[0], kernels.reciprocal(0.0) if {divide} else "")
"""


def run(folder: Path, *, after: float, name: str = "belvedere.fake", script: str = SCRIPT,
        divide: bool = True, **environment: str) -> subprocess.CompletedProcess[str]:  # fmt: skip
    file = folder / "fake.py"
    if not file.exists():
        file.write_text(KERNELS)
    return subprocess.run(
        [sys.executable, "-c", script.format(after=after, name=name, file=str(file),
                                             divide=divide)],
        env={**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache"), **environment},
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip


def test_compiling_is_told_once_and_cached_kernels_say_nothing(tmp_path: Path) -> None:
    first = run(tmp_path, after=0.0)
    assert first.returncode == 0, first.stderr
    assert first.stdout.split() == ["20.0", "inf"]  # NumPy's rule: 1/0 is no exception
    assert first.stderr == "belvedere: compiling kernels (first run only) ...\n"
    second = run(tmp_path, after=0.0)
    assert second.stdout == first.stdout
    assert second.stderr == ""


def test_a_short_wait_is_not_told(tmp_path: Path) -> None:
    assert run(tmp_path, after=1000.0).stderr == ""


def test_other_peoples_kernels_are_not_told(tmp_path: Path) -> None:
    assert run(tmp_path, after=0.0, name="somebody_else").stderr == ""


@pytest.mark.parametrize("disabled", ["0", "1"])
def test_a_step_of_a_kernel_can_be_called_from_python(tmp_path: Path, disabled: str) -> None:
    """Also when a kernel was compiled with it before: what it lacks would end the process."""
    calls = "kernels.quadrupled(1.5), kernels.doubled(2.5), kernels.doubled(7), kernels.doubled(4)"
    for _ in range(2):  # compiled, and from the cache
        script = SCRIPT + f"print({calls})\n"
        done = run(tmp_path, after=1000.0, script=script, NUMBA_DISABLE_JIT=disabled, divide=False)
        assert done.returncode == 0, done.stderr
        assert done.stdout.splitlines()[1] == "6.0 5.0 14 8"


def test_a_step_is_compiled_once_whatever_constants_it_is_called_with(tmp_path: Path) -> None:
    script = SCRIPT + "print(kernels.sextupled(1.5), len(kernels.times.overloads))\n"
    done = run(tmp_path, after=1000.0, script=script)
    assert done.stdout.splitlines()[1] == "9.0 1", done.stderr


def test_without_compilation_overruns_raise(tmp_path: Path) -> None:
    done = run(
        tmp_path,
        after=0.0,
        divide=False,
        script=SCRIPT + "kernels.overrun(np.arange(5.0), out)\n",
        NUMBA_DISABLE_JIT="1",
    )
    assert done.stdout.split() == ["20.0"]
    assert "IndexError" in done.stderr
    assert "compiling" not in done.stderr


@pytest.mark.parametrize("module", ["belvedere", "belvedere.scene", "belvedere.ground"])
def test_importing_costs_no_numba(module: str) -> None:
    heavy = "('numba', 'scipy', 'PIL', 'imageio', 'av', 'trimesh', 'rich', 'OpenEXR', 'torch')"
    code = f"import sys, {module}; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.strip() == "[]"
