"""Warps from and to panoramas as a whole: seams, poles, identity, chains, quality, anything."""

from __future__ import annotations

import importlib
from itertools import product
from typing import Any

import numpy as np
import pytest

from belvedere.ground.errors import InputError
from belvedere.scene import Camera, CameraModel, CylinderCamera, Frame, ReferenceView, SphereCamera
from belvedere.studio._bench_quality import fill_nearest
from belvedere.studio.metrics import psnr, ssim_map
from belvedere.warp import PreparedView, SplatOptions, Warper, WarpOptions, prepare, warp
from belvedere.warp.panoramas import bent_passage
from tests.fuzz import assert_frame_is_sound, strange_camera
from tests.oracles.panorama import Room
from tests.warp.worlds import (
    boards,
    noise,
    random_camera,
    random_rotation,
    same,
    straight_camera,
    view_of,
)

KINDS = ("cylinder", "sphere")
EYE = np.array([0.1, -0.2, 1.3])
RECONSTRUCTIONS: tuple[Any, ...] = ("point", "splat", "inverse")


@pytest.fixture(scope="module")
def room() -> Room:
    return Room(0)


def beside(x: float, y: float, z: float) -> Any:
    """A place that many metres from `EYE`."""
    return EYE + np.array([x, y, z])


def all_round(
    kind: str, center: Any = EYE, width: int = 96, turn: Any = None, azimuth: float | None = None
) -> Any:
    """A panorama with square pixels; a cylinder's sees 52 degrees up and down."""
    if kind == "sphere":
        return SphereCamera(center, width, width // 2, turn, azimuth)
    return CylinderCamera(center, width, int(0.4 * width), turn, azimuth)


def straight(center: Any = EYE, toward: Any = (1.0, 0.3, -0.1), size: int = 48) -> Camera:
    up = (0, 0, 1) if abs(toward[2]) < 0.9 * np.linalg.norm(toward) else (1, 0, 0)
    return Camera.look_at(center, np.add(center, toward), up, 60, width=size, height=size)


def off(a: Frame, b: Frame) -> tuple[float, float]:
    """Share of pixels that differ in coverage or by more than 1 in colour; worst disparity."""
    covered = (a.coverage > 0) & (b.coverage > 0)
    step = np.abs(a.color.astype(int) - b.color.astype(int)).max(axis=-1)
    differ = ((a.coverage > 0) != (b.coverage > 0)) | (covered & (step > 1))
    error = np.abs(a.disparity - b.disparity)[covered & ~differ]
    return float(differ.mean()), float(error.max())


# ---- identity ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "reconstruction"), list(product(KINDS, RECONSTRUCTIONS)))
def test_a_panorama_warped_to_its_own_camera_comes_back_to_the_last_bit(
    kind: str, reconstruction: Any
) -> None:
    rng = np.random.default_rng(0)
    for n, colors in enumerate(("rgb8", "rgba8", "rgb32", "rgba32")):
        camera = all_round(kind, rng.normal(size=3), 40 + n, random_rotation(rng), rng.normal())
        disparity = rng.uniform(0, 2, camera.size).astype(np.float32)
        disparity[rng.random(camera.size) < 0.1] = np.nan
        view = ReferenceView(camera, noise(rng, camera.height, camera.width, colors), disparity)
        for visibility in ("order", "zbuffer"):
            frame = warp(view, camera, reconstruction=reconstruction, visibility=visibility)
            known = ~np.isnan(disparity)
            np.testing.assert_array_equal(frame.disparity, disparity)
            np.testing.assert_array_equal(frame.coverage, known.astype(np.float32))
            np.testing.assert_array_equal(frame.color[known], view.color[known])
            assert not frame.color[~known].any()


# ---- seams and poles ---------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "reconstruction"), list(product(KINDS, RECONSTRUCTIONS)))
def test_the_picture_does_not_show_where_the_reference_has_its_seam(
    room: Room, kind: str, reconstruction: Any
) -> None:
    """The same panorama cut open in front of the camera and behind it."""
    camera = all_round(kind)
    view = room.photograph(camera)
    half = camera.width // 2
    rolled = all_round(kind, azimuth=camera.azimuth - np.pi)
    turned = ReferenceView(rolled, np.roll(view.color, -half, 1), np.roll(view.disparity, -half, 1))
    for toward in ((-1.0, 0.02, 0.0), (1.0, -0.2, 0.1), (0.1, 0.0, 1.0), (0.0, 0.1, -1.0)):
        desired = straight(beside(0.2, 0.15, 0.1), toward)
        there, here = (warp(one, desired, reconstruction=reconstruction) for one in (view, turned))
        share, worst = off(there, here)
        assert share < 0.002  # a sample on the border of two pixels
        assert worst < 1e-3


@pytest.mark.parametrize(("kind", "reconstruction"), list(product(KINDS, RECONSTRUCTIONS)))
def test_the_picture_does_not_show_where_the_desired_panorama_has_its_seam(
    room: Room, kind: str, reconstruction: Any
) -> None:
    views = [room.photograph(all_round("sphere")), room.photograph(straight(size=64))]
    desired = all_round(kind, beside(0.2, 0.15, 0.1), 120)
    half = desired.width // 2
    turned = all_round(kind, desired.center, 120, azimuth=desired.azimuth - np.pi)
    there = warp(views, desired, reconstruction=reconstruction)
    here = warp(views, turned, reconstruction=reconstruction)
    back = Frame(
        desired, np.roll(here.color, half, 1), np.roll(here.disparity, half, 1),
        np.roll(here.coverage, half, 1),
    )  # fmt: skip
    share, worst = off(there, back)
    assert share < 0.002
    assert worst < 1e-5


@pytest.mark.parametrize("desired_kind", ["plane", "cylinder", "sphere"])
@pytest.mark.parametrize("up", [1.0, -1.0])
def test_a_sphere_is_closed_at_its_poles(up: float, desired_kind: str) -> None:
    """An empty room: every ray meets a plane, seen through the poles too."""
    room = Room(1, boxes=0)
    view = room.photograph(all_round("sphere", width=128))
    center = beside(0.1, 0.05, -0.1)
    if desired_kind == "plane":
        desired: CameraModel = straight(center, (0.02, 0.0, up), 60)
    else:  # its equator runs through the reference's poles
        turn = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]) * (up, 1, up)
        desired = all_round(desired_kind, center, 128, turn)
    frame = warp(view, desired)
    truth = room.photograph(desired, 1)
    row = view.camera.project(desired.unproject(*desired.pixel_grid(), truth.disparity))[1]
    cap = row < 15 if up > 0 else row > 48  # 50 degrees round the pole
    assert cap.sum() > 600
    assert (frame.coverage[cap] == 1).all()
    np.testing.assert_allclose(frame.disparity[cap], truth.disparity[cap], rtol=1e-3)
    assert psnr(frame.color, truth.color, cap) > 30


def test_the_last_rows_of_a_desired_sphere_show_what_is_straight_up_and_down() -> None:
    room = Room(1, boxes=0)
    desired = all_round("sphere", beside(0.1, 0.05, -0.1), 64)
    for kind in ("plane", "sphere"):
        for row, up in ((0, 1.0), (31, -1.0)):
            toward = (0.02, 0.0, up)
            camera = straight(EYE, toward, 80) if kind == "plane" else all_round(kind, width=96)
            frame = warp(room.photograph(camera), desired)
            assert (frame.coverage[row] == 1).all()
            wanted = room.look(desired, np.arange(64.0), np.full(64, float(row)))[1]
            np.testing.assert_allclose(frame.disparity[row], wanted, rtol=1e-3)


def test_holes_are_filled_across_the_seam() -> None:
    """A hole beside a green pillar: the red wall that goes on behind it is beyond the seam."""
    for kind, left in product(KINDS, (True, False)):
        camera = all_round(kind, width=64)
        color = np.full((*camera.size, 3), (0, 200, 0), np.uint8)
        disparity = np.full(camera.size, 2.0, np.float32)
        wall, gap = (np.s_[:, -24:], np.s_[:, :4]) if left else (np.s_[:, :24], np.s_[:, -4:])
        color[wall], disparity[wall], disparity[gap] = (200, 0, 0), 0.5, np.nan
        frame = warp(view_of(camera, disparity, color), camera, fill="background")
        assert frame.filled is not None
        np.testing.assert_array_equal(frame.filled, np.isnan(disparity))
        assert (frame.color[gap][..., 0] > 190).all()
        np.testing.assert_allclose(frame.disparity[gap], 0.5, rtol=1e-4)
        assert (frame.coverage[gap] == 0).all()


def test_a_silhouette_on_the_desired_seam_is_mixed_with_what_is_beyond_it() -> None:
    """A board whose edge runs through the first column, and the same not at a seam."""
    reference = SphereCamera((0, 0, 0), 192, 96)
    disparity = np.full(reference.size, 0.2, np.float32)
    disparity[30:66, 60:131] = 0.8
    color = np.where(disparity[..., None] > 0.5, [1.0, 0.8, 0.6], [0.0, 0.1, 0.3])
    view = view_of(reference, disparity, color.astype(np.float32))
    for kind, step in product(KINDS, range(-20, 20)):
        azimuth = reference.rays(60 + step / 4, 48.0)
        straight_on = float(np.arctan2(azimuth[1], azimuth[0]))
        desired, turned = (
            all_round(kind, (0.1, 0.05, 0.0), 150, azimuth=straight_on + turn)
            for turn in (0.0, 2 * np.pi * 40 / 150)
        )
        at_seam, inside = warp(view, desired), warp(view, turned)
        shown = np.roll(inside.coverage, -40, 1), np.roll(inside.color, -40, 1)
        np.testing.assert_allclose(at_seam.coverage, shown[0], atol=1e-6)
        np.testing.assert_allclose(at_seam.color, shown[1], atol=1e-4)


# ---- right pictures ----------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_planar_to_panorama_to_planar_is_planar_to_planar(room: Room, kind: str) -> None:
    view = room.photograph(straight(size=96), 3)
    between = all_round(kind, beside(0.02, -0.05, 0.03), 640)  # finer, so that it keeps all
    desired = straight(beside(0.05, -0.1, 0.05), size=80)
    at_once = warp(view, desired)
    by_way = warp(warp(view, between).as_view(), desired)
    both = (at_once.coverage == 1) & (by_way.coverage == 1)
    assert both.mean() > 0.8
    assert psnr(by_way.color, at_once.color, both) > 30
    error = np.abs(by_way.disparity / at_once.disparity - 1)[both]
    assert np.median(error) < 1e-4
    assert np.mean(error > 0.03) < 0.02


@pytest.mark.parametrize("kind", KINDS)
def test_what_stands_outside_the_frustum_hides_only_if_the_reference_looks_all_round(
    kind: str,
) -> None:
    """The invisible occluder of spec image-warping 4: a pillar beside the reference's picture."""
    room = Room(2, boxes=0)
    room.boxes = np.array([[[1.35, 1.45, 0.0], [1.5, 1.75, 2.6]]])
    room.hue = np.vstack([room.hue, [[0.9, 0.1, 0.1]]])
    eye = np.array([-0.2, -1.0, 1.3])
    planar = Camera.look_at(eye, eye + np.array([0, 1, 0]), fov_deg=60, width=96, height=96)
    desired = Camera.look_at((0.9, -1.2, 1.3), (0.9, 0, 1.3), fov_deg=60, width=96, height=96)
    truth = room.photograph(desired)
    pillar = truth.color[..., 0] > 1.5 * truth.color[..., 1]
    assert pillar.mean() > 0.02
    assert not room.sees(desired, planar, truth.disparity)[pillar].any()
    for view, right in ((room.photograph(planar), False),
                        (room.photograph(all_round(kind, eye, 523)), True)):  # fmt: skip
        frame = warp(view, desired)
        seen = frame.coverage > 0
        error = np.abs(frame.disparity / truth.disparity - 1) < 0.02
        if right:
            assert (error & seen)[pillar].mean() > 0.95
        else:  # it shows the wall behind, with confidence
            assert seen[pillar].mean() > 0.5
            assert not (error & seen)[pillar].any()


def within(camera: CameraModel, forward: Any, most_deg: float) -> Any:
    """(H, W) where a camera looks within some degrees of a direction."""
    rays = camera.rays(*camera.pixel_grid())
    cosine = rays @ forward / np.linalg.norm(rays, axis=-1) / np.linalg.norm(forward)
    return cosine > np.cos(np.radians(most_deg))


def of_kind(kind: str, eye: Any, forward: Any, roll: float = 0.0, size: int = 64) -> Any:
    """Cameras that have as many pixels within 16 degrees of one line of sight."""
    level = straight(eye, forward).matrix
    up = -level[:, 1] + np.tan(roll) * level[:, 0]
    around = int(round(1.03 * np.pi / np.tan(np.radians(30)) * size / 2) * 2)
    if kind == "plane":
        return Camera.look_at(eye, eye + forward, up, 60, width=size, height=size)
    if kind == "sphere":
        return SphereCamera.at(eye, forward, up, width=around)
    return CylinderCamera.at(eye, forward, up, width=around, height=around // 4)


def test_pictures_are_as_good_as_between_planes_at_equal_angular_resolution() -> None:
    """Truly seen pixels near the axis, where pixels of all manifolds are of one size.

    Two references, 6 rooms. Measured over 40: 39.4 dB and SSIM 0.9882 between planes; with a
    panorama at either end or both -0.41 to +0.49 dB, each give or take 0.22 of chance, and
    0.9878 to 0.9894.
    """
    scores: dict[tuple[str, str], list[tuple[float, float, float]]] = {}
    kinds = ("plane", *KINDS)
    for n in range(6):
        room, forward = Room(n), np.array([np.cos(n + 0.4), np.sin(n + 0.4), -0.15])
        side = np.array([-forward[1], forward[0], 0.0])
        stands = [
            (EYE + 0.2 * side, forward + 0.07 * side + (0, 0, 0.03), 0.044),
            (EYE - 0.25 * side + (0, 0, 0.05), forward - 0.09 * side - (0, 0, 0.05), -0.05),
        ]
        views, truths = {}, {}
        for kind in kinds:
            cameras = [of_kind(kind, *stand) for stand in stands]
            views[kind] = [room.photograph(one, 3, within(one, forward, 50)) for one in cameras]
            desired = of_kind(kind, EYE, forward)
            truths[kind] = room.photograph(desired, 3, within(desired, forward, 25))
        for first, second in product(kinds, repeat=2):
            truth = truths[second]
            seen = within(truth.camera, forward, 16)
            seen &= np.logical_or.reduce(
                [room.sees(truth.camera, one.camera, truth.disparity) for one in views["plane"]]
            )
            frame = warp(views[first], truth.camera)
            covered = frame.coverage > 0
            filled = fill_nearest(frame.color, covered)
            scores.setdefault((first, second), []).append((
                psnr(filled, truth.color, seen),
                float(ssim_map(filled, truth.color, seen)[seen].mean()),
                float((seen & ~covered).sum() / seen.sum()),
            ))  # fmt: skip
    mean = {pair: np.mean(each, axis=0) for pair, each in scores.items()}
    planes = mean.pop(("plane", "plane"))
    for pair, (decibels, similarity, cracks) in mean.items():
        assert decibels > planes[0] - 1.2, pair  # of so few rooms, chance is half a decibel
        assert similarity > planes[1] - 0.004, pair
        assert cracks < 0.002, pair
    assert np.mean([decibels for decibels, *_ in mean.values()]) > planes[0] - 0.8


def test_between_planes_the_kernels_of_panoramas_give_the_picture_of_planes(
    room: Room, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So what a panorama's picture lacks is its grid's doing, and not the engine's."""
    views = [room.photograph(straight(EYE + step, size=64), 2)
             for step in ((0.1, 0.1, 0.0), (-0.1, -0.15, 0.05))]  # fmt: skip
    desired = straight(size=64)
    flat = warp(views, desired)
    monkeypatch.setattr(importlib.import_module("belvedere.warp.warp"), "_passage",
                        lambda *given: bent_passage(*given[:4]))  # fmt: skip
    bent = warp(views, desired)
    assert ((flat.coverage > 0) == (bent.coverage > 0)).mean() > 0.999
    both = (flat.coverage > 0) & (bent.coverage > 0)
    assert (flat.color == bent.color).all(axis=-1)[both].mean() > 0.97
    assert psnr(bent.color, flat.color, both) > 45


# ---- threads, choices, anything ----------------------------------------------------------------


@pytest.mark.parametrize(("reconstruction", "visibility", "composite"), list(
    product(RECONSTRUCTIONS, ("order", "zbuffer"), ("blend", "nearest"))))  # fmt: skip
def test_the_number_of_threads_does_not_change_a_byte(
    reconstruction: Any, visibility: Any, composite: Any
) -> None:
    rng = np.random.default_rng(7)
    for n in range(4):
        views = []
        for kind in KINDS[: 1 + n % 2] if n < 3 else ("plane",):
            camera = (
                straight() if kind == "plane" else all_round(kind, rng.normal(size=3) * 0.1, 80)
            )
            disparity, _ = boards(rng, camera.height, camera.width, 8)
            disparity[rng.random(disparity.shape) < 0.03] = np.nan
            views.append(ReferenceView(camera, noise(rng, camera.height, camera.width), disparity))
        desired: CameraModel = (
            straight(size=140) if n == 0 else all_round(KINDS[n % 2], width=200 + n)
        )
        options = WarpOptions(reconstruction, visibility, composite,
                              fill="background" if n == 1 else "none",
                              splat=SplatOptions(3) if n == 2 else SplatOptions())  # fmt: skip
        one = warp(views, desired, threads=1, options=options)
        for threads in (2, 4):
            assert same(one, warp(views, desired, threads=threads, options=options)), (n, threads)


def test_splats_leave_no_gap_where_a_sphere_s_columns_crowd() -> None:
    """A wall straight above, from a coarse plane: squares grow wider toward the pole."""
    camera = straight((0, 0, 0), (0.02, 0, 1), 40)
    view = view_of(camera, np.full((40, 40), 0.5))
    desired = SphereCamera((0, 0, 0.1), 160, 80)
    frame = warp(view, desired, reconstruction="splat")
    assert (frame.coverage[:9] == 1).all()  # 20 degrees round the pole
    points = warp(view, desired, reconstruction="point")
    assert points.coverage[:9].mean() < 0.9
    fixed = warp(view, desired, reconstruction="splat", splat=SplatOptions(3))
    assert points.coverage.sum() < fixed.coverage.sum() <= 9 * points.coverage.sum()


def strange_panorama(rng: np.random.Generator, n: int) -> Any:
    width, height = ((1, 1), (2, 1), (5, 2), (3, 7), (16, 8), (40, 21))[n % 6]
    center = rng.normal(size=3) * 10.0 ** rng.uniform(-6, 6) if n % 3 else np.zeros(3)
    if n % 2:
        return SphereCamera(center, width, height, random_rotation(rng), rng.normal() * 10)
    return CylinderCamera(
        center, width, height, random_rotation(rng), rng.normal() * 10, rng.normal() * 10,
        10.0 ** rng.uniform(-3, 2),
    )  # fmt: skip


def test_anything_goes_and_every_frame_is_sound() -> None:
    rng = np.random.default_rng(11)
    for n in range(400):
        camera = random_camera(rng, 9, 7, turn=3.1) if n % 5 == 0 else strange_panorama(rng, n)
        scale = 10.0 ** rng.uniform(-6, 6) if n % 4 == 0 else 1.0
        disparity = (rng.uniform(0, 2, camera.size) / scale).astype(np.float32)
        disparity[rng.random(camera.size) < (0.0, 0.5, 1.0)[n % 3]] = np.nan
        disparity[rng.random(camera.size) < 0.2] = 0
        view = ReferenceView(camera, noise(rng, camera.height, camera.width), disparity)
        desired: Any = strange_panorama(rng, n + 3)
        if n % 5 == 0:
            desired = desired.moved(strange_camera(rng, n // 5, view).center)
        elif n % 5 == 1:
            desired = random_camera(rng, 8, 13, reach=10.0 ** rng.uniform(-3, 3), turn=3.1)
        views = [view, view] if n % 7 == 0 else view
        frame = warp(views, desired, reconstruction=RECONSTRUCTIONS[n % 3], threads=1)
        assert_frame_is_sound(frame)


@pytest.mark.parametrize("reconstruction", ["mesh", "offset"])
def test_reconstructions_of_planes_say_what_panoramas_have_instead(reconstruction: Any) -> None:
    ball, plane = all_round("sphere", width=8), straight(size=8)
    for view, desired in ((ball, plane), (plane, ball)):
        given = view_of(view, np.ones(view.size))
        with pytest.raises(InputError, match=f'"{reconstruction}" goes between planar cameras only'
                           '.*choose "point" or "splat" or "inverse"'):  # fmt: skip
            warp(given, desired, reconstruction=reconstruction)


def test_a_warper_and_prepared_views_give_the_same_panoramas(room: Room) -> None:
    views = [room.photograph(all_round(kind, beside(0.1 * n, 0, 0), 48), 1)
             for n, kind in enumerate(KINDS)]  # fmt: skip
    desired = all_round("sphere", width=64)
    wanted = warp(views, desired)
    prepared = [prepare(view) for view in views]
    assert all(isinstance(one, PreparedView) for one in prepared)
    assert same(warp(prepared, desired), wanted)
    warper = Warper(64, 32, kept=1)
    for _ in range(3):
        assert same(warper.warp(views, desired), wanted)


def test_a_prepared_panorama_keeps_the_view_it_was_made_from() -> None:
    """A warper knows views by their identity: another view must never come in their place."""
    warper = Warper(16, 8)
    camera = all_round("sphere", width=16)
    for value in range(60):
        view = view_of(camera, np.ones(camera.size), np.full((*camera.size, 3), value, np.uint8))
        assert (warper.warp(view, camera).color == value).all()


def test_nearer_references_count_for_more_whatever_their_manifold() -> None:
    red, blue = (
        np.broadcast_to(np.array(c, np.float32), (24, 48, 3)) for c in ((1, 0, 0), (0, 0, 1))
    )
    near = view_of(SphereCamera((0, 0, 0), 48, 24), np.full((24, 48), 0.01), red)
    far = view_of(SphereCamera((0.4, 0, 0), 48, 24), np.full((24, 48), 0.01), blue)
    frame = warp([near, far], SphereCamera((0.1, 0, 0), 48, 24))
    assert (frame.color[..., 0] > 0.8).all()
    assert (frame.color[..., 2] > 0.05).all()
    only = warp([near, far], straight_camera(20, 20), composite="nearest")
    assert (only.color[..., 0] > 0.99).all()
