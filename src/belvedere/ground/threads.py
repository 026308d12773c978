"""Several threads, one answer.

Kernels release the interpreter's lock, so plain threads of the standard library are enough and no
threading layer is shared with (or upset by) other libraries such as torch. What is computed must
not depend on how many threads run: work is cut into items that write disjoint parts of the output.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar

from belvedere.ground.checks import check_integer
from belvedere.ground.scratch import own_memory

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


class _Job(Generic[Item, Result]):
    """Items that several threads take from until none is left."""

    def __init__(self, function: Callable[[Item], Result], items: Sequence[Item]) -> None:
        self.function, self.items = function, items
        self.results: dict[int, Result] = {}
        self.error: BaseException | None = None
        self._pending = iter(range(len(items)))  # next() on it is atomic in CPython
        self._ended: list[int] = []  # so is append()
        self._signal: SimpleQueue[None] = SimpleQueue()

    def work(self) -> None:
        """Take items until none is left; after an error the rest is left undone."""
        with own_memory():
            for index in self._pending:
                try:
                    if self.error is None:
                        self.results[index] = self.function(self.items[index])
                except BaseException as caught:  # the caller raises it, once nobody writes
                    self.error = self.error or caught
                self._ended.append(index)
        if len(self._ended) == len(self.items):
            self._signal.put(None)

    def wait(self) -> None:
        """Return when every item has ended, whoever worked on it."""
        while len(self._ended) < len(self.items):
            try:
                self._signal.get(timeout=1.0)
            except Empty:  # an interrupt may have come between the last item and its signal
                continue
            except BaseException as caught:
                self.error = self.error or caught


class _Helpers:
    """Threads kept for the life of the process, waiting for jobs."""

    def __init__(self) -> None:
        self._jobs: SimpleQueue[_Job[Any, Any] | None] = SimpleQueue()
        # what interrupts a thread that holds it may offer a job of its own
        self._lock, self._count = threading.RLock(), 0

    def offer(self, job: _Job[Any, Any], helpers: int) -> None:
        """Let so many threads help, as soon as they are awake."""
        if self._count < helpers:
            with self._lock:
                while self._count < helpers:
                    self._count += 1
                    name = f"belvedere_{self._count}"
                    threading.Thread(target=self._serve, name=name, daemon=True).start()
        for _ in range(helpers):
            self._jobs.put(job)

    def dismiss(self) -> None:
        """Let all of them end, with what they hold."""
        with self._lock:
            for _ in range(self._count):
                self._jobs.put(None)
            self._count = 0

    def _serve(self) -> None:
        while (job := self._jobs.get()) is not None:
            job.work()
            del job  # and the arrays it holds


@lru_cache(maxsize=1)
def _helpers(process: int) -> _Helpers:
    """The helpers of this process; a fork has none of its parent's threads."""
    del process
    return _Helpers()


def renew_helpers() -> None:
    """End the threads that wait for work; the next work starts new ones without working memory."""
    _helpers(os.getpid()).dismiss()


def run_parallel(
    function: Callable[[Item], Result], items: Sequence[Item], threads: int | None = None
) -> list[Result]:
    """``[function(item) for item in items]`` on several threads, results in order.

    The calling thread takes part, so one item or one thread wakes nobody, and it waits for items
    only, not for helpers that wake when all is done. Each works in memory of its own (`scratch`),
    even where it interrupts another one in the same thread. The first exception is raised when no
    item is worked on any more, so that no thread writes into arrays the caller has given up; items
    that nobody had begun are then left undone.
    """
    count = min(thread_count(threads), len(items))
    if count <= 1:
        with own_memory():
            return [function(item) for item in items]
    job = _Job(function, items)
    _helpers(os.getpid()).offer(job, count - 1)
    job.work()
    job.wait()
    if job.error is not None:
        raise job.error
    return [job.results[index] for index in range(len(items))]


def row_bands(height: int, count: int) -> list[tuple[int, int]]:
    """``[0, height)`` cut into at most ``count`` runs of nearly equal length."""
    count = min(count, height)
    return list(pairwise(height * n // count for n in range(count + 1)))
