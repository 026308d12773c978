"""Independent pieces of work on Dask."""

from __future__ import annotations

import math
import threading

import pytest

pytest.importorskip("distributed", reason="needs dask (pip install 'belvedere[cluster]')")

from belvedere.ground.errors import InputError
from belvedere.walkthrough import tasks
from belvedere.walkthrough.tasks import crew


def test_results_come_in_the_order_of_the_items_and_progress_is_told() -> None:
    told = []
    with crew(workers=2) as workers:
        assert workers.local
        roots = workers.run(
            math.sqrt, [(float(n * n),) for n in range(9)], lambda d, n: told.append((d, n))
        )
    assert roots == list(range(9))
    assert told == [(n, 9) for n in range(10)]


def test_what_a_task_raises_ends_the_stage_and_the_next_goes_on() -> None:
    with crew(workers=1) as workers:
        with pytest.raises(ValueError, match="math domain"):
            workers.run(math.sqrt, [(4.0,), (-1.0,)], lambda d, n: None)
        assert workers.run(math.sqrt, [(4.0,)], lambda d, n: None) == [2.0]


def test_several_run_at_a_time() -> None:
    with crew(workers=2) as workers:
        assert sorted(workers.run(_meet, [(0,), (1,)], lambda d, n: None)) == [0, 1]


_BARRIER = threading.Barrier(2, timeout=20)


def _meet(_: int) -> int:
    return _BARRIER.wait()


def test_two_crews_work_at_a_time() -> None:
    """No port is asked for by number, so a second preparation does not disturb the first."""
    with crew(workers=1) as first, crew(workers=1) as second:
        assert first.run(math.sqrt, [(4.0,)], lambda d, n: None) == [2.0]
        assert second.run(math.sqrt, [(9.0,)], lambda d, n: None) == [3.0]


def test_a_cluster_that_is_not_there_is_named(monkeypatch) -> None:
    monkeypatch.setattr(tasks, "PATIENCE_S", 0.5)
    with (
        pytest.raises(InputError, match="no Dask scheduler answers"),
        crew("tcp://127.0.0.1:9"),
    ):
        pass
    with pytest.raises(InputError, match="leave it out"), crew("tcp://127.0.0.1:9", workers=2):
        pass
