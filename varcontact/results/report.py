"""A solution in words, for people; a comparison in words."""

from __future__ import annotations

import textwrap
from collections import defaultdict
from collections.abc import Callable
from dataclasses import asdict, is_dataclass
from typing import Any

import numpy as np

from varcontact.discrete.stick_slip import EXTERIOR, SLIP
from varcontact.html import in_rows
from varcontact.results.error_estimate import with_bar
from varcontact.results.history import History
from varcontact.results.solution import Solution
from varcontact.scene.friction import BRANCHES, Law
from varcontact.scene.friction_laws import kind_of
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady, TimeStep
from varcontact.scene.transient import Transient


def report(sol: Solution, with_doubts: bool = True) -> str:
    """The printed report of a solution, see `Solution.report`."""
    above = [f"WARNING: {doubt}" for doubt in sol.scene.doubts if with_doubts]
    count = sol.elements
    text = (
        f"{count['contact']} elements, {sol.areas['contact']:.4g}{_unit(sol)('area')}"
        + " wide" * sol.scene.line
    )
    if sol.scene.motion is not None:
        text += ": " + ", ".join(
            f"{number} {name}" for name, number in count.items() if name != "contact"
        )
    warned = [("WARNING", words) for words in sol.warnings if words not in sol.scene.doubts]
    rows = [*warned, *_loads(sol), ("contact", text), ("", "")]
    rows += [*_certificate(sol), *_estimate(sol), ("", ""), *_methods(sol)]
    return "\n".join([*above, in_rows(headline(sol), rows, width=18)])


_KINDS = {Steady: "Steady rolling", Shift: "Shift", TimeStep: "A step of rolling in time"}


def headline(sol: Solution) -> str:
    """What was solved, in a line."""
    kind = "Normal contact" if sol.motion is None else _KINDS[type(sol.motion)]
    unlike = "conformal" if sol.scene.conformal else "unlike"
    bodies = (
        f"{unlike} bodies ({sol.scene.difference})"
        if sol.scene.coupled
        else "quasi-identical bodies"
    )
    state = "" if sol.converged else ": NOT CONVERGED"
    size = f"line contact, {sol.grid.nx}" if sol.grid.line else f"{sol.grid.nx} x {sol.grid.ny}"
    return f"{kind} of {bodies}, {size} elements{state}"


def _loads(sol: Solution) -> list[tuple[str, str]]:
    unit, bars = (
        _unit(sol),
        defaultdict(float, {} if sol.error_estimate is None else sol.error_estimate.bars),
    )
    load, peak = with_bar(sol.normal_force, bars["normal_force"]), f"{sol.max_pressure:.4g}"
    if sol.error_estimate is not None and "peak_pressure" in bars:
        peak = with_bar(sol.error_estimate.values["peak_pressure"], bars["peak_pressure"])
    rows = [
        ("normal force", f"{load}{unit('force')}, largest pressure {peak}{unit('pressure')}"),
        ("approach", _sized(sol.approach, unit("length"), bars["approach"])),
    ]
    motion = sol.motion
    if motion is None:
        return rows
    first, second, third = sol.creepage
    if motion.rolls:
        words, turn = "creepage", f", spin = {third:.6g}{unit('spin')}"
        rigid = [
            f"{name} = {with_bar(value, bars[name])}"
            for name, value in (("vx", first), ("vy", second))
        ]
    else:
        words, turn, values = (
            "rigid shift",
            f", rotation = {third:.6g}",
            (("ux", first), ("uy", second)),
        )
        rigid = [f"{name} = {_sized(value, unit('length'), bars[name])}" for name, value in values]
    rows.append((words, ", ".join(rigid) + ("" if sol.scene.line else turn)))
    limit = float(sol.traction_bound.sum() * sol.grid.area)
    Fx, Fy = (_without_noise(F, limit) for F in sol.force)
    part = (
        f", {100 * np.hypot(Fx, Fy) / limit:.4g} % of the friction limit"
        if 0 < limit < np.inf
        else ""
    )
    forces = (("Fx", _without_noise(Fx, Fy)), ("Fy", _without_noise(Fy, Fx)))
    words = ", ".join(f"{name} = {with_bar(value, bars[name])}" for name, value in forces)
    rows.append(("tangential force", f"{words}{unit('force')}{part}"))
    moment = _without_noise(sol.moment, limit * sol.grid.nx * sol.grid.sides[0])
    known = f"Mz = {with_bar(moment, bars['Mz'])}{unit('moment')}" if sol.plan.has_moment else ""
    rows.append(("twisting moment", known or f"none by {sol.plan.tangential}"))
    if not known and third:
        rows.append(
            ("work", f"unknown: {sol.plan.tangential} has no moment, which spin works against")
        )
    elif not sol.scene.frictionless:
        by = "moment" if motion.rolls == 0 else "force"
        put, lost = (_without_noise(work, limit) for work in (sol.power, sol.friction_work))
        how = "" if motion.rolls == 0 else " per unit of distance rolled"
        given = "undefined (no reference depth)" if np.isnan(put) else f"{put:.5g}{unit(by)}"
        layer = sol.scene.third_body
        flow = "" if layer is None or not layer.yields else " and flow of the third body"
        rows.append(
            ("work", f"{given} supplied, {lost:.5g}{unit(by)} dissipated by friction{flow}{how}")
        )
        if sol.scene.bodies.relaxes and isinstance(motion, Steady):
            rows.append(
                ("", f"{put - lost:.5g}{unit(by)} dissipated inside the viscoelastic bodies")
            )
        if sol.negative_work < 0:
            part = f"{-100 * sol.negative_work:.2g} %"
            why = (
                "grid error"
                if sol.plan.theory is None
                else "tractions of the theory do not oppose slip there"
            )
            rows.append(("", f"{part} of it is negative on single elements: {why}"))
    if sol.temperature is not None:
        found = np.where(sol.state != EXTERIOR, sol.temperature[0], -np.inf)
        row, column = np.unravel_index(np.argmax(found), found.shape)
        where = f"x = {sol.grid.x[column]:.4g}" + (
            "" if sol.scene.line else f", y = {sol.grid.y[row]:.4g}"
        )
        rows.append(
            ("temperature", f"at most {found.max():.4g} in the contact, at {where}{unit('length')}")
        )
    return rows


def _certificate(sol: Solution) -> list[tuple[str, str]]:
    certificate, unit = sol.certificate, _unit(sol)
    if sol.plan.closed_form and not sol.plan.has_friction:
        gap = (
            ""
            if certificate.level == "none"
            else f" and relative gap {certificate.relative_gap:.1e}"
        )
        sampled = f"residual {certificate.normal_residual:.1e}{gap}"
        return [
            ("certificate", "Hertz's closed form, exact in the continuum; no iterations"),
            ("", f"(residual of the discretised equations on this grid: {sampled})"),
        ]
    gap = "" if certificate.level == "none" else f"relative gap {certificate.relative_gap:.1e}, "
    rows = [("certificate", f"{gap}residual {certificate.residual:.1e}")]
    bound, reason = certificate.force_bound, no_guarantee(sol)
    if reason:
        rows.append(("", f"no guaranteed bound: {reason}"))
    elif sol.plan.has_friction:
        sizes = f"Fx to {bound[0]:.1e}, Fy to {bound[1]:.1e}{unit('force')}"
        sizes += f", Mz to {bound[2]:.1e}{unit('moment')}" if sol.plan.has_moment else ""
        where = " in this step" if isinstance(sol.motion, TimeStep) else ""
        if sol.plan.closed_form:
            where += " with Hertz's pressure"
        elif np.all(np.isfinite(certificate.pressure_part)):
            where += " with the error of the pressure included"
        else:
            where += " with this pressure"
        rows.append(("", f"guaranteed bounds on this grid{where}: {sizes}"))
    if sol.note:
        rows.append(("", sol.note))
    if sol.plan.closed_form:
        rows.append(("", "(Hertz's pressure is exact in the continuum; on this grid its residual is "
                         f"{certificate.normal_residual:.1e})"))  # fmt: skip
    return rows


def _estimate(sol: Solution) -> list[tuple[str, str]]:
    """How far the answer is from the continuum, about: of a solution to an accuracy, or within a
    time.
    """
    estimate = sol.error_estimate
    if estimate is None or not estimate.errors:
        chosen = (
            "the grid"
            if isinstance(sol.scene.grid, Grid)
            else "dq, spin_offset and slip_difference"
        )
        why = f"the certificate holds for this grid; omit {chosen} for an error bar against the continuum"
        if sol.plan.theory is not None:
            why = f"{sol.plan.tangential} is an approximate theory, whose error does not fall with the elements"
        elif sol.scene.no_slip:
            why = "errors are relative to the friction limit, which is infinite"
        elif sol.scene.third_body is not None:
            why = "the certificate holds for this grid; solve on another to see how the answer depends on it"
        return [("", f"no error bar: {why}")]
    force, moment, rest = "f Fz", "f Fz sqrt(ab)", "saturation"
    if not sol.plan.has_friction:
        force = moment = rest = "themselves"
    units = {"Fx": force, "Fy": force, "Mz": moment}
    said: dict[str, list[str]] = {}
    for name, error in estimate.errors.items():
        said.setdefault(units.get(name, rest), []).append(f"{name} to {error:.1e}")
    errors = "; ".join(f"{', '.join(names)} of {unit}" for unit, names in said.items())
    grids = ", ".join(
        f"{each.nx} x {each.ny}" if not sol.grid.line else f"{each.nx}" for each in estimate.solves
    )
    return [
        ("", ""),
        ("accuracy", f"estimated errors against the continuum: {errors}"),
        *(("", line) for line in textwrap.wrap(estimate.how, 98)),
        (
            "",
            f"solved with {grids} elements in {sum(each.seconds for each in estimate.solves):.2g} s",
        ),
    ]


def no_guarantee(sol: Solution) -> str:
    """Why no bound on the forces is known, or nothing where one is."""
    if sol.certificate.level != "full":
        left_out = "bound" if sol.certificate.level == "gap" else "gap and bound"
        return f'{left_out} not computed: certify = "{sol.certificate.level}"; "full" computes everything'
    bound = sol.certificate.force_bound[: 3 if sol.plan.has_moment else 2]
    if np.all(np.isfinite(bound)):
        return ""
    if np.any(np.isnan(bound)):
        return "the values exceed the range of floating-point numbers"
    if sol.scene.coupled:
        kind = "conformal" if sol.scene.conformal else "unlike"
        return f"the bodies are {kind}, and the traction bound depends on the solution"
    if isinstance(sol.scene.friction, Law):
        on = (
            "temperature"
            if sol.scene.friction.warm
            else "solution"
            if sol.scene.friction.local
            else "slip"
        )
        return (
            f"the coefficient of friction depends on the {on}, and there may be several solutions"
        )
    if sol.scene.third_body is not None and sol.scene.third_body.k_tau != 0:
        return "the yield stress of the third body depends on the solution"
    dx, dy = sol.grid.sides
    step = sol.scene.motion.dq if isinstance(sol.scene.motion, Steady) else None
    return (
        "the symmetric part of the problem is not positive definite, and there may be several solutions or none: "
        f"motion.dq = {step if step is not None else dx:.3g} is too short for elements with sides {dx:.3g} by {dy:.3g}"
    )


def _methods(sol: Solution) -> list[tuple[str, str]]:
    rows = []
    if sol.plan.method != "auto":
        rows.append(("method", f"{sol.plan.method}: {sol.plan.reasons.get('method', '')}"))
    for name in ("normal", "tangential", "coupling"):
        chosen, by = getattr(sol.plan, name), sol.solved_by.get(name, "")
        end = f"; solved by {by}" if by not in ("", chosen) else ""
        if name == "coupling" and sol.passes and sol.friction is None:
            end = f", {len(sol.passes)} passes"
        rows.append((name, f"{chosen}: {sol.plan.reasons.get(name, '')}{end}"))
    for problem, solvers in sol.calls.items():
        each = []
        for name, calls in solvers.items():
            often = "once" if calls.count == 1 else f"{calls.count} times"
            each.append(
                f"{name} {often}"
                + (f" ({calls.iterations} iterations)" if calls.iterations else "")
            )
        rows.append(
            (
                "solver calls" if problem == next(iter(sol.calls)) else "",
                f"{problem}: {', '.join(each)}",
            )
        )
    if sol.branch:
        count, found = len(sol.passes), _coefficients(sol)
        passes = (
            f"; {count} passes, the last changed {sol.passes[-1][0]:.0e}"
            if count > 1
            else f"; {count} pass" * count
        )
        values = (
            ""
            if found is None
            else ": coefficient {:.4g} to {:.4g} in the slip area".format(*found)
        )
        assert isinstance(sol.scene.friction, Law)
        law = f"{kind_of(sol.scene.friction)}, solution found from {BRANCHES[sol.branch]}{values}{passes}"
        rows.append(("friction law", law))
    stages = ", ".join(
        f"{name} {seconds:.2f}" for name, seconds in sol.timing.items() if name != "total"
    )
    rows.append(("time", f"{sol.timing['total']:.2f} s ({stages})"))
    return rows


def _unit(sol: Solution) -> Callable[[str], str]:
    units, line = sol.scene.units, sol.scene.line
    return lambda quantity: f" {units.of(quantity, line)}" if units is not None else ""


def _sized(displacement: float, unit: str, bar: float) -> str:
    return (
        "undefined (no reference depth)"
        if np.isnan(displacement)
        else f"{with_bar(displacement, bar)}{unit}"
    )


def _without_noise(value: float, scale: float) -> float:
    """A number, or zero where it is rounding beside the scale."""
    return 0.0 if abs(value) < 1e-13 * abs(scale) < np.inf else value


def report_history(history: History) -> str:
    """The printed report of a history, see `History.report`: up to ten steps evenly, and the last
    one in full.
    """
    wanted = history.scene.motion.steps if isinstance(history.scene.motion, Transient) else 0
    count = len(history)
    state = "" if count == wanted else f": {count} FINISHED"
    doubts = [f"WARNING: {doubt}" for doubt in history.scene.doubts]
    lines = [*doubts, f"Rolling in time, {wanted} steps{state}", ""]
    if count == 0:
        return lines[0]
    lines.append(
        "  ".join(
            name.rjust(11) for name in ("step", "rolled", "Fz", "Fx", "Fy", "Mz", "dissipated")
        )
    )
    columns = [
        history.rolled,
        history.normal_force,
        *history.force.T,
        history.moment,
        history.dissipation,
    ]
    shown = np.unique(np.linspace(0, count - 1, 10).round().astype(int))
    lines += ["  ".join([f"{k:11d}", *(f"{column[k]:11.5g}" for column in columns)]) for k in shown]
    warned = [k for k in shown[:-1] if history.scene.under_law and history[k].warnings][-1:]
    lines += (
        ["", *(f"WARNING: step {k}: {history[k].warnings[0]}" for k in warned)] if warned else []
    )
    if history.scene.thermal is not None:
        lines += ["", f"Surface temperature at the end at most {history.temperature().max():.4g}."]
    estimate = history.error_estimate
    if estimate is not None:
        largest: dict[str, float] = {}
        for name, error in estimate.errors.items():
            kind = name.partition("[")[0]
            largest[kind] = max(largest.get(kind, 0.0), error)
        errors = ", ".join(f"{name} to {error:.1e}" for name, error in largest.items())
        lines += [
            "",
            f"Estimated errors against the continuum, with steps of this length: {errors}, over all steps.",
        ]
    return "\n".join([*lines, "", f"Step {count - 1}: {report(history[-1], with_doubts=False)}"])


AS_THEY_ARE = (
    *(
        "normal_force",
        "force",
        "moment",
        "approach",
        "creepage",
        "power",
        "friction_work",
        "negative_work",
    ),
    *(
        "elements",
        "certificate",
        "converged",
        "iterations",
        "status",
        "solved_by",
        "calls",
        "branch",
        "note",
    ),
    *("warnings", "error_estimate"),
)
"""What a summary has of a solution under its own name."""


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
    found = sol.friction[sol.state == SLIP]
    return [float(found.min()), float(found.max())]


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
    return plain(asdict(value)) if is_dataclass(value) and not isinstance(value, type) else value
