"""``belvedere prepare``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from belvedere.cli.arguments import ForceOption, JsonOption, option_under, output_option
from belvedere.cli.console import note, progress_bar, say, say_json
from belvedere.ground.wording import counted


class Cells(StrEnum):
    """Where rooms and doors are known from."""

    AUTO = "auto"
    STATED = "stated"
    FOUND = "found"


class Placement(StrEnum):
    """Where references stand."""

    ERROR = "error"
    ARC = "arc"


class Doors(StrEnum):
    """What becomes of door leaves."""

    OPEN = "open"
    CLOSED = "closed"


model_option = option_under("How to read the model")
reference_option = option_under("Cells and references")
work_option = option_under("Who does the work")


def prepare(
    model: Annotated[
        str,
        typer.Argument(
            metavar="MODEL",
            help="A glTF/GLB, OBJ, PLY or IFC file; or built-in:flat, built-in:bungalow or "
            "built-in:villa, furnished houses made on the spot.",
        ),
    ],
    output: Annotated[
        Path | None,
        output_option("--output", "-o", help="Folder to make. By default the model's name."),
    ] = None,
    cells: Annotated[
        Cells,
        reference_option(
            help="stated: rooms and openings that the model names (IFC, glTF extras, or "
            "MODEL.building.json beside it). found: looked for in its free space. auto: stated, "
            "if there are any."
        ),
    ] = Cells.AUTO,
    cells_file: Annotated[
        Path | None,
        reference_option(
            help="A cells.json to use instead: prepare once, look at plan.svg, edit, go on."
        ),
    ] = None,
    references: Annotated[
        int,
        reference_option(
            min=1, max=1000, help="Pictures on each side of a door or opening between two rooms."
        ),
    ] = 6,
    texels: Annotated[
        int,
        reference_option(
            min=8,
            max=2048,
            help="Of a door's picture: 256 makes 256 x 256. Larger portals get more.",
        ),
    ] = 256,
    placement: Annotated[
        Placement,
        reference_option(
            help="error: where they remove most holes. arc: evenly before the portal."
        ),
    ] = Placement.ERROR,
    bound: Annotated[
        float,
        reference_option(
            min=0.0,
            max=1.0,
            help="With placement by error: share of holes at which fewer pictures are enough.",
        ),
    ] = 0.0,
    inside: Annotated[
        int,
        reference_option(
            min=0,
            help="Cells with at least so many polygons are photographed from inside too, and shown "
            "by these pictures instead of being drawn; 0 for all cells.",
        ),
    ] = 2_000_000,
    units: Annotated[
        str | None,
        model_option(help="m, cm, mm, ft or in, where the file does not say."),
    ] = None,
    up: Annotated[
        str | None,
        model_option(help="x, y or z: the axis that points up."),
    ] = None,
    doors: Annotated[
        Doors,
        model_option(
            help="open: leave out the door leaves that can be told, so that one can walk through."
        ),
    ] = Doors.OPEN,
    seed: Annotated[int, model_option(min=0, help="Of a built-in house.")] = 0,
    detail: Annotated[
        int,
        model_option(
            min=1,
            max=20,
            help="Of a built-in house: so many times its polygons, in the same shapes.",
        ),
    ] = 1,
    rays: Annotated[
        int,
        model_option(
            min=4,
            max=4096,
            help="For each point of the baked light; fewer is quicker and blotchier.",
        ),
    ] = 64,
    cluster: Annotated[
        str | None,
        work_option(
            metavar="tcp://HOST:PORT",
            help="Give the work to a Dask cluster that sees the same files.",
        ),
    ] = None,
    workers: Annotated[
        int | None,
        work_option(
            min=1, max=256, help="Threads on this machine. By default as many as it has processors."
        ),
    ] = None,
    dry_run: Annotated[
        bool,
        work_option("--dry-run", help="Only say how many pictures, bytes and minutes it would be."),
    ] = False,
    force: ForceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Make a building model walkable: find its rooms and doors, light it, photograph it.

    The folder it makes holds the cells and portals (cells.json, and a floor plan to look at), the
    lit model, and a few pictures with depth for each portal. An interrupted preparation goes on
    when the same command is repeated, and ends with the same bytes.

    Examples: belvedere prepare built-in:flat;
    belvedere prepare house.ifc -o house --dry-run;
    belvedere prepare house.glb --cells found --placement arc
    """  # fmt: skip
    from belvedere.walkthrough import PlacementOptions, PrepareOptions, estimate
    from belvedere.walkthrough import prepare as make
    from belvedere.walkthrough.cell_images import CellImageOptions

    options = PrepareOptions(
        cells=cells.value, cells_file=None if cells_file is None else str(cells_file.absolute()),
        placement=placement.value, bound=bound, units=units, up=up, doors=doors.value, rays=rays,
        seed=seed, detail=detail, references=PlacementOptions(count=references, texels=texels),
        inside=CellImageOptions(polygons=inside),
    )  # fmt: skip
    target = output or Path(model.removeprefix("built-in:")).with_suffix("")
    target = Path(target.name) if output is None else target
    if dry_run:
        with progress_bar(quiet=as_json) as tell:
            guess = estimate(model, options, workers=workers, progress=tell)
        if as_json:
            say_json(guess.as_dict())
        else:
            say(f"{model}: {guess.summary}")
        return
    # on a cluster the workers hold the model, and Dask's own page shows their memory
    with progress_bar(quiet=as_json, memory=cluster is None) as tell:
        made = make(
            model, target, options=options, cluster=cluster, workers=workers, force=force,
            progress=tell,
        )  # fmt: skip
    if as_json:
        say_json(made.as_dict())
        return
    for finding in made.findings:
        note(finding)
    say(
        f"{target}: {counted(len(made.cells), 'cell')}, {counted(made.portals, 'portal')}, "
        f"{counted(made.references, 'reference')}, "
        + (f"{counted(made.inside, 'picture')} inside cells, " if made.inside else "")
        + f"{made.bytes / 1e6:.1f} MB, {made.seconds:.0f} s"
    )
    say(f"look at {target / 'plan.svg'}, then: belvedere walk {target}")
