"""The picture that a frame is put together in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import LINEAR_TO_SRGB8, SRGB8_TO_LINEAR
from belvedere.ground.scratch import scratch
from belvedere.ground.threads import row_bands, run_parallel, thread_count
from belvedere.scene import Camera, Frame
from belvedere.walkthrough.cells import Portal

F8 = npt.NDArray[np.float64]

LEAST_PIXELS = 16_384
"""A thread is worth waking for so many."""
TOUCHING_M = 1e-6
"""An eye nearer to a portal's plane counts as this far from it: the plane's disparity is finite."""

__all__ = ["Crop", "Window", "cropped"]


@dataclass(frozen=True, slots=True, eq=False)
class Crop:
    """A part of a window."""

    camera: Camera
    """The window's, cut to it."""
    u0: int
    """Its first column in the window."""
    v0: int
    """Its first row."""


def cropped(camera: Camera, polygon: F8) -> Crop | None:
    """The box round a polygon, (N, 3) relative to the eye; without corners, the whole window.

    None if no pixel's center can lie in it.
    """
    if not len(polygon):
        return Crop(camera, 0, 0)
    rays = polygon @ np.linalg.inv(camera.matrix).T
    u, v = rays[:, 0] / rays[:, 2], rays[:, 1] / rays[:, 2]
    u0, u1 = max(int(np.ceil(u.min())), 0), min(int(np.floor(u.max())), camera.width - 1)
    v0, v1 = max(int(np.ceil(v.min())), 0), min(int(np.floor(v.max())), camera.height - 1)
    if u1 < u0 or v1 < v0:
        return None
    return Crop(camera.cropped(u0, v0, u1 - u0 + 1, v1 - v0 + 1), u0, v0)


@dataclass(slots=True, eq=False)
class Window:
    """What the visitor sees so far."""

    frame: Frame
    """What is shown so far, uint8; its arrays are written to."""
    kept: npt.NDArray[np.uint8] | None
    """(H, W, 3) what was seen through portals last, shown in holes; None to leave these."""
    threads: int | None

    @property
    def camera(self) -> Camera:
        """The visitor's."""
        assert isinstance(self.frame.camera, Camera)
        return self.frame.camera

    def show(
        self,
        portal: Portal,
        planes: F8,
        seen: Frame,
        crop: Crop | None = None,
        weight: float = 1.0,
        merge: bool = False,
    ) -> None:
        """Show what is seen through a portal, where nothing stands before its plane.

        Args:
            portal: which.
            planes: (K, 3) of the frustum through it, pointing inwards.
            seen: what to show.
            crop: where; None for the whole window.
            weight: of what is shown against what is there; below 1 while it fades in or out.
            merge: what is there comes from pictures that look through the portal too: leave it
                where ``seen`` has a hole, and where it is clearly nearer.
        """
        from belvedere.walkthrough import _compose

        height = float(portal.normal @ (portal.center - self.camera.center))
        if abs(height) < TOUCHING_M:
            height = TOUCHING_M if height > 0.0 else -TOUCHING_M
        frame, kept = self.frame, self.frame.color if self.kept is None else self.kept
        u0, v0 = (0, 0) if crop is None else (crop.u0, crop.v0)
        rows, width = seen.disparity.shape
        bands = row_bands(rows, min(thread_count(self.threads), 1 + rows * width // LEAST_PIXELS))

        def part(band: tuple[int, int]) -> None:
            _compose.show_through(
                self.camera.matrix, planes, portal.normal, 1.0 / height, u0, v0, *band,
                seen.color, seen.disparity, seen.coverage, weight, SRGB8_TO_LINEAR,
                LINEAR_TO_SRGB8, merge, self.kept is not None, kept, frame.color, frame.disparity,
                frame.coverage,
            )  # fmt: skip

        run_parallel(part, bands, self.threads)

    def find_holes(self) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
        """Columns and rows of the pixels that nothing covers."""
        from belvedere.walkthrough import _compose

        coverage = self.frame.coverage
        index = scratch("window holes", (coverage.size,), np.int32)
        count = _compose.list_holes(coverage.reshape(-1), index)
        v, u = np.divmod(index[:count].astype(np.intp), coverage.shape[1])
        return u, v
