"""The free floor of a room while it is furnished: where a piece may stand so that people get by.

The floor is a grid of squares. Pieces keep off doors and off windows that they would cover; a place
is taken only when a person can still walk between all doors of the room afterwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.model.architecture import Side
from belvedere.model.charts import Rect
from belvedere.model.plan import SIDES, Door, HousePlan, RoomPlan, Window, span_of

SQUARE = 0.05
"""Metres."""
BODY = 0.38
"""Half the width that a walker needs, metres: a little more than half of 0.7."""
DOOR_DEPTH = 0.85
"""In front of a door nothing stands this near."""
REACHED = 0.85
"""Share of the floor that fits a walker which can be reached from the doors."""
YAW: dict[Side, float] = {"north": 0.0, "west": 90.0, "south": 180.0, "east": -90.0}
"""Turn of a piece whose back is to that wall, degrees."""


@dataclass(frozen=True, slots=True)
class Spot:
    """Where a piece stands: its origin and turn."""

    x: float
    """Metres."""
    y: float
    """Metres."""
    yaw: float
    """Degrees."""
    side: Side = "north"
    """The wall behind it."""


class Space:
    """A room's floor and walls as they fill up."""

    def __init__(self, plan: HousePlan, room: RoomPlan, rng: np.random.Generator) -> None:
        self.room, self.rect, self._rng = room, room.rect, rng
        x0, y0, x1, y1 = self.rect
        self._shape = (int(np.ceil((x1 - x0) / SQUARE)), int(np.ceil((y1 - y0) / SQUARE)))
        self._taken = np.zeros(self._shape, dtype=bool)
        self._kept = np.zeros(self._shape, dtype=bool)
        self._openings = {
            side: [hole for hole in plan.openings_of(room, side) if hole[1] < plan.height]
            for side in SIDES
        }
        self._tall: dict[Side, list[tuple[float, float]]] = {side: [] for side in SIDES}
        self._doors: list[tuple[float, float]] = []
        for side in SIDES:
            for low, _, high, _, what in self._openings[side]:
                if isinstance(what, Door):
                    self._keep(self._off(side, low - 0.12, high + 0.12, DOOR_DEPTH))
                    self._tall[side].append((low - 0.11, high + 0.11))
                    self._doors.append(_middle(self._off(side, low, high, 2.0 * BODY + 0.1)))
                else:
                    self._tall[side].append((low - 0.08, high + 0.08))
        if plan.entrance is not None and plan.entrance[0] == room.name:
            _, side, at = plan.entrance
            self._keep(self._off(side, at - 0.7, at + 0.7, 1.1))
            self._tall[side].append((at - 0.7, at + 0.7))
            self._doors.append(_middle(self._off(side, at - 0.5, at + 0.5, 2.0 * BODY + 0.1)))
        void, stair = plan.void(), plan.stair
        if void is not None and stair is not None and stair.room == room.name:
            low, high = void[3] - stair.width, void[3]
            self._take((void[0] - 0.1, low - 0.05, stair.foot + 0.1, high))
            self._keep((stair.foot, low - 0.1, stair.foot + 1.0, high))
            self._doors.append((stair.foot + 0.5, high - stair.width / 2.0))
            self._tall["north"].append((void[0], stair.foot + 0.1))

    def windows(self) -> list[tuple[Side, float, float, Window]]:
        """(side, low, high, window) of the room's windows."""
        return [
            (side, low, high, what)
            for side in SIDES
            for low, _, high, _, what in self._openings[side]
            if isinstance(what, Window)
        ]

    def against_wall(
        self,
        width: float,
        depth: float,
        height: float = 0.8,
        front: float = 0.0,
        where: str = "any",
        sides: Sequence[Side] = (),
    ) -> Spot | None:
        """A place for a piece with its back to a wall; None where there is none.

        Args:
            width: along the wall, metres.
            depth: off the wall.
            height: what is higher than a sill does not stand before the window.
            front: depth of floor before it that other pieces leave free.
            where: ``"middle"`` of the wall, its ``"corner"``, or ``"any"``.
            sides: which walls may be taken, the best first; all when empty.
        """
        order = list(sides) or [SIDES[k] for k in self._rng.permutation(4)]
        for side in order:
            low, high = span_of(self.room, side)
            gap = 0.03
            places = np.arange(low + gap + width / 2.0, high - gap - width / 2.0 + 1e-9, 0.05)
            middle = (low + high) / 2.0
            if where == "any":
                places = self._rng.permutation(places)
            else:
                sign = 1.0 if where == "middle" else -1.0
                places = places[np.argsort(sign * np.abs(places - middle), kind="stable")]
            for at in places:
                span = (float(at) - width / 2.0, float(at) + width / 2.0)
                if self._hides(side, span, height):
                    continue
                area = self._off(side, *span, depth + 0.02)
                before = self._off(side, *span, depth + front)
                if self._fits(area, before):
                    self._take(area)
                    self._keep(before)
                    if height > 1.1:
                        self._tall[side].append(span)
                    x, y = self.point_on(side, float(at))
                    return Spot(x, y, YAW[side], side)
        return None

    def inside(self, width: float, depth: float, margin: float = 0.0) -> Spot | None:
        """A place in the middle of the room, or as near to it as may be; turned if that fits."""
        x0, y0, x1, y1 = self.rect
        long_x = (x1 - x0) >= (y1 - y0)
        for turned in (not long_x, long_x):
            w, d = (depth, width) if turned else (width, depth)
            xs = np.arange(x0 + w / 2.0 + margin, x1 - w / 2.0 - margin, 0.15)
            ys = np.arange(y0 + d / 2.0 + margin, y1 - d / 2.0 - margin, 0.15)
            if not len(xs) or not len(ys):
                continue
            gx, gy = (g.ravel() for g in np.meshgrid(xs, ys))
            off = np.hypot(gx - (x0 + x1) / 2.0, gy - (y0 + y1) / 2.0)
            for k in np.argsort(off, kind="stable"):
                x, y = float(gx[k]), float(gy[k])
                area = (x - w / 2, y - d / 2, x + w / 2, y + d / 2)
                if self._fits(area, area):
                    self._take(area)
                    return Spot(x, y, 90.0 if turned else 0.0)
        return None

    def on_wall(
        self, width: float, sides: Sequence[Side] = (), where: str = "middle"
    ) -> Spot | None:
        """A place on a wall for a picture or a lamp, clear of doors, windows, tall furniture."""
        order = list(sides) or [SIDES[k] for k in self._rng.permutation(4)]
        for side in order:
            low, high = span_of(self.room, side)
            places = np.arange(low + 0.15 + width / 2.0, high - 0.15 - width / 2.0 + 1e-9, 0.05)
            middle = (low + high) / 2.0
            if where == "any":
                places = self._rng.permutation(places)
            else:
                places = places[np.argsort(np.abs(places - middle), kind="stable")]
            for at in places:
                span = (float(at) - width / 2.0, float(at) + width / 2.0)
                if any(a < span[1] + 0.05 and span[0] < c + 0.05 for a, c in self._tall[side]):
                    continue
                self._tall[side].append(span)
                x, y = self.point_on(side, float(at))
                return Spot(x, y, YAW[side], side)
        return None

    def cover(self, side: Side, low: float, high: float) -> None:
        """Nothing more hangs on this part of a wall, and nothing tall stands before it."""
        self._tall[side].append((low, high))

    def take_under_window(self, side: Side, low: float, high: float, depth: float) -> bool:
        """Take the floor under a window for a radiator or curtains, if it is free."""
        area = self._off(side, low, high, depth)
        if not self._fits(area, area):
            return False
        self._take(area)
        return True

    def _hides(self, side: Side, span: tuple[float, float], height: float) -> bool:
        for low, z0, high, _, what in self._openings[side]:
            room = isinstance(what, Window) and height <= z0 - 0.04
            if not room and span[0] < high + 0.08 and low - 0.08 < span[1]:
                return True
        return any(height > 1.1 and span[0] < c and a < span[1] for a, c in self._tall[side])

    def point_on(self, side: Side, at: float) -> tuple[float, float]:
        """The point of a wall at a coordinate along it."""
        x0, y0, x1, y1 = self.rect
        return {"north": (at, y1), "south": (at, y0), "east": (x1, at), "west": (x0, at)}[side]

    def _off(self, side: Side, low: float, high: float, depth: float) -> Rect:
        x0, y0, x1, y1 = self.rect
        return {
            "north": (low, y1 - depth, high, y1),
            "south": (low, y0, high, y0 + depth),
            "east": (x1 - depth, low, x1, high),
            "west": (x0, low, x0 + depth, high),
        }[side]

    def _squares(self, area: Rect) -> tuple[slice, slice]:
        x0, y0, _, _ = self.rect
        low = np.floor((np.array([area[0] - x0, area[1] - y0]) + 1e-6) / SQUARE).astype(int)
        high = np.ceil((np.array([area[2] - x0, area[3] - y0]) - 1e-6) / SQUARE).astype(int)
        low = np.maximum(low, 0)
        high = np.maximum(high, low)
        return slice(int(low[0]), int(high[0])), slice(int(low[1]), int(high[1]))

    def _take(self, area: Rect) -> None:
        self._taken[self._squares(area)] = True

    def _keep(self, area: Rect) -> None:
        self._kept[self._squares(area)] = True

    def _fits(self, area: Rect, before: Rect) -> bool:
        part, more = self._squares(area), self._squares(before)
        if (self._taken | self._kept)[part].any() or self._taken[more].any():
            return False
        trial = self._taken.copy()
        trial[part] = True
        return self._passable(trial)

    def _passable(self, taken: npt.NDArray[np.bool_]) -> bool:
        """Whether a walker gets from every door to every other, and to most of the room."""
        from scipy import ndimage

        if len(self._doors) == 0:
            return True
        far = np.asarray(ndimage.distance_transform_edt(np.pad(~taken, 1)))
        label = np.asarray(ndimage.label(far[1:-1, 1:-1] * SQUARE > BODY)[0])  # type: ignore[index]
        x0, y0, _, _ = self.rect
        found = set()
        for x, y in self._doors:
            i = min(max(int((x - x0) / SQUARE), 0), self._shape[0] - 1)
            j = min(max(int((y - y0) / SQUARE), 0), self._shape[1] - 1)
            near = label[max(i - 3, 0) : i + 4, max(j - 3, 0) : j + 4]
            found.add(int(near.max()))
        if len(found) != 1 or 0 in found:
            return False
        area = np.bincount(label.ravel())[1:]
        return bool(area[found.pop() - 1] >= REACHED * area.sum())


def _middle(area: Rect) -> tuple[float, float]:
    return (area[0] + area[2]) / 2.0, (area[1] + area[3]) / 2.0
