"""Working memory is kept by its thread, and shared with nobody."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np

from belvedere.ground.scratch import scratch


def test_a_thread_gets_the_same_memory_again() -> None:
    first = scratch("test", (4, 5), np.float32)
    first.fill(7.0)
    again = scratch("test", (20,), np.float32)
    assert np.shares_memory(first, again)
    assert (again == 7.0).all()


def test_another_name_is_other_memory() -> None:
    assert not np.shares_memory(scratch("one", (8,), np.uint8), scratch("two", (8,), np.uint8))


def test_more_is_given_when_more_is_asked_for() -> None:
    scratch("growing", (2, 2), np.int32)
    large = scratch("growing", (300, 7), np.int32)
    assert large.shape == (300, 7)
    assert large.dtype == np.int32
    assert np.shares_memory(large, scratch("growing", (3,), np.int32))


def test_two_threads_never_share() -> None:
    together = Barrier(2)

    def mine(value: int) -> bool:
        array = scratch("shared name", (1000,), np.int64)
        array.fill(value)
        together.wait()
        return bool((array == value).all())

    with ThreadPoolExecutor(2) as pool:
        assert all(pool.map(mine, [1, 2]))
