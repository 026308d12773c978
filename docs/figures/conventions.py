"""The conventions, drawn: frames, pixel centres, disparity."""

from __future__ import annotations

import numpy as np
from pen import BLUE, FAINT, GREEN, INK, ORANGE, PANEL, RED, SOFT, TEAL, Pen, Point

from belvedere import Camera


def frames() -> str:
    """World axes and camera axes, drawn through the library's own camera."""
    pen = Pen(720, 400, "World: x, y on the ground, z up. Camera: x right, y down, z forward.")
    onlooker = Camera.look_at((3.4, -4.4, 2.9), (1.05, 1.0, 0.85), fov_deg=37,
                              width=720, height=400)  # fmt: skip

    def at(*point: float) -> Point:
        u, v, _ = onlooker.project(point)
        return float(u), float(v)

    for k in range(-1, 5):
        pen.line([at(k, -1, 0), at(k, 4, 0)], FAINT, 1)
        pen.line([at(-1, k, 0), at(4, k, 0)], FAINT, 1)
    for end, color, word in (
        ((1, 0, 0), RED, "x"),
        ((0, 1, 0), GREEN, "y"),
        ((0, 0, 1), BLUE, "z"),
    ):
        pen.arrow(at(0, 0, 0), at(*end), color, 2.6, head=11)
        x, y = at(*(1.13 * np.array(end)))
        pen.text((x, y + 4), word, color, 17, "middle", "bold")
    x, y = at(0, 0, 0)
    pen.text((x - 12, y + 24), "world", INK, 15, "middle", "bold")
    pen.text((x - 12, y + 42), "metres, +z up", SOFT, 13, "middle")

    eye = np.array([3.5, 1.5, 1.0])
    camera = Camera.look_at(eye, (1.2, 2.5, 0.95), fov_deg=42, width=8, height=6)
    depth = 1.55
    corners = [camera.unproject(u, v, 1 / depth) for u, v in
               ((-0.5, -0.5), (7.5, -0.5), (7.5, 5.5), (-0.5, 5.5))]  # fmt: skip
    pen.line([at(*c) for c in corners], TEAL, 1.6, fill="#1f7a8c22", closed=True)
    for corner in corners:
        pen.line([at(*eye), at(*corner)], TEAL, 1.1, "4 4")
    pose = camera.camera_to_world
    for axis, color, word in ((0, RED, "x  right"), (1, GREEN, "y  down"), (2, BLUE, "z  forward")):
        end = eye + 0.62 * pose[:3, axis]
        pen.arrow(at(*eye), at(*end), color, 2.6, head=10)
        x, y = at(*(eye + 0.72 * pose[:3, axis]))
        side = {0: (4, -4, "start"), 1: (10, 6, "start"), 2: (-4, -10, "end")}[axis]
        pen.text((x + side[0], y + side[1]), word, color, 15, side[2], "bold")
    pen.dot(at(*eye), INK, 4)
    x, y = at(*eye)
    pen.text((x + 12, y + 22), "camera", INK, 15, "start", "bold")
    x, y = at(*corners[0])
    pen.dot((x, y), TEAL, 4)
    pen.text((x - 10, y + 4), "pixel (0, 0) lies here", TEAL, 13, "end")
    pen.text((20, 32), "camera_to_world (4 x 4) maps camera axes to world axes:", INK, 14)
    pen.text((20, 52), "X_world = camera_to_world @ (x, y, z, 1)", SOFT, 13, mono=True)
    return pen.sheet()


def pixels() -> str:
    """Pixel centres at integers, edges at halves, arrays [v, u]."""
    pen = Pen(720, 330, "Pixel centres lie at integers; the picture's edge lies at -0.5.")
    side, left, top = 58.0, 110.0, 74.0
    columns, rows = 5, 3
    pen.box(left, top, columns * side, rows * side, "#ffffff", INK, 0)
    for k in range(1, columns):
        pen.line([(left + k * side, top), (left + k * side, top + rows * side)], FAINT, 1.2)
    for k in range(1, rows):
        pen.line([(left, top + k * side), (left + columns * side, top + k * side)], FAINT, 1.2)
    chosen_u, chosen_v = 3, 1
    pen.box(left + chosen_u * side, top + chosen_v * side, side, side, "#d2741f33", ORANGE, 0)
    for v in range(rows):
        for u in range(columns):
            place = left + (u + 0.5) * side, top + (v + 0.5) * side
            pen.dot(place, ORANGE if (u, v) == (chosen_u, chosen_v) else SOFT, 3)
            pen.text((place[0], place[1] + 19), f"{u}, {v}", SOFT, 12, "middle")
    y, x = top - 26, left - 30
    pen.arrow((left + 0.5 * side, y), (left + columns * side + 26, y), RED, 2)
    pen.text((left + columns * side + 34, y + 5), "u", RED, 17, weight="bold")
    pen.arrow((x, top + 0.5 * side), (x, top + rows * side + 26), GREEN, 2)
    pen.text((x, top + rows * side + 46), "v", GREEN, 17, "middle", "bold")
    for k in range(columns):
        pen.text((left + (k + 0.5) * side, y - 9), str(k), RED, 13, "middle")
    for k in range(rows):
        pen.text((x - 11, top + (k + 0.5) * side + 5), str(k), GREEN, 13, "end")
    pen.text((left - 6, top + rows * side + 22), "(-0.5, 2.5)", SOFT, 12, "start")
    pen.dot((left, top + rows * side), INK, 3)
    pen.dot((left, top), INK, 3)
    pen.text((left - 6, top - 6), "(-0.5, -0.5)", SOFT, 12, "end")

    column = 452.0
    lines = [
        ("image[v, u]", "arrays are rows first"),
        ("image[1, 3]", "is the orange pixel: u = 3, v = 1"),
        ("(3.0, 1.0)", "is its centre"),
        ("-0.5 ... width - 0.5", "from edge to edge"),
        ("cx = (width - 1) / 2", "puts the axis in the middle"),
    ]
    for k, (code, words) in enumerate(lines):
        pen.text((column, top + 12 + 46 * k), code, INK, 14, mono=True)
        pen.text((column, top + 31 + 46 * k), words, SOFT, 13)
    return pen.sheet()


def disparity() -> str:
    """Disparity along a ray; depth and range beside it."""
    pen = Pen(720, 380, "Disparity is one over depth: 1 at the image plane, 0 infinitely far.")
    eye = np.array([70.0, 250.0])
    unit = 150.0
    pen.arrow((eye[0], eye[1]), (700, eye[1]), SOFT, 1.4, head=9)
    pen.text((698, eye[1] + 20), "Z, depth along the axis (metres)", SOFT, 13, "end")
    plane = eye[0] + unit
    pen.line([(plane, 60), (plane, 330)], TEAL, 2.4)
    pen.text((plane, 46), "image plane, at unit depth", TEAL, 14, "middle", "bold")
    for k in range(6):
        pen.line([(plane - 4, 85 + 45 * k), (plane + 4, 85 + 45 * k)], TEAL, 1.2)
    slope = -0.27

    def on_ray(depth: float) -> Point:
        return float(eye[0] + unit * depth), float(eye[1] + unit * depth * slope)

    pen.arrow((float(eye[0]), float(eye[1])), on_ray(4.12), INK, 2)
    for depth, label in ((1.0, "1"), (2.0, "1/2"), (4.0, "1/4")):
        x, y = on_ray(depth)
        pen.line([(x, y), (x, eye[1])], FAINT, 1.2, "3 4")
        pen.dot((x, y), ORANGE, 5)
        pen.text((x - 8, y - 12), f"disparity {label}", ORANGE, 14, "end", "bold")
        pen.text((x, eye[1] + 20), f"Z = {depth:g}" if depth < 4 else "", SOFT, 13, "middle")
    pen.text((on_ray(4.0)[0] - 40, eye[1] - 12), "Z = 4", SOFT, 13, "middle")
    pen.text((700, on_ray(4.1)[1] - 34), "to infinity: disparity 0", INK, 13, "end")
    pen.dot((float(eye[0]), float(eye[1])), INK, 5)
    pen.text((eye[0], eye[1] + 24), "eye C", INK, 14, "middle", "bold")
    down = 15.0
    pen.line([(float(eye[0]) + 8, float(eye[1]) + down - 2), (on_ray(4)[0], on_ray(4)[1] + down)],
             BLUE, 1.4, "6 4")  # fmt: skip
    pen.text((on_ray(2.5)[0] + 8, on_ray(2.5)[1] + 40), "range: the ray's length", BLUE, 13)
    pen.box(20, 340, 680, 30, PANEL)
    words = "X = C + (1 / disparity) * P @ (u, v, 1); 0: infinitely far, NaN: no sample"
    pen.text((360, 360), words, INK, 14, "middle", mono=True)
    return pen.sheet()
