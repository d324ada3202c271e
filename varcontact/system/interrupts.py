"""Ctrl-C while other languages compute.

Python looks for signals between its own instructions: not while a solver or LAPACK computes, for a minute perhaps. And
some solvers (SCS, OSQP) take SIGINT for themselves and return as if they had failed. So what may take long computes in
a thread beside, for which the main thread waits: Ctrl-C ends the waiting at once, as `KeyboardInterrupt`.
"""

from __future__ import annotations

import contextvars
import signal
import threading
from collections.abc import Callable
from importlib import import_module
from typing import Any, Generic, TypeVar

Result = TypeVar("Result")

LONGEST = 0.005
"""Seconds for which a solver that takes SIGINT for itself has it."""
MANY = 1000
"""Rows of a matrix whose factors take longer (0.05 s) than it takes to start a thread (0.1 ms)."""


def interruptible(work: Callable[[], Result], rows: int = MANY) -> Result:
    """What `work` returns or raises; Ctrl-C does not wait for it."""
    if rows < MANY or threading.current_thread() is not threading.main_thread():
        return work()
    call = _Call(work)
    thread = threading.Thread(target=contextvars.copy_context().run, args=(call.run,), daemon=True)
    thread.start()
    pause = 1e-3
    while not call.done.wait(pause):
        _take_sigint_back()
        pause = min(2 * pause, LONGEST)
    return call.result()


def imported(name: str) -> Any:
    """The package of a `name`; Ctrl-C does not leave it half imported."""
    return interruptible(lambda: import_module(name))


class _Call(Generic[Result]):
    """A call in another thread."""

    def __init__(self, work: Callable[[], Result]) -> None:
        self._work, self._results = work, list[Result]()
        self._error: BaseException | None = None
        self.done = threading.Event()

    def run(self) -> None:
        try:
            self._results.append(self._work())
        except BaseException as error:  # it is raised where the call was made
            self._error = error
        finally:
            self.done.set()

    def result(self) -> Result:
        if self._error is not None:
            raise self._error
        return self._results[0]


def _take_sigint_back() -> None:
    """Python's handler of SIGINT in place of that of a solver."""
    handler = signal.getsignal(signal.SIGINT)
    if handler is not None:
        signal.signal(signal.SIGINT, handler)
