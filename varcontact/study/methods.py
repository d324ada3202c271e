"""Methods of studies: what their names say, and what each makes of a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from varcontact import checks
from varcontact.errors import NotConverged, SceneError, SolverUnavailable, VarcontactError
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.solvers.registry import (
    Kind,
    load_packages,
    normal_methods,
    solver_spec,
    tangential_methods,
)
from varcontact.solving.methods import FORMULATIONS, Methods
from varcontact.solving.own_solvers import solver_name
from varcontact.solving.selection import PRESETS, select
from varcontact.solving.warm_start import Series, solve_in_turn
from varcontact.theories.on_grid import THEORIES

DEFAULT_METHODS = (
    "conic", "convex", "active-set", "kalker", "clarabel", "clarabel+polish", "scs",
    "cvxpy:CLARABEL", "tang", "fastsim", "fastsim-weighted", "linear", "vermeulen-johnson"
)  # fmt: skip
BOUNDS = ("Fx_bound", "Fy_bound", "Mz_bound")
"""Columns of the guaranteed bounds on the errors of forces and moment."""


@dataclass(frozen=True)
class Method:
    """A method of a comparison by its name.

    `pair`: whether a solver is named for each of the two problems. `tractions`: whether there is
    one for tangential problems.
    """

    name: str
    methods: Methods
    polish: bool = False
    pair: bool = True
    tractions: bool = True

    @classmethod
    def named(cls, text: str | Methods) -> Method:
        """Method from a name, ``[normal|]tangential[/formulation][+polish]``, or from `Methods`."""
        if isinstance(text, Methods):
            return cls(str(text), text)
        if callable(text):
            allowed = "a name: register_solver gives one to a function"
            raise SceneError("methods", text, allowed)
        name = str(text).strip()
        rest, plus, polish = name.partition("+")
        if plus and polish != "polish":
            raise SceneError("methods", text, 'with no other suffix than "+polish"')
        rest, _, formulation = rest.partition("/")
        if formulation:
            checks.choice("methods", formulation, FORMULATIONS[1:])
        else:
            formulation = "auto"
        if rest in PRESETS and rest != "auto":
            if plus:
                allowed = f'"{rest}": only a program solver called by name is polished'
                raise SceneError("methods", text, allowed)
            return cls(name, Methods(formulation=formulation, method=rest), pair=False)
        normal, tangential = _pair(rest)
        methods = Methods(normal=normal, tangential=tangential or "auto", formulation=formulation)
        return cls(name, methods, bool(plus), "|" in name, tangential != "")

    def plan(self, scene: Scene) -> Plan:
        """The plan for a scene; SceneError or SolverUnavailable if the method does not apply to
        it.
        """
        moves = scene.motion is not None
        if moves and not self.tractions:
            allowed = f'a pair, as "{self.name}|clarabel": it is for normal problems'
            raise SceneError("methods", self.name, allowed)
        methods = self.methods
        if select(scene).normal == "hertz" and not self.pair and moves:
            methods = replace(methods, normal="auto")
        plan = select(scene, methods)
        to_polish = plan.states_program("normal")
        to_polish |= plan.states_program("tangential")
        if self.polish and not to_polish:
            allowed = 'without "+polish": only program solvers are polished'
            raise SceneError("methods", self.name, allowed)
        return plan


def _pair(text: str) -> tuple[str, str]:
    """The normal and the tangential method of ``normal|tangential``, or of one name for both; ""
    for none.
    """
    normal, bar, tangential = text.partition("|")
    every = ["auto", *tangential_methods(), *THEORIES]
    if bar:
        if not _is_solver("normal", normal):
            checks.choice("methods", normal, ["auto", *normal_methods()])
        if not _is_solver("tangential", tangential):
            checks.choice("methods", tangential, every)
        return normal, tangential
    if _is_solver("normal", text):
        return text, text if _is_solver("tangential", text) else ""
    if _is_solver("tangential", text):
        return "norm", text
    only_normal = [name for name in normal_methods() if name not in every]
    checks.choice("methods", text, list(dict.fromkeys([*every, *PRESETS, *only_normal])))
    if text == "hertz":
        return text, ""
    return "auto", text


def _is_solver(kind: Kind, name: str) -> bool:
    """True for a solver of one kind of problem, installed or not; missing packages are reported
    later.
    """
    spec = solver_spec(kind, solver_name(kind, name))
    return spec is not None and not spec.intervals_only


def attempted(
    scene: Scene,
    method: Method,
    tol: float,
    motions: Sequence[Steady | Shift | None],
    trace: bool = False,
) -> tuple[str, str, list[Solution]]:
    """Outcome of the first motion and its reason, and the solutions for all motions, as far as the
    method gets.

    If the first does not converge, the solutions are its best iterate alone, if there is one.
    """
    solutions: list[Solution] = []
    try:
        plan = method.plan(scene)
        load_packages(plan.normal, plan.tangential)
        series = Series(tol, method.polish, trace=trace)
        solutions.extend(solve_in_turn(scene, motions, plan, series))
    except VarcontactError as error:
        if not solutions:  # those before a later failure stay
            if isinstance(error, NotConverged) and error.solution is not None:
                solutions = [error.solution]
            return failure(error), str(error), solutions
    return outcome(plan), "", solutions


def failure(error: VarcontactError) -> str:
    """The outcome of a solve that ends with an error."""
    if isinstance(error, NotConverged):
        return "not converged"
    if isinstance(error, SolverUnavailable):
        return "unavailable"
    return "refused"


def outcome(plan: Plan) -> str:
    """The outcome of a plan that gives a solution: that of theories, closed forms and single passes
    is approximate.
    """
    formula = plan.theory is not None or (not plan.has_friction and plan.closed_form)
    if formula or plan.coupling == "johnson":
        return "approximate"
    return "solved"


def neighbour(motion: Steady | Shift) -> Steady | Shift:
    """The motion with creepages and forces one per cent smaller."""
    names = ("vx", "vy", "spin") if isinstance(motion, Steady) else ("ux", "uy", "rotation")
    values = {name: getattr(motion, name) for name in (*names, "Fx", "Fy")}
    smaller: dict[str, Any] = {
        name: None if value is None else 0.99 * value for name, value in values.items()
    }
    return replace(motion, **smaller)


def figures(sol: Solution) -> dict[str, Any]:
    """Figures of a solution by the columns that tables of studies have; of a shift vx, vy and spin
    are its own.
    """
    certificate = sol.certificate
    Fx, Fy = map(float, sol.force)
    vx, vy, spin = map(float, sol.creepage)
    columns = {
        "Fx": Fx,
        "Fy": Fy,
        "vx": vx,
        "vy": vy,
        "spin": spin,
        "Mz": sol.moment,
        "normal_force": sol.normal_force,
        "approach": sol.approach,
        "max_pressure": sol.max_pressure,
        "friction_work": sol.friction_work,
        "gap": certificate.gap,
        "relative_gap": certificate.relative_gap,
        "residual": certificate.residual,
        "iterations": sum(sol.iterations.values()),
        **sol.elements,
    }
    columns |= {f"{name}_area": area for name, area in sol.areas.items()}
    if certificate.level == "full":
        columns |= zip(BOUNDS, map(float, certificate.force_bound), strict=True)
    if sol.error_estimate is not None:
        columns |= {f"{name}_error": bar for name, bar in sol.error_estimate.bars.items()}
    return columns
