"""How much memory one call takes beyond what it is given, its result included."""

from __future__ import annotations

import ctypes
import gc
import re
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from threading import Thread
from typing import Any

from belvedere.ground.scratch import forget_loans
from belvedere.ground.threads import renew_helpers

STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")
RESET_PEAK = "5"
"""What Linux wants to be told to forget the highest resident size so far."""


def peak_megabytes(run: Callable[[], Any]) -> float:
    """The larger of what Python's allocators saw and of how far the process grew.

    The first knows NumPy's arrays on any system; the second, on Linux, also what libraries and
    kernels take for themselves. Each call runs in a thread of its own after the helping threads
    are renewed and kept memory is given back, so that both count as they would in a first call.
    Warm the call up before: what is loaded or compiled once is not its working memory.
    """
    grown = _resident_growth(run)
    _forget()
    gc.collect()
    tracemalloc.start()
    try:
        before, _ = tracemalloc.get_traced_memory()
        tracemalloc.reset_peak()
        _in_new_thread(run)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    return max(peak - before, grown) / 1e6


def _resident_growth(run: Callable[[], Any]) -> int:
    """Bytes by which the process was larger at most than before; 0 where nobody tells."""
    _forget()
    gc.collect()
    try:
        ctypes.CDLL(None).malloc_trim(0)  # freed pages go back, so that using them anew is seen
        RESET.write_text(RESET_PEAK)
        before = _status("VmRSS")
    except (OSError, AttributeError, TypeError):
        return 0
    _in_new_thread(run)
    return max(_status("VmHWM") - before, 0)


def _status(field: str) -> int:
    found = re.search(rf"^{field}:\s*(\d+) kB", STATUS.read_text(), re.MULTILINE)
    return 1024 * int(found.group(1)) if found else 0


def _forget() -> None:
    """Let threads end that hold scratch memory, and memory go that waits to be used again."""
    renew_helpers()
    forget_loans()


def _in_new_thread(run: Callable[[], Any]) -> None:
    thread = Thread(target=run)
    thread.start()
    thread.join()
