"""Where cells touch without a wall between them: free contact surfaces, found with rays.

From points close to every side of a cell rays go outwards. Those that nothing stops within the
thickness of a wall, and that arrive in another cell or in the open, mark a free patch; each
connected patch is bounded by a rectangle. The rectangle may be larger than the patch, never
smaller: what can be seen through the patch is seen through the portal.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.model.building import OpeningKind
from belvedere.model.raycast import RayCaster
from belvedere.walkthrough.cells import OUTSIDE, Cell, enclosed
from belvedere.walkthrough.columns import Layers
from belvedere.walkthrough.necks import DOOR_M

F8 = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

STEP_M = 0.05
"""Between rays."""
INSET_M = 0.08
"""How far inside a cell they begin."""
WALL_M = 0.8
"""No wall or slab is thicker."""
PROBES_M = (0.03, 0.1, 0.18, 0.26, 0.35, 0.45, 0.6, WALL_M)
"""How far beyond its side a neighbour is looked for."""
OPEN_M = 6.0
"""A ray that goes on so far beyond a side is outdoors, as is one under the open sky."""
LEAST_PATCH_M2, LEAST_SIDE_M = 0.08, 0.25
MARGIN_M = 0.12
"""Rays that pass so close to a known portal pass through it."""

__all__ = ["Contact", "Passages", "add_contacts", "cell_at", "crossing", "facing"]


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """A rectangle between two cells, not yet named."""

    corners: F8
    """(4, 3) metres."""
    first: int
    """A cell."""
    second: int
    """Another, or `OUTSIDE`."""
    kind: OpeningKind
    """Whether people walk through."""


@dataclass(frozen=True, slots=True, eq=False)
class Passages:
    """Steps that lead from one cell to another."""

    points: F8
    """(K, 3) where, on the floor, metres."""
    cells: npt.NDArray[np.int32]
    """(K, 2) from which cell to which, the smaller first."""
    spacing: float
    """Width of a step, metres."""

    @classmethod
    def of_layers(cls, layers: Layers, cell: npt.NDArray[np.int32]) -> Passages:
        """From places on floors and the cell that each is in."""
        points, pairs = [np.zeros((0, 3))], [np.zeros((0, 2), dtype=np.int32)]
        at = np.column_stack([layers.centers, layers.floor])
        for d in (1, 3):
            n = np.flatnonzero(layers.link[:, d] >= 0)
            to = layers.link[n, d]
            n, to = n[cell[n] != cell[to]], to[cell[n] != cell[to]]
            points.append((at[n] + at[to]) / 2.0)
            pairs.append(np.sort(np.stack([cell[n], cell[to]], axis=1), axis=1))
        return cls(np.concatenate(points), np.concatenate(pairs), layers.grid.spacing)

    def through(self, contact: Contact) -> bool:
        """Whether steps over half a metre of width lead through a contact."""
        pair = sorted((contact.first, contact.second))
        mine = self.points[(self.cells == pair).all(axis=1)]
        corners = contact.corners
        u, v = corners[1] - corners[0], corners[3] - corners[0]
        width, height = float(np.linalg.norm(u)), float(np.linalg.norm(v))
        u, v = u / width, v / height
        normal = np.cross(u, v)
        off = mine - corners[0]
        s, t, far = off @ u, off @ v, np.abs(off @ normal)
        near = (s > -0.05) & (s < width + 0.05)
        if abs(normal[2]) > 0.5:
            near &= (t > -0.05) & (t < height + 0.05)
        else:
            near &= (far < 0.4) & (t > -0.4) & (t < height - 1.5)
        return bool(near.sum() * self.spacing >= 0.5)


@dataclass(frozen=True, slots=True, eq=False)
class _Side:
    """A rectangle of sample points on a side of a cell."""

    origin: F8
    """(3,) a corner, on the side itself."""
    u: F8
    """(3,) unit vector along its rows."""
    v: F8
    """(3,) unit vector up its columns."""
    out: F8
    """(3,) unit vector outwards."""
    inside: Mask
    """(rows, columns) which samples belong to the cell."""

    def points(self) -> F8:
        """(rows, columns, 3) on the side."""
        rows, columns = self.inside.shape
        s = (np.arange(columns) + 0.5) * STEP_M
        t = (np.arange(rows) + 0.5) * STEP_M
        return self.origin + s[None, :, None] * self.u + t[:, None, None] * self.v


def cell_at(cells: list[Cell], points: F8) -> npt.NDArray[np.int32]:
    """(N,) cell of each point, or `OUTSIDE`: see `CellGraph.cells_at`."""
    found = np.full(len(points), OUTSIDE, dtype=np.int32)
    height = np.full(len(points), -np.inf)
    for index, cell in enumerate(cells):
        low, high = cell.low, cell.high
        near = np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
        if not len(near):
            continue
        better = near[cell.contains(points[near]) & (cell.floor > height[near])]
        found[better], height[better] = index, cell.floor
    return found


def add_contacts(
    cells: list[Cell],
    clear: RayCaster,
    solid: RayCaster,
    known: list[Contact],
    seeds: list[F8],
    passages: Passages,
) -> list[Contact]:
    """The known contacts and all others that rays find.

    Args:
        cells: upright prisms, metres.
        clear: the building without door leaves and panes: what light passes.
        solid: the building without door leaves: what a person passes.
        known: portals there already; what passes through them is no news.
        seeds: for each cell (N, 3) points in its free space. A side that none of them sees is
            behind something, a sloping roof perhaps.
        passages: where people step from cell to cell.
    """
    contacts = list(known)
    for index in range(len(cells)):
        fresh: list[tuple[Contact, F8]] = []
        for side in _sides(cells[index]):
            for contact in _on_side(cells, index, side, clear, contacts, seeds[index]):
                _join(fresh, contact, side.out)
        contacts += [replace(c, kind=_kind(c, solid, out, passages)) for c, out in fresh]
    return contacts


def _join(fresh: list[tuple[Contact, F8]], contact: Contact, out: F8) -> None:
    """Add a contact, as one with those it overlaps or touches in the same plane."""
    u, v = contact.corners[1] - contact.corners[0], contact.corners[3] - contact.corners[0]
    u, v = u / np.linalg.norm(u), v / np.linalg.norm(v)
    apart = True
    while apart:
        apart = False
        box = (contact.corners - contact.corners[0]) @ np.stack([u, v], axis=1)
        for k, (other, way) in enumerate(fresh):
            if (other.first, other.second) != (contact.first, contact.second) or way @ out < 0.99:
                continue
            off = other.corners - contact.corners[0]
            near = off @ np.stack([u, v], axis=1)
            gap = np.maximum(near.min(axis=0) - box.max(axis=0), box.min(axis=0) - near.max(axis=0))
            if gap.max() > 0.12 or np.abs(off @ out).max() > 0.15:
                continue
            low = np.minimum(near.min(axis=0), box.min(axis=0))
            high = np.maximum(near.max(axis=0), box.max(axis=0))
            corners = contact.corners[0] + np.array(
                [low, [high[0], low[1]], high, [low[0], high[1]]]
            ) @ np.stack([u, v])
            contact = replace(contact, corners=corners)
            del fresh[k]
            apart = True
            break
    fresh.append((contact, out))


def _sides(cell: Cell) -> list[_Side]:
    """Walls, ceiling and floor of a prism."""
    sides = []
    height = cell.ceiling - cell.floor
    rows = max(int(height / STEP_M), 1)
    up = np.array([0.0, 0.0, 1.0])
    for ring in map(_bends, cell.rings):
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            length = float(np.hypot(*(b - a)))
            if length < LEAST_SIDE_M:
                continue
            u = np.array([*(b - a) / length, 0.0])
            out = np.array([u[1], -u[0], 0.0])
            test = (a + b) / 2.0 + 0.01 * out[:2]
            if enclosed(cell.rings, test[:1], test[1:])[0]:
                out = -out
            inside = np.ones((rows, max(int(length / STEP_M), 1)), dtype=bool)
            sides.append(_Side(np.array([*a, cell.floor]), u, up, out, inside))
    low, high = cell.low[:2], cell.high[:2]
    columns, lines = (max(int(n), 1) for n in (high - low) / STEP_M)
    x, y = np.meshgrid(np.arange(columns) + 0.5, np.arange(lines) + 0.5)
    plan = enclosed(cell.rings, low[0] + x * STEP_M, low[1] + y * STEP_M)
    for z, way in ((cell.ceiling, 1.0), (cell.floor, -1.0)):
        origin = np.array([*low, z])
        sides.append(_Side(origin, np.eye(3)[0], np.eye(3)[1], way * up, plan))
    return sides


def _bends(ring: F8) -> F8:
    """A ring without the corners at which it goes straight on."""
    kept = list(ring)
    k = 0
    while k < len(kept) and len(kept) > 3:
        way, on = kept[k] - kept[k - 1], kept[(k + 1) % len(kept)] - kept[k]
        length = float(np.hypot(*way) * np.hypot(*on))
        if length == 0.0 or (
            abs(way[0] * on[1] - way[1] * on[0]) < 0.002 * length and way @ on > 0
        ):
            del kept[k]
            k = max(k - 1, 0)
        else:
            k += 1
    return np.array(kept)


def _on_side(
    cells: list[Cell], index: int, side: _Side, clear: RayCaster, known: list[Contact], seeds: F8
) -> list[Contact]:
    from scipy import ndimage

    grid = side.points()
    rows, columns = np.nonzero(side.inside)
    on = grid[rows, columns]
    start = on - INSET_M * side.out
    own = cell_at(cells, start) == index  # where cells overlap, only what is truly this one's
    rows, columns, on, start = rows[own], columns[own], on[own], start[own]
    hits = clear.cast(start, np.broadcast_to(side.out, start.shape))
    free = hits.t.astype(np.float64) - INSET_M
    maybe = np.flatnonzero(free > PROBES_M[0])
    maybe = maybe[~_passes_known(index, start[maybe], side.out, free[maybe], known)]
    beyond, apart = _beyond(cells, index, on[maybe], side.out, free[maybe], clear)
    there = beyond != index
    maybe, beyond, apart = maybe[there], beyond[there], apart[there]
    seen = _seen(clear, seeds, start[maybe])
    maybe, beyond, apart = maybe[seen], beyond[seen], apart[seen]
    found = []
    for other in np.unique(beyond):
        mask = np.zeros(side.inside.shape, dtype=bool)
        mine = maybe[beyond == other]
        mask[rows[mine], columns[mine]] = True
        padded: Any = ndimage.binary_closing(np.pad(mask, 3), np.ones((3, 3)), iterations=2)
        whole = padded[3:-3, 3:-3]
        labelled: Any = ndimage.label(whole)
        label = labelled[0]
        for k, box in enumerate(ndimage.find_objects(label)):
            count = int((mask & (label == k + 1)).sum())
            tall, wide = ((s.stop - s.start) * STEP_M for s in box)
            if count * STEP_M**2 < LEAST_PATCH_M2 or min(tall, wide) < LEAST_SIDE_M:
                continue
            within = label[rows[mine], columns[mine]] == k + 1
            gap = float(np.median(apart[beyond == other][within]))
            corners = _rectangle(side, box, 0.05 if other == OUTSIDE else 0.15)
            if other == OUTSIDE:
                gap = 2.0 * _jamb_middle(clear, corners, side.out)
            corners = corners + side.out * min(gap, WALL_M) / 2.0
            found.append(Contact(corners, index, int(other), "opening"))
    return found


def _beyond(
    cells: list[Cell], index: int, on: F8, out: F8, free: F8, clear: RayCaster
) -> tuple[npt.NDArray[np.int32], F8]:
    """What each free ray arrives in (``index``: nothing of interest), and how far away."""
    beyond = np.full(len(on), index, dtype=np.int32)
    apart = np.zeros(len(on))
    inside = np.zeros(len(on), dtype=bool)
    for far in PROBES_M:
        todo = np.flatnonzero((beyond == index) & ~inside & (free > far))
        if not len(todo):
            break
        cell = cell_at(cells, on[todo] + far * out)
        inside[todo] |= cell == index  # out of a niche and back
        new = (cell != index) & (cell != OUTSIDE)
        beyond[todo[new]], apart[todo[new]] = cell[new], far
    todo = np.flatnonzero((beyond == index) & ~inside & (free > 1.0))
    if len(todo):
        point = on[todo] + 0.95 * out
        sky = ~clear.blocked(point, np.broadcast_to([0.0, 0.0, 1.0], point.shape))
        sky |= free[todo] > OPEN_M
        sky &= cell_at(cells, on[todo] + 0.95 * out) == OUTSIDE
        beyond[todo[sky]], apart[todo[sky]] = OUTSIDE, 0.3
    return beyond, apart


def crossing(corners: F8, start: F8, way: F8, reach: npt.ArrayLike, margin: float = 0.0) -> Mask:
    """(N,) which rays cross a rectangle within ``reach`` lengths, ``margin`` metres generous."""
    u, v = corners[1] - corners[0], corners[3] - corners[0]
    width, height = float(np.linalg.norm(u)), float(np.linalg.norm(v))
    u, v = u / width, v / height
    normal = np.cross(u, v)
    along = np.asarray(way, dtype=np.float64) @ normal
    with np.errstate(divide="ignore", invalid="ignore"):
        t = ((corners[0] - start) @ normal) / along
        point = start + np.where(np.isfinite(t), t, 0.0)[..., None] * way - corners[0]
    s, r = point @ u, point @ v
    return (
        np.isfinite(t) & (t >= 0.0) & (t <= reach)
        & (s >= -margin) & (s <= width + margin) & (r >= -margin) & (r <= height + margin)
    )  # fmt: skip


def _passes_known(index: int, start: F8, out: F8, free: F8, known: list[Contact]) -> Mask:
    passes = np.zeros(len(start), dtype=bool)
    for contact in known:
        if index in (contact.first, contact.second):
            back = start - 0.3 * out  # a portal may lie a little inside
            reach = np.minimum(free, 1.0) + INSET_M + 0.3
            passes |= crossing(contact.corners, back, out, reach, MARGIN_M)
    return passes


def _seen(clear: RayCaster, seeds: F8, points: F8) -> Mask:
    seen = np.zeros(len(points), dtype=bool)
    for seed in seeds:
        todo = np.flatnonzero(~seen)
        if not len(todo):
            break
        way = points[todo] - seed
        seen[todo] = ~clear.blocked(np.broadcast_to(seed, way.shape), way, 1.0)
    return seen


def _rectangle(side: _Side, box: tuple[slice, slice], corner: float) -> F8:
    """A patch's rectangle, a step wider all round: an edge lies anywhere between two rays.

    Where it reaches an end of its side it goes on by ``corner`` metres: outlines cut corners.
    """
    rows, columns = box
    left = columns.start * STEP_M - (corner if columns.start == 0 else STEP_M)
    at_end = columns.stop == side.inside.shape[1]
    right = columns.stop * STEP_M + (corner if at_end else STEP_M)
    low, high = (rows.start - 1) * STEP_M, (rows.stop + 1) * STEP_M
    plane = np.array([[left, low], [right, low], [right, high], [left, high]])
    return side.origin + plane @ np.stack([side.u, side.v])


def _jamb_middle(clear: RayCaster, corners: F8, out: F8) -> float:
    """How far out of a side the middle of the wall round a window lies, metres."""
    along = corners[1] - corners[0]
    width = float(np.linalg.norm(along))
    offsets = np.arange(0.0, WALL_M, 0.04)
    points = corners.mean(axis=0) + offsets[:, None] * out
    way = np.broadcast_to(along / width, points.shape)
    wide = np.minimum(clear.cast(points, way).t, 9.0) + np.minimum(clear.cast(points, -way).t, 9.0)
    within = np.flatnonzero(wide <= width + 0.25)
    return float(offsets[within].mean()) if len(within) else 0.1


def _kind(contact: Contact, solid: RayCaster, out: F8, passages: Passages) -> OpeningKind:
    """What a patch is: is there somewhere a step through it, half a metre wide?"""
    if contact.second != OUTSIDE:
        return "opening" if passages.through(contact) else "window"
    corners = contact.corners
    u, v = corners[1] - corners[0], corners[3] - corners[0]
    if abs(out[2]) > 0.5 or np.linalg.norm(v) < 1.8:
        return "window"
    s = np.linspace(0.02, 0.98, max(int(np.linalg.norm(u) / 0.1), 2))
    foot = corners[0] + s[:, None] * u
    passes = np.ones(len(s), dtype=bool)
    for high in (0.4, 0.7, 1.0, 1.4, 1.7):
        start = foot + np.array([0.0, 0.0, high]) - 0.25 * out
        passes &= ~solid.blocked(start, np.broadcast_to(out, start.shape), 0.5)
    # where the model ends at its walls there is no ground outside to look for; inside there must
    # be floor up to the wall, and not a window seat
    for inside in (0.3, 0.6, 0.9):
        start = foot + np.array([0.0, 0.0, 0.4]) - inside * out
        passes &= solid.blocked(start, np.broadcast_to([0.0, 0.0, -1.0], start.shape), 0.7)
    run = best = 0
    for free in passes:
        run = run + 1 if free else 0
        best = max(best, run)
    width = float(np.linalg.norm(u))
    if best * width / len(s) < 0.5:
        return "window"
    return "door" if width <= DOOR_M else "opening"


def facing(corners: F8, cell: Cell) -> F8:
    """The corners, turned round where needed so that their normal points into ``cell``."""
    normal = np.cross(corners[2] - corners[0], corners[3] - corners[1])
    normal = normal / np.linalg.norm(normal)
    far = np.array([0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0])[:, None]
    center = corners.mean(axis=0)
    ahead = int(cell.contains(center + far * normal).sum())
    behind = int(cell.contains(center - far * normal).sum())
    if ahead == behind:
        middle = (cell.low + cell.high) / 2.0
        ahead, behind = (1, 0) if (middle - center) @ normal > 0.0 else (0, 1)
    return corners if ahead > behind else corners[::-1].copy()
