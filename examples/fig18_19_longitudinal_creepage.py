"""Kalker's Figs. 18 and 19: tractions by longitudinal creepage, by the simplified and by the exact
theory.

Both on the line y = 0 of a circular contact. Left, Fig. 18: the simplified theory has a parabolic
traction bound, and without slip a straight line that breaks Coulomb's law at the trailing edge;
FASTSIM follows the line up to the bound. Right, Fig. 19: the exact theory has Hertz's bound, and
where stick ends a vertical tangent. Both carry nearly the same force.

The radius is 1, G = 1, nu = 0.25, f = 1, Fz = 1.
Run: python examples/fig18_19_longitudinal_creepage.py [picture.png]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import varcontact as vc
from varcontact.theories import FastsimField, fastsim_field, flexibilities

NU, LIMIT, VX = 0.25, 1.0, -0.25
TABLE = vc.no_slip_coefficients(1.0, NU)
L = float(flexibilities(1.0, 1.0, 1.0, TABLE)[0])
BOUND, NO_SLIP, TRACTION = "0.45", "C0--", "C3"


def simplified(points: int) -> FastsimField:
    """FASTSIM with so many intervals along each strip; the middle strip lies on y = 0."""
    return fastsim_field(1.0, 1.0, 1.0, LIMIT, (VX, 0.0, 0.0), TABLE, m=points, n=21)


def stick_end() -> float:
    """Where the straight line (168) meets the parabola (169)."""
    return -1 + abs(VX) * np.pi / (2 * LIMIT * L)


def exact(cells: int) -> vc.Solution:
    """The exact theory, so many elements across: an odd number has a row on y = 0."""
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=NU),
        surface=vc.Ellipse(a=1.0, b=1.0),
        normal_force=LIMIT,
        friction=1.0,
        motion=vc.Steady(vx=VX),
        grid=vc.Grid(nx=cells, ny=cells),
    )
    return vc.solve(scene)


def draw_simplified(ax: Axes, field: FastsimField) -> None:
    """The bound, the straight line, and FASTSIM's tractions."""
    x = np.linspace(-1.0, 1.0, 201)
    row = field.y.size // 2
    ax.plot(x, 2 * LIMIT / np.pi * (1 - x**2), color=BOUND, label="traction bound")
    ax.plot(x, (x - 1) * VX / L, NO_SLIP, label="without slip (168)")
    ax.plot(field.x[row], field.traction[0, row], ".", color=TRACTION, label="traction")
    ax.axvline(stick_end(), color="0.8", linewidth=1, zorder=0)
    ax.set_title(f"Fig. 18: simplified theory, $F_x = {field.force[0]:.3f}$")


def draw_exact(ax: Axes, sol: vc.Solution) -> None:
    """The bound, and the tractions of the middle row."""
    x = np.linspace(-1.0, 1.0, 201)
    row = sol.grid.ny // 2
    ax.plot(x, 1.5 * LIMIT / np.pi * np.sqrt(1 - x**2), color=BOUND)
    ax.plot(sol.grid.x, sol.traction[0, row], ".", color=TRACTION)
    ax.axvline(exact_stick_end(sol), color="0.8", linewidth=1, zorder=0)
    ax.set_title(f"Fig. 19: exact theory, $F_x = {sol.force[0]:.3f}$")


def exact_stick_end(sol: vc.Solution) -> float:
    """The rear edge of the elements that stick on y = 0."""
    sticks = sol.state[sol.grid.ny // 2] == 1
    return float(sol.grid.x[sticks].min() - sol.grid.sides[0] / 2)


def main(
    picture: str = "fig18_19_longitudinal_creepage.png", points: int = 50, cells: int = 41
) -> tuple[FastsimField, vc.Solution]:
    """Both theories, their forces and where stick ends, and the picture."""
    field = simplified(points)
    sol = exact(cells)
    print(f"simplified theory: Fx = {field.force[0]:.4f} f Fz, sticks from x = {stick_end():.3f}")
    print(f"exact theory:      Fx = {sol.force[0]:.4f} f Fz, from x = {exact_stick_end(sol):.3f}")
    figure, axes = plt.subplots(1, 2, figsize=(10.5, 4.4), sharey=True, layout="constrained")
    draw_simplified(axes[0], field)
    draw_exact(axes[1], sol)
    for ax in axes:
        ax.set_xlabel("x, rolling to the right")
        ax.set_ylim(0, 0.75)
    axes[0].set_ylabel("$p_x$ on $y = 0$")
    figure.legend(
        *axes[0].get_legend_handles_labels(), ncols=3, loc="outside lower center", frameon=False
    )
    figure.savefig(picture, dpi=150)
    plt.close(figure)
    print(f"picture: {Path(picture).resolve()}")
    return field, sol


if __name__ == "__main__":
    main(*sys.argv[1:2])
