"""Silhouettes: each edge's place beside those before and after it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from belvedere.warp import prepare
from tests.warp.worlds import straight_camera, view_of


def straightened(right: Any, down: Any, disparity: Any) -> tuple[Any, Any]:
    """Places 0 to 1 after neighbours along silhouettes were asked."""
    from belvedere.warp import _straighten

    places = [np.round(254 * place).astype(np.uint8) for place in (right, down)]
    links = prepare(view_of(straight_camera(disparity.shape[1], disparity.shape[0]), disparity))
    out = [place.copy() for place in places]
    _straighten.straighten_edges(
        places[0], places[1], disparity, links.links(), 0, disparity.shape[0], out[0], out[1]
    )
    return out[0] / 254.0, out[1] / 254.0


def slanted_edge(slant: float, axis: int) -> tuple[Any, Any]:
    """Disparity of a half plane of 40 x 40 samples, and in each row where its edge runs."""
    across, row = np.meshgrid(np.arange(40), np.arange(40))
    edge = 18.3 - slant * (np.arange(40) - 20)
    disparity = np.where(across <= 18.3 - slant * (row - 20), 0.8, 0.2).astype(np.float32)
    return (disparity.T.copy() if axis else disparity), edge


@pytest.mark.parametrize("slant", [0.0, 0.05, 0.3, -0.7])
@pytest.mark.parametrize("axis", [0, 1])
def test_asking_along_a_silhouette_keeps_a_straight_one(axis: int, slant: float) -> None:
    disparity, edge = slanted_edge(slant, axis)
    places = np.full((2, 40, 40), 0.5)
    rows, columns = np.arange(40), np.floor(edge).astype(int)
    exact = places[0] if axis == 0 else places[1].T
    exact[rows, columns] = edge - columns
    result = straightened(places[0], places[1], disparity)
    found = result[0] if axis == 0 else result[1].T
    np.testing.assert_allclose(found[rows, columns], edge - columns, atol=1.5 / 254)


@pytest.mark.parametrize("slant", [0.2, 0.3, -0.4])
@pytest.mark.parametrize("axis", [0, 1])
def test_stairs_alone_tell_where_a_silhouette_runs(axis: int, slant: float) -> None:
    """Nothing is known of any sample; half ways are 0.25 off, in the mean."""
    disparity, edge = slanted_edge(slant, axis)
    result = straightened(np.full((40, 40), 0.5), np.full((40, 40), 0.5), disparity)
    found = result[0] if axis == 0 else result[1].T
    rows = np.arange(8, 32)
    columns = np.floor(edge).astype(int)[rows]
    off = np.abs(found[rows, columns] - (edge[rows] - columns))
    assert off.mean() < 0.15


def test_one_wrong_place_among_right_ones_gives_way() -> None:
    disparity, edge = slanted_edge(0.0, 0)
    right = np.full((40, 40), 0.5)
    right[:, 18] = edge - 18
    right[20, 18] = 1.0
    found, _ = straightened(right, np.full((40, 40), 0.5), disparity)
    assert abs(found[20, 18] - 0.3) < 0.4 * 0.7
    assert np.all(np.abs(found[np.arange(40) != 20, 18] - 0.3) < 0.12)


def test_a_silhouette_that_turns_its_near_side_is_another() -> None:
    """A board ends where one on the other side begins: neither hears of the other's edge."""
    disparity = np.full((40, 40), 0.2, np.float32)
    disparity[:20, :19] = 0.8
    disparity[20:, 19:] = 0.8
    right = np.full((40, 40), 0.5)
    right[:20, 18], right[20:, 18] = 0.1, 0.9
    found, _ = straightened(right, np.full((40, 40), 0.5), disparity)
    np.testing.assert_allclose(found[:, 18], right[:, 18], atol=1 / 254)
