"""Ray-cast ground truth: balls before a wall, and which of their points another camera sees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.ndimage import binary_dilation

from belvedere.ground.color import encode_srgb8
from belvedere.scene import Camera, ReferenceView

F8 = npt.NDArray[np.float64]


B1 = npt.NDArray[np.bool_]


def grown(mask: B1) -> B1:
    """The mask and its pixels' eight neighbours."""
    return np.asarray(binary_dilation(mask, np.ones((3, 3))), np.bool_)


def shrunk(mask: B1) -> B1:
    """The mask without the neighbours of what is outside it."""
    return ~grown(~mask)


@dataclass(frozen=True, slots=True)
class Balls:
    """Balls, light with soft stripes, before a darker wall at y = ``wall``."""

    centers: tuple[tuple[float, float, float], ...]
    radius: float
    wall: float = 8.0

    def cast(self, eye: F8, rays: F8) -> tuple[F8, npt.NDArray[np.int64]]:
        """(...) multiples of the rays, and the ball that is hit there; -1 is the wall."""
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.where(rays[..., 1] > 0, (self.wall - eye[1]) / rays[..., 1], np.inf)
            hit = np.full(t.shape, -1)
            for index, center in enumerate(self.centers):
                off = eye - np.asarray(center)
                a, b = (rays**2).sum(-1), (rays * off).sum(-1)
                root = np.sqrt(b**2 - a * (off @ off - self.radius**2))
                enter = (-b - root) / a
                nearer = (enter > 0) & (enter < t)
                t, hit = np.where(nearer, enter, t), np.where(nearer, index, hit)
        return t, hit

    def look(self, camera: Camera, u: F8, v: F8) -> tuple[F8, F8, npt.NDArray[np.int64]]:
        """Linear grey (...), disparity (...) and ball (...) at pixels (u, v)."""
        rays = camera.rays(u, v)
        t, hit = self.cast(camera.center, rays)
        x, _, z = np.moveaxis(camera.center + rays * t[..., None], -1, 0)
        stripes = 0.1 * np.sin(5 * x) * np.sin(5 * z)
        return np.where(hit >= 0, 0.6, 0.2) + stripes, 1.0 / t, hit

    def photograph(self, camera: Camera, rays: int = 6) -> ReferenceView:
        """``rays`` x ``rays`` colours a pixel, averaged in linear light; depth at the centres."""
        u, v = np.broadcast_arrays(*camera.pixel_grid())
        places = (np.arange(rays) + 0.5) / rays - 0.5
        total = np.zeros(camera.size)
        for dv in places:
            for du in places:
                total += self.look(camera, u + du, v + dv)[0]
        color = encode_srgb8((total / rays**2)[..., None].repeat(3, -1))
        return ReferenceView(camera, color, self.look(camera, u, v)[1].astype(np.float32))

    def seen(
        self, camera: Camera, other: Camera
    ) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
        """(H, W) whether what ``camera`` shows lies in ``other``'s picture; and is not hidden."""
        u, v = np.broadcast_arrays(*camera.pixel_grid())
        points = camera.unproject(u, v, self.look(camera, u, v)[1])
        x, y, d = other.project(points)
        inside = (x >= 0) & (x <= other.width - 1) & (y >= 0) & (y <= other.height - 1) & (d > 0)
        t, _ = self.cast(other.center, points - other.center)
        return inside, inside & (t > 1 - 1e-6)
