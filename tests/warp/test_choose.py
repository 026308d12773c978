"""Which references are chosen for a picture."""

from __future__ import annotations

import numpy as np
import pytest

from belvedere.ground.errors import CameraError
from belvedere.scene import Camera, CylinderCamera, OrthographicCamera, SphereCamera
from belvedere.warp import choose_references
from tests.warp.worlds import random_camera, straight_camera

DISPARITIES = (0.2, 0.4, 0.8)


def row(*places: float) -> list[Camera]:
    return [straight_camera(40, 30, (x, 0, 0)) for x in places]


def test_the_reference_at_the_eye_comes_first_and_nearer_ones_before_farther() -> None:
    cameras = row(-2, -1, 0, 1.2, 2.5)
    assert choose_references(cameras, cameras[2], DISPARITIES, 1) == [2]
    assert choose_references(cameras, straight_camera(40, 30, (0.9, 0, 0)), DISPARITIES, 1) == [3]
    order = choose_references(cameras, cameras[2], DISPARITIES, 5)
    assert sorted(order) == [0, 1, 2, 3, 4]
    assert order[:3] == [2, 1, 3]


def test_a_near_camera_that_looks_away_is_worth_less_than_a_far_one_that_sees() -> None:
    away = straight_camera(40, 30, (0.01, 0, 0))
    turned = Camera(np.diag([-1.0, -1.0, 1.0]) @ away.matrix, away.center, 40, 30)
    cameras = [turned, straight_camera(40, 30, (1.0, 0, 0))]
    assert choose_references(cameras, straight_camera(40, 30), DISPARITIES, 2) == [1, 0]


def test_the_second_reference_shows_what_the_first_does_not() -> None:
    half = straight_camera(20, 30, (0.1, 0, 0), focal=40)  # the left half, cropped
    left = Camera(half.matrix + np.outer(half.matrix[:, 0], [0, 0, -9.5]), half.center, 20, 30)
    right = Camera(half.matrix + np.outer(half.matrix[:, 0], [0, 0, 9.5]), half.center, 20, 30)
    cameras = [left, left.moved((0.12, 0, 0)), right.moved((0.3, 0, 0))]
    chosen = choose_references(cameras, straight_camera(40, 30), DISPARITIES, 2)
    assert chosen == [0, 2]


def test_excluded_references_are_not_chosen_and_nothing_is_made_up() -> None:
    cameras = row(-1, 0, 1)
    assert 1 not in choose_references(cameras, cameras[1], DISPARITIES, 3, exclude=[1])
    assert choose_references(cameras, cameras[1], DISPARITIES, 3, exclude={0, 1, 2}) == []
    assert choose_references([], cameras[1], DISPARITIES, 3) == []
    assert choose_references(cameras, cameras[1], DISPARITIES, 0) == []
    assert len(choose_references(cameras, cameras[1], DISPARITIES, 99)) == 3


def test_references_that_see_nothing_come_last_and_nearest_first() -> None:
    back = [Camera(np.diag([-1.0, -1.0, 1.0]) @ c.matrix, c.center, 40, 30) for c in row(5, 1, 3)]
    assert choose_references(back, straight_camera(40, 30), DISPARITIES, 3) == [1, 2, 0]


def test_the_choice_is_one_for_any_camera_at_any_disparity() -> None:
    rng = np.random.default_rng(0)
    for n in range(100):
        count = int(rng.integers(1, 8))
        cameras = [random_camera(rng, 20, 16, reach=3, turn=3.1) for _ in range(count)]
        if n % 5 == 0:
            cameras += [cameras[0]]
        desired = random_camera(rng, 20, 16, reach=3, turn=3.1)
        disparities = ([0.0], [1e-9, 1e9], rng.uniform(0, 2, 4), [np.nan])[n % 4]
        chosen = choose_references(cameras, desired, disparities, 3)
        assert len(chosen) == min(3, len(cameras)) == len(set(chosen))
        assert chosen == choose_references(cameras, desired, disparities, 3)


def test_a_panorama_sees_what_a_plane_at_its_place_looks_away_from() -> None:
    desired = straight_camera(40, 30)
    away = straight_camera(40, 30, (0.1, 0, 0))
    turned = Camera(np.diag([-1.0, -1.0, 1.0]) @ away.matrix, away.center, 40, 30)
    for around in (SphereCamera((0.2, 0, 0), 80, 40), CylinderCamera((0.2, 0, 0), 80, 40)):
        far = straight_camera(40, 30, (1.5, 0, 0))
        assert choose_references([turned, far, around], desired, DISPARITIES, 3) == [2, 1, 0]
    # a cylinder of one row of pixels sees the horizon only
    slit = CylinderCamera((0.2, 0, 0), 80, 1)
    assert choose_references([slit, far], desired, DISPARITIES, 2) == [1, 0]


def test_for_a_panorama_the_references_are_chosen_that_look_another_way() -> None:
    desired = SphereCamera((0, 0, 0), 80, 40)
    ahead, beside, back = (straight_camera(40, 30, (x, 0, 0)) for x in (0.1, 0.15, 0.2))
    back = Camera(np.diag([-1.0, -1.0, 1.0]) @ back.matrix, back.center, 40, 30)
    assert choose_references([ahead, beside, back], desired, DISPARITIES, 2) == [0, 2]


def test_parallel_rays_are_refused_on_either_side() -> None:
    plan = OrthographicCamera(np.eye(4), [0.1, 0.1], 8, 4)
    with pytest.raises(CameraError, match="the reference view has a OrthographicCamera"):
        choose_references([plan], straight_camera(8, 6), DISPARITIES, 1)
    with pytest.raises(CameraError, match="the desired view has a OrthographicCamera"):
        choose_references(row(0), plan, DISPARITIES, 1)
