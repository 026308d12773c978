"""One picture, seen from somewhere else.

A photograph that knows the depth of each pixel is warped half a metre to the side. From the left
in `forward_warp.png`: the reference, the warp with its holes marked, and what is really there. The
holes are honest: nothing in the reference says what stands behind the sofa's arm.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import belvedere as bv
from belvedere.model import build_interior, photograph
from belvedere.scene.io import write_color
from belvedere.studio import picture_with_holes, psnr


def main(output: Path) -> None:
    house = build_interior(seed=0, rays=64)
    here = bv.Camera.look_at((1.0, 1.5, 1.6), (3.8, 3.1, 0.9), fov_deg=58, width=320, height=256)
    there = here.moved(here.center + np.array([0.25, -0.45, 0.1]))

    reference = photograph(house, here)
    frame = bv.warp(reference, there)
    truth = photograph(house, there)

    shown = picture_with_holes(frame.color, frame.coverage)
    write_color(output / "forward_warp.png", np.hstack([reference.color, shown, truth.color]))
    bv.save_frame(frame, output / "forward_warp_transparent.png", alpha=True, force=True)

    known = frame.coverage > 0
    print(f"holes: {frame.hole_fraction:.1%} of the picture")
    print(f"PSNR against what is really there, on the rest: "
          f"{psnr(frame.color, truth.color, known):.1f} dB")  # fmt: skip


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "examples-output"))
