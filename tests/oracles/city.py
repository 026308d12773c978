"""Ray-cast ground truth: textured blocks on a plane, exact depth, many rays a pixel."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import encode_srgb8
from belvedere.scene import Camera, ReferenceView

F8 = npt.NDArray[np.float64]


class City:
    """Blocks on the ground z = 0 within ``extent`` metres of the origin, under a black sky."""

    def __init__(self, seed: int, blocks: int = 5, extent: float = 10.0) -> None:
        rng = np.random.default_rng(seed)
        side = 2 * extent / blocks
        corner = np.stack(np.meshgrid(*[np.arange(blocks) * side - extent] * 2), -1).reshape(-1, 2)
        low = corner + side * rng.uniform(0.15, 0.25, corner.shape)
        high = corner + side * rng.uniform(0.65, 0.8, corner.shape)
        tall = rng.uniform(0.5, 3.0, (len(corner), 1))
        self.low = np.hstack([low, np.zeros_like(tall)])
        self.high = np.hstack([high, tall])
        self.hue = rng.uniform(0.2, 0.6, (len(corner) + 1, 3))

    def look(self, camera: Camera, u: F8, v: F8) -> tuple[F8, F8]:
        """Linear colour (..., 3) and disparity (...) along the rays of pixels (u, v)."""
        rays = camera.rays(u, v)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.where(rays[..., 2] < 0, -camera.center[2] / rays[..., 2], np.inf)
            hit = np.zeros(t.shape, int)
            for n, (low, high) in enumerate(zip(self.low, self.high, strict=True), 1):
                a, b = (low - camera.center) / rays, (high - camera.center) / rays
                enter = np.minimum(a, b).max(axis=-1)
                leave = np.maximum(a, b).min(axis=-1)
                nearer = (enter < leave) & (enter > 0) & (enter < t)
                t, hit = np.where(nearer, enter, t), np.where(nearer, n, hit)
            point = camera.center + rays * np.where(np.isfinite(t), t, 0.0)[..., None]
        x, y, z = np.moveaxis(point, -1, 0)
        wave = 0.25 * np.sin(9 * x + 2 * z) * np.sin(8 * y) + 0.15 * np.sin(11 * z + 3 * x)
        color = np.clip(self.hue[hit] + wave[..., None], 0.0, 1.0)
        seen = np.isfinite(t)
        return np.where(seen[..., None], color, 0.0), np.where(seen, 1.0 / t, 0.0)

    def photograph(self, camera: Camera, rays: int = 8) -> ReferenceView:
        """``rays`` x ``rays`` colours a pixel, averaged in linear light; depth at the centres."""
        u, v = np.broadcast_arrays(*camera.pixel_grid())
        places = (np.arange(rays) + 0.5) / rays - 0.5
        total = np.zeros((*camera.size, 3))
        for dv in places:
            for du in places:
                total += self.look(camera, u + du, v + dv)[0]
        disparity = self.look(camera, u, v)[1]
        return ReferenceView(camera, encode_srgb8(total / rays**2), disparity.astype(np.float32))
