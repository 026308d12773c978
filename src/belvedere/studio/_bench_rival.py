"""What every rival of the warp is given and gives back, and how single pictures are fused."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.scene import Camera, Frame, ReferenceView
from belvedere.studio._bench_peers import Picture

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]

FAR_M = 1000.0
"""Depth that infinitely far samples (the sky) are given for rivals that know depth only."""
SAME_DEPTH = 0.01
"""Relative difference in depth up to which pictures of two references show one surface."""

Warp = Callable[[Any, Camera, int], "Frame | Picture | Layer"]


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """A picture with disparity, as rivals give it that work in disparity."""

    color: U1
    """(H, W, 3) sRGB."""
    disparity: F4
    """(H, W) 1/metre; NaN or below 0 where nothing landed."""


@dataclass(frozen=True, slots=True, eq=False)
class Rival:
    """One way to show references from a desired camera."""

    name: str
    what: str
    """What it does, in one line."""
    install: str
    """What to install when something is missing."""
    prepare: Callable[[Sequence[ReferenceView], int], Any]
    """``prepare(views, threads)``: what does not depend on the desired camera; its own timing.
    MissingDependencyError if a library or a compiler is missing."""
    warp: Warp
    """``warp(prepared, camera, threads)``: all the rest."""
    threads: int | None = None
    """How many threads it uses whatever it is told: 0 all the machine has; None as it is told."""
    lazy: bool = False
    """Whether part of the preparation waits for the first warp."""


def shown(result: Frame | Picture | Layer) -> tuple[npt.NDArray[Any], F4, npt.NDArray[np.bool_]]:
    """Colour, disparity and which pixels are covered, of what any contestant gives."""
    if isinstance(result, Frame):
        return result.color, result.disparity, result.coverage > 0
    if isinstance(result, Layer):
        return result.color, result.disparity, result.disparity >= 0
    color, depth = result.color, np.nan_to_num(result.depth)
    if color.dtype == np.float32:  # sRGB-encoded in [0, 1]
        color = np.rint(np.clip(color, 0.0, 1.0) * 255.0).astype(np.uint8)
    covered = depth > 0
    with np.errstate(divide="ignore"):
        return color, np.where(covered, np.float32(1.0) / depth, np.float32(np.nan)), covered


def planar_of(view: ReferenceView) -> Camera:
    """The view's camera; stations have planar ones only."""
    assert isinstance(view.camera, Camera)
    return view.camera


def depth_of(view: ReferenceView) -> F4:
    """(H, W) z-depth, the sky at `FAR_M`; 0 where there is no sample."""
    near = np.maximum(view.disparity, np.float32(1.0 / FAR_M))
    depth = np.float32(1.0) / near
    return np.where(np.isnan(depth), np.float32(0.0), depth)


def fuse_nearest(pictures: Sequence[Picture]) -> Picture:
    """The nearest of several pictures' surfaces, their mean where they agree on the depth."""
    if len(pictures) == 1:
        return pictures[0]
    depths = [np.where(one.depth > 0, one.depth, np.float32(np.inf)) for one in pictures]
    front = depths[0]
    for depth in depths[1:]:
        front = np.minimum(front, depth)
    limit = front * np.float32(1.0 + SAME_DEPTH)
    total = np.zeros((*front.shape, 3), np.float32)
    count = np.zeros(front.shape, np.float32)
    for one, depth in zip(pictures, depths, strict=True):
        same = (depth <= limit) & np.isfinite(depth)
        total += one.color * same[..., None]
        count += same
    color = total / np.maximum(count, 1.0)[..., None]
    if pictures[0].color.dtype == np.uint8:
        color = (color + np.float32(0.5)).astype(np.uint8)
    return Picture(color, np.where(count > 0, front, np.float32(0.0)))
