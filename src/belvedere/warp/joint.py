"""References that are parts of one picture: the sides of a box round one eye.

What one eye sees in one direction is one surface, so parts that hardly overlap have nothing to tell
one another, and together they take no more room than one reference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from belvedere.scene import Camera
from belvedere.warp.prepare import PreparedView
from belvedere.warp.reconstruct import Passage

F8 = npt.NDArray[np.float64]

__all__ = ["join_parts", "shared_layers"]


def join_parts(passages: Sequence[Passage]) -> tuple[list[Passage], list[int]]:
    """Let parts of one picture share a layer, and leave out those that the desired view misses.

    Returns:
        The passages, and their numbers among those given. Where none has parts, all of them.
    """
    shared = shared_layers([one.prepared for one in passages])
    if shared is None or not all(one.back.size == 12 for one in passages):
        return list(passages), list(range(len(passages)))
    kept = [n for n, one in enumerate(passages) if len(one.tiles)] or [0]
    numbers = {layer: k for k, layer in enumerate(dict.fromkeys(shared[n] for n in kept))}
    return [replace(passages[n], layer=numbers[shared[n]]) for n in kept], kept


def shared_layers(views: Sequence[PreparedView]) -> list[int] | None:
    """For each view the number of the layer it belongs to; None if each has one of its own.

    Views share a layer when they have the same eye, to the bit, and none sees the middle of
    another's picture. Layers are numbered in the order of their first views.
    """
    cameras = [one.camera for one in views if isinstance(one.camera, Camera)]
    eyes = [camera.center.tobytes() for camera in cameras]
    if len(set(eyes)) == len(eyes) or len(cameras) < len(views):
        return None
    parts: list[list[int]] = []
    for n, view in enumerate(views):
        for part in parts:
            if eyes[part[0]] == eyes[n] and not any(_overlap(view, views[k]) for k in part):
                part.append(n)
                break
        else:
            parts.append([n])
    if len(parts) == len(views):
        return None
    numbers = [0] * len(views)
    for number, part in enumerate(parts):
        for n in part:
            numbers[n] = number
    return numbers


def _overlap(one: PreparedView, other: PreparedView) -> bool:
    return _sees(one, other.middle) or _sees(other, one.middle)


def _sees(one: PreparedView, direction: F8) -> bool:
    """Whether a direction from one's eye is in its picture."""
    return bool((one.edge_planes @ direction > 0.0).all())
