"""Holding views out: which, predicted from which, and how the numbers come about."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest

from belvedere.ground.errors import InputError, SceneError
from belvedere.scene import Frame, ViewSet
from belvedere.studio.evaluate import evaluate, plan_hold_out
from belvedere.studio.metrics import psnr, ssim
from belvedere.studio.scores import Summary
from belvedere.warp import fill_background
from tests.studio.tiny_scenes import copying, row_of_views


def test_every_fourth_view_is_held_out_and_never_a_reference() -> None:
    views = row_of_views(10)
    plan = plan_hold_out(views, 4, 2)
    assert [target for target, _ in plan] == [0, 4, 8]
    used = {index for _, chosen in plan for index in chosen}
    assert used.isdisjoint({0, 4, 8})
    assert set(dict(plan)[4]) == {3, 5}


def test_a_pair_predicts_each_view_from_the_other() -> None:
    assert plan_hold_out(row_of_views(2), 4, 2) == [(0, (1,)), (1, (0,))]


def test_holding_out_every_view_predicts_each_from_all_the_others() -> None:
    plan = plan_hold_out(row_of_views(4), 1, 2)
    assert [target for target, _ in plan] == [0, 1, 2, 3]
    assert all(target not in chosen and len(chosen) == 2 for target, chosen in plan)


def test_views_can_be_named_for_holding_out() -> None:
    plan = plan_hold_out(row_of_views(5), [2, 4], 1)
    assert [target for target, _ in plan] == [2, 4]
    assert all(set(chosen) <= {0, 1, 3} for _, chosen in plan)


def test_a_held_out_view_needs_no_depth_and_one_without_is_no_reference() -> None:
    full = row_of_views(5)
    flat = [dataclasses.replace(entry, has_depth=False, load=None) for entry in full.entries[:2]]
    plan = plan_hold_out(ViewSet((*flat, *full.entries[2:])), 4, 2)
    assert [target for target, _ in plan] == [0, 4]
    assert all(1 not in chosen for _, chosen in plan)


def test_the_numbers_are_those_of_the_pixels_they_name() -> None:
    views = row_of_views(3)
    result = evaluate(
        views, hold_out=[1], references=1, reconstructions=("point", "splat"), predict=copying,
        repeats=1,
    )  # fmt: skip
    point, splat = result.scores
    truth = views.color(1)
    shown = copying([views[int(point.references[0][-2:])]], views.cameras[1],
                    reconstruction="splat")  # fmt: skip
    covered = shown.coverage > 0
    shown = fill_background(shown)
    black = np.where(covered[..., None], shown.color, 0).astype(np.uint8)
    assert splat.hole_fraction == 0.5
    assert splat.psnr_covered == pytest.approx(psnr(shown.color, truth, covered), abs=1e-9)
    assert splat.psnr_whole == pytest.approx(psnr(shown.color, truth), abs=1e-9)
    assert splat.psnr_unfilled == pytest.approx(psnr(black, truth), abs=1e-9)
    assert splat.ssim_covered == pytest.approx(ssim(shown.color, truth, covered), abs=1e-12)
    assert splat.ssim_whole == pytest.approx(ssim(shown.color, truth), abs=1e-12)
    assert point.psnr_common == splat.psnr_common == pytest.approx(splat.psnr_covered)
    assert point.common_fraction == 0.5
    assert point.hole_fraction == 0.0
    assert point.nearest_m == pytest.approx(0.08)


def test_each_timed_call_follows_one_that_may_compile() -> None:
    calls: list[int] = []

    def counting(views, camera, *, reconstruction: str) -> Frame:
        calls.append(1)
        return copying(views, camera, reconstruction=reconstruction)

    evaluate(row_of_views(3), hold_out=[1], reconstructions="point", predict=counting, repeats=3)
    assert len(calls) == 1 + 3


def test_observers_see_each_prediction_with_its_truth_and_progress_counts_them() -> None:
    views = row_of_views(4)
    seen: list[tuple[str, str]] = []
    steps: list[tuple[int, int]] = []

    def observe(score, truth, frame) -> None:
        assert np.array_equal(truth, views.color(views.names.index(score.view)))
        assert frame.filled is not None
        seen.append((score.view, score.reconstruction))

    evaluate(
        views, hold_out=2, reconstructions=("point", "splat"), predict=copying, observe=observe,
        repeats=1, progress=lambda done, total, _: steps.append((done, total)),
    )  # fmt: skip
    assert seen == [(v, r) for v in ("view_00", "view_02") for r in ("point", "splat")]
    assert steps == [(i, 4) for i in range(5)]


def test_transparent_parts_of_a_truth_do_not_count() -> None:
    views = row_of_views(2)
    target = views[0]
    alpha = np.full(target.camera.size, 255, np.uint8)
    alpha[:, :10] = 0
    layered = np.dstack([target.color, alpha])
    layered[:, :10] = 0
    entries = (dataclasses.replace(views.entries[0], load_color=lambda: layered), views.entries[1])
    result = evaluate(ViewSet(entries), hold_out=[0], predict=copying, repeats=1)
    expected = psnr(views.color(1), target.color, alpha > 0)
    assert result.scores[0].psnr_whole == pytest.approx(expected, abs=1e-9)


def test_a_warped_neighbour_predicts_a_view_well() -> None:
    """PSNR 33 dB when written; copying the neighbour gives 22."""
    result = evaluate(row_of_views(4), hold_out=[1], reconstructions=["mesh"], repeats=1, threads=1)
    score = result.scores[0]
    assert score.psnr_covered > 28
    assert score.hole_fraction < 0.05
    assert score.ms > 0


def test_means_leave_out_views_without_any_covered_pixel_and_say_so() -> None:
    result = evaluate(row_of_views(4), hold_out=2, predict=copying, repeats=1)
    known, other = result.scores
    lost = dataclasses.replace(other, psnr_covered=math.nan, hole_fraction=1.0, ms=9.0)
    summary = Summary.of([known, lost])
    assert (summary.views, summary.measured) == (2, 1)
    assert summary.psnr_covered == known.psnr_covered
    assert summary.hole_fraction == pytest.approx((known.hole_fraction + 1) / 2)
    assert summary.ms == pytest.approx((known.ms + 9.0) / 2)


def test_an_exact_prediction_goes_into_json() -> None:
    views = row_of_views(3)
    exact = views[1]

    def perfect(views, camera, *, reconstruction: str) -> Frame:
        return Frame(camera, exact.color, exact.disparity, np.ones(camera.size, np.float32))

    result = evaluate(views, hold_out=[1], predict=perfect, repeats=1)
    text = json.dumps(result.as_dict(), allow_nan=False)
    assert json.loads(text)["summary"][0]["psnr_covered"] == "Infinity"
    assert json.loads(text)["views"][0]["ssim_covered"] == 1.0


@pytest.mark.parametrize(
    ("count", "options", "error", "message"),
    [
        (1, {}, SceneError, "the set has 1 view, expected at least 2"),
        (3, {"hold_out": [0, 1, 2]}, SceneError, "no view with depth is left to predict 'view_00'"),
        (3, {"hold_out": 0}, InputError, "evaluate.hold_out is 0, expected a whole number from 1"),
        (3, {"hold_out": []}, InputError, "evaluate.hold_out is empty"),
        (3, {"hold_out": [3]}, InputError, "evaluate.hold_out[0] is 3, expected a whole number"),
        (3, {"references": 0}, InputError, "evaluate.references is 0"),
        (3, {"reconstructions": "blur"}, InputError, "'blur', expected one of 'point', 'splat'"),
        (3, {"reconstructions": ()}, InputError, "evaluate.reconstructions is empty"),
    ],
)
def test_an_evaluation_that_cannot_be_done_is_refused(count, options, error, message) -> None:
    with pytest.raises(error) as refusal:
        evaluate(row_of_views(count), **options)
    assert message in str(refusal.value)
