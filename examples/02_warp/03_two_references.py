"""Two references fill each other's holes.

What hides behind the chair in one picture stands free in the other. `two_references.png`, top
row: the desired view warped from the left reference, from the right one, and from both. Bottom
row: the disparity that comes with the picture, what is left of holes, and those holes filled
from the background beside them, which the frame marks in a mask of its own: invented pixels are
never passed off as seen ones.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import belvedere as bv
from belvedere.model import build_interior, photograph
from belvedere.scene.io import write_color
from belvedere.studio import coverage_picture, disparity_picture, picture_with_holes


def main(output: Path) -> None:
    house = build_interior(seed=0, rays=64)
    desired = bv.Camera.look_at(
        (5.75, 2.5, 1.6), (7.3, 0.9, 0.8), fov_deg=58, width=320, height=256
    )
    aside = 0.35 * desired.matrix[:, 0] / np.linalg.norm(desired.matrix[:, 0])  # to the right
    left, right = (photograph(house, desired.moved(desired.center + s * aside)) for s in (-1, 1))

    one, other, both = (bv.warp(views, desired) for views in (left, right, [left, right]))
    filled = bv.warp([left, right], desired, fill="background")

    top = [picture_with_holes(frame.color, frame.coverage) for frame in (one, other, both)]
    bottom = [
        disparity_picture(both.disparity),
        coverage_picture(both.color, both.coverage),
        filled.color,
    ]
    write_color(output / "two_references.png", np.vstack([np.hstack(top), np.hstack(bottom)]))
    assert filled.filled is not None
    for name, frame in (("left", one), ("right", other), ("both", both)):
        print(f"holes from {name:5}: {frame.hole_fraction:.2%}")
    print(f"invented when filled: {filled.filled.mean():.2%}, coverage still says 0 there")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "examples-output"))
