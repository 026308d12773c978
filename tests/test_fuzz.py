"""Anything goes: tiny pictures, strange cameras, every option; more of them by ``tests.fuzz``."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from belvedere.warp import RECONSTRUCTIONS
from tests import fuzz

FOLDER = Path(__file__).resolve().parents[1]


def run_apart(*arguments: str, **environment: str) -> str:
    """The last line of ``python -m tests.fuzz`` in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.fuzz", *arguments],
        cwd=FOLDER, env={**os.environ, **environment}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    return done.stdout.strip().splitlines()[-1]


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_six_hundred_strange_cameras_break_nothing(reconstruction: Any) -> None:
    """Of every reconstruction; a hundred thousand were run when this was written."""
    assert fuzz.failures(range(600), reconstruction) == []


@pytest.mark.parametrize(
    ("reconstruction", "numbers"),
    [
        # colours in holes: a plane so steep that its footprint lay on any front, even on none
        ("gaussian", [33452, 95954]),
        # a wide sub-sample's surface, continued to its pixel's centre, ended beyond infinity
        ("offset", [14560, 25210, 55978, 57586, 72544, 99166]),
    ],
)
def test_cases_that_failed_once_stay_sound(reconstruction: Any, numbers: list[int]) -> None:
    assert fuzz.failures(numbers, reconstruction) == []


def test_interpreted_kernels_never_reach_outside_an_array_at_either_end() -> None:
    """Plain Python raises beyond the end; before the start it would count from the end."""
    assert run_apart("--cameras", "90", NUMBA_DISABLE_JIT="1").startswith("90 cameras, 0 failed")


@pytest.mark.slow  # compiles every kernel anew
def test_compiled_kernels_with_checked_indices_stay_inside_their_arrays(tmp_path: Path) -> None:
    """All but the loads and stores of several floats at once, which no check reaches."""
    line = run_apart("--cameras", "1200", NUMBA_BOUNDSCHECK="1", NUMBA_CACHE_DIR=str(tmp_path))
    assert line.startswith("1200 cameras, 0 failed")


def test_most_cases_show_something() -> None:
    """Frames without a covered pixel would find nothing."""
    covered = [fuzz.strange_warp(number, "point").coverage.any() for number in range(300)]
    assert sum(covered) > 150


def test_a_case_that_fails_is_told_by_its_number(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def unsound(frame: Any) -> None:
        assert frame.camera.width == 0

    monkeypatch.setattr(fuzz, "assert_frame_is_sound", unsound)
    assert fuzz.failures([11, 12], "point") == [11, 12]
    told = capsys.readouterr().err
    assert "case 11, point" in told
    assert "AssertionError" in told


def test_compiled_kernels_cannot_be_guarded() -> None:
    with pytest.raises(RuntimeError, match="NUMBA_DISABLE_JIT=1"):
        fuzz.guard_kernels()
