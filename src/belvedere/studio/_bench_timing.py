"""Timing several ways of doing one job so that their times compare."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from belvedere.ground.progress import Progress


@dataclass(frozen=True, slots=True, eq=False)
class Contestant:
    """Something to be timed."""

    name: str
    what: str
    threads: int | None
    run: Callable[[], Any]
    samples: int
    """Reference samples that one call warps."""
    note: str = ""


@dataclass(frozen=True, slots=True)
class Times:
    """What was measured of one contestant."""

    first_s: float
    """The first call of this process, seconds: compiling or loading kernels is in it."""
    ms: tuple[float, ...]
    """Each warm call, milliseconds, in the order they ran."""

    @property
    def median(self) -> float:
        """Milliseconds that half the calls stay below."""
        return float(np.median(self.ms))

    def percentile(self, share: float) -> float:
        """Milliseconds that ``share`` per cent of the calls stay below."""
        return float(np.percentile(self.ms, share))


def time_interleaved(
    contestants: Sequence[Contestant], repeats: int, progress: Progress
) -> list[Times]:
    """Time every contestant ``repeats`` times, taking turns.

    Each round runs every contestant once, starting one further on each time, so that whatever the
    machine does meanwhile (clock, neighbours, cache) meets all of them alike. The call before the
    timed one is the contestant's own, untimed: each finds the caches as a loop of its own leaves
    them. Garbage is collected between rounds, never while the clock runs.
    """
    first = []
    for index, one in enumerate(contestants):
        progress(index, len(contestants), "first calls (kernels compile once)")
        began = time.perf_counter()
        one.run()
        first.append(time.perf_counter() - began)
    taken: list[list[float]] = [[] for _ in contestants]
    collecting = gc.isenabled()
    gc.disable()
    try:
        for turn in range(repeats):
            progress(turn, repeats, "timing")
            gc.collect()
            for step in range(len(contestants)):
                index = (turn + step) % len(contestants)
                run = contestants[index].run
                run()
                began = time.perf_counter()
                run()
                taken[index].append(1000.0 * (time.perf_counter() - began))
    finally:
        if collecting:
            gc.enable()
    progress(repeats, repeats, "timing")
    return [Times(begun, tuple(each)) for begun, each in zip(first, taken, strict=True)]
