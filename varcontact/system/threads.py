"""One BLAS thread while varcontact computes.

Active sets make many products and factors of some hundred rows. Wherever processes share the cores, threads of BLAS
lose much on them by waiting for each other: docs/speed.md has the measurement.
"""

from __future__ import annotations

import os
from contextlib import ContextDecorator
from functools import cache
from importlib import import_module
from threading import Lock
from typing import Any

VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "BLIS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
"""Where one of these is set, its number of threads stays."""


class _Limit(ContextDecorator):
    """The number of threads is the whole process's: the first to come lowers it, the last to leave restores it."""

    def __init__(self) -> None:
        self._lock, self._inside = Lock(), 0
        self._lowered: Any = None

    def hold(self) -> None:
        self._lock.acquire()

    def release(self) -> None:
        self._lock.release()

    def __enter__(self) -> None:
        with self._lock:
            if self._inside == 0 and not any(name in os.environ for name in VARIABLES):
                self._lowered = _libraries().limit(limits=1, user_api="blas")
            self._inside += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0 and self._lowered is not None:
                self._lowered.restore_original_limits()
                self._lowered = None


_LIMIT = _Limit()
if hasattr(os, "register_at_fork"):  # a child forked while another thread holds the lock would wait for it for ever
    os.register_at_fork(before=_LIMIT.hold, after_in_parent=_LIMIT.release, after_in_child=_LIMIT.release)


def one_blas_thread() -> ContextDecorator:
    """Limit BLAS to one thread within a block, or as a decorator within a function.

    Every public function holds it whose matrices or products grow with the elements of a contact or the points of a
    surface, and so does what is computed later on, when a result is asked for it. Calls may be nested (0.5 us), and may
    come from several threads at once. Nothing is limited where an environment variable of `VARIABLES` is set: it is the
    user's choice.
    """
    return _LIMIT


@cache
def _libraries() -> Any:
    from threadpoolctl import ThreadpoolController

    import_module("scipy.linalg")  # its BLAS is another library than NumPy's, and has to be there to be found
    return ThreadpoolController()
