"""Architectural walkthroughs: cells, portals, and the pictures seen through them.

A building is cut into cells that see each other through portals; behind a portal stand not polygons
but a few photographs with depth, warped to the eye. After Rafferty, Aliaga and Lastra 1998.
"""

from belvedere.walkthrough.cells import OUTSIDE, Cell, CellGraph, Portal
from belvedere.walkthrough.contents import CellContents, contents_of
from belvedere.walkthrough.error_driven import (
    Holes,
    candidate_eyes,
    choose_eyes,
    measure_holes,
    place_references,
    visitor_eyes,
)
from belvedere.walkthrough.frame_loop import MODES, FrameStatistics, Mode, Walker, WalkOptions
from belvedere.walkthrough.geometry import GeometryDrawer
from belvedere.walkthrough.placement import (
    EYE_M,
    PlacementOptions,
    Side,
    reference_camera,
    semicircle_eyes,
    sides_of,
)
from belvedere.walkthrough.portal_images import PortalImages, take_reference
from belvedere.walkthrough.switching import Switches, SwitchOptions
from belvedere.walkthrough.visibility import Sight, Visibility, view_cell

__all__ = [
    "EYE_M",
    "MODES",
    "OUTSIDE",
    "Cell",
    "CellContents",
    "CellGraph",
    "FrameStatistics",
    "GeometryDrawer",
    "Holes",
    "Mode",
    "PlacementOptions",
    "Portal",
    "PortalImages",
    "Side",
    "Sight",
    "SwitchOptions",
    "Switches",
    "Visibility",
    "WalkOptions",
    "Walker",
    "candidate_eyes",
    "choose_eyes",
    "contents_of",
    "measure_holes",
    "place_references",
    "reference_camera",
    "semicircle_eyes",
    "sides_of",
    "take_reference",
    "view_cell",
    "visitor_eyes",
]
