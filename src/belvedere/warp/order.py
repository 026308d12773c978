"""Occlusion-compatible order: draw what can be hidden before what can hide it, without depths.

::

      +------------+-------+        desired eye in front (e_z > 0): every sheet is scanned toward
      |  -> ->     | <- <- |        the epipole, which comes last
      |  |         |     | |
      |  v         |     v |        behind (e_z < 0): away from the antipode, which comes first
      +------------x-------+
      |  ^         |     ^ |        at pixel (u, v) the directions are
      |  -> ->     | <- <- |            sign(e_x - u e_z)  and  sign(e_y - v e_z)
      +------------+-------+

A sheet is a part of the reference image with one scan order; an axis is split only where the
epipole's coordinate falls inside the image, so there are one, two or four.

Source: McMillan's course notes, section 5; spec image-warping 3.6 (the division-free rule).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, slots=True)
class Sheet:
    """A part of the reference image, columns [u_low, u_high), rows [v_low, v_high)."""

    u_low: int
    u_high: int
    u_step: int
    """+1: scanned left to right; -1: right to left."""
    v_low: int
    v_high: int
    v_step: int
    """+1: scanned downwards; -1: upwards."""


def occlusion_compatible_sheets(
    epipole: npt.ArrayLike, width: int, height: int
) -> tuple[Sheet, ...]:
    """The sheets of a reference image for a desired eye.

    Args:
        epipole: (3,) signed homogeneous image of the desired eye, from `warp.epipole`.
        width: of the reference image, pixels.
        height: of the reference image, pixels.

    Returns:
        One, two or four sheets that together hold every pixel once. Sheets are independent; within
        one, any traversal monotone in both directions draws far before near.
    """
    ex, ey, ez = (float(x) for x in np.asarray(epipole))
    return tuple(
        Sheet(u_low, u_high, u_step, v_low, v_high, v_step)
        for v_low, v_high, v_step in _axis_runs(ey, ez, height)
        for u_low, u_high, u_step in _axis_runs(ex, ez, width)
    )


def occlusion_compatible_cell_sheets(
    epipole: npt.ArrayLike, width: int, height: int
) -> tuple[Sheet, ...]:
    """The sheets of the cells between samples, in the order in which they must be drawn.

    A cell (u, v) reaches from its sample to the next one right and below. The row and the column of
    cells that hold the epipole reach to both sides of it, so they belong to no quadrant: drawn with
    one they would be hidden by farther cells of the other. They make sheets of their own, last when
    the eye is in front and first when it is behind::

        +------+---+------+
        |  1   | 2 |  1   |        in front (e_z > 0): 1, then 2, then 3
        +------+---+------+
        |  2   | 3 |  2   |        behind (e_z < 0): 3, then 2, then 1
        +------+---+------+
        |  1   | 2 |  1   |
        +------+---+------+

    Args:
        epipole: (3,) as in `occlusion_compatible_sheets`.
        width: of the reference image, pixels; the cell left of its first column comes with it.
        height: of the reference image, pixels.

    Returns:
        One to nine sheets that together hold every pixel once. In the order given, any traversal
        monotone in both directions of each draws far before near.
    """
    ex, ey, ez = (float(x) for x in np.asarray(epipole))
    sheets = [
        (along[3] + across[3], Sheet(*across[:3], *along[:3]))
        for along in _cell_runs(ey, ez, height)
        for across in _cell_runs(ex, ez, width)
    ]
    sheets.sort(key=lambda one: one[0] if ez > 0.0 else -one[0])
    return tuple(sheet for _, sheet in sheets)


def _cell_runs(e: float, ez: float, length: int) -> list[tuple[int, int, int, int]]:
    """Runs [low, high) of cells on one side of the epipole, scan direction, and 1 if it is in."""
    ratio = e / ez if ez != 0.0 else -1.0
    if not 0.0 <= ratio < length:
        return [(*run, 0) for run in _axis_runs(e, ez, length)]
    toward = 1 if ez > 0.0 else -1
    middle = math.floor(ratio)
    runs = [
        (0, middle, toward, 0),
        (middle, middle + 1, toward, 1),
        (middle + 1, length, -toward, 0),
    ]
    return [run for run in runs if run[0] < run[1]]


def _axis_runs(e: float, ez: float, length: int) -> list[tuple[int, int, int]]:
    """Runs [low, high) of equal ``sign(e - x ez)`` for x in [0, length), with that sign."""
    if ez == 0.0:
        return [(0, length, 1 if e >= 0.0 else -1)]
    toward = 1 if ez > 0.0 else -1
    ratio = e / ez
    split = 0 if ratio <= 0.0 else length if ratio > length else math.ceil(ratio)
    runs = [(0, split, toward), (split, length, -toward)]
    return [run for run in runs if run[0] < run[1]]


def order_key(epipole_ray: npt.ArrayLike, rays: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Sort key that gives an occlusion-compatible order on any image manifold.

    Args:
        epipole_ray: (3,) world direction from the reference center to the desired one.
        rays: (..., 3) world rays of the reference pixels.

    Returns:
        (...) cosine of the angle between the two: draw in increasing order.
    """
    directions = np.asarray(rays, dtype=np.float64)
    toward = np.asarray(epipole_ray, dtype=np.float64)
    return directions @ toward / np.linalg.norm(directions, axis=-1)
