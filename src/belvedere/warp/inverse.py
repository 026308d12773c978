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

import numpy as np
import numpy.typing as npt

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
    color: F4,
    disparity: F4,
    coverage: F4,
) -> None:
    """Paint references together into rows [low, high) of the desired view.

    Args:
        passages: one per reference, the nearest first.
        weights: (n,) how much each counts.
        rows: of the desired view.
        color: (rows, W, 4) linear, written.
        disparity: (rows, W), -1 where nothing is known.
        coverage: (rows, W).

    Memory: 36 bytes and 10 more for each reference, a pixel of the rows.
    """
    from belvedere.warp import _lookup, _surface, _surface_any

    low, high = max(rows[0] - HALO, 0), min(rows[1] + HALO, passages[0].height)
    count, size = len(passages), (high - low, color.shape[1])
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
        drawing.draw_surface(
            passage.w, passage.disparity, passage.links, passage.tiles, low, high, tolerance, *layer
        )
        drawing.draw_parts(
            passage.w,
            parts.corners,
            parts.near,
            parts.ends,
            passage.tiles,
            low,
            high,
            tolerance,
            *layer,
        )
    if count > 1 and options.composite == "nearest":
        _lookup.keep_nearest_reference(centers, edges)
    elif count > 1:
        for n, passage in enumerate(passages):
            _lookup.reject_seen_through(
                passage.back,
                passage.disparity,
                passage.links,
                n,
                low,
                tolerance,
                centers,
                edges,
            )
    front = scratch("inverse front", size, np.float32)
    alpha = scratch("inverse alpha", size, np.float32)
    index = scratch("inverse index", (size[0] * size[1],), np.int32)
    behind = scratch("inverse behind", (size[0] * size[1],), np.float32)
    partial = _lookup.merge_layers(
        centers, edges, masks, weights, tolerance, front, alpha, index, behind
    )
    core = slice(rows[0] - low, rows[1] - low)
    total = scratch("inverse total", (*color.shape[:2], 4), np.float32)
    total_weight = scratch("inverse weight", color.shape[:2], np.float32)
    total.fill(0.0)
    total_weight.fill(0.0)
    total_behind = scratch("inverse total behind", (partial + 1, 4), np.float32)
    weight_behind = scratch("inverse weight behind", (partial + 1,), np.float32)
    total_behind.fill(0.0)
    weight_behind.fill(0.0)
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
            tolerance,
            EDGE_TOLERANCE,
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
            EDGE_TOLERANCE,
            total_behind,
            weight_behind,
        )
    disparity[:] = front[core]
    _lookup.divide(total, total_weight, color, disparity, coverage)
    _lookup.blend_behind(
        index,
        behind,
        partial,
        core.start,
        alpha,
        total_behind,
        weight_behind,
        color,
        disparity,
        coverage,
    )
