"""Lit polygons drawn fast."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from belvedere.ground.errors import CameraError, InputError
from belvedere.model import LitModel, Rasterizer, _draw_plan, _raster_setup, photograph
from belvedere.model.charts import Builder
from belvedere.model.lattice import Lattice
from belvedere.model.light import LightMap
from belvedere.scene import Camera, SphereCamera
from belvedere.scene.mesh import Material
from belvedere.studio.metrics import psnr
from tests.oracles.raster import nearest_faces


def evenly_lit(corners: np.ndarray) -> LitModel:
    """Quads (K, 4, 3) of white paper under an even light."""
    b = Builder()
    paper = b.material("paper", (0.6, 0.5, 0.4))
    b.patches(corners, paper, np.zeros((len(corners), 4, 2)))
    mesh, charts = b.finish()
    count = len(charts.material)
    one = Lattice(np.arange(count, dtype=np.int32), np.ones((count, 2), dtype=np.int32))
    light = LightMap(one, np.full((count, 3), 0.5, np.float32), one, np.zeros(count, np.float32),
                     np.zeros(3, np.float32))  # fmt: skip
    return LitModel(mesh, charts, light)


def box_corners(low, high) -> np.ndarray:
    x0, y0, z0, x1, y1, z1 = *low, *high
    p = np.array([[x, y, z] for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)], dtype=float)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return np.array([[p[i] for i in quad] for quad in quads])


CAMERAS = [
    ((1.2, 1.5, 1.6), (5.0, 2.3, 1.5), 60.0),
    ((7.0, 3.6, 1.6), (6.8, 7.0, 1.5), 60.0),
    ((5.27, 2.2, 1.6), (9.0, 2.3, 1.2), 100.0),  # in a doorway, close to its lining
    ((4.0, 6.0, 4.4), (8.0, 7.0, 0.0), 75.0),
]


@pytest.mark.parametrize(("eye", "target", "fov"), CAMERAS)
def test_the_picture_is_that_of_rays(house, eye, target, fov) -> None:
    camera = Camera.look_at(eye, target, fov_deg=fov, width=320, height=240)
    truth = photograph(house, camera, 1)
    color, disparity, face = Rasterizer(house).draw(camera)
    agree = np.abs(disparity - truth.disparity) <= 1e-5 * truth.disparity
    assert agree.mean() > 0.999
    assert ((face >= 0) == (disparity > 0)).all()
    assert psnr(color, truth.color) > 45.0
    assert psnr(color, truth.color, agree) > 50.0


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_random_triangles_are_those_of_the_slow_twin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    size = 10.0 ** rng.uniform(-2, 1.5)
    middle = rng.uniform((1, -3, -3), (7, 3, 3), (12, 1, 3))
    quads = middle + rng.uniform(-size, size, (12, 4, 3))
    quads[:, 3] = quads[:, 0] + quads[:, 2] - quads[:, 1]
    model = evenly_lit(quads)
    camera = Camera.look_at(rng.normal(0, 1, 3), rng.normal((4.0, 0.0, 0.0), 0.5),
                            fov_deg=float(rng.uniform(20, 120)), width=48, height=36)  # fmt: skip
    face, delta = nearest_faces(model.mesh, camera)
    _, disparity, drawn = Rasterizer(model).draw(camera)
    same = face == drawn
    assert same.mean() > 0.985  # a corner is rounded to 1/256 of a pixel
    np.testing.assert_allclose(disparity[same], delta[same], rtol=2e-5)


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.1, 2.5])
def test_a_closed_box_has_no_cracks_and_no_pixel_twice(turn: float) -> None:
    """A fine tessellation from inside: every pixel is covered, and by one face of each plane."""
    n = 24
    cells = []
    for quad in box_corners((-2, -1.5, -1.2), (2, 1.5, 1.4)):
        s = np.linspace(0, 1, n + 1)
        grid = (
            quad[0] * (1 - s[:, None, None]) * (1 - s[None, :, None])
            + quad[1] * s[:, None, None] * (1 - s[None, :, None])
            + quad[2] * s[:, None, None] * s[None, :, None]
            + quad[3] * (1 - s[:, None, None]) * s[None, :, None]
        )
        corners = (grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:])
        cells.append(np.stack(corners, axis=2).reshape(-1, 4, 3))
    model = evenly_lit(np.concatenate(cells))
    camera = Camera.look_at((0.3, 0.2, 0.1), (np.cos(turn), np.sin(turn), 0.4), fov_deg=90,
                            width=200, height=160)  # fmt: skip
    rasterizer = Rasterizer(model)
    _, _, face = rasterizer.draw(camera)
    assert (face >= 0).all()
    # each face alone: together they cover what the whole does, no pixel by two of one plane
    per_plane = 2 * n * n
    for plane in range(6):
        covered = np.zeros(camera.size, dtype=int)
        for start in range(plane * per_plane, (plane + 1) * per_plane, 8):
            alone = rasterizer.prepare(np.arange(start, start + 8))
            _, _, one = rasterizer.draw(camera, [(alone, None)])
            covered += one >= 0
        assert covered.max() <= 1


@pytest.mark.parametrize("size", [(1, 1), (3, 2), (7, 30), (8, 8), (64, 40)])
def test_textures_of_any_size_are_read_as_photographs_read_them(size) -> None:
    """A texture of fewer than eight texels a side has no second level."""
    plain = evenly_lit(np.array([[[3, -2, -2], [3, 2, -2], [3, 2, 2], [3, -2, 2]]], dtype=float))
    texture = np.random.default_rng(1).integers(0, 256, (*size, 3)).astype(np.uint8)
    uv = np.array([[[0, 0], [2, 0], [2, 2]], [[0, 0], [2, 2], [0, 2]]], dtype=np.float32)
    paper = Material("paper", (0.9, 0.8, 0.7), texture)
    model = LitModel(replace(plain.mesh, materials=(paper,), uv=uv), plain.charts, plain.light)
    for fov in (4, 60, 170):
        camera = Camera.look_at((0, 0.3, 0.2), (3, 0, 0), fov_deg=fov, width=64, height=48)
        truth = photograph(model, camera, 1)
        color, _, _ = Rasterizer(model).draw(camera)
        assert psnr(color, truth.color) > 40.0


def test_parts_and_threads_change_nothing(house) -> None:
    camera = Camera.look_at(*CAMERAS[0][:2], fov_deg=60, width=200, height=150)
    whole = Rasterizer(house, threads=1).draw(camera)
    for threads in (2, 3, 4):
        for a, b in zip(whole, Rasterizer(house, threads).draw(camera), strict=True):
            np.testing.assert_array_equal(a, b)
    rasterizer = Rasterizer(house)
    seen = rasterizer.prepare(np.unique(whole[2][whole[2] >= 0]))
    again = rasterizer.draw(camera, [(seen, None)])
    np.testing.assert_array_equal(again[0], whole[0])


def test_what_lies_outside_the_planes_may_be_left_out_and_nothing_inside_is(house) -> None:
    camera = Camera.look_at(*CAMERAS[0][:2], fov_deg=60, width=200, height=150)
    whole = Rasterizer(house).draw(camera)
    left, right = camera.rays([60, 140], [75, 75])
    planes = np.asarray(
        [np.cross(camera.matrix[:, 1], left), -np.cross(camera.matrix[:, 1], right)], np.float64
    )
    planes = planes * np.sign(planes @ camera.rays(100, 75))[:, None]
    rasterizer = Rasterizer(house)
    color, _, face = rasterizer.draw(camera, [(rasterizer.prepare(), planes)])
    np.testing.assert_array_equal(color[:, 61:140], whole[0][:, 61:140])
    assert (face[:, :20] != whole[2][:, :20]).mean() > 0.2


def test_a_wall_through_the_eye_is_cut_not_turned_inside_out() -> None:
    floor = np.array([[[-500, -500, 0], [500, -500, 0], [500, 500, 0], [-500, 500, 0]]], float)
    camera = Camera.look_at((0, 0, 1.6), (1, 0, 1.6), fov_deg=90, width=64, height=64)
    _, disparity, face = Rasterizer(evenly_lit(floor)).draw(camera)
    rows = np.arange(64)[:, None] - 31.5
    expected = np.where(rows > 0, rows / 32.0 / 1.6, 0.0)
    far = (rows > 0) & (expected < 1 / 500.0)
    assert ((face >= 0) == (rows > 0))[~far[:, 0]].all()
    np.testing.assert_allclose(disparity[34:], np.broadcast_to(expected[34:], (30, 64)), rtol=1e-5)


def test_far_from_the_origin_nothing_shakes(house) -> None:
    shift = np.array([4e5, 5.2e6, 300.0])
    mesh = replace(house.mesh, vertices=house.mesh.vertices + shift)
    moved = LitModel(mesh, house.charts, house.light)
    camera = Camera.look_at(*CAMERAS[0][:2], fov_deg=60, width=160, height=120)
    there = replace(camera, center=camera.center + shift)
    here = Rasterizer(house).draw(camera)
    away = Rasterizer(moved).draw(there)
    assert (here[2] == away[2]).mean() > 0.999


def test_no_faces_draw_the_sky(house) -> None:
    rasterizer = Rasterizer(house)
    camera = Camera.look_at(*CAMERAS[0][:2], width=32, height=24)
    color, disparity, face = rasterizer.draw(camera, [(rasterizer.prepare(np.zeros(0, int)), None)])
    assert (face == -1).all()
    assert (disparity == 0).all()
    assert color.any()


def test_what_it_cannot_draw_is_refused(house) -> None:
    rasterizer = Rasterizer(house)
    with pytest.raises(CameraError, match="photograph"):
        rasterizer.draw(SphereCamera.at((1, 1, 1), width=32, height=16))
    with pytest.raises(InputError, match="there are"):
        rasterizer.prepare([10**7])
    with pytest.raises(InputError, match="indices"):
        rasterizer.prepare([0.5])


def test_of_two_faces_in_one_place_the_first_is_seen_however_the_camera_stands() -> None:
    wall = np.array([[[4, -2, -2], [4, 2, -2], [4, 2, 2], [4, -2, 2]]], float)
    rasterizer = Rasterizer(evenly_lit(np.concatenate([wall, wall, wall])))
    parts = [rasterizer.prepare([k, k + 1]) for k in (4, 0, 2)]
    for eye in ((0, 0, 0), (1.5, 0.7, -0.3), (0, -1.9, 1.0)):
        camera = Camera.look_at(eye, (4, 0, 0), fov_deg=60, width=64, height=48)
        for lists in (None, [(part, None) for part in parts]):
            _, _, face = rasterizer.draw(camera, lists)
            assert set(np.unique(face)) <= {-1, 0, 1}


def test_what_a_wall_hides_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Clusters and small triangles that nearer tiles hide are left out: the picture stays."""
    rng = np.random.default_rng(3)
    small = rng.uniform((2, -2, -2), (9, 2, 2), (3000, 1, 3)) + rng.normal(0, 0.03, (3000, 4, 3))
    small[:, 3] = small[:, 0] + small[:, 2] - small[:, 1]
    wall = np.array([[[4, -1, -3], [4, 3, -3], [4, 3, 3], [4, -1, 3]]], float)
    rasterizer = Rasterizer(evenly_lit(np.concatenate([small, wall])))
    camera = Camera.look_at((0, 0, 0), (4, 0.2, 0), fov_deg=50, width=150, height=97)
    whole = rasterizer.draw(camera)
    seen = []
    kernel = _raster_setup.set_up
    monkeypatch.setattr(_draw_plan, "FEW", 0)
    monkeypatch.setattr(_draw_plan, "FIRST_BATCH", 300)

    def count(*args) -> None:
        kernel(*args)
        seen.append(int(args[15][args[0]].sum()))

    monkeypatch.setattr(_raster_setup, "set_up", count)
    for threads in (1, 3):
        rasterizer.threads = threads
        for a, b in zip(whole, rasterizer.draw(camera), strict=True):
            np.testing.assert_array_equal(a, b)
    assert sum(seen) < 0.8 * 2 * len(rasterizer.model.mesh.faces)


def test_the_sky_is_that_of_photographs() -> None:
    model = evenly_lit(box_corners((-2, -2, -9), (2, 2, -8)))
    for turn in np.linspace(0.0, 6.0, 7):
        target = (np.cos(turn), np.sin(turn), 0.15)
        camera = Camera.look_at((0, 0, 0), target, fov_deg=70, width=163, height=90)
        color, _, face = Rasterizer(model).draw(camera)
        assert (face == -1).all()
        truth = photograph(model, camera, 1).color
        assert (np.abs(color.astype(int) - truth) > 1).mean() < 2e-3


def test_a_frame_is_the_callers_own(house) -> None:
    rasterizer = Rasterizer(house)
    first = rasterizer.draw(Camera.look_at(*CAMERAS[0][:2], width=640, height=640))
    kept = [each.copy() for each in first]
    rasterizer.draw(Camera.look_at(*CAMERAS[1][:2], width=640, height=640))
    for a, b in zip(first, kept, strict=True):
        np.testing.assert_array_equal(a, b)


def test_colors_of_corners_multiply_the_base_color(house) -> None:
    colors = 0.7 + 0.6 * np.sin(7.0 * house.mesh.vertices[house.mesh.faces])
    tinted = LitModel(replace(house.mesh, colors=colors), house.charts, house.light)
    camera = Camera.look_at(*CAMERAS[0][:2], fov_deg=60, width=200, height=150)
    truth, plain = photograph(tinted, camera, 1), photograph(house, camera, 1)
    color, disparity, _ = Rasterizer(tinted).draw(camera)
    agree = np.abs(disparity - truth.disparity) <= 1e-5 * truth.disparity
    assert psnr(color, truth.color, agree) > 50.0
    assert psnr(plain.color, truth.color) < 25.0
    # one color for all is the base color's factor
    even = LitModel(replace(house.mesh, colors=np.ones_like(colors)), house.charts, house.light)
    np.testing.assert_array_equal(photograph(even, camera, 2).color,
                                  photograph(house, camera, 2).color)  # fmt: skip
