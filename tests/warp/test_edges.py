"""Where one surface ends: links, mixed samples, and gaps that are none."""

from __future__ import annotations

import numpy as np
import pytest

from belvedere.scene import ReferenceView
from belvedere.warp import PreparedView, prepare
from tests.warp.worlds import boards, grey, plane_disparity, random_camera, straight_camera

RIGHT, DOWN, MIXED = 1, 2, 4


def prepared(disparity: np.ndarray, **choices: float) -> PreparedView:
    d = np.asarray(disparity, np.float32)
    height, width = d.shape
    return prepare(ReferenceView(straight_camera(width, height), grey(height, width), d), **choices)  # type: ignore[arg-type]


def all_linked(links: np.ndarray) -> bool:
    return bool(
        (links[:, :-1] & RIGHT).all() and (links[:-1] & DOWN).all() and not (links & MIXED).any()
    )


def test_every_plane_is_one_surface_however_steep() -> None:
    rng = np.random.default_rng(0)
    steep = 0
    for _ in range(400):
        camera = random_camera(rng, 40, 30, reach=0.1)
        normal = rng.normal(size=3)
        delta = plane_disparity(camera, normal, float(rng.uniform(0.5, 5)))
        if (delta <= 1e-4).any():
            continue
        jump = np.abs(np.diff(delta, axis=1)) / np.maximum(delta[:, 1:], delta[:, :-1])
        steep += bool((jump > 0.05).any())
        assert all_linked(prepared(delta).links())
    assert steep > 10


def test_a_plane_to_its_horizon_is_one_surface() -> None:
    delta = np.broadcast_to(np.linspace(0, 1, 30)[:, None], (30, 40))
    assert all_linked(prepared(delta).links())


def test_links_break_at_the_edges_of_boards_and_nowhere_else() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        disparity, label = boards(rng, 40, 60)
        noisy = disparity * rng.normal(1, 0.003, disparity.shape)
        links = prepared(noisy).links()
        np.testing.assert_array_equal((links[:, :-1] & RIGHT) > 0, label[:, :-1] == label[:, 1:])
        np.testing.assert_array_equal((links[:-1] & DOWN) > 0, label[:-1] == label[1:])
        assert not (links & MIXED).any()


@pytest.mark.parametrize("turned", [False, True])
def test_a_step_between_level_surfaces_is_an_edge_and_the_same_step_of_a_slope_is_none(
    turned: bool,
) -> None:
    """A post and a baluster at nearly one distance, and a wall seen at a slant."""
    step = np.full((20, 30), 0.40)
    step[:, 15:] = 0.416  # 4 per cent: within the tolerance of 5
    slope = np.broadcast_to(0.3 * 1.04 ** np.arange(30.0), (20, 30))
    relief = np.full((20, 30), 0.40)
    relief[:, 15:] = 0.408  # 2 per cent: noise, or a moulding
    step, slope, relief = (np.rot90(d) if turned else d for d in (step, slope, relief))
    assert all_linked(prepared(slope).links())
    assert all_linked(prepared(relief).links())
    links, bit = prepared(step).links(), DOWN if turned else RIGHT
    broken = np.argwhere(~(links & bit).astype(bool))
    places = {int(at[0 if turned else 1]) for at in broken} - {29}
    assert places == {14}


def test_nothing_links_across_the_picture_s_border_or_to_missing_samples() -> None:
    disparity = np.ones((6, 7), np.float32)
    disparity[2, 3] = np.nan
    links = prepared(disparity, bridge=0).links()
    assert not (links[:, -1] & RIGHT).any()
    assert not (links[-1] & DOWN).any()
    assert links[2, 3] == 0
    assert not links[2, 2] & RIGHT
    assert not links[1, 3] & DOWN


def test_a_false_sample_between_two_surfaces_is_mixed_and_a_thin_object_is_not() -> None:
    wall, board = 0.2, 1.0
    row = np.full((5, 20), wall)
    row[:, 10:] = board
    row[:, 9] = 0.6
    links = prepared(row).links()
    assert (links[:, 9] & MIXED).all()
    assert not (links[:, [8, 10]] & MIXED).any()
    thin = np.full((5, 20), wall)
    thin[:, 9] = board
    thin[2, :] = board
    assert not (prepared(thin).links() & MIXED).any()
    column = prepared(row.T).links()
    assert (column[9] & MIXED).all()


def test_infinitely_far_samples_are_one_surface_and_apart_from_all_others() -> None:
    sky = np.zeros((8, 9))
    assert all_linked(prepared(sky).links())
    sky[4:] = 0.01
    links = prepared(sky).links()
    assert not (links[3] & DOWN).any()


def test_seams_inside_a_surface_are_bridged_at_its_own_disparity() -> None:
    camera = straight_camera(40, 30)
    whole = plane_disparity(camera, (0.3, 1.0, 0.2), 4.0)
    torn = whole.astype(np.float32)
    torn[:, 12:14] = np.nan
    torn[9, :] = np.nan
    torn[20:23, 30] = np.nan
    surface = prepared(torn).surface()
    # a seam that runs into the border has one side only: nothing to agree with there
    holes = np.isnan(surface)
    assert set(zip(*np.nonzero(holes), strict=True)) <= {(9, 0), (9, 39), (0, 12), (0, 13)}
    assert all_linked(prepared(np.where(holes, whole, surface)).links())
    np.testing.assert_allclose(surface[~holes], whole[~holes], rtol=2e-3)
    np.testing.assert_array_equal(surface[~np.isnan(torn)], torn[~np.isnan(torn)])


def test_gaps_at_edges_and_wide_ones_stay_open() -> None:
    edge = np.full((9, 20), 0.2)
    edge[:, 10:] = 1.0
    edge[:, 9:11] = np.nan
    np.testing.assert_array_equal(np.isnan(prepared(edge).surface()), np.isnan(edge))
    wide = np.full((9, 20), 0.2)
    wide[2:7, 6:11] = np.nan
    np.testing.assert_array_equal(np.isnan(prepared(wide).surface()), np.isnan(wide))
    assert not np.isnan(prepared(wide, bridge=5).surface()).any()
    assert np.isnan(prepared(np.where(wide > 0, wide, np.nan), bridge=0).surface()).sum() == 25


def test_a_tolerance_of_one_links_everything_and_of_zero_only_planes() -> None:
    disparity, label = boards(np.random.default_rng(2), 20, 30, 3)
    assert all_linked(prepared(disparity, edge_tolerance=1.0).links())
    links = prepared(disparity, edge_tolerance=0.0).links()
    np.testing.assert_array_equal((links[:, :-1] & RIGHT) > 0, label[:, :-1] == label[:, 1:])


@pytest.mark.parametrize("threads", [2, 3, 4])
def test_preparing_does_not_depend_on_the_threads(threads: int) -> None:
    rng = np.random.default_rng(3)
    disparity, _ = boards(rng, 61, 97)
    disparity[rng.random(disparity.shape) < 0.2] = np.nan
    one, many = prepared(disparity), prepared(disparity)
    assert one.surface(1).tobytes() == many.surface(threads).tobytes()
    assert one.links(1).tobytes() == many.links(threads).tobytes()
    assert one.linear(1).tobytes() == many.linear(threads).tobytes()
    for a, b in zip(one.surface_range(1), many.surface_range(threads), strict=True):
        assert a.tobytes() == b.tobytes()
