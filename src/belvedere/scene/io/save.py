"""Our scene folder: ``transforms.json`` that other tools open, and ``belvedere.json`` beside it.

::

    scene/  belvedere.json   kind, version, units, what it affords, provenance
            transforms.json  nerfstudio's keys; depth_file_path and depth_unit_scale_factor too
            images/NAME.png  colour
            depth/NAME.png   16-bit: 0 no sample, 65535 infinitely far, else depth / depth step

"Infinitely far" is written as 65535 (16-bit) or as infinity (float depth), and the key
``belvedere_depth_infinity`` says so; a tool that does not know the key sees 65.535 m. Keys that
are not ours and came with the set are kept, but for those that name files that are not copied.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from belvedere.ground.checks import check_choice
from belvedere.ground.progress import Progress, silent
from belvedere.scene.camera import Camera
from belvedere.scene.io.atomic import check_replaceable, staged_folder, staging_path
from belvedere.scene.io.depth import INFINITY_CODE
from belvedere.scene.io.json_files import write_json
from belvedere.scene.io.pictures import INFINITY_KEY, view_names
from belvedere.scene.io.pixels_out import (
    DEPTH_FORMATS,
    FLOAT_ADVICE,
    ColorFormat,
    DepthFormat,
    PixelPlan,
    SavedViews,
    WrittenFile,
    color_suffix,
    depth_step,
    planar_cameras,
    same_intrinsics,
    write_pixels,
)
from belvedere.scene.io.transforms import (
    KNOWN_FRAME_KEYS,
    KNOWN_KEYS,
    NAME_KEY,
    VERSION,
)
from belvedere.scene.pose import OPENCV_FROM_OPENGL
from belvedere.scene.scene import Affordances
from belvedere.scene.views import ViewSet

MANIFEST = "belvedere.json"
"""Marks a folder that we wrote, and may therefore replace."""


def save_views(
    views: ViewSet,
    path: str | Path,
    *,
    color_format: ColorFormat | None = None,
    depth_format: DepthFormat = "png16",
    depth_step_m: float | None = None,
    force: bool = False,
    progress: Progress = silent,
) -> SavedViews:
    """Save a set of views as a scene folder. It is there complete, or not at all.

    A call that was interrupted goes on, when it is repeated, with what is complete.

    Args:
        views: planar cameras; views without depth are saved without.
        path: the folder to make.
        color_format: ``png``, ``jpg`` (quality 95), ``webp`` (lossless) or ``exr``; by default
            PNG for bytes and OpenEXR for linear colour.
        depth_format: ``png16``, or float32 metres as ``exr``, ``npy`` or ``pfm``.
        depth_step_m: metres per number of 16-bit depth; by default 0.001 where every depth fits.
        force: replace a folder that belvedere wrote.
        progress: called after every view.

    Returns:
        What was written, with what the formats could not hold.

    Raises:
        OutputError: the folder exists without ``force`` or is not ours; disk full, read-only.
        InputError: unknown format; depth that ``depth_step_m`` cannot hold.
        SceneError: a camera that is not planar; a view whose own files are bad.
        MissingDependencyError: OpenEXR without the extra ``exr``.
    """
    target = Path(path)
    check_replaceable(target, force, MANIFEST)
    check_choice("save_views", "depth_format", depth_format, DEPTH_FORMATS)
    cameras = planar_cameras(views, "transforms.json")
    any_depth = any(entry.has_depth for entry in views.entries)
    step = depth_step(views, depth_step_m) if any_depth and depth_format == "png16" else None
    plan = PixelPlan("images", color_suffix(views, color_format), "depth", depth_format, step,
                     depth_advice=FLOAT_ADVICE if depth_step_m is None else None)  # fmt: skip
    with staged_folder(target, force=force, owned_by=MANIFEST, resume=True) as folder:
        files, resumed, notes = write_pixels(views, folder, plan, progress)
        write_json(folder / MANIFEST, manifest(views))
        write_json(folder / "transforms.json", _transforms(views, cameras, files, plan))
    return SavedViews(target, "belvedere", len(files), resumed, step, notes)


def manifest(views: ViewSet) -> dict[str, Any]:
    """What ``belvedere.json`` says of a set of views."""
    from belvedere.ground.version import __version__

    old: dict[str, Any] = dict(views.facts.get("belvedere") or {})
    affords = Affordances("discrete", "none")
    if views.has_depth:
        affords = Affordances("continuous", "local")
    provenance: dict[str, Any] = dict(old.pop("provenance", None) or {})
    if "source_format" not in provenance and "format" in views.facts:
        provenance["source_format"] = views.facts["format"]
        provenance["source"] = Path(str(views.facts.get("path", ""))).name
    provenance["written_by"] = f"belvedere {__version__}"
    own = {"kind": "views", "version": VERSION, "units": "metres",
           "affords": affords.as_dict(), "provenance": provenance}  # fmt: skip
    return own | {key: value for key, value in old.items() if key not in own}


def discard_partial(path: str | Path) -> bool:
    """Remove what an interrupted save of ``path`` left; whether there was anything."""
    import shutil

    partial = staging_path(path)
    if not partial.exists():
        return False
    shutil.rmtree(partial)
    return True


def _transforms(
    views: ViewSet, cameras: list[Camera], files: list[WrittenFile], plan: PixelPlan
) -> dict[str, Any]:
    shared = same_intrinsics(cameras)
    root: dict[str, Any] = {"camera_model": "OPENCV"}
    if shared:
        root |= _intrinsics(cameras[0])
    if any(file.depth for file in files):
        if plan.depth_step is not None:
            root["depth_unit_scale_factor"] = root["integer_depth_scale"] = plan.depth_step
            root[INFINITY_KEY] = INFINITY_CODE
        else:
            root["depth_unit_scale_factor"] = 1.0
            root[INFINITY_KEY] = "inf"
    root |= _kept(views.facts.get("extra"), KNOWN_KEYS)
    expected = view_names([file.color for file in files])
    frame_extra = views.facts.get("frame_extra") or {}
    frames: list[dict[str, Any]] = []
    for file, camera, name in zip(files, cameras, expected, strict=True):
        frame: dict[str, Any] = {"file_path": file.color}
        if file.depth is not None:
            frame["depth_file_path"] = file.depth
        if name != file.name:
            frame[NAME_KEY] = file.name
        if not shared:
            frame |= _intrinsics(camera)
        frame["transform_matrix"] = (camera.camera_to_world @ OPENCV_FROM_OPENGL).tolist()
        frames.append(frame | _kept(frame_extra.get(file.name), KNOWN_FRAME_KEYS))
    return root | {"frames": frames}


def _intrinsics(camera: Camera) -> dict[str, Any]:
    k = camera.intrinsics
    return {"fl_x": float(k[0, 0]), "fl_y": float(k[1, 1]), "cx": float(k[0, 2]) + 0.5,
            "cy": float(k[1, 2]) + 0.5, "w": camera.width, "h": camera.height}  # fmt: skip


def _kept(extra: dict[str, Any] | None, known: frozenset[str]) -> dict[str, Any]:
    """Keys that are not ours, but for those that name files: these are not copied."""
    return {
        key: value
        for key, value in (extra or {}).items()
        if key not in known and not key.endswith(("_path", "_paths", "_filenames"))
    }
