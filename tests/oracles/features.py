"""Slow twin of features looked up backwards: one pixel, one reference, one sample after another."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from belvedere.scene import Camera, Frame
from belvedere.warp import PreparedView
from belvedere.warp._edges import INTACT, MIXED, SMOOTH
from tests.oracles.warp import project_samples

F8 = npt.NDArray[np.float64]
TAP_TOLERANCE = 0.05
BESIDE_EDGES = 0.05
"""What a reference counts there."""


def look_up_features(
    frame: Frame, views: Sequence[PreparedView], tolerance: float, kind: str
) -> F8:
    """(H, W, C) features of a frame's covered pixels, NaN elsewhere; views the nearest first."""
    away = [float(np.linalg.norm(one.camera.center - frame.camera.center)) for one in views]
    floor = 0.05 * sum(away) / len(away)
    nearness = [1.0 / (d * d + floor * floor) for d in away]
    channels = views[0].view.features.shape[2]  # type: ignore[union-attr]
    out = np.full((*frame.coverage.shape, channels), np.nan)
    for y, x in np.argwhere(frame.coverage > 0):
        delta = float(frame.disparity[y, x])
        seeing = []
        for view, near in zip(views, nearness, strict=True):
            place = _land(frame, view, x, y, delta)
            if place is None:
                continue
            u, v, there = place
            weight = near * _seen(view, u, v, there, tolerance)
            if weight > 0:
                seeing.append((weight, view, place))
        if not seeing:
            continue  # nobody confirms it: the kernel takes what fits best
        if kind == "nearest":
            seeing = [max(seeing, key=lambda one: one[0])]
        total = sum(weight for weight, _, _ in seeing)
        out[y, x] = sum(w / total * _taps(v, p[0], p[1], p[2], kind) for w, v, p in seeing)
    return out


def _land(
    frame: Frame, view: PreparedView, x: int, y: int, delta: float
) -> tuple[float, float, float] | None:
    assert isinstance(frame.camera, Camera)
    assert isinstance(view.camera, Camera)
    u, v, d = (float(a) for a in project_samples(frame.camera, view.camera, x, y, delta))
    height, width = view.disparity.shape
    if not (-0.5 <= u <= width - 0.5 and -0.5 <= v <= height - 0.5):
        return None
    return u, v, d


def _seen(view: PreparedView, u: float, v: float, delta: float, tolerance: float) -> float:
    """1 inside a surface that agrees, less beside an edge, 0 where it does not."""
    surface, links = view.surface().astype(float), view.links()
    height, width = surface.shape
    i, j = min(max(math.floor(u), 0), width - 2), min(max(math.floor(v), 0), height - 2)
    cell = surface[j : j + 2, i : i + 2]
    if links[j, i] & INTACT:
        along = cell[:, 0] + (cell[:, 1] - cell[:, 0]) * (u - i)
        here = along[0] + (along[1] - along[0]) * (v - j)
        if abs(here - delta) > tolerance * delta + np.ptp(cell) / 2:
            return 0.0
        return 1.0 if links[j, i] & SMOOTH else BESIDE_EDGES
    fits = abs(cell - delta) <= TAP_TOLERANCE * delta
    fits &= (links[j : j + 2, i : i + 2] & MIXED) == 0
    return BESIDE_EDGES if fits.any() else 0.0


def _taps(view: PreparedView, u: float, v: float, delta: float, kind: str) -> F8:
    surface, links = view.surface().astype(float), view.links()
    features = view.view.features
    assert features is not None
    height, width = surface.shape
    i, j = math.floor(u), math.floor(v)
    smooth = 0 <= i < width and 0 <= j < height and bool(links[j, i] & SMOOTH)
    total, weights, nearest = np.zeros(features.shape[2]), 0.0, (math.inf, 0, 0)
    for row in range(max(j - 1, 0), min(j + 3, height)):
        for column in range(max(i - 1, 0), min(i + 3, width)):
            reach = _kernel(u - column, kind) * _kernel(v - row, kind)
            if kind != "nearest" and reach == 0:
                continue
            if not smooth and not abs(surface[row, column] - delta) <= TAP_TOLERANCE * delta:
                continue
            total += reach * features[row, column]
            weights += reach
            nearest = min(nearest, (math.hypot(u - column, v - row), row, column))
    if kind == "nearest" or weights < 0.5:
        return features[nearest[1], nearest[2]].astype(float)
    return total / weights


def _kernel(distance: float, kind: str) -> float:
    """Linear, or Keys' cubic with a = -1/2, which is Catmull and Rom's."""
    t = abs(distance)
    if kind == "linear":
        return max(1.0 - t, 0.0)
    if t < 1:
        return 1.5 * t**3 - 2.5 * t**2 + 1
    return -0.5 * t**3 + 2.5 * t**2 - 4 * t + 2 if t < 2 else 0.0
