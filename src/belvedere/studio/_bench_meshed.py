"""A reference as a mesh of two triangles a pixel, shown by others' rasterisers and ray casters.

Triangles whose corners differ in disparity by more than `EDGE` are left out: they would stretch
from a foreground to what lies behind it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import MissingDependencyError
from belvedere.ground.threads import run_parallel
from belvedere.scene import Camera, ReferenceView
from belvedere.studio._bench_peers import Picture, opencv_functions, register_and_look_up
from belvedere.studio._bench_rival import F4, FAR_M, depth_of, fuse_nearest, planar_of

I4 = npt.NDArray[np.int32]

EDGE = 0.05
"""Relative jump in disparity at which the mesh is cut: that of `belvedere.warp`."""
ROWS = 64
"""Picture rows a thread casts at once."""
NEAR_M = 0.1
"""The rasteriser's near plane, metres; its depths lose digits when it is nearer."""


@dataclass(frozen=True, slots=True, eq=False)
class DepthMesh:
    """One reference as triangles."""

    vertices: F4
    """(n, 3) world positions, one a pixel."""
    faces: I4
    """(m, 3)."""
    color: F4
    """(n, 3) sRGB-encoded, 0 to 255."""


def depth_mesh(view: ReferenceView) -> DepthMesh:
    """Two triangles for each four pixels, cut at depth edges."""
    camera, depth = planar_of(view), depth_of(view)
    height, width = depth.shape
    v, u = np.mgrid[0:height, 0:width]
    vertices = camera.center + camera.rays(u, v) * depth[..., None]
    index = np.arange(height * width, dtype=np.int32).reshape(height, width)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]
    faces = np.concatenate([np.stack([a, c, b], -1), np.stack([b, c, d], -1)]).reshape(-1, 3)
    corners = depth.ravel()[faces]
    whole = (corners.min(1) > 0) & (corners.max(1) <= (1.0 + EDGE) * corners.min(1))
    return DepthMesh(
        vertices.reshape(-1, 3).astype(np.float32),
        np.ascontiguousarray(faces[whole]),
        view.color.reshape(-1, 3).astype(np.float32),
    )


# ---- Embree ----------------------------------------------------------------------------------


def prepare_embree(views: Sequence[ReferenceView], threads: int) -> list[tuple[Any, DepthMesh]]:
    """A mesh and Embree's hierarchy over it for each reference."""
    del threads
    try:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene
    except ImportError as caught:
        raise MissingDependencyError("embreex") from caught
    prepared = []
    for view in views:
        mesh, scene = depth_mesh(view), EmbreeScene()
        TriangleMesh(scene, mesh.vertices, mesh.faces)
        scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))  # builds it
        prepared.append((scene, mesh))
    return prepared


def warp_embree(prepared: list[tuple[Any, DepthMesh]], camera: Camera, threads: int) -> Picture:
    """A ray a pixel into each reference's mesh; colours interpolated over the triangle."""
    matrix = camera.matrix.astype(np.float32)
    u = np.arange(camera.width, dtype=np.float32)[:, None] * matrix[:, 0] + matrix[:, 2]
    color = np.zeros((len(prepared), *camera.size, 3), np.uint8)
    depth = np.zeros((len(prepared), *camera.size), np.float32)

    def cast(first: int) -> None:
        rows = slice(first, min(first + ROWS, camera.height))
        v = np.arange(rows.start, rows.stop, dtype=np.float32)[:, None, None] * matrix[:, 1]
        rays = (u + v).reshape(-1, 3)
        origins = np.empty_like(rays)
        origins[:] = camera.center
        for n, (scene, mesh) in enumerate(prepared):
            hit = scene.run(origins, rays, query="INTERSECT", output=True)
            found = np.flatnonzero(hit["primID"] >= 0)
            corners = mesh.faces[hit["primID"][found]]
            b, c = hit["u"][found, None], hit["v"][found, None]
            mean = mesh.color[corners[:, 0]] * (1.0 - b - c)
            mean += mesh.color[corners[:, 1]] * b + mesh.color[corners[:, 2]] * c
            color[n, rows].reshape(-1, 3)[found] = (mean + 0.5).astype(np.uint8)
            depth[n, rows].reshape(-1)[found] = hit["tfar"][found]  # rays reach to unit depth

    run_parallel(cast, range(0, camera.height, ROWS), threads)
    return fuse_nearest([Picture(*one) for one in zip(color, depth, strict=True)])


# ---- OpenCV ----------------------------------------------------------------------------------


def prepare_triangles(views: Sequence[ReferenceView], threads: int) -> list[DepthMesh]:
    """The meshes, colours in [0, 1] as the rasteriser wants them."""
    del threads
    opencv_functions("triangleRasterize")
    meshes = [depth_mesh(view) for view in views]
    return [DepthMesh(one.vertices, one.faces, one.color / np.float32(255.0)) for one in meshes]


def warp_triangles(prepared: list[DepthMesh], camera: Camera, threads: int) -> Picture:
    """`triangleRasterize` of each reference's mesh, then the nearest of them."""
    cv2, (rasterize,) = opencv_functions("triangleRasterize")
    cv2.setNumThreads(threads)
    settings = cv2.TriangleRasterizeSettings()
    settings.setCullingMode(cv2.RASTERIZE_CULLING_NONE)
    settings.setShadingType(cv2.RASTERIZE_SHADING_SHADED)
    # its camera has y up, z backward and its axis in the picture's middle: any K fits with a shear
    height, width = camera.size
    square = np.array([[2.0 / height, 0.0, (0.5 - width / 2) * 2 / height],
                       [0.0, -2.0 / height, (height / 2 - 0.5) * 2 / height],
                       [0.0, 0.0, -1.0]])  # fmt: skip
    pose = np.eye(4)
    pose[:3] = square @ camera.intrinsics @ camera.world_to_camera[:3]
    pictures = []
    for mesh in prepared:
        color = np.zeros((*camera.size, 3), np.float32)
        depth = np.full(camera.size, np.float32(2.0 * FAR_M))
        color, depth = rasterize(
            mesh.vertices[None], mesh.faces[None], mesh.color[None], color, depth,
            pose.astype(np.float32), math.pi / 2, NEAR_M, 2.0 * FAR_M, settings,
        )  # fmt: skip
        depth[depth > 1.5 * FAR_M] = 0.0
        pictures.append(Picture(np.rint(color * 255.0).astype(np.uint8), depth))
    return fuse_nearest(pictures)


def prepare_registered(
    views: Sequence[ReferenceView], threads: int
) -> list[tuple[Camera, npt.NDArray[Any], F4]]:
    """Camera, colour and depth of each reference."""
    del threads
    opencv_functions("registerDepth")
    return [(planar_of(view), view.color, depth_of(view)) for view in views]


def warp_registered(
    prepared: list[tuple[Camera, npt.NDArray[Any], F4]], camera: Camera, threads: int
) -> Picture:
    """`registerDepth` and `remap` of each reference, then the nearest of them."""
    cv2, (register,) = opencv_functions("registerDepth")
    cv2.setNumThreads(threads)
    return fuse_nearest([register_and_look_up(cv2, register, *one, camera) for one in prepared])
