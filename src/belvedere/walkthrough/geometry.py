"""Drawing the polygons of the cells in sight."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from belvedere.model import (
    DrawList,
    LitModel,
    OpenGLDrawList,
    OpenGLRasterizer,
    Rasterizer,
    photograph_pixels,
)
from belvedere.scene import Camera
from belvedere.walkthrough.contents import CellContents
from belvedere.walkthrough.visibility import Sight

__all__ = ["CellRasterizer", "GeometryDrawer"]


class GeometryDrawer(Protocol):
    """Draws polygons into a window."""

    def draw(
        self, camera: Camera, sights: Sequence[Sight] | None, threads: int | None
    ) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32]]:
        """The polygons of all cells in ``sights``, each at least within its frustum; None: all.

        Returns:
            (H, W, 3) sRGB and (H, W) disparity, 0 in the sky, which the caller may write to.
        """
        ...

    def trace(
        self, camera: Camera, u: npt.NDArray[np.intp], v: npt.NDArray[np.intp], threads: int | None
    ) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32]]:
        """What the pixels (u[i], v[i]) see of the whole model: (N, 3) sRGB, (N,) disparity."""
        ...


class CellRasterizer:
    """Draws cells with a rasterizer; each cell's list is made when first seen.

    Args:
        model: what stands in the cells.
        contents: which of its faces stand where.
        rasterizer: of the model; None for a `Rasterizer`, the fastest on every processor tried.

    Memory: see `belvedere.model.Rasterizer`.
    """

    def __init__(
        self,
        model: LitModel,
        contents: CellContents,
        rasterizer: Rasterizer | OpenGLRasterizer | None = None,
    ) -> None:
        self._model, self._contents = model, contents
        self._rasterizer: Any = Rasterizer(model) if rasterizer is None else rasterizer
        self._lists: dict[int, DrawList | OpenGLDrawList] = {}

    def draw(
        self, camera: Camera, sights: Sequence[Sight] | None, threads: int | None
    ) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32]]:
        """See `GeometryDrawer.draw`. A cell seen through several portals is drawn once for each."""
        self._rasterizer.threads = threads
        if sights is None:
            color, disparity, _ = self._rasterizer.draw(camera)
            return color, disparity
        lists = [(self._list(sight.cell), sight.planes) for sight in sights]
        color, disparity, _ = self._rasterizer.draw(camera, lists)
        return color, disparity

    def trace(
        self, camera: Camera, u: npt.NDArray[np.intp], v: npt.NDArray[np.intp], threads: int | None
    ) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32]]:
        """See `GeometryDrawer.trace`."""
        return photograph_pixels(self._model, camera, u, v, threads)

    def _list(self, cell: int) -> DrawList | OpenGLDrawList:
        if cell not in self._lists:
            self._lists[cell] = self._rasterizer.prepare(self._contents.faces(cell))
        return self._lists[cell]
