"""What drawing looks up of a model, laid out for reading fast. Private."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import SRGB8_TO_LINEAR
from belvedere.model.photograph import LitModel, Shading

F4 = npt.NDArray[np.float32]
F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class DrawTables:
    """Arguments of `_shade_pixels.shade_pixels`, which tells what they are."""

    plane: F8
    """(M, 4) normal and height of each face's plane."""
    maps: F4
    """(M, 4, 4) slopes of chart and texture coordinates."""
    record: I4
    """(M, 8) where each face's light is, its material, and the bits of its texel density."""
    tints: F4
    """(M, 4, 4) slopes of the corners' own colors; (0, 4, 4) if there are none."""
    base: F4
    """(T, 4) base colors."""
    emission: F4
    """(T, 4) emissions."""
    texture_of: I4
    """(T,) row of `sizes`, or -1."""
    texels: npt.NDArray[np.uint16]
    """(X, 4) linear texels of all levels, framed."""
    sizes: F4
    """(Q, 2) width and height of each level."""
    places: npt.NDArray[np.int64]
    """(Q, 2) first texel of each level, and texels a row."""
    depth: int
    """Levels of each texture."""
    soft: F4
    """(P, 4) soft light, and zeros."""
    sun: F4
    """(S,) sun light, and zeros."""

    @classmethod
    def of(cls, model: LitModel, origin: F8) -> DrawTables:
        """The tables of a model, positions counted from ``origin``."""
        from belvedere.model import _shade_pixels as kernels

        mesh, charts, light, look = model.mesh, model.charts, model.light, model.shading
        count = len(mesh.faces)
        plane, maps = np.empty((count, 4)), np.empty((count, 4, 4), dtype=np.float32)
        kernels.face_tables(mesh.vertices, mesh.faces, origin, mesh.uv, charts.st, plane, maps)
        record = np.empty((count, 8), dtype=np.int32)
        for column, lattice in (
            (kernels.CHART, light.soft_lattice), (kernels.SUN, light.sun_lattice)
        ):  # fmt: skip
            record[:, column] = lattice.first[charts.of_face]
            record[:, column + 1 : column + 3] = lattice.shape[charts.of_face]
        record[:, kernels.MATERIAL] = mesh.material_index
        record[:, kernels.DENSITY] = look.density.view(np.int32)
        tints = np.empty((len(look.colors), 4, 4), dtype=np.float32)
        if len(tints):
            red_green, blue = look.colors[..., :2], look.colors[..., 2:].repeat(2, axis=2)
            kernels.face_tables(
                mesh.vertices, mesh.faces, origin, blue, red_green, np.empty_like(plane), tints
            )
        depth = look.levels.shape[1]
        # the cell of a lattice's last column or row is read whole, its far side with no weight
        more = [
            2 + int(each.shape.max(initial=0)) for each in (light.soft_lattice, light.sun_lattice)
        ]
        soft = np.zeros((len(light.soft) + more[0], 4), dtype=np.float32)
        soft[: len(light.soft), :3] = light.soft
        return cls(
            plane, maps, record, tints, _with_fourth(look.base), _with_fourth(look.emission),
            np.where(look.texture_of < 0, -1, look.texture_of * depth).astype(np.int32),
            *_framed(look), depth, soft,
            np.concatenate([light.sun, np.zeros(more[1])], dtype=np.float32),
        )  # fmt: skip


def _with_fourth(color: F4) -> F4:
    """(T, 4) colors and zeros."""
    return np.concatenate(
        [color.reshape(-1, 3), np.zeros((len(color), 1))], axis=1, dtype=np.float32
    )


def _framed(look: Shading) -> tuple[npt.NDArray[np.uint16], F4, npt.NDArray[np.int64]]:
    """(X, 4) texels, each level framed by a texel from its other side; sizes and places."""
    levels = look.levels.reshape(-1, 3)
    width, height = levels[:, 2].astype(np.int64), levels[:, 1].astype(np.int64)
    _, kept, place = np.unique(levels[:, 0], return_index=True, return_inverse=True)
    size = (width[kept] + 2) * (height[kept] + 2)
    first = np.cumsum(size) - size
    linear = np.rint(SRGB8_TO_LINEAR * 65535.0).astype(np.uint16)
    texels = np.zeros((int(size.sum()), 4), dtype=np.uint16)
    for start, level in zip(first, levels[kept], strict=True):
        from_, rows, columns = (int(each) for each in level)
        image = look.texels[from_ : from_ + rows * columns].reshape(rows, columns, 3)
        framed = texels[start : start + (rows + 2) * (columns + 2)]
        framed = framed.reshape(rows + 2, columns + 2, 4)
        framed[1:-1, 1:-1, :3] = linear[image]
        framed[0], framed[-1] = framed[-2], framed[1]
        framed[:, 0], framed[:, -1] = framed[:, -2], framed[:, 1]
    sizes = np.stack([width, height], axis=1).astype(np.float32)
    return texels, sizes, np.stack([first[place.ravel()], width + 2], axis=1)
