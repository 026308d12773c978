"""Cells drawn by casting a ray for every pixel: the slow twin of the geometry drawer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from belvedere.model import LitModel, photograph
from belvedere.scene import Camera
from belvedere.walkthrough import CellContents, Sight


def part_of(model: LitModel, faces: np.ndarray) -> LitModel:
    """The same light on some of the faces."""
    mesh, charts = model.mesh, model.charts
    return LitModel(
        replace(mesh, faces=mesh.faces[faces], material_index=mesh.material_index[faces],
                uv=mesh.uv[faces]),
        replace(charts, of_face=charts.of_face[faces], st=charts.st[faces]),
        model.light,
    )  # fmt: skip


class RayDrawer:
    """See `belvedere.walkthrough.GeometryDrawer`."""

    def __init__(self, model: LitModel, contents: CellContents) -> None:
        self.model, self.contents = model, contents
        self._parts: dict[tuple[int, ...], LitModel] = {}

    def draw(
        self, camera: Camera, sights: Sequence[Sight] | None, threads: int | None
    ) -> tuple[np.ndarray, np.ndarray]:
        model = self.model
        if sights is not None:
            key = tuple(sorted({s.cell for s in sights}))
            if key not in self._parts:
                faces = np.unique(np.concatenate([self.contents.faces(c) for c in key]))
                self._parts[key] = part_of(self.model, faces)
            model = self._parts[key]
        view = photograph(model, camera, 1, threads=threads)
        return view.color.copy(), view.disparity.copy()

    def trace(self, camera, u, v, threads):
        view = photograph(self.model, camera, 1, threads=threads)
        return view.color[v, u], view.disparity[v, u]
