"""Pillow behind our own pixel limit.

Pillow's guard against decompression bombs is a global of the process: it warns above 89 million
pixels and refuses at twice that, which a legitimate panorama exceeds. Files are therefore opened
by the plugin class of the format, which reads the header and knows no limit; ours is checked
then, and the user's global stays as it is.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from belvedere.ground.errors import FileFormatError
from belvedere.scene.io.limits import ImageFormat, check_pixel_count

if TYPE_CHECKING:
    from PIL.Image import Image

_ORIENTATION = 274
"""The TIFF tag that says how to turn a picture."""


@contextlib.contextmanager
def open_image(path: Path, kind: ImageFormat) -> Iterator[Image]:
    """A decoded Pillow image whose header has been checked. Its first picture, if it holds more.

    Raises:
        FileFormatError: too large, truncated, corrupt.
    """
    with path.open("rb") as stream:
        yield decode_image(path, kind, stream)


def decode_image(path: str | Path, kind: ImageFormat, stream: object) -> Image:
    """A decoded Pillow image out of an open stream; ``path`` is its name for messages.

    Raises:
        FileFormatError: too large, truncated, corrupt.
    """
    image = _plugin(path, kind, stream)
    check_pixel_count(path, *image.size)
    _check_upright(path, image)
    try:
        if kind == "tiff":
            from PIL.Image import core

            # room for the pixels, or the TIFF plugin asks Pillow's own limit before making it
            image.im = core.new(image.mode, image.size)
        image.load()
    except Exception as error:  # decoders of foreign bytes raise nearly anything
        raise _broken(path, kind, error) from error
    return image


def header_size(path: Path, kind: ImageFormat) -> tuple[int, int]:
    """``(width, height)`` by the header, within our limit; no pixel is decoded."""
    with path.open("rb") as stream:
        size = _plugin(path, kind, stream).size
    check_pixel_count(path, *size)
    return size


def _plugin(path: str | Path, kind: ImageFormat, stream: object) -> Image:
    from PIL import JpegImagePlugin, PngImagePlugin, TiffImagePlugin, WebPImagePlugin

    plugins = {
        "png": PngImagePlugin.PngImageFile,
        "jpeg": JpegImagePlugin.JpegImageFile,
        "webp": WebPImagePlugin.WebPImageFile,
        "tiff": TiffImagePlugin.TiffImageFile,
    }
    try:
        return plugins[kind](stream)
    except Exception as error:  # as above
        raise _broken(path, kind, error) from error


def _check_upright(path: str | Path, image: Image) -> None:
    """Refuse a TIFF that asks to be turned: Pillow would turn it, and K is for stored pixels."""
    tags = getattr(image, "tag_v2", None)
    if tags is not None and tags.get(_ORIENTATION, 1) != 1:
        raise FileFormatError(
            f"{path}: asks to be turned (orientation {tags[_ORIENTATION]}): save it upright, so "
            "that its pixels are where its camera has them"
        )


def _broken(path: str | Path, kind: ImageFormat, error: BaseException) -> FileFormatError:
    names = {"png": "PNG", "jpeg": "JPEG", "webp": "WebP", "tiff": "TIFF"}
    reason = str(error).split("\n")[0] or type(error).__name__
    return FileFormatError(
        f"{path}: is truncated or corrupt {names[kind]} ({reason}): copy or export it again"
    )
