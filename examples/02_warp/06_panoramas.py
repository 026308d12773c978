"""Panoramas are references too, and panoramas are what one can ask for.

Two spheres, photographed 0.8 m apart in the hall with their depth, know it all round: whatever
enters a view from beside, behind or above hides what it should. `panoramas.png` shows the two
references above; below them a whole panorama from between them, warped, and two planar views from
the same place: backwards, where the references have their seam, and straight up through their
poles. Holes are magenta: what neither sphere saw. A cylinder does the same without the poles.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import belvedere as bv
from belvedere.model import build_interior, photograph
from belvedere.scene.io import write_color
from belvedere.studio import picture_with_holes, psnr

EYES = (6.3, 5.25, 1.6), (5.6, 5.6, 1.5)
AHEAD = (-1.0, 0.55, 0.0)
SHOWN = (512, 256)


def smaller(color: np.ndarray) -> np.ndarray:
    """A panorama as tall as the other pictures: every n-th pixel of it."""
    step = color.shape[0] // SHOWN[1]
    return color[step // 2 :: step, step // 2 :: step][: SHOWN[1], : SHOWN[0]]


def main(output: Path) -> None:
    house = build_interior(seed=0, rays=64)
    spheres = [bv.SphereCamera.at(eye, AHEAD, width=1536) for eye in EYES]
    views = [photograph(house, sphere, samples=2) for sphere in spheres]

    between = np.mean(EYES, axis=0)
    cameras = {
        "panorama": bv.SphereCamera.at(between, AHEAD, width=1024),
        "backwards": bv.Camera.look_at(
            between, between - AHEAD, fov_deg=60, width=SHOWN[1], height=SHOWN[1]
        ),
        "straight up": bv.Camera.look_at(
            between,
            between + np.array((0, 0, 1)),
            AHEAD,
            fov_deg=75,
            width=SHOWN[1],
            height=SHOWN[1],
        ),
    }
    pictures = []
    for name, camera in cameras.items():
        frame = bv.warp(views, camera)
        truth = photograph(house, camera, samples=2)
        known = frame.coverage > 0
        print(f"{name}: {psnr(frame.color, truth.color, known):.1f} dB, "
              f"{frame.hole_fraction:.1%} holes")  # fmt: skip
        shown = picture_with_holes(frame.color, frame.coverage)
        pictures.append(smaller(shown) if name == "panorama" else shown)

    references = np.hstack([smaller(view.color) for view in views])
    write_color(output / "panoramas.png", np.vstack([references, np.hstack(pictures)]))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "examples-output"))
