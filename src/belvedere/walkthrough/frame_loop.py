"""One frame after another: the view cell's polygons, and pictures behind its portals.

::

    1 look      which cells are in sight, up to the portals that show pictures
    2 draw      the polygons of those cells
    3 warp      for each portal with pictures its nearest references, into its part of the window
    4 compose   show them where nothing stands before the portal

Modes: ``full`` draws every polygon and ``culling`` those of all cells in sight; ``textures`` paints
the nearest reference flat on the portal, ``one`` warps the nearest, ``two`` the two nearest.

Source: Rafferty, Aliaga and Lastra 1998; spec portal-walkthrough 3.2, 3.7.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_choice, check_number
from belvedere.ground.color import LINEAR_TO_SRGB8, SRGB8_TO_LINEAR
from belvedere.ground.errors import CameraError
from belvedere.scene import Camera, Frame, ReferenceView
from belvedere.walkthrough.cells import OUTSIDE, CellGraph
from belvedere.walkthrough.geometry import GeometryDrawer
from belvedere.walkthrough.portal_images import PortalImages
from belvedere.walkthrough.switching import Switches, SwitchOptions
from belvedere.walkthrough.visibility import DOORWAY_M, Sight, Visibility, view_cell
from belvedere.warp import PreparedView, WarpOptions, prepare, warp

F8 = npt.NDArray[np.float64]
Mode = Literal["full", "culling", "textures", "one", "two"]
"""What stands behind portals; see `WalkOptions`."""
MODES: tuple[str, ...] = get_args(Mode)
"""All modes by name."""
Merge = Literal["over", "disparity"]
Fill = Literal["none", "background", "trace"]

KEPT_VIEWS = 512
"""Prepared references that a walker remembers: some 2 GB of them at 65,000 texels each."""
_Target = tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32], npt.NDArray[np.float32]]
"""Color, disparity and coverage of the window."""

__all__ = ["MODES", "FrameStatistics", "Mode", "WalkOptions", "Walker"]


@dataclass(frozen=True, slots=True)
class WalkOptions:
    """How frames are made."""

    mode: Mode = "two"
    """What stands behind portals; see the module."""
    merge: Merge = "disparity"
    """With two references: ``"over"`` warps the second nearest first and the nearest over it, as
    the paper does; ``"disparity"`` lets the nearer surface win and blends where both see it."""
    reconstruction: str = "inverse"
    """Of the warps; see `belvedere.WarpOptions`."""
    persist: bool = False
    """Show in a portal's holes what was seen there in the frames before (an uncleared buffer)."""
    fill: Fill = "trace"
    """What becomes of holes, the pixels behind a portal that no reference saw: ``"trace"`` casts a
    ray for each, ``"background"`` continues what lies around, ``"none"`` leaves them black."""
    reach: float = 1e6
    """Portals farther off than this, metres, are not looked through."""
    switch: SwitchOptions = field(default_factory=SwitchOptions)
    """Where geometry takes over from pictures."""

    def __post_init__(self) -> None:
        check_choice("WalkOptions", "mode", self.mode, MODES)
        check_choice("WalkOptions", "merge", self.merge, get_args(Merge))
        check_choice("WalkOptions", "fill", self.fill, get_args(Fill))
        check_number("WalkOptions", "reach", self.reach, 0.0)
        WarpOptions(reconstruction=self.reconstruction)  # type: ignore[arg-type]


@dataclass(slots=True)
class FrameStatistics:
    """What one frame took."""

    cell: int = -1
    """The cell the eye is in."""
    cells: int = 0
    """Cells whose polygons were drawn."""
    portals: int = 0
    """Portals that showed pictures."""
    references: int = 0
    """Pictures warped."""
    look_ms: float = 0.0
    draw_ms: float = 0.0
    warp_ms: float = 0.0
    compose_ms: float = 0.0
    fill_ms: float = 0.0
    holes: float = 0.0
    """Share of the window that no reference and no polygon covers, before it is filled."""

    @property
    def ms(self) -> float:
        """The whole frame, milliseconds."""
        return self.look_ms + self.draw_ms + self.warp_ms + self.compose_ms + self.fill_ms


class Walker:
    """A visitor's window into a building. Frames depend on those before (fades, kept pixels).

    Args:
        graph: cells and portals.
        drawer: draws the cells' polygons.
        images: pictures by (portal, cell they are seen from).
        options: how.
        threads: how many to use; None for as many as there are processors. Frames are the same.

    Memory: 14 bytes a pixel of the window and its references, up to 56 bytes a sample more for each
    reference that was shown.
    """

    def __init__(
        self,
        graph: CellGraph,
        drawer: GeometryDrawer,
        images: Mapping[tuple[int, int], PortalImages],
        options: WalkOptions | None = None,
        threads: int | None = None,
    ) -> None:
        self.graph, self.drawer, self.images = graph, drawer, images
        self.options = options or WalkOptions()
        self.threads = threads
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
            ]
        ).reshape(-1, 2)
        self._prepared: OrderedDict[tuple[int, int, int], PreparedView] = OrderedDict()
        self._kept = np.zeros((0, 0, 3), np.uint8)
        self._cell = OUTSIDE

    def cut(self) -> None:
        """Begin anew, as after a jump: nothing fades, nothing is kept."""
        self._switches.reset()
        self._kept = np.zeros((0, 0, 3), np.uint8)
        self._cell = OUTSIDE

    def warm(self) -> None:
        """Read and prepare the references of all portals, as far as memory allows, in advance."""
        if self.options.mode in ("full", "culling"):
            return
        for key in self.images:
            if len(self._prepared) == KEPT_VIEWS:
                break
            for index in range(len(self.images[key].references)):
                self._ready(key, index)

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
        everything = self.options.mode == "full"
        color, disparity = self.drawer.draw(camera, None if everything else drawn, self.threads)
        coverage = np.ones(camera.size, dtype=np.float32)
        stats.cells = len(self.graph.cells) if everything else len({s.cell for s in drawn})
        stats.draw_ms = clock.lap()
        for sight in self._pictured(sights, camera):
            self._show(sight, camera, (color, disparity, coverage), stats, clock)
        self.holes = self._find_holes(camera, (color, disparity, coverage))
        frame = Frame(camera, color, disparity, coverage)
        stats.holes = float(self.holes.mean())
        if stats.holes > 0.0 and self.options.fill == "background":
            from belvedere.warp.holes import fill_background

            frame = fill_background(frame, threads=self.threads)
        stats.fill_ms = clock.lap()
        self.statistics = stats
        return frame

    def _find_holes(self, camera: Camera, target: _Target) -> npt.NDArray[np.bool_]:
        """Pixels that nothing covers. Rays tell them from the sky, which is behind everything.

        With ``fill="trace"`` the rays' colours are shown; otherwise holes are black, but for what
        ``persist`` keeps.
        """
        color, disparity, coverage = target
        holes = coverage == 0.0
        v, u = np.nonzero(holes)
        if not len(v):
            return holes
        seen, delta = self.drawer.trace(camera, u, v, self.threads)
        sky = delta == 0.0
        known = np.ones(len(v), dtype=bool) if self.options.fill == "trace" else sky
        color[v[known], u[known]] = seen[known]
        disparity[v[known], u[known]] = delta[known]
        coverage[v[known], u[known]] = 1.0
        if not self.options.persist:
            color[v[~known], u[~known]] = 0
        holes[v[sky], u[sky]] = False
        return holes

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
        if self.options.mode in ("full", "culling"):
            if self.options.mode == "full":
                return [], closed
            return self._visibility.look(camera, self._cell, closed, self.options.reach), closed
        self._switches.update(camera.center)
        closed = (self._switches.share == 0.0) & self._has_images[
            np.arange(len(closed)), self._behind(camera.center)
        ]
        return self._visibility.look(camera, self._cell, closed, self.options.reach), closed

    def _front(self, portal: int, camera: Camera) -> int:
        """The cell on the eye's side of a portal."""
        return self.graph.portals[portal].cells[int(self._behind(camera.center)[portal])]

    def _behind(self, eye: F8) -> npt.NDArray[np.intp]:
        """(P,) 0 where the eye is on the side of each portal's first cell, 1 on the other."""
        off = np.einsum("pc,pc->p", eye - self._visibility.corners[:, 0], self._visibility.normals)
        return (off < 0.0).astype(np.intp)

    def _pictured(self, sights: list[Sight], camera: Camera) -> list[Sight]:
        """Sights through portals that show pictures, wholly or still fading; the farthest first."""
        if self.options.mode in ("full", "culling"):
            return []
        shown = [
            s for s in sights
            if s.portal >= 0 and len(s.polygon) and self._switches.share[s.portal] < 1.0
            and (s.portal, self._front(s.portal, camera)) in self.images
        ]  # fmt: skip

        def distance(s: Sight) -> float:
            return float(np.linalg.norm(s.polygon.mean(axis=0)))

        return sorted(shown, key=distance, reverse=True)

    def _show(
        self,
        sight: Sight,
        camera: Camera,
        target: _Target,
        stats: FrameStatistics,
        clock: _Clock,
    ) -> None:
        """Warp one portal's references and put them in their place."""
        from belvedere.walkthrough import _compose

        crop, u0, v0 = _cropped(camera, sight.polygon)
        if crop is None:
            return
        key = (sight.portal, self._front(sight.portal, camera))
        chosen = self.images[key].nearest(camera.center, 2 if self.options.mode == "two" else 1)
        warped = self._warped(key, chosen, crop)
        stats.portals += 1
        stats.references += len(chosen)
        stats.warp_ms += clock.lap()
        color, disparity, coverage = target
        if self.options.persist and self._kept.shape != color.shape:
            self._kept = np.zeros_like(color)
        portal = self.graph.portals[sight.portal]
        height = float(portal.normal @ (portal.center - camera.center))
        _compose.show_through(
            camera.matrix, sight.planes, portal.normal, 1.0 / height, u0, v0, warped.color,
            warped.disparity, warped.coverage, 1.0 - self._switches.share[sight.portal],
            SRGB8_TO_LINEAR, LINEAR_TO_SRGB8, self.options.persist,
            self._kept if self.options.persist else color, color, disparity, coverage,
        )  # fmt: skip
        stats.compose_ms += clock.lap()

    def _warped(self, key: tuple[int, int], chosen: list[int], crop: Camera) -> Frame:
        views = [self._ready(key, index) for index in chosen]
        composite = "blend" if self.options.merge == "disparity" else "nearest"
        return warp(
            views, crop, threads=self.threads, reconstruction=self.options.reconstruction,
            composite=composite, reconcile=False,
        )  # fmt: skip

    def _ready(self, key: tuple[int, int], index: int) -> PreparedView:
        """A reference prepared once; in ``textures`` mode flattened onto its portal."""
        name = (*key, index)
        if name not in self._prepared:
            images = self.images[key]
            view = images.references[index]
            if self.options.mode == "textures":
                view = _flattened(view, images.side.portal.center)
            self._prepared[name] = prepare(view)
            if len(self._prepared) > KEPT_VIEWS:
                self._prepared.popitem(last=False)
        self._prepared.move_to_end(name)
        return self._prepared[name]


class _Clock:
    """Milliseconds since it was last asked."""

    def __init__(self) -> None:
        self._last = time.perf_counter()

    def lap(self) -> float:
        now = time.perf_counter()
        passed, self._last = (now - self._last) * 1e3, now
        return passed


def _cropped(camera: Camera, polygon: F8) -> tuple[Camera | None, int, int]:
    """The window's camera cut to the box round a polygon, and the column and row it begins at.

    ``polygon`` is (N, 3) relative to the eye. None if no pixel's center can lie in the box.
    """
    rays = polygon @ np.linalg.inv(camera.matrix).T
    u, v = rays[:, 0] / rays[:, 2], rays[:, 1] / rays[:, 2]
    u0, u1 = max(int(np.ceil(u.min())), 0), min(int(np.floor(u.max())), camera.width - 1)
    v0, v1 = max(int(np.ceil(v.min())), 0), min(int(np.floor(v.max())), camera.height - 1)
    if u1 < u0 or v1 < v0:
        return None, 0, 0
    matrix = camera.matrix.copy()
    matrix[:, 2] += u0 * matrix[:, 0] + v0 * matrix[:, 1]
    return Camera(matrix, camera.center, u1 - u0 + 1, v1 - v0 + 1), u0, v0


def _flattened(view: ReferenceView, on: F8) -> ReferenceView:
    """The view as a picture painted on the plane of its portal, which it faces."""
    assert isinstance(view.camera, Camera)
    depth = float((on - view.camera.center) @ view.camera.forward)
    return replace(view, disparity=np.full(view.camera.size, 1.0 / depth, dtype=np.float32))
