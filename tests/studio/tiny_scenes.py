"""A wall with a board before it, photographed exactly from a row of cameras."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from belvedere.ground.color import encode_srgb8
from belvedere.scene import (
    Affordances,
    Camera,
    CameraModel,
    Frame,
    ReferenceView,
    ViewingRegion,
    ViewSet,
)

WIDTH, HEIGHT = 48, 36


def camera_at(x: float, width: int = WIDTH, height: int = HEIGHT) -> Camera:
    """On the row, looking at the wall."""
    return Camera.look_at((x, 0, 0), (x, 4, 0), fov_deg=50, width=width, height=height)


def photograph(camera: CameraModel) -> ReferenceView:
    """The wall y = 4 and a board at y = 2.5, both painted with smooth waves."""
    assert isinstance(camera, Camera)
    u, v = camera.pixel_grid()
    rays = camera.rays(u, v)
    depth = np.full(camera.size, 4.0)
    for plane, half in ((2.5, 0.35),):
        points = camera.center + rays * (plane / rays[..., 1:2])
        hit = np.abs(points[..., [0, 2]]).max(axis=-1) < half
        depth[hit] = plane
    points = camera.center + rays * (depth / rays[..., 1])[..., None]
    x, z = points[..., 0], points[..., 2]
    color = 0.5 + 0.25 * np.stack([np.sin(3 * x), np.cos(4 * z), np.sin(2 * x + z)], -1)
    color *= np.where(depth < 3, 0.4, 1.0)[..., None]
    return ReferenceView.from_depth(camera, encode_srgb8(color), depth.astype(np.float32))


def row_of_views(count: int, step: float = 0.08) -> ViewSet:
    """Views named ``view_00`` ... along the row."""
    views = [photograph(camera_at(step * i)) for i in range(count)]
    return ViewSet.of(views, [f"view_{i:02d}" for i in range(count)])


def copying(views: Sequence[ReferenceView], camera: CameraModel, *, reconstruction: str) -> Frame:
    """A predictor that shows the first reference as it is; "splat" leaves the left half out."""
    color = views[0].color.copy()
    coverage = np.ones(camera.size, np.float32)
    if reconstruction == "splat":
        coverage[:, : camera.width // 2] = 0
        color[coverage == 0] = 0
    return Frame(
        camera, color, np.where(coverage > 0, views[0].disparity, np.float32(np.nan)), coverage
    )


class Painted:
    """A scene that needs no warp: it is photographed anew from every camera."""

    affords = Affordances("continuous", "global")
    viewing_region = ViewingRegion(np.zeros(3), np.ones(3))
    home = camera_at(0.0)

    def __init__(self) -> None:
        self.rendered = 0

    def render(self, camera: CameraModel) -> Frame:
        view = photograph(camera)
        coverage = np.ones(camera.size, np.float32)
        coverage[0] = 0.0
        self.rendered += 1
        return Frame(camera, view.color, view.disparity, coverage)
