"""The polygon noun: triangles with materials and texture coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import SceneError

__all__ = ["Material", "Mesh"]

_BLACK = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Material:
    """A diffuse surface: the product of a base color and, if there is one, a texture."""

    name: str
    """What people call it; shown in messages."""
    base_color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Linear reflectance per channel in [0, 1]; multiplies the texture."""
    texture: npt.NDArray[np.uint8] | npt.NDArray[np.float32] | None = None
    """(H, W, 3) uint8 sRGB or float32 linear, or None. It repeats; row 0 lies at v = 0."""
    emission: tuple[float, float, float] = _BLACK
    """Linear radiance that the surface gives off by itself."""

    def __post_init__(self) -> None:
        """Refuse colours and textures that are of no use."""
        for name in ("base_color", "emission"):
            value = np.asarray(getattr(self, name), dtype=np.float64)
            if value.shape != (3,) or not np.all(np.isfinite(value)) or np.any(value < 0.0):
                raise SceneError(
                    f"Material {self.name!r}: {name} is {getattr(self, name)!r}, expected three "
                    "finite linear values >= 0"
                )
        texture = self.texture
        if texture is None:
            return
        if texture.ndim != 3 or texture.shape[2] != 3 or texture.size == 0:
            raise SceneError(
                f"Material {self.name!r}: texture has shape {texture.shape}, expected (H, W, 3): "
                "drop alpha and repeat grey three times"
            )
        if texture.dtype not in (np.uint8, np.float32):
            raise SceneError(
                f"Material {self.name!r}: texture is {texture.dtype}, expected uint8 (sRGB) or "
                "float32 (linear)"
            )


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Triangles in world space, each with a material and texture coordinates per corner.

    The front of a face is the side from which its corners run counter-clockwise.
    """

    vertices: npt.NDArray[np.float64]
    """(N, 3) positions, metres, world frame."""
    faces: npt.NDArray[np.int32]
    """(M, 3) vertex indices."""
    material_index: npt.NDArray[np.int32]
    """(M,) index into `materials`."""
    uv: npt.NDArray[np.float32]
    """(M, 3, 2) texture coordinates of each face's corners, in repeats of the texture."""
    materials: tuple[Material, ...] = field(default_factory=tuple)
    """Shared by the faces."""
    colors: npt.NDArray[np.float32] | None = None
    """(M, 3, 3) linear colors of each face's corners, which multiply the base color; or None."""

    def __post_init__(self) -> None:
        """Convert to the stated types and refuse indices that point nowhere."""
        set_field = object.__setattr__  # frozen: this is the one place that may
        set_field(self, "vertices", np.ascontiguousarray(self.vertices, dtype=np.float64))
        set_field(self, "faces", np.ascontiguousarray(self.faces, dtype=np.int32))
        set_field(self, "material_index", np.ascontiguousarray(self.material_index, np.int32))
        set_field(self, "uv", np.ascontiguousarray(self.uv, dtype=np.float32))
        set_field(self, "materials", tuple(self.materials))
        count = len(self.faces)
        if self.colors is not None:
            set_field(self, "colors", np.ascontiguousarray(self.colors, dtype=np.float32))
        expected: dict[str, tuple[int, ...]] = {
            "vertices": (len(self.vertices), 3),
            "faces": (count, 3),
        }
        expected |= {"material_index": (count,), "uv": (count, 3, 2)}
        if self.colors is not None:
            expected["colors"] = (count, 3, 3)
        for name, shape in expected.items():
            if getattr(self, name).shape != shape:
                raise SceneError(
                    f"Mesh.{name} has shape {getattr(self, name).shape}, expected {shape}"
                )
        _check_range("faces", self.faces, len(self.vertices), "vertices")
        _check_range("material_index", self.material_index, len(self.materials), "materials")
        for name in ("vertices", "uv", *(() if self.colors is None else ("colors",))):
            bad = np.argwhere(~np.isfinite(getattr(self, name)))
            if len(bad):
                raise SceneError(
                    f"Mesh.{name}{bad[0].tolist()} is not finite ({len(bad)} such values): "
                    "remove the faces that use it"
                )

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """(2, 3) smallest and largest coordinates, metres; zeros for an empty mesh."""
        if not len(self.vertices):
            return np.zeros((2, 3))
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def normals(self) -> npt.NDArray[np.float64]:
        """(M, 3) unit normals of the faces' fronts; zero for a face without area."""
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        return np.divide(normal, length, out=np.zeros_like(normal), where=length > 0.0)

    @classmethod
    def concatenate(cls, meshes: Sequence[Mesh]) -> Mesh:
        """One mesh out of several; materials that are the same object are kept once."""
        materials: list[Material] = []
        place: dict[int, int] = {}
        vertices, faces, index, uv = [np.zeros((0, 3))], [], [], []
        colors: list[npt.NDArray[np.float32] | None] = []
        first = 0
        for mesh in meshes:
            for material in mesh.materials:
                if id(material) not in place:
                    place[id(material)] = len(materials)
                    materials.append(material)
            to_new = np.array([place[id(m)] for m in mesh.materials], dtype=np.int32)
            vertices.append(mesh.vertices)
            faces.append(mesh.faces + first)
            index.append(to_new[mesh.material_index] if len(to_new) else mesh.material_index)
            uv.append(mesh.uv)
            colors.append(mesh.colors)
            first += len(mesh.vertices)
        if not faces:
            return cls(
                vertices[0],
                np.zeros((0, 3), np.int32),
                np.zeros(0, np.int32),
                np.zeros((0, 3, 2), np.float32),
            )
        return cls(
            np.concatenate(vertices),
            np.concatenate(faces),
            np.concatenate(index),
            np.concatenate(uv),
            tuple(materials),
            _joined_colors(colors, [len(part) for part in faces]),
        )


def _joined_colors(
    parts: Sequence[npt.NDArray[np.float32] | None], counts: Sequence[int]
) -> npt.NDArray[np.float32] | None:
    """The colors of joined meshes: white where a part has none, None where no part has any."""
    if all(part is None for part in parts):
        return None
    white = [np.ones((n, 3, 3), np.float32) if p is None else p
             for p, n in zip(parts, counts, strict=True)]  # fmt: skip
    return np.concatenate(white)


def _check_range(name: str, index: npt.NDArray[np.int32], count: int, target: str) -> None:
    bad = np.argwhere((index < 0) | (index >= count))
    if len(bad):
        at = tuple(int(i) for i in bad[0])
        raise SceneError(
            f"Mesh.{name}{list(at)} is {int(index[at])}, but there are {count} {target} "
            f"(0 to {count - 1}): {len(bad)} such indices"
        )
