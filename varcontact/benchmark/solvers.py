"""Solvers of the comparison by name: the package's own, entry points, and users' modules."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any

from varcontact import checks
from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.errors import SceneError
from varcontact.solvers.conic.backends import BEHIND, PROGRAM_SOLVERS, ProgramSolver, unlisted
from varcontact.solvers.conic.backends import FORMULATIONS as ENERGIES
from varcontact.solvers.conic.programs import normal_program
from varcontact.solvers.interface import Settings
from varcontact.solvers.own import OwnSolver
from varcontact.solvers.registry import Kind, SolverSpec, check_installed, solver_spec
from varcontact.solving.own_solvers import solver_name
from varcontact.system.files import first_line

DEFAULT_SOLVERS = (
    "norm|tang-safeguarded",
    "newton",
    "splitting",
    "clarabel/complementary",
    "clarabel/potential",
    "clarabel/gap",
    "osqp",
    "osqp/potential",
    "scs",
    "qpsolvers:piqp",
    "qpsolvers:proxqp",
    "qpsolvers:daqp",
    "qpsolvers:quadprog",
    "qpsolvers:highs",
    "cvxpy:CLARABEL",
)
"""Solvers that are compared if none are named: active sets, Newton's method, projection and
contraction, and programs of three formulations by solvers of all kinds."""
FORM = "[normal|]tangential[/formulation], a name of a solver, or module:function"


@dataclass(frozen=True)
class Entry:
    """A solver of the comparison: of one kind of problem or of both, with its formulation."""

    name: str
    specs: tuple[SolverSpec, ...]
    formulation: str

    def spec_for(self, problem: NormalProblem | TangentialProblem) -> SolverSpec | None:
        """Solver for a problem; None where it does not apply."""
        kind = "tangential"
        if isinstance(problem, NormalProblem):
            kind = "normal"
        for spec in self.specs:
            if spec.kind == kind and self._applies(spec, problem):
                return spec
        return None

    def _applies(self, spec: SolverSpec, problem: NormalProblem | TangentialProblem) -> bool:
        disks = isinstance(problem, TangentialProblem) and problem.components == 2
        if disks and spec.intervals_only:
            return False
        # without symmetry there is no energy
        return problem.symmetric or self.formulation in ("auto", "gap")


def entry_named(text: str) -> Entry:
    """Solver with this name; SceneError if there is none, SolverUnavailable if it is not
    installed.
    """
    if not isinstance(text, str) or not text:
        raise SceneError("solvers", text, FORM)
    names, slash, formulation = text.partition("/")
    if slash:
        checks.choice("solvers", formulation, ENERGIES)
    specs = _specs(names)
    if not specs:
        raise SceneError("solvers", text, FORM)
    if slash:
        if not all(spec.states_program for spec in specs):
            allowed = f"without /{formulation}: it is no solver of programs"
            raise SceneError("solvers", text, allowed)
        specs = [_of_formulation(spec, formulation) for spec in specs]
    for spec in specs:
        check_installed(spec)
    return Entry(text, tuple(specs), formulation or "auto")


def _specs(names: str) -> list[SolverSpec]:
    """Solvers named by ``normal|tangential``, or by one name for both problems; empty unless both
    names of a pair are solvers.
    """
    normal, bar, tangential = names.partition("|")
    if not bar:
        tangential = normal
    found = [_spec("normal", normal), _spec("tangential", tangential)]
    specs = [spec for spec in found if spec is not None]
    if bar and len(specs) < 2:
        return []
    return specs


def _spec(kind: Kind, name: str) -> SolverSpec | None:
    module, colon, function = name.partition(":")
    if colon and module not in BEHIND:
        own = OwnSolver(_imported(module, function))
        return SolverSpec(name, kind, own, matrix_free=True, own=True)
    return solver_spec(kind, solver_name(kind, name))


def _of_formulation(spec: SolverSpec, formulation: str) -> SolverSpec:
    """Solver that states normal problems by this formulation instead of the cheapest one; solvers
    of tractions are unchanged.
    """
    if spec.kind == "tangential":
        return spec
    program_solver = PROGRAM_SOLVERS.get(spec.name) or unlisted(spec.name)
    assert isinstance(program_solver, ProgramSolver)

    def solve(problem: NormalProblem, settings: Settings, _: RawSolution | None) -> RawSolution:
        program = normal_program(problem, *ENERGIES[formulation])
        return program_solver.solve(program, settings)

    return replace(spec, solve=solve)


def _imported(module: str, function: str) -> Callable[..., Any]:
    """Function imported from a user's module."""
    name = f"{module}:{function}"
    try:
        found = getattr(import_module(module), function)
    except Exception as error:  # the module's own code runs here, and may raise anything
        why = f"{type(error).__name__}: {first_line(error)}"
        raise SceneError("solvers", name, f"a function of a module ({why})") from None
    if not callable(found):
        raise SceneError("solvers", name, "a function of a problem, settings and a start")
    return found


def without_made(problem: Any) -> Any:
    """Copy of the problem without the matrices, factors and transforms made for other solvers."""
    changed = {}
    for name in ("operator", "instant"):
        operator = getattr(problem, name, None)
        if operator is not None:
            changed[name] = replace(operator, grid_operator=replace(operator.grid_operator))
    return replace(problem, **changed)
