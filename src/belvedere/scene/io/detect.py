"""Which format a folder is in, told by what lies in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from belvedere.ground.checks import check_choice, check_path
from belvedere.ground.errors import InputError, MissingFileError, SceneError
from belvedere.scene.conventions import Conventions
from belvedere.scene.io.cameras_json import CONVENTIONS as CAMERAS_JSON_CONVENTIONS
from belvedere.scene.io.cameras_json import read_cameras_json
from belvedere.scene.io.colmap_views import CONVENTIONS as COLMAP_CONVENTIONS
from belvedere.scene.io.colmap_views import model_folder, read_colmap
from belvedere.scene.io.json_files import read_json
from belvedere.scene.io.redwood import CONVENTIONS as REDWOOD_CONVENTIONS
from belvedere.scene.io.redwood import read_redwood
from belvedere.scene.io.stereo import CONVENTIONS as STEREO_CONVENTIONS
from belvedere.scene.io.stereo import read_stereo, stereo_files
from belvedere.scene.io.transforms import CONVENTIONS as TRANSFORMS_CONVENTIONS
from belvedere.scene.io.transforms import read_transforms
from belvedere.scene.io.tum import CONVENTIONS as TUM_CONVENTIONS
from belvedere.scene.io.tum import read_tum
from belvedere.scene.views import ViewSet


@dataclass(frozen=True, slots=True)
class ViewFormat:
    """A layout of posed pictures that we read."""

    name: str
    looks_for: str
    """What tells it, in words."""
    conventions: Conventions
    """Its own; a ``depth_scale`` of None is told by its files."""
    recognises: Callable[[Path], bool]
    read: Callable[[Path, Conventions | None], ViewSet]


FORMATS: tuple[ViewFormat, ...] = (
    ViewFormat("transforms", "transforms.json (belvedere, nerfstudio, instant-ngp)",
               TRANSFORMS_CONVENTIONS, lambda p: (p / "transforms.json").is_file(),
               read_transforms),
    ViewFormat("cameras.json", "cameras.json", CAMERAS_JSON_CONVENTIONS,
               lambda p: (p / "cameras.json").is_file(), read_cameras_json),
    ViewFormat("tum", "rgb.txt and groundtruth.txt (TUM RGB-D)", TUM_CONVENTIONS,
               lambda p: (p / "rgb.txt").is_file() and (p / "groundtruth.txt").is_file(),
               read_tum),
    ViewFormat("redwood", "trajectory.log (Open3D, Redwood, ICL-NUIM)", REDWOOD_CONVENTIONS,
               lambda p: (p / "trajectory.log").is_file(), read_redwood),
    ViewFormat("colmap", "cameras.bin and images.bin, or .txt, here or in sparse/ (COLMAP)",
               COLMAP_CONVENTIONS, lambda p: model_folder(p) is not None, read_colmap),
    ViewFormat("stereo", "im0, im1, disp0 or left, right, disp_left (Middlebury)",
               STEREO_CONVENTIONS, lambda p: stereo_files(p) is not None, read_stereo),
)  # fmt: skip
"""Looked for in this order; the first that fits is read."""


def find_format(name: str) -> ViewFormat:
    """The format called ``name``.

    Raises:
        InputError: there is none.
    """
    check_choice("read_views", "format", name, [entry.name for entry in FORMATS])
    return next(entry for entry in FORMATS if entry.name == name)


def detect_format(path: str | Path) -> ViewFormat:
    """The format of a folder, or of the JSON file that heads a scene.

    Raises:
        MissingFileError: there is nothing at ``path``.
        SceneError: an empty folder, or nothing we know; the message lists what was looked for.
        InputError: ``path`` is no path.
    """
    place = check_path("detect_format", "path", path)
    if not place.exists():
        raise MissingFileError(f"no file or folder {place}: check the name")
    if place.is_file():
        if place.suffix.lower() != ".json":
            raise SceneError(
                f"{place} is a file, expected a folder with posed pictures, a transforms.json or a "
                "cameras.json"
            )
        return find_format("cameras.json" if place.name == "cameras.json" else "transforms")
    for entry in FORMATS:
        if entry.recognises(place):
            return entry
    if not any(place.iterdir()):
        raise SceneError(f"{place} is an empty folder, expected a scene")
    if (place / "belvedere.json").is_file():
        kind = read_json(place / "belvedere.json").text("kind")
        raise SceneError(
            f"{place}: belvedere.json says its kind is {kind!r}, but there is no set of posed "
            "pictures (transforms.json) in it"
        )
    raise SceneError(
        f"{place}: no scene that belvedere knows; looked for "
        + "; ".join(entry.looks_for for entry in FORMATS)
    )


def read_views(
    path: str | Path,
    conventions: Conventions | None = None,
    format: str | None = None,  # noqa: A002 - the command line's word, and everybody's
) -> ViewSet:
    """Read posed pictures, with depth where they have it, in any format we know.

    Pixels are read when a view is asked for. ``facts`` tells what was found: ``format``,
    ``frames``, ``frames_with_depth``, ``depth_scale``, ``conventions``, ``undistorted`` ...

    Args:
        path: a folder, or the ``transforms.json`` or ``cameras.json`` of one.
        conventions: how to read the numbers instead of the format's own way; start from
            `format_conventions` to change one of them.
        format: one of the names in `FORMATS`, instead of looking.

    Raises:
        MissingFileError, UnsafePathError, FileFormatError, SceneError: what is wrong where.
        InputError: ``path`` is no path, ``format`` is unknown or ``conventions`` are not
            `Conventions`.
    """
    place = check_path("read_views", "path", path)
    if conventions is not None and not isinstance(conventions, Conventions):
        raise InputError(
            f"read_views.conventions is a {type(conventions).__name__}, expected belvedere's "
            "Conventions"
        )
    if format is None:
        return detect_format(place).read(place, conventions)
    chosen = find_format(format)
    if not place.exists():
        raise MissingFileError(f"no file or folder {place}: check the name")
    return chosen.read(place, conventions)


def format_conventions(path: str | Path) -> Conventions:
    """The conventions that the format of ``path`` has by itself.

    ``dataclasses.replace`` changes one of them for `read_views`.
    """
    return detect_format(path).conventions
