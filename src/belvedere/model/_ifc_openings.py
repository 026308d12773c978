"""An IFC's doors, windows and plain openings as rectangles between rooms.

          host wall, seen from above
=========+             +=============
         |---- width --|   ^ thickness: the rectangle stands in its middle
=========+             +=============
 room on one side: points beyond the wall are looked up in the rooms' outlines
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.model._ifc_rooms import inside
from belvedere.model._ifc_shapes import Shape
from belvedere.model.building import Opening, OpeningKind, Room
from belvedere.model.report import Report

F8 = npt.NDArray[np.float64]

HOSTS = ("IfcWall", "IfcSlab", "IfcRoof", "IfcCurtainWall", "IfcPlate", "IfcCovering")
"""What an opening that nothing fills must lie in to join rooms; holes in furniture do not."""
SMALL_M = 0.3
"""Plain openings smaller than this are for pipes."""
REACH_M = (0.05, 0.15, 0.3, 0.6)
"""How far beyond a wall's faces a room is looked for."""
SLACK_M = 0.02
"""How much an opening may fall short of its host's faces and still go through."""


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """Where an opening lies."""

    corners: F8
    """(4, 3) the rectangle, the lower two first."""
    normal: F8
    """(3,) through it."""
    thickness: float
    """Of what it goes through, metres."""
    through: bool
    """Whether it goes through all of its host; True where that is not known."""


@dataclass(frozen=True, slots=True, eq=False)
class Hole:
    """An opening before its rooms are known."""

    element: Any
    """The door or window, or the opening element where nothing fills it."""
    kind: OpeningKind
    """Whether people walk through."""
    frame: Frame
    """Where it lies."""


def holes_of(model: Any, shapes: dict[int, Shape], report: Report) -> list[Hole]:
    """All doors and windows, and plain openings through walls, floors and roofs."""
    found: list[Hole] = []
    filled: set[int] = set()
    small = blind = 0
    for opening in sorted(model.by_type("IfcOpeningElement"), key=lambda o: o.id()):
        host = opening.VoidsElements[0].RelatingBuildingElement if opening.VoidsElements else None
        fillers = [rel.RelatedBuildingElement for rel in opening.HasFillings or ()]
        shape = shapes.get(opening.id())
        for filler in fillers or [None]:
            kind = _kind(filler)
            if shape is None or kind is None:
                continue
            axis = None if filler is None or filler.id() not in shapes else shapes[filler.id()].axes
            frame = frame_of(shape, None if axis is None else axis[1], _host_points(host, shapes))
            if filler is not None:
                filled.add(filler.id())
            elif host is None or not any(host.is_a(name) for name in HOSTS):
                continue
            elif not frame.through:
                blind += 1
                continue
            elif _size(frame).min() < SMALL_M:
                small += 1
                continue
            found.append(Hole(filler or opening, kind, frame))
    for element in (*model.by_type("IfcDoor"), *model.by_type("IfcWindow")):
        if element.id() not in filled and element.id() in shapes:
            shape = shapes[element.id()]
            kind = _kind(element)
            assert kind is not None
            found.append(Hole(element, kind, _own_frame(shape)))
    plain = [h for h in found if h.kind == "opening"]
    filled_too = {id(h) for h in plain if any(_same_place(h, o) for o in found if o is not h)}
    found = [h for h in found if id(h) not in filled_too]
    report.count(small, "opening", "openings", f"smaller than {SMALL_M} m: for pipes, left out")
    report.count(blind, "recess", "recesses", "not through the whole wall: no opening")
    return found


def frame_of(shape: Shape, through: F8 | None, host: F8) -> Frame:
    """The rectangle of an opening's body.

    Args:
        shape: the body, near enough a box.
        through: (3,) the filler's own y axis, which leads through it; None where nothing fills it.
        host: (N, 3) points of what it lies in; may be none.
    """
    axes = _box_axes(shape)
    own = np.stack([shape.vertices @ a for a in axes])
    low, high = own.min(axis=1), own.max(axis=1)
    k = int(np.argmin(high - low))
    covers = np.zeros(3, dtype=bool)
    far = np.stack([host @ a for a in axes])
    if len(host):
        covers = (low <= far.min(axis=1) + SLACK_M) & (high >= far.max(axis=1) - SLACK_M)
    along = -1 if through is None else int(np.abs(axes @ through).argmax())
    if covers.any() and not (along >= 0 and covers[along]):
        k = int(np.argmin(np.where(covers, np.ptp(far, axis=1), np.inf)))
    elif along >= 0:
        k = along
    first, last = low[k], high[k]
    if len(host) and far[k].max() > first and far[k].min() < last:
        first, last = max(first, far[k].min()), min(last, far[k].max())
    return _rectangle(axes, low, high, k, first, last, bool(covers[k]) or not len(host))


def openings_of(
    holes: list[Hole], rooms: dict[int, Room], boundaries: dict[int, set[int]], report: Report
) -> tuple[Opening, ...]:
    """The openings with the rooms on both sides.

    Args:
        holes: where the openings lie.
        rooms: by the id of their space.
        boundaries: ids of the spaces that the IFC itself relates to an element.
        report: told where the IFC and its geometry disagree.
    """
    found: list[Opening] = []
    within = unlike = 0
    often = Counter(str(hole.element.Name or hole.element.is_a()) for hole in holes)
    for hole in holes:
        sides = [_room_beside(hole.frame, sign, rooms) for sign in (1.0, -1.0)]
        stated = {k for k in boundaries.get(hole.element.id(), set()) if k in rooms}
        sides = _completed(sides, stated, hole.frame, rooms)
        if stated and not stated >= {k for k in sides if k is not None}:
            unlike += 1
        if sides[0] == sides[1] and (hole.kind == "opening" or sides[0] is not None):
            within += 1
            continue
        name = str(hole.element.Name or hole.element.is_a())
        if often[name] > 1:
            name = f"{name} #{hole.element.id()}"
        pair = tuple(None if k is None else rooms[k].name for k in sides)
        found.append(Opening(name, hole.kind, hole.frame.corners, (pair[0], pair[1])))
    report.count(within, "opening", "openings", "with one room, or none, on both sides: left out")
    report.count(
        unlike, "opening", "openings", "whose rooms differ from the IFC's space boundaries: its "
        "geometry is believed",
    )  # fmt: skip
    return tuple(found)


def space_boundaries(model: Any) -> dict[int, set[int]]:
    """For each element the ids of the spaces that the IFC says it bounds."""
    found: dict[int, set[int]] = {}
    for relation in model.by_type("IfcRelSpaceBoundary"):
        element, space = relation.RelatedBuildingElement, relation.RelatingSpace
        if element is not None and space is not None:
            found.setdefault(element.id(), set()).add(space.id())
    return found


def _same_place(plain: Hole, other: Hole) -> bool:
    """Whether a door or window fills what another element has as a plain opening too."""
    a, b = plain.frame, other.frame
    apart = float(np.linalg.norm(a.corners.mean(axis=0) - b.corners.mean(axis=0)))
    return other.kind != "opening" and apart < 0.25 * float(_size(a).min()) + a.thickness / 2.0


def _kind(filler: Any) -> OpeningKind | None:
    if filler is None:
        return "opening"
    if filler.is_a("IfcDoor"):
        return "door"
    return "window" if filler.is_a("IfcWindow") else None


def _host_points(host: Any, shapes: dict[int, Shape]) -> F8:
    """(N, 3) points of an element and of the parts it is made of."""
    if host is None:
        return np.zeros((0, 3))
    parts = [host]
    for relation in getattr(host, "IsDecomposedBy", ()) or ():
        parts.extend(relation.RelatedObjects)
    found = [shapes[part.id()].vertices for part in parts if part.id() in shapes]
    return np.concatenate(found) if found else np.zeros((0, 3))


def _own_frame(shape: Shape) -> Frame:
    """The rectangle of a door or window that fills no opening: its own box."""
    own = np.stack([shape.vertices @ a for a in shape.axes])
    low, high = own.min(axis=1), own.max(axis=1)
    return _rectangle(shape.axes, low, high, 1, low[1], high[1], True)


def _rectangle(
    axes: F8, low: F8, high: F8, k: int, first: float, last: float, through: bool
) -> Frame:
    others = [j for j in range(3) if j != k]
    others.sort(key=lambda j: abs(axes[j][2]))  # the steeper one last
    across, up = others
    corners = np.empty((4, 3))
    rise = (low[up], high[up]) if axes[up][2] >= 0.0 else (high[up], low[up])
    for n, (a, b) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
        corners[n] = (
            (low[across], high[across])[a] * axes[across]
            + rise[b] * axes[up]
            + (first + last) / 2.0 * axes[k]
        )
    return Frame(corners, axes[k], float(last - first), through)


def _box_axes(shape: Shape) -> F8:
    """(3, 3) unit normals of a box-like body's faces, the largest pair of faces first."""
    a, b, c = np.moveaxis(shape.corners, 1, 0)
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    unit: F8 = np.asarray(normal / np.maximum(area, 1e-30)[:, None], np.float64)
    near = np.abs(unit @ unit.T) > 0.99
    first = unit[int((near @ area).argmax())]
    square = np.abs(unit @ first) < 0.1
    if square.any():
        second = unit[int(np.where(square, near @ area, -1.0).argmax())]
    else:
        second = np.cross(first, np.eye(3)[int(np.abs(first).argmin())])
    second = np.asarray(second - (second @ first) * first, np.float64)
    second /= np.linalg.norm(second)
    return np.stack([first, second, np.cross(first, second)]).astype(np.float64)


def _size(frame: Frame) -> F8:
    """(2,) width and height, metres."""
    c = frame.corners
    return np.array([np.linalg.norm(c[1] - c[0]), np.linalg.norm(c[3] - c[0])], np.float64)


def _room_beside(frame: Frame, sign: float, rooms: dict[int, Room]) -> int | None:
    """The room on one side: the nearest that most probe points lie in."""
    c = frame.corners
    spread = np.array([[s, t] for s in (0.2, 0.5, 0.8) for t in (0.2, 0.5, 0.8)])
    points = c[0] + spread[:, :1] * (c[1] - c[0]) + spread[:, 1:] * (c[3] - c[0])
    for reach in REACH_M:
        probes = points + sign * (frame.thickness / 2.0 + reach) * frame.normal
        votes: dict[int, int] = {}
        for key, room in rooms.items():
            level = (probes[:, 2] > room.floor) & (probes[:, 2] < room.ceiling)
            count = int((level & inside(room.rings, probes[:, :2])).sum()) if level.any() else 0
            if count:
                votes[key] = count
        if votes:
            return max(votes, key=lambda key: (votes[key], rooms[key].floor, -key))
    return None


def _completed(
    sides: list[int | None], stated: set[int], frame: Frame, rooms: dict[int, Room]
) -> list[int | None]:
    """Sides that no outline reaches, from what the IFC states, if that lies on that side."""
    left = sorted(stated - {k for k in sides if k is not None})
    center = frame.corners.mean(axis=0)
    for n, sign in enumerate((1.0, -1.0)):
        if sides[n] is not None:
            continue
        for key in left:
            room = rooms[key]
            corners = np.concatenate(room.rings)
            middle = np.array([*corners.mean(axis=0), (room.floor + room.ceiling) / 2.0])
            apart = _distance(room.rings, center[:2])
            if sign * float((middle - center) @ frame.normal) > 0.0 and (
                apart < float(_size(frame).max()) + frame.thickness
            ):
                sides[n] = key
                left.remove(key)
                break
    return sides


def _distance(rings: tuple[F8, ...], point: F8) -> float:
    """From a point to the nearest place of any ring, metres."""
    best = np.inf
    for ring in rings:
        along = np.roll(ring, -1, axis=0) - ring
        length = np.maximum((along**2).sum(axis=1), 1e-30)
        share = np.clip(((point - ring) * along).sum(axis=1) / length, 0.0, 1.0)
        best = min(best, float(np.linalg.norm(ring + share[:, None] * along - point, axis=1).min()))
    return best
