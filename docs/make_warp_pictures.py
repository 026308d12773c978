"""Make the pictures of "How the warp works": ``python docs/make_warp_pictures.py [FOLDER]``.

Photographs of the built-in house and what the library makes of them; the drawings of that page are
in ``docs/figures``. All of it is seeded, so the same pictures come out every time.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

import belvedere as bv
from belvedere.model import LitModel, build_interior, photograph
from belvedere.studio import picture_with_holes
from belvedere.warp import (
    PreparedView,
    _matte,
    epipole,
    occlusion_compatible_sheets,
    order_key,
    warp_matrix,
    warp_points,
)

FOLDER = Path(__file__).parent / "how-the-warp-works"
TINTS = ("#d6476350", "#1f6fb250", "#e0a01f50", "#3a9a5a50")
GAP = 6
Picture = npt.NDArray[np.uint8]


def kitchen_cameras() -> tuple[bv.Camera, bv.Camera]:
    """Where a picture was taken, and half a metre nearer to the table."""
    here = bv.Camera.look_at((5.75, 2.5, 1.6), (7.3, 0.9, 0.9), fov_deg=60, width=320, height=256)
    return here, here.moved(here.center + 0.55 * here.forward + [0.25, 0.1, -0.05])


def row(panels: list[Picture]) -> Picture:
    """Pictures of one height beside one another, on white."""
    white = np.full((panels[0].shape[0], GAP, 3), 255, np.uint8)
    parts = [part for panel in panels for part in (white, panel)]
    return np.concatenate(parts[1:], axis=1)


def magnify(picture: Picture, part: tuple[slice, slice], times: int) -> Picture:
    """A part of a picture, each pixel a square."""
    return np.kron(picture[part], np.ones((times, times, 1), np.uint8))


def sheets(house: LitModel) -> Picture:
    """The sheets of a reference with the epipole; then the first half of its samples, and all."""
    here, there = kitchen_cameras()
    there = there.resized(160, 128)
    view = photograph(house, here)
    eye = epipole(here, there)
    canvas = Image.fromarray(view.color)
    draw = ImageDraw.Draw(canvas, "RGBA")
    cut = occlusion_compatible_sheets(eye, here.width, here.height)
    for sheet, tint in zip(cut, TINTS, strict=False):
        u0, u1, v0, v1 = sheet.u_low, sheet.u_high, sheet.v_low, sheet.v_high
        draw.rectangle([u0, v0, u1 - 1, v1 - 1], fill=tint, outline="#ffffffc0")
        for part in (0.25, 0.5, 0.75):
            y = v0 + part * (v1 - v0)
            start, end = (u0 + 12, u1 - 12) if sheet.u_step > 0 else (u1 - 12, u0 + 12)
            draw.line([start, y, end, y], fill="white", width=2)
            neck = end - 8 * sheet.u_step
            draw.polygon([(end, y), (neck, y - 5), (neck, y + 5)], fill="white")
    x, y = (float(c) for c in eye[:2] / eye[2])
    draw.ellipse([x - 6, y - 6, x + 6, y + 6], fill="#d2741f", outline="white", width=2)

    grid = here.pixel_grid()
    order = np.argsort(order_key(there.center - here.center, here.rays(*grid)).ravel())
    x, y, _ = warp_points(warp_matrix(here, there), *grid, view.disparity)
    x, y = np.floor(x + 0.5).ravel(), np.floor(y + 0.5).ravel()
    lands = (x >= 0) & (x < there.width) & (y >= 0) & (y < there.height)
    panels = [np.asarray(canvas)]
    for samples in (order[: order.size // 2], order):
        painted = np.full((*there.size, 3), 236, np.uint8)
        for n in samples[lands[samples]]:  # what comes later covers: no depth is compared
            painted[int(y[n]), int(x[n])] = view.color.reshape(-1, 3)[n]
        panels.append(magnify(painted, np.s_[:, :], 2))
    return row(panels)


def cracks(house: LitModel) -> Picture:
    """The same pixels by three reconstructors; uncovered ones are rose."""
    here, there = kitchen_cameras()
    view = bv.prepare(photograph(house, here))
    panels = []
    for name in ("point", "splat", "inverse"):
        frame = bv.warp(view, there, reconstruction=name)
        shown = picture_with_holes(frame.color, frame.coverage)
        panels.append(magnify(shown, np.s_[0:90, 138:242], 3))
    return row(panels)


def edge_ticks(view: PreparedView, part: tuple[slice, slice], times: int) -> Picture:
    """A part of a reference, with a line wherever the edge between two samples runs."""
    links, linear = view.links(), view.linear()
    right, down = (np.empty(links.shape, np.uint8) for _ in range(2))
    _matte.find_edges(linear, view.surface(), links, 0, links.shape[0], right, down)
    canvas = Image.fromarray(magnify(view.color, part, times))
    draw = ImageDraw.Draw(canvas)
    top, left = part[0].start, part[1].start
    for v in range(part[0].start, part[0].stop):
        for u in range(part[1].start, part[1].stop):
            bits = int(links[v, u])
            x, y = (u - left + 0.5) * times, (v - top + 0.5) * times  # the sample's centre
            if not bits & 1:
                at = x + right[v, u] / 254 * times
                draw.line([at, y - times / 2, at, y + times / 2], fill="#ff3b6b", width=3)
            if not bits & 2:
                at = y + down[v, u] / 254 * times
                draw.line([x - times / 2, at, x + times / 2, at], fill="#ff3b6b", width=3)
    return np.asarray(canvas)


def silhouette(house: LitModel) -> Picture:
    """A handrail in the reference, with where its edges run; warped in two ways; the truth."""
    here = bv.Camera.look_at((6.95, 4.6, 1.6), (6.1, 7.2, 1.7), fov_deg=60, width=320, height=256)
    there = here.moved(here.center + 0.3 * here.forward + [0.0, 0.0, -0.06])
    view = bv.prepare(photograph(house, here))
    truth = photograph(house, there)
    u, v, times = 150, 66, 14
    x, y, _ = there.project(here.unproject(u, v, view.disparity[v, u]))
    u2, v2 = round(float(x)), round(float(y))
    part, moved = (np.s_[b - 8 : b + 8, a - 9 : a + 9] for a, b in ((u, v), (u2, v2)))
    panels = [magnify(view.color, part, times), edge_ticks(view, part, times)]
    for name in ("mesh", "inverse"):
        frame = bv.warp(view, there, reconstruction=name)
        panels.append(magnify(picture_with_holes(frame.color, frame.coverage), moved, times))
    return row([*panels, magnify(truth.color, moved, times)])


PICTURES = {"sheets.png": sheets, "cracks.png": cracks, "silhouette.png": silhouette}


def main(folder: Path) -> None:
    """Make them into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    house = build_interior(seed=0, rays=64)
    for name, make in PICTURES.items():
        Image.fromarray(make(house)).quantize(192, dither=Image.Dither.NONE).save(
            folder / name, optimize=True
        )


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
