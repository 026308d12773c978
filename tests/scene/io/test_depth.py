"""Depth maps: stored numbers go in and come out; bad files are named."""

from __future__ import annotations

import struct
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from belvedere.ground.errors import FileFormatError, InputError, MissingFileError
from belvedere.scene.io.depth import (
    DEPTH_SUFFIXES,
    encode_colmap_depth,
    quantise_depth,
    read_depth_values,
    write_depth,
)

F4 = npt.NDArray[np.float32]
FLOAT_SUFFIXES = [suffix for suffix in DEPTH_SUFFIXES if suffix != ".png"]


@pytest.fixture
def depth(rng: np.random.Generator) -> F4:
    values = rng.uniform(0.1, 30, (7, 5)).astype(np.float32)
    values[0, 0], values[0, 1] = 0, np.inf
    return values


@pytest.mark.parametrize("suffix", FLOAT_SUFFIXES)
def test_float_depth_comes_back_bit_for_bit(tmp_path: Path, depth: F4, suffix: str) -> None:
    write_depth(tmp_path / f"a{suffix}", depth)
    back = read_depth_values(tmp_path / f"a{suffix}")
    assert back.dtype == np.float32
    np.testing.assert_array_equal(back, depth)


def test_sixteen_bits_come_back_exactly(tmp_path: Path, rng: np.random.Generator) -> None:
    stored = rng.integers(0, 65536, (6, 8), dtype=np.uint16)
    write_depth(tmp_path / "a.png", stored)
    np.testing.assert_array_equal(read_depth_values(tmp_path / "a.png"), stored)


def test_colmap_depth_comes_back_bit_for_bit(tmp_path: Path, depth: F4) -> None:
    (tmp_path / "a.geometric.bin").write_bytes(encode_colmap_depth(depth))
    np.testing.assert_array_equal(read_depth_values(tmp_path / "a.geometric.bin"), depth)


@pytest.mark.parametrize("dtype", ["<f8", ">f4", "<u2", "i4", "f2"])
def test_npy_of_any_number_type_is_read(tmp_path: Path, dtype: str) -> None:
    np.save(tmp_path / "a.npy", np.arange(6).reshape(2, 3, 1).astype(dtype))
    np.testing.assert_array_equal(read_depth_values(tmp_path / "a.npy"), [[0, 1, 2], [3, 4, 5]])


def test_pfm_of_either_byte_order_is_read_from_the_bottom_up(tmp_path: Path) -> None:
    for order, scale in (("<", b"-0.0039"), (">", b"1.0")):
        data = np.array([[3, 4], [1, 2]], dtype=f"{order}f4")  # the lower row comes first
        (tmp_path / "a.pfm").write_bytes(b"Pf\n2 2\n" + scale + b"\n" + data.tobytes())
        np.testing.assert_array_equal(read_depth_values(tmp_path / "a.pfm"), [[1, 2], [3, 4]])


def test_tiff_and_eight_bit_maps_are_read(tmp_path: Path) -> None:
    values = np.array([[1, 200]], dtype=np.uint8)
    Image.fromarray(values).save(tmp_path / "a.png")
    Image.fromarray(values.astype(np.uint16) * 100).save(tmp_path / "b.tif")
    np.testing.assert_array_equal(read_depth_values(tmp_path / "a.png"), [[1, 200]])
    np.testing.assert_array_equal(read_depth_values(tmp_path / "b.tif"), [[100, 20000]])


def test_exr_depth_is_found_in_the_usual_channels(tmp_path: Path) -> None:
    from belvedere.scene.io.exr import write_exr

    plane = np.full((2, 3), 4.0, np.float32)
    for channels in (["Z"], ["Y"], ["depth.Z", "R", "G", "B"], ["R", "G", "B"], ["odd"]):
        other = {name: plane if name != "G" else plane * 0 for name in channels}
        write_exr(tmp_path / "a.exr", other)
        np.testing.assert_array_equal(read_depth_values(tmp_path / "a.exr"), plane)
    write_exr(tmp_path / "a.exr", {"u": plane, "w": plane})
    with pytest.raises(FileFormatError, match="has the channels u, w, expected depth in Z"):
        read_depth_values(tmp_path / "a.exr")


# ---- quantising --------------------------------------------------------------------------------


def test_quantising_is_exact_to_half_a_step_and_keeps_holes_and_infinity() -> None:
    metres = np.array([[0.0, np.nan, np.inf, 1.2344, 65.534]])
    stored = quantise_depth(metres, 0.001)
    np.testing.assert_array_equal(stored, [[0, 0, 65535, 1234, 65534]])


@pytest.mark.parametrize(
    ("metres", "message"),
    [
        ([[70.0]], r"depth reaches 70 m, but 16 bits hold 65.534 m in steps of 0.001 m"),
        ([[65.535]], "use a larger step or a float depth format"),
        ([[0.0004]], r"as near as 0.0004 m, which steps of 0.001 m round to 0"),
    ],
)
def test_nothing_is_clipped_silently(metres: list[list[float]], message: str) -> None:
    with pytest.raises(InputError, match=message):
        quantise_depth(np.array(metres), 0.001)


@pytest.mark.parametrize("step", [0.0, -1.0, float("nan")])
def test_a_step_is_positive(step: float) -> None:
    with pytest.raises(InputError, match=r"quantise_depth\.step"):
        quantise_depth(np.ones((1, 1)), step)


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("a.bmp", np.zeros((2, 2), np.float32), "ends in '.bmp'"),
        ("a.png", np.zeros((2, 2), np.float32), "is float32 for .png, expected uint16"),
        ("a.exr", np.zeros((2, 2), np.uint16), "expected floating point metres"),
        ("a.exr", np.zeros((2, 2, 1), np.float32), "has shape"),
    ],
)
def test_the_writer_refuses_what_it_cannot_write(
    tmp_path: Path, name: str, values: F4, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        write_depth(tmp_path / name, values)


# ---- bad files ---------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [*DEPTH_SUFFIXES, ".bin"])
def test_a_truncated_map_is_named(tmp_path: Path, rng: np.random.Generator, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    values = rng.uniform(1, 9, (40, 40)).astype(np.float32)
    if suffix == ".bin":
        path.write_bytes(encode_colmap_depth(values))
    else:
        write_depth(path, quantise_depth(values, 0.001) if suffix == ".png" else values)
    path.write_bytes(path.read_bytes()[:-500])
    with pytest.raises(FileFormatError, match="truncated"):
        read_depth_values(path)


HUGE = 31_623


def npy_header(shape: str, descr: str = "'<f4'") -> bytes:
    text = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.png", b"", "is empty"),
        ("a.png", b"hello", "is not a PNG"),
        ("a.pfm", b"Pf\n31623 31623\n-1.0\n1234", "its header says 31623 x 31623 pixels, more"),
        ("a.pfm", b"Pf\n100 100\n-1.0\n1234", "promises 40000 bytes of pixels and 4 are there"),
        ("a.pfm", b"Pf\n0 5\n-1.0\n", "its header says 0 x 5 pixels"),
        ("a.pfm", b"Pf\n-3 5\n-1.0\n", "its header says -3 x 5 pixels"),
        ("a.pfm", b"Pf\n3 5\n", "PFM header is cut off"),
        ("a.pfm", b"Pf\nx 5\n-1.0\n", "expected width, height and scale"),
        ("a.pfm", b"Pf\n3 5\n0\n", "PFM scale is 0"),
        ("a.pfm", b"PF\n1 1\n-1.0\n" + bytes(12), "is a colour PFM, expected one channel"),
        ("a.npy", npy_header("(31623, 31623)"), "its header says 31623 x 31623 pixels, more"),
        ("a.npy", npy_header("(10, 10)"), "promises 400 bytes of pixels and 0 are there"),
        ("a.npy", npy_header("(4,)"), r"holds float32 of shape \(4,\), expected"),
        ("a.npy", npy_header("(2, 2)", "'|O'"), r"holds Python objects \(pickle\)"),
        ("a.npy", npy_header("(2, 2)", "'<U3'"), "holds <U3 of shape"),
        ("a.npy", npy_header("(2, -2)"), "its header says -2 x 2 pixels"),
        ("a.npy", b"\x93NUMPY\x01\x00\x05\x00{abc\n", "NPY header is corrupt"),
        ("a.npy", b"\x93NUMPY\x09\x00\x05\x00{abc\n", "NPY header is corrupt"),
        ("a.npy", b"\x93NUMPY", "NPY header is corrupt"),
        ("a.bin", b"31623&31623&1&", "its header says 31623 x 31623 pixels, more"),
        ("a.bin", b"2&2&3&" + bytes(48), "has 3 channels"),
        ("a.bin", b"2&x&1&" + bytes(48), "is no COLMAP depth map"),
    ],
)
def test_a_file_that_lies_is_refused_before_its_pixels_are_read(
    tmp_path: Path, name: str, data: bytes, message: str
) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(FileFormatError, match=message) as caught:
        read_depth_values(tmp_path / name)
    assert name in str(caught.value)


def test_a_pickle_in_an_npy_file_is_never_loaded(tmp_path: Path) -> None:
    class Bomb:
        def __reduce__(self) -> tuple[object, tuple[str]]:
            return sys.exit, ("a pickle was loaded",)

    array = np.empty((1, 1), dtype=object)
    array[0, 0] = Bomb()
    np.save(tmp_path / "a.npy", array, allow_pickle=True)
    with pytest.raises(FileFormatError, match="which belvedere never loads"):
        read_depth_values(tmp_path / "a.npy")


def test_a_colour_picture_is_no_depth(tmp_path: Path) -> None:
    Image.new("RGB", (3, 2)).save(tmp_path / "a.png")
    with pytest.raises(FileFormatError, match=r"expected one channel of depth .* colour picture"):
        read_depth_values(tmp_path / "a.png")


def test_a_missing_map_is_named(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"a\.png"):
        read_depth_values(tmp_path / "a.png")
