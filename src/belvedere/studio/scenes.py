"""Opening and saving scenes of every kind.

A file format knows pictures and cameras; only this floor knows which kinds of scene they can
become. `open_scene` looks at what lies in a folder, reads it, and gives the scene that shows it.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

from belvedere.ground.checks import check_path
from belvedere.ground.errors import InputError, SceneError
from belvedere.scene import Scene, ViewSet
from belvedere.scene.conventions import Conventions
from belvedere.scene.io.detect import detect_format, find_format, read_views
from belvedere.scene.io.json_files import read_json
from belvedere.scene.io.pixels_out import SavedViews
from belvedere.scene.io.save import save_views
from belvedere.studio._judgement import ConventionReport
from belvedere.studio.conventions import check_conventions
from belvedere.warp import DepthViews, Photographs


class ConventionWarning(UserWarning):
    """A capture's views disagree, as they do when a scale or a convention is wrong."""


def open_scene(
    path: str | Path,
    *,
    check: bool = False,
    format: str | None = None,  # noqa: A002 - the command line's word, and everybody's
    depth_scale: float | None = None,
    depth_kind: str | None = None,
    pose: str | None = None,
    axes: str | None = None,
    pixel_centers: str | None = None,
    **choices: Any,
) -> Scene:
    """Open a scene: posed pictures in any format that belvedere reads, or a prepared building.

    ::

        scene = bv.open_scene("capture/", check=True)
        frame = scene.render(scene.home)

    Args:
        path: a folder, or its ``transforms.json`` or ``cameras.json``.
        check: warp neighbouring views into each other first, and warn in one line if they disagree,
            with the option that would make them agree. Costs a second or two.
        format: a name in `belvedere.scene.io.FORMATS`, instead of looking.
        depth_scale: metres per stored unit of depth, instead of what the format says.
        depth_kind: "z", "ray" or "disparity", instead of the format's own.
        pose: "camera_to_world" or "world_to_camera".
        axes: "opencv" or "opengl".
        pixel_centers: "integer" or "half".
        choices: for `DepthViews`: ``references``, ``threads``, ``reconstruction``, ``fill`` ...

    Returns:
        `Walkthrough` for a folder that `prepare` made (its choices are those of `WalkOptions`);
        `DepthViews` where any picture has depth (pictures without it are left out), otherwise
        `Photographs`.

    Raises:
        MissingFileError, UnsafePathError, FileFormatError, SceneError: what is wrong where.
        InputError: ``path`` is no path; an option that does not exist, or a value that it does not
            take.

    Warns:
        ConventionWarning: with ``check``, when views disagree.
    """
    check_path("open_scene", "path", path)
    if is_walkthrough(path):
        from belvedere.walkthrough import WalkOptions, Walkthrough

        threads = choices.pop("threads", None)
        for name in choices:
            if name not in WalkOptions.__dataclass_fields__:
                raise InputError(
                    f"open_scene: {name} is no choice of a walkthrough, expected one of "
                    f"{', '.join(WalkOptions.__dataclass_fields__)}, threads"
                )
        return Walkthrough.open(path, WalkOptions(**choices), threads)
    asked = stated_conventions(
        depth_scale=depth_scale,
        depth_kind=depth_kind,
        pose=pose,
        axes=axes,
        pixel_centers=pixel_centers,
    )
    views = read_capture(path, asked, format)
    if check:
        report = check_views(views)
        if report is not None and report.verdict == "mistake":
            warnings.warn(f"{path}: {report.line}", ConventionWarning, stacklevel=2)
    return scene_of(views, **choices)


def is_walkthrough(path: str | Path) -> bool:
    """Whether a folder says that it is a prepared building."""
    manifest = Path(path) / "belvedere.json"
    if not manifest.is_file():
        return False
    return read_json(manifest).data.get("kind") == "walkthrough"


def scene_of(views: ViewSet, **choices: Any) -> DepthViews | Photographs:
    """The scene that shows a set of views.

    Args:
        views: with depth, without, or some with.
        choices: for `DepthViews`; a set without depth takes ``threads`` only.

    Raises:
        InputError: choices for depth views where no view has depth.
    """
    with_depth = [index for index, entry in enumerate(views.entries) if entry.has_depth]
    if with_depth:
        whole = len(with_depth) == len(views)
        return DepthViews(views if whole else views.select(with_depth), **choices)
    threads = choices.pop("threads", None)
    choices.pop("references", None)
    if choices:
        raise InputError(
            f"open_scene: {sorted(choices)[0]} is for scenes with depth, and none of the "
            f"{len(views)} pictures has any"
        )
    return Photographs(views, threads=threads)


def stated_conventions(**stated: Any) -> dict[str, Any]:
    """The conventions that were stated, without those left as None.

    Raises:
        InputError: a value that a convention does not take.
    """
    asked = {name: value for name, value in stated.items() if value is not None}
    replace(Conventions(), **asked)  # refuses wrong values before any file is read
    return asked


def read_capture(
    path: str | Path,
    asked: dict[str, Any] | None = None,
    format: str | None = None,  # noqa: A002 - as in open_scene
) -> ViewSet:
    """Posed pictures from disk, read by their format's conventions but for those ``asked``.

    Raises:
        SceneError: a prepared building, which is no set of pictures.
    """
    if is_walkthrough(path):
        raise SceneError(
            f"{path}: is a prepared building, not a set of pictures: belvedere walk shows it, and "
            "each folder in its references/ is a set of pictures"
        )
    if not asked:
        return read_views(path, format=format)
    layout = detect_format(path) if format is None else find_format(format)
    return read_views(path, replace(layout.conventions, **asked), format)


def check_views(views: ViewSet) -> ConventionReport | None:
    """Whether neighbouring views agree, and if not, what would make them agree.

    Returns:
        None where there is nothing to compare: no depth, or no stored numbers to re-read.
    """
    conventions = views.facts.get("conventions")
    indices = [index for index, entry in enumerate(views.entries) if entry.has_depth]
    if not indices or conventions is None:
        return None
    current = Conventions(**conventions).resolved(float(views.facts.get("depth_scale") or 1.0))
    return check_conventions(views.select(indices), current)


def save_scene(
    scene: Scene | ViewSet, path: str | Path, *, force: bool = False, **options: Any
) -> SavedViews:
    """Save a scene as a folder of standard files.

    Args:
        scene: `DepthViews`, `Photographs` or the `ViewSet` of one.
        path: the folder to make; it is there complete, or not at all.
        force: replace a folder that belvedere wrote.
        options: as `belvedere.scene.io.save_views`: ``color_format``, ``depth_format`` ...

    Raises:
        InputError: a kind of scene that has no file format.
        OutputError: the folder exists without ``force``, or cannot be written.
    """
    views = scene if isinstance(scene, ViewSet) else getattr(scene, "views", None)
    if not isinstance(views, ViewSet):
        raise InputError(
            f"save_scene: a {type(scene).__name__} has no file format, expected depth views, "
            "photographs or a set of views: render it to views first"
        )
    return save_views(views, path, force=force, **options)
