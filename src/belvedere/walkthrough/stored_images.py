"""The pictures of a prepared scene, read from its folder when they are first asked for."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from belvedere.ground.errors import SceneError
from belvedere.scene import ViewEntry, ViewSet
from belvedere.walkthrough.cell_images import SIDES, CellImages
from belvedere.walkthrough.cells import CellGraph
from belvedere.walkthrough.placement import Side
from belvedere.walkthrough.portal_images import PortalImages

PLACES = "places.json"
"""Where pictures inside cells were taken."""
KEPT_BYTES = 1 << 30
"""Bytes of references that are kept in memory by default."""

__all__ = ["StoredCellImages", "StoredImages", "place_folder", "side_folder"]


def side_folder(portal: int, cell: int) -> str:
    """The folder, inside a scene, of what is seen through a portal from a cell."""
    return f"references/p{portal:03d}-c{cell:03d}"


def place_folder(cell: int, place: int) -> str:
    """The folder, inside a scene, of what is seen all round from a place in a cell."""
    return f"references/c{cell:03d}-e{place:02d}"


class StoredImages(Mapping[tuple[int, int], PortalImages]):
    """The references of a scene by (portal, cell), read when they are first asked for.

    Memory: at most ``kept_bytes`` of pixels, and at least one side's.
    """

    def __init__(self, folder: Path, graph: CellGraph, kept_bytes: int = KEPT_BYTES) -> None:
        self._folder, self._graph, self._limit = folder, graph, kept_bytes
        self._keys = tuple(
            (k, cell)
            for k, portal in enumerate(graph.portals)
            for cell in portal.cells
            if cell >= 0 and (folder / side_folder(k, cell)).is_dir()
        )
        self._known = frozenset(self._keys)
        self._read: OrderedDict[tuple[int, int], PortalImages] = OrderedDict()
        self._bytes = 0
        self._lock = threading.Lock()

    def __contains__(self, key: object) -> bool:
        return key in self._known

    def __iter__(self) -> Iterator[tuple[int, int]]:
        return iter(self._keys)

    def __len__(self) -> int:
        return len(self._keys)

    def __getitem__(self, key: tuple[int, int]) -> PortalImages:
        if key not in self._known:
            raise KeyError(key)
        with self._lock:
            if key in self._read:
                self._read.move_to_end(key)
                return self._read[key]
        images = self._load(key)
        with self._lock:
            self._read[key] = images
            self._bytes += _bytes(images)
            while self._bytes > self._limit and len(self._read) > 1:
                self._bytes -= _bytes(self._read.popitem(last=False)[1])
        return images

    def _load(self, key: tuple[int, int]) -> PortalImages:
        from belvedere.scene.io.detect import read_views

        portal, cell = key
        views = read_views(self._folder / side_folder(portal, cell))
        side = Side(self._graph.portals[portal], cell, self._graph.cells[cell].floor)
        return PortalImages(side, tuple(views[k] for k in range(len(views))))


class StoredCellImages(Mapping[int, CellImages]):
    """The pictures of a scene's cells from inside; each is read when it is first asked for.

    Memory: see `belvedere.scene.ViewSet`, for each cell.
    """

    def __init__(self, folder: Path, cells: int) -> None:
        self._folder = folder
        self._cells = tuple(k for k in range(cells) if (folder / place_folder(k, 0)).is_dir())
        self._read: dict[int, CellImages] = {}

    def __iter__(self) -> Iterator[int]:
        return iter(self._cells)

    def __len__(self) -> int:
        return len(self._cells)

    def __contains__(self, key: object) -> bool:
        return key in self._cells

    def __getitem__(self, key: int) -> CellImages:
        if key not in self._cells:
            raise KeyError(key)
        if key not in self._read:
            self._read[key] = self._load(key)
        return self._read[key]

    def _load(self, cell: int) -> CellImages:
        from belvedere.scene.io.detect import read_views

        entries: list[ViewEntry] = []
        while (folder := self._folder / place_folder(cell, len(entries) // SIDES)).is_dir():
            views = read_views(folder)
            if len(views) != SIDES:
                raise SceneError(f"{folder}: has {len(views)} pictures, expected {SIDES}")
            entries += [replace(one, name=f"{folder.name}/{one.name}") for one in views.entries]
        return CellImages(ViewSet(tuple(entries)))


def _bytes(images: PortalImages) -> int:
    return sum(view.nbytes for view in images.references)
