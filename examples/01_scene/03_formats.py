"""One capture in four layouts, and back.

The same three views are written in every layout that belvedere writes, with its own axes, pose
direction, pixel centres and depth unit, and read back. The cameras come back to rounding, the
depth to half a step of its 16 bits (COLMAP keeps floats). `formats.png` shows the capture: colour
on top, depth below, near light and far dark.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import belvedere as bv
from belvedere.model import build_interior, photograph
from belvedere.scene.io import WRITERS, read_views, write_color, write_views
from belvedere.studio import disparity_picture


def main(output: Path) -> None:
    house = build_interior(seed=0, rays=64)
    cameras = house.reference_cameras(24, width=208, height=166)
    cameras = [cameras[index] for index in (0, 6, 20)]
    views = bv.ViewSet.of([photograph(house, camera) for camera in cameras])

    print(f"{'layout':14} {'eye off by':>12} {'depth off by':>14}   files")
    for layout in WRITERS:
        folder = output / f"capture-{layout}"
        write_views(views, folder, layout, force=True)
        again = read_views(folder)
        eye = max(
            float(np.linalg.norm(a.center - b.center))
            for a, b in zip(views.cameras, again.cameras, strict=True)
        )
        depth = max(
            float(np.max(np.abs(1 / view.disparity[near] - 1 / back.disparity[near])))
            for view, back in zip(views, again, strict=True)
            for near in [(view.disparity > 0.01) & (back.disparity > 0.01)]  # not the sky
        )
        names = ", ".join(sorted(path.name for path in folder.iterdir())[:4])
        print(f"{layout:14} {eye * 1000:9.6f} mm {depth * 1000:11.4f} mm   {names}")

    color = np.hstack([view.color for view in views])
    depth = np.hstack([disparity_picture(view.disparity) for view in views])
    write_color(output / "formats.png", np.vstack([color, depth]))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "examples-output"))
