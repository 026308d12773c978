"""Architectural walkthroughs: cells, portals, and the pictures seen through them.

A building is cut into cells that see each other through portals; behind a portal stand not polygons
but a few photographs with depth, warped to the eye. After Rafferty, Aliaga and Lastra 1998.
"""

from belvedere.walkthrough.cells import OUTSIDE, Cell, CellGraph, Portal

__all__ = ["OUTSIDE", "Cell", "CellGraph", "Portal"]
