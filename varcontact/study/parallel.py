"""Tasks over an executor: in this process, in processes of its own, or on a cluster. Results come
as they finish.
"""

from __future__ import annotations

import math
import multiprocessing
import os
import signal
import sys
import threading
import tracemalloc
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from varcontact import checks
from varcontact.errors import SceneError, VarcontactError, WorkersLost
from varcontact.solving.own_solvers import registered, with_registered

Key = TypeVar("Key")
Result = TypeVar("Result")

CHUNK = 8
"""Scenes that a worker solves one after the other."""
MOST_WORKERS = 1024
START = "forkserver" if sys.platform == "linux" else "spawn"
"""Start method of processes. Other systems than Linux have no fork server, or their libraries break
in forks (macOS)."""
PRELOAD = ["psutil", "scipy.fft", "scipy.linalg", "scipy.special", "varcontact.study.sweep"]
"""Modules that the fork server imports, once for all processes."""


@dataclass(frozen=True)
class Execution:
    """Executor and number of workers for tasks, as for `sweep`, and the function called with their
    names.
    """

    executor: Executor | None
    workers: int
    progress: Callable[[Any], Any]


def results(
    work: Callable[..., Result],
    tasks: Mapping[Key, tuple[Any, ...]],
    executor: Executor | None,
    progress: Callable[[Key], Any] = lambda name: None,
) -> Iterator[tuple[Key, Result]]:
    """The name and the result of each task, as they finish; without an executor they are done here,
    in order.

    A task is the arguments of `work`. Progress is called with a task's name when it begins here, or
    finishes elsewhere. When left early, what has not begun is cancelled.
    """
    if executor is None:
        for name, task in tasks.items():
            progress(name)
            yield name, work(*task)
        return
    names: dict[Future[Result], Key] = {}
    own = registered()
    try:
        with _lost_workers():
            for name, task in tasks.items():
                names[executor.submit(with_registered, own, work, *task)] = name
        for future in as_completed(names):
            with _lost_workers():
                result = future.result()
            progress(names[future])
            yield names.pop(future), result
    finally:
        if not isinstance(executor, _Processes):  # these pools end at once, with their tasks
            for future in names:
                future.cancel()


@contextmanager
def _lost_workers() -> Iterator[None]:
    """Turn errors of the executor, not those of the work, into `WorkersLost`."""
    try:
        yield
    except VarcontactError:
        raise
    except Exception as error:  # executors of other packages may raise anything
        words = f"{type(error).__name__}: {error}".strip(": ").splitlines()[0]
        raise WorkersLost(f"the executor gives no result ({words})") from error


@contextmanager
def opened(executor: Any, workers: Any) -> Iterator[Executor | None]:
    """The given executor, which stays open; or None for one worker: this process; or processes of
    our own.

    Our own end at once when the block, or this process, ends early.
    """
    workers = checks.whole("workers", workers, most=MOST_WORKERS)
    if executor is not None:
        if not isinstance(executor, Executor):
            allowed = "None or a concurrent.futures.Executor"
            if hasattr(executor, "get_executor"):
                allowed += "; of a dask client: client.get_executor()"
            raise SceneError("executor", executor, allowed)
        if workers != 1:
            raise SceneError("workers", workers, "left out: the executor has its own")
        yield executor
        return
    if workers == 1:
        yield None
        return
    # Not forked from this process: a fork would copy locks that other threads hold. On Linux they
    # are forked from a
    # process that only imports what they need; elsewhere each is started anew.
    context = multiprocessing.get_context(START)
    if START == "forkserver":
        context.set_forkserver_preload(PRELOAD)
    watched, lifeline = context.Pipe(duplex=False)
    pool = _Processes(workers, context, _start_worker, (watched,))
    try:
        yield pool
        pool.shutdown()
    finally:
        lifeline.close()
        watched.close()
        # processes that end at once; semaphores that wait for it would outlive them
        pool.shutdown(cancel_futures=True)


class _Processes(ProcessPoolExecutor):
    """A pool that Ctrl-C does not meet while processes, or their server's imports, begin."""

    def submit(self, work: Callable[..., Result], /, *task: Any, **options: Any) -> Future[Result]:
        if START != "forkserver" or threading.current_thread() is not threading.main_thread():
            return super().submit(work, *task, **options)
        pressed: list[Any] = []
        # which the server inherits
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT,))
        # other threads may take it
        handler = signal.signal(signal.SIGINT, lambda *said: pressed.append(said))
        try:
            return super().submit(work, *task, **options)
        finally:
            signal.signal(signal.SIGINT, handler)
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
            if pressed and callable(handler):
                handler(*pressed[0])


def _start_worker(watched: Connection) -> None:
    """Initialise a worker: Ctrl-C is left to the parent, with which the worker ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(watched,), daemon=True).start()


def _end_with(watched: Connection) -> None:
    """End this process when the other end of the pipe is closed."""
    try:
        watched.poll(None)
    finally:
        os._exit(1)


def traced(work: Callable[[], Result]) -> tuple[Result, float]:
    """The result of `work`, and the largest memory of its arrays [bytes]; tracing takes time of its
    own.

    NaN but in the main thread: memory is traced for a whole process.
    """
    if threading.current_thread() is not threading.main_thread():
        return work(), math.nan
    tracing = tracemalloc.is_tracing()
    if not tracing:
        tracemalloc.start()
    try:
        tracemalloc.reset_peak()
        before = tracemalloc.get_traced_memory()[0]
        return work(), tracemalloc.get_traced_memory()[1] - before
    finally:
        if not tracing:
            tracemalloc.stop()
