"""``belvedere render``."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from belvedere.cli.arguments import (
    AxesOption,
    DepthKindOption,
    DepthScaleOption,
    Fill,
    FillOption,
    ForceOption,
    FormatOption,
    JsonOption,
    PixelCentersOption,
    PoseOption,
    Reconstruction,
    ReconstructionOption,
    ReferencesOption,
    SceneArgument,
    SizeOption,
    ThreadsOption,
    Visibility,
    VisibilityOption,
    look_option,
    output_option,
    parse_size,
    stated,
)
from belvedere.cli.console import progress_bar, say, say_json
from belvedere.ground.errors import InputError
from belvedere.ground.wording import counted

if TYPE_CHECKING:
    from belvedere.scene import CameraModel
    from belvedere.warp import DepthViews

EXPLAINED = ("source", "holes", "error")
"""Pictures that ``--explain`` writes; their names' last part but one."""
PICTURE_SUFFIXES = (".png", ".webp", ".jpg", ".jpeg", ".exr")


def render(
    scene: SceneArgument,
    path: Annotated[
        str,
        look_option(
            "--path",
            "-p",
            help="Where the camera goes: wobble, through, orbit, dolly, or a path file (JSON).",
        ),
    ] = "wobble",
    output: Annotated[
        Path | None,
        output_option(
            "--output",
            "-o",
            help="NAME.mp4 (a video), NAME (a folder of pictures) or NAME.png/.exr (one picture). "
            "By default the scene's name and .mp4.",
        ),
    ] = None,
    seconds: Annotated[float | None, look_option(min=0.01, help="Length of a preset path.")] = None,
    at: Annotated[
        float,
        look_option(min=0.0, help="For one picture: seconds along the path."),
    ] = 0.0,
    fps: Annotated[float, look_option(min=0.1, max=240, help="Frames a second.")] = 30.0,
    frames: Annotated[
        int | None,
        look_option(min=1, help="How many frames, instead of seconds times fps."),
    ] = None,
    size: SizeOption = None,
    reconstruction: ReconstructionOption = Reconstruction.INVERSE,
    visibility: VisibilityOption = Visibility.ORDER,
    references: ReferencesOption = 2,
    fill: FillOption = Fill.BACKGROUND,
    explain: Annotated[
        bool,
        output_option(
            "--explain",
            help="For one picture: write beside it, in false colours, which reference each pixel "
            "comes from (.source), what kinds of holes there are (.holes) and how far off colours "
            "are expected to be (.error).",
        ),
    ] = False,
    threads: ThreadsOption = None,
    force: ForceOption = False,
    as_json: JsonOption = False,
    layout: FormatOption = None,
    depth_scale: DepthScaleOption = None,
    depth_kind: DepthKindOption = None,
    pose: PoseOption = None,
    axes: AxesOption = None,
    pixel_centers: PixelCentersOption = None,
) -> None:
    """Render new views of a scene along a path: a video, a folder of pictures, or one picture.

    Interrupted jobs go on where they stopped when the same command is repeated.

    Examples: belvedere render capture/ -o walk.mp4;
    belvedere render capture/ --path orbit -o frames --frames 60;
    belvedere render capture/ --at 1.5 -o view.png --explain
    """
    from belvedere.scene.io import save_frame
    from belvedere.scene.io.atomic import require_free
    from belvedere.studio.paths import path_for
    from belvedere.studio.scenes import read_capture, scene_of
    from belvedere.studio.walk import render_path
    from belvedere.warp import DepthViews

    asked = stated(depth_scale, depth_kind, pose, axes, pixel_centers)
    wanted = parse_size(size)
    views = read_capture(scene, asked, layout)
    choices = {"reconstruction": reconstruction.value, "visibility": visibility.value}
    if not any(entry.has_depth for entry in views.entries):
        opened = scene_of(views, threads=threads)
    else:
        opened = scene_of(views, references=references, threads=threads, fill=fill.value, **choices)
    target = output or Path(scene.resolve().name).with_suffix(".mp4")
    way = path_for(opened, path, seconds, wanted)
    if explain and target.suffix.lower() not in PICTURE_SUFFIXES:
        raise InputError(
            f"--explain goes with one picture, but the output is {target.name}: give -o NAME.png, "
            "and --at for another time along the path"
        )
    if explain and not isinstance(opened, DepthViews):
        raise InputError(
            f"--explain needs depth, which the views of {scene.name} do not have: without it "
            "nobody knows what a picture shows of another"
        )
    if target.suffix.lower() in PICTURE_SUFFIXES:
        beside = {name: target.with_suffix(f".{name}.png") for name in EXPLAINED if explain}
        for one in (target, *beside.values()):
            require_free(one, force)
        end = way.start + way.duration
        if at > end + 1e-9:
            raise InputError(
                f"--at {at:g} lies beyond the path, which is {way.duration:g} s long: give a time "
                f"from {way.start:g} to {end:g}"
            )
        camera = way.camera(min(at, end))
        opened.render(camera)  # compiles and prepares, so that the time told is the warp's
        began = time.perf_counter()
        frame = opened.render(camera)
        ms = (time.perf_counter() - began) * 1e3
        save_frame(frame, target, force=force)
        if explain and isinstance(opened, DepthViews):
            _write_explained(opened, camera, beside)
        facts = {"output": str(target), "ms": round(ms, 3), "holes": frame.hole_fraction}
        line = (
            f"{target}: {camera.width}x{camera.height}, {ms:.1f} ms, {_holes(frame.hole_fraction)}"
        )
        if beside:
            facts["explained"] = [str(one) for one in beside.values()]
            line += "; " + ", ".join(one.name for one in beside.values()) + " explain it"
    else:
        options = {
            "scene": str(scene.resolve()), "references": references, "fill": fill.value,
            **choices, **asked,
        }  # fmt: skip
        with progress_bar(quiet=as_json) as tell:
            result = render_path(
                opened, way, target, fps=fps, frames=frames, options=options, force=force,
                progress=tell,
            )  # fmt: skip
        facts = result.as_dict() | {"output": str(target)}
        ms_text = "already rendered" if result.ms is None else f"{result.ms:.1f} ms a frame"
        resumed = f" ({result.reused} from before)" if result.reused else ""
        number = counted(result.frames, "frame")
        line = (
            f"{target}: {number}{resumed}, {result.size[0]}x{result.size[1]}, {ms_text}, "
            f"{_holes(result.hole_fraction)}"
        )
    if as_json:
        say_json(facts)
    else:
        say(line)


def _write_explained(scene: DepthViews, camera: CameraModel, files: dict[str, Path]) -> None:
    from belvedere.scene.io import write_color
    from belvedere.studio.explained import explained_pictures

    chosen = scene.choose(camera)
    frame = scene.warp(chosen, camera, explain=True)
    assert frame.explanation is not None
    names = [scene.views.names[index] for index in chosen]
    pictures = explained_pictures(frame, frame.explanation, names)
    for name, file in files.items():
        write_color(file, pictures[name])


def _holes(share: float) -> str:
    return f"{100 * share:.1f} % of the pixels unseen by any reference"
