"""What is told while a job runs."""

from __future__ import annotations

import io
import re
import sys

import pytest

from belvedere.cli.console import most_memory, progress_bar


class Terminal(io.StringIO):
    """An error stream that people read."""

    def isatty(self) -> bool:
        return True


def test_where_nobody_looks_on_a_stage_is_a_line(capsys) -> None:
    with progress_bar() as tell:
        tell(0, 3, "counting")
        tell(3, 3, "counting")
    err = capsys.readouterr().err
    assert re.fullmatch(r"counting: 3 to do\ncounting: done in \d+\.\d s\n", err)


@pytest.mark.skipif(sys.platform == "win32", reason="the system does not tell")
def test_memory_is_shown_beside_the_time(capsys, monkeypatch) -> None:
    assert re.fullmatch(r"memory \d+\.\d GB", most_memory())
    with progress_bar(memory=True) as tell:
        tell(0, 3, "counting")
        tell(3, 3, "counting")
    assert re.search(r"done in \d+\.\d s, memory \d+\.\d GB\n", capsys.readouterr().err)
    for memory in (True, False):
        terminal = Terminal()
        monkeypatch.setattr(sys, "stderr", terminal)
        with progress_bar(memory=memory) as tell:
            tell(1, 3, "counting")
        assert "counting" in terminal.getvalue()
        assert ("GB" in terminal.getvalue()) == memory


def test_memory_that_the_system_does_not_tell_is_left_out(capsys, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "resource", None)  # as on Windows
    assert most_memory() == ""
    with progress_bar(memory=True) as tell:
        tell(0, 3, "counting")
        tell(3, 3, "counting")
    assert re.search(r"done in \d+\.\d s\n", capsys.readouterr().err)
