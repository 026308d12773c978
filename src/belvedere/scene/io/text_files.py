"""Small text files of numbers: trajectories, calibrations, lists of file names."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from belvedere.ground.errors import FileFormatError, MissingFileError

MAX_BYTES = 1 << 30
"""Largest text file we read (1 GiB: COLMAP's lists of points are long)."""


def text_lines(path: str | Path, *, comment: str = "#") -> Iterator[tuple[int, str]]:
    """Line numbers (from 1) and stripped lines that are neither blank nor comments.

    Raises:
        MissingFileError: there is no such file.
        FileFormatError: empty, too large, or not text.
    """
    file = Path(path)
    if not file.is_file():
        raise MissingFileError(f"no file {file}: the format needs it")
    size = file.stat().st_size
    if size == 0:
        raise FileFormatError(f"{file}: is empty (0 bytes): restore it or write it again")
    if size > MAX_BYTES:
        raise FileFormatError(f"{file}: has {size} bytes, more than the {MAX_BYTES} read as text")
    try:
        with file.open(encoding="utf-8-sig") as stream:
            for number, line in enumerate(stream, start=1):
                text = line.strip()
                if text and not text.startswith(comment):
                    yield number, text
    except UnicodeDecodeError as error:
        raise FileFormatError(f"{file}: is not UTF-8 text ({error.reason})") from None


def numbers(where: str, words: list[str], count: int | None = None) -> list[float]:
    """Words as finite numbers.

    Raises:
        FileFormatError: another count, a word that is no number, NaN or an infinity.
    """
    if count is not None and len(words) != count:
        raise FileFormatError(f"{where} has {len(words)} values, expected {count}")
    values: list[float] = []
    for word in words:
        try:
            values.append(float(word))
        except ValueError:
            raise FileFormatError(f"{where} has {word[:40]!r}, expected a number") from None
        if not math.isfinite(values[-1]):
            raise FileFormatError(f"{where} has {word}, expected a finite number")
    return values
