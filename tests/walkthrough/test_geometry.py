"""Cells are drawn by whichever rasterizer is given."""

from __future__ import annotations

import numpy as np
import pytest

from belvedere.ground.errors import BelvedereError
from belvedere.model import Interior, OpenGLRasterizer
from belvedere.scene import Camera
from belvedere.walkthrough import CellContents, Sight
from belvedere.walkthrough.geometry import CellRasterizer

NOTHING = np.zeros((0, 3))


def halves(house: Interior) -> CellContents:
    """Every other face in one cell, the others in another."""
    faces = np.arange(len(house.mesh.faces), dtype=np.int32)
    return CellContents((faces[::2], faces[1::2]), faces)


def test_opengl_draws_the_cells_that_our_rasterizer_draws(house: Interior) -> None:
    try:
        opengl = OpenGLRasterizer(house)
    except BelvedereError as refusal:
        pytest.skip(str(refusal))
    camera = Camera.look_at((1.2, 1.5, 1.6), (5.0, 2.3, 1.5), fov_deg=60, width=96, height=72)
    sights = [Sight(cell, -1, (), NOTHING, NOTHING) for cell in (0, 1)]
    ours = CellRasterizer(house, halves(house))
    theirs = CellRasterizer(house, halves(house), opengl)
    one, whole = ours.draw(camera, sights[:1], 1)[1], ours.draw(camera, sights, 1)[1]
    assert (one != whole).mean() > 0.3
    for part, expected in ((sights[:1], one), (sights, whole), (None, whole)):
        _, disparity = theirs.draw(camera, part, 1)
        assert np.isclose(disparity, expected, rtol=1e-4).mean() > 0.998  # edges differ
