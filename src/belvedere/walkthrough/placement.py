"""Where the references of a portal stand.

On a semicircle in front of it, at eye height, each with an off-axis camera whose picture is exactly
the portal, so that every texel looks through the opening::

             portal
    ====|==============|====
          .  60 deg  .
       o    o    o    o          eyes; what stands between them and the portal is clipped away
          .         .

Source: spec portal-walkthrough 2 and 3.4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer, check_number
from belvedere.scene import Camera
from belvedere.walkthrough.cells import OUTSIDE, Cell, Portal

F8 = npt.NDArray[np.float64]

EYE_M = 1.6
"""Height of a visitor's eye above the floor."""
LARGEST_TEXELS = 2048
"""Texels across a reference, at most."""

__all__ = [
    "EYE_M",
    "PlacementOptions",
    "Side",
    "reference_camera",
    "semicircle_eyes",
    "sides_of",
]


@dataclass(frozen=True, slots=True)
class PlacementOptions:
    """Where references stand and how fine they are."""

    count: int = 6
    """References on each side of a portal between two cells."""
    span_deg: float = 100.0
    """From the first to the last, seen from the portal's middle."""
    radius: float = 2.0
    """Metres from the portal's middle; three quarters of its width where that is more."""
    texels: int = 256
    """A reference of a portal of `AREA` square metres has ``texels ** 2`` of them; a larger portal
    has more in proportion."""
    eye: float = EYE_M
    """Metres above the floor."""

    def __post_init__(self) -> None:
        owner = "PlacementOptions"
        check_integer(owner, "count", self.count, 1, 1000)
        check_integer(owner, "texels", self.texels, 8, LARGEST_TEXELS)
        check_number(owner, "span_deg", self.span_deg, 0.0, 170.0)
        check_number(owner, "radius", self.radius, 0.1, 1000.0)
        check_number(owner, "eye", self.eye, 0.1, 100.0)


AREA = 2.0
"""Square metres of a portal whose references have the stated number of texels: a door."""


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """A portal as it is seen from one of its cells."""

    portal: Portal
    """Which."""
    cell: int
    """The viewer's."""
    floor: float
    """Height of the viewer's floor, metres."""

    @property
    def normal(self) -> F8:
        """(3,) unit, towards the viewer."""
        return self.portal.normal * (1.0 if self.portal.cells[0] == self.cell else -1.0)

    @property
    def corner(self) -> F8:
        """(3,) the upper left corner, as the viewer sees it."""
        return self._ordered()[0]

    @property
    def down(self) -> F8:
        """(3,) the left edge, downwards."""
        corners = self._ordered()
        return corners[1] - corners[0]

    @property
    def right(self) -> F8:
        """(3,) the upper edge, to the right; made perpendicular to `down`."""
        corners = self._ordered()
        across, down = corners[3] - corners[0], self.down
        return across - down * (across @ down) / (down @ down)

    def _ordered(self) -> F8:
        """(4, 3) from the upper left counter-clockwise as the viewer sees it."""
        corners = self.portal.corners
        if self.portal.cells[0] != self.cell:
            corners = corners[::-1]
        falls = np.roll(corners, -1, axis=0) - corners
        steep = falls[:, 2] / np.linalg.norm(falls, axis=1)
        return np.roll(corners, -int(np.argmin(np.round(steep, 6))), axis=0)


def sides_of(portal: Portal, cells: Sequence[Cell]) -> tuple[Side, ...]:
    """A portal from each of its cells; none where it leads outside.

    What lies outside is mostly the sky, infinitely far, of which an eye through a window sees
    another part than any reference: there polygons and sky are drawn.
    """
    if OUTSIDE in portal.cells:
        return ()
    return tuple(Side(portal, cell, cells[cell].floor) for cell in portal.cells)


def semicircle_eyes(side: Side, options: PlacementOptions, count: int | None = None) -> F8:
    """(N, 3) eyes in front of a portal, from its left to its right.

    Args:
        side: the portal, from where.
        options: radius, span and height.
        count: how many; None for ``options.count``.

    Before an upright portal they stand at eye height above the viewer's floor. Before one that
    lies flat (a stair well seen from below) the arc stands upright in the portal's own axes.
    """
    width = float(np.linalg.norm(side.right))
    radius = max(options.radius, 0.75 * width)
    half = np.radians(options.span_deg) / 2.0
    wanted = options.count if count is None else count
    angle = np.linspace(-half, half, wanted) if wanted > 1 else np.zeros(1)
    right = side.right / width
    eyes = side.portal.center + radius * (
        np.cos(angle)[:, None] * side.normal + np.sin(angle)[:, None] * right
    )
    if abs(side.normal[2]) < 0.5:
        eyes[:, 2] = side.floor + options.eye
    return eyes


def reference_camera(side: Side, eye: F8, options: PlacementOptions) -> tuple[Camera, float]:
    """The off-axis camera at ``eye`` whose picture is the portal.

    Returns:
        The camera, and the depth of the portal's plane in it: the near distance of its picture.
        At that depth disparity is largest, so ``disparity * near`` is 1 on the portal and less
        beyond (spec portal-walkthrough 3.4).

    Raises:
        CameraError: the eye is not on the viewer's side of the portal's plane.
    """
    right, down = side.right, side.down
    width_m, height_m = float(np.linalg.norm(right)), float(np.linalg.norm(down))
    scale = options.texels * max(1.0, np.sqrt(width_m * height_m / AREA))
    across = scale * np.sqrt(width_m / height_m)
    up = scale * np.sqrt(height_m / width_m)
    width, height = (int(np.clip(round(n), 8, LARGEST_TEXELS)) for n in (across, up))
    camera = Camera.through_rectangle(eye, side.corner, right, down, width=width, height=height)
    return camera, float((side.portal.center - eye) @ camera.forward)
