"""The house of rooms and floors, and the way from a file to a frame."""

from __future__ import annotations

from pen import BLUE, GREEN, INK, ORANGE, PANEL, SOFT, TEAL, Pen

FLOORS: tuple[tuple[int, tuple[tuple[str, str], ...]], ...] = (
    (5, (("cli", "parse, show, save: no algorithm lives here"),)),
    (4, (("studio", "open, check, walk, evaluate, report"),)),
    (
        3,
        (
            ("walkthrough", "cells, portals, frames"),
            ("to come", "layered images, relief, hulls"),
        ),
    ),
    (
        2,
        (("warp", "equation, order, reconstructors"), ("model", "ray casting, the built-in house")),
    ),
    (1, (("scene", "cameras, views, frames, paths; scene/io reads and writes them"),)),
    (0, (("ground", "checks, errors, colour, threads, the kernel decorator"),)),
)


def floors() -> str:
    """Rooms on floors, the roof on top."""
    pen = Pen(720, 470, "The house: rooms on floors; a room imports only from the floors below it.")
    left, right, high = 74.0, 614.0, 58.0
    pen.line([(left - 26, 92), ((left + right) / 2, 26), (right + 26, 92)], INK, 2.4, fill=PANEL)
    pen.text(((left + right) / 2, 74), "belvedere", INK, 19, "middle", "bold")
    y = 92.0
    tints = {"cli": "#e8d9c5", "studio": "#dfe6d5", "walkthrough": "#dde0ee", "warp": "#d4e3ea",
             "model": "#d4e3ea",
             "scene": "#eadfd4", "ground": "#dedbd2"}  # fmt: skip
    for floor, rooms in FLOORS:
        width = (right - left) / len(rooms)
        for k, (name, words) in enumerate(rooms):
            x = left + k * width
            pen.box(x, y, width, high, tints.get(name, "#ffffff"), INK, 0)
            future = name not in tints
            pen.text((x + width / 2, y + 25), name, SOFT if future else INK, 16, "middle", "bold")
            pen.text((x + width / 2, y + 45), words, SOFT, 12.5, "middle")
        pen.text((left - 16, y + 36), str(floor), SOFT, 18, "end", "bold")
        y += high
    pen.line([(30, y), (690, y)], INK, 2.4)
    pen.arrow((right + 46, 150), (right + 46, y - 8), ORANGE, 2.2, head=10)
    for k, word in enumerate(("imports", "only", "downwards")):
        pen.text((right + 34, 106 + 15 * k), word, ORANGE, 12, "start")
    return pen.sheet()


def flow() -> str:
    """From files to a frame."""
    pen = Pen(720, 400, "From files to a frame: read, choose, warp, merge, show.")
    boxes = {
        "files": (20, 40, 150, 64, "files", "pictures, depth, poses", "#eadfd4"),
        "views": (210, 40, 150, 64, "ViewSet", "lazy, named, posed", "#eadfd4"),
        "scene": (400, 40, 150, 64, "DepthViews", "a Scene", "#d4e3ea"),
        "choose": (400, 160, 150, 64, "choose", "best references", "#d4e3ea"),
        "warp": (210, 160, 150, 64, "warp", "each in bands", "#d4e3ea"),
        "merge": (20, 160, 150, 64, "merge", "by disparity", "#d4e3ea"),
        "frame": (20, 290, 178, 72, "Frame", "colour, disparity, coverage", "#eadfd4"),
        "out": (270, 290, 190, 72, "picture, video, report", "save_frame, render_path", "#dfe6d5"),
        "camera": (590, 160, 110, 64, "Camera", "the desired view", "#eadfd4"),
        "check": (590, 40, 110, 64, "check", "do views agree?", "#dfe6d5"),
    }
    for x, y, width, height, name, words, tint in boxes.values():
        pen.box(x, y, width, height, tint, SOFT)
        pen.text((x + width / 2, y + height / 2 - 3), name, INK, 15, "middle", "bold")
        pen.text((x + width / 2, y + height / 2 + 17), words, SOFT, 11.5, "middle")
    pen.arrow((170, 72), (208, 72), TEAL)
    pen.text((189, 30), "read_views: foreign conventions end here", TEAL, 12, "start")
    pen.arrow((360, 72), (398, 72), TEAL)
    pen.arrow((550, 72), (588, 72), GREEN, dash="5 4")
    pen.arrow((475, 104), (475, 158), TEAL)
    pen.text((484, 136), "render(camera)", TEAL, 12)
    pen.arrow((590, 192), (552, 192), BLUE)
    pen.arrow((400, 192), (362, 192), TEAL)
    pen.arrow((210, 192), (172, 192), TEAL)
    pen.arrow((95, 224), (95, 288), TEAL)
    pen.arrow((198, 326), (268, 326), TEAL)
    pen.line([(95, 362), (95, 384), (520, 384), (520, 258), (285, 258)], ORANGE, 1.8, "5 4")
    pen.arrow((285, 258), (285, 226), ORANGE)
    pen.text((534, 330), "as_view(): a frame is a", ORANGE, 12)
    pen.text((534, 346), "reference view again", ORANGE, 12)
    return pen.sheet()
