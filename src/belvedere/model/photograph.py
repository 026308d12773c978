"""Photographs of a lit model: supersampled color, exact disparity.

Color is the mean, in linear light, of a square of samples per pixel. Disparity belongs to the ray
through the pixel's center alone, worked out in float64 from the plane of the face that it meets:
a mean of disparities across an edge would be the depth of nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_choice, check_integer, check_number
from belvedere.ground.color import LINEAR_TO_SRGB8, SRGB8_TO_LINEAR
from belvedere.ground.threads import run_parallel
from belvedere.model.charts import Charts
from belvedere.model.light import LightMap
from belvedere.model.raycast import RayCaster
from belvedere.scene import CameraModel, ReferenceView
from belvedere.scene.mesh import Mesh

ROWS = 16
"""Image rows per piece of work."""
MOST_SAMPLES = 16
PIXELS = 4096
"""Single pixels per piece of work."""


@dataclass(frozen=True, eq=False)
class LitModel:
    """Polygons with baked light, ready to be photographed."""

    mesh: Mesh
    """What stands there."""
    charts: Charts
    """Where the light is stored on it."""
    light: LightMap
    """The light."""

    @cached_property
    def caster(self) -> RayCaster:
        """Rays against the mesh; made once."""
        return RayCaster(self.mesh)

    @cached_property
    def shading(self) -> Shading:
        """What shading looks up per face; made once."""
        return Shading.of(self)


@dataclass(frozen=True, slots=True, eq=False)
class Shading:
    """Tables for the shading kernel."""

    density: npt.NDArray[np.float32]
    """(M,) texels per metre on each face."""
    normal: npt.NDArray[np.float32]
    """(M, 3) unit normals of the faces."""
    flat: npt.NDArray[np.bool_]
    """(K,) charts on which positions, colors, textures and light coordinates are all affine."""
    base: npt.NDArray[np.float32]
    """(T, 3) base color of each material."""
    emission: npt.NDArray[np.float32]
    """(T, 3) emission of each material."""
    colors: npt.NDArray[np.float32]
    """(M, 3, 3) the corners' own colors, which multiply the base color; (0, 3, 3) if none."""
    texture_of: npt.NDArray[np.int32]
    """(T,) row of `levels`, or -1."""
    texels: npt.NDArray[np.uint8]
    """(X, 3) sRGB texels of all levels of all textures."""
    levels: npt.NDArray[np.int32]
    """(Q, L, 3) first texel, height, width of each texture's levels, each half the one before."""

    @classmethod
    def of(cls, model: LitModel) -> Shading:
        """The tables of a model."""
        mesh, charts = model.mesh, model.charts
        pyramids, texture_of = [], np.full(len(mesh.materials), -1, dtype=np.int32)
        for k, material in enumerate(mesh.materials):
            if material.texture is not None:
                texture_of[k] = len(pyramids)
                pyramids.append(_pyramid(material.texture))
        depth = max(2, *(len(p) for p in pyramids), 0)  # two levels are read at a time
        levels = np.zeros((max(len(pyramids), 1), depth, 3), dtype=np.int32)
        texels, first = [np.zeros((1, 3), dtype=np.uint8)], 1
        for q, pyramid in enumerate(pyramids):
            places = []
            for image in pyramid:
                places.append((first, *image.shape[:2]))
                texels.append(image.reshape(-1, 3))
                first += len(texels[-1])
            levels[q] = places + [places[-1]] * (depth - len(places))
        c = charts.corners
        bent = np.abs(c[:, 0] - c[:, 1] + c[:, 2] - c[:, 3]).max(axis=1)
        return cls(
            _texel_density(mesh, texture_of, levels),
            mesh.normals().astype(np.float32),
            (bent < 1e-9) & _evenly_colored(mesh, charts),
            np.array([m.base_color for m in mesh.materials], dtype=np.float32),
            np.array([m.emission for m in mesh.materials], dtype=np.float32),
            np.zeros((0, 3, 3), dtype=np.float32) if mesh.colors is None else mesh.colors,
            texture_of,
            np.concatenate(texels),
            levels,
        )


def photograph(
    model: LitModel,
    camera: CameraModel,
    samples: int = 3,
    dtype: Literal["uint8", "float32"] = "uint8",
    threads: int | None = None,
    near: float = 0.0,
) -> ReferenceView:
    """Take a picture that knows its depth.

    Where a pixel and its eight neighbours see one flat surface, its samples are shaded on that
    surface's plane without rays of their own; everywhere else each sample casts a ray.

    Args:
        model: what to look at.
        camera: from where; any kind.
        samples: per pixel side, so ``samples ** 2`` colors are averaged.
        dtype: ``"uint8"`` for sRGB, ``"float32"`` for linear radiance.
        threads: how many to use; None for as many as there are processors.
        near: what stands nearer than this along a ray is not there, counted as disparity counts
            (for a planar camera in depths, metres). A camera through a portal clips the room
            between it and the portal so.

    Returns:
        Color (H, W, 3) and disparity (H, W), which is 0 where the sky is seen.

    Raises:
        InputError: samples out of range, an unknown dtype, a negative or infinite ``near``.
        MissingDependencyError: embreex is not installed.
    """
    samples = check_integer("photograph", "samples", samples, 1, MOST_SAMPLES)
    check_choice("photograph", "dtype", dtype, ("uint8", "float32"))
    near = check_number("photograph", "near", near, 0.0)
    size = (camera.height, camera.width)
    face = np.empty(size, dtype=np.int32)
    disparity = np.empty(size, dtype=np.float32)
    caster, mesh = model.caster, model.mesh
    _ = model.shading  # made here, before the threads want it
    from belvedere.model import _kernels

    def look(first: int) -> None:
        rows = slice(first, min(first + ROWS, size[0]))
        v, u = np.mgrid[rows, 0 : size[1]]
        origins, directions = _rays(camera, u.ravel(), v.ravel())
        start = origins + near * directions
        hit = caster.cast_piece(start.astype(np.float32), directions.astype(np.float32))
        face[rows] = hit["primID"].reshape(-1, size[1])
        delta = np.empty(len(directions))
        _kernels.exact_disparity(
            hit["primID"], origins, directions, mesh.vertices, mesh.faces, delta
        )
        disparity[rows] = np.abs(delta).reshape(-1, size[1])

    pieces = range(0, size[0], ROWS)
    run_parallel(look, pieces, threads)
    chart = np.where(face >= 0, model.charts.of_face[face], -1)
    plain = np.empty(size, dtype=bool)
    _kernels.find_plain(chart, model.shading.flat, plain)
    color = np.zeros((*size, 3), dtype=np.float32)
    spread = _pixel_angle(camera) / samples

    def paint(first: int) -> None:
        rows = slice(first, min(first + ROWS, size[0]))
        part = face[rows], plain[rows], color[rows]
        _paint_rows(model, camera, rows, samples, spread, near, *part)

    run_parallel(paint, pieces, threads)
    return ReferenceView(camera, encode(color) if dtype == "uint8" else color, disparity)


def photograph_pixels(
    model: LitModel,
    camera: CameraModel,
    u: npt.NDArray[np.integer],
    v: npt.NDArray[np.integer],
    threads: int | None = None,
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32]]:
    """What single pixels of a photograph would show, by one ray each.

    Args:
        model: what to look at.
        camera: from where; any kind.
        u: (N,) columns.
        v: (N,) rows.
        threads: how many to use; None for as many as there are processors.

    Returns:
        (N, 3) sRGB and (N,) disparity, 0 where the sky is seen.
    """
    color = np.zeros((len(u), 3), dtype=np.float32)
    disparity = np.empty(len(u), dtype=np.float32)
    spread = _pixel_angle(camera)
    _ = model.shading, model.caster  # made here, before the threads want them
    from belvedere.model import _kernels

    def look(first: int) -> None:
        part = slice(first, first + PIXELS)
        origins, directions = _rays(camera, u[part], v[part])
        hit = model.caster.cast_piece(origins.astype(np.float32), directions.astype(np.float32))
        delta = np.empty(len(directions))
        _kernels.exact_disparity(
            hit["primID"], origins, directions, model.mesh.vertices, model.mesh.faces, delta
        )
        disparity[part] = np.abs(delta)
        _shade(
            model, hit["primID"], hit["u"], hit["v"], hit["tfar"], directions, spread, 1,
            np.arange(len(directions)), color[part],
        )  # fmt: skip

    run_parallel(look, range(0, len(u), PIXELS), threads)
    return encode(color), disparity


def encode(color: npt.NDArray[np.float32]) -> npt.NDArray[np.uint8]:
    """``uint8`` sRGB of (H, W, 3) linear radiance, through the table."""
    steps = len(LINEAR_TO_SRGB8) - 1
    root = np.sqrt(np.clip(color, 0.0, 1.0)) * np.float32(steps) + np.float32(0.5)
    return LINEAR_TO_SRGB8[root.astype(np.int32)]


def _paint_rows(
    model: LitModel,
    camera: CameraModel,
    rows: slice,
    samples: int,
    spread: float,
    near: float,
    face: npt.NDArray[np.int32],
    plain: npt.NDArray[np.bool_],
    color: npt.NDArray[np.float32],
) -> None:
    from belvedere.model import _kernels

    mesh = model.mesh
    step = (np.arange(samples) + 0.5) / samples - 0.5
    v, u = np.mgrid[rows, 0 : camera.width]
    count = samples * samples
    for simple in (True, False):
        pixel = np.flatnonzero(plain.ravel() == simple)
        if not len(pixel):
            continue
        at_u = (u.ravel()[pixel, None, None] + step).repeat(samples, axis=1).ravel()
        at_v = (v.ravel()[pixel, None, None] + step[:, None]).repeat(samples, axis=2).ravel()
        origins, directions = _rays(camera, at_u, at_v)
        if simple:
            hit_face = face.ravel()[pixel].repeat(count)
            b, c, t = (np.zeros(len(hit_face), dtype=np.float32) for _ in range(3))
            _kernels.plane_hits(hit_face, origins, directions, mesh.vertices, mesh.faces, b, c, t)
        else:
            start = (origins + near * directions).astype(np.float32)
            hit = model.caster.cast_piece(start, directions.astype(np.float32))
            hit_face, b, c, t = hit["primID"], hit["u"], hit["v"], hit["tfar"]
            t = t + np.float32(near)
        _shade(model, hit_face, b, c, t, directions, spread, count, pixel, color.reshape(-1, 3))


def _shade(
    model: LitModel,
    face: npt.NDArray[np.int32],
    b: npt.NDArray[np.float32],
    c: npt.NDArray[np.float32],
    t: npt.NDArray[np.float32],
    directions: npt.NDArray[np.float64],
    spread: float,
    count: int,
    pixel: npt.NDArray[np.intp],
    out_color: npt.NDArray[np.float32],
) -> None:
    """Add the mean of every ``count`` samples to ``out_color[pixel]``."""
    from belvedere.model import _kernels

    mesh, charts, light, look = model.mesh, model.charts, model.light, model.shading
    length = np.sqrt(np.einsum("ij,ij->i", directions, directions))
    _kernels.shade(
        face, b, c, directions, t * length, spread, count, pixel, charts.of_face,
        charts.st, mesh.uv, look.density, look.normal, mesh.material_index, look.base,
        look.emission, look.colors, look.texture_of, look.texels, look.levels, SRGB8_TO_LINEAR,
        light.soft_lattice.first, light.soft_lattice.shape, light.soft,
        light.sun_lattice.first, light.sun_lattice.shape, light.sun, light.sun_color,
        out_color,
    )  # fmt: skip


def _rays(
    camera: CameraModel, u: npt.NDArray[np.number], v: npt.NDArray[np.number]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """(N, 3) origins and directions, float64 and contiguous."""
    return (
        np.ascontiguousarray(camera.origins(u, v), dtype=np.float64),
        np.ascontiguousarray(camera.rays(u, v), dtype=np.float64),
    )


def _pixel_angle(camera: CameraModel) -> float:
    """Angle between neighbouring rays in the middle of the picture, radians."""
    u = camera.width / 2.0 + np.array([-0.5, 0.5])
    a, b = camera.rays(u, np.full(2, camera.height / 2.0))
    return float(np.linalg.norm(np.cross(a, b)) / (np.linalg.norm(a) * np.linalg.norm(b)))


def _pyramid(texture: npt.NDArray[np.generic]) -> list[npt.NDArray[np.uint8]]:
    """The texture at halved sizes down to a few texels, each averaged in linear light."""
    if texture.dtype == np.uint8:
        image = texture.astype(np.uint8)
        linear = SRGB8_TO_LINEAR[image]
    else:
        linear = texture.astype(np.float32)
        image = encode(linear)
    levels = [image]
    while min(linear.shape[:2]) >= 8:
        height, width = linear.shape[0] // 2 * 2, linear.shape[1] // 2 * 2
        even = linear[:height, :width]
        linear = 0.25 * (
            even[::2, ::2] + even[1::2, ::2] + even[::2, 1::2] + even[1::2, 1::2]
        )  # fmt: skip
        levels.append(encode(linear))
    return levels


def _evenly_colored(mesh: Mesh, charts: Charts) -> npt.NDArray[np.bool_]:
    """(K,) whether all corners on a chart have one color."""
    count = len(charts.material)
    if mesh.colors is None:
        return np.ones(count, dtype=np.bool_)
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, charts.of_face, mesh.colors.min(axis=1))
    np.maximum.at(high, charts.of_face, mesh.colors.max(axis=1))
    return np.asarray(~(high > low).any(axis=1))


def _texel_density(
    mesh: Mesh, texture_of: npt.NDArray[np.int32], levels: npt.NDArray[np.int32]
) -> npt.NDArray[np.float32]:
    """(M,) texels per metre: the root of texels per square metre."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    p, q = mesh.uv[:, 1] - mesh.uv[:, 0], mesh.uv[:, 2] - mesh.uv[:, 0]
    covered = np.abs(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])
    which = texture_of[mesh.material_index]
    texels = np.where(which >= 0, levels[which, 0, 1] * levels[which, 0, 2], 0)
    return np.sqrt(covered * texels / np.maximum(area, 1e-12)).astype(np.float32)
