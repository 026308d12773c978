"""What a prepared scene depends on, beside the model."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

from belvedere.ground.checks import check_choice, check_number
from belvedere.walkthrough.cell_images import CellImageOptions
from belvedere.walkthrough.placement import PlacementOptions

Placement = Literal["error", "arc"]
CellSource = Literal["auto", "stated", "found"]

__all__ = ["CellSource", "Placement", "PrepareOptions"]


@dataclass(frozen=True, slots=True)
class PrepareOptions:
    """Everything that the prepared scene depends on, beside the model."""

    cells: CellSource = "auto"
    """``"stated"`` takes rooms and openings from the model (IFC, glTF extras, a side file),
    ``"found"`` looks for them in its free space, ``"auto"`` takes what is stated, if anything."""
    cells_file: str | None = None
    """A ``cells.json`` to use instead, such as an earlier one that was edited by hand."""
    placement: Placement = "error"
    """``"error"`` puts references where they remove most holes, ``"arc"`` evenly on an arc."""
    bound: float = 0.0
    """With ``"error"``: mean share of holes at which fewer references are enough."""
    references: PlacementOptions = field(default_factory=PlacementOptions)
    """How many, how fine, how high."""
    inside: CellImageOptions = field(default_factory=CellImageOptions)
    """Which cells are photographed from inside, to be shown without their polygons."""
    units: str | None = None
    """Of the model's coordinates, where its format does not say or says it wrongly."""
    up: str | None = None
    """Its axis that points up, likewise."""
    doors: Literal["open", "closed"] = "open"
    """Whether door leaves that can be told are left out."""
    rays: int = 64
    """Gathered for each point of light; fewer is quicker and blotchier."""
    seed: int = 0
    """Of a built-in house."""
    detail: int = 1
    """Of a built-in house: so many times its polygons, in the same shapes."""

    def __post_init__(self) -> None:
        owner = "PrepareOptions"
        check_choice(owner, "cells", self.cells, get_args(CellSource))
        check_choice(owner, "placement", self.placement, get_args(Placement))
        check_choice(owner, "doors", self.doors, ("open", "closed"))
        check_number(owner, "bound", self.bound, 0.0, 1.0)
