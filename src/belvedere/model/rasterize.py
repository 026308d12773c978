"""Drawing lit polygons fast: z-buffered triangles, shaded once a pixel.

The picture of `photograph` with one sample a pixel, at the speed of a walk. Triangles are drawn in
bands of rows by as many threads as there are; which face a pixel shows is settled first, then each
pixel is shaded once. Triangles are kept in compact clusters, so that what lies outside a frustum is
skipped by the hundred.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import LINEAR_TO_SRGB8
from belvedere.ground.errors import CameraError, InputError
from belvedere.ground.scratch import scratch
from belvedere.ground.threads import run_parallel, thread_count
from belvedere.model._draw_tables import DrawTables
from belvedere.model.photograph import LitModel, _pixel_angle
from belvedere.scene import Camera, CameraModel

F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]

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
    """(V, 3) metres from the rasterizer's origin."""
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
        self._all: DrawList | None = None

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
        corners = (mesh.vertices[mesh.faces[chosen]] - self.origin).astype(np.float32)
        order = _curve_order(corners.mean(axis=1))
        chosen, corners = chosen[order], corners[order]
        count = len(chosen)
        first = np.arange(0, count + CLUSTER, CLUSTER)[: -(-count // CLUSTER) + 1]
        first[-1] = count
        cluster = np.repeat(np.arange(len(first) - 1), np.diff(first))
        # each vertex once a cluster
        key = cluster[:, None] * np.int64(len(mesh.vertices)) + mesh.faces[chosen]
        unique, place = np.unique(key.ravel(), return_inverse=True)
        owner = unique // max(len(mesh.vertices), 1)
        first_vertex = np.searchsorted(owner, np.arange(len(first)))
        local = place.reshape(-1, 3) - first_vertex[cluster][:, None]
        vertices = mesh.vertices[unique % max(len(mesh.vertices), 1)] - self.origin
        vertices = np.ascontiguousarray(vertices, dtype=np.float32).reshape(-1, 3)
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
        from belvedere.model import _raster, _shade_pixels

        if not isinstance(camera, Camera):
            raise CameraError(
                f"Rasterizer.draw.camera is a {type(camera).__name__}, expected a planar Camera: "
                "belvedere.model.photograph takes every kind"
            )
        if lists is None:
            self._all = self._all or self.prepare()
            lists = [(self._all, None)]
        height, width = camera.size
        face = np.full((height, width), -1, dtype=np.int32)
        disparity = np.zeros((height, width), dtype=np.float32)
        color = np.zeros((height, width, 3), dtype=np.uint8)
        inverse, eye = np.linalg.inv(camera.matrix), camera.center - self.origin
        picture = np.array([0, width - 1, 0, height - 1], dtype=np.int32)
        border = _picture_planes(camera)
        jobs = []
        for drawn, planes in lists:
            rects = np.empty((len(drawn.low), 4), dtype=np.int32)
            limits = border if planes is None else np.vstack([border, planes])
            _raster.cull_clusters(drawn.low, drawn.high, eye, limits, inverse, picture, rects)
            jobs.append((drawn, rects))
        t, sun_color = self._tables, self.model.light.sun_color
        density = t.record.view(np.float32)
        spread = _pixel_angle(camera)

        def work(rows: tuple[int, int]) -> None:
            for drawn, rects in jobs:
                _raster.draw_clusters(
                    drawn.first_vertex, drawn.vertices, drawn.first_face, drawn.corners,
                    drawn.faces, rects, eye, inverse, *rows, width, height, face, disparity,
                )  # fmt: skip
            room = width + _shade_pixels.PAD
            _shade_pixels.shade_pixels(
                face, *rows, camera.matrix, eye, spread, t.plane, t.maps, t.record, density,
                t.base, t.emission, t.texture_of, t.texels, t.sizes, t.places, t.depth,
                LINEAR_TO_SRGB8, t.soft, t.sun, sun_color,
                scratch("shade work", (_shade_pixels.ROWS, room), np.float32),
                scratch("shade cells", (_shade_pixels.WHOLE_ROWS, room), np.int32),
                scratch("shade light", (room, 4), np.float32),
                scratch("shade codes", (4 * room,), np.int32), disparity, color,
            )  # fmt: skip

        bands = thread_count(self.threads) * BANDS_PER_THREAD
        edges = np.unique(np.linspace(0, height, min(bands, height) + 1).astype(int))
        run_parallel(work, list(pairwise(edges)), self.threads)
        return color, disparity, face


def _picture_planes(camera: Camera) -> F8:
    """(4, 3) planes through the eye and the picture's outer edges, pointing inwards."""
    u = np.array([-0.5, camera.width - 0.5, camera.width - 0.5, -0.5])
    v = np.array([-0.5, -0.5, camera.height - 0.5, camera.height - 0.5])
    rays = camera.rays(u, v)
    planes = np.cross(rays, np.roll(rays, -1, axis=0))
    return planes * np.sign(planes @ rays.sum(axis=0))[:, None]


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
