"""How well a set of views predicts the views it does not hold.

Views are held out, each is predicted from the best of the others by warping, and the prediction is
compared with the picture that was really taken there. Nothing of a held-out view but its camera
is shown to the predictor, and a held-out view is never a reference for another one.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import Protocol

import numpy as np

from belvedere.ground.checks import check_choice, check_integer
from belvedere.ground.errors import InputError, SceneError
from belvedere.ground.progress import Progress, silent
from belvedere.ground.threads import run_parallel
from belvedere.scene.camera import Camera
from belvedere.scene.camera_model import CameraModel
from belvedere.scene.view import Color, Frame, ReferenceView
from belvedere.scene.views import ViewSet
from belvedere.studio.metrics import Mask, psnr_of_squares, shown_values, ssim
from belvedere.studio.scores import Evaluation, ViewScore


class Predictor(Protocol):
    """Anything that predicts a picture from others: the warp, or a rival to compare with it."""

    def __call__(
        self,
        views: Sequence[ReferenceView],
        camera: CameraModel,
        *,
        reconstruction: str,
    ) -> Frame:
        """The picture from ``camera``, its holes left as they are."""
        ...


Observer = Callable[[ViewScore, Color, Frame], None]
"""Called as ``observe(score, truth, frame)`` after each prediction, before its pixels are let go.
The frame's holes are filled and marked in ``frame.filled``."""


def evaluate(
    views: ViewSet,
    *,
    hold_out: int | Sequence[int] = 4,
    references: int = 2,
    reconstructions: Sequence[str] | str = ("inverse",),
    visibility: str = "order",
    repeats: int = 3,
    threads: int | None = None,
    predict: Predictor | None = None,
    observe: Observer | None = None,
    progress: Progress = silent,
) -> Evaluation:
    """Hold views out, predict each from the others, and say how far off the predictions are.

    Args:
        views: the set; a held-out view needs colour only, a reference depth as well.
        hold_out: hold out every n-th view, the first included (0, n, 2n ...). 1 holds out each
            view in turn, all others being its references; so does a set of two (a stereo pair),
            whatever ``hold_out`` says. A sequence names the held-out views by their index.
        references: how many of the best references predict a view.
        reconstructions: names of `belvedere.warp.RECONSTRUCTIONS`, or "all".
        visibility: "order" or "zbuffer", handed to the warp.
        repeats: timed renders of each view, of which the median counts. They follow one that does
            not: it may compile, and it prepares the references as a scene does once for all.
        threads: for the warp; None uses every processor of this process.
        predict: what predicts; None is `belvedere.warp.warp` with ``visibility`` and ``threads``.
        observe: sees every prediction with its pixels; a report keeps small copies this way.
        progress: told after each prediction.

    Returns:
        Scores of every view and reconstruction, with means and medians.

    Raises:
        InputError: an unknown reconstruction, a count out of range.
        SceneError: too few views with depth, or a file that cannot be read.

    Memory: what ``views`` keeps, one view's predictions in every reconstruction at once (to know
    the pixels they all cover), and some twenty float64 planes a thread for the metrics. Nothing
    grows with the number of views.
    """
    names = reconstruction_names(reconstructions)
    check_integer("evaluate", "repeats", repeats, 1, 1000)
    plan = plan_hold_out(views, hold_out, references)
    predictor = predict if predict is not None else _warp_predictor(visibility, threads)
    started = time.perf_counter()
    scores: list[ViewScore] = []
    total = len(plan) * len(names)
    what = "predicting held-out views"
    progress(0, total, what)
    for target, chosen in plan:
        held = [views[index] for index in chosen]
        truth = views.color(target)
        camera = views.entries[target].camera
        frames = {name: _timed(predictor, held, camera, name, repeats) for name in names}
        common = np.logical_and.reduce([frame.coverage > 0 for frame, _, _ in frames.values()])
        compare = partial(_compare, truth, common)
        measured = run_parallel(compare, [frame for frame, _, _ in frames.values()], threads)
        for (name, (frame, ms, fill_ms)), numbers in zip(frames.items(), measured, strict=True):
            score = ViewScore(
                views.names[target], name, tuple(views.names[index] for index in chosen),
                _nearest(views, target, chosen), **numbers, ms=ms, fill_ms=fill_ms,
            )  # fmt: skip
            scores.append(score)
            if observe is not None:
                observe(score, truth, frame)
            progress(len(scores), total, what)
    first = views.entries[plan[0][0]].camera
    options = {
        "hold_out": list(hold_out) if isinstance(hold_out, Sequence) else hold_out,
        "references": references, "reconstructions": list(names),
        "visibility": visibility, "repeats": repeats, "threads": threads,
    }  # fmt: skip
    return Evaluation(
        tuple(scores), options, len(views), (first.width, first.height),
        time.perf_counter() - started,
    )  # fmt: skip


def plan_hold_out(
    views: ViewSet, hold_out: int | Sequence[int], references: int
) -> list[tuple[int, tuple[int, ...]]]:
    """Which views are held out, and which views predict each: ``[(view, references), ...]``.

    Reads the depth of a few views that may be references, to know how far the scene is.

    Raises:
        InputError: a count out of range.
        SceneError: the set has one view, or no view with depth is left to predict from.
    """
    from belvedere.warp import DepthViews

    check_integer("evaluate", "references", references, 1, 1000)
    if len(views) < 2:
        raise SceneError(
            "evaluate: the set has 1 view, expected at least 2: one to hold out and one to "
            "predict it from"
        )
    held, in_turn = _held_out(len(views), hold_out)
    hidden = set() if in_turn else set(held)
    allowed = [i for i, entry in enumerate(views.entries) if entry.has_depth and i not in hidden]
    chooser = DepthViews(views.select(allowed), references=1) if allowed else None
    plan = []
    for target in held:
        exclude = [place for place, index in enumerate(allowed) if index == target]
        if chooser is None or len(allowed) == len(exclude):
            raise SceneError(
                f"evaluate: no view with depth is left to predict {views.names[target]!r} from "
                f"({len(views)} views, {sum(not e.has_depth for e in views.entries)} without "
                "depth): hold fewer views out, or add depth"
            )
        camera = views.entries[target].camera
        chosen = chooser.choose(camera, references, exclude=exclude)
        plan.append((target, tuple(allowed[place] for place in chosen)))
    return plan


def reconstruction_names(wanted: Sequence[str] | str) -> tuple[str, ...]:
    """The reconstructions that are meant: a name, several, or "all".

    Raises:
        InputError: an unknown name, or none.
    """
    from belvedere.warp import RECONSTRUCTIONS

    names = (wanted,) if isinstance(wanted, str) else tuple(dict.fromkeys(wanted))
    if not names:
        raise InputError(
            "evaluate.reconstructions is empty, expected at least one of "
            + ", ".join(map(repr, RECONSTRUCTIONS))
        )
    for name in names:
        check_choice("evaluate", "reconstructions", name, (*RECONSTRUCTIONS, "all"))
    return RECONSTRUCTIONS if "all" in names else names


def _held_out(count: int, hold_out: int | Sequence[int]) -> tuple[list[int], bool]:
    """Indices of the held-out views, and whether each is predicted from all the others."""
    if not isinstance(hold_out, Sequence):
        every = check_integer("evaluate", "hold_out", hold_out, 1, 1_000_000)
        in_turn = every == 1 or count == 2
        return list(range(count)) if in_turn else list(range(0, count, every)), in_turn
    held = [
        check_integer("evaluate", f"hold_out[{place}]", index, 0, count - 1)
        for place, index in enumerate(hold_out)
    ]
    if not held:
        raise InputError("evaluate.hold_out is empty, expected the index of at least one view")
    return list(dict.fromkeys(held)), False


def _warp_predictor(visibility: str, threads: int | None) -> Predictor:
    """The warp, which keeps the last references prepared."""
    from belvedere.warp import PreparedView, prepare, warp

    prepared: dict[int, PreparedView] = {}

    def predict(
        views: Sequence[ReferenceView],
        camera: CameraModel,
        *,
        reconstruction: str,
    ) -> Frame:
        held = {id(view): view for view in views}
        for stale in prepared.keys() - held.keys():
            del prepared[stale]
        for key in held.keys() - prepared.keys():
            prepared[key] = prepare(held[key])  # which keeps the view, so its id stays its own
        return warp(
            [prepared[id(view)] for view in views],
            camera,
            reconstruction=reconstruction,
            visibility=visibility,
            threads=threads,
        )

    return predict


def _timed(
    predict: Predictor,
    held: Sequence[ReferenceView],
    camera: CameraModel,
    reconstruction: str,
    repeats: int,
) -> tuple[Frame, float, float]:
    """The filled prediction, the median milliseconds without filling, and those of filling."""
    from belvedere.warp import fill_background

    frame = predict(held, camera, reconstruction=reconstruction)
    _warm_filling()
    times = []
    for _ in range(repeats):
        started = time.perf_counter()
        frame = predict(held, camera, reconstruction=reconstruction)
        times.append(time.perf_counter() - started)
    started = time.perf_counter()
    filled = fill_background(frame)
    return filled, 1e3 * statistics.median(times), 1e3 * (time.perf_counter() - started)


@lru_cache(maxsize=1)
def _warm_filling() -> None:
    """Fill a hole nobody looks at, so that no measured filling compiles."""
    from belvedere.warp import fill_background

    camera = Camera.look_at((0, 0, 0), (1, 0, 0), width=8, height=8)
    known = np.ones((8, 8), np.float32)
    known[4, 4] = 0
    for dtype in (np.uint8, np.float32):
        color = np.zeros((8, 8, 3), dtype)
        fill_background(Frame(camera, color, np.where(known > 0, known, np.nan), known))


def _compare(truth: Color, common: Mask, frame: Frame) -> dict[str, float]:
    """Every number of `ViewScore` that comes from pixels."""
    valid = truth_mask(truth)
    covered = (frame.coverage > 0) & valid
    shown, wanted = shown_values(frame.color), shown_values(truth)
    squares = (shown - wanted) ** 2
    unfilled = np.where((frame.coverage > 0)[..., None], squares, wanted**2)
    return {
        "psnr_covered": psnr_of_squares(squares[covered]),
        "psnr_common": psnr_of_squares(squares[common & valid]),
        "psnr_whole": psnr_of_squares(squares[valid]),
        "psnr_unfilled": psnr_of_squares(unfilled[valid]),
        "ssim_covered": ssim(frame.color, truth, covered),
        "ssim_whole": ssim(frame.color, truth, None if valid.all() else valid),
        "hole_fraction": float(np.mean(frame.coverage[valid] == 0)) if valid.any() else math.nan,
        "common_fraction": float(np.mean(common[valid])) if valid.any() else math.nan,
    }


def truth_mask(truth: Color) -> Mask:
    """(H, W) True where a photograph has content: everywhere, or where its alpha is above 0."""
    if truth.shape[2] == 4:
        return truth[..., 3] > 0
    return np.ones(truth.shape[:2], dtype=np.bool_)


def _nearest(views: ViewSet, target: int, chosen: Sequence[int]) -> float:
    eye = views.entries[target].camera.center
    return min(float(np.linalg.norm(views.entries[i].camera.center - eye)) for i in chosen)
