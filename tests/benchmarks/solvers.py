"""Solvers side by side on the package's set of contact problems: `varcontact benchmark`, kept.

All runs are kept in results/solvers.csv, from which a later run continues: the quick set is part of
the whole. Tables are made of all runs that are kept, and are kept after a quick run, too.
"""

from collections.abc import Callable
from functools import partial
from itertools import product

import numpy as np
import pandas as pd

import varcontact as vc
from tests.benchmarks.table import RESULTS, Table, keep
from varcontact.benchmark.solvers import DEFAULT_SOLVERS

STORE = RESULTS / "solvers.csv"
TOLS = (1e-3, 1e-6, 1e-9)
GROUPS = ("pressures", "shifts", "rolling", "line rolling")
MAIN_SOLVERS = DEFAULT_SOLVERS[:3]
STRIDE = 8
"""Problems that follow each other in size are so many places apart in a run."""
Problems = dict[str, vc.BenchmarkProblem]
FAMILIES = {
    "active sets": MAIN_SOLVERS[:1],
    "`newton`": ("newton",),
    "`splitting`": ("splitting",),
    "best program": DEFAULT_SOLVERS[3:],
}
"""Columns of the table by size, and the solvers of each."""


def compared(quick: bool) -> vc.SolverComparison:
    """The comparison on the quick or on the whole set, with all problems of the store that every
    solver was tried on.
    """
    chosen = balanced(vc.benchmark_problems(quick=quick))
    # the main solvers first: a run that ends early has them on all problems
    for solvers in (MAIN_SOLVERS, DEFAULT_SOLVERS):
        progress = partial(print, flush=True)
        vc.benchmark_solvers(solvers, chosen, tols=TOLS, store=STORE, progress=progress)
    tried = pd.read_csv(STORE, keep_default_na=False).groupby("problem")["solver"].nunique()
    complete = set(tried.index[tried == len(DEFAULT_SOLVERS)])
    finished = {name: each for name, each in vc.benchmark_problems().items() if name in complete}
    return vc.benchmark_solvers(DEFAULT_SOLVERS, finished, tols=TOLS, store=STORE)


def balanced(problems: Problems) -> Problems:
    """The problems in an order whose first ones are of all sizes."""
    cells = {
        name: each.scene.grid.nx * (each.scene.grid.ny or 1) for name, each in problems.items()
    }
    by_size = sorted(cells, key=cells.__getitem__)
    order = [name for offset in range(STRIDE) for name in by_size[offset::STRIDE]]
    return {name: problems[name] for name in order}


def kept(name: str, table: Callable[[vc.SolverComparison], Table], quick: bool) -> Table:
    """A table of all runs; of a quick run it is kept here."""
    comparison = compared(quick)
    made = table(comparison)
    made.measured["problems"] = comparison.runs["problem"].nunique()
    made.measured["machines"] = sorted(set(comparison.runs["machine"]))
    if quick:
        keep("solvers", name, made)
    return made


def code(name: str) -> str:
    """A name of a solver in a table, whose columns a bar would divide."""
    escaped = name.replace("|", r"\|")
    return f"`{escaped}`"


def means(group: str, comparison: vc.SolverComparison) -> Table:
    """Shifted geometric means of processor seconds, and problems solved, by tolerance."""
    summary = comparison.summary()
    part = summary[summary["group"] == group].set_index(["solver", "tol"])
    order = part["mean"].xs(1e-6, level="tol").sort_values().index
    rows = []
    for solver in order:
        row: list[object] = [code(solver)]
        for tol in TOLS:
            cell = part.loc[(solver, tol)]
            row += [float(cell["mean"]), f"{cell['solved']:.0f} of {cell['problems']:.0f}"]
        rows.append(row)
    head = ["solver"]
    for tol in TOLS:
        head += [f"s, to {tol:g}", "solved"]
    return Table(head, ["", *[".2g", ""] * 3], rows)


def main(quick: bool) -> Table:
    """Means of active sets, Newton's method and splitting by group, on all problems."""
    problems = vc.benchmark_problems(quick=quick)
    comparison = vc.benchmark_solvers(MAIN_SOLVERS, problems, tols=TOLS, store=STORE)
    summary = comparison.summary().set_index(["group", "solver", "tol"])
    rows = []
    for group, solver in product(GROUPS, MAIN_SOLVERS):
        row: list[object] = [group, code(solver)]
        for tol in TOLS:
            cell = summary.loc[(group, solver, tol)]
            row += [float(cell["mean"]), f"{cell['solved']:.0f} of {cell['problems']:.0f}"]
        rows.append(row)
    head = ["problems", "solver"]
    for tol in TOLS:
        head += [f"s, to {tol:g}", "solved"]
    return Table(head, ["", "", *[".2g", ""] * 3], rows)


def profiles(comparison: vc.SolverComparison) -> Table:
    """Fractions of the problems that are solved to 1e-6 within 1, 2, 10 and 100 times the least
    time.
    """
    rows = []
    for group in GROUPS[:3]:
        profile = comparison.profile(group, 1e-6, factors=(1.0, 2.0, 10.0, 100.0))
        order = profile.mean().sort_values(ascending=False).index
        rows += [[group, code(name), *map(float, profile[name])] for name in order]
    head = ["problems", "solver", "fastest", "within 2 times", "10 times", "100 times"]
    return Table(head, ["", "", *[".2f"] * 4], rows)


def failures(comparison: vc.SolverComparison) -> Table:
    """Outcomes by solver, all tolerances."""
    counts = comparison.failures()
    rows = [[code(str(name)), *map(int, row)] for name, row in counts.iterrows()]
    return Table(["solver", *counts.columns], [""] * (1 + counts.shape[1]), rows)


def sizes(comparison: vc.SolverComparison) -> Table:
    """Median seconds of active sets, Newton's method, splitting and the best program, by size and
    tolerance.
    """
    rows = []
    for tol in TOLS:
        for row in comparison.sizes(tol).to_dict("records"):
            best = [_least(row, names) for names in FAMILIES.values()]
            rows.append([row["group"], row["size"], f"{tol:g}", *best])
    rows = [row for row in rows if row[0] in GROUPS]
    rows.sort(key=lambda row: GROUPS.index(row[0]))
    head = ["problems", "elements", "to", *FAMILIES]
    return Table(head, ["", "", "", *[".2g"] * 4], rows)


def _least(row: dict[str, float], solvers: tuple[str, ...]) -> float | str:
    """The least seconds of some solvers; a dash where none solves half of the problems."""
    least = np.nanmin([row.get(name, np.inf) for name in solvers], initial=np.inf)
    if np.isfinite(least):
        return float(least)
    return "-"


TABLES = {
    "main": main,
    "pressures": partial(kept, "pressures", partial(means, "pressures")),
    "shifts": partial(kept, "shifts", partial(means, "shifts")),
    "rolling": partial(kept, "rolling", partial(means, "rolling")),
    "sizes": partial(kept, "sizes", sizes),
    "profiles": partial(kept, "profiles", profiles),
    "failures": partial(kept, "failures", failures),
}
for name, function in {"sizes": sizes, "profiles": profiles, "failures": failures}.items():
    TABLES[name].__doc__ = function.__doc__
for group in GROUPS[:3]:
    TABLES[group].__doc__ = means.__doc__
