"""One chart, drawn by us as SVG: decibels per view, one line a way of predicting."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

MARKS = ("circle", "square", "triangle", "diamond", "cross")
"""One shape a line, so that nobody needs to tell colours apart."""


LETTER = 8.0
"""The most that a letter of the axis takes, pixels; none of them is a wide one."""


@dataclass(frozen=True, slots=True)
class Line:
    """One way of predicting: a value a view."""

    label: str
    values: tuple[float, ...]
    """Decibels, one a view; NaN leaves a gap, infinity (an identical picture) sits on the top."""
    style: int
    """Colour and mark, 0 to 4."""
    dashed: bool = False


def psnr_chart(names: Sequence[str], lines: Sequence[Line], width: int) -> str:
    """An ``<svg>`` of ``width`` CSS pixels' layout that scales with its column.

    Args:
        names: the views, left to right.
        lines: what to draw; colours come from the page's ``--way-0`` ... ``--way-4``.
        width: layout width; text keeps its size relative to it, so draw one chart per layout.
    """
    height = 260 if width > 500 else 240
    finite = [v for line in lines for v in line.values if math.isfinite(v)]
    low, high, step = _axis(finite)
    ticks = _ticks(low, high, step)
    left = 8 + max(math.ceil(LETTER * len(text)) for _, text in ticks) + 4
    right, top, bottom = 12, 14, 44
    count = max(len(names), 1)

    def x_of(index: int) -> float:
        return left + (width - left - right) * (index + 0.5) / count

    def y_of(value: float) -> float:
        share = 1.0 if math.isinf(value) else (value - low) / (high - low)
        return top + (height - top - bottom) * (1.0 - share)

    parts = [
        f'<svg class="chart" viewBox="0 0 {width} {height}" role="img" '
        f'aria-label="PSNR in decibels for each held-out view">'
    ]
    for value, text in ticks:
        y = y_of(value)
        parts.append(f'<line class="grid" x1="{left}" x2="{width - right}" y1="{y:.1f}" '
                     f'y2="{y:.1f}"/><text class="tick" x="{left - 8}" y="{y + 4:.1f}" '
                     f'text-anchor="end">{text}</text>')  # fmt: skip
    labels = short_names(names)
    every = max(math.ceil(count * 9 * max(map(len, labels), default=1) / (width - left)), 1)
    parts += [
        f'<text class="tick" x="{x_of(index):.1f}" y="{height - bottom + 20}" '
        f'text-anchor="middle">{escape(labels[index])}</text>'
        for index in range(0, len(names), every)
    ]
    parts.append(f'<text class="tick" x="{(left + width - right) / 2:.1f}" y="{height - 4}" '
                 'text-anchor="middle">held-out view</text>')  # fmt: skip
    for line in lines:
        points = [(x_of(i), y_of(v), i) for i, v in enumerate(line.values) if not math.isnan(v)]
        path = " ".join(f"{'L' if n else 'M'}{x:.1f},{y:.1f}" for n, (x, y, _) in enumerate(points))
        dash = " dashed" if line.dashed else ""
        parts.append(f'<g class="way-{line.style}{dash}"><path class="line" d="{path}"/>')
        for x, y, index in points:
            shown = line.values[index]
            text = "identical" if math.isinf(shown) else f"{shown:.2f} dB"
            tip = escape(f"{names[index]}: {line.label} {text}")
            size = 4.2 if count <= 40 else 2.4
            parts.append(mark(line.style, x, y, size, tip))
        parts.append("</g>")
    parts.append("</svg>")
    return "".join(parts)


def mark(style: int, x: float, y: float, size: float, tip: str = "") -> str:
    """One of `MARKS` around (x, y), with a tooltip that is HTML already."""
    title = f"<title>{tip}</title>" if tip else ""
    kind, r = MARKS[style % len(MARKS)], size
    if kind == "circle":
        return f'<circle class="mark" cx="{x:.1f}" cy="{y:.1f}" r="{r}">{title}</circle>'
    outline = {
        "square": ((-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)),
        "triangle": ((0, -1.15), (1.1, 0.85), (-1.1, 0.85)),
        "diamond": ((0, -1.25), (1.25, 0), (0, 1.25), (-1.25, 0)),
        "cross": ((-1, -0.4), (-0.4, -0.4), (-0.4, -1), (0.4, -1), (0.4, -0.4), (1, -0.4),
                  (1, 0.4), (0.4, 0.4), (0.4, 1), (-0.4, 1), (-0.4, 0.4), (-1, 0.4)),
    }[kind]  # fmt: skip
    points = " ".join(f"{x + r * a:.1f},{y + r * b:.1f}" for a, b in outline)
    return f'<polygon class="mark" points="{points}">{title}</polygon>'


def legend(lines: Sequence[Line]) -> str:
    """The chart's key as an HTML list."""
    items = []
    for line in lines:
        dash = " dashed" if line.dashed else ""
        items.append(
            f'<li><svg class="key way-{line.style}{dash}" viewBox="0 0 28 14" aria-hidden="true">'
            f'<path class="line" d="M1,7L27,7"/>{mark(line.style, 14, 7, 4.2)}</svg>'
            f"{escape(line.label)}</li>"
        )
    return f'<ul class="legend">{"".join(items)}</ul>'


def short_names(names: Sequence[str]) -> list[str]:
    """What tells the names apart, if that is short; their place in the list otherwise.

    Only whole words are cut: what all names begin with up to a sign such as ``_``, and a suffix
    such as ``.png``.
    """
    most = 8
    if all(len(name) <= most for name in names):
        return list(names)
    stems = [name.rpartition(".")[0] or name for name in names]
    if len({name.rpartition(".")[2] for name in names}) > 1:
        stems = list(names)
    shared = next(
        (i for i, letters in enumerate(zip(*stems, strict=False)) if len(set(letters)) > 1), 0
    )
    while shared and stems[0][shared - 1].isalnum():
        shared -= 1
    cut = [stem[shared:] for stem in stems]
    if len(names) > 1 and all(0 < len(name) <= most for name in cut):
        return cut
    return [str(index + 1) for index in range(len(names))]


def _axis(values: Sequence[float]) -> tuple[float, float, float]:
    """Low end, high end and step of an axis that holds the values with some air."""
    low, high = min(values, default=20.0), max(values, default=40.0)
    span = max(high - low, 2.0)
    rough = span / 4
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * m for m in (1, 2, 2.5, 5, 10) if power * m >= rough)
    return (
        step * math.floor((low - 0.15 * span) / step),
        step * math.ceil((high + 0.15 * span) / step),
        step,
    )


def _ticks(low: float, high: float, step: float) -> list[tuple[float, str]]:
    """The axis's values and what is written beside them; the top one names the unit."""
    values = [low + step * index for index in range(round((high - low) / step) + 1)]
    return [(value, f"{value:g}" + (" dB" if value == values[-1] else "")) for value in values]
