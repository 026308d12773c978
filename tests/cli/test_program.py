"""The program as a process: fast to answer, one line when it refuses, quiet when interrupted."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from belvedere import cli
from belvedere.ground import SceneError
from tests.cli.conftest import Program


def test_our_errors_are_one_line_and_exit_with_2(program: Program, tmp_path: Path) -> None:
    told = program("info", tmp_path / "nothing")
    assert told.status == 2
    assert told.out == ""
    assert told.err.startswith("belvedere: no file or folder")
    assert told.err.count("\n") == 1


def test_debug_shows_the_traceback(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="no file or folder"):
        cli.main(["info", str(tmp_path / "nothing"), "--debug"])


def test_a_bug_is_called_a_bug_without_a_traceback(
    program: Program, kept_capture: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from belvedere.studio import inspect

    def broken(*_: object, **__: object) -> None:
        raise RuntimeError("gears")

    monkeypatch.setattr(inspect, "inspect_scene", broken)
    told = program("info", kept_capture)
    assert told.status == cli.EXIT_BROKEN
    assert "internal error, RuntimeError: gears" in told.err
    assert "Traceback" not in told.err


def test_unknown_words_are_refused_by_name(program: Program, kept_capture: Path) -> None:
    assert program("fly").status == 2
    told = program("render", kept_capture, "--path", "spiral", "-o", "x.png")
    assert told.status == 2
    assert "spiral" in told.err


@pytest.mark.slow
def test_ctrl_c_half_way_leaves_nothing_half_written_and_the_same_command_goes_on(
    kept_capture: Path, tmp_path: Path
) -> None:
    words = [sys.executable, "-m", "belvedere", "render", str(kept_capture), "--frames", "900",
             "--size", "160x120", "-o", str(tmp_path / "walk")]  # fmt: skip
    process = subprocess.Popen(
        words, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        # a job that a shell starts in the background hands down an ignored interrupt
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # noqa: PLW1509
    )  # fmt: skip
    partial = tmp_path / ".walk.belvedere-partial"
    deadline = time.monotonic() + 60
    while not list(partial.glob("frame_0000*.png")) and time.monotonic() < deadline:
        assert process.poll() is None, process.communicate()
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == cli.EXIT_INTERRUPTED, err
    assert "belvedere: interrupted: nothing half-written is left; repeating the same" in err
    assert "Traceback" not in err
    assert not (tmp_path / "walk").exists()
    again = subprocess.run(words, capture_output=True, text=True, check=False, timeout=300)
    assert again.returncode == 0, again.stderr
    assert "from before" in again.stdout
    assert re.search(r"rendering frames: \d+ of 900 are there, \d+ to do", again.stderr)
    assert len(list((tmp_path / "walk").glob("frame_*.png"))) == 900
    assert not partial.exists()


def test_nothing_is_fetched_from_the_network(kept_capture: Path, tmp_path: Path) -> None:
    guard = (
        "import socket, sys\n"
        "def refuse(*a, **k): raise AssertionError('network')\n"
        "socket.socket.connect = refuse\n"
        "socket.create_connection = refuse\n"
        "from belvedere.cli import main\n"
        "main(sys.argv[1:])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", guard, "render", str(kept_capture), "-o", str(tmp_path / "a.png")],
        capture_output=True, text=True, check=False, env=dict(os.environ),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
