"""What a model shows closed that a visitor sees or walks through: door leaves and panes.

A mesh has no doors, only triangles; what they are is told by the names of their materials, which
is where glTF, OBJ and IFC converters put it.
"""

from __future__ import annotations

import re

import numpy as np
import numpy.typing as npt

from belvedere.scene.mesh import Mesh

DOOR = re.compile(r"(?<!out)(?<!in)door(?!step|mat|bell)|\bt(ü|ue)r\b|\bporte\b|\bpuerta\b", re.I)
"""Names that doors go by."""
PANE = re.compile(
    r"window|glass(?!es)|glazing|\bpanes?\b|\bglas\b|\bfenster\b|\bfen[eê]tre\b", re.I
)
"""Names that windows and panes go by; what lies in them is looked through."""
SILL = re.compile(r"sill|board|seat|frame|curtain|blind|shutter", re.I)
"""What has a window or a door in its name and is none."""

__all__ = ["named_doors", "named_panes", "without"]


def named_doors(mesh: Mesh) -> npt.NDArray[np.bool_]:
    """(M,) which faces have a material named as a door."""
    return _named(mesh, DOOR)


def named_panes(mesh: Mesh) -> npt.NDArray[np.bool_]:
    """(M,) which faces have a material named as a window or as glass."""
    return _named(mesh, PANE)


def without(mesh: Mesh, faces: npt.NDArray[np.bool_]) -> Mesh:
    """The mesh less the marked faces; the very same where none is marked."""
    if not faces.any():
        return mesh
    stay = ~faces
    return Mesh(
        mesh.vertices, mesh.faces[stay], mesh.material_index[stay], mesh.uv[stay], mesh.materials
    )


def _named(mesh: Mesh, pattern: re.Pattern[str]) -> npt.NDArray[np.bool_]:
    called = np.array(
        [bool(pattern.search(m.name)) and not SILL.search(m.name) for m in mesh.materials],
        dtype=bool,
    )
    return called[mesh.material_index] if len(called) else np.zeros(len(mesh.faces), dtype=bool)
