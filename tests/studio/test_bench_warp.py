"""The suite "warp" measures everybody, and its rivals do the job they say."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest

from belvedere.ground.errors import InputError, MissingDependencyError, OutputError
from belvedere.scene import Camera, ReferenceView
from belvedere.studio import _bench_compiled, _bench_warp
from belvedere.studio._bench_compiled import prepare_c, warp_c
from belvedere.studio._bench_field import FIELD
from belvedere.studio._bench_memory import peak_megabytes
from belvedere.studio._bench_peers import Picture
from belvedere.studio._bench_rival import Rival, fuse_nearest, shown
from belvedere.studio._bench_scene import make_room
from belvedere.studio.bench import BenchResult, bench
from belvedere.warp import RECONSTRUCTIONS, warp

SIZE = 48
SLOW = {"torch-softmax", "torch-splat", "open3d-cloud"}
"""Rivals whose libraries take seconds to load."""
NEAREST = {"c-point", "open3d-cloud"}
"""Rivals that do not interpolate: up to half a pixel off, 2 levels of the plane's shade."""


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("bench")


@pytest.fixture(scope="module")
def result(kept: Path) -> BenchResult:
    return bench(
        "warp", size=SIZE, repeats=1, threads=1, peers=False, references=(2, 1),
        output=kept / "run", cache=kept / "stations",
    )  # fmt: skip


def rival(name: str) -> Rival:
    return next(one for one in FIELD if one.name == name)


def test_every_reconstructor_is_judged_and_timed_with_every_number_of_references(
    result: BenchResult,
) -> None:
    names = ["default", *RECONSTRUCTIONS]
    assert [(row.name, row.references) for row in result.rows] == [
        (name, count) for count in (2, 1) for name in names
    ]
    for row in result.rows:
        assert row.psnr is not None
        assert 15 < row.psnr < 60
        assert row.ssim is not None
        assert 0.3 < row.ssim <= 1
        for share in (row.cracks, row.ghosts, row.wrong_depth):
            assert share is not None
            assert 0 <= share <= 100
        assert row.ms_median is not None
        assert row.prepare_ms is not None
        assert row.megabytes is not None
        assert row.megabytes >= SIZE * SIZE * 11 / 1e6  # the frame itself


def test_ratios_are_to_the_default_with_as_many_references(result: BenchResult) -> None:
    assert result.baseline == "default"
    for count in (1, 2):
        unit, mesh = result.row("default", count), result.row("mesh", count)
        assert unit.ratio == 1.0
        assert unit.ms_median is not None
        assert mesh.ms_median is not None
        assert mesh.ratio == pytest.approx(mesh.ms_median / unit.ms_median)


def test_points_leave_more_cracks_than_meshes(result: BenchResult) -> None:
    points, mesh = result.row("point", 2), result.row("mesh", 2)
    assert points.cracks is not None
    assert mesh.cracks is not None
    assert points.cracks > mesh.cracks


def test_pictures_are_written_and_never_replaced_unasked(result: BenchResult, kept: Path) -> None:
    folder = kept / "run"
    names = {file.name for file in folder.iterdir()}
    assert {"bench.json", "hall-truth.png", "kitchen-1-mesh.png", "kitchen-2-mesh-coverage.png",
            "living-room-2-default-difference.png"} <= names  # fmt: skip
    assert len(names) == 1 + 3 + 3 * 3 * len(result.rows)
    assert json.loads((folder / "bench.json").read_text())["suite"] == "warp"
    with pytest.raises(OutputError, match="--force"):
        bench("warp", size=SIZE, output=folder, cache=kept / "stations")


def test_the_table_fits_eighty_columns_and_the_json_has_no_nan(result: BenchResult) -> None:
    from rich.console import Console

    page = io.StringIO()
    Console(file=page, width=80).print(result.table())
    assert "…" not in page.getvalue()
    assert "crack" in page.getvalue()
    json.dumps(result.as_dict(), allow_nan=False)


def test_wrong_plans_are_refused_before_the_work() -> None:
    with pytest.raises(InputError, match="references is empty"):
        bench("warp", references=())
    with pytest.raises(InputError, match=r"bench\.references is 6"):
        bench("warp", references=(2, 6))
    with pytest.raises(InputError, match="makes no pictures"):
        bench("speed", output="somewhere")


def test_one_thread_more_is_one_row_more(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_bench_warp, "thread_count", lambda threads: threads or 3)
    assert _bench_warp.Plan.of((2,), None, False, 1).threads == (3, 1)
    assert _bench_warp.Plan.of((2,), 3, False, 1).threads == (3,)
    assert _bench_warp.Plan.of((2, 1, 2), 1, False, 1).references == (2, 1)


def test_the_compiled_bound_is_our_point_warp() -> None:
    room = make_room(96)
    try:
        prepared = prepare_c(room.views[:1], 1)
    except MissingDependencyError as missing:
        pytest.skip(f"{missing} is not installed")
    color, disparity, covered = shown(warp_c(prepared, room.camera, 1))
    ours = warp(room.views[0], room.camera, reconstruction="point", visibility="zbuffer")
    same = covered == (ours.coverage > 0)
    both = covered & (ours.coverage > 0)
    same[both] &= (color[both] == ours.color[both]).all(axis=-1)
    same[both] &= np.isclose(disparity[both], ours.disparity[both], rtol=1e-5)
    assert same.mean() >= 0.999


def test_without_a_compiler_the_row_says_so(monkeypatch: pytest.MonkeyPatch, kept: Path) -> None:
    monkeypatch.setattr(_bench_compiled, "COMPILERS", ("no such compiler",))
    monkeypatch.setattr(_bench_warp, "FIELD", (rival("c-point"),))
    _bench_compiled.compiled_warp.cache_clear()
    found = bench("warp", size=SIZE, repeats=1, threads=1, cache=kept / "stations")
    row = found.row("c-point")
    assert row.note.startswith("a C compiler is not installed: a C compiler such as gcc")
    assert row.ms_median is None


@pytest.mark.parametrize(
    "one",
    [pytest.param(one, marks=[pytest.mark.slow] if one.name in SLOW else []) for one in FIELD],
    ids=lambda one: one.name,
)
def test_each_rival_shows_a_plane_where_it_is(one: Rival) -> None:
    """Two references of a shaded plane, shown half a pixel's shift and more away."""
    views = [plane_seen_from(aside) for aside in (0.0, 0.05)]
    wanted = plane_seen_from(0.02)
    assert isinstance(wanted.camera, Camera)
    try:
        prepared = one.prepare(views, 1)
    except MissingDependencyError as missing:
        pytest.skip(f"{missing} is not installed")
    color, disparity, covered = shown(one.warp(prepared, wanted.camera, 1))
    inner = np.zeros_like(covered)
    inner[4:-4, 4:-4] = True
    assert covered[inner].mean() > 0.97
    np.testing.assert_allclose(disparity[inner & covered], 0.5, rtol=1e-3)
    apart = color[inner & covered].astype(int) - wanted.color[inner & covered].astype(int)
    assert abs(apart).max() <= 5
    assert abs(apart.mean(axis=0)).max() < (2.0 if one.name in NEAREST else 0.8)


def plane_seen_from(aside: float) -> ReferenceView:
    """A wall 2 metres away whose colour changes by some four levels a pixel."""
    camera = Camera.look_at((0, aside, 0), (1, aside, 0), fov_deg=60, width=SIZE, height=SIZE)
    v, u = np.mgrid[0:SIZE, 0:SIZE]
    disparity = np.full((SIZE, SIZE), 0.5, np.float32)
    points = camera.unproject(u, v, disparity.astype(float))
    shade = 128 + 80 * np.stack([points[..., 1], points[..., 2], -points[..., 1]], axis=-1)
    return ReferenceView(camera, np.rint(shade).astype(np.uint8), disparity)


def test_fusing_takes_the_nearest_surface_and_the_mean_where_they_agree() -> None:
    def picture(level: int, *depth: float) -> Picture:
        row = np.array([depth], np.float32)
        return Picture(np.full((1, len(depth), 3), level, np.uint8), row)

    fused = fuse_nearest([picture(100, 1.0, 2.0, 0.0, 3.0), picture(200, 2.0, 2.01, 4.0, 0.0)])
    np.testing.assert_array_equal(fused.color[0, :, 0], [100, 150, 200, 100])
    np.testing.assert_allclose(fused.depth[0], [1.0, 2.0, 4.0, 3.0])
    nothing = fuse_nearest([picture(9, 0.0), picture(9, np.nan)])
    assert nothing.depth[0, 0] == 0.0
    assert not nothing.color.any()


def test_memory_is_what_a_call_takes_at_most() -> None:
    def call() -> None:
        for _ in range(3):
            np.ones(1_000_000)  # 8 MB, freed at once

    assert 8.0 <= peak_megabytes(call) < 30.0


def test_kept_scratch_counts_as_in_a_first_call() -> None:
    from belvedere.ground.scratch import scratch

    def call() -> None:
        scratch("bench test", (1_000_000,), np.float64).fill(0.0)

    call()
    assert peak_megabytes(call) >= 8.0
