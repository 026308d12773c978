"""Slow twin of the Gaussian reconstructor, in float64: pixel by pixel over every sample's ellipse.

Spec image-warping 3.7. Depths come from tangent planes in the world, not from gradients.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.scene import Camera
from belvedere.warp import GaussianOptions, jacobian, warp_matrix

F8 = npt.NDArray[np.float64]
B1 = npt.NDArray[np.bool_]

CORE = math.sqrt(0.5)
"""Half the diagonal between four samples."""
LEAST, FULL = 0.2, 0.8
"""Weights from which a pixel is covered, and wholly."""


@dataclass(frozen=True, slots=True, eq=False)
class Sums:
    """What the twin adds up."""

    color: F8
    """(rows, columns, C) the mean."""
    disparity: F8
    """(rows, columns) of the front surface, NaN in holes."""
    coverage: F8
    """(rows, columns)."""
    sure: B1
    """Where rounding decides nothing: no ellipse ends and no surface begins near the pixel."""


@dataclass(frozen=True, slots=True, eq=False)
class Ellipse:
    """One sample in the desired view, at every pixel."""

    square: F8
    """(rows, columns) squared radius, reference pixels."""
    plane: F8
    """(rows, columns) warped disparity of its tangent plane there."""
    moved: float
    """Its own warped disparity."""
    span: float
    """How much that changes a reference pixel away, at most."""
    area: float
    """What a weight of 1 counts."""
    rim: bool
    """Whether a neighbour is missing or on another surface."""


def gradient(disparity: F8, label: npt.NDArray[np.int64], v: int, u: int) -> tuple[F8, bool]:
    """(2,) d(delta)/du and /dv from neighbours with the same label, and whether one is missing."""
    steps, missing = [], False
    for dv, du in ((0, 1), (1, 0)):
        found = []
        for sign in (-1, 1):
            j, i = v + sign * dv, u + sign * du
            inside = 0 <= j < disparity.shape[0] and 0 <= i < disparity.shape[1]
            if inside and label[j, i] == label[v, u]:
                found.append(sign * (disparity[j, i] - disparity[v, u]))
        missing |= len(found) < 2
        steps.append(float(np.mean(found)) if found else 0.0)
    return np.array(steps), missing


def ellipse_of(
    reference: Camera,
    desired: Camera,
    disparity: F8,
    label: npt.NDArray[np.int64],
    at: tuple[int, int],
    options: GaussianOptions,
) -> Ellipse | None:
    """The ellipse of sample ``at`` (v, u), or None if it is behind the eye or turned away."""
    v, u = at
    matrix = warp_matrix(reference, desired)
    delta = disparity[v, u]
    slopes, rim = gradient(disparity, label, v, u)
    r, s, t = matrix @ [u, v, 1.0, delta]
    stretch = jacobian(matrix, u, v, delta, (slopes[0], slopes[1]))
    det = float(np.linalg.det(stretch))
    if not (t > 0 and det > 0):
        return None
    spread = stretch @ stretch.T + options.low_pass * np.eye(2)
    y, x = np.indices(desired.size, dtype=float)
    off = np.stack([x - r / t, y - s / t], -1)
    square = np.einsum("...i,ij,...j", off, np.linalg.inv(spread), off)
    # the tangent plane warps by a homography: back to the reference, and there to its disparity
    plane = np.array([*slopes, delta - slopes @ [u, v]])
    over = matrix[:, :3] + np.outer(matrix[:, 3], plane)
    back = np.stack([x, y, np.ones_like(x)], -1) @ np.linalg.inv(over).T
    scaled = (back @ plane).astype(np.float64)  # delta / t, as the homography's scale is t itself
    moved = delta / t
    per_step = slopes / t - moved * (matrix[2, :2] + matrix[2, 3] * slopes) / t
    span = float(np.hypot(*per_step))
    return Ellipse(square, scaled, moved, span, det / math.sqrt(float(np.linalg.det(spread))), rim)


def gaussian_warp(
    reference: Camera,
    desired: Camera,
    color: F8,
    disparity: F8,
    label: npt.NDArray[np.int64],
    options: GaussianOptions,
    tolerance: float = 0.03,
    slack: float = 2e-3,
) -> Sums:
    """One reference by Gaussian footprints.

    Args:
        reference: its camera.
        desired: the camera to fill.
        color: (H, W, C) linear.
        disparity: (H, W), NaN where there is no sample.
        label: (H, W) which surface a sample lies on.
        options: of the footprints.
        tolerance: relative difference in disparity of one surface.
        slack: relative error that the kernels may make.
    """
    samples = np.argwhere(~np.isnan(disparity))
    places = [(int(v), int(u)) for v, u in samples]
    ellipses = [ellipse_of(reference, desired, disparity, label, p, options) for p in places]
    front, rim = np.full(desired.size, -1.0), np.full(desired.size, -1.0)
    sure = np.ones(desired.size, bool)
    reach = options.cut
    for one in ellipses:
        if one is None:
            continue
        for radius, target in ((CORE, front), (reach, rim)):
            sure &= abs(one.square - radius**2) > slack
            if target is front or one.rim:
                most = one.span * radius
                believed = np.maximum(np.minimum(one.plane, one.moved + most), 0)
                inside = one.square < radius**2
                target[inside] = np.maximum(target, believed)[inside]
    front = np.where(front < 0, rim, front)
    total, sums = np.zeros(desired.size), np.zeros((*desired.size, color.shape[2]))
    whole = 2 * np.pi * options.sigma**2 * (1 - math.exp(-(reach**2) / (2 * options.sigma**2)))
    for place, one in zip(places, ellipses, strict=True):
        if one is None:
            continue
        low, high = (one.moved - one.span * reach) * (1 - tolerance), one.moved + one.span * reach
        inside = (one.square < reach**2) & (front >= low) & (front * (1 - tolerance) <= high)
        near = one.square < reach**2
        sure &= ~(near & (abs(front - low) < slack * front))
        sure &= ~(near & (abs(front * (1 - tolerance) - high) < slack * front))
        weight = np.exp(-one.square / (2 * options.sigma**2)) * one.area / whole * inside
        total += weight
        sums += weight[..., None] * color[place]
    sure &= abs(total - LEAST) > slack
    covered = total > LEAST
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.where(covered[..., None], sums / total[..., None], 0.0)
    share = np.clip((total - LEAST) / (FULL - LEAST), 0.0, 1.0)
    return Sums(mean, np.where(covered, front, np.nan), np.where(covered, share, 0.0), sure)
