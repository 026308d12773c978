"""The reconstructors: how samples that have moved become a picture again.

Each paints one reference into one band of the desired view and says whether it works on the
view's own colour (it only copies) or on linear radiance (it averages).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_choice, check_integer, check_number
from belvedere.ground.errors import InputError
from belvedere.ground.scratch import scratch
from belvedere.warp.prepare import PreparedView
from belvedere.warp.silhouettes import Silhouettes

F4 = npt.NDArray[np.float32]

Reconstruction = Literal["point", "splat", "mesh", "offset", "inverse"]
RECONSTRUCTIONS: tuple[Reconstruction, ...] = ("point", "splat", "mesh", "offset", "inverse")

SURFACE_TOLERANCE = 0.03
"""Relative difference in disparity up to which samples that meet in a pixel are one surface. Above
sensor noise and the change across a pixel's slope, below the steps of furniture."""


@dataclass(frozen=True, slots=True)
class SplatOptions:
    """Footprints of `splat`."""

    size: int | Literal["jacobian"] = "jacobian"
    """Pixels along the square's side, odd, up to 15; or "jacobian": what each sample grows to."""
    largest: int = 7
    """Upper bound of a growing footprint, odd: samples grow without gaps up to 0.7 times it."""

    def __post_init__(self) -> None:
        for name, value in (("size", self.size), ("largest", self.largest)):
            if name == "size" and value == "jacobian":
                continue
            if check_integer("SplatOptions", name, value, 1, 15) % 2 == 0:
                raise InputError(f"SplatOptions.{name} is {value}, expected an odd number")

    @property
    def halo(self) -> int:
        """Pixels that a splat reaches beyond the one its sample lands in."""
        return (self.largest if self.size == "jacobian" else self.size) // 2


@dataclass(frozen=True, slots=True)
class OffsetOptions:
    """Lattice and filter of `offset` (Popescu and Lastra's a, b, o)."""

    density: int | Literal["adaptive"] = "adaptive"
    """Sub-samples per reference pixel and axis: even, the paper's a = b c for growth up to c; or
    "adaptive": what each cell of four samples needs, so that nothing shows through."""
    largest: int = 32
    """Upper bound of an adaptive density: cells grow without leaks up to largest / (sqrt(2) b)."""
    buffer_scale: int = 2
    """Warp-buffer cells per output pixel and axis, even."""
    offset_bits: int = 2
    """Bits of a sub-sample's place in its cell, per axis, 0 to 4."""
    filter: Literal["radial", "separable"] = "separable"
    """Raised cosine: of the distance (0 at the corners of 2 x 2 pixels), or a product of two. The
    paper allows both readings; the product is the sharper one, by 0.3 dB on the built-in house."""
    radius: float = 0.8
    """Half the filter's width, output pixels, up to 1, the paper's. A narrower one blurs less: at
    0.8 predictions gain 0.15 dB on the built-in house and on photographs. From 0.5, so that every
    sub-sample in a pixel counts in it."""

    def __post_init__(self) -> None:
        for name, value, high in (
            ("density", self.density, 16),
            ("buffer_scale", self.buffer_scale, 8),
        ):
            if name == "density" and value == "adaptive":
                continue
            if check_integer("OffsetOptions", name, value, 2, high) % 2:
                raise InputError(f"OffsetOptions.{name} is {value}, expected an even number")
        check_integer("OffsetOptions", "largest", self.largest, 2, 128)
        check_integer("OffsetOptions", "offset_bits", self.offset_bits, 0, 4)
        check_number("OffsetOptions", "radius", self.radius, 0.5, 1.0)
        check_choice("OffsetOptions", "filter", self.filter, ("radial", "separable"))


@dataclass(frozen=True, slots=True)
class WarpOptions:
    """How references become a picture; checked when made. Every field has a sane default."""

    reconstruction: Reconstruction = "inverse"
    """"point", "splat", "mesh", "offset" or "inverse"."""
    visibility: Literal["order", "zbuffer"] = "order"
    """Within one reference: occlusion-compatible order, or comparing disparities, as "inverse"
    always does."""
    composite: Literal["blend", "nearest"] = "blend"
    """Across references: merge by disparity with weights, or the nearest over the farther."""
    fill: Literal["none", "background"] = "none"
    """Whether holes are filled, from the farther side; filled pixels are marked in the frame."""
    surface_tolerance: float = SURFACE_TOLERANCE
    """Relative difference in disparity up to which samples or layers show one surface."""
    splat: SplatOptions = SplatOptions()
    offset: OffsetOptions = OffsetOptions()

    def __post_init__(self) -> None:
        owner = "WarpOptions"
        check_choice(owner, "reconstruction", self.reconstruction, RECONSTRUCTIONS)
        check_choice(owner, "visibility", self.visibility, ("order", "zbuffer"))
        check_choice(owner, "composite", self.composite, ("blend", "nearest"))
        check_choice(owner, "fill", self.fill, ("none", "background"))
        check_number(owner, "surface_tolerance", self.surface_tolerance, 0.0, 1.0)
        for name, value, kind in (
            ("splat", self.splat, SplatOptions),
            ("offset", self.offset, OffsetOptions),
        ):
            if not isinstance(value, kind):
                raise InputError(
                    f"{owner}.{name} is a {type(value).__name__}, expected {kind.__name__}(...)"
                )


@dataclass(frozen=True, slots=True, eq=False)
class Passage:
    """One reference on its way to one desired view."""

    matrix: npt.NDArray[np.float64]
    """(3, 4) warp matrix."""
    tiles: npt.NDArray[np.int32]
    """(n, FIELDS) tiles that can land, in order."""
    options: WarpOptions
    color: npt.NDArray[Any]
    """(H, W, C) what the reconstructor reads: the view's own colour, or linear."""
    disparity: F4
    """(H, W) what it reads: the samples alone, or with small gaps bridged."""
    links: npt.NDArray[np.uint8]
    """(H, W) bits of `_edges`; empty for a reconstructor that joins no samples."""
    height: int
    """Rows of the whole desired view."""
    back: npt.NDArray[Any]
    """Geometry from the desired view to the reference, see `_landing`; between planes (12,)."""
    prepared: PreparedView
    """What the reference's view was prepared to."""

    @property
    def silhouettes(self) -> Silhouettes:
        """Of the reference; once they were asked for, they are at hand."""
        return self.prepared.silhouettes()

    @property
    def w(self) -> npt.NDArray[Any]:
        """(12,) the warp matrix for kernels."""
        return self.matrix.astype(np.float32).ravel()


@dataclass(frozen=True, slots=True, eq=False)
class Visibility:
    """What a band of the desired view sees of one reference."""

    sample: npt.NDArray[np.int32]
    """(rows, width) ``v * W + u`` of the reference sample; -1 where there is none."""
    disparity: F4
    """(rows, width) its warped disparity; -1 where there is none."""


Painter = Callable[[Passage, tuple[int, int], npt.NDArray[Any], F4, F4], None]
"""Paints a passage into rows [low, high): colour (rows, W, C), disparity (preset to -1), coverage.
A copying reconstructor leaves coverage alone: every painted pixel counts as covered."""


@dataclass(frozen=True, slots=True)
class Reconstructor:
    """One way to rebuild a continuous picture from moved samples."""

    paint: Painter
    averages: bool = False
    """Whether it mixes colours, and so reads and writes linear RGBA."""
    joins: bool = False
    """Whether it joins neighbouring samples, and so must know which share a surface."""
    together: bool = False
    """Whether it paints all references at once instead of a layer each; see `inverse`."""

    def pad(self, options: WarpOptions) -> int:
        """Pixels painted beyond where a sample lands."""
        if self.paint is _paint_splats:
            return options.splat.halo + 1
        return 2


def _scatter_band(passage: Passage, rows: tuple[int, int], width: int, halo: int) -> Visibility:
    """Which sample each cell of a band sees, with ``halo`` cells round it."""
    from belvedere.warp import _scatter

    shape = (rows[1] - rows[0] + 2 * halo, width + 2 * halo)
    sample = scratch("sample", shape, np.int32)
    disparity = scratch("disparity", shape, np.float32)
    sample.fill(-1)
    disparity.fill(-1.0)
    _scatter.scatter(
        passage.w,
        passage.disparity,
        passage.tiles,
        halo,
        rows[0] - halo,
        shape[1],
        shape[0],
        passage.height,
        passage.options.visibility == "order",
        sample.reshape(-1),
        disparity.reshape(-1),
    )
    return Visibility(sample, disparity)


def _gather_band(
    passage: Passage, seen: Visibility, color: npt.NDArray[Any], disparity: F4
) -> None:
    from belvedere.warp import _scatter

    disparity[:] = seen.disparity
    _scatter.gather(passage.color.reshape(-1, color.shape[2]), seen.sample, color)


def _paint_points(
    passage: Passage, rows: tuple[int, int], color: npt.NDArray[Any], disparity: F4, coverage: F4
) -> None:
    del coverage
    _gather_band(passage, _scatter_band(passage, rows, color.shape[1], 0), color, disparity)


def _paint_splats(
    passage: Passage, rows: tuple[int, int], color: npt.NDArray[Any], disparity: F4, coverage: F4
) -> None:
    from belvedere.warp import _scatter

    del coverage
    options, matrix = passage.options, passage.matrix
    halo, size = options.splat.halo, options.splat.size
    dets = float(np.linalg.det(matrix[:, :3])), float(np.linalg.det(matrix[:, [0, 1, 3]]))
    seen = _scatter_band(passage, rows, color.shape[1], halo)
    radius, reach = scratch("radius", seen.sample.shape, np.uint8), halo
    if size == "jacobian":
        reach = _scatter.measure_growth(
            passage.w, passage.disparity, *dets, seen.sample, halo, radius
        )
    else:
        radius.fill(halo)
    wide = Visibility(
        scratch("wide", disparity.shape, np.int32),
        scratch("wide disparity", disparity.shape, np.float32),
    )
    _scatter.spread(
        passage.w,
        passage.disparity,
        *dets,
        0 if size == "jacobian" else size,
        seen.sample,
        seen.disparity,
        radius,
        reach,
        halo,
        rows[0],
        options.surface_tolerance,
        wide.sample,
        wide.disparity,
    )
    _gather_band(passage, wide, color, disparity)


def _paint_mesh(
    passage: Passage, rows: tuple[int, int], color: npt.NDArray[Any], disparity: F4, coverage: F4
) -> None:
    from belvedere.warp import _mesh

    del coverage
    _mesh.draw_mesh(
        passage.w,
        passage.color,
        passage.disparity,
        passage.links,
        passage.tiles,
        rows[0],
        rows[1],
        passage.options.visibility == "order",
        color,
        disparity,
    )


def _paint_offset(
    passage: Passage, rows: tuple[int, int], color: npt.NDArray[Any], disparity: F4, coverage: F4
) -> None:
    from belvedere.warp import _offset, _offset_resolve

    options = passage.options.offset
    scale, bits = options.buffer_scale, options.offset_bits
    height, width = disparity.shape
    cells = (height * scale + scale, width * scale + scale)
    count = cells[0] * cells[1]
    cell_color = scratch("cell color", (count + 1, 4), np.float32)
    cell_word = scratch("cell word", (count + 1,), np.uint64)
    cell_word.fill(_offset.EMPTY)
    _offset.fill_offset_buffer(
        passage.w,
        passage.color,
        passage.disparity,
        passage.links,
        passage.tiles,
        rows[0],
        rows[1],
        passage.height,
        0 if options.density == "adaptive" else options.density,
        options.largest,
        scale,
        bits,
        passage.options.visibility == "order",
        passage.options.surface_tolerance,
        cells[1],
        cell_color,
        cell_word,
    )
    _offset_resolve.resolve_offset_buffer(
        cell_color[:count].reshape(*cells, 4),
        cell_word[:count].reshape(cells),
        filter_weights(options),
        scale,
        bits,
        passage.options.surface_tolerance,
        color,
        disparity,
        coverage,
    )


@lru_cache(maxsize=16)
def filter_weights(options: OffsetOptions) -> F4:
    """The (2 b 2^o, 2 b 2^o) raised-cosine table, at the resolution of the offsets.

    Source: Popescu and Lastra, section 3.6 (2^o where the pseudo-code prints o); spec
    offset-buffer-warping 3.6 for both readings.
    """
    count = 2 * options.buffer_scale << options.offset_bits
    distance = np.abs((np.arange(count) + 0.5) * 2.0 / count - 1.0) / options.radius
    if options.filter == "separable":
        row = 0.5 * (1.0 + np.cos(np.pi * np.minimum(distance, 1.0)))
        table = row[:, None] * row[None, :]
    else:
        reach = np.hypot(distance[:, None], distance[None, :]) / np.sqrt(2.0)
        table = 0.5 * (1.0 + np.cos(np.pi * np.minimum(reach, 1.0)))
    weights = table.astype(np.float32)
    weights.setflags(write=False)
    return weights


RECONSTRUCTORS: dict[str, Reconstructor] = {
    "point": Reconstructor(_paint_points),
    "splat": Reconstructor(_paint_splats),
    "mesh": Reconstructor(_paint_mesh, averages=True, joins=True),
    "offset": Reconstructor(_paint_offset, averages=True, joins=True),
    "inverse": Reconstructor(_paint_mesh, averages=True, joins=True, together=True),
}
