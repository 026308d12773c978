"""References where they remove most holes."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from belvedere.ground.errors import InputError
from belvedere.walkthrough import (
    PlacementOptions,
    Side,
    SwitchOptions,
    candidate_eyes,
    choose_eyes,
    measure_holes,
    semicircle_eyes,
    visitor_eyes,
)


@pytest.fixture(scope="module")
def measured(house, graph):
    side, options = Side(graph.portals[0], 0, 0.0), PlacementOptions()
    visitors = visitor_eyes(side, graph.cells[0], options, SwitchOptions(), 12)
    fixed = semicircle_eyes(side, options)
    candidates = np.concatenate([candidate_eyes(side, options), fixed])
    return side, measure_holes(house.caster, side, candidates, visitors, rays=12)


def test_a_visitor_who_stands_where_a_reference_does_sees_no_hole(house, graph) -> None:
    side, options = Side(graph.portals[0], 0, 0.0), PlacementOptions()
    visitors = visitor_eyes(side, graph.cells[0], options, SwitchOptions(), 6)
    holes = measure_holes(house.caster, side, visitors, visitors, rays=10)
    own = holes.seen[np.arange(6), np.arange(6)]
    assert own.mean() > 0.995  # a shadow ray may graze an edge that the sight ray passed


def test_what_a_reference_sees_agrees_with_its_picture(house, graph) -> None:
    """A point is seen exactly where the reference's own depth there is the point's."""
    from belvedere.walkthrough import reference_camera, take_reference

    side, options = Side(graph.portals[0], 0, 0.0), PlacementOptions(texels=512)
    visitor = visitor_eyes(side, graph.cells[0], options, SwitchOptions(), 1)
    eye = semicircle_eyes(side, options)[1]
    rays = 16
    seen = measure_holes(house.caster, side, eye[None], visitor, rays=rays).seen[0, 0]
    camera, _ = reference_camera(side, eye, options)
    view = take_reference(house, side, eye, options)
    step = (np.arange(rays) + 0.5) / rays
    s, t = np.meshgrid(step, step)
    on = side.corner + s.reshape(-1, 1) * side.right + t.reshape(-1, 1) * side.down
    hit = house.caster.cast(on, on - visitor[0])
    agreed = total = 0
    for point, way, far, claimed in zip(on, on - visitor[0], hit.t, seen, strict=True):
        if not np.isfinite(far):
            continue
        u, v, delta = camera.project((point + far * way)[None])
        i, j = round(float(u[0])), round(float(v[0]))
        inside = 0 <= i < camera.width and 0 <= j < camera.height
        shown = inside and abs(view.disparity[j, i] / delta[0] - 1.0) < 0.02
        agreed += bool(shown) == bool(claimed)
        total += 1
    assert total > 100
    assert agreed >= 0.97 * total


def test_each_reference_added_leaves_fewer_holes(measured) -> None:
    _, holes = measured
    chosen, left = choose_eyes(holes, bound=0.0, budget=5)
    assert len(set(chosen)) == len(chosen) >= 3
    assert all(a > b for a, b in pairwise(left))
    assert left[-1] == pytest.approx(holes.mean(chosen))


def test_four_placed_by_error_leave_no_more_holes_than_six_on_the_arc(measured) -> None:
    _, holes = measured
    arc = list(range(len(holes.candidates) - 6, len(holes.candidates)))
    free = replace(holes, candidates=holes.candidates[:-6], seen=holes.seen[:-6])
    _, left = choose_eyes(free, bound=0.0, budget=4)
    assert left[-1] <= holes.mean(arc)


def test_it_stops_at_the_bound(measured) -> None:
    _, holes = measured
    _, all_left = choose_eyes(holes, bound=0.0, budget=5)
    _, left = choose_eyes(holes, bound=all_left[1], budget=5)
    assert len(left) == 2


def test_visitors_stand_in_the_cell_before_the_portal_and_not_too_near(graph) -> None:
    side, switch = Side(graph.portals[1], 2, 0.0), SwitchOptions()
    eyes = visitor_eyes(side, graph.cells[2], PlacementOptions(), switch, 25)
    assert len(eyes) == 25
    assert graph.cells[2].contains(eyes).all()
    assert ((eyes - side.portal.center) @ side.normal > 0).all()
    assert (np.linalg.norm((eyes - side.portal.center)[:, :2], axis=1) > 0.75).all()


def test_budgets_of_no_use_are_refused(measured) -> None:
    with pytest.raises(InputError, match="budget"):
        choose_eyes(measured[1], budget=0)
    with pytest.raises(InputError, match="bound"):
        choose_eyes(measured[1], bound=2.0)
