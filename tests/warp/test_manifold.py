"""Landing between any two central cameras, and panoramas that go on beyond their seams."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.ground.errors import CameraError
from belvedere.scene import CameraModel, CylinderCamera, OrthographicCamera, SphereCamera
from belvedere.warp.manifold import (
    SeamlessCamera,
    central,
    geometry,
    own_samples,
    same_pixels,
    seamless,
)
from tests.warp.worlds import random_camera, random_rotation, view_of

KINDS = ("plane", "cylinder", "sphere")


def any_camera(rng: np.random.Generator, kind: str, width: int = 40, height: int = 24) -> Any:
    """A camera of a kind, anywhere near, turned anyhow."""
    if kind == "plane":
        return random_camera(rng, width, height, 0.3, np.pi)
    turn, center = random_rotation(rng), rng.normal(size=3) * 0.3
    azimuth = rng.uniform(-3, 3)
    if kind == "sphere":
        return SphereCamera(center, width, height, turn, azimuth)
    return CylinderCamera(
        center, width, height, turn, azimuth, rng.uniform(0, height), rng.uniform(0.02, 0.2)
    )


def land(
    reference: CameraModel, desired: CameraModel, u: Any, v: Any, delta: Any
) -> np.ndarray[Any, Any]:
    """(n, 3) column, row and disparity in the desired view, by the kernels' own arithmetic."""
    from belvedere.warp import _landing

    g = geometry(reference, desired)
    out = []
    for each in zip(u, v, delta, strict=True):
        x, y, scale = _landing.project(g, _landing.TARGET, *_landing.reach(g, *each))
        out.append((x, y, each[2] * scale))
    return np.array(out)


@pytest.mark.parametrize("first", KINDS)
@pytest.mark.parametrize("second", KINDS)
def test_a_sample_lands_where_its_point_projects(first: str, second: str) -> None:
    rng = np.random.default_rng(0)
    shown = 0
    for _ in range(20):
        reference, desired = any_camera(rng, first), any_camera(rng, second)
        u, v = rng.uniform(-0.5, 39.5, 50), rng.uniform(-0.5, 23.5, 50)
        delta = rng.uniform(0.05, 3.0, 50)
        found = land(reference, desired, u, v, delta)
        wanted = np.stack(desired.project(reference.unproject(u, v, delta)), axis=-1)
        np.testing.assert_array_equal(np.isnan(found).any(-1), np.isnan(wanted).any(-1))
        seen = ~np.isnan(wanted).any(-1)
        # one column is another a turn further on
        if second != "plane":
            found[:, 0] += 40 * np.rint((wanted[:, 0] - found[:, 0]) / 40)
        np.testing.assert_allclose(found[seen], wanted[seen], rtol=1e-9, atol=1e-9)
        shown += int(seen.sum())
    assert shown > (300 if second == "plane" else 900)


@pytest.mark.parametrize("kinds", [("plane", "sphere", "plane"), ("cylinder", "plane", "sphere"),
                                   ("sphere", "cylinder", "sphere")])  # fmt: skip
def test_landing_by_way_of_a_third_camera_is_landing_at_once(kinds: tuple[str, str, str]) -> None:
    rng = np.random.default_rng(1)
    compared = 0
    for _ in range(20):
        a, b, c = (any_camera(rng, kind) for kind in kinds)
        u, v = rng.uniform(0, 39, 30), rng.uniform(0, 23, 30)
        delta = rng.uniform(0.1, 2.0, 30)
        there = land(a, b, u, v, delta)
        known = ~np.isnan(there).any(-1)
        twice = land(b, c, *there[known].T)
        once = land(a, c, u[known], v[known], delta[known])
        seen = ~np.isnan(once).any(-1)
        np.testing.assert_allclose(twice[seen], once[seen], rtol=1e-7, atol=1e-7)
        compared += int(seen.sum())
    assert compared > 100


@pytest.mark.parametrize("kind", ["cylinder", "sphere"])
def test_a_seamless_view_shows_everywhere_what_its_rays_meet(kind: str) -> None:
    rng = np.random.default_rng(2)
    camera = any_camera(rng, kind, 24, 10)
    view = view_of(camera, rng.uniform(0.1, 1.0, (10, 24)), rng.integers(0, 256, (10, 24, 3),
                   dtype=np.uint8))  # fmt: skip
    whole = seamless(view)
    assert isinstance(whole.camera, SeamlessCamera)
    assert whole.camera.size == whole.disparity.shape
    u, v = np.broadcast_arrays(*whole.camera.pixel_grid())
    x, y, _ = camera.project(camera.center + whole.camera.rays(u, v))
    x, y = np.rint(x).astype(int) % 24, np.rint(y).astype(int)
    assert y.min() >= 0
    assert y.max() < 10
    np.testing.assert_array_equal(whole.disparity, view.disparity[y, x])
    np.testing.assert_array_equal(whole.color, view.color[y, x])
    rows, columns = own_samples(whole.camera)
    np.testing.assert_array_equal(whole.disparity[rows, columns], view.disparity)
    again = np.stack(whole.camera.project(whole.camera.unproject(u, v, whole.disparity)))
    np.testing.assert_allclose(again[:2, rows, columns], [u[rows, columns], v[rows, columns]],
                               atol=1e-9)  # fmt: skip


def test_beyond_a_pole_of_an_odd_sphere_the_other_side_is_half_a_column_off_at_most() -> None:
    camera = SphereCamera((0, 0, 0), 25, 12)
    u, v = np.broadcast_arrays(*camera.pixel_grid())
    x = camera.rays(u, v)[..., 0]
    whole = seamless(view_of(camera, x - x.min()))
    grid = np.broadcast_arrays(*whole.camera.pixel_grid())
    off = np.abs(whole.disparity - (whole.camera.rays(*grid)[..., 0] - x.min()))
    ring = np.cos(np.pi * (0.5 - np.arange(-12, 24) / 12 - 0.5 / 12))
    assert (off <= np.abs(ring)[:, None] * np.pi / 25 + 1e-6).all()


def test_only_one_camera_shows_the_same_pixels() -> None:
    camera = SphereCamera((0, 0, 0), 32, 16)
    assert same_pixels(camera, SphereCamera((0, 0, 0), 32, 16))
    assert same_pixels(seamless(view_of(camera, np.ones((16, 32)))).camera, camera)
    turned = SphereCamera((0, 0, 0), 32, 16, azimuth=0.1)
    others = [turned, camera.moved((0, 0, 1e-9)), camera.resized(32, 8),
              SphereCamera((0, 0, 0), 32, 16, random_rotation(np.random.default_rng(0))),
              CylinderCamera((0, 0, 0), 32, 16)]  # fmt: skip
    for other in others:
        assert not same_pixels(camera, other)


def test_parallel_rays_are_refused_with_what_to_use_instead() -> None:
    plan = OrthographicCamera.along((0, 0, -1), up=(0, 1, 0), view_height=4.0, width=9, height=9)
    with pytest.raises(CameraError, match="OrthographicCamera, but warping goes between cameras "
                       r"whose rays meet in one point \(belvedere.Camera"):  # fmt: skip
        central(plan, "reference")
