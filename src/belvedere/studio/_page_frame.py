"""What the pages of reports have in common: head, style, title, figures in large type, footer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from string import Template


@dataclass(frozen=True, slots=True)
class PageFrame:
    """The top of a page. Text, not HTML, except ``lede``."""

    kind: str
    """What the page is: "evaluation", "walk"."""
    title: str
    version: str
    """Of belvedere."""
    lede: str
    """One paragraph below the title, HTML."""
    figures: Sequence[tuple[str, str, str]]
    """Name, value and unit of the numbers in large type."""


def framed_page(frame: PageFrame, name: str, parts: Mapping[str, str]) -> str:
    """The page whose middle is ``page/NAME.html``.

    Args:
        frame: its top.
        name: of the template; ``NAME.css`` and ``NAME.js`` beside it go in too, where there are.
        parts: HTML for the names in the template.
    """
    page = files("belvedere.studio") / "page"

    def read(file: str) -> str:
        return (page / file).read_text("utf-8") if (page / file).is_file() else ""

    script = read(f"{name}.js")
    figures = "".join(
        f"<div><dt>{escape(key)}</dt><dd>{value}<small>{unit}</small></dd></div>"
        for key, value, unit in frame.figures
    )
    return Template(read("page.html")).substitute(
        kind=escape(frame.kind), title=escape(frame.title), version=escape(frame.version),
        style=read("page.css") + read(f"{name}.css"), lede=frame.lede, figures=figures,
        main=Template(read(f"{name}.html")).substitute(parts),
        script=f"<script>\n{script}\n</script>" if script else "",
    )  # fmt: skip
