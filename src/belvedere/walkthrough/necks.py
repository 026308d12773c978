"""A rectangle in each neck that is a door or an opening between walls, found with rays.

    from above            from the side
      wall                  ceiling ______  ______
    ######  left jamb                    | |  lintel
    ######                     head      |_|
     - - +  plane                         :  plane: middle of the lintel, or of the narrow part
    ######                                :
    ######  right jamb      floor  _______:______

A neck is no door when its jambs do not go up to its head (a cupboard), when they belong to a wall
that just goes on (a corridor), or when nothing narrows. Over two metres it must lie between the
free ends of two walls.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.model.raycast import RayCaster
from belvedere.scene.mesh import Mesh

F8 = npt.NDArray[np.float64]

DOOR_M = 2.0
"""No door is wider."""
WIDEST_M, NARROWEST_M = 3.5, 0.45
"""An opening between the ends of two walls may be, but not wider than this."""
DEEPEST_M = 0.7
"""A wall is no thicker."""
LINTEL_M = 0.08
"""How far a head lies below the ceilings on its sides, at least."""
RECEDE_M = 0.1
"""How far walls draw back beside a jamb, at least."""
BEHIND_M = 0.35
"""A wall goes on so far behind its jamb, at least: a post does not."""
STEP_M = 0.01
"""Between rays across a wall."""
REACH_M = 12.0

__all__ = ["Neck", "fit_neck", "wall_ends"]


@dataclass(frozen=True, slots=True, eq=False)
class Neck:
    """A door-like opening."""

    left: F8
    """(2,) jamb, metres."""
    right: F8
    """(2,) the other jamb."""
    floor: float
    """Height of the sill."""
    head: float
    """Height of the lintel, or of the ceiling where there is none."""
    depth: float
    """Thickness of the wall."""
    lintel: bool
    """Whether something bounds it from above."""

    @property
    def width(self) -> float:
        """Clear width, metres."""
        return float(np.linalg.norm(self.right - self.left))

    @property
    def center(self) -> F8:
        """(2,) the middle in plan."""
        return (self.left + self.right) / 2.0

    @property
    def corners(self) -> F8:
        """(4, 3) the rectangle."""
        a, b = self.left, self.right
        return np.array([[*a, self.floor], [*b, self.floor], [*b, self.head], [*a, self.head]])


class _Probe:
    """Rays from points near a neck."""

    def __init__(self, caster: RayCaster, band: float) -> None:
        self.caster, self.band = caster, band

    def sideways(self, points: F8, directions: F8, height: float) -> F8:
        start = np.column_stack([points, np.full(len(points), height)])
        along = np.column_stack([directions, np.zeros(len(directions))])
        return np.minimum(self.caster.cast(start, along, 1).t.astype(np.float64), REACH_M)

    def spans(self, points: F8, direction: F8, height: float) -> tuple[F8, F8]:
        """Free lengths to the left (against ``direction``) and to the right of points."""
        way = np.broadcast_to(direction, points.shape)
        both = self.sideways(np.concatenate([points, points]), np.concatenate([-way, way]), height)
        return both[: len(points)], both[len(points) :]

    def ceilings(self, points: F8) -> F8:
        start = np.column_stack([points, np.full(len(points), self.band)])
        up = np.broadcast_to([0.0, 0.0, 1.0], start.shape)
        t = self.caster.cast(start, up, 1).t.astype(np.float64)
        return self.band + np.minimum(t, REACH_M)


def fit_neck(
    caster: RayCaster, at: F8, floor: float, head: float = 1.9, along: F8 | None = None
) -> Neck | None:
    """The opening round a point, or None if there is none that is like a door.

    Args:
        caster: the building without door leaves.
        at: (2,) a point in the middle of a neck.
        floor: height of the floor there.
        head: height above the floor that is free.
        along: (2,) unit vector from jamb to jamb where it is known; else the shortest way across.
    """
    probe = _Probe(caster, floor + head - 0.06)
    cut = _cut_across(probe, at, along)
    if cut is not None:  # again from the middle of the wall, where the angle is sharp
        cut = _cut_across(probe, cut.middle, along)
    if cut is None or cut.depth > DEEPEST_M or _is_wedge(cut):
        return None
    a = cut.line[cut.center] - cut.left[cut.center] * cut.along
    b = cut.line[cut.center] + cut.right[cut.center] * cut.along
    heads = probe.ceilings(a + np.linspace(0.1, 0.9, 9)[:, None] * (b - a))
    neck = Neck(a, b, floor, float(heads.max()), cut.depth, cut.lintel)
    if not NARROWEST_M <= neck.width <= WIDEST_M:
        return None
    if neck.lintel and np.median(heads) > cut.tops[cut.center] + 0.3:
        return None  # a lamp, no lintel
    through = cut.through
    if not _jambs_stand(probe, neck, cut.along, floor, head):
        return None
    if not _walls_go_on(probe, neck, cut.along, through) or _is_aslant(probe, neck, cut.along):
        return None
    # without a head, or wider than a door: only between the ends of two walls
    if neck.lintel and neck.width <= DOOR_M:
        return neck
    recedes = _recedes(probe, neck, cut.along, through)
    return neck if recedes.any(axis=0).all() and recedes.sum() >= 3 else None


@dataclass(frozen=True, slots=True, eq=False)
class _Cut:
    """What rays see along a line across the wall, through the middle of a neck."""

    along: F8
    """(2,) from jamb to jamb."""
    line: F8
    """(N, 2) points a centimetre apart."""
    left: F8
    """(N,) free length against ``along``."""
    right: F8
    """(N,) free length along it."""
    tops: F8
    """(N,) heights of the ceiling."""
    span: tuple[int, int]
    """First and last point within the wall."""
    lintel: bool
    """Whether the wall goes on above."""

    @property
    def through(self) -> F8:
        """(2,) across the wall."""
        return np.array([-self.along[1], self.along[0]])

    @property
    def center(self) -> int:
        """The point in the middle of the wall."""
        return round((self.span[0] + self.span[1]) / 2)

    @property
    def middle(self) -> F8:
        """(2,) halfway between the jambs there."""
        k = self.center
        return self.line[k] + self.along * (self.right[k] - self.left[k]) / 2.0

    @property
    def depth(self) -> float:
        """Thickness of the wall, metres."""
        return STEP_M * (self.span[1] - self.span[0])


def _cut_across(probe: _Probe, at: F8, along: F8 | None) -> _Cut | None:
    middle = at
    if along is None:
        found = _narrowest(probe, at)
        if found is None:
            return None
        middle, along = found
    steps = round(DEEPEST_M / STEP_M)
    offsets = STEP_M * np.arange(-steps, steps + 1)
    line = middle + offsets[:, None] * np.array([-along[1], along[0]])
    left, right = probe.spans(line, along, probe.band)
    width, tops = left + right, probe.ceilings(line)
    low = _run(tops <= tops[steps] + 0.03, steps)
    lintel = _is_lintel(low, tops, steps)
    span = low if lintel else _run(width <= width[steps] + 0.03, steps)
    return _Cut(along, line, left, right, tops, span, lintel)


def wall_ends(
    caster: RayCaster, at: F8, floor: F8, toward: F8, head: float = 1.9
) -> tuple[npt.NDArray[np.intp], F8, F8]:
    """Which of N points beside something in the way lie before the end of a wall.

    Args:
        caster: the building without door leaves.
        at: (N, 2) points.
        floor: (N,) heights of their floors.
        toward: (N, 2) directions to what is in the way.
        head: height above the floor that is free.

    Returns:
        Indices (K,) of such points, (K, 2) middles between the wall's end and what faces it,
        and (K, 2) unit vectors across.
    """
    height = floor + head - 0.06
    start = np.column_stack([at, height])
    hits = caster.cast(start, np.column_stack([toward, np.zeros(len(at))]))
    reached = np.flatnonzero((hits.face >= 0) & (hits.t * np.linalg.norm(toward, axis=1) < 0.3))
    normal = _normals(caster.mesh, hits.face[reached])[:, :2]
    size = np.linalg.norm(normal, axis=1)
    reached, normal = reached[size > 0.9], normal[size > 0.9]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    normal *= np.where((normal * toward[reached]).sum(axis=1) > 0.0, -1.0, 1.0)[:, None]
    tangent = np.column_stack([-normal[:, 1], normal[:, 0]])

    def free(shift: float, way: F8) -> F8:
        origin = start[reached] + shift * np.column_stack([tangent, np.zeros(len(reached))])
        along = np.column_stack([way, np.zeros(len(reached))])
        return np.minimum(caster.cast(origin, along).t.astype(np.float64), REACH_M)

    to_end, across = free(0.0, -normal), free(0.0, normal)
    ends = np.minimum(free(0.3, -normal), free(-0.3, -normal)) > to_end + 0.3
    ends &= (to_end + across <= WIDEST_M) & (to_end + across >= NARROWEST_M)
    middle = at[reached] + normal * ((across - to_end) / 2.0)[:, None]
    return reached[ends], middle[ends], normal[ends]


def _normals(mesh: Mesh, face: npt.NDArray[np.int32]) -> F8:
    """(N, 3) unit normals of some faces."""
    a, b, c = (mesh.vertices[mesh.faces[face, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)


def _narrowest(probe: _Probe, at: F8) -> tuple[F8, F8] | None:
    """Middle of the shortest line from wall to wall through a point, and its direction."""
    middle = at
    angles, along = np.arange(0.0, np.pi, np.pi / 60), np.zeros(2)
    for _ in range(3):
        ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        points = np.broadcast_to(middle, ways.shape)
        both = probe.sideways(
            np.concatenate([points, points]), np.concatenate([-ways, ways]), probe.band
        )
        left, right = both[: len(ways)], both[len(ways) :]
        best = int(np.argmin(left + right))
        if left[best] + right[best] > WIDEST_M + 0.2:
            return None
        along = ways[best]
        middle = middle + along * (right[best] - left[best]) / 2.0
        step = angles[1] - angles[0]
        angles = angles[best] + np.linspace(-1.5 * step, 1.5 * step, 31)
    return middle, along


def _run(mask: npt.NDArray[np.bool_], start: int) -> tuple[int, int]:
    """First and last of the Trues around ``start``."""
    first = last = start
    while first > 0 and mask[first - 1]:
        first -= 1
    while last + 1 < len(mask) and mask[last + 1]:
        last += 1
    return first, last


def _is_lintel(low: tuple[int, int], tops: F8, middle: int) -> bool:
    """Whether the ceiling over the neck is a strip with higher ones on both sides."""
    if low[0] == 0 or low[1] == len(tops) - 1 or STEP_M * (low[1] - low[0]) > DEEPEST_M:
        return False
    before = np.median(tops[max(low[0] - 12, 0) : low[0]])
    behind = np.median(tops[low[1] + 1 : low[1] + 13])
    return bool(min(before, behind) - tops[middle] >= LINTEL_M)


def _jambs_stand(probe: _Probe, neck: Neck, along: F8, floor: float, head: float) -> bool:
    """Whether something stands at both jambs from near the floor up to the head."""
    middle = ((neck.left + neck.right) / 2.0)[None]
    half = neck.width / 2.0
    top = neck.head if neck.head < probe.band + REACH_M - 1.0 else floor + 2.6
    heights = np.concatenate(
        [np.linspace(floor + 0.35, floor + head - 0.2, 6), np.linspace(floor + head, top - 0.06, 5)]
    )
    stands = np.zeros(2)
    for k, height in enumerate(heights):
        left, right = probe.spans(middle, along, float(height))
        near = np.array([left[0], right[0]]) <= half + 0.1
        if k >= 6 and not near.all():
            return False
        stands += near
    return bool((stands >= len(heights) - 1).all())


def _walls_go_on(probe: _Probe, neck: Neck, along: F8, through: F8) -> bool:
    """Whether a wall follows behind both jambs, or a side wall comes first; posts stand alone."""
    away, beyond = neck.depth / 2.0 + 0.15, neck.width / 2.0 + BEHIND_M
    side = np.array([[-away], [away]]) * through
    free = np.stack(probe.spans(neck.center + side, along, probe.band), axis=1)
    for k, way in enumerate((-along, along)):
        start = np.column_stack([neck.center + way * beyond + side, np.full(2, probe.band)])
        back = np.column_stack([-side / away, np.zeros(2)])
        wall = probe.caster.blocked(start, back, 2.0 * away, 1)
        if not (wall | (free[:, k] < beyond)).any():
            return False
    return True


def _is_aslant(probe: _Probe, neck: Neck, along: F8) -> bool:
    """Whether it meets a jamb at a slant: from a corner to a wall that just goes on."""
    slanted = np.ones(2, dtype=bool)
    for height in (probe.band, probe.band - 0.5):
        start = np.array([[*neck.center, height]] * 2)
        way = np.array([[*along, 0.0], [*-along, 0.0]])
        face = probe.caster.cast(start, way, 1).face
        # straight on, or along a knife's edge, is as it should be
        meet = np.abs(_normals(probe.caster.mesh, face)[:, :2] @ along)
        slanted &= (meet > 0.26) & (meet < 0.96)
    return bool(slanted.any())


def _is_wedge(cut: _Cut) -> bool:
    """Whether it gets narrower still to one side: the corner of a room."""
    first, last = cut.span
    width = cut.left + cut.right
    before, behind = width[max(first - 12, 0) : first], width[last + 1 : last + 13]
    least = float(width[first : last + 1].min()) - 0.05
    return any(len(part) > 0 and float(np.median(part)) < least for part in (before, behind))


def _recedes(probe: _Probe, neck: Neck, along: F8, through: F8) -> npt.NDArray[np.bool_]:
    """(2, 2) whether the walls draw back before and behind (rows) the left and right jamb."""
    middle = (neck.left + neck.right) / 2.0
    away = neck.depth / 2.0 + 0.12
    points = middle + np.array([[-away], [away]]) * through
    left, right = probe.spans(points, along, probe.band)
    return np.stack([left, right], axis=1) > neck.width / 2.0 + RECEDE_M
