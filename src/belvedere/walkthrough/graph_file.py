"""Cell graphs as JSON that people edit by hand: see docs/formats.md."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, get_args

import numpy as np

from belvedere.ground.errors import FileFormatError, MissingFileError, SceneError
from belvedere.model.building import OpeningKind
from belvedere.walkthrough.cells import OUTSIDE, Cell, CellGraph, Portal
from belvedere.walkthrough.contacts import facing

KIND, VERSION = "belvedere cells", 1
MAX_BYTES = 64 << 20
DECIMALS = 4
"""Tenths of a millimetre."""

__all__ = ["load_graph", "save_graph"]


def save_graph(graph: CellGraph, path: str | Path, *, force: bool = True) -> Path:
    """Write cells and portals as JSON, atomically.

    Args:
        graph: cells and portals.
        path: the file.
        force: replace a file that is there.

    Raises:
        OutputError: the file is there and must stay, or cannot be written.
    """
    from belvedere.scene.io import atomic_write

    cells = [
        {
            "name": cell.name,
            "storey": cell.storey,
            "floor": round(cell.floor, DECIMALS),
            "ceiling": round(cell.ceiling, DECIMALS),
            "rings": [_rounded(ring) for ring in cell.rings],
        }
        for cell in graph.cells
    ]
    portals = [
        {
            "name": portal.name,
            "kind": portal.kind,
            "cells": [None if c == OUTSIDE else graph.cells[c].name for c in portal.cells],
            "corners": _rounded(portal.corners),
        }
        for portal in graph.portals
    ]
    entries = {"cells": cells, "portals": portals}
    head = f'{{\n "kind": "{KIND}",\n "version": {VERSION},\n "unit": "metre",\n "up": "z"'
    text = head
    for key, members in entries.items():
        lines = ",\n".join("  " + json.dumps(member, ensure_ascii=False) for member in members)
        text += f',\n "{key}": [\n{lines}\n ]' if members else f',\n "{key}": []'
    with atomic_write(path, force=force) as temporary:
        Path(temporary).write_text(text + "\n}\n", encoding="utf-8")
    return Path(path)


def _rounded(points: Any) -> list[list[float]]:
    return [[round(float(v), DECIMALS) for v in point] for point in points]


def load_graph(path: str | Path) -> CellGraph:
    """Read cells and portals.

    Portals may name their cells or count them; their corners may run either way round.

    Raises:
        MissingFileError: no such file.
        FileFormatError: not JSON, of another kind or a newer version; something is missing or
            wrong: the message begins with the file and the key.
    """
    file = Path(path)
    if not file.is_file():
        raise MissingFileError(f"{file}: no such file")
    if file.stat().st_size > MAX_BYTES:
        raise FileFormatError(f"{file}: {file.stat().st_size:,} bytes: no list of cells is so long")
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise FileFormatError(f"{file}: not JSON: {error}") from error
    if not isinstance(data, dict) or data.get("kind") != KIND:
        raise FileFormatError(f'{file}: kind is not "{KIND}": no file of cells and portals')
    if data.get("version") != VERSION:
        raise FileFormatError(
            f"{file}: version is {data.get('version')!r}, this belvedere reads {VERSION}"
        )
    if data.get("unit", "metre") != "metre" or data.get("up", "z") != "z":
        raise FileFormatError(f'{file}: unit must be "metre" and up "z": convert the numbers')
    cells = tuple(_cell(file, k, e) for k, e in enumerate(_entries(file, data, "cells")))
    if not cells:
        raise FileFormatError(f"{file}: cells is empty: at least one is needed")
    portals = tuple(
        _portal(file, k, e, cells) for k, e in enumerate(_entries(file, data, "portals"))
    )
    try:
        return CellGraph(cells, portals)
    except SceneError as error:
        raise FileFormatError(f"{file}: {error}") from error


def _entries(file: Path, data: dict[str, Any], key: str) -> list[dict[str, Any]]:
    entries = data.get(key)
    if not isinstance(entries, list):
        raise FileFormatError(f"{file}: {key} is missing or no list")
    for k, entry in enumerate(entries):
        if not isinstance(entry, dict):
            raise FileFormatError(f"{file}: {key}[{k}] is {entry!r:.60}, expected an object")
    return entries


def _name(file: Path, at: str, entry: dict[str, Any]) -> str:
    name = entry.get("name")
    if not isinstance(name, str) or not name:
        raise FileFormatError(f"{file}: {at}.name is {name!r:.60}, expected text")
    return name


def _number(file: Path, at: str, entry: dict[str, Any], key: str) -> float:
    value = entry.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise FileFormatError(f"{file}: {at}.{key} is {value!r:.60}, expected a finite number")
    return float(value)


def _points(file: Path, at: str, value: Any, least: int, axes: int) -> Any:
    try:
        points = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise FileFormatError(f"{file}: {at} is no list of points") from error
    if points.ndim != 2 or points.shape[1] != axes or len(points) < least:
        raise FileFormatError(
            f"{file}: {at} has shape {points.shape}, expected ({least} or more, {axes})"
        )
    if not np.isfinite(points).all():
        raise FileFormatError(f"{file}: {at} holds numbers that are not finite")
    return points


def _cell(file: Path, k: int, entry: dict[str, Any]) -> Cell:
    at = f"cells[{k}]"
    rings = entry.get("rings")
    if not isinstance(rings, list) or not rings:
        raise FileFormatError(f"{file}: {at}.rings is missing, no list or empty")
    floor, ceiling = (_number(file, at, entry, key) for key in ("floor", "ceiling"))
    if ceiling <= floor:
        raise FileFormatError(
            f"{file}: {at}.ceiling is {ceiling} m, expected more than its floor at {floor} m"
        )
    storey = entry.get("storey", 0)
    if isinstance(storey, bool) or not isinstance(storey, int):
        raise FileFormatError(f"{file}: {at}.storey is {storey!r:.60}, expected a whole number")
    outlines = tuple(_points(file, f"{at}.rings[{n}]", r, 3, 2) for n, r in enumerate(rings))
    return Cell(_name(file, at, entry), outlines, floor, ceiling, storey)


def _portal(file: Path, k: int, entry: dict[str, Any], cells: tuple[Cell, ...]) -> Portal:
    at = f"portals[{k}]"
    kind: Any = entry.get("kind")
    if kind not in get_args(OpeningKind):
        raise FileFormatError(
            f"{file}: {at}.kind is {kind!r:.60}, expected one of {', '.join(get_args(OpeningKind))}"
        )
    sides = entry.get("cells")
    if not isinstance(sides, list) or len(sides) != 2:
        raise FileFormatError(
            f"{file}: {at}.cells is {sides!r:.60}, expected two cells (null: outside)"
        )
    first, second = (_side(file, f"{at}.cells[{n}]", s, cells) for n, s in enumerate(sides))
    if first == OUTSIDE:
        first, second = second, first
    if first == second:
        raise FileFormatError(f"{file}: {at}.cells are the same on both sides: {sides!r:.60}")
    corners = _points(file, f"{at}.corners", entry.get("corners"), 4, 3)
    if len(corners) != 4:
        raise FileFormatError(f"{file}: {at}.corners are {len(corners)}, expected 4")
    try:
        portal = Portal(_name(file, at, entry), kind, corners, (first, second))
    except SceneError as error:
        raise FileFormatError(f"{file}: {at}: {error}") from error
    turned = facing(portal.corners, cells[first])
    return Portal(portal.name, portal.kind, turned, portal.cells)


def _side(file: Path, at: str, value: Any, cells: tuple[Cell, ...]) -> int:
    if value is None or (value == OUTSIDE and not isinstance(value, bool)):
        return OUTSIDE
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value < len(cells):
        return value
    names = [cell.name for cell in cells]
    if isinstance(value, str) and value in names:
        return names.index(value)
    raise FileFormatError(
        f"{file}: {at} is {value!r:.60}, which is no cell of this file (null: outside)"
    )
