"""What every solver is given besides its problem, and how its calls are counted."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.solvers.conic.programs import ConicProgram, Workspace
from varcontact.solvers.statistics import SolveStats

LONGEST = 1e9
"""Seconds that a solver of programs has where there is no deadline."""

Problem = TypeVar("Problem", NormalProblem, TangentialProblem)
Start = TypeVar("Start", RawSolution, RawSolution | None)


class OutOfTime(Exception):
    """A solver has not finished by its deadline."""


def check_time(deadline: float) -> None:
    """Raise `OutOfTime` past a deadline, by `time.perf_counter` [s]; called in every iteration that takes long."""
    if time.perf_counter() > deadline:
        raise OutOfTime


@dataclass(frozen=True)
class Settings:
    """What every solver is given."""

    tol: float = 1e-8
    # the program to be solved: "complementary", "potential" or "gap"; "auto" for the one that suits
    formulation: str = "auto"
    workspace: Workspace | None = None  # where solvers keep their set-ups for the next problem of the same structure
    stats: SolveStats = field(default_factory=SolveStats)  # where their calls are counted
    # whether the answer is one of many passes or of a scan, and nothing beyond `tol` is of use
    loose_tolerance: bool = False
    deadline: float = math.inf  # when solvers raise `OutOfTime`, by `time.perf_counter` [s]

    @property
    def seconds_left(self) -> float:
        """Until the deadline, more than zero."""
        return min(max(self.deadline - time.perf_counter(), 1e-3), LONGEST)

    def kept(self, key: Hashable, program: ConicProgram) -> tuple[Any, bool]:
        """The set-up that is kept for a program of that structure, or None; and whether its matrices are the same."""
        return (None, False) if self.workspace is None else self.workspace.find(key, program)

    def keep(self, key: Hashable, program: ConicProgram, setup: Any) -> None:
        if self.workspace is not None:
            self.workspace.keep(key, program, setup)


Solver = Callable[[Problem, Settings, Start], RawSolution]
"""From a problem, settings and a start to tractions; the start may be None but where only a polish is meant."""
NormalSolver = Solver[NormalProblem, RawSolution | None]
TangentialSolver = Solver[TangentialProblem, RawSolution | None]


def counted(name: str, solver: Solver[Problem, Start]) -> Solver[Problem, Start]:
    """A solver whose calls are counted in `settings.stats` under a name, which its answers bear if they have none."""

    def solve(problem: Problem, settings: Settings, start: Start) -> RawSolution:
        check_time(settings.deadline)
        with settings.stats.called(name):
            raw = solver(problem, settings, start)
            settings.stats.iterated(name, raw.iterations)
        return replace(raw, solver=raw.solver or name)

    return solve
