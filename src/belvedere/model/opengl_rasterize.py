"""Drawing lit polygons with OpenGL, for machines whose graphics card does it faster.

The same lists, pictures and tables as `rasterize`, so that either may stand in for the other. The
card settles which face a pixel shows and shades it; the disparity of that face's plane is worked
out here, in float64.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import BelvedereError, CameraError, MissingDependencyError
from belvedere.ground.scratch import lend
from belvedere.ground.threads import row_bands, run_parallel, thread_count
from belvedere.model import _opengl_shaders as shaders
from belvedere.model._draw_plan import DrawPlan
from belvedere.model._draw_tables import DrawTables
from belvedere.model.photograph import LitModel, _pixel_angle
from belvedere.model.rasterize import DrawList, Rasterizer
from belvedere.scene import Camera, CameraModel

F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]

NEAREST_M = 0.01
"""What is nearer than this to the eye, in depth, is cut away: as `rasterize` does."""
GAP = 4
"""Fewer clusters out of sight than these are drawn too rather than begin another draw call."""
WIDEST = 14
"""Tables are at most 2 ** WIDEST texels wide."""

__all__ = ["OpenGLDrawList", "OpenGLRasterizer"]


@dataclass(frozen=True, slots=True, eq=False)
class OpenGLDrawList:
    """Some faces of a model on the graphics card; see `OpenGLRasterizer.prepare`."""

    drawn: DrawList
    """The faces."""
    vertex_array: Any
    """Their corners, cluster by cluster."""
    face_of: Any
    """Texture: the face of each triangle."""


class OpenGLRasterizer:
    """Draws one lit model with OpenGL 3.3, for frame after frame, into memory.

    A stand-in for `Rasterizer`, with the same lists and pictures but for rounding: faces agree on
    all but some pixels of edges, and where faces coincide either may show. Whether it is faster
    depends on who draws: see `renderer`. With a program that draws on the processor ("llvmpipe")
    it is slower than `Rasterizer`.

    Any thread may draw, one at a time.

    Args:
        model: what to draw.
        threads: how many settle disparities; None for as many as there are processors.

    Raises:
        MissingDependencyError: moderngl is not installed.
        BelvedereError: the machine gives no OpenGL 3.3 context.

    Memory: as `Rasterizer`, and as much again on the card; surfaces less than ``6e-6 Z ** 2``
    metres apart, Z away, may show through one another (24 bits of depth).
    """

    def __init__(self, model: LitModel, threads: int | None = None) -> None:
        self.model, self.threads = model, threads
        self._rasterizer = Rasterizer(model, threads)
        self._context = _make_context()
        most = int(self._context.info["GL_MAX_TEXTURE_SIZE"])
        self._bits = min(WIDEST, most.bit_length() - 1)
        self._targets: tuple[Any, Any] | None = None
        self._all: OpenGLDrawList | None = None
        with self._context:
            self._visible = self._program(shaders.VISIBILITY_VERTEX, shaders.VISIBILITY_FRAGMENT)
            self._shade = self._program(shaders.EVERY_PIXEL, shaders.SHADE)
            self._every_pixel = self._context.vertex_array(self._shade, [])
            no_face = self._program(shaders.EVERY_PIXEL, shaders.NO_FACE)
            self._no_face = self._context.vertex_array(no_face, [])
            self._textures = self._upload(self._rasterizer.tables)

    @property
    def renderer(self) -> str:
        """Who draws: the name of the graphics card or of the program that stands in for one."""
        return str(self._context.info["GL_RENDERER"])

    def prepare(self, faces: npt.ArrayLike | None = None) -> OpenGLDrawList:
        """Make some faces ready to be drawn; see `Rasterizer.prepare`."""
        drawn = self._rasterizer.prepare(faces)
        cluster = np.repeat(np.arange(len(drawn.low)), np.diff(drawn.first_face))
        index = drawn.first_vertex[:-1][cluster][:, None] + drawn.corners.astype(np.int32)
        vertices = np.ascontiguousarray(drawn.vertices[:3].T, dtype=np.float32)
        with self._context:  # a buffer cannot be empty
            points = self._context.buffer(vertices.tobytes() or bytes(12))
            corners = self._context.buffer(index.astype(np.uint32).tobytes() or bytes(12))
            content = [(points, "3f", "position")]
            vertex_array = self._context.vertex_array(self._visible, content, index_buffer=corners)
            return OpenGLDrawList(drawn, vertex_array, self._table(drawn.faces.reshape(-1, 1)))

    def draw(
        self,
        camera: CameraModel,
        lists: Sequence[tuple[OpenGLDrawList, F8 | None]] | None = None,
    ) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32], I4]:
        """Draw the model, or parts of it; see `Rasterizer.draw`.

        Raises:
            CameraError: not a planar camera, or one larger than the card can draw.
        """
        if not isinstance(camera, Camera):
            raise CameraError(
                f"OpenGLRasterizer.draw.camera is a {type(camera).__name__}, expected a planar "
                "Camera: belvedere.model.photograph takes every kind"
            )
        if lists is None:
            self._all = self._all or self.prepare()
            lists = [(self._all, None)]
        eye = camera.center - self._rasterizer.origin
        with self._context:
            self._context.gc()  # what lists that are gone have left on the card
            visible, shown = self._targets_for(camera)
            self._draw_faces(camera, eye, lists, visible)
            self._draw_colors(camera, eye, visible, shown)
            return self._read(camera, eye, visible, shown)

    def _draw_faces(
        self,
        camera: Camera,
        eye: F8,
        lists: Sequence[tuple[OpenGLDrawList, F8 | None]],
        target: Any,
    ) -> None:
        target.use()
        target.clear(depth=0.0)
        self._context.enable_only(self._context.NOTHING)
        self._no_face.render(self._context.TRIANGLES, vertices=3)
        self._context.enable_only(self._context.DEPTH_TEST)
        self._context.depth_func = ">"
        program = self._visible
        _set_matrix(program["pixels_from_world"], np.linalg.inv(camera.matrix))
        program["eye"].value = tuple(eye)
        program["size"].value = (float(camera.width), float(camera.height))
        program["near"].value = NEAREST_M
        program["face_of"].value = 0
        origin = self._rasterizer.origin
        for each, planes in lists:
            each.face_of.use(0)
            for first, last in _ranges(
                DrawPlan(camera, origin, [(each.drawn, planes)]), each.drawn
            ):
                program["first"].value = first
                each.vertex_array.render(vertices=3 * (last - first), first=3 * first)

    def _draw_colors(self, camera: Camera, eye: F8, visible: Any, shown: Any) -> None:
        shown.use()
        self._context.enable_only(self._context.NOTHING)
        program = self._shade
        textures = {
            "faces": visible.color_attachments[0], "depths": visible.depth_attachment,
            **self._textures,
        }  # fmt: skip
        for unit, (name, texture) in enumerate(textures.items()):
            texture.use(unit)
            program[name].value = unit
        _set_matrix(program["matrix"], camera.matrix)
        program["eye"].value = tuple(eye)
        program["sun_color"].value = tuple(float(c) for c in self.model.light.sun_color)
        program["near"].value = NEAREST_M
        program["spread"].value = _pixel_angle(camera)
        program["finest"].value = self._rasterizer.tables.depth - 1.001
        program["tinted"].value = int(len(self._rasterizer.tables.tints) > 0)
        self._every_pixel.render(self._context.TRIANGLES, vertices=3)

    def _read(
        self, camera: Camera, eye: F8, visible: Any, shown: Any
    ) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32], I4]:
        """Colors and faces from the card, and the disparities of those faces' planes."""
        from belvedere.model import _kernels

        height, width = camera.size
        block = lend(11 * height * width)
        face, bits = block[: 8 * height * width].view(np.int32).reshape(2, height, width)
        disparity = bits.view(np.float32)
        color = block[8 * height * width :].reshape(height, width, 3)
        visible.read_into(face, components=1, dtype="i4", alignment=1)
        shown.read_into(color, components=3, alignment=1)
        bands = row_bands(height, 4 * thread_count(self.threads))

        def settle(rows: tuple[int, int]) -> int:
            return _kernels.plane_disparities(
                face, *rows, camera.matrix, eye, self._rasterizer.tables.plane, disparity
            )

        if sum(run_parallel(settle, bands, self.threads)):
            edge_on = np.isnan(disparity)
            depth = np.frombuffer(visible.depth_attachment.read(alignment=1), np.float32)
            disparity[edge_on] = depth.reshape(height, width)[edge_on] / np.float32(NEAREST_M)
        return color, disparity, face

    def _targets_for(self, camera: Camera) -> tuple[Any, Any]:
        """Frame buffers for faces with depth and for colors, of a camera's size."""
        size = (camera.width, camera.height)
        most = int(self._context.info["GL_MAX_TEXTURE_SIZE"])
        if max(size) > most:
            raise CameraError(
                f"OpenGLRasterizer.draw.camera has {size[0]} x {size[1]} pixels, expected at most "
                f"{most} a side: {self.renderer} draws no more"
            )
        if self._targets is None or self._targets[0].size != size:
            context = self._context
            faces, depth = context.texture(size, 1, dtype="i4"), context.depth_texture(size)
            depth.compare_func = ""  # its values are read, not compared
            visible = context.framebuffer([faces], depth)
            self._targets = visible, context.framebuffer([context.texture(size, 4)])
        return self._targets

    def _upload(self, t: DrawTables) -> dict[str, Any]:
        """Everything shading looks up, as textures by their names in the shader."""
        base = np.concatenate([t.base[:, :3], t.texture_of[:, None]], axis=1, dtype=np.float32)
        levels = np.concatenate([t.places, t.sizes], axis=1).astype(np.int32)
        return {
            "planes": self._table(t.plane.astype(np.float32)),
            "maps": self._table(t.maps.reshape(-1, 4)),
            "tints": self._table(t.tints.reshape(-1, 4)),
            "records": self._table(t.record.reshape(-1, 4)),
            "materials": self._table(np.stack([base, t.emission], axis=1).reshape(-1, 4)),
            "levels": self._table(levels),
            "texels": self._table(t.texels),
            "soft": self._table(t.soft),
            "sun": self._table(t.sun.reshape(-1, 1)),
        }

    def _table(self, values: npt.NDArray[Any]) -> Any:
        """(N, C) values as a texture whose rows follow one another."""
        columns = 1 << self._bits
        rows = max(-(-len(values) // columns), 1)
        if rows > columns:
            raise BelvedereError(
                f"OpenGLRasterizer: a table of {len(values)} rows does not fit the card's largest "
                f"texture ({columns} x {columns}): draw the model with Rasterizer"
            )
        padded = np.zeros((rows * columns, values.shape[1]), dtype=values.dtype)
        padded[: len(values)] = values
        kind = {"float32": "f4", "int32": "i4", "uint16": "nu2"}[values.dtype.name]
        return self._context.texture(
            (columns, rows), values.shape[1], padded.tobytes(), alignment=1, dtype=kind
        )

    def _program(self, vertex: str, fragment: str) -> Any:
        head = f"#version 330\nconst int BITS = {self._bits}, MASK = {(1 << self._bits) - 1};\n"
        return self._context.program(vertex_shader=head + vertex, fragment_shader=head + fragment)


def _make_context() -> Any:
    try:
        import moderngl
    except ImportError as error:
        raise MissingDependencyError.for_extra("moderngl", "opengl", "draw with OpenGL") from error
    failures: list[str] = []
    choices: tuple[dict[str, Any], ...] = ({"backend": "egl"}, {})
    for choice in choices:  # EGL needs no display; others are found by moderngl
        try:
            context = moderngl.create_context(require=330, standalone=True, **choice)
        except Exception as error:  # whatever the driver's loader raises
            failures.append(str(error))
            continue
        context.gc_mode = "context_gc"
        return context
    raise BelvedereError(
        f"OpenGLRasterizer: this machine gives no OpenGL 3.3 context ({'; '.join(failures)}): "
        "install the graphics card's driver with EGL, or draw with Rasterizer, which needs none"
    )


def _ranges(plan: DrawPlan, drawn: DrawList) -> list[tuple[int, int]]:
    """First triangle in sight and the one after the last, several times; the nearest first."""
    if not len(plan.cluster):
        return []
    order = np.argsort(plan.cluster)
    seen, near = plan.cluster[order], plan.near[order]
    begin = np.concatenate([[0], 1 + np.flatnonzero(np.diff(seen) > GAP)])
    end = np.append(begin[1:], len(seen))
    nearest = np.argsort(-np.maximum.reduceat(near, begin), kind="stable")
    first, last = drawn.first_face[seen[begin]], drawn.first_face[seen[end - 1] + 1]
    return [(int(first[k]), int(last[k])) for k in nearest]


def _set_matrix(uniform: Any, matrix: npt.NDArray[Any]) -> None:
    """OpenGL reads column after column."""
    uniform.write(np.ascontiguousarray(matrix.T, dtype=np.float32).tobytes())
