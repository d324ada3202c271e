"""How far the approximate theories are from the exact one, over the standard bank of scenes.

FASTSIM is there with separate flexibilities ("fastsim") and with the single weighted one that the
paper prints, (164) ("fastsim-weighted"), each under the parabolic traction bound (167) and under
Hertz's (166) ("-elliptic").

A distance is |F - F_exact| in percent of f Fz, both on the same elements. The scenes that no theory
can treat are left out.

Run: python examples/theories_bank.py [elements across the contact]
"""

import sys

import pandas as pd

import varcontact as vc

FASTSIM = ("fastsim", "fastsim-weighted", "fastsim-elliptic", "fastsim-weighted-elliptic")
THEORIES = (*FASTSIM, "linear", "vermeulen-johnson")


def main(cells: int = 28) -> pd.DataFrame:
    """Compare, print; distances in percent, with a row for each scene and a column for each
    theory.
    """
    bank = vc.standard_bank(cells)
    table = vc.compare(bank, ("tang-safeguarded", *THEORIES))
    table = table[table["outcome"] == "approximate"]
    distances = 100 * table.pivot(index="scene", columns="method", values="force_distance")
    distances = distances.reindex(
        index=[name for name in bank if name in distances.index], columns=list(THEORIES)
    )
    print(f"Distance from the exact theory, in % of f Fz, on {cells} elements across:\n")
    print(distances.round(1).to_string(na_rep=""))
    return distances


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:2]))
