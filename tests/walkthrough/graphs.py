"""Small buildings with known cells and portals, for the tests of this room."""

from __future__ import annotations

import numpy as np

from belvedere.walkthrough import Cell, CellGraph, Portal


def ring(x0: float, y0: float, x1: float, y1: float) -> tuple[np.ndarray, ...]:
    return (np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], dtype=np.float64),)


def upright(
    name: str,
    axis: str,
    at: float,
    span: tuple[float, float],
    rise: tuple[float, float],
    cells: tuple[int, int],
    kind: str = "door",
) -> Portal:
    """A portal in the plane ``axis = at``; ``cells[0]`` lies on the lower side of it."""
    (a, b), (z0, z1) = span, rise
    if axis == "x":
        corners = np.array([[at, b, z0], [at, a, z0], [at, a, z1], [at, b, z1]])
    else:
        corners = np.array([[a, at, z0], [b, at, z0], [b, at, z1], [a, at, z1]])
    return Portal(name, kind, corners, cells)  # type: ignore[arg-type]


def grid_of_rooms(
    across: int, deep: int, rng: np.random.Generator, chance: float = 0.8, wall: float = 0.2
) -> CellGraph:
    """Rooms of 4 m by 3 m with doors and windows at random places in the walls between them."""
    cells, portals = [], []
    for j in range(deep):
        for i in range(across):
            x, y = 4.0 * i, 3.0 * j
            half = wall / 2
            cells.append(
                Cell(f"room {i},{j}", ring(x + half, y + half, x + 4 - half, y + 3 - half), 0, 2.6)
            )
    for j in range(deep):
        for i in range(across):
            here = j * across + i
            for axis, beyond, free in (
                ("x", here + 1, i + 1 < across),
                ("y", here + across, j + 1 < deep),
            ):
                if not free or rng.random() > chance:
                    continue
                length, start = (3.0, 3.0 * j) if axis == "x" else (4.0, 4.0 * i)
                low = start + 0.3 + rng.random() * (length - 1.8)
                at = 4.0 * (i + 1) if axis == "x" else 3.0 * (j + 1)
                window = rng.random() < 0.3
                rise = (0.8, 2.0) if window else (0.0, 2.1)
                portals.append(
                    upright(f"{axis} {here}", axis, at, (low, low + 0.9), rise, (here, beyond),
                            "window" if window else "door")
                )  # fmt: skip
    return CellGraph(tuple(cells), tuple(portals))


def three_rooms() -> CellGraph:
    """Those of the built-in interior (see `belvedere.model.interior`)."""
    cells = (
        Cell("living room", ring(0.0, 0.0, 5.2, 4.4), 0.0, 2.75),
        Cell("kitchen", ring(5.34, 0.0, 9.2, 4.4), 0.0, 2.75),
        Cell("hall", ring(0.0, 4.54, 9.2, 7.8), 0.0, 4.9),
    )
    portals = (
        upright("wide opening", "x", 5.27, (1.5, 2.95), (0.0, 2.2), (0, 1), "opening"),
        upright("living room door", "y", 4.47, (1.15, 2.15), (0.0, 2.12), (0, 2)),
        upright("kitchen door", "y", 4.47, (6.5, 7.5), (0.0, 2.12), (1, 2)),
    )
    return CellGraph(cells, portals)
