"""A frame is a reference view again.

What comes out of a warp has a camera, colour and disparity, so it can be warped once more. Where
nothing hides, going from A to B to C is going from A to C. `chained_warps.png`, from the left:
A warped to B, that frame warped on to C, A warped to C directly, and the difference of the last
two around grey. The way round loses a little sharpness, and what B could not see.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import belvedere as bv
from belvedere.model import build_interior, photograph
from belvedere.scene.io import write_color
from belvedere.studio import picture_with_holes, psnr, signed_difference


def main(output: Path) -> None:
    house = build_interior(seed=0, rays=64)
    a = bv.Camera.look_at((4.9, 5.7, 1.6), (1.4, 6.4, 1.5), fov_deg=60, width=260, height=208)
    b = a.moved(a.center + np.array([-0.3, 0.25, 0.1]))
    c = a.moved(a.center + np.array([-0.6, 0.0, 0.0]))

    view = photograph(house, a)
    over_b = bv.warp(view, b)
    round_trip = bv.warp(over_b.as_view(), c)
    direct = bv.warp(view, c)

    known = (round_trip.coverage > 0) & (direct.coverage > 0)
    pictures = [
        picture_with_holes(frame.color, frame.coverage) for frame in (over_b, round_trip, direct)
    ]
    pictures.append(signed_difference(round_trip.color, direct.color, known))
    write_color(output / "chained_warps.png", np.hstack(pictures))

    near = known & (direct.disparity > 0.01) & (round_trip.disparity > 0.01)  # not the sky
    depth = np.abs(1 / round_trip.disparity[near] - 1 / direct.disparity[near])
    print(f"A to B to C against A to C: {psnr(round_trip.color, direct.color, known):.1f} dB")
    print(f"median difference in depth: {1000 * np.median(depth):.2f} mm")
    print(f"holes: {round_trip.hole_fraction:.1%} by way of B, {direct.hole_fraction:.1%} directly")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "examples-output"))
