"""How large an image may claim to be, and what kind of file one really is.

Checked from the header, before any pixel is decoded, for every format.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from belvedere.ground.errors import FileFormatError, MissingFileError

MAX_PIXELS = 1 << 28
"""Pixels of the largest image we read: 268 million. A 16384 x 8192 panorama has half as many;
what claims more is taken for a broken or hostile header (a decompression bomb)."""

ImageFormat = Literal["png", "jpeg", "webp", "tiff", "exr", "pfm", "npy", "colmap"]


def check_pixel_count(path: str | Path, width: int, height: int) -> None:
    """Refuse an image by the size in its header.

    Raises:
        FileFormatError: a side below 1 or more than `MAX_PIXELS` pixels.
    """
    if width < 1 or height < 1:
        raise FileFormatError(f"{path}: its header says {width} x {height} pixels: write it again")
    if width * height > MAX_PIXELS:
        raise FileFormatError(
            f"{path}: its header says {width} x {height} pixels, more than the {MAX_PIXELS} "
            "belvedere reads: the file is broken, or reduce the image"
        )


def sniff(path: str | Path) -> ImageFormat:
    """The format of an image file by its first bytes; its name does not count.

    Raises:
        MissingFileError: there is no such file.
        FileFormatError: empty, or none of the formats we read.
    """
    file = Path(path)
    if not file.is_file():
        raise MissingFileError(f"no image file {file}: check the name")
    with file.open("rb") as stream:
        head = stream.read(64)
    return sniff_bytes(head, file)


def sniff_bytes(head: bytes, file: str | Path) -> ImageFormat:
    """The format of an image by its first 64 bytes; ``file`` is its name for messages.

    Raises:
        FileFormatError: empty, or none of the formats we read.
    """
    if not head:
        raise FileFormatError(f"{file}: is empty (0 bytes): copy or export it again")
    for magic, name in _MAGIC.items():
        if head.startswith(magic):
            return name
    if head[:4] == b"RIFF" and head[8:12] == b"WEBP":
        return "webp"
    if head[:2] in (b"PF", b"Pf") and head[2:3].isspace():
        return "pfm"
    if head[:1].isdigit() and head.count(b"&") >= 3:
        return "colmap"
    raise FileFormatError(
        f"{file}: is not a PNG, JPEG, WebP, TIFF, OpenEXR, PFM or NPY image (it starts with "
        f"{head[:8]!r}): export it as one of these"
    )


_MAGIC: dict[bytes, ImageFormat] = {
    b"\x89PNG\r\n\x1a\n": "png",
    b"\xff\xd8\xff": "jpeg",
    b"II*\x00": "tiff",
    b"MM\x00*": "tiff",
    b"\x76\x2f\x31\x01": "exr",
    b"\x93NUMPY": "npy",
}
