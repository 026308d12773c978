"""Wrong depth scale, or wrong pose? Ask the views.

A correct capture is read in seven wrong ways, one mistake at a time, and belvedere is asked what
is the matter. Neighbouring views are warped into each other under every reading of the numbers;
the one that makes them agree is named, with the option that mends it.
`wrong_conventions.png` shows what each mistake does to the picture: one neighbour warped to the
place of another, first as it should be, then for each mistake in the order printed.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import belvedere as bv
from belvedere.model import build_interior, photograph
from belvedere.scene.conventions import Conventions
from belvedere.scene.io import read_views, write_color, write_views
from belvedere.studio import picture_with_holes
from belvedere.studio.conventions import check_conventions

MISTAKES: dict[str, dict[str, str | float]] = {
    "depth taken for metres": {"depth_scale": 1.0},
    "depth divided by 5000": {"depth_scale": 1 / 5000},
    "depth along the ray": {"depth_kind": "ray"},
    "disparity for depth": {"depth_kind": "disparity", "depth_scale": 0.0002},
    "world-to-camera": {"pose": "world_to_camera"},
    "OpenGL's axes": {"axes": "opengl"},
    "pixel centres at .5": {"pixel_centers": "half"},
}


def main(output: Path) -> None:
    house = build_interior(seed=0, rays=64)
    cameras = house.reference_cameras(48, width=320, height=256)[28:40]
    truth = bv.ViewSet.of([photograph(house, camera) for camera in cameras])
    folder = output / "capture"
    write_views(truth, folder, "cameras.json", force=True)

    right = Conventions(depth_scale=0.001)
    tiles: list[np.ndarray] = []
    for name, wrong in {"nothing": {}, **MISTAKES}.items():
        read_as = replace(right, **wrong)
        views = read_views(folder, read_as)
        report = check_conventions(views, read_as)
        print(f"{name}:\n    {report.line}")
        frame = bv.warp(views[5], views.cameras[6], reconstruction="splat")
        tiles.append(picture_with_holes(frame.color, frame.coverage)[::2, ::2])
    write_color(
        output / "wrong_conventions.png", np.vstack([np.hstack(tiles[:4]), np.hstack(tiles[4:])])
    )


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "examples-output"))
