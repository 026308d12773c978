"""The TUM RGB-D layout: ``rgb.txt``, ``depth.txt``, ``groundtruth.txt``, timestamps associated.

Conventions: camera-to-world poses as ``timestamp tx ty tz qx qy qz qw``, OpenCV camera axes, pixel
centres at integers, depth along the axis in 1/5000 metre. The layout has no place for intrinsics:
``calibration.txt`` with ``fx fy cx cy`` is read where it is there; otherwise 525, 525, 319.5,
239.5 for 640 x 480, which the set's authors recommend for its registered depth.

Source: https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import FileFormatError, MissingFileError, SceneError
from belvedere.scene.conventions import Conventions
from belvedere.scene.io.images import image_size
from belvedere.scene.io.paths import existing
from belvedere.scene.io.pictures import Picture, build_views, view_names
from belvedere.scene.io.redwood import PRIMESENSE
from belvedere.scene.io.rotations import rotation_of
from belvedere.scene.io.text_files import numbers, text_lines
from belvedere.scene.pose import pose_matrix
from belvedere.scene.views import ViewSet

F8 = npt.NDArray[np.float64]
DEPTH_STEP = 1.0 / 5000.0
CONVENTIONS = Conventions(depth_scale=DEPTH_STEP)
"""The layout's own."""
MAX_DIFFERENCE_S = 0.02
"""Seconds by which a depth map or pose may differ from its picture, as the set's own tool."""


def read_tum(
    path: str | Path,
    conventions: Conventions | None = None,
    max_difference_s: float = MAX_DIFFERENCE_S,
) -> ViewSet:
    """Read a folder in the TUM RGB-D layout.

    Args:
        path: the folder with ``rgb.txt``.
        conventions: how to read the numbers instead of the layout's own way.
        max_difference_s: pictures without a pose nearer than this are left out and counted in
            the facts; each pose and depth map serves one picture, the closest pairs first.

    Raises:
        MissingFileError, FileFormatError, UnsafePathError, SceneError: what is wrong in which file
            and line; no picture has a pose.
    """
    folder = Path(path)
    rgb = _read_list(folder / "rgb.txt")
    depth = _read_list(folder / "depth.txt") if (folder / "depth.txt").is_file() else []
    poses = read_trajectory_tum(folder / "groundtruth.txt")
    of_pose = associate([t for t, _, _ in rgb], [t for t, _ in poses], max_difference_s)
    of_depth = associate([t for t, _, _ in rgb], [t for t, _, _ in depth], max_difference_s)
    used = [i for i in sorted(of_pose) if not depth or i in of_depth]
    if not used:
        raise SceneError(
            f"{folder}: no picture of rgb.txt lies within {max_difference_s:g} s of a pose in "
            "groundtruth.txt" + (" and a map in depth.txt" if depth else "") + ": are the clocks "
            "the same?"
        )
    color_files = {i: existing(folder, rgb[i][1], rgb[i][2]) for i in used}
    k, width, height, source = _intrinsics(folder, color_files[used[0]])
    names = dict(zip(used, view_names([rgb[i][1] for i in used]), strict=True))
    pictures = [
        Picture(
            rgb[i][2], names[i], color_files[i],
            existing(folder, depth[of_depth[i]][1], depth[of_depth[i]][2]) if depth else None,
            k, poses[of_pose[i]][1], width, height,
        )
        for i in used
    ]  # fmt: skip
    chosen = (conventions or CONVENTIONS).resolved(DEPTH_STEP)
    facts = {
        "format": "tum",
        "path": str(path),
        "depth_scale": chosen.depth_scale,
        "intrinsics_from": source,
        "pictures_without_partner": len(rgb) - len(used),
    }
    return build_views(pictures, chosen, facts)


def associate(first: list[float], second: list[float], max_difference: float) -> dict[int, int]:
    """For each index of ``first`` its partner in ``second``: nearest pairs first, each used once.

    Args:
        first: timestamps, seconds.
        second: timestamps, seconds.
        max_difference: pairs further apart are no pairs.

    Source: ``associate.py`` of the TUM RGB-D benchmark.
    """
    order = np.argsort(np.array(second), kind="stable")
    times = np.array(second)[order] if second else np.zeros(0)
    pairs: list[tuple[float, int, int]] = []
    for i, t in enumerate(first):
        low = int(np.searchsorted(times, t - max_difference, side="left"))
        high = int(np.searchsorted(times, t + max_difference, side="right"))
        pairs += [(abs(float(times[j]) - t), i, int(order[j])) for j in range(low, high)]
    found: dict[int, int] = {}
    taken: set[int] = set()
    for _, i, j in sorted(pairs):
        if i not in found and j not in taken:
            found[i] = j
            taken.add(j)
    return found


def read_trajectory_tum(path: str | Path) -> list[tuple[float, F8]]:
    """Timestamps and (4, 4) camera-to-world poses of a TUM trajectory, in the file's order.

    Raises:
        MissingFileError, FileFormatError: no file, or a line that is not what it must be.
    """
    file = Path(path)
    poses: list[tuple[float, F8]] = []
    for number, line in text_lines(file):
        where = f"{file.name}: line {number}"
        t, x, y, z, qx, qy, qz, qw = numbers(where, line.split(), 8)
        poses.append((t, pose_matrix(rotation_of(where, qw, qx, qy, qz), [x, y, z])))
    if not poses:
        raise FileFormatError(f"{file}: lists no poses")
    return poses


def _read_list(file: Path) -> list[tuple[float, str, str]]:
    """Timestamp, file name and place of each line."""
    rows: list[tuple[float, str, str]] = []
    for number, line in text_lines(file):
        words = line.split(maxsplit=1)
        where = f"{file.name}: line {number}"
        if len(words) != 2:
            raise FileFormatError(f"{where} is {line[:40]!r}, expected a timestamp and a file")
        rows.append((numbers(where, words[:1], 1)[0], words[1], where))
    if not rows:
        raise FileFormatError(f"{file}: lists no files")
    return rows


def _intrinsics(folder: Path, first: Path) -> tuple[F8, int, int, str]:
    width, height = image_size(first)
    file = folder / "calibration.txt"
    if file.is_file():
        number, line = next(text_lines(file), (0, ""))
        where = f"calibration.txt: line {number}"
        words = line.split()
        if len(words) > 4 and any(numbers(where, words[4:])):
            raise SceneError(
                f"{where} has distortion {words[4:]}, but registered depth is not distorted the "
                "same way: undistort the pictures, or leave fx fy cx cy alone"
            )
        fx, fy, cx, cy = numbers(where, words[:4], 4)
        return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]]), width, height, file.name
    if (width, height) != (640, 480):
        raise MissingFileError(
            f"{folder}: no calibration.txt, and the pictures are {width} x {height}, not 640 x "
            "480: add one with 'fx fy cx cy' in pixels"
        )
    return PRIMESENSE, width, height, "the benchmark's default 525, 319.5, 239.5"
