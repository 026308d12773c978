"""What a warp needs of a reference view, whatever the desired camera: computed once, kept."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer, check_number
from belvedere.ground.color import SRGB8_TO_LINEAR, encode_srgb8
from belvedere.ground.errors import ViewError
from belvedere.ground.threads import row_bands, run_parallel, thread_count
from belvedere.scene import Camera, CameraModel, ReferenceView
from belvedere.warp.manifold import central
from belvedere.warp.silhouettes import Silhouettes, find_silhouettes

if TYPE_CHECKING:
    from belvedere.warp.disagreement import Disagreement

EDGE_TOLERANCE = 0.05
"""Relative jump in disparity between neighbouring samples that is still one surface. Sensor noise
and creases stay below, depth edges of rooms and streets above (spec offset-buffer-warping 3.1)."""

BRIDGE = 3
"""Missing samples in a row that are bridged where both sides agree. Registered depth has seams of
one sample, and sensors specks of two or three."""
BRIDGE_PASSES = 2
"""The first closes seams, the second what is left where two seams cross."""


Copy = tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]
"""(h, w, 4) linear colour and (h, w) disparity of a smaller copy of a view."""
LARGEST_SHRINK = 32.0
"""Samples along the side of a pixel of the desired view up to which rims are wide enough for it."""
SMALLEST_COPY = 4
"""Samples along the shorter side of a copy at least."""


@dataclass(eq=False)
class PreparedView:
    """A reference view with its tile bounds, edges and linear colour.

    Made by `prepare`; `warp` accepts it wherever it accepts a view, and then skips that work. It
    holds the view's pixels as they were: prepare again after changing them.

    Memory: 4 bytes a sample for what `point` and `splat` scatter; for the others 5 for surfaces and
    edges, 16 for linear colour, 1.3 to compare references, and 7 for copies to shrink and 1 for
    each power of two by which it is shrunk. Each only once a reconstruction that needs it was used.
    """

    view: ReferenceView
    camera: CameraModel
    tile_low: npt.NDArray[np.float32]
    """(tiles down, tiles across) smallest disparity of each tile."""
    tile_high: npt.NDArray[np.float32]
    """The largest; below the smallest where a tile has no sample."""
    edge_tolerance: float = EDGE_TOLERANCE
    bridge: int = BRIDGE
    _surface: npt.NDArray[np.float32] | None = field(default=None, repr=False)
    _links: npt.NDArray[np.uint8] | None = field(default=None, repr=False)
    _surface_range: tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]] | None = field(
        default=None, repr=False
    )
    _linear: npt.NDArray[np.float32] | None = field(default=None, repr=False)
    _carried: npt.NDArray[np.uint32] | None = field(default=None, repr=False)
    _silhouettes: Silhouettes | None = field(default=None, repr=False)
    _copies: tuple[Copy, ...] = field(default=(), init=False, repr=False)
    _wide_links: dict[int, npt.NDArray[np.uint8]] = field(
        default_factory=dict, init=False, repr=False
    )
    _brightness: dict[int, npt.NDArray[np.float32]] = field(
        default_factory=dict, init=False, repr=False
    )
    compared: WeakKeyDictionary[PreparedView, Disagreement] = field(
        default_factory=WeakKeyDictionary, init=False, repr=False
    )
    """How this reference shows what others see; see `reconcile`."""

    def __getstate__(self) -> dict[str, Any]:
        """All but what is known of other views, which do not travel along."""
        return {name: value for name, value in self.__dict__.items() if name != "compared"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state, compared=WeakKeyDictionary())

    @property
    def color(self) -> npt.NDArray[Any]:
        """(H, W, C) as the view has it."""
        return self.view.color

    @property
    def disparity(self) -> npt.NDArray[np.float32]:
        """(H, W)."""
        return self.view.disparity

    @property
    def features(self) -> npt.NDArray[np.float32] | None:
        """(H, W, C), or None."""
        return self.view.features

    @cached_property
    def features_whole(self) -> bool:
        """Whether every sample has features."""
        return self.features is not None and not bool(np.isnan(self.features[..., 0]).any())

    @cached_property
    def edge_planes(self) -> npt.NDArray[np.float64]:
        """(4, 3) the sides of a planar camera's pyramid; see `Camera.edge_planes`."""
        assert isinstance(self.camera, Camera)
        return self.camera.edge_planes

    @cached_property
    def middle(self) -> npt.NDArray[np.float64]:
        """(3,) the direction of the middle of a planar camera's picture."""
        assert isinstance(self.camera, Camera)
        width, height = self.camera.width, self.camera.height
        return self.camera.matrix @ np.array([(width - 1) / 2.0, (height - 1) / 2.0, 1.0])

    def surface(self, threads: int | None = None) -> npt.NDArray[np.float32]:
        """(H, W) disparity with small gaps inside a surface bridged (see `prepare`)."""
        if self._surface is None:
            surface = self.disparity
            if self.bridge > 0 and bool(np.isnan(surface).any()):
                for _ in range(BRIDGE_PASSES):
                    surface = self._bridged(surface, threads)
            self._surface = surface  # once it is whole: another thread may be warping this view
        return self._surface

    def _bridged(
        self, disparity: npt.NDArray[np.float32], threads: int | None
    ) -> npt.NDArray[np.float32]:
        from belvedere.warp import _bridging

        out = np.empty(disparity.shape, np.float32)

        def bridge(band: tuple[int, int]) -> None:
            _bridging.bridge_gaps(disparity, self.bridge, self.edge_tolerance, *band, out)

        run_parallel(bridge, row_bands(disparity.shape[0], thread_count(threads)), threads)
        return out

    def links(self, threads: int | None = None) -> npt.NDArray[np.uint8]:
        """(H, W) which neighbours share a surface; bits RIGHT, DOWN, MIXED of `_edges`."""
        if self._links is None:
            from belvedere.warp import _edges, _marks

            disparity = self.surface(threads)
            out = np.empty(disparity.shape, np.uint8)
            bands = row_bands(disparity.shape[0], thread_count(threads))

            def link(band: tuple[int, int]) -> None:
                _edges.link_samples(disparity, self.edge_tolerance, *band, out)

            def mark(band: tuple[int, int]) -> None:
                _marks.mark_mixed(disparity, *band, out)

            run_parallel(link, bands, threads)
            run_parallel(mark, bands, threads)
            run_parallel(lambda band: _marks.mark_intact(*band, out), bands, threads)
            run_parallel(lambda band: _marks.mark_smooth(*band, out), bands, threads)
            self._mark_rims(out, _marks.REACH, threads)
            self._links = out
        return self._links

    def _mark_rims(self, links: npt.NDArray[np.uint8], reach: int, threads: int | None) -> None:
        from belvedere.warp import _marks

        disparity = self.surface(threads)
        run_parallel(
            lambda band: _marks.mark_rims(disparity, self.edge_tolerance, reach, *band, links),
            row_bands(disparity.shape[0], thread_count(threads)),
            threads,
        )

    def wide_links(self, shrink: float, threads: int | None = None) -> npt.NDArray[np.uint8]:
        """`links` whose rims are as wide as pixels of a view that shrinks this one need.

        Args:
            shrink: samples along the side of such a pixel, at least 1.
            threads: how many to use.
        """
        from belvedere.warp import _marks

        reach = _marks.REACH << math.ceil(math.log2(min(shrink, LARGEST_SHRINK)))
        if reach not in self._wide_links:
            links = self.links(threads).copy()
            self._mark_rims(links, reach, threads)
            self._wide_links[reach] = links
        return self._wide_links[reach]

    def surface_range(
        self, threads: int | None = None
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        """As ``tile_low`` and ``tile_high``, but of the surfaces that join samples."""
        if self._surface_range is None:
            from belvedere.warp import _ranges

            disparity, links = self.surface(threads), self.links(threads)
            low, high = np.empty_like(self.tile_low), np.empty_like(self.tile_high)
            samples = self.tile_low, self.tile_high
            if disparity is not self.disparity:
                samples = sample_range(disparity)

            def measure(band: tuple[int, int]) -> None:
                _ranges.surface_range(disparity, links, *samples, *band, low, high)

            run_parallel(measure, row_bands(low.shape[0], thread_count(threads)), threads)
            self._surface_range = low, high
        return self._surface_range

    def linear(self, threads: int | None = None) -> npt.NDArray[np.float32]:
        """(H, W, 4) linear ``float32`` colour; the fourth channel is alpha, or 0 without one."""
        if self._linear is None:
            self._linear = linear_rgba(self.color, threads)
        return self._linear

    def carried(self, threads: int | None = None) -> npt.NDArray[np.uint32]:
        """(H, W) what a scattered sample takes along: its bytes, or its number among floats."""
        if self._carried is None:
            from belvedere.warp import _scatter

            shape = self.disparity.shape
            if self.color.dtype == np.uint8:
                out = np.empty(shape, np.uint32)

                def pack(band: tuple[int, int]) -> None:
                    _scatter.pack_bytes(self.color[slice(*band)], out[slice(*band)])

                run_parallel(pack, row_bands(shape[0], thread_count(threads)), threads)
            else:
                out = np.arange(shape[0] * shape[1], dtype=np.uint32).reshape(shape)
            self._carried = out
        return self._carried

    def silhouettes(self, threads: int | None = None) -> Silhouettes:
        """Where surfaces end between samples, and colours that no longer mix two of them."""
        if self._silhouettes is None:
            # linear colour that nobody asked for yet is un-mixed in place
            own = self._linear is None and self.color.dtype == np.uint8
            linear = linear_rgba(self.color, threads) if own else self.linear(threads).copy()
            self._silhouettes = find_silhouettes(
                linear, self.surface(threads), self.links(threads), threads
            )
        return self._silhouettes

    def copies(self, threads: int | None = None) -> tuple[Copy, ...]:
        """The view, and copies of it, each half of the one before; see `_shrink`.

        None at all of a view that is smaller than `SMALLEST_COPY`.
        """
        if not self._copies:
            from belvedere.warp import _shrink

            copies = [(self.silhouettes(threads).color, self.surface(threads))]
            while min(copies[-1][1].shape) >= 2 * SMALLEST_COPY:
                color, disparity = copies[-1]
                height, width = (-(-side // 2) for side in disparity.shape)
                half = np.empty((height, width, 4), np.float32)
                depth = np.empty((height, width), np.float32)
                _shrink.halve_surfaces(
                    color, disparity, self.edge_tolerance * len(copies), half, depth
                )
                copies.append((half, depth))
            self._copies = tuple(copies) if min(copies[0][1].shape) >= SMALLEST_COPY else ()
        return self._copies

    def has_surface(self, silhouettes: bool) -> bool:
        """Whether `find_surface` has nothing left to do."""
        return self._surface_range is not None and not (silhouettes and self._silhouettes is None)

    def find_surface(self, silhouettes: bool, threads: int | None = None) -> None:
        """Do what reconstructors that join samples need, and with silhouettes what `inverse` does.

        That is all but what it takes to compare references.
        """
        self.surface_range(threads)
        if silhouettes:
            self.silhouettes(threads)

    def brightness(self, threads: int | None = None) -> dict[int, npt.NDArray[np.float32]]:
        """Roots of mean radiance of 2 x 2, 4 x 4 and 8 x 8 samples, by the side of the square.

        NaN where an edge is near.
        """
        if not self._brightness:
            from belvedere.warp import _compare

            color, links = self.silhouettes(threads).color, self.links(threads)
            half = np.empty((color.shape[0] // 2, color.shape[1] // 2), np.float32)
            run_parallel(
                lambda band: _compare.halve_color(
                    color[2 * band[0] : 2 * band[1]],
                    links[2 * band[0] : 2 * band[1]],
                    half[slice(*band)],
                ),
                row_bands(half.shape[0], thread_count(threads)),
                threads,
            )
            images = {2: half}
            for size in (4, 8):
                finer = images[size // 2]
                images[size] = np.empty((finer.shape[0] // 2, finer.shape[1] // 2), np.float32)
                _compare.halve(finer, images[size])
            self._brightness = images
        return self._brightness


def halved(view: ReferenceView | PreparedView, threads: int | None = None) -> ReferenceView:
    """A view with half the samples across and down, the mean of four of one surface each.

    For desired views so far away that all samples would be wasted. Colours are ``float32`` linear
    where the view's are, else ``uint8``; an odd last row or column is left out.

    Raises:
        ViewError: fewer than 8 samples across or down, or not a planar camera.
    """
    prepared = prepare(view)
    camera, (height, width) = prepared.camera, prepared.disparity.shape
    if not isinstance(camera, Camera):
        raise ViewError(f"halved takes views of a planar Camera, not of {type(camera).__name__}")
    copies = prepared.copies(threads)
    if len(copies) < 2:
        raise ViewError(f"a view of {width} x {height} samples is too small to be halved")
    color, disparity = (part[: height // 2, : width // 2] for part in copies[1])
    color = color[..., : prepared.color.shape[2]]
    if prepared.color.dtype == np.uint8:
        color = encode_srgb8(color)
    grid = np.array([[2.0, 0.0, 0.5], [0.0, 2.0, 0.5], [0.0, 0.0, 1.0]])
    half = Camera(camera.matrix @ grid, camera.center, width // 2, height // 2)
    return ReferenceView(half, np.ascontiguousarray(color), np.ascontiguousarray(disparity))


def prepare(
    view: ReferenceView | PreparedView,
    edge_tolerance: float = EDGE_TOLERANCE,
    bridge: int = BRIDGE,
) -> PreparedView:
    """Do once what warps of the same view would repeat.

    Args:
        view: a reference view with a planar camera, a cylinder or a sphere; a prepared one is
            returned as it is.
        edge_tolerance: relative jump in disparity that still counts as one surface.
        bridge: missing samples in a row that "gaussian", "mesh", "offset" and "inverse" take
            to lie on the surface round them, if both ends agree; 0 leaves every gap open. "point"
            and "splat" show samples only.

    Raises:
        InputError: a negative tolerance or bridge.
        CameraError: the view's camera is orthographic.
        ViewError: it is no reference view.
    """
    if isinstance(view, PreparedView):
        return view
    if not isinstance(view, ReferenceView):
        raise ViewError(
            f"prepare.view is a {type(view).__name__}, expected a ReferenceView "
            "(a Frame becomes one with as_view())"
        )
    check_number("prepare", "edge_tolerance", edge_tolerance, 0.0, 1.0)
    check_integer("prepare", "bridge", bridge, 0, 64)
    camera = central(view.camera, "reference")
    if not isinstance(camera, Camera):
        from belvedere.warp.panoramas import prepare_panorama

        return prepare_panorama(view, edge_tolerance, bridge)
    low, high = sample_range(view.disparity)
    return PreparedView(view, camera, low, high, edge_tolerance, bridge)


def sample_range(
    disparity: npt.NDArray[np.float32],
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """(tiles down, tiles across) the smallest and largest disparity in each tile and round it."""
    from belvedere.warp import _tiles

    shape = tuple(-(-side // _tiles.TILE) for side in disparity.shape)
    low, high = np.empty(shape, np.float32), np.empty(shape, np.float32)
    _tiles.disparity_range(disparity, low, high)
    return low, high


def linear_rgba(color: npt.NDArray[Any], threads: int | None = None) -> npt.NDArray[np.float32]:
    """(H, W, 4) linear ``float32`` of (H, W, 3|4) ``uint8`` sRGB or ``float32`` linear colour."""
    if color.dtype == np.float32 and color.shape[2] == 4:
        return color
    out = np.empty((*color.shape[:2], 4), np.float32)
    if color.dtype == np.float32:
        out[..., :3] = color
        out[..., 3] = 0.0
        return out
    from belvedere.warp import _compose

    def decode(band: tuple[int, int]) -> None:
        rows = slice(*band)
        _compose.decode(color[rows], SRGB8_TO_LINEAR, out[rows])

    run_parallel(decode, row_bands(color.shape[0], thread_count(threads)), threads)
    return out
