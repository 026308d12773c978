"""The mesh: continuous inside surfaces, cut between them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.scene import Camera, ReferenceView
from belvedere.warp import prepare, warp, warp_matrix, warp_points
from tests.warp.worlds import (
    VISIBILITIES,
    plane_disparity,
    random_camera,
    straight_camera,
    view_of,
)


def ramp(camera: Camera) -> np.ndarray:
    """(H, W, 3) float32 colours affine in the place in the picture."""
    u, v = np.broadcast_arrays(*camera.pixel_grid())
    return np.stack([0.01 * u, 0.02 * v, 0.5 + 0.003 * (u - v)], -1).astype(np.float32)


def back_to_reference(
    reference: Camera, desired: Camera, normal: Any, offset: float
) -> tuple[np.ndarray, np.ndarray]:
    """Reference pixel (u, v) of the plane's point at each desired pixel; NaN behind."""
    delta = plane_disparity(desired, normal, offset)
    u, v = np.broadcast_arrays(*desired.pixel_grid())
    delta = np.where(delta > 0, delta, np.nan)
    return warp_points(warp_matrix(desired, reference), u, v, delta)[:2]


@pytest.mark.parametrize("visibility", VISIBILITIES)
def test_a_slanted_plane_is_one_picture_under_turns_and_zooms(visibility: Any) -> None:
    rng = np.random.default_rng(0)
    inside_all = 0
    for _ in range(25):
        reference = straight_camera(64, 48)
        normal = np.array([rng.normal(0, 0.3), 1.0, rng.normal(0, 0.3)])
        offset = 4.0
        delta = plane_disparity(reference, normal, offset)
        if delta.min() < 0.02:
            continue
        desired = random_camera(rng, 97, 61, reach=0.6, turn=0.7)
        frame = warp(
            view_of(reference, delta, ramp(reference)),
            desired,
            reconstruction="mesh",
            visibility=visibility,
        )
        u, v = back_to_reference(reference, desired, normal, offset)
        inside = (u >= -0.45) & (u <= 63.45) & (v >= -0.45) & (v <= 47.45)
        middle = (u >= 0) & (u <= 63) & (v >= 0) & (v <= 47)
        inside_all += int(inside.sum())
        assert np.all(frame.coverage[inside] == 1)
        wanted = np.stack([0.01 * u, 0.02 * v, 0.5 + 0.003 * (u - v)], -1)
        # two triangles are affine in the desired view, the picture is projective within a cell
        np.testing.assert_allclose(frame.color[middle], wanted[middle], atol=2e-3)
        truth = plane_disparity(desired, normal, offset)
        np.testing.assert_allclose(frame.disparity[inside], truth[inside], rtol=1e-4)
        outside = (u < -0.55) | (u > 63.55) | (v < -0.55) | (v > 47.55) | np.isnan(u)
        assert np.all(frame.coverage[outside] == 0)
    assert inside_all > 10_000


@pytest.mark.parametrize("visibility", VISIBILITIES)
def test_no_skin_hangs_between_a_near_board_and_the_wall(visibility: Any) -> None:
    camera = straight_camera(64, 48)
    disparity = np.full((48, 64), 0.2, np.float32)
    disparity[14:34, 20:44] = 0.8
    color = np.where(disparity[..., None] > 0.5, [250, 0, 0], [0, 0, 250]).astype(np.uint8)
    view = ReferenceView(camera, color, disparity)
    for step in ((0.3, 0, 0), (-0.3, 0, 0.2), (0.1, 0.5, -0.3), (0.2, -0.5, 0)):
        frame = warp(view, camera.moved(step), reconstruction="mesh", visibility=visibility)
        seen = frame.coverage > 0
        wall, board = (d / (1 - d * step[1]) for d in (0.2, 0.8))
        near = np.abs(frame.disparity - board) < 1e-4
        far = np.abs(frame.disparity - wall) < 1e-4
        np.testing.assert_array_equal(near | far, seen)
        assert np.all(frame.color[near] == [250, 0, 0])
        assert np.all(frame.color[far] == [0, 0, 250])
        assert near.sum() > 200
        assert (~seen).sum() > 100


@pytest.mark.parametrize("reconstruction", ["mesh", "offset"])
def test_a_thin_object_survives(reconstruction: Any) -> None:
    camera = straight_camera(64, 48)
    disparity = np.full((48, 64), 0.2, np.float32)
    disparity[:, 30] = 0.6
    disparity[24, 40:60] = 0.6
    disparity[10, 50] = 0.6
    frame = warp(view_of(camera, disparity), camera.moved((0.2, 0, 0)),
                 reconstruction=reconstruction)  # fmt: skip
    near = np.abs(frame.disparity - 0.6) < 1e-3
    shift = 64 * 0.2 * 0.6  # 7.68 pixels to the left
    assert near[:, int(30 - shift)].all() or near[:, int(31 - shift)].all()
    assert near[24, int(41 - shift) : int(59 - shift)].all()
    assert near[10, int(50 - shift)] or near[10, int(51 - shift)]
    assert near.sum() <= 2 * (48 + 22)


@pytest.mark.parametrize("reconstruction", ["mesh", "offset"])
def test_mixed_samples_are_dropped(reconstruction: Any) -> None:
    camera = straight_camera(64, 48)
    disparity = np.full((48, 64), 0.2, np.float32)
    disparity[:, 32:] = 0.8
    disparity[:, 31] = 0.5
    frame = warp(view_of(camera, disparity), camera.moved((0.2, 0, 0)),
                 reconstruction=reconstruction)  # fmt: skip
    values = np.unique(np.round(frame.disparity[frame.coverage > 0], 3))
    assert set(values.tolist()) == {np.float32(0.2).item(), np.float32(0.8).item()} or np.allclose(
        values, [0.2, 0.8]
    )
    part = camera.cropped(0, 0, 63, 48)  # the same pixels, but not the same picture
    dropped = warp(view_of(camera, disparity), part, reconstruction=reconstruction)
    assert np.all(dropped.coverage[:, 31] == 0)


def test_a_plane_seen_from_behind_is_culled() -> None:
    camera = straight_camera(40, 30)
    normal = np.array([1.0, 0.25, 0.0])  # a wall along the line of sight, to the right
    delta = plane_disparity(camera, normal, 1.5)
    view = view_of(camera, np.where(delta > 0.02, delta, np.nan), ramp(camera))
    before = warp(view, camera.moved((-0.3, 0, 0)), reconstruction="mesh")
    assert (before.coverage > 0).sum() > 200
    behind = camera.moved((8, 0, 0))
    assert not warp(view, behind, reconstruction="mesh").coverage.any()
    # and the points are in its picture: they are merely seen from the back
    points = camera.unproject(*camera.pixel_grid(), view.disparity)
    u, v, _ = behind.project(points[np.isfinite(view.disparity)])
    assert ((u > 0) & (u < 39) & (v > 0) & (v < 29)).sum() > 20


def test_one_cell_never_grows_beyond_the_largest_quad() -> None:
    camera = straight_camera(5, 5, focal=5)
    view = view_of(camera, np.ones((5, 5)))
    for growth, painted in ((20.0, True), (60.0, True), (70.0, False)):
        desired = straight_camera(301, 301, (0, 1 - 1 / growth, 0), focal=5)
        frame = warp(view, desired, reconstruction="mesh")
        assert frame.coverage.any() == painted
        if painted:  # five samples of that size, or as many as the view holds
            wide = min(301, round(5 * growth))
            assert abs((frame.coverage > 0).sum() - wide**2) <= 4 * wide


def test_bridged_seams_do_not_show() -> None:
    camera = straight_camera(64, 48)
    disparity = np.full((48, 64), 0.25, np.float32)
    disparity[:, 20:22] = np.nan
    view = view_of(camera, disparity, ramp(camera))
    desired = camera.moved((0.1, 0.3, 0.05))
    whole = warp(view, desired, reconstruction="mesh")
    torn = warp(prepare(view, bridge=0), desired, reconstruction="mesh")
    interior = np.s_[6:-6, 6:-6]
    assert np.all(whole.coverage[interior] == 1)
    assert (torn.coverage[interior] == 0).sum() >= 36
