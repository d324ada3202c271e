"""Settings of every solver, and statistics that count and time its calls."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.discrete.residuals import normal_residual, tangential_residual
from varcontact.solvers.trace import Follower, Reporter, Trace
from varcontact.system.process import changed

SHORT_STEP = 0.05
"""Step of steady rolling, in element lengths, below which Newton's method is slower than active
sets."""
SECONDS_MAX = 1e9
"""Time limit of a program's solver without a deadline [s]."""
Problem = TypeVar("Problem", bound=NormalProblem | TangentialProblem)
Start = TypeVar("Start", RawSolution, RawSolution | None)


@dataclass(frozen=True)
class Calls:
    """All calls of one solver.

    Attributes
    ----------
    count : int
        Number of calls.
    iterations : int
        Its iterations, as it counts them, in all calls.
    seconds : float
        Its time in all calls, without that of other solvers which it called.
    """

    count: int = 0
    iterations: int = 0
    seconds: float = 0.0


def ignored(iterate: RawSolution | np.ndarray) -> None:
    """Follower that records nothing."""


class SolveStats:
    """The statistics of one solve; they also report its progress, as words to the function
    `progress`.

    >>> stats = SolveStats()
    >>> with stats.stage("normal"), stats.called("clarabel"):
    ...     stats.iterated("clarabel", 12)
    >>> stats.calls["normal"]["clarabel"].count, stats.calls["normal"]["clarabel"].iterations
    (1, 12)
    """

    def __init__(
        self, progress: Callable[[str], None] | None = None, trace: Trace | None = None
    ) -> None:
        self.calls: dict[str, dict[str, Calls]] = {}
        self.trace = trace
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
        """Context for a stage of the solve; within "grid" no further stages are recorded."""
        if "grid" in self._stages:
            yield
            return
        if self._progress is not None:
            self._progress(name)
        started = time.perf_counter()
        self._stages.append(name)
        self._within_stages.append(0.0)
        try:
            yield
        finally:
            took = time.perf_counter() - started
            self._stages.pop()
            self._seconds[name] = self._seconds.get(name, 0.0) + took - self._within_stages.pop()
            if self._within_stages:
                self._within_stages[-1] += took

    @contextmanager
    def called(self, solver: str) -> Iterator[None]:
        """Context of one call of a solver; calls within it are counted separately."""
        self._within_calls.append(0.0)
        started = time.perf_counter()
        traced: AbstractContextManager[None] = nullcontext()
        if self.trace is not None:
            traced = self.trace.called(self._stage, solver)
        try:
            with traced:
                yield
        finally:
            took = time.perf_counter() - started
            own = took - self._within_calls.pop()
            if self._within_calls:
                self._within_calls[-1] += took
            self.iterated(solver, count=1, seconds=own)

    def iterated(
        self, solver: str, iterations: int = 0, count: int = 0, seconds: float = 0.0
    ) -> None:
        """Iterations of a solver, added to those of its earlier calls."""
        solvers = self.calls.setdefault(self._stage, {})
        calls = solvers.get(solver, Calls())
        solvers[solver] = Calls(
            calls.count + count, calls.iterations + iterations, calls.seconds + seconds
        )

    @property
    def traces(self) -> bool:
        """True where the iterates of solvers are recorded: not in the search for a grid."""
        return self.trace is not None and self.trace.active and "grid" not in self._stages

    def follow(self, problem: NormalProblem | TangentialProblem) -> Follower:
        """Function that records the iterates of the present call of a solver, or does nothing."""
        if self.trace is None or not self.traces:
            return ignored
        return self.trace.follower(problem)

    def reporter(self) -> Reporter | None:
        """Function that records figures that a solver reports itself; None without a trace."""
        if self.trace is None or not self.traces:
            return None
        return self.trace.reporter()

    def add_answer(self, problem: NormalProblem | TangentialProblem, answer: RawSolution) -> None:
        if self.trace is not None and self.traces:
            self.trace.add_answer(problem, answer)

    def tell(self, words: str) -> None:
        if self._progress is not None and "grid" not in self._stages:
            self._progress(f"{self._stage}: {words}")

    @property
    def _stage(self) -> str:
        return self._stages[-1] if self._stages else ""


class OutOfTime(Exception):
    """A solver has not finished by its deadline."""


def check_time(deadline: float) -> None:
    """Raise `OutOfTime` past a deadline, by `time.perf_counter` [s]; called in every iteration that
    takes long.
    """
    if time.perf_counter() > deadline:
        raise OutOfTime


@dataclass(frozen=True)
class Settings:
    """Settings of a solve, the same for every solver."""

    tol: float = 1e-8
    # the program to be solved: "complementary", "potential" or "gap"; "auto" for the one that suits
    formulation: str = "auto"
    stats: SolveStats = field(default_factory=SolveStats)  # where their calls are counted
    # whether the answer is one of many passes or of a scan, and nothing beyond `tol` is of use
    loose_tolerance: bool = False
    deadline: float = math.inf  # when solvers raise `OutOfTime`, by `time.perf_counter` [s]

    @property
    def seconds_left(self) -> float:
        return min(max(self.deadline - time.perf_counter(), 1e-3), SECONDS_MAX)


Solver = Callable[[Problem, Settings, Start], RawSolution]
"""Function of a problem, settings and a start to tractions; the start may be None but where only a
polish is meant."""
TangentialSolver = Solver[TangentialProblem, RawSolution | None]


def counted(name: str, solver: Solver[Problem, Start]) -> Solver[Problem, Start]:
    """Solver whose calls are counted in `settings.stats` under a name, which its answers get if
    they have none.
    """

    def solve(problem: Problem, settings: Settings, start: Start) -> RawSolution:
        check_time(settings.deadline)
        with settings.stats.called(name):
            raw = solver(problem, settings, start)
            settings.stats.iterated(name, raw.iterations)
            settings.stats.add_answer(problem, raw)
        return changed(raw, solver=raw.solver or name)

    return solve


def natural_residual(problem: NormalProblem | TangentialProblem, raw: RawSolution) -> float:
    """Residual of the natural map relative to the largest traction, as measured by the solver or
    computed here.
    """
    if not math.isnan(raw.residual):
        return raw.residual
    if isinstance(problem, NormalProblem):
        return normal_residual(problem, raw.traction, raw.rigid)
    return tangential_residual(problem, raw.traction, raw.rigid)


def better(
    problem: NormalProblem | TangentialProblem, best: RawSolution | None, other: RawSolution
) -> RawSolution:
    """The answer with the smaller residual, or the only one."""
    if best is None or not best.finite:
        return other
    if natural_residual(problem, other) < natural_residual(problem, best):
        return other
    return best
