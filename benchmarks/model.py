"""Polygons drawn in software (asv): ours beside what else draws or casts them on this machine.

One frame of the built-in house from three stations, one or two threads; a rival that is not
installed is left out. Ours and `photograph` make the lit picture; rays, Open3D's and OpenGL's find
out only which triangle a pixel shows, or how far it is.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from belvedere.ground.threads import run_parallel
from belvedere.model import LitModel, Rasterizer, build_interior, photograph
from belvedere.model.photograph import ROWS
from belvedere.scene import Camera

SIZE = 640, 512
STATIONS = [
    ((1.2, 1.5, 1.6), (5.0, 2.3, 1.5), 60.0),
    ((7.0, 3.6, 1.6), (6.8, 7.0, 1.5), 60.0),
    ((5.27, 2.2, 1.6), (9.0, 2.3, 1.2), 100.0),
]
"""Eye and target in metres, field of view in degrees."""
NAMES = ["ours", "embree rays", "photograph", "open3d rays", "opengl ids"]
NEAR_M, FAR_M = 0.05, 100.0


class Frames:
    """One frame of each station."""

    params: ClassVar = [NAMES, [1, 2]]
    param_names: ClassVar = ["renderer", "threads"]
    timeout = 300

    def setup_cache(self) -> Any:
        """Light the house once for all benchmarks."""
        house = build_interior(seed=0, rays=16)
        return LitModel(house.mesh, house.charts, house.light)

    def setup(self, model: LitModel, name: str, threads: int) -> None:
        rivals = Rivals(model, threads)
        self.draw = rivals.choose(name)
        for camera in cameras():
            self.draw(camera)  # kernels compile here, tables are made

    def time_three_frames(self, *_: object) -> None:
        for camera in cameras():
            self.draw(camera)


def cameras() -> list[Camera]:
    """The stations' cameras."""
    return [
        Camera.look_at(eye, target, fov_deg=fov, width=SIZE[0], height=SIZE[1])
        for eye, target, fov in STATIONS
    ]


class Rivals:
    """What draws a model, each made when it is asked for."""

    def __init__(self, model: LitModel, threads: int) -> None:
        self.model, self.threads = model, threads

    def choose(self, name: str) -> Callable[[Camera], Any]:
        """The function that draws a frame; NotImplementedError tells asv to leave it out."""
        if name == "ours":
            return Rasterizer(self.model, self.threads).draw
        if name == "embree rays":
            return self._cast
        if name == "photograph":
            return lambda camera: photograph(self.model, camera, 1, threads=self.threads)
        module = {"open3d rays": "open3d", "opengl ids": "moderngl"}[name]
        if importlib.util.find_spec(module) is None:
            raise NotImplementedError(f"{module} is not installed")
        return self._open3d() if name == "open3d rays" else self._opengl()

    def _cast(self, camera: Camera) -> None:
        """Every pixel's ray, which face it meets."""

        def look(first: int) -> None:
            rows = slice(first, min(first + ROWS, camera.height))
            v, u = np.mgrid[rows, 0 : camera.width]
            start = camera.origins(u.ravel(), v.ravel()).astype(np.float32)
            self.model.caster.cast_piece(
                start, camera.rays(u.ravel(), v.ravel()).astype(np.float32)
            )

        run_parallel(look, range(0, camera.height, ROWS), self.threads)

    @cached_property
    def _soup(self) -> np.ndarray[Any, np.dtype[np.float32]]:
        mesh = self.model.mesh
        return np.ascontiguousarray(mesh.vertices[mesh.faces].reshape(-1, 3), dtype=np.float32)

    def _open3d(self) -> Callable[[Camera], Any]:
        import open3d as library

        open3d: Any = library

        scene = open3d.t.geometry.RaycastingScene(nthreads=self.threads)
        mesh = self.model.mesh
        scene.add_triangles(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32))

        def draw(camera: Camera) -> Any:
            v, u = np.mgrid[0 : camera.height, 0 : camera.width]
            start = camera.origins(u.ravel(), v.ravel())
            rays = np.concatenate([start, camera.rays(u.ravel(), v.ravel())], axis=1)
            return scene.cast_rays(open3d.core.Tensor(rays.astype(np.float32)))

        return draw

    def _opengl(self) -> Callable[[Camera], Any]:
        import moderngl

        opengl: Any = moderngl
        if self.threads > 1:
            raise NotImplementedError("it starts threads as it likes")
        os.environ["LP_NUM_THREADS"] = "1"  # where OpenGL is software
        try:
            context = opengl.create_context(standalone=True, backend="egl")
        except Exception as error:
            raise NotImplementedError("no OpenGL here") from error
        program = context.program(
            vertex_shader="""#version 330
                uniform mat4 view; in vec3 place;
                void main() { gl_Position = view * vec4(place, 1.0); }""",
            fragment_shader="""#version 330
                out int face;
                void main() { face = gl_PrimitiveID; }""",
        )
        array = context.vertex_array(program, [(context.buffer(self._soup), "3f", "place")])
        size = SIZE
        buffer = context.framebuffer(
            [context.texture(size, 1, dtype="i4")], context.depth_texture(size)
        )
        buffer.use()
        context.enable(opengl.DEPTH_TEST)

        def draw(camera: Camera) -> Any:
            buffer.clear()
            program["view"].write(clip_from_world(camera).T.astype(np.float32).tobytes())
            array.render()
            return buffer.read(components=1, dtype="i4")

        return draw


def _unit_step(camera: Camera) -> float:
    """Height of a pixel at unit depth."""
    return float(np.linalg.norm(camera.matrix[:, 1]))


def world_to_eye(camera: Camera) -> np.ndarray[Any, np.dtype[np.float32]]:
    """(4, 4) rigid transform: x to the right, y up, z towards the viewer."""
    right, down = camera.matrix[:, 0], camera.matrix[:, 1]
    right, down = right / np.linalg.norm(right), down / np.linalg.norm(down)
    turn = np.stack([right, -down, -np.cross(right, down)])
    world = np.eye(4, dtype=np.float32)
    world[:3, :3], world[:3, 3] = turn, -turn @ camera.center
    return world


def clip_from_world(camera: Camera) -> np.ndarray[Any, np.dtype[np.float64]]:
    """(4, 4) OpenGL's matrix of a camera that looks straight ahead."""
    flat = 2.0 / (camera.width * _unit_step(camera))
    tall = 2.0 / (camera.height * _unit_step(camera))
    near, far = NEAR_M, FAR_M
    clip = np.diag([flat, tall, (far + near) / (near - far), 0.0])
    clip[2, 3], clip[3, 2] = 2.0 * far * near / (near - far), -1.0
    return clip @ world_to_eye(camera).astype(np.float64)
