"""Ray-cast ground truth of a railing: thin straight bars before a far wall, area by many rays."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import encode_srgb8
from belvedere.scene import Camera, ReferenceView

F8 = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Railing:
    """Flat bars in the plane y = ``near`` before a wall at y = ``far``, both facing the viewer."""

    width: float
    """Of a bar, metres."""
    period: float
    """From one bar to the next, metres."""
    angle: float
    """Of the bars from upright, radians."""
    near: float = 2.0
    far: float = 8.0

    def on_bar(self, camera: Camera, u: F8, v: F8) -> npt.NDArray[np.bool_]:
        """(...) whether the rays of pixels (u, v) meet a bar."""
        rays = camera.rays(u, v)
        x, _, z = np.moveaxis(
            camera.center + rays * ((self.near - camera.center[1]) / rays[..., 1])[..., None], -1, 0
        )
        across = x * math.cos(self.angle) + z * math.sin(self.angle)
        return np.abs((across + self.period / 2) % self.period - self.period / 2) < self.width / 2

    def share(self, camera: Camera, rays: int = 8) -> F8:
        """(H, W) how much of each pixel the bars cover."""
        u, v = np.broadcast_arrays(*camera.pixel_grid())
        places = (np.arange(rays) + 0.5) / rays - 0.5
        total = np.zeros(camera.size)
        for dv in places:
            for du in places:
                total += self.on_bar(camera, u + du, v + dv)
        return total / rays**2

    def photograph(self, camera: Camera) -> ReferenceView:
        """Bars of linear 0.8 before a wall of 0.1: colours of the area, depth at the centres."""
        share = self.share(camera)
        hit = self.on_bar(camera, *np.broadcast_arrays(*camera.pixel_grid()))
        depth = np.where(hit, self.near, self.far) - camera.center[1]
        color = encode_srgb8((0.1 + 0.7 * share)[..., None].repeat(3, -1))
        return ReferenceView(camera, color, (1.0 / depth).astype(np.float32))
