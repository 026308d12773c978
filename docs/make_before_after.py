"""Make "before and after": ``python docs/make_before_after.py [SCENE] [--view NAME] [-o FILE]``.

A part of one picture, magnified, from left to right: by moving points, by the best of the other
libraries that are installed, by the default, and the truth. Without a scene it is a desired view
of the built-in house, from two references; of a scene, a view that is held out.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

import belvedere as bv
from belvedere.ground.errors import MissingDependencyError
from belvedere.scene import Camera, ReferenceView
from belvedere.studio._bench_captured import held_out_view
from belvedere.studio._bench_field import FIELD
from belvedere.studio._bench_rival import shown
from belvedere.studio._bench_stations import make_stations
from belvedere.studio.difference import picture_with_holes
from belvedere.studio.evaluate import plan_hold_out
from belvedere.studio.metrics import psnr

FILE = Path(__file__).parent / "how-the-warp-works" / "before-after.png"
STATION, PART = 1, (60, 255, 110, 110)
"""Which station of the house, and the part of its picture: left, top, width, height."""
TIMES, GAP = 3, 6
Picture = npt.NDArray[np.uint8]


def of_house() -> tuple[Sequence[ReferenceView], Camera, Picture]:
    """References, desired camera and truth of a benchmark station."""
    station = make_stations(512)[STATION]
    return station.views(2), station.camera, station.color


def of_scene(path: Path, name: str | None) -> tuple[Sequence[ReferenceView], Camera, Picture]:
    """The same of a scene's view, the middle one unless named."""
    views = bv.read_views(path)
    plan = plan_hold_out(views, 1, 2)
    target, chosen = plan[views.names.index(name) if name else len(plan) // 2]
    held = held_out_view(views, target, chosen)
    return held.references, held.camera, held.color


def best_rival(
    views: Sequence[ReferenceView], camera: Camera, truth: Picture
) -> tuple[str, Picture]:
    """Name and picture of the rival with the highest PSNR on what it covers, holes in rose."""
    found: list[tuple[float, str, Picture]] = []
    for rival in FIELD:
        try:
            prepared = rival.prepare(views, 1)
        except MissingDependencyError:
            continue
        color, _, covered = shown(rival.warp(prepared, camera, 1))
        picture = picture_with_holes(color, covered.astype(np.float32))
        found.append((psnr(color, truth, covered), rival.name, picture))
    _, name, picture = max(found, key=lambda one: one[0])
    return name, picture


def main() -> None:
    """Make it into a file."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("scene", nargs="?", type=Path, help="posed pictures with depth")
    parser.add_argument("--view", help="name of the view that is held out")
    parser.add_argument(
        "--part", default=",".join(map(str, PART)), help="left,top,width,height (pixels)"
    )
    parser.add_argument("-o", "--output", type=Path, default=FILE)
    told = parser.parse_args()
    views, camera, truth = of_scene(told.scene, told.view) if told.scene else of_house()
    name, rival = best_rival(views, camera, truth)
    ours = [bv.warp(views, camera, reconstruction=one) for one in ("point", "inverse")]
    point, inverse = (picture_with_holes(frame.color, frame.coverage) for frame in ours)
    left, top, width, height = (int(word) for word in told.part.split(","))
    part = np.s_[top : top + height, left : left + width]
    panels: list[Picture] = []
    for picture in (point, rival, inverse, truth):
        large = np.kron(picture[part], np.ones((TIMES, TIMES, 1), np.uint8))
        panels += [np.full((large.shape[0], GAP, 3), 255, np.uint8), large]
    sheet = Image.fromarray(np.concatenate(panels[1:], axis=1))
    sheet.quantize(192, dither=Image.Dither.NONE).save(told.output, optimize=True)
    sys.stdout.write(f"{told.output}: point, {name}, inverse, truth\n")


if __name__ == "__main__":
    main()
