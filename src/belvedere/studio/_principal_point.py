"""Does a principal point half a pixel away explain the pictures better than the one given?

A shift ``d`` of the principal point moves the warp from view i to view j by about ``(R_ij - I) d``:
nothing without rotation, a fraction of half a pixel with it. Calibration and pose errors of real
captures are larger than that, so a plain comparison of errors proves nothing. What is done instead:

1. Corners are followed by depth and pose into many views, with their patches reshaped, and aligned
   to some 0.1 px (`follow`).
2. A shift ``(x, y)`` is fitted *together with what else is commonly a little wrong*: both focal
   lengths, the depth scale, radial distortion and the row-by-row exposure of a moving camera.
3. Its uncertainty comes from leaving out one view at a time (pose errors belong to views), plus a
   share of the error that the fit leaves (what the model lacks), plus `CALIBRATION_PX` (principal
   points are calibrated no better).
4. Two hypotheses are weighed, shift (0, 0) and shift (+-0.5, +-0.5): the log of the ratio of their
   likelihoods is the evidence of the pictures.
5. Numbers tell as well: a principal point written exactly at width / 2 is a pixel-corner habit, one
   exactly at (width - 1) / 2 a pixel-centre habit (`written_evidence`). By itself that is not
   enough for an alarm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.scene.pose import invert_pose
from belvedere.studio._matches import Matches, Snapshot, align, join_matches, nearest_value

F8 = npt.NDArray[np.float64]

MAX_PAIRS = 60
CORNERS = 200
"""Corners followed from each view, of the strongest."""
MIN_POINTS = 300
MIN_VIEWS = 4
MAX_TURN = 1.3
"""Radians between two views beyond which patches are not followed."""
CALIBRATION_PX = 0.15
"""Standard error, per axis, of a well-calibrated principal point."""
MODEL_SHARE = 0.3
"""Share of the fit's median error counted as systematic."""
USELESS_PX = 0.6
"""A standard error above this says nothing about half a pixel."""
MISFIT = 12.0
"""Squared standard errors from the asked-for shift beyond which it explains nothing either."""
WRITTEN_TOLERANCE_PX = 0.01
WRITTEN_WEIGHT = 6.0
"""Log odds that a principal point written exactly at a nominal centre gives: of calibrated ones,
spread over 10 px or so, one in a hundred and fifty falls so near by chance."""

PRIOR = {"x": 3.0, "y": 3.0, "fx": 0.02, "fy": 0.02, "scale": 0.03, "radial": 0.05, "rows": 0.1}
"""What is fitted, with standard deviations before looking: pixels, log ratios, 1, frame steps."""
_STEPS = np.array([1e-2, 1e-2, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4])


@dataclass(frozen=True, slots=True)
class ShiftEvidence:
    """What pictures and numbers say about the principal point, in pixels of the views."""

    shift: tuple[float, float] | None
    """Fitted: true minus given; None when it could not be fitted."""
    error: tuple[float, float] | None
    """Standard errors of the shift."""
    points: int
    pictures: float
    """Log likelihood ratio of a shift of ``half`` on both axes against none; 0 = no evidence."""
    written: float
    """Log odds from how the principal point is written."""
    half: float
    """The shift that was asked about: -0.5 or +0.5."""


def written_evidence(
    centers: Sequence[tuple[float, float]], sizes: Sequence[tuple[int, int]], half: float
) -> float:
    """Log odds for a shift of ``half``, from principal points that stand at nominal places.

    Args:
        centers: (cx, cy) as now read, pixel centres at integers.
        sizes: (width, height) of each view.
        half: the shift asked about.
    """

    def nominal(shift: float) -> bool:
        return all(
            min(abs(cx + shift - (w - 1) / 2), abs(cy + shift - (h - 1) / 2)) < WRITTEN_TOLERANCE_PX
            for (cx, cy), (w, h) in zip(centers, sizes, strict=True)
        )

    return WRITTEN_WEIGHT * (float(nominal(half)) - float(nominal(0.0)))


def weigh_shift(snapshots: Sequence[Snapshot], half: float, written: float) -> ShiftEvidence:
    """Fit the principal point's shift and weigh ``half`` on both axes against none.

    Args:
        snapshots: views whose depth and poses have passed the other checks.
        half: -0.5 or +0.5, pixels of the original views.
        written: of `written_evidence`.
    """
    nothing = ShiftEvidence(None, None, 0, 0.0, written, half)
    if len(snapshots) < MIN_VIEWS:
        return nothing
    matches = follow(snapshots)
    if len(matches) < MIN_POINTS:
        return nothing
    fit = _fit(snapshots, matches)
    shrink = snapshots[0].shrink
    shift = fit.shift * shrink
    systematic = MODEL_SHARE * fit.median_px * shrink
    covariance = fit.covariance * shrink**2 + (systematic**2 + CALIBRATION_PX**2) * np.eye(2)
    precision = np.linalg.inv(covariance)
    error = np.sqrt(np.diag(covariance))
    away = shift - half
    ratio = 0.5 * float(shift @ precision @ shift - away @ precision @ away)
    if float(error.min()) > USELESS_PX:
        ratio = 0.0
    elif float(away @ precision @ away) > MISFIT:
        ratio = min(ratio, 0.0)
    return ShiftEvidence(
        (float(shift[0]), float(shift[1])), (float(error[0]), float(error[1])), len(matches),
        ratio, written, half,
    )  # fmt: skip


# ---- following corners by depth and pose ---------------------------------------------------------


def follow(snapshots: Sequence[Snapshot]) -> Matches:
    """Corners of each view found in other views, where depth and pose say, to some 0.1 px."""
    parts: list[tuple[int, int, F8, F8]] = []
    slopes = [_local_planes(s) for s in snapshots]
    for i, j in _turned_pairs(snapshots):
        points = _follow_pair(snapshots[i], snapshots[j], *slopes[i])
        if points is not None:
            parts.append((i, j, *points))
    return join_matches(snapshots, parts)


def _turned_pairs(snapshots: Sequence[Snapshot]) -> list[tuple[int, int]]:
    """Up to `MAX_PAIRS` ordered pairs that may overlap, spread over small and large rotations."""
    found: list[tuple[float, int, int]] = []
    for i, a in enumerate(snapshots):
        h, w = a.depth.shape
        grid = np.stack(np.meshgrid(np.linspace(8, w - 9, 7), np.linspace(8, h - 9, 5)), axis=-1)
        grid = grid.reshape(-1, 2)
        depth = nearest_value(a.depth, grid)
        for j, b in enumerate(snapshots):
            cosine = (np.trace(b.pose[:3, :3].T @ a.pose[:3, :3]) - 1) / 2
            turn = float(np.arccos(np.clip(cosine, -1, 1)))
            if i == j or turn > MAX_TURN:
                continue
            at, _ = _carry(a, b, grid, depth)
            if np.isfinite(nearest_value(b.depth, at)).mean() > 0.15:
                found.append((turn, i, j))
    found.sort()
    keep = np.unique(np.linspace(0, len(found) - 1, MAX_PAIRS).round()) if found else []
    return [found[int(index)][1:] for index in keep]


def _carry(a: Snapshot, b: Snapshot, points: F8, depth: F8) -> tuple[F8, F8]:
    """(n, 2) where points of ``a`` are in ``b``, NaN behind it, and their (n,) depth there."""
    rays = np.column_stack([points, np.ones(len(points))]) @ np.linalg.inv(a.K).T
    move = invert_pose(b.pose) @ a.pose
    there = (rays * depth[:, None]) @ move[:3, :3].T + move[:3, 3]
    with np.errstate(all="ignore"):
        image = (there / np.where(there[:, 2:] > 1e-9, there[:, 2:], np.nan)) @ b.K.T
    return image[:, :2], there[:, 2]


def _local_planes(snapshot: Snapshot) -> tuple[F8, F8, F8]:
    """Corners (n, 2) on smooth surfaces, their disparity (n,) and its slope (n, 2) per pixel."""
    corners = snapshot.corners[:CORNERS]
    u, v = corners.astype(np.intp).T
    with np.errstate(all="ignore"):
        disparity = 1.0 / snapshot.depth
    reach = 3 * np.arange(-1, 2)
    patch = disparity[v[:, None, None] + reach[:, None], u[:, None, None] + reach]
    middle = patch.mean(axis=(1, 2))
    slope = np.column_stack(
        [(patch[:, :, 2] - patch[:, :, 0]).mean(axis=1), (patch[:, 2] - patch[:, 0]).mean(axis=1)]
    ) / (2 * reach[2])
    smooth = np.isfinite(middle) & (middle > 0)
    return corners[smooth], middle[smooth], slope[smooth]


def _follow_pair(
    a: Snapshot, b: Snapshot, corners: F8, disparity: F8, slope: F8
) -> tuple[F8, F8] | None:
    guess, depth = _carry(a, b, corners, 1.0 / disparity)
    with np.errstate(invalid="ignore"):
        step = np.abs(np.log(nearest_value(b.depth, guess) / depth))
    height, width = b.depth.shape
    inside = (np.abs(guess - [width / 2, height / 2]) < [width / 2 - 12, height / 2 - 12]).all(1)
    with np.errstate(invalid="ignore"):
        kept = inside & (step < 0.06)
    if kept.sum() < 12:
        return None
    corners, disparity, slope, guess = corners[kept], disparity[kept], slope[kept], guess[kept]
    reach = 2.0
    with np.errstate(all="ignore"):
        ends = [
            _carry(a, b, corners + reach * unit, 1.0 / (disparity + reach * slope @ unit))[0]
            for unit in np.eye(2)
        ]
        shape = np.stack([(end - guess) / reach for end in ends], axis=-1)
        area = np.linalg.det(shape)
        mild = (area > 0.4) & (area < 2.5) & np.isfinite(shape).all(axis=(1, 2))
    if mild.sum() < 12:
        return None
    corners, guess, shape = corners[mild], guess[mild], shape[mild]
    found, _ = align(a.gray, b.gray, corners, guess, shape, spread=2.0, steps=4)
    found, likeness = align(a.gray, b.gray, corners, found, shape, spread=1.0, steps=4)
    kept = (likeness > 0.88) & (np.linalg.norm(found - guess, axis=1) < 10)
    return (corners[kept], found[kept]) if kept.sum() >= 6 else None


# ---- the fit -------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Fit:
    shift: F8
    covariance: F8
    """(2, 2) from leaving out one view at a time."""
    median_px: float
    parameters: F8


def _velocities(snapshots: Sequence[Snapshot]) -> F8:
    """(views, 6) turn and step per frame in camera axes, by central differences; 0 when large."""
    count = len(snapshots)
    out = np.zeros((count, 6))
    for k in range(count):
        low, high = max(k - 1, 0), min(k + 1, count - 1)
        move = invert_pose(snapshots[low].pose) @ snapshots[high].pose / (high - low)
        turn = np.array([move[2, 1] - move[1, 2], move[0, 2] - move[2, 0], move[1, 0] - move[0, 1]])
        if np.linalg.norm(turn) < 1.0:
            out[k] = [*(turn / 2), *move[:3, 3]]
    return out


class _Residuals:
    """Pixels between where points are and where the parameters put them."""

    def __init__(self, snapshots: Sequence[Snapshot], matches: Matches) -> None:
        self.m = matches
        self.K = np.array([s.K for s in snapshots])
        self.heights = np.array([s.gray.shape[0] for s in snapshots])
        poses = np.array([s.pose for s in snapshots])
        move = np.linalg.inv(poses)[matches.second] @ poses[matches.first]
        self.rotation, self.translation = move[:, :3, :3], move[:, :3, 3]
        self.velocity = _velocities(snapshots)

    def _normalise(self, view: npt.NDArray[np.int64], points: F8, p: F8) -> F8:
        K = self.K[view]
        y = (points[:, 1] - K[:, 1, 2] - p[1]) / (K[:, 1, 1] * np.exp(p[3]))
        x = (points[:, 0] - K[:, 0, 2] - p[0] - K[:, 0, 1] * y) / (K[:, 0, 0] * np.exp(p[2]))
        stretch = 1.0 + p[5] * (x * x + y * y)
        return np.column_stack([x * stretch, y * stretch, np.ones(len(x))])

    def _drift(self, view: npt.NDArray[np.int64], points: F8, p: F8) -> F8:
        row = points[:, 1] / self.heights[view] - 0.5
        return self.velocity[view] * (p[6] * row)[:, None]

    def __call__(self, p: F8) -> F8:
        m = self.m
        here = self._normalise(m.first, m.here, p) * (m.depth_here * np.exp(p[4]))[:, None]
        drift = self._drift(m.first, m.here, p)
        here = here + np.cross(drift[:, :3], here) + drift[:, 3:]
        there = np.einsum("nab,nb->na", self.rotation, here) + self.translation
        drift = self._drift(m.second, m.there, p)
        there = there - np.cross(drift[:, :3], there) - drift[:, 3:]
        seen = self._normalise(m.second, m.there, p)
        focal = self.K[m.second][:, [0, 1], [0, 1]]
        return (seen[:, :2] - there[:, :2] / there[:, 2:]) * focal


def _fit(snapshots: Sequence[Snapshot], matches: Matches) -> _Fit:
    residuals = _Residuals(snapshots, matches)
    prior = 1.0 / np.array(list(PRIOR.values())) ** 2
    p = np.zeros(len(prior))
    width = 1.0
    length = np.zeros(len(matches))
    normal, right, total = (
        np.zeros((3, len(p), len(p)))[:, :1],
        np.zeros((1, len(p))),
        np.diag(prior),
    )
    for step in range(8):
        error = residuals(p)
        length = np.linalg.norm(error, axis=1)
        if step < 4:
            width = max(0.15, 1.2 * float(np.median(length)))
        weight = (1.0 + (length / (2 * width)) ** 2) ** -2 / width**2
        slope = np.stack(
            [(residuals(p + h * unit) - error) / h
             for h, unit in zip(_STEPS, np.eye(len(p)), strict=True)]
        )  # fmt: skip
        # Normal equations view by view: each match counts for both of its views.
        normal = np.einsum("anr,n,bnr->nab", slope, weight, slope, optimize=True)
        right = -np.einsum("anr,n,nr->na", slope, weight, error, optimize=True)
        total = normal.sum(axis=0) + np.diag(prior)
        p = p + np.linalg.solve(total, right.sum(axis=0) - prior * p)
    shifts = []
    views = np.unique(np.concatenate([matches.first, matches.second]))
    for view in views:
        kept = (matches.first != view) & (matches.second != view)
        part = normal[kept].sum(axis=0) + np.diag(prior)
        pull = right[kept].sum(axis=0) - prior * p
        shifts.append(np.linalg.solve(part, pull)[:2])
    spread = np.array(shifts) - np.mean(shifts, axis=0)
    covariance = spread.T @ spread * (len(views) - 1) / len(views)
    covariance += np.linalg.inv(total)[:2, :2]
    return _Fit(p[:2], covariance, float(np.median(length)), p)
