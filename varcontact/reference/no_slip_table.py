"""The table of creepage coefficients that the package ships:
``python -m varcontact.reference.no_slip_table FILE.csv``.

It takes some minutes. Ratios a/b have 20 to the decade; Poisson's ratios are
Chebyshev's points of [-1, 0.5].
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np

from varcontact.reference.no_slip_ellipse import resultants

RATIOS = 10.0 ** (np.arange(-60, 61) / 20)
POISSON = -0.25 - 0.75 * np.cos(np.pi * np.arange(13) / 12)
HEAD = "a_over_b,nu,C11,C22,C23,C33"


def lines() -> Iterator[str]:
    """Lines of the table, the head first; the error of an entry is that of `no_slip_ellipse` at its
    degree.
    """
    yield HEAD
    for ratio in RATIOS:
        degree = 256 if ratio < 0.1 else 128
        for nu in POISSON:
            C = resultants(float(ratio), float(nu), degree)
            entries = (C[0, 0], C[1, 1], C[1, 2], C[2, 2])
            yield f"{ratio:.12g},{nu:.12g}," + ",".join(f"{entry:.9g}" for entry in entries)


if __name__ == "__main__":
    with open(sys.argv[1], "w", encoding="utf-8") as table:
        for line in lines():
            print(line, file=table, flush=True)
