"""Printed reports of solutions and of comparisons."""

from __future__ import annotations

import textwrap
from collections import defaultdict
from dataclasses import asdict, is_dataclass
from typing import Any

import numpy as np

from varcontact.discrete.stick_slip import EXTERIOR, SLIP
from varcontact.html import in_rows
from varcontact.results.error_estimate import ErrorEstimate, with_bar
from varcontact.results.history import History
from varcontact.results.quantities_of_interest import friction_limit
from varcontact.results.solution import Solution
from varcontact.scene.friction import BRANCHES, Law
from varcontact.scene.friction_laws import kind_of
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady, TimeStep
from varcontact.scene.surfaces import SampledDistance
from varcontact.scene.transient import Transient
from varcontact.solvers.interface import Calls


def report(sol: Solution, with_warnings: bool = True) -> str:
    """The printed report of a solution, see `Solution.report`."""
    above = [f"WARNING: {doubt}" for doubt in sol.scene.doubts if with_warnings]
    rows = [("WARNING", words) for words in sol.warnings if words not in sol.scene.doubts]
    rows += [*_loads(sol), ("contact", _contact_elements(sol)), *_samples(sol), ("", "")]
    rows += [*_certificate(sol), *_estimate(sol), ("", ""), *_methods(sol)]
    return "\n".join([*above, in_rows(headline(sol), rows, width=18)])


_KINDS = {Steady: "Steady rolling", Shift: "Shift", TimeStep: "A step of rolling in time"}


def headline(sol: Solution) -> str:
    """Kind of motion and bodies, and the number of elements, in a line."""
    kind = "Normal contact" if sol.motion is None else _KINDS[type(sol.motion)]
    bodies = "quasi-identical bodies"
    if sol.scene.coupled:
        bodies = f"{sol.scene.kind_of_bodies} bodies ({sol.scene.difference})"
    size = f"{sol.grid.nx} x {sol.grid.ny}"
    if sol.grid.line:
        size = f"line contact, {sol.grid.nx}"
    state = "" if sol.converged else ": NOT CONVERGED"
    return f"{kind} of {bodies}, {size} elements{state}"


def _contact_elements(sol: Solution) -> str:
    count = sol.elements
    text = f"{count['contact']} elements, {sol.areas['contact']:.4g}{_unit(sol, 'area')}"
    if sol.scene.line:
        text += " wide"
    if sol.scene.motion is not None:
        areas = [f"{number} {name}" for name, number in count.items() if name != "contact"]
        text += f": {', '.join(areas)}"
    return text


def _samples(sol: Solution) -> Rows:
    """Roughness of a plane surface that is given by samples with coordinates."""
    surface = sol.scene.surface
    if not isinstance(surface, SampledDistance) or surface.x is None or sol.scene.conformal:
        return []
    rough = surface.roughness
    slopes = f"root mean square slope {rough.slope_x:.3g} along x"
    if not sol.scene.line:
        slopes += f", {rough.slope_y:.3g} along y"
    return [("samples", f"Sq = {rough.Sq:.4g}{_unit(sol, 'length')} about a paraboloid, {slopes}")]


Rows = list[tuple[str, str]]
"""Headings and texts of the rows of a report; of a further line the heading is empty."""


def _loads(sol: Solution) -> Rows:
    """Forces, creepages, work and temperature."""
    rows = _normal_load(sol)
    if sol.motion is None:
        return rows
    rows += [("creepage" if sol.motion.rolls else "rigid shift", _rigid_motion(sol))]
    rows += [("tangential force", _tangential_force(sol))]
    largest = float(np.hypot(*sol.traction).max())
    if largest > 0:
        share = f"{largest / float(sol.pressure.max()):.4g} of the largest pressure"
        rows.append(("largest traction", share))
    rows += [("twisting moment", _twisting_moment(sol))]
    if not sol.plan.has_moment and sol.creepage[2]:
        unknown = f"unknown: {sol.plan.tangential} has no moment, which spin works against"
        rows.append(("work", unknown))
    elif not sol.scene.frictionless:
        rows += _work(sol)
    if sol.temperature is not None:
        rows.append(("temperature", _largest_temperature(sol, sol.temperature[0])))
    return rows


def _error_bars(sol: Solution) -> dict[str, float]:
    """Error bars of the values by name, 0 where none is known."""
    bars: dict[str, float] = defaultdict(float)
    if sol.error_estimate is not None:
        bars.update(sol.error_estimate.bars)
    return bars


def _normal_load(sol: Solution) -> Rows:
    bars = _error_bars(sol)
    peak = f"{sol.max_pressure:.4g}"
    if sol.error_estimate is not None and "peak_pressure" in bars:
        peak = with_bar(sol.error_estimate.values["peak_pressure"], bars["peak_pressure"])
    load = with_bar(sol.normal_force, bars["normal_force"]) + _unit(sol, "force")
    approach = _displacement(sol, sol.approach, bars["approach"])
    rows = [
        ("normal force", f"{load}, largest pressure {peak}{_unit(sol, 'pressure')}"),
        ("approach", approach),
    ]
    if sol.loads_beside:
        forces = np.sum([each.force for each in sol.loads_beside], axis=0)
        words = ", ".join(f"{force:.6g}" for force in forces)
        rows.append(("loads beside", f"Fx, Fy, Fz = {words}{_unit(sol, 'force')}"))
    return rows


def _rigid_motion(sol: Solution) -> str:
    """Creepages and spin, or the components of a rigid shift."""
    bars = _error_bars(sol)
    assert sol.motion is not None
    along_x, along_y, about_z = sol.creepage
    if sol.motion.rolls:
        words = [f"vx = {with_bar(along_x, bars['vx'])}", f"vy = {with_bar(along_y, bars['vy'])}"]
        turn = f"spin = {about_z:.6g}{_unit(sol, 'spin')}"
    else:
        ux = _displacement(sol, along_x, bars["ux"])
        uy = _displacement(sol, along_y, bars["uy"])
        words = [f"ux = {ux}", f"uy = {uy}"]
        turn = f"rotation = {about_z:.6g}"
    if not sol.scene.line:
        words.append(turn)
    return ", ".join(words)


def _tangential_force(sol: Solution) -> str:
    bars = _error_bars(sol)
    limit = friction_limit(sol)
    Fx, Fy = (_without_noise(F, limit) for F in sol.force)
    along_x = with_bar(_without_noise(Fx, Fy), bars["Fx"])
    along_y = with_bar(_without_noise(Fy, Fx), bars["Fy"])
    text = f"Fx = {along_x}, Fy = {along_y}{_unit(sol, 'force')}"
    if 0 < limit < np.inf:
        text += f", {100 * np.hypot(Fx, Fy) / limit:.4g} % of the friction limit"
    return text


def _twisting_moment(sol: Solution) -> str:
    if not sol.plan.has_moment:
        return f"none by {sol.plan.tangential}"
    scale = friction_limit(sol) * sol.grid.nx * sol.grid.sides[0]
    moment = _without_noise(sol.moment, scale)
    return f"Mz = {with_bar(moment, _error_bars(sol)['Mz'])}{_unit(sol, 'moment')}"


def _work(sol: Solution) -> Rows:
    """Work supplied and dissipated: of a shift, or per unit of distance rolled."""
    assert sol.motion is not None
    unit = _unit(sol, "force")
    distance = " per unit of distance rolled"
    if sol.motion.rolls == 0:
        unit = _unit(sol, "moment")
        distance = ""
    limit = friction_limit(sol)
    power = _without_noise(sol.power, limit)
    dissipated = _without_noise(sol.friction_work, limit)
    supplied = f"{power:.5g}{unit}"
    if np.isnan(power):
        supplied = "undefined (no reference depth)"
    sink = "friction"
    if sol.scene.flows:
        sink += " and flow of the third body"
    rows = [("work", f"{supplied} supplied, {dissipated:.5g}{unit} dissipated by {sink}{distance}")]
    if sol.scene.bodies.relaxes and isinstance(sol.motion, Steady):
        inside = f"{power - dissipated:.5g}{unit} dissipated inside the viscoelastic bodies"
        rows.append(("", inside))
    if sol.negative_work < 0:
        reason = "tractions of the theory do not oppose slip there"
        if sol.plan.theory is None:
            reason = "grid error"
        part = f"{-100 * sol.negative_work:.2g} % of it is negative on single elements"
        rows.append(("", f"{part}: {reason}"))
    return rows


def _largest_temperature(sol: Solution, temperature: np.ndarray) -> str:
    inside = np.where(sol.state != EXTERIOR, temperature, -np.inf)
    row, column = np.unravel_index(np.argmax(inside), inside.shape)
    place = f"x = {sol.grid.x[column]:.4g}"
    if not sol.scene.line:
        place += f", y = {sol.grid.y[row]:.4g}"
    return f"at most {inside.max():.4g} in the contact, at {place}{_unit(sol, 'length')}"


def _certificate(sol: Solution) -> Rows:
    certificate = sol.certificate
    gap = ""
    if certificate.level != "none":
        gap = f"relative gap {certificate.relative_gap:.1e}"
    if sol.plan.closed_form and not sol.plan.has_friction:
        sampled = f"residual {certificate.normal_residual:.1e}"
        sampled += f" and {gap}" if gap else ""
        return [
            ("certificate", "Hertz's closed form, exact in the continuum; no iterations"),
            ("", f"(residual of the discretised equations on this grid: {sampled})"),
        ]
    gap += ", " if gap else ""
    rows = [("certificate", f"{gap}residual {certificate.residual:.1e}")]
    reason = no_guarantee(sol)
    if reason:
        rows.append(("", f"no guaranteed bound: {reason}"))
    elif sol.plan.has_friction:
        rows.append(("", _force_bounds(sol)))
    if sol.note:
        rows.append(("", sol.note))
    if sol.plan.closed_form:
        exact = "Hertz's pressure is exact in the continuum; on this grid its residual is"
        rows.append(("", f"({exact} {certificate.normal_residual:.1e})"))
    return rows


def _force_bounds(sol: Solution) -> str:
    """Guaranteed bounds on the errors of forces and moment, and their assumptions."""
    bound = sol.certificate.force_bound
    sizes = f"Fx to {bound[0]:.1e}, Fy to {bound[1]:.1e}{_unit(sol, 'force')}"
    if sol.plan.has_moment:
        sizes += f", Mz to {bound[2]:.1e}{_unit(sol, 'moment')}"
    where = ""
    if isinstance(sol.motion, TimeStep):
        where = " in this step"
    if sol.plan.closed_form:
        where += " with Hertz's pressure"
    elif np.all(np.isfinite(sol.certificate.pressure_part)):
        where += " with the error of the pressure included"
    else:
        where += " with this pressure"
    return f"guaranteed bounds on this grid{where}: {sizes}"


def _estimate(sol: Solution) -> Rows:
    """Estimated errors against the continuum, of a solution to an accuracy or within a time."""
    estimate = sol.error_estimate
    if estimate is None or not estimate.errors:
        return [("", f"no error bar: {_no_estimate(sol)}")]
    # names of values with the same unit are grouped
    names: dict[str, list[str]] = {}
    for name, error in estimate.errors.items():
        names.setdefault(_unit_of_error(sol, name), []).append(f"{name} to {error:.1e}")
    errors = "; ".join(f"{', '.join(each)} of {unit}" for unit, each in names.items())
    grids = [f"{each.nx} x {each.ny}" for each in estimate.solves]
    if sol.grid.line:
        grids = [f"{each.nx}" for each in estimate.solves]
    seconds = sum(each.seconds for each in estimate.solves)
    return [
        ("", ""),
        ("accuracy", f"estimated errors against the continuum: {errors}"),
        *(("", line) for line in textwrap.wrap(estimate.how, 98)),
        ("", f"solved with {', '.join(grids)} elements in {seconds:.2g} s"),
    ]


def _unit_of_error(sol: Solution, name: str) -> str:
    """Unit of the error of a value, in words."""
    if not sol.plan.has_friction:
        return "themselves"
    return {"Fx": "f Fz", "Fy": "f Fz", "Mz": "f Fz sqrt(ab)"}.get(name, "saturation")


def _no_estimate(sol: Solution) -> str:
    """The reason why a solution has no error bar."""
    if sol.plan.theory is not None:
        theory = sol.plan.tangential
        return f"{theory} is an approximate theory, whose error does not fall with the elements"
    if sol.scene.no_slip:
        return "errors are relative to the friction limit, which is infinite"
    if not sol.scene.bare:
        return (
            "the certificate holds for this grid; "
            "solve on another to see how the answer depends on it"
        )
    chosen = "dq, spin_offset and slip_difference"
    if isinstance(sol.scene.grid, Grid):
        chosen = "the grid"
    return (
        f"the certificate holds for this grid; omit {chosen} for an error bar against the continuum"
    )


def no_guarantee(sol: Solution) -> str:
    """The reason why no bound on the forces is known; empty if one is."""
    if sol.certificate.level != "full":
        left_out = "bound" if sol.certificate.level == "gap" else "gap and bound"
        level = sol.certificate.level
        return f'{left_out} not computed: certify = "{level}"; "full" computes everything'
    bound = sol.certificate.force_bound[: 3 if sol.plan.has_moment else 2]
    if np.all(np.isfinite(bound)):
        return ""
    if np.any(np.isnan(bound)):
        return "the values exceed the range of floating-point numbers"
    if sol.scene.coupled:
        bodies = sol.scene.kind_of_bodies
        return f"the bodies are {bodies}, and the traction bound depends on the solution"
    if isinstance(sol.scene.friction, Law):
        variable = _variable_of_law(sol.scene.friction)
        return (
            f"the coefficient of friction depends on the {variable}, "
            "and there may be several solutions"
        )
    if sol.scene.yield_stress_changes:
        return "the yield stress of the third body depends on the solution"
    reason = (
        "the symmetric part of the problem is not found to be positive definite, so nothing is "
        "proved but the residual: there may be several solutions or none, and no method has to "
        "converge"
    )
    motion = sol.scene.motion
    dx, dy = sol.grid.sides
    if isinstance(motion, Steady) and motion.dq is not None and motion.dq < dx:
        return (
            f"{reason}; motion.dq = {motion.dq:.3g} is short for elements of {dx:.3g} by {dy:.3g}"
        )
    return reason


def _variable_of_law(law: Law) -> str:
    """Variable on which the coefficient of friction depends, in words."""
    if law.warm:
        return "temperature"
    return "solution" if law.local else "slip"


def _methods(sol: Solution) -> Rows:
    """Methods with their reasons, solver calls, friction law and times."""
    reasons = sol.plan.reasons
    rows = []
    if sol.plan.method != "auto":
        rows.append(("method", f"{sol.plan.method}: {reasons.get('method', '')}"))
    for name in ("normal", "tangential", "coupling"):
        chosen = getattr(sol.plan, name)
        rows.append((name, f"{chosen}: {reasons.get(name, '')}{_after_method(sol, name)}"))
    heading = "solver calls"
    for problem, solvers in sol.calls.items():
        calls = [_calls_of_solver(name, made) for name, made in solvers.items()]
        rows.append((heading, f"{problem}: {', '.join(calls)}"))
        heading = ""
    if sol.branch:
        rows.append(("friction law", _friction_law(sol)))
    stages = [f"{name} {seconds:.2f}" for name, seconds in sol.timing.items() if name != "total"]
    rows.append(("time", f"{sol.timing['total']:.2f} s ({', '.join(stages)})"))
    return rows


def _after_method(sol: Solution, name: str) -> str:
    """Passes of the coupling, or the solver that gave the answer if it is not the planned one."""
    if name == "coupling" and sol.passes and sol.friction is None:
        return f", {_counted_passes(len(sol.passes))}"
    solver = sol.solved_by.get(name, "")
    return f"; solved by {solver}" if solver not in ("", getattr(sol.plan, name)) else ""


def _calls_of_solver(name: str, calls: Calls) -> str:
    text = f"{name} once" if calls.count == 1 else f"{name} {calls.count} times"
    if calls.iterations:
        text += f" ({calls.iterations} iterations)"
    return text


def _friction_law(sol: Solution) -> str:
    """Kind of the law, start of the search, range of the coefficient, and passes."""
    assert isinstance(sol.scene.friction, Law)
    text = f"{kind_of(sol.scene.friction)}, solution found from {BRANCHES[sol.branch]}"
    coefficients = _coefficients(sol)
    if coefficients is not None:
        least, largest = coefficients
        text += f": coefficient {least:.4g} to {largest:.4g} in the slip area"
    if sol.passes:
        text += f"; {_counted_passes(len(sol.passes))}"
    if len(sol.passes) > 1:
        text += f", the last changed {sol.passes[-1][0]:.0e}"
    return text


def _counted_passes(count: int) -> str:
    return "1 pass" if count == 1 else f"{count} passes"


def _unit(sol: Solution, quantity: str) -> str:
    """The unit of a quantity after a blank; empty where the scene names no units."""
    if sol.scene.units is None:
        return ""
    return f" {sol.scene.units.of(quantity, sol.scene.line)}"


def _displacement(sol: Solution, value: float, bar: float) -> str:
    if np.isnan(value):
        return "undefined (no reference depth)"
    return f"{with_bar(value, bar)}{_unit(sol, 'length')}"


def _without_noise(value: float, scale: float) -> float:
    """Number, or zero where it is only rounding relative to the scale."""
    return 0.0 if abs(value) < 1e-13 * abs(scale) < np.inf else value


REPORTED_STEPS = 10
"""Largest number of steps of a history in its report."""


def report_history(history: History) -> str:
    """The printed report of a history, see `History.report`: up to ten steps evenly, and the last
    one in full.
    """
    planned = 0
    if isinstance(history.scene.motion, Transient):
        planned = history.scene.motion.steps
    count = len(history)
    state = "" if count == planned else f": {count} FINISHED"
    doubts = [f"WARNING: {doubt}" for doubt in history.scene.doubts]
    lines = [*doubts, f"Rolling in time, {planned} steps{state}", ""]
    if count == 0:
        return lines[0]
    shown = np.unique(np.linspace(0, count - 1, REPORTED_STEPS).round().astype(int))
    lines += _table_of_steps(history, shown)
    if history.scene.under_law:
        warned = [k for k in shown[:-1] if history[k].warnings]
        lines += [line for k in warned[-1:] for line in ("", _warning_of_step(history, k))]
    if history.scene.thermal is not None:
        lines += ["", f"Surface temperature at the end at most {history.temperature().max():.4g}."]
    if history.error_estimate is not None:
        lines += ["", _largest_errors(history.error_estimate)]
    return "\n".join([*lines, "", f"Step {count - 1}: {report(history[-1], with_warnings=False)}"])


def _table_of_steps(history: History, shown: np.ndarray) -> list[str]:
    headings = ("step", "rolled", "Fz", "Fx", "Fy", "Mz", "dissipated")
    columns = [history.rolled, history.normal_force, *history.force.T]
    columns += [history.moment, history.dissipation]
    lines = ["  ".join(name.rjust(11) for name in headings)]
    for k in shown:
        entries = [f"{k:11d}", *(f"{column[k]:11.5g}" for column in columns)]
        lines.append("  ".join(entries))
    return lines


def _warning_of_step(history: History, k: int) -> str:
    return f"WARNING: step {k}: {history[k].warnings[0]}"


def _largest_errors(estimate: ErrorEstimate) -> str:
    """The largest error of each value over all steps, whose names end in [step]."""
    largest: dict[str, float] = {}
    for name, error in estimate.errors.items():
        kind = name.partition("[")[0]
        largest[kind] = max(largest.get(kind, 0.0), error)
    errors = ", ".join(f"{name} to {error:.1e}" for name, error in largest.items())
    heading = "Estimated errors against the continuum, with steps of this length"
    return f"{heading}: {errors}, over all steps."


AS_THEY_ARE = (
    "normal_force",
    "force",
    "moment",
    "approach",
    "creepage",
    "power",
    "friction_work",
    "negative_work",
    "elements",
    "certificate",
    "converged",
    "iterations",
    "status",
    "solved_by",
    "calls",
    "branch",
    "note",
    "warnings",
    "error_estimate",
)
"""Entries of a summary that a solution has under the same names."""


def summary(sol: Solution) -> dict[str, Any]:
    """The solution as plain numbers, see `Solution.summary`."""
    return {
        **{name: plain(getattr(sol, name)) for name in AS_THEY_ARE},
        "doubts": list(sol.scene.doubts),
        "method": {name: getattr(sol.plan, name) for name in ("normal", "tangential", "coupling")},
        "road": sol.plan.method,
        "formulation": sol.plan.formulation,
        "passes": len(sol.passes),
        "convergence": plain(sol.passes),
        "coefficient": _coefficients(sol),
        "seconds": sol.timing["total"],
    }


def _coefficients(sol: Solution) -> list[float] | None:
    if sol.friction is None or not np.any(sol.state == SLIP):
        return None
    slipping = sol.friction[sol.state == SLIP]
    return [float(slipping.min()), float(slipping.max())]


def plain(value: Any) -> Any:
    """Dictionaries, lists, words and numbers for JSON, which has no NaN and no infinity: None for
    these.
    """
    if hasattr(value, "plain"):
        value = value.plain()
    if isinstance(value, dict):
        return {name: plain(each) for name, each in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(each) for each in value]
    if isinstance(value, float):
        return float(value) if np.isfinite(value) else None
    if is_dataclass(value) and not isinstance(value, type):
        return plain(asdict(value))
    return value
