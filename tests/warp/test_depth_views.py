"""Sets of pictures as scenes."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from belvedere.ground.errors import CameraError, InputError, SceneError
from belvedere.scene import (
    OrthographicCamera,
    ReferenceView,
    Scene,
    SphereCamera,
    ViewEntry,
    ViewSet,
)
from belvedere.warp import DepthViews, Photographs, warp
from tests.oracles.panorama import Room
from tests.warp.worlds import boards, noise, same, straight_camera, view_of


def row_of(count: int) -> list[ReferenceView]:
    rng = np.random.default_rng(0)
    made = []
    for n in range(count):
        disparity, _ = boards(rng, 30, 40, 3)
        made.append(view_of(straight_camera(40, 30, (n, 0, 0)), disparity, noise(rng, 30, 40)))
    return made


def without_depth(views: list[ReferenceView]) -> ViewSet:
    return ViewSet(
        tuple(
            ViewEntry(f"p{n}", v.camera, False, lambda v=v: v.color, None)
            for n, v in enumerate(views)
        )
    )


def test_pictures_with_depth_are_a_scene_to_walk_through() -> None:
    scene = DepthViews(row_of(3))
    assert isinstance(scene, Scene)
    assert scene.affords.movement == "continuous"
    assert scene.home is scene.views.cameras[0]
    assert scene.viewing_region.contains(np.array([1.0, 0.1, -0.1]))
    assert not scene.viewing_region.contains(np.array([9.0, 0, 0]))


def test_a_frame_is_the_warp_of_the_best_references() -> None:
    views = row_of(4)
    scene = DepthViews(views, references=2, threads=1)
    desired = straight_camera(40, 30, (1.3, 0, 0.1))
    chosen = scene.choose(desired)
    assert chosen == [1, 2]
    assert same(scene.render(desired), warp([views[1], views[2]], desired))
    one = scene.render(desired, exclude=[1], reconstruction="point")
    assert scene.choose(desired, exclude=[1])[0] == 2
    assert same(one, scene.warp(scene.choose(desired, exclude=[1]), desired,
                                reconstruction="point"))  # fmt: skip


def test_choices_of_the_scene_hold_for_its_frames_and_a_frame_may_choose_otherwise() -> None:
    views = row_of(2)
    scene = DepthViews(views, references=1, reconstruction="point", fill="background")
    assert scene.options.reconstruction == "point"
    frame = scene.render(views[0].camera)
    assert frame.filled is not None
    np.testing.assert_array_equal(frame.color, views[0].color)
    assert scene.render(views[0].camera, fill="none").filled is None


def test_one_view_is_enough() -> None:
    views = row_of(1)
    scene = DepthViews(views, references=4)
    assert scene.choose(straight_camera(40, 30, (0.5, 0, 0))) == [0]
    assert scene.render(scene.home).coverage.all()


def test_views_that_see_nothing_give_holes_not_errors() -> None:
    empty = [view_of(straight_camera(40, 30), np.full((30, 40), np.nan))]
    scene = DepthViews(empty)
    assert scene.typical_disparities.tolist() == [1.0]
    assert scene.render(scene.home).hole_fraction == 1
    sky = DepthViews([view_of(straight_camera(40, 30), np.zeros((30, 40)))])
    assert sky.render(sky.home.moved((5, 5, 5))).coverage.all()  # type: ignore[attr-defined]


def test_many_visitors_see_what_one_sees() -> None:
    views = row_of(4)
    views = [
        ReferenceView(v.camera, v.color, np.where(v.color[..., 0] < 20, np.nan, v.disparity))
        for v in views
    ]
    cameras = [straight_camera(40, 30, (0.2 * n, 0.1, 0)) for n in range(12)]
    alone = [DepthViews(views, threads=1).render(c) for c in cameras]
    scene = DepthViews(views, threads=1)
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(scene.render, cameras))
    assert all(same(a, b) for a, b in zip(alone, together, strict=True))


@pytest.mark.parametrize("reconstruction", ["point", "splat", "mesh", "offset"])
def test_frames_chain_as_views(reconstruction: Any) -> None:
    views = row_of(2)
    scene = DepthViews(views, references=1, reconstruction=reconstruction)
    frame = scene.render(straight_camera(40, 30, (0.2, 0, 0)))
    onward = DepthViews([frame.as_view()], reconstruction=reconstruction)
    again = onward.render(onward.home, reconstruction="point")
    np.testing.assert_array_equal(again.color, frame.color)
    np.testing.assert_array_equal(again.disparity, frame.disparity)


def test_memory_kept_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    from belvedere.warp import depth_views

    monkeypatch.setattr(depth_views, "PREPARED_BYTES", 3 * 40 * 30 * 27)
    scene = DepthViews(row_of(6))
    for n in range(6):
        scene.prepared(n)
    assert list(scene._prepared) == [3, 4, 5]


def test_photographs_are_turned_but_never_moved() -> None:
    views = row_of(3)
    scene = Photographs(without_depth(views), threads=1)
    assert isinstance(scene, Scene)
    assert scene.affords.movement == "discrete"
    assert scene.affords.geometry == "none"
    for n in range(3):
        frame = scene.render(straight_camera(40, 30, (n + 0.1, 0.05, 0)), reconstruction="point")
        np.testing.assert_array_equal(frame.color, views[n].color)
        assert not frame.disparity.any()
        assert frame.camera.center[0] == n + 0.1
    assert scene.choose(straight_camera(40, 30, (1.1, 0, 0)), exclude=[1]) == 2
    assert scene.viewing_region.contains(np.array([1.5, 0, 0]))


def test_panoramas_are_walked_through_and_turned_like_other_views() -> None:
    cameras = [SphereCamera((x, 0, 1.3), 64, 32) for x in (-0.3, 0.0, 0.4)]
    room = Room(0)
    views = [room.photograph(camera, 1) for camera in cameras]
    desired = straight_camera(40, 30, (0.1, 0.05, 1.3))
    scene = DepthViews(views, threads=1)
    assert scene.choose(desired)[0] == 1
    for camera in (desired, cameras[0].moved((0.1, 0.05, 1.3))):
        frame = scene.render(camera)
        assert frame.camera is camera
        assert (frame.coverage > 0).mean() > 0.97
    photographs = Photographs(without_depth(views), threads=1)
    turned = photographs.render(cameras[0].moved((0.05, 0, 1.3)), reconstruction="point")
    np.testing.assert_array_equal(turned.color, views[1].color)
    assert photographs.render(desired).hole_fraction == 0


def test_scenes_refuse_what_they_cannot_show() -> None:
    views = row_of(2)
    with pytest.raises(SceneError, match="view 'p0' has no depth, so it cannot be warped"):
        DepthViews(without_depth(views))
    with pytest.raises(SceneError, match="is empty, expected at least one view"):
        DepthViews([])
    with pytest.raises(InputError, match=r"references is 17, expected a whole number"):
        DepthViews(views, references=17)
    with pytest.raises(InputError, match="warp has no option 'quality'"):
        DepthViews(views, quality=3)
    scene, photographs = DepthViews(views), Photographs(without_depth(views))
    with pytest.raises(SceneError, match="DepthViews: all 2 references are excluded"):
        scene.render(scene.home, exclude=[0, 1])
    with pytest.raises(SceneError, match="Photographs: all 2 photographs are excluded"):
        photographs.render(scene.home, exclude=[0, 1])
    for one in (scene, photographs):
        with pytest.raises(CameraError, match="the desired view has a OrthographicCamera"):
            one.render(OrthographicCamera(np.eye(4), [0.1, 0.1], 8, 4))
        with pytest.raises(InputError, match="warp has no option 'quality'"):
            one.render(scene.home, quality=3)
