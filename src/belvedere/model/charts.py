"""Charts: the pieces of surface on which light is stored, and the builder that collects them.

A chart is a bilinear patch with a unit square (s, t) of its own. Its front is the side from which
its corners run counter-clockwise:

    3 (0,1) ---- 2 (1,1)
      |            |          normal towards the reader
    0 (0,0) ---- 1 (1,0)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.scene.mesh import Material, Mesh

F8 = npt.NDArray[np.float64]

UNIT = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
"""(4, 2) the chart coordinates of a quad's corners, in order."""

Rect = tuple[float, float, float, float]
"""(low, low, high, high) corners of a rectangle."""


@dataclass(frozen=True, slots=True, eq=False)
class Charts:
    """Where each face of a mesh lies on the surfaces that carry light."""

    corners: F8
    """(K, 4, 3) corner positions, metres."""
    normals: F8
    """(K, 4, 3) shading normals at the corners, unit; they differ where a surface is curved."""
    material: npt.NDArray[np.int32]
    """(K,) material index."""
    of_face: npt.NDArray[np.int32]
    """(M,) the chart of each face."""
    st: npt.NDArray[np.float32]
    """(M, 3, 2) chart coordinates of each face's corners."""
    cutouts: npt.NDArray[np.float64]
    """(C, 5) chart index, s0, t0, s1, t1: parts of charts where there is no surface."""
    joined: npt.NDArray[np.bool_] | None = None
    """(K,) charts that are pieces of larger surfaces: their corners belong to their neighbours too,
    and light is continuous across them. None: those that are `curved`, light each by itself."""
    covered: bool = True
    """Whether faces cover all of every chart but its cutouts."""
    two_sided: npt.NDArray[np.bool_] | None = None
    """(K,) which charts are seen from both sides; None for none."""

    @property
    def curved(self) -> npt.NDArray[np.bool_]:
        """(K,) whether light is stored at the very corners, which neighbours share."""
        if self.joined is not None:
            return self.joined
        return np.abs(self.normals - self.normals[:, :1]).max(axis=(1, 2)) > 1e-6


class Builder:
    """Collects quads and turns them into a mesh with charts.

    Furniture is made around its own origin and stood in place by `placed`.
    """

    def __init__(self) -> None:
        self.materials: list[Material] = []
        self._corners: list[F8] = []
        self._normals: list[F8] = []
        self._material: list[npt.NDArray[np.int32]] = []
        self._vertices: list[F8] = []
        self._uv: list[F8] = []
        self._st: list[F8] = []
        self._chart: list[npt.NDArray[np.int32]] = []
        self._cutouts: list[tuple[float, ...]] = []
        self._count = 0
        self._rotation = np.eye(3)
        self._shift = np.zeros(3)

    def material(
        self,
        name: str,
        color: Sequence[float],
        texture: npt.NDArray[np.uint8] | None = None,
        emission: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> int:
        """Add a material; gives its index."""
        r, g, b = (float(c) for c in color)
        er, eg, eb = (float(c) for c in emission)
        self.materials.append(Material(name, (r, g, b), texture, (er, eg, eb)))
        return len(self.materials) - 1

    @contextmanager
    def placed(
        self, x: float, y: float, z: float = 0.0, yaw_deg: float = 0.0, pitch_deg: float = 0.0
    ) -> Iterator[None]:
        """Everything added inside stands at (x, y, z), tipped about x, then turned about +z."""
        before = self._rotation, self._shift
        a, b = np.radians(yaw_deg), np.radians(pitch_deg)
        yaw = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1.0]])
        tip = np.array([[1.0, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
        self._shift = self._shift + self._rotation @ np.array([x, y, z])
        self._rotation = self._rotation @ yaw @ tip
        yield
        self._rotation, self._shift = before

    def to_world(self, point: Sequence[float]) -> F8:
        """(3,) world position of a point given in the current place."""
        return self._rotation @ np.asarray(point, dtype=np.float64) + self._shift

    def patches(
        self,
        corners: npt.ArrayLike,
        material: int,
        uv: npt.ArrayLike,
        normals: F8 | None = None,
        bends: F8 | None = None,
    ) -> None:
        """Add K quads, one chart and two faces each.

        Args:
            corners: (K, 4, 3) positions, counter-clockwise seen from the front.
            material: index from `material`.
            uv: (K, 4, 2) texture coordinates, in repeats of the texture.
            normals: (K, 4, 3) shading normals; None for flat quads.
            bends: (K, 4, 3) normals from which the edges along s are bent, where they are not the
                shading normals: the rim of a disc. Only builders that bend edges use them.
        """
        del bends
        points = np.asarray(corners, dtype=np.float64)
        flat = np.cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 1])
        shading = np.repeat(flat[:, None], 4, axis=1) if normals is None else normals
        unit = shading / np.maximum(np.linalg.norm(shading, axis=2, keepdims=True), 1e-12)
        count = len(points)
        chart = self._add_charts(points, unit, material)
        st = np.broadcast_to(UNIT, (count, 4, 2))
        self._add_faces(points, np.asarray(uv, dtype=np.float64), st, chart)

    def sheet(
        self,
        corners: F8,
        material: int,
        uv_scale: float,
        cells: Sequence[Rect],
        cutouts: Sequence[Rect] = (),
        uv_shift: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Add one flat chart of which only ``cells`` are surface: a wall with its openings.

        Args:
            corners: (4, 3) the whole rectangle.
            material: index from `material`.
            uv_scale: repeats of the texture per metre.
            cells: (s0, t0, s1, t1) in metres along the rectangle's two sides.
            cutouts: the openings between the cells, in metres likewise.
            uv_shift: added to the texture coordinates.
        """
        along, up = corners[1] - corners[0], corners[3] - corners[0]
        size = np.array([np.linalg.norm(along), np.linalg.norm(up)])
        normal = np.cross(along, up) / (size[0] * size[1])
        chart = self._add_charts(corners[None], np.broadcast_to(normal, (1, 4, 3)), material)
        low = np.array([c[:2] for c in cells])[:, None]
        high = np.array([c[2:] for c in cells])[:, None]
        metres = low + UNIT * (high - low)
        st = metres / size
        points = corners[0] + st[..., :1] * along + st[..., 1:] * up
        self._add_faces(
            points, metres * uv_scale + np.array(uv_shift), st, np.repeat(chart, len(cells))
        )
        for s0, t0, s1, t1 in cutouts:
            self._cutouts.append(
                (float(chart[0]), s0 / size[0], t0 / size[1], s1 / size[0], t1 / size[1])
            )

    def _add_charts(self, points: F8, normals: F8, material: int) -> npt.NDArray[np.int32]:
        self._corners.append(points @ self._rotation.T + self._shift)
        self._normals.append(normals @ self._rotation.T)
        self._material.append(np.full(len(points), material, dtype=np.int32))
        chart = np.arange(self._count, self._count + len(points), dtype=np.int32)
        self._count += len(points)
        return chart

    def _add_faces(self, points: F8, uv: F8, st: F8, chart: npt.NDArray[np.int32]) -> None:
        self._vertices.append((points @ self._rotation.T + self._shift).reshape(-1, 3))
        self._uv.append(uv)
        self._st.append(st)
        self._chart.append(chart)

    def finish(self) -> tuple[Mesh, Charts]:
        """The mesh of all quads (two triangles each, in order) and its charts."""
        halves = np.array([[0, 1, 2], [0, 2, 3]])
        chart = np.concatenate(self._chart)
        first = 4 * np.arange(len(chart))[:, None, None]
        faces = (first + halves).reshape(-1, 3).astype(np.int32)
        uv = np.concatenate(self._uv)[:, halves].reshape(-1, 3, 2).astype(np.float32)
        st = np.concatenate(self._st)[:, halves].reshape(-1, 3, 2).astype(np.float32)
        of_face = np.repeat(chart, 2)
        material = np.concatenate(self._material)
        mesh = Mesh(
            np.concatenate(self._vertices), faces, material[of_face], uv, tuple(self.materials)
        )
        charts = Charts(
            np.concatenate(self._corners),
            np.concatenate(self._normals),
            material,
            of_face,
            st,
            np.array(self._cutouts, dtype=np.float64).reshape(-1, 5),
        )
        return mesh, charts
