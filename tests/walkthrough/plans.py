"""Small buildings of known truth, put together from boxes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from belvedere.scene.mesh import Material, Mesh

Span = tuple[float, float, float, float]
"""A hole in a wall: from, to along it; sill, head above the ground."""

PAINT = Material("paint")
_FACES = np.array(
    [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4],
     [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]]
)  # fmt: skip


def solid(corners: np.ndarray, material: Material = PAINT) -> Mesh:
    """A box-like solid from its four lower and four upper corners, anticlockwise from above."""
    count = len(_FACES)
    return Mesh(
        corners, _FACES, np.zeros(count, np.int32), np.zeros((count, 3, 2), np.float32), (material,)
    )


def box(low: Sequence[float], high: Sequence[float], material: Material = PAINT) -> Mesh:
    (x0, y0, z0), (x1, y1, z1) = low, high
    plan = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    return solid(np.array([(x, y, z) for z in (z0, z1) for x, y in plan]), material)


def wall(
    a: tuple[float, float], b: tuple[float, float], height: tuple[float, float] = (0.0, 2.6),
    thickness: float = 0.15, holes: Sequence[Span] = (),
) -> list[Mesh]:  # fmt: skip
    """A wall along its middle line, with holes."""
    start, way = np.array(a), np.array(b) - np.array(a)
    length = float(np.hypot(*way))
    way = way / length
    side = np.array([-way[1], way[0]]) * thickness / 2.0

    def piece(s0: float, s1: float, z0: float, z1: float) -> Mesh:
        p, q = start + s0 * way, start + s1 * way
        plan = [p - side, q - side, q + side, p + side]
        return solid(np.array([(*c, z) for z in (z0, z1) for c in plan]))

    parts, at = [], -thickness / 2.0
    for s0, s1, sill, head in sorted(holes):
        parts.append(piece(at, s0, *height))
        if sill > height[0]:
            parts.append(piece(s0, s1, height[0], sill))
        if head < height[1]:
            parts.append(piece(s0, s1, head, height[1]))
        at = s1
    parts.append(piece(at, length + thickness / 2.0, *height))
    return parts


def slab(low: tuple[float, float], high: tuple[float, float], top: float) -> Mesh:
    """A floor or ceiling 0.2 m thick whose upper side is at ``top``."""
    return box((*low, top - 0.2), (*high, top))


def shell(
    size: tuple[float, float],
    height: float = 2.6,
    holes: Mapping[str, Sequence[Span]] | None = None,
) -> list[Mesh]:
    """Floor, ceiling and four outer walls round (0, 0) to ``size``; holes by s, e, n, w."""
    x, y = size
    h = holes or {}
    return [
        slab((-0.2, -0.2), (x + 0.2, y + 0.2), 0.0),
        slab((-0.2, -0.2), (x + 0.2, y + 0.2), height + 0.2),
        *wall((0, 0), (x, 0), (0, height), holes=h.get("s", ())),
        *wall((x, 0), (x, y), (0, height), holes=h.get("e", ())),
        *wall((x, y), (0, y), (0, height), holes=h.get("n", ())),
        *wall((0, y), (0, 0), (0, height), holes=h.get("w", ())),
    ]


def moved(mesh: Mesh, turn_deg: float = 0.0, shift: Sequence[float] = (0, 0, 0)) -> Mesh:
    a = np.radians(turn_deg)
    turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    points = mesh.vertices @ turn.T + np.array(shift)
    return Mesh(points, mesh.faces, mesh.material_index, mesh.uv, mesh.materials)


def two_rooms(door: Span = (1.5, 2.4, 0.0, 2.05)) -> Mesh:
    """4 x 4 m and 3 x 4 m with a door between them."""
    return Mesh.concatenate([*shell((7, 4)), *wall((4, 0), (4, 4), holes=[door])])


def flat() -> Mesh:
    """Three rooms along a corridor 1.2 m wide and 9 m long, doors 0.85 m, furniture."""
    doors = [(1.0, 1.85, 0.0, 2.03), (4.1, 4.95, 0.0, 2.03), (7.0, 7.85, 0.0, 2.03)]
    parts = [
        *shell((9, 5.2), holes={"w": [(4.2, 5.0, 0.0, 2.1)], "s": [(1.0, 2.2, 0.9, 2.2)]}),
        *wall((0, 4), (9, 4), holes=doors),
        *wall((3, 0), (3, 4)),
        *wall((6, 0), (6, 4)),
        box((0.2, 2.0, 0), (2.0, 3.4, 0.5)),  # a bed
        box((2.3, 0.1, 0), (2.9, 1.4, 2.1)),  # a wardrobe
        box((4.0, 1.5, 0.72), (5.2, 2.3, 0.75)),  # a table top
        box((4.1, 1.6, 0), (4.2, 1.7, 0.72)),
        box((6.2, 0.1, 0), (6.6, 2.6, 1.0)),  # a sideboard
    ]
    return Mesh.concatenate(parts)


def l_shape() -> Mesh:
    """One L-shaped room, its legs 1.6 m wide."""
    return Mesh.concatenate(
        [
            slab((-0.2, -0.2), (6.2, 5.2), 0.0), slab((-0.2, -0.2), (6.2, 5.2), 2.8),
            *wall((0, 0), (6, 0)), *wall((6, 0), (6, 1.6)), *wall((6, 1.6), (1.6, 1.6)),
            *wall((1.6, 1.6), (1.6, 5)), *wall((1.6, 5), (0, 5)), *wall((0, 5), (0, 0)),
        ]
    )  # fmt: skip


def stairs(
    foot: tuple[float, float], width: float, steps: int, rise: float, going: float
) -> list[Mesh]:
    """Solid steps that climb towards +x from ``foot``, their corner of least x and y."""
    x, y = foot
    return [
        box((x + k * going, y, 0.0), (x + (k + 1) * going, y + width, (k + 1) * rise))
        for k in range(steps)
    ]


def two_storeys() -> Mesh:
    """7 x 5 m twice, a straight stair in a hole 1 m wide; two rooms on each floor."""
    hole, top = (1.5, 5.2), 2.8
    upper = [
        slab((-0.2, -0.2), (7.2, 4.0), top),
        slab((-0.2, 4.0), (hole[0], 5.2), top),
        slab((hole[1], 4.0), (7.2, 5.2), top),
    ]
    parts = [
        slab((-0.2, -0.2), (7.2, 5.2), 0.0), *upper, slab((-0.2, -0.2), (7.2, 5.2), 5.6),
        *stairs((1.5, 4.0), 0.95, 15, top / 16, 0.25),
    ]  # fmt: skip
    for low, high in ((0.0, 2.6), (top, 5.4)):
        head = low + 2.05
        for a, b in (((0, 0), (7, 0)), ((7, 0), (7, 5)), ((7, 5), (0, 5)), ((0, 5), (0, 0))):
            parts += wall(a, b, (low, high))
        parts += wall((0, 2.4), (7, 2.4), (low, high), holes=[(4.0, 4.9, low, head)])
    # the slab's edge round the stairwell closes the gap between ceiling and floor above
    return Mesh.concatenate(parts)


def truth_doors() -> dict[str, tuple[float, float, float]]:
    """Centres of the doors of `flat`."""
    return {"1": (1.425, 4.0, 1.015), "2": (4.525, 4.0, 1.015), "3": (7.425, 4.0, 1.015)}
