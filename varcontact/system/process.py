"""Resources that this process may use: memory, one BLAS thread, and the time until Ctrl-C.

`need` refuses work before it starts where memory is too little. Active sets
make many products and factors of some hundred rows: wherever processes share
the cores, threads of BLAS lose much on them by waiting for each other
(docs/speed.md has the measurement).

Python looks for signals between its own instructions: not while a solver or
LAPACK computes, for a minute perhaps. And some solvers (SCS, OSQP) take SIGINT
for themselves and return as if they had failed. So what may take long computes
in a thread beside, for which the main thread waits: Ctrl-C ends the waiting at
once, as `KeyboardInterrupt`.
"""

from __future__ import annotations

import contextlib
import contextvars
import math
import os
import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, wait
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, Generic, Self, TypeVar, overload

from varcontact.errors import TooLarge

SMALLER = "a grid with fewer elements would fit"
"""Remedy named in messages where the grid takes the memory."""
LITTLE = 2.0**24
"""Bytes that are assumed to be free: a query takes half a millisecond, a noticeable part of a small
solve."""
VARIABLES = (
    "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS"
)  # fmt: skip
"""Environment variables for the number of threads: if one of them is set, it stays."""
Result = TypeVar("Result")
Value = TypeVar("Value")
LONGEST = 0.005
"""Time for which a solver that handles SIGINT itself keeps it [s]."""
MANY = 1000
"""Rows of a matrix whose factors take longer (0.05 s) than it takes to start a thread (0.1 ms)."""


def available() -> float:
    """Bytes of memory that this process can still take.

    The least of what the machine has, of what the control groups of the process leave (containers
    and batch systems set their limits there), and of what ``ulimit -v`` leaves.
    """
    import psutil

    left = min(float(psutil.virtual_memory().available), left_by_control_groups())
    with contextlib.suppress(ImportError):  # not available on Windows
        import resource

        most, _ = resource.getrlimit(resource.RLIMIT_AS)
        if most != resource.RLIM_INFINITY:
            left = min(left, float(most - psutil.Process().memory_info().vms))
    return max(0.0, left)


def left_by_control_groups(root: Path = Path("/")) -> float:
    """Bytes that the control groups of this process leave to it, those above it included; infinite
    without limits.
    """
    left = [math.inf]
    for line in _lines(root / "proc/self/cgroup"):
        number, _, name = line.split(":", 2)
        group = Path(name.lstrip("/"))
        for folder in (group, *group.parents) if number == "0" else ():  # version 2
            place = root / "sys/fs/cgroup" / folder
            most = _lines(place / "memory.max")
            taken = _lines(place / "memory.current")
            if most and taken and most[0] != "max":
                statistics = dict(entry.split() for entry in _lines(place / "memory.stat"))
                # copies of files, which make room when needed
                dropped = int(statistics.get("inactive_file", 0))
                left.append(float(most[0]) - float(taken[0]) + dropped)
    return min(left)


def _lines(path: Path) -> list[str]:
    """Lines of a small file; none where there is no such file."""
    try:
        return path.read_text().splitlines()
    except OSError:
        return []


def fits(size: float) -> bool:
    """True where so many bytes are free."""
    return size < LITTLE or size <= available()


def need(what: str, size: float, fits: str) -> None:
    """Raise `TooLarge` if `size` bytes are not free."""
    if size >= LITTLE and size > (there := available()):
        raise TooLarge(what, size, there, fits)


class _Limit(contextlib.ContextDecorator):
    """The number of threads is the whole process's: the first to come lowers it, the last to leave
    restores it.
    """

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self._inside = 0
        self._lowered: Any = None

    def __enter__(self) -> None:
        with self.lock:
            if self._inside == 0 and not any(name in os.environ for name in VARIABLES):
                self._lowered = _libraries().limit(limits=1, user_api="blas")
            self._inside += 1

    def __exit__(self, *_: object) -> None:
        with self.lock:
            self._inside -= 1
            if self._inside == 0 and self._lowered is not None:
                self._lowered.restore_original_limits()
                self._lowered = None


_LIMIT = _Limit()
# a child forked while another thread holds the lock would wait for ever
if hasattr(os, "register_at_fork"):
    os.register_at_fork(
        before=_LIMIT.lock.acquire,
        after_in_parent=_LIMIT.lock.release,
        after_in_child=_LIMIT.lock.release,
    )


class lazy_property(Generic[Value]):  # noqa: N801 - written as the decorator `property` is
    """A property that is computed once; by each of the threads that read it first at the same time.

    `functools.cached_property` of Python 3.11 holds a lock meanwhile, for which a forked process
    waits for ever.
    """

    def __init__(self, compute: Callable[[Any], Value]) -> None:
        self.compute = compute
        self.__doc__ = compute.__doc__

    @overload
    def __get__(self, owner: None, kind: type) -> Self: ...

    @overload
    def __get__(self, owner: object, kind: type) -> Value: ...

    def __get__(self, owner: object, kind: type) -> Self | Value:
        if owner is None:
            return self
        value = self.compute(owner)
        object.__setattr__(owner, self.compute.__name__, value)  # also where the class is frozen
        return value


class on_demand(Generic[Value]):  # noqa: N801 - written as the default of a field
    """A field of a dataclass that is given as its value or as a function that computes it; the
    function is called when the field is first read.
    """

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __repr__(self) -> str:
        return "<on demand>"  # the default in signatures

    def __set__(self, owner: Any, value: Value | Callable[[], Value]) -> None:
        if isinstance(value, on_demand):  # its default, to dataclasses
            raise TypeError(f"{type(owner).__name__} needs {self.name}")
        owner.__dict__[self.name] = value

    @overload
    def __get__(self, owner: None, kind: type) -> Self: ...

    @overload
    def __get__(self, owner: Any, kind: type) -> Value: ...

    def __get__(self, owner: Any, kind: type) -> Self | Value:
        if owner is None:
            return self
        value = owner.__dict__[self.name]
        if callable(value):
            value = value()
            owner.__dict__[self.name] = value  # which frees what the function takes
        return value


def changed(entry: Value, **changes: Any) -> Value:
    """A frozen dataclass with changes that need no check: `dataclasses.replace` without the class's
    own, in a fifth of the time. Lazy properties are not copied.
    """
    names = entry.__dataclass_fields__  # type: ignore[attr-defined]
    entries = {name: value for name, value in entry.__dict__.items() if name in names}
    made = object.__new__(type(entry))
    made.__dict__.update(entries, **changes)
    return made


def one_blas_thread() -> _Limit:
    """Limit BLAS to one thread within a block, or as a decorator within a function.

    Every public function holds it whose matrices or products grow with the elements of a contact or
    the points of a surface, and so does what is computed later on, when a result is asked for it.
    Calls may be nested (0.5 us), and may come from several threads at once. Nothing is limited
    where an environment variable of `VARIABLES` is set: it is the user's choice.
    """
    return _LIMIT


@cache
def _libraries() -> Any:
    from threadpoolctl import ThreadpoolController

    # its BLAS is another library than NumPy's, and has to be there to be found
    import_module("scipy.linalg")
    return ThreadpoolController()


def interruptible(work: Callable[[], Result], rows: int = MANY) -> Result:
    """Result or error of `work`; Ctrl-C does not wait for it."""
    if rows < MANY or threading.current_thread() is not threading.main_thread():
        return work()
    return within(work, math.inf)


def within(work: Callable[[], Result], deadline: float) -> Result:
    """Result or error of `work` in a separate thread; `TimeoutError` past a deadline, by
    `time.perf_counter` [s]: the thread is then left alone.
    """
    found: Future[Result] = Future()

    def run() -> None:
        try:
            found.set_result(work())
        except BaseException as error:  # it is raised where the call was made
            found.set_exception(error)

    threading.Thread(target=contextvars.copy_context().run, args=(run,), daemon=True).start()
    in_main_thread = threading.current_thread() is threading.main_thread()
    pause = 1e-3
    while not wait([found], pause).done:
        if in_main_thread:
            _take_back_sigint()
        if time.perf_counter() > deadline:
            raise TimeoutError
        pause = min(2 * pause, LONGEST)
    return found.result()


def _take_back_sigint() -> None:
    """Restore Python's handler of Ctrl-C, in place of a solver's."""
    handler = signal.getsignal(signal.SIGINT)
    if handler is not None:
        signal.signal(signal.SIGINT, handler)


def imported(name: str) -> Any:
    """The package of a `name`; Ctrl-C does not leave it half imported."""
    return interruptible(lambda: import_module(name))
