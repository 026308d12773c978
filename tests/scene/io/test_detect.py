"""Which format a folder is in; what is said when it is in none."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from belvedere import ViewSet
from belvedere.ground.errors import InputError, MissingFileError, SceneError
from belvedere.scene.io import detect_format, read_views, write_views


def test_an_empty_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="is an empty folder, expected a scene"):
        read_views(tmp_path)


def test_an_unknown_folder_lists_what_was_looked_for(tmp_path: Path) -> None:
    (tmp_path / "holiday.png").write_text("")
    with pytest.raises(SceneError) as caught:
        read_views(tmp_path)
    for words in ("transforms.json", "cameras.json", "rgb.txt and groundtruth.txt",
                  "trajectory.log", "COLMAP", "Middlebury"):  # fmt: skip
        assert words in str(caught.value)


def test_nothing_at_all_is_named(tmp_path: Path) -> None:
    choices: tuple[dict[str, Any], ...] = ({}, {"format": "tum"})
    for options in choices:
        with pytest.raises(MissingFileError, match=r"no file or folder .*nowhere"):
            read_views(tmp_path / "nowhere", **options)


def test_a_file_that_heads_no_scene_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_text("")
    with pytest.raises(SceneError, match=r"a\.png is a file, expected a folder"):
        read_views(tmp_path / "a.png")


def test_another_kind_of_belvedere_folder_is_told_from_no_scene(tmp_path: Path) -> None:
    (tmp_path / "belvedere.json").write_text(json.dumps({"kind": "walkthrough", "version": 1}))
    with pytest.raises(SceneError, match="its kind is 'walkthrough'"):
        read_views(tmp_path)


def test_the_format_and_the_conventions_may_be_given_but_not_anyhow(
    tmp_path: Path, views: ViewSet
) -> None:
    write_views(views, tmp_path / "a", "cameras.json")
    assert read_views(tmp_path / "a", format="cameras.json").names == views.names
    with pytest.raises(InputError, match=r"format is 'obj', expected one of 'transforms'"):
        read_views(tmp_path / "a", format="obj")
    with pytest.raises(MissingFileError, match=r"rgb\.txt"):
        read_views(tmp_path / "a", format="tum")
    wrong: Any = {"axes": "opencv"}
    with pytest.raises(InputError, match="conventions is a dict, expected belvedere's Conventions"):
        read_views(tmp_path / "a", wrong)


def test_the_json_itself_may_be_named(tmp_path: Path, views: ViewSet) -> None:
    for layout, name in (("belvedere", "transforms.json"), ("cameras.json", "cameras.json")):
        write_views(views, tmp_path / layout, layout)
        assert read_views(tmp_path / layout / name).names == views.names


def test_every_public_name_of_the_room_is_there() -> None:
    from belvedere.scene import io

    for name in io.__all__:
        assert getattr(io, name) is not None
        assert name in dir(io)
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        _ = io.nothing


@pytest.mark.parametrize("nothing", [None, 3, b"capture"])
def test_what_is_no_path_is_refused(nothing: Any) -> None:
    for read in (read_views, detect_format):
        with pytest.raises(
            InputError, match=r"\.path is .*, expected the name of a file or folder"
        ):
            read(nothing)
