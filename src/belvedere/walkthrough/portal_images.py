"""The pictures that stand for what lies beyond a portal.

Source: spec portal-walkthrough 3.3 to 3.7.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import InputError
from belvedere.model import LitModel, photograph
from belvedere.scene import Camera, ReferenceView
from belvedere.walkthrough.placement import (
    PlacementOptions,
    Side,
    reference_camera,
    semicircle_eyes,
)

F8 = npt.NDArray[np.float64]

SAMPLES = 3
"""Samples per side of a reference's texel."""

__all__ = ["PortalImages", "take_reference"]


def take_reference(
    model: LitModel, side: Side, eye: F8, options: PlacementOptions, threads: int | None = None
) -> ReferenceView:
    """Photograph what is seen through a portal from one eye; the room in front is clipped away."""
    camera, near = reference_camera(side, eye, options)
    return photograph(model, camera, SAMPLES, threads=threads, near=near)


@dataclass(frozen=True, slots=True, eq=False)
class PortalImages:
    """All references on one side of one portal."""

    side: Side
    """Which portal, seen from where."""
    references: tuple[ReferenceView, ...]
    """At least one."""

    def __post_init__(self) -> None:
        if not self.references:
            raise InputError(f"Portal {self.side.portal.name!r} has no references on this side")

    @classmethod
    def take(
        cls,
        model: LitModel,
        side: Side,
        options: PlacementOptions | None = None,
        eyes: F8 | None = None,
        threads: int | None = None,
    ) -> PortalImages:
        """Photograph from all eyes of the semicircle, or from those given."""
        chosen = options or PlacementOptions()
        places = semicircle_eyes(side, chosen) if eyes is None else eyes
        return cls(side, tuple(take_reference(model, side, p, chosen, threads) for p in places))

    def nearest(self, eye: F8, count: int) -> list[int]:
        """Indices of the references that see the portal most as ``eye`` does, best first.

        Measured at the portal's middle by the angle between the directions to the two eyes, which
        suits references on an arc better than the distance between the eyes: a visitor far away
        sees what the reference in his direction sees. Equal angles are told apart by distance.
        """
        eyes = np.array([r.camera.center for r in self.references])
        apart = eyes_apart(self.side.portal.center, eyes, eye)
        return [int(k) for k in np.argsort(apart, kind="stable")[:count]]

    def texels_a_pixel(self, camera: Camera) -> float:
        """Texels of a reference on the side of a camera's pixel, at the portal's middle.

        Across or down, whichever are fewer. Below 1 the camera spreads texels over several pixels;
        0 if the middle is behind the eye.
        """
        inverse = np.linalg.inv(camera.matrix)
        x, y, depth = inverse @ (self.side.portal.center - camera.center)
        if depth <= 0.0:
            return 0.0
        rows, columns = self.references[0].disparity.shape
        finest = np.inf
        for edge, texels in ((self.side.right, columns), (self.side.down, rows)):
            du, dv, dw = inverse @ edge
            pixels = np.hypot(du - dw * x / depth, dv - dw * y / depth) / depth
            finest = min(finest, texels / max(float(pixels), 1e-12))
        return float(finest)


def eyes_apart(center: F8, eyes: F8, eye: F8) -> F8:
    """(N,) how differently each of (N, 3) eyes and ``eye`` look at ``center``; 0 for the same.

    The angle between the directions to them in radians, and a tenth of the logarithm of the ratio
    of their distances.
    """
    arms = eyes - center
    length = np.maximum(np.linalg.norm(arms, axis=1), 1e-9)
    arm = np.asarray(eye, dtype=np.float64) - center
    far = max(float(np.linalg.norm(arm)), 1e-9)
    cosine = np.clip(arms @ arm / (length * far), -1.0, 1.0)
    return np.arccos(cosine) + 0.1 * np.abs(np.log(length / far))
