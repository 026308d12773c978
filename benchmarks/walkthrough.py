"""A walk through the one-storey house: frame times, holes, popping, scaling.

    python -m benchmarks.walkthrough FOLDER [--frames N] [--only NAME] [--json]

FOLDER keeps what is prepared: the house of 528,000 polygons, and of ten times as many. Times that
are compared are measured in turns, frame by frame, in one process. Parts:

    modes      culling, textures, one and two along the recorded path
    worst      holes of one and of two, where one has most
    popping    two with the prepared references against flat textures with 120 a side
    count      6 references a side against 60: the same frame time
    heavy      ten times the polygons, drawn, or shown by pictures from inside
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from belvedere.scene import Camera, ReferenceView
from belvedere.studio.walkthrough import frames_along, variation, walk
from belvedere.walkthrough import (
    PlacementOptions,
    PortalImages,
    PrepareOptions,
    Side,
    Walker,
    WalkOptions,
    Walkthrough,
    prepare,
    semicircle_eyes,
    sides_of,
    take_reference,
)
from belvedere.walkthrough.portal_images import eyes_apart

SIZE = (640, 512)
FRAMES = 520
PARTS = ("modes", "worst", "popping", "count", "heavy")


class TakenWhenAsked(Sequence[ReferenceView]):
    """References of one side on an arc; each is photographed when it is first asked for."""

    def __init__(self, scene: Walkthrough, side: Side, count: int) -> None:
        self.options = PlacementOptions(count=count)
        self.scene, self.side, self.eyes = scene, side, semicircle_eyes(side, self.options)
        self._taken: dict[int, ReferenceView] = {}

    def __len__(self) -> int:
        return len(self.eyes)

    def __getitem__(self, index: Any) -> Any:
        if index not in self._taken:
            self._taken[index] = take_reference(
                self.scene.model, self.side, self.eyes[index], self.options
            )
        return self._taken[index]


class ArcImages(PortalImages):
    """`PortalImages` whose references are `TakenWhenAsked`."""

    def nearest(self, eye: Any, count: int) -> list[int]:
        references: Any = self.references
        apart = eyes_apart(self.side.portal.center, references.eyes, eye)
        return [int(k) for k in np.argsort(apart, kind="stable")[:count]]


class Arcs(Mapping[tuple[int, int], PortalImages]):
    """So many references on an arc for each side of each portal."""

    def __init__(self, scene: Walkthrough, count: int) -> None:
        self._images: dict[tuple[int, int], PortalImages] = {}
        for k, portal in enumerate(scene.graph.portals):
            for side in sides_of(portal, scene.graph.cells):
                references: Any = TakenWhenAsked(scene, side, count)
                self._images[k, side.cell] = ArcImages(side, references)

    def __getitem__(self, key: tuple[int, int]) -> PortalImages:
        return self._images[key]

    def __iter__(self) -> Iterator[tuple[int, int]]:
        return iter(self._images)

    def __len__(self) -> int:
        return len(self._images)


def in_turns(walkers: Mapping[str, Walker], cameras: Sequence[Camera]) -> dict[str, dict[str, Any]]:
    """Frame times of several walkers, each frame by one after the other; the path is walked twice
    and only the second time counts, when all references are at hand.
    """
    times: dict[str, list[float]] = {}
    stages: dict[str, list[list[float]]] = {}
    for _ in range(2):
        times, stages = {name: [] for name in walkers}, {name: [] for name in walkers}
        for walker in walkers.values():
            walker.cut()
        for camera in cameras:
            for name, walker in walkers.items():
                walker.frame(camera)
                one = walker.statistics
                times[name].append(one.ms)
                stages[name].append(
                    [one.look_ms, one.draw_ms, one.warp_ms, one.compose_ms, one.fill_ms]
                )
    return {
        name: {
            "median": round(float(np.median(ms)), 2),
            "p99": round(float(np.percentile(ms, 99)), 2),
            "cv": round(variation(np.array(ms)), 3),
            "stages": dict(
                zip(("look", "draw", "warp", "compose", "fill"),
                    np.round(np.mean(stages[name], axis=0), 2).tolist(), strict=True)
            ),
            "times": ms,
        }
        for name, ms in times.items()
    }  # fmt: skip


def modes(scene: Walkthrough, cameras: list[Camera]) -> dict[str, Any]:
    """Every mode, its times against those of culling and its quality."""
    found: dict[str, Any] = {}
    for mode in ("textures", "one", "two"):
        found[mode] = walk(scene, cameras, WalkOptions(mode=mode), compare=True).as_dict()
    return found


def worst(scene: Walkthrough, cameras: list[Camera]) -> dict[str, Any]:
    """Holes at the position where one reference leaves most, and on average."""
    holes = {}
    for mode in ("one", "two"):
        walker = scene.walker(WalkOptions(mode=mode))
        shares = []
        for camera in cameras:
            walker.frame(camera)
            shares.append(100 * walker.statistics.holes)
        holes[mode] = np.array(shares)
    at = int(np.argmax(holes["one"]))
    return {
        "frame": at,
        "one_percent": round(float(holes["one"][at]), 3),
        "two_percent": round(float(holes["two"][at]), 3),
        "ratio": round(float(holes["two"][at] / holes["one"][at]), 3),
        "mean_percent": {mode: round(float(share.mean()), 3) for mode, share in holes.items()},
    }


def popping(scene: Walkthrough, cameras: list[Camera], count: int = 120) -> dict[str, Any]:
    """The largest change between frames that no motion explains."""
    textured = replace(scene, images=Arcs(scene, count))
    two = walk(scene, cameras, WalkOptions(mode="two"), compare=True).compared
    flat = walk_without_warming(textured, cameras, WalkOptions(mode="textures"))
    assert two is not None
    return {"two": round(two.popping, 3), f"textures_{count}": round(flat, 3)}


def walk_without_warming(scene: Walkthrough, cameras: list[Camera], options: WalkOptions) -> float:
    """Popping of a walk, of which only the references on its way are taken."""
    from belvedere.studio.walkthrough import Popping

    ours, truth, meter = scene.walker(options), scene.walker(WalkOptions(mode="culling")), Popping()
    for camera in cameras:
        meter.add(ours.frame(camera), truth.frame(camera))
    return meter.largest


def count(scene: Walkthrough, cameras: list[Camera]) -> dict[str, Any]:
    """Frame times with 6 and with 60 references a side."""
    walkers = {
        str(n): replace(scene, images=Arcs(scene, n)).walker(WalkOptions(mode="two"))
        for n in (6, 60)
    }
    found = in_turns(walkers, cameras)
    ratio = np.median(np.array(found["60"]["times"]) / np.array(found["6"]["times"]))
    return found | {"ratio": round(float(ratio), 3)}


def heavy(scene: Walkthrough, more: Walkthrough, cameras: list[Camera]) -> dict[str, Any]:
    """What ten times the polygons cost."""
    walkers: dict[str, Walker] = {}
    for name, one in (("x1", scene), ("x10", more)):
        walkers[f"culling {name}"] = one.walker(WalkOptions(mode="culling"))
        walkers[f"two {name}, polygons"] = one.walker(WalkOptions(mode="two", cells="polygons"))
        walkers[f"two {name}, pictures"] = one.walker(WalkOptions(mode="two"))
    found = in_turns(walkers, cameras)
    ratios = {
        kind: round(found[kind.format("x10")]["median"] / found[kind.format("x1")]["median"], 3)
        for kind in ("culling {}", "two {}, polygons", "two {}, pictures")
    }
    return found | {"x10 over x1": {kind.replace(" {}", ""): r for kind, r in ratios.items()}}


def prepared(folder: Path, detail: int) -> Walkthrough:
    """The house, prepared if it is not yet; every cell with pictures from inside."""
    from belvedere.walkthrough import CellImageOptions

    place = folder / f"bungalow-x{detail}"
    if not place.is_dir():
        options = PrepareOptions(detail=detail, inside=CellImageOptions(polygons=0))
        prepare("built-in:bungalow", place, options=options)
    return Walkthrough.open(place)


def plain(scene: Walkthrough) -> Walkthrough:
    """The scene as it is prepared by default: its cells are light enough to be drawn."""
    return replace(scene, cell_images={})


def main() -> None:
    """Measure, and print a line for each part."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="keeps what is prepared")
    parser.add_argument("--frames", type=int, default=FRAMES)
    parser.add_argument("--only", choices=PARTS, action="append")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    chosen = given.only or PARTS
    scene = prepared(given.folder, 1)
    assert scene.path is not None
    cameras = frames_along(scene.path, given.frames, SIZE)
    found: dict[str, Any] = {}
    for part in chosen:
        if part == "heavy":
            found[part] = heavy(scene, prepared(given.folder, 10), cameras)
        else:
            found[part] = globals()[part](plain(scene), cameras)
        if not given.json:
            print(f"{part}:")
            for key, value in found[part].items():
                shown = value
                if isinstance(value, dict):
                    shown = {k: v for k, v in value.items() if k != "times"}
                print(f"  {key}: {shown}", flush=True)
    if given.json:
        print(json.dumps(found))


if __name__ == "__main__":
    main()
