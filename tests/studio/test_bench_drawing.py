"""The suite "drawing" measures renderers that draw the same pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("embreex", reason="ray casting needs embreex (pip install 'belvedere[model]')")

from belvedere.ground.errors import MissingDependencyError
from belvedere.studio import _bench_drawing
from belvedere.studio._bench_drawing import RENDERERS, Subject
from belvedere.studio.bench import BenchResult, bench

SIZE = 48


@pytest.fixture(scope="module")
def subject() -> Subject:
    return _bench_drawing.make_subjects(SIZE, ())[0]


@pytest.fixture
def result(subject: Subject, monkeypatch: pytest.MonkeyPatch) -> BenchResult:
    def refuse(*_: Any) -> Any:
        raise MissingDependencyError("open3d")

    monkeypatch.setattr(_bench_drawing, "make_subjects", lambda *_: [subject])
    what, _, is_peer = RENDERERS["open3d-rays"]
    monkeypatch.setitem(RENDERERS, "open3d-rays", (what, refuse, is_peer))
    return bench("drawing", size=SIZE, repeats=1)


def test_every_renderer_has_a_row_and_who_is_missing_says_so(result: BenchResult) -> None:
    assert result.baseline == "rasterizer"
    assert result.rows[0].name == "rasterizer/interior"
    assert result.rows[0].ratio == 1.0
    assert "open3d" in result.row("open3d-rays/interior").note
    for name in ("rasterizer", "photograph", "embree-rays"):
        row = result.row(f"{name}/interior")
        assert row.ms_median is not None
        assert row.ms_median > 0.0
    assert result.table().row_count == len(result.rows)


def test_lit_pictures_are_those_of_photographs(result: BenchResult) -> None:
    row = result.row("rasterizer/interior")
    assert row.same_surface is not None
    assert row.same_surface > 99.5
    assert row.psnr is not None
    assert row.psnr > 40.0
    assert result.row("photograph/interior").psnr is None  # it is what they are compared with
    assert result.row("embree-rays/interior").psnr is None


def test_rays_find_the_faces_that_are_drawn(subject: Subject) -> None:
    camera = subject.cameras[0]
    _, _, face = RENDERERS["rasterizer"][1](subject.model, 1)(camera)
    rays = RENDERERS["embree-rays"][1](subject.model, 1)(camera)
    assert np.mean(rays == face) > 0.99


def test_without_peers_there_are_none(subject: Subject, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_bench_drawing, "make_subjects", lambda *_: [subject])
    rows = bench("drawing", size=SIZE, repeats=1, peers=False, threads=1).rows
    assert [row.name.split("/")[0] for row in rows] == ["rasterizer", "opengl", "photograph"]
