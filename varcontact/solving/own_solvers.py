"""Solvers of users by name: registered, given as functions, or found by entry points."""

from __future__ import annotations

import math
import pickle
import re
from collections.abc import Callable, Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, TypeVar

from varcontact import checks
from varcontact.errors import SceneError, SolverUnavailable
from varcontact.solvers.own import OwnFunction, OwnSolver
from varcontact.solvers.registry import SOLVERS, Kind, SolverSpec, solver_spec
from varcontact.system.files import first_line
from varcontact.theories.on_grid import THEORIES

Result = TypeVar("Result")
SolverChoice = str | OwnFunction
"""A method by name, or a function of a user."""
GROUP = "varcontact.solvers"
"""Group of the entry points."""
NAME = re.compile(r"\w[\w.-]*")
"""Pattern of solver names: without the characters that separate parts of method names."""
RESERVED = (
    "auto",
    "none",
    "hertz",
    "no-slip",
    "program",
    "convex",
    "conic",
    "active-set",
    "kalker",
)
"""Names with another meaning, which solvers cannot have."""


@checks.named_options()
def register_solver(
    name: str,
    solve: Callable[..., Any],
    kind: Kind = "tangential",
    *,
    time_limit: float = math.inf,
) -> None:
    """Give a solver of your own a name, by which it is called like those of the package.

    `solve`, `scan`, `compare`, `tradeoff` and scene files then take the name; `solve` and `scan`
    also take the function itself as `normal` or `tangential`. A package registers its solvers by an
    entry point of the group ``varcontact.solvers``: its name is that of the solver, and it names a
    function without arguments that calls this one.

    Parameters
    ----------
    name : str
        Letters, digits, points, ``-`` and ``_``. An own solver of this name is replaced.
    solve : callable
        ``solve(problem, settings, start)``. Of a normal problem it returns pressures (n,), or
        (pressures, approach (1,)); of a tangential one tractions (c, n), or (tractions, rigid
        shift (c,)), which it must where a force is prescribed. ``problem.shift(traction, rigid)``
        is ``W + M p``, ``problem.operator`` has M as ``apply`` and ``matrix``,
        ``problem.potential.projected(trial, weight)`` is the projection on the traction bound.
        ``settings.tol`` is the residual to reach, by `varcontact.energy.tangential_residual` or
        `normal_residual`; ``start`` an answer to begin with, or None. All arrays are read-only.
    kind : {"tangential", "normal"}
    time_limit : float
        Seconds of a call [s].

    Raises
    ------
    SceneError
        For a name that is taken or has other characters, what is no function, or another kind.

    Notes
    -----
    No answer is trusted: the certificate judges it, and `NotConverged` names what is missing.
    Where the function raises, returns something else or does not end, `NotConverged` names the
    solver and says so. It is called in a thread beside: Ctrl-C does not reach it, and past its time
    it is left to itself.

    Examples
    --------
    >>> import numpy as np
    >>> import varcontact as vc
    >>> def projected_steps(problem, settings, start):
    ...     p = np.zeros_like(problem.rigid_shift)
    ...     weight = np.linalg.norm(problem.operator.matrix, 2)
    ...     for _ in range(2000):
    ...         p = problem.potential.projected(p - problem.shift(p, p[:, 0] * 0) / weight, weight)
    ...     return p
    >>> vc.register_solver("projected-steps", projected_steps)
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    ...     friction=0.3, motion=vc.Shift(ux=0.1), grid=vc.Grid(nx=8, ny=8))
    >>> sol = vc.solve(scene, tangential="projected-steps")
    >>> sol.solved_by["tangential"], sol.certificate.residual < 1e-8
    ('projected-steps', True)
    """
    checks.choice("kind", kind, ("tangential", "normal"))
    _check_name(name, kind)
    _check_function("solve", solve)
    _add(name, kind, OwnSolver(solve, checks.positive_or_infinite("time_limit", time_limit)))


def _check_name(name: Any, kind: Kind) -> None:
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise SceneError("name", name, "a word of letters, digits, points, - and _")
    spec = SOLVERS.get((kind, name))
    if name in RESERVED or name in THEORIES or (spec is not None and not spec.own):
        raise SceneError("name", name, "another name: this one is taken")


def _check_function(field: str, function: Any) -> None:
    if not callable(function) or isinstance(function, type):
        raise SceneError(field, function, "a function of a problem, settings and a start")


def _add(name: str, kind: Kind, own: OwnSolver) -> None:
    SOLVERS[kind, name] = SolverSpec(name, kind, own, matrix_free=True, own=True)


def solver_name(kind: Kind, value: Any) -> Any:
    """The name of a method that is given by name or as a function; an entry point of the name is
    called.
    """
    if callable(value):
        _check_function(kind, value)
        return _adopted(kind, value)
    if not isinstance(value, str) or value in (*RESERVED, *THEORIES):
        return value
    if solver_spec(kind, value) is None:
        _call_entry_point(value)
    return value


def _adopted(kind: Kind, function: OwnFunction) -> str:
    """Name under which a function is registered: its own, if that is free."""
    for spec in SOLVERS.values():
        if spec.own and spec.kind == kind and spec.solve == OwnSolver(function):
            return spec.name
    own_name = getattr(function, "__name__", "own")
    plain = "".join(NAME.findall(str(own_name))) or "own"
    name = plain
    number = 1
    while (kind, name) in SOLVERS or name in (*RESERVED, *THEORIES):
        number += 1
        name = f"{plain}-{number}"
    _add(name, kind, OwnSolver(function))
    return name


@cache
def _entry_points() -> dict[str, EntryPoint]:
    return {each.name: each for each in entry_points(group=GROUP)}


def _call_entry_point(name: str) -> None:
    """Let a package register its solver of this name; `SolverUnavailable` where that fails."""
    entry_point = _entry_points().get(name)
    if entry_point is None:
        return
    try:
        entry_point.load()()
    except Exception as error:  # a package's own code runs here, and may raise anything
        why = f"{type(error).__name__}: {first_line(error)}"
        raise SolverUnavailable(
            name, f"its entry point {entry_point.value} fails ({why})"
        ) from None


Registered = Mapping[tuple[Kind, str], OwnSolver]
"""Own solvers by kind and name."""


def registered() -> Registered:
    """Registered solvers that can be sent to other processes."""
    return {
        key: spec.solve
        for key, spec in SOLVERS.items()
        if isinstance(spec.solve, OwnSolver) and _goes_elsewhere(spec.solve)
    }


def _goes_elsewhere(own: OwnSolver) -> bool:
    try:
        pickle.dumps(own)
    except Exception:  # pickle may raise anything
        return False
    return True


def with_registered(own: Registered, work: Callable[..., Result], *task: Any) -> Result:
    """Result of `work` in a process that first gets the registered solvers of another."""
    for (kind, name), each in own.items():
        _add(name, kind, each)
    return work(*task)
