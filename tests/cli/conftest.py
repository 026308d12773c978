"""A capture on disk, and the program as a person runs it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from belvedere.cli import run
from belvedere.scene.io import save_views, to_cameras_json
from tests.studio.tiny_scenes import row_of_views


@dataclass(frozen=True)
class Outcome:
    status: int
    out: str
    err: str


Program = Callable[..., Outcome]


@pytest.fixture
def program(capsys: pytest.CaptureFixture[str]) -> Program:
    """Runs ``belvedere WORDS...`` in this process."""

    def call(*words: object) -> Outcome:
        status = run([str(word) for word in words])
        captured = capsys.readouterr()
        return Outcome(status, captured.out, captured.err)

    return call


@pytest.fixture(scope="session")
def kept_capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("captures") / "row"
    save_views(row_of_views(6), folder)
    return folder


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    """A scene folder in our format that a test may spoil."""
    folder = tmp_path / "capture"
    save_views(row_of_views(6), folder)
    return folder


@pytest.fixture
def cameras_json_capture(tmp_path: Path) -> Path:
    """The same in the cameras.json layout."""
    folder = tmp_path / "capture_json"
    to_cameras_json(row_of_views(6), folder)
    return folder
