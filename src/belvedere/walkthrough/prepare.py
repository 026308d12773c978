"""From a building model to a scene that can be walked through.

::

    1 model       read or built, lit                             one task
    2 cells       found or as stated, checked, drawn as a plan   one task
    3 references  placed and photographed                        one task for each side of a portal
    4 scene       the manifest, and the folder gets its name

Each task reads what the ones before wrote and writes its own piece, so they may run anywhere that
sees the folder, and whatever is complete after an interruption is not made again.
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from belvedere.ground.checks import check_choice, check_number
from belvedere.ground.errors import MissingFileError, SceneError
from belvedere.ground.progress import Progress, silent
from belvedere.ground.version import __version__
from belvedere.scene import Affordances, ViewSet
from belvedere.scene.io.json_files import read_json, write_json
from belvedere.walkthrough.cells import CellGraph
from belvedere.walkthrough.job import PrepareJob
from belvedere.walkthrough.placement import (
    PlacementOptions,
    reference_camera,
    semicircle_eyes,
    sides_of,
)
from belvedere.walkthrough.walkthrough import KIND, MANIFEST, VERSION, side_folder

Placement = Literal["error", "arc"]
CellSource = Literal["auto", "stated", "found"]

__all__ = ["Estimate", "PrepareOptions", "Prepared", "estimate", "prepare"]


@dataclass(frozen=True, slots=True)
class PrepareOptions:
    """Everything that the prepared scene depends on, beside the model."""

    cells: CellSource = "auto"
    """``"stated"`` takes rooms and openings from the model (IFC, glTF extras, a side file),
    ``"found"`` looks for them in its free space, ``"auto"`` takes what is stated, if anything."""
    cells_file: str | None = None
    """A ``cells.json`` to use instead, such as an earlier one that was edited by hand."""
    placement: Placement = "error"
    """``"error"`` puts references where they remove most holes, ``"arc"`` evenly on an arc."""
    bound: float = 0.0
    """With ``"error"``: mean share of holes at which fewer references are enough."""
    references: PlacementOptions = field(default_factory=PlacementOptions)
    """How many, how fine, how high."""
    units: str | None = None
    """Of the model's coordinates, where its format does not say or says it wrongly."""
    up: str | None = None
    """Its axis that points up, likewise."""
    doors: Literal["open", "closed"] = "open"
    """Whether door leaves that can be told are left out."""
    rays: int = 64
    """Gathered for each point of light; fewer is quicker and blotchier."""
    seed: int = 0
    """Of a built-in house."""
    detail: int = 1
    """Of a built-in house: so many times its polygons, in the same shapes."""

    def __post_init__(self) -> None:
        owner = "PrepareOptions"
        check_choice(owner, "cells", self.cells, get_args(CellSource))
        check_choice(owner, "placement", self.placement, get_args(Placement))
        check_choice(owner, "doors", self.doors, ("open", "closed"))
        check_number(owner, "bound", self.bound, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Prepared:
    """What a preparation made."""

    output: Path
    """The scene's folder."""
    cells: tuple[str, ...]
    """Their names."""
    portals: int
    doors: int
    """Portals that people walk through."""
    references: int
    bytes: int
    """On disk."""
    seconds: float
    """This call."""
    findings: tuple[str, ...]
    """What the check of the cells, and the reading of the model, had to say."""

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "output": self.output.name,
            "cells": len(self.cells),
            "portals": self.portals,
            "doors": self.doors,
            "references": self.references,
            "bytes": self.bytes,
            "seconds": round(self.seconds, 2),
            "cell_names": list(self.cells),
            "findings": list(self.findings),
        }


def prepare(
    model: str | Path,
    output: str | Path,
    *,
    options: PrepareOptions | None = None,
    cluster: str | None = None,
    workers: int | None = None,
    force: bool = False,
    progress: Progress = silent,
) -> Prepared:
    """Prepare a building model for walking through.

    ::

        prepare("house.ifc", "house-scene")
        prepare("built-in:flat", "flat")

    A call that was interrupted, however hard, goes on when it is repeated, and ends with the same
    bytes.

    Args:
        model: a glTF, OBJ, PLY or IFC file, or ``built-in:NAME`` with a name of
            `belvedere.model.HOUSES`.
        output: the folder to make.
        options: what the scene depends on.
        cluster: ``tcp://HOST:PORT`` of a Dask scheduler whose workers see the same files; None
            for this machine.
        workers: threads on this machine; None for as many as there are processors.
        force: replace an existing scene, or start an interrupted one anew.
        progress: told stage by stage.

    Raises:
        OutputError: the folder exists without ``force``, is not a scene, or cannot be written;
            another process is preparing it.
        MissingFileError, FileFormatError, SceneError: the model is missing or of no use.
        MissingDependencyError: an extra is not installed.

    Memory: on each machine the model with its light (some 600 bytes a polygon).
    """
    import time

    from belvedere.walkthrough.tasks import crew

    began = time.perf_counter()
    chosen = options or PrepareOptions()
    target = Path(output).absolute()
    source = str(model) if _is_built_in(model) else str(Path(model).absolute())
    description = {
        "model": str(model) if _is_built_in(model) else Path(model).name,
        "digest": _digest(source),
        "cells_file": None if chosen.cells_file is None else _digest(chosen.cells_file),
        "options": {k: v for k, v in asdict(chosen).items() if k != "cells_file"},
        "belvedere": __version__,
    }
    with (
        PrepareJob.working_on(target, description, force) as job,
        crew(cluster, workers) as workers_of,
    ):
        folder = str(job.folder)
        # on this machine the long single tasks use every thread; photographs one each
        threads = 1 if workers_of.local else None

        def stage(task: Callable[..., Any], items: list[tuple[Any, ...]], what: str) -> list[Any]:
            return workers_of.run(task, items, lambda done, total: progress(done, total, what))

        stage(make_model, [(folder, source, chosen, workers)], "lighting the model")
        stage(make_cells, [(folder, chosen)], "finding cells and portals")
        graph = _graph(job.folder)
        items = [
            (folder, k, side.cell, chosen, threads)
            for k, portal in enumerate(graph.portals)
            for side in sides_of(portal, graph.cells)
        ]
        counts = stage(make_references, items, "taking references")
        manifest = _manifest(job, graph, sum(counts))
        write_json(job.folder / MANIFEST, manifest)
    held = manifest["counts"]
    size = sum(f.stat().st_size for f in target.rglob("*") if f.is_file())
    return Prepared(
        Path(output), tuple(cell.name for cell in graph.cells), held["portals"], held["doors"],
        held["references"], size, time.perf_counter() - began, tuple(manifest["findings"]),
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Estimate:
    """What a preparation would take, told beforehand."""

    cells: int
    portals: int
    references: int
    """Pictures at most: error-driven placement may need fewer."""
    bytes: int
    """On disk, about."""
    minutes: float
    """On this machine, about."""

    @property
    def summary(self) -> str:
        """One line."""
        return (
            f"{self.cells} cells, {self.portals} portals, at most {self.references} references, "
            f"about {self.bytes / 1e6:.0f} MB and {self.minutes:.1f} minutes"
        )

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self) | {"minutes": round(self.minutes, 2)}


def estimate(
    model: str | Path,
    options: PrepareOptions | None = None,
    *,
    workers: int | None = None,
    progress: Progress = silent,
) -> Estimate:
    """How many pictures, bytes and minutes a preparation would be; nothing is written.

    The model is read and its cells are found; then rays are cast for a moment to see how quick this
    machine is with this model. Light is not baked, so minutes are a guess within a factor of two.

    Args:
        model: see `prepare`.
        options: see `prepare`.
        workers: threads; None for as many as there are processors.
        progress: told stage by stage.

    Raises:
        MissingFileError, FileFormatError, SceneError: the model is missing or of no use.
    """
    import time

    from belvedere.ground.threads import thread_count
    from belvedere.model import RayCaster

    chosen = options or PrepareOptions()
    source = str(model) if _is_built_in(model) else str(Path(model).absolute())
    _digest(source)
    began = time.perf_counter()
    progress(0, 2, "looking at the model")
    mesh, building, _ = read_source(source, chosen)
    progress(1, 2, "looking at the model")
    graph, _ = cells_of(mesh, building, chosen)
    looked = time.perf_counter() - began
    caster = RayCaster(mesh)
    low, high = mesh.bounds
    rng = np.random.default_rng(0)
    starts, ways = low + rng.random((100_000, 3)) * (high - low), rng.normal(size=(100_000, 3))
    began = time.perf_counter()
    caster.cast(starts, ways, workers)
    ray = (time.perf_counter() - began) / len(starts)
    progress(2, 2, "looking at the model")
    sides = [side for portal in graph.portals for side in sides_of(portal, graph.cells)]
    texels = 0
    for side in sides:
        eye = semicircle_eyes(side, chosen.references, 1)[0]
        camera, _near = reference_camera(side, eye, chosen.references)
        texels += chosen.references.count * camera.width * camera.height
    area = 0.5 * np.linalg.norm(
        np.cross(*(mesh.vertices[mesh.faces[:, k]] - mesh.vertices[mesh.faces[:, 0]]
                   for k in (1, 2))), axis=1
    ).sum()  # fmt: skip
    points = min(area / 0.13**2, 3e6) + 1.5 * len(mesh.faces)
    rays = points * chosen.rays * 0.5 + (PLACING_RAYS if chosen.placement == "error" else 0) * len(
        sides
    )
    pixel = TEXEL_S / thread_count(workers)
    return Estimate(
        len(graph.cells), len(graph.portals), chosen.references.count * len(sides),
        int(texels * TEXEL_BYTES + len(mesh.faces) * FACE_BYTES),
        (looked + rays * ray * 2.0 + texels * pixel) / 60.0,
    )  # fmt: skip


TEXEL_BYTES = 3.2
"""Of a reference on disk: PNG colour and depth, as measured on the built-in houses."""
FACE_BYTES = 250
"""Of a face on disk: its polygons twice, and light."""
TEXEL_S = 1.5e-6
"""Seconds of one thread for a texel of nine samples, on a laptop of 2020."""
PLACING_RAYS = 24 * 36 * 256
"""Shadow rays that place the references of one side."""


# ---- tasks: functions of their own, so that workers elsewhere know them --------------------------


def read_source(source: str, options: PrepareOptions) -> tuple[Any, Any, list[str]]:
    """The polygons of a model, what it states of its rooms, and what was lost."""
    from belvedere.model import build_unlit_house, read_model

    if _is_built_in(source):
        house = build_unlit_house(source.partition(":")[2], options.seed, detail=options.detail)
        return house.mesh, house.plan.building(), []
    found = read_model(source, units=options.units, up=options.up, doors=options.doors)  # type: ignore[arg-type]
    return found.mesh, found.building, list(found.dropped)


def make_model(folder: str, source: str, options: PrepareOptions, threads: int | None) -> None:
    """Read or build the model, light it, and write it for us and for other tools."""
    from belvedere.model import build_house, light_model, save_lit_model, write_glb

    here = Path(folder)
    if (here / "model.json").is_file():
        return
    if _is_built_in(source):
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


def make_cells(folder: str, options: PrepareOptions) -> None:
    """Find cells and portals, check them, draw the plan, and lay a walk through them."""
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
    if not (here / "path.json").is_file():
        try:
            tour(graph, FreeSpace.of_mesh(mesh)).save(here / "path.json")
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
    model, graph = _lit(folder), _graph(Path(folder))
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


def _graph(folder: Path) -> CellGraph:
    return _graph_of(str(folder), (folder / "cells.json").stat().st_mtime_ns)


def _manifest(job: PrepareJob, graph: CellGraph, references: int) -> dict[str, Any]:
    told = read_json(job.folder / "findings.json").data["findings"]
    notes = read_json(job.folder / "model.json").data["notes"]
    return {
        "kind": KIND,
        "version": VERSION,
        "units": "metres",
        "affords": Affordances("continuous", "global", "fixed").as_dict(),
        "counts": {
            "cells": len(graph.cells),
            "portals": len(graph.portals),
            "doors": sum(portal.walkable for portal in graph.portals),
            "references": references,
        },
        "findings": [*notes, *told],
        "provenance": {
            "model": job.description["model"],
            "digest": job.description["digest"],
            "options": job.description["options"],
            "written_by": f"belvedere {__version__}",
        },
    }


def _is_built_in(model: str | Path) -> bool:
    return str(model).startswith("built-in:")


def _digest(source: str) -> str:
    """A short hash of a file's bytes; a built-in house is known by its name."""
    if _is_built_in(source):
        return source
    path = Path(source)
    if not path.is_file():
        raise MissingFileError(f"{source}: there is no such file")
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()[:16]
