"""What a reader of one format hands over: nothing is converted yet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from belvedere.model._triangles import Triangles
from belvedere.scene.mesh import Material


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """Triangles in a file's own units and axes, with what they look like and are called."""

    format: str
    """For people."""
    triangles: Triangles
    """Not cleaned yet."""
    materials: Sequence[Material]
    """That the triangles index."""
    things: Sequence[str]
    """Names of the objects that the triangles index."""
    building: Any = None
    """The building as JSON, or a `Building`; None where the file states none."""
