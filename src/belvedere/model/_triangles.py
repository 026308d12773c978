"""Triangles as a reader finds them, and what makes a `Mesh` of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from belvedere.model._weld import first_equal
from belvedere.model.report import Report
from belvedere.scene.mesh import Material, Mesh

F8 = npt.NDArray[np.float64]
F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
I8 = npt.NDArray[np.int64]

FLAT = 1e-9
"""A face is without area where it is this much thinner than long: float64 cannot say more."""
NO_MATERIAL = Material("no material", (0.8, 0.8, 0.8))
"""For faces that name none: the light grey that most tools show."""


@dataclass(slots=True)
class Triangles:
    """Faces in a file's own units and axes. Values may be of no use yet."""

    vertices: F8
    """(N, 3) positions."""
    faces: I8
    """(M, 3) vertex indices, in range."""
    material: I4
    """(M,) index into the reader's materials, or -1."""
    uv: F4
    """(M, 3, 2) texture coordinates, row 0 of a texture at v = 0."""
    colors: F4 | None = None
    """(M, 3, 3) linear, or None."""
    thing: I4 = field(default_factory=lambda: np.zeros(0, np.int32))
    """(M,) index into the reader's names of objects."""

    def kept(self, keep: npt.NDArray[np.bool_]) -> Triangles:
        """Only the faces that ``keep`` (M,) says."""
        if keep.all():
            return self
        colors = None if self.colors is None else self.colors[keep]
        return Triangles(
            self.vertices, self.faces[keep], self.material[keep], self.uv[keep], colors,
            self.thing[keep],
        )  # fmt: skip

    @classmethod
    def joined(cls, parts: Sequence[Triangles]) -> Triangles:
        """All of them, in order."""
        if not parts:
            return cls(
                np.zeros((0, 3)), np.zeros((0, 3), np.int64), np.zeros(0, np.int32),
                np.zeros((0, 3, 2), np.float32),
            )  # fmt: skip
        if len(parts) == 1:
            return parts[0]
        first = np.cumsum([0, *(len(p.vertices) for p in parts)])
        colors = None
        if any(p.colors is not None for p in parts):
            colors = np.concatenate(
                [
                    np.ones((len(p.faces), 3, 3), np.float32) if p.colors is None else p.colors
                    for p in parts
                ]
            )
        return cls(
            np.concatenate([p.vertices for p in parts]),
            np.concatenate([p.faces + shift for p, shift in zip(parts, first, strict=False)]),
            np.concatenate([p.material for p in parts]),
            np.concatenate([p.uv for p in parts]),
            colors,
            np.concatenate([p.thing for p in parts]),
        )


def cleaned(triangles: Triangles, report: Report) -> Triangles:
    """Without faces that nothing can be done with; equal vertices joined, unused ones gone."""
    faces = triangles.faces
    finite = np.asarray(np.isfinite(triangles.vertices).all(axis=1))
    if not finite.all():
        usable = np.asarray(finite[faces].all(axis=1))
        report.count(
            int(np.count_nonzero(~finite)), "vertex", "vertices", "with NaN or infinite coordinates"
            f": {np.count_nonzero(~usable):,} faces that use them left out",
        )  # fmt: skip
        triangles = triangles.kept(usable)
        triangles.vertices = np.where(finite[:, None], triangles.vertices, 0.0)
    bad = ~np.isfinite(triangles.uv)
    if bad.any():
        report.count(
            int(bad.any(axis=2).sum()), "corner", "corners", "without finite texture coordinates: "
            "0 taken",
        )  # fmt: skip
        triangles.uv = np.where(bad, np.float32(0.0), triangles.uv)
    if triangles.colors is not None:
        triangles.colors = np.nan_to_num(triangles.colors, nan=1.0, posinf=1.0, neginf=0.0)
    triangles.faces = first_equal(triangles.vertices)[triangles.faces]
    flat = _flat(triangles.vertices, triangles.faces)
    report.count(int(flat.sum()), "face", "faces", "without area: left out")
    triangles = triangles.kept(~flat)
    again = _repeated(triangles.faces)
    report.count(int(again.sum()), "face", "faces", "given twice: left out the second time")
    return _compact(triangles.kept(~again))


def as_mesh(triangles: Triangles, materials: Sequence[Material], report: Report) -> Mesh:
    """The mesh of cleaned triangles, with the materials that they use."""
    index = triangles.material.copy()
    bare = index < 0
    report.count(int(bare.sum()), "face", "faces", "without a material: painted light grey")
    everything = (*materials, NO_MATERIAL)
    index[bare] = len(materials)
    used = np.unique(index)
    place = np.zeros(len(everything), dtype=np.int32)
    place[used] = np.arange(len(used))
    return Mesh(
        triangles.vertices,
        triangles.faces.astype(np.int32),
        place[index],
        triangles.uv,
        tuple(everything[k] for k in used),
        triangles.colors,
    )


def _flat(vertices: F8, faces: I8) -> npt.NDArray[np.bool_]:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    with np.errstate(over="ignore", invalid="ignore"):
        twice = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        sides = [((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))]
        return ~(twice > FLAT * np.maximum.reduce(sides))


def _repeated(faces: I8) -> npt.NDArray[np.bool_]:
    """Faces with the same corners in the same sense as an earlier one: the back is no repeat."""
    start = faces.argmin(axis=1)
    turned = np.take_along_axis(faces, (start[:, None] + np.arange(3)) % 3, axis=1)
    return first_equal(turned) != np.arange(len(faces))


def _compact(triangles: Triangles) -> Triangles:
    used = np.zeros(len(triangles.vertices), dtype=bool)
    used[triangles.faces] = True
    place = np.cumsum(used) - 1
    triangles.vertices = triangles.vertices[used]
    triangles.faces = place[triangles.faces]
    return triangles
