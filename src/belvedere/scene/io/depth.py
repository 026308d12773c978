"""Depth maps in files: 16-bit PNG, PFM, OpenEXR, NPY, TIFF, COLMAP's own.

These functions move stored numbers and know no units: what a number means is for `Conventions`.
NPY files are read without pickle.
"""

from __future__ import annotations

import io
import math
from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_number, check_shape
from belvedere.ground.errors import FileFormatError, InputError
from belvedere.scene.io.atomic import atomic_write, write_bytes
from belvedere.scene.io.exr import read_exr_depth, write_exr
from belvedere.scene.io.limits import check_pixel_count, sniff
from belvedere.scene.io.pillow import open_image

F4 = npt.NDArray[np.float32]
DEPTH_SUFFIXES = (".png", ".pfm", ".exr", ".npy", ".tif", ".tiff")
INFINITY_CODE = 65535
"""Stored value of "infinitely far" in our 16-bit depth; finite depth goes up to 65534."""


def read_depth_values(path: str | Path) -> F4:
    """The stored numbers of a depth map, unscaled.

    Args:
        path: PNG or TIFF (8 or 16 bits, or float, one channel), PFM (grey; the magnitude of its
            scale is ignored, its sign is the byte order), OpenEXR (channel Z), NPY (two axes),
            or COLMAP's ``.geometric.bin``.

    Returns:
        (H, W) float32; 0, NaN and infinities as stored.

    Raises:
        MissingFileError: there is no such file.
        FileFormatError: empty, truncated, corrupt, larger than `MAX_PIXELS`, or of another kind.
    """
    file = Path(path)
    kind = sniff(file)
    if kind == "exr":
        return read_exr_depth(file)
    if kind == "pfm":
        return _read_pfm(file)
    if kind == "npy":
        return _read_npy(file)
    if kind == "colmap":
        return _read_colmap(file)
    with open_image(file, kind) as image:
        if image.mode not in ("L", "I", "I;16", "I;16B", "I;16L", "F"):
            raise FileFormatError(
                f"{file}: has pixels of the kind {image.mode!r}, expected one channel of depth "
                "(16-bit grey): is this the colour picture, or depth painted for the eye?"
            )
        return np.array(image, dtype=np.float32)


def write_depth(path: str | Path, values: npt.NDArray[Any], *, force: bool = True) -> None:
    """Write a depth map's stored numbers atomically.

    Args:
        path: ``.png`` (16 bits), ``.pfm``, ``.exr`` (channel Z), ``.npy`` or ``.tif`` (float32).
        values: (H, W); ``uint16`` for PNG (see `quantise_depth`), floating point otherwise.
        force: replace an existing file.

    Raises:
        InputError: another suffix, shape or type.
        OutputError: see `atomic_write`.
    """
    file, array = Path(path), np.asarray(values)
    check_shape("write_depth", "values", array, (None, None))
    suffix = file.suffix.lower()
    if suffix not in DEPTH_SUFFIXES:
        raise InputError(
            f"{file} ends in {file.suffix!r}, expected one of {', '.join(DEPTH_SUFFIXES)}"
        )
    if (array.dtype == np.uint16) != (suffix == ".png"):
        raise InputError(
            f"write_depth.values is {array.dtype} for {suffix}, expected "
            + ("uint16: see quantise_depth" if suffix == ".png" else "floating point metres")
        )
    if suffix == ".exr":
        with atomic_write(file, force=force) as temporary:
            write_exr(temporary, {"Z": array})
        return
    write_bytes(file, _encode_depth(array, suffix), force=force)


def quantise_depth(
    depth: npt.NDArray[Any], step: float, advice: str | None = None
) -> npt.NDArray[np.uint16]:
    """Depth in metres as 16-bit numbers: 0 no sample, `INFINITY_CODE` infinitely far.

    Args:
        depth: (H, W) metres; NaN and 0 no sample, infinity infinitely far.
        step: metres per number.
        advice: what helps where depth does not fit; None: another step or a float format.

    Raises:
        InputError: a depth lies beyond 65534 steps (nothing is clipped), or rounds to 0.
    """
    check_number("quantise_depth", "step", step, 0.0, open_low=True)
    values = np.asarray(depth, dtype=np.float64)
    known = np.isfinite(values) & (values > 0)
    steps = np.rint(np.where(known, values, 0.0) / step)
    if steps.max(initial=0) > INFINITY_CODE - 1:
        raise InputError(
            f"depth reaches {values[known].max():.6g} m, but 16 bits hold "
            f"{(INFINITY_CODE - 1) * step:.6g} m in steps of {step:g} m: "
            + (advice or "use a larger step or a float depth format (exr, pfm, npy)")
        )
    if bool((steps[known] == 0).any()):
        raise InputError(
            f"depth comes as near as {values[known].min():.3g} m, which steps of {step:g} m round "
            "to 0 (no sample): "
            + (advice or "use a smaller step or a float depth format (exr, pfm, npy)")
        )
    steps[np.isposinf(values)] = INFINITY_CODE
    return steps.astype(np.uint16)


def _encode_depth(array: npt.NDArray[Any], suffix: str) -> bytes:
    buffer = io.BytesIO()
    if suffix == ".npy":
        np.save(buffer, np.ascontiguousarray(array, dtype="<f4"), allow_pickle=False)
    elif suffix == ".pfm":
        height, width = array.shape
        buffer.write(f"Pf\n{width} {height}\n-1.0\n".encode())
        buffer.write(np.ascontiguousarray(array[::-1], dtype="<f4").tobytes())
    else:
        from PIL import Image

        whole = suffix == ".png"
        picture = Image.fromarray(np.ascontiguousarray(array, np.uint16 if whole else np.float32))
        picture.save(buffer, "PNG" if whole else "TIFF")
    return buffer.getvalue()


def _read_pfm(file: Path) -> F4:
    with file.open("rb") as stream:
        head = stream.read(256)
        words: list[bytes] = []
        place = 0
        while len(words) < 4:  # "Pf", width, height, scale: blanks of any kind between
            start = place + len(head[place:]) - len(head[place:].lstrip())
            end = start
            while end < len(head) and not head[end : end + 1].isspace():
                end += 1
            if end >= len(head):
                raise FileFormatError(f"{file}: its PFM header is cut off: export it again")
            words.append(head[start:end])
            place = end
        try:
            width, height, scale = int(words[1]), int(words[2]), float(words[3])
        except ValueError:
            raise FileFormatError(
                f"{file}: its PFM header has {b' '.join(words[1:])!r}, expected width, height and "
                "scale"
            ) from None
        if words[0] == b"PF":
            raise FileFormatError(f"{file}: is a colour PFM, expected one channel (Pf) of depth")
        if scale == 0 or not math.isfinite(scale):
            raise FileFormatError(f"{file}: its PFM scale is {scale:g}, expected -1.0 or 1.0")
        check_pixel_count(file, width, height)
        offset = place + 1
        _check_bytes(file, offset, width * height * 4)
        stream.seek(offset)
        data = np.fromfile(stream, dtype="<f4" if scale < 0 else ">f4", count=width * height)
    return data.reshape(height, width)[::-1].astype(np.float32)


def _read_npy(file: Path) -> F4:
    with file.open("rb") as stream:
        try:
            version = np.lib.format.read_magic(stream)
            reader = {
                (1, 0): np.lib.format.read_array_header_1_0,
                (2, 0): np.lib.format.read_array_header_2_0,
            }.get(version)
            if reader is None:
                raise ValueError(f"version {version}")
            shape, _, dtype = reader(stream)
        except (ValueError, TypeError, EOFError, SyntaxError, TokenError) as error:
            raise FileFormatError(
                f"{file}: its NPY header is corrupt ({str(error).splitlines()[0]}): save it again"
            ) from None
        if dtype.hasobject:
            raise FileFormatError(
                f"{file}: holds Python objects (pickle), which belvedere never loads: save it as "
                "an array of float32"
            )
        if len(shape) == 3 and shape[2] == 1:
            shape = shape[:2]
        if len(shape) != 2 or dtype.kind not in "fui":
            raise FileFormatError(
                f"{file}: holds {dtype} of shape {tuple(shape)}, expected (height, width) numbers"
            )
        check_pixel_count(file, shape[1], shape[0])
        _check_bytes(file, stream.tell(), shape[0] * shape[1] * dtype.itemsize)
        stream.seek(0)
        return np.load(stream, allow_pickle=False).reshape(shape).astype(np.float32)


def _read_colmap(file: Path) -> F4:
    with file.open("rb") as stream:
        head = stream.read(64)
        parts = head.split(b"&", 3)
        try:
            width, height, channels = (int(part) for part in parts[:3])
        except ValueError:
            raise FileFormatError(f"{file}: is no COLMAP depth map ({head[:16]!r})") from None
        check_pixel_count(file, width, height)
        if channels != 1:
            raise FileFormatError(f"{file}: has {channels} channels (normals?), expected 1: depth")
        offset = sum(len(part) + 1 for part in parts[:3])
        _check_bytes(file, offset, width * height * 4)
        stream.seek(offset)
        return np.fromfile(stream, dtype="<f4", count=width * height).reshape(height, width)


def encode_colmap_depth(depth: F4) -> bytes:
    """The bytes of COLMAP's depth map file for (H, W) metres, 0 where there is no sample."""
    height, width = depth.shape
    return f"{width}&{height}&1&".encode() + np.ascontiguousarray(depth, dtype="<f4").tobytes()


def _check_bytes(file: Path, offset: int, wanted: int) -> None:
    have = file.stat().st_size - offset
    if have < wanted:
        raise FileFormatError(
            f"{file}: is truncated: its header promises {wanted} bytes of pixels and {have} are "
            "there: copy or export it again"
        )
