"""Traces of solvers: what each iterate is worth, by the same measures for all.

Measuring takes time of its own, which the clock of a trace leaves out.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.discrete.residuals import (
    gap,
    normal_gap,
    normal_residual,
    tangential_residual,
)
from varcontact.interfaces.potential import project

Follower = Callable[[RawSolution | np.ndarray], None]
"""Function that records an iterate; tractions alone where the rigid shift is known."""
Reporter = Callable[..., None]
"""Function that records figures which a solver reports itself, by the names of `FIGURES`."""
FIGURES = ("residual", "gap", "objective", "changes")
"""Figures of an iterate: residual of the natural map; duality gap and objective of the program,
dimensionless energies; elements whose area is another than before."""


@dataclass
class Call:
    """One call of a solver, and its iterates so far."""

    problem: str
    solver: str
    number: int
    iterates: int = 0
    measured: bool = False


@dataclass
class Trace:
    """The iterates of all calls of solvers in one solve, a record each."""

    records: list[dict[str, Any]] = field(default_factory=list)
    _calls: list[Call] = field(default_factory=list)
    _count: int = 0
    _begun: float = field(default_factory=time.perf_counter)
    _measuring: float = 0.0

    @property
    def active(self) -> bool:
        """True within a call of a solver."""
        return bool(self._calls)

    @contextmanager
    def called(self, problem: str, solver: str) -> Iterator[None]:
        """A call of a solver; calls inside it are traced for themselves."""
        self._count += 1
        self._calls.append(Call(problem, solver, self._count))
        try:
            yield
        finally:
            self._calls.pop()

    def follower(self, problem: NormalProblem | TangentialProblem) -> Follower:
        """A function that measures and records the iterates of the present call."""
        call = self._calls[-1]
        areas: list[np.ndarray] = []

        def follow(iterate: RawSolution | np.ndarray) -> None:
            started = time.perf_counter()
            if not isinstance(iterate, RawSolution):
                iterate = _alone(problem, iterate)
            figures, area = _measured(problem, iterate)
            if areas:
                figures["changes"] = int(
                    problem.operator.copies * np.count_nonzero(area != areas.pop())
                )
            areas.append(area)
            call.measured = True
            self._add(call, started, figures)

        return follow

    def reporter(self) -> Reporter:
        """A function that records what the solver of the present call reports itself."""
        call = self._calls[-1]

        def report(**figures: float) -> None:
            self._add(call, time.perf_counter(), figures)

        return report

    def add_answer(self, problem: NormalProblem | TangentialProblem, answer: RawSolution) -> None:
        """Record the answer of the present call, where no iterate was measured."""
        if not self._calls[-1].measured and answer.finite:
            self.follower(problem)(answer)

    def _add(self, call: Call, started: float, figures: dict[str, float]) -> None:
        second = started - self._begun - self._measuring
        where = {"problem": call.problem, "solver": call.solver, "call": call.number}
        self.records.append({**where, "iteration": call.iterates, "second": second, **figures})
        call.iterates += 1
        self._measuring += time.perf_counter() - started


def _alone(problem: NormalProblem | TangentialProblem, traction: np.ndarray) -> RawSolution:
    """Pressures or tractions with the approach, or the rigid shift, that is known."""
    if isinstance(problem, TangentialProblem):
        return RawSolution(traction, np.zeros(problem.components))
    return RawSolution(traction, np.array([problem.mean_approach(traction)]))


def _measured(
    problem: NormalProblem | TangentialProblem, iterate: RawSolution
) -> tuple[dict[str, float], np.ndarray]:
    """Figures of an admissible iterate, and the areas where the natural map has it."""
    with np.errstate(over="ignore", invalid="ignore"):
        if isinstance(problem, NormalProblem):
            return _of_pressure(problem, iterate)
        return _of_tractions(problem, iterate)


def _of_pressure(
    problem: NormalProblem, iterate: RawSolution
) -> tuple[dict[str, float], np.ndarray]:
    pressure = np.maximum(iterate.traction, 0.0)
    rigid = iterate.rigid
    elastic = problem.operator.apply(pressure[None])[0]
    distance = problem.distance - (problem.approach or 0.0)
    absolute = np.nan  # without pressure under a force there is none
    if pressure.any() or problem.force is None:
        absolute, _ = normal_gap(problem, pressure, rigid, elastic)
    figures = {
        "residual": normal_residual(problem, pressure, rigid, elastic),
        "gap": absolute,
        "objective": problem.area * float(pressure @ (0.5 * elastic + distance)),
    }
    shift = problem.distance - rigid[0] + elastic
    return figures, pressure > shift / problem.operator.diagonal


def _of_tractions(
    problem: TangentialProblem, iterate: RawSolution
) -> tuple[dict[str, float], np.ndarray]:
    traction = project(iterate.traction, problem.bound)
    rigid = iterate.rigid
    shift = problem.shift(traction, rigid)
    copies = problem.operator.copies  # 2 for one half of a symmetric contact, else 1
    absolute = copies * gap(problem, traction, rigid, shift)[0]
    objective = absolute
    if problem.symmetric:
        elastic = shift - problem.rigid_shift - rigid[:, None]
        energies = traction * (0.5 * elastic + problem.rigid_shift)
        objective = copies * problem.area * float(energies.sum())
    figures = {
        "residual": tangential_residual(problem, traction, rigid, shift),
        "gap": absolute,
        "objective": objective,
    }
    own = problem.operator.diagonal
    return figures, problem.potential.slips(traction - shift / own, own)
