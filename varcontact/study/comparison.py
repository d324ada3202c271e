"""The table of a comparison, printed and in a notebook."""

from __future__ import annotations

from typing import Any

import pandas as pd

from varcontact.html import html_table
from varcontact.study.csv_table import cell, columns_of_text

SHOWN = {
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
"""Headings of the printed table, with the columns under them and their format."""


class Comparison(pd.DataFrame):  # type: ignore[misc]
    """A data frame with one row per scene and method, see `varcontact.compare`.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30), normal_force=106.7e3,
    ...     friction=0.33, motion=vc.Steady(vx=1e-3), grid=vc.Grid(nx=8, ny=8))
    >>> table = vc.compare(scene, ["tang", "fastsim"])
    >>> len(table[table["outcome"] == "solved"])
    1
    """

    @property
    def _constructor(self) -> Any:
        return Comparison

    def _repr_html_(self) -> str:
        """A table for each scene; pandas' own where columns are missing."""
        if not {"scene", *(name for name, _ in SHOWN.values())} <= set(self.columns):
            frame: str = super()._repr_html_()
            return frame
        blocks = []
        for scene, cells, reasons in _printed(self):
            table = pd.DataFrame(cells, columns=list(SHOWN)).to_html(index=False, border=0)
            blocks += [html_table(scene, []), table, *([html_table("not solved", reasons)] if reasons else [])]
        return "\n".join(blocks)


def summary(table: pd.DataFrame) -> str:
    """A comparison as text: a block for each scene, then what was not solved and why."""
    blocks = []
    for scene, cells, reasons in _printed(table):
        lines = columns_of_text([list(SHOWN), *cells], left=2)
        blocks.append("\n".join([scene, *lines, *(f"  {method}: {reason}" for method, reason in reasons)]))
    return "\n\n".join(blocks)


def _printed(table: pd.DataFrame) -> list[tuple[str, list[list[str]], list[tuple[str, str]]]]:
    """By scene: its name, the cells under the headings, methods without an answer and why."""
    found = []
    for scene, rows in table.groupby("scene", sort=False):
        records = rows.to_dict("records")
        cells = [[cell(row[name], form) for name, form in SHOWN.values()] for row in records]
        found.append((str(scene), cells, [(row["method"], row["reason"]) for row in records if row["reason"]]))
    return found
