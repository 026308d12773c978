"""A pen that draws SVG by hand: lines, arrows, words. No plotting library, no fonts to load.

Figures sit on a sheet of their own, so that they read the same in a light and a dark page.
"""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

INK, SOFT, FAINT = "#22303c", "#64717c", "#d9d6cc"
PAPER, PANEL = "#fbfaf6", "#f2efe6"
RED, GREEN, BLUE, ORANGE, TEAL = "#c0392b", "#2e8b57", "#2b6cb0", "#d2741f", "#1f7a8c"
Point = tuple[float, float]


class Pen:
    """Collects SVG elements; `sheet` gives the file."""

    def __init__(self, width: float, height: float, title: str) -> None:
        self.width, self.height, self.title = width, height, title
        self._parts: list[str] = []

    def add(self, text: str) -> None:
        self._parts.append(text)

    def line(self, points: Iterable[Point], color: str = INK, width: float = 1.6,
             dash: str = "", fill: str = "none", closed: bool = False) -> None:  # fmt: skip
        way = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        kind = "polygon" if closed else "polyline"
        self.add(
            f'<{kind} points="{way}" fill="{fill}" stroke="{color}" stroke-width="{width:g}"'
            f' stroke-linejoin="round" stroke-linecap="round"{dashed}/>'
        )

    def arrow(self, start: Point, end: Point, color: str = INK, width: float = 1.8,
              dash: str = "", head: float = 8.0) -> None:  # fmt: skip
        dx, dy = end[0] - start[0], end[1] - start[1]
        length = (dx * dx + dy * dy) ** 0.5
        ux, uy = dx / length, dy / length
        neck = (end[0] - head * ux, end[1] - head * uy)
        self.line([start, neck], color, width, dash)
        side = 0.42 * head
        tips = [end, (neck[0] - side * uy, neck[1] + side * ux),
                (neck[0] + side * uy, neck[1] - side * ux)]  # fmt: skip
        self.line(tips, color, 0.5, fill=color, closed=True)

    def box(self, x: float, y: float, width: float, height: float, fill: str = PANEL,
            stroke: str = FAINT, radius: float = 6.0) -> None:  # fmt: skip
        self.add(
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"'
            f' rx="{radius:g}" fill="{fill}" stroke="{stroke}"/>'
        )

    def dot(self, at: Point, color: str = INK, radius: float = 3.2) -> None:
        self.add(f'<circle cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="{radius:g}" fill="{color}"/>')

    def text(self, at: Point, words: str, color: str = INK, size: float = 14.0,
             anchor: str = "start", weight: str = "normal", mono: bool = False
    ) -> None:  # fmt: skip
        family = "ui-monospace, 'DejaVu Sans Mono', Menlo, monospace" if mono else (
            "'Segoe UI', 'DejaVu Sans', Helvetica, Arial, sans-serif"
        )  # fmt: skip
        self.add(
            f'<text x="{at[0]:.1f}" y="{at[1]:.1f}" fill="{color}" font-size="{size:g}"'
            f' text-anchor="{anchor}" font-weight="{weight}" font-family="{family}">'
            f"{escape(words)}</text>"
        )

    def sheet(self) -> str:
        """The whole file."""
        return "\n".join(
            [
                f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width:g} '
                f'{self.height:g}" role="img" aria-label="{escape(self.title, quote=True)}">',
                f"<title>{escape(self.title)}</title>",
                f'<rect width="{self.width:g}" height="{self.height:g}" rx="10" fill="{PAPER}"/>',
                *self._parts,
                "</svg>",
                "",
            ]
        )
