"""The inverse pass: forward for visibility, backwards for colour.

First every reference's surface is scan-converted into the desired view, disparities only. Then the
references check one another: what one of them guessed at an edge is taken back where another looks
through it. Last, each pixel's colour is looked up in every reference that sees its surface, with
taps that stay on that surface, and at silhouettes blended over what is behind in proportion to the
area each covers.

Source: the inverse pass that McMillan and Popescu leave to future work; spec image-warping 3.8 and
offset-buffer-warping 7 for un-mixed edges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import LINEAR_TO_SRGB8
from belvedere.ground.scratch import scratch
from belvedere.warp.prepare import EDGE_TOLERANCE
from belvedere.warp.reconstruct import Passage

F4 = npt.NDArray[np.float32]

HALO = 2
"""Rows beyond a band that its pixels depend on: cracks are closed from the next row, and what is
behind a silhouette is asked of the row after that."""


def paint_inverse(
    passages: Sequence[Passage],
    weights: F4,
    rows: tuple[int, int],
    color: npt.NDArray[Any],
    disparity: F4,
    coverage: F4,
) -> None:
    """Paint references together into rows [low, high) of the desired view.

    Args:
        passages: one per reference, the nearest first.
        weights: (n,) how much each counts; those that share a layer count alike.
        rows: of the desired view.
        color: (rows, W, 3|4) of the references' type, written.
        disparity: (rows, W), NaN where nothing is known.
        coverage: (rows, W).

    Memory: 37 bytes and 10 more for each reference, a pixel of the rows.
    """
    low, high = max(rows[0] - HALO, 0), min(rows[1] + HALO, passages[0].height)
    layers = _draw_layers(passages, low, (high - low, disparity.shape[1]))
    if len(passages) > 1:
        _reject(passages, layers)
    shown = _merge(passages, weights, layers)
    _color(passages, weights, layers, shown, rows, color, disparity, coverage)


@dataclass(frozen=True, slots=True, eq=False)
class _Layers:
    """What each of n references shows in the rows from ``low`` on, in memory of the thread.

    References that are parts of one picture share a layer; see `joint.shared_layers`.
    """

    low: int
    of: list[int]
    """The number of each reference's layer."""
    centers: F4
    """(n, rows, W) disparity at the centre of each pixel, -1 = none."""
    edges: F4
    """(n, rows, W) that of its nearest surface near an edge, -1 = none."""
    masks: npt.NDArray[np.uint16]
    """(n, rows, W) sixteenths of the pixel that surface covers."""

    @property
    def size(self) -> tuple[int, int]:
        return self.centers.shape[1], self.centers.shape[2]


@dataclass(frozen=True, slots=True, eq=False)
class _Shown:
    """What the pixels of those rows show; see `_layers.merge_layers`."""

    front: F4
    alpha: F4
    index: npt.NDArray[np.int32]
    behind: F4
    partial: int


def _draw_layers(passages: Sequence[Passage], low: int, size: tuple[int, int]) -> _Layers:
    """Scan-convert every reference's surface into a layer of its own."""
    from belvedere.warp import _surface, _surface_any

    of = [n if passage.layer < 0 else passage.layer for n, passage in enumerate(passages)]
    count, tolerance = max(of) + 1, passages[0].options.surface_tolerance
    centers = scratch("inverse centers", (count, *size), np.float32)
    edges = scratch("inverse edges", (count, *size), np.float32)
    masks = scratch("inverse masks", (count, *size), np.uint16)
    centers.fill(-1.0)
    edges.fill(-1.0)
    for n, passage in zip(of, passages, strict=True):
        parts = passage.silhouettes.parts
        layer = centers[n], edges[n], masks[n]
        drawing = _surface if passage.w.dtype == np.float32 else _surface_any
        given = passage.tiles, low, low + size[0], tolerance, *layer
        # parts first: intact cells are only asked how much they cover where an edge is known
        drawing.draw_parts(passage.w, parts.corners, parts.near, parts.ends, *given)
        drawing.draw_surface(passage.w, passage.disparity, passage.links, *given)
    return _Layers(low, of, centers, edges, masks)


def _reject(passages: Sequence[Passage], layers: _Layers) -> None:
    """Let every reference take back what the others guessed and it can see to be wrong."""
    from belvedere.warp import _rejection

    options, centers, edges = passages[0].options, layers.centers, layers.edges
    if options.merge_ratio is not None:
        _rejection.keep_one_reference(options.merge_ratio, centers, edges)
        return
    for (n, one), (k, other) in permutations(zip(layers.of, passages, strict=True), 2):
        if n == k:
            continue
        _rejection.reject_seen_through(
            *(one.back, one.disparity, one.links, n),
            *(other.w, other.back, other.disparity, other.links, k, *other.columns),
            *(layers.low, options.surface_tolerance, centers, edges),
        )


def _merge(passages: Sequence[Passage], weights: F4, layers: _Layers) -> _Shown:
    """Close cracks and find what each pixel shows, and what is behind it at silhouettes."""
    from belvedere.warp import _cracks, _layers

    size, tolerance = layers.size, passages[0].options.surface_tolerance
    front = scratch("inverse front", size, np.float32)
    alpha = scratch("inverse alpha", size, np.float32)
    index = scratch("inverse index", (size[0] * size[1],), np.int32)
    behind = scratch("inverse behind", (size[0] * size[1],), np.float32)
    seen = scratch("inverse seen", (size[0] * size[1],), np.uint8)
    centers, edges = layers.centers, layers.edges
    cracks = _cracks.find_cracks(centers, edges, tolerance, front, index, behind, seen)
    for passage in passages:
        _cracks.witness_cracks(
            *(passage.back, passage.disparity, index, behind, cracks),
            *(size[1], layers.low, tolerance, seen),
        )
    nearness = np.empty(len(centers), np.float32)
    nearness[layers.of] = weights
    partial = _layers.merge_layers(
        *(centers, edges, layers.masks, nearness, tolerance, seen, cracks),
        *(front, alpha, index, behind),
    )
    return _Shown(front, alpha, index, behind, partial)


def _color(
    passages: Sequence[Passage],
    weights: F4,
    layers: _Layers,
    shown: _Shown,
    rows: tuple[int, int],
    color: npt.NDArray[Any],
    disparity: F4,
    coverage: F4,
) -> None:
    """Look colours up in every reference and blend them into the frame's rows."""
    from belvedere.warp import _lookup

    low, width, partial = layers.low, layers.size[1], shown.partial
    core = slice(rows[0] - low, rows[1] - low)
    front = shown.front[core]
    total = scratch("inverse total", (*disparity.shape, 4), np.float32)
    total_weight = scratch("inverse weight", disparity.shape, np.float32)
    below = scratch("inverse below", (partial + 1, 4), np.float32)
    below_weight = scratch("inverse below weight", (partial + 1,), np.float32)
    below.fill(0.0)
    below_weight.fill(0.0)
    for n, passage in enumerate(passages):
        back, clean, own = passage.back, passage.silhouettes.color, passage.disparity
        number, share = layers.of[n], (weights[n], passage.gain)
        layer = layers.centers[number, core], layers.edges[number, core]
        tolerance = passage.options.surface_tolerance
        sees = None
        if passage.copies:
            sees = (np.maximum(*layer) >= front * np.float32(1.0 - tolerance)).view(np.uint8)
        asked = _ask_copies(passage, None, front, sees, width, rows[0])
        _lookup.look_up(
            *(back, clean, own, passage.links, *layer, front, rows[0], *share, asked.part),
            *(tolerance, EDGE_TOLERANCE, n == 0, *passage.columns, total, total_weight),
        )
        asked.look_up(*share, total, total_weight)
        index, behind = shown.index[:partial], shown.behind[:partial]
        asked = _ask_copies(passage, index, behind, None, width, low)
        _lookup.look_up_behind(
            *(back, clean, own, index, behind, partial, width, low, *share, asked.part),
            *(EDGE_TOLERANCE, below, below_weight),
        )
        asked.look_up(*share, below, below_weight)
    _lookup.finish_rows(
        *(total, total_weight, front, shown.alpha, shown.index, shown.behind, partial),
        *(core.start, below, below_weight, LINEAR_TO_SRGB8, color, disparity, coverage),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Asked:
    """Pixels, and which copies of a reference tell what they show; see `_shrink.find_levels`."""

    passage: Passage
    index: npt.NDArray[np.int32] | None
    delta: F4
    width: int
    low: int
    levels: npt.NDArray[np.uint8]
    part: F4 | None
    """None where the desired view does not shrink the reference: no copy is asked."""

    def look_up(self, weight: float, gain: float, color: F4, total_weight: F4) -> None:
        """Add what the copies tell of them."""
        from belvedere.warp import _shrink

        if self.part is None:
            return
        own = self.passage
        for level, copy in enumerate(own.copies):
            _shrink.look_up_copy(
                *(own.back, *copy, level, own.disparity, own.links, self.index, self.delta),
                *(self.levels, self.part.reshape(-1), self.width, self.low, weight, gain),
                *(EDGE_TOLERANCE, color.reshape(-1, 4), total_weight.reshape(-1)),
            )


def _ask_copies(
    passage: Passage,
    index: npt.NDArray[np.int32] | None,
    delta: F4,
    sees: npt.NDArray[np.uint8] | None,
    width: int,
    low: int,
) -> _Asked:
    """Which copies to ask; index, delta and sees, of n pixels, as in `_shrink.find_levels`."""
    from belvedere.warp import _shrink

    levels, part, flat = np.empty(0, np.uint8), None, delta.reshape(-1)
    if passage.copies:
        purpose = "front" if index is None else "behind"
        levels = scratch(f"inverse {purpose} levels", flat.shape, np.uint8)
        part = scratch(f"inverse {purpose} part", delta.shape, np.float32)
        _shrink.find_levels(
            *(passage.back, index, flat, None if sees is None else sees.reshape(-1), width, low),
            *(*passage.columns, len(passage.copies), levels, part.reshape(-1)),
        )
    return _Asked(passage, index, flat, width, low, levels, part)
