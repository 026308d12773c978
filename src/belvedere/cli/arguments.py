"""Arguments that several commands share, with the words that explain them."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from belvedere.ground.errors import InputError


class Reconstruction(StrEnum):
    """See `belvedere.warp.RECONSTRUCTIONS`."""

    POINT = "point"
    SPLAT = "splat"
    GAUSSIAN = "gaussian"
    MESH = "mesh"
    OFFSET = "offset"
    INVERSE = "inverse"


class Visibility(StrEnum):
    """How one reference hides parts of itself."""

    ORDER = "order"
    ZBUFFER = "zbuffer"


class Fill(StrEnum):
    """What becomes of holes."""

    NONE = "none"
    BACKGROUND = "background"


class DepthKind(StrEnum):
    """What stored depth measures."""

    Z = "z"
    RAY = "ray"
    DISPARITY = "disparity"


class Pose(StrEnum):
    """Which way stored poses map."""

    CAMERA_TO_WORLD = "camera_to_world"
    WORLD_TO_CAMERA = "world_to_camera"


class Axes(StrEnum):
    """Stored camera axes."""

    OPENCV = "opencv"
    OPENGL = "opengl"


class PixelCenters(StrEnum):
    """Where stored intrinsics put the first pixel's centre."""

    INTEGER = "integer"
    HALF = "half"


def option_under(heading: str) -> Callable[..., Any]:
    """`typer.Option`, for options that ``--help`` lists under one heading."""
    return partial(typer.Option, rich_help_panel=heading)


reading_option = option_under("How to read the numbers (if `belvedere info` says so)")
look_option = option_under("How to render")
output_option = option_under("Output")

SceneArgument = Annotated[
    Path, typer.Argument(metavar="SCENE", help="A scene folder, or its transforms.json.")
]
DepthScaleOption = Annotated[
    float | None,
    reading_option(
        help="Metres per stored unit of depth: 0.001 for millimetres, 0.0002 for TUM's 1/5000."
    ),
]
DepthKindOption = Annotated[
    DepthKind | None,
    reading_option(help="Depth along the axis, along the ray, or 1/depth."),
]
PoseOption = Annotated[Pose | None, reading_option(help="Which way the pose matrices map.")]
AxesOption = Annotated[
    Axes | None,
    reading_option(help="Camera axes: y down, z forward; or y up, z back."),
]
PixelCentersOption = Annotated[
    PixelCenters | None,
    reading_option(help="Centre of the first pixel: 0 or 0.5."),
]
FormatOption = Annotated[
    str | None,
    reading_option(
        "--format",
        help="Layout of the scene, instead of looking: transforms, cameras.json, tum, redwood, "
        "colmap, stereo.",
    ),
]
ReconstructionOption = Annotated[
    Reconstruction,
    look_option(
        "--reconstruction",
        "-r",
        help="How samples become a picture again; inverse gives the best one.",
    ),
]
VisibilityOption = Annotated[
    Visibility,
    look_option(help="Occlusion-compatible order, or comparing depths."),
]
FillOption = Annotated[Fill, look_option(help="Leave holes black, or continue the background.")]
ReferencesOption = Annotated[int, look_option(min=1, max=16, help="Views warped for one picture.")]
SizeOption = Annotated[
    str | None, look_option(metavar="WIDTHxHEIGHT", help="Size of the pictures.")
]
ThreadsOption = Annotated[
    int | None,
    look_option(
        min=1,
        max=256,
        help="Threads; by default one per processor. The pictures are the same for any number.",
    ),
]
ForceOption = Annotated[bool, output_option("--force", help="Replace what is there.")]
JsonOption = Annotated[bool, output_option("--json", help="Print JSON for scripts.")]


def parse_size(text: str | None) -> tuple[int, int] | None:
    """(width, height) of ``640x512``.

    Raises:
        InputError: another form.
    """
    if text is None:
        return None
    width, times, height = text.lower().partition("x")
    if not (times and width.isdecimal() and height.isdecimal()):
        raise InputError(f"--size is {text!r}, expected WIDTHxHEIGHT such as 640x512")
    return int(width), int(height)


def stated(
    depth_scale: float | None,
    depth_kind: DepthKind | None,
    pose: Pose | None,
    axes: Axes | None,
    pixel_centers: PixelCenters | None,
) -> dict[str, str | float]:
    """The conventions given on the command line, as `open_scene` takes them."""
    from belvedere.studio.scenes import stated_conventions

    return stated_conventions(
        depth_scale=depth_scale,
        depth_kind=None if depth_kind is None else depth_kind.value,
        pose=None if pose is None else pose.value,
        axes=None if axes is None else axes.value,
        pixel_centers=None if pixel_centers is None else pixel_centers.value,
    )
