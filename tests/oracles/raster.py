"""Triangles drawn one pixel at a time with rays: the slow twin of the rasterizer."""

from __future__ import annotations

import numpy as np

from belvedere.scene import Camera
from belvedere.scene.mesh import Mesh


def nearest_faces(mesh: Mesh, camera: Camera, near: float = 0.01) -> tuple[np.ndarray, np.ndarray]:
    """(H, W) face of the largest disparity along each pixel's ray, -1 for none, and disparity."""
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    rays = camera.rays(u, v)
    face = np.full(camera.size, -1)
    best = np.zeros(camera.size)
    for index, (a, b, c) in enumerate(mesh.vertices[mesh.faces]):
        normal = np.cross(b - a, c - a)
        slope = rays @ normal
        height = (a - camera.center) @ normal
        with np.errstate(divide="ignore", invalid="ignore"):
            t = height / slope
            at = camera.center + t[..., None] * rays
        inside = np.isfinite(t) & (t >= near)
        for p, q in ((a, b), (b, c), (c, a)):
            inside &= np.cross(q - p, at - p) @ normal >= 0.0
        with np.errstate(divide="ignore"):
            delta = np.where(inside, 1.0 / np.where(inside, t, 1.0), 0.0)
        nearer = delta > best
        face[nearer], best[nearer] = index, delta[nearer]
    return face, best
