"""A walk through a building whose rooms are pictures until one is near.

A furnished flat is built and lit, its rooms and doors are drawn as a plan, and six photographs with
depth are taken on each side of the door between them. The same is done for a model of your own by
`belvedere prepare house.glb -o house`. `walk.png` shows three moments of a walk: whatever is seen
through the door is two photographs, warped to the eye, until the visitor has come near.
`walk_plan.png` shows where the three were. `walk.mp4` is the walk. `walk_figures.png` makes the
paper's figures anew, at the place where a single reference leaves most holes (rose). Above: one
reference (A), two (B). Below: the polygons themselves (C), and the signed difference of B and C
(D), where grey is no difference.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import belvedere as bv
from belvedere.scene.io import VideoWriter, write_color
from belvedere.studio.walk_report import paper_figures
from belvedere.studio.walkthrough import frames_along, walk
from belvedere.walkthrough import (
    Mark,
    PlacementOptions,
    PrepareOptions,
    WalkOptions,
    Walkthrough,
    draw_plan,
    prepare,
)

MOMENTS = (2, 40, 94)
"""Frames of the walk that `walk.png` shows."""


def main(output: Path) -> None:
    quick = PrepareOptions(rays=32, references=PlacementOptions(count=6, texels=192))
    made = prepare("built-in:flat", output / "flat", options=quick, force=True)
    print(f"{', '.join(made.cells)}: {made.portals} portals, {made.references} references")

    scene = bv.open_scene(output / "flat")
    assert isinstance(scene, Walkthrough)
    assert scene.path is not None
    cameras = frames_along(scene.path, 120, (320, 256))
    moments = []
    with VideoWriter(output / "walk.mp4", 320, 256, fps=12, crf=31, force=True) as video:

        def observe(index: int, frame: bv.Frame, _: bv.Frame | None) -> None:
            video.write(frame.color)
            if index in MOMENTS:
                moments.append(frame.color.copy())

        two = walk(scene, cameras, observe=observe)
    gap = np.full((256, 8, 3), 255, np.uint8)
    write_color(output / "walk.png", np.hstack([moments[0], gap, moments[1], gap, moments[2]]))
    marks = [
        Mark(tuple(cameras[k].center), tuple(cameras[k].forward[:2]), f"{number}")
        for number, k in enumerate(MOMENTS, 1)
    ]
    plan = draw_plan(scene.graph, scene.model.mesh, marks=marks)
    write_color(output / "walk_plan.png", plan.image())

    one = walk(scene, cameras, WalkOptions(mode="one"))
    holes = {result.mode: [frame.holes for frame in result.frames] for result in (one, two)}
    worst = int(np.argmax(holes["one"]))
    for mode, share in holes.items():
        print(f"holes, {mode:3}: {share[worst]:.2%} at the worst place, {np.mean(share):.2%} mean")
    figures = list(paper_figures(scene, cameras, worst).values())
    write_color(
        output / "walk_figures.png", np.vstack([np.hstack(figures[:2]), np.hstack(figures[2:])])
    )


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "examples-output"))
