"""Frame times along a walk as SVG, one line a mode."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

HEIGHT = 280
LEFT, RIGHT, TOP, BOTTOM = 46, 10, 12, 40
POINTS = 400
"""Corners of a line at most: of more frames, each corner shows the slowest of a few."""


def times_chart(times: Mapping[str, Sequence[float]], width: int) -> str:
    """An ``<svg>`` of ``width`` CSS pixels' layout.

    Args:
        times: milliseconds of each frame by mode; all of one length.
        width: layout width.
    """
    longest = max((float(np.percentile(values, 99.5)) for values in times.values()), default=1.0)
    step = _step(longest)
    top = step * max(np.ceil(longest / step), 1)
    count = max((len(values) for values in times.values()), default=1)

    def y_of(value: float) -> float:
        return TOP + (HEIGHT - TOP - BOTTOM) * (1.0 - min(value / top, 1.0))

    def x_of(index: float) -> float:
        return LEFT + (width - LEFT - RIGHT) * index / max(count - 1, 1)

    parts = [
        f'<svg class="chart" viewBox="0 0 {width} {HEIGHT}" role="img" '
        'aria-label="Milliseconds of each frame of the walk, by mode">'
    ]
    for k in range(round(top / step) + 1):
        y = y_of(k * step)
        parts.append(
            f'<line class="grid" x1="{LEFT}" x2="{width - RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>'
            f'<text class="tick" x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{k * step:g}'
            "</text>"
        )
    parts += [
        f'<text class="tick" x="{x_of(index):.1f}" y="{HEIGHT - BOTTOM + 18}" '
        f'text-anchor="middle">{index}</text>'
        for index in np.linspace(0, count - 1, 5 if width > 500 else 3).astype(int)
    ]
    parts.append(
        f'<text class="tick" x="{(LEFT + width - RIGHT) / 2:.1f}" y="{HEIGHT - 4}" '
        'text-anchor="middle">frame</text>'
    )
    for style, (mode, values) in enumerate(times.items()):
        every = -(-len(values) // POINTS)
        slowest = [max(values[i : i + every]) for i in range(0, len(values), every)]
        path = " ".join(
            f"{'L' if i else 'M'}{x_of(i * every):.1f},{y_of(value):.1f}"
            for i, value in enumerate(slowest)
        )
        parts.append(
            f'<g class="way-{style}"><path class="line" d="{path}"><title>{escape(mode)}</title>'
            "</path></g>"
        )
    parts.append("</svg>")
    return "".join(parts)


def _step(longest: float) -> float:
    """A round distance between lines of the grid: four to eight of them."""
    rough = max(longest, 1e-3) / 5.0
    power = 10.0 ** np.floor(np.log10(rough))
    return float(next(power * m for m in (1, 2, 5, 10) if power * m >= rough))
