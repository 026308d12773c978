"""What stands still: walls with openings, windows, doors, a stair with thin balusters."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Literal

import numpy as np

from belvedere.model.charts import Builder, Rect
from belvedere.model.shapes import box, tube

Side = Literal["north", "south", "east", "west"]
"""The side of a room on which a wall stands; its front looks into the room."""

Palette = dict[str, int]
"""Material indices by name."""


def wall(
    b: Builder,
    side: Side,
    at: float,
    span: tuple[float, float],
    rise: tuple[float, float],
    material: int,
    openings: Sequence[Rect] = (),
    scale: float = 0.5,
) -> None:
    """The face of a wall that a room sees.

    Args:
        b: where to add it.
        side: which wall of the room.
        at: its y (north, south) or x (east, west).
        span: lowest and highest x or y along it.
        rise: lowest and highest z.
        material: index.
        openings: (low, z0, high, z1) holes in world coordinates.
        scale: texture repeats per metre.
    """
    low, high = span
    forward = side in ("north", "west")  # so that along x up looks into the room
    ends = (low, high) if forward else (high, low)
    if side in ("north", "south"):
        flat = [(ends[0], at), (ends[1], at), (ends[1], at), (ends[0], at)]
    else:
        flat = [(at, ends[0]), (at, ends[1]), (at, ends[1]), (at, ends[0])]
    heights = (rise[0], rise[0], rise[1], rise[1])
    corners = np.array([(x, y, z) for (x, y), z in zip(flat, heights, strict=True)])

    def local(opening: Rect) -> Rect:
        a, z0, c, z1 = opening
        if not forward:
            a, c = high + low - c, high + low - a
        return a - low, z0 - rise[0], c - low, z1 - rise[0]

    holes = [local(o) for o in openings]
    b.sheet(corners, material, scale, cells_around(high - low, rise[1] - rise[0], holes), holes)


def cells_around(length: float, height: float, holes: Sequence[Rect]) -> list[Rect]:
    """A rectangle around its holes, as columns cut into rectangles."""
    cuts = sorted({0.0, length, *(h[0] for h in holes), *(h[2] for h in holes)})
    cells: list[Rect] = []
    for left, right in pairwise(cuts):
        middle, floor = (left + right) / 2.0, 0.0
        for hole in sorted((h for h in holes if h[0] < middle < h[2]), key=lambda h: h[1]):
            if hole[1] > floor + 1e-9:
                cells.append((left, floor, right, hole[1]))
            floor = hole[3]
        if floor < height - 1e-9:
            cells.append((left, floor, right, height))
    return cells


def floor(b: Builder, area: Rect, z: float, material: int, scale: float) -> None:
    """A level floor seen from above; the texture lies in world coordinates."""
    x0, y0, x1, y1 = area
    corners = np.array([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])
    shift = (x0 * scale, y0 * scale)
    b.sheet(corners, material, scale, [(0.0, 0.0, x1 - x0, y1 - y0)], uv_shift=shift)


def ceiling(b: Builder, area: Rect, z: float, material: int) -> None:
    """A level ceiling seen from below."""
    x0, y0, x1, y1 = area
    corners = np.array([[x0, y1, z], [x1, y1, z], [x1, y0, z], [x0, y0, z]])
    b.sheet(corners, material, 0.5, [(0.0, 0.0, x1 - x0, y1 - y0)])


def _slab(
    axis: str, a: float, c: float, low: float, high: float, z0: float, z1: float
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Box corners for a thing spanning a..c along a wall, low..high through it."""
    if axis == "x":
        return (a, low, z0), (c, high, z1)
    return (low, a, z0), (high, c, z1)


def window(
    b: Builder,
    m: Palette,
    side: Side,
    at: float,
    opening: Rect,
    panes: tuple[int, int],
    thickness: float = 0.30,
) -> None:
    """Lining, frame, thin glazing bars and a sill board for an opening in an outer wall.

    Args:
        b: where to add it.
        m: materials ``frame`` and ``trim``.
        side: which wall.
        at: the inner face's y or x.
        opening: (low, z0, high, z1).
        panes: how many across and up.
        thickness: of the wall, metres; it extends outwards from the inner face.
    """
    axis = "x" if side in ("north", "south") else "y"
    out = 1.0 if side in ("north", "east") else -1.0
    low, z0, high, z1 = opening
    depth = sorted((at, at + out * thickness))
    through = "-y +y" if axis == "x" else "-x +x"
    box(b, *_slab(axis, low, high, depth[0], depth[1], z0, z1), m["trim"], 0.5, through, True)
    middle = at + out * thickness * 0.62

    def bar(a0: float, a1: float, h0: float, h1: float, thick: float) -> None:
        box(b, *_slab(axis, a0, a1, middle - thick / 2, middle + thick / 2, h0, h1), m["frame"])

    rim = 0.055
    bar(low, low + rim, z0, z1, 0.06)
    bar(high - rim, high, z0, z1, 0.06)
    bar(low + rim, high - rim, z0, z0 + rim, 0.06)
    bar(low + rim, high - rim, z1 - rim, z1, 0.06)
    across, up = panes
    for k in range(1, across):
        half = 0.030 if across % 2 == 0 and k == across // 2 else 0.011
        x = low + (high - low) * k / across
        bar(x - half, x + half, z0 + rim, z1 - rim, 0.04)
    for k in range(1, up):
        z = z0 + (z1 - z0) * k / up
        bar(low + rim, high - rim, z - 0.011, z + 0.011, 0.034)
    board = sorted((at - out * 0.05, at + out * thickness * 0.5))
    box(b, *_slab(axis, low, high, board[0], board[1], z0 - 0.035, z0 + 0.004), m["frame"])
    front = sorted((at - out * 0.05, at))
    for a, c in ((low - 0.06, low), (high, high + 0.06)):
        box(b, *_slab(axis, a, c, front[0], front[1], z0 - 0.035, z0 + 0.004), m["frame"])


def doorway(
    b: Builder,
    m: Palette,
    axis: Literal["x", "y"],
    faces: tuple[float, float],
    opening: tuple[float, float],
    height: float,
) -> None:
    """Lining, threshold and casings of an opening in an inner wall.

    Args:
        b: where to add it.
        m: materials ``trim`` and ``oak``.
        axis: along which the wall runs.
        faces: the wall's two faces across that axis.
        opening: low and high along the axis.
        height: of the opening, metres.
    """
    low, high = opening
    through = "-y +y" if axis == "x" else "-x +x"
    sides = f"{through} -z"
    corners = _slab(axis, low, high, faces[0], faces[1], 0.0, height)
    box(b, *corners, m["trim"], 0.5, sides, True)
    keep_floor = "-x +x -y +y +z"
    box(b, *corners, m["oak"], 1.0, keep_floor, True)
    for face, out in ((faces[0], -1.0), (faces[1], 1.0)):
        depth = sorted((face, face + out * 0.02))
        for a, c, z0, z1 in (
            (low - 0.09, low, 0.0, height + 0.09),
            (high, high + 0.09, 0.0, height + 0.09),
            (low, high, height, height + 0.09),
        ):
            box(b, *_slab(axis, a, c, depth[0], depth[1], z0, z1), m["trim"], 0.5)


def skirting(
    b: Builder,
    m: Palette,
    side: Side,
    at: float,
    span: tuple[float, float],
    gaps: Sequence[tuple[float, float]] = (),
) -> None:
    """A board along the foot of a wall, leaving gaps at doors."""
    axis = "x" if side in ("north", "south") else "y"
    out = -1.0 if side in ("north", "east") else 1.0
    depth = sorted((at, at + out * 0.014))
    start = span[0]
    for low, high in [*sorted(gaps), (span[1], span[1])]:
        if low > start:
            box(b, *_slab(axis, start, low, depth[0], depth[1], 0.0, 0.09), m["trim"], 0.5, "-z")
        start = high


def stair(
    b: Builder,
    m: Palette,
    foot: tuple[float, float],
    width: float,
    steps: int,
    riser: float,
    going: float,
) -> None:
    """A straight stair that climbs towards -x, with balusters on its -y side.

    Args:
        b: where to add it.
        m: materials ``oak``, ``trim``, ``dark``.
        foot: (x, y) of the first riser's corner on the open side.
        width: from there towards +y, metres.
        steps: number of risers; the last one ends at the floor above.
        riser: height of a step.
        going: depth of a step.
    """
    x0, y0 = foot
    for k in range(steps - 1):
        x, z = x0 - k * going, (k + 1) * riser
        box(b, (x - going, y0, z - 0.035), (x + 0.025, y0 + width, z), m["oak"], 0.8)
        box(b, (x - 0.018, y0 + 0.03, z - riser), (x, y0 + width, z - 0.035), m["trim"], 0.5,
            "-z +z")  # fmt: skip
        for at in (0.25, 0.75):
            _baluster(b, m, x - going * at, y0 + 0.045, z, 0.90 + riser * at)
    run, climb = (steps - 1) * going, steps * riser
    for y in (y0 + 0.01, y0 + width - 0.06):
        _stringer(b, m, x0, y, run, climb, riser, going)
    rail = (x0 + 0.04, y0 + 0.045, 0.93 + riser * 0.9)
    end = (x0 - run, y0 + 0.045, climb + 0.93)
    tube(b, rail, end, 0.027, m["dark"], 8)
    newel(b, m, x0 + 0.06, y0 + 0.045, 0.0, 1.16)


def _stringer(
    b: Builder, m: Palette, x0: float, y: float, run: float, climb: float, riser: float,
    going: float,
) -> None:  # fmt: skip
    """A sloping board under the steps, 5 cm thick."""
    slope = riser / going
    tops = [(x0 - 0.02, 0.02), (x0 - run, climb - riser - 0.04)]
    heel = (x0 - run, climb - riser - 0.38)
    toe = (x0 - 0.02 - 0.30 / slope, 0.0)
    quad = np.array([toe, heel, tops[1], tops[0]])
    for depth, flip in ((y, False), (y + 0.05, True)):
        points = np.column_stack([quad[:, 0], np.full(4, depth), quad[:, 1]])
        points = points if not flip else points[::-1]
        b.patches(points[::-1][None], m["trim"], points[::-1][None][..., [0, 2]] * 0.5)
    under = np.array(
        [[toe[0], y, 0.0], [heel[0], y, heel[1]], [heel[0], y + 0.05, heel[1]],
         [toe[0], y + 0.05, 0.0]]
    )  # fmt: skip
    b.patches(under[None], m["trim"], under[None][..., :2])
    over = np.array(
        [
            [tops[1][0], y, tops[1][1]],
            [tops[0][0], y, tops[0][1]],
            [tops[0][0], y + 0.05, tops[0][1]],
            [tops[1][0], y + 0.05, tops[1][1]],
        ]
    )
    b.patches(over[None], m["trim"], over[None][..., :2])


def _baluster(b: Builder, m: Palette, x: float, y: float, z: float, height: float) -> None:
    """A turned stick 18 mm thick with a square foot."""
    tube(b, (x, y, z), (x, y, z + height), 0.009, m["trim"], 6)
    box(b, (x - 0.014, y - 0.014, z), (x + 0.014, y + 0.014, z + 0.10), m["trim"], 1.0, "-z")


def newel(b: Builder, m: Palette, x: float, y: float, z: float, height: float) -> None:
    """The post at the end of a rail."""
    box(b, (x - 0.045, y - 0.045, z), (x + 0.045, y + 0.045, z + height), m["oak"], 1.0, "-z")
    box(b, (x - 0.06, y - 0.06, z + height), (x + 0.06, y + 0.06, z + height + 0.03), m["dark"])


def railing(
    b: Builder, m: Palette, start: tuple[float, float], end: tuple[float, float], z: float
) -> None:
    """A level railing of thin balusters every 11 cm between two points on a floor at ``z``."""
    p, q = np.array(start), np.array(end)
    count = max(int(np.linalg.norm(q - p) / 0.11), 1)
    for k in range(1, count):
        x, y = p + (q - p) * k / count
        _baluster(b, m, float(x), float(y), z, 0.93)
    tube(b, (*start, z + 0.95), (*end, z + 0.95), 0.027, m["dark"], 8)
    newel(b, m, *start, z, 1.02)
    newel(b, m, *end, z, 1.02)
