"""Colour pictures: what goes in comes out, and bad files are named."""

from __future__ import annotations

import struct
import subprocess
import sys
import warnings
import zlib
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from belvedere.ground.color import color_to_linear, decode_srgb8
from belvedere.ground.errors import (
    FileFormatError,
    InputError,
    MissingDependencyError,
    MissingFileError,
)
from belvedere.scene.io import limits
from belvedere.scene.io.images import image_size, premultiply, read_color, write_color
from belvedere.scene.io.limits import MAX_PIXELS

U1 = npt.NDArray[np.uint8]
SUFFIXES = (".png", ".webp", ".jpg", ".exr", ".tif")


@pytest.fixture
def pixels(rng: np.random.Generator) -> U1:
    return rng.integers(0, 256, (9, 12, 3), dtype=np.uint8)


def save_any(path: Path, pixels: U1) -> Path:
    """Write with our writer, or Pillow for the formats we only read."""
    if path.suffix == ".tif":
        Image.fromarray(pixels).save(path)
    else:
        write_color(path, pixels)
    return path


# ---- round trips -------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".png", ".webp", ".tif"])
def test_lossless_formats_give_every_byte_back(tmp_path: Path, pixels: U1, suffix: str) -> None:
    path = save_any(tmp_path / f"a{suffix}", pixels)
    np.testing.assert_array_equal(read_color(path), pixels)
    assert image_size(path) == (12, 9)


def test_jpeg_gives_a_smooth_picture_back_nearly(tmp_path: Path) -> None:
    ramp = np.linspace(40, 200, 64)[None, :, None] + np.zeros((48, 1, 3))
    pixels = np.rint(ramp).astype(np.uint8)
    write_color(tmp_path / "a.jpg", pixels)
    back = read_color(tmp_path / "a.jpg")
    assert back.dtype == np.uint8
    assert np.abs(back.astype(int) - pixels).max() <= 3


def test_exr_keeps_linear_colour_beyond_white_and_below_black(tmp_path: Path) -> None:
    linear = np.array([[[-0.5, 0.25, 1e4], [0.0, 1.0, 2.0]]], dtype=np.float32)
    write_color(tmp_path / "a.exr", linear)
    back = read_color(tmp_path / "a.exr")
    assert back.dtype == np.float32
    np.testing.assert_array_equal(back, linear)
    assert image_size(tmp_path / "a.exr") == (2, 1)


def test_bytes_are_decoded_for_exr_and_linear_is_encoded_for_png(
    tmp_path: Path, pixels: U1
) -> None:
    write_color(tmp_path / "a.exr", pixels)
    linear = read_color(tmp_path / "a.exr")
    np.testing.assert_array_equal(linear, decode_srgb8(pixels))
    write_color(tmp_path / "b.png", linear)
    np.testing.assert_array_equal(read_color(tmp_path / "b.png"), pixels)


def test_the_same_picture_gives_the_same_bytes(tmp_path: Path, pixels: U1) -> None:
    for suffix in (".png", ".webp", ".jpg", ".exr"):
        for name in "ab":
            write_color(tmp_path / f"{name}{suffix}", pixels)
        first, second = ((tmp_path / f"{name}{suffix}").read_bytes() for name in "ab")
        assert first == second, suffix


# ---- alpha -------------------------------------------------------------------------------------


def test_alpha_is_straight_in_the_file_and_premultiplied_in_linear_light_here(
    tmp_path: Path,
) -> None:
    straight = np.array([[[200, 100, 50, 128], [200, 100, 50, 255], [200, 100, 50, 0]]], np.uint8)
    Image.fromarray(straight).save(tmp_path / "a.png")
    color = read_color(tmp_path / "a.png")
    want = decode_srgb8(straight[..., :3]) * (straight[..., 3:] / np.float32(255))
    np.testing.assert_allclose(color_to_linear(color)[..., :3], want, atol=4e-3)  # one byte step
    np.testing.assert_array_equal(color[0, 1], straight[0, 1])
    np.testing.assert_array_equal(color[0, 2], [0, 0, 0, 0])
    write_color(tmp_path / "b.png", color)
    with Image.open(tmp_path / "b.png") as image:
        back = np.array(image).astype(int)
    assert np.abs(back[0, :2] - straight[0, :2]).max() <= 1
    assert back[0, 2, 3] == 0


def test_opaque_alpha_changes_no_byte(rng: np.random.Generator, tmp_path: Path) -> None:
    color = rng.integers(0, 256, (5, 6, 4), dtype=np.uint8)
    color[..., 3] = 255
    for suffix in (".png", ".webp"):
        write_color(tmp_path / f"a{suffix}", color)
        back = read_color(tmp_path / f"a{suffix}")
        np.testing.assert_array_equal(back[..., :3], color[..., :3])
    assert premultiply(color) is color


def test_exr_alpha_is_premultiplied_already(tmp_path: Path) -> None:
    color = np.array([[[0.2, 0.1, 0.05, 0.5]]], dtype=np.float32)
    write_color(tmp_path / "a.exr", color)
    np.testing.assert_array_equal(read_color(tmp_path / "a.exr"), color)


# ---- rarer kinds -------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", ["1", "L", "P", "LA", "RGBA"])
def test_grey_and_palette_pictures_become_colour(tmp_path: Path, mode: str, pixels: U1) -> None:
    image = Image.fromarray(pixels).convert(mode)
    image.save(tmp_path / "a.png")
    back = read_color(tmp_path / "a.png")
    want = np.array(image.convert("RGBA" if "A" in mode else "RGB"))
    np.testing.assert_array_equal(back, want)


def test_a_palette_with_a_transparent_colour_has_four_channels(tmp_path: Path) -> None:
    image = Image.new("P", (2, 1))
    image.putpalette([10, 20, 30, 40, 50, 60])
    image.putpixel((1, 0), 1)
    image.save(tmp_path / "a.png", transparency=0)
    np.testing.assert_array_equal(
        read_color(tmp_path / "a.png"), [[[0, 0, 0, 0], [40, 50, 60, 255]]]
    )


def test_sixteen_bit_colour_keeps_its_upper_eight_bits(tmp_path: Path) -> None:
    rows = b"\x00" + struct.pack(">3H", 0x12FF, 0x8001, 0xFF00)
    (tmp_path / "a.png").write_bytes(png(1, 1, rows, bits=16, kind=2))
    np.testing.assert_array_equal(read_color(tmp_path / "a.png"), [[[0x12, 0x80, 0xFF]]])


def test_exif_orientation_is_not_applied(tmp_path: Path, pixels: U1) -> None:
    exif = Image.Exif()
    exif[0x0112] = 6  # a quarter turn
    Image.fromarray(pixels).save(tmp_path / "a.png", exif=exif)
    np.testing.assert_array_equal(read_color(tmp_path / "a.png"), pixels)


def test_the_contents_count_and_not_the_name(tmp_path: Path, pixels: U1) -> None:
    write_color(tmp_path / "a.png", pixels)
    (tmp_path / "a.png").rename(tmp_path / "b.jpg")
    np.testing.assert_array_equal(read_color(tmp_path / "b.jpg"), pixels)


@pytest.mark.parametrize(
    ("image", "name", "message"),
    [
        (Image.new("I;16", (2, 2)), "a.png", "16-bit grey and float are read as depth"),
        (Image.new("F", (2, 2)), "a.tif", "has pixels of the kind 'F'"),
        (Image.new("CMYK", (2, 2)), "a.jpg", "has pixels of the kind 'CMYK'.* convert it to sRGB"),
        (Image.new("LAB", (2, 2)), "a.tif", "has pixels of the kind 'LAB'"),
    ],
)
def test_pixels_whose_meaning_we_would_guess_are_refused(
    tmp_path: Path, image: Image.Image, name: str, message: str
) -> None:
    image.save(tmp_path / name)
    with pytest.raises(FileFormatError, match=message):
        read_color(tmp_path / name)


# ---- bad files ---------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("keep", [0.02, 0.5, 0.95])
def test_a_truncated_picture_is_named(
    tmp_path: Path, rng: np.random.Generator, suffix: str, keep: float
) -> None:
    path = save_any(tmp_path / f"a{suffix}", rng.integers(0, 256, (64, 64, 3), dtype=np.uint8))
    data = path.read_bytes()
    path.write_bytes(data[: max(20, int(len(data) * keep))])
    with pytest.raises(FileFormatError, match=r"truncated or corrupt .* copy or export it again"):
        read_color(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_an_empty_picture_is_named(tmp_path: Path, suffix: str) -> None:
    (tmp_path / f"a{suffix}").write_bytes(b"")
    with pytest.raises(FileFormatError, match=r"a\.\w+: is empty \(0 bytes\)"):
        read_color(tmp_path / f"a{suffix}")


def test_a_file_that_is_no_image_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_text("<html>not found</html>")
    with pytest.raises(FileFormatError, match=r"is not a PNG, JPEG, .*it starts with b'<html>no'"):
        read_color(tmp_path / "a.png")


def test_a_missing_picture_is_named(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"no image file .*a\.png"):
        read_color(tmp_path / "a.png")


def test_depth_is_not_colour(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.zeros((2, 2), np.float32))
    with pytest.raises(FileFormatError, match="holds NPY depth, expected a colour picture"):
        read_color(tmp_path / "a.npy")
    with pytest.raises(FileFormatError, match="expected a colour picture"):
        image_size(tmp_path / "a.npy")


def png(width: int, height: int, rows: bytes, bits: int = 8, kind: int = 2) -> bytes:
    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(
            ">I", zlib.crc32(name + data))  # fmt: skip

    header = struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows))
            + chunk(b"IEND", b""))  # fmt: skip


def huge_header(path: Path) -> None:
    """A small file whose header promises 10^9 pixels."""
    side = 31_623
    pixels = np.zeros((8, 8, 3), np.uint8)
    if path.suffix == ".png":
        path.write_bytes(png(side, side, b"\x00"))
        return
    save_any(path, pixels)
    data = bytearray(path.read_bytes())
    if path.suffix == ".jpg":
        at = data.index(b"\xff\xc0") + 5
        data[at : at + 4] = struct.pack(">HH", side, side)
    elif path.suffix == ".exr":
        for name in (b"dataWindow", b"displayWindow"):
            at = data.index(name + b"\x00box2i\x00") + len(name) + 7 + 4
            data[at : at + 16] = struct.pack("<4i", 0, 0, side - 1, side - 1)
    else:  # the entries of the directory for width and height: tag, type, count, value
        for tag in (256, 257):
            at = data.index(struct.pack("<H", tag), struct.unpack("<I", data[4:8])[0])
            data[at : at + 12] = struct.pack("<HHII", tag, 4, 1, side)
    path.write_bytes(bytes(data))


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".exr"])
def test_a_header_of_a_thousand_million_pixels_is_refused_undecoded(
    tmp_path: Path, suffix: str
) -> None:
    huge_header(tmp_path / f"a{suffix}")
    for read in (read_color, image_size):
        with pytest.raises(FileFormatError, match=r"its header says 31623 x 31623 pixels, more"):
            read(tmp_path / f"a{suffix}")


def test_a_million_pixels_wide_is_refused_too(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(png(1_000_000, 1000, b"\x00"))
    with pytest.raises(FileFormatError, match="its header says 1000000 x 1000 pixels"):
        read_color(tmp_path / "a.png")


def test_the_limit_holds_for_webp_as_well(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, pixels: U1
) -> None:
    write_color(tmp_path / "a.webp", pixels)
    monkeypatch.setattr(limits, "MAX_PIXELS", 100)
    with pytest.raises(FileFormatError, match="12 x 9 pixels, more than the 100"):
        read_color(tmp_path / "a.webp")


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif"])
def test_a_panorama_beyond_pillows_limit_is_read_and_the_users_limit_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    assert MAX_PIXELS >= 16384 * 8192
    Image.new("L", (400, 100)).save(tmp_path / f"a{suffix}")
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 10_000)  # the user's own choice
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert read_color(tmp_path / f"a{suffix}").shape == (100, 400, 3)
    assert Image.MAX_IMAGE_PIXELS == 10_000


def test_a_tiff_that_asks_to_be_turned_is_refused(tmp_path: Path, pixels: U1) -> None:
    Image.fromarray(pixels).save(tmp_path / "a.tif", tiffinfo={274: 6})
    with pytest.raises(FileFormatError, match=r"asks to be turned \(orientation 6\)"):
        read_color(tmp_path / "a.tif")


# ---- refusals of the writer --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "color", "message"),
    [
        ("a.bmp", np.zeros((2, 2, 3), np.uint8), "ends in '.bmp', expected one of"),
        ("a", np.zeros((2, 2, 3), np.uint8), "the suffix chooses the format"),
        ("a.png", np.zeros((2, 2), np.uint8), "repeat a grey image three times"),
        ("a.png", np.zeros((2, 2, 3), np.int32), "is int32, expected uint8"),
        ("a.jpg", np.zeros((2, 2, 4), np.uint8), "JPEG holds no alpha"),
    ],
)
def test_the_writer_refuses_what_it_cannot_write(
    tmp_path: Path, name: str, color: U1, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        write_color(tmp_path / name, color)
    assert list(tmp_path.iterdir()) == []


def test_a_missing_openexr_is_named_with_its_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_color(tmp_path / "a.exr", np.zeros((2, 2, 3), np.float32))
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    for attempt in (
        lambda: read_color(tmp_path / "a.exr"),
        lambda: write_color(tmp_path / "b.exr", np.zeros((2, 2, 3), np.float32)),
    ):
        with pytest.raises(MissingDependencyError, match=r"pip install 'belvedere\[exr\]'"):
            attempt()
    assert [path.name for path in tmp_path.iterdir()] == ["a.exr"]


def test_an_exr_of_other_channels_is_refused(tmp_path: Path) -> None:
    from belvedere.scene.io.exr import write_exr

    write_exr(tmp_path / "a.exr", {"Z": np.zeros((2, 3), np.float32)})
    with pytest.raises(FileFormatError, match="has the channels Z, expected R, G and B"):
        read_color(tmp_path / "a.exr")


def test_an_exr_cropped_to_its_data_window_is_refused(tmp_path: Path) -> None:
    write_color(tmp_path / "a.exr", np.zeros((4, 4, 3), np.float32))
    data = bytearray((tmp_path / "a.exr").read_bytes())
    at = data.index(b"displayWindow\x00box2i\x00") + 20 + 4
    data[at : at + 16] = struct.pack("<4i", 0, 0, 9, 9)
    (tmp_path / "a.exr").write_bytes(bytes(data))
    with pytest.raises(FileFormatError, match="data window is not its display window"):
        read_color(tmp_path / "a.exr")


@pytest.mark.skipif(find_spec("torch") is None, reason="torch is not installed")
@pytest.mark.parametrize("order", ["torch first", "torch last"])
def test_torch_may_be_imported_before_or_after_us(tmp_path: Path, order: str) -> None:
    ours = f"""
import numpy as np
from belvedere.scene.io import read_color, write_color, VideoWriter
for name in ("a.exr", "a.png"):
    write_color({str(tmp_path)!r} + "/" + name, np.full((4, 5, 3), 0.25, np.float32))
    assert read_color({str(tmp_path)!r} + "/" + name).shape == (4, 5, 3)
with VideoWriter({str(tmp_path / "a.mp4")!r}, 64, 48) as video:
    video.write(np.zeros((48, 64, 3), np.uint8))
"""
    theirs = "\nimport torch\nassert float((torch.ones(64, 64) @ torch.ones(64, 64)).sum()) > 0\n"
    code = theirs + ours if order == "torch first" else ours + theirs
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
