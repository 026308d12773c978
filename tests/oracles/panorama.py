"""Slow twins for cylinders and spheres: every ray against every triangle, in the world."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import encode_srgb8
from belvedere.scene import CameraModel, CylinderCamera, ReferenceView, SphereCamera

F8 = npt.NDArray[np.float64]
B1 = npt.NDArray[np.bool_]


def cell_triangles(reference: CameraModel, disparity: npt.NDArray[np.float32]) -> F8:
    """(n, 3, 3) world corners of the two triangles of each cell, and of a sphere's polar caps.

    Cells go round the seam of a panorama. Corners go round as the picture turns.
    """
    height, width = reference.size
    u, v = np.broadcast_arrays(*reference.pixel_grid())
    points = reference.unproject(u, v, disparity.astype(float))
    if isinstance(reference, CylinderCamera | SphereCamera):
        points = np.concatenate([points, points[:, :1]], axis=1)
    a, b, c, d = points[:-1, :-1], points[:-1, 1:], points[1:, :-1], points[1:, 1:]
    made = [np.stack(part, axis=-2).reshape(-1, 3, 3) for part in ((a, b, c), (d, c, b))]
    if isinstance(reference, SphereCamera):
        for row, flip in ((0, True), (height - 1, False)):
            held = disparity[row].astype(float).mean() / np.cos(0.5 * np.pi / height)
            pole = reference.unproject(0.0, -0.5 if flip else height - 0.5, held)
            rim = points[row]
            tip = np.broadcast_to(pole, (width, 3))
            order = (tip, rim[1:], rim[:-1]) if flip else (tip, rim[:-1], rim[1:])
            made.append(np.stack(order, axis=-2))
    return np.concatenate(made)


def cast(triangles: F8, desired: CameraModel, near: float) -> tuple[F8, B1]:
    """Disparity of the nearest triangle that faces each desired pixel's ray, -1 without one.

    A triangle faces the eye if its corners turn as the picture does. Second, where a ray passes a
    side closely, at an angle of less than ``near``: either answer is right there.
    """
    rays = desired.rays(*desired.pixel_grid()).reshape(-1, 3)
    unit = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    found, doubt = np.full(len(rays), -1.0), np.zeros(len(rays), bool)
    for a, b, c in triangles - desired.center:
        sides = np.array([np.cross(b, c), np.cross(c, a), np.cross(a, b)])
        volume = a @ sides[0]
        if volume <= 0:
            continue
        weights = rays @ sides.T / volume  # ray = sum of weights times corners
        total = weights.sum(axis=-1)  # the ray meets the triangle's plane at ray / total
        inward = (unit @ (sides / np.linalg.norm(sides, axis=-1, keepdims=True)).T).min(axis=-1)
        doubt |= (np.abs(inward) < near) & (total > 0)
        inside = (weights.min(axis=-1) >= 0) & (total > 0)
        found[inside] = np.maximum(found[inside], total[inside])
    return found.reshape(desired.size), doubt.reshape(desired.size)


class Room:
    """A closed room with boxes standing in it, textured to the last pixel: truth for any camera."""

    low, high = np.array([-3.0, -2.5, 0.0]), np.array([3.0, 2.5, 2.6])

    def __init__(self, seed: int, boxes: int = 7) -> None:
        rng = np.random.default_rng(seed)
        angle = np.arange(boxes) * 2 * np.pi / boxes + rng.uniform(-0.3, 0.3, boxes)
        away, side = rng.uniform(1.3, 2.0, boxes), rng.uniform(0.15, 0.35, (boxes, 2))
        middle = away[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        bottom = rng.uniform(0.0, 1.2, boxes)
        self.boxes = np.stack([
            np.column_stack([middle - side, bottom]),
            np.column_stack([middle + side, bottom + rng.uniform(0.4, 1.2, boxes)]),
        ], axis=1)  # fmt: skip
        self.hue = rng.uniform(0.25, 0.6, (boxes + 6, 3))

    def look(self, camera: CameraModel, u: F8, v: F8) -> tuple[F8, F8]:
        """Linear colour (..., 3) and disparity (...) along the rays of pixels (u, v)."""
        rays = camera.rays(u, v)
        with np.errstate(divide="ignore", invalid="ignore"):
            wall = np.where(rays > 0, self.high - camera.center, self.low - camera.center) / rays
            axis = np.argmin(np.where(rays == 0, np.inf, wall), axis=-1)
            t = np.take_along_axis(wall, axis[..., None], -1)[..., 0]
            hit = 2 * axis + (np.take_along_axis(rays, axis[..., None], -1)[..., 0] > 0)
            for n, (low, high) in enumerate(self.boxes):
                a, b = (low - camera.center) / rays, (high - camera.center) / rays
                enter, leave = np.fmin(a, b).max(axis=-1), np.fmax(a, b).min(axis=-1)
                nearer = (enter < leave) & (enter > 0) & (enter < t)
                t, hit = np.where(nearer, enter, t), np.where(nearer, n + 6, hit)
        x, y, z = np.moveaxis(camera.center + rays * t[..., None], -1, 0)
        wave = 0.15 * np.sin(23 * x + 5 * z) * np.sin(21 * y + 3 * z) + 0.1 * np.sin(25 * z + 4 * x)
        return np.clip(self.hue[hit] + wave[..., None], 0.0, 1.0), 1.0 / t

    def photograph(
        self, camera: CameraModel, rays: int = 4, part: B1 | None = None
    ) -> ReferenceView:
        """``rays`` x ``rays`` colours a pixel, averaged in linear light; depth at the centres.

        With ``part`` only those pixels are taken: the others are black and have no sample.
        """
        whole = np.ones(camera.size, bool) if part is None else part
        u, v = (each[whole] for each in np.broadcast_arrays(*camera.pixel_grid()))
        places = (np.arange(rays) + 0.5) / rays - 0.5
        total = np.zeros((u.size, 3))
        for dv in places:
            for du in places:
                total += self.look(camera, u + du, v + dv)[0]
        color, disparity = np.zeros((*camera.size, 3), np.uint8), np.full(camera.size, np.nan)
        color[whole] = encode_srgb8(total / rays**2)
        disparity[whole] = self.look(camera, u, v)[1]
        return ReferenceView(camera, color, disparity.astype(np.float32))

    def sees(
        self, camera: CameraModel, other: CameraModel, disparity: npt.NDArray[np.floating]
    ) -> B1:
        """Where ``other`` truly sees the surface at the centres of ``camera``'s pixels."""
        u, v = np.broadcast_arrays(*camera.pixel_grid())
        x, y, expected = other.project(camera.unproject(u, v, disparity))
        height, width = other.size
        inside = (x > -0.5) & (x < width - 0.5) & (y > -0.5) & (y < height - 0.5)
        met = np.zeros(camera.size)
        met[inside] = self.look(other, x[inside], y[inside])[1]
        return inside & (np.abs(met - expected) < 1e-4 * np.abs(expected))
