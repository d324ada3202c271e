"""The comparison of solvers: its table, shifted geometric means, profiles and failures."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

import varcontact
from varcontact import checks
from varcontact.benchmark.problem_set import (
    SET_VERSION,
    BenchmarkProblem,
    benchmark_problems,
    check_problems,
)
from varcontact.benchmark.solvers import DEFAULT_SOLVERS, entry_named
from varcontact.benchmark.trials import GROUPS, OUTCOMES, Process, Trial, trials
from varcontact.errors import Interrupted, SceneError, SolverUnavailable
from varcontact.html import Reported
from varcontact.study.csv_table import Table, cell, columns_of_text, of_another, plain_rows
from varcontact.system.process import imported
from varcontact.system.progress import Progress

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

COLUMNS = (
    "problem", "family", "group", "elements", "solver", "tol", "outcome", "reason", "residual",
    "relative_gap", "seconds", "iterations", "limit", "machine", "version", "set_version"
)  # fmt: skip
WORDS = (
    "problem", "family", "group", "solver", "outcome", "reason", "machine", "version"
)  # fmt: skip
TOLS = (1e-3, 1e-6, 1e-9)
SHIFT = 0.01
"""Shift of the geometric means [s]."""
FACTORS = (1.0, 2.0, 5.0, 10.0, 100.0)
"""Multiples of the least time at which performance profiles are tabulated."""
SIZES = (0, 150, 500, 1000, 3000)
"""Limits of the size classes [elements]."""
NOT_APPLICABLE = "does not apply"


@checks.named_options()
def benchmark_solvers(
    solvers: Sequence[str] | None = None,
    problems: Mapping[str, BenchmarkProblem] | None = None,
    *,
    tols: ArrayLike = TOLS,
    limit: float = 10.0,
    store: str | Path | None = None,
    progress: Progress = None,
) -> SolverComparison:
    """Compare solvers on the set of contact problems: each from its data, on one thread, judged by
    our residual and gap.

    Parameters
    ----------
    solvers : sequence of str, optional
        Each ``[normal|]tangential[/formulation]``, as "newton", "norm|tang", "clarabel/gap",
        "cvxpy:SCS", the name of an own or entry-point solver, or ``module:function``, a function
        as for `register_solver`. Those of the package that are installed, if not given.
    problems : dict of str to BenchmarkProblem, optional
        Some of `benchmark_problems()`; all of them, if not given.
    tols : array_like
        Tolerances. An answer is "solved" where residual and relative gap are within.
    limit : float
        Processor seconds of a solver on a problem at a tolerance; its process is then ended, and
        tighter tolerances are not tried.
    store : str or Path, optional
        A CSV file, written after each solver. What it holds is not measured again.
    progress : callable or true, optional
        Called with problem and solver.

    Returns
    -------
    SolverComparison

    Raises
    ------
    SceneError
        For what is no solver, or a store of another study, before any work.
    SolverUnavailable
        For a solver that is named and not installed.
    Interrupted
        By Ctrl-C; its `partial` is the comparison as far as it got.

    Notes
    -----
    Seconds are processor seconds of the call, least of three where it is short, with all matrices,
    factors and transforms made anew.

    Examples
    --------
    >>> import varcontact as vc
    >>> name = "shift, 6 across"
    >>> chosen = {name: vc.benchmark_problems()[name]}
    >>> result = vc.benchmark_solvers(["splitting", "newton"], chosen, tols=[1e-6])
    >>> result.runs["outcome"].tolist()
    ['solved', 'solved']
    """
    chosen = _names(solvers)
    if problems is None:
        problems = benchmark_problems()
    check_problems(problems)
    tolerances = np.atleast_1d(checks.positives("tols", tols)).tolist()
    limit = checks.positive("limit", limit)
    report = checks.progress(progress)
    made = partial(SolverComparison.of, problems=problems, solvers=chosen, tols=tolerances)
    imported("pandas")  # imported now: after Ctrl-C the import would have to be waited for
    with Table.opened(store, COLUMNS, WORDS, "a table of an earlier comparison") as table:
        _check_table(table, limit)
        measured = {_key(row) for row in table.rows}
        try:
            with Process(limit) as process:
                for trial in trials(list(problems.values()), chosen, tolerances):
                    keys = {(trial.problem.name, trial.solver, tol) for tol in trial.tols}
                    if not keys <= measured:
                        report(f"{trial.problem.name}: {trial.solver}")
                        others = [row for row in table.rows if _key(row) not in keys]
                        table.write([*others, *_rows(process, trial)])
        except KeyboardInterrupt:
            raise Interrupted(made(table.rows)) from None
        return made(table.rows)


def _check_table(table: Table, limit: float) -> None:
    """Refuse a table of other problems, or with another time limit."""
    for row in table.rows:
        if row["set_version"] != SET_VERSION:
            raise of_another(table.path, "was measured on another version of the problems")
        if row["limit"] != limit:
            raise of_another(table.path, f"was measured with a limit of {row['limit']:g} s")


def _key(row: Mapping[str, Any]) -> tuple[str, str, float]:
    return row["problem"], row["solver"], row["tol"]


def _names(solvers: Any) -> list[str]:
    """Names of the solvers to compare, each once."""
    if solvers is None:
        return _installed()
    if isinstance(solvers, str) or not isinstance(solvers, Sequence) or not solvers:
        raise SceneError("solvers", solvers, "a list of names")
    return list(dict.fromkeys(entry_named(each).name for each in solvers))


def _installed() -> list[str]:
    """The default solvers that are installed."""
    found = []
    for name in DEFAULT_SOLVERS:
        try:
            found.append(entry_named(name).name)
        except SolverUnavailable:
            continue
    return found


def _rows(process: Process, trial: Trial) -> list[dict[str, Any]]:
    """The rows of a trial."""
    posed = process.begin(trial)
    common = {
        "problem": trial.problem.name,
        "family": trial.problem.family,
        "group": posed.group,
        "elements": posed.elements,
        "solver": trial.solver,
        "limit": process.limit,
        "machine": _machine(),
        "version": varcontact.__version__,
        "set_version": SET_VERSION,
    }
    rows = []
    if posed.applies:
        for tol, verdict in process.verdicts(trial):
            rows.append({**common, "tol": tol, **asdict(verdict)})
    else:
        absent = {"outcome": NOT_APPLICABLE, "reason": ""}
        rows = [{**common, "tol": tol, **absent} for tol in trial.tols]
    return rows


def _machine() -> str:
    """Processor and system."""
    model = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        for line in information.read_text().splitlines():
            if line.startswith("model name"):
                model = line.partition(":")[2].strip()
                break
    return f"{model}, {platform.system()}, Python {platform.python_version()}"


@dataclass(frozen=True, eq=False)
class SolverComparison(Reported):
    """Solvers side by side on a set of problems.

    Attributes
    ----------
    runs : pandas.DataFrame
        A row per problem, solver and tolerance: group of the problem, elements; outcome ("solved";
        "inaccurate": not by our measures; "gave up": it says so itself; "out of time", "too
        large" for the memory, "failed", "crashed") and reason; residual of the natural map,
        relative gap, processor seconds, iterations; limit, machine, version.
    """

    runs: pd.DataFrame

    @classmethod
    def of(
        cls,
        rows: list[dict[str, Any]],
        problems: Mapping[str, BenchmarkProblem],
        solvers: Sequence[str],
        tols: Sequence[float],
    ) -> SolverComparison:
        """Comparison from the rows of a table that belong to these problems, solvers and
        tolerances.
        """
        import pandas as pd

        chosen = [
            row
            for row in rows
            if row["problem"] in problems and row["solver"] in solvers and row["tol"] in tols
        ]
        return cls(pd.DataFrame(chosen, columns=list(COLUMNS)))

    @property
    def tried(self) -> pd.DataFrame:
        """The rows in which the solver applies to the problem, with `cost`: seconds to the
        tolerance, infinite where it is not reached.

        A run with a tighter tolerance counts, too: solvers understand tolerances in
        their own ways.
        """
        rows = self.runs[self.runs["outcome"] != NOT_APPLICABLE]
        names = ["problem", "solver"]
        measured = ["residual", "relative_gap", "seconds"]
        runs = rows[[*names, "tol", *measured]].rename(columns={"tol": "tol_of_run"})
        pairs = rows[[*names, "tol"]].merge(runs, on=names)
        reached = pairs["tol_of_run"] <= pairs["tol"]
        for name in measured[:2]:
            reached &= pairs[name].astype(float) <= pairs["tol"]
        costs = pairs[reached].groupby([*names, "tol"])["seconds"].min().rename("cost")
        rows = rows.join(costs, on=[*names, "tol"])
        rows["cost"] = rows["cost"].astype(float).fillna(np.inf)
        return rows.assign(solved=np.isfinite(rows["cost"]))

    def summary(self) -> pd.DataFrame:
        """Problems, those solved, and shifted geometric means of the seconds by group, tolerance
        and solver; `ratio` is the mean divided by the least one. Failures count as the limit.
        """
        import pandas as pd

        rows = []
        for (group, tol, solver), part in self.tried.groupby(["group", "tol", "solver"]):
            seconds = np.minimum(part["cost"], part["limit"])
            mean = float(np.exp(np.log(seconds + SHIFT).mean()) - SHIFT)
            rows.append(
                {
                    "group": group,
                    "tol": tol,
                    "solver": solver,
                    "problems": len(part),
                    "solved": int(part["solved"].sum()),
                    "mean": mean,
                }
            )
        names = ["group", "tol", "solver", "problems", "solved", "mean"]
        table = pd.DataFrame(rows, columns=names)
        table["ratio"] = table["mean"] / table.groupby(["group", "tol"])["mean"].transform("min")
        table["place"] = table["group"].map(GROUPS.index)
        table = table.sort_values(["place", "tol", "mean"], ascending=[True, False, True])
        return table.drop(columns="place").reset_index(drop=True)

    @checks.named_options()
    def profile(self, group: str, tol: float, factors: Sequence[float] = FACTORS) -> pd.DataFrame:
        """Fraction of the problems of a group that each solver solves within so many times the
        least time of all (Dolan and More, Math. Program. 91 (2002) 201-213).

        Parameters
        ----------
        group : str
            One of `runs`.
        tol : float
        factors : sequence of float

        Returns
        -------
        pandas.DataFrame
            A row per factor, a column per solver.
        """
        import pandas as pd

        ratios = self._ratios(group, tol)
        limits = checks.positives("factors", list(factors))
        fractions = {name: [(each <= f).mean() for f in limits] for name, each in ratios.items()}
        return pd.DataFrame(fractions, index=pd.Index(limits, name="factor"))

    def _ratios(self, group: str, tol: float) -> pd.DataFrame:
        """Seconds divided by the least time of all solvers, by problem and solver; infinite where
        not solved.
        """
        tried = self.tried
        checks.choice("group", group, list(dict.fromkeys(tried["group"])))
        part = tried[(tried["group"] == group) & (tried["tol"] == tol)]
        cost = part.pivot(index="problem", columns="solver", values="cost").fillna(np.inf)
        least = cost.min(axis=1)
        return cost[np.isfinite(least)].div(least[np.isfinite(least)], axis=0)

    def failures(self) -> pd.DataFrame:
        """Number of outcomes of each kind, by solver."""
        import pandas as pd

        tried = self.tried
        counts = pd.crosstab(tried["solver"], tried["outcome"])
        return counts.reindex(columns=list(OUTCOMES), fill_value=0)

    def sizes(self, tol: float) -> pd.DataFrame:
        """Median seconds by group, class of sizes and solver; infinite where half of the problems
        are not solved to `tol`.
        """
        import pandas as pd

        tried = self.tried
        part = tried[tried["tol"] == tol]
        labels = [f"{low + 1}-{high}" for low, high in pairwise(SIZES)]
        size = pd.cut(part["elements"], list(SIZES), labels=labels)
        by_class = part.assign(size=size).groupby(["group", "size", "solver"], observed=True)
        return by_class["cost"].median().unstack("solver").reset_index()

    def plot(self, tol: float | None = None) -> Figure:
        """Performance profiles at a tolerance `tol`, the tightest if not given, with a panel for
        each group of problems.
        """
        from varcontact.benchmark.plots import plot_profiles

        if tol is None:
            tol = float(self.runs["tol"].min())
        return plot_profiles(self, tol)

    def to_json(self) -> str:
        """Summary, failures and all runs as one JSON object; null where nothing is known."""
        tables = {
            "summary": plain_rows(self.summary()),
            "failures": plain_rows(self.failures().reset_index()),
            "runs": plain_rows(self.runs),
        }
        return json.dumps(tables, indent=2, allow_nan=False, default=lambda value: value.item())

    def report(self) -> str:
        """Means by group and tolerance, and failures by reason, for people."""
        blocks = []
        for (group, tol), part in self.summary().groupby(["group", "tol"], sort=False):
            title = f"{group}, to {tol:g}: mean seconds, relative to the fastest, problems solved"
            lines = list(_lines(part))
            blocks.append("\n".join([title, *(f"  {line}" for line in lines)]))
        failures = self.failures()
        head = ["solver", *failures.columns]
        counts = [[name, *map(str, row)] for name, row in _items(failures)]
        words = [f"  {line}" for line in columns_of_text([head, *counts], left=1)]
        blocks.append("\n".join(["outcomes, all tolerances", *words]))
        return "\n\n".join(blocks)

    def __repr__(self) -> str:
        problems = self.runs["problem"].nunique()
        return f"SolverComparison({problems} problems, {self.runs['solver'].nunique()} solvers)"


def _lines(part: pd.DataFrame) -> Iterator[str]:
    lines = []
    for row in part.to_dict("records"):
        solved = f"{row['solved']} of {row['problems']}"
        lines.append([row["solver"], cell(row["mean"], ".3g"), cell(row["ratio"], ".2g"), solved])
    yield from columns_of_text(lines, left=1)


def _items(table: pd.DataFrame) -> Iterator[tuple[str, list[Any]]]:
    for name, row in table.iterrows():
        yield str(name), row.tolist()
