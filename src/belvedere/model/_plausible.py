"""What a model's units and up axis must be, told by its shape: it is taken for a building.

In a building the largest level faces are floors, ceilings and flat roofs, so the axis across which
faces lie in the fewest, largest planes is up. Above a floor there is headroom of 2.1 to 4.2 m, so
the unit is the one in which most floors have that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

F8 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int64]

UNITS = {"m": 1.0, "ft": 0.3048, "in": 0.0254, "cm": 0.01, "mm": 0.001}
"""Metres per unit, the likelier first."""
NAMES = {"m": "metres", "ft": "feet", "in": "inches", "cm": "centimetres", "mm": "millimetres"}
HEADROOM_M = (2.1, 4.2)
"""From a floor to what is above it."""
BUILDING_M = (1.0, 500.0)
"""The longest side of what is taken for a building, or a room of one."""
TYPICAL_M = 15.0
LEVEL = 0.999
"""Cosine from which a face counts as level: 2.6 degrees."""
PROBES = 192
MOST_FACES = 20_000
"""Level faces that are looked at; of more, an even share."""


@dataclass(frozen=True, slots=True)
class Guess:
    """A unit and how it was found."""

    unit: str
    """A key of `UNITS`."""
    why: str
    """For people."""


def guess_up(vertices: F8, faces: I8) -> str:
    """``"y"`` or ``"z"``: across which the faces lie in the largest planes; y where neither does.

    Args:
        vertices: (N, 3) finite positions in any unit.
        faces: (M, 3) triangles with an area.
    """
    score = [_planarity(vertices, faces, axis) for axis in (1, 2)]
    return "z" if score[1] > score[0] else "y"


def guess_unit(vertices: F8, faces: I8) -> Guess:
    """The unit in which floors have the most headroom; else the one of a plausible size.

    Args:
        vertices: (N, 3) finite positions, +z up.
        faces: (M, 3) triangles with an area.
    """
    low, high = np.percentile(vertices, [0.5, 99.5], axis=0)  # a stray vertex does not count
    longest = float((high - low).max())
    sizes = {
        key: metres
        for key, metres in UNITS.items()
        if BUILDING_M[0] <= longest * metres <= BUILDING_M[1]
    }
    rooms = headrooms(vertices, faces)
    if len(rooms) >= PROBES // 8:
        share = {
            key: float(np.mean((rooms * m >= HEADROOM_M[0]) & (rooms * m <= HEADROOM_M[1])))
            for key, m in sizes.items()
        }
        best = max(share, key=lambda key: (share[key] > 0.2, round(share[key], 1)), default="")
        if best and share[best] > 0.2:
            low_m, high_m = HEADROOM_M
            return Guess(
                best, f"{share[best]:.0%} of its floors then have {low_m} to {high_m} m of headroom"
            )
    if not sizes:
        best = min(UNITS, key=lambda key: abs(np.log(max(longest, 1e-30) * UNITS[key] / TYPICAL_M)))
    else:
        best = next(iter(sizes))
    return Guess(best, f"it is {longest:.4g} units long")


def headrooms(vertices: F8, faces: I8) -> F8:
    """(K,) heights of what is next above points spread over the upward faces, in the mesh's units.

    Points with nothing above them are left out.
    """
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1)
    level = np.flatnonzero(np.abs(normal[:, 2]) > LEVEL * area)
    upward = np.flatnonzero(normal[:, 2] > LEVEL * area)
    if not len(upward):
        return np.zeros(0)
    ends = np.cumsum(area[upward])
    chosen = upward[np.searchsorted(ends, (np.arange(PROBES) + 0.5) / PROBES * ends[-1])]
    points = corners[chosen].mean(axis=1)
    if len(level) > MOST_FACES:
        level = level[np.argsort(-area[level], kind="stable")[:MOST_FACES]]
    above = corners[level]
    found = np.full(PROBES, np.inf)
    for k, point in enumerate(points):
        gap = above[:, 0, 2] - point[2]
        over = above[(gap > 1e-6 * np.ptp(vertices[:, 2])) & _covers(above, point)]
        if len(over):
            found[k] = (over[:, :, 2].mean(axis=1) - point[2]).min()
    return found[np.isfinite(found)]


def _covers(triangles: F8, point: F8) -> npt.NDArray[np.bool_]:
    """Which triangles have the point under or over them."""
    flat = triangles[:, :, :2] - point[:2]
    after = np.roll(flat, -1, axis=1)
    side = flat[..., 0] * after[..., 1] - flat[..., 1] * after[..., 0]
    return np.asarray((side >= 0.0).all(axis=1) | (side <= 0.0).all(axis=1))


def _planarity(vertices: F8, faces: I8, axis: int) -> float:
    """Root of the summed squared areas of the planes across an axis: large planes count most."""
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1)
    across = np.abs(normal[:, axis]) > LEVEL * area
    if not across.any():
        return 0.0
    height = corners[across, :, axis].mean(axis=1)
    extent = max(float(np.ptp(vertices, axis=0).max()), 1e-30)
    _, plane = np.unique(np.rint(height / extent * 1000.0), return_inverse=True)
    return float(np.sqrt((np.bincount(plane, area[across]) ** 2).sum()))
