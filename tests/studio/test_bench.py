"""The benchmark runs, says what it measured, and its rivals do the same job."""

from __future__ import annotations

import io
import json
import math
from dataclasses import replace

import numpy as np
import pytest

from belvedere.ground.errors import BelvedereError, InputError, MissingDependencyError
from belvedere.ground.progress import silent
from belvedere.scene import Camera, ReferenceView
from belvedere.studio import _bench_speed, _bench_startup
from belvedere.studio._bench_peers import PEERS, Peer, Picture, agreement
from belvedere.studio._bench_scene import BenchScene, make_room
from belvedere.studio._bench_speed import warp_choices
from belvedere.studio._bench_timing import Contestant, time_interleaved
from belvedere.studio.bench import BenchResult, BenchRow, bench
from belvedere.warp import warp

SIZE = 48


@pytest.fixture(scope="module")
def room() -> BenchScene:
    return make_room(SIZE)


@pytest.fixture(scope="module")
def result() -> BenchResult:
    return bench("speed", size=SIZE, repeats=2, peers=True)


def plane_and_camera() -> tuple[ReferenceView, Camera]:
    """A textured plane 2 metres away, and a camera three pixels' shift to the left of the first."""
    camera = Camera.look_at((0, 0, 0), (1, 0, 0), fov_deg=60, width=64, height=64)
    color = np.random.default_rng(5).integers(0, 256, (64, 64, 3)).astype(np.uint8)
    aside = 3 * 2.0 / camera.intrinsics[0, 0]
    desired = Camera.look_at((0, aside, 0), (1, aside, 0), fov_deg=60, width=64, height=64)
    view = ReferenceView(camera, color, np.full((64, 64), 0.5, np.float32))
    return view, desired


def test_the_room_is_the_same_every_time_and_another_for_another_seed(room: BenchScene) -> None:
    again, other = make_room(SIZE), make_room(SIZE, seed=1)
    for one, two in zip(room.views, again.views, strict=True):
        np.testing.assert_array_equal(one.color, two.color)
        np.testing.assert_array_equal(one.disparity, two.disparity)
    assert not np.array_equal(room.views[0].color, other.views[0].color)


def test_the_room_has_depth_everywhere_and_edges_in_it() -> None:
    view = make_room(128).views[0]
    assert np.isfinite(view.disparity).all()
    assert (view.disparity > 0).all()
    jumps = np.abs(np.diff(view.disparity, axis=1)) / view.disparity[:, 1:]
    assert 0.01 < np.mean(jumps > 0.05) < 0.2


def test_the_depth_of_the_room_is_the_same_seen_from_both_references() -> None:
    room = make_room(128)
    moved = warp(room.views[0], room.views[1].camera, reconstruction="point")
    seen = moved.coverage > 0
    ratio = moved.disparity[seen] / room.views[1].disparity[seen]
    assert np.mean(np.abs(ratio - 1) < 0.02) > 0.9


def test_every_contestant_is_measured(result: BenchResult) -> None:
    names = [row.name for row in result.rows]
    assert len(set(names)) == len(names)
    for name in warp_choices():
        for use in ("order", "order/view", "zbuffer", "order/two"):
            assert f"{name}/{use}" in names
    assert {"copy", "numpy", "numpy-sort", "open3d", "opencv"} <= set(names)
    for row in result.rows:
        if row.ms_median is None:
            assert "pip install" in row.note
            continue
        assert row.ms_min is not None
        assert row.ms_p90 is not None
        assert 0 < row.ms_min <= row.ms_median <= row.ms_p90


def test_ratios_refer_to_the_named_baseline(result: BenchResult) -> None:
    assert result.baseline == "point/order"
    unit = result.row(result.baseline)
    assert unit.ratio == 1.0
    copy = result.row("copy")
    assert copy.ms_median is not None
    assert unit.ms_median is not None
    assert copy.ratio == pytest.approx(copy.ms_median / unit.ms_median)
    assert unit.ns_per_sample == pytest.approx(unit.ms_median * 1e6 / SIZE**2)


def test_the_json_names_the_machine_and_has_no_nan(result: BenchResult) -> None:
    text = json.dumps(result.as_dict(), allow_nan=False)
    held = json.loads(text)
    assert held["schema"] == "belvedere.bench"
    assert held["version"] == 2
    assert held["machine"]["threads"] >= 1
    assert set(held) == {
        "schema", "version", "suite", "baseline", "repeats", "machine", "load_before",
        "load_after", "rows",
    }  # fmt: skip
    assert all(set(row) == set(held["rows"][0]) for row in held["rows"])


def test_the_table_prints_brackets_as_they_are(result: BenchResult) -> None:
    from rich.console import Console

    note = "not installed: pip install 'belvedere[peers]'"
    row = replace(result.rows[0], name="open3d[cpu]", note=note)
    page = io.StringIO()
    Console(file=page, width=200).print(replace(result, rows=(row,)).table())
    assert note in " ".join(page.getvalue().split())  # wrapped to the table's width
    assert "open3d[cpu]" in page.getvalue()


def test_the_table_holds_every_row(result: BenchResult) -> None:
    from rich.console import Console

    page = io.StringIO()
    Console(file=page, width=200).print(result.table())
    assert all(row.name in page.getvalue() for row in result.rows)


def test_with_one_thread_nothing_runs_on_two() -> None:
    alone = bench("speed", size=16, repeats=1, threads=1, peers=False)
    assert {row.threads for row in alone.rows} == {1}
    assert not any(row.name == "numpy" for row in alone.rows)


@pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.name)
def test_each_peer_shows_a_plane_as_we_do(peer: Peer) -> None:
    view, camera = plane_and_camera()
    try:
        run = peer.make(view, camera, 1)
    except MissingDependencyError as missing:
        pytest.skip(f"{missing} is not installed")
    ours = warp(view, camera, reconstruction="point", visibility="zbuffer")
    surface, color = agreement(run(), ours)
    if peer.name == "opencv-warpframe":  # rounds down: here to either side of a pixel's centre
        assert surface > 90
        return
    assert surface > 98
    assert color > 98


def test_agreement_sees_another_surface_and_another_colour() -> None:
    view, camera = plane_and_camera()
    frame = warp(view, camera, reconstruction="point")
    depth = np.where(frame.coverage > 0, 1.0 / np.nan_to_num(frame.disparity, nan=1.0), 0.0)
    depth = depth.astype(np.float32)
    assert agreement(Picture(frame.color, depth), frame) == (100.0, 100.0)
    surface, _ = agreement(Picture(frame.color, depth * np.float32(1.1)), frame)
    assert surface == pytest.approx(100.0 * frame.hole_fraction)
    assert agreement(Picture(255 - frame.color, depth), frame)[1] < 20


def test_a_missing_library_is_a_row_that_says_what_to_install(
    room: BenchScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "open3d", None)
    peer = next(one for one in PEERS if one.name == "open3d")
    row = _bench_speed._peer_contestant(peer, room, 1)
    assert isinstance(row, BenchRow)
    assert row.note == "Open3D is not installed: pip install 'belvedere[peers]'"
    assert row.ms_median is None


def test_contestants_take_turns() -> None:
    order: list[str] = []
    contestants = [
        Contestant(name, "", 1, lambda name=name: order.append(name), 1) for name in "abc"
    ]
    times = time_interleaved(contestants, 3, silent)
    assert "".join(order) == "abc" + "aabbcc" + "bbccaa" + "ccaabb"
    assert [len(one.ms) for one in times] == [3, 3, 3]
    assert times[0].percentile(100) == max(times[0].ms)


def test_progress_is_told_to_the_end() -> None:
    told: list[tuple[int, int, str]] = []
    bench("speed", size=8, repeats=1, threads=1, peers=False, progress=lambda *a: told.append(a))
    assert told[-1][:2] == (1, 1)
    assert all(0 <= done <= total for done, total, _ in told)


def test_a_process_that_fails_is_an_error_with_its_last_line() -> None:
    with pytest.raises(BelvedereError, match="process 'x' failed: RuntimeError: boom"):
        _bench_startup._run("x", ["-c", "raise RuntimeError('boom')"], {})


def test_starting_up_is_measured_in_whole_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_bench_startup, "FIRST_CALLS", ())
    started = bench("startup", repeats=1)
    assert started.row("import belvedere").ratio is not None
    bare, loaded = started.row("python").ms_median, started.row("import belvedere").ms_median
    assert bare is not None
    assert loaded is not None
    assert math.isfinite(loaded)


def test_unknown_suites_and_sizes_are_refused() -> None:
    with pytest.raises(InputError, match="suite"):
        bench("wrap")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="size"):
        bench(size=4)
    with pytest.raises(InputError, match="repeats"):
        bench(repeats=0)
