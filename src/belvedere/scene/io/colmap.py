"""COLMAP's sparse models, text and binary: cameras and images. Points are not read.

Conventions of the files: world-to-camera poses as quaternion (w, x, y, z) and translation, OpenCV
camera axes, the picture's upper left corner at (0, 0), so the first pixel's centre at 0.5.

Source: https://colmap.github.io/format.html
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import FileFormatError, MissingFileError, SceneError
from belvedere.scene.io.atomic import write_bytes
from belvedere.scene.io.lens import Lens
from belvedere.scene.io.rotations import quaternion_of, rotation_of
from belvedere.scene.io.text_files import numbers, text_lines
from belvedere.scene.pose import pose_matrix

F8 = npt.NDArray[np.float64]
MODELS: tuple[tuple[str, int], ...] = (
    ("SIMPLE_PINHOLE", 3), ("PINHOLE", 4), ("SIMPLE_RADIAL", 4), ("RADIAL", 5), ("OPENCV", 8),
    ("OPENCV_FISHEYE", 8), ("FULL_OPENCV", 12), ("FOV", 5), ("SIMPLE_RADIAL_FISHEYE", 4),
    ("RADIAL_FISHEYE", 5), ("THIN_PRISM_FISHEYE", 12),
)  # fmt: skip
"""Name and number of parameters, in the order of their numbers in binary files."""
_COUNTS = dict(MODELS)
_SINGLE_FOCAL = ("SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "SIMPLE_RADIAL_FISHEYE",
                 "RADIAL_FISHEYE")  # fmt: skip
_FISHEYE = ("OPENCV_FISHEYE", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE")
MAX_ITEMS = 1 << 24
"""Cameras, images or points that a header may promise."""


@dataclass(frozen=True, slots=True)
class ColmapCamera:
    """Intrinsics as the model stores them."""

    id: int
    model: str
    width: int
    height: int
    params: tuple[float, ...]
    """Focal lengths, principal point (corner convention), distortion, as ``model`` orders them."""

    def lens(self, where: str) -> Lens:
        """The camera as a lens; the principal point stays in the corner convention.

        Raises:
            SceneError: a camera model that we cannot undistort.
        """
        if self.model in ("FOV", "THIN_PRISM_FISHEYE"):
            raise SceneError(
                f"{where} has the camera model {self.model}, which is not read: undistort with "
                "'colmap image_undistorter'"
            )
        p = self.params
        fx, fy, cx, cy, *rest = (p[0], *p) if self.model in _SINGLE_FOCAL else p
        if fx <= 0 or fy <= 0:
            raise SceneError(f"{where} has focal lengths {fx:g}, {fy:g}: they must be positive")
        fisheye = self.model in _FISHEYE
        coefficients = [*rest, 0.0, 0.0, 0.0, 0.0][: max(4, len(rest))]
        return Lens(self.width, self.height, fx, fy, cx, cy, tuple(coefficients), fisheye)


@dataclass(frozen=True, slots=True, eq=False)
class ColmapImage:
    """A registered picture."""

    id: int
    name: str
    """Its file, relative to the folder of images."""
    camera_id: int
    world_to_camera: F8
    """(4, 4), OpenCV camera axes."""


@dataclass(frozen=True, slots=True, eq=False)
class ColmapModel:
    """Cameras by number, and images in the file's order."""

    cameras: dict[int, ColmapCamera]
    images: tuple[ColmapImage, ...]


def read_model(folder: str | Path) -> ColmapModel:
    """Read ``cameras`` and ``images``, ``.bin`` before ``.txt``.

    Raises:
        MissingFileError: neither pair is there.
        FileFormatError: truncated, corrupt, unknown camera model, an image without its camera.
    """
    place = Path(folder)
    for suffix in (".bin", ".txt"):
        cameras_file, images_file = place / f"cameras{suffix}", place / f"images{suffix}"
        if cameras_file.is_file() and images_file.is_file():
            binary = suffix == ".bin"
            cameras = (_cameras_bin if binary else _cameras_txt)(cameras_file)
            images = (_images_bin if binary else _images_txt)(images_file)
            return _checked(images_file, cameras, images)
    raise MissingFileError(f"{place}: no cameras.bin with images.bin, nor cameras.txt with "
                           "images.txt")  # fmt: skip


def write_model(folder: str | Path, model: ColmapModel, *, binary: bool = True) -> None:
    """Write ``cameras``, ``images`` and an empty ``points3D`` into an existing folder.

    Args:
        folder: where to.
        model: what to write; images without keypoints.
        binary: ``.bin``, or ``.txt`` with every digit.

    Raises:
        OutputError: see `atomic_write`.
    """
    place = Path(folder)
    if binary:
        write_bytes(place / "cameras.bin", _pack_cameras(model))
        write_bytes(place / "images.bin", _pack_images(model))
        write_bytes(place / "points3D.bin", struct.pack("<Q", 0))
        return
    cameras = ["# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]"] + [
        f"{c.id} {c.model} {c.width} {c.height} {' '.join(map(repr, c.params))}"
        for c in model.cameras.values()
    ]
    images = ["# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME", "# POINTS2D[]"]
    for i in model.images:
        images += [f"{i.id} {' '.join(map(repr, _pose_numbers(i)))} {i.camera_id} {i.name}", ""]
    write_bytes(place / "cameras.txt", ("\n".join(cameras) + "\n").encode())
    write_bytes(place / "images.txt", ("\n".join(images) + "\n").encode())
    write_bytes(place / "points3D.txt", b"# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[]\n")


def _checked(
    file: Path, cameras: dict[int, ColmapCamera], images: list[ColmapImage]
) -> ColmapModel:
    for image in images:
        if image.camera_id not in cameras:
            raise FileFormatError(
                f"{file}: image {image.id} ({image.name}) has camera {image.camera_id}, which "
                "cameras does not list: the files are not of one model"
            )
    if not images:
        raise FileFormatError(f"{file}: lists no images: the reconstruction is empty")
    return ColmapModel(cameras, tuple(images))


def _pose_numbers(image: ColmapImage) -> tuple[float, ...]:
    """Qw qx qy qz tx ty tz."""
    pose = image.world_to_camera
    return (*quaternion_of(pose[:3, :3]), *(float(x) for x in pose[:3, 3]))


# ---- text ------------------------------------------------------------------------------------


def _cameras_txt(file: Path) -> dict[int, ColmapCamera]:
    cameras: dict[int, ColmapCamera] = {}
    for number, line in text_lines(file):
        where = f"{file.name}: line {number}"
        words = line.split()
        if len(words) < 4 or words[1] not in _COUNTS:
            raise FileFormatError(
                f"{where} is {line[:60]!r}, expected CAMERA_ID, a camera model, WIDTH, HEIGHT, "
                "PARAMS"
            )
        key, width, height = (int(x) for x in numbers(where, [words[0], *words[2:4]]))
        params = numbers(f"{where} ({words[1]})", words[4:], _COUNTS[words[1]])
        cameras[key] = ColmapCamera(key, words[1], width, height, tuple(params))
    return cameras


def _images_txt(file: Path) -> list[ColmapImage]:
    """Two lines an image, the second (its keypoints) possibly blank: so blank lines count."""
    images: list[ColmapImage] = []
    next(text_lines(file), None)  # checks the file
    points_follow = False
    with file.open(encoding="utf-8") as stream:
        for number, raw in enumerate(stream, start=1):
            line = raw.strip()
            if line.startswith("#"):
                continue
            if points_follow:
                points_follow = False
                continue
            if not line:
                continue
            where = f"{file.name}: line {number}"
            words = line.split(maxsplit=9)
            if len(words) != 10:
                raise FileFormatError(
                    f"{where} has {len(words)} values, expected IMAGE_ID, QW, QX, QY, QZ, TX, TY, "
                    "TZ, CAMERA_ID, NAME"
                )
            key, *pose, camera = numbers(where, words[:9])
            images.append(_image(where, int(key), pose, int(camera), words[9]))
            points_follow = True
    return images


def _image(where: str, key: int, pose: list[float], camera: int, name: str) -> ColmapImage:
    rotation = rotation_of(where, *pose[:4])
    return ColmapImage(key, name, camera, pose_matrix(rotation, pose[4:]))


# ---- binary ----------------------------------------------------------------------------------


def _cameras_bin(file: Path) -> dict[int, ColmapCamera]:
    cameras: dict[int, ColmapCamera] = {}
    with file.open("rb") as stream:
        for _ in range(_count(file, stream)):
            key, model, width, height = _unpack(file, stream, "<iiQQ")
            if not 0 <= model < len(MODELS):
                raise FileFormatError(f"{file}: camera {key} has the unknown model {model}")
            name, count = MODELS[model]
            params = _finite(file, f"camera {key}", _unpack(file, stream, f"<{count}d"))
            cameras[key] = ColmapCamera(key, name, width, height, params)
    return cameras


def _images_bin(file: Path) -> list[ColmapImage]:
    images: list[ColmapImage] = []
    with file.open("rb") as stream:
        for _ in range(_count(file, stream)):
            key, *pose, camera = _unpack(file, stream, "<i7di")
            where = f"{file.name}: image {key}"
            _finite(file, f"image {key}", tuple(pose))
            letters = bytearray()
            while (letter := _take(file, stream, 1)) != b"\x00":
                letters += letter
                if len(letters) > 4096:
                    raise FileFormatError(f"{file}: image {key} has a name of over 4096 letters")
            name = letters.decode("utf-8", errors="replace")
            (points,) = _unpack(file, stream, "<Q")
            if points > MAX_ITEMS:
                raise FileFormatError(f"{file}: image {key} promises {points} keypoints: corrupt")
            _take(file, stream, 24 * points)
            images.append(_image(where, key, list(pose), camera, name))
    return images


def _count(file: Path, stream: BinaryIO) -> int:
    (count,) = _unpack(file, stream, "<Q")
    if count > MAX_ITEMS:
        raise FileFormatError(f"{file}: promises {count} entries: it is corrupt, or no COLMAP file")
    return count


def _unpack(file: Path, stream: BinaryIO, layout: str) -> tuple[int, ...]:
    return struct.unpack(layout, _take(file, stream, struct.calcsize(layout)))


def _take(file: Path, stream: BinaryIO, size: int) -> bytes:
    data = stream.read(size)
    if len(data) != size:
        raise FileFormatError(f"{file}: ends too early, it is truncated: copy it again")
    return data


def _finite(file: Path, what: str, values: tuple[float, ...]) -> tuple[float, ...]:
    if not np.isfinite(values).all():
        raise FileFormatError(f"{file}: {what} has {list(values)}, expected finite numbers")
    return values


def _pack_cameras(model: ColmapModel) -> bytes:
    parts = [struct.pack("<Q", len(model.cameras))]
    order = [name for name, _ in MODELS]
    for c in model.cameras.values():
        parts.append(struct.pack("<iiQQ", c.id, order.index(c.model), c.width, c.height))
        parts.append(struct.pack(f"<{len(c.params)}d", *c.params))
    return b"".join(parts)


def _pack_images(model: ColmapModel) -> bytes:
    parts = [struct.pack("<Q", len(model.images))]
    for image in model.images:
        parts.append(struct.pack("<i7di", image.id, *_pose_numbers(image), image.camera_id))
        parts.append(image.name.encode() + b"\x00" + struct.pack("<Q", 0))
    return b"".join(parts)
