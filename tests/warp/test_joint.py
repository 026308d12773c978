"""References that are parts of one picture."""

from __future__ import annotations

import importlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from belvedere.scene import Camera, ReferenceView
from belvedere.studio.metrics import psnr
from belvedere.warp import prepare, warp
from belvedere.warp.joint import shared_layers
from belvedere.warp.reconcile import UNCHANGED

EYE = np.array([0.0, 0.0, 1.5])


def looking(way, eye=EYE, fov: float = 94.0, size: int = 96) -> Camera:
    return Camera.look_at(eye, np.asarray(eye) + way, width=size, height=size, fov_deg=fov)


def room(camera: Camera) -> ReferenceView:
    """A box of 6 x 6 x 3 metres with waves painted on its walls, seen from inside."""
    v, u = np.mgrid[: camera.height, : camera.width]
    rays = camera.rays(u, v)
    low, high = np.array([-3.0, -3.0, 0.0]), np.array([3.0, 3.0, 3.0])
    with np.errstate(divide="ignore"):
        ends = np.maximum((low - camera.center) / rays, (high - camera.center) / rays)
    depth = ends.min(axis=-1)
    point = camera.center + rays * depth[..., None]
    wave = np.stack([np.sin(2.1 * point + k).sum(axis=-1) for k in range(3)], axis=-1)
    color = (127 + 40 * wave).astype(np.uint8)
    return ReferenceView(camera, color, (1.0 / depth).astype(np.float32))


def test_sides_of_a_box_share_a_layer() -> None:
    sides = [prepare(room(looking(way))) for way in ((1, 0, 0), (0, 1, 0), (-1, 0, 0))]
    other = prepare(room(looking((1, 0, 0), EYE + np.array([0.1, 0.0, 0.0]))))
    assert shared_layers([*sides, other]) == [0, 0, 0, 1]
    assert shared_layers([sides[0], other, sides[1]]) == [0, 1, 0]


def test_pictures_that_overlap_by_half_do_not() -> None:
    one, twin = prepare(room(looking((1, 0, 0)))), prepare(room(looking((1, 0.5, 0))))
    side = prepare(room(looking((0, -1, 0))))
    assert shared_layers([one, twin]) is None
    assert shared_layers([one, twin, side]) == [0, 1, 0]


def test_different_eyes_never_do() -> None:
    views = [
        prepare(room(looking((1, 0, 0), EYE + np.array([0.0, 0.01 * k, 0.0])))) for k in range(3)
    ]
    assert shared_layers(views) is None


@pytest.mark.parametrize("composite", ["blend", "nearest"])
def test_parts_show_what_a_wide_picture_shows(composite: str) -> None:
    """Two sides of a box, against one picture that is wide enough for both, and the truth."""
    desired = Camera.look_at(
        EYE + np.array([0.2, -0.3, 0.1]),
        EYE + np.array([2.0, 1.8, -0.2]),
        width=120,
        height=90,
        fov_deg=60,
    )
    second = room(looking((1, 1, 0), EYE + np.array([0.3, 0.2, 0.0]), fov=120, size=160))
    parts = [room(looking(way)) for way in ((1, 0, 0), (0, 1, 0))]
    away = room(looking((-1, 0, 0)))  # shows nothing of it, and costs nothing
    truth = room(desired)
    frame = warp([*parts, second, away], desired, composite=composite, reconcile=False)
    assert (frame.coverage > 0).mean() > 0.995
    assert psnr(frame.color, truth.color, frame.coverage > 0) > 38.0


def test_no_seam_opens_between_parts() -> None:
    desired = Camera.look_at(
        EYE + np.array([0.1, -0.1, 0.0]),
        EYE + np.array([2.0, 2.0, 0.0]),
        width=200,
        height=150,
        fov_deg=50,
    )
    parts = [room(looking(way)) for way in ((1, 0, 0), (0, 1, 0))]
    frame = warp(parts, desired)
    assert (frame.coverage > 0).all()


def test_views_that_miss_the_picture_change_nothing() -> None:
    desired = looking((1, 0, 0), EYE + np.array([0.1, 0.0, 0.0]), fov=40)
    views = [room(looking(way)) for way in ((1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0))]
    np.testing.assert_array_equal(
        warp(views, desired, reconcile=False).color, warp(views[:1], desired, reconcile=False).color
    )


def test_parts_that_all_miss_leave_holes() -> None:
    views = [room(looking(way)) for way in ((1, 0, 0), (0, 1, 0))]
    desired = Camera.look_at(
        EYE + np.array([20.0, 0, 0]), EYE + np.array([40.0, 0, 0]), width=32, height=24, fov_deg=40
    )
    assert not (warp(views, desired).coverage > 0).any()


def test_frames_of_parts_do_not_depend_on_threads() -> None:
    desired = looking((1, 0.9, 0.1), EYE + np.array([0.2, 0.1, 0.0]), fov=60, size=300)
    views = [room(looking(way)) for way in ((1, 0, 0), (0, 1, 0), (0, -1, 0))]
    frames = [warp(views, desired, threads=n) for n in (1, 2, 3)]
    for other in frames[1:]:
        np.testing.assert_array_equal(frames[0].color, other.color)


def test_features_of_reconciled_parts_though_some_miss_the_picture(monkeypatch) -> None:
    """Each reference is asked by its own geometry, not by that of the next one drawn."""
    warping = importlib.import_module("belvedere.warp.warp")
    same: Any = lambda views, *_: [replace(UNCHANGED) for _ in views]  # noqa: E731
    monkeypatch.setattr(warping, "corrections", same)  # moved by nothing, but moved
    desired = looking((1, 0.2, 0), EYE + np.array([0.1, 0.05, 0.0]), fov=40)
    views = [room(looking(way)) for way in ((0, -1, 0), (1, 0, 0), (-1, 0, 0))]
    featured = [replace(one, features=one.color.astype(np.float32)) for one in views]
    frame = warp(featured, desired)
    assert frame.features is not None
    known = (frame.coverage > 0) & np.isfinite(frame.features[..., 0])
    assert known.mean() > 0.9
    assert np.abs(frame.features[known] - frame.color[known]).mean() < 3.0
