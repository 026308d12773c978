"""Small words of messages."""

from __future__ import annotations


def counted(count: int, one: str, many: str | None = None) -> str:
    """A number with its noun: ``1 frame``, ``2 frames``.

    Args:
        count: how many.
        one: the noun for one.
        many: the noun for any other number; by default ``one`` and an s.
    """
    return f"{count} {one if count == 1 else many or one + 's'}"
