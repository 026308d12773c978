"""The suite "warp": every reconstructor and every rival, judged by its picture and by its time.

At each station all of them get the same references and show the same desired camera. Pictures are
judged once, since they do not depend on threads; times are taken by turns.
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer
from belvedere.ground.errors import InputError, MissingDependencyError
from belvedere.ground.progress import Progress
from belvedere.ground.threads import thread_count
from belvedere.scene import Camera, Frame, ReferenceView
from belvedere.studio._bench_field import FIELD
from belvedere.studio._bench_memory import peak_megabytes
from belvedere.studio._bench_quality import Quality, mean_quality, quality
from belvedere.studio._bench_rival import Rival, shown
from belvedere.studio._bench_rows import BenchRow
from belvedere.studio._bench_stations import MOST_REFERENCES, Station
from belvedere.studio._bench_timing import Contestant, Times, time_interleaved

BASELINE = "default"
RECORD = "bench.json"

Pictures = dict[str, npt.NDArray[np.uint8]]
"""File names and the pictures to be written there."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What is measured."""

    references: tuple[int, ...]
    threads: tuple[int, ...]
    """Thread counts to time, the largest first."""
    peers: bool
    repeats: int

    @classmethod
    def of(cls, references: Sequence[int], threads: int | None, peers: bool, repeats: int) -> Plan:
        """Checked; ``threads`` None means as many as there are, and one.

        Raises:
            InputError: no number of references, or one that the stations do not have.
        """
        if not references:
            raise InputError("bench.references is empty, expected numbers such as (1, 2, 5)")
        for number in references:
            check_integer("bench", "references", number, 1, MOST_REFERENCES)
        most = thread_count(threads)
        counts = (most, 1) if threads is None and most > 1 else (most,)
        return cls(tuple(dict.fromkeys(references)), counts, peers, repeats)


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A contestant with its references prepared, for one number of them."""

    rival: Rival
    prepared: list[Any]
    """For each station."""
    quality: Quality

    def variants(self, plan: Plan) -> list[tuple[str, int, int]]:
        """Its rows: name, the threads it is told to use, and those it uses."""
        fixed = self.rival.threads
        if fixed is not None:
            return [(self.rival.name, plan.threads[0], fixed or os.cpu_count() or 1)]
        return [
            (self.rival.name if index == 0 else f"{self.rival.name}/{count}t", count, count)
            for index, count in enumerate(plan.threads)
        ]


def our_entries() -> list[Rival]:
    """`belvedere.warp` without options, then with each reconstruction."""
    from belvedere.warp import RECONSTRUCTIONS

    ways: list[tuple[str, str, dict[str, Any]]] = [
        (BASELINE, "belvedere.warp(views, camera)", {}),
        *((name, f'belvedere.warp, reconstruction="{name}"', {"reconstruction": name})
          for name in RECONSTRUCTIONS),
    ]  # fmt: skip
    return [
        Rival(name, what, "", _prepare_ours, partial(_warp_ours, choices), lazy=True)
        for name, what, choices in ways
    ]


def _prepare_ours(views: Sequence[ReferenceView], threads: int) -> list[Any]:
    from belvedere.warp import prepare

    del threads
    return [prepare(view) for view in views]


def _warp_ours(choices: dict[str, Any], prepared: Any, camera: Camera, threads: int) -> Frame:
    from belvedere.warp import warp

    return warp(prepared, camera, threads=threads, **choices)


def warp_rows(
    stations: Sequence[Station], plan: Plan, progress: Progress, pictures: Pictures | None = None
) -> list[BenchRow]:
    """Every row of the suite; the pictures are added to ``pictures`` if it is given."""
    if pictures is not None:
        pictures |= {f"{station.slug}-truth.png": station.color for station in stations}
    rows: list[BenchRow] = []
    for count in plan.references:
        entries: list[Entry] = []
        missing: list[BenchRow] = []
        rivals = [*our_entries(), *(FIELD if plan.peers else ())]
        for index, rival in enumerate(rivals):
            progress(index, len(rivals), f"judging pictures from {counted_references(count)}")
            try:
                entries.append(_judge(rival, stations, count, plan, pictures))
            except MissingDependencyError as absent:
                size = stations[0].camera.width
                text = f"{absent} is not installed: {rival.install}"
                missing.append(
                    BenchRow(rival.name, rival.what, size, None, references=count, note=text)
                )
        progress(len(rivals), len(rivals), f"judging pictures from {counted_references(count)}")
        rows += _timed(entries, stations, count, plan, progress) + missing
    return rows


def counted_references(references: int) -> str:
    """Such as "2 references"."""
    from belvedere.ground.wording import counted

    return counted(references, "reference")


def _judge(
    rival: Rival, stations: Sequence[Station], count: int, plan: Plan, pictures: Pictures | None
) -> Entry:
    prepared, each = [], []
    for station in stations:
        ready = rival.prepare(station.views(count), plan.threads[0])
        color, disparity, covered = shown(rival.warp(ready, station.camera, plan.threads[0]))
        each.append(quality(color, disparity, covered, station, count))
        prepared.append(ready)
        if pictures is not None:
            pictures |= _pictures(rival.name, station, count, color, covered)
    return Entry(rival, prepared, mean_quality(each))


def _pictures(
    name: str, station: Station, count: int, color: Any, covered: npt.NDArray[np.bool_]
) -> Pictures:
    from belvedere.studio.difference import coverage_picture, picture_with_holes, signed_difference

    stem, coverage = f"{station.slug}-{count}-{name}", covered.astype(np.float32)
    return {
        f"{stem}.png": picture_with_holes(color, coverage),
        f"{stem}-difference.png": signed_difference(color, station.color, covered),
        f"{stem}-coverage.png": coverage_picture(color, coverage),
    }


def _timed(
    entries: list[Entry], stations: Sequence[Station], count: int, plan: Plan, progress: Progress
) -> list[BenchRow]:
    """Rows of the entries, timed by turns at one station after the other."""
    variants = [(entry, *rest) for entry in entries for rest in entry.variants(plan)]
    samples = count * stations[0].disparity.size
    taken: list[list[float]] = [[] for _ in variants]
    first: list[float] = []
    rounds = -(-plan.repeats // len(stations))
    for index, station in enumerate(stations):
        contestants = [
            Contestant(name, entry.rival.what, used,
                       partial(entry.rival.warp, entry.prepared[index], station.camera, told),
                       samples)
            for entry, name, told, used in variants
        ]  # fmt: skip
        timed = time_interleaved(contestants, rounds, progress)
        first = first or [one.first_s for one in timed]
        for held, one in zip(taken, timed, strict=True):
            held.extend(one.ms)
    times = [Times(begun, tuple(ms)) for begun, ms in zip(first, taken, strict=True)]
    unit = times[0].median
    return [
        _row(entry, name, told, used, stations, count, one, unit)
        for (entry, name, told, used), one in zip(variants, times, strict=True)
    ]


def _row(
    entry: Entry,
    name: str,
    told: int,
    used: int,
    stations: Sequence[Station],
    count: int,
    times: Times,
    unit: float,
) -> BenchRow:
    rival, judged = entry.rival, entry.quality
    run = partial(rival.warp, entry.prepared[0], stations[0].camera, told)
    return BenchRow(
        name=name,
        what=rival.what,
        size=stations[0].camera.width,
        threads=used,
        references=count,
        ms_median=times.median,
        ms_min=min(times.ms),
        ms_p90=times.percentile(90),
        ns_per_sample=times.median * 1e6 / (count * stations[0].disparity.size),
        ratio=times.median / unit,
        prepare_ms=_prepare_ms(rival, stations, count, told),
        compile_s=times.first_s,
        psnr=finite(judged.psnr),
        ssim=finite(judged.ssim),
        cracks=judged.cracks,
        ghosts=judged.ghosts,
        wrong_depth=judged.wrong_depth,
        megabytes=peak_megabytes(run),
    )


def finite(value: float) -> float | None:
    """A number as JSON can hold it: the PSNR of two equal pictures has none."""
    return value if np.isfinite(value) else None


def _prepare_ms(rival: Rival, stations: Sequence[Station], count: int, threads: int) -> float:
    """Milliseconds a reference, the median over the stations."""
    taken = []
    for station in stations:
        views = station.views(count)
        began = time.perf_counter()
        prepared = rival.prepare(views, threads)
        seconds = time.perf_counter() - began
        if rival.lazy:  # what the first picture takes more than the next
            ends = [time.perf_counter()]
            for _ in range(3):
                rival.warp(prepared, station.camera, threads)
                ends.append(time.perf_counter())
            first, *others = np.diff(ends)
            seconds += max(first - min(others), 0.0)
        taken.append(1000.0 * seconds / count)
    return float(np.median(taken))


def check_free(output: Path, force: bool) -> Path:
    """The folder to write, before the long work.

    Raises:
        OutputError: it exists and ``force`` is False, or it is none of ours.
    """
    from belvedere.scene.io.atomic import check_replaceable

    target = output.absolute()
    check_replaceable(target, force, RECORD)
    return target


def write_run(target: Path, record: dict[str, Any], pictures: Pictures, force: bool) -> None:
    """The pictures and bench.json in a new folder, all of them or none."""
    from belvedere.scene.io.atomic import staged_folder
    from belvedere.scene.io.images import write_color
    from belvedere.scene.io.json_files import write_json

    with staged_folder(target, force=force, owned_by=RECORD) as folder:
        for name, picture in pictures.items():
            write_color(folder / name, picture)
        write_json(folder / RECORD, record)
