"""What is said of a frame is true: small worlds in which every answer is known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import belvedere as bv
from belvedere.ground.errors import BelvedereError
from belvedere.warp import RECONSTRUCTIONS, prepare
from tests.warp.worlds import (
    boards,
    checks,
    grey,
    noise,
    plane_disparity,
    random_camera,
    straight_camera,
    view_of,
)

RNG = np.random.default_rng
WALL, BOARD = 0.25, 1.0
WIDTH, HEIGHT = 60, 40


def board_before_wall(shift: float = 0.0, holes: Any = None) -> bv.ReferenceView:
    """A board 1 m away in the middle of a wall 4 m away, seen from a step to the right."""
    camera = straight_camera(WIDTH, HEIGHT).moved((shift, 0, 0))
    u, _ = np.broadcast_arrays(*camera.pixel_grid())
    left = 25 - shift * WIDTH * BOARD
    disparity = np.where((u >= left) & (u < left + 10), BOARD, WALL).astype(np.float32)
    if holes is not None:
        disparity[holes] = np.nan
    return bv.ReferenceView(camera, checks(camera), disparity)


def explained(views: Any, camera: bv.Camera, **choices: Any) -> tuple[bv.Frame, bv.Explanation]:
    frame = bv.warp(views, camera, explain=True, **choices)
    assert frame.explanation is not None
    return frame, frame.explanation


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_behind_a_board_is_an_exposure_and_beyond_the_picture_the_outside(
    reconstruction: Any,
) -> None:
    desired = straight_camera(WIDTH, HEIGHT).moved((0.2, 0, 0))
    frame, why = explained(board_before_wall(), desired, reconstruction=reconstruction)
    row = why.hole[HEIGHT // 2]
    # the board moves by 12 pixels to the left, the wall by 3
    assert (row[24:30] == bv.Hole.UNSEEN).all()
    assert (row[58:] == bv.Hole.OUTSIDE).all()
    assert (row[:12] == bv.Hole.COVERED).all()
    np.testing.assert_array_equal(why.hole == bv.Hole.COVERED, ~frame.holes)


@pytest.mark.parametrize("reconstruction", ["point", "splat"])
def test_where_samples_lie_apart_a_hole_is_a_crack(reconstruction: Any) -> None:
    camera = straight_camera(WIDTH, HEIGHT)
    delta = plane_disparity(camera, (0.3, 1.0, 0.1), 3.0)
    closer = straight_camera(WIDTH, HEIGHT, center=(0.1, 1.4, 0.05))
    splat = bv.SplatOptions(size=1)
    _, why = explained(view_of(camera, delta), closer, reconstruction=reconstruction, splat=splat)
    inner = why.hole[4:-4, 4:-4]
    holes = inner[inner != bv.Hole.COVERED]
    assert holes.size > 0.4 * inner.size
    # samples stand alone: some holes have no two sides in one row, column or diagonal
    assert (holes == bv.Hole.UNDERSAMPLED).mean() > 0.95


def test_a_second_reference_that_sees_behind_the_board_turns_an_exposure_into_cover() -> None:
    desired = straight_camera(WIDTH, HEIGHT).moved((0.2, 0, 0))
    views = [board_before_wall(), board_before_wall(0.35)]
    _, why = explained(views, desired)
    assert not (why.hole[:, 20:40] != bv.Hole.COVERED).any()
    middle = HEIGHT // 2
    assert (why.source[middle, 25:29] == 1).all()  # only the right one sees behind the board
    assert (why.seen_by[middle, 25:29] == 2).all()
    assert (why.seen_by[middle, 9:12] == 1).all()  # hidden behind the board from the right
    assert (why.seen_by[middle, 45:50] == 3).all()
    assert (why.seen_count[middle, 45:50] == 2).all()


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_references_are_numbered_as_they_were_given(reconstruction: Any) -> None:
    views = [board_before_wall(s) for s in (0.5, 0.1, 0.3)]
    desired = straight_camera(WIDTH, HEIGHT).moved((0.31, 0, 0))
    _, why = explained(views, desired, reconstruction=reconstruction)
    _, other = explained(views[::-1], desired, reconstruction=reconstruction)
    covered = why.hole == bv.Hole.COVERED
    assert set(np.unique(why.source[~covered])) <= {-1}
    assert (why.source[covered] >= 0).all()
    np.testing.assert_array_equal(why.source[covered], 2 - other.source[covered])
    mirrored = (why.seen_by & 1) << 2 | (why.seen_by & 2) | (why.seen_by & 4) >> 2
    np.testing.assert_array_equal(mirrored, other.seen_by)
    assert np.median(why.source[covered]) == 2  # the nearest shows most of it


def test_explaining_later_says_the_same_as_explaining_at_once() -> None:
    views = [board_before_wall(), board_before_wall(0.35)]
    desired = straight_camera(WIDTH, HEIGHT).moved((0.2, 0.1, 0))
    for fill in ("none", "background"):
        frame, at_once = explained(views, desired, fill=fill)
        later = bv.explain(frame, views)
        for name in ("source", "seen_by", "hole", "error"):
            np.testing.assert_array_equal(getattr(later, name), getattr(at_once, name))
    assert bv.warp(views, desired).explanation is None


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_explanations_are_the_same_bytes_for_any_number_of_threads(reconstruction: Any) -> None:
    rng = RNG(3)
    views = [
        view_of(straight_camera(190, 170).moved((x, 0, 0)), boards(rng, 170, 190)[0],
                noise(rng, 170, 190))
        for x in (0.0, 0.2)
    ]  # fmt: skip
    desired = straight_camera(200, 180).moved((0.1, 0.1, 0.02))
    frame = bv.warp(views, desired, reconstruction=reconstruction)
    held = [bv.explain(frame, views, threads=n) for n in (1, 2, 3, 4)]
    for name in ("source", "seen_by", "hole", "error"):
        assert len({getattr(one, name).tobytes() for one in held}) == 1


def test_errors_are_known_where_there_is_colour_and_only_there() -> None:
    for seed in range(8):
        rng = RNG(seed)
        views = [
            view_of(random_camera(rng, 40, 30, 0.3), boards(rng, 30, 40)[0], noise(rng, 30, 40))
            for _ in range(3)
        ]
        frame, why = explained(views, random_camera(rng, 44, 36, 0.5, 0.5))
        np.testing.assert_array_equal(np.isnan(why.error), frame.holes)
        assert (why.error[~frame.holes] > 0).all()
        assert (why.seen_count <= 3).all()
        np.testing.assert_array_equal(why.seen_count[frame.holes], 0)


def test_a_picture_that_disagrees_with_its_references_is_expected_to_be_wrong() -> None:
    camera = straight_camera(WIDTH, HEIGHT)
    plain = view_of(camera, np.full(camera.size, WALL), grey(HEIGHT, WIDTH, 100))
    frame = bv.warp(plain, camera)
    right = bv.explain(frame, plain)
    color = frame.color.copy()
    color[10:20] = 151  # 0.2 lighter
    wrong = bv.explain(bv.Frame(camera, color, frame.disparity, frame.coverage), plain)
    assert right.error.max() < 0.01
    assert 0.1 < np.median(wrong.error[12:18]) < 0.3
    assert wrong.error[25:].max() < 0.01
    two = [
        plain, view_of(camera.moved((0.1, 0, 0)), plain.disparity,
                          grey(HEIGHT, WIDTH, 120)),
    ]  # fmt: skip
    mixed = bv.explain(bv.warp(two, camera.moved((0.05, 0, 0))), two)
    assert np.median(mixed.error) > 2 * np.median(right.error)


def test_what_no_reference_confirms_is_expected_to_be_wrong() -> None:
    camera = straight_camera(WIDTH, HEIGHT)
    view = view_of(camera, np.full(camera.size, WALL))
    frame = bv.warp(view, camera)
    moved = bv.Frame(camera, frame.color, frame.disparity * np.float32(1.5), frame.coverage)
    why, before = bv.explain(moved, view), bv.explain(frame, view)
    assert (why.seen_by == 0).mean() > 0.9
    assert (why.source == 0).all()
    assert why.error.min() > 5 * before.error.max()


def test_doubted_disparities_cost_what_they_shift() -> None:
    """A slope of colour of 3 bytes a pixel, shifted by d, is off by 3 d bytes."""
    camera = straight_camera(80, 40)
    u, _ = np.broadcast_arrays(*camera.pixel_grid())
    color = np.repeat((10 + 3 * u)[..., None], 3, -1).astype(np.uint8)
    disparity = np.full(camera.size, 0.5)
    desired = straight_camera(80, 40).moved((0.4, 0, 0))
    noise_share = 0.05
    sure = bv.explain(bv.warp(view_of(camera, disparity, color), desired), [
        view_of(camera, disparity, color)])  # fmt: skip
    wrong = view_of(camera, disparity * (1 + noise_share), color)
    frame = bv.warp(wrong, desired)
    why = bv.explain(frame, wrong, disparity_error=noise_share)
    true = bv.warp(view_of(camera, disparity, color), desired)
    inner = np.s_[5:-5, 5:50]
    off = abs(frame.color[inner].astype(float) - true.color[inner]).mean() / 255
    added = np.sqrt(np.median(why.error[inner] ** 2 - sure.error[inner] ** 2))
    # contrast is a mean over both axes, this slope lies along the one that shifts
    assert off / 2 < added < off * 1.2, (off, added)


def test_a_coarser_reference_is_expected_to_be_worse() -> None:
    fine, coarse = straight_camera(WIDTH, HEIGHT), straight_camera(WIDTH, HEIGHT).resized(30, 20)
    views = []
    for camera, step in ((fine, 1.0), (coarse, 2.0)):  # one slope of colour, in each one's pixels
        u, _ = np.broadcast_arrays(*camera.pixel_grid())
        color = np.repeat((4 * step * u + 2 * step)[..., None], 3, axis=2).astype(np.uint8)
        views.append(view_of(camera, np.full(camera.size, WALL), color))
    frame = bv.warp(views[0], fine)
    near, far = (np.median(bv.explain(frame, view).error) for view in views)
    assert far > 1.1 * near


def test_the_outside_is_what_lies_farthest_back() -> None:
    """A lintel near the eye hangs above the hole, but what is missing is more of the wall."""
    camera = straight_camera(WIDTH, HEIGHT)
    _, v = np.broadcast_arrays(*camera.pixel_grid())
    view = view_of(camera, np.where(v < 10, BOARD, WALL))
    aside = camera.matrix @ np.array([[1.0, 0, 6], [0, 1, 0], [0, 0, 1]])  # 6 pixels to the right
    desired = bv.Camera(aside, camera.center - [0.2, 0, 0], WIDTH, HEIGHT)
    _, why = explained(view, desired)
    # in column 58 the lintel's place is column 52 of the reference, the wall's is 61
    assert (why.hole[2:8, 57:] == bv.Hole.COVERED).all()
    assert (why.hole[14:-2, 58:] == bv.Hole.OUTSIDE).all()


def test_colour_of_any_kind_is_explained() -> None:
    for kind in ("rgb8", "rgba8", "rgb32", "rgba32"):
        view = view_of(straight_camera(40, 30), np.full((30, 40), 0.5), noise(RNG(0), 30, 40, kind))
        _, why = explained([view, view], straight_camera(36, 28).moved((0.1, 0, 0)))
        assert np.nanmax(why.error) < 1


@pytest.mark.parametrize("size", [(1, 1), (1, 5), (5, 1), (2, 2)])
def test_tiny_pictures_are_explained(size: tuple[int, int]) -> None:
    width, height = size
    camera = straight_camera(width, height, focal=4)
    view = view_of(camera, np.full((height, width), 0.5))
    for desired in (camera, camera.moved((0.1, 0, 0)), straight_camera(7, 6, focal=4)):
        for reconstruction in RECONSTRUCTIONS:
            frame, why = explained(view, desired, reconstruction=reconstruction)
            np.testing.assert_array_equal(why.hole == bv.Hole.COVERED, ~frame.holes)


def test_a_view_of_nothing_is_all_outside_or_unseen() -> None:
    view = view_of(straight_camera(20, 16), np.full((16, 20), np.nan))
    frame, why = explained(view, straight_camera(24, 18))
    assert frame.holes.all()
    assert (why.hole != bv.Hole.COVERED).all()
    assert (why.source == -1).all()
    assert why.share(bv.Hole.COVERED) == 0


BAD: list[Any] = ["x"]


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda f, v: bv.explain(BAD[0], v), "explain.frame is a str, expected a Frame"),
        (lambda f, v: bv.explain(f, []), "explain.views is empty"),
        (lambda f, v: bv.explain(f, [v] * 33), "explain.views are 33, expected at most 32"),
        (lambda f, v: bv.explain(f, v, surface_tolerance=2), "explain.surface_tolerance is 2"),
        (lambda f, v: bv.explain(f, v, disparity_error=-1), "explain.disparity_error is -1"),
        (lambda f, v: bv.explain(f, prepare(v), threads=0), "threads is 0"),
        (lambda f, v: bv.warp(v, f.camera, explain="yes"), "WarpOptions.explain is 'yes'"),
    ],
)
def test_a_bad_call_is_refused(make: Any, text: str) -> None:
    view = view_of(straight_camera(4, 3), np.ones((3, 4)))
    with pytest.raises(BelvedereError) as refusal:
        make(bv.warp(view, straight_camera(4, 3)), view)
    assert text in str(refusal.value)
