"""The pictures that stand for what lies beyond a portal.

Source: spec portal-walkthrough 3.3 to 3.7.
"""

from __future__ import annotations

from collections.abc import Sequence
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
        return nearest_eyes(
            self.side.portal.center, [r.camera.center for r in self.references], eye, count
        )


def nearest_eyes(center: F8, eyes: Sequence[F8], eye: F8, count: int) -> list[int]:
    """Which ``count`` of ``eyes`` look at ``center`` most as ``eye`` does, best first."""
    arms = np.asarray(eyes, dtype=np.float64) - center
    length = np.linalg.norm(arms, axis=1)
    arm = np.asarray(eye, dtype=np.float64) - center
    far = max(float(np.linalg.norm(arm)), 1e-9)
    cosine = np.clip(arms @ arm / (np.maximum(length, 1e-9) * far), -1.0, 1.0)
    apart = np.arccos(cosine) + 0.1 * np.abs(np.log(np.maximum(length, 1e-9) / far))
    return [int(k) for k in np.argsort(apart, kind="stable")[:count]]


def is_in_front(side: Side, camera: Camera) -> bool:
    """Whether the camera's eye is on the viewer's side of the portal."""
    return bool((camera.center - side.portal.center) @ side.normal > 0.0)
