"""Seconds by stage, the calls of solvers, and the name of each stage, for showing progress."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from varcontact.solvers.tally import Calls, Tally


class Clock:
    """Adds up the time of named stages, ``with clock("normal"): ...``, and the calls of solvers.

    Parameters
    ----------
    progress : callable, optional
        Called with the name of each stage as it begins.
    """

    def __init__(self, progress: Callable[[str], None] | None = None) -> None:
        self._begun = time.perf_counter()
        self._progress = progress
        self._stages: dict[str, float] = {}
        self._inner: list[float] = []
        self._tallies: dict[str, Tally] = {}

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Count what runs inside as part of `stage`, without the stages within it."""
        if self._progress is not None:
            self._progress(stage)
        begun = time.perf_counter()
        self._inner.append(0.0)
        try:
            yield
        finally:
            took = time.perf_counter() - begun
            self._stages[stage] = self._stages.get(stage, 0.0) + took - self._inner.pop()
            if self._inner:
                self._inner[-1] += took

    def timing(self) -> dict[str, float]:
        """Seconds by stage so far, and in total."""
        return {**self._stages, "total": time.perf_counter() - self._begun}

    def tally(self, problem: str) -> Tally:
        """Where the calls for a problem are counted: "normal", "tangential", "joint", or "grid" before these.

        Parameters
        ----------
        problem : str
            "normal", "tangential", "joint", or "grid" before these.
        """
        if problem not in self._tallies:
            progress = self._progress
            self._tallies[problem] = Tally(None if progress is None else lambda words: progress(f"{problem}: {words}"))
        return self._tallies[problem]

    def adopt(self, problem: str, tally: Tally) -> None:
        """Count the calls of another clock as well, as those for a problem.

        Parameters
        ----------
        problem : str
            As of `tally`.
        tally : Tally
            Of the other clock.
        """
        self._tallies[problem] = tally

    def calls(self) -> dict[str, dict[str, Calls]]:
        """Calls so far, by problem and solver."""
        return {problem: dict(tally.calls) for problem, tally in self._tallies.items() if tally.calls}
