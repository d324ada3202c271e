"""Result of a convergence study: its tables and its report."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.html import Reported
from varcontact.study.csv_table import cell, columns_of_text, plain_rows
from varcontact.study.extrapolate import HIDDEN, SAME, extrapolate
from varcontact.study.methods import BOUNDS

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

QUANTITIES = (
    "normal_force", "Fx", "Fy", "Mz", "vx", "vy", "approach", "contact_area", "stick_area",
    "slip_area", "pressure_norm", "traction_norm"
)  # fmt: skip
"""Quantities that are extrapolated. The norms are roots of the integrals of squares; in a shift vx
and vy are ux and uy."""
SHIFTS = {"vx": "ux", "vy": "uy"}
"""Names of shifts, by the names of creepages."""
STAIRCASE = ("staircase", "staircase_x", "staircase_y", "staircase_xx", "staircase_yy")
COLUMNS = (
    "method", "cells", "offset", "outcome", "reason", *QUANTITIES, "spin", "elements", "residual",
    *BOUNDS, "iterations", "seconds", "memory", *STAIRCASE, "identity"
)  # fmt: skip
"""Columns of the table of solves."""
WORDS = ("method", "outcome", "reason", "identity")


@dataclass(frozen=True, eq=False)
class Convergence(Reported):
    """A study of convergence.

    Attributes
    ----------
    runs : pandas.DataFrame
        A row per solve: method, cells across the contact, offset, outcome and
        reason as in `compare`; the quantities; the certificate's residual and
        bounds; iterations; seconds; memory, the largest of arrays during the
        solve [bytes], without what solvers written in other languages take for
        themselves (measured at the first offset, which takes longer by that);
        staircase, what the elements miss of Hertz's ellipse, with its moments.
    grids : pandas.DataFrame
        A row per method and grid: numbers of solves and of answers, the
        quantities' means over the offsets and (``Fx_spread``) standard
        deviations, the largest residual, bounds and memory, the mean of seconds
        (of the solves without measured memory, if there are any).
    limits : pandas.DataFrame
        A row per method and quantity: extrapolated `value` with the half width
        `error` of its 95 % interval, `order` with its interval `order_low` to
        `order_high`, `finest` (the mean on the finest grid), `finest_error`
        (its distance from the value, and the error on top), `noise`, the spread
        of single solves there; `solver_bound`, the certificate's bound on how
        far that is from the exact solution of the same discrete problem;
        `reason` where something is missing.
    shift : bool
        True if the scene is a shift, whose ux and uy are in the columns vx and vy.
    """

    runs: pd.DataFrame
    grids: pd.DataFrame
    limits: pd.DataFrame
    shift: bool = False

    @classmethod
    def of(
        cls,
        rows: list[dict[str, Any]],
        cells: Sequence[int],
        methods: Sequence[str],
        offsets: int,
        shift: bool = False,
    ) -> Convergence:
        """Convergence from the rows of a table that belong to these grids, methods and offsets; of
        a scene that rolls, or of a `shift`.
        """
        import pandas as pd

        chosen = [
            row
            for row in rows
            if row["cells"] in cells and row["method"] in methods and row["offset"] < offsets
        ]
        chosen.sort(key=lambda row: (methods.index(row["method"]), row["cells"], row["offset"]))
        runs = pd.DataFrame(chosen, columns=list(COLUMNS))
        answers = runs[runs["outcome"].isin(["solved", "approximate"])]
        grids = [
            _grid(name, n, part, answers)
            for (name, n), part in runs.groupby(["method", "cells"], sort=False)
        ]
        limits = [
            _limit(name, quantity, answers[answers["method"] == name])
            for name in methods
            for quantity in QUANTITIES
        ]
        return cls(
            runs,
            pd.DataFrame(grids),
            pd.DataFrame([row for row in limits if row is not None]),
            shift,
        )

    @checks.named_options()
    def limit(self, quantity: str, method: str | None = None) -> dict[str, Any]:
        """The row of `limits` of a `quantity` of `QUANTITIES`, as a dict; of the only `method`, or
        the one named. In a shift "ux" and "uy" have the rows of vx and vy.

        SceneError if there is no such row.
        """
        row_of = {name: name for name in dict.fromkeys(self.limits["quantity"])}
        if self.shift:
            row_of = {SHIFTS.get(name, name): name for name in row_of} | row_of
        rows: list[dict[str, Any]] = [
            row
            for row in self.limits.to_dict("records")
            if row["quantity"] == row_of.get(quantity) and method in (None, row["method"])
        ]
        if len(rows) != 1:
            methods = dict.fromkeys(self.runs["method"])
            message = (
                f"quantity {quantity!r}, method {method!r} is not one limit; choose one of "
                f"{', '.join(row_of)}, with a method of {', '.join(methods)}"
            )
            raise SceneError("quantity, method", (quantity, method), message=message)
        return rows[0]

    @checks.named_options()
    def plot(self, quantities: Sequence[str] | None = None) -> Figure:
        """Picture of the errors over the number of cells, a panel for each quantity that changes
        with the grid.

        `quantities` are some of them, such as ``["Fx", "Mz"]``; SceneError for one that the study
        has not.
        """
        from varcontact.plotting.studies import plot_convergence

        return plot_convergence(self, quantities)

    def to_json(self) -> str:
        """The tables of grids and of limits as one JSON object; null where nothing is known."""
        tables = {"grids": plain_rows(self.grids), "limits": plain_rows(self.limits)}
        failed = self.runs[~self.runs["outcome"].isin(["solved", "approximate"])]
        tables["failed"] = plain_rows(failed[["method", "cells", "offset", "outcome", "reason"]])
        return json.dumps(tables, indent=2, allow_nan=False)

    def report(self) -> str:
        """The tables in words and figures, for people: a block for each method."""
        return "\n\n".join(_block(self, name) for name in dict.fromkeys(self.runs["method"]))

    def __repr__(self) -> str:
        cells = list(dict.fromkeys(self.runs["cells"]))
        methods = list(dict.fromkeys(self.runs["method"]))
        return f"Convergence(cells={cells}, methods={methods})"


def _grid(name: str, cells: int, runs: pd.DataFrame, answers: pd.DataFrame) -> dict[str, Any]:
    part = answers[(answers["method"] == name) & (answers["cells"] == cells)]
    plain = part[part["memory"].isna()]
    return {
        "method": name,
        "cells": cells,
        "solves": len(runs),
        "answers": len(part),
        **{quantity: part[quantity].mean() for quantity in QUANTITIES},
        **{f"{quantity}_spread": part[quantity].std() for quantity in QUANTITIES},
        **{column: part[column].max() for column in ("residual", *BOUNDS)},
        "seconds": (plain if len(plain) else part)["seconds"].mean(),
        "memory": part["memory"].max(),
    }


def _limit(name: str, quantity: str, answers: pd.DataFrame) -> dict[str, Any] | None:
    """The limit of one quantity by one method; None where it has no values (the approach of some
    line contacts).
    """
    rows = answers[answers[quantity].notna()]
    if rows.empty:
        return None
    staircase = rows[list(STAIRCASE)].dropna(axis=1).to_numpy(dtype=float)
    h = 1 / rows["cells"].to_numpy(dtype=float)
    values = rows[quantity].to_numpy(dtype=float)
    limit = extrapolate(h, values, staircase, _scale(rows, quantity))
    last = rows[rows["cells"] == rows["cells"].max()]
    finest = float(last[quantity].mean())
    bound = np.nan
    if f"{quantity}_bound" in BOUNDS:
        bound = float(last[f"{quantity}_bound"].max())
    row = {
        "method": name,
        "quantity": quantity,
        **vars(limit),
        "finest": finest,
        "finest_error": abs(finest - limit.value) + limit.error,
        "noise": float(last[quantity].std()),
        "solver_bound": bound,
    }
    row["reason"] = row.pop("reason")  # the last column
    return row


def _scale(rows: pd.DataFrame, quantity: str) -> float:
    """Size of a quantity where symmetry makes it zero; 0 for those that are never zero."""
    if quantity in ("Fx", "Fy"):
        return float(rows["normal_force"].max())
    if quantity == "Mz":
        return float((rows["normal_force"] * np.sqrt(rows["contact_area"])).max())
    if quantity in ("vx", "vy"):
        return float(rows[["vx", "vy"]].abs().max(axis=1).max())
    return 0.0


def _block(study: Convergence, name: str) -> str:
    """Means by grid, limits, and what went wrong, for one method."""
    grids = study.grids[study.grids["method"] == name].to_dict("records")
    limits = [row for row in study.limits.to_dict("records") if row["method"] == name]
    same = [row["quantity"] for row in limits if row["reason"] == SAME]
    changing = [row for row in limits if row["reason"] != SAME]
    lines = [name, *_means_as_text(grids, [row["quantity"] for row in changing])]
    if changing:
        lines += ["", *_limits_as_text(changing)]
    if same:
        lines.append(f"the same on all grids: {', '.join(same)}")
    quantities: dict[str, list[str]] = {}
    for row in changing:
        quantities.setdefault(row["reason"], []).append(row["quantity"])
    lines += [f"{', '.join(names)}: {reason}" for reason, names in quantities.items() if reason]
    runs = study.runs[(study.runs["method"] == name) & (study.runs["reason"] != "")]
    lines += [
        f"{row['cells']} cells, offset {row['offset']}: {row['reason']}"
        for row in runs.to_dict("records")
    ]
    return "\n".join(lines)


def _means_as_text(grids: list[dict[str, Any]], quantities: list[str]) -> list[str]:
    lines = [["cells", *quantities, "residual", "seconds", "MiB"]]
    for row in grids:
        cells = f"{row['cells']}"
        if row["answers"] != row["solves"]:
            cells += f" ({row['answers']} of {row['solves']})"
        means = [cell(row[quantity], ".6g") for quantity in quantities]
        residual = cell(row["residual"], ".0e")
        seconds = cell(row["seconds"], ".3f")
        lines.append([cells, *means, residual, seconds, cell(row["memory"] / 2**20, ".1f")])
    return columns_of_text(lines, left=1)


def _limits_as_text(limits: list[dict[str, Any]]) -> list[str]:
    forms = {
        "extrapolated": ("value", ".7g"),
        "error": ("error", ".2g"),
        "order": ("order", ".2f"),
        "finest grid": ("finest", ".7g"),
        "its error": ("finest_error", ".2g"),
        "noise": ("noise", ".2g"),
        "solver bound": ("solver_bound", ".2g"),
    }
    lines = [["", *forms]]
    for row in limits:
        cells = {heading: cell(row[column], form) for heading, (column, form) in forms.items()}
        if row["reason"] == HIDDEN:
            cells["order"] = ""
        elif cells["order"] and row["order_low"] == row["order_low"]:
            cells["order"] += f" ({row['order_low']:.1f} to {row['order_high']:.1f})"
        lines.append([row["quantity"], *cells.values()])
    return columns_of_text(lines, left=1)
