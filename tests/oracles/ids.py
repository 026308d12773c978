"""Which cell every pixel shows, by drawing the whole building: the slow twin of visibility.

No portal decides here. A pixel belongs to the cell that holds the air in front of the surface it
shows; in a doorway, which is in no cell, to the cell on that side of the portal.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from belvedere.model import LitModel, Rasterizer, RayCaster
from belvedere.model.charts import UNIT, Charts
from belvedere.model.lattice import Lattice
from belvedere.model.light import LightMap
from belvedere.scene import Camera
from belvedere.scene.mesh import Material, Mesh
from belvedere.walkthrough import OUTSIDE, CellGraph

F8 = npt.NDArray[np.float64]
Labels = npt.NDArray[np.int64]

NOWHERE = -2
"""In no cell, in no doorway, and not outdoors: within a wall's thickness, or in a closed void."""
LIFT_M = 0.01
"""How far before a surface the air is looked for."""
EDGE_M = 0.02
"""A jamb's surface belongs to its doorway, whose rectangle is no more exact than this."""
WALL_M = 0.6
"""Half the thickest wall with a doorway. Outdoors is what is farther than this from every cell, or
lies under the open sky."""


def without_light(mesh: Mesh) -> LitModel:
    """A mesh as a model that can be drawn, all white: one chart, one point of light."""
    corners, normals = np.zeros((1, 4, 3)), np.zeros((1, 4, 3))
    corners[0, :, :2], normals[..., 2] = UNIT, 1.0
    count = len(mesh.faces)
    charts = Charts(
        corners, normals, np.zeros(1, np.int32), np.zeros(count, np.int32),
        np.zeros((count, 3, 2), np.float32), np.zeros((0, 5)),
    )  # fmt: skip
    point = Lattice(np.zeros(1, np.int32), np.ones((1, 2), np.int32))
    white, dark = np.ones((1, 3), np.float32), np.zeros(1, np.float32)
    plain = replace(mesh, materials=tuple(Material(m.name) for m in mesh.materials), colors=None)
    return LitModel(plain, charts, LightMap(point, white, point, dark, white[0]))


class IdBuffer:
    """Draws a building and says which cell each pixel shows."""

    def __init__(self, mesh: Mesh, graph: CellGraph) -> None:
        self.graph = graph
        self.caster = RayCaster(mesh)
        self._rasterizer = Rasterizer(without_light(mesh), threads=1)
        self._normals = mesh.normals()
        self._boxes = [(cell.low - WALL_M, cell.high + WALL_M) for cell in graph.cells]

    def draw(self, camera: Camera) -> tuple[Labels, F8]:
        """(H, W) cell, `OUTSIDE` or `NOWHERE`; (H, W) distance in lengths of the pixel's ray."""
        _, disparity, face = self._rasterizer.draw(camera)
        t = np.full(camera.size, np.inf)
        np.divide(1.0, disparity, out=t, where=disparity > 0.0, dtype=np.float64)
        v, u = np.indices(camera.size)
        return self.labels(camera.center, camera.rays(u, v), t, face), t

    def cast(self, camera: Camera, u: Labels, v: Labels) -> tuple[Labels, F8]:
        """As `draw` for some pixels, by rays: edges that meet without sharing corners hold."""
        rays = camera.rays(u, v)
        hits = self.caster.cast(np.broadcast_to(camera.center, rays.shape), rays, 1)
        t = hits.t.astype(np.float64)
        return self.labels(camera.center, rays, t, hits.face), t

    def labels(self, eye: F8, rays: F8, t: F8, face: npt.NDArray[np.int32]) -> Labels:
        """What (..., 3) rays that meet faces at distances ``t`` show."""
        found = np.full(face.shape, OUTSIDE, dtype=np.int64)
        some = face >= 0
        normals, rays = self._normals[face[some]], rays[some]
        away = np.einsum("nc,nc->n", normals, rays) > 0.0
        lift = np.where(away, -LIFT_M, LIFT_M)[:, None] * normals
        found[some] = self.cells_at(eye + t[some][:, None] * rays + lift)
        return found

    def cells_at(self, points: F8) -> Labels:
        """(N,) cell of points, `OUTSIDE` or `NOWHERE`."""
        found = self.graph.cells_at(points).astype(np.int64)
        loose = np.flatnonzero(found == OUTSIDE)
        found[loose] = self.doorways(points[loose])
        lost = loose[found[loose] == NOWHERE]
        x, y, z = points[lost].T
        near = np.zeros(len(lost), dtype=bool)
        for (x0, y0, z0), (x1, y1, z1) in self._boxes:
            near |= (x0 <= x) & (x <= x1) & (y0 <= y) & (y <= y1) & (z0 <= z) & (z <= z1)
        up = np.broadcast_to([0.0, 0.0, 1.0], (len(lost), 3))
        found[lost[~near | ~self.caster.blocked(points[lost], up, threads=1)]] = OUTSIDE
        return found

    def doorways(self, points: F8, portals: npt.ArrayLike | None = None) -> Labels:
        """(N,) the cell on whose side of a portal a point in its doorway lies, or `NOWHERE`."""
        found, nearest = np.full(len(points), NOWHERE), np.full(len(points), WALL_M)
        chosen = range(len(self.graph.portals)) if portals is None else np.asarray(portals)
        for index in chosen:
            portal = self.graph.portals[index]
            c = portal.corners
            off = (points - c[0]) @ portal.normal
            here = np.abs(off) < nearest
            for side in (c[1] - c[0], c[3] - c[0]):
                length = float(np.linalg.norm(side))
                at = (points - c[0]) @ (side / length)
                here &= (at >= -EDGE_M) & (at <= length + EDGE_M)
            found[here] = np.where(off[here] >= 0.0, *portal.cells)
            nearest[here] = np.abs(off[here])
        return found
