from __future__ import annotations

import sys
import threading
import time
from typing import Any

import numpy as np
import pytest

from belvedere.ground.errors import InputError
from belvedere.ground.threads import renew_helpers, run_parallel, thread_count

THREADS = [1, 2, 3, 4]


@pytest.mark.parametrize("threads", THREADS)
def test_results_come_in_the_order_of_the_items(threads: int) -> None:
    def slow_first(item: int) -> int:
        time.sleep(0.002 * (8 - item))
        return item * item

    assert run_parallel(slow_first, range(8), threads) == [i * i for i in range(8)]


@pytest.mark.parametrize("threads", THREADS)
def test_no_items_make_no_results(threads: int) -> None:
    assert run_parallel(lambda item: item, [], threads) == []


@pytest.mark.parametrize("threads", THREADS)
def test_every_item_is_worked_on_once(threads: int) -> None:
    hits = np.zeros(1000, int)

    def hit(item: int) -> None:
        hits[item] += 1

    run_parallel(hit, range(1000), threads)
    np.testing.assert_array_equal(hits, 1)


@pytest.mark.parametrize("threads", THREADS)
@pytest.mark.parametrize("bad", [0, 3, 7])
def test_an_exception_reaches_the_caller(threads: int, bad: int) -> None:
    def fail(item: int) -> int:
        if item == bad:
            raise KeyError(f"item {item}")
        return item

    with pytest.raises(KeyError, match=f"item {bad}"):
        run_parallel(fail, range(8), threads)
    assert run_parallel(lambda item: item, range(3), threads) == [0, 1, 2]  # and no harm is done


def test_nobody_is_still_writing_when_the_exception_arrives() -> None:
    busy = threading.Event()
    ended: list[int] = []

    def work(item: int) -> None:
        if item == 0:
            busy.wait(5)
            raise ValueError("first")
        busy.set()
        time.sleep(0.05)
        ended.append(item)

    with pytest.raises(ValueError, match="first"):
        run_parallel(work, range(2), 2)
    assert ended == [1]


def test_ctrl_c_reaches_the_caller() -> None:
    def interrupt(item: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_parallel(interrupt, range(4), 2)


def test_one_thread_is_the_callers_own() -> None:
    names = run_parallel(lambda _: threading.current_thread().name, range(3), 1)
    assert names == [threading.current_thread().name] * 3


def test_several_callers_may_run_at_once() -> None:
    results: dict[int, list[int]] = {}

    def call(base: int) -> None:
        results[base] = run_parallel(lambda item: base + item, range(50), 3)

    callers = [threading.Thread(target=call, args=(1000 * k,)) for k in range(4)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join(10)
    assert results == {1000 * k: [1000 * k + i for i in range(50)] for k in range(4)}


def test_the_number_of_threads_is_checked() -> None:
    assert thread_count(3) == 3
    assert 1 <= thread_count() <= 256
    for threads in (0, -1, 257, 1.5, True):
        with pytest.raises(InputError, match=r"options.threads is .*whole number from 1 to 256"):
            thread_count(threads)  # type: ignore[arg-type]


def test_nobody_waits_for_a_helper_that_has_nothing_to_do() -> None:
    """Whoever wakes late must not hold up the caller, nor harm a later job."""
    gate, busy = threading.Event(), threading.Semaphore(0)

    def hold(item: int) -> int:
        busy.release()
        gate.wait(10)
        return item

    first = threading.Thread(target=run_parallel, args=(hold, range(9), 9))
    first.start()
    for _ in range(9):
        assert busy.acquire(timeout=10)
    began = time.monotonic()
    assert run_parallel(lambda item: item, range(6), 3) == list(range(6))  # every helper is busy
    assert time.monotonic() - began < 5
    gate.set()
    first.join(10)
    assert not first.is_alive()
    assert run_parallel(lambda item: -item, range(6), 3) == [0, -1, -2, -3, -4, -5]


def test_what_nobody_had_begun_when_an_item_failed_is_left_undone() -> None:
    done: list[int] = []

    def fail_first(item: int) -> None:
        if item == 0:
            raise ValueError("first")
        time.sleep(0.01)
        done.append(item)

    with pytest.raises(ValueError, match="first"):
        run_parallel(fail_first, range(100), 2)
    assert len(done) < 10


def test_what_interrupts_the_waking_of_helpers_may_wake_some_itself() -> None:
    results: list[list[int]] = []

    def interrupt(frame: Any, event: str, value: Any) -> None:
        del value
        if event == "call" and frame.f_code is threading.Thread.start.__code__:
            results.append(run_parallel(lambda item: -item, range(5), 4))

    def run() -> None:
        sys.setprofile(interrupt)
        results.append(run_parallel(lambda item: item, range(9), 3))
        sys.setprofile(None)

    renew_helpers()
    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(10)
    assert not thread.is_alive()  # it would wait for a lock of its own
    assert results[-1] == list(range(9))
    assert len(results) > 1  # it did interrupt
    assert all(one == [0, -1, -2, -3, -4] for one in results[:-1])
