"""A rectified stereo pair with true disparity, as Middlebury publishes them.

* 2014: ``im0 im1 disp0.pfm [disp1.pfm] calib.txt``; ``Z = baseline f / (d + doffs)``.
* 2003: ``left right disp_left [disp_right]`` and no calibration. Assumed, and to be given where
  known: a focal length of 3740 pixels at a width of 1800 (the later Middlebury rigs; 935 at 450)
  and a baseline of 0.16 m. A wrong guess scales the world's depth; warps stay right.

The left camera stands at the origin and looks along +y of our world (z up); the right one stands
``baseline`` metres to its right. Pixel centres at integers; ``x_right = x_left - d``. A disparity
of 0, NaN or infinity is no sample. A view has depth where its own disparity map is there.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_number
from belvedere.ground.errors import FileFormatError, MissingFileError, SceneError
from belvedere.scene.conventions import Conventions
from belvedere.scene.io.images import image_size
from belvedere.scene.io.pictures import Picture, build_views
from belvedere.scene.io.text_files import numbers, text_lines
from belvedere.scene.pose import pose_matrix
from belvedere.scene.views import ViewSet

F8 = npt.NDArray[np.float64]
CONVENTIONS = Conventions(depth_kind="disparity")
"""The layouts' own; ``depth_scale`` is 1 / (focal length x baseline)."""
ASSUMED_FOCAL = 3740.0 / 1800.0
"""Focal length over width, where nothing says."""
ASSUMED_BASELINE = 0.16
"""Metres, where nothing says."""
LAYOUTS = (("im0", "im1", "disp0", "disp1"), ("left", "right", "disp_left", "disp_right"))
"""File stems: left and right picture, left and right disparity."""
_COLOR = (".png", ".ppm.png", ".jpg", ".jpeg", ".webp", ".tif", ".exr")
_DISPARITY = (".pfm", ".tif", ".tiff", ".png", ".exr", ".npy")
FORWARD_Y = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
"""Columns right, down, forward: looks along +y with +z up."""


@dataclass(frozen=True, slots=True)
class StereoRig:
    """Calibration of a rectified pair, pixels and metres."""

    left_k: F8
    """(3, 3) of the left picture."""
    right_k: F8
    """(3, 3) of the right picture."""
    baseline: float
    """Metres."""
    doffs: float
    """Difference of the principal points' columns, right minus left, pixels."""
    source: str
    """Where the numbers come from."""


def read_stereo(
    path: str | Path,
    conventions: Conventions | None = None,
    *,
    focal_px: float | None = None,
    baseline: float | None = None,
) -> ViewSet:
    """Read a rectified pair: the views ``left`` and ``right``.

    Args:
        path: the folder.
        conventions: how to read the numbers instead of the layout's own way.
        focal_px: focal length in pixels instead of the file's or the assumed one.
        baseline: metres instead of the file's or the assumed one.

    Raises:
        MissingFileError, FileFormatError, SceneError: a picture or disparity is missing, calib.txt
            lacks a key, pictures and calibration differ in size.
        InputError: a focal length or baseline that is not positive.
    """
    folder = Path(path)
    files = stereo_files(folder)
    if files is None:
        raise MissingFileError(
            f"{folder}: no rectified pair: expected "
            + "; ".join(f"{a}.*, {b}.*, {c}.*" for a, b, c, _ in LAYOUTS)
        )
    size = image_size(files["left"])
    rig = stereo_rig(folder, size, focal_px, baseline)
    scale = 1.0 / (rig.left_k[0, 0] * rig.baseline)
    chosen = (conventions or CONVENTIONS).resolved(scale)
    pictures = [
        Picture(
            f"{folder.name}: {side}", side, files[side], files.get(f"disp_{side}"), k,
            pose_matrix(FORWARD_Y, [offset, 0, 0]), *size,
            depth_offset=rig.doffs,
        )
        for side, k, offset in (("left", rig.left_k, 0.0), ("right", rig.right_k, rig.baseline))
    ]  # fmt: skip
    facts: dict[str, Any] = {
        "format": "stereo", "path": str(path), "depth_scale": chosen.depth_scale,
        "calibration_from": rig.source, "focal_px": float(rig.left_k[0, 0]),
        "baseline_m": rig.baseline, "doffs_px": rig.doffs,
    }  # fmt: skip
    return build_views(pictures, chosen, facts)


def stereo_files(folder: Path) -> dict[str, Path] | None:
    """The pair's files by role (left, right, disp_left, disp_right), or None: no pair here."""
    for left, right, disp_left, disp_right in LAYOUTS:
        found = {
            role: file
            for role, stem, suffixes in (
                ("left", left, _COLOR), ("right", right, _COLOR),
                ("disp_left", disp_left, _DISPARITY), ("disp_right", disp_right, _DISPARITY),
            )
            if (file := _first(folder, stem, suffixes)) is not None
        }  # fmt: skip
        if {"left", "right", "disp_left"} <= found.keys():
            return found
    return None


def stereo_rig(
    folder: Path, size: tuple[int, int], focal_px: float | None, baseline: float | None
) -> StereoRig:
    """The calibration of a pair of ``size`` (width, height): given, from calib.txt, or assumed."""
    for name, value in (("focal_px", focal_px), ("baseline", baseline)):
        if value is not None:
            check_number("read_stereo", name, value, 0.0, open_low=True)
    width, height = size
    if (folder / "calib.txt").is_file():
        rig = read_middlebury_calibration(folder / "calib.txt", size)
        if focal_px is None and baseline is None:
            return rig
        k0, k1 = rig.left_k.copy(), rig.right_k.copy()
        if focal_px is not None:
            k0[[0, 1], [0, 1]] = k1[[0, 1], [0, 1]] = focal_px
        return StereoRig(k0, k1, baseline or rig.baseline, rig.doffs, "calib.txt and the caller")
    focal = focal_px if focal_px is not None else ASSUMED_FOCAL * width
    k = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1.0]])
    known = focal_px is not None and baseline is not None
    return StereoRig(
        k, k, baseline if baseline is not None else ASSUMED_BASELINE, 0.0,
        "the caller" if known else "assumed (no calib.txt): depth is right up to a scale",
    )  # fmt: skip


def read_middlebury_calibration(path: str | Path, size: tuple[int, int]) -> StereoRig:
    """Read a ``calib.txt`` of Middlebury 2014 (baseline in millimetres).

    Raises:
        MissingFileError, FileFormatError, SceneError: a key is missing or wrong, or it is for
            pictures of another size.
    """
    file = Path(path)
    values = {}
    for number, line in text_lines(file):
        key, equals, value = line.partition("=")
        if not equals:
            raise FileFormatError(
                f"{file.name}: line {number} is {line[:40]!r}, expected key=value"
            )
        values[key.strip()] = value.strip()
    for key in ("cam0", "cam1", "baseline"):
        if key not in values:
            raise FileFormatError(f"{file}: has no {key!r}: it is not a Middlebury calibration")
    k0, k1 = (
        np.array(numbers(f"{file.name}: {cam}", re.sub(r"[\[\];]", " ", values[cam]).split(), 9))
        .reshape(3, 3)
        for cam in ("cam0", "cam1")
    )  # fmt: skip
    doffs = numbers(f"{file.name}: doffs", [values.get("doffs", str(k1[0, 2] - k0[0, 2]))])[0]
    baseline = numbers(f"{file.name}: baseline", [values["baseline"]])[0] / 1000.0
    if baseline <= 0 or k0[0, 0] <= 0:
        raise FileFormatError(
            f"{file}: baseline {baseline * 1000:g} mm and focal length {k0[0, 0]:g} px must be "
            "positive"
        )
    for key, have in zip(("width", "height"), size, strict=True):
        if key in values and int(numbers(f"{file.name}: {key}", [values[key]])[0]) != have:
            raise SceneError(
                f"{file}: {key} is {values[key]}, but the pictures have {have}: scale the "
                "calibration with the pictures"
            )
    return StereoRig(k0, k1, baseline, doffs, file.name)


def _first(folder: Path, stem: str, suffixes: tuple[str, ...]) -> Path | None:
    return next((p for s in suffixes if (p := folder / f"{stem}{s}").is_file()), None)
