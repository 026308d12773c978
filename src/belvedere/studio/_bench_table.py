"""A benchmark's rows for people to read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from belvedere.studio.bench import BenchResult

if TYPE_CHECKING:
    from rich.table import Table

COLUMNS = (
    ("median", "ms_median", ".2f"),
    ("min ms", "ms_min", ".2f"),
    ("ns/smp", "ns_per_sample", ".1f"),
    ("ratio", "ratio", ".2f"),
    ("surf%", "same_surface", ".1f"),
    ("col%", "same_color", ".1f"),
)
"""Heading, field and format of the numbers that fit 80 columns; the JSON has the others. Columns
without any number are left out."""


def bench_table(result: BenchResult) -> Table:
    """The rows of a run, with their notes and the machine's load below."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    notes = [f"{row.name}: {row.note}" for row in result.rows if row.note]
    loads = [f"{load:.2f}" for load in result.load if load is not None]
    if loads:
        notes.append(f"load of the machine: {', then '.join(loads)}")
    table = Table(
        title=Text(f"{result.suite}: ratios to {result.baseline!r}", "table.title"),
        caption=Text("\n".join(notes), "table.caption"),  # plain: "belvedere[peers]" is no markup
        caption_justify="left",
        box=box.SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
    )
    columns = [
        (head, field, form)
        for head, field, form in COLUMNS
        if any(getattr(row, field) is not None for row in result.rows)
    ]
    threaded = any(row.threads is not None for row in result.rows)
    table.add_column("contestant", no_wrap=True)
    if threaded:
        table.add_column("thr", justify="right", no_wrap=True)
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
