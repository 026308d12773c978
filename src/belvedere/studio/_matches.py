"""Which pixels of two pictures show the same point, found without believing camera or depth.

Corners (Shi and Tomasi) with plain 8 x 8 patch descriptors, matched mutually with a ratio test and
then aligned to a fraction of a pixel (Lucas and Kanade). Kept plain on purpose: neighbouring views
of a capture differ little, and a match that depends on no convention can judge all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

F8 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int64]

WORK_SIDE = 800
"""Pictures with a longer side are shrunk by a whole factor first; convention errors are gross."""
FEATURES = 400
"""Corners kept in a view, the strongest first."""
BORDER = 16
"""Pixels kept free at the edge, so that every patch lies inside."""
MATCHES_PER_PAIR = 80
"""The best matches kept of one pair of views, so that no pair outvotes the others."""
MIN_PAIR = 8
"""Pairs with fewer mutual matches are left out: what they hold is mostly chance."""
DEPTH_STEP = 1.1
"""A corner beside a larger jump of depth than this ratio is left out: which side is it on?"""


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """One view as the check works on it: grey, shrunk by a whole factor, depth as now read."""

    K: F8
    """(3, 3), pixels of the shrunk picture, centres at integers."""
    pose: F8
    """(4, 4) camera to world, as now read."""
    gray: npt.NDArray[np.float32]
    """(h, w) 0 to 255, lightly smoothed."""
    depth: F8
    """(h, w) z-depth as now read; NaN where there is none."""
    shrink: int
    """Pixels of the view along one side of a pixel here."""
    corners: F8
    """(n, 2) u, v of the corners that have depth, strongest first."""
    descriptors: npt.NDArray[np.float32]
    """(n, 64) unit vectors."""


@dataclass(frozen=True, slots=True, eq=False)
class Matches:
    """Points seen by two views, all pairs in one: arrays of one length."""

    pair: I8
    """Index of the pair it belongs to, from 0."""
    first: I8
    second: I8
    """Indices of the snapshots."""
    here: F8
    """(n, 2) u, v in the first view."""
    there: F8
    """(n, 2) u, v in the second."""
    depth_here: F8
    depth_there: F8
    """z-depth as now read; NaN where the second view has none."""

    def __len__(self) -> int:
        return len(self.pair)


def take_snapshot(view: Any) -> Snapshot:
    """The working copy of a reference view with a planar camera.

    Args:
        view: has ``camera`` (planar), ``color`` (H, W, 3|4) uint8 or linear float32, and
            ``disparity`` (H, W), 1/metre, NaN = none.
    """
    from scipy import ndimage

    color = np.asarray(view.color)[..., :3]
    shrink = max(1, -(-max(color.shape[:2]) // WORK_SIDE))
    height, width = color.shape[0] // shrink * shrink, color.shape[1] // shrink * shrink
    if color.dtype != np.uint8:  # linear radiance: roughly what an eye sees, 0 to 255
        color = 255 * np.sqrt(np.clip(color, 0, 1))
    gray = color[:height, :width].astype(np.float32) @ np.array([0.3, 0.59, 0.11], np.float32)
    gray = gray.reshape(height // shrink, shrink, width // shrink, shrink).mean(axis=(1, 3))
    disparity = np.asarray(view.disparity, dtype=np.float64)
    disparity = disparity[shrink // 2 : height : shrink, shrink // 2 : width : shrink]
    with np.errstate(all="ignore"):
        depth = np.where(np.isfinite(disparity) & (disparity > 0), 1.0 / disparity, np.nan)
    K = view.camera.intrinsics.copy()
    K[:2, 2] -= (shrink - 1) / 2
    K[:2] /= shrink
    corners, descriptors = _corners(gray, depth)
    smooth = np.asarray(ndimage.gaussian_filter(gray, 1.0), dtype=np.float32)
    return Snapshot(K, view.camera.camera_to_world, smooth, depth, shrink, corners, descriptors)


def _corners(gray: npt.NDArray[np.float32], depth: F8) -> tuple[F8, npt.NDArray[np.float32]]:
    from scipy import ndimage

    smooth = ndimage.gaussian_filter(gray, 1.0)
    gx, gy = ndimage.sobel(smooth, 1) / 8, ndimage.sobel(smooth, 0) / 8
    xx, xy, yy = (ndimage.gaussian_filter(p, 2.0) for p in (gx * gx, gx * gy, gy * gy))
    strength = (xx + yy) / 2 - np.sqrt(((xx - yy) / 2) ** 2 + xy * xy)
    low = ndimage.minimum_filter(np.where(np.isnan(depth), -1.0, depth), 5)
    high = ndimage.maximum_filter(np.where(np.isnan(depth), np.inf, depth), 5)
    peak = (ndimage.maximum_filter(strength, 9) == strength) & (strength > 0.5)
    peak &= (low > 0) & (high < DEPTH_STEP * low)
    inside = np.zeros_like(peak)
    inside[BORDER:-BORDER, BORDER:-BORDER] = True
    v, u = np.nonzero(peak & inside)
    order = np.argsort(-strength[v, u], kind="stable")[:FEATURES]
    v, u = v[order], u[order]
    blurred = ndimage.gaussian_filter(gray, 2.0)
    step = np.arange(8) * 4 - 14
    patch = blurred[v[:, None, None] + step[:, None], u[:, None, None] + step].reshape(-1, 64)
    patch = patch - patch.mean(axis=1, keepdims=True)
    patch /= np.linalg.norm(patch, axis=1, keepdims=True) + 1e-6
    return np.column_stack([u, v]).astype(np.float64), patch.astype(np.float32)


def nearest_value(values: F8, points: F8) -> F8:
    """(n,) values of an (h, w) map at the pixels nearest to (n, 2) points; NaN outside."""
    with np.errstate(invalid="ignore"):
        column, row = np.floor(points.T + 0.5)
        inside = (column >= 0) & (row >= 0) & (column < values.shape[1]) & (row < values.shape[0])
    u = np.where(inside, column, 0).astype(np.intp)
    v = np.where(inside, row, 0).astype(np.intp)
    return np.where(inside, values[v, u], np.nan)


def align(
    here: npt.NDArray[np.float32],
    there: npt.NDArray[np.float32],
    start: F8,
    guess: F8,
    shape: F8 | None = None,
    *,
    spread: float = 1.0,
    steps: int = 6,
) -> tuple[F8, F8]:
    """Where the patches around ``start`` in one picture lie in another, to a fraction of a pixel.

    Args:
        here: (h, w) first picture.
        there: (h, w) second picture.
        start: (n, 2) patch centres in the first.
        guess: (n, 2) about where they are in the second, within some 3 ``spread`` pixels.
        shape: (n, 2, 2) what the patches' offsets become in the second picture; None: unchanged.
        spread: pixels between the 9 x 9 samples of a patch.
        steps: Gauss-Newton steps.

    Returns:
        (n, 2) positions in the second picture, and (n,) correlation there, -1 to 1.

    Source: Lucas and Kanade 1981, with brightness and contrast of each patch divided out.
    """
    from scipy import ndimage

    axis = np.arange(-4, 5) * spread
    offset = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    weight = np.exp(-(offset**2).sum(axis=1) / (2 * (2.6 * spread) ** 2))
    weight /= weight.sum()
    moved = np.broadcast_to(offset, (len(start), *offset.shape))
    if shape is not None:
        moved = np.einsum("nab,kb->nka", shape, offset)

    def sample(image: Any, points: Any) -> Any:
        return ndimage.map_coordinates(image, [points[..., 1], points[..., 0]], order=1,
                                       mode="nearest", output=np.float64)  # fmt: skip

    def centred(values: Any) -> Any:
        return values - (values @ weight)[:, None]

    at = start[:, None] + offset
    patch = centred(sample(here, at))
    contrast = np.sqrt((patch**2) @ weight) + 1e-6
    slope = np.stack(
        [sample(here, at + half) - sample(here, at - half) for half in 0.5 * np.eye(2)],
        axis=-1,
    )
    if shape is not None:  # the gradient as the second picture has it
        slope = np.einsum("nkb,nba->nka", slope, np.linalg.inv(shape))
    slope -= np.einsum("nka,k->na", slope, weight)[:, None]
    normal = np.einsum("nka,k,nkb->nab", slope, weight, slope) + 1e-6 * np.eye(2)
    gain = np.linalg.inv(normal)
    found = guess.copy()
    for _ in range(steps):
        other = centred(sample(there, found[:, None] + moved))
        error = other * (contrast / (np.sqrt((other**2) @ weight) + 1e-6))[:, None] - patch
        step = -np.einsum("nab,nkb,nk,k->na", gain, slope, error, weight, optimize=True)
        length = np.linalg.norm(step, axis=1, keepdims=True)
        found += step * np.minimum(1.0, 1.5 * spread / (length + 1e-9))
    other = centred(sample(there, found[:, None] + moved))
    spread_there = np.sqrt((other**2) @ weight) + 1e-6
    return found, ((patch * other) @ weight) / (contrast * spread_there)


def _match_pair(a: Snapshot, b: Snapshot) -> tuple[F8, F8] | None:
    """(n, 2) corners of ``a`` and where they are in ``b``; None when the views share too few."""
    if min(len(a.corners), len(b.corners)) < MIN_PAIR:
        return None
    likeness = a.descriptors @ b.descriptors.T
    index = np.arange(len(likeness))
    best = likeness.argmax(axis=1)
    top = likeness[index, best]
    mutual = likeness.argmax(axis=0)[best] == index
    likeness[index, best] = -1
    good = mutual & (top > 0.8) & (1 - top < 0.6 * (1 - likeness.max(axis=1)))
    if good.sum() < MIN_PAIR:
        return None
    order = np.flatnonzero(good)
    order = order[np.argsort(-top[order], kind="stable")][:MATCHES_PER_PAIR]
    start, guess = a.corners[order], b.corners[best[order]]
    found, correlation = align(a.gray, b.gray, start, guess)
    kept = (correlation > 0.8) & (np.linalg.norm(found - guess, axis=1) < 4)
    return (start[kept], found[kept]) if kept.sum() >= MIN_PAIR else None


def find_matches(snapshots: Sequence[Snapshot]) -> Matches:
    """All matches of all pairs of views that share enough of them."""
    parts: list[tuple[int, int, F8, F8]] = []
    for i, a in enumerate(snapshots):
        for j in range(i + 1, len(snapshots)):
            points = _match_pair(a, snapshots[j])
            if points is not None:
                parts.append((i, j, *points))
    return join_matches(snapshots, parts)


def join_matches(
    snapshots: Sequence[Snapshot], parts: Sequence[tuple[int, int, F8, F8]]
) -> Matches:
    """One `Matches` of (first, second, here (n, 2), there (n, 2)) for each pair."""
    counts = [len(part[2]) for part in parts]

    def column(values: Sequence[int]) -> I8:
        return np.repeat(np.array(values, dtype=np.int64), counts)

    def stack(arrays: list[F8], *shape: int) -> F8:
        return np.concatenate(arrays) if arrays else np.zeros((0, *shape))

    return Matches(
        column(range(len(parts))),
        column([part[0] for part in parts]),
        column([part[1] for part in parts]),
        stack([part[2] for part in parts], 2),
        stack([part[3] for part in parts], 2),
        stack([nearest_value(snapshots[part[0]].depth, part[2]) for part in parts]),
        stack([nearest_value(snapshots[part[1]].depth, part[3]) for part in parts]),
    )
