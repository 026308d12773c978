"""Camera paths: through the rooms, round a table, and a gentle wobble.

A path is a list of keyframes with times and a smooth movement between them; it is saved as JSON
that people can write by hand. `paths.png` draws three presets over a plan of the house: `through`
(orange) visits the reference views in turn, `orbit` (red) circles the kitchen table, `wobble`
(blue) is the closed loop about three neighbouring views that shows parallax where the views show
the scene best. `wobble.mp4` is that loop, warped from the views.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import belvedere as bv
from belvedere.model import build_interior, photograph
from belvedere.scene import orbit, through, wobble
from belvedere.scene.io import VideoWriter, write_color


def main(output: Path) -> None:
    house = build_interior(seed=0, rays=64)
    references = house.reference_cameras(24, width=320, height=256)
    middle = bv.Camera.look_at((2.6, 0.9, 1.5), (3.6, 3.5, 0.8), fov_deg=55, width=320, height=256)
    aside = middle.camera_to_world[:3, 0]  # the camera's x axis, to the right
    views = [photograph(house, middle.moved(middle.center + 0.45 * k * aside)) for k in (-1, 0, 1)]

    paths = {
        "#e07b1f": through(references, duration=10.0),
        "#c2315a": orbit((7.05, 1.12, 0.9), radius=0.95, rise=0.7, width=320, height=256),
        "#1f6fb2": wobble([view.camera for view in views]),
    }
    plan = bv.OrthographicCamera.look_at(
        (4.6, 3.9, 2.05), (4.6, 3.9, 0), up=(0, 1, 0), view_height=8.2, width=624, height=540
    )
    picture = photograph(house, plan).color
    canvas = Image.fromarray((0.45 * picture + 0.55 * 255).astype(np.uint8))
    draw = ImageDraw.Draw(canvas)
    for color, path in paths.items():
        for camera in path.cameras(40):
            u, v, _ = plan.project(np.stack([camera.center, camera.center + 0.3 * camera.forward]))
            draw.line([u[0], v[0], u[1], v[1]], fill=color, width=2)
            draw.ellipse([u[0] - 3, v[0] - 3, u[0] + 3, v[0] + 3], fill=color)
    write_color(output / "paths.png", np.asarray(canvas))

    loop = paths["#1f6fb2"]
    loop.save(output / "wobble.json")
    assert bv.CameraPath.load(output / "wobble.json").duration == loop.duration
    scene = bv.DepthViews(views, references=3, fill="background")
    with VideoWriter(output / "wobble.mp4", 320, 256, fps=12, crf=26, force=True) as video:
        for camera in loop.cameras_at(fps=12):
            video.write(scene.render(camera).color)
    print(f"wobble.mp4: {video.frames} frames, one round of {loop.duration:g} s")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "examples-output"))
