"""Slow twins for cylinders and spheres: every ray against every triangle, in the world."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.scene import CameraModel, CylinderCamera, SphereCamera

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
