"""Hiding without depths: occlusion-compatible order.

McMillan's observation: if the samples of a picture are painted in the right order, near ones land
over far ones with no comparison of depths at all. The order follows from the epipole alone, the
place in the reference where the desired eye is seen. `occlusion_order.png`, from the left: the
reference, cut at the epipole into sheets, with arrows along the order of painting (the eye moves
forward here, so every sheet runs toward the epipole); the samples painted in this order, into a
picture of half the size so that they leave few gaps; the same samples in the reverse order, where
the far covers the near. The order holds for points that land on one another: among the many that
only share a pixel here, a very few still come out wrong.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import belvedere as bv
from belvedere.model import build_interior, photograph
from belvedere.scene.io import write_color
from belvedere.warp import epipole, occlusion_compatible_sheets, warp_matrix, warp_points


def main(output: Path) -> None:
    house = build_interior(seed=0, rays=64)
    here = bv.Camera.look_at((5.75, 2.5, 1.6), (7.3, 0.9, 0.9), fov_deg=60, width=320, height=256)
    there = here.moved(here.center + 0.6 * here.forward + [0.15, 0.08, -0.08]).resized(160, 128)
    view = photograph(house, here)

    eye = epipole(here, there)
    sheets = occlusion_compatible_sheets(eye, here.width, here.height)
    canvas = Image.fromarray(view.color)
    draw = ImageDraw.Draw(canvas, "RGBA")
    order: list[np.ndarray] = []
    for sheet, tint in zip(sheets, ("#d6476345", "#1f6fb245", "#e0a01f45", "#3a9a5a45"),
                           strict=False):  # fmt: skip
        u0, u1, v0, v1 = sheet.u_low, sheet.u_high, sheet.v_low, sheet.v_high
        draw.rectangle([u0, v0, u1 - 1, v1 - 1], fill=tint, outline="#ffffffc0")
        for step in (0.25, 0.5, 0.75):
            y = v0 + step * (v1 - v0)
            ends = (u0 + 14, u1 - 14) if sheet.u_step > 0 else (u1 - 14, u0 + 14)
            draw.line([ends[0], y, ends[1], y], fill="white", width=2)
            tip, back = ends[1], ends[1] - 8 * sheet.u_step
            draw.polygon([(tip, y), (back, y - 5), (back, y + 5)], fill="white")
        rows = np.arange(v0, v1)[:: sheet.v_step]
        columns = np.arange(u0, u1)[:: sheet.u_step]
        order.append((rows[:, None] * here.width + columns).ravel())

    first_to_last = np.concatenate(order)
    u, v = here.pixel_grid()
    x, y, delta = warp_points(warp_matrix(here, there), u, v, view.disparity)
    x, y, delta = np.floor(x + 0.5).ravel(), np.floor(y + 0.5).ravel(), delta.ravel()

    def paint(indices: np.ndarray) -> np.ndarray:
        """Which sample each pixel shows: NumPy assigns in order, so the last painted stays."""
        inside = (x >= 0) & (x < there.width) & (y >= 0) & (y < there.height)
        indices = indices[inside[indices]]
        seen = np.full(there.size, -1)
        seen[y[indices].astype(int), x[indices].astype(int)] = indices
        return seen

    nearest = bv.warp(view, there, reconstruction="point", visibility="zbuffer").disparity
    panels = [np.asarray(canvas)]
    print(f"epipole at {(eye[:2] / eye[2]).round(1)}, {len(sheets)} sheets")
    for name, indices in (("in order", first_to_last), ("in reverse", first_to_last[::-1])):
        seen = paint(indices)
        color = np.where(seen[..., None] < 0, 0, view.color.reshape(-1, 3)[seen]).astype(np.uint8)
        panels.append(np.kron(color, np.ones((2, 2, 1), np.uint8)))
        hidden = (seen >= 0) & (delta[seen] < 0.97 * nearest)
        print(f"painted {name}: {hidden.mean():.2%} of the pixels show what should be hidden")
    write_color(output / "occlusion_order.png", np.hstack(panels))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "examples-output"))
