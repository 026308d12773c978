"""``transforms.json``: nerfstudio's and instant-ngp's scenes, Blender's synthetic ones, and ours.

Conventions of the file: poses camera-to-world with OpenGL camera axes; world +z up, kept; the
upper left corner of the picture is (0, 0), so the first pixel's centre lies at 0.5. Depth is along
the axis. Its unit: ``depth_unit_scale_factor`` or instant-ngp's ``integer_depth_scale`` where the
file has one; otherwise whole numbers are millimetres (nerfstudio's default) and floats metres.

A ``belvedere.json`` beside it makes the folder one of ours (see `save_views`).

Source: nerfstudio, data conventions; instant-ngp, NeRF dataset tips.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from belvedere.ground.errors import MissingFileError, SceneError
from belvedere.scene.conventions import Conventions
from belvedere.scene.io.images import image_size
from belvedere.scene.io.json_files import JsonObject, read_json
from belvedere.scene.io.lens import Lens
from belvedere.scene.io.paths import existing, inside
from belvedere.scene.io.pictures import (
    INFINITY_KEY,
    Picture,
    build_views,
    default_scale,
    stored_infinity,
    view_names,
)
from belvedere.scene.views import ViewSet

CONVENTIONS = Conventions(pose="camera_to_world", axes="opengl", pixel_centers="half")
"""The file's own."""
VERSION = 1
"""Of our folder format; a larger one is refused."""
NAME_KEY = "belvedere_name"
"""A view's name, where its file could not be called so."""
DEPTH_KEYS = ("depth_file_path", "depth_path")
"""nerfstudio's word for a frame's depth map, and instant-ngp's."""
STRAIGHT_MODELS = ("PINHOLE", "SIMPLE_PINHOLE", "PERSPECTIVE")
OPENCV_MODELS = ("OPENCV", "RADIAL", "SIMPLE_RADIAL", "FULL_OPENCV")
FISHEYE_MODELS = ("OPENCV_FISHEYE",)
LENS_KEYS = ("k1", "k2", "k3", "k4", "p1", "p2")
_SUFFIXES = (".png", ".jpg", ".jpeg", ".webp", ".exr")

KNOWN_KEYS = frozenset(
    {"camera_model", "camera_angle_x", "camera_angle_y", "fl_x", "fl_y", "cx", "cy", "w", "h",
     "depth_unit_scale_factor", "integer_depth_scale", "enable_depth_loading", "frames",
     "is_fisheye", INFINITY_KEY, *LENS_KEYS}
)  # fmt: skip
KNOWN_FRAME_KEYS = (KNOWN_KEYS - {"frames"}) | {
    "file_path", *DEPTH_KEYS, "transform_matrix", NAME_KEY,
}  # fmt: skip


def read_transforms(path: str | Path, conventions: Conventions | None = None) -> ViewSet:
    """Read a ``transforms.json`` scene, with or without depth; ours too.

    Args:
        path: the folder, or the JSON file itself (``transforms_train.json``).
        conventions: how to read the numbers instead of the file's own way.

    Raises:
        MissingFileError, FileFormatError, UnsafePathError, SceneError: what is wrong in which file,
            key and frame.
        MissingDependencyError: distorted pictures without OpenCV.
    """
    file = Path(path)
    if file.is_dir():
        file = file / "transforms.json"
    root = read_json(file)
    folder = file.parent
    facts: dict[str, Any] = {"format": "transforms", "path": str(path)}
    if file.name == "transforms.json" and (folder / "belvedere.json").exists():
        facts |= _read_manifest(folder)
    frames = list(root.objects("frames"))
    colors = [_color_file(folder, frame) for frame in frames]
    names = view_names([frame.text("file_path") for frame in frames])
    depths = [_depth_file(folder, frame) for frame in frames]
    pictures = [
        _picture(root, frame, frame.text(NAME_KEY, name), color, depth)
        for frame, name, color, depth in zip(frames, names, colors, depths, strict=True)
    ]
    own, said = _depth_scale(root, next((depth for depth in depths if depth), None))
    chosen = (conventions or CONVENTIONS).resolved(own)
    facts |= {"depth_scale": chosen.depth_scale, "depth_scale_from": said}
    if conventions is not None and conventions.depth_scale is not None:
        facts["depth_scale_from"] = "given by the caller"
    _keep_unknown(facts, root, frames, pictures)
    return build_views(pictures, chosen, facts, stored_infinity(root))


def _picture(
    root: JsonObject, frame: JsonObject, name: str, color: Path, depth: Path | None
) -> Picture:
    pose = frame.array("transform_matrix", _pose_shape(frame))
    width, height = _size(root, frame, color)
    fx, fy = _focals(root, frame, width, height)
    cx = _owner(root, frame, "cx").number("cx", width / 2)
    cy = _owner(root, frame, "cy").number("cy", height / 2)
    lens = _lens(root, frame, Lens(width, height, fx, fy, cx, cy, ()))
    k = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])
    return Picture(frame.here, name, color, depth, k, pose, width, height, lens)


def _owner(root: JsonObject, frame: JsonObject, key: str) -> JsonObject:
    """Whoever says ``key``: the frame where it does, the file otherwise."""
    return frame if key in frame else root


def _pose_shape(frame: JsonObject) -> tuple[int, ...]:
    """(4, 4), or the (3, 4) that some tools write."""
    rows = frame.require("transform_matrix")
    three = isinstance(rows, list) and len(rows) == 3
    return (3, 4) if three and all(isinstance(r, list) and len(r) == 4 for r in rows) else (4, 4)


def _color_file(folder: Path, frame: JsonObject) -> Path:
    where, text = frame.place("file_path"), frame.text("file_path")
    path = inside(folder, text, where)
    if path.is_file():
        return path
    for suffix in _SUFFIXES:  # Blender's synthetic scenes leave it out
        candidate = path.with_name(path.name + suffix)
        if candidate.is_file():
            return inside(folder, text + suffix, where)
    raise MissingFileError(
        f"{where}: no file {text!r} in {folder} (nor with {', '.join(_SUFFIXES)} after it): "
        "paths are relative to transforms.json"
    )


def _depth_file(folder: Path, frame: JsonObject) -> Path | None:
    for key in DEPTH_KEYS:
        if key in frame:
            return existing(folder, frame.text(key), frame.place(key))
    return None


def _size(root: JsonObject, frame: JsonObject, color: Path) -> tuple[int, int]:
    if ("w" in frame or "w" in root) and ("h" in frame or "h" in root):
        return (_owner(root, frame, "w").integer("w", low=1),
                _owner(root, frame, "h").integer("h", low=1))  # fmt: skip
    return image_size(color)


def _focals(root: JsonObject, frame: JsonObject, width: int, height: int) -> tuple[float, float]:
    found: dict[str, float] = {}
    for key, angle, side in (("fl_x", "camera_angle_x", width), ("fl_y", "camera_angle_y", height)):
        owner = _owner(root, frame, key)
        if key in owner:
            found[key] = owner.number(key, above=0.0)
            continue
        owner = _owner(root, frame, angle)
        if angle in owner:
            radians = owner.number(angle, above=0.0)
            if radians >= math.pi:
                raise SceneError(f"{owner.place(angle)} is {radians:g}, expected radians below pi")
            found[key] = 0.5 * side / math.tan(0.5 * radians)
    if not found:
        raise SceneError(
            f"{frame.here} has no focal length: add 'fl_x' (pixels) or 'camera_angle_x' "
            "(radians), for all frames or for each"
        )
    either = next(iter(found.values()))
    return found.get("fl_x", either), found.get("fl_y", either)


def _lens(root: JsonObject, frame: JsonObject, bare: Lens) -> Lens | None:
    owner = _owner(root, frame, "camera_model")
    model = owner.text("camera_model", "OPENCV").upper()
    if model in STRAIGHT_MODELS:
        return None
    if model not in OPENCV_MODELS + FISHEYE_MODELS:
        raise SceneError(
            f"{owner.place('camera_model')} is {model!r}, expected one of "
            f"{', '.join(STRAIGHT_MODELS + OPENCV_MODELS + FISHEYE_MODELS)}: only planar pictures "
            "are read"
        )
    k1, k2, k3, k4, p1, p2 = (_owner(root, frame, key).number(key, 0.0) for key in LENS_KEYS)
    if model in FISHEYE_MODELS or root.data.get("is_fisheye") is True:
        return replace(bare, coefficients=(k1, k2, k3, k4), fisheye=True)
    if k4:
        raise SceneError(
            f"{_owner(root, frame, 'k4').place('k4')} is {k4:g}, which only 'OPENCV_FISHEYE' has: "
            "name the camera_model, or undistort the pictures first"
        )
    return replace(bare, coefficients=(k1, k2, p1, p2, k3))


def _depth_scale(root: JsonObject, sample: Path | None) -> tuple[float, str]:
    for key in ("depth_unit_scale_factor", "integer_depth_scale"):
        if key in root:
            return root.number(key, above=0.0), f"{root.where}: {key}"
    return default_scale(sample)


def _read_manifest(folder: Path) -> dict[str, Any]:
    """What ``belvedere.json`` says, checked for a version that we know."""
    manifest = read_json(folder / "belvedere.json")
    version = manifest.integer("version", low=1)
    if version > VERSION:
        raise SceneError(
            f"{manifest.place('version')} is {version}, but this belvedere reads up to {VERSION}: "
            "the scene was written by a newer one; pip install --upgrade belvedere"
        )
    kind = manifest.text("kind")
    if kind != "views":
        raise SceneError(
            f"{manifest.place('kind')} is {kind!r}, expected 'views': this folder holds another "
            "kind of scene"
        )
    units = manifest.text("units", "metres")
    if units != "metres":
        raise SceneError(f"{manifest.place('units')} is {units!r}, expected 'metres'")
    return {"format": "belvedere", "belvedere": manifest.data}


def _keep_unknown(
    facts: dict[str, Any], root: JsonObject, frames: list[JsonObject], pictures: list[Picture]
) -> None:
    """Remember keys that are not ours, so that writing the scene again keeps them."""
    extra = {key: value for key, value in root.data.items() if key not in KNOWN_KEYS}
    if extra:
        facts["extra"] = extra
    frame_extra: dict[str, Any] = {}
    for frame, picture in zip(frames, pictures, strict=True):
        own = {key: value for key, value in frame.data.items() if key not in KNOWN_FRAME_KEYS}
        if own:
            frame_extra[picture.name] = own
    if frame_extra:
        facts["frame_extra"] = frame_extra
