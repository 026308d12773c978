"""What is written is there complete, or not at all."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from belvedere.ground.errors import InputError, OutputError
from belvedere.scene.io.atomic import (
    atomic_write,
    require_free,
    staged_folder,
    staging_path,
    write_bytes,
)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_file_appears_under_its_name_and_nothing_else_stays(tmp_path: Path) -> None:
    with atomic_write(tmp_path / "deep" / "a.txt") as temporary:
        assert temporary.suffix == ".txt"
        assert not (tmp_path / "deep" / "a.txt").exists()
        temporary.write_text("whole")
    assert (tmp_path / "deep" / "a.txt").read_text() == "whole"
    assert names(tmp_path / "deep") == ["a.txt"]


@pytest.mark.parametrize("error", [ValueError("no"), KeyboardInterrupt(), SystemExit(1)])
def test_an_error_half_way_leaves_the_old_file_and_no_other(
    tmp_path: Path, error: BaseException
) -> None:
    (tmp_path / "a.txt").write_text("old")
    with (  # noqa: PT012 - the block is what is tested
        pytest.raises(type(error)),
        atomic_write(tmp_path / "a.txt") as temporary,
    ):
        temporary.write_text("ha")
        raise error
    assert (tmp_path / "a.txt").read_text() == "old"
    assert names(tmp_path) == ["a.txt"]


def test_what_exists_is_replaced_only_by_force(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("old")
    with pytest.raises(OutputError, match=r"a\.txt exists: pass --force"):
        require_free(tmp_path / "a.txt")
    with pytest.raises(OutputError, match="--force"):
        write_bytes(tmp_path / "a.txt", b"new", force=False)
    write_bytes(tmp_path / "a.txt", b"new", force=True)
    assert (tmp_path / "a.txt").read_text() == "new"


def test_a_dangling_link_counts_as_something_that_exists(tmp_path: Path) -> None:
    (tmp_path / "a.txt").symlink_to(tmp_path / "nowhere")
    with pytest.raises(OutputError, match="--force"):
        require_free(tmp_path / "a.txt")


def test_a_folder_is_not_a_file_to_write(tmp_path: Path) -> None:
    (tmp_path / "a.png").mkdir()
    with pytest.raises(OutputError, match="is a folder, expected the name of a file"):
        write_bytes(tmp_path / "a.png", b"")


@pytest.mark.parametrize(
    ("number", "message"),
    [
        (errno.ENOSPC, "the disk is full .* free some space or write elsewhere"),
        (errno.EROFS, "cannot be written here .* read-only"),
        (errno.EACCES, "cannot be written here .* choose another"),
        (errno.ENAMETOOLONG, "cannot be written"),
    ],
)
def test_the_systems_refusals_become_one_clear_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, message: str
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(OutputError, match=message):
        write_bytes(tmp_path / "a.bin", b"12")
    assert names(tmp_path) == []


def test_a_path_through_a_file_is_refused_as_output(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        write_bytes(tmp_path / "file" / "a.bin", b"12")


def test_errors_that_are_not_about_writing_pass_unchanged(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), atomic_write(tmp_path / "a.txt"):
        (tmp_path / "not there").read_text()


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on file sizes there")
def test_a_disk_that_runs_full_is_named_and_leaves_nothing(tmp_path: Path) -> None:
    code = f"""
import resource, signal
from belvedere.ground.errors import OutputError
from belvedere.scene.io.atomic import write_bytes
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
try:
    write_bytes({str(tmp_path / "big.bin")!r}, bytes(100_000))
except OutputError as error:
    print(error)
"""
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "the disk is full" in out.stdout
    assert names(tmp_path) == []


# ---- folders -----------------------------------------------------------------------------------


def test_a_folder_appears_complete(tmp_path: Path) -> None:
    with staged_folder(tmp_path / "scene") as folder:
        (folder / "a").write_text("1")
        assert not (tmp_path / "scene").exists()
    assert names(tmp_path) == ["scene"]
    assert names(tmp_path / "scene") == ["a"]


def test_an_error_leaves_neither_the_folder_nor_its_parts(tmp_path: Path) -> None:
    with (  # noqa: PT012 - the block is what is tested
        pytest.raises(InputError),
        staged_folder(tmp_path / "scene", resume=True) as folder,
    ):
        (folder / "a").write_text("1")
        raise InputError("bad view")
    assert names(tmp_path) == []


def test_an_interruption_keeps_the_parts_only_for_those_that_resume(tmp_path: Path) -> None:
    for resume in (False, True):
        with (  # noqa: PT012 - the block is what is tested
            pytest.raises(KeyboardInterrupt),
            staged_folder(tmp_path / "scene", resume=resume) as folder,
        ):
            (folder / "a").write_text("1")
            raise KeyboardInterrupt
        assert staging_path(tmp_path / "scene").exists() == resume
        assert not (tmp_path / "scene").exists()
    with staged_folder(tmp_path / "scene", resume=True) as folder:
        assert (folder / "a").read_text() == "1"
    assert names(tmp_path) == ["scene"]


def test_what_a_crash_left_is_cleared_by_those_that_start_anew(tmp_path: Path) -> None:
    staging = staging_path(tmp_path / "scene")
    staging.mkdir()
    (staging / "old").write_text("")
    with staged_folder(tmp_path / "scene") as folder:
        (folder / "new").write_text("")
    assert names(tmp_path / "scene") == ["new"]


def test_only_our_own_folders_are_replaced_even_by_force(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    (home / "letters.txt").write_text("dear")
    with (
        pytest.raises(OutputError, match="not a folder that belvedere wrote"),
        staged_folder(home, force=True, owned_by="belvedere.json"),
    ):
        pass
    assert (home / "letters.txt").read_text() == "dear"
    (home / "belvedere.json").write_text("{}")
    with pytest.raises(OutputError, match="--force"), staged_folder(home):
        pass
    with staged_folder(home, force=True, owned_by="belvedere.json") as folder:
        (folder / "x").write_text("")
    assert names(home) == ["x"]
    assert names(tmp_path) == ["home"]


def test_an_empty_folder_may_be_filled_without_force(tmp_path: Path) -> None:
    (tmp_path / "scene").mkdir()
    with staged_folder(tmp_path / "scene", owned_by="belvedere.json") as folder:
        (folder / "x").write_text("")
    assert names(tmp_path / "scene") == ["x"]


def test_a_file_is_not_a_folder_to_make(tmp_path: Path) -> None:
    (tmp_path / "scene").write_text("")
    with (
        pytest.raises(OutputError, match="is a file, expected the name of a folder"),
        staged_folder(tmp_path / "scene", force=True),
    ):
        pass


def test_a_replacement_that_fails_gives_the_old_folder_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = tmp_path / "scene"
    scene.mkdir()
    (scene / "belvedere.json").write_text("{}")
    rename: Callable[..., None] = os.rename
    staging = staging_path(scene)

    def refuse(source: Path, target: Path) -> None:
        if Path(source) == staging:
            raise OSError(errno.EROFS, "Read-only file system")
        rename(source, target)

    monkeypatch.setattr(os, "rename", refuse)
    with (
        pytest.raises(OutputError, match="read-only"),
        staged_folder(scene, force=True, owned_by="belvedere.json") as folder,
    ):
        (folder / "x").write_text("")
    assert names(tmp_path) == ["scene"]
    assert names(scene) == ["belvedere.json"]
