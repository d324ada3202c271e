"""Answers whose values are those of their error estimates."""

from __future__ import annotations

import math
from dataclasses import replace

from varcontact.results.error_estimate import ErrorEstimate
from varcontact.results.history import History
from varcontact.results.solution import Solution
from varcontact.solving.error_norm import creepage_names, friction_limit

Answer = Solution | History


def with_values(answer: Answer, estimate: ErrorEstimate) -> Answer:
    """An answer with an estimate, whose values become its own; of a history each step with those of the step.

    Parameters
    ----------
    answer : Solution or History
    estimate : ErrorEstimate
        With the names of `values`.
    """
    if isinstance(answer, History):
        steps = [_with_values(sol, estimate.of_step(k)) for k, sol in enumerate(answer)]
        return replace(answer, solutions=steps)
    return _with_values(answer, estimate)


def _with_values(solution: Solution, estimate: ErrorEstimate) -> Solution:
    estimate = replace(estimate, values=_carried(estimate.values, solution))
    known = estimate.values
    names = creepage_names(solution)
    first, second, third = (known.get(name, own) for name, own in zip(names, solution.creepage, strict=True))
    approach = known.get("approach", solution.approach)
    return replace(solution, creepage=(first, second, third), approach=approach, error_estimate=estimate)


def _carried(values: dict[str, float], solution: Solution) -> dict[str, float]:
    """Values whose tangential force is not beyond what friction carries: extrapolated, it may be by a little."""
    if not {"Fx", "Fy"} <= set(values):
        return values
    size, limit = math.hypot(values["Fx"], values["Fy"]), friction_limit(solution)
    part = limit / size if size > limit else 1.0
    return values | {name: part * values[name] for name in ("Fx", "Fy")}


def peaks_by_hertz(answer: Answer) -> dict[str, float]:
    """Hertz's largest pressure of a solution, or of each step of a history in which the bodies touch.

    Parameters
    ----------
    answer : Solution or History
    """
    if isinstance(answer, History):
        return {f"{name}[{k}]": peak for k, sol in enumerate(answer) for name, peak in peaks_by_hertz(sol).items()}
    hertz = answer.scene.hertz if answer.pressure.any() else None
    return {} if hertz is None else {"peak_pressure": hertz.peak_pressure}
