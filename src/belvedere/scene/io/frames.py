"""A rendered frame as a picture file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from belvedere.ground.checks import check_path
from belvedere.ground.color import color_to_linear, color_to_srgb8
from belvedere.ground.errors import InputError
from belvedere.scene.io.atomic import atomic_write, require_free, write_bytes
from belvedere.scene.io.exr import write_exr
from belvedere.scene.io.images import encode_picture, premultiply, unpremultiply
from belvedere.scene.view import Color, Frame

FRAME_SUFFIXES = (".png", ".webp", ".jpg", ".jpeg", ".exr")


def save_frame(frame: Frame, path: str | Path, *, alpha: bool = False, force: bool = False) -> Path:
    """Save a frame as a picture; the suffix chooses the format.

    * ``.png``, ``.webp`` (lossless), ``.jpg`` (quality 95): 8-bit sRGB colour, holes black as the
      frame has them. Linear colour is clipped to [0, 1].
    * ``.exr``: float32 linear R, G, B (and A), ``Z`` = 1 / disparity in metres (0 in holes,
      infinity for infinitely far) and ``coverage``.

    Args:
        frame: what a scene rendered.
        path: the file; missing folders are made.
        alpha: make holes transparent (PNG and WebP): alpha is the coverage.
        force: replace an existing file.

    Returns:
        The file written.

    Raises:
        OutputError: it exists without ``force``; disk full, read-only.
        InputError: no frame, no path or another suffix; ``alpha`` for a format that has none or
            ``.exr``.
        MissingDependencyError: OpenEXR without the extra ``exr``.
    """
    if not isinstance(frame, Frame):
        raise InputError(
            f"save_frame.frame is a {type(frame).__name__}, expected a Frame: what a scene's "
            "render() or belvedere.warp() gives"
        )
    file = check_path("save_frame", "path", path)
    suffix = file.suffix.lower()
    if suffix not in FRAME_SUFFIXES:
        raise InputError(
            f"{file} ends in {file.suffix!r}, expected one of {', '.join(FRAME_SUFFIXES)}: the "
            "suffix chooses the format"
        )
    if alpha and suffix not in (".png", ".webp"):
        raise InputError(
            f"{file}: save_frame.alpha is for .png and .webp"
            + (": .exr holds the coverage as a channel anyway" if suffix == ".exr" else "")
        )
    require_free(file, force)
    if suffix == ".exr":
        with atomic_write(file, force=force) as temporary:
            write_exr(temporary, frame_channels(frame))
        return file
    color = _with_coverage(frame) if alpha else frame.color
    if suffix in (".jpg", ".jpeg"):
        color = color[..., :3]  # premultiplied: over black
    write_bytes(file, encode_picture(color, suffix), force=force)
    return file


def frame_channels(frame: Frame) -> dict[str, np.ndarray]:
    """A frame's OpenEXR channels, each (H, W) float32."""
    linear = color_to_linear(frame.color)
    with np.errstate(divide="ignore"):
        depth = np.float32(1.0) / frame.disparity
    channels = {name: linear[..., i] for i, name in enumerate("RGBA"[: linear.shape[2]])}
    channels["Z"] = np.where(np.isnan(depth), np.float32(0), depth)
    channels["coverage"] = frame.coverage
    return channels


def _with_coverage(frame: Frame) -> Color:
    """(H, W, 4) premultiplied bytes whose alpha is the coverage (times the frame's own alpha)."""
    if frame.color.shape[2] == 4:
        straight = unpremultiply(frame.color)
        own = straight[..., 3] / np.float32(255.0)
    else:
        straight = color_to_srgb8(frame.color)
        own = np.float32(1.0)
    coverage = np.rint(np.clip(frame.coverage * own, 0.0, 1.0) * 255.0).astype(np.uint8)
    return premultiply(np.concatenate([straight[..., :3], coverage[..., None]], axis=-1))
