"""Killed preparations end with the same bytes; more of them by ``tests.kills``."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

pytest.importorskip("distributed", reason="needs dask (pip install 'belvedere[cluster]')")

from tests import kills

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no process groups to kill")
QUICK = ("--rays", "4", "--references", "2", "--texels", "24")


@pytest.mark.slow
def test_a_preparation_killed_twice_ends_with_the_same_bytes(tmp_path: Path, capsys) -> None:
    """Once when some seconds have passed, once when some files are there."""
    assert kills.kill_and_compare("built-in:flat", tmp_path, 2, 5, QUICK) == []
    told = capsys.readouterr().out
    assert told.count("killed after") == 2
    assert "the same bytes" in told


def test_folders_are_compared_byte_by_byte(tmp_path: Path) -> None:
    one, other = tmp_path / "one", tmp_path / "other"
    for folder in (one, other):
        (folder / "deep").mkdir(parents=True)
        (folder / "deep" / "same").write_bytes(b"same")
        (folder / "changed").write_bytes(b"0123")
    assert kills.differences(one, other) == []
    (other / "changed").write_bytes(b"0124")
    (other / "more").write_bytes(b"")
    (one / "deep" / "less").write_bytes(b"")
    assert kills.differences(one, other) == ["changed", "deep/less", "more"]


def test_a_process_that_its_block_leaves_is_gone() -> None:
    sleep = [sys.executable, "-c", "import time; time.sleep(600)"]
    with pytest.raises(KeyboardInterrupt), kills.running(sleep) as process:
        raise KeyboardInterrupt
    assert process.returncode == -9
    assert not kills.finishes(sleep, kills.later(0.1))
    assert kills.finishes([sys.executable, "-c", ""], kills.later(600.0))


def test_a_preparation_that_fails_by_itself_is_no_kill() -> None:
    with pytest.raises(kills.PreparationError, match="no such house"):
        kills.finishes([sys.executable, "-c", "raise SystemExit('no such house')"])


def test_a_moment_comes_with_the_files(tmp_path: Path) -> None:
    moment = kills.once_there(tmp_path, 2)
    (tmp_path / "one").touch()
    assert not moment()
    (tmp_path / "two").touch()
    assert moment()
