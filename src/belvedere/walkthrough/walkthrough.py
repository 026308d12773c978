"""A prepared building as a scene.

::

    scene/  belvedere.json      kind, version, units, what it affords, where it came from, counts
            model.glb           the polygons, for other tools
            model.lit           the polygons with their baked light, for us
            cells.json          cells and portals; may be edited by hand
            plan.svg, plan.png  the floor plan
            free.npz            where a visitor can stand
            path.json           a walk through the building
            references/p007-c03/  what is seen through portal 7 from cell 3: a scene folder of its
                                  own, which every other command opens too
            places.json           where pictures were taken inside cells with very many polygons
            references/c003-e01/  what is seen all round from place 1 in cell 3
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from belvedere.ground.errors import MissingFileError, SceneError
from belvedere.model import LitModel
from belvedere.scene import (
    Affordances,
    Camera,
    CameraModel,
    CameraPath,
    Frame,
    ViewingRegion,
)
from belvedere.scene.io.json_files import read_json
from belvedere.scene.io.paths import existing
from belvedere.walkthrough.cell_images import CellImages
from belvedere.walkthrough.cells import CellGraph
from belvedere.walkthrough.contents import contents_of
from belvedere.walkthrough.frame_loop import Walker
from belvedere.walkthrough.free_space import FreeSpace
from belvedere.walkthrough.geometry import CellRasterizer
from belvedere.walkthrough.model_source import digest_of
from belvedere.walkthrough.placement import sides_of
from belvedere.walkthrough.portal_images import PortalImages
from belvedere.walkthrough.stored_images import (
    PLACES,
    StoredCellImages,
    StoredImages,
    place_folder,
    side_folder,
)
from belvedere.walkthrough.walk_options import WalkOptions

KIND, VERSION = "walkthrough", 1
MANIFEST = "belvedere.json"
FREE = "free.npz"
"""Where a visitor can stand; scenes of earlier versions have none."""

__all__ = ["Walkthrough"]


@dataclass(eq=False)
class Walkthrough:
    """A building to walk through. A `belvedere.scene.Scene`; frames of its own by `walker`."""

    graph: CellGraph
    """Cells and portals."""
    model: LitModel
    """The polygons with their light."""
    images: Mapping[tuple[int, int], PortalImages]
    """References by (portal, cell they are seen from)."""
    home: Camera
    """A camera that shows it well."""
    path: CameraPath | None = None
    """A walk through the building, if one is known."""
    options: WalkOptions = field(default_factory=WalkOptions)
    """How `render` makes frames."""
    threads: int | None = None
    """How many to use; None for as many as there are processors."""
    facts: dict[str, Any] = field(default_factory=dict)
    """What its folder says of it."""
    free: Path | None = None
    """A file of its free space; None to find that from the polygons."""
    cell_images: Mapping[int, CellImages] = field(default_factory=dict)
    """Pictures from inside of cells that have very many polygons."""

    @classmethod
    def open(
        cls, path: str | Path, options: WalkOptions | None = None, threads: int | None = None
    ) -> Walkthrough:
        """Open a folder that `prepare` wrote.

        Raises:
            MissingFileError: a part is missing.
            SceneError: the folder is of another kind, or a part does not say what it must.
        """
        from belvedere.model import load_lit_model
        from belvedere.walkthrough.graph_file import load_graph

        folder = Path(path)
        if not folder.is_dir():
            raise MissingFileError(f"{folder}: there is no such folder")
        if not (folder / MANIFEST).is_file():
            raise MissingFileError(
                f"{folder}: is no prepared building: it holds no {MANIFEST}. "
                "`belvedere prepare MODEL -o NAME` makes one of a model"
            )
        facts = read_json(folder / MANIFEST).data
        if facts.get("kind") != KIND:
            raise SceneError(f"{folder}: is a scene of kind {facts.get('kind')!r}, not {KIND!r}")
        if not isinstance(facts.get("version"), int) or facts["version"] > VERSION:
            raise SceneError(
                f"{folder}: is of version {facts.get('version')!r}, and this belvedere knows up to "
                f"{VERSION}: update belvedere"
            )
        graph = load_graph(folder / "cells.json")
        _check_whole(folder, graph, facts)
        way = CameraPath.load(folder / "path.json") if (folder / "path.json").is_file() else None
        model = load_lit_model(folder / "model.lit")
        if way is None:
            home = _first_look(graph)
        else:
            camera = way.camera(way.start)
            assert isinstance(camera, Camera)
            home = camera
        return cls(
            graph, model, StoredImages(folder, graph), home, way, options or WalkOptions(), threads,
            dict(facts), folder / FREE if (folder / FREE).is_file() else None,
            StoredCellImages(folder, len(graph.cells)),
        )  # fmt: skip

    @property
    def affords(self) -> Affordances:
        """Walk anywhere: polygons stand wherever pictures do not; the light is baked."""
        return Affordances("continuous", "global", "fixed")

    @property
    def viewing_region(self) -> ViewingRegion:
        """The box round all cells."""
        import numpy as np

        lows = np.array([cell.low for cell in self.graph.cells])
        highs = np.array([cell.high for cell in self.graph.cells])
        return ViewingRegion(lows.min(axis=0), highs.max(axis=0))

    @cached_property
    def drawer(self) -> CellRasterizer:
        """Draws the cells' polygons; made once for all walkers."""
        return CellRasterizer(self.model, contents_of(self.model.mesh, self.graph))

    @cached_property
    def space(self) -> FreeSpace:
        """Where a visitor can walk; read or made when it is first asked for.

        Raises:
            FileFormatError: the scene's file of it is broken.
            SceneError: there is no such file, and nowhere to stand.
        """
        if self.free is not None:
            return FreeSpace.load(self.free)
        return FreeSpace.of_mesh(self.model.mesh)

    @cached_property
    def _own(self) -> Walker:
        return self.walker()

    def walker(self, options: WalkOptions | None = None) -> Walker:
        """A visitor's window, for frame after frame; several may look at one walkthrough."""
        return Walker(
            self.graph, self.drawer, self.images, options or self.options, self.threads,
            self.cell_images,
        )  # fmt: skip

    def render(self, camera: CameraModel) -> Frame:
        """One frame by itself: nothing fades in and nothing is kept from earlier ones.

        Raises:
            CameraError: not a planar camera.
        """
        self._own.cut()
        return self._own.frame(camera)  # type: ignore[arg-type]


def _check_whole(folder: Path, graph: CellGraph, facts: Mapping[str, Any]) -> None:
    """Whether all pictures are there, and the cells are those they were taken of."""
    known = facts.get("cells_digest")  # earlier scenes say nothing
    if known is not None and known != digest_of(str(folder / "cells.json")):
        raise SceneError(
            f"{folder / 'cells.json'} was changed since the pictures were taken, which are known "
            "by its numbers: prepare the model again with --cells-file and the changed file"
        )
    wanted = [
        side_folder(k, side.cell)
        for k, portal in enumerate(graph.portals)
        for side in sides_of(portal, graph.cells)
    ]
    if facts.get("counts", {}).get("inside"):
        eyes = read_json(existing(folder, PLACES)).data.get("eyes", {})
        wanted += [
            place_folder(int(c), k) for c, places in eyes.items() for k in range(len(places))
        ]
    for name in wanted:
        if not (folder / name).is_dir():
            raise MissingFileError(f"{folder}: {name} is missing: prepare the model again")


def _first_look(graph: CellGraph) -> Camera:
    """From the largest cell's middle towards its first portal."""
    import numpy as np

    from belvedere.walkthrough.placement import EYE_M

    cell = max(
        range(len(graph.cells)),
        key=lambda k: float(np.prod((graph.cells[k].high - graph.cells[k].low)[:2])),
    )
    room = graph.cells[cell]
    eye = (room.low + room.high) / 2.0
    eye[2] = room.floor + EYE_M
    ahead = eye + np.array([1.0, 0.0, 0.0])
    for index in graph.portals_of[cell]:
        target = graph.portals[index].center
        if np.linalg.norm((target - eye)[:2]) > 0.5:
            ahead = np.array([*target[:2], eye[2] - 0.1])
            break
    return Camera.look_at(eye, ahead, width=640, height=512)
