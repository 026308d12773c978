"""``cameras.json`` with ``images/`` and ``depth/``: intrinsics and poses in one plain file.

::

    {"width": 540, "height": 360, "K": [[fx, 0, cx], [0, fy, cy], [0, 0, 1]],
     "depth_unit": "millimetres",
     "frames": [{"image": "images/a.png", "depth": "depth/a.png", "camera_to_world": [4x4]}]}

Conventions of the file: camera-to-world, OpenCV camera axes, metres, pixel centres at integers,
depth along the axis. ``K``, ``width`` and ``height`` may stand in a frame instead; ``file`` may
stand for ``image``; ``world_to_camera`` for ``camera_to_world``. ``depth_unit`` begins with
millimetres, centimetres or metres, or ``depth_scale`` gives metres per stored number; without
either, whole numbers are millimetres and floats metres.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from belvedere.ground.errors import SceneError
from belvedere.scene.conventions import Conventions
from belvedere.scene.io.images import image_size
from belvedere.scene.io.json_files import JsonObject, read_json
from belvedere.scene.io.paths import existing
from belvedere.scene.io.pictures import (
    Picture,
    build_views,
    default_scale,
    stored_infinity,
    view_names,
)
from belvedere.scene.pose import invert_pose
from belvedere.scene.views import ViewSet

CONVENTIONS = Conventions()
"""The file's own, which are ours."""
UNITS = {"millimet": 0.001, "mm": 0.001, "centimet": 0.01, "cm": 0.01, "met": 1.0}
"""Metres per unit, by how the word for it begins."""


def read_cameras_json(path: str | Path, conventions: Conventions | None = None) -> ViewSet:
    """Read a ``cameras.json`` scene, with or without depth.

    Args:
        path: the folder, or the JSON file itself.
        conventions: how to read the numbers instead of the file's own way.

    Raises:
        MissingFileError, FileFormatError, UnsafePathError, SceneError: what is wrong in which file,
            key and frame.
    """
    file = Path(path)
    if file.is_dir():
        file = file / "cameras.json"
    root = read_json(file)
    frames = list(root.objects("frames"))
    texts = [_image_text(frame) for frame in frames]
    pictures = [
        _picture(file.parent, root, frame, frame.text("name", name), text)
        for frame, name, text in zip(frames, view_names(texts), texts, strict=True)
    ]
    own, said = _depth_scale(root, next((p.depth for p in pictures if p.depth), None))
    chosen = (conventions or CONVENTIONS).resolved(own)
    if conventions is not None and conventions.depth_scale is not None:
        said = "given by the caller"
    facts = {
        "format": "cameras.json",
        "path": str(path),
        "depth_scale": chosen.depth_scale,
        "depth_scale_from": said,
    }
    return build_views(pictures, chosen, facts, stored_infinity(root))


def _picture(folder: Path, root: JsonObject, frame: JsonObject, name: str, text: str) -> Picture:
    color = existing(folder, text, frame.place("image" if "image" in frame else "file"))
    depth = None
    if "depth" in frame:
        depth = existing(folder, frame.text("depth"), frame.place("depth"))
    if "camera_to_world" not in frame and "world_to_camera" in frame:
        pose = invert_pose(frame.array("world_to_camera", (4, 4)))
    else:
        pose = frame.array("camera_to_world", (4, 4))
    owner = frame if "K" in frame else root
    k = owner.array("K", (3, 3))
    size = [
        (frame if key in frame else root).integer(key, low=1) if key in frame or key in root else 0
        for key in ("width", "height")
    ]
    width, height = size if all(size) else image_size(color)
    return Picture(frame.here, name, color, depth, k, np.asarray(pose), width, height)


def _image_text(frame: JsonObject) -> str:
    for key in ("image", "file"):
        if key in frame:
            return frame.text(key)
    raise SceneError(f"{frame.here} has no 'image' (or 'file'): add the picture's path")


def _depth_scale(root: JsonObject, sample: Path | None) -> tuple[float, str]:
    if "depth_scale" in root:
        return root.number("depth_scale", above=0.0), f"{root.where}: depth_scale"
    if "depth_unit" in root:
        words = root.text("depth_unit").strip().lower()
        words = "metres" if words == "m" else words
        for start, scale in UNITS.items():
            if words.startswith(start):
                return scale, f"{root.where}: depth_unit"
        raise SceneError(
            f"{root.place('depth_unit')} is {words!r}, expected text beginning with millimetres, "
            "centimetres or metres; or give 'depth_scale' in metres per stored number"
        )
    return default_scale(sample)
