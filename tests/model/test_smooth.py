"""Smooth surfaces cut from a cage: circles stay circles, whatever the number of polygons."""

from __future__ import annotations

import numpy as np
import pytest

from belvedere.model.charts import Builder
from belvedere.model.ornament import ball, bar, cornice, lathe, ring
from belvedere.model.shapes import box, cushion, tube
from belvedere.model.smooth import SmoothBuilder


def with_material() -> tuple[SmoothBuilder, int]:
    b = SmoothBuilder()
    return b, b.material("clay", (0.5, 0.5, 0.5))


def crowd() -> SmoothBuilder:
    """Some furniture-like things."""
    b, clay = with_material()
    for k in range(6):
        with b.placed(k, 0.3 * k, 0.0, 20.0 * k):
            lathe(b, [(0.05, 0.0), (0.1, 0.1), (0.04, 0.3), (1e-3, 0.4)], clay)
            box(b, (-0.2, -0.2, -0.1), (0.2, 0.2, 0.0), clay)
            cushion(b, (-0.3, 0.3, 0.0), (0.3, 0.6, 0.2), clay, bulge=0.02)
            bar(b, [(0, 0, 0.4), (0.1, 0, 0.6), (0.3, 0, 0.7)], 0.02, clay)
    return b


@pytest.mark.parametrize("polygons", [6_000, 20_000, 200_000])
def test_a_number_of_polygons_is_met_within_a_hundredth(polygons: int) -> None:
    b = crowd()
    cage, _ = b.finish()
    assert len(cage.faces) < 5_000
    mesh, charts = b.refined(polygons)
    assert len(mesh.faces) == pytest.approx(polygons, rel=0.01)
    assert len(charts.of_face) == len(charts.st) == len(mesh.faces)


def test_fewer_polygons_than_the_cage_has_give_the_cage() -> None:
    b = crowd()
    cage, _ = b.finish()
    mesh, _ = b.refined(10)
    assert len(mesh.faces) == len(cage.faces)
    assert mesh.normals().any(axis=1).all()


def test_a_cylinder_of_six_sides_becomes_round() -> None:
    b, clay = with_material()
    tube(b, (0, 0, 0), (0, 0, 1), 0.5, clay, 6)
    mesh, _ = b.refined(2_000)
    radius = np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 1])
    assert np.abs(radius - 0.5).max() < 0.5 * 2e-4  # a cubic is that near to a sixth of a circle


def test_a_ball_becomes_round() -> None:
    b, clay = with_material()
    ball(b, (1.0, 2.0, 3.0), 0.5, clay, 8)
    mesh, _ = b.refined(5_000)
    radius = np.linalg.norm(mesh.vertices - [1.0, 2.0, 3.0], axis=1)
    assert np.abs(radius - 0.5).max() < 0.5 * 0.012


def test_the_rim_of_a_disc_is_a_circle_though_its_normals_are_all_alike() -> None:
    b, clay = with_material()
    lathe(b, [(0.3, 0.0), (1e-6, 0.0)], clay, 8)
    mesh, _ = b.refined(3_000)
    radius = np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 1])
    rim = radius > 0.27
    angle = np.arctan2(mesh.vertices[rim, 1], mesh.vertices[rim, 0])
    widest = [radius[rim][np.abs(angle - a) < 0.05].max() for a in np.linspace(-3.0, 3.0, 50)]
    np.testing.assert_allclose(widest, 0.3, rtol=2e-3)
    assert np.abs(mesh.vertices[:, 2]).max() == 0.0


def test_two_runs_of_a_turned_body_meet_at_their_crease() -> None:
    """A cup's wall and its rim: no gap shows between them."""
    b, clay = with_material()
    lathe(b, [(0.1, 0.0), (0.1, 0.2), (0.08, 0.2)], clay, 8)
    mesh, _ = b.refined(4_000)
    top = np.abs(mesh.vertices[:, 2] - 0.2) < 1e-9
    radius = np.hypot(mesh.vertices[top, 0], mesh.vertices[top, 1])
    rim = radius[radius > 0.095]
    np.testing.assert_allclose(rim, 0.1, atol=1e-4)


def test_flat_things_are_not_cut() -> None:
    b, clay = with_material()
    box(b, (0, 0, 0), (1, 1, 1), clay)
    mesh, _ = b.refined(5_000)
    assert len(mesh.faces) == 12


def test_fine_and_coarse_lie_on_the_same_charts() -> None:
    b = crowd()
    coarse, fine = b.refined(6_000), b.refined(60_000)
    np.testing.assert_array_equal(coarse[1].corners, fine[1].corners)
    np.testing.assert_array_equal(coarse[1].joined, fine[1].joined)
    for mesh, charts in (coarse, fine):
        assert np.unique(charts.of_face).size == len(charts.corners)
        s, t = charts.st[..., 0].mean(axis=1), charts.st[..., 1].mean(axis=1)
        c = charts.corners[charts.of_face].transpose(1, 2, 0)
        flat = (1 - s) * (1 - t) * c[0] + s * (1 - t) * c[1] + s * t * c[2] + (1 - s) * t * c[3]
        middle = mesh.vertices[mesh.faces].mean(axis=1)
        assert np.abs(middle - flat.T).max() < 0.03  # surfaces leave their cage by so much


def test_fronts_of_the_smooth_surface_are_those_of_the_cage() -> None:
    b = crowd()
    mesh, charts = b.refined(30_000)
    up = charts.normals[charts.of_face].mean(axis=1)
    turned = np.einsum("ij,ij->i", mesh.normals(), up) < -0.05
    assert turned.mean() < 0.002  # slivers at poles


@pytest.mark.parametrize(
    "shape",
    [
        lambda b, m: ball(b, (0, 0, 0), 0.3, m),
        lambda b, m: lathe(b, [(0.2, -0.3), (0.3, 0.0), (0.1, 0.3)], m),
        lambda b, m: bar(b, [(0, 0, -0.5), (0, 0, 0.0), (0, 0, 0.5)], 0.1, m),
    ],
)
def test_shapes_show_their_fronts_outwards(shape: object) -> None:
    b, clay = with_material()
    shape(b, clay)  # type: ignore[operator]
    mesh, _ = b.finish()
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    out = middle * [1.0, 1.0, 0.0]
    facing = np.einsum("ij,ij->i", mesh.normals(), out)
    assert (facing > -1e-9).all()


def test_a_ring_and_a_cornice_show_their_fronts_outwards() -> None:
    b, clay = with_material()
    ring(b, (0, 0, 0), 0.5, 0.05, clay)
    mesh, _ = b.finish()
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    around = middle * [1.0, 1.0, 0.0]
    core = around / np.linalg.norm(around, axis=1, keepdims=True) * 0.5
    assert (np.einsum("ij,ij->i", mesh.normals(), middle - core) > 0).all()
    b, clay = with_material()
    cornice(b, (0.0, 0.0, 4.0, 3.0), 2.7, clay)
    mesh, _ = b.finish()
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    to_room = np.array([2.0, 1.5, 1.0]) - middle
    assert (np.einsum("ij,ij->i", mesh.normals(), to_room) > -1e-9).mean() > 0.98


def test_a_plain_builder_makes_the_same_cage() -> None:
    """Bends are for those who bend: the small interior keeps its bytes."""
    meshes = []
    for b in (Builder(), SmoothBuilder()):
        clay = b.material("clay", (0.5, 0.5, 0.5))
        lathe(b, [(0.2, 0.0), (0.3, 0.2), (0.1, 0.4)], clay)
        meshes.append(b.finish()[0])
    np.testing.assert_array_equal(meshes[0].vertices, meshes[1].vertices)
