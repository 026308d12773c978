"""A model that came out of a file."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from belvedere.model.building import Building
from belvedere.scene.mesh import Mesh

__all__ = ["ImportedModel", "ModelSource"]


@dataclass(frozen=True, slots=True)
class ModelSource:
    """What a file said of itself, and what had to be guessed."""

    format: str
    """``glTF``, ``OBJ``, ``PLY``, or the IFC schema, such as ``IFC2X3``."""
    metres_per_unit: float
    """What its coordinates were multiplied by."""
    units: str
    """How that is known, for people: ``metres by definition``, ``taken as millimetres``."""
    up: str
    """The axis of the file that became +z: ``x``, ``y`` or ``z``."""
    guessed: tuple[str, ...]
    """Which of ``units`` and ``up`` were guessed from the model's shape."""
    vertices: int
    """Vertices in the file, instances counted each time."""
    faces: int
    """Triangles in the file, larger polygons cut up, instances counted each time."""


@dataclass(frozen=True, slots=True, eq=False)
class ImportedModel:
    """Triangles in metres, +z up, right-handed; what the model states; what was lost."""

    mesh: Mesh
    """What stands there, with ``origin`` subtracted."""
    building: Building | None
    """Rooms and openings, in the mesh's coordinates; None where the model states none."""
    origin: npt.NDArray[np.float64]
    """(3,) metres: the place in the model's own world at which the mesh has its zero."""
    dropped: tuple[str, ...]
    """What was left out, changed or guessed, one line each, for people."""
    source: ModelSource
    """What the file said of itself."""
    names: tuple[str, ...] = field(default_factory=tuple)
    """What the model calls its objects."""
    object_of_face: npt.NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, np.int32))
    """(M,) index into ``names``."""
