"""Several threads, one answer.

Kernels release the interpreter's lock, so plain threads of the standard library are enough and no
threading layer is shared with (or upset by) other libraries such as torch. What is computed must
not depend on how many threads run: work is cut into items that write disjoint parts of the output.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from itertools import pairwise
from typing import TypeVar

from belvedere.ground.checks import check_integer

Item = TypeVar("Item")
Result = TypeVar("Result")

MAX_THREADS = 256


def thread_count(threads: int | None = None) -> int:
    """How many threads to use: ``threads``, or as many as this process has processors.

    Raises:
        InputError: ``threads`` is not a whole number from 1 to 256.
    """
    if threads is not None:
        return check_integer("options", "threads", threads, 1, MAX_THREADS)
    if hasattr(os, "sched_getaffinity"):
        return min(len(os.sched_getaffinity(0)), MAX_THREADS)
    return min(os.cpu_count() or 1, MAX_THREADS)


@lru_cache(maxsize=8)
def _pool(threads: int, process: int) -> ThreadPoolExecutor:
    """A pool kept for the life of the process (``process`` renews it after a fork)."""
    del process
    return ThreadPoolExecutor(max_workers=threads, thread_name_prefix="belvedere")


def run_parallel(
    function: Callable[[Item], Result], items: Sequence[Item], threads: int | None = None
) -> list[Result]:
    """``[function(item) for item in items]`` on several threads, results in order.

    The calling thread takes part, so one item or one thread starts no pool. The first exception is
    raised after every item has ended: no thread writes into arrays the caller has given up. Do
    not call it from within ``function``: the pool is not re-entrant.
    """
    count = min(thread_count(threads), len(items))
    if count <= 1:
        return [function(item) for item in items]

    pending = iter(range(len(items)))  # next() on it is atomic in CPython
    results: dict[int, Result] = {}

    def work() -> None:
        for index in pending:
            results[index] = function(items[index])

    futures = [_pool(count - 1, os.getpid()).submit(work) for _ in range(count - 1)]
    error: BaseException | None = None
    try:
        work()
    except BaseException as caught:  # raised again below, once nobody writes
        error = caught
    for future in futures:
        caught = future.exception()
        error = error or caught
    if error is not None:
        raise error
    return [results[index] for index in range(len(items))]


def row_bands(height: int, count: int) -> list[tuple[int, int]]:
    """``[0, height)`` cut into at most ``count`` runs of nearly equal length."""
    count = min(count, height)
    return list(pairwise(height * n // count for n in range(count + 1)))
