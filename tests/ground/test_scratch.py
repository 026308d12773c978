"""Working memory is kept by its thread, and shared with nobody."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier
from typing import Any

import numpy as np
import pytest

from belvedere.ground.scratch import SMALLEST_LOAN, lend, own_memory, scratch
from belvedere.ground.threads import run_parallel


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


def test_work_that_interrupts_other_work_gets_other_memory() -> None:
    with own_memory():
        mine = scratch("work", (64,), np.uint8)
        with own_memory():
            theirs = scratch("work", (64,), np.uint8)
            assert not np.shares_memory(mine, theirs)
        assert np.shares_memory(mine, scratch("work", (64,), np.uint8))
    with own_memory():  # one set is kept, and it is the outermost
        assert np.shares_memory(mine, scratch("work", (64,), np.uint8))


def test_work_that_fails_leaves_the_memory_to_the_one_it_interrupted() -> None:
    with own_memory():
        mine = scratch("work", (64,), np.uint8)
        with pytest.raises(KeyError, match="inner"), own_memory():
            raise KeyError("inner")
        assert np.shares_memory(mine, scratch("work", (64,), np.uint8))


@pytest.mark.parametrize("threads", [1, 3])
def test_parallel_work_may_run_inside_parallel_work(threads: int) -> None:
    def outer(value: int) -> bool:
        mine = scratch("nested", (256,), np.int64)
        mine.fill(value)
        run_parallel(lambda k: scratch("nested", (256,), np.int64).fill(-k), range(1, 4), threads)
        return bool((mine == value).all())

    assert all(run_parallel(outer, range(6), threads))


@pytest.mark.parametrize("keep", [lambda block: block, lambda block: block[8:12].view(np.uint32)])
def test_lent_memory_comes_back_when_the_last_array_in_it_is_gone(keep: Any) -> None:
    size = SMALLEST_LOAN + 40
    held = keep(lend(size))
    place = held.ctypes.data
    other = lend(size)
    assert not np.shares_memory(held, other)
    del held
    again = lend(size - 20)  # a little less fits as well
    assert again.ctypes.data <= place < again.ctypes.data + again.nbytes
    assert again.shape == (size - 20,)


def test_memory_that_is_much_too_large_or_too_small_is_not_lent_again() -> None:
    block = lend(4 * SMALLEST_LOAN)
    block[:] = 7
    del block
    assert lend(SMALLEST_LOAN).nbytes == SMALLEST_LOAN
    block = lend(SMALLEST_LOAN)
    del block
    assert lend(2 * SMALLEST_LOAN).nbytes == 2 * SMALLEST_LOAN
