"""Architectural walkthroughs: cells, portals, and the pictures seen through them.

A building is cut into cells that see each other through portals; behind a portal stand not polygons
but a few photographs with depth, warped to the eye. After Rafferty, Aliaga and Lastra 1998.
"""

from belvedere.walkthrough.automatic import find_cells
from belvedere.walkthrough.cell_images import CellImageOptions, CellImages
from belvedere.walkthrough.cells import OUTSIDE, Cell, CellGraph, Portal
from belvedere.walkthrough.checking import Finding, check_cells, leak_percent
from belvedere.walkthrough.contents import CellContents, contents_of
from belvedere.walkthrough.error_driven import (
    Holes,
    candidate_eyes,
    choose_eyes,
    measure_holes,
    place_references,
    visitor_eyes,
)
from belvedere.walkthrough.estimate import Estimate, estimate
from belvedere.walkthrough.frame_loop import Walker
from belvedere.walkthrough.free_space import Body, FreeSpace
from belvedere.walkthrough.geometry import CellRasterizer, GeometryDrawer
from belvedere.walkthrough.graph_file import load_graph, save_graph
from belvedere.walkthrough.placement import (
    EYE_M,
    PlacementOptions,
    Side,
    reference_camera,
    semicircle_eyes,
    sides_of,
)
from belvedere.walkthrough.plan import Mark, Plan, draw_plan
from belvedere.walkthrough.portal_images import PortalImages, take_reference
from belvedere.walkthrough.prepare import Prepared, prepare
from belvedere.walkthrough.prepare_options import PrepareOptions
from belvedere.walkthrough.stated import cells_of_building
from belvedere.walkthrough.switching import Switches, SwitchOptions
from belvedere.walkthrough.tour import random_walk, tour
from belvedere.walkthrough.visibility import Sight, Visibility, view_cell
from belvedere.walkthrough.walk_options import MODES, FrameStatistics, Mode, WalkOptions
from belvedere.walkthrough.walkthrough import Walkthrough

__all__ = [
    "EYE_M",
    "MODES",
    "OUTSIDE",
    "Body",
    "Cell",
    "CellContents",
    "CellGraph",
    "CellImageOptions",
    "CellImages",
    "CellRasterizer",
    "Estimate",
    "Finding",
    "FrameStatistics",
    "FreeSpace",
    "GeometryDrawer",
    "Holes",
    "Mark",
    "Mode",
    "PlacementOptions",
    "Plan",
    "Portal",
    "PortalImages",
    "PrepareOptions",
    "Prepared",
    "Side",
    "Sight",
    "SwitchOptions",
    "Switches",
    "Visibility",
    "WalkOptions",
    "Walker",
    "Walkthrough",
    "candidate_eyes",
    "cells_of_building",
    "check_cells",
    "choose_eyes",
    "contents_of",
    "draw_plan",
    "estimate",
    "find_cells",
    "leak_percent",
    "load_graph",
    "measure_holes",
    "place_references",
    "prepare",
    "random_walk",
    "reference_camera",
    "save_graph",
    "semicircle_eyes",
    "sides_of",
    "take_reference",
    "tour",
    "view_cell",
    "visitor_eyes",
]
