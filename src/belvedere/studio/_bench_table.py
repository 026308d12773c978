"""A benchmark's rows for people to read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from belvedere.studio._bench_rows import BenchResult

if TYPE_CHECKING:
    from rich.table import Table

COLUMNS = (
    ("median", "ms_median", ".2f"),
    ("min ms", "ms_min", ".2f"),
    ("ns/smp", "ns_per_sample", ".1f"),
    ("ratio", "ratio", ".2f"),
    ("surf%", "same_surface", ".1f"),
    ("col%", "same_color", ".1f"),
    ("PSNR", "psnr", ".1f"),
)
"""Heading, field and format of the numbers that fit 80 columns; the JSON has the others. Columns
without any number are left out."""

WARP_COLUMNS = (
    ("n", "references", "d"),
    ("ms", "ms_median", ".1f"),
    ("ratio", "ratio", ".2f"),
    ("prep", "prepare_ms", ".0f"),
    ("PSNR", "psnr", ".2f"),
    ("SSIM", "ssim", ".4f"),
    ("crack", "cracks", ".2f"),
    ("ghost", "ghosts", ".2f"),
    ("depth", "wrong_depth", ".2f"),
    ("hole", "holes", ".1f"),
    ("MB", "megabytes", ".0f"),
)
"""The same for suite "warp"."""
WARP_LEGEND = (
    "t: threads; n: references; ms: median; prep: ms to prepare one; PSNR (dB) and SSIM of what "
    "a reference truly saw; crack: % of that left open; ghost: % painted that none saw; depth: % "
    "painted at another depth; MB: working memory. Means over the stations."
)

SCENE_LEGEND = (
    "t: threads; n: references; ms: median; PSNR (dB) and SSIM of the pixels that everybody "
    "covers; hole: % of the picture left open; MB: working memory. Means over the held-out views."
)


def bench_table(result: BenchResult) -> Table:
    """The rows of a run, with their notes and the machine's load below."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    notes = [f"{row.name}: {row.note}" for row in result.rows if row.note]
    loads = [f"{load:.2f}" for load in result.load if load is not None]
    if loads:
        notes.append(f"load of the machine: {', then '.join(loads)}")
    if result.suite == "warp":
        captured = any(row.holes is not None for row in result.rows)
        notes.insert(0, SCENE_LEGEND if captured else WARP_LEGEND)
    table = Table(
        title=Text(f"{result.suite}: ratios to {result.baseline!r}", "table.title"),
        caption=Text("\n".join(notes), "table.caption"),  # plain: "belvedere[peers]" is no markup
        caption_justify="left",
        box=box.SIMPLE_HEAD,
        padding=(0, 0 if result.suite == "warp" else 1, 0, 0),
    )
    columns = [
        (head, field, form)
        for head, field, form in (WARP_COLUMNS if result.suite == "warp" else COLUMNS)
        if any(getattr(row, field) is not None for row in result.rows)
    ]
    threaded = any(row.threads is not None for row in result.rows)
    table.add_column("contestant", no_wrap=True)
    if threaded:
        table.add_column("t" if result.suite == "warp" else "thr", justify="right", no_wrap=True)
    for head, _, _ in columns:
        table.add_column(head, justify="right", no_wrap=True)
    for row in result.rows:
        numbers = [
            "" if (value := getattr(row, field)) is None else format(value, form)
            for _, field, form in columns
        ]
        threads = "" if row.threads is None else str(row.threads)
        table.add_row(Text(row.name), *([threads] if threaded else []), *numbers)
    return table
