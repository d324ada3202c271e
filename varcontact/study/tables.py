"""Tables in words and figures, for people."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd


def summary(table: pd.DataFrame) -> str:
    """A comparison in words and figures, for people: a block for each scene, then what was not solved and why.

    Parameters
    ----------
    table : DataFrame
        As `compare` gives it.
    """
    blocks = []
    for scene, rows in table.groupby("scene", sort=False):
        records = rows.to_dict("records")
        lines = [list(SHOWN), *([cell(row[name], form) for name, form in SHOWN.values()] for row in records)]
        text = columns_of_text(lines, left=2)
        reasons = [f"  {row['method']}: {row['reason']}" for row in records if row["reason"]]
        blocks.append("\n".join([str(scene), *text, *reasons]))
    return "\n\n".join(blocks)


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
"""Columns of the printed table: which of the measured ones, and how written."""


def columns_of_text(lines: list[list[str]], left: int) -> list[str]:
    """Lines of cells below each other, the first `left` columns flush left.

    Parameters
    ----------
    lines : list of list of str
        Equally many cells a line.
    left : int
    """
    widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
    return [
        "  ".join(
            cell.ljust(width) if i < left else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in lines
    ]


def cell(value: Any, form: str) -> str:
    """A value as text; nothing where it is not known.

    Parameters
    ----------
    value : object
        NaN where it is not known.
    form : str
        As of `format`.
    """
    return "" if value != value else format(value, form)
