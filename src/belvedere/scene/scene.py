"""Anything that can be looked at: the `Scene` protocol and what a scene affords.

Viewers, path renderers and evaluators know only this; they never ask which kind of scene it is.

Source: Debevec's capability table; spec fundamentals 3.1.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Literal, Protocol, runtime_checkable

import numpy as np

from belvedere.ground.checks import check_choice
from belvedere.scene.camera_model import F8, CameraModel
from belvedere.scene.view import Frame

Movement = Literal["none", "rotation", "discrete", "continuous"]
Geometry = Literal["none", "local", "global"]
Lighting = Literal["fixed", "dynamic"]


@dataclass(frozen=True, slots=True)
class Affordances:
    """How freely a scene may be looked at: what navigation and relighting controls rely on."""

    movement: Movement
    """"none": one picture; "rotation": look around; "discrete": hop; "continuous": walk freely."""
    geometry: Geometry
    """"none", "local" (what the references saw) or "global" (a whole model)."""
    lighting: Lighting = "fixed"
    """"fixed" as photographed, or "dynamic"."""

    def __post_init__(self) -> None:
        owner = "Affordances"
        check_choice(
            owner, "movement", self.movement, ("none", "rotation", "discrete", "continuous")
        )
        check_choice(owner, "geometry", self.geometry, ("none", "local", "global"))
        check_choice(owner, "lighting", self.lighting, ("fixed", "dynamic"))

    def as_dict(self) -> dict[str, str]:
        """The three words, for JSON."""
        return asdict(self)


@dataclass(frozen=True, slots=True, eq=False)
class ViewingRegion:
    """Where a visitor may stand: a box in world space, metres."""

    low: F8
    """(3,) smallest x, y, z."""
    high: F8
    """(3,) largest x, y, z."""

    @classmethod
    def around(cls, points: F8, margin: float = 0.0) -> ViewingRegion:
        """The smallest box round (N, 3) points, widened by ``margin`` metres on every side."""
        return cls(points.min(axis=0) - margin, points.max(axis=0) + margin)

    def contains(self, point: F8) -> bool:
        """Whether a (3,) point lies in the box."""
        return bool(np.all(point >= self.low) and np.all(point <= self.high))


@runtime_checkable
class Scene(Protocol):
    """Anything that can be looked at. It has one verb."""

    @property
    def affords(self) -> Affordances:
        """What kind of looking it allows."""
        ...

    @property
    def viewing_region(self) -> ViewingRegion:
        """Where it looks right from."""
        ...

    @property
    def home(self) -> CameraModel:
        """A camera that shows it well, for a first picture."""
        ...

    def render(self, camera: CameraModel) -> Frame:
        """The picture from a camera: colour, disparity and coverage."""
        ...
