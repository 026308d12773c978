"""Loops that lay light lattices on triangles that are no rectangles. Private."""

from __future__ import annotations

import math
from typing import Any

import numpy.typing as npt

from belvedere.ground.jit import kernel

A = npt.NDArray[Any]


@kernel
def flat_groups(
    pair_a: A, pair_b: A, normals: A, heights: A, kind: A, least_cosine: float, most_apart: float,
    out_root: A,
) -> None:  # fmt: skip
    """Join faces that share an edge, lie in one plane and are of one kind (union by the smaller).

    Args:
        pair_a: (E,) faces on one side of each edge.
        pair_b: (E,) faces on its other side.
        normals: (M, 3) unit, either way round.
        heights: (M,) of each plane along its normal.
        kind: (M,) what may be joined with what.
        least_cosine: of the angle between two planes.
        most_apart: metres between them.
        out_root: (M,) int32, each face's own number before; afterwards the smallest of its group.
    """
    for e in range(pair_a.shape[0]):
        a, b = pair_a[e], pair_b[e]
        if kind[a] != kind[b]:
            continue
        turn = 0.0
        for c in range(3):
            turn += normals[a, c] * normals[b, c]
        if abs(turn) < least_cosine:
            continue
        sign = 1.0 if turn > 0.0 else -1.0
        if abs(heights[a] - sign * heights[b]) > most_apart:
            continue
        while out_root[a] != a:
            out_root[a] = out_root[out_root[a]]
            a = out_root[a]
        while out_root[b] != b:
            out_root[b] = out_root[out_root[b]]
            b = out_root[b]
        if a < b:
            out_root[b] = a
        elif b < a:
            out_root[a] = b
    for f in range(out_root.shape[0]):  # roots are smaller, so one pass in order settles all
        out_root[f] = out_root[out_root[f]]


@kernel
def _root(face: int, out_piece: A, out_sign: A) -> tuple[int, float]:
    """The root of a face and how it is wound against it; halves the way there."""
    sign = 1.0
    while out_piece[face] != face:
        above = out_piece[face]
        if out_piece[above] != above:
            out_sign[face] *= out_sign[above]
            out_piece[face] = out_piece[above]
        sign *= out_sign[face]
        face = out_piece[face]
    return face, sign


@kernel
def wind_alike(one: A, two: A, opposed: A, out_piece: A, out_sign: A) -> None:
    """Join faces to pieces; within a piece, ``out_sign`` turns all fronts to one side.

    Union-find that knows of each face whether it is wound like its root; ``out_piece`` comes as
    0, 1, 2, ... and ``out_sign`` as ones.
    """
    for e in range(one.shape[0]):
        a, sign_a = _root(one[e], out_piece, out_sign)
        b, sign_b = _root(two[e], out_piece, out_sign)
        if a != b:
            low, high = min(a, b), max(a, b)
            out_piece[high] = low
            out_sign[high] = sign_a * sign_b * (1.0 if opposed[e] else -1.0)
    for f in range(out_piece.shape[0]):
        root, sign = _root(f, out_piece, out_sign)
        out_piece[f] = root
        out_sign[f] = sign


@kernel
def settle_points(
    first_face: A, faces: A, st: A, sides: A, first: A, shape: A, out_s: A, out_t: A, out_near: A
) -> None:
    """Move the points of each chart's lattice onto its triangles.

    Args:
        first_face: (K + 1,) where each chart's faces begin in ``faces``.
        faces: face indices, chart by chart.
        st: (M, 3, 2) chart coordinates of the faces' corners.
        sides: (K, 2) metres along s and t.
        first: (K,) of the lattice.
        shape: (K, 2) of the lattice.
        out_s: (P,) where each point of the lattice lies on the chart.
        out_t: (P,) likewise.
        out_near: (P,) bool: False for points that no pixel's light is ever read from.
    """
    for k in range(first.shape[0]):
        ns, nt = shape[k, 0], shape[k, 1]
        a, b = sides[k, 0], sides[k, 1]
        step_s = a / max(ns - 1, 1)
        step_t = b / max(nt - 1, 1)
        for j in range(nt):
            for i in range(ns):
                at = first[k] + j * ns + i
                x = (0.5 if ns == 1 else i / (ns - 1.0)) * a
                y = (0.5 if nt == 1 else j / (nt - 1.0)) * b
                best, bx, by = math.inf, x, y
                for q in range(first_face[k], first_face[k + 1]):
                    f = faces[q]
                    x0, y0 = st[f, 0, 0] * a, st[f, 0, 1] * b
                    x1, y1 = st[f, 1, 0] * a, st[f, 1, 1] * b
                    x2, y2 = st[f, 2, 0] * a, st[f, 2, 1] * b
                    # a quick no: farther from the triangle's box than the best so far
                    dx = max(min(x0, x1, x2) - x, x - max(x0, x1, x2), 0.0)
                    dy = max(min(y0, y1, y2) - y, y - max(y0, y1, y2), 0.0)
                    if dx * dx + dy * dy >= best:
                        continue
                    e0 = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)
                    e1 = (x2 - x1) * (y - y1) - (y2 - y1) * (x - x1)
                    e2 = (x0 - x2) * (y - y2) - (y0 - y2) * (x - x2)
                    if (e0 >= 0 and e1 >= 0 and e2 >= 0) or (e0 <= 0 and e1 <= 0 and e2 <= 0):
                        best, bx, by = 0.0, x, y
                        break
                    for side in range(3):
                        px, py = (x0, y0) if side == 0 else (x1, y1) if side == 1 else (x2, y2)
                        qx, qy = (x1, y1) if side == 0 else (x2, y2) if side == 1 else (x0, y0)
                        ex, ey = qx - px, qy - py
                        share = ((x - px) * ex + (y - py) * ey) / max(ex * ex + ey * ey, 1e-18)
                        share = min(max(share, 0.0), 1.0)
                        cx, cy = px + share * ex, py + share * ey
                        off = (x - cx) ** 2 + (y - cy) ** 2
                        if off < best:
                            # a little inside: towards the middle of the triangle
                            mx, my = (x0 + x1 + x2) / 3.0 - cx, (y0 + y1 + y2) / 3.0 - cy
                            pull = min(0.01 / max(math.sqrt(mx * mx + my * my), 1e-9), 0.2)
                            best, bx, by = off, cx + pull * mx, cy + pull * my
                out_s[at] = bx / a if a > 0.0 else 0.5
                out_t[at] = by / b if b > 0.0 else 0.5
                reach = 1.5 * max(step_s, step_t)
                out_near[at] = best <= reach * reach or best == 0.0
