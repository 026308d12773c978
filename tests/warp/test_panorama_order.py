"""Occlusion-compatible order with panoramas: what a z-buffer shows, without looking at depths."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.scene import Camera, CylinderCamera, SphereCamera
from belvedere.warp import order_key, warp
from tests.warp.worlds import boards, straight_camera, view_of

WIDTH = 96
SIZES = {"plane": (24, 18), "cylinder": (WIDTH, 16), "sphere": (WIDTH, WIDTH // 2)}
TALL = 1.6
"""How much larger than a sphere's the pixels of a plane or of a cylinder's rows are in the middle,
so that they are no smaller at the border."""
FINER = 1.5
"""Pixels of the desired view to one of the reference. Where several samples meet in a pixel because
the picture shrinks, there is more than one right answer."""
PAIRS = [
    (first, second)
    for first in ("plane", "cylinder", "sphere")
    for second in ("plane", "cylinder", "sphere")
    if (first, second) != ("plane", "plane")
]


def reference_of(kind: str) -> Any:
    if kind == "plane":
        return straight_camera(*SIZES[kind], focal=WIDTH / (2 * np.pi) / TALL)
    if kind == "sphere":
        return SphereCamera((0, 0, 0), *SIZES[kind])
    return CylinderCamera((0, 0, 0), *SIZES[kind], row_step=TALL * 2 * np.pi / WIDTH)


def desired_of(kind: str, center: Any, toward: Any) -> Any:
    """A finer view from ``center``; planes look along ``toward``."""
    if kind == "plane":
        up = (0, 0, 1) if abs(toward[2]) < 0.9 else (1, 0, 0)
        return Camera.look_at(center, center + toward, up, 70, width=36, height=27)
    made = reference_of(kind).moved(center)
    return made.resized(int(FINER * made.width), int(FINER * made.height))


def direction(azimuth: float, elevation: float) -> Any:
    flat = np.cos(elevation)
    return np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)])


def wrong_pixels(pair: tuple[str, str], elevation_deg: float, scenes: int = 12) -> tuple[int, int]:
    """Covered pixels where order shows another surface than the z-buffer, and all covered ones."""
    rng = np.random.default_rng(3)
    wrong = covered = 0
    for n in range(scenes):
        reference = reference_of(pair[0])
        width, height = SIZES[pair[0]]
        disparity, label = boards(rng, height, width, 8)
        color = np.repeat(label[..., None].astype(np.uint8) * 20 + 9, 3, axis=-1)
        view = view_of(reference, disparity, color)
        sign = rng.choice([-1, 1])
        step = 0.5 * direction(rng.uniform(-np.pi, np.pi), sign * np.radians(elevation_deg))
        around = direction(rng.uniform(-np.pi, np.pi), rng.uniform(-0.6, 0.6))
        desired = desired_of(pair[1], step, np.array([0, 1.0, 0]) if pair[0] == "plane" else around)
        by_order, by_depth = (
            warp(view, desired, reconstruction="point", visibility=v, threads=1 + n % 2)
            for v in ("order", "zbuffer")
        )
        wrong += int((by_order.color != by_depth.color).any(axis=-1).sum())
        covered += int((by_depth.coverage > 0).sum())
    return wrong, covered


@pytest.mark.parametrize("elevation_deg", [0, 25, 60, 90])
@pytest.mark.parametrize("pair", PAIRS)
def test_the_painter_shows_what_the_z_buffer_shows(
    pair: tuple[str, str], elevation_deg: float
) -> None:
    wrong, covered = wrong_pixels(pair, elevation_deg)
    assert wrong == 0
    assert covered > (2_000 if "plane" in pair else 12_000)


@pytest.mark.parametrize("elevation_deg", [0, 25, 60, 90])
@pytest.mark.parametrize("pair", PAIRS)
def test_the_reversed_order_shows_wrong_surfaces(
    pair: tuple[str, str], elevation_deg: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    from belvedere.warp import _scatter_any

    def backwards(rank: Any, out_order: Any) -> None:
        out_order[:] = np.argsort(-rank.astype(int), kind="stable")

    monkeypatch.setattr(_scatter_any, "sort_by_rank", backwards)
    wrong, covered = wrong_pixels(pair, elevation_deg)
    assert wrong > 0.005 * covered


def test_samples_are_sorted_by_the_angle_from_the_eye() -> None:
    from belvedere.warp import _scatter_any
    from belvedere.warp.manifold import direction_frame, geometry

    rng = np.random.default_rng(0)
    for kind in ("plane", "cylinder", "sphere"):
        reference = reference_of(kind)
        toward = direction(rng.uniform(-3, 3), rng.uniform(-1.5, 1.5))
        width, height = SIZES[kind]
        rank = np.empty(width * height, np.uint16)
        g = geometry(reference, SphereCamera(toward, 8, 4))
        own = 0, height, 0, width
        _scatter_any.rank_samples(g, direction_frame(reference), toward, own, 0, height, rank)
        key = order_key(toward, reference.rays(*reference.pixel_grid())).ravel()
        np.testing.assert_allclose(np.arccos(key), np.pi * (1 - rank / 65535), atol=1e-4)
        order = np.empty(rank.size, np.int32)
        _scatter_any.sort_by_rank(rank, order)
        np.testing.assert_array_equal(order, np.argsort(rank, kind="stable"))
