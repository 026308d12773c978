"""The tasks of a preparation: functions of their own, so that workers elsewhere know them.

Each does nothing where its piece is in the work folder already, and else writes it whole.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from belvedere.ground.errors import SceneError
from belvedere.scene import ViewSet
from belvedere.scene.io.json_files import read_json, write_json
from belvedere.walkthrough.cells import CellGraph
from belvedere.walkthrough.model_source import cells_of, is_built_in, read_source
from belvedere.walkthrough.placement import semicircle_eyes, sides_of
from belvedere.walkthrough.prepare_options import PrepareOptions
from belvedere.walkthrough.stored_images import PLACES, place_folder, side_folder
from belvedere.walkthrough.walkthrough import FREE

__all__ = [
    "graph_in",
    "make_inside",
    "make_model",
    "make_places",
    "make_plan",
    "make_references",
]


def make_model(folder: str, source: str, options: PrepareOptions, threads: int | None) -> None:
    """Read or build the model, find its cells, light it, and write it for us and other tools.

    Cells come before light: where the model states no rooms, lamps hang in those that are found.
    """
    from belvedere.model import build_house, light_model, save_lit_model, write_glb
    from belvedere.walkthrough.graph_file import save_graph

    here = Path(folder)
    if (here / "model.json").is_file():
        return
    if is_built_in(source):
        model = build_house(
            source.partition(":")[2], options.seed, detail=options.detail, rays=options.rays,
            threads=threads,
        )  # fmt: skip
        building, notes = model.building, []
        graph, told = cells_of(model.mesh, building, options)
        model.path.save(here / "path.json")
    else:
        mesh, building, notes = read_source(source, options)
        graph, told = cells_of(mesh, building, options)
        rooms = building or _rooms_of(graph)
        model = light_model(mesh, rooms, rays=options.rays, threads=threads)
    save_lit_model(here / "model.lit", model)
    write_glb(here / "model.glb", model.mesh, building, force=True)
    stated = None if building is None else building.as_dict()
    save_graph(graph, here / "cells.json")
    write_json(here / "model.json", {"notes": [*notes, *told], "building": stated})


def _rooms_of(graph: CellGraph) -> Any:
    """Found cells as rooms, for their lamps."""
    from belvedere.model import Building, Room

    return Building(
        tuple(Room(cell.name, cell.rings, cell.floor, cell.ceiling) for cell in graph.cells)
    )


def make_plan(folder: str) -> None:
    """Check the cells, draw their plan, and say where one can walk."""
    from belvedere.walkthrough.checking import check_cells
    from belvedere.walkthrough.free_space import FreeSpace
    from belvedere.walkthrough.plan import draw_plan
    from belvedere.walkthrough.tour import tour

    here = Path(folder)
    if (here / "findings.json").is_file():
        return
    mesh, graph = _lit(folder).mesh, graph_in(here)
    findings = [str(finding) for finding in check_cells(graph, mesh)]
    plan = draw_plan(graph, mesh)
    plan.save(here / "plan.svg")
    plan.save(here / "plan.png")
    try:
        space = FreeSpace.of_mesh(mesh)
        space.save(here / FREE)
        if not (here / "path.json").is_file():
            tour(graph, space).save(here / "path.json")
    except SceneError as error:
        findings.append(f"note: no walk was laid through the building: {error}")
    write_json(here / "findings.json", {"findings": findings})


def make_references(
    folder: str, portal: int, cell: int, options: PrepareOptions, threads: int | None
) -> int:
    """Place and photograph the references of one side of a portal; how many there are."""
    from belvedere.scene.io.save import save_views
    from belvedere.walkthrough.error_driven import place_references
    from belvedere.walkthrough.portal_images import take_reference

    target = Path(folder) / side_folder(portal, cell)
    if (target / "transforms.json").is_file():
        return len(read_json(target / "transforms.json").data["frames"])
    model, graph = _lit(folder), graph_in(Path(folder))
    sides = sides_of(graph.portals[portal], graph.cells)
    side = next(s for s in sides if s.cell == cell)
    place = options.references
    if options.placement == "arc":
        eyes = semicircle_eyes(side, place)
    else:
        eyes = place_references(
            model.caster, side, graph.cells[cell], place, place.count, options.bound,
            threads=threads,
        )  # fmt: skip
    views = [take_reference(model, side, eye, place, threads) for eye in eyes]
    save_views(ViewSet.of(views), target, force=True)
    return len(views)


def make_places(folder: str, options: PrepareOptions, threads: int | None) -> list[tuple[int, int]]:
    """Choose the cells with too many polygons to draw, and the places for their pictures.

    A cell in which nobody can stand has none. Returns (cell, place) of all places.
    """
    from belvedere.walkthrough.cell_images import places_in
    from belvedere.walkthrough.contents import contents_of
    from belvedere.walkthrough.free_space import FreeSpace

    path, chosen = Path(folder) / PLACES, options.inside
    if not path.is_file():
        model, graph = _lit(folder), graph_in(Path(folder))
        contents = contents_of(model.mesh, graph)
        heavy = [k for k in range(len(graph.cells)) if len(contents.faces(k)) >= chosen.polygons]
        places: dict[str, list[list[float]]] = {}
        if heavy and (Path(folder) / FREE).is_file():
            standing = FreeSpace.load(Path(folder) / FREE).eyes()
            within = graph.cells_at(standing)
            for cell in heavy:
                eyes = standing[within == cell]
                if len(eyes):
                    found = places_in(model.caster, eyes, chosen.spacing, threads)
                    places[str(cell)] = found.tolist()
        write_json(path, {"eyes": places})
    eyes_of = read_json(path).data["eyes"]
    return [(int(cell), k) for cell, eyes in eyes_of.items() for k in range(len(eyes))]


def make_inside(
    folder: str, cell: int, place: int, options: PrepareOptions, threads: int | None
) -> int:
    """Photograph a cell from one of its places; how many pictures there are."""
    from belvedere.scene.io.save import save_views
    from belvedere.walkthrough.cell_images import SIDES, photograph_place

    target = Path(folder) / place_folder(cell, place)
    if not (target / "transforms.json").is_file():
        eye = np.array(read_json(Path(folder) / PLACES).data["eyes"][str(cell)][place])
        views = photograph_place(_lit(folder), eye, options.inside, threads)
        save_views(ViewSet.of(views), target, force=True)
    return SIDES


@lru_cache(maxsize=1)
def _lit(folder: str) -> Any:
    from belvedere.model import load_lit_model

    return load_lit_model(Path(folder) / "model.lit")


@lru_cache(maxsize=1)
def _graph_of(folder: str, changed: int) -> CellGraph:
    from belvedere.walkthrough.graph_file import load_graph

    del changed
    return load_graph(Path(folder) / "cells.json")


def graph_in(folder: Path) -> CellGraph:
    """The cells of a work folder."""
    return _graph_of(str(folder), (folder / "cells.json").stat().st_mtime_ns)
