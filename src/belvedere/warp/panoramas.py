"""Warps with a panorama at either end: what `warp` does differently then, and nothing else.

Points and splats are scattered in the order of `order_key`, or by comparing disparities; the
inverse pass is the one of planes with other kernels (`_surface_any`, `_landing`). A desired
panorama is painted a little beyond its seam on both sides, so that pixels there have neighbours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import InputError
from belvedere.ground.scratch import scratch
from belvedere.ground.threads import row_bands, run_parallel, thread_count
from belvedere.scene import Camera, CameraModel, ReferenceView
from belvedere.warp.inverse import HALO, paint_inverse
from belvedere.warp.manifold import (
    SeamlessCamera,
    check_planar,
    direction_frame,
    geometry,
    is_panoramic,
    own_samples,
    passage_matrix,
    seamless,
    unrolled,
)
from belvedere.warp.prepare import PreparedView
from belvedere.warp.reconstruct import RECONSTRUCTORS, Passage, Reconstructor, WarpOptions
from belvedere.warp.silhouettes import Parts, Silhouettes

F4 = npt.NDArray[np.float32]
F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]

TASKS_PER_THREAD = 4


@dataclass(eq=False)
class PreparedPanorama(PreparedView):
    """A prepared view that goes on beyond its seam and poles; see `manifold.seamless`.

    Memory: a copy of the view beside what any prepared view holds.
    """

    original: ReferenceView | None = None
    """The view as it was given, kept alive: `Warper` knows views by their identity."""

    def silhouettes(self, threads: int | None = None) -> Silhouettes:
        """As `PreparedView.silhouettes`, the parts of one turn only, and the caps of the poles."""
        if self._silhouettes is None:
            whole = super().silhouettes(threads)
            assert isinstance(self.camera, SeamlessCamera)
            parts = _own_parts(whole.parts, self.surface(threads), self.links(threads), self.camera)
            self._silhouettes = Silhouettes(whole.color, parts)
        return self._silhouettes


@dataclass(frozen=True, slots=True, eq=False)
class BentPassage(Passage):
    """A passage with a panorama at either end."""

    ahead: F8 = field(default_factory=lambda: np.empty(0))
    """Geometry from the reference to the desired view; see `_landing`."""
    margin: int = 0
    """Columns that the desired view is painted beyond its seam on both sides."""
    samples: Samples | None = None
    """For the reconstructors that scatter."""

    @property
    def w(self) -> F8:
        """The geometry, where a passage between planes has its matrix."""
        return self.ahead


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Where all samples of one reference land."""

    own: tuple[int, int, int, int]
    """First row, row after the last, first column, column after the last of what is scattered."""
    cells: I4
    """(n,) pixel each lands in, -1 outside the desired view."""
    places: F4
    """(3, n) x, y, warped disparity."""
    order: I4
    """(n,) occlusion-compatible; empty when disparities are compared."""
    halves: F4
    """(n,) half the side of each splat, or (1,) of all."""


def prepare_panorama(view: ReferenceView, edge_tolerance: float, bridge: int) -> PreparedPanorama:
    """`prepare` for a cylinder or a sphere; its arguments checked."""
    if view.features is not None:
        check_planar("features are warped", view.camera, [])
    whole = seamless(view)
    none = np.empty((0, 0), np.float32)  # tiles are bounded by what they draw, see `_own_tiles`
    return PreparedPanorama(whole, whole.camera, none, none, edge_tolerance, bridge, original=view)


def reconstructor_of(passage: Passage) -> Reconstructor:
    """How a passage is painted."""
    known = PANORAMIC if isinstance(passage, BentPassage) else RECONSTRUCTORS
    return known[passage.options.reconstruction]


def refuse_for_panoramas(options: WarpOptions, cameras: Sequence[CameraModel]) -> None:
    """Say which reconstructions a warp with a panorama has.

    Raises:
        InputError: one that goes between planar cameras only.
    """
    if options.reconstruction in PANORAMIC or all(isinstance(one, Camera) for one in cameras):
        return
    named = " or ".join(f'"{name}"' for name in PANORAMIC)
    raise InputError(
        f'warp.reconstruction "{options.reconstruction}" goes between planar cameras only: with a '
        f"cylinder or a sphere among the cameras choose {named}"
    )


def _own_parts(parts: Parts, surface: F4, links: Any, camera: SeamlessCamera) -> Parts:
    """The parts of a seamless picture whose cells are the panorama's own, and its polar caps."""
    from belvedere.warp import _tiles

    rows, columns = own_samples(camera)
    middle = np.floor(parts.corners.reshape(4, 3, -1)[:, :2].mean(axis=0)).astype(int)
    own = (middle[0] >= columns.start) & (middle[0] < columns.stop)
    if camera.rows:
        own &= (middle[1] >= rows.start) & (middle[1] < rows.stop - 1)
    tile = np.searchsorted(parts.ends.ravel(), np.arange(own.size), side="right")[own]
    corners, near = parts.corners[:, own], parts.near[own]
    for row in (rows.start, rows.stop - 1) if camera.rows and rows.stop - rows.start > 1 else ():
        cap, kind, column = _cap(surface, links, camera, row)
        cell_row = min(row, rows.stop - 2)
        tile = np.concatenate(
            [tile, cell_row // _tiles.TILE * parts.ends.shape[1] + column // _tiles.TILE]
        )
        corners, near = np.hstack([corners, cap]), np.concatenate([near, kind])
    order = np.argsort(tile, kind="stable")
    ends = np.cumsum(np.bincount(tile, minlength=parts.ends.size)).astype(np.int32)
    return Parts(
        np.ascontiguousarray(corners[:, order]), near[order], ends.reshape(parts.ends.shape)
    )


def _cap(
    surface: F4, links: Any, camera: SeamlessCamera, row: int
) -> tuple[F4, npt.NDArray[np.uint8], npt.NDArray[np.int64]]:
    """Triangles from a sphere's first or last row to its pole.

    Where the whole row is one surface, so is the cap: a plane ``n . D`` has at the pole the mean of
    its disparities on a circle round it, over the cosine of the circle's radius. Else every sample
    owns its sector.

    Returns:
        (12, n) corners; (n,) sides as parts have them; (n,) columns.
    """
    from belvedere.warp import _edges, _surface_any

    columns = own_samples(camera)[1]
    u = np.arange(columns.start, columns.stop)
    top = row == camera.rows
    pole = row - 0.5 if top else row + 0.5
    held, bits = surface[row, u], links[row, u]
    whole = bool(np.all(bits & _edges.RIGHT)) and not bool(np.any(bits & _edges.MIXED))
    if whole:
        left, right = u, u + 1
        low, high = surface[row, u], surface[row, u + 1]
        tip = np.full(
            u.size, held.mean(dtype=np.float64) / np.cos(0.5 * np.pi / camera.base.height)
        )
        kind = np.full(u.size, _surface_any.CAP, np.uint8)
    else:
        u = u[~np.isnan(held) & ((bits & _edges.MIXED) == 0)]
        left, right = u - 0.5, u + 0.5
        low = high = tip = surface[row, u]
        kind = np.zeros(u.size, np.uint8)
    rim = ((left, np.full(u.size, float(row)), low), (right, np.full(u.size, float(row)), high))
    apex = ((0.5 * (left + right), np.full(u.size, pole), tip),) * 2
    corners = np.array([*apex, *rim] if top else [*rim, *apex], np.float32)
    return corners.reshape(12, -1), kind, u


def bent_passage(
    prepared: PreparedView, desired: CameraModel, options: WarpOptions, threads: int | None
) -> BentPassage:
    """Everything that painting one reference into a view needs, with a panorama at either end."""
    joins = PANORAMIC[options.reconstruction].joins
    margin = HALO if joins and is_panoramic(desired) else 0
    if margin:
        desired = unrolled(desired, margin)
    ahead = geometry(prepared.camera, desired)
    return BentPassage(
        passage_matrix(prepared.camera, desired),
        _own_tiles(prepared, ahead, desired.height, threads)
        if joins
        else np.empty((0, 8), np.int32),
        options,
        prepared.color if joins else prepared.linear(threads),
        prepared.surface(threads) if joins else prepared.disparity,
        prepared.links(threads) if joins else np.empty((0, 0), np.uint8),
        desired.height,
        geometry(desired, prepared.camera),
        prepared,
        np.empty((0, 0), np.int32),
        ahead,
        margin,
        None if joins else _land(prepared, desired, ahead, options, threads),
    )


def _own_tiles(prepared: PreparedView, ahead: F8, height: int, threads: int | None) -> I4:
    """(n, FIELDS) tiles of what is a camera's own, with the rows that each reaches."""
    from belvedere.warp import _surface_any, _tiles

    camera = prepared.camera
    rows, columns = own_samples(camera)
    # between a sphere's last row and the one beyond its pole there is no cell of its own
    last = rows.stop - 1 if isinstance(camera, SeamlessCamera) and camera.rows else rows.stop
    side = _tiles.TILE
    table = np.array(
        [
            (max(u, columns.start), min(u + side, columns.stop), 1,
             max(v, rows.start), min(v + side, last), 1, 0, 0)
            for v in range(rows.start // side * side, last, side)
            for u in range(columns.start // side * side, columns.stop, side)
        ],
        np.int32,
    ).reshape(-1, _tiles.FIELDS)  # fmt: skip
    parts = prepared.silhouettes(threads).parts
    given = ahead, prepared.surface(threads), prepared.links(threads), parts.corners, parts.ends

    def bound(part: tuple[int, int]) -> None:
        _surface_any.bound_tiles(*given, height, *part, table)

    run_parallel(bound, row_bands(len(table), thread_count(threads) * TASKS_PER_THREAD), threads)
    return np.ascontiguousarray(table[table[:, 6] < table[:, 7]])


def _land(
    prepared: PreparedView, desired: CameraModel, ahead: F8, options: WarpOptions,
    threads: int | None,
) -> Samples:  # fmt: skip
    """Land all samples of a reference, and put them in order if it is asked for."""
    from belvedere.warp import _scatter_any

    rows, columns = own_samples(prepared.camera)
    own = rows.start, rows.stop, columns.start, columns.stop
    count = (own[1] - own[0]) * (own[3] - own[2])
    places, cells = np.empty((3, count), np.float32), np.empty(count, np.int32)
    bands = row_bands(own[1] - own[0], thread_count(threads) * TASKS_PER_THREAD)

    def land(band: tuple[int, int]) -> None:
        _scatter_any.land_samples(
            ahead, prepared.disparity, own, *band, desired.width, desired.height, places, cells
        )

    run_parallel(land, bands, threads)
    size = options.splat.size
    halves = np.full(1, 0.5 * size if isinstance(size, int) else 0.0, np.float32)
    if options.reconstruction == "splat" and size == "jacobian":
        halves = np.empty(count, np.float32)
        given = ahead, prepared.disparity, own
        largest = options.splat.halo + 0.5
        run_parallel(
            lambda band: _scatter_any.measure_halves(*given, *band, largest, places, halves),
            bands,
            threads,
        )
    order = np.empty(0, np.int32)
    if options.visibility == "order":
        toward = desired.center - prepared.camera.center
        toward = toward / (float(np.linalg.norm(toward)) or 1.0)
        frame, rank = direction_frame(prepared.camera), np.empty(count, np.uint16)
        run_parallel(
            lambda band: _scatter_any.rank_samples(ahead, frame, toward, own, *band, rank),
            bands,
            threads,
        )
        order = np.empty(count, np.int32)
        _scatter_any.sort_by_rank(rank, order)
    return Samples(own, cells, places, order, halves)


def _scatter_rows(passage: BentPassage, sample: I4, disparity: F4, row_low: int) -> None:
    """Which sample each pixel of some rows sees; the outputs are (rows, width)."""
    from belvedere.warp import _scatter_any

    held = passage.samples
    assert held is not None
    sample.fill(-1)
    disparity.fill(-1.0)
    _scatter_any.scatter(
        held.cells, held.places, held.order, row_low, held.own, passage.disparity.shape[1],
        sample, disparity,
    )  # fmt: skip


def _gather(passage: Passage, sample: I4, color: F4) -> None:
    from belvedere.warp import _scatter_any

    _scatter_any.gather(passage.color, sample, color)


def _paint_points(
    passage: Passage, rows: tuple[int, int], color: F4, disparity: F4, coverage: F4
) -> None:
    del coverage
    assert isinstance(passage, BentPassage)
    sample = scratch("sample", disparity.shape, np.int32)
    _scatter_rows(passage, sample, disparity, rows[0])
    _gather(passage, sample, color)


def _paint_splats(
    passage: Passage, rows: tuple[int, int], color: F4, disparity: F4, coverage: F4
) -> None:
    from belvedere.warp import _scatter_any

    del coverage
    assert isinstance(passage, BentPassage)
    held, chosen = passage.samples, passage.options.splat
    assert held is not None
    low, high = max(rows[0] - chosen.halo - 1, 0), min(rows[1] + chosen.halo + 1, passage.height)
    seen = scratch("seen", (high - low, disparity.shape[1]), np.int32)
    _scatter_rows(passage, seen, scratch("seen disparity", seen.shape, np.float32), low)
    sample = scratch("sample", disparity.shape, np.int32)
    _scatter_any.splat(
        passage.ahead, held.cells, held.places, held.halves, chosen.size == "jacobian", seen, low,
        rows[0], held.own, passage.disparity.shape[1], passage.options.surface_tolerance,
        scratch("front", disparity.shape, np.float32),
        scratch("nearest", disparity.shape, np.float32),
        sample, disparity,
    )  # fmt: skip
    _gather(passage, sample, color)


def paint_beyond_seam(
    passages: Sequence[Passage], weights: F4, rows: tuple[int, int], color: npt.NDArray[Any],
    disparity: F4, coverage: F4,
) -> None:  # fmt: skip
    """`paint_inverse` with columns beyond the seam of a desired panorama; arguments as there."""
    first = passages[0]
    margin = first.margin if isinstance(first, BentPassage) else 0
    if margin == 0:
        paint_inverse(passages, weights, rows, color, disparity, coverage)
        return
    wide = (disparity.shape[0], disparity.shape[1] + 2 * margin)
    painted = (
        scratch("wide color", (*wide, color.shape[2]), color.dtype),
        scratch("wide disparity", wide, np.float32),
        scratch("wide coverage", wide, np.float32),
    )
    paint_inverse(passages, weights, rows, *painted)
    for out, held in zip((color, disparity, coverage), painted, strict=True):
        out[:] = held[:, margin:-margin]


PANORAMIC: dict[str, Reconstructor] = {
    "point": Reconstructor(_paint_points),
    "splat": Reconstructor(_paint_splats),
    "inverse": Reconstructor(None, joins=True, together=True),
}
"""What a warp with a panorama can do; `RECONSTRUCTORS` is for planes."""
