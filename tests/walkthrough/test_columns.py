from __future__ import annotations

import numpy as np
import pytest

from belvedere.ground.errors import InputError, SceneError
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough import columns as module
from belvedere.walkthrough.columns import Columns, Grid, Layers, link_layers, standing_layers
from tests.oracles import floors
from tests.walkthrough import plans


def triangle(corners: np.ndarray) -> Mesh:
    uv = np.zeros((1, 3, 2), np.float32)
    return Mesh(corners, np.array([[0, 1, 2]]), np.zeros(1, np.int32), uv, (plans.PAINT,))


@pytest.mark.parametrize("seed", range(8))
def test_a_triangle_fills_the_columns_it_touches_as_high_as_it_is_there(seed: int) -> None:
    rng = np.random.default_rng(seed)
    corners = rng.uniform(0.0, 2.0, (3, 3)) * [1.0, 1.0, 3.0]
    corners[1:, 0] += 1.2
    columns = Columns.of_mesh(triangle(corners), 0.1)
    local = (corners - columns.grid.origin)[None]
    truth = floors.sampled_spans(local, 0.1, rng, 20000)
    assert len(truth) > 20
    for (i, j), (low, high) in truth.items():
        column = j * columns.grid.nx + i
        a, b = columns.first[column : column + 2]
        assert b == a + 1
        assert columns.low[a] <= low + 1e-9
        assert columns.high[a] >= high - 1e-9
    filled = np.flatnonzero(np.diff(columns.first))
    total = sum(high - low for low, high in truth.values())
    assert len(filled) < 1.2 * len(truth) + 5  # samples miss some corners of columns, not many
    assert (columns.high - columns.low).sum() < 1.25 * total + 0.2


def test_a_table_leaves_a_gap_and_slits_are_closed() -> None:
    parts = [
        plans.slab((0, 0), (2, 2), 0.0),
        plans.box((0.5, 0.5, 0.70), (1.5, 1.5, 0.74)),
        plans.box((0.5, 0.5, 0.755), (1.5, 1.5, 0.80)),
    ]
    columns = Columns.of_mesh(Mesh.concatenate(parts), 0.05)
    i, j = (int((1.0 - columns.grid.origin[k]) / 0.05) for k in (0, 1))
    a, b = columns.first[j * columns.grid.nx + i : j * columns.grid.nx + i + 2]
    np.testing.assert_allclose(columns.low[a:b] - 0.2, [-0.2, 0.0, 0.70, 0.74, 0.80], atol=1e-9)


def test_the_order_of_the_faces_changes_nothing() -> None:
    mesh, rng = plans.flat(), np.random.default_rng(5)
    order = rng.permutation(len(mesh.faces))
    mixed = Mesh(
        mesh.vertices, mesh.faces[order], mesh.material_index[order], mesh.uv[order], mesh.materials
    )
    one, two = Columns.of_mesh(mesh), Columns.of_mesh(mixed)
    for name in ("first", "low", "high", "up"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))


@pytest.mark.parametrize("seed", range(4))
def test_distances_are_those_to_the_nearest_wall(seed: int) -> None:
    rng = np.random.default_rng(seed)
    free = rng.random((30, 40)) > 0.06
    column = np.flatnonzero(free.ravel()).astype(np.int32)
    grid = Grid((0.0, 0.0, 0.0), 0.05, 40, 30)
    level, sky = np.zeros(len(column)), np.full(len(column), 3.0)
    layers = link_layers(grid, column, level, sky, 0.25, 1.9)
    far = np.full(free.shape, np.nan)
    far.ravel()[column] = layers.distance()
    truth = floors.nearest_wall(free, 0.05)
    # vectors handed on by neighbours may miss the very nearest by a hair (Danielsson 1980)
    np.testing.assert_array_less(truth[free] - 1e-9, far[free])
    assert np.abs(far - truth)[free].max() < 0.05 * 0.3
    assert (np.abs(far - truth)[free] < 1e-9).mean() > 0.99


@pytest.mark.parametrize("seed", range(4))
def test_labels_are_the_connected_sets(seed: int) -> None:
    rng = np.random.default_rng(seed)
    column = np.flatnonzero(rng.random(600) > 0.45).astype(np.int32)
    height = rng.choice([0.0, 0.2, 0.9], len(column))
    grid = Grid((0.0, 0.0, 0.0), 0.05, 30, 20)
    layers = link_layers(grid, column, height, height + 2.5, 0.25, 1.9)
    label, count = layers.label()
    sets = floors.connected(layers.link)
    assert count == len(sets)
    assert {frozenset(np.flatnonzero(label == k).tolist()) for k in range(count)} == set(sets)


def test_links_lead_both_ways_and_respect_head_and_step() -> None:
    grid = Grid((0.0, 0.0, 0.0), 0.05, 4, 1)
    column = np.arange(4, dtype=np.int32)
    floor = np.array([0.0, 0.2, 0.5, 0.5])
    ceiling = np.array([2.5, 2.5, 2.6, 2.3])
    layers = link_layers(grid, column, floor, ceiling, 0.25, 1.9)
    assert layers.link[:, 1].tolist() == [1, -1, -1, -1]
    assert layers.link[:, 0].tolist() == [-1, 0, -1, -1]


def test_places_taken_keep_only_links_among_themselves() -> None:
    columns = Columns.of_mesh(plans.two_rooms())
    layers, up = standing_layers(columns, 1.9, 0.25)
    assert up.mean() > 0.95
    keep = layers.centers[:, 0] < 3.0
    some = layers.take(keep)
    assert isinstance(some, Layers)
    assert some.link.max() < keep.sum()
    back = np.flatnonzero(keep)
    for d in range(4):
        linked = some.link[:, d] >= 0
        np.testing.assert_array_equal(back[some.link[linked, d]], layers.link[back[linked], d])


def scaled(factor: float) -> Mesh:
    mesh = plans.two_rooms()
    return Mesh(mesh.vertices * factor, mesh.faces, mesh.material_index, mesh.uv, mesh.materials)


def test_what_is_no_building_in_metres_is_refused() -> None:
    with pytest.raises(SceneError, match="in millimetres"):
        Columns.of_mesh(scaled(1000.0))
    with pytest.raises(SceneError, match="too small"):
        Columns.of_mesh(scaled(0.001))
    with pytest.raises(SceneError, match="no faces"):
        Columns.of_mesh(Mesh.concatenate([]))
    with pytest.raises(SceneError, match=r"Give a spacing of 0\.\d+ m"):
        Columns.of_mesh(scaled(120.0), 0.05)
    with pytest.raises(InputError, match="spacing"):
        Columns.of_mesh(plans.two_rooms(), 0.0)


def test_more_spans_than_memory_holds_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_SPANS", 1000)
    with pytest.raises(SceneError, match=r"more than 1,000: give a larger spacing"):
        Columns.of_mesh(plans.two_rooms())
