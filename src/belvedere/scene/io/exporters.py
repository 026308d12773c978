"""A set of views in other tools' layouts: cameras.json, COLMAP, TUM RGB-D.

Every folder also gets a ``belvedere.json``, by which ``force`` knows that it may be replaced.
What a layout cannot hold is refused (another camera per picture in TUM), or told in the notes
(names, infinitely far pixels).
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from belvedere.ground.checks import check_choice, check_path
from belvedere.ground.errors import InputError, SceneError
from belvedere.ground.progress import Progress, silent
from belvedere.ground.wording import counted
from belvedere.scene.camera import Camera
from belvedere.scene.io.atomic import check_replaceable, staged_folder, write_bytes
from belvedere.scene.io.colmap import ColmapCamera, ColmapImage, ColmapModel, write_model
from belvedere.scene.io.colmap_views import DEPTH_FOLDER
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
from belvedere.scene.io.rotations import quaternion_of
from belvedere.scene.io.save import MANIFEST, manifest, save_views
from belvedere.scene.io.tum import DEPTH_STEP
from belvedere.scene.views import ViewSet

TUM_ADVICE = "write another layout (belvedere, cameras.json or colmap)"
"""What helps where TUM's 16-bit depth does not."""

Header = Callable[[Path, list[Camera], list[WrittenFile], PixelPlan], None]


def to_cameras_json(
    views: ViewSet,
    path: str | Path,
    *,
    color_format: ColorFormat | None = None,
    depth_format: DepthFormat = "png16",
    force: bool = False,
    progress: Progress = silent,
) -> SavedViews:
    """Write ``cameras.json`` + ``images/`` + ``depth/``; arguments and errors as `save_views`."""
    check_choice("to_cameras_json", "depth_format", depth_format, DEPTH_FORMATS)
    cameras = planar_cameras(views, "cameras.json", skew=True)
    any_depth = any(entry.has_depth for entry in views.entries)
    step = depth_step(views, None) if any_depth and depth_format == "png16" else None
    plan = PixelPlan("images", color_suffix(views, color_format), "depth", depth_format, step,
                     depth_advice=FLOAT_ADVICE)  # fmt: skip
    return _export(views, path, "cameras.json", cameras, plan, _cameras_json, force, progress)


def to_colmap(
    views: ViewSet,
    path: str | Path,
    *,
    binary: bool = True,
    color_format: ColorFormat | None = None,
    force: bool = False,
    progress: Progress = silent,
) -> SavedViews:
    """Write a COLMAP dense workspace: ``sparse/``, ``images/``, ``stereo/depth_maps/``.

    Args:
        views: as `save_views`.
        path: as `save_views`.
        binary: ``.bin`` model files, or text.
        color_format: as `save_views`.
        force: as `save_views`.
        progress: as `save_views`.

    Raises:
        OutputError, InputError, SceneError: as `save_views`.
    """
    cameras = planar_cameras(views, "COLMAP's PINHOLE model")
    plan = PixelPlan("images", color_suffix(views, color_format), DEPTH_FOLDER, "colmap", None,
                     infinity=False)  # fmt: skip
    header = partial(_colmap_model, binary=binary)
    name = "colmap" if binary else "colmap-text"
    return _export(views, path, name, cameras, plan, header, force, progress)


def to_tum(
    views: ViewSet,
    path: str | Path,
    *,
    color_format: ColorFormat | None = None,
    depth_format: DepthFormat = "png16",
    force: bool = False,
    progress: Progress = silent,
) -> SavedViews:
    """Write the TUM RGB-D layout, a picture a second, with ``calibration.txt``.

    Args:
        views: as `save_views`.
        path: as `save_views`.
        color_format: as `save_views`.
        depth_format: the layout has ``png16`` alone, in steps of 1/5000 m.
        force: as `save_views`.
        progress: as `save_views`.

    Raises:
        SceneError: cameras that differ, or depth for some views only: the layout has one camera.
        InputError: another depth format, or depth beyond 13.1 m, the most that 16 bits of
            1/5000 m hold.
        OutputError: as `save_views`.
    """
    if depth_format != "png16":
        raise InputError(
            f"to_tum.depth_format is {depth_format!r}, but the layout 'tum' holds 16-bit depth "
            f"(png16) only: {TUM_ADVICE}"
        )
    cameras = planar_cameras(views, "the TUM layout")
    if not same_intrinsics(cameras):
        raise SceneError("the TUM layout has one camera for all pictures, but these differ in K "
                         "or size: write transforms.json or cameras.json")  # fmt: skip
    if len({entry.has_depth for entry in views.entries}) > 1:
        raise SceneError("the TUM layout has depth for every picture or none, but these have it "
                         "for some: write transforms.json or cameras.json")  # fmt: skip
    plan = PixelPlan("rgb", color_suffix(views, color_format), "depth", "png16", DEPTH_STEP,
                     infinity=False, depth_advice=TUM_ADVICE)  # fmt: skip
    return _export(views, path, "tum", cameras, plan, _tum_lists, force, progress)


WRITERS: dict[str, Callable[..., SavedViews]] = {
    "belvedere": save_views,
    "transforms": save_views,
    "cameras.json": to_cameras_json,
    "colmap": to_colmap,
    "colmap-text": partial(to_colmap, binary=False),
    "tum": to_tum,
}
"""Layout -> its writer. Our folder is a ``transforms.json`` scene."""


OWN_DEPTH = " (its depth maps have a format of their own)"
"""Why COLMAP's layouts take no depth format."""


def write_views(
    views: ViewSet, path: str | Path, layout: str = "belvedere", **options: Any
) -> SavedViews:
    """Write a set of views in a layout of `WRITERS`; ``options`` as its writer takes them.

    Raises:
        InputError: an unknown layout, ``path`` is no path, or an option that the layout does not
            take.
    """
    check_choice("write_views", "layout", layout, WRITERS)
    check_path("write_views", "path", path)
    writer = WRITERS[layout]
    taken = [
        name
        for name, parameter in inspect.signature(writer).parameters.items()
        if parameter.kind is parameter.KEYWORD_ONLY and name not in ("force", "progress")
    ]
    for name in sorted(options.keys() - {*taken, "force", "progress"}):
        why = OWN_DEPTH if name == "depth_format" else ""
        raise InputError(
            f"write_views.{name}: the layout {layout!r} does not take it{why}: leave it out "
            f"(it takes {', '.join(taken)})"
        )
    return writer(views, path, **options)


def _export(
    views: ViewSet,
    path: str | Path,
    layout: str,
    cameras: list[Camera],
    plan: PixelPlan,
    header: Header,
    force: bool,
    progress: Progress,
) -> SavedViews:
    target = Path(path)
    check_replaceable(target, force, MANIFEST)
    with staged_folder(target, force=force, owned_by=MANIFEST, resume=True) as folder:
        files, resumed, notes = write_pixels(views, folder, plan, progress)
        write_json(folder / MANIFEST, manifest(views) | {"layout": layout})
        header(folder, cameras, files, plan)
    renamed = sum(
        name != file.name
        for name, file in zip(view_names([f.color for f in files]), files, strict=True)
    )
    if renamed and layout != "cameras.json":
        called = "is called after its file" if renamed == 1 else "are called after their files"
        notes = (*notes, f"{counted(renamed, 'view')} {called}: the format has no names")
    return SavedViews(target, layout, len(files), resumed, plan.depth_step, notes)


def _cameras_json(
    folder: Path, cameras: list[Camera], files: list[WrittenFile], plan: PixelPlan
) -> None:
    shared = same_intrinsics(cameras)
    root: dict[str, Any] = _intrinsics(cameras[0]) if shared else {}
    if any(file.depth for file in files):
        step = plan.depth_step
        root["depth_scale"] = 1.0 if step is None else step
        root[INFINITY_KEY] = "inf" if step is None else INFINITY_CODE
    root["pose"] = "camera-to-world, OpenCV camera axes, metres; pixel centres at integers"
    expected = view_names([file.color for file in files])
    frames: list[dict[str, Any]] = []
    for file, camera, name in zip(files, cameras, expected, strict=True):
        frame: dict[str, Any] = {"image": file.color}
        if file.depth is not None:
            frame["depth"] = file.depth
        if name != file.name:
            frame["name"] = file.name
        if not shared:
            frame |= _intrinsics(camera)
        frames.append(frame | {"camera_to_world": camera.camera_to_world.tolist()})
    write_json(folder / "cameras.json", root | {"frames": frames})


def _intrinsics(camera: Camera) -> dict[str, Any]:
    return {"width": camera.width, "height": camera.height, "K": camera.intrinsics.tolist()}


def _colmap_model(
    folder: Path, cameras: list[Camera], files: list[WrittenFile], plan: PixelPlan, binary: bool
) -> None:
    shared = same_intrinsics(cameras)
    models: dict[int, ColmapCamera] = {}
    images: list[ColmapImage] = []
    for index, (camera, file) in enumerate(zip(cameras, files, strict=True), start=1):
        key = 1 if shared else index
        k = camera.intrinsics
        params = (k[0, 0], k[1, 1], k[0, 2] + 0.5, k[1, 2] + 0.5)
        models.setdefault(key, ColmapCamera(key, "PINHOLE", camera.width, camera.height,
                                            tuple(float(p) for p in params)))  # fmt: skip
        name = file.color.removeprefix(f"{plan.color_folder}/")
        images.append(ColmapImage(index, name, key, camera.world_to_camera))
    (folder / "sparse").mkdir(exist_ok=True)
    write_model(folder / "sparse", ColmapModel(models, tuple(images)), binary=binary)


def _tum_lists(
    folder: Path, cameras: list[Camera], files: list[WrittenFile], plan: PixelPlan
) -> None:
    del plan
    k = cameras[0].intrinsics
    numbers = [k[0, 0], k[1, 1], k[0, 2], k[1, 2]]
    lines = {
        "calibration.txt": ["# fx fy cx cy", " ".join(repr(float(x)) for x in numbers)],
        "rgb.txt": ["# timestamp filename"],
        "depth.txt": ["# timestamp filename"],
        "groundtruth.txt": ["# timestamp tx ty tz qx qy qz qw"],
    }
    for index, (camera, file) in enumerate(zip(cameras, files, strict=True)):
        t = f"{index}.000000"
        w, x, y, z = quaternion_of(camera.camera_to_world[:3, :3])
        pose = " ".join(repr(float(value)) for value in (*camera.center, x, y, z, w))
        lines["groundtruth.txt"].append(f"{t} {pose}")
        lines["rgb.txt"].append(f"{t} {file.color}")
        if file.depth is not None:
            lines["depth.txt"].append(f"{t} {file.depth}")
    if len(lines["depth.txt"]) == 1:
        del lines["depth.txt"]
    for name, text in lines.items():
        write_bytes(folder / name, ("\n".join(text) + "\n").encode())
