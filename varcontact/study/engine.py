"""Pieces of work over an executor: here, in processes, or on a cluster. Their results come as they are done."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from itertools import islice
from multiprocessing.connection import Connection
from queue import SimpleQueue
from typing import Any, TypeVar

from varcontact import checks
from varcontact.errors import SceneError, VarcontactError, WorkersLost

Task = TypeVar("Task")
Result = TypeVar("Result")

CHUNK = 8
"""Scenes that a worker solves one after the other."""
MOST_AT_ONCE = 512
"""Pieces of work that an executor has at once, so that it need not hold the scenes of all of them."""
MOST_WORKERS = 1024
START = "forkserver" if sys.platform == "linux" else "spawn"
"""How own processes begin. Elsewhere there is no such thing, or its libraries are not made for forks (macOS)."""


def results(
    work: Callable[[Task], Result], tasks: Sequence[Task], executor: Executor | None, meanwhile: bool = False
) -> Iterator[tuple[int, Result]]:
    """What becomes of each task, in the order in which they are done.

    Left early, by Ctrl-C for one, it takes back the tasks that no worker has begun.

    Parameters
    ----------
    work : callable
        A function of one task, which other processes can import.
    tasks : sequence
    executor : concurrent.futures.Executor or None
        None: here, one after the other.
    meanwhile : bool
        Whether tasks are done here, too, while own processes begin.

    Yields
    ------
    number : int
        Of the task.
    result : object

    Raises
    ------
    VarcontactError
        As `work` raises it.
    WorkersLost
        If the executor gives no result.
    """
    if executor is None:
        yield from enumerate(map(work, tasks))
        return
    done: SimpleQueue[Future[Result]] = SimpleQueue()
    numbers: dict[Future[Result], int] = {}
    waiting = iter(enumerate(tasks))

    def hand_out(count: int) -> None:
        for number, task in islice(waiting, count):
            future = executor.submit(work, task)
            numbers[future] = number
            future.add_done_callback(done.put)

    try:
        while meanwhile and getattr(executor, "beginning", False) and (task := next(waiting, None)) is not None:
            yield task[0], work(task[1])
        with _answering():
            hand_out(MOST_AT_ONCE)
        while numbers:
            future = done.get()
            with _answering():
                result = future.result()
            yield numbers.pop(future), result
            with _answering():
                hand_out(1)
    finally:
        for future in numbers:
            future.cancel()


@contextmanager
def _answering() -> Iterator[None]:
    """Whatever comes from the executor and not from the work becomes one error."""
    try:
        yield
    except VarcontactError:
        raise
    except Exception as error:  # executors of other packages raise what they like
        words = f"{type(error).__name__}: {error}".strip(": ").splitlines()[0]
        raise WorkersLost(f"the executor gives no result ({words})") from error


@contextmanager
def opened(executor: Any, workers: Any) -> Iterator[Executor | None]:
    """The executor that is asked for: one that is given, own processes, or none for work that is done here.

    Parameters
    ----------
    executor : concurrent.futures.Executor or None
        It stays open.
    workers : int
        Without an executor: how many processes; 1: none.

    Raises
    ------
    SceneError
        If the one is no executor, the other no number from 1, or both are given.
    """
    workers = checks.whole("workers", workers, most=MOST_WORKERS)
    if executor is not None:
        if not isinstance(executor, Executor):
            hint = "; of a dask client: client.get_executor()" if hasattr(executor, "get_executor") else ""
            raise SceneError("executor", executor, f"None or a concurrent.futures.Executor{hint}")
        if workers != 1:
            raise SceneError("workers", workers, "left out: the executor has its own")
        yield executor
    elif workers == 1:
        yield None
    else:
        with processes(workers) as pool:
            yield pool


@contextmanager
def processes(workers: int) -> Iterator[Executor]:
    """A pool of processes, which end at once where the block, or this process, ends early.

    They are not forked from this process, because a fork takes along locks that other threads hold. So a program that
    uses them needs ``if __name__ == "__main__":`` around what it does. On Linux they are forked from a process that
    does nothing but import what they need, once for all of them; elsewhere each is begun anew.

    Parameters
    ----------
    workers : int
    """
    context = multiprocessing.get_context(START)
    if START == "forkserver":
        context.set_forkserver_preload(["varcontact.study.preload"])
    watched, lifeline = context.Pipe(duplex=False)
    pool = OwnProcesses(workers, context, _begin_worker, (watched,))
    try:
        yield pool
        pool.shutdown()
    finally:
        lifeline.close()
        watched.close()
        pool.shutdown(cancel_futures=True)  # processes that end at once; semaphores that wait for it would outlive them


class OwnProcesses(ProcessPoolExecutor):
    """A pool that begins its processes while this one does something else."""

    def __init__(
        self, workers: int, context: Any, initializer: Callable[..., None], arguments: tuple[Any, ...]
    ) -> None:
        super().__init__(workers, context, initializer, arguments)
        self._beginner = threading.Thread(target=self._begin, daemon=True)
        self._beginner.start()

    def _begin(self) -> None:
        if START == "forkserver":  # whose imports a Ctrl-C at the terminal must not end; what it forks ignores it
            signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT,))
        with suppress(Exception):  # which comes again where tasks are handed out
            self.submit(int)

    @property
    def beginning(self) -> bool:
        """Whether they have yet to begin."""
        return self._beginner.is_alive()


def alone() -> bool:
    """Whether no other thread works beside this one: memory is traced for a whole process."""
    return threading.current_thread() is threading.main_thread()


def _begin_worker(watched: Connection) -> None:
    """In a new worker: Ctrl-C is the business of the process that began it, and so is when to end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(watched,), daemon=True).start()


def _end_with(watched: Connection) -> None:
    """End this process when nobody holds the other end of the pipe any more."""
    try:
        watched.poll(None)
    finally:
        os._exit(1)
