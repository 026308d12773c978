"""JSON, read strictly and written atomically.

`JsonObject` reads values by key and says file, key and index when one is missing or wrong::

    transforms.json: frames[3].transform_matrix has shape (3, 3), expected (4, 4)
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import shape_text
from belvedere.ground.errors import FileFormatError, MissingFileError, SceneError
from belvedere.scene.io.atomic import write_bytes

MAX_BYTES = 1 << 28
"""Largest JSON file we read (256 MiB: a million frames)."""


def read_json(path: str | Path) -> JsonObject:
    """Read a JSON file whose outermost value is an object.

    Raises:
        MissingFileError: there is no such file.
        FileFormatError: empty, truncated, larger than 256 MiB, not UTF-8, no JSON object, a key
            twice in one object, NaN or an infinity.
    """
    file = Path(path)
    text = _read_text(file)
    found: list[str] = []

    def constant(word: str) -> float:
        found.append(word)
        return float(word.replace("Infinity", "inf"))

    def number(digits: str) -> float:
        value = float(digits)
        if math.isinf(value):
            found.append(digits)
        return value

    try:
        data = json.loads(
            text, parse_constant=constant, parse_float=number, object_pairs_hook=_unique(file)
        )
    except json.JSONDecodeError as error:
        at_end = error.pos >= len(text.rstrip())
        raise FileFormatError(
            f"{file}: "
            + ("ends too early, it is truncated" if at_end else f"is not JSON ({error.msg})")
            + f" at line {error.lineno}, column {error.colno}: restore it or write it again"
        ) from None
    except (ValueError, RecursionError) as error:
        if isinstance(error, FileFormatError):
            raise
        raise FileFormatError(f"{file}: is not JSON that can be read ({error})") from None
    if found:
        raise FileFormatError(
            f"{file.name}: {_find_bad(data)} is {found[0]}, expected a finite number: mend the "
            "pipeline that wrote it"
        )
    if not isinstance(data, dict):
        raise FileFormatError(
            f"{file}: holds a {_kind(data)}, expected a JSON object in braces {{...}}"
        )
    return JsonObject(file.name, data)


def write_json(path: str | Path, data: dict[str, Any], *, force: bool = True) -> None:
    """Write a JSON object atomically, keys in their order, floats with every digit.

    Raises:
        OutputError: see `atomic_write`.
        SceneError: a value that JSON cannot hold, such as NaN.
    """
    try:
        text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise SceneError(f"{path}: cannot be written as JSON ({error})") from error
    write_bytes(path, (text + "\n").encode(), force=force)


class JsonObject:
    """A JSON object that knows its place, so that refusals can name it."""

    def __init__(self, where: str, data: dict[str, Any], prefix: str = "") -> None:
        self.where = where
        """File, for messages."""
        self.data = data
        """The plain dictionary."""
        self.prefix = prefix
        """``frames[3].``, or nothing for the outermost object."""

    def place(self, key: str) -> str:
        """How a message names a key: ``transforms.json: frames[3].file_path``."""
        return f"{self.where}: {self.prefix}{key}"

    @property
    def here(self) -> str:
        """How a message names this object."""
        return f"{self.where}: {self.prefix.rstrip('.')}" if self.prefix else self.where

    def __contains__(self, key: str) -> bool:
        return self.data.get(key) is not None

    def require(self, key: str) -> Any:
        """The value of ``key``.

        Raises:
            SceneError: it is missing or null.
        """
        if key not in self:
            raise SceneError(f"{self.here} has no {key!r}: add it")
        return self.data[key]

    def text(self, key: str, default: str | None = None) -> str:
        """Text, or ``default`` where the key is missing."""
        if default is not None and key not in self:
            return default
        value = self.require(key)
        if not isinstance(value, str):
            raise SceneError(f"{self.place(key)} is {_short(value)}, expected text")
        return value

    def number(
        self, key: str, default: float | None = None, *, low: float = -math.inf,
        above: float = -math.inf,
    ) -> float:  # fmt: skip
        """A finite number >= ``low`` and > ``above``, or ``default`` where the key is missing."""
        if default is not None and key not in self:
            return default
        value = self.require(key)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise SceneError(f"{self.place(key)} is {_short(value)}, expected a number")
        if value < low or value <= above:
            bound = f"above {above:g}" if value <= above else f"of at least {low:g}"
            raise SceneError(f"{self.place(key)} is {value:g}, expected a number {bound}")
        return float(value)

    def integer(self, key: str, default: int | None = None, *, low: int = 0) -> int:
        """A whole number >= ``low`` (640.0 counts), or ``default`` where the key is missing."""
        if default is not None and key not in self:
            return default
        value = self.number(key)
        if value != int(value) or value < low:
            raise SceneError(
                f"{self.place(key)} is {_short(self.data[key])}, expected a whole number from {low}"
            )
        return int(value)

    def array(self, key: str, shape: tuple[int, ...]) -> npt.NDArray[np.float64]:
        """An array of numbers of one shape."""
        value = self.require(key)
        try:
            array = np.array(value, dtype=np.float64)
        except (TypeError, ValueError):
            raise SceneError(
                f"{self.place(key)} is not {shape_text(shape)} numbers: a row is ragged or has text"
            ) from None
        if array.shape != shape:
            raise SceneError(
                f"{self.place(key)} has shape {shape_text(array.shape)}, expected "
                f"{shape_text(shape)}"
            )
        return array

    def object(self, key: str) -> JsonObject:
        """A nested object; an empty one where the key is missing."""
        value = self.data.get(key)
        if value is None:
            value = {}
        if not isinstance(value, dict):
            raise SceneError(f"{self.place(key)} is {_short(value)}, expected an object {{...}}")
        return JsonObject(self.where, value, f"{self.prefix}{key}.")

    def objects(self, key: str) -> Iterator[JsonObject]:
        """The objects of a list that must not be empty."""
        value = self.require(key)
        if not isinstance(value, list) or not value:
            raise SceneError(f"{self.place(key)} is {_short(value)}, expected a list of objects")
        for index, item in enumerate(value):
            if not isinstance(item, dict):
                raise SceneError(
                    f"{self.place(key)}[{index}] is {_short(item)}, expected an object {{...}}"
                )
            yield JsonObject(self.where, item, f"{self.prefix}{key}[{index}].")


def _read_text(file: Path) -> str:
    if not file.is_file():
        raise MissingFileError(f"no file {file}: check the name")
    size = file.stat().st_size
    if size > MAX_BYTES:
        raise FileFormatError(f"{file}: has {size} bytes, more than the {MAX_BYTES} read as JSON")
    if size == 0:
        raise FileFormatError(f"{file}: is empty (0 bytes): restore it or write it again")
    try:
        text = file.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileFormatError(f"{file}: is not UTF-8 text ({error.reason} at byte {error.start})"
                              ) from None  # fmt: skip
    if not text.strip():
        raise FileFormatError(f"{file}: holds nothing but blanks: restore it or write it again")
    return text


def _unique(file: Path) -> Any:
    def build(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        data = dict(pairs)
        if len(data) != len(pairs):
            seen: set[str] = set()
            twice = next(key for key, _ in pairs if key in seen or seen.add(key))
            raise FileFormatError(
                f"{file}: the key {twice!r} stands twice in one object: remove one of them"
            )
        return data

    return build


def _find_bad(value: Any, place: str = "") -> str:
    """Where the first NaN or infinity stands: ``frames[0].transform_matrix[1][3]``."""
    if isinstance(value, float):
        return "" if math.isfinite(value) else place or "the value"
    items: Any = ()
    if isinstance(value, dict):
        items = ((f"{place}.{key}" if place else key, item) for key, item in value.items())
    elif isinstance(value, list):
        items = ((f"{place}[{index}]", item) for index, item in enumerate(value))
    return next((found for name, item in items if (found := _find_bad(item, name))), "")


def _kind(value: Any) -> str:
    words = {list: "list", str: "text", bool: "truth value", type(None): "null"}
    return words.get(type(value), "number")


def _short(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 40 else text[:37] + "..."
