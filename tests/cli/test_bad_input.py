"""Bad input of every kind: each case names what a person would read, and nothing is half-written.

Each case spoils a sound capture (or asks for something impossible), runs the program, and expects
exit status 2, one line on the error stream with the words given, and no output that opens.
"""

from __future__ import annotations

import errno
import json
import os
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from belvedere.ground.jit import NOTICE
from tests.cli.conftest import Program

Spoil = Callable[[Path], None]


def edit(name: str, change: Callable[[dict[str, Any]], None]) -> Spoil:
    """Change the parsed JSON of a file of the capture."""

    def spoil(capture: Path) -> None:
        file = capture / name
        data = json.loads(file.read_text())
        change(data)
        file.write_text(json.dumps(data))

    return spoil


def write(name: str, content: bytes) -> Spoil:
    def spoil(capture: Path) -> None:
        (capture / name).write_bytes(content)

    return spoil


def set_key(*keys: Any, value: Any) -> Callable[[dict[str, Any]], None]:
    def change(data: Any) -> None:
        for key in keys[:-1]:
            data = data[key]
        data[keys[-1]] = value

    return change


def drop_key(*keys: Any) -> Callable[[dict[str, Any]], None]:
    def change(data: Any) -> None:
        for key in keys[:-1]:
            data = data[key]
        del data[keys[-1]]

    return change


def drop_keys(*keys: str) -> Callable[[dict[str, Any]], None]:
    def change(data: dict[str, Any]) -> None:
        for key in keys:
            del data[key]

    return change


def truncate(name: str, keep: float = 0.5) -> Spoil:
    def spoil(capture: Path) -> None:
        file = capture / name
        content = file.read_bytes()
        file.write_bytes(content[: int(len(content) * keep)])

    return spoil


def remove(name: str) -> Spoil:
    return lambda capture: (capture / name).unlink()


def huge_png(bits: int) -> bytes:
    """A PNG whose header says 40000 x 25000 pixels, 10^9, and that holds none."""
    color = 0 if bits == 16 else 2
    header = struct.pack(">IIBBBBB", 40000, 25000, bits, color, 0, 0, 0)

    def chunk(kind: bytes, data: bytes) -> bytes:
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(b""))
        + chunk(b"IEND", b"")
    )


def resize_depth(capture: Path) -> None:
    Image.fromarray(np.full((20, 30), 1000, np.uint16)).save(capture / "depth/view_00.png")


def link_out(capture: Path) -> None:
    outside = capture.parent / "elsewhere.png"
    (capture / "images/view_00.png").rename(outside)
    (capture / "images/view_00.png").symlink_to(outside)


POSE = ("frames", 0, "transform_matrix")

CASES: dict[str, tuple[Spoil, str]] = {
    "truncated PNG": (truncate("images/view_00.png"), r"images/view_00.png.*(truncated|damaged)"),
    "truncated depth PNG": (truncate("depth/view_00.png"), r"depth/view_00.png"),
    "0-byte picture": (write("images/view_00.png", b""), r"images/view_00.png.*empty"),
    "picture that is text": (write("images/view_00.png", b"hello"), r"images/view_00.png"),
    "10^9-pixel colour header": (write("images/view_00.png", huge_png(8)), r"40000 x 25000"),
    "10^9-pixel depth header": (write("depth/view_00.png", huge_png(16)), r"40000 x 25000"),
    "depth of another size": (resize_depth, r"20.*30|30.*20"),
    "missing picture": (remove("images/view_00.png"), r"view_00.png"),
    "missing depth": (remove("depth/view_00.png"), r"depth/view_00.png"),
    "missing transforms.json": (remove("transforms.json"), r"transforms.json"),
    "0-byte JSON": (write("transforms.json", b""), r"transforms.json.*empty"),
    "truncated JSON": (truncate("transforms.json"), r"transforms.json.*line"),
    "JSON that is a list": (write("transforms.json", b"[]"), r"transforms.json"),
    "JSON in binary": (write("transforms.json", b"\xff\xfe\x00{"), r"transforms.json"),
    "NaN in JSON": (
        write("transforms.json", b'{"fl_x": NaN, "frames": []}'),
        r"transforms.json.*NaN",
    ),
    "duplicate key": (
        write("transforms.json", b'{"w": 48, "w": 49, "frames": []}'),
        r"transforms.json.*'w'",
    ),
    "no frames key": (edit("transforms.json", drop_key("frames")), r"frames"),
    "empty frames": (edit("transforms.json", set_key("frames", value=[])), r"frames"),
    "pose with a huge number": (
        edit("transforms.json", set_key(*POSE, 0, 0, value=1e400)),
        r"transforms.json",
    ),
    "scaled pose": (
        edit("transforms.json", set_key(*POSE, value=(np.diag([2, 2, 2, 1.0])).tolist())),
        r"frames\[0\].*rigid",
    ),
    "mirrored pose": (
        edit("transforms.json", set_key(*POSE, value=(np.diag([-1, 1, 1, 1.0])).tolist())),
        r"frames\[0\].*mirror",
    ),
    "pose of 3 x 3": (
        edit("transforms.json", set_key(*POSE, value=np.eye(3).tolist())),
        r"frames\[0\].*transform_matrix",
    ),
    "pose of words": (
        edit("transforms.json", set_key(*POSE, value="identity")),
        r"frames\[0\].*transform_matrix",
    ),
    "transposed pose": (
        edit(
            "transforms.json",
            set_key(*POSE, value=[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [1, 2, 3, 1]]),
        ),
        r"last row",
    ),
    "missing pose": (edit("transforms.json", drop_key(*POSE)), r"transform_matrix"),
    "zero focal length": (edit("transforms.json", set_key("fl_x", value=0)), r"fl_x|fx"),
    "negative focal length": (edit("transforms.json", set_key("fl_x", value=-50)), r"fl_x|fx"),
    "no focal length": (
        edit("transforms.json", drop_keys("fl_x", "fl_y")),
        r"fl_x",
    ),
    "focal length of words": (edit("transforms.json", set_key("fl_x", value="long")), r"fl_x"),
    "zero width": (edit("transforms.json", set_key("w", value=0)), r"w"),
    "width of another picture": (edit("transforms.json", set_key("w", value=50)), r"50"),
    "absolute path": (
        edit("transforms.json", set_key("frames", 0, "file_path", value="/etc/hostname")),
        r"/etc/hostname.*(absolute|leave|outside|relative)",
    ),
    "path with ..": (
        edit("transforms.json", set_key("frames", 0, "file_path", value="../secret.png")),
        r"\.\./secret.png",
    ),
    "depth path with ..": (
        edit("transforms.json", set_key("frames", 0, "depth_file_path", value="a/../../b.png")),
        r"\.\.",
    ),
    "link out of the folder": (link_out, r"view_00.png.*(link|leaves|outside)"),
    "duplicate frame names": (
        edit("transforms.json", lambda d: d["frames"].append(dict(d["frames"][0]))),
        r"view_00",
    ),
    "file_path that is a number": (
        edit("transforms.json", set_key("frames", 0, "file_path", value=7)),
        r"file_path",
    ),
    "newer version": (
        edit("belvedere.json", set_key("version", value=999)),
        r"999.*newer|newer.*999",
    ),
    "unknown kind": (edit("belvedere.json", set_key("kind", value="hologram")), r"hologram"),
    "depth scale of zero": (
        edit("transforms.json", set_key("depth_unit_scale_factor", value=0)),
        r"depth_unit_scale_factor",
    ),
    "unknown lens": (
        edit("transforms.json", set_key("camera_model", value="KALEIDOSCOPE")),
        r"KALEIDOSCOPE",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_a_spoilt_capture_is_refused_in_one_line(
    program: Program, capture: Path, tmp_path: Path, case: str
) -> None:
    spoil, words = CASES[case]
    spoil(capture)
    output = tmp_path / "out.png"
    told = program("render", capture, "-o", output, "--references", 6)
    refused_well(told.status, told.out, told.err, words)
    assert not output.exists()
    assert not [file for file in tmp_path.iterdir() if file.name.startswith((".", "out"))]


def refused_well(status: int, out: str, err: str, words: str) -> None:
    import re

    err = err.replace(NOTICE, "")  # a first run may have to compile
    lines = [line for line in err.splitlines() if line.startswith("belvedere: ")]
    assert status == 2, (status, out, err)
    assert len(lines) == 1, err
    assert "Traceback" not in err
    assert "internal error" not in err
    assert re.search(words, lines[0]), lines[0]
    assert len(lines[0]) < 600


ARGUMENTS: dict[str, tuple[list[str], str]] = {
    "no such scene": (["info", "{capture}/nowhere"], r"no file or folder"),
    "empty folder": (["info", "{empty}"], r"empty folder"),
    "folder without a scene": (["info", "{other}"], r"looked for"),
    "a picture as a scene": (["info", "{capture}/images/view_00.png"], r"is a file"),
    "unknown layout": (["info", "{capture}", "--format", "tarot"], r"tarot"),
    "negative depth scale": (["info", "{capture}", "--depth-scale", "-1"], r"depth_scale"),
    "NaN depth scale": (["info", "{capture}", "--depth-scale", "nan"], r"depth_scale"),
    "size of words": (["render", "{capture}", "--size", "big", "-o", "{new}.png"], r"WIDTHxHEIGHT"),
    "size of nothing": (["render", "{capture}", "--size", "0x10", "-o", "{new}.png"], r"width"),
    "size beyond reason": (
        ["render", "{capture}", "--size", "99999999x1", "-o", "{new}.png"],
        r"99999999",
    ),
    "unknown path": (["render", "{capture}", "--path", "zigzag", "-o", "{new}.png"], r"zigzag"),
    "missing path file": (
        ["render", "{capture}", "--path", "zigzag.json", "-o", "{new}.png"],
        r"zigzag.json",
    ),
    "path file that is a scene": (
        ["render", "{capture}", "--path", "{capture}/transforms.json", "-o", "{new}.png"],
        r"transforms.json",
    ),
    "unknown picture format": (["render", "{capture}", "-o", "{new}.bmp"], r"bmp"),
    "evaluate one view": (["evaluate", "{one}", "-o", "{new}"], r"view"),
    "unknown reconstruction": (
        ["evaluate", "{capture}", "-r", "magic", "-o", "{new}"],
        r"magic",
    ),
    "convert to unknown layout": (["convert", "{capture}", "{new}", "--to", "tarot"], r"tarot"),
    "convert onto itself": (["convert", "{capture}", "{capture}"], r"exists|--force"),
    "convert into a full folder": (["convert", "{capture}", "{other}", "--force"], r"belvedere"),
    "report where a file is": (["evaluate", "{capture}", "-o", "{other}/notes.txt"], r"notes.txt"),
}


@pytest.mark.parametrize("case", ARGUMENTS)
def test_impossible_wishes_are_refused_in_one_line(
    program: Program, capture: Path, tmp_path: Path, case: str
) -> None:
    words, expected = ARGUMENTS[case]
    empty, other, one = tmp_path / "empty", tmp_path / "other", tmp_path / "one"
    empty.mkdir()
    other.mkdir()
    (other / "notes.txt").write_text("mine")
    if "{one}" in words:
        from belvedere.scene.io import read_views, save_views

        save_views(read_views(capture).select([0]), one)
    places = {
        "capture": capture,
        "empty": empty,
        "other": other,
        "one": one,
        "new": tmp_path / "new",
    }
    told = program(*[word.format(**places) for word in words])
    refused_well(told.status, told.out, told.err, expected)
    assert (other / "notes.txt").read_text() == "mine"
    assert not list(tmp_path.glob("new*"))


def test_a_read_only_place_is_refused_in_one_line(
    program: Program, kept_capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if os.geteuid() == 0:  # root may write anywhere: let the system call say what it would

        def refuse(*_: object, **__: object) -> None:
            raise OSError(errno.EROFS, "Read-only file system", str(tmp_path / "a.png"))

        monkeypatch.setattr(Path, "write_bytes", refuse)
    else:
        tmp_path.chmod(0o500)
    told = program("render", kept_capture, "-o", tmp_path / "a.png")
    refused_well(told.status, told.out, told.err, r"(?i)read-only|permission")


def test_a_full_disk_is_refused_in_one_line_and_leaves_nothing(
    program: Program, kept_capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    told = program("convert", kept_capture, tmp_path / "copy")
    refused_well(told.status, told.out, told.err, r"(?i)full|no space")
    assert not (tmp_path / "copy").exists()
    told = program("render", kept_capture, "-o", tmp_path / "a.png")
    refused_well(told.status, told.out, told.err, r"(?i)full|no space")
    assert not list(tmp_path.glob("*.png"))


def test_an_interrupted_conversion_goes_on_and_never_opens_half(
    program: Program, kept_capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from belvedere.scene.io import pixels_out
    from belvedere.scene.views import ViewSet

    loads = ViewSet.__getitem__
    seen = 0

    def interrupted(self: ViewSet, index: int) -> Any:
        nonlocal seen
        seen += 1
        if seen > 8:
            raise KeyboardInterrupt
        return loads(self, index)

    assert pixels_out
    monkeypatch.setattr(ViewSet, "__getitem__", interrupted)
    first = program("convert", kept_capture, tmp_path / "copy")
    assert first.status == 130
    assert not (tmp_path / "copy").exists()
    assert program("info", tmp_path / "copy").status == 2
    monkeypatch.setattr(ViewSet, "__getitem__", loads)
    again = program("convert", kept_capture, tmp_path / "copy", "--json")
    assert again.status == 0, again.err
    assert json.loads(again.out)["views"] == 6
    assert program("info", tmp_path / "copy", "--no-check").status == 0
