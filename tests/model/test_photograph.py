"""Photographs: exact disparity, believable colour, one answer for any number of threads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from belvedere.ground.color import color_to_linear
from belvedere.ground.errors import InputError
from belvedere.model import Interior, LightSettings, LitModel, ModelScene, RayCaster, bake
from belvedere.model import photograph as photograph_
from belvedere.model.charts import Builder
from belvedere.model.shapes import box
from belvedere.scene import (
    Camera,
    CameraModel,
    CylinderCamera,
    OrthographicCamera,
    ReferenceView,
    Scene,
    SphereCamera,
)
from tests.model.test_rasterize import evenly_lit

CAMERAS: list[CameraModel] = [
    Camera.look_at((1.0, 1.4, 1.6), (4.4, 2.9, 1.1), width=80, height=60),
    CylinderCamera.at((6.6, 2.9, 1.6), forward=(1.0, 0.0, 0.0), width=96, height=40),
    SphereCamera.at((4.6, 5.7, 1.6), forward=(1.0, 0.0, 0.0), width=96, height=48),
]


def empty_room(low: tuple[float, ...], high: tuple[float, ...]) -> LitModel:
    b = Builder()
    box(b, low, high, b.material("white", (0.5, 0.5, 0.5)), inside=True)
    mesh, charts = b.finish()
    light = bake(mesh, charts, RayCaster(mesh), LightSettings(rays=4, bounces=0))
    return LitModel(mesh, charts, light)


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda c: type(c).__name__)
def test_disparity_in_an_empty_room_is_that_of_its_planes(camera: CameraModel) -> None:
    low, high = (-1.0, -0.7, -0.2), (11.3, 8.1, 4.4)
    view = photograph_(empty_room(low, high), camera, samples=1)
    rays = camera.rays(*camera.pixel_grid())
    with np.errstate(divide="ignore", invalid="ignore"):
        to_wall = np.maximum(rays / (np.array(high) - camera.center),
                             rays / (np.array(low) - camera.center))  # fmt: skip
    np.testing.assert_allclose(view.disparity, to_wall.max(axis=-1), rtol=1e-6)


def test_an_orthographic_photograph_knows_its_depth() -> None:
    camera = OrthographicCamera.look_at(
        (2.0, 2.0, 3.0), (2.0, 2.0, 0.0), up=(0.0, 1.0, 0.0), width=16, height=12, view_height=1.0
    )
    view = photograph_(empty_room((0, 0, 0), (4, 4, 4)), camera, samples=1)
    points = camera.unproject(*camera.pixel_grid(), view.disparity)
    np.testing.assert_allclose(points[..., 2], 0.0, atol=1e-6)


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda c: type(c).__name__)
def test_every_pixel_lies_on_the_surface_it_shows(house: Interior, camera: CameraModel) -> None:
    view = photograph_(house, camera, samples=1)
    u, v = camera.pixel_grid()
    rays = camera.rays(u, v).reshape(-1, 3)
    hits = house.caster.cast(np.broadcast_to(camera.center, rays.shape), rays)
    near = hits.face >= 0
    np.testing.assert_array_equal(view.disparity.ravel() > 0, near)
    points = camera.unproject(u, v, view.disparity).reshape(-1, 3)[near]
    corner = house.mesh.vertices[house.mesh.faces[hits.face[near], 0]]
    off = np.einsum("ij,ij->i", points - corner, house.mesh.normals()[hits.face[near]])
    assert np.abs(off).max() < 2e-6  # metres: the float32 of the stored disparity


def test_the_sky_outside_is_infinitely_far_and_bright(house: Interior) -> None:
    camera = Camera.look_at((1.4, 2.0, 1.6), (1.4, -1.0, 1.8), width=64, height=48)
    view = photograph_(house, camera, samples=2, dtype="float32")
    sky = view.disparity == 0
    assert 0.1 < sky.mean() < 0.9
    assert view.color[sky].mean() > 0.15
    assert np.isfinite(view.disparity).all()


def test_bytes_are_the_encoded_linear_picture(house: Interior) -> None:
    linear = photograph_(house, CAMERAS[0], samples=2, dtype="float32").color
    encoded = photograph_(house, CAMERAS[0], samples=2).color
    assert linear.dtype == np.float32
    assert encoded.dtype == np.uint8
    from belvedere.ground.color import encode_srgb8

    assert np.abs(encode_srgb8(linear).astype(int) - encoded).max() <= 1  # table of 4096 entries


def test_threads_do_not_change_a_photograph(house: Interior) -> None:
    one, two = (photograph_(house, CAMERAS[0], samples=2, threads=n) for n in (1, 2))
    np.testing.assert_array_equal(one.color, two.color)
    np.testing.assert_array_equal(one.disparity, two.disparity)


def test_samples_on_a_flat_surface_need_no_rays_of_their_own(house: Interior) -> None:
    """The shortcut of `photograph`, held against a picture that casts every sample."""
    camera = CAMERAS[0]
    assert isinstance(camera, Camera)
    fine = camera.resized(camera.width * 3, camera.height * 3)
    every = photograph_(house, fine, samples=1, dtype="float32").color
    mean = every.reshape(camera.height, 3, camera.width, 3, 3).mean(axis=(1, 3))
    quick = photograph_(house, camera, samples=3, dtype="float32").color
    error = np.abs(quick - mean)
    assert np.median(error) < 2e-3
    assert error.mean() < 6e-3  # mip levels differ a little between the two


def test_a_texture_of_one_color_looks_the_same_from_any_distance() -> None:
    """Whichever two of a texture's levels a sample reads, their weights add up to one."""
    grey = np.full((256, 256, 3), 150, np.uint8)
    floor = np.array([[[-40, -40, 0], [40, -40, 0], [40, 40, 0], [-40, 40, 0]]], dtype=float)
    plain = evenly_lit(floor)
    (paper,) = plain.mesh.materials
    uv = plain.mesh.vertices[plain.mesh.faces][:, :, :2].astype(np.float32)
    textured = LitModel(
        replace(plain.mesh, materials=(replace(paper, texture=grey),), uv=uv),
        plain.charts, plain.light,
    )  # fmt: skip
    # pixels from one to thousands of texels: every share of two neighbouring levels
    camera = Camera.look_at((0.0, 0.0, 1.0), (1.0, 0.1, 0.8), width=120, height=160)
    painted, bare = (
        photograph_(model, camera, samples=1, dtype="float32") for model in (textured, plain)
    )
    seen = bare.disparity > 0
    assert seen.mean() > 0.5
    gain = color_to_linear(grey[:1, :1])[0, 0]
    np.testing.assert_allclose(painted.color[seen], bare.color[seen] * gain, rtol=1e-5)


def test_a_model_is_a_scene(house: Interior) -> None:
    home = Camera.look_at((1.0, 1.4, 1.6), (4.4, 2.9, 1.1), width=32, height=24)
    scene = ModelScene(house, home, samples=1)
    assert isinstance(scene, Scene)
    assert scene.affords.as_dict() == {
        "movement": "continuous", "geometry": "global", "lighting": "fixed",
    }  # fmt: skip
    assert scene.viewing_region.contains(home.center)
    frame = scene.render(home)
    assert frame.hole_fraction == 0
    assert isinstance(frame.as_view(), ReferenceView)


def test_photographs_refuse_what_they_cannot_take(house: Interior) -> None:
    with pytest.raises(InputError, match=r"photograph\.samples is 0, expected a whole number"):
        photograph_(house, CAMERAS[0], samples=0)
    with pytest.raises(InputError, match=r"photograph\.dtype is 'uint16', expected one of"):
        photograph_(house, CAMERAS[0], dtype="uint16")  # type: ignore[arg-type]
