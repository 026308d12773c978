"""The reconstructors: how samples that have moved become a picture again.

Each either paints one reference into one band of the desired view, in linear radiance, or scatters
samples as they are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_choice, check_integer, check_number
from belvedere.ground.errors import InputError
from belvedere.ground.scratch import scratch
from belvedere.warp.features import FEATURE_FILTERS, FeatureFilter
from belvedere.warp.prepare import Copy, PreparedView
from belvedere.warp.silhouettes import Silhouettes

F4 = npt.NDArray[np.float32]

Reconstruction = Literal["point", "splat", "gaussian", "mesh", "offset", "inverse"]
RECONSTRUCTIONS: tuple[Reconstruction, ...] = (
    "point", "splat", "gaussian", "mesh", "offset", "inverse"
)  # fmt: skip

GAUSSIAN_HALO = 7
"""Pixels round a tile's bounds that its Gaussian footprints may paint. The bounds know of one
reference pixel round the samples already; the tails beyond it weigh a tenth at most."""

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
class GaussianOptions:
    """Footprints of `gaussian`: round in the reference, ellipses in the desired view."""

    sigma: float = 0.5
    """Standard deviation, reference pixels, 0.4 to 1: wider is smoother, narrower ripples."""
    cut: float = 1.5
    """Radius at which it ends, reference pixels, 1.5 to 3: from there on neighbours overlap enough
    that footprints blurred by `low_pass` reach the middle of a pixel, however small they are."""
    low_pass: float = 0.25
    """Variance added along both axes of the desired view, in squared pixels and for a variance of
    one squared reference pixel, 0.25 to 1: blurs what a smaller picture could not show."""

    def __post_init__(self) -> None:
        owner = "GaussianOptions"
        check_number(owner, "sigma", self.sigma, 0.4, 1.0)
        check_number(owner, "cut", self.cut, 1.5, 3.0)
        check_number(owner, "low_pass", self.low_pass, 0.25, 1.0)


@dataclass(frozen=True, slots=True)
class OffsetOptions:
    """Lattice and filter of `offset` (Popescu and Lastra's a, b, o)."""

    density: int | Literal["adaptive"] = "adaptive"
    """Sub-samples per reference pixel and axis: even, the paper's a = b c for growth up to c; or
    "adaptive": what each row of cells needs, so that nothing shows through. Where a surface goes on
    all round and the reference is not twice as fine as the picture, about one a pixel tells what
    it sees, and its colour is looked up at its own centre: sharper, by 0.2 to 0.6 dB on the
    built-in house, and faster. The filter is left for edges and for what shrinks."""
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
    front_filter: bool = False
    """Leave out cells that see a surface behind what two opposite neighbours of theirs see. With a
    fixed density that is too small it is background shining through; an adaptive one leaves none,
    and the filter then only closes true slits half a pixel wide (0.04 dB in the built-in house)."""

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
        if not isinstance(self.front_filter, bool):
            raise InputError(
                f"OffsetOptions.front_filter is {self.front_filter!r}, expected True or False"
            )


@dataclass(frozen=True, slots=True)
class WarpOptions:
    """How references become a picture; checked when made. Every field has a sane default."""

    reconstruction: Reconstruction = "inverse"
    """"point", "splat", "gaussian", "mesh", "offset" or "inverse"."""
    visibility: Literal["order", "zbuffer"] = "order"
    """Within one reference: occlusion-compatible order, or comparing disparities, as
    "gaussian", "offset" and "inverse" always do."""
    composite: Literal["blend", "nearest", "fuzzy"] = "blend"
    """Across references: merge by disparity with weights; the nearest over the farther; or one
    for each pixel, the nearest unless another's surface lies clearly in front of its own, by
    ``surface_tolerance`` (0: the hard z-buffer)."""
    fill: Literal["none", "background"] = "none"
    """Whether holes are filled, from the farther side; filled pixels are marked in the frame."""
    surface_tolerance: float = SURFACE_TOLERANCE
    """Relative difference in disparity up to which samples or layers show one surface."""
    reconcile: bool = True
    """Whether planar references that disagree, by some pixels or in exposure, are brought to their
    mean first; "inverse" does, see `reconcile`."""
    splat: SplatOptions = SplatOptions()
    gaussian: GaussianOptions = GaussianOptions()
    offset: OffsetOptions = OffsetOptions()
    feature_filter: FeatureFilter = "cubic"
    """How features are looked up between samples: "cubic", "linear", or "nearest", which never
    mixes two samples or two references: for labels."""
    explain: bool = False
    """Whether the frame comes with its `Explanation`; see `explain`."""

    def __post_init__(self) -> None:
        owner = "WarpOptions"
        check_choice(owner, "reconstruction", self.reconstruction, RECONSTRUCTIONS)
        check_choice(owner, "visibility", self.visibility, ("order", "zbuffer"))
        check_choice(owner, "composite", self.composite, ("blend", "nearest", "fuzzy"))
        check_choice(owner, "fill", self.fill, ("none", "background"))
        check_choice(owner, "feature_filter", self.feature_filter, FEATURE_FILTERS)
        for name, value in (("explain", self.explain), ("reconcile", self.reconcile)):
            if not isinstance(value, bool):
                raise InputError(f"{owner}.{name} is {value!r}, expected True or False")
        check_number(owner, "surface_tolerance", self.surface_tolerance, 0.0, 1.0)
        for name, value, kind in (
            ("splat", self.splat, SplatOptions),
            ("gaussian", self.gaussian, GaussianOptions),
            ("offset", self.offset, OffsetOptions),
        ):
            if not isinstance(value, kind):
                raise InputError(
                    f"{owner}.{name} is a {type(value).__name__}, expected {kind.__name__}(...)"
                )

    @property
    def merge_ratio(self) -> float | None:
        """How many times larger a later reference's disparity must be to replace an earlier's.

        None: they are blended. Source: spec offset-buffer-warping 3.4.
        """
        ratios = {"blend": None, "nearest": float("inf"), "fuzzy": 1.0 + self.surface_tolerance}
        return ratios[self.composite]


@dataclass(frozen=True, slots=True, eq=False)
class Passage:
    """One reference on its way to one desired view."""

    matrix: npt.NDArray[np.float64]
    """(3, 4) warp matrix."""
    tiles: npt.NDArray[np.int32]
    """(n, FIELDS) tiles that can land, in order."""
    options: WarpOptions
    color: npt.NDArray[Any]
    """(H, W, C) what the reconstructor reads: linear colour, or the view's own where it scatters
    that or reads the silhouettes'."""
    disparity: F4
    """(H, W) what it reads: the samples alone, or with small gaps bridged."""
    links: npt.NDArray[np.uint8]
    """(H, W) bits of `_edges`; empty for a reconstructor that joins no samples."""
    height: int
    """Rows of the whole desired view."""
    back: npt.NDArray[Any]
    """Geometry from the desired view to the reference, see `_landing`; between planes (12,). Empty
    for who needs none."""
    prepared: PreparedView
    """What the reference's view was prepared to."""
    runs: npt.NDArray[np.int32]
    """(n, RUN) tiles that stand side by side, for who scatters; see `_tiles.list_runs`."""
    gain: float = field(default=1.0, kw_only=True)
    """Factor of its linear colours, so that references are exposed alike."""
    copies: tuple[Copy, ...] = field(default=(), kw_only=True)
    """The reference and smaller copies of it, if the desired view shrinks it."""
    layer: int = field(default=-1, kw_only=True)
    """Number of the layer of `inverse` that it is drawn to, if references share layers; see
    `joint.shared_layers`."""
    columns: tuple[int, int] = field(default=(0, 1 << 30), kw_only=True)
    """First column of the desired view that it can reach, and the one after the last."""

    @property
    def silhouettes(self) -> Silhouettes:
        """Of the reference; once they were asked for, they are at hand."""
        return self.prepared.silhouettes()

    @property
    def w(self) -> npt.NDArray[Any]:
        """(12,) the warp matrix for kernels."""
        return self.matrix.astype(np.float32).ravel()


Painter = Callable[[Passage, tuple[int, int], npt.NDArray[Any], F4, F4], None]
"""Paints a passage into rows [low, high): linear colour (rows, W, 4), disparity (preset to -1),
coverage (preset to 1)."""


@dataclass(frozen=True, slots=True)
class Reconstructor:
    """One way to rebuild a continuous picture from moved samples."""

    paint: Painter | None
    """None for one that scatters, or paints all references together."""
    joins: bool = False
    """Whether it joins neighbouring samples, and so must know which share a surface."""
    together: bool = False
    """Whether it paints all references at once instead of a layer each; see `inverse`."""
    paints_all: bool = False
    """Whether it writes every pixel, holes too, so that nothing need be preset."""
    halo: Callable[[WarpOptions], int] = lambda options: 1
    """Pixels that a sample can paint beyond the one it lands in."""

    @property
    def scatters(self) -> bool:
        """Whether it moves samples whole and copies their colours; see `scatter`."""
        return self.paint is None and not self.together


def _paint_gaussians(
    passage: Passage, rows: tuple[int, int], color: npt.NDArray[Any], disparity: F4, coverage: F4
) -> None:
    from belvedere.warp import _gaussian

    options, tolerance = passage.options.gaussian, passage.options.surface_tolerance
    front, rim, weight = (
        scratch(f"gaussian {name}", disparity.shape, np.float32)
        for name in ("front", "rim", "weight")
    )
    front.fill(-1.0)
    rim.fill(-1.0)
    weight.fill(0.0)
    samples = passage.disparity, passage.links, passage.tiles, *rows, options.low_pass
    _gaussian.find_front(passage.w, *samples, options.cut, front, rim)
    _gaussian.accumulate(
        passage.w,
        passage.color,
        *samples,
        footprint_weights(options),
        options.cut,
        tolerance,
        front.reshape(-1),
        color,
        weight.reshape(-1),
    )
    _gaussian.resolve(weight, front, color, disparity, coverage)


@lru_cache(maxsize=16)
def footprint_weights(options: GaussianOptions) -> F4:
    """Weights over the square of the radius, and 0 beyond the cut; a lattice's sum to 1.

    Source: spec image-warping 3.7.
    """
    from belvedere.warp._gaussian import WEIGHTS

    two_variances = 2.0 * options.sigma**2
    square = (np.arange(WEIGHTS) + 0.5) * options.cut**2 / WEIGHTS
    whole = np.pi * two_variances * -np.expm1(-(options.cut**2) / two_variances)
    weights = np.zeros(WEIGHTS + 1, np.float32)
    weights[:-1] = np.exp(-square / two_variances) / whole
    weights.setflags(write=False)
    return weights


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
    from belvedere.warp import _offset, _offset_front, _offset_resolve, _offset_word

    options = passage.options.offset
    scale, tolerance = options.buffer_scale, passage.options.surface_tolerance
    layout = _offset_word.word_layout(options.offset_bits, tolerance, *passage.disparity.shape)
    height, width = disparity.shape
    density = 0 if options.density == "adaptive" else options.density
    halo = 1 if options.front_filter else 0  # rows of cells that only the filter looks at
    cells = ((height + 2) * scale + 2 * halo, (width + 2) * scale)
    count = cells[0] * cells[1]
    words = scratch("cell word", (count + 1,), np.uint64)
    words.fill(_offset_word.EMPTY)
    _offset.fill_offset_buffer(
        passage.w,
        passage.disparity,
        passage.links,
        passage.tiles,
        rows[0] * scale - halo,
        passage.height,
        density,
        options.largest,
        scale,
        layout,
        cells[1],
        words,
    )
    grid = words[:count].reshape(cells)
    if options.front_filter:
        _offset_front.drop_leaks(
            grid, layout, tolerance, scratch("cell rows", (3, cells[1]), np.float32)
        )
    _offset_resolve.resolve_offset_buffer(
        passage.w,
        passage.disparity,
        grid[halo : cells[0] - halo],
        passage.color,
        passage.links,
        block_weights(options),
        *cubic_weights(_offset_word.IN_CELL),
        layout,
        scale,
        tolerance,
        density == 0,
        rows[0],
        scratch("above color", (width, 4), np.float32),
        scratch("above", (width, 4), np.float32),
        scratch("wide color", (3, width + 2, 4), np.float32),
        scratch("wide disparity", (3, width + 2), np.float32),
        color,
        disparity,
        coverage,
    )


@lru_cache(maxsize=16)
def block_weights(options: OffsetOptions) -> F4:
    """(b b 2^2o, 4) `filter_weights` of each place of each cell of a block in its four pixels.

    Places as cells number them: see `_offset_word.mark`.
    """
    scale, places = options.buffer_scale, 1 << options.offset_bits
    table = filter_weights(options).reshape(2, scale, places, 2, scale, places)
    # the pixel above a block has it in the lower half of its filter, the pixel left in the right
    corners = table[::-1, :, :, ::-1].transpose(1, 4, 2, 5, 0, 3)
    weights = np.ascontiguousarray(corners).reshape(scale, scale, places * places, 4)
    odd = np.indices((scale, scale)).sum(axis=0) % 2 == 1
    weights[odd] = weights[odd][:, ::-1]  # there places are numbered from the other end
    weights = weights.reshape(-1, 4)
    weights.setflags(write=False)
    return weights


@lru_cache(maxsize=2)
def cubic_weights(bits: int) -> tuple[F4, F4]:
    """Weights of the samples at -1, 0, 1, 2 at each of 2^bits places between 0 and 1.

    Catmull and Rom's cubic: it passes through the samples and keeps quadratics.

    Returns:
        (2^bits, 16) each weight four times, and (2^bits, 4) each once.
    """
    f = np.arange(1 << bits) / (1 << bits)
    table = np.stack(
        [
            0.5 * f * (f * (2 - f) - 1),
            0.5 * (f * f * (3 * f - 5) + 2),
            0.5 * f * (f * (4 - 3 * f) + 1),
            0.5 * f * f * (f - 1),
        ],
        axis=1,
    ).astype(np.float32)
    spread = np.repeat(table, 4, axis=1)
    table.setflags(write=False)
    spread.setflags(write=False)
    return spread, table


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
    "point": Reconstructor(None),
    "splat": Reconstructor(None, halo=lambda options: options.splat.halo),
    "gaussian": Reconstructor(_paint_gaussians, joins=True, halo=lambda options: GAUSSIAN_HALO),
    "mesh": Reconstructor(_paint_mesh, joins=True),
    "offset": Reconstructor(_paint_offset, joins=True, paints_all=True),
    "inverse": Reconstructor(None, joins=True, together=True),
}
