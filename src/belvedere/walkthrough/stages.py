"""The tasks of a preparation: functions of their own, so that workers elsewhere know them.

Each does nothing where its piece is in the work folder already, and else writes it whole.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

from belvedere.ground.errors import SceneError
from belvedere.scene import ViewSet
from belvedere.scene.io.json_files import read_json, write_json
from belvedere.walkthrough.cells import CellGraph
from belvedere.walkthrough.model_source import cells_of, is_built_in, read_source
from belvedere.walkthrough.placement import semicircle_eyes, sides_of
from belvedere.walkthrough.prepare_options import PrepareOptions
from belvedere.walkthrough.walkthrough import FREE, side_folder

__all__ = ["graph_in", "make_cells", "make_model", "make_references"]


def make_model(folder: str, source: str, options: PrepareOptions, threads: int | None) -> None:
    """Read or build the model, light it, and write it for us and for other tools."""
    from belvedere.model import build_house, light_model, save_lit_model, write_glb

    here = Path(folder)
    if (here / "model.json").is_file():
        return
    if is_built_in(source):
        model = build_house(
            source.partition(":")[2], options.seed, detail=options.detail, rays=options.rays,
            threads=threads,
        )  # fmt: skip
        building, notes = model.building, []
        model.path.save(here / "path.json")
    else:
        mesh, building, notes = read_source(source, options)
        model = light_model(mesh, building, rays=options.rays, threads=threads)
    save_lit_model(here / "model.lit", model)
    write_glb(here / "model.glb", model.mesh, building, force=True)
    stated = None if building is None else building.as_dict()
    write_json(here / "model.json", {"notes": notes, "building": stated})


def make_cells(folder: str, options: PrepareOptions) -> None:
    """Find cells and portals, check them, draw the plan, and say where one can walk."""
    from belvedere.model import Building
    from belvedere.walkthrough.checking import check_cells
    from belvedere.walkthrough.free_space import FreeSpace
    from belvedere.walkthrough.graph_file import save_graph
    from belvedere.walkthrough.plan import draw_plan
    from belvedere.walkthrough.tour import tour

    here = Path(folder)
    if (here / "cells.json").is_file():
        return
    mesh = _lit(folder).mesh
    stated = read_json(here / "model.json").data["building"]
    building = None if stated is None else Building.from_dict(stated, "model.json: building")
    graph, told = cells_of(mesh, building, options)
    findings = [*told, *(str(finding) for finding in check_cells(graph, mesh))]
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
    save_graph(graph, here / "cells.json")


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
