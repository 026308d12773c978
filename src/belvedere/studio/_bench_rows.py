"""What a benchmark measured: rows, and the run they belong to."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

from belvedere.studio.machine import Machine

Suite = Literal["speed", "warp", "startup", "drawing"]
SUITES: tuple[Suite, ...] = ("speed", "warp", "startup", "drawing")
SCHEMA, VERSION = "belvedere.bench", 2


@dataclass(frozen=True, slots=True)
class BenchRow:
    """One measured contestant. What was not measured is None."""

    name: str
    """Unique among its run's rows with as many references, such as ``splat3/order/view``."""
    what: str
    """What the call does."""
    size: int | None
    """Pixels along both sides of reference and desired view."""
    threads: int | None
    """Threads it used."""
    references: int | None = None
    """Reference views that one picture is made from (suite "warp")."""
    ms_median: float | None = None
    ms_min: float | None = None
    ms_p90: float | None = None
    ns_per_sample: float | None = None
    """Median nanoseconds for each reference sample, so that sizes compare."""
    ratio: float | None = None
    """Median time over the median time of the run's baseline (with as many references)."""
    prepare_ms: float | None = None
    """Milliseconds for each reference of what is done once, whatever the desired cameras."""
    compile_s: float | None = None
    """Seconds of the first call in this process, in which kernels are compiled or loaded."""
    same_surface: float | None = None
    """Per cent of pixels in which a peer shows the surface, or the hole, that we show; of drawn
    polygons, that `photograph` shows."""
    same_color: float | None = None
    """Per cent of commonly covered pixels in which its colour is ours."""
    psnr: float | None = None
    """Decibels in truly seen pixels, holes filled by the nearest covered pixel; see `Quality`. On a
    scene, of the pixels that every contestant covers; of drawn polygons, to `photograph`."""
    ssim: float | None = None
    """Mean of the SSIM map over the same pixels."""
    cracks: float | None = None
    """Per cent of the truly seen pixels that are uncovered."""
    ghosts: float | None = None
    """Per cent of all pixels that are covered though no reference saw what is there."""
    holes: float | None = None
    """Per cent of a held-out photograph's pixels left uncovered (suite "warp" on a scene)."""
    wrong_depth: float | None = None
    """Per cent of the covered, truly seen pixels whose disparity is off by over 2 %."""
    megabytes: float | None = None
    """Working memory of a call at its highest, the result included, 10^6 bytes."""
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

    def row(self, name: str, references: int | None = None) -> BenchRow:
        """The row of that name, with that many references if there are several."""
        return next(
            row for row in self.rows if row.name == name and references in (None, row.references)
        )

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
