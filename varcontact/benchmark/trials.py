"""Trials of solvers, one at a time in a process beside: it is ended where a solver is out of time.

Seconds are processor seconds, which other work on the machine changes little.
"""

from __future__ import annotations

import math
import multiprocessing
import os
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from typing import Any

from varcontact.benchmark.problem_set import BenchmarkProblem
from varcontact.benchmark.solvers import Entry, entry_named, without_made
from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.discrete.residuals import gap, normal_gap
from varcontact.errors import SceneError, TooLarge, WorkersLost
from varcontact.interfaces.potential import project
from varcontact.solvers.interface import OutOfTime, Settings, natural_residual
from varcontact.solvers.registry import SolverSpec
from varcontact.solving.own_solvers import Registered, registered, with_registered
from varcontact.solving.pipeline import check_memory
from varcontact.system.files import first_line
from varcontact.system.process import imported, one_blas_thread

REPEATED_BELOW = 0.1
"""Trials shorter than this are repeated [s], as short times scatter."""
REPEATS = 3
WAITING_MAX = 10.0
"""Longest time that a process may sleep, divided by its limit of processor time: for solvers that
only wait. On a busy machine a process that could run does not count as asleep."""
LOOK = 0.05
"""Time between two checks of a process [s]."""
REASON_MAX = 120
"""Characters to which a reason is cut."""
OUTCOMES = (
    "solved", "inaccurate", "gave up", "out of time", "too large", "failed", "crashed"
)  # fmt: skip
"""Outcomes: residual and gap within the tolerance; reported as solved, but not within it; reported
as not converged; and reasons for having no answer."""


GROUPS = (
    "pressures", "shifts", "rolling", "line rolling", "viscoelastic pressures"
)  # fmt: skip
"""Groups of problems, of each of which a solver takes all or none: QPs; cones with an energy; cones
without one; QPs without one."""


def group_of(problem: NormalProblem | TangentialProblem) -> str:
    """The group of a problem."""
    if isinstance(problem, NormalProblem):
        if problem.symmetric:
            return "pressures"
        return "viscoelastic pressures"
    if problem.symmetric:
        return "shifts"
    if problem.components == 1:
        return "line rolling"
    return "rolling"


@dataclass(frozen=True)
class Trial:
    """One solver on one problem at several tolerances, from loose to tight."""

    problem: BenchmarkProblem
    solver: str
    tols: tuple[float, ...]


@dataclass(frozen=True)
class Posed:
    """Description of a problem that the process sends before it solves it."""

    group: str
    elements: int
    applies: bool


@dataclass(frozen=True)
class Verdict:
    """Answer of a solver at one tolerance, judged by the package's own residual and gap."""

    outcome: str
    reason: str = ""
    residual: float = math.nan
    relative_gap: float = math.nan
    seconds: float = math.nan
    iterations: int = 0


class Process:
    """Worker process that runs solvers; restarted after a solver had to be ended."""

    def __init__(self, limit: float) -> None:
        self.limit = limit
        self._process: Any = None
        self._ours: Connection | None = None

    def __enter__(self) -> Process:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def begin(self, trial: Trial) -> Posed:
        """Let the process build the problem; returns its description."""
        connection = self._connection()
        connection.send(trial)
        posed = self._received(math.inf)
        if isinstance(posed, Verdict):
            raise WorkersLost(f"{trial.problem.name} was not posed: {posed.reason}")
        assert isinstance(posed, Posed)
        return posed

    def verdicts(self, trial: Trial) -> Iterator[tuple[float, Verdict]]:
        """Verdict at each tolerance of a trial that has begun; after a timeout or a crash repeated
        for the tighter ones.
        """
        for i, tol in enumerate(trial.tols):
            verdict = self._received(self.limit)
            yield tol, verdict
            if verdict.outcome in ("out of time", "crashed"):
                self._end()
                for tighter in trial.tols[i + 1 :]:
                    reason = f"not tried: {verdict.outcome} at {tol:g}"
                    yield tighter, replace(verdict, reason=reason)
                return

    def _connection(self) -> Connection:
        if self._ours is not None:
            return self._ours
        context = multiprocessing.get_context("spawn")
        self._ours, theirs = context.Pipe()
        arguments = (theirs, registered())
        self._process = context.Process(target=_serve, args=arguments, daemon=True)
        self._process.start()
        theirs.close()
        return self._ours

    def _received(self, limit: float) -> Any:
        """Next message of the process; a Verdict of our own if its time is over or it ends."""
        import psutil

        assert self._ours is not None
        process = psutil.Process(self._process.pid)
        used_before = _processor_seconds(process)
        waited = 0.0
        while not self._ours.poll(LOOK):
            used = _processor_seconds(process) - used_before
            if _sleeps(process):
                waited += LOOK
            if used > limit or waited > WAITING_MAX * limit:
                return Verdict("out of time", f"{limit:g} s", seconds=limit)
        try:
            return self._ours.recv()
        except (EOFError, ConnectionResetError):
            self._process.join()
            return Verdict("crashed", f"its process ended with {self._process.exitcode}")

    def _end(self) -> None:
        if self._process is None:
            return
        self._process.kill()
        self._process.join()
        self._process = None
        self._ours = None


def _processor_seconds(process: Any) -> float:
    """Processor time that a process has used so far [s]; 0 if it has ended."""
    from psutil import NoSuchProcess

    try:
        times = process.cpu_times()
    except NoSuchProcess:
        return 0.0
    return float(times.user + times.system)


def _sleeps(process: Any) -> bool:
    """True where a process waits for something other than a processor."""
    import psutil

    try:
        return bool(process.status() == psutil.STATUS_SLEEPING)
    except psutil.NoSuchProcess:
        return False


# ------------------------------------------------------------------------- in the process beside


def _serve(connection: Connection, own: Registered) -> None:
    with_registered(own, _try_all, connection)


def _try_all(connection: Connection) -> None:
    name = ""
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # output of solvers goes to standard error
    with suppress(EOFError, KeyboardInterrupt), one_blas_thread():
        while True:
            trial = connection.recv()
            if trial.problem.name != name:
                problem = trial.problem.program().contact_problem
                name = trial.problem.name
            _try(connection, trial, problem)


def _try(connection: Connection, trial: Trial, problem: NormalProblem | TangentialProblem) -> None:
    """Send whether the solver applies, and its verdict at each tolerance."""
    entry = entry_named(trial.solver)
    spec = entry.spec_for(problem)
    elements = problem.operator.elements.size
    connection.send(Posed(group_of(problem), elements, spec is not None))
    if spec is None:
        return
    for package in spec.needs:
        imported(package)
    for tol in trial.tols:
        connection.send(verdict(problem, entry, spec, tol))


def verdict(
    problem: NormalProblem | TangentialProblem, entry: Entry, spec: SolverSpec, tol: float
) -> Verdict:
    """The verdict on a solver's answer."""
    unknowns = problem.operator.elements.size
    if isinstance(problem, TangentialProblem):
        unknowns = problem.rigid_shift.size
    seconds = math.inf
    try:
        check_memory(spec.kind, spec, entry.formulation, unknowns)
        for _ in range(REPEATS):
            settings = Settings(tol, entry.formulation)
            fresh = without_made(problem)
            begun = time.process_time()
            raw = spec.once(fresh, settings, None)
            seconds = min(seconds, time.process_time() - begun)
            if seconds > REPEATED_BELOW:
                break
    except (TooLarge, MemoryError) as error:
        return Verdict("too large", _reason(error))
    except OutOfTime:
        return Verdict("out of time")
    except SceneError as error:
        return Verdict("failed", _reason(error))
    except Exception as error:  # solvers are other people's code and may raise anything
        return Verdict("failed", f"{type(error).__name__}: {_reason(error)}")
    return _verdict_on(problem, raw, tol, seconds)


def _verdict_on(
    problem: NormalProblem | TangentialProblem, raw: RawSolution, tol: float, seconds: float
) -> Verdict:
    """The verdict on an answer by the residual of the natural map and the relative gap."""
    if not raw.finite:
        return Verdict("failed", raw.status[:REASON_MAX], seconds=seconds)
    residual = natural_residual(problem, raw)
    if isinstance(problem, NormalProblem):
        relative_gap = normal_gap(problem, raw.traction, raw.rigid)[1]
    else:
        admissible = project(raw.traction, problem.bound)
        relative_gap = gap(problem, admissible, raw.rigid)[1]
    outcome = "gave up"
    if residual <= tol and relative_gap <= tol:
        outcome = "solved"
    elif raw.solved:
        outcome = "inaccurate"
    return Verdict(
        outcome, raw.status[:REASON_MAX], residual, relative_gap, seconds, raw.iterations
    )


def _reason(error: Exception) -> str:
    return first_line(error)[:REASON_MAX]


def trials(
    problems: Sequence[BenchmarkProblem], solvers: Sequence[str], tols: Sequence[float]
) -> Iterator[Trial]:
    """All trials, problem by problem, each with its tolerances from loose to tight."""
    loose_first = tuple(sorted(tols, reverse=True))
    for problem in problems:
        for solver in solvers:
            yield Trial(problem, solver, loose_first)
