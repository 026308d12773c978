"""What a preparation would take, told beforehand."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from belvedere.ground.progress import Progress, silent
from belvedere.ground.wording import counted
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough.cell_images import SIDES, CellImageOptions, box_cameras
from belvedere.walkthrough.cells import CellGraph
from belvedere.walkthrough.contents import contents_of
from belvedere.walkthrough.model_source import cells_of, digest_of, is_built_in, read_source
from belvedere.walkthrough.placement import reference_camera, semicircle_eyes, sides_of
from belvedere.walkthrough.prepare_options import PrepareOptions

TEXEL_BYTES = 3.2
"""Of a reference on disk: PNG colour and depth, as measured on the built-in houses."""
FACE_BYTES = 250
"""Of a face on disk: its polygons twice, and light."""
TEXEL_S = 1.5e-6
"""Seconds of one thread for a texel of nine samples, on a laptop of 2020."""
PLACE_AREA = 0.9
"""Square metres of a cell for each place, in squares of their distance."""
PLACING_RAYS = 24 * 36 * 256
"""Shadow rays that place the references of one side."""

__all__ = ["Estimate", "estimate"]


@dataclass(frozen=True, slots=True)
class Estimate:
    """What a preparation would take, told beforehand."""

    cells: int
    portals: int
    references: int
    """Pictures at most: error-driven placement may need fewer."""
    inside: int
    """Pictures of cells from inside, about."""
    bytes: int
    """On disk, about."""
    minutes: float
    """On this machine, about."""

    @property
    def summary(self) -> str:
        """One line."""
        few = self.minutes < 1.0
        time = "less than a minute" if few else counted(round(self.minutes), "minute")
        return (
            f"{counted(self.cells, 'cell')}, {counted(self.portals, 'portal')}, at most "
            f"{counted(self.references, 'reference')}, "
            + (f"{counted(self.inside, 'picture')} inside cells, " if self.inside else "")
            + f"about {self.bytes / 1e6:.0f} MB and {time}"
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
    source = str(model) if is_built_in(model) else str(Path(model).absolute())
    digest_of(source)
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
    places = _places(mesh, graph, chosen.inside)
    cameras = box_cameras(np.zeros(3), chosen.inside.texels)
    texels += places * sum(camera.width * camera.height for camera in cameras)
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
        len(graph.cells), len(graph.portals), chosen.references.count * len(sides), SIDES * places,
        int(texels * TEXEL_BYTES + len(mesh.faces) * FACE_BYTES),
        (looked + rays * ray * 2.0 + texels * pixel) / 60.0,
    )  # fmt: skip


def _places(mesh: Mesh, graph: CellGraph, options: CellImageOptions) -> int:
    """From how many places heavy cells would be photographed, about."""
    contents = contents_of(mesh, graph)
    heavy = [c for k, c in enumerate(graph.cells) if len(contents.faces(k)) >= options.polygons]
    each = PLACE_AREA * options.spacing**2
    return sum(int(np.ceil(np.prod((cell.high - cell.low)[:2]) / each)) for cell in heavy)
