"""The built-in house: the same every time, and one can walk through it."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

from belvedere.ground.errors import InputError
from belvedere.model import Interior, build_interior
from belvedere.model.interior import EYE_M, ROOMS
from belvedere.model.palette import paint_textures


def digest(house: Interior) -> str:
    total = hashlib.sha256()
    for array in (house.mesh.vertices, house.mesh.uv, house.light.soft, house.light.sun):
        total.update(np.ascontiguousarray(array).tobytes())
    for material in house.mesh.materials:
        if material.texture is not None:
            total.update(material.texture.tobytes())
    return total.hexdigest()


def sphere_directions(count: int) -> np.ndarray:
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, 2.399963 * k
    ring = np.sqrt(1.0 - z * z)
    return np.stack([ring * np.cos(angle), ring * np.sin(angle), z], axis=1)


def clearance(house: Interior, point: np.ndarray) -> float:
    directions = sphere_directions(400)
    return float(house.caster.cast(np.broadcast_to(point, (400, 3)), directions).t.min())


def test_one_seed_gives_the_same_bytes_on_one_thread_as_on_several(house: Interior) -> None:
    again = build_interior(seed=0, rays=8, threads=1)
    assert digest(again) == digest(house)


def test_another_seed_paints_other_textures(house: Interior) -> None:
    planks = next(m.texture for m in house.mesh.materials if m.name == "planks")
    assert planks is not None
    np.testing.assert_array_equal(paint_textures(0)["planks"], planks)
    assert (paint_textures(1)["planks"] != planks).any()


def test_reference_cameras_stand_in_free_space_in_three_rooms(house: Interior) -> None:
    cameras = house.reference_cameras(count=16, width=64, height=48)
    assert len(cameras) == 16
    rooms = set()
    for camera in cameras:
        assert clearance(house, camera.center) > 0.25
        x, y, z = camera.center
        assert z == pytest.approx(EYE_M)
        rooms |= {n for n, (a, b, c, d) in ROOMS.items() if a < x < c and b < y < d}
    assert rooms == set(ROOMS)


def test_the_walk_passes_through_no_wall_and_no_furniture(house: Interior) -> None:
    eyes = np.array([eye for eye, _ in house.walk_keyframes(121)])
    for height in (EYE_M, 1.0, 0.45):  # the head, the hips, the knees
        level = eyes.copy()
        level[:, 2] = height
        assert not house.caster.blocked(level[:-1], np.diff(level, axis=0), 1.0).any()
        assert min(clearance(house, p) for p in level[::4]) > 0.25
    assert np.linalg.norm(np.diff(eyes, axis=0), axis=1).max() < 0.2


def test_nobody_looks_at_the_back_of_a_surface(house: Interior) -> None:
    """Inverted faces would be lit from the wrong side."""
    wrong = total = 0
    for camera in house.reference_cameras(8, 64, 48):
        rays = camera.rays(*camera.pixel_grid()).reshape(-1, 3)
        hits = house.caster.cast(np.broadcast_to(camera.center, rays.shape), rays)
        normals = house.mesh.normals()[hits.face]
        facing = np.einsum("ij,ij->i", normals, rays)
        wrong += np.count_nonzero((hits.face >= 0) & (facing > 1e-6))
        total += len(rays)
    assert wrong <= 0.003 * total  # the edges of leaves and shades are seen from behind


def test_no_light_leaks_into_what_is_shut(house: Interior) -> None:
    """Every upward ray from the rooms meets a ceiling: there are no cracks in the shell."""
    x, y = np.meshgrid(np.linspace(0.02, 9.18, 120), np.linspace(0.02, 7.78, 120))
    inside = np.zeros(x.shape, dtype=bool)
    for a, b, c, d in ROOMS.values():
        inside |= (x > a + 0.01) & (x < c - 0.01) & (y > b + 0.01) & (y < d - 0.01)
    origins = np.stack([x[inside], y[inside], np.full(inside.sum(), 2.70)], axis=1)
    up = np.broadcast_to([0.0, 0.0, 1.0], origins.shape)
    assert house.caster.blocked(origins, up, 3.0).all()
    assert house.caster.blocked(origins, -up, 3.0).all()


def test_light_is_finite_and_every_room_has_some(house: Interior) -> None:
    assert np.isfinite(house.light.soft).all()
    assert (house.light.soft >= 0).all()
    assert house.light.sun.min() == 0.0
    assert 0.4 < house.light.sun.max() <= 1.0


@pytest.mark.parametrize(("name", "value"), [("seed", -1), ("seed", 1.5), ("rays", 0)])
def test_odd_orders_are_refused(name: str, value: object) -> None:
    with pytest.raises(InputError, match=rf"build_interior\.{name} is {value}, expected a whole"):
        build_interior(**{name: value})  # type: ignore[arg-type]


def test_a_walk_needs_two_poses(house: Interior) -> None:
    with pytest.raises(InputError, match=r"walk_keyframes\.count is 1"):
        house.walk_keyframes(1)
