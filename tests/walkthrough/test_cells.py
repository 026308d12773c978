from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from belvedere.ground.errors import SceneError
from belvedere.walkthrough import OUTSIDE, Cell, CellGraph, Portal

SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
EAST = np.array([4.0, 0.0])
COURT = np.array([[1.0, 1.0], [3.0, 1.0], [3.0, 3.0], [1.0, 3.0]])


def upright(x: float = 4.0) -> np.ndarray:
    """Counter-clockwise when seen from -x."""
    return np.array([[x, 2.0, 0.0], [x, 1.0, 0.0], [x, 1.0, 2.0], [x, 2.0, 2.0]])


def graph() -> CellGraph:
    hall = Cell("hall", (SQUARE,), 0.0, 5.0)
    room = Cell("room", (SQUARE + EAST,), 0.0, 2.5)
    loft = Cell("loft", (SQUARE + EAST,), 2.6, 5.0, 1)
    return CellGraph(
        (hall, room, loft),
        (
            Portal("door", "door", upright(), (0, 1)),
            Portal("hatch", "window", upright() + np.array([0.0, 0.0, 2.7]), (0, 2)),
            Portal("front", "door", upright(0.0)[::-1], (0, OUTSIDE)),
        ),
    )


def test_a_ring_inside_a_ring_is_a_courtyard() -> None:
    cell = Cell("ring", (SQUARE, COURT), 0.0, 3.0)
    inside = cell.contains([[0.5, 2, 1], [2, 2, 1], [3.5, 2, 1], [0.5, 2, 3.5], [5, 2, 1]])
    assert inside.tolist() == [True, False, True, False, False]
    assert cell.low.tolist() == [0, 0, 0]
    assert cell.high.tolist() == [4, 4, 3]


@given(st.floats(-1, 5), st.floats(-1, 5), st.floats(0, 6.28))
def test_turning_room_and_point_together_changes_nothing(x: float, y: float, angle: float) -> None:
    if min(abs(x - e) for e in (0, 1, 3, 4)) < 1e-6 or min(abs(y - e) for e in (0, 1, 3, 4)) < 1e-6:
        return
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    flat = Cell("flat", (SQUARE, COURT), 0.0, 3.0).contains([[x, y, 1.0]])
    turned = Cell("turned", (SQUARE @ turn.T, COURT @ turn.T), 0.0, 3.0)
    assert turned.contains([[*(turn @ [x, y]), 1.0]])[0] == flat[0]


def test_a_portal_looks_into_its_first_cell() -> None:
    door = graph().portals[0]
    assert door.normal.tolist() == [-1, 0, 0]
    assert door.center.tolist() == [4, 1.5, 1]
    assert (door.beyond(0), door.beyond(1)) == (1, 0)
    assert door.walkable
    assert not graph().portals[1].walkable


def test_neighbours_of_a_cell() -> None:
    g = graph()
    assert g.portals_of == ((0, 1, 2), (0,), (1,))
    assert list(g.neighbours(0)) == [(0, 1), (1, 2), (2, OUTSIDE)]
    assert list(g.neighbours(0, walking=True)) == [(0, 1), (2, OUTSIDE)]


def test_of_cells_one_above_another_the_next_below_counts() -> None:
    g = graph()
    at = g.cells_at([[2, 2, 4], [6, 2, 1], [6, 2, 4], [9, 2, 1], [6, 2, 2.55]])
    assert at.tolist() == [0, 1, 2, OUTSIDE, OUTSIDE]
    low = Cell("under", (SQUARE,), 0.0, 5.0)
    stair = Cell("landing", (SQUARE,), 2.0, 5.0)
    assert CellGraph((low, stair), ()).cells_at([[1, 1, 3], [1, 1, 1]]).tolist() == [1, 0]


@pytest.mark.parametrize(
    ("corners", "words"),
    [
        (np.zeros((4, 3)), "is a line"),
        (upright()[:3], "four finite points"),
        (np.where(upright() == 2.0, np.nan, upright()), "four finite points"),
        (upright() + np.eye(4)[:, 1:2] * [1.0, 0.0, 0.0], "is not flat"),
    ],
)
def test_what_is_no_rectangle_is_refused(corners: np.ndarray, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        Portal("door", "door", corners, (0, 1))


def test_a_graph_refuses_names_twice_and_cells_that_are_not_there() -> None:
    cell = Cell("a", (SQUARE,), 0.0, 2.0)
    with pytest.raises(SceneError, match="several cells are called 'a'"):
        CellGraph((cell, cell), ())
    for pair, words in (((0, 3), "joins cells 0 and 3"), ((0, 0), "with itself"),
                        ((OUTSIDE, 0), "joins cells -1 and 0")):  # fmt: skip
        with pytest.raises(SceneError, match=words):
            CellGraph((cell, Cell("b", (SQUARE,), 3.0, 4.0)),
                      (Portal("d", "door", upright(), pair),))  # fmt: skip
