"""Loops for unlike bodies: Johnson's process, Panagiotopoulos's and the joint loop, by friction f
and unlikeness K.

An elastic cylinder on a rigid one, K = (1 - 2 nu)/2, in three motions: free rolling, rolling under
half of the force that friction can carry (of f = 2 where f is infinite), and a shift by that force.
How many passes each loop needs for a residual of the whole of 1e-8, a cross where it does not get
there, and what residual Johnson's single pass leaves.

Run: python examples/coupling_loops.py [picture.png]
"""

import math
import sys
from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import varcontact as vc

FRICTION = (0.01, 0.05, 0.1, 0.3, 0.6, 1.0, 2.0, math.inf)
UNLIKENESS = (0.0, 0.02, 0.1, 0.2, 0.3, 0.4, 0.5)
LOAD = 1e-3
MOTIONS = {
    "free rolling": lambda f: vc.Steady(Fx=0.0),
    "rolling, Fx = -0.5 f Fz": lambda f: vc.Steady(Fx=-0.5 * min(f, 2.0) * LOAD),
    "shift, Fx = 0.5 f Fz": lambda f: vc.Shift(Fx=0.5 * min(f, 2.0) * LOAD),
}
LOOPS = ("panagiotopoulos", "joint")


@dataclass(frozen=True)
class Cell:
    """One scene by one loop: passes, the residual of the whole, whether it is below the
    tolerance.
    """

    passes: int
    residual: float
    converged: bool


Table = dict[tuple[float, float], Cell]


def cell(f: float, K: float, motion: str, coupling: str, cells: int) -> Cell:
    """Solve one scene by the active-set methods inside one loop."""
    nu = 0.5 - K
    scene = vc.Scene(
        bodies=vc.Bodies(G=(1.0, math.inf), nu=(nu, nu)),
        surface=vc.Cylinders(R=1.0),
        normal_force=LOAD,
        friction=f,
        motion=MOTIONS[motion](f),
        grid=vc.Grid(nx=cells),
    )
    try:
        sol = vc.solve(scene, normal="norm", tangential="tang-safeguarded", coupling=coupling)
    except vc.NotConverged as error:
        sol = error.solution
    return Cell(len(sol.passes), sol.certificate.residual, sol.converged)


def draw(ax: Axes, table: Table, title: str, johnson: bool) -> None:
    """Passes as numbers and colours, crosses where the loop failed; of Johnson's process the
    residual.
    """
    frictions, unlikeness = sorted({f for f, _ in table}), sorted({K for _, K in table})
    values = np.array([[_value(table[f, K], johnson) for f in frictions] for K in unlikeness])
    limits = (-8, 0) if johnson else (1, 50)
    ax.imshow(values, origin="lower", cmap="YlOrBr", vmin=limits[0], vmax=limits[1], aspect="auto")
    for row, column in np.ndindex(values.shape):
        entry = table[frictions[column], unlikeness[row]]
        text = f"{entry.residual:.0e}" if johnson else f"{entry.passes}" if entry.converged else "×"
        dark = (values[row, column] - limits[0]) / (limits[1] - limits[0]) > 0.6
        colour = "white" if dark else "black"
        ax.text(
            column, row, text, ha="center", va="center", fontsize=8 if johnson else 9, color=colour
        )
    ax.set_xticks(range(len(frictions)), [f"{f:g}" for f in frictions])
    ax.set_yticks(range(len(unlikeness)), [f"{K:g}" for K in unlikeness])
    ax.set_title(title, fontsize="medium")


def _value(entry: Cell, johnson: bool) -> float:
    return math.log10(max(entry.residual, 1e-16)) if johnson else entry.passes


def main(
    picture: str = "coupling_loops.png",
    cells: int = 40,
    frictions: tuple[float, ...] = FRICTION,
    unlikeness: tuple[float, ...] = UNLIKENESS,
) -> dict[tuple[str, str], Table]:
    """Solve, draw and print; by motion and loop the cells by (f, K)."""
    tables = {
        (motion, loop): {
            (f, K): cell(f, K, motion, loop, cells) for f in frictions for K in unlikeness
        }
        for motion in MOTIONS
        for loop in ("johnson", *LOOPS)
    }
    figure, axes = plt.subplots(3, 3, figsize=(9.5, 8.5), layout="constrained")
    for ax, ((motion, loop), table) in zip(axes.flat, tables.items(), strict=True):
        johnson = loop == "johnson"
        shown = "residual after johnson" if johnson else f"passes of {loop}"
        draw(ax, table, f"{motion}:\n{shown}", johnson)
        failed = [key for key, entry in table.items() if not entry.converged and key[1] != 0]
        worst = max(entry.residual for entry in table.values())
        most = max(entry.passes for entry in table.values())
        if johnson:
            print(f"{motion:24s} {loop:16s} residual of the whole up to {worst:.1e}")
        else:
            print(
                f"{motion:24s} {loop:16s} up to {most} passes, "
                f"{len(failed)} of {len(table)} failed, {worst:.1e}"
            )
    for ax in axes[-1]:
        ax.set_xlabel("friction f")
    for ax in axes[:, 0]:
        ax.set_ylabel("K")
    figure.savefig(picture, dpi=110)
    plt.close(figure)
    return tables


if __name__ == "__main__":
    main(*sys.argv[1:2])
