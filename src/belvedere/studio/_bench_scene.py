"""A room made of boxes, cast by NumPy: the benchmark's own scene, the same on every machine.

Rays meet axis-aligned boxes only, so disparity is exact and nothing but NumPy is needed: walls and
a floor (planes), a table and shelves (depth edges), a slatted rail and thin legs (parts a pixel or
two wide), all with texture to the last pixel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from belvedere.scene import Camera, ReferenceView

F8 = npt.NDArray[np.float64]

Contents = Literal["nothing", "furniture", "sticks"]
"""What stands in the room."""

ROOM = np.array([[0.0, 0.0, 0.0], [6.0, 5.0, 2.8]])
"""(2, 3) low and high corner of the room, metres; its inside is seen."""
FOV_DEG = 60.0
GRAIN_M = 0.02
"""Side of the smallest patches of texture: one to three pixels of a 512 x 512 view."""


@dataclass(frozen=True, slots=True, eq=False)
class BenchScene:
    """Reference views of the room, and the camera they are warped to."""

    views: tuple[ReferenceView, ...]
    """Nearest to the desired camera first; colour ``uint8``, no sample missing."""
    camera: Camera
    """The desired camera, of the views' size and intrinsics."""


def make_room(size: int = 512, seed: int = 0, contents: Contents = "furniture") -> BenchScene:
    """Two references and a desired view 0.25 and 0.3 metres from them, turned by some degrees.

    Args:
        size: pixels along both sides of every view, at least 8.
        seed: of the texture and of where things stand.
        contents: how complex what is seen is: bare walls, furniture, or a field of sticks that is
            nearly all edges. The cameras and the number of samples stay the same.
    """
    furnish = {"nothing": _leave_bare, "furniture": _furnish, "sticks": _plant_sticks}[contents]
    boxes, tints = furnish(np.random.default_rng(seed))
    desired = _camera((1.0, 1.1, 1.55), (4.6, 3.6, 0.95), size)
    eyes = (((1.16, 0.92, 1.6), (4.5, 3.8, 0.9)), ((0.8, 1.3, 1.48), (4.8, 3.5, 1.0)))
    views = tuple(
        _photograph(_camera(eye, target, size), boxes, tints, seed) for eye, target in eyes
    )
    return BenchScene(views, desired)


def _camera(
    eye: tuple[float, float, float], target: tuple[float, float, float], size: int
) -> Camera:
    return Camera.look_at(eye, target, fov_deg=FOV_DEG, width=size, height=size)


def _leave_bare(rng: np.random.Generator) -> tuple[F8, F8]:
    """No boxes, and the room's tints."""
    return np.empty((0, 2, 3)), rng.uniform(0.15, 0.9, (3, 3))


def _plant_sticks(rng: np.random.Generator) -> tuple[F8, F8]:
    """Three hundred sticks, two to four pixels of a 512 x 512 view thick, and the tints."""
    low = rng.uniform((1.8, 1.6, 0.0), (5.6, 4.6, 0.3), (300, 3))
    high = low + rng.uniform((0.01, 0.01, 1.2), (0.02, 0.02, 2.4), (300, 3))
    return np.stack([low, high], axis=1), rng.uniform(0.15, 0.9, (303, 3))


def _furnish(rng: np.random.Generator) -> tuple[F8, F8]:
    """(n, 2, 3) boxes and their (n, 3) linear tints, after the room's own three."""
    boxes: list[tuple[float, float, float, float, float, float]] = []
    x, y = 3.0 + rng.uniform(-0.1, 0.1, 2)
    boxes.append((x, y, 0.7, x + 1.2, y + 0.8, 0.74))  # a table and its legs
    boxes += [(x + a, y + b, 0.0, x + a + 0.04, y + b + 0.04, 0.7)
              for a in (0.02, 1.14) for b in (0.02, 0.74)]  # fmt: skip
    boxes.append((x + 0.3, y + 0.2, 0.74, x + 0.55, y + 0.4, 1.0))  # something on it
    boxes += [(4.2 + 0.0, 4.6, z, 5.8, 5.0, z + 0.03) for z in (0.4, 0.9, 1.4, 1.9)]  # shelves
    for z in (0.43, 0.93, 1.43):
        left = 4.25
        while left < 5.6:  # books
            wide, high = rng.uniform(0.04, 0.12), rng.uniform(0.2, 0.4)
            boxes.append((left, 4.7, z, left + wide, 4.95, z + high))
            left += wide + rng.uniform(0.0, 0.06)
    boxes.append((1.9, 3.9, 0.95, 3.2, 3.93, 0.98))  # a rail on slats
    boxes += [(1.92 + 0.08 * n, 3.905, 0.0, 1.935 + 0.08 * n, 3.92, 0.95) for n in range(16)]
    boxes.append((5.2, 1.4, 0.0, 5.9, 2.4, 1.1))  # a chest
    array = np.array(boxes).reshape(-1, 2, 3)
    return array, rng.uniform(0.15, 0.9, (len(array) + 3, 3))


def _photograph(camera: Camera, boxes: F8, tints: F8, seed: int) -> ReferenceView:
    """What a camera sees: colour with texture, and the exact disparity."""
    rows, columns = np.mgrid[0 : camera.height, 0 : camera.width].astype(np.float64)
    rays = camera.rays(columns, rows)
    depth, surface, axis = _cast(camera, rays, boxes)
    points = camera.center + depth[..., None] * rays
    facing = np.array([0.75, 0.9, 1.0])[axis]
    linear = tints[surface] * (facing * _grain(points, axis, seed))[..., None]
    color = np.round(255.0 * np.clip(linear, 0.0, 1.0) ** (1.0 / 2.2)).astype(np.uint8)
    return ReferenceView(camera, color, (1.0 / depth).astype(np.float32))


def _cast(
    camera: Camera, rays: F8, boxes: F8
) -> tuple[F8, npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """z-depth (rays reach unit depth), surface and the axis it faces, of each ray's first hit."""
    center = camera.center
    with np.errstate(divide="ignore", invalid="ignore"):
        leaving = np.where(rays > 0, (ROOM[1] - center) / rays, (ROOM[0] - center) / rays)
    axis = np.nanargmin(leaving, axis=-1)
    depth = np.nanmin(leaving, axis=-1)
    surface = axis.copy()
    for index, box in enumerate(boxes):
        part = _window(camera, box)
        with np.errstate(divide="ignore", invalid="ignore"):
            first, second = (box[0] - center) / rays[part], (box[1] - center) / rays[part]
        near, far = np.fmin(first, second), np.fmax(first, second)
        enter = near.max(axis=-1)
        hit = (enter > 0) & (enter < far.min(axis=-1)) & (enter < depth[part])
        depth[part][hit] = enter[hit]
        axis[part][hit] = near[hit].argmax(axis=-1)
        surface[part][hit] = index + 3
    return depth, surface, axis


def _window(camera: Camera, box: F8) -> tuple[slice, slice]:
    """Rows and columns that can see a box; all of them if it reaches behind the camera."""
    corners = np.array([[box[i, 0], box[j, 1], box[k, 2]] for i, j, k in np.ndindex(2, 2, 2)])
    u, v, delta = camera.project(corners)
    if not np.all(delta > 0):
        return slice(None), slice(None)
    low = np.floor(np.clip([v.min(), u.min()], 0, camera.size)).astype(int)
    high = np.ceil(np.clip([v.max() + 1, u.max() + 1], 0, camera.size)).astype(int)
    return slice(low[0], high[0]), slice(low[1], high[1])


def _grain(points: F8, axis: npt.NDArray[np.int64], seed: int) -> F8:
    """Brightness of the texture: patches of three sizes, each of its own grey."""
    flat = points.copy()
    np.put_along_axis(flat, axis[..., None], 0.0, -1)  # rounding across the surface is no texture
    total = np.full(axis.shape, 0.4)
    for level, weight in ((1, 0.25), (4, 0.25), (16, 0.3)):
        patch = np.floor(flat / (GRAIN_M * level)).astype(np.int64).astype(np.uint64)
        mixed = patch @ np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9],
                                 np.uint64)  # fmt: skip
        mixed += np.uint64(seed + 1) * np.uint64(0x27D4EB2F165667C5)
        mixed ^= mixed >> np.uint64(29)
        mixed *= np.uint64(0xBF58476D1CE4E5B9)
        total += weight * ((mixed >> np.uint64(40)).astype(np.float64) / 2.0**24)
    return total
