"""When a portal shows pictures and when the polygons behind it, without flicker.

Close to a portal its few texels spread over the whole window, and from beside it an eye looks past
all that its references saw. There the geometry behind it is drawn instead. The change happens
nearer on the way in than on the way out, and takes some frames.

Source: spec portal-walkthrough 3.1; distances and fading are its [CHOICE].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer, check_number
from belvedere.walkthrough.cells import Portal

F8 = npt.NDArray[np.float64]

__all__ = ["SwitchOptions", "Switches"]


@dataclass(frozen=True, slots=True)
class SwitchOptions:
    """Where geometry takes over."""

    angle_deg: float = 30.0
    """A portal that is wider than this, seen from the eye, shows geometry: there a door's 256 x 256
    texels are spread over some 330 x 330 pixels of a window of 640 x 512."""
    widths: float = 0.75
    """So does one nearer than this many of its widths."""
    slant_deg: float = 50.0
    """So does one seen from farther aside than this, counted from straight ahead at its middle:
    where the references' arc ends."""
    hysteresis: float = 1.25
    """Pictures come back at this many times the distance."""
    fade: int = 3
    """Frames of the change; 0 changes at once."""

    def __post_init__(self) -> None:
        owner = "SwitchOptions"
        check_number(owner, "angle_deg", self.angle_deg, 1.0, 179.0)
        check_number(owner, "widths", self.widths, 0.0, 1000.0)
        check_number(owner, "slant_deg", self.slant_deg, 1.0, 90.0)
        check_number(owner, "hysteresis", self.hysteresis, 1.0, 10.0)
        check_integer(owner, "fade", self.fade, 0, 1000)


@dataclass(frozen=True, slots=True, eq=False)
class _Rectangles:
    """Portals as arrays, their more level edges counted as widths."""

    corner: F8
    """(P, 3) where width and height begin."""
    along: F8
    """(P, 3) the width."""
    up: F8
    """(P, 3) the height."""

    @classmethod
    def of(cls, portals: Sequence[Portal]) -> _Rectangles:
        corners = np.array([p.corners for p in portals]).reshape(-1, 4, 3)
        sides = np.roll(corners, -1, axis=1) - corners
        level = np.argmin(np.abs(sides[:, :2, 2]), axis=1)
        k = np.arange(len(corners))
        return cls(corners[k, level], sides[k, level], sides[k, level + 1])

    def closeness(self, eye: F8, options: SwitchOptions) -> F8:
        """(P,) how close an eye is to each; see `closeness`."""
        wide = np.einsum("pc,pc->p", self.along, self.along)
        high = np.einsum("pc,pc->p", self.up, self.up)
        off = eye - self.corner
        s = np.clip(np.einsum("pc,pc->p", off, self.along) / wide, 0.0, 1.0)
        t = np.clip(np.einsum("pc,pc->p", off, self.up) / high, 0.0, 1.0)
        left = t[:, None] * self.up - off  # the width's two ends at the eye's height
        right = left + self.along
        nearest = left + s[:, None] * self.along
        distance = np.maximum(np.sqrt(np.einsum("pc,pc->p", nearest, nearest)), 1e-9)
        dot = np.einsum("pc,pc->p", left, right)
        squares = np.einsum("pc,pc->p", left, left) * np.einsum("pc,pc->p", right, right)
        angle = np.arctan2(np.sqrt(np.maximum(squares - dot * dot, 0.0)), dot)
        middle = off - 0.5 * (self.along + self.up)
        aside = np.abs(np.einsum("pc,pc->p", middle, self.along)) / np.sqrt(wide)
        normal = np.cross(self.along, self.up)
        ahead = np.abs(np.einsum("pc,pc->p", middle, normal)) / np.sqrt(wide * high)
        return np.maximum.reduce([
            angle / np.radians(options.angle_deg),
            options.widths * np.sqrt(wide) / distance,
            np.arctan2(aside, ahead) / np.radians(options.slant_deg),
        ])  # fmt: skip


def closeness(portal: Portal, eye: F8, options: SwitchOptions) -> float:
    """How close an eye is: above 1 the portal shows geometry.

    The largest of three ratios: of the angle that the portal's width subtends to the one allowed,
    of the distance allowed to the distance of the portal's nearest point, and of the angle aside to
    the one allowed.
    """
    return float(_Rectangles.of([portal]).closeness(eye, options)[0])


class Switches:
    """Remembers what each portal shows."""

    def __init__(self, portals: tuple[Portal, ...], options: SwitchOptions) -> None:
        self.portals, self.options = portals, options
        self.geometry = np.zeros(len(portals), dtype=bool)
        """(P,) which show geometry."""
        self.share = np.zeros(len(portals))
        """(P,) how far geometry has faded in: 0 pictures alone, 1 geometry alone."""
        self._began = False
        self._rectangles = _Rectangles.of(portals)

    def update(self, eye: F8) -> None:
        """Decide anew for an eye; the first call and `reset` decide at once, without fading."""
        limits = np.where(self.geometry, 1.0 / self.options.hysteresis, 1.0)
        self.geometry = self._rectangles.closeness(eye, self.options) >= limits
        if not self._began or self.options.fade == 0:
            self.share = self.geometry.astype(np.float64)
        else:
            step = 1.0 / (self.options.fade + 1)
            target = self.geometry.astype(np.float64)
            self.share = self.share + np.clip(target - self.share, -step, step)
        self._began = True

    def reset(self) -> None:
        """Forget: the next frame begins anew, as after a jump."""
        self.geometry[:] = False
        self._began = False
