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
        weights: (n,) how much each counts.
        rows: of the desired view.
        color: (rows, W, 3|4) of the references' type, written.
        disparity: (rows, W), NaN where nothing is known.
        coverage: (rows, W).

    Memory: 37 bytes and 10 more for each reference, a pixel of the rows.
    """
    from belvedere.warp import _layers, _lookup, _surface, _surface_any

    low, high = max(rows[0] - HALO, 0), min(rows[1] + HALO, passages[0].height)
    count, size = len(passages), (high - low, disparity.shape[1])
    options = passages[0].options
    tolerance = options.surface_tolerance
    centers = scratch("inverse centers", (count, *size), np.float32)
    edges = scratch("inverse edges", (count, *size), np.float32)
    masks = scratch("inverse masks", (count, *size), np.uint16)
    centers.fill(-1.0)
    edges.fill(-1.0)
    for n, passage in enumerate(passages):
        parts = passage.silhouettes.parts
        layer = centers[n], edges[n], masks[n]
        drawing = _surface if passage.w.dtype == np.float32 else _surface_any
        given = passage.tiles, low, high, tolerance, *layer
        # parts first: intact cells are only asked how much they cover where an edge is known
        drawing.draw_parts(passage.w, parts.corners, parts.near, parts.ends, *given)
        drawing.draw_surface(passage.w, passage.disparity, passage.links, *given)
    if count > 1 and options.merge_ratio is not None:
        _layers.keep_one_reference(options.merge_ratio, centers, edges)
    elif count > 1:
        for n, passage in enumerate(passages):
            for k, other in enumerate(passages):
                if k == n:
                    continue
                _layers.reject_seen_through(
                    passage.back,
                    passage.disparity,
                    passage.links,
                    n,
                    other.w,
                    other.back,
                    other.disparity,
                    other.links,
                    k,
                    low,
                    tolerance,
                    centers,
                    edges,
                )
    front = scratch("inverse front", size, np.float32)
    alpha = scratch("inverse alpha", size, np.float32)
    index = scratch("inverse index", (size[0] * size[1],), np.int32)
    behind = scratch("inverse behind", (size[0] * size[1],), np.float32)
    seen = scratch("inverse seen", (size[0] * size[1],), np.uint8)
    cracks = _layers.find_cracks(centers, edges, tolerance, front, index, behind, seen)
    for passage in passages:
        _layers.witness_cracks(
            passage.back,
            passage.disparity,
            index,
            behind,
            cracks,
            size[1],
            low,
            tolerance,
            seen,
        )
    partial = _layers.merge_layers(
        centers, edges, masks, weights, tolerance, seen, cracks, front, alpha, index, behind
    )
    core = slice(rows[0] - low, rows[1] - low)
    total = scratch("inverse total", (*disparity.shape, 4), np.float32)
    total_weight = scratch("inverse weight", disparity.shape, np.float32)
    below = scratch("inverse below", (partial + 1, 4), np.float32)
    below_weight = scratch("inverse below weight", (partial + 1,), np.float32)
    below.fill(0.0)
    below_weight.fill(0.0)
    for n, passage in enumerate(passages):
        clean = passage.silhouettes.color
        _lookup.look_up(
            passage.back,
            clean,
            passage.disparity,
            passage.links,
            centers[n, core],
            edges[n, core],
            front[core],
            rows[0],
            weights[n],
            passage.gain,
            tolerance,
            EDGE_TOLERANCE,
            n == 0,
            total,
            total_weight,
        )
        _lookup.look_up_behind(
            passage.back,
            clean,
            passage.disparity,
            index,
            behind,
            partial,
            size[1],
            low,
            weights[n],
            passage.gain,
            EDGE_TOLERANCE,
            below,
            below_weight,
        )
    _lookup.finish_rows(
        total,
        total_weight,
        front[core],
        alpha,
        index,
        behind,
        partial,
        core.start,
        below,
        below_weight,
        LINEAR_TO_SRGB8,
        color,
        disparity,
        coverage,
    )
