"""How well a way of reading a capture's numbers explains the matches between its pictures.

A reading turns the depth ``Z`` as now read, the pose as now read and one gain ``g`` into a
prediction: where in the second view a matched point should be, and how deep. ``basis`` is the
depth at gain 1:

    z          Z' = g * raw            raw: the stored value, up to the current scale
    ray        Z' = g * raw / |ray|    |ray|: length of the ray that reaches unit depth
    disparity  Z' = g / raw
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.scene.conventions import Axes, Conventions, DepthKind, PoseKind
from belvedere.scene.pose import OPENCV_FROM_OPENGL, invert_pose
from belvedere.studio._matches import Matches, Snapshot, nearest_value

F8 = npt.NDArray[np.float64]

DEPTH_TOLERANCE = 0.05
"""Relative depth difference at which a point counts half, unless the capture is better."""


MIN_OVERLAP = 0.15
"""Share of grid points that must land on known depth before their agreement means anything."""
SHADE = 20.0
"""Difference of grey levels, of 255, at which a grid point counts half."""


@dataclass(frozen=True, slots=True)
class Reading:
    """One way to read the numbers, the gain aside."""

    depth_kind: DepthKind
    pose: PoseKind
    axes: Axes


class Evidence:
    """The matched points of a capture, ready to be read in any way.

    With too few matches, points on a grid serve instead: for them the depth and the brightness
    where they land are compared, and landing outside the picture counts as a miss.
    """

    def __init__(
        self, snapshots: Sequence[Snapshot], matches: Matches, current: Conventions, *, dense: bool
    ) -> None:
        self.snapshots = snapshots
        self.matches = matches
        self.dense = dense
        self.scale = float(current.depth_scale or 1.0)
        self.current = Reading(current.depth_kind, current.pose, current.axes)
        inverse = np.linalg.inv(np.array([s.K for s in snapshots])).astype(np.float64)
        self._K = np.array([s.K for s in snapshots])
        self._ray_here = _rays(inverse, matches.first, matches.here)
        self._ray_there = _rays(inverse, matches.second, matches.there)
        self._shade = np.zeros(len(matches))
        for index in np.unique(matches.first) if dense else ():
            part = matches.first == index
            shade = snapshots[index].gray.astype(np.float64)
            self._shade[part] = nearest_value(shade, matches.here[part])
        self._moves: dict[tuple[PoseKind, Axes], tuple[F8, F8]] = {}

    # ---- reading ----------------------------------------------------------------------------

    def gain(self, depth_kind: DepthKind, scale: float) -> float:
        """The gain that a depth scale means."""
        return 1.0 / scale if depth_kind == "disparity" else scale

    def _raw(self, depth: F8, rays: F8) -> F8:
        """Stored values, from z-depth as now read."""
        if self.current.depth_kind == "disparity":
            return 1.0 / (depth * self.scale)
        length = np.linalg.norm(rays, axis=-1) if self.current.depth_kind == "ray" else 1.0
        return depth * length / self.scale

    def _basis(self, depth_kind: DepthKind, depth: F8, rays: F8) -> F8:
        raw = self._raw(depth, rays)
        if depth_kind == "disparity":
            return 1.0 / raw
        return raw / np.linalg.norm(rays, axis=-1) if depth_kind == "ray" else raw

    def typical_gain(self, depth_kind: DepthKind) -> float:
        """The gain that keeps the median depth as it is now read."""
        depth = self.matches.depth_here
        basis = self._basis(depth_kind, depth, self._ray_here)
        return float(np.median(depth) / np.median(basis))

    def motion(self, reading: Reading) -> tuple[F8, F8]:
        """(n, 3, 3) rotations and (n, 3) translations, second camera from first camera."""
        key = (reading.pose, reading.axes)
        if key not in self._moves:
            poses = np.array([self._reread(s.pose, reading) for s in self.snapshots])
            back = np.array([invert_pose(pose) for pose in poses])
            first, second = self.matches.first, self.matches.second
            both = np.einsum("nab,nbc->nac", back[second], poses[first])
            self._moves[key] = (both[:, :3, :3], both[:, :3, 3])
        return self._moves[key]

    def _reread(self, pose: F8, reading: Reading) -> F8:
        raw = pose @ OPENCV_FROM_OPENGL if self.current.axes == "opengl" else pose
        if reading.pose != self.current.pose:
            raw = invert_pose(raw)
        return raw @ OPENCV_FROM_OPENGL if reading.axes == "opengl" else raw

    # ---- judging ----------------------------------------------------------------------------

    def errors(self, reading: Reading, gains: npt.ArrayLike) -> tuple[F8, F8]:
        """What a reading gets wrong, for several gains at once.

        Args:
            reading: how the numbers are read.
            gains: (k,) gains.

        Returns:
            (k, n) distances in pixels from where the match is, infinite behind the camera, and
            (k, n) absolute log ratios of the two depths (NaN where the second view has none). Grid
            points have no match: their distance is infinite outside the picture, and inside it
            one tolerance for `SHADE` grey levels of difference.
        """
        m = self.matches
        rotation, translation = self.motion(reading)
        basis = self._basis(reading.depth_kind, m.depth_here, self._ray_here)
        turned = np.einsum("nab,nb->na", rotation, self._ray_here * basis[:, None])
        gain = np.atleast_1d(np.asarray(gains, dtype=np.float64))[:, None]
        point = gain[..., None] * turned + translation
        with np.errstate(all="ignore"):
            depth = point[..., 2]
            K = self._K[m.second]
            v = point[..., 1] / depth * K[:, 1, 1] + K[:, 1, 2]
            u = (K[:, 0, 0] * point[..., 0] + K[:, 0, 1] * point[..., 1]) / depth + K[:, 0, 2]
            ahead = depth > 1e-9
            if self.dense:
                seen, shade = self._look_up(reading, u, v)
                distance = np.where(ahead, shade / SHADE, np.inf)
            else:
                distance = np.hypot(u - m.there[:, 0], v - m.there[:, 1])
                distance = np.where(ahead, distance, np.inf)
                seen = self._basis(reading.depth_kind, m.depth_there, self._ray_there)
            ratio = np.abs(np.log(np.where(ahead, depth, np.nan) / (gain * seen)))
        return distance, ratio

    def _look_up(self, reading: Reading, u: F8, v: F8) -> tuple[F8, F8]:
        """(k, n) basis depth where points land, and the grey level's difference: inf outside."""
        seen = np.full(u.shape, np.nan)
        differs = np.full(u.shape, np.inf)
        for index in np.unique(self.matches.second):
            part = np.flatnonzero(self.matches.second == index)
            snapshot = self.snapshots[index]
            points = np.stack([u[:, part], v[:, part]], axis=-1).reshape(-1, 2)
            depth = nearest_value(snapshot.depth, points)
            rays = np.column_stack([points, np.ones(len(points))]) @ np.linalg.inv(snapshot.K).T
            basis = self._basis(reading.depth_kind, depth, rays)
            seen[:, part] = basis.reshape(len(u), -1)
            shade = nearest_value(snapshot.gray.astype(np.float64), points).reshape(len(u), -1)
            differs[:, part] = np.nan_to_num(np.abs(shade - self._shade[part]), nan=np.inf)
        return seen, differs

    def scores(
        self,
        reading: Reading,
        gains: npt.ArrayLike,
        tolerance_px: float,
        depth_tolerance: float = DEPTH_TOLERANCE,
    ) -> F8:
        """(k, n) from 0 to 1: how well each point is explained. 1 is exactly.

        A point counts half at ``tolerance_px`` pixels, or at a relative ``depth_tolerance``.
        """
        distance, ratio = self.errors(reading, gains)
        missing = np.isnan(ratio)
        ratio = np.where(missing, 0.0, ratio)
        near = 1.0 / (1.0 + (distance / (1.0 if self.dense else tolerance_px)) ** 2)
        score = near / (1.0 + (ratio / depth_tolerance) ** 2)
        # A grid point that lands where the second view has no depth says nothing for or against.
        return np.where(missing & np.isfinite(distance), 0.25, score) if self.dense else score

    def agreement(
        self, reading: Reading, gain: float, tolerance_px: float, depth_tolerance: float
    ) -> float:
        """Share of points within ``tolerance_px`` and ``depth_tolerance``, for people to read."""
        distance, ratio = self.errors(reading, gain)
        fits = (distance < (2.0 if self.dense else tolerance_px)) & ~(ratio > depth_tolerance)
        if self.dense:  # of the points that land where there is depth, if those are not too few
            known = np.isfinite(ratio) & np.isfinite(distance)
            return float(fits[known].mean()) if known.mean() >= MIN_OVERLAP else 0.0
        return float(fits.mean()) if fits.size else 0.0


def _rays(inverse: F8, view: npt.NDArray[Any], points: F8) -> F8:
    """(n, 3) rays of unit depth in camera axes."""
    homogeneous = np.column_stack([points, np.ones(len(points))])
    return np.einsum("nab,nb->na", inverse[view], homogeneous)
