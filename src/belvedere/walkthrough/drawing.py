"""A list of lines, areas and words that becomes SVG or pixels."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from html import escape
from typing import Any

import numpy as np
import numpy.typing as npt

F8 = npt.NDArray[np.float64]
Color = tuple[int, int, int]

SHARPER = 3
"""Pixels are drawn so many times finer and averaged."""

__all__ = ["Drawing", "Label", "text_width"]


@dataclass(frozen=True, slots=True, eq=False)
class Area:
    """Filled outlines; holes by the even-odd rule."""

    rings: tuple[F8, ...]
    """(N, 2) points, picture units, y down."""
    fill: Color
    """sRGB."""
    rim: float = 0.0
    """Width of a rim of the same colour, half of it outside."""


@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Straight strokes."""

    ends: F8
    """(N, 2, 2) points, picture units."""
    color: Color
    """sRGB."""
    width: float
    """Picture units."""


@dataclass(frozen=True, slots=True, eq=False)
class Label:
    """A line of text round its middle."""

    at: tuple[float, float]
    """Its middle, picture units."""
    text: str
    """The words."""
    size: float
    """Height of the letters' em."""
    color: Color
    """sRGB."""
    halo: Color | None = None
    """A rim of this colour that keeps it legible."""

    @property
    def box(self) -> tuple[float, float, float, float]:
        """x0, y0, x1, y1."""
        half = text_width(self.text, self.size) / 2.0 + 2.0
        x, y = self.at
        return x - half, y - 0.6 * self.size, x + half, y + 0.6 * self.size


@dataclass
class Drawing:
    """Things in the order in which they are painted."""

    width: int
    """Picture units, pixels at scale 1."""
    height: int
    """Picture units."""
    items: list[Area | Lines | Label] = field(default_factory=list)
    """The later ones cover the earlier."""

    def svg(self) -> str:
        """The drawing as a standalone SVG document."""
        parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width}" height="{self.height}" '
            f'viewBox="0 0 {self.width} {self.height}" '
            'font-family="Helvetica, Arial, sans-serif" text-anchor="middle">',
            f'<rect width="{self.width}" height="{self.height}" fill="#ffffff"/>',
        ]
        parts += [_svg_item(item) for item in self.items]
        return "\n".join([*parts, "</svg>"]) + "\n"

    def image(self, scale: float = 1.0) -> npt.NDArray[np.uint8]:
        """(H, W, 3) sRGB pixels."""
        from PIL import Image, ImageDraw

        size = (max(round(self.width * scale), 1), max(round(self.height * scale), 1))
        big = SHARPER * scale
        image = Image.new("RGB", (size[0] * SHARPER, size[1] * SHARPER), (255, 255, 255))
        pen = ImageDraw.Draw(image)
        for item in self.items:
            if isinstance(item, Area):
                _paint_area(image, item, big)
            elif isinstance(item, Lines):
                _paint_lines(pen, item, big)
            else:
                _paint_label(pen, item, big)
        return np.asarray(image.resize(size, Image.Resampling.BOX))


def _hex(color: Color) -> str:
    return "#{:02x}{:02x}{:02x}".format(*color)


def _svg_item(item: Area | Lines | Label) -> str:
    if isinstance(item, Label):
        halo = ""
        if item.halo is not None:
            halo = (
                f' stroke="{_hex(item.halo)}" stroke-width="{item.size / 4:.1f}"'
                ' stroke-linejoin="round" paint-order="stroke"'
            )
        x, y = item.at
        return (
            f'<text x="{x:.1f}" y="{y + 0.35 * item.size:.1f}" font-size="{item.size:.1f}" '
            f'fill="{_hex(item.color)}"{halo}>{escape(item.text)}</text>'
        )
    if isinstance(item, Lines):
        path = "".join(f"M{a[0]:.1f} {a[1]:.1f}L{b[0]:.1f} {b[1]:.1f}" for a, b in item.ends)
        return (
            f'<path d="{path}" stroke="{_hex(item.color)}" stroke-width="{item.width:.1f}" '
            'stroke-linecap="round" fill="none"/>'
        )
    path = "".join(
        "M" + "L".join(f"{p[0]:.1f} {p[1]:.1f}" for p in ring) + "Z" for ring in item.rings
    )
    rim = ""
    if item.rim > 0.0:
        rim = f' stroke="{_hex(item.fill)}" stroke-width="{item.rim:.1f}"'
    return f'<path d="{path}" fill="{_hex(item.fill)}" fill-rule="evenodd"{rim}/>'


def _paint_area(image: Any, item: Area, big: float) -> None:
    from PIL import Image, ImageChops, ImageDraw

    mask = Image.new("1", image.size, 0)
    for ring in item.rings:  # even-odd: each ring turns over what it encloses
        one = Image.new("1", image.size, 0)
        ImageDraw.Draw(one).polygon([(x * big, y * big) for x, y in ring], fill=1)
        mask = ImageChops.logical_xor(mask, one)
    if item.rim > 0.0:
        pen = ImageDraw.Draw(mask)
        for ring in item.rings:
            closed = [(x * big, y * big) for x, y in [*ring, ring[0]]]
            pen.line(closed, fill=1, width=max(round(item.rim * big), 1), joint="curve")
            r = item.rim * big / 2.0
            for x, y in closed:
                pen.rectangle((x - r, y - r, x + r, y + r), fill=1)
    image.paste(item.fill, (0, 0), mask)


def _paint_lines(pen: Any, item: Lines, big: float) -> None:
    width = max(round(item.width * big), 1)
    for a, b in item.ends * big:
        pen.line([tuple(a), tuple(b)], fill=item.color, width=width)
        if width > 2:
            r = width / 2.0 - 0.5
            for x, y in (a, b):
                pen.ellipse((x - r, y - r, x + r, y + r), fill=item.color)


def _paint_label(pen: Any, item: Label, big: float) -> None:
    x, y = item.at
    extra: dict[str, Any] = {}
    if item.halo is not None:
        extra = {"stroke_width": max(round(item.size * big / 8), 1), "stroke_fill": item.halo}
    pen.text(
        (x * big, y * big), item.text, fill=item.color, font=_font(item.size * big), anchor="mm",
        **extra,
    )  # fmt: skip


@lru_cache(maxsize=32)
def _font(size: float) -> Any:
    from PIL import ImageFont

    return ImageFont.load_default(max(size, 4.0))


@lru_cache(maxsize=4096)
def text_width(text: str, size: float) -> float:
    """How wide a text comes out, a little generously: browsers take other letters."""
    return 1.08 * float(_font(40.0).getlength(text)) * size / 40.0
