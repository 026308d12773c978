"""Error-driven placement: references where they remove most holes.

What a visitor can see through a portal is sampled: from eyes all over his side, rays through the
portal meet points, and for each candidate reference we ask, with a shadow ray, which of these
points it sees through the same portal. A point that none of the references used for an eye sees is
a hole there. References are added one by one, each the one that leaves fewest holes.

Source: spec portal-walkthrough 7 (automatic next-best reference by hole minimisation).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer, check_number
from belvedere.model import RayCaster
from belvedere.walkthrough.cells import Cell
from belvedere.walkthrough.placement import PlacementOptions, Side, semicircle_eyes
from belvedere.walkthrough.portal_images import eyes_apart
from belvedere.walkthrough.switching import SwitchOptions, closeness

F8 = npt.NDArray[np.float64]

ANGLES, RADII = 9, (0.75, 1.25, 2.0, 3.2)
"""Candidates: on arcs of these radii, metres, at so many angles each."""
ARC_DEG = 140.0
"""From the first to the last candidate, seen from the portal's middle."""
VISITORS = SwitchOptions(angle_deg=60.0, slant_deg=60.0)
"""Where references are placed for visitors: beyond both limits of walks."""
LIFT = 1e-3
"""Metres by which shadow rays start off the surface."""

__all__ = [
    "Holes",
    "candidate_eyes",
    "choose_eyes",
    "measure_holes",
    "place_references",
    "visitor_eyes",
]


@dataclass(frozen=True, eq=False)
class Holes:
    """Which points behind a portal candidates see."""

    candidates: F8
    """(C, 3) eyes that references may have."""
    visitors: F8
    """(E, 3) eyes of visitors."""
    seen: npt.NDArray[np.bool_]
    """(C, E, N): candidate sees the visitor's n-th point."""
    center: F8
    """(3,) the portal's middle."""
    weight: F8
    """(E,) the portal's solid angle for each visitor, as a share of the sum: its part of what all
    visitors see."""

    def mean(self, chosen: list[int], used: int = 2) -> float:
        """Share of holes in what all visitors see through the portal."""
        return float(self.share(chosen, used) @ self.weight)

    def share(self, chosen: list[int], used: int = 2) -> npt.NDArray[np.float64]:
        """(E,) share of holes for each visitor, with the ``used`` nearest of the chosen ones."""
        if not chosen:
            return np.ones(len(self.visitors))
        order = np.argsort(self._apart[:, chosen], axis=1, kind="stable")[:, :used]
        near = np.asarray(chosen)[order]
        visitor = np.arange(len(self.visitors))
        seen = self.seen[near[:, 0], visitor]
        for k in range(1, near.shape[1]):
            seen = seen | self.seen[near[:, k], visitor]
        return 1.0 - seen.mean(axis=1)

    @cached_property
    def _apart(self) -> F8:
        """(E, C) how differently each visitor and each candidate look at the portal."""
        return np.array([eyes_apart(self.center, self.candidates, v) for v in self.visitors])


def candidate_eyes(side: Side, options: PlacementOptions) -> F8:
    """(C, 3) places for references: arcs of several radii before the portal, at eye height."""
    width = float(np.linalg.norm(side.right))
    angles = np.radians(np.linspace(-ARC_DEG / 2.0, ARC_DEG / 2.0, ANGLES))
    right = side.right / width
    rays = np.cos(angles)[:, None] * side.normal + np.sin(angles)[:, None] * right
    eyes = np.concatenate([side.portal.center + r * max(1.0, width) * rays for r in RADII])
    if abs(side.normal[2]) < 0.5:
        eyes[:, 2] = side.floor + options.eye
    return eyes


def visitor_eyes(
    side: Side, cell: Cell, options: PlacementOptions, switch: SwitchOptions, count: int = 24
) -> F8:
    """(E, 3) places in the cell from which the portal is seen and shows pictures.

    Spread evenly over the cell by a golden-ratio lattice; fewer than ``count`` where little of the
    cell lies before the portal and far enough from it, none where nothing does.
    """
    low, high = cell.low[:2], cell.high[:2]
    index = np.arange(16 * count)
    unit = np.stack([(index * 0.7548776662466927) % 1.0, (index * 0.5698402909980532) % 1.0], 1)
    places = np.column_stack([low + unit * (high - low), np.full(len(unit), side.floor)])
    places[:, 2] += options.eye
    inside = cell.contains(places)
    before = (places - side.portal.center) @ side.normal > 0.05
    kept = places[inside & before]
    far = [closeness(side.portal, place, switch) < 1.0 for place in kept[: 4 * count]]
    return kept[: 4 * count][np.array(far, dtype=bool)][:count] if len(kept) else kept


def place_references(
    caster: RayCaster,
    side: Side,
    cell: Cell,
    options: PlacementOptions,
    count: int,
    bound: float = 0.0,
    switch: SwitchOptions | None = None,
    threads: int | None = None,
) -> F8:
    """(N, 3) eyes of at most ``count`` references: where error says, or on the arc.

    The arc is the answer where no visitor of the cell can stand so that pictures are shown. Without
    ``switch``, visitors stand a little nearer and farther aside than where geometry takes over: so
    those in between the sampled ones are on all sides among sampled ones.

    Args:
        caster: of the whole model.
        side: the portal, from the visitors' side.
        cell: the visitors'.
        options: height of eyes, and the arc.
        count: references at most.
        bound: share of holes at which fewer are enough.
        switch: where geometry takes over from pictures; None for `VISITORS`.
        threads: how many to use; None for as many as there are processors.
    """
    visitors = visitor_eyes(side, cell, options, switch or VISITORS)
    if not len(visitors):
        return semicircle_eyes(side, options, count)
    candidates = candidate_eyes(side, options)
    holes = measure_holes(caster, side, candidates, visitors, threads=threads)
    chosen, _ = choose_eyes(holes, bound, count)
    return candidates[chosen]


def measure_holes(
    caster: RayCaster,
    side: Side,
    candidates: F8,
    visitors: F8,
    rays: int = 16,
    threads: int | None = None,
) -> Holes:
    """Sample what visitors see through a portal, and which candidates see it too.

    Args:
        caster: of the whole model.
        side: the portal, from the visitors' side.
        candidates: (C, 3).
        visitors: (E, 3).
        rays: for each visitor ``rays ** 2`` through the portal.
        threads: how many to use; None for as many as there are processors.

    Memory: ``C * E * rays ** 2`` bytes, and 40 times ``E * C`` rays' worth while it runs.
    """
    rays = check_integer("measure_holes", "rays", rays, 1, 1000)
    step = (np.arange(rays) + 0.5) / rays
    s, t = np.meshgrid(step, step)
    on = side.corner + s.reshape(-1, 1) * side.right + t.reshape(-1, 1) * side.down
    seen = np.zeros((len(candidates), len(visitors), len(on)), dtype=bool)
    for e, visitor in enumerate(visitors):
        along = on - visitor
        hit = caster.cast(on, along, threads)  # what stands before the portal is not asked
        sky = ~np.isfinite(hit.t)
        seen[:, e, sky] = True  # everybody who looks through sees the same sky
        at = np.flatnonzero(~sky)
        points = on[at] + hit.t[at, None] * along[at]
        points -= LIFT * along[at] / np.linalg.norm(along[at], axis=1, keepdims=True)
        seen[:, e, at] = _see_through(caster, side, candidates, points, threads)
    arms = visitors - side.portal.center
    angle = np.abs(arms @ side.normal) / np.linalg.norm(arms, axis=1) ** 3
    return Holes(candidates, visitors, seen, side.portal.center, angle / max(angle.sum(), 1e-12))


def _see_through(
    caster: RayCaster, side: Side, eyes: F8, points: F8, threads: int | None
) -> npt.NDArray[np.bool_]:
    """(C, N) whether each of C eyes sees each of N points beyond a portal, through it."""
    towards = (eyes[:, None] - points).reshape(-1, 3)
    starts = np.broadcast_to(points, (len(eyes), *points.shape)).reshape(-1, 3)
    height = (starts - side.portal.center) @ side.normal
    rise = towards @ side.normal
    share = np.divide(-height, rise, out=np.full(len(starts), -1.0), where=rise > 1e-9)
    cross = starts + share[:, None] * towards - side.corner
    x = cross @ side.right / (side.right @ side.right)
    y = cross @ side.down / (side.down @ side.down)
    through = (share >= 0.0) & (share <= 1.0) & (x >= 0) & (x <= 1) & (y >= 0) & (y <= 1)
    result = np.zeros(len(starts), dtype=bool)
    at = np.flatnonzero(through & (share > 1e-9))
    # only up to the portal: what stands before it is not asked
    reach = np.maximum(share[at] - 1e-6, 1e-9)
    result[at] = ~caster.blocked(starts[at], towards[at], reach, threads)
    result[through & (share <= 1e-9)] = True
    return result.reshape(len(eyes), len(points))


def choose_eyes(
    holes: Holes, bound: float = 0.01, budget: int = 6, used: int = 2
) -> tuple[list[int], list[float]]:
    """Add the reference that leaves fewest holes, until few enough are left or the budget is spent.

    Args:
        holes: from `measure_holes`.
        bound: share of holes, in what all visitors see, that is good enough.
        budget: references at most.
        used: how many of them a frame warps.

    Returns:
        Indices of candidates in the order they were added, and the share of holes after each.

    Raises:
        InputError: a bound outside [0, 1] or a budget below 1.
    """
    bound = check_number("choose_eyes", "bound", bound, 0.0, 1.0)
    budget = check_integer("choose_eyes", "budget", budget, 1, 10_000)
    chosen: list[int] = []
    left: list[float] = []
    while len(chosen) < min(budget, len(holes.candidates)) and (not left or left[-1] > bound):
        rest = [k for k in range(len(holes.candidates)) if k not in chosen]
        means = [holes.mean([*chosen, k], used) for k in rest]
        best = int(np.argmin(means))
        if left and means[best] >= left[-1]:
            break
        chosen.append(rest[best])
        left.append(means[best])
    return chosen, left
