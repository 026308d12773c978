"""Small exact views to write and read back."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from belvedere import Camera, ReferenceView, ViewSet

WIDTH, HEIGHT = 12, 9

MakeViews = Callable[..., ViewSet]


@pytest.fixture
def make_views() -> MakeViews:
    """Three tiny views with depth on a grid of 1 mm, from different places."""

    def make(
        count: int = 3, *, far: bool = False, holes: bool = True, linear: bool = False,
        alpha: bool = False, depth: tuple[float, float] = (0.5, 8.0), seed: int = 7,
        focals: tuple[float, ...] = (),
    ) -> ViewSet:  # fmt: skip
        rng = np.random.default_rng(seed)
        views: list[ReferenceView] = []
        for index in range(count):
            eye = np.array([0.3 * index, -3.0, 1.0]) + rng.uniform(-0.05, 0.05, 3)
            camera = Camera.look_at(eye, (0.1, 0.2, 0.7), fov_deg=50, width=WIDTH, height=HEIGHT)
            k = camera.intrinsics.copy()
            k[0, 2] += 0.31  # no symmetry that could hide a mistake
            k[1, 2] -= 0.17
            if focals:
                k[0, 0] = k[1, 1] = focals[index]
            camera = Camera.from_intrinsics(k, camera.camera_to_world, WIDTH, HEIGHT)
            channels = 4 if alpha else 3
            color = rng.integers(0, 256, (HEIGHT, WIDTH, channels), dtype=np.uint8)
            if alpha:
                color[..., 3] = 255
            metres = np.round(rng.uniform(*depth, (HEIGHT, WIDTH)), 3)
            disparity = (1.0 / metres).astype(np.float32)
            if holes:
                disparity[0, :4] = np.nan
            if far:
                disparity[1, :4] = 0.0
            pixels = (color / np.float32(64)).astype(np.float32) if linear else color
            views.append(ReferenceView(camera, pixels, disparity))
        return ViewSet.of(views, [f"v{index:02d}" for index in range(count)])

    return make


@pytest.fixture
def views(make_views: MakeViews) -> ViewSet:
    return make_views()
