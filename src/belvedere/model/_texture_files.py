"""Pictures that models name or carry, as textures."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import SRGB8_TO_LINEAR
from belvedere.ground.errors import FileFormatError
from belvedere.scene.io.limits import sniff_bytes
from belvedere.scene.io.pillow import decode_image


@dataclass(frozen=True, slots=True, eq=False)
class TextureFile:
    """A decoded picture."""

    color: npt.NDArray[np.uint8]
    """(H, W, 3) sRGB, as stored: never multiplied by alpha."""
    opacity: float
    """Mean alpha in [0, 1]; 1 without an alpha channel."""

    @property
    def mean(self) -> npt.NDArray[np.float64]:
        """(3,) mean linear color."""
        return np.array([SRGB8_TO_LINEAR[self.color[..., k]].mean() for k in range(3)], np.float64)


def decode_texture(data: bytes | memoryview, name: str) -> TextureFile:
    """Decode a PNG, JPEG, WebP or TIFF.

    Args:
        data: the whole file.
        name: what messages call it.

    Raises:
        FileFormatError: empty, none of these formats, truncated, too large, no 8-bit color.
    """
    kind = sniff_bytes(bytes(data[:64]), name)
    if kind not in ("png", "jpeg", "webp", "tiff"):
        raise FileFormatError(f"{name}: is {kind}, expected a PNG, JPEG, WebP or TIFF texture")
    with decode_image(name, kind, io.BytesIO(data)) as image:
        if image.mode[0] in "IF":
            raise FileFormatError(f"{name}: has pixels of the kind {image.mode!r}, expected 8 bits")
        if "A" in image.mode or "a" in image.mode or "transparency" in image.info:
            pixels = np.array(image.convert("RGBA"))
            color = np.ascontiguousarray(pixels[..., :3])
            return TextureFile(color, float(pixels[..., 3].mean()) / 255.0)
        return TextureFile(np.array(image.convert("RGB")), 1.0)
