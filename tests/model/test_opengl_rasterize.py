"""Polygons drawn with OpenGL: the pictures of `Rasterizer`, whoever draws them."""

from __future__ import annotations

import sys
import threading
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("moderngl", reason="OpenGL needs moderngl (pip install 'belvedere[opengl]')")

from dataclasses import replace

from belvedere.ground.errors import (
    BelvedereError,
    CameraError,
    InputError,
    MissingDependencyError,
)
from belvedere.model import LitModel, OpenGLRasterizer, Rasterizer, opengl_rasterize, photograph
from belvedere.model import _kernels as kernels
from belvedere.model._draw_plan import DrawPlan
from belvedere.scene import Camera, SphereCamera
from belvedere.studio.metrics import psnr
from tests.model.test_rasterize import CAMERAS, evenly_lit
from tests.oracles.raster import nearest_faces


@pytest.fixture(scope="module", autouse=True)
def context() -> None:
    import moderngl

    try:
        make: Any = moderngl.create_context
        make(require=330, standalone=True, backend="egl").release()
    except Exception as error:
        pytest.skip(f"no OpenGL on this machine: {error}")


@pytest.fixture(scope="module")
def drawer(house: LitModel) -> OpenGLRasterizer:
    return OpenGLRasterizer(house)


@pytest.mark.parametrize(("eye", "target", "fov"), CAMERAS)
def test_the_picture_is_that_of_rays(house, drawer, eye, target, fov) -> None:
    camera = Camera.look_at(eye, target, fov_deg=fov, width=320, height=240)
    truth = photograph(house, camera, 1)
    color, disparity, face = drawer.draw(camera)
    agree = np.abs(disparity - truth.disparity) <= 1e-5 * truth.disparity
    assert agree.mean() > 0.999
    assert ((face >= 0) == (disparity > 0)).all()
    assert psnr(color, truth.color) > 45.0
    assert psnr(color, truth.color, agree) > 50.0


def test_corner_colors_multiply_what_materials_are(house) -> None:
    camera = Camera.look_at(*CAMERAS[0][:2], fov_deg=60, width=160, height=120)
    random = np.random.default_rng(3).uniform(0.2, 1.0, (len(house.mesh.faces), 3, 3))
    mesh = replace(house.mesh, colors=random.astype(np.float32))
    model = LitModel(mesh, house.charts, house.light)
    color, _, face = OpenGLRasterizer(model).draw(camera)
    expected, _, same = Rasterizer(model).draw(camera)
    assert psnr(color, expected, face == same) > 50.0


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_random_triangles_are_those_of_the_slow_twin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    size = 10.0 ** rng.uniform(-1.5, 1.0)
    quads = rng.uniform((1, -3, -3), (7, 3, 3), (12, 1, 3)) + rng.uniform(-size, size, (12, 4, 3))
    quads[:, 3] = quads[:, 0] + quads[:, 2] - quads[:, 1]
    model = evenly_lit(quads)
    straight = Camera.look_at(rng.normal(0, 1, 3), rng.normal(4, 0.5, 3) * [1, 0.1, 0.1],
                              fov_deg=float(rng.uniform(20, 110)), width=64, height=60)  # fmt: skip
    camera = straight.cropped(9, -5, 48, 36)  # off-axis
    face, delta = nearest_faces(model.mesh, camera)
    _, disparity, drawn = OpenGLRasterizer(model).draw(camera)
    same = face == drawn
    assert same.mean() > 0.985  # a corner is rounded to a part of a pixel
    np.testing.assert_allclose(disparity[same], delta[same], rtol=2e-5)


def test_parts_make_the_whole_and_what_is_outside_planes_may_be_left_out(house, drawer) -> None:
    camera = Camera.look_at(*CAMERAS[0][:2], fov_deg=60, width=200, height=150)
    whole = drawer.draw(camera)
    half = len(house.mesh.faces) // 2
    parts = [drawer.prepare(np.arange(half)), drawer.prepare(np.arange(half, 2 * half + 1)[:-1])]
    again = drawer.draw(camera, [(part, None) for part in parts])
    assert (again[2] == whole[2]).mean() > 0.99  # of faces that coincide either may show
    left, right = camera.rays([60, 140], [75, 75])
    planes = np.array([np.cross(camera.matrix[:, 1], left), -np.cross(camera.matrix[:, 1], right)])
    planes *= np.sign(planes @ camera.rays(100, 75))[:, None]
    _, _, face = drawer.draw(camera, [(drawer.prepare(), planes)])
    assert (face[:, 61:140] == whole[2][:, 61:140]).mean() > 0.998
    assert (face[:, :20] != whole[2][:, :20]).any()


def test_ranges_hold_every_cluster_in_sight_once_and_leave_others_out(house) -> None:
    camera = Camera.look_at(*CAMERAS[0][:2], fov_deg=20, width=64, height=48)
    rasterizer = Rasterizer(house)
    drawn = rasterizer.prepare()
    plan = DrawPlan(camera, rasterizer.origin, [(drawn, None)])
    times = np.zeros(len(drawn.faces), dtype=int)
    for first, last in opengl_rasterize._ranges(plan, drawn):
        times[first:last] += 1
    assert times.max() == 1
    for cluster in plan.cluster:
        assert times[drawn.first_face[cluster] : drawn.first_face[cluster + 1]].all()
    assert 0.05 < times.mean() < 0.9


def test_a_floor_under_the_eye_is_cut_not_turned_inside_out() -> None:
    floor = np.array([[[-500, -500, 0], [500, -500, 0], [500, 500, 0], [-500, 500, 0]]], float)
    camera = Camera.look_at((0, 0, 1.6), (1, 0, 1.6), fov_deg=90, width=64, height=64)
    _, disparity, face = OpenGLRasterizer(evenly_lit(floor)).draw(camera)
    rows = np.arange(64)[:, None] - 31.5
    expected = np.broadcast_to(rows / 32.0 / 1.6, (64, 64))
    assert (face[34:] >= 0).all()
    assert (face[:32] == -1).all()
    np.testing.assert_allclose(disparity[34:], expected[34:], rtol=1e-5)


def test_no_faces_draw_the_sky(drawer) -> None:
    camera = Camera.look_at(*CAMERAS[0][:2], width=32, height=24)
    color, disparity, face = drawer.draw(camera, [(drawer.prepare(np.zeros(0, int)), None)])
    assert (face == -1).all()
    assert (disparity == 0).all()
    assert color.any()


def test_pictures_of_other_sizes_and_other_models_come_between(house, drawer) -> None:
    cameras = [Camera.look_at(*CAMERAS[k][:2], width=w, height=h)
               for k, w, h in ((0, 60, 40), (1, 33, 57), (0, 60, 40))]  # fmt: skip
    other = OpenGLRasterizer(
        evenly_lit(np.array([[[3, -1, -1], [3, 1, -1], [3, 1, 1], [3, -1, 1]]]))
    )
    first = drawer.draw(cameras[0])
    other.draw(cameras[1])
    drawer.draw(cameras[1])
    for a, b in zip(first, drawer.draw(cameras[2]), strict=True):
        np.testing.assert_array_equal(a, b)


def test_another_thread_may_draw(drawer) -> None:
    camera = Camera.look_at(*CAMERAS[0][:2], width=40, height=30)
    here, there = drawer.draw(camera), []
    thread = threading.Thread(target=lambda: there.append(drawer.draw(camera)))
    thread.start()
    thread.join()
    for a, b in zip(here, there[0], strict=True):
        np.testing.assert_array_equal(a, b)


def test_a_plane_through_the_eye_has_no_disparity_of_its_own() -> None:
    face = np.array([[0, 1, -1]], dtype=np.int32)
    plane = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 2.0]])
    out = np.empty((1, 3), dtype=np.float32)
    matrix = np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]])
    unknown = kernels.plane_disparities(face, 0, 1, matrix, np.zeros(3), plane, out)
    assert unknown == 1
    np.testing.assert_array_equal(out, [[np.nan, 0.5, 0.0]])


def test_what_it_cannot_draw_is_refused(drawer) -> None:
    with pytest.raises(CameraError, match="photograph"):
        drawer.draw(SphereCamera.at((1, 1, 1), width=32, height=16))
    with pytest.raises(CameraError, match="expected at most"):
        drawer.draw(Camera.look_at((0, 0, 0), (1, 0, 0), width=10**6, height=2))
    with pytest.raises(InputError, match="there are"):
        drawer.prepare([10**7])


def test_who_draws_can_be_asked(drawer) -> None:
    assert drawer.renderer


def test_a_machine_without_moderngl_or_without_opengl_is_told(house, monkeypatch) -> None:
    import moderngl

    def refuse(**_: Any) -> None:
        raise RuntimeError("no driver")

    monkeypatch.setattr(moderngl, "create_context", refuse)
    with pytest.raises(BelvedereError, match=r"no OpenGL 3\.3 context .*no driver"):
        OpenGLRasterizer(house)
    monkeypatch.setitem(sys.modules, "moderngl", None)
    with pytest.raises(MissingDependencyError, match=r"belvedere\[opengl\]"):
        OpenGLRasterizer(house)
