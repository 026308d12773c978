"""Are a capture's numbers read the right way? Neighbouring views tell.

The commonest mistake with RGB-D data is a wrong depth scale or pose convention. Views of one scene
must agree with each other, so each way of reading the numbers can be tried, and one that makes
disagreeing views agree is named together with the option that mends it.

**Evidence.** Corners matched between views from their pixels alone (`_matches`) are predicted under
each reading (`_hypotheses`): 3 kinds of depth x 2 pose directions x 2 axes, each with the current
scale and with a fitted one (`_search`). A point scores ``1 / (1 + (e / a)^2) / (1 + (r / b)^2)``
for an error of ``e`` pixels and a depth ratio of ``exp(r)``; ``a`` and ``b`` are 2.5 times the
median errors of the best reading, so noisy captures are judged by their own noise. Where texture is
too poor, or views too far apart, for matches, depth and brightness are compared where the points
of a grid land; that takes three views and a wider margin. Views must overlap; a scale
needs a baseline (halving or doubling it must cost 10 % of the score); a single view says nothing.

**Strength.** A mistake is named when its reading scores at least `MARGIN` higher than the current
one, explains `ENOUGH` of the points, improves most pairs of views and has no rival within `RIVAL`;
two mistakes at once only when they score `MARGIN` above every single one. A scale within 8 % of
the current one is no mistake. Otherwise the verdict is "agree", or "cannot tell" with the reason.

**Half a pixel** is judged last, of captures that pass the rest by their matches, and by its own
evidence (`_principal_point`): log odds of the pictures (a joint fit with jackknifed errors) and of
how the principal point is written, against a prior of `HALF_PRIOR`. On hand-held captures the
pictures alone cannot resolve half a pixel: the standard error is then one or two pixels. An alarm
that rests on the numbers alone says so; one that has neither evidence is not raised.

The constants in capitals are in `_judgement`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import InputError
from belvedere.scene.camera import Camera
from belvedere.scene.conventions import Conventions
from belvedere.studio._hypotheses import Evidence
from belvedere.studio._judgement import ConventionReport, judge, with_shift
from belvedere.studio._matches import Matches, Snapshot, find_matches, join_matches, take_snapshot
from belvedere.studio._principal_point import (
    weigh_shift,
    written_evidence,
)
from belvedere.studio._search import search

MAX_VIEWS = 20
"""Views loaded at most."""
MIN_MATCHES = 40
"""Fewer matches than this are not evidence: points of a grid serve instead."""
MAX_GRID_POINTS = 2000
"""Grid points compared, when matches are too few."""


class ViewLike(Protocol):
    """What is needed of a view: see `belvedere.scene.ReferenceView`."""

    @property
    def camera(self) -> Any: ...  # noqa: D102
    @property
    def color(self) -> npt.NDArray[Any]: ...  # noqa: D102
    @property
    def disparity(self) -> npt.NDArray[Any]: ...  # noqa: D102


class ViewsLike(Protocol):
    """A sequence of views that may load each when asked: a list, or a `belvedere.scene.ViewSet`."""

    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> ViewLike: ...


def check_conventions(views: ViewsLike, current: Conventions) -> ConventionReport:
    """Warp views into each other and say which way of reading the numbers makes them agree.

    Args:
        views: reference views as now read, of one scene; planar cameras. At most `MAX_VIEWS` are
            loaded, one at a time. Frames of one sequence should be in order.
        current: how they were read, with a concrete ``depth_scale``.

    Returns:
        A report; its ``line`` is for people. Deterministic. About 2 s for 20 views of 540 x 360.

    Raises:
        InputError: ``current.depth_scale`` is None.
    """
    if current.depth_scale is None:
        raise InputError(
            "check_conventions: current.depth_scale is None, expected metres per stored unit: "
            "use Conventions.resolved"
        )
    if len(views) < 2:
        return ConventionReport(
            "cannot tell", "a single view: conventions show only between views", views=len(views)
        )
    chosen = choose_views(len(views))
    snapshots: list[Snapshot] = []
    centers: list[tuple[float, float]] = []
    sizes: list[tuple[int, int]] = []
    for index in chosen:
        view = views[index]
        if not isinstance(view.camera, Camera):
            return ConventionReport(
                "cannot tell",
                f"view {index} has a {type(view.camera).__name__}: only planar cameras are checked",
            )
        snapshots.append(take_snapshot(view))
        K = view.camera.intrinsics
        centers.append((float(K[0, 2]), float(K[1, 2])))
        sizes.append((view.camera.width, view.camera.height))
    if sum(bool(np.isfinite(s.depth).any()) for s in snapshots) < 2:
        return ConventionReport(
            "cannot tell", "fewer than two views have depth: nothing to compare", views=len(chosen)
        )
    evidence = _gather(snapshots, current)
    if evidence is None:
        return ConventionReport(
            "cannot tell",
            "no two views were found to show the same surfaces: nothing to compare",
            views=len(chosen),
        )
    result = search(evidence, current, snapshots[0].gray.shape[1])
    report = judge(evidence, result, current, len(chosen))
    if report.verdict != "agree" or report.basis != "matches":
        return report
    half = -0.5 if current.pixel_centers == "integer" else 0.5
    shift = weigh_shift(snapshots, half, written_evidence(centers, sizes, half))
    return with_shift(report, shift, current, centers[0], sizes[0])


def choose_views(count: int) -> list[int]:
    """Which views to load: all of a few; else runs with growing gaps, spread over the sequence."""
    if count <= MAX_VIEWS:
        return list(range(count))
    gaps = [0, 1, 3, 6, 10]
    starts = np.linspace(0, count - 1 - gaps[-1], MAX_VIEWS // len(gaps)).astype(int)
    return sorted({int(start) + gap for start in starts for gap in gaps})


# ---- evidence ------------------------------------------------------------------------------------


def _gather(snapshots: Sequence[Snapshot], current: Conventions) -> Evidence | None:
    matches = find_matches(snapshots)
    if len(matches) >= MIN_MATCHES:
        return Evidence(snapshots, matches, current, dense=False)
    if len(snapshots) < 3:  # depth and brightness of one pair of views agree by chance too often
        return None
    grid = _grid_points(snapshots)
    return Evidence(snapshots, grid, current, dense=True) if len(grid) >= MIN_MATCHES else None


def _grid_points(snapshots: Sequence[Snapshot]) -> Matches:
    """Points on a grid, of each view towards its neighbours in the sequence."""
    parts = []
    for i, snapshot in enumerate(snapshots):
        height, width = snapshot.depth.shape
        u, v = np.meshgrid(np.linspace(4, width - 5, 14), np.linspace(4, height - 5, 10))
        points = np.column_stack([u.ravel(), v.ravel()]).round()
        known = np.isfinite(snapshot.depth[points[:, 1].astype(int), points[:, 0].astype(int)])
        points = points[known]
        near = [j for j in (i - 2, i - 1, i + 1, i + 2) if 0 <= j < len(snapshots)]
        share = max(1, -(-len(points) * 4 * len(snapshots) // MAX_GRID_POINTS))
        for j in near:
            part = points[(i + j) % share :: share]
            parts += [(i, j, part, part)] if len(part) else []
    return join_matches(snapshots, parts)


__all__ = ["ConventionReport", "ViewLike", "ViewsLike", "check_conventions", "choose_views"]
