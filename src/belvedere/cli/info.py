"""``belvedere info``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from belvedere.cli.arguments import (
    AxesOption,
    DepthKindOption,
    DepthScaleOption,
    FormatOption,
    JsonOption,
    PixelCentersOption,
    PoseOption,
    SceneArgument,
    stated,
)
from belvedere.cli.console import say, say_json
from belvedere.ground.wording import counted


def info(
    scene: SceneArgument,
    check: Annotated[
        bool, typer.Option(help="Warp neighbouring views into each other and see if they agree.")
    ] = True,
    views: Annotated[bool, typer.Option("--views", help="List every view.")] = False,
    as_json: JsonOption = False,
    layout: FormatOption = None,
    depth_scale: DepthScaleOption = None,
    depth_kind: DepthKindOption = None,
    pose: PoseOption = None,
    axes: AxesOption = None,
    pixel_centers: PixelCentersOption = None,
) -> None:
    """Say what a scene is, what it affords, how big it is, and whether its views agree.

    When they disagree, one line says which mistake would explain it (a wrong depth scale, poses
    the wrong way round, OpenGL axes ...) and which option mends it. The same options work with
    every other command.

    Example: belvedere info capture/
    """
    from belvedere.studio.inspect import inspect_scene, median_depth
    from belvedere.studio.scenes import is_walkthrough

    if is_walkthrough(scene):
        _say_walkthrough(scene, as_json)
        return

    asked = stated(depth_scale, depth_kind, pose, axes, pixel_centers)
    facts = inspect_scene(scene, asked, format=layout, check=check)
    if as_json:
        say_json(facts.as_dict())
        return
    held = facts.views.facts
    with_depth = sum(entry.has_depth for entry in facts.views.entries)
    depth = "without depth" if with_depth == 0 else "with depth"
    if 0 < with_depth < len(facts.views):
        depth = f"{with_depth} of them with depth"
    number = counted(len(facts.views), "view")
    say(f"{facts.path}: {number}, {depth} ({held.get('format', 'unknown')} layout)")
    say(f"  pictures   {', '.join(facts.sizes)}; {facts.disk_bytes / 1e6:.1f} MB on disk")
    metres = median_depth(facts)
    if metres is not None:
        near, far = 1 / facts.disparities[2], 1 / max(facts.disparities[0], 1e-9)
        unit = "" if facts.stored_unit is None else f", stored unit {facts.stored_unit:g} m"
        say(f"  depth      {metres:.2f} m in the middle, half from {near:.2f} to {far:.2f} m{unit}")
    span = " x ".join(f"{x:.2f}" for x in facts.eye_span)
    say(f"  walk       {span} m of eye positions")
    affords = facts.affords
    say(f"  affords    movement {affords.movement}, geometry {affords.geometry}, "
        f"lighting {affords.lighting}")  # fmt: skip
    if held.get("undistorted"):
        say(f"  lens       undistorted on reading: {held['undistorted']}")
    if facts.check is not None:
        say(f"  check      {facts.check.line}")
        if facts.check.options:
            say(f"             try: belvedere info {scene} {facts.check.cli}")
    if views:
        for entry in facts.views.entries:
            place = ", ".join(f"{x:.3f}" for x in entry.camera.center)
            size = f"{entry.camera.width}x{entry.camera.height}"
            say(f"  {entry.name}  {size}  at ({place})" + ("" if entry.has_depth else "  no depth"))


def _say_walkthrough(scene: Path, as_json: bool) -> None:
    """What a prepared building says of itself."""
    from belvedere.walkthrough import Walkthrough

    opened = Walkthrough.open(scene)
    facts, counts = opened.facts, opened.facts["counts"]
    disk = sum(path.stat().st_size for path in scene.rglob("*") if path.is_file())
    faces = len(opened.model.mesh.faces)
    if as_json:
        say_json({"path": str(scene), "kind": "walkthrough", **counts, "polygons": faces,
                  "disk_bytes": disk, "affords": opened.affords.as_dict(),
                  "cell_names": [cell.name for cell in opened.graph.cells],
                  "findings": facts["findings"]})  # fmt: skip
        return
    low, high = opened.viewing_region.low, opened.viewing_region.high
    affords = opened.affords
    doors = f"{counted(counts['portals'], 'portal')}, {counts['doors']} of them to walk through"
    say(f"{scene}: a walkthrough of {counted(counts['cells'], 'cell')} and {doors}")
    inside = counts.get("inside", 0)
    say(f"  model      {faces:,} polygons, {counted(counts['references'], 'reference')}"
        + (f", {counted(inside, 'picture')} inside cells" if inside else "") + "; "
        f"{disk / 1e6:.1f} MB on disk")  # fmt: skip
    say(f"  cells      {', '.join(cell.name for cell in opened.graph.cells)}")
    size = " x ".join(f"{x:.1f}" for x in high - low)
    say(f"  extent     {size} m")
    say(f"  affords    movement {affords.movement}, geometry {affords.geometry}, "
        f"lighting {affords.lighting}")  # fmt: skip
    for finding in facts["findings"]:
        say(f"  note       {finding}")
    say(f"  try        belvedere walk {scene}")
