"""Six ways to make a continuous picture out of moved samples.

Samples that have moved no longer lie on a grid. `point` paints the pixel each one lands in and
leaves cracks where the picture grows; `splat` paints squares as large as the sample has grown;
`gaussian` weights an ellipse round each, as its surface stretches it, over the pixels it holds;
`mesh` draws the quads between neighbouring samples, cut at depth edges; `offset` finds what is
visible on a finer grid that remembers where in its cell each sample fell, and filters that;
`inverse` (the default) finds surfaces first and then looks their colours up backwards, with edges
that cover pixels in part. `reconstructors.png` has them in this order, magnified from one warp
toward the stair; below each, its signed difference from the truth, where grey means right.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import belvedere as bv
from belvedere.model import build_interior, photograph
from belvedere.scene.io import write_color
from belvedere.studio import picture_with_holes, psnr, signed_difference
from belvedere.warp import RECONSTRUCTIONS


def main(output: Path) -> None:
    house = build_interior(seed=0, rays=64)
    here = bv.Camera.look_at((6.95, 4.6, 1.6), (6.1, 7.2, 1.7), fov_deg=60, width=320, height=256)
    there = here.moved(here.center + 0.55 * here.forward + [-0.12, 0.0, 0.05])
    reference = bv.prepare(photograph(house, here))  # edges and tiles, once for all six
    truth = photograph(house, there)

    frames = {name: bv.warp(reference, there, reconstruction=name) for name in RECONSTRUCTIONS}
    common = np.all([frame.coverage > 0 for frame in frames.values()], axis=0)
    part = np.s_[70:198, 96:252]
    tops, bottoms = [], []
    for name, frame in frames.items():
        holes = picture_with_holes(frame.color, frame.coverage)
        off = signed_difference(frame.color, truth.color, frame.coverage > 0)
        tops.append(np.kron(holes[part], np.ones((2, 2, 1), np.uint8)))
        bottoms.append(np.kron(off[part], np.ones((2, 2, 1), np.uint8)))
        quality = psnr(frame.color, truth.color, common)
        print(f"{name:8} holes {frame.hole_fraction:5.1%}   PSNR {quality:.1f} dB on common pixels")
    write_color(output / "reconstructors.png", np.vstack([np.hstack(tops), np.hstack(bottoms)]))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "examples-output"))
