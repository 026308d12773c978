"""Scan conversion on any manifold: what every ray against every triangle finds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from belvedere.scene import Camera, CameraModel, CylinderCamera, SphereCamera
from belvedere.warp import WarpOptions, prepare
from belvedere.warp.panoramas import BentPassage, bent_passage
from tests.oracles.panorama import cast, cell_triangles
from tests.warp.test_surface import TOLERANCE, drawn_surface
from tests.warp.worlds import random_camera, random_rotation, straight_camera, view_of

WIDTH, HEIGHT = 30, 16
KINDS = ("plane", "cylinder", "sphere")


def camera_of(rng: np.random.Generator, kind: str, center: Any, scale: float = 1.0) -> Any:
    """A camera of a kind, turned anyhow."""
    turn = random_rotation(rng)
    width, height = int(WIDTH * scale), int(HEIGHT * scale)
    if kind == "sphere":
        return SphereCamera(center, width, height, turn, rng.uniform(-3, 3))
    if kind == "cylinder":
        return CylinderCamera(center, width, height, turn, rng.uniform(-3, 3), height * 0.4,
                              2 * np.pi / width)  # fmt: skip
    k = np.array([[width * 0.5, 0, width / 2], [0, width * 0.5, height / 2], [0, 0, 1]])
    return Camera(turn @ np.linalg.inv(k), center, width, height)


def bumps(rng: np.random.Generator, height: int, width: int, round_seam: bool) -> Any:
    """(H, W) smooth disparities round 0.4, going on beyond the seam."""
    mode: Any = ("nearest", "wrap" if round_seam else "nearest")
    held = gaussian_filter(rng.normal(size=(height, width)), 2.0, mode=mode)
    return (0.4 + 0.03 * held / np.abs(held).max()).astype(np.float32)


def draw(passage: BentPassage, low: int, high: int, width: int, caps: bool = True) -> Any:
    """Rows [low, high) of what a passage draws: centres, edges, masks."""
    from belvedere.warp import _surface_any

    blank = np.full((2, high - low, width + 2 * passage.margin), -1.0, np.float32)
    layer = blank[0], blank[1], np.zeros(blank[0].shape, np.uint16)
    _surface_any.draw_surface(
        passage.w, passage.disparity, passage.links, passage.tiles, low, high, TOLERANCE, *layer
    )
    parts = passage.silhouettes.parts
    if caps:
        _surface_any.draw_parts(
            passage.w, parts.corners, parts.near, parts.ends, passage.tiles, low, high, TOLERANCE,
            *layer,
        )  # fmt: skip
    return layer


def passage_of(
    reference: CameraModel, disparity: Any, desired: CameraModel, edge_tolerance: float = 0.05
) -> BentPassage:
    held = prepare(view_of(reference, disparity), edge_tolerance, bridge=0)
    return bent_passage(held, desired, WarpOptions(), 1)


@pytest.mark.parametrize("second", KINDS)
@pytest.mark.parametrize("first", KINDS)
def test_the_surface_is_what_every_ray_meets_first(first: str, second: str) -> None:
    """Seams, poles and all: cells, and on spheres the caps. Other parts are the planes' own."""
    rng = np.random.default_rng(KINDS.index(first) * 3 + KINDS.index(second))
    compared = 0
    for n in range(3):
        reference = camera_of(rng, first, (0, 0, 0))
        desired = camera_of(rng, second, rng.normal(0, 0.4, 3), (0.5, 1.0, 1.7)[n])
        disparity = bumps(rng, *reference.size, first != "plane")
        if first == "sphere":  # one surface over each pole, so that the caps are known
            disparity[0], disparity[-1] = disparity[0].mean(), disparity[-1].mean()
        passage = passage_of(reference, disparity, desired, 1.0)
        found = draw(passage, 0, desired.height, desired.width, first == "sphere")[0]
        near = 3e-3 * 2 * np.pi / desired.width  # a little more than the slack
        wanted, doubt = cast(cell_triangles(reference, disparity), desired, near)
        if passage.margin:
            m = passage.margin
            np.testing.assert_array_equal(found[:, :m], found[:, -2 * m : -m])
            np.testing.assert_array_equal(found[:, -m:], found[:, m : 2 * m])
            found = found[:, m:-m]
        sure = ~doubt
        np.testing.assert_array_equal((found >= 0)[sure], (wanted >= 0)[sure])
        np.testing.assert_allclose(found[sure], wanted[sure], rtol=2e-5)
        compared += int((sure & (wanted >= 0)).sum())
        if first == "sphere":  # closed all round
            assert (found >= 0).all()
    assert compared > (100 if "plane" in (first, second) else 900)


def test_between_planes_it_draws_what_the_kernels_of_planes_draw() -> None:
    rng = np.random.default_rng(20)
    for _ in range(8):
        reference, desired = straight_camera(WIDTH, HEIGHT), random_camera(rng, 41, 29, 0.3, 0.5)
        disparity = bumps(rng, HEIGHT, WIDTH, False)
        flat = drawn_surface(disparity, reference, desired)
        bent = draw(passage_of(reference, disparity, desired), 0, 29, 41, False)[0]
        apart = (flat >= 0) != (bent >= 0)
        assert apart.mean() < 0.002  # centres on a side
        both = (flat >= 0) & (bent >= 0)
        np.testing.assert_allclose(bent[both], flat[both], rtol=1e-4)


@pytest.mark.parametrize("second", KINDS)
def test_bands_drawn_apart_are_the_picture_drawn_at_once(second: str) -> None:
    rng = np.random.default_rng(30)
    for first in ("cylinder", "sphere"):
        reference = camera_of(rng, first, (0, 0, 0))
        desired = camera_of(rng, second, (0.3, -0.2, 0.1), 2.0)
        disparity = bumps(rng, HEIGHT, WIDTH, True)
        disparity[5:9, 20:] *= 2  # silhouettes and their masks
        passage = passage_of(reference, disparity, desired)
        whole = draw(passage, 0, desired.height, desired.width)
        for low, high in ((0, 5), (5, 6), (6, desired.height)):
            band = draw(passage, low, high, desired.width)
            for part, all_of_it in zip(band, whole, strict=True):
                np.testing.assert_array_equal(part, all_of_it[low:high])


@pytest.mark.parametrize("second", KINDS)
def test_masks_tell_the_share_of_a_pixel_that_a_board_covers(second: str) -> None:
    """A frontal board before a wall: sixteen places against many rays through each pixel."""
    from belvedere.warp import _layers

    rng = np.random.default_rng(40)
    reference = SphereCamera((0, 0, 0), 96, 48)
    disparity = np.full((48, 96), 0.2, np.float32)
    disparity[16:33, 30:60] = 0.8
    desired = camera_of(rng, second, (0.15, 0.1, -0.1), 3.0)
    if second == "plane":
        toward = reference.rays(44.5, 24.0)
        desired = Camera.look_at((0.15, 0.1, -0.1), toward, fov_deg=90, width=60, height=50)
    passage = passage_of(reference, disparity, desired)
    _, edges, masks = draw(passage, 0, desired.height, desired.width)
    m = passage.margin
    edges, masks = edges[:, m : edges.shape[1] - m], masks[:, m : masks.shape[1] - m]
    u, v = np.broadcast_arrays(*desired.pixel_grid())
    steps, total = (np.arange(8) + 0.5) / 8 - 0.5, np.zeros(desired.size)
    for du in steps:
        for dv in steps:
            total += on_board(reference, desired, u + du, v + dv)
    truth = total / 64
    found = np.array([_layers.covered(int(bits)) for bits in masks.ravel()]).reshape(truth.shape)
    # a board drawn as quads has straight sides between samples; corners are rounded in neither
    partial = (truth > 0.02) & (truth < 0.98) & (edges > 0.5)
    assert partial.sum() > 30
    off = (found - truth)[partial]
    assert abs(off.mean()) < 0.03
    assert np.abs(off).max() < 0.25


def on_board(reference: SphereCamera, desired: CameraModel, u: Any, v: Any) -> Any:
    """Whether rays of the desired camera meet the board, samples 30 to 59 and 16 to 32 wide.

    It is part of a sphere round the reference of radius 1 / 0.8, up to half way to the wall.
    """
    rays = desired.rays(u, v)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    offset, radius = desired.center - reference.center, 1 / 0.8
    half = rays @ offset
    ahead = -half + np.sqrt(half**2 - offset @ offset + radius**2)
    x, y, _ = reference.project(desired.center + ahead[..., None] * rays)
    return (x > 29.5) & (x < 59.5) & (y > 15.5) & (y < 32.5)
