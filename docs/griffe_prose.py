"""Our docstrings are prose with a little reStructuredText; the site is Markdown.

Three things differ and are turned here: ``::`` before an indented block, tables ruled with ``====``
and double backquotes. Nothing else is touched.
"""

from __future__ import annotations

import re
from typing import Any

import griffe

_RULE = re.compile(r"^=+(?: +=+)+$")


def to_markdown(text: str) -> str:
    """A docstring's reStructuredText turned into Markdown."""
    lines: list[str] = []
    table = False
    rules = 0
    for line in text.splitlines():
        if _RULE.match(line.strip()):
            if not table:
                table, rules = True, 0
                lines += ["", "```text"]
            else:
                rules += 1
            lines.append(line)
            continue
        if table and not line.strip():
            table = False
            lines += ["```", ""]
            continue
        lines.append(line if table else _plain(line))
    if table:
        lines.append("```")
    return "\n".join(lines)


def _plain(line: str) -> str:
    if line.startswith("    "):
        return line
    if line.strip() == "::":
        return ""
    if line.endswith("::"):
        line = line[:-1]
    return re.sub(r"``(.+?)``", r"`\1`", line)


class Prose(griffe.Extension):
    """Applies `to_markdown` to every docstring once it is read."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        if obj.docstring is not None:
            obj.docstring.value = to_markdown(obj.docstring.value)
