"""Solvers of users: called on data that they cannot change, within their time, and never believed.

Whatever goes wrong in one is the failure of that solver: it is an answer without numbers, with the
reason as its status.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, TypeVar

import numpy as np

from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.discrete.residuals import normal_residual
from varcontact.errors import shortened
from varcontact.solvers.interface import OutOfTime, Settings
from varcontact.system.files import first_line
from varcontact.system.process import within

OwnFunction = Callable[[Any, Settings, RawSolution | None], Any]
"""Function of a problem, settings and a start to tractions, to (tractions, rigid shift), or to a
`RawSolution`."""
Data = TypeVar("Data")
TRACTION_MAX = 1e50
"""Largest dimensionless traction of an answer: products of more leave floating point."""
WORDS_MAX = 200
"""Characters of an error's first line."""
PRESSURE_RESIDUAL_MAX = 0.1
"""Residual above which pressures do not show where the contact is."""


class Failure(Exception):
    """Reason why an answer cannot be used."""


@dataclass(frozen=True)
class OwnSolver:
    """A solver of a user, with a limit of its time [s]."""

    function: OwnFunction
    time_limit: float = math.inf

    def __call__(
        self,
        problem: NormalProblem | TangentialProblem,
        settings: Settings,
        start: RawSolution | None,
    ) -> RawSolution:
        """Answer to a problem, or a failure without numbers that gives its reason."""
        try:
            return _answer(problem, self._called(problem, settings, start))
        except Failure as failure:
            return _no_answer(problem, str(failure))

    def _called(
        self,
        problem: NormalProblem | TangentialProblem,
        settings: Settings,
        start: RawSolution | None,
    ) -> Any:
        """Result of the user's function, called in a separate thread that Ctrl-C and the deadline
        can leave.
        """
        deadline = min(settings.deadline, time.perf_counter() + self.time_limit)
        handed = read_only(problem)
        initial = None
        if start is not None:
            initial = read_only(start)
        limited = replace(settings, deadline=deadline)

        def work() -> tuple[Any, BaseException | None]:
            try:
                return self.function(handed, limited, initial), None
            except BaseException as error:  # errors of the user's solver, of any kind
                return None, error

        try:
            result, error = within(work, deadline)
        except TimeoutError:
            raise Failure("it did not end within its time") from None
        if isinstance(error, OutOfTime):
            raise Failure("it did not end within its time")
        if error is not None:
            raise Failure(f"it raised {_words(error)}")
        return result


def read_only(data: Data) -> Data:
    """A copy of a dataclass whose arrays, and those of the dataclasses in it, cannot be changed."""
    changed = {}
    for each in fields(data):  # type: ignore[arg-type]
        if not each.init:  # made from the others
            continue
        value = getattr(data, each.name)
        if isinstance(value, np.ndarray):
            value = value.copy()
            value.flags.writeable = False
        elif is_dataclass(value) and not isinstance(value, type):
            value = read_only(value)
        changed[each.name] = value
    return replace(data, **changed)  # type: ignore[type-var]


def _words(error: BaseException) -> str:
    """Kind of an error and its first line, if that can be printed."""
    name = type(error).__name__
    if not isinstance(error, Exception):
        return name
    try:
        return f"{name}: {first_line(error)[:WORDS_MAX]}"
    except Exception:
        return name


def _answer(problem: NormalProblem | TangentialProblem, result: Any) -> RawSolution:
    """Raw solution from the result of the user's function; a `Failure` where it cannot be one."""
    raw = RawSolution(np.zeros(0), np.zeros(0), status="Solved")
    traction = result
    rigid = None
    if isinstance(result, RawSolution):
        raw = result
        traction = result.traction
        rigid = result.rigid
    elif isinstance(result, tuple) and len(result) == 2:
        traction, rigid = result
    if isinstance(problem, NormalProblem):
        pressure = _numbers("pressures", traction, problem.distance.shape)
        return _pressure(problem, raw, pressure, rigid)
    tractions = _numbers("tractions", traction, problem.rigid_shift.shape)
    if rigid is None and problem.free:
        raise Failure("it must return (tractions, rigid shift) where a force is prescribed")
    if rigid is None:
        rigid = np.zeros(problem.components)
    shifts = _numbers("rigid shift", rigid, (problem.components,))
    return replace(raw, traction=tractions, rigid=shifts, residual=math.nan)


def _pressure(
    problem: NormalProblem, raw: RawSolution, pressure: np.ndarray, rigid: Any
) -> RawSolution:
    """Pressures with their approach; if that is neither prescribed nor returned, it is the mean of
    ``h + A p`` weighted by them.
    """
    if not pressure.max() > 0:
        raise Failure("it returned no pressure")
    if problem.approach is not None or rigid is None:
        rigid = [problem.mean_approach(pressure)]
    approach = _numbers("approach", rigid, (1,))
    residual = normal_residual(problem, pressure, approach)
    if not residual <= PRESSURE_RESIDUAL_MAX:
        raise Failure(f"its pressures have a residual of {residual:.2g}")
    return replace(raw, traction=pressure, rigid=approach, residual=math.nan)


def _numbers(what: str, values: Any, shape: tuple[int, ...]) -> np.ndarray:
    """A copy of finite numbers of a shape."""
    try:
        array = np.asarray(values)
        good = array.dtype.kind in "iuf"
    except Exception:  # an object's own code runs here, and may raise anything
        good = False
    if not good:
        raise Failure(f"it returned {shortened(values)} as {what}")
    if array.shape != shape:
        raise Failure(f"it returned {what} of shape {array.shape}, not {shape}")
    numbers = array.astype(float)
    if not np.abs(numbers).max(initial=0.0) <= TRACTION_MAX:
        raise Failure(f"it returned {what} that are not finite, or out of range")
    return numbers


def _no_answer(problem: NormalProblem | TangentialProblem, reason: str) -> RawSolution:
    if isinstance(problem, NormalProblem):
        nothing = np.full(problem.distance.shape, np.nan)
        return RawSolution(nothing, np.full(1, np.nan), 0, reason, False)
    nothing = np.full(problem.rigid_shift.shape, np.nan)
    return RawSolution(nothing, np.full(problem.components, np.nan), 0, reason, False)
