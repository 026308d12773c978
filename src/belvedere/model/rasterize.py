"""Drawing lit polygons fast: z-buffered triangles, shaded once a pixel.

The picture of `photograph` with one sample a pixel, at the speed of a walk. Triangles are drawn in
bands of rows by as many threads as there are; which face a pixel shows is settled first, then each
pixel is shaded once. Triangles are kept in compact clusters, so that what lies outside a frustum is
skipped by the hundred.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import LINEAR_TO_SRGB8
from belvedere.ground.errors import CameraError, InputError
from belvedere.ground.scratch import lend, scratch
from belvedere.ground.threads import row_bands, run_parallel, thread_count
from belvedere.model._draw_plan import DrawPlan
from belvedere.model._draw_tables import DrawTables
from belvedere.model.photograph import LitModel, _pixel_angle
from belvedere.scene import Camera, CameraModel

F8 = npt.NDArray[np.float64]
F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
I8 = npt.NDArray[np.int64]

CLUSTER = 80
"""Triangles of a cluster: at most 240 corners, so that one byte names a corner."""
BANDS_PER_THREAD = 6
"""Bands are handed to whichever thread is free."""

__all__ = ["DrawList", "Rasterizer"]


@dataclass(frozen=True, slots=True, eq=False)
class DrawList:
    """Some faces of a model, ready to be drawn; see `Rasterizer.prepare`."""

    faces: I4
    """(F,) face indices, cluster by cluster."""
    first_face: I4
    """(C + 1,) where each cluster's faces begin."""
    corners: npt.NDArray[np.uint8]
    """(F, 3) vertex of the cluster."""
    first_vertex: I4
    """(C + 1,) where each cluster's vertices begin."""
    vertices: npt.NDArray[np.float32]
    """(3, V) metres from the rasterizer's origin."""
    low: npt.NDArray[np.float32]
    """(C, 3) smallest corner of each cluster's box."""
    high: npt.NDArray[np.float32]
    """(C, 3) largest."""


class Rasterizer:
    """Draws one lit model, for frame after frame.

    ::

        rasterizer = Rasterizer(house)
        color, disparity, face = rasterizer.draw(camera)

    Args:
        model: what to draw.
        threads: how many to use; None for as many as there are processors. Pictures are the same.

    Memory: 128 bytes a face, 45 more for each list that a face is in, 11 bytes a pixel, and beside
    the model's own textures and light 8 bytes a texel, 16 a point of soft light, 4 a point of sun.
    """

    def __init__(self, model: LitModel, threads: int | None = None) -> None:
        self.model, self.threads = model, threads
        self.origin = model.mesh.bounds.mean(axis=0)
        self._tables = DrawTables.of(model, self.origin)
        self._vertices = (model.mesh.vertices - self.origin).astype(np.float32)
        self._corners = _same_vertices(self._vertices)[model.mesh.faces]
        self._all: DrawList | None = None

    @property
    def tables(self) -> DrawTables:
        """What shading looks up, positions counted from `origin`."""
        return self._tables

    def prepare(self, faces: npt.ArrayLike | None = None) -> DrawList:
        """Make some faces ready to be drawn.

        Args:
            faces: (F,) indices; None for all.

        Raises:
            InputError: an index that is no face.
        """
        mesh = self.model.mesh
        total = len(mesh.faces)
        chosen = np.arange(total, dtype=np.int32) if faces is None else np.asarray(faces)
        if chosen.ndim != 1 or chosen.dtype.kind not in "iu":
            raise InputError("Rasterizer.prepare.faces must be a list of face indices")
        if len(chosen) and (chosen.min() < 0 or chosen.max() >= total):
            raise InputError(
                f"Rasterizer.prepare.faces names face {int(chosen.max())}, but there are {total}"
            )
        chosen = chosen[self._tables.plane[chosen, :3].any(axis=1)].astype(np.int32)
        corners = self._vertices[self._corners[chosen]]
        order = _curve_order(corners.mean(axis=1))
        chosen, corners = chosen[order], corners[order]
        count = len(chosen)
        first = np.arange(0, count + CLUSTER, CLUSTER)[: -(-count // CLUSTER) + 1]
        first[-1] = count
        cluster = np.repeat(np.arange(len(first) - 1), np.diff(first))
        # each vertex once a cluster
        key = cluster[:, None] * np.int64(len(mesh.vertices)) + self._corners[chosen]
        unique, place = np.unique(key.ravel(), return_inverse=True)
        owner = unique // max(len(mesh.vertices), 1)
        first_vertex = np.searchsorted(owner, np.arange(len(first)))
        local = place.reshape(-1, 3) - first_vertex[cluster][:, None]
        vertices = self._vertices[unique % max(len(mesh.vertices), 1)]
        vertices = np.ascontiguousarray(vertices.reshape(-1, 3).T)
        low = high = np.zeros((0, 3), dtype=np.float32)
        if count:
            low = np.minimum.reduceat(corners.min(axis=1), first[:-1])
            high = np.maximum.reduceat(corners.max(axis=1), first[:-1])
        return DrawList(
            chosen, first.astype(np.int32), local.astype(np.uint8), first_vertex.astype(np.int32),
            vertices, low, high,
        )  # fmt: skip

    def draw(
        self,
        camera: CameraModel,
        lists: Sequence[tuple[DrawList, F8 | None]] | None = None,
    ) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32], I4]:
        """Draw the model, or parts of it.

        Args:
            camera: planar.
            lists: what to draw, each with the (K, 3) planes through the eye, pointing inwards,
                that it is seen within (None: within the picture). What lies outside them may be
                drawn too. None draws every face.

        Returns:
            (H, W, 3) sRGB; (H, W) disparity, 0 in the sky; (H, W) face, -1 in the sky. What lies
            within a centimetre of the eye, in depth, is not drawn.

        Raises:
            CameraError: not a planar camera: `photograph` takes the others.
        """
        from belvedere.model import _raster_fill, _raster_setup

        if not isinstance(camera, Camera):
            raise CameraError(
                f"Rasterizer.draw.camera is a {type(camera).__name__}, expected a planar Camera: "
                "belvedere.model.photograph takes every kind"
            )
        if lists is None:
            self._all = self._all or self.prepare()
            lists = [(self._all, None)]
        height, width = camera.size
        block = lend(11 * height * width)
        face, disparity = block[: 8 * height * width].view(np.int32).reshape(2, height, width)
        disparity = disparity.view(np.float32)
        color = block[8 * height * width :].reshape(height, width, 3)
        plan = DrawPlan(camera, self.origin, lists, self.threads)
        tile = _raster_setup.TILE
        tiles = scratch("raster tiles", (-(-height // tile), -(-width // tile)), np.float32)
        tiles.fill(0.0)
        keys = scratch("raster keys", (height, (tiles.shape[1] + 1) * tile), np.int64)
        threads = thread_count(self.threads)
        bands = row_bands(len(tiles), threads * BANDS_PER_THREAD)
        bands = [(first * tile, min(last * tile, height)) for first, last in bands]
        batches = plan.batches()
        for batch in batches:
            room, record = plan.make_room(*batch)

            def set_up(part: tuple[int, I8], room: I8 = room, record: I4 = record) -> None:
                _set_up(lists[part[0]][0], plan, part[1], room, record, tiles, camera)

            def draw(
                rows: tuple[int, int],
                batch: tuple[int, int] = batch,
                room: I8 = room,
                record: I4 = record,
            ) -> None:
                if batch == batches[0]:
                    _raster_fill.clear_keys(*rows, width, keys)
                _raster_fill.draw_records(
                    *batch, plan.rects, room, plan.count, record, record.view(np.float32), *rows,
                    keys,
                )  # fmt: skip
                if batch == batches[-1]:
                    self._shade(camera, plan.eye, rows, keys, face, disparity, color)
                else:
                    _raster_fill.least_disparities(*rows, keys, tiles)

            run_parallel(set_up, plan.parts(*batch, threads), self.threads)
            run_parallel(draw, bands, self.threads)
        return color, disparity, face

    def _shade(
        self, camera: Camera, eye: F8, rows: tuple[int, int], keys: I8, *out: npt.NDArray[Any]
    ) -> None:
        """Shade some rows into face, disparity and color."""
        from belvedere.model import _shade_pixels

        t, room = self._tables, camera.width + _shade_pixels.PAD
        _shade_pixels.shade_pixels(
            keys, *rows, camera.matrix, eye, _pixel_angle(camera), t.plane, t.maps, t.record,
            t.record.view(np.float32), t.tints, t.base, t.emission, t.texture_of, t.texels, t.sizes,
            t.places, t.depth, LINEAR_TO_SRGB8, t.soft, t.sun, self.model.light.sun_color,
            scratch("shade work", (_shade_pixels.ROWS, room), np.float32),
            scratch("shade cells", (_shade_pixels.WHOLE_ROWS, room), np.int32),
            scratch("shade light", (room, 4), np.float32),
            scratch("shade codes", (4 * room,), np.int32), *out,
        )  # fmt: skip


def _set_up(
    drawn: DrawList, plan: DrawPlan, places: I8, room: I8, record: I4, tiles: F4, camera: Camera
) -> None:
    """Find out which triangles of some clusters of a list may show."""
    from belvedere.model import _raster_setup

    _raster_setup.set_up(
        places, plan.cluster, plan.rects, plan.near, room, drawn.first_vertex, drawn.vertices,
        drawn.first_face, drawn.corners, drawn.faces, plan.eye, plan.inverse, camera.width,
        camera.height, tiles, plan.count, record, record.view(np.float32),
    )  # fmt: skip


def _same_vertices(vertices: F4) -> I4:
    """(N,) for each vertex the number of one that stands for all at its place."""
    order = np.lexsort(vertices.T)
    placed = vertices[order]
    new = np.ones(len(order), dtype=np.bool_)
    new[1:] = (placed[1:] != placed[:-1]).any(axis=1)
    same = np.empty(len(order), dtype=np.int32)
    same[order] = order[new][np.cumsum(new) - 1] if len(order) else order
    return same


def _curve_order(points: npt.NDArray[np.float32]) -> npt.NDArray[np.int64]:
    """Places along a Z-order curve through the box of the points: neighbours stay together."""
    if not len(points):
        return np.zeros(0, dtype=np.int64)
    low, high = points.min(axis=0), points.max(axis=0)
    size = max(float((high - low).max()), 1e-9)
    cell = np.clip((points - low) / size * 1023.0, 0, 1023).astype(np.uint64)
    code = np.zeros(len(points), dtype=np.uint64)
    for bit in range(10):
        for axis in range(3):
            taken = (cell[:, axis] >> np.uint64(bit)) & np.uint64(1)
            code |= taken << np.uint64(3 * bit + axis)
    return np.argsort(code, kind="stable")
