"""A solution in words, for people; a comparison in words."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.scene.friction import BRANCHES, Law, kind_of
from varcontact.scene.motion import Shift, Steady, TimeStep, Transient

if TYPE_CHECKING:
    import pandas as pd

    from varcontact.planning.plan import Plan
    from varcontact.planning.sizes import Sizes
    from varcontact.problem.tally import Calls
    from varcontact.results.history import History
    from varcontact.results.solution import Solution


def report(sol: Solution) -> str:
    """The printed report of a solution, see `Solution.report`."""
    lines = [_headline(sol), ""]
    rows = [*_loads(sol), *_areas(sol), ("", ""), *_certificate(sol), ("", ""), *_methods(sol)]
    lines += [f"  {name:<18}{text}".rstrip() for name, text in rows]
    return "\n".join(lines)


_KINDS = {Steady: "Steady rolling", Shift: "Shift", TimeStep: "A step of rolling in time"}


def _headline(sol: Solution) -> str:
    kind = "Normal contact" if sol.motion is None else _KINDS[type(sol.motion)]
    K = sol.scene.bodies.K
    bodies = "quasi-identical bodies" if K == 0 else f"unlike bodies (K = {K:.3g})"
    state = "" if sol.converged else ": NOT CONVERGED"
    size = f"line contact, {sol.grid.nx}" if sol.grid.line else f"{sol.grid.nx} x {sol.grid.ny}"
    return f"{kind} of {bodies}, {size} elements{state}"


def _loads(sol: Solution) -> list[tuple[str, str]]:
    unit = _unit(sol)
    rows = [
        (
            "normal force",
            f"{sol.normal_force:.6g}{unit('force')}, largest pressure {sol.pressure.max():.4g}{unit('pressure')}",
        ),
        ("approach", _sized(sol.approach, unit("length"))),
    ]
    motion = sol.motion
    if motion is None:
        return rows
    first, second, third = sol.creepage
    if motion.rolls:
        turn = "" if sol.scene.line else f", spin = {third:.6g}{unit('spin')}"
        rows.append(("creepage", f"vx = {first:.6g}, vy = {second:.6g}{turn}"))
    else:
        turn = "" if sol.scene.line else f", rotation = {third:.6g}"
        shifts = (f"{name} = {_sized(value, unit('length'))}" for name, value in (("ux", first), ("uy", second)))
        rows.append(("rigid shift", ", ".join(shifts) + turn))
    limit = float(sol.traction_bound.sum() * sol.grid.area)
    Fx, Fy = (_without_noise(F, limit) for F in sol.force)
    part = f", {np.hypot(Fx, Fy) / limit:.4f} of what friction can carry" if 0 < limit < np.inf else ""
    rows.append(
        (
            "tangential force",
            f"Fx = {_without_noise(Fx, Fy):.6g}, Fy = {_without_noise(Fy, Fx):.6g}{unit('force')}{part}",
        )
    )
    moment = _without_noise(sol.moment, limit * sol.grid.nx * sol.grid.sides[0])
    rows.append(("twisting moment", f"Mz = {moment:.6g}{unit('moment')}"))
    return rows


def _areas(sol: Solution) -> list[tuple[str, str]]:
    count, unit = sol.elements, _unit(sol)
    size = f"{sol.areas['contact']:.4g}{unit('area')}" + (" wide" if sol.scene.line else "")
    text = f"{count['contact']} elements, {size}"
    if sol.scene.motion is not None:
        text += f": {count['stick']} stick, {count['slip']} slip"
    return [("contact", text)]


def _certificate(sol: Solution) -> list[tuple[str, str]]:
    certificate, unit = sol.certificate, _unit(sol)
    rows = [("certificate", f"relative gap {certificate.relative_gap:.1e}, residual {certificate.residual:.1e}")]
    bound, reason = certificate.force_bound, no_guarantee(sol)
    if reason:
        rows.append(("", f"no guaranteed bound: {reason}"))
    elif sol.plan.tangential != "none":
        guaranteed = f"Fx to {bound[0]:.1e}, Fy to {bound[1]:.1e}{unit('force')}, Mz to {bound[2]:.1e}{unit('moment')}"
        rows.append(("", f"guaranteed on this grid: {guaranteed}"))
    if sol.plan.normal == "hertz":
        rows.append(("", "(Hertz's pressure is exact but for the grid, whose own equations it meets "
                         f"to {certificate.normal_residual:.1e})"))  # fmt: skip
    return rows


def no_guarantee(sol: Solution) -> str:
    """Why no bound on the forces is known, or nothing where one is."""
    if np.all(np.isfinite(sol.certificate.force_bound)):
        return ""
    if np.any(np.isnan(sol.certificate.force_bound)):
        return "the numbers went beyond the range of floating point"
    if sol.scene.bodies.K != 0:
        return "the bodies are unlike, and the traction bound depends on the solution"
    if isinstance(sol.scene.friction, Law):
        return "the coefficient of friction depends on the slip, and there may be several solutions"
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
        end = f"; the answer is that of {by}" if by not in ("", chosen) else ""
        if name == "coupling" and sol.passes and sol.friction is None:
            end = f", {len(sol.passes)} passes"
        rows.append((name, f"{chosen}: {sol.plan.reasons.get(name, '')}{end}"))
    for problem, solvers in sol.calls.items():
        name = "solver calls" if problem == next(iter(sol.calls)) else ""
        rows.append((name, f"{problem}: {', '.join(_called(*each) for each in solvers.items())}"))
    if sol.branch:
        rows.append(("friction law", _law(sol)))
    stages = ", ".join(f"{name} {seconds:.2f}" for name, seconds in sol.timing.items() if name != "total")
    rows.append(("time", f"{sol.timing['total']:.2f} s ({stages})"))
    return rows


def _called(name: str, calls: Calls) -> str:
    """A solver's calls, for people."""
    iterations = f"{calls.iterations} iterations, " if calls.iterations else ""
    return f"{name} {calls.count} ({iterations}{calls.seconds:.2g} s)"


def _law(sol: Solution) -> str:
    """The law, the branch that was found, and the coefficients on it."""
    count = len(sol.passes)
    passes = f"; {count} passes, the last changed {sol.passes[-1][0]:.0e}" if count > 1 else f"; {count} pass" * count
    found = sol.summary()["coefficient"]
    values = "" if found is None else ": coefficient {:.4g} to {:.4g} where it slips".format(*found)
    assert isinstance(sol.scene.friction, Law)
    return f"{kind_of(sol.scene.friction)}, the solution found from {BRANCHES[sol.branch]}{values}{passes}"


def _unit(sol: Solution) -> Callable[[str], str]:
    units, line = sol.scene.units, sol.scene.line
    return lambda quantity: f" {units.of(quantity, line)}" if units is not None else ""


def _sized(displacement: float, unit: str) -> str:
    return "open (no reference depth)" if np.isnan(displacement) else f"{displacement:.6g}{unit}"


def _without_noise(value: float, scale: float) -> float:
    """A number, or zero where it is rounding beside the scale."""
    return 0.0 if abs(value) < 1e-13 * abs(scale) < np.inf else value


def report_history(history: History) -> str:
    """The printed report of a history, see `History.report`: up to ten steps evenly, and the last one in full."""
    wanted = history.scene.motion.steps if isinstance(history.scene.motion, Transient) else 0
    count = len(history)
    state = "" if count == wanted else f": {count} FINISHED"
    lines = [f"Rolling in time, {wanted} steps{state}", ""]
    if count == 0:
        return lines[0]
    heads = ("step", "rolled", "Fz", "Fx", "Fy", "Mz", "dissipated")
    lines.append("  ".join(name.rjust(11) for name in heads))
    columns = [history.rolled, history.normal_force, *history.force.T, history.moment, history.dissipation]
    shown = np.unique(np.linspace(0, count - 1, 10).round().astype(int))
    lines += ["  ".join([f"{k:11d}", *(f"{column[k]:11.5g}" for column in columns)]) for k in shown]
    return "\n".join([*lines, "", f"Step {count - 1}: {report(history[-1])}"])


def plan_report(plan: Plan) -> str:
    """The printed form of a plan: what, and why."""
    rows = [
        (name, f"{getattr(plan, name)}: {plan.reasons[name]}")
        for name in ("dimension", "bodies", "surface", "motion", "friction")
    ]
    rows += [("special", f"{name}: {plan.reasons[name]}") for name in plan.special]
    methods = ("method", "normal", "tangential", "coupling", "formulation")
    rows += [("", ""), *((name, f"{getattr(plan, name)}: {plan.reasons[name]}") for name in methods)]
    if plan.sizes is not None:
        rows += [("", ""), *_sizes(plan.sizes)]
    return "\n".join(["Plan", "", *(f"  {name:<20}{text}".rstrip() for name, text in rows)])


def _sizes(sizes: Sizes) -> list[tuple[str, str]]:
    most = "" if sizes.exact else "at most "
    sides = (
        ""
        if sizes.sides is None
        else f", each {sizes.sides[0]:.4g}" + f" by {sizes.sides[1]:.4g}" * (sizes.grid[0] > 1)
    )
    rows = [("grid", f"{sizes.grid[1]} x {sizes.grid[0]} elements{sides}")]
    for problem, count in sizes.elements.items():
        unknowns = sizes.unknowns[problem]
        rows.append(
            (
                f"{problem} problem",
                f"{most}{count} elements, {f'{most}{unknowns} unknowns' if unknowns else 'closed form'}",
            )
        )
    if sizes.mirrored:
        rows.append(("", "half the unknowns: the tangential problem is its own mirror image"))
    for matrix in sizes.matrices:
        most = "at most " if matrix.at_most else ""
        what = f"{most}{matrix.rows} x {matrix.columns}{' offsets' if matrix.kind == 'table' else ''}"
        rows.append((matrix.name, f"{matrix.kind}, {what}, {_bytes(matrix.bytes)}: {matrix.reason}"))
    stages = ", ".join(f"{name} {_bytes(size)}" for name, size in sizes.memory.items())
    rows.append(("peak memory", f"about {_bytes(sizes.peak)} ({stages})"))
    if not sizes.exact:
        rows.append(("", "upper bounds: the contact is not known before it is solved for"))
    return rows


def _bytes(size: float) -> str:
    """Bytes in a unit that suits."""
    power = next((power for power in range(3) if size < 1000 * 1024**power), 3)
    return f"{size / 1024**power:.3g} {('B', 'KiB', 'MiB', 'GiB')[power]}"


def summary(table: pd.DataFrame) -> str:
    """A comparison in words and figures, for people: a block for each scene, then what was not solved and why."""
    blocks = []
    for scene, rows in table.groupby("scene", sort=False):
        records = rows.to_dict("records")
        lines = [list(_SHOWN), *([_cell(row[name], form) for name, form in _SHOWN.values()] for row in records)]
        text = columns_of_text(lines, left=2)
        reasons = [f"  {row['method']}: {row['reason']}" for row in records if row["reason"]]
        blocks.append("\n".join([str(scene), *text, *reasons]))
    return "\n\n".join(blocks)


_SHOWN = {
    "method": ("method", "s"),
    "outcome": ("outcome", "s"),
    "Fx": ("Fx", ".6g"),
    "Fy": ("Fy", ".6g"),
    "Mz": ("Mz", ".5g"),
    "rel. gap": ("relative_gap", ".0e"),
    "residual": ("residual", ".0e"),
    "force off": ("force_distance", ".0e"),
    "traction off": ("traction_distance", ".0e"),
    "areas off": ("misclassified", ".0f"),
    "iterations": ("iterations", ".0f"),
    "set-up s": ("setup_seconds", ".3f"),
    "repeat s": ("repeat_seconds", ".3f"),
    "calls": ("calls", "s"),
}
"""Columns of the printed table: which of the measured ones, and how written."""


def columns_of_text(lines: list[list[str]], left: int) -> list[str]:
    """Lines of cells below each other, the first `left` columns flush left."""
    widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
    return [
        "  ".join(
            cell.ljust(width) if i < left else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in lines
    ]


def _cell(value: Any, form: str) -> str:
    """A value as text; nothing where it is not known."""
    return "" if value != value else format(value, form)
