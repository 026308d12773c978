"""References of a portal, and how fine they are on the screen."""

from __future__ import annotations

import numpy as np
import pytest

from belvedere.scene import Camera
from belvedere.walkthrough import SwitchOptions, Walker, WalkOptions, contents_of
from tests.oracles.drawing import RayDrawer


@pytest.mark.parametrize("eye", [(0.4, 2.2, 1.6), (2.5, 1.2, 1.6), (1.0, 3.9, 0.7)])
def test_texels_a_pixel_is_the_coarser_way_over_the_portal(images, eye) -> None:
    one = images[0, 0]
    camera = Camera.look_at(eye, (6.0, 2.6, 1.2), width=320, height=240, fov_deg=60)
    half = np.array([0.5, -0.5])[:, None]
    exact = []
    rows, columns = one.references[0].disparity.shape
    for edge, texels in ((one.side.right, columns), (one.side.down, rows)):
        u, v, _ = camera.project(one.side.portal.center + 0.02 * half * edge)
        exact.append(0.02 * texels / np.hypot(u[0] - u[1], v[0] - v[1]))
    assert one.texels_a_pixel(camera) == pytest.approx(min(exact), rel=1e-3)


def test_a_portal_behind_the_eye_is_not_fine(images) -> None:
    away = Camera.look_at((2.0, 2.0, 1.6), (0.0, 2.0, 1.6), width=32, height=24, fov_deg=60)
    assert images[0, 0].texels_a_pixel(away) == 0.0


def test_small_portals_are_warped_from_fewer_texels(house, graph, images, monkeypatch) -> None:
    drawer = RayDrawer(house, contents_of(house.mesh, graph))
    walker = Walker(graph, drawer, images, WalkOptions(fill="none", switch=SwitchOptions(fade=0)))
    sizes: list[int] = []
    warped = walker._warped

    def noted(views, camera):
        sizes.append(views[0].disparity.size)
        return warped(views, camera)

    monkeypatch.setattr(walker, "_warped", noted)
    for width in (640, 320, 120):
        walker.frame(
            Camera.look_at(
                (1.6, 1.8, 1.6), (6, 2.3, 1.4), width=width, height=width // 2, fov_deg=60
            )
        )
    whole = images[0, 0].references[0].disparity.size
    assert sizes[0] == whole
    assert whole >= sizes[1] > sizes[2] > 0
