"""How fast the library is on this machine, beside others that do the same job.

Ratios come from one run: contestants take turns in one process (see `_bench_timing`), and peers
say by how many pixels their picture agrees with ours. The scene is made here from a seed.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from belvedere.ground.checks import check_choice, check_integer
from belvedere.ground.errors import MissingDependencyError
from belvedere.ground.threads import thread_count
from belvedere.scene import Frame
from belvedere.studio._bench_peers import PEERS, Peer, agreement
from belvedere.studio._bench_scene import BenchScene, make_room
from belvedere.studio._bench_timing import Contestant, Times, time_interleaved
from belvedere.studio.machine import Machine, describe_machine
from belvedere.studio.progress import Progress, silent

Suite = Literal["warp", "startup"]
SUITES: tuple[Suite, ...] = ("warp", "startup")
BYTES_PER_SAMPLE = 18
"""What a point warp of ``uint8`` RGB must move: 7 bytes of colour and disparity in, 11 of colour,
disparity and coverage out."""
SCHEMA, VERSION = "belvedere.bench", 1


@dataclass(frozen=True, slots=True)
class BenchRow:
    """One measured contestant. What was not measured is None."""

    name: str
    """Unique in its run, such as ``splat3/order/view``."""
    what: str
    """What the call does."""
    size: int | None
    """Pixels along both sides of reference and desired view."""
    threads: int | None
    """Threads it used."""
    ms_median: float | None = None
    ms_min: float | None = None
    ms_p90: float | None = None
    ns_per_sample: float | None = None
    """Median nanoseconds for each reference sample, so that sizes compare."""
    ratio: float | None = None
    """Median time over the median time of the run's baseline."""
    compile_s: float | None = None
    """Seconds of the first call in this process, in which kernels are compiled or loaded."""
    same_surface: float | None = None
    """Per cent of pixels in which a peer shows the surface, or the hole, that we show."""
    same_color: float | None = None
    """Per cent of commonly covered pixels in which its colour is ours."""
    note: str = ""


@dataclass(frozen=True, slots=True)
class BenchResult:
    """A run of one suite."""

    suite: Suite
    baseline: str
    """Name of the row that ratios refer to."""
    repeats: int
    machine: Machine
    load: tuple[float | None, float | None]
    """Processes running or waiting (the system's one-minute average) before and after the run; a
    quiet machine starts near 0. None where the system does not tell."""
    rows: tuple[BenchRow, ...]

    def row(self, name: str) -> BenchRow:
        """The row of that name."""
        return next(row for row in self.rows if row.name == name)

    def table(self) -> Any:
        """A `rich.table.Table` of the rows."""
        from belvedere.studio._bench_table import bench_table

        return bench_table(self)

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "schema": SCHEMA,
            "version": VERSION,
            "suite": self.suite,
            "baseline": self.baseline,
            "repeats": self.repeats,
            "machine": self.machine.as_dict(),
            "load_before": self.load[0],
            "load_after": self.load[1],
            "rows": [asdict(row) for row in self.rows],
        }


def bench(
    suite: Suite = "warp",
    size: int = 512,
    repeats: int = 30,
    threads: int | None = None,
    peers: bool = True,
    progress: Progress = silent,
) -> BenchResult:
    """Measure this machine.

    Args:
        suite: "warp": every reconstructor, one reference and two, beside peers and the time that
            copying as many bytes takes; "startup": whole processes and first calls.
        size: pixels along both sides of every picture ("warp").
        repeats: timed calls of each contestant ("warp"); processes of each kind ("startup", at
            most 5, cold kernels once).
        threads: how many to use; by default both one and as many as there are processors.
        peers: whether other libraries are measured too ("warp").
        progress: told how far the run is.

    Raises:
        InputError: an unknown suite, a size below 8 or no repeats.
    """
    check_choice("bench", "suite", suite, SUITES)
    check_integer("bench", "size", size, 8, 8192)
    check_integer("bench", "repeats", repeats, 1, 10_000)
    before = _load()
    if suite == "startup":
        from belvedere.studio._bench_startup import BASELINE, startup_rows

        rows, baseline = startup_rows(min(repeats, 5), progress), BASELINE
    else:
        rows, baseline = _warp_rows(size, repeats, threads, peers, progress)
    return BenchResult(
        suite, baseline, repeats, describe_machine(threads), (before, _load()), tuple(rows)
    )


def warp_choices() -> dict[str, dict[str, Any]]:
    """The reconstructors as they are measured: name to choices of `belvedere.warp`."""
    from belvedere.warp import OffsetOptions, SplatOptions

    return {
        "point": {"reconstruction": "point"},
        "splat3": {"reconstruction": "splat", "splat": SplatOptions(size=3)},
        "splat-jacobian": {"reconstruction": "splat", "splat": SplatOptions(size="jacobian")},
        "mesh": {"reconstruction": "mesh"},
        "offset": {"reconstruction": "offset"},
        "offset-full": {"reconstruction": "offset", "offset": OffsetOptions(density=4)},
    }


def warp_contestants(scene: BenchScene, threads: int | None = None) -> Iterator[Contestant]:
    """Our own ways of warping the room, the baseline first."""
    from belvedere.warp import prepare, warp

    most = thread_count(threads)
    views, camera = scene.views, scene.camera
    prepared = tuple(prepare(view) for view in views)
    samples = views[0].disparity.size
    uses = [
        ("order", "order", prepared[0], "one prepared reference", most),
        ("order/view", "order", views[0], "one view, preparing it included", most),
        ("zbuffer", "zbuffer", prepared[0], "one prepared reference", most),
        ("order/two", "order", prepared, "two prepared references, blended", most),
    ]
    if threads is None and most > 1:
        uses.insert(1, ("order/1t", "order", prepared[0], "one prepared reference", 1))
    for suffix, visibility, given, text, count in uses:
        for name, choices in warp_choices().items():
            references = len(given) if isinstance(given, tuple) else 1

            def run(
                given: Any = given,
                visibility: Any = visibility,
                count: int = count,
                choices: dict[str, Any] = choices,
            ) -> Frame:
                return warp(given, camera, visibility=visibility, threads=count, **choices)

            yield Contestant(
                f"{name}/{suffix}", f"{text}, {visibility}", count, run, samples * references
            )


def copy_contestant(samples: int) -> Contestant:
    """Copying as many bytes as a point warp must move: the least time it could take."""
    source = np.ones(samples * BYTES_PER_SAMPLE // 2, np.uint8)
    target = np.empty_like(source)

    def run() -> None:
        np.copyto(target, source)

    return Contestant("copy", "memory copy, half of the bytes read and half written", 1, run,
                      samples)  # fmt: skip


def _warp_rows(
    size: int, repeats: int, threads: int | None, peers: bool, progress: Progress
) -> tuple[list[BenchRow], str]:
    progress(0, 1, "making the room")
    scene = make_room(size)
    contestants = [*warp_contestants(scene, threads), copy_contestant(size * size)]
    baseline = contestants[0].name
    missing: list[BenchRow] = []
    for peer in PEERS if peers else ():
        rival = _peer_contestant(peer, scene, threads)
        if isinstance(rival, Contestant):
            contestants.append(rival)
        else:
            missing.append(rival)
    times = time_interleaved(contestants, repeats, progress)
    agreed = _agreements(scene, contestants)
    unit = times[0].median
    rows = [
        _row(one, taken, size, unit, agreed.get(one.name))
        for one, taken in zip(contestants, times, strict=True)
    ]
    return rows + missing, baseline


def _peer_contestant(peer: Peer, scene: BenchScene, threads: int | None) -> Contestant | BenchRow:
    told = thread_count(threads)
    used = {None: told, 0: os.cpu_count() or 1}.get(peer.threads, peer.threads)
    view = scene.views[0]
    try:
        run = peer.make(view, scene.camera, told)
    except MissingDependencyError as missing:
        return BenchRow(peer.name, peer.what, view.camera.width, None,
                        note=f"{missing} is not installed: {peer.install}")  # fmt: skip
    return Contestant(peer.name, peer.what, used, run, view.disparity.size)


def _agreements(scene: BenchScene, contestants: list[Contestant]) -> dict[str, tuple[float, float]]:
    """Each peer's picture beside our point warp with a z-buffer, which is the job they do."""
    from belvedere.warp import warp

    names = {peer.name for peer in PEERS}
    ours = warp(scene.views[0], scene.camera, reconstruction="point", visibility="zbuffer")
    return {one.name: agreement(one.run(), ours) for one in contestants if one.name in names}


def _row(
    one: Contestant, taken: Times, size: int, unit: float, agreed: tuple[float, float] | None
) -> BenchRow:
    note = one.note
    if one.name == "copy":
        speed = one.samples * BYTES_PER_SAMPLE / (taken.median * 1e6)
        note = f"{BYTES_PER_SAMPLE} bytes a sample at {speed:.1f} GB/s on one thread"
    surface, color = agreed if agreed is not None else (None, None)
    return BenchRow(
        name=one.name,
        what=one.what,
        size=size,
        threads=one.threads,
        ms_median=taken.median,
        ms_min=min(taken.ms),
        ms_p90=taken.percentile(90),
        ns_per_sample=taken.median * 1e6 / one.samples,
        ratio=taken.median / unit,
        compile_s=taken.first_s,
        same_surface=surface,
        same_color=color,
        note=note,
    )


def _load() -> float | None:
    return round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None
