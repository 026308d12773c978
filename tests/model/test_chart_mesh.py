"""Light for any mesh: charts that fit, fronts that people see, nothing black."""

from __future__ import annotations

import numpy as np
import pytest

from belvedere.ground.errors import InputError
from belvedere.model import (
    Building,
    LightSettings,
    LitModel,
    RayCaster,
    Room,
    light_model,
    photograph,
    room_lamps,
)
from belvedere.model.chart_mesh import charts_of
from belvedere.model.charts import Builder
from belvedere.model.ornament import lathe
from belvedere.model.shapes import box
from belvedere.scene import Camera
from belvedere.scene.mesh import Material, Mesh

GREY = Material("grey", (0.6, 0.6, 0.6))
QUICK = LightSettings(rays=16, bounces=2, soft_spacing=0.3, sun_spacing=0.1, emissive=True)
SIZE = (4.0, 3.0, 2.6)


def room_with_things(window: bool = True) -> Mesh:
    """A room with a table, a cupboard by the wall and a vase; fronts as people see them."""
    b = Builder()
    wall, wood = b.material("wall", (0.7, 0.7, 0.7)), b.material("wood", (0.5, 0.3, 0.2))
    x, y, z = SIZE
    faces = "-y" if window else ""
    box(b, (0.0, 0.0, 0.0), SIZE, wall, 1.0, faces, inside=True)
    box(b, (-0.2, -0.2, -0.2), (x + 0.2, y + 0.2, z + 0.2), wall, 1.0, faces)
    box(b, (1.5, 1.0, 0.7), (2.5, 1.8, 0.75), wood)
    box(b, (0.02, 1.0, 0.05), (0.5, 2.0, 1.8), wood)
    lathe(b, [(0.1, 0.75), (0.15, 0.9), (0.06, 1.1)], wood, 12, (2.0, 1.4, 0.0), crisp=False)
    return b.finish()[0]


def shuffled(mesh: Mesh, seed: int = 0) -> Mesh:
    """The same triangles, half of them turned the wrong way."""
    wrong = np.random.default_rng(seed).random(len(mesh.faces)) < 0.5
    faces, uv = mesh.faces.copy(), mesh.uv.copy()
    faces[wrong], uv[wrong] = faces[wrong][:, ::-1], uv[wrong][:, ::-1]
    return Mesh(mesh.vertices, faces, mesh.material_index, uv, mesh.materials)


def positions(mesh: Mesh, charts: object) -> np.ndarray:
    """(M, 3, 3) where the charts put the corners of the faces."""
    st, corners = charts.st, charts.corners[charts.of_face]  # type: ignore[attr-defined]
    s, t = st[..., :1].astype(float), st[..., 1:].astype(float)
    return (
        (1 - s) * (1 - t) * corners[:, None, 0] + s * (1 - t) * corners[:, None, 1]
        + s * t * corners[:, None, 2] + (1 - s) * t * corners[:, None, 3]
    )  # fmt: skip


def seen(model: LitModel) -> list[np.ndarray]:
    x, y, z = SIZE
    eye = (x - 0.4, 0.4, 1.6)
    targets = [(0.2, y, 0.8), (2.0, 1.4, 0.8), (x - 0.4, y, 0.2), (1.0, y, z)]
    return [
        photograph(model, Camera.look_at(eye, to, fov_deg=60, width=60, height=48), 1).color
        for to in targets
    ]


def test_charts_put_every_corner_where_it_is() -> None:
    mesh = shuffled(room_with_things())
    charts = charts_of(mesh, RayCaster(mesh))
    np.testing.assert_allclose(positions(mesh, charts), mesh.vertices[mesh.faces], atol=2e-3)
    assert charts.st.min() >= -1e-6
    assert charts.st.max() <= 1.0 + 1e-6
    np.testing.assert_array_equal(charts.material[charts.of_face], mesh.material_index)


def test_coplanar_faces_share_a_chart_and_curved_ones_do_not() -> None:
    b = Builder()
    grey = b.material("grey", (0.5, 0.5, 0.5))
    box(b, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), grey)
    charts = charts_of(b.finish()[0], RayCaster(b.finish()[0]))
    assert len(charts.corners) == 6
    lathe(b, [(0.5, 2.0), (0.5, 3.0)], grey, 16)
    mesh = b.finish()[0]
    assert len(charts_of(mesh, RayCaster(mesh)).corners) > 6 + 8


def test_fronts_are_the_sides_that_people_see_whatever_the_winding() -> None:
    right = room_with_things()
    wanted = right.normals()
    for mesh in (right, shuffled(right), shuffled(right, 1)):
        charts = charts_of(mesh, RayCaster(mesh))
        front = charts.normals.mean(axis=1)[charts.of_face]
        agree = np.einsum("ij,ij->i", front, wanted) > 0.0
        a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        assert area[agree].sum() > 0.99 * area.sum()


def test_wrong_winding_gives_the_same_picture_and_nothing_black() -> None:
    mesh = room_with_things()
    building = Building((Room("room", (np.array([[0, 0], [4, 0], [4, 3], [0, 3]]),), 0.0, 2.6),))
    lamps = room_lamps(building)
    settings = LightSettings(lamps=lamps, rays=16, bounces=2, soft_spacing=0.2, sun_spacing=0.05)
    right, wrong = (light_model(m, settings=settings) for m in (mesh, shuffled(mesh)))
    for a, b in zip(seen(right), seen(wrong), strict=True):
        assert (b.max(axis=2) < 8).mean() < 0.01
        assert np.abs(a.astype(float) - b.astype(float)).mean() < 6.0


def test_soup_degenerate_faces_and_one_triangle_do_no_harm() -> None:
    rng = np.random.default_rng(5)
    soup = rng.uniform(0.0, 2.0, (60, 1, 3)) + rng.normal(0.0, 0.3, (60, 3, 3))
    soup[:5, 2] = soup[:5, 1]
    soup[5, :] = soup[5, 0]
    for corners in (soup, soup[10:11], soup[5:6]):
        count = len(corners)
        mesh = Mesh(
            corners.reshape(-1, 3), np.arange(3 * count, dtype=np.int32).reshape(-1, 3),
            np.zeros(count, np.int32), np.zeros((count, 3, 2), np.float32), (GREY,),
        )  # fmt: skip
        model = light_model(mesh, settings=QUICK)
        assert np.isfinite(model.light.soft).all()
        assert np.isfinite(model.light.sun).all()
        camera = Camera.look_at((-3.0, 1.0, 2.0), (1.0, 1.0, 1.0), width=40, height=30)
        assert np.isfinite(photograph(model, camera, 1, "float32").color).all()


def test_glowing_surfaces_light_a_closed_room() -> None:
    b = Builder()
    grey = b.material("grey", (0.6, 0.6, 0.6))
    box(b, (0.0, 0.0, 0.0), SIZE, grey, 1.0, "", inside=True)
    dark = light_model(b.finish()[0], settings=QUICK)
    glow = b.material("glow", (0.8, 0.8, 0.8), None, (4.0, 4.0, 4.0))
    box(b, (1.5, 1.0, 2.3), (2.5, 2.0, 2.5), glow)
    lit = light_model(b.finish()[0], settings=QUICK)
    camera = Camera.look_at((0.3, 0.3, 1.5), (3.0, 2.5, 0.0), width=40, height=30)
    assert photograph(dark, camera, 1, "float32").color.max() < 1e-3
    assert photograph(lit, camera, 1, "float32").color.min() > 0.01


def test_light_is_the_same_for_any_number_of_threads_and_progress_is_told() -> None:
    mesh = room_with_things()
    told: list[int] = []
    one = light_model(mesh, settings=QUICK, threads=1, progress=lambda d, _, __: told.append(d))
    several = light_model(mesh, settings=QUICK, threads=3)
    np.testing.assert_array_equal(one.light.soft, several.light.soft)
    np.testing.assert_array_equal(one.light.sun, several.light.sun)
    assert told == sorted(told)
    assert told[-1] == 100


def test_lamps_hang_in_every_room_and_below_its_ceiling() -> None:
    rings = (np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 4.0], [0.0, 4.0]]),)
    building = Building((Room("hall", rings, 0.0, 2.5), Room("loft", rings, 2.8, 5.0)))
    lamps = room_lamps(building)
    assert len(lamps) >= 4
    for lamp in lamps:
        x, y, z = lamp.center
        assert 0.0 < x < 9.0
        assert 0.0 < y < 4.0
        assert 1.5 < z < 2.5 or 4.0 < z < 5.0


def test_lamps_of_a_room_round_a_corner_hang_inside_it() -> None:
    ring = np.array([[0, 0], [6, 0], [6, 1.6], [1.6, 1.6], [1.6, 5], [0, 5]], dtype=float)
    for count in (1, 2, 5):
        room = Room("corner", (ring * np.sqrt(count),), 0.0, 2.5)
        spots = np.array([lamp.center[:2] for lamp in room_lamps(Building((room,)))])
        assert len(spots) == count
        across = 1.6 * np.sqrt(count)
        inside = (spots.min(axis=1) > 0.2) & (spots.min(axis=1) < across - 0.2)
        assert inside.all(), spots
        apart = np.linalg.norm(spots[:, None] - spots, axis=2) + 99.0 * np.eye(count)
        assert apart.min() > 1.0


def test_an_empty_mesh_is_refused() -> None:
    none = np.zeros((0, 3), np.int32)
    uv = np.zeros((0, 3, 2), np.float32)
    empty = Mesh(np.zeros((0, 3)), none, np.zeros(0, np.int32), uv, (GREY,))
    with pytest.raises(InputError, match="no faces"):
        light_model(empty)
