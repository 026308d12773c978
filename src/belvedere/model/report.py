"""What a reader has to say about a file: what it left out, changed or guessed."""

from __future__ import annotations

__all__ = ["Report"]


class Report:
    """Lines for the reader's user, in the order in which they came up, each once."""

    def __init__(self) -> None:
        self._counts: dict[str, int] = {}

    def note(self, line: str) -> None:
        """Say something; said again, it is counted."""
        self._counts[line] = self._counts.get(line, 0) + 1

    def count(self, number: int, one: str, many: str, what: str) -> None:
        """``3 faces without area: left out``; nothing where the number is 0."""
        if number:
            self.note(f"{number:,} {one if number == 1 else many} {what}".replace(" :", ":"))

    @property
    def lines(self) -> tuple[str, ...]:
        """All of it."""
        return tuple(
            line if number == 1 else f"{line} ({number} times)"
            for line, number in self._counts.items()
        )
