"""Architectural walkthroughs: cells, portals, and the pictures seen through them.

A building is cut into cells that see each other through portals; behind a portal stand not polygons
but a few photographs with depth, warped to the eye. After Rafferty, Aliaga and Lastra 1998.
"""

from belvedere.walkthrough.automatic import find_cells
from belvedere.walkthrough.cells import OUTSIDE, Cell, CellGraph, Portal
from belvedere.walkthrough.checking import Finding, check_cells, leak_percent
from belvedere.walkthrough.free_space import Body, FreeSpace
from belvedere.walkthrough.graph_file import load_graph, save_graph
from belvedere.walkthrough.plan import Mark, Plan, draw_plan
from belvedere.walkthrough.stated import cells_of_building

__all__ = [
    "OUTSIDE",
    "Body",
    "Cell",
    "CellGraph",
    "Finding",
    "FreeSpace",
    "Mark",
    "Plan",
    "Portal",
    "cells_of_building",
    "check_cells",
    "draw_plan",
    "find_cells",
    "leak_percent",
    "load_graph",
    "save_graph",
]
