"""Seconds by stage of a solve, and how often solvers are called, for how long, with how many iterations."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Calls:
    """All calls of one solver.

    Attributes
    ----------
    count : int
        How often it was called.
    iterations : int
        Its iterations, as it counts them, in all calls.
    seconds : float
        Its time in all calls, without that of other solvers which it called.
    """

    count: int = 0
    iterations: int = 0
    seconds: float = 0.0


class SolveStats:
    """The statistics of one solve; they also report its progress, as words to the function `progress`.

    >>> stats = SolveStats()
    >>> with stats.stage("normal"), stats.called("clarabel"):
    ...     stats.iterated("clarabel", 12)
    >>> stats.calls["normal"]["clarabel"].count, stats.calls["normal"]["clarabel"].iterations
    (1, 12)
    """

    def __init__(self, progress: Callable[[str], None] | None = None) -> None:
        self.calls: dict[str, dict[str, Calls]] = {}
        self._progress = progress
        self._begun = time.perf_counter()
        self._seconds: dict[str, float] = {}
        self._stages: list[str] = []
        self._within_stages: list[float] = []
        self._within_calls: list[float] = []

    @property
    def timing(self) -> dict[str, float]:
        """Seconds by stage so far, each without the stages within it, and in total."""
        return {**self._seconds, "total": time.perf_counter() - self._begun}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """A stage of the solve, which solvers are called in; within "grid" there are no further stages."""
        if "grid" in self._stages:
            yield
            return
        if self._progress is not None:
            self._progress(name)
        begun = time.perf_counter()
        self._stages.append(name)
        self._within_stages.append(0.0)
        try:
            yield
        finally:
            took = time.perf_counter() - begun
            self._stages.pop()
            self._seconds[name] = self._seconds.get(name, 0.0) + took - self._within_stages.pop()
            if self._within_stages:
                self._within_stages[-1] += took

    @contextmanager
    def called(self, solver: str) -> Iterator[None]:
        """One call of a solver; calls inside it count for themselves."""
        self._within_calls.append(0.0)
        begun = time.perf_counter()
        try:
            yield
        finally:
            took = time.perf_counter() - begun
            own = took - self._within_calls.pop()
            if self._within_calls:
                self._within_calls[-1] += took
            self._add(solver, count=1, seconds=own)

    def iterated(self, solver: str, iterations: int) -> None:
        """Iterations of a solver, added to those of its earlier calls."""
        self._add(solver, iterations=iterations)

    def tell(self, words: str) -> None:
        """How far a solver is."""
        if self._progress is not None and "grid" not in self._stages:
            self._progress(f"{self._problem}: {words}")

    @property
    def _problem(self) -> str:
        return self._stages[-1] if self._stages else ""

    def _add(self, solver: str, count: int = 0, iterations: int = 0, seconds: float = 0.0) -> None:
        solvers = self.calls.setdefault(self._problem, {})
        known = solvers.get(solver, Calls())
        solvers[solver] = replace(
            known,
            count=known.count + count,
            iterations=known.iterations + iterations,
            seconds=known.seconds + seconds,
        )
