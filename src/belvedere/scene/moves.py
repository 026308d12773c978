"""Camera moves: paths that need no keyframes from you.

`orbit` circles a point, `dolly` goes from one camera to another, `through` visits cameras in turn.
`belvedere.scene.loops` has `wobble`, which moves gently about reference views.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import (
    as_array,
    check_finite,
    check_number,
    check_shape,
)
from belvedere.ground.errors import PathError
from belvedere.scene.camera import Camera
from belvedere.scene.camera_model import F8, CameraModel
from belvedere.scene.path import CameraPath

KEYS_PER_TURN = 36
"""Keyframes of a circle; between them the path is within 3e-5 radii of it."""

WORTH_OF_A_TURN = 1.0
"""Radians of turning that take as long as moving by one typical step."""


# ---- moves from numbers --------------------------------------------------------------------------


def orbit(
    target: npt.ArrayLike,
    radius: float,
    *,
    rise: float = 0.0,
    start_deg: float = -90.0,
    turns: float = 1.0,
    duration: float = 10.0,
    fov_deg: float = 60.0,
    width: int = 640,
    height: int = 480,
) -> CameraPath:
    """A circle about a point, looking at it, counter-clockwise as seen from above.

    Args:
        target: (3,) point looked at, metres.
        radius: horizontal distance from it, metres.
        rise: metres of the eye above it.
        start_deg: azimuth of the first camera as seen from the target, degrees from +x to +y; -90
            looks north (+y) first.
        turns: how often it goes round, negative for clockwise; whole numbers make a closed path.
        duration: seconds in all.
        fov_deg: vertical field of view, degrees.
        width: pixels across.
        height: pixels down.

    Raises:
        PathError: a number out of range.
    """
    middle = as_array("orbit", "target", target)
    check_shape("orbit", "target", middle, (3,), error=PathError)
    check_finite("orbit", "target", middle, PathError)
    r = check_number("orbit", "radius", radius, 0.0, open_low=True, error=PathError)
    up = check_number("orbit", "rise", rise, error=PathError)
    first = math.radians(check_number("orbit", "start_deg", start_deg, error=PathError))
    rounds = check_number("orbit", "turns", turns, -1000.0, 1000.0, error=PathError)
    seconds = check_seconds("orbit", duration)
    if rounds == 0:
        raise PathError("orbit.turns is 0, expected how often to go round, such as 1 or -0.5")
    spans = max(math.ceil(KEYS_PER_TURN * abs(rounds)), 2)
    closed = rounds == int(rounds)
    angles = first + 2.0 * math.pi * rounds * np.arange(spans + (not closed)) / spans
    eyes = middle + np.stack(
        [r * np.cos(angles), r * np.sin(angles), np.full(len(angles), up)], axis=1
    )
    cameras = [
        Camera.look_at(eye, middle, fov_deg=fov_deg, width=width, height=height) for eye in eyes
    ]
    times = seconds * np.arange(len(cameras)) / spans
    return CameraPath.of(cameras, times.tolist(), seconds if closed else None)


def dolly(start: Camera, end: Camera, duration: float = 5.0, *, ease: bool = True) -> CameraPath:
    """A straight move from one camera to another; position, orientation and lens.

    Args:
        start: first camera; its picture size is the path's.
        end: last camera.
        duration: seconds.
        ease: set out and come to rest gently, rather than move at one speed throughout.

    Raises:
        PathError: no planar cameras, a duration that is not positive.
    """
    for name, camera in (("start", start), ("end", end)):
        if not isinstance(camera, Camera):
            raise PathError(f"dolly.{name} is a {type(camera).__name__}, expected a planar Camera")
    seconds = check_seconds("dolly", duration)
    straight = CameraPath.of([start, end.resized(start.width, start.height)], [0.0, seconds])
    if not ease:
        return straight
    share = np.arange(17) / 16
    eased = share**2 * (3.0 - 2.0 * share)
    return CameraPath.of(straight.cameras_at_times(seconds * eased), (seconds * share).tolist())


# ---- moves from reference views ------------------------------------------------------------------


def through(
    cameras: Sequence[CameraModel], duration: float | None = None, *, closed: bool = False
) -> CameraPath:
    """A path through every camera in the order given, at an even pace.

    Time is shared out by how far neighbours are apart, in metres and in angle. Pictures have the
    first camera's size; cameras of other sizes lend their pose, with the first one's lens.

    Args:
        cameras: one or more; those that are not planar lend their pose (see `planar_like`).
        duration: seconds in all; None: half a second for each camera, from 4 to 60.
        closed: go on from the last to the first.

    Raises:
        PathError: no camera, a duration that is not positive.
    """
    held = planar_set("through", cameras)
    seconds = min(max(0.5 * len(held), 4.0), 60.0)
    seconds = seconds if duration is None else check_seconds("through", duration)
    if len(held) == 1:
        return CameraPath.of(held, [0.0], seconds)
    times = _even_times(held, closed)
    period = seconds if closed else None
    return CameraPath.of(held, (seconds * times[: len(held)]).tolist(), period)


def planar_like(camera: CameraModel, fov_deg: float = 60.0) -> Camera:
    """A planar camera at the place of a camera of any kind, looking at its picture's middle.

    A planar camera is returned as it is. Others get the vertical field of view stated and a
    picture as high as theirs and 4:3 wide.
    """
    if isinstance(camera, Camera):
        return camera
    u, v = (camera.width - 1) / 2, (camera.height - 1) / 2
    eye = camera.origins(u, v)
    ahead = camera.rays(u, v)
    above = camera.origins(u, v - 1) + camera.rays(u, v - 1) - eye - ahead
    width = max(round(camera.height * 4 / 3), 1)
    return Camera.look_at(eye, eye + ahead, above, fov_deg, width=width, height=camera.height)


def planar_set(owner: str, cameras: Sequence[CameraModel]) -> list[Camera]:
    """Planar cameras of one size: the first one's, and its lens where the size differs."""
    for index, camera in enumerate(cameras):
        if not isinstance(camera, CameraModel):
            raise PathError(
                f"{owner}.cameras[{index}] is a {type(camera).__name__}, expected a camera"
            )
    held = [planar_like(camera) for camera in cameras]
    if not held:
        raise PathError(f"{owner}.cameras is empty, expected at least one camera")
    first = held[0]
    k = first.intrinsics
    return [
        camera
        if camera.size == first.size
        else Camera.from_intrinsics(k, camera.camera_to_world, first.width, first.height)
        for camera in held
    ]


def even_costs(places: F8, turned: F8) -> F8:
    """(N,) how far each view is from the next one, and the last from the first.

    Metres are divided by the median step, so that they compare with the (N,) angles ``turned``; a
    view twice in the same place still costs a little, since no two keyframes may have one time.
    """
    moved = np.linalg.norm(np.roll(places, -1, axis=0) - places, axis=1)
    real = moved[:-1][moved[:-1] > 1e-12]
    scale = float(np.median(real)) if real.size else 1.0
    cost = moved / scale + turned / WORTH_OF_A_TURN
    mean = float(cost.mean())
    return cost + (0.02 * mean if mean > 0 else 1.0)


def _even_times(cameras: list[Camera], closed: bool) -> F8:
    """Time of each camera (and of the return), from 0 to 1, by how far it is along."""
    poses = np.stack([camera.camera_to_world for camera in cameras])
    turns = poses[:, :3, :3]
    cosine = (np.einsum("nij,nij->n", turns, np.roll(turns, -1, axis=0)) - 1.0) / 2.0
    steps = even_costs(poses[:, :3, 3], np.arccos(np.clip(cosine, -1.0, 1.0)))
    at = np.concatenate([[0.0], np.cumsum(steps if closed else steps[:-1])])
    return at / at[-1]


def check_seconds(owner: str, duration: object) -> float:
    """A positive number of seconds, or a `PathError`."""
    return check_number(owner, "duration", duration, 0.0, open_low=True, error=PathError)
