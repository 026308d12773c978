"""The offset buffer, drawn: sub-samples between four samples, and the cells they land in."""

from __future__ import annotations

import math

import numpy as np
from pen import FAINT, INK, ORANGE, SOFT, TEAL, Pen

from belvedere import Camera
from belvedere.warp import warp_matrix, warp_points

DENSITY, SCALE = 6, 2


def lattice() -> str:
    """Left: four samples and the lattice between them. Right: the cells of the warp buffer."""
    pen = Pen(720, 360, "Sub-samples between four samples, and the cells and offsets they land in.")
    here = Camera.look_at((0, -3, 1.2), (0, 0, 1.2), fov_deg=60, width=8, height=6)
    there = Camera.look_at(
        (0.3, -1.75, 1.2), (0.2, 0, 1.1), up=(0.18, 0, 1), fov_deg=60, width=8, height=6
    )
    corner_u, corner_v = 4, 2
    slope = np.array([[0.40, 0.36], [0.42, 0.38]])  # disparity at the four samples
    part = (np.arange(DENSITY) + 0.5) / DENSITY
    t, s = np.meshgrid(part, part)  # right, down
    delta = ((1 - s) * ((1 - t) * slope[0, 0] + t * slope[0, 1])
             + s * ((1 - t) * slope[1, 0] + t * slope[1, 1]))  # fmt: skip
    matrix = warp_matrix(here, there)
    x, y, _ = warp_points(matrix, corner_u + t, corner_v + s, delta)
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    corners = [warp_points(matrix, corner_u + a, corner_v + b, slope[b, a]) for a, b in square]

    side, left, top = 190.0, 62.0, 96.0
    pen.text((left + side / 2, 36), "four samples of the reference", INK, 15, "middle", "bold")
    pen.text((left + side / 2, 56), f"{DENSITY} x {DENSITY} sub-samples between them", SOFT, 13,
             "middle")  # fmt: skip
    pen.line([(left + a * side, top + b * side) for a, b in square], INK, 1.4, closed=True)
    for a, b in zip(t.ravel(), s.ravel(), strict=True):
        pen.dot((left + a * side, top + b * side), TEAL, 3.4)
    for a, b in square:
        pen.dot((left + a * side, top + b * side), ORANGE, 7)
    pen.arrow((left + side + 24, top + side / 2), (left + side + 84, top + side / 2), INK, 2)
    pen.text((left + side + 54, top + side / 2 - 12), "warp", INK, 14, "middle")

    low_x, low_y = (float(np.round(min(c[axis] for c in corners))) for axis in (0, 1))
    columns, rows, pixel, left, top = 4, 4, 57.0, 420.0, 82.0

    def at(px: float, py: float) -> tuple[float, float]:
        return left + (px - low_x + 0.5) * pixel, top + (py - low_y + 0.5) * pixel

    pen.text((left + columns * pixel / 2, 36), "sixteen pixels of the desired view", INK, 15,
             "middle", "bold")  # fmt: skip
    pen.text((left + columns * pixel / 2, 56), f"each {SCALE} x {SCALE} cells; hit ones are filled",
             SOFT, 13, "middle")  # fmt: skip
    cell = pixel / SCALE
    hit: dict[tuple[int, int], list[tuple[float, float]]] = {}
    for one in zip(x.ravel(), y.ravel(), strict=True):
        place = at(*(float(c) for c in one))
        index = int((place[0] - left) // cell), int((place[1] - top) // cell)
        hit.setdefault(index, []).append(place)
    for a, b in hit:
        pen.box(left + a * cell, top + b * cell, cell, cell, "#1f7a8c26", "none", 0)
    for k in range(columns * SCALE + 1):
        heavy = k % SCALE == 0
        pen.line([(left + k * cell, top), (left + k * cell, top + rows * pixel)],
                 SOFT if heavy else FAINT, 1.6 if heavy else 1.1)  # fmt: skip
    for k in range(rows * SCALE + 1):
        heavy = k % SCALE == 0
        pen.line([(left, top + k * cell), (left + columns * pixel, top + k * cell)],
                 SOFT if heavy else FAINT, 1.6 if heavy else 1.1)  # fmt: skip
    pen.line([at(float(c[0]), float(c[1])) for c in corners], INK, 1.4, closed=True)
    for index, places in hit.items():
        middle = [left + (index[0] + 0.5) * cell, top + (index[1] + 0.5) * cell]
        kept = min(places, key=lambda place: math.dist(place, middle))
        for place in places:
            pen.dot(place, *((TEAL, 3.8) if place == kept else ("#b4ae9c", 2.6)))
    for c in corners:
        pen.dot(at(float(c[0]), float(c[1])), ORANGE, 6)
    kept_words = "A cell keeps one sub-sample (dark) and where in the cell it lies."
    pen.text((360, 340), kept_words, SOFT, 13, "middle")
    return pen.sheet()
