"""``belvedere bench`` as a person types it."""

from __future__ import annotations

import json

from tests.cli.conftest import Program


def test_plain_bench_measures_speed(program: Program) -> None:
    told = program("bench", "--size", 16, "--repeats", 1, "--no-peers", "--json")
    assert told.status == 0
    held = json.loads(told.out)
    assert held["suite"] == "speed"
    assert held["baseline"] == "point/order"


def test_bench_warp_judges_pictures(program: Program) -> None:
    told = program(
        "bench", "warp", "--size", 32, "--repeats", 1, "--no-peers", "--refs", "1", "--json"
    )
    assert told.status == 0
    held = json.loads(told.out)
    assert held["suite"] == "warp"
    assert all(row["psnr"] > 10 and row["references"] == 1 for row in held["rows"])


def test_references_that_are_no_numbers_are_refused(program: Program) -> None:
    told = program("bench", "warp", "--refs", "one,2")
    assert told.status == 2
    assert "--refs is 'one,2', expected numbers of references such as 1,2,5" in told.err
