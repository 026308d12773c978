"""`point` and `splat`: samples move whole, and are averaged only where references meet.

Every reference scatters into a layer of words of its own, disparity and colour in one (see
`_scatter`); then one pass over the layers makes the frame's pixels.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import LINEAR_TO_SRGB8, SRGB8_TO_LINEAR
from belvedere.ground.scratch import scratch
from belvedere.warp import _join, _scatter, _splat, _tiles
from belvedere.warp.reconstruct import Passage

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
I8 = npt.NDArray[np.int64]
U4 = npt.NDArray[np.uint32]


def paint_scattered(
    passages: Sequence[Passage],
    weights: F4,
    rows: tuple[int, int],
    color: npt.NDArray[Any],
    disparity: F4,
    coverage: F4,
) -> None:
    """Paint references into rows [low, high) of the desired view.

    Args:
        passages: one per reference, the nearest first.
        weights: (n,) how much each counts where several see one surface.
        rows: of the desired view.
        color: (rows, W, C) of the references' type, written.
        disparity: (rows, W), NaN in holes.
        coverage: (rows, W), 1 or 0.

    Memory: 8 bytes for each reference, for `splat` 12 more, and with several of ``float32`` colour
    4 more for each, a pixel of the rows.
    """
    options = passages[0].options
    height, width = disparity.shape
    spare = -(-_scatter.SPARE // width)  # rows behind each layer, for what lands nowhere
    words = scratch("words", (len(passages), height + spare, width), np.int64)
    for n, passage in enumerate(passages):
        if options.reconstruction == "splat":
            _splat_layer(passage, rows, words[n, :height])
        else:
            _scatter_samples(passage, rows, (height, width), 0, words[n].reshape(-1), None)
    if len(passages) > 1 and options.merge_ratio is not None:
        _join.keep_first(words, options.merge_ratio)
    if color.dtype != np.uint8:
        _join_samples(passages, weights, words, color, disparity, coverage)
    elif len(passages) == 1:
        _join.copy_bytes(words[0], color, disparity, coverage)
    elif len(passages) == 2:
        table = _pairs(float(weights[0]), float(weights[1]))
        _join.blend_two(
            words, weights, options.surface_tolerance, table, color, disparity, coverage
        )
    else:
        _join.blend_bytes(
            words,
            weights,
            options.surface_tolerance,
            SRGB8_TO_LINEAR,
            LINEAR_TO_SRGB8,
            color,
            disparity,
            coverage,
        )


def runs_of(tiles: I4) -> I4:
    """(n, RUN) table of the tiles that stand side by side, for `_scatter.scatter`."""
    runs = np.empty((len(tiles), _tiles.RUN), np.int32)
    return runs[: _tiles.list_runs(tiles, runs)]


def _scatter_samples(
    passage: Passage,
    rows: tuple[int, int],
    shape: tuple[int, int],
    halo: int,
    out_word: I8,
    out_place: U4 | None,
) -> None:
    """One reference's samples in a band of the desired view, with ``halo`` cells round it."""
    _scatter.scatter(
        passage.w,
        passage.disparity,
        passage.prepared.carried(),
        passage.tiles,
        passage.runs,
        passage.prepared.tile_low,
        passage.prepared.tile_high,
        halo,
        rows[0] - halo,
        shape[1],
        shape[0],
        passage.height,
        passage.options.visibility == "order",
        out_word,
        out_place,
    )


def _splat_layer(passage: Passage, rows: tuple[int, int], out_word: I8) -> None:
    """What the squares of one reference's samples cover in a band of the desired view."""
    options, matrix = passage.options.splat, passage.matrix
    halo = options.halo
    shape = out_word.shape[0] + 2 * halo, out_word.shape[1] + 2 * halo
    cells = shape[0] * shape[1]
    word = scratch("scattered", (cells + _scatter.SPARE,), np.int64)
    place = scratch("places", (cells + _scatter.SPARE,), np.uint32)
    _scatter_samples(passage, rows, shape, halo, word, place)
    _splat.spread(
        word[:cells].reshape(shape),
        place[:cells].reshape(shape),
        passage.back,
        float(np.linalg.det(matrix[:, :3])),
        float(np.linalg.det(matrix[:, [0, 1, 3]])),
        0 if options.size == "jacobian" else options.size,
        halo,
        rows[0],
        passage.options.surface_tolerance,
        out_word,
    )


@lru_cache(maxsize=4)
def _pairs(first: float, second: float) -> npt.NDArray[np.uint8]:
    """What bytes of two references mix to; every band of a frame asks for the same."""
    table = np.empty(65536, np.uint8)
    _join.pair_table(np.float32(first), np.float32(second), SRGB8_TO_LINEAR, LINEAR_TO_SRGB8, table)
    return table


def _join_samples(
    passages: Sequence[Passage],
    weights: F4,
    words: I8,
    color: F4,
    disparity: F4,
    coverage: F4,
) -> None:
    """Layers that carry numbers: colours are fetched now."""
    colors = [one.color.reshape(-1, color.shape[2]) for one in passages]
    if len(passages) == 1:
        _join.copy_samples(words[0], colors[0], color, disparity, coverage)
        return
    shares = scratch("shares", words.shape, np.float32)
    _join.settle(words, weights, passages[0].options.surface_tolerance, shares, disparity, coverage)
    color.fill(0.0)
    for n, held in enumerate(colors):
        _join.add_samples(words[n], shares[n], held, color)
