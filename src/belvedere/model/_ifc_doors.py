"""Which parts of a door move: its leaves, with what hangs on them, but not its frame.

A closed door hides the next room, and IFC does not say which part is the leaf. A part of a door
that covers the middle of the opening is a leaf; so is one that touches neither jamb nor head, such
as a handle. What is left is the frame.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.model._ifc_openings import Frame
from belvedere.model._ifc_shapes import Shape

F8 = npt.NDArray[np.float64]

MIDDLE = ((0.2, 0.35, 0.5, 0.65, 0.8), (0.15, 0.3, 0.45, 0.6, 0.75))
"""Where a leaf is looked for, in shares of the opening's width and height."""
EDGE_M = 0.02
"""A part that comes this close to a jamb or the head touches it."""


def moving_faces(shape: Shape, frame: Frame) -> npt.NDArray[np.bool_]:
    """(M,) which faces of a door belong to its leaves.

    Args:
        shape: the door's.
        frame: of the opening that it fills.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    c = frame.corners
    across, up = c[1] - c[0], c[3] - c[0]
    width, height = np.linalg.norm(across), np.linalg.norm(up)
    flat = np.stack(
        [(shape.vertices - c[0]) @ across / width**2, (shape.vertices - c[0]) @ up / height**2], 1
    )
    _, item = np.unique(shape.item, return_inverse=True)
    node = shape.faces + (item * len(shape.vertices))[:, None]  # items share no corners
    pairs = np.concatenate([node[:, [0, 1]], node[:, [1, 2]]])
    count = (int(item.max()) + 1) * len(shape.vertices)
    graph = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), (count, count))
    part = connected_components(graph, directed=False)[1][node[:, 0]]
    middle = np.array([[s, t] for s in MIDDLE[0] for t in MIDDLE[1]])
    moving = np.zeros(len(shape.faces), dtype=bool)
    for k in np.unique(part):
        own = part == k
        corners = flat[shape.faces[own]]
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        hangs = (
            low[0] * width > EDGE_M
            and (1.0 - high[0]) * width > EDGE_M
            and (1.0 - high[1]) * height > EDGE_M
        )
        if hangs or _covers_any(corners, middle):
            moving |= own
    return moving


def _covers_any(triangles: F8, points: F8) -> bool:
    """Whether any of (M, 3, 2) triangles covers any of (N, 2) points."""
    a, b, c = (triangles[:, None, k] for k in range(3))

    def side(p: F8, q: F8) -> F8:
        return (q[..., 0] - p[..., 0]) * (points[:, 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (
            points[:, 0] - p[..., 0]
        )

    s = np.stack([side(a, b), side(b, c), side(c, a)])
    flat = np.abs(s.sum(axis=0)) < 1e-12  # seen edge on
    return bool((((s >= 0.0).all(axis=0) | (s <= 0.0).all(axis=0)) & ~flat).any())
