"""How fast and how good the library is on this machine, beside others that do the same job.

Ratios come from one run: contestants take turns in one process (see `_bench_timing`). Scenes are
made here from a seed.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from belvedere.ground.checks import check_choice, check_integer
from belvedere.ground.errors import InputError
from belvedere.ground.progress import Progress, silent
from belvedere.studio._bench_rows import SUITES, BenchResult, BenchRow, Suite
from belvedere.studio.machine import describe_machine

__all__ = ["SUITES", "BenchResult", "BenchRow", "Suite", "bench"]

REPEATS: dict[Suite, int] = {"speed": 30, "warp": 12, "startup": 5, "drawing": 10}
"""Timed calls of each contestant unless told otherwise."""
SMALLEST: dict[Suite, int] = {"speed": 8, "warp": 32, "startup": 8, "drawing": 8}
"""Pixels a side, at least."""


def bench(
    suite: Suite = "speed",
    size: int = 512,
    repeats: int | None = None,
    threads: int | None = None,
    peers: bool = True,
    progress: Progress = silent,
    *,
    references: Sequence[int] = (2,),
    held_out: bool = False,
    scene: str | Path | None = None,
    output: str | Path | None = None,
    force: bool = False,
    cache: Path | None = None,
) -> BenchResult:
    """Measure this machine.

    Args:
        suite: "speed": every reconstructor in every use, beside peers and the time that copying
            as many bytes takes; "warp": the picture as well as the time of every reconstructor
            and its rivals, against what the desired cameras truly show; "startup": whole
            processes and first calls; "drawing": polygons, beside OpenGL and ray casters.
        size: pixels along both sides of every picture ("speed", "warp", "drawing").
        repeats: timed calls of each contestant; processes of each kind ("startup", at most 5, cold
            kernels once). None for what suits the suite.
        threads: how many to use; by default both one and as many as there are processors.
        peers: whether other libraries are measured too ("speed", "warp", "drawing").
        progress: told how far the run is.
        references: how many reference views each picture is made from, every number in turn
            ("warp").
        held_out: judge at other stations in another house, to check what was tuned ("warp").
        scene: any posed pictures with depth that `read_views` opens: each is held out and predicted
            from its best neighbours, instead of the stations; ``size`` is the pictures' own
            ("warp").
        output: folder for every picture, its difference from the truth and its coverage, with
            bench.json ("warp").
        force: replace that folder.
        cache: folder in which the stations' photographs are kept between runs ("warp").

    Raises:
        InputError: an unknown suite, a size too small, no repeats, a number of references that
            the stations do not have, a folder or a scene for a suite without pictures, a scene
            that is held out as well.
        SceneError: a scene with too few views with depth, or what `read_views` raises.
        OutputError: the folder exists and ``force`` is False.
        MissingDependencyError: embreex is not installed ("warp", "drawing").
    """
    check_choice("bench", "suite", suite, SUITES)
    check_integer("bench", "size", size, SMALLEST[suite], 8192)
    count = REPEATS[suite] if repeats is None else repeats
    check_integer("bench", "repeats", count, 1, 10_000)
    if output is not None and suite != "warp":
        raise InputError(f"bench.output: suite {suite!r} makes no pictures, only 'warp' does")
    if scene is not None and (suite != "warp" or held_out):
        raise InputError(
            "bench.scene goes with suite 'warp' and without held_out, which names other stations: "
            f"got suite {suite!r}, held_out {held_out}"
        )
    before = _load()
    if suite == "startup":
        from belvedere.studio._bench_startup import BASELINE, startup_rows

        rows, baseline = startup_rows(min(count, 5), progress), BASELINE
        return _result(suite, baseline, count, threads, before, rows)
    if suite == "speed":
        from belvedere.studio._bench_speed import speed_rows

        rows, baseline = speed_rows(size, count, threads, peers, progress)
        return _result(suite, baseline, count, threads, before, rows)
    if suite == "drawing":
        from belvedere.studio._bench_drawing import drawing_rows

        rows, baseline = drawing_rows(size, count, threads, peers, progress)
        return _result(suite, baseline, count, threads, before, rows)
    from belvedere.studio._bench_stations import make_stations
    from belvedere.studio._bench_warp import BASELINE, Plan, check_free, warp_rows, write_run

    plan = Plan.of(references, threads, peers, count)
    target = None if output is None else check_free(Path(output), force)
    pictures = None if target is None else {}
    if scene is not None:
        from belvedere.scene.io import read_views
        from belvedere.studio._bench_captured import captured_rows

        rows = captured_rows(read_views(scene), plan, progress, pictures)
    else:
        stations = make_stations(size, held_out, cache, threads, progress)
        rows = warp_rows(stations, plan, progress, pictures)
    result = _result(suite, BASELINE, count, threads, before, rows)
    if target is not None and pictures is not None:
        write_run(target, result.as_dict(), pictures, force)
    return result


def _result(
    suite: Suite,
    baseline: str,
    repeats: int,
    threads: int | None,
    before: float | None,
    rows: Sequence[BenchRow],
) -> BenchResult:
    machine = describe_machine(threads)
    return BenchResult(suite, baseline, repeats, machine, (before, _load()), tuple(rows))


def _load() -> float | None:
    return round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None
