from __future__ import annotations

import itertools
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra.numpy import arrays

from belvedere.ground.errors import InputError
from belvedere.scene.io import read_color
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough import CellGraph, Mark, draw_plan, find_cells
from belvedere.walkthrough.cells import enclosed
from belvedere.walkthrough.drawing import Label
from belvedere.walkthrough.outlines import area_of, inner_point, outline_rings
from belvedere.walkthrough.plan import _slice
from tests.walkthrough import plans

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def flat() -> CellGraph:
    return find_cells(plans.flat())


def test_every_room_and_portal_is_written_on_it(flat: CellGraph) -> None:
    plan = draw_plan(flat, plans.flat())
    root = ElementTree.fromstring(plan.svg)
    words = {text.text for text in root.iter(f"{SVG}text")}
    assert {cell.name for cell in flat.cells} <= words
    assert {portal.name for portal in flat.portals} <= words
    assert {"storey 0, floor at 0.00 m", "5 m", "x", "y"} <= words
    assert any(word and word.endswith(" m") and "." in word for word in words)  # areas


def test_labels_do_not_cover_one_another(duplex: Mesh, duplex_cells: CellGraph) -> None:
    labels = [item for item in draw_plan(duplex_cells, duplex).drawing.items
              if isinstance(item, Label) and item.text != "2"]  # fmt: skip
    covered = 0.0
    for a, b in itertools.combinations(labels, 2):
        w = min(a.box[2], b.box[2]) - max(a.box[0], b.box[0])
        h = min(a.box[3], b.box[3]) - max(a.box[1], b.box[1])
        covered += max(w, 0.0) * max(h, 0.0)
    assert covered < 0.01 * sum((x.box[2] - x.box[0]) * (x.box[3] - x.box[1]) for x in labels)


def test_rooms_are_coloured_and_walls_dark(flat: CellGraph) -> None:
    plan = draw_plan(flat, plans.flat(), pixels_per_metre=40.0)
    image = plan.image().astype(int)
    assert image.shape == (plan.drawing.height, plan.drawing.width, 3)

    def at(x: float, y: float) -> np.ndarray:
        low = np.min([cell.low[:2] for cell in flat.cells], axis=0) - 0.9
        high = np.max([cell.high[:2] for cell in flat.cells], axis=0) + 0.9
        u = plan.drawing.width / 2.0 + (x - (low[0] + high[0]) / 2.0) * 40.0
        v = (high[1] - y) * 40.0 + 46.0
        return image[round(v), round(u)]

    rooms = [at(0.4, 2.6), at(3.5, 3.5), at(8.5, 3.5), at(2.2, 4.7)]
    assert len({tuple(color) for color in rooms}) == 4
    assert all(color.min() > 150 and np.ptp(color) > 10 for color in rooms), rooms
    face = [at(x, 3.925) for x in np.linspace(2.2, 2.8, 40)]
    assert min(color.max() for color in face) < 120


def test_it_is_saved_as_svg_and_png(flat: CellGraph, tmp_path: Path) -> None:
    plan = draw_plan(flat, plans.flat(), pixels_per_metre=20.0)
    assert plan.save(tmp_path / "plan.svg").read_text() == plan.svg
    np.testing.assert_array_equal(read_color(plan.save(tmp_path / "plan.png")), plan.image())
    with pytest.raises(InputError, match=r"must end in \.svg or \.png"):
        plan.save(tmp_path / "plan.pdf")


def test_a_plan_is_wide_enough_for_what_is_written_below_it() -> None:
    from belvedere.walkthrough import Cell

    closet = Cell("closet", (np.array([[0, 0], [1.2, 0], [1.2, 2.0], [0, 2.0]]),), 0.0, 2.6)
    drawing = draw_plan(CellGraph((closet,), ()), Mesh.concatenate([])).drawing
    labels = [item for item in drawing.items if isinstance(item, Label)]
    assert {"5 m", "door", "window"} <= {label.text for label in labels}
    assert min(label.box[0] for label in labels) >= 0.0
    assert max(label.box[2] for label in labels) <= drawing.width
    middle = next(label.at[0] for label in labels if label.text == "closet")
    assert abs(middle - drawing.width / 2) < 30  # and the room is in the middle


def test_marks_stand_on_their_storey() -> None:
    mesh = plans.two_storeys()
    graph = find_cells(mesh)
    marks = [Mark((1.0, 1.0, 1.6), (1.0, 0.0), "low"), Mark((1.0, 1.0, 4.4), (0.0, 1.0), "high")]
    drawing = draw_plan(graph, mesh, marks=marks).drawing
    x = {item.text: item.at[0] for item in drawing.items if isinstance(item, Label)}
    assert x["low"] < drawing.width / 2 < x["high"]


def test_names_are_written_as_they_are_and_never_as_markup(flat: CellGraph) -> None:
    from belvedere.walkthrough import Cell

    odd = Cell('<b>&"café"', flat.cells[0].rings, 0.0, 2.6)
    graph = CellGraph((odd, *flat.cells[1:]), ())
    root = ElementTree.fromstring(draw_plan(graph, Mesh.concatenate([])).svg)
    assert odd.name in {text.text for text in root.iter(f"{SVG}text")}


def test_a_huge_building_makes_no_huge_picture(flat: CellGraph) -> None:
    from belvedere.walkthrough import Cell

    big = Cell("hall", (np.array([[0, 0], [900.0, 0], [900, 700], [0, 700]]),), 0.0, 20.0)
    plan = draw_plan(CellGraph((big,), ()), Mesh.concatenate([]))
    assert max(plan.drawing.width, plan.drawing.height) < 8200
    with pytest.raises(InputError, match="pixels_per_metre"):
        draw_plan(flat, plans.flat(), pixels_per_metre=0.0)


def test_the_cut_of_a_box_is_its_outline() -> None:
    segments = _slice(plans.box((1, 2, 0), (3, 5, 2)), 1.2)
    length = np.hypot(*(segments[:, 1] - segments[:, 0]).T).sum()
    assert length == pytest.approx(2 * (2 + 3))
    assert segments.reshape(-1, 2).min(axis=0).tolist() == [1, 2]


@given(arrays(bool, (9, 11)))
def test_outlines_enclose_exactly_their_squares(mask: np.ndarray) -> None:
    rings = outline_rings(mask, 1.0, 0.0)
    v, u = np.mgrid[0:9, 0:11] + 0.5
    np.testing.assert_array_equal(enclosed(rings, u, v), mask)
    assert area_of(rings) == pytest.approx(mask.sum())


@pytest.mark.parametrize("turn", [0.0, 12.0, 30.0, 45.0])
def test_outlines_of_turned_rectangles_have_few_corners(turn: float) -> None:
    a = np.radians(turn)
    y, x = (np.mgrid[0:160, 0:160] + 0.5) * 0.05
    s, t = (x - 4) * np.cos(a) + (y - 4) * np.sin(a), (y - 4) * np.cos(a) - (x - 4) * np.sin(a)
    (ring,) = outline_rings((np.abs(s) < 2.52) & (np.abs(t) < 1.52), 0.05, 0.0725)
    assert len(ring) <= 16
    assert area_of((ring,)) == pytest.approx(5.04 * 3.04, rel=0.03)


def test_a_label_s_place_is_inside_and_off_the_walls() -> None:
    ring = np.array([[0, 0], [6, 0], [6, 1], [1, 1], [1, 6], [0, 6.0]])
    at, far = inner_point((ring,))
    assert enclosed((ring,), at[:1], at[1:])[0]
    assert far > 0.4
