"""False colours for what `belvedere.explain` says: sources, holes and errors, with a legend.

Pictures are (H, W, 3) ``uint8`` sRGB.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_number, check_shape
from belvedere.scene.explanation import MOST_REFERENCES, Explanation, Hole
from belvedere.scene.view import Frame
from belvedere.studio.difference import GREY, HOLE_TINT, dusk_table
from belvedere.studio.metrics import shown_values

U1 = npt.NDArray[np.uint8]
Tint = tuple[int, int, int]

HOLE_TINTS: dict[Hole, Tint] = {
    Hole.UNDERSAMPLED: (255, 176, 0),
    Hole.UNSEEN: HOLE_TINT,
    Hole.OUTSIDE: (70, 110, 190),
}
"""Cracks amber, exposures the rose that holes have everywhere, the outside blue."""
HOLE_NAMES: dict[Hole, str] = {
    Hole.UNDERSAMPLED: "crack", Hole.UNSEEN: "unseen", Hole.OUTSIDE: "outside",
}  # fmt: skip
LARGEST_ERROR = 0.1
"""Error at the light end of the table: 26 of 255, which everybody sees."""
FIRST_TINTS: tuple[Tint, ...] = (
    (230, 159, 0), (86, 180, 233), (0, 158, 115), (240, 228, 66), (0, 114, 178), (213, 94, 0),
    (204, 121, 167),
)  # fmt: skip
"""Colours that people with any colour vision tell apart (Okabe and Ito 2008)."""
LEGEND_ROW = 18
"""Pixels down of a legend's line: the built-in font and some air."""


def source_tints(count: int) -> list[Tint]:
    """A colour for each of ``count`` references."""
    return [_tint(n) for n in range(count)]


def _tint(n: int) -> Tint:
    if n < len(FIRST_TINTS):
        return FIRST_TINTS[n]
    import colorsys

    hue = (n * 0.618034) % 1.0
    r, g, b = colorsys.hls_to_rgb(hue, 0.35 + 0.3 * ((n // 2) % 2), 0.7)
    return round(255 * r), round(255 * g), round(255 * b)


def source_picture(frame: Frame, explanation: Explanation) -> U1:
    """The picture in the colours of the references that its pixels come from, holes dark."""
    shade = 0.3 + 0.7 * _luma(frame, explanation)
    table = np.array([*source_tints(MOST_REFERENCES), (0, 0, 0)], np.float64)
    picture = table[np.minimum(explanation.source, MOST_REFERENCES - 1)] * shade[..., None]
    picture[explanation.source < 0] = 24
    return np.rint(picture).astype(np.uint8)


def hole_picture(frame: Frame, explanation: Explanation) -> U1:
    """The picture in pale grey, and each kind of hole in its colour."""
    grey = np.rint(255 * (0.5 + 0.4 * _luma(frame, explanation))).astype(np.uint8)
    picture = np.repeat(grey[..., None], 3, axis=2)
    for kind, tint in HOLE_TINTS.items():
        picture[explanation.hole == kind] = tint
    return picture


def error_picture(explanation: Explanation, high: float = LARGEST_ERROR) -> U1:
    """Expected errors: none is dark blue, ``high`` and more pale yellow; holes are grey."""
    check_number("error_picture", "high", high, 0.0, open_low=True)
    known = np.isfinite(explanation.error)
    share = np.clip(np.where(known, explanation.error, 0.0) / high, 0.0, 1.0)
    picture = dusk_table()[np.rint(255 * share).astype(np.uint8)]
    picture[~known] = GREY
    return picture


def add_legend(picture: U1, entries: Sequence[tuple[str, Tint]]) -> U1:
    """``picture`` with a line below it that says what colours mean.

    Args:
        picture: (H, W, 3).
        entries: words and their colours; those that no longer fit begin another line.

    Returns:
        (H + lines, W, 3).
    """
    from PIL import Image, ImageDraw, ImageFont

    width, font = picture.shape[1], ImageFont.load_default()
    places: list[tuple[int, int]] = []
    x, row = 4, 0
    for words, _ in entries:
        need = 16 + int(font.getlength(words)) + 10
        if x > 4 and x + need > width:
            x, row = 4, row + 1
        places.append((x, row))
        x += need
    strip = Image.new("RGB", (width, LEGEND_ROW * (row + 1)), (255, 255, 255))
    draw = ImageDraw.Draw(strip)
    for (words, tint), (left, line) in zip(entries, places, strict=True):
        top = LEGEND_ROW * line
        draw.rectangle((left, top + 4, left + 10, top + 14), fill=tint)
        draw.text((left + 15, top + 3), words, fill=(32, 32, 32), font=font)
    return np.vstack([picture, np.asarray(strip)])


def explained_pictures(
    frame: Frame, explanation: Explanation, names: Sequence[str] = ()
) -> dict[str, U1]:
    """``source``, ``holes`` and ``error``, each with its legend.

    Args:
        frame: the frame.
        explanation: of that frame.
        names: of the references, in the order in which they were given; by default numbers.
    """
    used = [int(n) for n in np.unique(explanation.source) if n >= 0]
    titles = {n: names[n] if n < len(names) else f"reference {n}" for n in used}
    tints = source_tints(max(used, default=0) + 1)
    table = dusk_table()
    steps = [(f"{LARGEST_ERROR * k / 4:g}", _of(table[round(255 * k / 4)])) for k in range(5)]
    kinds = [
        (f"{HOLE_NAMES[kind]} {explanation.share(kind):.1%}", tint)
        for kind, tint in HOLE_TINTS.items()
    ]
    return {
        "source": add_legend(
            source_picture(frame, explanation), [(titles[n], tints[n]) for n in used]
        ),
        "holes": add_legend(hole_picture(frame, explanation), kinds),
        "error": add_legend(error_picture(explanation), steps),
    }


def _of(color: U1) -> Tint:
    return int(color[0]), int(color[1]), int(color[2])


def _luma(frame: Frame, explanation: Explanation) -> npt.NDArray[np.float64]:
    luma = shown_values(frame.color) @ np.array([0.299, 0.587, 0.114])
    check_shape("explanation", "source", explanation.source, luma.shape, "it is of another frame")
    return luma
