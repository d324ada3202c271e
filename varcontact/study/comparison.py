"""The table that a comparison gives."""

from __future__ import annotations

from typing import Any

import pandas as pd

from varcontact.html import html_table
from varcontact.study.tables import SHOWN, cell


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
        """The columns that the printed table has, a table for each scene; any other part as pandas has it."""
        if not {"scene", *(name for name, _ in SHOWN.values())} <= set(self.columns):
            frame: str = super()._repr_html_()
            return frame
        return "\n".join(_scene(str(name), rows) for name, rows in self.groupby("scene", sort=False))


def _scene(name: str, rows: pd.DataFrame) -> str:
    """The rows of a scene, then what was not solved and why."""
    records = rows.to_dict("records")
    frame = pd.DataFrame(
        [[cell(row[key], form) for key, form in SHOWN.values()] for row in records], columns=list(SHOWN)
    )
    reasons = [(row["method"], row["reason"]) for row in records if row["reason"]]
    table: str = frame.to_html(index=False, border=0)
    title = html_table(name, [])
    return "\n".join([title, table, *([html_table("not solved", reasons)] if reasons else [])])
