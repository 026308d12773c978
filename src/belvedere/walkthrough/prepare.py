"""From a building model to a scene that can be walked through.

::

    1 model       read or built; cells found or as stated; lit   one task
    2 plan        cells checked and drawn; where one can walk    one task
    3 references  placed and photographed                        one task for each side of a portal
    4 places      cells with very many polygons, from inside     one task for each place
    5 scene       the manifest, and the folder gets its name

Each task reads what the ones before wrote and writes its own piece, so they may run anywhere that
sees the folder, and whatever is complete after an interruption is not made again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from belvedere.ground.progress import Progress, silent
from belvedere.ground.version import __version__
from belvedere.scene import Affordances
from belvedere.scene.io.json_files import read_json, write_json
from belvedere.walkthrough.cells import CellGraph
from belvedere.walkthrough.job import PrepareJob
from belvedere.walkthrough.model_source import digest_of, is_built_in
from belvedere.walkthrough.placement import sides_of
from belvedere.walkthrough.prepare_options import PrepareOptions
from belvedere.walkthrough.stages import (
    graph_in,
    make_inside,
    make_model,
    make_places,
    make_plan,
    make_references,
)
from belvedere.walkthrough.walkthrough import KIND, MANIFEST, VERSION

__all__ = ["Prepared", "prepare"]


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
    inside: int
    """Pictures of cells from inside."""
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
            "inside": self.inside,
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
    source = str(model) if is_built_in(model) else str(Path(model).absolute())
    description = {
        "model": str(model) if is_built_in(model) else Path(model).name,
        "digest": digest_of(source),
        "cells_file": None if chosen.cells_file is None else digest_of(chosen.cells_file),
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

        stage(make_model, [(folder, source, chosen, workers)], "finding cells, baking light")
        stage(make_plan, [(folder,)], "checking cells, drawing plans")
        graph = graph_in(job.folder)
        items = [
            (folder, k, side.cell, chosen, threads)
            for k, portal in enumerate(graph.portals)
            for side in sides_of(portal, graph.cells)
        ]
        counts = stage(make_references, items, "taking references")
        places = stage(make_places, [(folder, chosen, workers)], "looking for heavy cells")[0]
        items = [(folder, *place, chosen, threads) for place in places]
        inside = stage(make_inside, items, "taking pictures inside cells") if items else []
        manifest = _manifest(job, graph, sum(counts), sum(inside))
        write_json(job.folder / MANIFEST, manifest)
    held = manifest["counts"]
    size = sum(f.stat().st_size for f in target.rglob("*") if f.is_file())
    return Prepared(
        Path(output), tuple(cell.name for cell in graph.cells), held["portals"], held["doors"],
        held["references"], held["inside"], size, time.perf_counter() - began,
        tuple(manifest["findings"]),
    )  # fmt: skip


def _manifest(job: PrepareJob, graph: CellGraph, references: int, inside: int) -> dict[str, Any]:
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
            "inside": inside,
        },
        "cells_digest": digest_of(str(job.folder / "cells.json")),
        "findings": [*notes, *told],
        "provenance": {
            "model": job.description["model"],
            "digest": job.description["digest"],
            "options": job.description["options"],
            "written_by": f"belvedere {__version__}",
        },
    }
