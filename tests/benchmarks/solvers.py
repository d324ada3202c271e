"""Solvers side by side on the package's set of contact problems: `varcontact benchmark`, kept.

All runs are kept in results/solvers.csv, from which a later run continues: the quick set is part of
the whole. Tables are made of all runs that are kept, and kept after a quick run, too.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

import varcontact as vc
from tests.benchmarks.table import RESULTS, Table, keep
from varcontact.benchmark.problem_set import QUICK_SET
from varcontact.benchmark.solvers import DEFAULT_SOLVERS

STORE = RESULTS / "solvers.csv"
TOLS = (1e-3, 1e-6, 1e-9)


def compared(quick: bool) -> vc.SolverComparison:
    """The comparison on the quick or on the whole set, with what the store has of the rest."""
    problems = vc.benchmark_problems()
    missing = problems
    if quick:
        missing = vc.benchmark_problems(quick=True)
    vc.benchmark_solvers(
        DEFAULT_SOLVERS, missing, tols=TOLS, store=STORE, progress=partial(print, flush=True)
    )
    import pandas as pd

    kept = set(pd.read_csv(STORE, keep_default_na=False)["problem"])
    finished = {name: each for name, each in problems.items() if name in kept}
    return vc.benchmark_solvers(DEFAULT_SOLVERS, finished, tols=TOLS, store=STORE)


def kept(name: str, table: Callable[[vc.SolverComparison], Table], quick: bool) -> Table:
    """A table of all runs; of a quick run it is kept here."""
    comparison = compared(quick)
    made = table(comparison)
    problems = comparison.runs["problem"].nunique()
    machines = sorted(set(comparison.runs["machine"]))
    made.measured.update(
        problems=problems,
        machines=machines,
        quick=set(QUICK_SET) >= set(comparison.runs["problem"]),
    )
    if quick:
        keep("solvers", name, made)
    return made


def means(group: str, comparison: vc.SolverComparison) -> Table:
    """Shifted geometric means of processor seconds, and problems solved, by tolerance."""
    summary = comparison.summary()
    part = summary[summary["group"] == group]
    rows = []
    for solver in part.sort_values(["tol", "mean"])["solver"].unique():
        row: list[object] = [f"`{solver}`"]
        for tol in TOLS:
            cell = part[(part["solver"] == solver) & (part["tol"] == tol)].iloc[0]
            row += [float(cell["mean"]), f"{cell['solved']} of {cell['problems']}"]
        rows.append(row)
    head = ["solver"]
    for tol in TOLS:
        head += [f"s, to {tol:g}", "solved"]
    return Table(head, ["", *[".2g", ""] * 3], rows)


def profiles(comparison: vc.SolverComparison) -> Table:
    """Fractions of the problems that are solved to 1e-6 within 1, 2, 10 and 100 times the least
    time.
    """
    rows = []
    for group in ("pressures", "shifts", "rolling"):
        profile = comparison.profile(group, 1e-6, factors=(1.0, 2.0, 10.0, 100.0))
        order = profile.mean().sort_values(ascending=False).index
        rows += [[group, f"`{name}`", *map(float, profile[name])] for name in order]
    head = ["problems", "solver", "fastest", "within 2 times", "10 times", "100 times"]
    return Table(head, ["", "", *[".2f"] * 4], rows)


def failures(comparison: vc.SolverComparison) -> Table:
    """Outcomes by solver, all tolerances."""
    counts = comparison.failures()
    rows = [[f"`{name}`", *map(int, row)] for name, row in counts.iterrows()]
    return Table(["solver", *counts.columns], [""] * (1 + counts.shape[1]), rows)


def sizes(comparison: vc.SolverComparison) -> Table:
    """Median seconds of the best of four families of solvers, by size and tolerance."""
    families = {
        "active sets": ["norm|tang-safeguarded"],
        "`newton`": ["newton"],
        "`splitting`": ["splitting"],
        "best program": list(DEFAULT_SOLVERS[3:]),
    }
    rows = []
    for tol in TOLS:
        for row in comparison.sizes(tol).to_dict("records"):
            best = []
            for names in families.values():
                value = min(
                    (row[name] for name in names if row.get(name, np.nan) > 0), default=None
                )
                best.append(value if value is not None and np.isfinite(value) else None)
            rows.append([row["group"], row["size"], f"{tol:g}", *best])
    order = {"pressures": 0, "shifts": 1, "rolling": 2, "line rolling": 3}
    rows = sorted((row for row in rows if row[0] in order), key=lambda row: order[row[0]])
    return Table(["problems", "elements", "to", *families], ["", "", "", *[".2g"] * 4], rows)


TABLES = {
    "pressures": partial(kept, "pressures", partial(means, "pressures")),
    "shifts": partial(kept, "shifts", partial(means, "shifts")),
    "rolling": partial(kept, "rolling", partial(means, "rolling")),
    "profiles": partial(kept, "profiles", profiles),
    "failures": partial(kept, "failures", failures),
    "sizes": partial(kept, "sizes", sizes),
}
