"""Cells in sight beside cells that have pixels: ``python -m tests.visibility built-in:villa``.

Random eyes in rooms, in doorways and outdoors look anywhere; each view is drawn whole, and every
pixel says which cell it shows (`tests.oracles.ids`). A cell with a pixel that `Visibility.look`
does not find is explained:

- **missed**: a chain of portals leads there. Visibility is wrong; the command gives 1.
- **leak**: the line of sight passes from cell to cell where no portal is: a crack in the model, or
  a portal smaller than its hole.
- **threshold**: what is seen lies on the near side of the cell's own portal: outlines reach
  through it, as a flat attic's do into the well of a skylight.
- **unconfirmed**: a ray through the pixel meets something else. Surfaces that meet without sharing
  corners leave cracks between pixels, and what is nearer than a centimetre is not drawn.

Each view has a number and comes from it alone: ``--first 4711 --views 1`` repeats one.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from belvedere.model import load_lit_model
from belvedere.scene import Camera
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough import OUTSIDE, CellGraph, PrepareOptions, Visibility, load_graph
from belvedere.walkthrough.model_source import cells_of, read_source
from belvedere.walkthrough.visibility import view_cell
from tests.oracles.ids import NOWHERE, IdBuffer, Labels
from tests.oracles.sight import cells_along

HOUSES = ("built-in:bungalow", "built-in:villa")
PLACES = ("room", "doorway", "outside")
SHARES = (0.8, 0.1, 0.1)
"""Of the eyes, in each of the places."""
REASONS = ("missed", "leak", "threshold", "unconfirmed")
SIZE = (320, 256)
SKY_M = 1e4
"""Where rays end that meet nothing, in lengths."""


@dataclass(frozen=True)
class View:
    """A random look at a building."""

    number: int
    place: str
    """One of `PLACES`."""
    cell: int
    """That the eye is in."""
    camera: Camera


@dataclass
class Tally:
    """What many views came to."""

    views: int = 0
    blind: int = 0
    """Views whose every pixel shows the inside of something solid."""
    reasons: Counter[str] = field(default_factory=Counter)
    """How many cells with pixels were not found, by reason."""
    found: Counter[str] = field(default_factory=Counter)
    """Cells found, by the eye's place."""
    seen: Counter[str] = field(default_factory=Counter)
    """Cells with pixels, likewise."""
    excess: dict[str, list[float]] = field(default_factory=lambda: {p: [] for p in PLACES})
    """Of each view the cells found in vain, as a share of those with pixels."""
    nowhere: float = 0.0
    """Pixels that show no cell, in views' worth."""
    told: list[str] = field(default_factory=list)
    """A line for every cell not found."""

    def excess_percent(self, place: str | None = None) -> float:
        """Cells found in vain in a view, on average, in percent of those with pixels."""
        shares = self.excess[place] if place else [x for one in self.excess.values() for x in one]
        return 100.0 * float(np.mean(shares)) if shares else 0.0

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "views": self.views,
            **{reason: self.reasons[reason] for reason in REASONS},
            "excess_percent": round(self.excess_percent(), 2),
            "excess_percent_by_place": {p: round(self.excess_percent(p), 2) for p in PLACES},
            "cells_found_mean": round(self.found.total() / max(self.views, 1), 3),
            "cells_seen_mean": round(self.seen.total() / max(self.views, 1), 3),
            "blind": self.blind,
            "pixels_nowhere_percent": round(100.0 * self.nowhere / max(self.views, 1), 3),
        }


def opened(model: str) -> tuple[Mesh, CellGraph]:
    """The polygons and cells of ``built-in:NAME``, a model file, or a prepared folder."""
    if (Path(model) / "cells.json").is_file():
        return load_lit_model(Path(model) / "model.lit").mesh, load_graph(
            Path(model) / "cells.json"
        )
    mesh, building, _ = read_source(model, PrepareOptions())
    return mesh, cells_of(mesh, building, PrepareOptions())[0]


def random_view(graph: CellGraph, seed: int, number: int, size: tuple[int, int] = SIZE) -> View:
    """View ``number``: an eye anywhere, looking anywhere, through any lens."""
    rng = np.random.default_rng([seed, number])
    place = PLACES[int(rng.choice(len(PLACES), p=SHARES))]
    if place == "doorway" and not graph.portals:
        place = "room"
    at = {"room": in_a_room, "doorway": in_a_doorway, "outside": outdoors}[place]
    eye, cell = at(graph, rng)
    if place == "outside":  # towards the building: most of the world is not
        target, _ = in_a_room(graph, rng)
        way = (target - eye) / np.linalg.norm(target - eye)
    else:
        yaw, pitch = rng.uniform(0.0, 2.0 * np.pi), np.clip(rng.normal(0.0, 0.4), -1.5, 1.5)
        flat = np.cos(pitch)
        way = np.array([np.cos(yaw) * flat, np.sin(yaw) * flat, np.sin(pitch)])
    width, height = size
    camera = Camera.look_at(
        eye, eye + way, fov_deg=rng.uniform(25.0, 110.0), width=width, height=height
    )
    return View(number, place, cell, camera)


def in_a_room(graph: CellGraph, rng: np.random.Generator) -> tuple[np.ndarray, int]:
    """An eye in a cell, mostly at a height where people's are."""
    while True:
        cell = int(rng.integers(len(graph.cells)))
        room = graph.cells[cell]
        eye = rng.uniform(room.low, room.high)
        if rng.random() < 0.7:
            eye[2] = room.floor + rng.uniform(1.3, 1.8)
        if graph.cells_at(eye[None])[0] == cell:
            return eye, cell


def in_a_doorway(graph: CellGraph, rng: np.random.Generator) -> tuple[np.ndarray, int]:
    """An eye in a portal's rectangle, a hair to a step before or behind it."""
    while True:
        portal = graph.portals[int(rng.integers(len(graph.portals)))]
        a, b, _, d = portal.corners
        s, t = rng.uniform(0.01, 0.99, 2)
        off = 10.0 ** rng.uniform(-4.0, -0.5) * rng.choice([-1.0, 1.0])
        eye = a + s * (b - a) + t * (d - a) + off * portal.normal
        cell = view_cell(graph, eye)
        if cell in portal.cells:
            return eye, cell


def outdoors(graph: CellGraph, rng: np.random.Generator) -> tuple[np.ndarray, int]:
    """An eye around the building, from a step to a street away."""
    low = np.min([cell.low for cell in graph.cells], axis=0)
    high = np.max([cell.high for cell in graph.cells], axis=0)
    while True:
        eye = rng.uniform(low - np.array([6.0, 6.0, 0.0]), high + np.array([6.0, 6.0, 1.0]))
        if ((eye[:2] < low[:2] - 0.8) | (eye[:2] > high[:2] + 0.8)).any():
            return eye, OUTSIDE


def unfound(
    ids: IdBuffer, view: View, labels: Labels, found: set[int]
) -> Iterator[tuple[str, int, str]]:
    """Why pixels show cells that were not found: one of `REASONS`, the cell, and where to look.

    Labels that rays, or the cell's own portal, say otherwise are put right in place.
    """
    v, u = np.nonzero(~np.isin(labels, [*found, NOWHERE]))
    drawn = labels[v, u]
    cast, t = ids.cast(view.camera, u, v)
    rays, t = view.camera.rays(u, v), np.minimum(t, SKY_M)
    points = view.camera.center + t[:, None] * rays
    shown = cast.copy()
    for cell in set(cast.tolist()) - found - {NOWHERE}:
        mine = np.flatnonzero(cast == cell)
        own = [k for k, portal in enumerate(ids.graph.portals) if cell in portal.cells]
        side = ids.doorways(points[mine], own)
        shown[mine] = np.where(side == NOWHERE, cell, side)
    labels[v, u] = shown
    for cell in sorted(set(drawn.tolist())):
        if cell not in cast:
            yield "unconfirmed", cell, f"no ray meets it, {(drawn == cell).sum()} pixels"
        elif cell not in shown:
            place = points[int(np.argmax(cast == cell))].round(3).tolist()
            yield "threshold", cell, f"before its portal, at {place}"
    for cell in sorted(set(shown.tolist()) - found - {NOWHERE}):
        yield _way_to(ids, view, cell, rays[shown == cell], t[shown == cell])


def _way_to(
    ids: IdBuffer, view: View, cell: int, rays: np.ndarray, t: np.ndarray
) -> tuple[str, int, str]:
    """Whether one of some rays that end in a cell, at distances ``t``, gets there by portals."""
    eye = view.camera.center
    for ray, end in zip(rays, t, strict=True):
        if cell in cells_along(ids.graph, view.cell, eye, ray, float(end)):
            place = (eye + end * ray).round(3).tolist()
            return "missed", cell, f"portals lead to {place}, {len(t)} pixels"
    steps = eye + np.linspace(0.0, t[0], 2000)[:, None] * rays[0]
    entry = steps[int(np.argmax(ids.graph.cells_at(steps) == cell))]
    return "leak", cell, f"entered at {entry.round(3).tolist()}, {len(t)} pixels"


def compare(ids: IdBuffer, look: Visibility, view: View, tally: Tally) -> None:
    """Add one view to the tally."""

    def name(cell: int) -> str:
        return "outside" if cell == OUTSIDE else repr(ids.graph.cells[cell].name)

    labels, _ = ids.draw(view.camera)
    found = {sight.cell for sight in look.look(view.camera, view.cell)}
    for reason, cell, where in unfound(ids, view, labels, found):
        tally.reasons[reason] += 1
        tally.told.append(
            f"view {view.number}, from {name(view.cell)}: {name(cell)} {reason}: {where}"
        )
    seen = set(np.unique(labels).tolist()) - {NOWHERE}
    tally.views += 1
    tally.nowhere += float((labels == NOWHERE).mean())
    if not seen:
        tally.blind += 1
        return
    tally.found[view.place] += len(found)
    tally.seen[view.place] += len(seen)
    tally.excess[view.place].append(len(found - seen) / len(seen))


def compared(
    mesh: Mesh, graph: CellGraph, numbers: Iterable[int], seed: int = 0,
    size: tuple[int, int] = SIZE,
) -> Tally:  # fmt: skip
    """Many views of a building."""
    ids, look, tally = IdBuffer(mesh, graph), Visibility(graph), Tally()
    for number in numbers:
        compare(ids, look, random_view(graph, seed, number, size), tally)
    return tally


def main() -> int:
    """Compare; gives 1 if a cell was missed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument(
        "models", nargs="*", default=HOUSES, metavar="MODEL",
        help="built-in:NAME, a model file or a prepared folder",
    )  # fmt: skip
    parser.add_argument("--views", type=int, default=10_000, help="of each model")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--size", default="x".join(map(str, SIZE)), help="of the pictures")
    parser.add_argument("--json", action="store_true")
    told = parser.parse_args()
    width, height = (int(side) for side in told.size.split("x"))
    results: dict[str, Any] = {}
    for model in told.models:
        began = time.perf_counter()
        numbers = range(told.first, told.first + told.views)
        tally = compared(*opened(model), numbers, told.seed, (width, height))
        seconds = time.perf_counter() - began
        results[model] = tally.as_dict() | {"seconds": round(seconds, 1)}
        for line in tally.told:
            print(f"{model}: {line}", file=sys.stderr)
        if not told.json:
            reasons = ", ".join(f"{tally.reasons[reason]} {reason}" for reason in REASONS)
            excess = ", ".join(f"{tally.excess_percent(p):.1f} % {p}" for p in PLACES)
            print(
                f"{model}: {tally.views} views, {reasons}; found in vain "
                f"{tally.excess_percent():.1f} % ({excess}) ({seconds:.0f} s)"
            )
    if told.json:
        print(json.dumps(results, indent=2))
    return 1 if any(result["missed"] for result in results.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
