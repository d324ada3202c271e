"""Methods side by side on the standard bank of scenes: error of the tractions against time, and a
table.

Run: python examples/compare_bank.py [picture.png] [table.csv]

The table file is written after each scene, and scenes that it has are not solved again.
"""

from __future__ import annotations

import sys

import pandas as pd

import varcontact as vc
from varcontact.study.compare import summary
from varcontact.study.methods import DEFAULT_METHODS


def main(
    picture: str | None = None,
    store: str | None = None,
    cells: int = 12,
    methods: tuple[str, ...] = DEFAULT_METHODS,
) -> pd.DataFrame:
    """Compare, print, draw; the table."""
    table = vc.compare(vc.standard_bank(cells), methods, store=store)
    print(summary(table))
    exact = table[table["outcome"] == "solved"]
    print(f"\nexact methods: forces within {exact['force_distance'].max():.0e} of f Fz, ", end="")
    print(f"tractions within {exact['traction_distance'].max():.0e} of the largest bound")
    if picture is not None:
        vc.plot_comparison(table).savefig(picture, dpi=150)
    return table


if __name__ == "__main__":
    main(*(sys.argv[1:3] or ["compare_bank.png"]))
