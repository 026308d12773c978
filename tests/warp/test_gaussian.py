"""Gaussian footprints: their ellipses, what they cover and what they hide."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from belvedere.scene import Camera, ReferenceView
from belvedere.warp import (
    GaussianOptions,
    jacobian,
    prepare,
    warp,
    warp_matrix,
    warp_points,
)
from belvedere.warp import _gaussian as kernels
from belvedere.warp.reconstruct import footprint_weights
from tests.oracles.gaussian import gaussian_warp
from tests.warp.worlds import (
    boards,
    checks,
    grey,
    noise,
    plane_disparity,
    random_camera,
    random_rotation,
    rolled,
    straight_camera,
    view_of,
)

GAUSSIAN: dict[str, Any] = {"reconstruction": "gaussian"}


def one_footprint(
    reference: Camera, desired: Camera, disparity: np.ndarray, options: GaussianOptions
) -> np.ndarray:
    """(rows, columns) weights that sample (2, 2) of a 5 x 5 reference adds to the desired view."""
    view = prepare(view_of(reference, disparity))
    rows, columns = desired.size
    tiles = np.array([[2, 3, 1, 2, 3, 1, 0, rows]], np.int32)
    w = warp_matrix(reference, desired).astype(np.float32).ravel()
    weight = np.zeros(desired.size, np.float32)
    front, color = np.zeros(rows * columns, np.float32), np.zeros((rows, columns, 4), np.float32)
    kernels.accumulate(
        w, view.linear(), view.surface(), view.links(), tiles, 0, rows, options.low_pass,
        footprint_weights(options), options.cut, 1.0, front, color, weight.reshape(-1),
    )  # fmt: skip
    return weight.astype(np.float64)


# ---- the ellipse -------------------------------------------------------------------------------


@pytest.mark.parametrize("n", range(8))
def test_a_footprint_is_the_ellipse_of_equation_25(n: int) -> None:
    """Its outline is J's circle, its second moments are J J^T; slopes and low pass included."""
    rng = np.random.default_rng(n)
    reference = straight_camera(5, 5, focal=200)
    desired = Camera(
        random_rotation(rng, 0.5) @ reference.matrix @ np.diag([0.06, 0.06, 1]) @ np.array(
            [[1, 0, -20 + 2 / 0.06], [0, 1, -20 + 2 / 0.06], [0, 0, 1.0]]
        ),
        rng.normal(0, 0.05, 3), 120, 120,
    )  # fmt: skip
    normal = np.array([0, 1.0, 0]) + rng.normal(0, 0.4, 3)
    disparity = plane_disparity(reference, normal, 3.0)
    matrix = warp_matrix(reference, desired)
    x, y, _ = (float(one) for one in warp_points(matrix, 2, 2, disparity[2, 2]))
    desired = Camera(
        desired.matrix @ np.array([[1, 0, x - 60], [0, 1, y - 60], [0, 0, 1]]),
        desired.center, 120, 120,
    )  # fmt: skip
    matrix = warp_matrix(reference, desired)
    x, y, _ = (float(one) for one in warp_points(matrix, 2, 2, disparity[2, 2]))
    slopes = disparity[2, 3] - disparity[2, 2], disparity[3, 2] - disparity[2, 2]
    stretch = jacobian(matrix, 2, 2, disparity[2, 2], slopes)
    options = GaussianOptions(low_pass=(0.25, 1.0)[n % 2])
    weight = one_footprint(reference, desired, disparity, options)
    spread = stretch @ stretch.T + options.low_pass * np.eye(2)

    v, u = np.indices(weight.shape)
    off = np.stack([u - x, v - y], -1)
    square = np.einsum("...i,ij,...j", off, np.linalg.inv(spread), off)
    assert not weight[square > 1.001 * options.cut**2].any()
    assert np.all(weight[square < 0.999 * options.cut**2] > 0)
    np.testing.assert_allclose(
        weight[square < 2] / weight.max(), np.exp(-2 * square[square < 2]), rtol=0.01
    )
    total = weight.sum()
    mean = np.einsum("vu,vui->i", weight, off) / total
    moments = np.einsum("vu,vui,vuj->ij", weight, off, off) / total
    ends = options.cut**2 / (2 * options.sigma**2)  # what the cut takes off a Gaussian's variance
    kept = 1 - ends * math.exp(-ends) / -math.expm1(-ends)
    assert np.abs(mean).max() < 0.02
    np.testing.assert_allclose(
        moments, spread * options.sigma**2 * kept, atol=0.01 * np.abs(moments).max()
    )
    assert total == pytest.approx(float(np.linalg.det(stretch)), rel=0.01)


def test_a_sample_without_neighbors_faces_the_reference_plane() -> None:
    reference = straight_camera(5, 5, focal=100)
    disparity = np.full((5, 5), np.nan)
    disparity[2, 2] = 0.5
    desired = straight_camera(101, 101, (0, 1.0, 0), focal=1000)
    weight = one_footprint(reference, desired, disparity, GaussianOptions())
    v, u = np.nonzero(weight)
    # a metre nearer and ten times the focal length: a circle of 1.5 reference pixels
    radius = 1.5 * math.hypot(20.0, 0.5)
    assert np.hypot(v - 50, u - 50).max() == pytest.approx(radius, abs=1)


@pytest.mark.parametrize("n", range(6))
def test_planes_come_out_exact(n: int) -> None:
    """Disparity of the plane at every pixel; no holes; nothing but the plane's colour."""
    rng = np.random.default_rng(n)
    camera = straight_camera(60, 50)
    normal = np.array([0, 1.0, 0]) + rng.normal(0, 0.25, 3)
    color = np.full((50, 60, 3), (0.2, 0.4, 0.8), np.float32)
    view = ReferenceView(camera, color, plane_disparity(camera, normal, 4.0).astype(np.float32))
    desired = random_camera(rng, 70, 60, reach=0.2, turn=0.3)
    frame = warp(view, desired, **GAUSSIAN)
    truth = plane_disparity(desired, normal, 4.0)
    point = desired.unproject(*desired.pixel_grid(), truth)
    u, v, _ = camera.project(point)
    inside = (u > 0) & (u < 59) & (v > 0) & (v < 49)
    assert inside.sum() > 300
    assert np.all(frame.coverage[inside] == 1)
    np.testing.assert_allclose(frame.disparity[inside], truth[inside], rtol=2e-5)
    np.testing.assert_allclose(frame.color[inside], color[:1, 0].repeat(inside.sum(), 0), rtol=1e-5)


# ---- the slow twin -----------------------------------------------------------------------------


@pytest.mark.parametrize("n", range(6))
def test_the_kernels_are_the_slow_twin(n: int) -> None:
    rng = np.random.default_rng(n)
    camera = straight_camera(26, 22)
    disparity, label = boards(rng, 22, 26, 3)
    slanted = disparity * np.linspace(1, 1.15, 26, dtype=np.float32)
    slanted[rng.random(slanted.shape) < 0.04] = np.nan
    label[np.isnan(slanted)] = -1
    view = ReferenceView(camera, noise(rng, 22, 26, "rgb32"), slanted)
    desired = Camera(
        random_rotation(rng, 0.2) @ camera.matrix, rng.normal(0, 0.3, 3), 33, 28
    ).resized(*((33, 28), (50, 40), (14, 11))[n % 3])
    options = GaussianOptions(sigma=(0.5, 0.4)[n % 2], low_pass=(0.25, 0.5)[n % 2])
    frame = warp(prepare(view, bridge=0), desired, gaussian=options, **GAUSSIAN)
    slow = gaussian_warp(
        camera, desired, view.color.astype(float), slanted.astype(float), label, options
    )
    assert slow.sure.mean() > 0.5
    assert (slow.coverage[slow.sure] > 0).mean() > 0.1
    sure = slow.sure
    np.testing.assert_allclose(frame.coverage[sure], slow.coverage[sure], atol=5e-3)
    np.testing.assert_allclose(frame.disparity[sure], slow.disparity[sure], rtol=1e-4)
    np.testing.assert_allclose(frame.color[sure], slow.color[sure], atol=0.02)


# ---- what it must not do -----------------------------------------------------------------------


@pytest.mark.parametrize("growth", [1.0, 1.5, 2.0, 4.0, 9.0])
@pytest.mark.parametrize("degrees", [0.0, 17.0, 45.0])
def test_nothing_behind_leaks_through_a_growing_turning_board(
    growth: float, degrees: float
) -> None:
    """A white board before a black wall, from ever nearer: inside it no pixel is but white."""
    camera = straight_camera(80, 80)
    disparity = np.full((80, 80), 0.25, np.float32)
    color = grey(80, 80, 0)
    board = np.s_[15:65, 15:65]
    disparity[board], color[board] = 0.5, 255
    desired = rolled(camera.moved((0, 2.0 - 2.0 / growth, 0)), degrees)
    frame = warp(view_of(camera, disparity, color), desired, **GAUSSIAN)
    u, v, d = warp_points(warp_matrix(desired, camera), *desired.pixel_grid(), 0.5 * growth)
    inside = (u > 14.6) & (u < 64.4) & (v > 14.6) & (v < 64.4)
    assert inside.sum() > 1000
    assert np.all(d > 0)
    assert np.all(frame.color[inside] == 255)
    assert np.all(frame.disparity[inside] > 0.49 * growth)
    deep = (u > 15) & (u < 64) & (v > 15) & (v < 64)
    assert np.all(frame.coverage[deep] == 1)


@pytest.mark.parametrize("shrink", [2, 3, 5, 8])
def test_a_shrunk_picture_has_no_holes_and_averages(shrink: int) -> None:
    camera = straight_camera(120, 120)
    color = checks(camera, 1)
    desired = straight_camera(120 // shrink, 120 // shrink)
    frame = warp(view_of(camera, np.full((120, 120), 0.3), color), desired, **GAUSSIAN)
    inside = np.s_[1:-1, 1:-1]
    assert np.all(frame.coverage[inside] == 1)
    mean = ((60 / 255) ** 2.2 + (200 / 255) ** 2.2) / 2  # in linear light, nearly
    assert np.abs(frame.color[inside] / 255.0 - mean ** (1 / 2.2)).max() < 0.02


def test_a_straight_edge_covers_half_a_pixel_where_it_cuts_it_in_half() -> None:
    camera = straight_camera(40, 40)
    disparity = np.full((40, 40), np.nan)
    disparity[:, :20] = 0.5
    shares = []
    for step in np.arange(0, 2, 0.125):
        desired = camera.moved((-2 * step / 40, 0, 0))  # the edge, at 19.5, moves right by a step
        shares.append(warp(view_of(camera, disparity), desired, **GAUSSIAN).coverage[20, 20])
    assert shares == sorted(shares)
    assert shares[0] == pytest.approx(0.0, abs=0.02)  # the whole pixel is beyond the edge
    assert shares[8] == pytest.approx(1.0)
    assert shares[4] == pytest.approx(0.5, abs=0.05)


def test_a_surface_seen_from_behind_shows_nothing() -> None:
    """A slanted plane, looked at from beyond it; points there are seen all the same."""
    camera = straight_camera(40, 40)
    disparity = plane_disparity(camera, (1.0, 0.3, 0), 0.8)
    disparity[disparity < 0.2] = np.nan
    beyond = camera.moved((1.0, -0.5, 0))
    assert warp(view_of(camera, disparity), beyond, reconstruction="point").coverage.any()
    assert not warp(view_of(camera, disparity), beyond, **GAUSSIAN).coverage.any()


def test_a_false_sample_between_two_surfaces_is_not_drawn() -> None:
    camera = straight_camera(40, 40)
    disparity, color = np.full((40, 40), 0.2), grey(40, 40, 0)
    disparity[:, 20:] = 0.6
    disparity[:, 19], color[:, 19] = 0.4, 255  # what resampling leaves of an edge
    frame = warp(view_of(camera, disparity, color), camera.moved((0.2, 0, 0)), **GAUSSIAN)
    assert not frame.color.any()


def test_one_sample_far_away_vanishes_in_a_small_picture_and_a_row_of_them_does_not() -> None:
    """Coverage is area: what is a hundredth of a pixel is reported as what it is, nothing."""
    camera = straight_camera(64, 64)
    lonely, row = (np.full((64, 64), np.nan) for _ in range(2))
    lonely[32, 32] = row[32:36, :] = 0.5
    small = straight_camera(16, 16)
    assert not warp(view_of(camera, lonely), small, **GAUSSIAN).coverage.any()
    assert warp(view_of(camera, row), small, **GAUSSIAN).coverage.max(axis=0).min() > 0.3


def test_visibility_by_order_and_by_comparison_are_one() -> None:
    rng = np.random.default_rng(3)
    disparity, _ = boards(rng, 50, 70)
    camera = straight_camera(70, 50)
    view = ReferenceView(camera, noise(rng, 50, 70), disparity)
    desired = camera.moved((0.3, 0.4, 0.1))
    frames = [warp(view, desired, visibility=one, **GAUSSIAN) for one in ("order", "zbuffer")]
    np.testing.assert_array_equal(frames[0].disparity, frames[1].disparity)
    np.testing.assert_allclose(frames[0].color.astype(int), frames[1].color.astype(int), atol=1)
