"""Ray casting: what is met, what blocks, what is refused."""

from __future__ import annotations

import builtins
from typing import Any

import numpy as np
import pytest

from belvedere.ground.errors import InputError, MissingDependencyError
from belvedere.model import RayCaster
from belvedere.scene.mesh import Material, Mesh


def scattered_triangles(rng: np.random.Generator, count: int) -> Mesh:
    corners = rng.uniform(-2, 2, (count, 1, 3)) + rng.normal(0, 0.5, (count, 3, 3))
    faces = np.arange(3 * count).reshape(count, 3)
    index, uv = np.zeros(count), np.zeros((count, 3, 2))
    return Mesh(corners.reshape(-1, 3), faces, index, uv, (Material("m"),))  # type: ignore[arg-type]


def nearest_by_hand(mesh: Mesh, origin: np.ndarray, direction: np.ndarray) -> tuple[int, float]:
    """The oracle: solve origin + t d = a + u e + v f for every triangle."""
    best, face = np.inf, -1
    for k, (a, b, c) in enumerate(mesh.vertices[mesh.faces]):
        matrix = np.column_stack([b - a, c - a, -direction])
        u, v, t = np.linalg.solve(matrix, origin - a)
        if u >= 0 and v >= 0 and u + v <= 1 and 0 < t < best:
            best, face = t, k
    return face, best


def test_rays_meet_the_nearest_triangle(rng: np.random.Generator) -> None:
    mesh = scattered_triangles(rng, 40)
    origins, directions = rng.uniform(-3, 3, (150, 3)), rng.normal(size=(150, 3))
    hits = RayCaster(mesh).cast(origins, directions)
    expected = [nearest_by_hand(mesh, o, d) for o, d in zip(origins, directions, strict=True)]
    np.testing.assert_array_equal(hits.face, [face for face, _ in expected])
    np.testing.assert_allclose(hits.t, [t for _, t in expected], rtol=2e-5)  # float32 rays
    assert 20 < np.count_nonzero(hits.face >= 0) < 150


def test_barycentrics_give_the_point_that_was_met(rng: np.random.Generator) -> None:
    mesh = scattered_triangles(rng, 40)
    origins, directions = rng.uniform(-3, 3, (300, 3)), rng.normal(size=(300, 3))
    hits = RayCaster(mesh).cast(origins, directions)
    met = hits.face >= 0
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces[hits.face[met]]], 1, 0)
    u, v = hits.barycentric[met].T[..., None]
    points = origins[met] + hits.t[met, None] * directions[met]
    np.testing.assert_allclose(a + u * (b - a) + v * (c - a), points, atol=2e-5)


def test_what_blocks_within_reach_is_what_is_met_within_reach(rng: np.random.Generator) -> None:
    caster = RayCaster(scattered_triangles(rng, 60))
    origins, directions = rng.uniform(-3, 3, (2000, 3)), rng.normal(size=(2000, 3))
    hits = caster.cast(origins, directions)
    for reach in (1.0, 2.5, np.inf):
        np.testing.assert_array_equal(
            caster.blocked(origins, directions, reach), (hits.face >= 0) & (hits.t <= reach)
        )


def test_threads_do_not_change_what_rays_meet(rng: np.random.Generator) -> None:
    caster = RayCaster(scattered_triangles(rng, 60))
    origins, directions = rng.uniform(-3, 3, (150_000, 3)), rng.normal(size=(150_000, 3))
    one, three = (caster.cast(origins, directions, threads=n) for n in (1, 3))
    np.testing.assert_array_equal(one.face, three.face)
    np.testing.assert_array_equal(one.t, three.t)


@pytest.mark.parametrize(
    ("origins", "directions", "message"),
    [
        (np.zeros((2, 2)), np.ones((2, 2)), r"origins \(2, 2\) and directions \(2, 2\) must both"),
        (np.zeros((2, 3)), np.ones((3, 3)), r"must both be \(N, 3\)"),
        ([[0, 0, np.nan]], [[1, 0, 0]], r"origins\[0\] is \[0.0, 0.0, nan\], expected finite"),
        (np.zeros((2, 3)), [[1, 0, 0], [0, 0, 0]], r"directions\[1\] is zero"),
    ],
)
def test_rays_that_lead_nowhere_are_refused(origins: Any, directions: Any, message: str) -> None:
    caster = RayCaster(scattered_triangles(np.random.default_rng(1), 2))
    with pytest.raises(InputError, match=message):
        caster.cast(origins, directions)


def test_an_empty_mesh_is_refused() -> None:
    with pytest.raises(InputError, match=r"RayCaster\.mesh has no faces"):
        RayCaster(Mesh.concatenate([]))


def test_a_missing_embree_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without_embree(name: str, *args: Any, **kwargs: Any) -> Any:
        if name.startswith("embreex"):
            raise ImportError(name)
        return real(name, *args, **kwargs)

    mesh = scattered_triangles(np.random.default_rng(1), 2)
    monkeypatch.setattr(builtins, "__import__", without_embree)
    with pytest.raises(MissingDependencyError, match=r"pip install 'belvedere\[model\]'"):
        RayCaster(mesh)
