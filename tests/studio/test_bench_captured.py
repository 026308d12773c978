"""The suite "warp" on a scene: everybody predicts what was held out, on the same pixels."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from belvedere.ground.errors import CameraError, InputError, SceneError
from belvedere.ground.progress import silent
from belvedere.scene import Camera, CylinderCamera, Frame, ReferenceView, ViewSet
from belvedere.scene.io import save_views
from belvedere.studio import _bench_captured
from belvedere.studio._bench_captured import captured_rows
from belvedere.studio._bench_rival import Rival
from belvedere.studio._bench_splatted import prepare_torch
from belvedere.studio._bench_warp import Plan
from belvedere.studio.bench import BenchResult, bench
from belvedere.warp import RECONSTRUCTIONS
from tests.studio.tiny_scenes import camera_at, photograph, row_of_views

PLAN = Plan.of((1,), 1, peers=False, repeats=1)


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("captured")
    save_views(row_of_views(3), folder / "scene")
    return folder


@pytest.fixture(scope="module")
def result(kept: Path) -> BenchResult:
    return bench(
        "warp", repeats=1, threads=1, peers=False, references=(2, 1), scene=kept / "scene",
        output=kept / "run",
    )  # fmt: skip


def test_every_reconstructor_predicts_every_view_with_every_number_of_references(
    result: BenchResult,
) -> None:
    names = ["default", *RECONSTRUCTIONS]
    assert [(row.name, row.references) for row in result.rows] == [
        (name, count) for count in (2, 1) for name in names
    ]
    for row in result.rows:
        assert row.psnr is not None
        assert 25 < row.psnr < 70
        assert row.ssim is not None
        assert 0.7 < row.ssim <= 1
        assert row.holes is not None
        assert 0 <= row.holes < 50
        assert row.ms_median is not None
        assert row.cracks is row.ghosts is row.wrong_depth is None
    assert "covered by all" in result.rows[0].note
    assert result.row("default", 2).ratio == 1
    default, inverse = result.row("default", 2), result.row("inverse", 2)
    assert (default.psnr, default.ssim, default.holes) == (
        inverse.psnr,
        inverse.ssim,
        inverse.holes,
    )


def test_the_table_speaks_of_held_out_views_and_the_pictures_are_written(
    result: BenchResult, kept: Path
) -> None:
    assert "held-out views" in str(result.table().caption)
    names = {file.name for file in (kept / "run").iterdir()}
    assert {"bench.json", "view_01-truth.png", "view_01-2-mesh.png",
            "view_02-1-default-difference.png"} <= names  # fmt: skip
    record = json.loads((kept / "run" / "bench.json").read_text())
    assert record["rows"][0]["holes"] == result.rows[0].holes


def copying(name: str, covered: Any, error: int) -> Rival:
    """Shows the photograph itself, ``error`` levels off on the right, and only where told."""

    def warp(prepared: Any, camera: Camera, threads: int) -> Frame:
        del prepared, threads
        view = photograph(camera)
        color = view.color.copy()
        color[:, camera.width // 2 :] = color[:, camera.width // 2 :] // 2 + error
        coverage = np.zeros(camera.size, np.float32)
        coverage[:, covered] = 1
        color[coverage == 0] = 0
        disparity = np.where(coverage > 0, view.disparity, np.float32(np.nan))
        return Frame(camera, color, disparity, coverage)

    return Rival(name, name, "", lambda views, threads: None, warp)


def test_only_pixels_that_everybody_covers_count(monkeypatch: pytest.MonkeyPatch) -> None:
    everything, left = slice(None), slice(0, 20)
    rivals = [copying("all", everything, 7), copying("left", left, 0)]
    monkeypatch.setattr(_bench_captured, "our_entries", lambda: rivals)
    rows = captured_rows(row_of_views(3), PLAN, silent)
    assert [row.psnr for row in rows] == [None, None]  # infinite: the left half is right
    assert [row.ssim for row in rows] == [1, 1]
    assert rows[0].holes == 0
    assert rows[1].holes == pytest.approx(100 * 28 / 48)
    assert rows[0].note == "41.7 % of the pixels are covered by all"


def test_floats_and_alpha_are_judged_as_bytes() -> None:
    views = [photograph(camera_at(0.08 * i)) for i in range(2)]
    plain = captured_rows(ViewSet.of(views, ["a", "b"]), PLAN, silent)
    opaque = [
        ReferenceView(
            view.camera,
            np.concatenate([view.color, np.full((*view.camera.size, 1), 255, np.uint8)], -1),
            view.disparity,
        )
        for view in views
    ]
    judged = captured_rows(ViewSet.of(opaque, ["a", "b"]), PLAN, silent)
    assert [row.psnr for row in judged] == [row.psnr for row in plain]


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"suite": "speed"}, "bench.scene goes with suite 'warp'"),
        ({"suite": "warp", "held_out": True}, "held_out True"),
    ],
)
def test_a_scene_where_none_is_asked_for_is_refused(given: dict[str, Any], text: str) -> None:
    with pytest.raises(InputError) as refusal:
        bench(scene="somewhere", **given)
    assert text in str(refusal.value)


def test_a_scene_that_cannot_be_held_out_is_refused() -> None:
    with pytest.raises(SceneError, match="expected at least 2"):
        captured_rows(row_of_views(1), PLAN, silent)
    round_about = CylinderCamera([0, 0, 0], 8, 6)
    panorama = ReferenceView(
        round_about, np.zeros((6, 8, 3), np.uint8), np.ones((6, 8), np.float32)
    )
    views = ViewSet.of([panorama, photograph(camera_at(0))], ["round", "flat"])
    with pytest.raises(CameraError, match="CylinderCamera"):
        captured_rows(views, PLAN, silent)


def test_samples_without_depth_are_no_points_for_torch() -> None:
    pytest.importorskip("torch")
    view = photograph(camera_at(0))
    disparity = view.disparity.copy()
    disparity[3, 5:9] = np.nan
    ready = prepare_torch([ReferenceView(view.camera, view.color, disparity)], 1)[0]
    assert ready.points.shape == (3, disparity.size - 4)
    assert ready.color.shape == (disparity.size - 4, 3)
