"""Independent pieces of work on Dask: on this machine's processors, or on a cluster of machines.

Every task writes its piece of the result into the work folder, whole or not at all, and does
nothing where the piece is there already. So it does not matter who does it, how often, or when
somebody is killed: Dask hands what a dead worker had to another.
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from belvedere.ground.errors import InputError, MissingDependencyError
from belvedere.ground.threads import thread_count

__all__ = ["Crew", "crew"]

LOOPBACK = "127.0.0.1:0"
"""Where the local scheduler may serve its page: a free port that other machines do not see. Left to
itself it listens on every interface, at a port of its own that somebody else may have."""
PATIENCE_S = 15.0
"""How long a cluster is waited for."""


class Crew:
    """Workers that take tasks."""

    def __init__(self, client: Any, local: bool) -> None:
        self._client = client
        self.local = local
        """Whether the workers are threads of this process."""

    def run(
        self,
        task: Callable[..., Any],
        items: Sequence[tuple[Any, ...]],
        tell: Callable[[int, int], None],
    ) -> list[Any]:
        """``task(*item)`` for every item, in any order and several at a time.

        Args:
            task: a function of a module, so that workers elsewhere know it.
            items: its arguments.
            tell: called as ``tell(done, total)`` from this thread.

        Returns:
            The results in the order of the items.

        Raises:
            What a task raised; the others that wait are given up.
        """
        from distributed import as_completed

        tell(0, len(items))
        # pure=False: a task is done for what it writes, so no earlier result stands for it
        futures = [self._client.submit(task, *item, pure=False) for item in items]
        place = {future.key: index for index, future in enumerate(futures)}
        results: list[Any] = [None] * len(items)
        try:
            for done, future in enumerate(as_completed(futures), 1):
                results[place[future.key]] = future.result()
                tell(done, len(items))
        finally:
            self._client.cancel(futures)
        return results


@contextlib.contextmanager
def crew(cluster: str | None = None, workers: int | None = None) -> Iterator[Crew]:
    """Workers for the block.

    Args:
        cluster: ``tcp://HOST:PORT`` of a Dask scheduler, whose workers have this package and see
            the same files; None for threads of this process.
        workers: how many threads; None for as many as there are processors.

    Raises:
        MissingDependencyError: dask is not installed.
        InputError: no scheduler answers at that address, or it has no workers.
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise MissingDependencyError.for_extra(
            "dask.distributed", "cluster", "prepare a scene"
        ) from error
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    if cluster is None:
        count = thread_count(workers)
        with (
            LocalCluster(
                n_workers=1, threads_per_worker=count, processes=False,
                dashboard_address=LOOPBACK,
                memory_limit=0,
            ) as here,
            Client(here) as client,
        ):  # fmt: skip
            yield Crew(client, True)
        return
    if workers is not None:
        raise InputError(
            "prepare.workers counts this machine's threads, but the work is given to "
            f"{cluster}: leave it out"
        )
    try:
        client = Client(cluster, timeout=PATIENCE_S)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(
            f"prepare.cluster: no Dask scheduler answers at {cluster}: start one with "
            "`dask scheduler` and workers with `dask worker`, or leave it out"
        ) from error
    with client:
        if not client.scheduler_info()["workers"]:
            raise InputError(
                f"prepare.cluster: the scheduler at {cluster} has no workers: start some with "
                f"`dask worker {cluster}`"
            )
        yield Crew(client, False)
