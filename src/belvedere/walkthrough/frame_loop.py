"""One frame after another: the view cell's polygons, and pictures behind its portals.

::

    1 look      which cells are in sight, up to the portals that show pictures
    2 draw      the polygons of those cells; of cells with too many, pictures taken inside them
    3 warp      for each portal with pictures its nearest references, into its part of the window
    4 compose   show them where nothing stands before the portal
    5 fill      what no reference saw

Modes: ``full`` draws every polygon and ``culling`` those of all cells in sight; ``textures`` paints
the nearest reference flat on the portal, ``one`` warps the nearest, ``two`` the two nearest.

Source: Rafferty, Aliaga and Lastra 1998; spec portal-walkthrough 3.2, 3.7.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import CameraError
from belvedere.scene import Camera, Frame, ReferenceView
from belvedere.walkthrough.cell_images import CellImages
from belvedere.walkthrough.cells import OUTSIDE, CellGraph
from belvedere.walkthrough.geometry import GeometryDrawer
from belvedere.walkthrough.portal_images import PortalImages
from belvedere.walkthrough.ready import ReadyReferences
from belvedere.walkthrough.switching import Switches
from belvedere.walkthrough.visibility import DOORWAY_M, Sight, Visibility, view_cell
from belvedere.walkthrough.walk_options import GEOMETRY_MODES, FrameStatistics, WalkOptions
from belvedere.walkthrough.window import Window, cropped
from belvedere.warp import PreparedView, halved, warp

F8 = npt.NDArray[np.float64]

TEXELS_A_PIXEL = 1.7
"""Texels on a pixel's side above which half of them are enough: 0.85 are left then."""
WARMED_HALVINGS = 2
"""How often references are halved in advance."""
LEAST_TEXELS = 32
"""A reference smaller than this, across or down, is not halved."""

__all__ = ["Walker"]


class Walker:
    """A visitor's window into a building. Frames depend on those before (fades, kept pixels).

    Args:
        graph: cells and portals.
        drawer: draws the cells' polygons.
        images: pictures by (portal, cell they are seen from).
        options: how.
        threads: how many to use; None for as many as there are processors. Frames are the same.
        cell_images: pictures of cells from inside, for those that have too many polygons.

    Memory: 14 bytes a pixel of the window, and some 2 GB of references made ready at most.
    """

    def __init__(
        self,
        graph: CellGraph,
        drawer: GeometryDrawer,
        images: Mapping[tuple[int, int], PortalImages],
        options: WalkOptions | None = None,
        threads: int | None = None,
        cell_images: Mapping[int, CellImages] | None = None,
    ) -> None:
        self.graph, self.drawer, self.images = graph, drawer, images
        self.options = options or WalkOptions()
        self.threads = threads
        wanted = self.options.cells == "pictures" and self.options.mode in ("one", "two")
        self.cell_images = cell_images or {} if wanted else {}
        self.statistics = FrameStatistics()
        """Of the last frame."""
        self.holes = np.zeros((0, 0), dtype=bool)
        """(H, W) of the last frame: what neither references nor polygons nor the sky cover."""
        self._visibility = Visibility(graph)
        self._switches = Switches(graph.portals, self.options.switch)
        self._has_images = np.array(
            [
                [(k, cell) in images for cell in portal.cells]
                for k, portal in enumerate(graph.portals)
            ],
            dtype=bool,
        ).reshape(-1, 2)
        self._ready = ReadyReferences()
        self._kept: npt.NDArray[np.uint8] | None = None
        self._cell = OUTSIDE

    def cut(self) -> None:
        """Begin anew, as after a jump: nothing fades, nothing is kept."""
        self._switches.reset()
        self._kept = None
        self._cell = OUTSIDE

    def warm(self) -> None:
        """Read and prepare the references of all portals, as far as memory allows, in advance."""
        if self.options.mode in GEOMETRY_MODES:
            return
        for key in self.images:
            for index in range(len(self.images[key].references)):
                for halvings in range(WARMED_HALVINGS + 1):
                    if self._ready.full:
                        return
                    view = self._portal_view(key, index, halvings)
                    if self.options.reconstruction == "inverse":
                        view.find_surface(True, self.threads)
                self._ready.end_frame()

    def frame(self, camera: Camera) -> Frame:
        """The next frame.

        Raises:
            CameraError: not a planar camera.
        """
        if not isinstance(camera, Camera):
            raise CameraError(
                f"Walker.frame.camera is a {type(camera).__name__}, expected a planar Camera"
            )
        stats, clock = FrameStatistics(), _Clock()
        sights, closed = self._look(camera, stats)
        stats.look_ms = clock.lap()
        drawn = [s for s in sights if s.portal < 0 or not closed[s.portal]]
        window = self._show_cells(drawn, camera, stats, clock)
        for sight in self._pictured(sights, camera):
            self._show_portal(sight, window, stats, clock)
        self._fill_holes(window, stats)
        frame = window.frame
        if stats.holes > 0.0 and self.options.fill == "background":
            from belvedere.warp.holes import fill_background

            frame = fill_background(frame, threads=self.threads)
        stats.fill_ms = clock.lap()
        self._ready.end_frame()
        self.statistics = stats
        return frame

    def _look(
        self, camera: Camera, stats: FrameStatistics
    ) -> tuple[list[Sight], npt.NDArray[np.bool_]]:
        """What is in sight, and which portals end sight because they show pictures."""
        here = view_cell(self.graph, camera.center)
        if here == OUTSIDE and self._cell != OUTSIDE:
            # in a wall's thickness or under a lining, where no cell is: still in the last one
            last = self.graph.cells[self._cell]
            near = np.clip(camera.center, last.low, last.high)
            here = self._cell if np.linalg.norm(camera.center - near) < DOORWAY_M else OUTSIDE
        self._cell = stats.cell = here
        closed = np.zeros(len(self.graph.portals), dtype=bool)
        if self.options.mode == "full":
            return [], closed
        if self.options.mode != "culling":
            self._switches.update(camera.center)
            closed = (self._switches.share == 0.0) & self._has_images[
                np.arange(len(closed)), self._behind(camera.center)
            ]
        return self._visibility.look(camera, self._cell, closed, self.options.reach), closed

    def _show_cells(
        self, drawn: list[Sight], camera: Camera, stats: FrameStatistics, clock: _Clock
    ) -> Window:
        """The cells that are shown themselves, by their polygons or by pictures from inside."""
        pictured = [sight for sight in drawn if sight.cell in self.cell_images]
        plain = [sight for sight in drawn if sight.cell not in self.cell_images]
        inside = bool(pictured) and pictured[0].portal < 0
        stats.pictured_cells = len({sight.cell for sight in pictured})
        polygons = None if inside and not plain else self._drawn(plain, camera, stats)
        stats.draw_ms += clock.lap()
        base = self._from_inside(pictured[0], camera, stats) if inside else polygons
        assert base is not None
        window = Window(base, self._keeping(base), self.threads)
        stats.warp_ms += clock.lap()
        if inside and polygons is not None:
            for sight in plain:
                window.show(self.graph.portals[sight.portal], sight.planes, polygons)
        stats.compose_ms += clock.lap()
        for sight in pictured[inside:]:
            crop = cropped(camera, sight.polygon)
            if crop is None:
                continue
            seen = self._from_inside(sight, crop.camera, stats)
            stats.warp_ms += clock.lap()
            window.show(self.graph.portals[sight.portal], sight.planes, seen, crop, merge=inside)
            stats.compose_ms += clock.lap()
        return window

    def _drawn(self, sights: list[Sight], camera: Camera, stats: FrameStatistics) -> Frame:
        everything = self.options.mode == "full"
        color, disparity = self.drawer.draw(camera, None if everything else sights, self.threads)
        stats.cells = len(self.graph.cells) if everything else len({s.cell for s in sights})
        return Frame(camera, color, disparity, np.ones(camera.size, dtype=np.float32))

    def _from_inside(self, sight: Sight, camera: Camera, stats: FrameStatistics) -> Frame:
        """A cell by its own pictures from the places nearest to the eye."""
        images = self.cell_images[sight.cell]
        chosen = [
            index
            for place in images.nearest(camera.center, self._count)
            for index in images.in_sight(place, camera)
        ]
        stats.references += len(chosen)
        views = [self._ready.get((sight.cell, k), lambda k=k: images.views[k]) for k in chosen]
        return self._warped(views, camera)

    def _pictured(self, sights: list[Sight], camera: Camera) -> list[Sight]:
        """Sights through portals that show pictures, wholly or still fading; the farthest first."""
        if self.options.mode in GEOMETRY_MODES:
            return []
        shown = [
            s for s in sights
            if s.portal >= 0 and len(s.polygon) and self._switches.share[s.portal] < 1.0
            and (s.portal, self._front(s.portal, camera)) in self.images
        ]  # fmt: skip

        def distance(s: Sight) -> float:
            return float(np.linalg.norm(s.polygon.mean(axis=0)))

        return sorted(shown, key=distance, reverse=True)

    def _show_portal(
        self, sight: Sight, window: Window, stats: FrameStatistics, clock: _Clock
    ) -> None:
        """Warp one portal's references and put them in their place."""
        crop = cropped(window.camera, sight.polygon)
        if crop is None:
            return
        key = (sight.portal, self._front(sight.portal, window.camera))
        share = float(self._switches.share[sight.portal])
        # what fades lies over polygons already: a second reference would only fill holes
        count = self._count if share == 0.0 else 1
        chosen = self.images[key].nearest(window.camera.center, count)
        fine = self.images[key].texels_a_pixel(window.camera)
        views = [self._portal_view(key, index, _halvings(fine)) for index in chosen]
        seen = self._warped(views, crop.camera)
        stats.portals += 1
        stats.references += len(chosen)
        stats.warp_ms += clock.lap()
        merge = self._cell in self.cell_images
        window.show(self.graph.portals[sight.portal], sight.planes, seen, crop, 1.0 - share, merge)
        stats.compose_ms += clock.lap()

    def _fill_holes(self, window: Window, stats: FrameStatistics) -> None:
        """Find the pixels that nothing covers. Rays tell them from the sky, which is behind all.

        With ``fill="trace"`` the rays' colours are shown; otherwise holes are black, but for what
        ``persist`` keeps.
        """
        self.holes = np.zeros(window.camera.size, dtype=bool)
        if stats.portals + stats.pictured_cells == 0:
            return
        u, v = window.find_holes()
        if not len(v):
            return
        seen, delta = self.drawer.trace(window.camera, u, v, self.threads)
        sky, frame = delta == 0.0, window.frame
        known = np.ones(len(v), dtype=bool) if self.options.fill == "trace" else sky
        frame.color[v[known], u[known]] = seen[known]
        frame.disparity[v[known], u[known]] = delta[known]
        frame.coverage[v[known], u[known]] = 1.0
        if not self.options.persist:
            frame.color[v[~known], u[~known]] = 0
        self.holes[v[~sky], u[~sky]] = True
        stats.holes = float((~sky).sum() / self.holes.size)

    @property
    def _count(self) -> int:
        """References used for a portal, and places for a cell."""
        return 2 if self.options.mode == "two" else 1

    def _keeping(self, frame: Frame) -> npt.NDArray[np.uint8] | None:
        """What was seen through portals last, if that is to be shown in holes."""
        if not self.options.persist:
            return None
        if self._kept is None or self._kept.shape != frame.color.shape:
            self._kept = np.zeros_like(frame.color)
        return self._kept

    def _front(self, portal: int, camera: Camera) -> int:
        """The cell on the eye's side of a portal."""
        return self.graph.portals[portal].cells[int(self._behind(camera.center)[portal])]

    def _behind(self, eye: F8) -> npt.NDArray[np.intp]:
        """(P,) 0 where the eye is on the side of each portal's first cell, 1 on the other."""
        off = np.einsum("pc,pc->p", eye - self._visibility.corners[:, 0], self._visibility.normals)
        return (off < 0.0).astype(np.intp)

    def _warped(self, views: list[PreparedView], camera: Camera) -> Frame:
        composite = "blend" if self.options.merge == "disparity" else "nearest"
        return warp(
            views, camera, threads=self.threads, reconstruction=self.options.reconstruction,
            composite=composite, reconcile=False,
        )  # fmt: skip

    def _portal_view(self, key: tuple[int, int], index: int, halvings: int = 0) -> PreparedView:
        """A portal's reference, so often halved; in ``textures`` mode flattened onto its portal."""

        def load() -> ReferenceView:
            if halvings > 0:
                finer = self._portal_view(key, index, halvings - 1)
                return halved(finer) if min(finer.disparity.shape) >= LEAST_TEXELS else finer.view
            images = self.images[key]
            view = images.references[index]
            flat = self.options.mode == "textures"
            return _flattened(view, images.side.portal.center) if flat else view

        return self._ready.get((*key, index, halvings), load)


class _Clock:
    """Milliseconds since it was last asked."""

    def __init__(self) -> None:
        self._last = time.perf_counter()

    def lap(self) -> float:
        now = time.perf_counter()
        passed, self._last = (now - self._last) * 1e3, now
        return passed


def _halvings(texels_a_pixel: float) -> int:
    """How often references are halved that have so many texels on a pixel's side."""
    return max(math.ceil(math.log2(max(texels_a_pixel / TEXELS_A_PIXEL, 1e-9))), 0)


def _flattened(view: ReferenceView, on: F8) -> ReferenceView:
    """The view as a picture painted on the plane of its portal, which it faces."""
    assert isinstance(view.camera, Camera)
    depth = float((on - view.camera.center) @ view.camera.forward)
    return replace(view, disparity=np.full(view.camera.size, 1.0 / depth, dtype=np.float32))
