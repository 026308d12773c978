"""Models by their name: a file's or a built-in house's polygons, and the cells that are in them."""

from __future__ import annotations

import hashlib
import warnings
from pathlib import Path
from typing import Any

from belvedere.ground.errors import MissingFileError, SceneError
from belvedere.walkthrough.cells import CellGraph
from belvedere.walkthrough.prepare_options import PrepareOptions

__all__ = ["cells_of", "digest_of", "is_built_in", "read_source"]


def is_built_in(model: str | Path) -> bool:
    """Whether a name stands for one of `belvedere.model.HOUSES`."""
    return str(model).startswith("built-in:")


def digest_of(source: str) -> str:
    """A short hash of a file's bytes; a built-in house is known by its name."""
    if is_built_in(source):
        return source
    path = Path(source)
    if not path.is_file():
        raise MissingFileError(f"{source}: there is no such file")
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()[:16]


def read_source(source: str, options: PrepareOptions) -> tuple[Any, Any, list[str]]:
    """The polygons of a model, what it states of its rooms, and what was lost."""
    from belvedere.model import build_unlit_house, read_model

    if is_built_in(source):
        house = build_unlit_house(source.partition(":")[2], options.seed, detail=options.detail)
        return house.mesh, house.plan.building(), []
    found = read_model(source, units=options.units, up=options.up, doors=options.doors)  # type: ignore[arg-type]
    return found.mesh, found.building, list(found.dropped)


def cells_of(mesh: Any, building: Any, options: PrepareOptions) -> tuple[CellGraph, list[str]]:
    """The cells of a model, from where the options say, and warnings.

    Raises:
        SceneError: none can be found; the options ask for stated ones and there are none.
    """
    from belvedere.walkthrough.automatic import find_cells
    from belvedere.walkthrough.graph_file import load_graph
    from belvedere.walkthrough.stated import cells_of_building

    if options.cells_file is not None:
        return load_graph(options.cells_file), []
    if building is not None and options.cells != "found":
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            graph = cells_of_building(building, mesh)
        return graph, [f"warning: {one.message}" for one in caught]
    if options.cells == "stated":
        raise SceneError(
            "the model states no rooms: prepare it with cells found in its free space "
            "(--cells found), or write a side file, see docs/formats.md"
        )
    return find_cells(mesh), []
