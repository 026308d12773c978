"""A lit model as a scene: the slow, exact twin of everything that warps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from belvedere.ground.checks import check_integer
from belvedere.model.photograph import MOST_SAMPLES, LitModel, photograph
from belvedere.scene import Affordances, Camera, CameraModel, Frame, ViewingRegion


@dataclass(frozen=True, eq=False)
class ModelScene:
    """Ray-cast polygons with fixed light; walk freely. A `belvedere.scene.Scene`."""

    model: LitModel
    """What is shown."""
    home: CameraModel
    """A camera that shows it well."""
    samples: int = 2
    """Samples per pixel side."""
    threads: int | None = None
    """How many to use; None for as many as there are processors."""

    def __post_init__(self) -> None:
        check_integer("ModelScene", "samples", self.samples, 1, MOST_SAMPLES)

    @classmethod
    def of(cls, model: LitModel, samples: int = 2) -> ModelScene:
        """A scene of any model, seen from the middle of it."""
        low, high = model.mesh.bounds
        middle = (low + high) / 2.0
        return cls(model, Camera.look_at(middle, middle + np.array([1.0, 0.0, 0.0])), samples)

    @property
    def affords(self) -> Affordances:
        """Walk anywhere: the whole geometry is known, the light is baked."""
        return Affordances("continuous", "global", "fixed")

    @property
    def viewing_region(self) -> ViewingRegion:
        """The box round the model."""
        low, high = self.model.mesh.bounds
        return ViewingRegion(low, high)

    def render(self, camera: CameraModel) -> Frame:
        """Cast rays. Every pixel is known, so coverage is 1 everywhere."""
        view = photograph(self.model, camera, self.samples, threads=self.threads)
        coverage = np.ones(camera.size, dtype=np.float32)
        return Frame(camera, view.color, view.disparity, coverage)
