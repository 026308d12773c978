"""Paths inside a scene stay inside it."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from belvedere.ground.errors import MissingFileError, SceneError, UnsafePathError
from belvedere.scene.io.paths import existing, file_name, inside


@pytest.mark.parametrize("good", ["a.png", "images/a.png", "./a.png", "x/../a.png", "a b/ü.png",
                                  "images//a.png", "..a.png"])  # fmt: skip
def test_ordinary_paths_are_taken(tmp_path: Path, good: str) -> None:
    assert inside(tmp_path, good) == tmp_path / good


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        ("/etc/passwd", "is the absolute path"),
        ("~/a.png", "is the absolute path"),
        ("C:/a.png", "is the absolute path"),
        ("c:a.png", "is the absolute path"),
        ("..\\a.png", "has a backslash"),
        ("images\\a.png", "has a backslash"),
        ("\\\\server\\a.png", "has a backslash"),
        ("../a.png", "leads out of the scene's folder"),
        ("images/../../a.png", "leads out of the scene's folder"),
        ("..", "leads out of the scene's folder"),
        ("a\x00.png", "control characters"),
        ("a\n.png", "control characters"),
    ],
)
def test_paths_that_could_leave_are_refused(tmp_path: Path, bad: str, message: str) -> None:
    where = "transforms.json: frames[3].file_path"
    with pytest.raises(UnsafePathError, match=message) as caught:
        inside(tmp_path, bad, where)
    assert str(caught.value).startswith(where)


@pytest.mark.parametrize("bad", ["", "  ", None, 3, ["a"]])
def test_what_is_no_path_is_refused(tmp_path: Path, bad: object) -> None:
    with pytest.raises(SceneError, match="expected the path of a file"):
        inside(tmp_path, bad)


def test_links_may_stay_inside_but_not_lead_out(tmp_path: Path) -> None:
    scene, other = tmp_path / "scene", tmp_path / "scene-other"
    for folder in (scene, other):
        folder.mkdir()
        (folder / "a.png").write_text("")
    (scene / "in.png").symlink_to("a.png")
    (scene / "out.png").symlink_to(other / "a.png")
    (scene / "images").symlink_to(other)
    assert existing(scene, "in.png").is_file()
    for name in ("out.png", "images/a.png"):
        with pytest.raises(UnsafePathError, match="symbolic link out of the scene's folder"):
            inside(scene, name)


def test_a_scene_reached_through_a_link_is_a_scene(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "a.png").write_text("")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    assert existing(tmp_path / "link", "a.png").is_file()


def test_a_missing_file_is_named_with_its_place(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"frames\[0\]\.file_path: no file 'a\.png' in"):
        existing(tmp_path, "a.png", "transforms.json: frames[0].file_path")
    with pytest.raises(FileNotFoundError):
        existing(tmp_path, "a.png")


@given(st.lists(st.text(max_size=140), max_size=8))
def test_names_become_files_that_are_safe_and_differ(names: list[str]) -> None:
    taken: set[str] = set()
    files = [file_name(name, taken, index) for index, name in enumerate(names)]
    assert len({file.lower() for file in files}) == len(files)
    for file in files:
        inside("/scene", f"images/{file}.png")
        assert len(file) <= 120


@pytest.mark.parametrize("name", ["con", "a/NUL.x", "..", ".hidden", "a:b", "x" * 121, "ü", "a/"])
def test_names_that_some_system_refuses_become_numbers(name: str) -> None:
    assert file_name(name, set(), 7) == "00007"


def test_names_that_differ_in_case_only_get_different_files() -> None:
    taken: set[str] = set()
    assert file_name("View", taken, 0) == "View"
    assert file_name("view", taken, 1) != "view"
