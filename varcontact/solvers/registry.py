"""Table of solvers: each is an entry with the properties that the package needs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import Any, Literal

from varcontact import checks
from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.errors import SceneError, SolverUnavailable
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.active_set.tang import tang, tang_safeguarded
from varcontact.solvers.conic.backends import PROGRAM_SOLVERS, ProgramSolver, unlisted
from varcontact.solvers.interface import Settings, counted
from varcontact.system.process import imported

Kind = Literal["normal", "tangential"]
"""The problems that solvers are for."""


BYTES_SPLITTING = 1200.0
"""Bytes per unknown at the peak of splitting, most of them differences of its extrapolation:
measured at 1000 to 1150 in tangential problems and 630 to 740 in normal ones, from 1600 to 26 000
unknowns."""


@dataclass(frozen=True)
class SolverSpec:
    """A solver of one kind of problem; called, it counts its calls under its name.

    Attributes
    ----------
    name : str
    kind : {"normal", "tangential"}
    solve : callable
        Of a problem, settings and a start, which may be None, to a raw solution.
    matrix_free : bool
        Whether it forms no matrix, reaches a given tolerance, and restarts by itself.
    states_program : bool
        Whether it hands a convex program to a solver; its answer can be polished.
    needs : tuple of str
        Packages that have to be installed.
    intervals_only : bool
        Whether it takes Coulomb's disks only where these are intervals, in line contact.
    restarts : bool
        Whether it is called again, from no start, where it fails from one (the step, the pass
        or the creepage before).
    falls_back : bool
        Whether splitting takes over from its best point where it misses the tolerance.
    own : bool
        Whether it is a user's, see `register_solver`.
    bytes_per_unknown : float
        Memory at the peak of a solver without a matrix, with influence numbers and fields.
    """

    name: str
    kind: Kind
    solve: Callable[[Any, Settings, RawSolution | None], RawSolution]
    matrix_free: bool = False
    states_program: bool = False
    needs: tuple[str, ...] = ()
    intervals_only: bool = False
    restarts: bool = False
    falls_back: bool = False
    own: bool = False
    bytes_per_unknown: float = 900.0

    def __call__(
        self,
        problem: NormalProblem | TangentialProblem,
        settings: Settings,
        start: RawSolution | None,
    ) -> RawSolution:
        raw = self.once(problem, settings, start)
        if not self.restarts or start is None or raw.solved:
            return raw
        restarted = self.once(problem, settings, None)
        return replace(restarted, iterations=raw.iterations + restarted.iterations)

    def once(
        self,
        problem: NormalProblem | TangentialProblem,
        settings: Settings,
        start: RawSolution | None,
    ) -> RawSolution:
        """The answer of one call."""
        return counted(self.name, self.solve)(problem, settings, start)


def _norm(exchange: Literal["set", "one"]) -> Callable[..., RawSolution]:
    def solve(problem: NormalProblem, settings: Settings, start: RawSolution | None) -> RawSolution:
        follow = settings.stats.follow(problem)
        deadline = settings.deadline
        return norm(problem, start, exchange=exchange, deadline=deadline, follow=follow)

    return solve


def _tang(newton: Literal["inexact", "exact"]) -> Callable[..., RawSolution]:
    def solve(
        problem: TangentialProblem, settings: Settings, start: RawSolution | None
    ) -> RawSolution:
        follow = settings.stats.follow(problem)
        return tang(problem, start, newton=newton, deadline=settings.deadline, follow=follow)

    return solve


def _tang_safeguarded(
    problem: TangentialProblem, settings: Settings, start: RawSolution | None
) -> RawSolution:
    return tang_safeguarded(problem, start, settings=settings)


def _newton_normal(
    problem: NormalProblem, settings: Settings, start: RawSolution | None
) -> RawSolution:
    from varcontact.solvers.newton.normal import newton_normal

    return newton_normal(problem, settings, start)


def _newton_tangential(
    problem: TangentialProblem, settings: Settings, start: RawSolution | None
) -> RawSolution:
    from varcontact.solvers.newton.tangential import newton_tangential

    return newton_tangential(problem, settings, start)


def _splitting_normal(
    problem: NormalProblem, settings: Settings, start: RawSolution | None
) -> RawSolution:
    from varcontact.solvers.splitting.method import splitting_normal

    return splitting_normal(problem, settings, start)


def _splitting_tangential(
    problem: TangentialProblem, settings: Settings, start: RawSolution | None
) -> RawSolution:
    from varcontact.solvers.splitting.method import splitting_tangential

    return splitting_tangential(problem, settings, start)


def of_program(kind: Kind, solver: ProgramSolver) -> SolverSpec:
    """A solver of programs as one of normal or of tangential problems."""

    def solve(problem: Any, settings: Settings, _: RawSolution | None) -> RawSolution:
        if kind == "normal":
            return solver.normal(problem, settings)
        return solver.tangential(problem, settings)

    return SolverSpec(
        solver.name,
        kind,
        solve,
        states_program=True,
        needs=solver.needs,
        intervals_only=kind == "tangential" and not solver.cones,
    )


SOLVERS: dict[tuple[Kind, str], SolverSpec] = {
    (spec.kind, spec.name): spec
    for spec in (
        SolverSpec("norm", "normal", _norm("set"), falls_back=True),
        SolverSpec("norm-single", "normal", _norm("one")),
        SolverSpec("newton", "normal", _newton_normal, matrix_free=True, falls_back=True),
        SolverSpec(
            "splitting",
            "normal",
            _splitting_normal,
            matrix_free=True,
            bytes_per_unknown=BYTES_SPLITTING,
        ),
        SolverSpec("tang", "tangential", _tang("inexact"), restarts=True),
        SolverSpec("tang-exact", "tangential", _tang("exact"), restarts=True),
        SolverSpec(
            "tang-safeguarded", "tangential", _tang_safeguarded, restarts=True, falls_back=True
        ),
        SolverSpec("newton", "tangential", _newton_tangential, matrix_free=True, falls_back=True),
        SolverSpec(
            "splitting",
            "tangential",
            _splitting_tangential,
            matrix_free=True,
            bytes_per_unknown=BYTES_SPLITTING,
        ),
        *(of_program("normal", solver) for solver in PROGRAM_SOLVERS.values()),
        *(of_program("tangential", solver) for solver in PROGRAM_SOLVERS.values()),
    )
}
"""All solvers by kind and name, installed or not."""


def solvers(kind: Kind) -> list[SolverSpec]:
    """The solvers of one kind of problem, in the order of the table."""
    return [spec for spec in SOLVERS.values() if spec.kind == kind]


def normal_methods() -> list[str]:
    """Names of all methods of the normal problem, installed or not; "hertz" is the closed form."""
    return ["hertz", *(spec.name for spec in solvers("normal"))]


def tangential_methods() -> list[str]:
    """Names of the methods that solve the tangential problem itself, installed or not."""
    return [spec.name for spec in solvers("tangential") if not spec.intervals_only]


def solver_spec(kind: Kind, name: str) -> SolverSpec | None:
    """Solver with this name, in the table or behind an interface; None for a closed form, a theory
    or an unknown name.
    """
    spec = SOLVERS.get((kind, name))
    if spec is not None:
        return spec
    program_solver = unlisted(name)
    if program_solver is None:
        return None
    return of_program(kind, program_solver)


def solver(kind: Kind, name: str, names: Sequence[str] = ()) -> SolverSpec:
    """Solver with this name; the error for an unknown name lists the available ones."""
    spec = solver_spec(kind, name)
    if spec is None:
        allowed = f"one of {', '.join(names)}{checks.nearest(name, names)}"
        raise SceneError(kind, name, allowed)
    return spec


def matrix_free(kind: Kind, name: str) -> bool:
    """True for a solver that forms no matrix."""
    spec = solver_spec(kind, name)
    return spec is not None and spec.matrix_free


def states_program(kind: Kind, name: str) -> bool:
    """True for a solver of convex programs."""
    spec = solver_spec(kind, name)
    return spec is not None and spec.states_program


def check_installed(spec: SolverSpec) -> None:
    """Refuse a solver whose packages are not there."""
    missing = [package for package in spec.needs if find_spec(package) is None]
    if missing:
        raise SolverUnavailable(spec.name, f"pip install {' '.join(missing)}")


def load_packages(normal: str, tangential: str) -> None:
    """Import what solvers need, so that no time measured afterwards contains it."""
    for spec in (solver_spec("normal", normal), solver_spec("tangential", tangential)):
        if spec is not None:
            for package in spec.needs:
                imported(package)
