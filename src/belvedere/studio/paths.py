"""A path through a scene from one word: a preset, or a file with keyframes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from belvedere.ground.errors import InputError, MissingFileError
from belvedere.scene import Camera, CameraModel, CameraPath, Scene, dolly, through, wobble
from belvedere.warp import DepthViews

PRESETS = ("wobble", "through", "orbit", "dolly")
"""Words that `path_for` takes beside a file's name."""

ORBIT_SHARE = 0.12
"""Radius of the default orbit's circle, as a share of the distance to what is looked at: further
out, the references would show more holes than picture."""
DOLLY_SHARE = 0.25
"""Length of the default dolly, as a share of the same distance."""


def path_for(
    scene: Scene,
    path: str | Path,
    seconds: float | None = None,
    size: tuple[int, int] | None = None,
) -> CameraPath:
    """The camera path that a word or a file means for a scene.

    Args:
        scene: what will be walked through.
        path: "wobble" (a gentle loop about the references), "through" (along them), "orbit" (a
            small circle that looks at what the first view looks at), "dolly" (straight ahead), or
            the name of a path file (JSON, see `CameraPath.save`).
        seconds: how long a preset takes; a file says so itself.
        size: (width, height) of the pictures; by default the first camera's or the file's.

    Raises:
        InputError: neither a preset nor a file.
        PathError: a file that is no path.
    """
    name = str(path)
    if name in PRESETS:
        made = _preset(scene, name, seconds)
    elif Path(path).is_file():
        made = CameraPath.load(path)
    elif name.endswith(".json"):
        raise MissingFileError(f"no path file {name}: presets are {', '.join(PRESETS)}")
    else:
        raise InputError(
            f"path is {name!r}, expected one of {', '.join(PRESETS)} or the name of a path file"
        )
    return made if size is None else made.resized(*size)


def _preset(scene: Scene, name: str, seconds: float | None) -> CameraPath:
    cameras = _cameras(scene)
    distance = _distance(scene)
    if name == "wobble":
        return wobble(cameras, seconds, distance=distance)
    if name == "through":
        return through(cameras, seconds)
    home = cameras[0]
    if not isinstance(home, Camera):
        raise InputError(
            f"path {name!r} starts from a planar camera, and the scene's first one is a "
            f"{type(home).__name__}: pass a path file"
        )
    if name == "dolly":
        ahead = home.center + home.forward * DOLLY_SHARE * distance
        return dolly(home, home.moved(ahead), seconds or 5.0)
    target = home.center + home.forward * distance
    radius = ORBIT_SHARE * distance
    right, down = home.camera_to_world[:3, 0], home.camera_to_world[:3, 1]
    angles = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    eyes = [home.center + radius * ((np.cos(a) - 1.0) * right + np.sin(a) * down) for a in angles]
    fov = float(np.degrees(home.fov))
    keys = [
        Camera.look_at(eye, target, up=-down, fov_deg=fov, width=home.width, height=home.height)
        for eye in eyes
    ]
    length = seconds or 8.0
    return CameraPath.of(keys, (length * np.arange(len(keys)) / len(keys)).tolist(), length)


def _cameras(scene: Scene) -> tuple[CameraModel, ...]:
    views = getattr(scene, "views", None)
    return views.cameras if views is not None else (scene.home,)


def _distance(scene: Scene) -> float:
    """Metres to what the scene shows; without depth, the extent of its viewing region."""
    if isinstance(scene, DepthViews):
        return 1.0 / float(np.median(scene.typical_disparities))
    span = scene.viewing_region.high - scene.viewing_region.low
    return float(np.linalg.norm(span)) or 2.0
