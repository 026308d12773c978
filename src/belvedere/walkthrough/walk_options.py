"""How frames of a walk are made, and what each took."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

from belvedere.ground.checks import check_choice, check_number
from belvedere.walkthrough.switching import SwitchOptions
from belvedere.warp import WarpOptions

Mode = Literal["full", "culling", "textures", "one", "two"]
"""What stands behind portals; see `WalkOptions`."""
MODES: tuple[str, ...] = get_args(Mode)
"""All modes by name."""
Merge = Literal["over", "disparity"]
Fill = Literal["none", "background", "trace"]
Cells = Literal["pictures", "polygons"]

GEOMETRY_MODES = ("full", "culling")
"""Modes without pictures."""

__all__ = ["GEOMETRY_MODES", "MODES", "FrameStatistics", "Mode", "WalkOptions"]


@dataclass(frozen=True, slots=True)
class WalkOptions:
    """How frames are made."""

    mode: Mode = "two"
    """What stands behind portals; see the module."""
    merge: Merge = "disparity"
    """With two references: ``"over"`` warps the second nearest first and the nearest over it, as
    the paper does; ``"disparity"`` lets the nearer surface win and blends where both see it."""
    reconstruction: str = "inverse"
    """Of the warps; see `belvedere.WarpOptions`."""
    cells: Cells = "pictures"
    """How cells that have pictures of their own are shown, those with very many polygons:
    ``"pictures"`` warps these (modes ``one`` and ``two``), ``"polygons"`` draws the cell."""
    persist: bool = False
    """Show in a portal's holes what was seen there in the frames before (an uncleared buffer)."""
    fill: Fill = "trace"
    """What becomes of holes, the pixels behind a portal that no reference saw: ``"trace"`` casts a
    ray for each, ``"background"`` continues what lies around, ``"none"`` leaves them black."""
    reach: float = 1e6
    """Portals farther off than this, metres, are not looked through."""
    switch: SwitchOptions = field(default_factory=SwitchOptions)
    """Where geometry takes over from pictures."""

    def __post_init__(self) -> None:
        check_choice("WalkOptions", "mode", self.mode, MODES)
        check_choice("WalkOptions", "merge", self.merge, get_args(Merge))
        check_choice("WalkOptions", "fill", self.fill, get_args(Fill))
        check_choice("WalkOptions", "cells", self.cells, get_args(Cells))
        check_number("WalkOptions", "reach", self.reach, 0.0)
        WarpOptions(reconstruction=self.reconstruction)  # type: ignore[arg-type]


@dataclass(slots=True)
class FrameStatistics:
    """What one frame took."""

    cell: int = -1
    """The cell the eye is in."""
    cells: int = 0
    """Cells whose polygons were drawn."""
    pictured_cells: int = 0
    """Cells shown by pictures of their own."""
    portals: int = 0
    """Portals that showed pictures."""
    references: int = 0
    """Pictures warped."""
    look_ms: float = 0.0
    draw_ms: float = 0.0
    warp_ms: float = 0.0
    compose_ms: float = 0.0
    fill_ms: float = 0.0
    holes: float = 0.0
    """Share of the window that no reference and no polygon covers, before it is filled."""

    @property
    def ms(self) -> float:
        """The whole frame, milliseconds."""
        return self.look_ms + self.draw_ms + self.warp_ms + self.compose_ms + self.fill_ms
