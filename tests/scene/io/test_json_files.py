"""JSON is read strictly; every refusal names file, key and index."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from belvedere.ground.errors import FileFormatError, MissingFileError, OutputError, SceneError
from belvedere.scene.io import json_files
from belvedere.scene.io.json_files import JsonObject, read_json, write_json


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"", r"is empty \(0 bytes\)"),
        (b" \n ", "holds nothing but blanks"),
        (b'{"a": 1', "ends too early, it is truncated at line 1"),
        (b'{"frames": [\n  {"a": 1},', "ends too early, it is truncated at line 2"),
        (b'{"a": 1,}', "is not JSON"),
        (b"[1, 2]", "holds a list, expected a JSON object"),
        (b"3", "holds a number, expected a JSON object"),
        (b'{"a": 1, "a": 2}', "the key 'a' stands twice"),
        (b'{"a": {"b": [1, NaN]}}', r"a\.b\[1\] is NaN, expected a finite number"),
        (b'{"a": -Infinity}', "a is -Infinity, expected a finite number"),
        (b'{"a": 1e999}', "a is 1e999, expected a finite number"),
        (b'{"a": "\xff"}', "is not UTF-8 text"),
        (b"[" * 100_000, "is not JSON that can be read"),
        (b'{"a": ' + b"9" * 5000 + b"}", "is not JSON that can be read"),
    ],
)
def test_what_is_no_good_json_is_refused(tmp_path: Path, text: bytes, message: str) -> None:
    (tmp_path / "transforms.json").write_bytes(text)
    with pytest.raises(FileFormatError, match=message) as caught:
        read_json(tmp_path / "transforms.json")
    assert "transforms.json" in str(caught.value)


def test_a_huge_file_is_refused_unread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(json_files, "MAX_BYTES", 10)
    (tmp_path / "a.json").write_text('{"a": "long text"}')
    with pytest.raises(FileFormatError, match="more than the 10 read as JSON"):
        read_json(tmp_path / "a.json")


def test_a_missing_file_is_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match="no file"):
        read_json(tmp_path / "a.json")


def test_a_byte_order_mark_is_no_harm(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_bytes(b'\xef\xbb\xbf{"a": 1}')
    assert read_json(tmp_path / "a.json").integer("a") == 1


def test_what_is_written_is_read_back_to_the_last_digit(tmp_path: Path) -> None:
    data = {"x": [0.1, 1 / 3, 1e-300], "name": "Aussicht – schön", "deep": {"list": [1, None]}}
    write_json(tmp_path / "a.json", data)
    assert read_json(tmp_path / "a.json").data == data
    with pytest.raises(OutputError, match="--force"):
        write_json(tmp_path / "a.json", data, force=False)
    with pytest.raises(SceneError, match="cannot be written as JSON"):
        write_json(tmp_path / "b.json", {"x": float("nan")})
    assert not (tmp_path / "b.json").exists()


DATA = {
    "w": 640, "half": 0.5, "word": "x", "flag": True, "matrix": [[1, 2], [3, 4]],
    "ragged": [[1], [2, 3]], "list": [{"a": 1}, 3], "nothing": None, "inner": {"k": "v"},
}  # fmt: skip


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda j: j.text("missing"), r"t\.json: frames\[2\] has no 'missing'"),
        (lambda j: j.text("nothing"), "has no 'nothing'"),
        (lambda j: j.text("w"), r"frames\[2\]\.w is 640, expected text"),
        (lambda j: j.number("word"), r'frames\[2\]\.word is "x", expected a number'),
        (lambda j: j.number("flag"), "flag is true, expected a number"),
        (lambda j: j.number("w", low=700), "w is 640, expected a number of at least 700"),
        (lambda j: j.number("half", above=0.5), "half is 0.5, expected a number above 0.5"),
        (lambda j: j.integer("half"), "half is 0.5, expected a whole number from 0"),
        (lambda j: j.integer("w", low=641), "expected a whole number from 641"),
        (lambda j: j.array("matrix", (4, 4)), r"matrix has shape \(2, 2\), expected \(4, 4\)"),
        (lambda j: j.array("ragged", (2, 2)), "a row is ragged or has text"),
        (lambda j: j.array("word", (2, 2)), "a row is ragged or has text"),
        (lambda j: j.object("w"), "w is 640, expected an object"),
        (lambda j: list(j.objects("w")), "w is 640, expected a list of objects"),
        (lambda j: list(j.objects("list")), r"list\[1\] is 3, expected an object"),
    ],
)
def test_wrong_values_are_refused_by_key(call: object, message: str) -> None:
    assert callable(call)
    with pytest.raises(SceneError, match=message):
        call(JsonObject("t.json", dict(DATA), "frames[2]."))


def test_right_values_are_read_by_key() -> None:
    values = JsonObject("t.json", dict(DATA))
    assert values.integer("w") == 640
    assert values.number("missing", 2.0) == 2.0
    assert values.text("missing", "d") == "d"
    assert values.object("inner").text("k") == "v"
    assert values.object("missing").data == {}
    assert values.here == "t.json"
    np.testing.assert_array_equal(values.array("matrix", (2, 2)), [[1, 2], [3, 4]])
