from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from belvedere.ground.errors import FileFormatError, MissingFileError, OutputError
from belvedere.walkthrough import CellGraph, find_cells, load_graph, save_graph
from tests.walkthrough import plans


@pytest.fixture(scope="module")
def graph() -> CellGraph:
    return find_cells(plans.flat())


def test_it_comes_back_as_it_was(graph: CellGraph, tmp_path: Path) -> None:
    again = load_graph(save_graph(graph, tmp_path / "cells.json"))
    for a, b in zip(graph.cells, again.cells, strict=True):
        assert (a.name, a.storey) == (b.name, b.storey)
        assert (b.floor, b.ceiling) == pytest.approx((a.floor, a.ceiling), abs=1e-4)
        for p, q in zip(a.rings, b.rings, strict=True):
            np.testing.assert_allclose(q, p, atol=1e-4)
    for a, b in zip(graph.portals, again.portals, strict=True):
        assert (a.name, a.kind, a.cells) == (b.name, b.kind, b.cells)
        np.testing.assert_allclose(b.corners, a.corners, atol=1e-4)
    first = (tmp_path / "cells.json").read_bytes()
    assert save_graph(again, tmp_path / "again.json").read_bytes() == first
    with pytest.raises(OutputError, match="exists"):
        save_graph(graph, tmp_path / "cells.json", force=False)


def test_a_line_is_a_cell_or_a_portal(graph: CellGraph, tmp_path: Path) -> None:
    lines = save_graph(graph, tmp_path / "cells.json").read_text().splitlines()
    assert len([line for line in lines if '"rings"' in line]) == len(graph.cells)
    assert len([line for line in lines if '"corners"' in line]) == len(graph.portals)


def test_people_may_count_cells_and_wind_corners_as_they_like(
    graph: CellGraph, tmp_path: Path
) -> None:
    file = save_graph(graph, tmp_path / "cells.json")
    data = json.loads(file.read_text())
    names = [cell["name"] for cell in data["cells"]]
    for portal in data["portals"]:
        portal["corners"].reverse()
        portal["cells"] = [-1 if c is None else names.index(c) for c in portal["cells"]]
    file.write_text(json.dumps(data))
    for a, b in zip(graph.portals, load_graph(file).portals, strict=True):
        assert a.cells == b.cells
        np.testing.assert_allclose(b.normal, a.normal, atol=1e-3)


BREAKS: list[tuple[list[Any], Any, str]] = [
    (["kind"], "scene", 'kind is not "belvedere cells"'),
    (["version"], 2, "version is 2, this belvedere reads 1"),
    (["unit"], "millimetre", 'unit must be "metre"'),
    (["cells"], [], "cells is empty"),
    (["cells"], {}, "cells is missing or no list"),
    (["cells", 1], 5, r"cells\[1\] is 5, expected an object"),
    (["cells", 1, "name"], None, r"cells\[1\]\.name is None, expected text"),
    (["portals", 1, "name"], "door 1", "several portals are called 'door 1'"),
    (["cells", 1, "floor"], "low", r"cells\[1\]\.floor is 'low', expected a finite number"),
    (["cells", 1, "ceiling"], -3, r"cells\[1\]\.ceiling is -3"),
    (["cells", 1, "storey"], 0.5, r"cells\[1\]\.storey is 0.5"),
    (["cells", 1, "rings"], [], r"cells\[1\]\.rings is missing"),
    (["cells", 1, "rings", 0], [[0, 0], [1, 1]], r"cells\[1\]\.rings\[0\] has shape \(2, 2\)"),
    (["cells", 1, "rings", 0], "square", r"cells\[1\]\.rings\[0\] is no list of points"),
    (["portals", 0, "kind"], "gate", r"portals\[0\]\.kind is 'gate'"),
    (["portals", 0, "cells"], ["room 1"], r"portals\[0\]\.cells is \['room 1'\]"),
    (["portals", 0, "cells"], ["room 1", "cellar"], r"portals\[0\]\.cells\[1\] is 'cellar'"),
    (["portals", 0, "cells"], ["room 1", "room 1"], r"portals\[0\]\.cells are the same"),
    (["portals", 0, "cells"], [None, None], r"portals\[0\]\.cells are the same"),
    (["portals", 0, "corners"], [[0, 0, 0]] * 4, r"portals\[0\]: Portal .* is a line"),
    (["portals", 0, "corners", 0], [0, 0], r"portals\[0\]\.corners is no list of points"),
    (["portals", 0, "corners"], [[0, 0, 0]] * 5, r"portals\[0\]\.corners are 5, expected 4"),
    (["portals", 0, "corners", 0, 0], float("nan"), r"portals\[0\]\.corners holds numbers"),
]


@pytest.mark.parametrize(("keys", "value", "words"), BREAKS)
def test_mistakes_are_named_by_their_key(
    graph: CellGraph, tmp_path: Path, keys: list[Any], value: Any, words: str
) -> None:
    file = save_graph(graph, tmp_path / "cells.json")
    data = json.loads(file.read_text())
    place = data
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = value
    file.write_text(json.dumps(data))
    with pytest.raises(FileFormatError, match=words) as caught:
        load_graph(file)
    assert "cells.json" in str(caught.value)


def test_files_that_are_none_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "cells.json"
    with pytest.raises(MissingFileError, match="no such file"):
        load_graph(file)
    for content in (b"", b"{", b"\xff\xfe\x00", b"[1]", b'{"kind": 3}', b"[" * 100000):
        file.write_bytes(content)
        with pytest.raises(FileFormatError, match=r"cells\.json"):
            load_graph(file)
