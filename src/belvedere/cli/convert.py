"""``belvedere convert``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from belvedere.cli.arguments import (
    AxesOption,
    DepthKindOption,
    DepthScaleOption,
    ForceOption,
    FormatOption,
    JsonOption,
    PixelCentersOption,
    PoseOption,
    output_option,
    stated,
)
from belvedere.cli.console import note, progress_bar, say, say_json
from belvedere.ground.wording import counted


def convert(
    scene: Annotated[Path, typer.Argument(metavar="IN", help="The scene to read.")],
    output: Annotated[Path, typer.Argument(metavar="OUT", help="The folder to write.")],
    to: Annotated[
        str,
        output_option(
            "--to",
            help="Layout: belvedere (transforms.json, opens in nerfstudio), cameras.json, colmap, "
            "colmap-text, tum.",
        ),
    ] = "belvedere",
    color_format: Annotated[
        str | None,
        output_option(help="png, jpg, webp or exr; by default png."),
    ] = None,
    depth_format: Annotated[
        str | None,
        output_option(
            help="png16, exr, npy or pfm; by default png16. COLMAP has its own, TUM png16 alone."
        ),
    ] = None,
    force: ForceOption = False,
    as_json: JsonOption = False,
    layout: FormatOption = None,
    depth_scale: DepthScaleOption = None,
    depth_kind: DepthKindOption = None,
    pose: PoseOption = None,
    axes: AxesOption = None,
    pixel_centers: PixelCentersOption = None,
) -> None:
    """Convert a scene between layouts: wrong conventions in, right ones out.

    The copy is written in our conventions, whatever the original's were, so options that mend a
    reading (--depth-scale and the rest) are needed only once.

    Example: belvedere convert capture/ mended --depth-scale 0.001
    """
    from belvedere.scene.io import write_views
    from belvedere.studio.scenes import read_capture

    asked = stated(depth_scale, depth_kind, pose, axes, pixel_centers)
    views = read_capture(scene, asked, layout)
    options: dict[str, object] = {}
    if color_format is not None:
        options["color_format"] = color_format
    if depth_format is not None:
        options["depth_format"] = depth_format
    with progress_bar(quiet=as_json) as tell:

        def told(done: int, total: int, what: str) -> None:
            if done == 1:  # what is refused is refused before a word about work
                tell(0, total, what)
            tell(done, total, what)

        saved = write_views(
            views,
            output,
            to,
            force=force,
            progress=told,
            **options,
        )
    if as_json:
        say_json(
            {"output": str(output), "layout": saved.format, "views": saved.views,
             "resumed": saved.resumed, "depth_step": saved.depth_step, "notes": list(saved.notes)}
        )  # fmt: skip
        return
    for text in saved.notes:
        note(f"note: {text}")
    resumed = f" ({saved.resumed} from before)" if saved.resumed else ""
    say(f"{output}: {counted(saved.views, 'view')} as {saved.format}{resumed}")
