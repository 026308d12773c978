"""`explain`: where a frame's pixels come from, which holes are cracks, how far off colours may be.

Nothing here depends on how the frame was made. Its disparity says where each pixel lies in each
reference, and the reference's own disparity there whether it sees that surface.

The expected error is the root of a sum of mean squares, each of them measured without the truth:

- how far the references that see a pixel are from the colour shown: they disagree, or the
  reconstruction blurred;
- contrast with the neighbours on the same surface, where a shift of a fraction of a pixel shows,
  and more of it where samples are stretched;
- contrast across depth edges, where the share of a pixel that each surface has is a guess;
- more where all that see the pixel do so beside an edge, and most where none confirms it;
- if the references' disparities are said to be off by some share: the shift that makes, which
  grows with the angle between the two rays, times the contrast.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_number
from belvedere.ground.color import color_to_srgb8
from belvedere.ground.errors import InputError, ViewError
from belvedere.ground.scratch import scratch
from belvedere.ground.threads import run_parallel
from belvedere.scene import CameraModel, Explanation, Frame, ReferenceView
from belvedere.scene.explanation import MOST_REFERENCES
from belvedere.warp.features import Asked, ask, bands_of
from belvedere.warp.manifold import check_planar
from belvedere.warp.prepare import EDGE_TOLERANCE, PreparedView
from belvedere.warp.reconstruct import SURFACE_TOLERANCE
from belvedere.warp.warp import nearest_order, nearness_weights, prepare_all

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]

FACTORS: F4 = np.array(
    [2.46e-5, 0.526, 0.0852, 0.0721, 0.0361, 1.11e-3, 0.0122, 4.69e-3, 0.0534], np.float32
)
"""(9,) factors of the mean squares, in the order of `_explain.FLOOR` ...: non-negative least
squares over every reconstruction, one, two and five references, on the three stations of the
built-in house that `belvedere bench warp` shows. Elsewhere they are a guess that tests hold to."""


EXPLAINED = "explain asks references"


def explain(
    frame: Frame,
    views: ReferenceView | PreparedView | Iterable[ReferenceView | PreparedView],
    *,
    surface_tolerance: float = SURFACE_TOLERANCE,
    disparity_error: float = 0.0,
    threads: int | None = None,
) -> Explanation:
    """Say of each pixel of a frame which references show it, why it is a hole, how far it is off.

    ::

        frame = bv.warp(views, camera)
        why = bv.explain(frame, views)
        cracks = why.hole == bv.Hole.UNDERSAMPLED

    The same as ``bv.warp(views, camera, explain=True).explanation``, for a frame that exists.

    Args:
        frame: made from ``views`` by any reconstruction.
        views: the references it was made from, at most 32.
        surface_tolerance: relative difference in disparity that is one surface.
        disparity_error: relative error (standard deviation) of the references' disparities: 0.01
            for sensors that are right to a per cent. The angle between reference and desired rays
            counts through it: it decides how far such an error shifts a colour.
        threads: how many to use; the result does not depend on it.

    Returns:
        Source, references that see the pixel, kind of hole, expected error; see `Explanation`.

    Raises:
        InputError: what is given is no frame; a value out of range.
        ViewError: no view, more than 32, or views that do not go together.
        CameraError: a camera that is not planar.

    A crack is proven: some reference sees, on an unbroken surface, what the hole's sides suggest is
    in it. An exposure is only what is left: a crack right at a silhouette, narrower than a sample,
    counts as one, since nobody knows where between two samples the edge runs.

    Memory: 11 bytes a pixel for the result, 8 more if there are holes, and a band's working memory
    on each thread: 36 bytes a pixel and 4 a reference, of 16,384 pixels.
    """
    if not isinstance(frame, Frame):
        raise InputError(
            f"explain.frame is a {type(frame).__name__}, expected a Frame, as warp gives it"
        )
    tolerance = check_number("explain", "surface_tolerance", surface_tolerance, 0.0, 1.0)
    doubt = check_number("explain", "disparity_error", disparity_error, 0.0, 1.0)
    held = prepare_all(views, "explain")
    if held[0].color.dtype != frame.color.dtype or held[0].color.shape[2] != frame.color.shape[2]:
        here, there = (f"{one.color.dtype} x {one.color.shape[2]}" for one in (frame, held[0]))
        raise ViewError(
            f"explain.frame has colours of type {here}, but explain.views of type {there}: a frame "
            "has the colours of the references it was made from"
        )
    desired = check_planar(EXPLAINED, frame.camera, [one.camera for one in held])
    order = nearest_order(held, desired)
    prepared = [held[n] for n in order]
    weights = nearness_weights(prepared, desired)
    return explain_prepared(frame, desired, prepared, order, weights, tolerance, doubt, threads)


def explain_prepared(
    frame: Frame,
    desired: CameraModel,
    views: Sequence[PreparedView],
    order: Sequence[int],
    weights: F4,
    tolerance: float,
    disparity_error: float,
    threads: int | None,
) -> Explanation:
    """`explain` once everything is checked.

    Args:
        frame: the frame.
        desired: its camera.
        views: the references, the nearest first.
        order: their numbers as the caller gave them.
        weights: (n,) how much each counts.
        tolerance: relative difference in disparity that is one surface.
        disparity_error: relative error of the references' disparities.
        threads: how many to use.
    """
    from belvedere.warp import _backward, _explain

    if len(views) > MOST_REFERENCES:
        raise ViewError(
            f"explain.views are {len(views)}, expected at most {MOST_REFERENCES}, as many as "
            "Explanation.seen_by has bits: leave out those that see least"
        )
    asked = [ask(one, desired, threads) for one in views]
    encoded, shown = [color_to_srgb8(one.color) for one in views], color_to_srgb8(frame.color)
    disparity, coverage = frame.disparity, frame.coverage
    numbers, doubt = np.array(order, np.int32), disparity_error / float(_explain.SHIFT)
    source, seen_by = np.empty(desired.size, np.int16), np.empty(desired.size, np.uint32)
    hole, error = np.zeros(desired.size, np.uint8), np.empty(desired.size, np.float32)
    sides = _sides(coverage)

    def work(rows: tuple[int, int]) -> None:
        band, size = slice(*rows), (rows[1] - rows[0], desired.width)
        each = scratch("explain weights", (len(views), *size), np.float32)
        sums = scratch("explain sums", (_explain.SUMS, *size), np.float32)
        slope = scratch("explain slope", (2, *size), np.float32)
        contrast = scratch("explain contrast", (2, *size), np.float32)
        sums.fill(0.0)
        _explain.survey(shown, disparity, coverage, tolerance, rows[0], slope, contrast)
        for n, (back, surface, links) in enumerate(asked):
            _backward.weigh(
                back, surface, links, disparity[band], coverage[band], rows[0], weights[n],
                tolerance, EDGE_TOLERANCE, each[n],
            )  # fmt: skip
            _explain.question(
                back, surface, links, encoded[n], disparity[band], shown[band], slope, rows[0],
                each[n], sums,
            )  # fmt: skip
        _explain.name_sources(each, numbers, source[band], seen_by[band])
        _explain.add_up(sums, contrast, coverage[band], FACTORS, doubt, error[band])
        if sides is not None:
            _tell_holes_apart(frame, asked, sides, tolerance, rows, hole)

    run_parallel(work, bands_of(desired, threads), threads)
    return Explanation(source, seen_by, hole, error)


def _sides(coverage: F4) -> tuple[I4, I4] | None:
    """(H, W) rows of the covered pixels above and below each one; None without any hole."""
    from belvedere.warp import _gaps

    if bool((coverage > 0).all()):
        return None
    above, below = np.empty(coverage.shape, np.int32), np.empty(coverage.shape, np.int32)
    _gaps.covered_rows(coverage, above, below)
    return above, below


def _tell_holes_apart(
    frame: Frame,
    asked: Sequence[Asked],
    sides: tuple[I4, I4],
    tolerance: float,
    rows: tuple[int, int],
    out_hole: U1,
) -> None:
    """Write the kinds of a band's holes into ``out_hole``, (H, W)."""
    from belvedere.warp import _gaps

    width = out_hole.shape[1]
    holes = int(np.count_nonzero(~(frame.coverage[slice(*rows)] > 0)))
    index = np.empty(holes, np.int32)
    guesses = np.empty((holes, _gaps.GUESSES), np.float32)
    answer = np.zeros((holes, _gaps.GUESSES), np.uint8)
    _gaps.guess(frame.disparity, frame.coverage, *sides, tolerance, *rows, index, guesses)
    for back, surface, links in asked:
        _gaps.ask_guesses(back, surface, links, index, guesses, width, tolerance, answer)
    _gaps.tell_apart(answer, index, out_hole.reshape(-1))
