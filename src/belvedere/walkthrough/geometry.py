"""Drawing the polygons of the cells in sight."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

from belvedere.scene import Camera
from belvedere.walkthrough.visibility import Sight

__all__ = ["GeometryDrawer"]


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
