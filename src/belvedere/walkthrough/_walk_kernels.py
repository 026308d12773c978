"""The steps of a visitor on layers of floors. Private."""

from __future__ import annotations

import math
from typing import Any

import numpy.typing as npt

from belvedere.ground.jit import kernel

A = npt.NDArray[Any]

PUSHES = 4


@kernel
def _neighbour(link: A, n: int, di: int, dj: int) -> int:
    """The place (di, dj) columns away, each -1, 0 or 1, by either way round; -1: none."""
    if di == 0 and dj == 0:
        return n
    x = -1 if di == 0 else (link[n, 1] if di > 0 else link[n, 0])
    y = -1 if dj == 0 else (link[n, 3] if dj > 0 else link[n, 2])
    if dj == 0:
        return x
    if di == 0:
        return y
    if x >= 0:
        m = link[x, 3] if dj > 0 else link[x, 2]
        if m >= 0:
            return m
    if y >= 0:
        return link[y, 1] if di > 0 else link[y, 0]
    return -1


@kernel
def field(
    link: A, column: A, nx: int, spacing: float, value: A, n: int, x: float, y: float,
    edge: float, own: bool,
) -> tuple[float, float, float]:  # fmt: skip
    """A value between the places round (x, y), bilinear, with its slope.

    Args:
        link: neighbours.
        column: of each place.
        nx: columns along x.
        spacing: metres.
        value: one per place.
        n: the place that (x, y) lies in.
        x: metres from the grid's corner.
        y: metres.
        edge: the value where there is no place.
        own: take the place's own value there instead.
    """
    i, j = column[n] % nx, column[n] // nx
    u, v = x / spacing - (i + 0.5), y / spacing - (j + 0.5)
    di, dj = (1 if u >= 0.0 else -1), (1 if v >= 0.0 else -1)
    u, v = abs(u), abs(v)
    a = value[n]
    missing = a if own else edge
    m = _neighbour(link, n, di, 0)
    b = value[m] if m >= 0 else missing
    m = _neighbour(link, n, 0, dj)
    c = value[m] if m >= 0 else missing
    m = _neighbour(link, n, di, dj)
    d = value[m] if m >= 0 else missing
    result = (a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v
    gx = ((b - a) * (1 - v) + (d - c) * v) * di / spacing
    gy = ((c - a) * (1 - u) + (d - b) * u) * dj / spacing
    return result, gx, gy


@kernel
def _follow(link: A, column: A, nx: int, spacing: float, n: int, x: float, y: float) -> int:
    """The place at (x, y) reached over links from n, at most one column away; -1: none."""
    i, j = column[n] % nx, column[n] // nx
    p, q = math.floor(x / spacing), math.floor(y / spacing)
    if abs(p - i) > 1 or abs(q - j) > 1:
        return -1
    return _neighbour(link, n, p - i, q - j)


@kernel
def stroll(
    link: A, column: A, nx: int, spacing: float, far: A, radius: float, start: int, x: float,
    y: float, dx: float, dy: float, most: float, out_at: A,
) -> int:  # fmt: skip
    """Move a body along (dx, dy), sliding along what is in its way.

    It goes in pieces of at most ``most`` metres; after each the body is pushed along the slope of
    the distance field until it is ``radius`` away from everything. Where it is too narrow for that
    a piece is taken only if it leads to more room.

    Returns:
        The place it ends in; its x, y are in ``out_at``.
    """
    n = start
    length = math.sqrt(dx * dx + dy * dy)
    pieces = max(math.ceil(length / most), 1)
    for _ in range(pieces):
        here, _, _ = field(link, column, nx, spacing, far, n, x, y, -0.5 * spacing, False)
        px, py, m = x + dx / pieces, y + dy / pieces, n
        m = _follow(link, column, nx, spacing, n, px, py)
        if m < 0:  # into something: try what is left along either axis
            px, py = x + dx / pieces, y
            m = _follow(link, column, nx, spacing, n, px, py)
            if m < 0:
                px, py = x, y + dy / pieces
                m = _follow(link, column, nx, spacing, n, px, py)
            if m < 0:
                continue
        room = 0.0
        for k in range(PUSHES + 1):
            room, gx, gy = field(link, column, nx, spacing, far, m, px, py, -0.5 * spacing, False)
            slope = math.sqrt(gx * gx + gy * gy)
            if room >= radius or slope < 1e-6 or k == PUSHES:
                break
            push = min((radius - room) / max(slope, 0.5), most)
            qx, qy = px + push * gx / slope, py + push * gy / slope
            to = _follow(link, column, nx, spacing, m, qx, qy)
            if to < 0:
                break
            px, py, m = qx, qy, to
        if room < radius - 1e-3 and room <= here:
            continue
        x, y, n = px, py, m
    out_at[0], out_at[1] = x, y
    return n
