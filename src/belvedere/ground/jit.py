"""The one way to compile a kernel.

``@kernel`` is Numba's ``njit`` with the house's settings: compiled once and kept on disk, lock
released (threads), NumPy's rules for division by zero, products fused with sums. Only modules that
hold kernels import this one, and they are imported where they are used: Numba costs half a second
that ``import belvedere`` must not pay.

When compiling takes over a second in all, one line on the error stream says so, once.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit, types
from numba.core import event

Function = TypeVar("Function", bound=Callable[..., Any])

Real = Any
"""A scalar in a kernel: float32 by convention, float64 where the kernel says so."""

SETTINGS: dict[str, Any] = {
    "cache": True,
    "no_cfunc_wrapper": True,  # for callers in C, of whom there are none
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract"},  # a product and a sum in one rounding; nothing else is taken lightly
}
STEP_SETTINGS: dict[str, Any] = {
    **SETTINGS,
    "forceinline": True,
    "no_cpython_wrapper": True,
    "_nrt": False,
}

NOTICE = "belvedere: compiling kernels (first run only) ...\n"
NOTICE_AFTER_S = 1.0


def kernel(function: Function) -> Function:
    """Compile a pure loop over arrays and scalars.

    A kernel takes arrays and writes arrays whose names start with ``out_``; it checks nothing,
    allocates nothing large and knows no class. With ``NUMBA_DISABLE_JIT=1`` it runs as the plain
    Python it is, so that overruns raise.
    """
    return njit(**SETTINGS)(function)  # type: ignore[call-overload]


def inner(function: Function) -> Function:
    """Compile a step of a kernel's loop into the kernel.

    It allocates nothing and returns no array: without Numba's runtime no reference to its arrays is
    counted, which costs more than many a step. Nor is it made callable from Python until somebody
    calls it, as tests do, nor compiled anew for every constant: that would be half the time that
    compiling takes.
    """
    step: Any = njit(**STEP_SETTINGS)(function)
    if step is not function:  # it is with NUMBA_DISABLE_JIT=1
        # what has no wrapper must never be found by a call from Python, which would end the process
        step._insert = _forget
        step.get_call_template = _Widened(step.get_call_template)
        step._compile_for_args = _Bridge(step)
    return step


def _forget(*compiled: Any) -> None:
    """Take no note of what was compiled."""


class _Widened:
    """Asks for one compilation whatever the constants that a step is called with.

    Once it is part of a kernel they are constants again.
    """

    def __init__(self, find: Callable[..., Any]) -> None:
        self._find = find

    def __call__(self, args: Any, kws: Any) -> Any:
        wide = {name: types.unliteral(kind) for name, kind in kws.items()}
        return self._find(tuple(types.unliteral(kind) for kind in args), wide)


class _Bridge:
    """Gives Python a kernel to call that does nothing but a step."""

    def __init__(self, step: Callable[..., Any]) -> None:
        self._step = step
        self._kernel: Callable[..., Any] | None = None

    def __call__(self, *args: Any) -> Callable[..., Any]:
        del args
        if self._kernel is None:
            step = self._step

            def call(*given: Any) -> Any:
                return step(*given)

            self._kernel = njit(nogil=True, error_model="numpy")(call)
        return self._kernel


class _CompileNotice(event.Listener):
    """Tells a waiting person, once, that the wait is a compilation."""

    def __init__(self) -> None:
        self._lock = threading.RLock()  # what interrupts a compilation may need one itself
        self._depth = 0
        self._began = 0.0
        self._spent = 0.0
        self._said = False
        self._timer: threading.Timer | None = None

    def on_start(self, event: event.Event) -> None:
        if self._said or not _is_ours(event):
            return
        with self._lock:
            self._depth += 1
            if self._depth == 1:
                self._began = time.monotonic()
                self._timer = threading.Timer(max(NOTICE_AFTER_S - self._spent, 0.0), self._say)
                self._timer.daemon = True
                self._timer.start()

    def on_end(self, event: event.Event) -> None:
        if self._said or not _is_ours(event):
            return
        with self._lock:
            self._depth = max(self._depth - 1, 0)
            if self._depth == 0 and self._timer is not None:
                self._timer.cancel()
                self._timer = None
                self._spent += time.monotonic() - self._began

    def _say(self) -> None:
        with self._lock:
            if not self._said:
                self._said = True
                sys.stderr.write(NOTICE)
                sys.stderr.flush()


def _is_ours(compile_event: event.Event) -> bool:
    data = compile_event.data
    dispatcher = data.get("dispatcher") if isinstance(data, dict) else None
    module = getattr(getattr(dispatcher, "py_func", None), "__module__", "") or ""
    return module.startswith("belvedere.")


event.register("numba:compile", _CompileNotice())
