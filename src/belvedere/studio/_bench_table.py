"""A benchmark's rows for people to read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from belvedere.studio.bench import BenchResult

if TYPE_CHECKING:
    from rich.table import Table

COLUMNS = (
    ("median ms", "ms_median", ".2f"),
    ("min", "ms_min", ".2f"),
    ("90 %", "ms_p90", ".2f"),
    ("ns/sample", "ns_per_sample", ".2f"),
    ("ratio", "ratio", ".2f"),
    ("first s", "compile_s", ".2f"),
    ("surface %", "same_surface", ".1f"),
    ("colour %", "same_color", ".1f"),
)
"""Heading, field and format of the numbers; columns without any number are left out."""


def bench_table(result: BenchResult) -> Table:
    """The rows of a run; what each is and its note stand in the JSON, notes of gaps here too."""
    from rich.table import Table

    loads = [f"{load:.2f}" for load in result.load if load is not None]
    table = Table(
        title=f"{result.suite}: ratios to {result.baseline!r}",
        caption=f"load of the machine: {', then '.join(loads)}" if loads else None,
    )
    columns = [
        (head, field, form)
        for head, field, form in COLUMNS
        if any(getattr(row, field) is not None for row in result.rows)
    ]
    table.add_column("contestant")
    table.add_column("threads", justify="right")
    for head, _, _ in columns:
        table.add_column(head, justify="right")
    noted = any(row.note for row in result.rows)
    if noted:
        table.add_column("note")
    for row in result.rows:
        numbers = [
            "" if (value := getattr(row, field)) is None else format(value, form)
            for _, field, form in columns
        ]
        threads = "" if row.threads is None else str(row.threads)
        table.add_row(row.name, threads, *numbers, *([row.note] if noted else []))
    return table
