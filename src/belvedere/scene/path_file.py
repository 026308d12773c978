"""Camera paths as JSON files that people can write by hand.

::

    {
      "belvedere_path": 1,
      "width": 640, "height": 512,
      "period": 12.0,
      "keyframes": [
        {"time": 0.0, "eye": [2, -3, 1.6], "target": [0, 0, 1], "fov_deg": 60},
        {"time": 4.0, "camera_to_world": [[...], [...], [...], [...]], "K": [[...], [...], [...]]}
      ]
    }

- ``belvedere_path``: the version of this layout, 1.
- ``width``, ``height``: pixels of the pictures.
- ``period``: seconds of one round, for a closed path; leave it out for an open one.
- ``keyframes``: in order of ``time`` (seconds). Each says where the camera is, as ``eye`` and
  ``target`` (metres; with ``up`` where that is not +z) or as ``camera_to_world`` (4x4; camera axes
  x right, y down, z forward); and what it shows, as ``fov_deg`` (vertical, degrees; 60 where left
  out) or as ``K`` (3x3, pixels, centres at integers).

Other keys are refused, so that a misspelt one does not pass unnoticed. `save_path` writes
``camera_to_world`` and ``K`` with every digit.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from belvedere.ground.errors import (
    CameraError,
    FileFormatError,
    MissingFileError,
    PathError,
    SceneError,
)
from belvedere.scene.camera import Camera
from belvedere.scene.path import CameraPath, Keyframe
from belvedere.scene.pose import look_at_rotation, pose_matrix

if TYPE_CHECKING:
    from belvedere.scene.io.json_files import JsonObject

VERSION = 1
DEFAULT_FOV_DEG = 60.0

_KEYS = ("belvedere_path", "width", "height", "period", "keyframes")
_KEYFRAME_KEYS = ("time", "eye", "target", "up", "camera_to_world", "fov_deg", "K")


def save_path(path: str | Path, camera_path: CameraPath, *, force: bool = True) -> None:
    """Write a camera path as JSON, atomically.

    Raises:
        OutputError: the file cannot be written, or exists and ``force`` is False.
    """
    from belvedere.scene.io.json_files import write_json

    height, width = camera_path.size
    data: dict[str, object] = {"belvedere_path": VERSION, "width": width, "height": height}
    if camera_path.period is not None:
        data["period"] = float(camera_path.period)
    data["keyframes"] = [
        {
            "time": float(key.time),
            "camera_to_world": key.camera.camera_to_world.tolist(),
            "K": key.camera.intrinsics.tolist(),
        }
        for key in camera_path.keyframes
    ]
    write_json(path, data, force=force)


def load_path(path: str | Path) -> CameraPath:
    """Read a camera path from JSON.

    Raises:
        MissingFileError: no such file.
        FileFormatError: the file is no JSON.
        PathError: the file, key and index of whatever else is wrong.
    """
    from belvedere.scene.io.json_files import read_json

    try:
        return _read(read_json(path))
    except (MissingFileError, FileFormatError):
        raise
    except SceneError as error:  # a value that is missing or wrong; it names file, key and index
        raise PathError(str(error)) from None


def _read(data: JsonObject) -> CameraPath:
    if "belvedere_path" not in data:
        raise PathError(
            f"{data.where} has no 'belvedere_path': it is no camera path of ours (see the docs of "
            f'belvedere.scene.path_file); add "belvedere_path": {VERSION} if it is'
        )
    version = data.integer("belvedere_path")
    if version > VERSION:
        raise PathError(
            f"{data.place('belvedere_path')} is {version}, this program reads up to {VERSION}: "
            "use a newer belvedere"
        )
    _refuse_unknown(data, _KEYS)
    width, height = data.integer("width", low=1), data.integer("height", low=1)
    keyframes = tuple(_keyframe(item, width, height) for item in data.objects("keyframes"))
    period = data.number("period") if "period" in data else None
    try:
        return CameraPath(keyframes, period)
    except PathError as error:
        raise PathError(f"{data.where}: {str(error).removeprefix('CameraPath.')}") from None


def _keyframe(item: JsonObject, width: int, height: int) -> Keyframe:
    _refuse_unknown(item, _KEYFRAME_KEYS)
    time = item.number("time")
    for one, other in (("eye", "camera_to_world"), ("K", "fov_deg")):
        if one in item and other in item:
            raise PathError(f"{item.here} has both {one!r} and {other!r}: leave one out")
    try:
        if "camera_to_world" in item:
            for key in ("target", "up"):
                if key in item:
                    raise PathError(f"{item.here} has both {key!r} and 'camera_to_world': "
                                    "leave one out")  # fmt: skip
            pose = item.array("camera_to_world", (4, 4))
        else:
            eye, target = item.array("eye", (3,)), item.array("target", (3,))
            up = item.array("up", (3,)) if "up" in item else (0.0, 0.0, 1.0)
            pose = pose_matrix(look_at_rotation(eye, target, up), eye)
        if "K" in item:
            k = item.array("K", (3, 3))
            return Keyframe(time, Camera.from_intrinsics(k, pose, width, height))
        fov_deg = item.number("fov_deg", DEFAULT_FOV_DEG)
        return Keyframe(time, Camera.from_fov(fov_deg, pose, width, height))
    except CameraError as error:
        raise PathError(f"{item.here}: {error}") from None


def _refuse_unknown(item: JsonObject, known: tuple[str, ...]) -> None:
    for key in item.data:
        if key not in known:
            raise PathError(
                f"{item.here} has the unknown key {key!r}, expected " + ", ".join(known)
            )
