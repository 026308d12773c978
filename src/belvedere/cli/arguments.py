"""Arguments that several commands share, with the words that explain them."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

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


READING = "How to read the numbers (if `belvedere info` says so)"
LOOK = "How to render"
OUTPUT = "Output"

SceneArgument = Annotated[
    Path, typer.Argument(metavar="SCENE", help="A scene folder, or its transforms.json.")
]
DepthScaleOption = Annotated[
    float | None,
    typer.Option(
        help="Metres per stored unit of depth: 0.001 for millimetres, 0.0002 for TUM's 1/5000.",
        rich_help_panel=READING,
    ),
]
DepthKindOption = Annotated[
    DepthKind | None,
    typer.Option(help="Depth along the axis, along the ray, or 1/depth.", rich_help_panel=READING),
]
PoseOption = Annotated[
    Pose | None, typer.Option(help="Which way the pose matrices map.", rich_help_panel=READING)
]
AxesOption = Annotated[
    Axes | None,
    typer.Option(help="Camera axes: y down, z forward; or y up, z back.", rich_help_panel=READING),
]
PixelCentersOption = Annotated[
    PixelCenters | None,
    typer.Option(help="Centre of the first pixel: 0 or 0.5.", rich_help_panel=READING),
]
FormatOption = Annotated[
    str | None,
    typer.Option(
        "--format",
        help="Layout of the scene, instead of looking: transforms, cameras.json, tum, redwood, "
        "colmap, stereo.",
        rich_help_panel=READING,
    ),
]
ReconstructionOption = Annotated[
    Reconstruction,
    typer.Option(
        "--reconstruction",
        "-r",
        help="How samples become a picture again; inverse gives the best one.",
        rich_help_panel=LOOK,
    ),
]
VisibilityOption = Annotated[
    Visibility,
    typer.Option(help="Occlusion-compatible order, or comparing depths.", rich_help_panel=LOOK),
]
FillOption = Annotated[
    Fill, typer.Option(help="Leave holes black, or continue the background.", rich_help_panel=LOOK)
]
ReferencesOption = Annotated[
    int, typer.Option(min=1, max=16, help="Views warped for one picture.", rich_help_panel=LOOK)
]
ThreadsOption = Annotated[
    int | None,
    typer.Option(min=1, max=256, help="Threads; by default one per processor. The pictures are "
                 "the same for any number.", rich_help_panel=LOOK),
]  # fmt: skip
ForceOption = Annotated[
    bool, typer.Option("--force", help="Replace what is there.", rich_help_panel=OUTPUT)
]
JsonOption = Annotated[
    bool, typer.Option("--json", help="Print JSON for scripts.", rich_help_panel=OUTPUT)
]


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
