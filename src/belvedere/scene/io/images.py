"""Colour pictures in files.

Pixels come as they are stored: EXIF orientation is not applied, because calibrations speak of the
stored grid, and colour profiles are not: bytes are taken as sRGB. The format is told by the first
bytes, not by the name. What becomes of the rarer kinds:

=====================  =========================================================================
grey, black and white  repeated to three channels
palette                looked up; four channels when a colour of it is transparent
alpha                  files hold it straight; it is premultiplied in linear light when read and
                       divided out when written (exact where alpha is 255 or 0)
16-bit RGB PNG         the upper eight bits of each channel
16-bit grey, float     refused as colour: that is how depth is stored (see `read_depth_values`)
CMYK, Lab              refused
animations             the first picture
TIFF to be turned      refused (orientation other than 1)
=====================  =========================================================================
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import color_to_linear, color_to_srgb8, encode_srgb8
from belvedere.ground.errors import FileFormatError, InputError
from belvedere.scene.io.atomic import atomic_write, write_bytes
from belvedere.scene.io.exr import exr_size, read_exr_color, write_exr
from belvedere.scene.io.limits import sniff
from belvedere.scene.io.pillow import header_size, open_image
from belvedere.scene.view import Color, check_color

COLOR_SUFFIXES = (".png", ".jpg", ".jpeg", ".webp", ".exr", ".tif", ".tiff")
"""File names that may hold colour."""
_WRITABLE = (".png", ".jpg", ".jpeg", ".webp", ".exr")
JPEG_QUALITY = 95


def read_color(path: str | Path) -> Color:
    """Read a colour picture: PNG, JPEG, WebP, TIFF or OpenEXR.

    Args:
        path: the file.

    Returns:
        (H, W, 3) or, with transparency, (H, W, 4) premultiplied; ``uint8`` sRGB, or ``float32``
        linear radiance for OpenEXR.

    Raises:
        MissingFileError: there is no such file.
        FileFormatError: empty, truncated, corrupt, larger than `MAX_PIXELS`, or no colour.
        MissingDependencyError: an OpenEXR file without the extra ``exr``.
    """
    file = Path(path)
    kind = sniff(file)
    if kind == "exr":
        return read_exr_color(file)
    if kind in ("pfm", "npy", "colmap"):
        raise FileFormatError(f"{file}: holds {kind.upper()} depth, expected a colour picture")
    with open_image(file, kind) as image:
        mode = image.mode
        transparent = "A" in mode or "a" in mode or "transparency" in image.info
        if mode not in ("1", "L", "LA", "La", "P", "PA", "RGB", "RGBA", "RGBa", "RGBX"):
            raise FileFormatError(
                f"{file}: has pixels of the kind {mode!r}, expected 8-bit grey, palette, RGB or "
                "RGBA colour: convert it to sRGB"
                + (" (16-bit grey and float are read as depth)" if mode[0] in "IF" else "")
            )
        if mode in ("La", "RGBa"):  # associated alpha, as some TIFFs have: already premultiplied
            return np.array(image.convert("RGBa") if mode == "La" else image)
        pixels = np.array(image.convert("RGBA" if transparent else "RGB"))
    return premultiply(pixels) if transparent else pixels


def image_size(path: str | Path) -> tuple[int, int]:
    """``(width, height)`` of a colour picture by its header; no pixel is decoded.

    Raises:
        MissingFileError, FileFormatError: as `read_color`.
    """
    file = Path(path)
    kind = sniff(file)
    if kind == "exr":
        return exr_size(file)
    if kind in ("pfm", "npy", "colmap"):
        raise FileFormatError(f"{file}: holds {kind.upper()} depth, expected a colour picture")
    return header_size(file, kind)


def write_color(path: str | Path, color: npt.NDArray[Any], *, force: bool = True) -> None:
    """Write a colour picture atomically: PNG, lossless WebP, JPEG (quality 95) or OpenEXR.

    Args:
        path: the suffix chooses the format.
        color: (H, W, 3|4) ``uint8`` sRGB or ``float32`` linear, alpha premultiplied. Linear colour
            is clipped to [0, 1] and encoded for the 8-bit formats; bytes are decoded for OpenEXR.
        force: replace an existing file.

    Raises:
        InputError: another suffix, shape or type; alpha in a JPEG.
        OutputError: see `atomic_write`.
        MissingDependencyError: OpenEXR without the extra ``exr``.
    """
    file = Path(path)
    suffix = file.suffix.lower()
    if suffix not in _WRITABLE:
        raise InputError(
            f"{file} ends in {file.suffix!r}, expected one of {', '.join(_WRITABLE)}: the suffix "
            "chooses the format"
        )
    pixels = check_color("write_color", color, np.asarray(color).shape[:2])
    if suffix == ".exr":
        linear = color_to_linear(pixels)
        names = "RGBA"[: linear.shape[2]]
        with atomic_write(file, force=force) as temporary:
            write_exr(temporary, {name: linear[..., i] for i, name in enumerate(names)})
        return
    if suffix in (".jpg", ".jpeg") and pixels.shape[2] == 4:
        raise InputError(f"{file}: JPEG holds no alpha: write .png or .webp, or drop the channel")
    write_bytes(file, encode_picture(pixels, suffix), force=force)


def encode_picture(pixels: Color, suffix: str) -> bytes:
    """The bytes of a PNG, WebP or JPEG file holding (H, W, 3|4) colour; the same every time."""
    from PIL import Image

    encoded = unpremultiply(pixels) if pixels.shape[2] == 4 else color_to_srgb8(pixels)
    picture = Image.fromarray(np.ascontiguousarray(encoded))
    buffer = io.BytesIO()
    if suffix == ".png":
        picture.save(buffer, "PNG", compress_level=6)
    elif suffix == ".webp":
        picture.save(buffer, "WEBP", lossless=True, exact=True, quality=70, method=4)
    else:
        picture.save(buffer, "JPEG", quality=JPEG_QUALITY, subsampling=0)
    return buffer.getvalue()


def premultiply(straight: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """(H, W, 4) bytes with straight alpha, premultiplied in linear light."""
    alpha = straight[..., 3]
    if bool((alpha == 255).all()):
        return straight
    linear = color_to_linear(straight)
    out = straight.copy()
    scaled = encode_srgb8(linear[..., :3] * linear[..., 3:])
    np.copyto(out[..., :3], scaled, where=(alpha != 255)[..., None])
    return out


def unpremultiply(color: Color) -> npt.NDArray[np.uint8]:
    """(H, W, 4) premultiplied colour as ``uint8`` sRGB with straight alpha, as files hold it."""
    linear = color_to_linear(color)
    alpha = linear[..., 3:]
    straight = np.divide(linear[..., :3], alpha, out=np.zeros_like(linear[..., :3]),
                         where=alpha > 0)  # fmt: skip
    out = color_to_srgb8(np.concatenate([straight, alpha], axis=-1))
    if color.dtype == np.uint8:
        np.copyto(out[..., :3], color[..., :3], where=(color[..., 3:] == 255))
    return out
