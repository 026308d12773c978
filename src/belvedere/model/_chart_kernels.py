"""Loops that lay charts over meshes and light on parts of them. Private."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from belvedere.ground.jit import kernel

A = npt.NDArray[Any]


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
def mark_surface(of_face: A, st: A, first: A, shape: A, out_mark: A) -> None:
    """Mark the lattice points that lie on a face of their chart."""
    for f in range(of_face.shape[0]):
        k = of_face[f]
        ns, nt = shape[k, 0], shape[k, 1]
        gs, gt = max(ns - 1, 1), max(nt - 1, 1)
        x0, y0 = st[f, 0, 0] * gs, st[f, 0, 1] * gt
        x1, y1 = st[f, 1, 0] * gs, st[f, 1, 1] * gt
        x2, y2 = st[f, 2, 0] * gs, st[f, 2, 1] * gt
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if area == 0.0:
            continue
        i0, i1 = int(min(x0, x1, x2)), int(max(x0, x1, x2)) + 1
        j0, j1 = int(min(y0, y1, y2)), int(max(y0, y1, y2)) + 1
        for j in range(max(j0, 0), min(j1, nt - 1) + 1):
            for i in range(max(i0, 0), min(i1, ns - 1) + 1):
                x, y = float(i), float(j)
                if ns == 1:
                    x = 0.5
                if nt == 1:
                    y = 0.5
                u = ((x - x0) * (y2 - y0) - (x2 - x0) * (y - y0)) / area
                v = ((x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)) / area
                if u > -1e-4 and v > -1e-4 and u + v < 1.0002:
                    out_mark[first[k] + j * ns + i] = True


@kernel
def fill_halves(first: A, shape: A, mark: A, light: A) -> None:
    """The corner of a parallelogram that no face has: what makes the light linear on the face."""
    for k in range(first.shape[0]):
        if shape[k, 0] == 2 and shape[k, 1] == 2 and not mark[first[k] + 3]:
            at = first[k]
            for c in range(3):
                light[at + 3, c] = light[at + 1, c] + light[at + 2, c] - light[at, c]
