"""A plan in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from varcontact.system import memory

if TYPE_CHECKING:
    from varcontact.planning.costs import Cost
    from varcontact.planning.plan import Plan
    from varcontact.planning.sizes import Sizes


def plan_report(plan: Plan) -> str:
    """The printed form of a plan: what, and why.

    Parameters
    ----------
    plan : Plan
    """
    return "\n".join(["Plan", "", *(f"  {name:<20}{text}".rstrip() for name, text in plan_rows(plan))])


def plan_rows(plan: Plan) -> list[tuple[str, str]]:
    """What a plan says, by name; empty rows part it.

    Parameters
    ----------
    plan : Plan
    """
    rows = [("WARNING", doubt) for doubt in plan.doubts]
    rows += [
        (name, f"{getattr(plan, name)}: {plan.reasons[name]}")
        for name in ("dimension", "bodies", "surface", "motion", "friction")
    ]
    rows += [("special", f"{name}: {plan.reasons[name]}") for name in plan.special]
    methods = ("method", "normal", "tangential", "coupling", "formulation")
    rows += [("", ""), *((name, f"{getattr(plan, name)}: {plan.reasons[name]}") for name in methods)]
    if plan.sizes is not None:
        rows += [("", ""), *_sizes(plan.sizes)]
    for i, cost in enumerate(plan.costs):
        time = "seconds not known" if cost.seconds is None else f"about {cost.seconds:.2g} s"
        rows.append(("" if i else "time, one core", f"{cost.method} ({_solvers(cost)}): {time}, {_bytes(cost.bytes)}"))
    return rows


def _solvers(cost: Cost) -> str:
    return cost.normal if cost.tangential == "none" else f"{cost.normal}, {cost.tangential}"


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
    there = memory.available()
    if sizes.peak > there:
        rows.append(("", f"{'does' if sizes.exact else 'may'} not fit: {_bytes(there)} are available"))
    if not sizes.exact:
        rows.append(("", "upper bounds: the contact is not known until it is solved for"))
    return rows


def _bytes(size: float) -> str:
    """Bytes in a unit that suits."""
    power = next((power for power in range(3) if size < 1000 * 1024**power), 3)
    return f"{size / 1024**power:.3g} {('B', 'KiB', 'MiB', 'GiB')[power]}"
