"""Kalker's Figs. 27 to 29: rolling of an elastic cylinder on a rigid one, free and under a
tangential force.

The paper gives G1 = 1, G2 infinite, nu1 = 0.286, f = 0.1, and for free rolling (Fx = 0) slip on
[0.410, 0.625], [-0.625, -0.575] and [-0.505, -0.300], the middle one against the others, in a
contact of half-width 0.625. Fig. 28 has Fx = 0.5 f Fz, and below it interchanged constants and the
opposite force; Fig. 29 has Fx = -0.5 f Fz. Half-width and radius only scale the tractions; the
radius is 1 here. The paper's f in Figs. 28 and 29 is taken to be that of Fig. 27.

Slip is that of body 1, the upper one, over body 2: negative at both edges in free rolling. (The
paper calls it "in the direction of rolling" there: it counts the other body's.)

Run: python examples/fig27_to_29_unlike_cylinders.py [picture.png]
"""

import math
import sys
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import varcontact as vc
from varcontact.plotting.style import SLIP_COLOUR, STICK_COLOUR, TRACTION_COLOUR

ELASTIC_ON_RIGID = vc.Bodies(G=(1.0, math.inf), nu=(0.286, 0.286))
RIGID_ON_ELASTIC = vc.Bodies(G=(math.inf, 1.0), nu=(0.286, 0.286))
HALF_WIDTH, RADIUS, FRICTION = 0.625, 1.0, 0.1
PRINTED = [(-0.625, -0.575), (-0.505, -0.300), (0.410, 0.625)]


def solved(bodies: vc.Bodies, part: float, cells: int) -> vc.Solution:
    """Steady rolling with Fx that part of f Fz, so many elements across."""
    force = vc.reference.line_contact(RADIUS, bodies, a=HALF_WIDTH).force
    scene = vc.Scene(
        bodies=bodies,
        surface=vc.Cylinders(R=RADIUS),
        normal_force=force,
        friction=FRICTION,
        motion=vc.Steady(Fx=part * FRICTION * force),
        grid=vc.Grid(nx=cells),
    )
    return vc.solve(scene)


def slip_intervals(sol: vc.Solution) -> list[tuple[float, float, int]]:
    """Where it slips: left end, right end and sign of the slip, from left to right."""
    signs = np.where(sol.state[0] == 2, np.sign(sol.slip[0, 0]), 0)
    ends = np.concatenate([[0], np.flatnonzero(np.diff(signs)) + 1, [signs.size]])
    edges = sol.grid.x[0] + (np.arange(signs.size + 1) - 0.5) * sol.grid.sides[0]
    return [
        (float(edges[i]), float(edges[j]), int(signs[i]))
        for i, j in pairwise(ends)
        if signs[i] != 0
    ]


def draw(row: list[Axes], sol: vc.Solution, title: str) -> None:
    """Traction within its bounds on the left, slip on the right; stick and slip areas behind."""
    x, dx = sol.grid.x, sol.grid.sides[0]
    for ax in row:
        for state, colour in ((1, STICK_COLOUR), (2, SLIP_COLOUR)):
            ax.bar(
                x[sol.state[0] == state],
                1.0,
                width=dx,
                color=colour,
                transform=ax.get_xaxis_transform(),
                zorder=0,
            )
        ax.axhline(0, color="k", linewidth=0.5)
        ax.set_xlim(x[0], x[-1])
    bound = sol.traction_bound[0]
    row[0].plot(x, bound, "0.5", x, -bound, "0.5", linewidth=1)
    row[0].plot(x, sol.traction[0, 0], color=TRACTION_COLOUR)
    row[1].plot(x, np.where(sol.state[0] > 0, sol.slip[0, 0], np.nan), color=TRACTION_COLOUR)
    row[0].set_title(f"{title}: $p_x$", fontsize="medium")
    row[1].set_title(f"slip, $v_x$ = {sol.creepage[0]:.4f}", fontsize="medium")


def main(
    picture: str = "fig27_to_29_unlike_cylinders.png", cells: int = 200
) -> dict[str, vc.Solution]:
    """Solve, draw and print; the solutions by figure."""
    cases = {
        "Fig. 27, free rolling": solved(ELASTIC_ON_RIGID, 0.0, cells),
        "Fig. 28, Fx = 0.5 f Fz": solved(ELASTIC_ON_RIGID, 0.5, cells),
        "Fig. 28, interchanged, -0.5 f Fz": solved(RIGID_ON_ELASTIC, -0.5, cells),
        "Fig. 29, Fx = -0.5 f Fz": solved(ELASTIC_ON_RIGID, -0.5, cells),
    }
    figure, axes = plt.subplots(4, 2, figsize=(9, 11), layout="constrained", sharex=True)
    for row, (title, sol) in zip(axes, cases.items(), strict=True):
        draw(list(row), sol, title)
        places = ", ".join(
            f"[{a:.3f}, {b:.3f}] {'+' if sign > 0 else '-'}" for a, b, sign in slip_intervals(sol)
        )
        print(f"{title}: vx = {sol.creepage[0]:.5f}, {len(sol.passes)} passes, slip on {places}")
    print("the paper, Fig. 27:", ", ".join(f"[{a:.3f}, {b:.3f}]" for a, b in PRINTED))
    for ax in axes[-1]:
        ax.set_xlabel("x, rolling to the right")
    figure.savefig(picture, dpi=120)
    plt.close(figure)
    return cases


if __name__ == "__main__":
    main(*sys.argv[1:2])
