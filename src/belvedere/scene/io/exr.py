"""OpenEXR: linear float images and depth, through the `OpenEXR` wheel (extra ``exr``).

Channels are read by name: R, G, B and A (premultiplied, as OpenEXR defines it), or Y for grey;
depth from Z. Half floats become float32.
"""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import FileFormatError, MissingDependencyError
from belvedere.scene.io.limits import check_pixel_count

F4 = npt.NDArray[np.float32]
DEPTH_CHANNELS = ("Z", "depth.Z", "Depth.Z", "depth.V", "Depth.V", "Y", "V", "R")
"""Where depth is looked for, in this order. R: tools without a depth channel write grey RGB."""


def exr_module() -> Any:
    """The `OpenEXR` package.

    Raises:
        MissingDependencyError: it is not installed.
    """
    try:
        import OpenEXR
    except ImportError as error:
        raise MissingDependencyError.for_extra(
            "OpenEXR", "exr", "read and write .exr files"
        ) from error
    return OpenEXR


def exr_size(path: Path) -> tuple[int, int]:
    """``(width, height)`` by the header, within our limit; no pixel is decoded.

    Raises:
        FileFormatError: corrupt, too large, or stored in a window that is not the whole picture.
    """
    openexr = exr_module()
    try:
        with openexr.File(str(path), header_only=True, num_threads=0) as file:
            header = file.header()
            data, display = header["dataWindow"], header["displayWindow"]
    except Exception as error:  # the wheel raises RuntimeError, ValueError and its own
        raise _broken(path, error) from error
    low, high = (np.asarray(corner, dtype=np.int64) for corner in data)
    width, height = (int(side) for side in high - low + 1)
    check_pixel_count(path, width, height)
    if any(np.any(np.asarray(a) != np.asarray(b)) for a, b in zip(data, display, strict=True)):
        raise FileFormatError(
            f"{path}: its data window is not its display window, so its pixels are only a part of "
            "the picture: export it uncropped"
        )
    return width, height


def read_exr_channels(path: Path) -> dict[str, F4]:
    """Every channel as (H, W) float32, by name.

    Raises:
        FileFormatError: truncated, corrupt, too large, or with subsampled channels.
    """
    width, height = exr_size(path)
    openexr = exr_module()
    try:
        with openexr.File(str(path), separate_channels=True, num_threads=0) as file:
            pixels = {name: np.array(c.pixels) for name, c in file.channels().items()}
    except Exception as error:  # as above
        raise _broken(path, error) from error
    for name, values in pixels.items():
        if values.shape != (height, width):
            raise FileFormatError(
                f"{path}: channel {name!r} has {values.shape[::-1]} samples for {(width, height)} "
                "pixels: export it without subsampling"
            )
    return {name: values.astype(np.float32) for name, values in pixels.items()}


def read_exr_color(path: Path) -> F4:
    """(H, W, 3|4) linear colour.

    Raises:
        FileFormatError: as `read_exr_channels`, or neither R, G, B nor Y are there.
    """
    channels = read_exr_channels(path)
    names = ["R", "G", "B"] if "R" in channels else ["Y", "Y", "Y"]
    if any(name not in channels for name in names):
        raise FileFormatError(
            f"{path}: has the channels {', '.join(sorted(channels))}, expected R, G and B, or Y: "
            "export the beauty layer alone"
        )
    if "A" in channels:
        names.append("A")
    return np.stack([channels[name] for name in names], axis=-1)


def read_exr_depth(path: Path) -> F4:
    """(H, W) depth in stored units, from the first of `DEPTH_CHANNELS` that is there.

    Raises:
        FileFormatError: as `read_exr_channels`, or no channel holds depth.
    """
    channels = read_exr_channels(path)
    for name in DEPTH_CHANNELS:
        if name in channels:
            return channels[name]
    if len(channels) == 1:
        return next(iter(channels.values()))
    raise FileFormatError(
        f"{path}: has the channels {', '.join(sorted(channels))}, expected depth in Z"
    )


def write_exr(path: Path, channels: dict[str, F4]) -> None:
    """Write (H, W) float32 channels, ZIP-compressed (lossless). ``path`` is replaced.

    Raises:
        OSError: the file cannot be written; `atomic_write` says it in our words.
        MissingDependencyError: OpenEXR is not installed.
    """
    openexr = exr_module()
    header = {"compression": openexr.ZIP_COMPRESSION, "type": openexr.scanlineimage}
    arrays = {name: np.ascontiguousarray(v, dtype=np.float32) for name, v in channels.items()}
    try:
        with openexr.File(header, arrays, num_threads=0) as file:
            file.write(os.fspath(path))
    except RuntimeError as error:  # the wheel keeps the system's reason in its text alone
        reasons = (errno.ENOSPC, errno.EROFS, errno.EACCES, errno.EFBIG)
        number = next((n for n in reasons if os.strerror(n) in str(error)), errno.EIO)
        reason = _line(error) if number == errno.EIO else os.strerror(number)
        raise OSError(number, reason) from error


def _broken(path: Path, error: Exception) -> FileFormatError:
    return FileFormatError(
        f"{path}: is truncated or corrupt OpenEXR ({_line(error)}): copy or export it again"
    )


def _line(error: Exception) -> str:
    return (str(error).strip() or type(error).__name__).split("\n")[0]
