"""The result of a study of convergence: its tables, and what is printed of them."""

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
"""What is extrapolated. The norms are roots of the integrals of squares; of a shift vx and vy are
ux and uy."""
STAIRCASE = ("staircase", "staircase_x", "staircase_y", "staircase_xx", "staircase_yy")
COLUMNS = (
    "method", "cells", "offset", "outcome", "reason", *QUANTITIES, "spin", "elements", "residual",
    *BOUNDS, "iterations", "seconds", "memory", *STAIRCASE, "identity"
)  # fmt: skip
"""What the table of solves says of each."""
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
    """

    runs: pd.DataFrame
    grids: pd.DataFrame
    limits: pd.DataFrame

    @classmethod
    def of(
        cls, rows: list[dict[str, Any]], cells: Sequence[int], methods: Sequence[str], offsets: int
    ) -> Convergence:
        """From the rows of a table, of which only those of these grids, methods and offsets are
        taken.
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
            runs, pd.DataFrame(grids), pd.DataFrame([row for row in limits if row is not None])
        )

    @checks.named_options()
    def limit(self, quantity: str, method: str | None = None) -> dict[str, Any]:
        """The row of `limits` of a `quantity` of `QUANTITIES`, as a dict; of the only `method`, or
        the one named.

        SceneError if there is no such row.
        """
        known = [row for row in self.limits.to_dict("records") if row["quantity"] == quantity]
        rows: list[dict[str, Any]] = [row for row in known if method in (None, row["method"])]
        if len(rows) != 1:
            choices = f"{', '.join(QUANTITIES)}, with a method of {', '.join(dict.fromkeys(self.runs['method']))}"
            message = f"quantity {quantity!r}, method {method!r} is not one limit; choose one of {choices}"
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
        cells, methods = (list(dict.fromkeys(self.runs[name])) for name in ("cells", "method"))
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
    known = answers[answers[quantity].notna()]
    if known.empty:
        return None
    force, creepage = known["normal_force"], known[["vx", "vy"]].abs().max(axis=1)
    sizes = {
        "Fx": force,
        "Fy": force,
        "Mz": force * np.sqrt(known["contact_area"]),
        "vx": creepage,
        "vy": creepage,
    }
    # where symmetry makes the quantity zero
    scale = float(sizes[quantity].max()) if quantity in sizes else 0.0
    staircase = known[list(STAIRCASE)].dropna(axis=1).to_numpy(dtype=float)
    h, values = 1 / known["cells"].to_numpy(dtype=float), known[quantity].to_numpy(dtype=float)
    limit = extrapolate(h, values, staircase, scale)
    last = known[known["cells"] == known["cells"].max()]
    finest = float(last[quantity].mean())
    bound = float(last[f"{quantity}_bound"].max()) if f"{quantity}_bound" in BOUNDS else np.nan
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


def _block(study: Convergence, name: str) -> str:
    """Means by grid, limits, and what went wrong, for one method."""
    grids = study.grids[study.grids["method"] == name].to_dict("records")
    limits = [row for row in study.limits.to_dict("records") if row["method"] == name]
    same = [row["quantity"] for row in limits if row["reason"] == SAME]
    shown = [row for row in limits if row["reason"] != SAME]
    head = ["cells", *(row["quantity"] for row in shown), "residual", "seconds", "MiB"]
    body = [
        [
            f"{row['cells']}"
            + (
                "" if row["answers"] == row["solves"] else f" ({row['answers']} of {row['solves']})"
            ),
            *(cell(row[each["quantity"]], ".6g") for each in shown),
            cell(row["residual"], ".0e"),
            cell(row["seconds"], ".3f"),
            cell(row["memory"] / 2**20, ".1f"),
        ]
        for row in grids
    ]
    lines = [name, *columns_of_text([head, *body], left=1)]
    reasons: dict[str, list[str]] = {}
    if shown:
        head = [
            "",
            "extrapolated",
            "error",
            "order",
            "finest grid",
            "its error",
            "noise",
            "solver bound",
        ]
        forms = {"finest": ".7g", "finest_error": ".2g", "noise": ".2g", "solver_bound": ".2g"}
        body = []
        for row in shown:
            order = "" if row["reason"] == HIDDEN else cell(row["order"], ".2f")
            if order and row["order_low"] == row["order_low"]:
                order += f" ({row['order_low']:.1f} to {row['order_high']:.1f})"
            known = [row["quantity"], cell(row["value"], ".7g"), cell(row["error"], ".2g"), order]
            body.append([*known, *(cell(row[name], form) for name, form in forms.items())])
        lines += ["", *columns_of_text([head, *body], left=1)]
    if same:
        lines.append(f"the same on all grids: {', '.join(same)}")
    for row in shown:
        reasons.setdefault(row["reason"], []).append(row["quantity"])
    lines += [f"{', '.join(names)}: {reason}" for reason, names in reasons.items() if reason]
    runs = study.runs[(study.runs["method"] == name) & (study.runs["reason"] != "")]
    lines += [
        f"{row['cells']} cells, offset {row['offset']}: {row['reason']}"
        for row in runs.to_dict("records")
    ]
    return "\n".join(lines)
