"""The tasks of a preparation that take pictures of cells from inside."""

from __future__ import annotations

from pathlib import Path

from belvedere.model import LitModel
from belvedere.scene import ViewSet
from belvedere.scene.io.json_files import read_json, write_json
from belvedere.walkthrough.cell_images import (
    SIDES,
    CellImageOptions,
    photograph_place,
    places_in,
)
from belvedere.walkthrough.cells import CellGraph
from belvedere.walkthrough.contents import contents_of
from belvedere.walkthrough.walkthrough import place_folder

PLACES = "places.json"
"""Where pictures of cells from inside are taken."""

__all__ = ["make_place_images", "place_cell_images"]


def place_cell_images(
    folder: str, model: LitModel, graph: CellGraph, options: CellImageOptions, threads: int | None
) -> list[tuple[int, int]]:
    """Choose the cells that have too many polygons to draw, and the places for their pictures.

    A cell in which nobody can stand has none.

    Returns:
        (cell, place) of all places.
    """
    from belvedere.walkthrough.free_space import Body, FreeSpace

    path = Path(folder) / PLACES
    if not path.is_file():
        contents = contents_of(model.mesh, graph)
        heavy = [k for k in range(len(graph.cells)) if len(contents.faces(k)) >= options.polygons]
        places: dict[str, list[list[float]]] = {}
        if heavy:
            body = Body(eye=options.eye, head=max(Body().head, options.eye))
            standing = FreeSpace.of_mesh(model.mesh, body).eyes()
            within = graph.cells_at(standing)
            for cell in heavy:
                eyes = standing[within == cell]
                if len(eyes):
                    chosen = places_in(model.caster, eyes, options.spacing, threads)
                    places[str(cell)] = chosen.tolist()
        write_json(path, {"eyes": places})
    found = read_json(path).data["eyes"]
    return [(int(cell), k) for cell, eyes in found.items() for k in range(len(eyes))]


def make_place_images(
    folder: str,
    cell: int,
    place: int,
    model: LitModel,
    options: CellImageOptions,
    threads: int | None,
) -> int:
    """Photograph a cell from one of its places; how many pictures there are."""
    import numpy as np

    from belvedere.scene.io.save import save_views

    target = Path(folder) / place_folder(cell, place)
    if not (target / "transforms.json").is_file():
        eye = read_json(Path(folder) / PLACES).data["eyes"][str(cell)][place]
        views = photograph_place(model, np.array(eye), options, threads)
        save_views(ViewSet.of(views), target, force=True)
    return SIDES
