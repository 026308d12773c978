"""A building prepared by worker processes of their own, one of which dies."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

pytest.importorskip("distributed", reason="needs dask (pip install 'belvedere[cluster]')")

import distributed

from belvedere.walkthrough import PlacementOptions, PrepareOptions, prepare
from tests.kills import differences, running

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == "win32", reason="no process groups to kill"),
]
OPTIONS = PrepareOptions(rays=4, references=PlacementOptions(count=2, texels=32))
PATIENCE_S = 40.0


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What one process makes."""
    target = tmp_path_factory.mktemp("alone") / "flat"
    prepare("built-in:flat", target, options=OPTIONS, workers=2)
    return target


@contextlib.contextmanager
def two_workers(folder: Path) -> Iterator[Any]:
    """A client of a scheduler, at a free port, with two worker processes; all gone afterwards."""
    told = folder / "scheduler.json"
    dask, local = [sys.executable, "-m", "dask"], ["--host", "127.0.0.1"]
    ports = ["--port", "0", "--dashboard-address", "127.0.0.1:0"]
    single = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory", str(folder)]
    with contextlib.ExitStack() as stack:
        begin = stack.enter_context
        begin(running([*dask, "scheduler", *local, *ports, "--scheduler-file", str(told)]))
        address = soon(lambda: json.loads(told.read_text())["address"])
        for _ in range(2):
            begin(running([*dask, "worker", address, *local, *single]))
        client = begin(distributed.Client(address, timeout=PATIENCE_S))
        client.wait_for_workers(2, timeout=PATIENCE_S)
        yield client


def soon(ask: Callable[[], Any]) -> Any:
    """What a question gives once it gives anything; time out when it never does."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        with contextlib.suppress(OSError, ValueError):
            if answer := ask():
                return answer
        time.sleep(0.01)
    raise TimeoutError(f"nothing within {PATIENCE_S} s")


def worker_in(client: Any, task: str) -> str | None:
    """The address of a worker that has a task of that name in hand."""
    for worker, keys in client.processing().items():
        if any(str(key).startswith(task) for key in keys):
            return worker
    return None


@pytest.mark.parametrize("task", [None, "make_model", "make_references"])
def test_two_worker_processes_make_the_same_bytes_even_if_one_dies_in_a_task(
    alone: Path, tmp_path: Path, task: str | None
) -> None:
    target = tmp_path / "scenes" / "flat"
    target.parent.mkdir()
    killed: list[str] = []
    with two_workers(tmp_path) as client:
        address, pids = client.scheduler.address, client.run(os.getpid)
        assert len(set(pids.values()) | {os.getpid()}) == 3

        def kill() -> None:
            worker = soon(lambda: worker_in(client, str(task)))
            os.kill(pids[worker], signal.SIGKILL)
            killed.append(worker)

        killer = Thread(target=kill)
        if task:
            killer.start()
        prepare("built-in:flat", target, options=OPTIONS, cluster=address)
        if task:
            killer.join()
            assert list(client.scheduler_info()["workers"]) == [w for w in pids if w not in killed]
            assert len(killed) == 1
    assert differences(alone, target) == []
    assert [path.name for path in target.parent.iterdir()] == ["flat"]
