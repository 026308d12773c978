"""Open3D's RGB-D layout, of the Redwood and augmented ICL-NUIM sets.

``color/`` (or ``image/``, ``rgb/``), ``depth/``, ``trajectory.log`` (per picture a line of three
integers, then four lines of camera-to-world) and a camera file with a column-major
``intrinsic_matrix``. Conventions: OpenCV camera axes, pixel centres at integers, depth along the
axis in millimetres. Without a camera file, PrimeSense's nominal 525, 319.5, 239.5 for 640 x 480.
"""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import FileFormatError, MissingFileError, SceneError
from belvedere.scene.conventions import Conventions
from belvedere.scene.io.depth import DEPTH_SUFFIXES
from belvedere.scene.io.images import COLOR_SUFFIXES, image_size
from belvedere.scene.io.json_files import read_json
from belvedere.scene.io.pictures import Picture, build_views
from belvedere.scene.io.text_files import numbers, text_lines
from belvedere.scene.views import ViewSet

CONVENTIONS = Conventions(depth_scale=0.001)
"""The layout's own."""
COLOR_FOLDERS = ("color", "image", "rgb", "images")
CAMERA_FILES = ("camera_primesense.json", "camera_intrinsic.json", "intrinsic.json", "camera.json")
PRIMESENSE = np.array([[525.0, 0, 319.5], [0, 525.0, 239.5], [0, 0, 1.0]])


def read_redwood(path: str | Path, conventions: Conventions | None = None) -> ViewSet:
    """Read a folder in Open3D's RGB-D layout.

    Args:
        path: the folder with ``trajectory.log``.
        conventions: how to read the numbers instead of the layout's own way.

    Raises:
        MissingFileError, FileFormatError, SceneError: what is wrong in which file and line.
    """
    folder = Path(path)
    poses = read_trajectory_log(folder / "trajectory.log")
    sub = next((name for name in COLOR_FOLDERS if (folder / name).is_dir()), None)
    if sub is None:
        raise MissingFileError(f"{folder}: no folder {' or '.join(COLOR_FOLDERS)} with pictures")
    colors = image_files(folder / sub, COLOR_SUFFIXES)
    depths = image_files(folder / "depth", DEPTH_SUFFIXES) if (folder / "depth").is_dir() else []
    for kind, files in (("pictures", colors), ("depth maps", depths)):
        if len(files) != len(poses) and files:
            raise SceneError(
                f"{folder}: {len(files)} {kind} for {len(poses)} poses in trajectory.log: "
                "every picture needs its pose"
            )
    if not colors:
        raise MissingFileError(f"{folder / sub}: holds no pictures")
    k, width, height, source = _intrinsics(folder, colors[0])
    pictures = [
        Picture(
            f"trajectory.log: pose {i}", colors[i].stem, colors[i], depths[i] if depths else None,
            k, pose, width, height,
        )
        for i, pose in enumerate(poses)
    ]  # fmt: skip
    own = CONVENTIONS.depth_scale or 1.0
    chosen = (conventions or CONVENTIONS).resolved(own)
    facts = {"format": "redwood", "path": str(path), "depth_scale": chosen.depth_scale,
             "intrinsics_from": source}  # fmt: skip
    return build_views(pictures, chosen, facts)


def read_trajectory_log(path: str | Path) -> list[npt.NDArray[np.float64]]:
    """The (4, 4) camera-to-world poses of an Open3D ``.log`` file, in its order.

    Raises:
        MissingFileError, FileFormatError: no file, or a line that is not what it must be.
    """
    file = Path(path)
    lines = text_lines(file)
    poses: list[npt.NDArray[np.float64]] = []
    for number, line in lines:
        numbers(f"{file.name}: line {number}", line.split(), 3)
        rows = [
            numbers(f"{file.name}: line {place}", text.split(), 4)
            for place, text in islice(lines, 4)
        ]
        if len(rows) < 4:
            raise FileFormatError(f"{file}: ends within pose {len(poses)}: it is truncated")
        poses.append(np.array(rows))
    return poses


def image_files(folder: Path, suffixes: tuple[str, ...]) -> list[Path]:
    """A folder's images in the order of their names; numbers count by value (2 before 10)."""

    def key(path: Path) -> tuple[Any, ...]:
        return (0, int(path.stem), path.name) if path.stem.isdecimal() else (1, 0, path.name)

    return sorted(
        (
            p
            for p in folder.iterdir()
            if p.suffix.lower() in suffixes and not p.name.startswith(".")
        ),
        key=key,
    )


def read_open3d_camera(path: Path) -> tuple[npt.NDArray[np.float64], int, int]:
    """``K, width, height`` of an Open3D camera file, whose matrix is column-major."""
    root = read_json(path)
    flat = root.array("intrinsic_matrix", (9,))
    return flat.reshape(3, 3).T, root.integer("width", low=1), root.integer("height", low=1)


def _intrinsics(folder: Path, first: Path) -> tuple[npt.NDArray[np.float64], int, int, str]:
    for name in CAMERA_FILES:
        if (folder / name).is_file():
            return *read_open3d_camera(folder / name), name
    width, height = image_size(first)
    if (width, height) != (640, 480):
        raise MissingFileError(
            f"{folder}: no {' or '.join(CAMERA_FILES)}, and the pictures are {width} x {height}, "
            "not 640 x 480: add a camera file"
        )
    return PRIMESENSE, width, height, "PrimeSense's nominal values (no camera file)"
