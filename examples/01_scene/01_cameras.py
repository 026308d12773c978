"""Four kinds of camera in one house.

Every camera has the same interface: `rays(u, v)` and `project(points)`, with disparity between
them, so the same house can be photographed by all of them. `cameras.png` shows, from the top: a
planar camera and an off-axis one whose picture is exactly a doorway (a portal); a full
equirectangular panorama and a cylinder of the hall; and two orthographic cameras that draw what
architects draw: a plan, cut 2.05 m above the floor, and a section through the stair.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from belvedere import Camera, CylinderCamera, OrthographicCamera, SphereCamera
from belvedere.model import build_interior, photograph
from belvedere.scene.io import write_color


def main(output: Path) -> None:
    house = build_interior(seed=0, rays=64)
    hall = (5.2, 6.0, 1.6)

    planar = Camera.look_at((0.9, 1.2, 1.6), (4.4, 2.7, 1.1), fov_deg=62, width=400, height=320)
    doorway = Camera.through_rectangle(
        (3.4, 1.3, 1.6), (5.2, 2.95, 2.2), right=(0, -1.45, 0), down=(0, 0, -2.2),
        width=224, height=320,
    )  # fmt: skip
    sphere = SphereCamera.at(hall, forward=(-1, 0.4, 0), width=640)
    cylinder = CylinderCamera.at(hall, forward=(-1, 0.4, 0), fov_deg=75, width=624, height=160)
    plan = OrthographicCamera.look_at(
        (4.6, 3.9, 2.05), (4.6, 3.9, 0), up=(0, 1, 0), view_height=8.2, width=312, height=270
    )
    section = OrthographicCamera.along(
        (0, 1, 0), center=(4.6, 5.2, 2.45), view_height=8.2 * 170 / 270, width=312, height=170
    )
    pictures = {
        camera_name: photograph(house, camera).color
        for camera_name, camera in {
            "planar": planar,
            "doorway": doorway,
            "sphere": sphere.resized(624, 312),
            "cylinder": cylinder,
            "plan": plan,
            "section": section,
        }.items()
    }
    paper = np.full((270, 312, 3), 255, np.uint8)
    paper[50:220] = pictures["section"]
    rows = [
        np.hstack([pictures["planar"], pictures["doorway"]]),
        pictures["sphere"],
        pictures["cylinder"],
        np.hstack([pictures["plan"], paper]),
    ]
    gap = np.full((6, 624, 3), 255, np.uint8)
    sheet = np.vstack([part for row in rows for part in (row, gap)][:-1])
    write_color(output / "cameras.png", sheet)

    corner = np.array([5.2, 2.95, 2.2])  # of the opening between living room and kitchen
    u, v, delta = doorway.project(corner)
    print(f"the opening's corner is the upper left edge of its picture: u = {u:.1f}, v = {v:.1f}")
    print(f"and {1 / delta:.2f} m deep; unproject gives {doorway.unproject(u, v, delta).round(6)}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "examples-output"))
