"""From squares on a grid to outlines of rooms."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

F8 = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_TURNS = ((1, 0), (0, 1), (-1, 0), (0, -1))

__all__ = ["area_of", "inner_point", "outline_rings"]


def outline_rings(mask: Mask, spacing: float, tolerance: float) -> tuple[F8, ...]:
    """Outlines of a set of squares, smoothed to ``tolerance``; holes are rings of their own.

    Args:
        mask: (ny, nx) which squares.
        spacing: of the grid, metres.
        tolerance: how far an outline may stray from the squares' sides, metres.

    Returns:
        (N, 2) rings in metres from the grid's corner, the longest first.
    """
    rings = [_simplify(ring * spacing, tolerance) for ring in _trace(np.pad(mask, 1))]
    kept = [ring - spacing for ring in rings if len(ring) >= 3 and abs(area_of((ring,))) > 0.02]
    return tuple(sorted(kept, key=lambda ring: -abs(area_of((ring,)))))


def _trace(mask: Mask) -> list[F8]:
    """Closed chains of grid corners with the squares on their left."""
    width = mask.shape[1]
    follow: dict[int, list[int]] = {}
    inside = mask.astype(np.int8)
    # sides between a square and what is not one, directed with the square on the left
    for axis, sign in ((0, 1), (0, -1), (1, 1), (1, -1)):
        beside = np.roll(inside, -sign, axis=axis)
        v, u = np.nonzero((inside == 1) & (beside == 0))
        if axis == 0:
            a, b = (v + 1, u + 1), (v + 1, u)
            if sign < 0:
                a, b = (v, u), (v, u + 1)
        else:
            a, b = (v, u + 1), (v + 1, u + 1)
            if sign < 0:
                a, b = (v + 1, u), (v, u)
        start, end = a[0] * (width + 1) + a[1], b[0] * (width + 1) + b[1]
        for s, e in zip(start.tolist(), end.tolist(), strict=True):
            follow.setdefault(s, []).append(e)
    rings = []
    while follow:
        first = min(follow)
        chain, at, came = [first], first, 0
        while True:
            ways = follow[at]
            # where two squares touch at a corner keep to the left: each its own outline
            to = ways[0] if len(ways) == 1 else min(ways, key=lambda w: _turn(came, w - at, width))
            ways.remove(to)
            if not ways:
                del follow[at]
            came, at = to - at, to
            if at == first:
                break
            chain.append(at)
        corners = np.array(chain)
        rings.append(
            np.stack([corners % (width + 1), corners // (width + 1)], axis=1).astype(np.float64)
        )
    return rings


def _turn(came: int, go: int, width: int) -> int:
    """0 for a left turn, 1 for straight on, 2 for a right turn."""
    ways = [1, width + 1, -1, -(width + 1)]
    return {1: 0, 0: 1, 3: 2, 2: 3}[(ways.index(go) - ways.index(came)) % 4]


def _simplify(ring: F8, tolerance: float) -> F8:
    """Douglas and Peucker on a closed chain, split at two corners far apart."""
    corners = ring[np.any(np.roll(ring, -1, 0) - ring != ring - np.roll(ring, 1, 0), axis=1)]
    if len(corners) < 4:
        return corners
    far = int(np.argmax(((corners - corners.mean(axis=0)) ** 2).sum(axis=1)))
    corners = np.roll(corners, -far, axis=0)
    other = int(np.argmax(((corners - corners[0]) ** 2).sum(axis=1)))
    closed = np.concatenate([corners, corners[:1]])
    keep = np.zeros(len(closed), dtype=bool)
    keep[[0, other, len(closed) - 1]] = True
    stack = [(0, other), (other, len(closed) - 1)]
    while stack:
        a, b = stack.pop()
        if b - a < 2:
            continue
        way = closed[b] - closed[a]
        length = float(np.hypot(*way))
        part = closed[a + 1 : b] - closed[a]
        off = np.abs(part[:, 0] * way[1] - part[:, 1] * way[0]) / max(length, 1e-12)
        if length < 1e-12:
            off = np.hypot(part[:, 0], part[:, 1])
        k = int(np.argmax(off))
        if off[k] > tolerance:
            keep[a + 1 + k] = True
            stack += [(a, a + 1 + k), (a + 1 + k, b)]
    return _straighten(closed, np.flatnonzero(keep), tolerance)


def _straighten(closed: F8, kept: npt.NDArray[np.intp], tolerance: float) -> F8:
    """The kept corners of a chain, with its nearly level and upright sides made exactly so."""
    corners = closed[kept[:-1]].copy()
    for k in range(len(corners)):
        chain = closed[kept[k] : kept[k + 1] + 1]
        way = chain[-1] - chain[0]
        for axis in (0, 1):
            if abs(way[axis]) <= tolerance and abs(way[1 - axis]) >= 4.0 * tolerance:
                weight = np.abs(np.diff(chain[:, 1 - axis]))
                middle = (chain[1:, axis] + chain[:-1, axis]) / 2.0
                on = float((weight * middle).sum() / weight.sum())
                corners[[k, (k + 1) % len(corners)], axis] = on
    return corners


def area_of(rings: tuple[F8, ...]) -> float:
    """Square metres that rings enclose; a hole inside counts against what is round it."""
    return abs(sum(_signed(ring) for ring in _oriented(rings)))


def _signed(ring: F8) -> float:
    ring = ring - ring[0]
    after = np.roll(ring, -1, axis=0)
    return float((ring[:, 0] * after[:, 1] - after[:, 0] * ring[:, 1]).sum()) / 2.0


def _oriented(rings: tuple[F8, ...]) -> list[F8]:
    """Rings turned so that holes run the other way round."""
    from belvedere.walkthrough.cells import enclosed

    turned = []
    for k, ring in enumerate(rings):
        rest = rings[:k] + rings[k + 1 :]
        middle = (ring[:1] + ring[1:2]) / 2.0
        hole = bool(rest) and bool(enclosed(rest, middle[:, 0], middle[:, 1])[0])
        turned.append(ring if (_signed(ring) > 0) != hole else ring[::-1])
    return turned


def inner_point(rings: tuple[F8, ...], margin: float = 0.0) -> tuple[F8, float]:
    """(2,) the point of the outlines' inside that is farthest from them, and how far.

    Found on a grid of some thousand points: good for a label, not for geometry.

    Args:
        rings: outlines.
        margin: pull towards the middle, metres of distance worth one metre nearer to it.
    """
    from belvedere.walkthrough.cells import enclosed

    every: Any = np.concatenate(rings)
    low, high = every.min(axis=0), every.max(axis=0)
    step = max(float((high - low).max()) / 48.0, 1e-3)
    x, y = np.meshgrid(
        np.arange(low[0] + step / 2, high[0], step), np.arange(low[1] + step / 2, high[1], step)
    )
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    points = points[enclosed(rings, points[:, 0], points[:, 1])]
    if not len(points):
        return every.mean(axis=0), 0.0
    far = np.full(len(points), np.inf)
    for ring in rings:
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            way = b - a
            t = np.clip((points - a) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
            far = np.minimum(far, np.hypot(*(points - a - t[:, None] * way).T))
    middle = (low + high) / 2.0
    score = far - margin * np.hypot(*(points - middle).T)
    best = int(np.argmax(score))
    return points[best], float(far[best])
