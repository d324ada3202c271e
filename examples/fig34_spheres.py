"""Kalker's Fig. 34: like spheres in steady rolling, with tractions, stick (A) and slip (S) areas,
and the spin pole.

(a) pure spin, (b) longitudinal creepage and spin, (c) lateral creepage and spin, (d) longitudinal
creepage, (e) large spin; and |p| on the line y = 0 of (a) and (d). The paper gives no numbers. Here
the radius of the contact is 1, G = 1, nu = 0.28, f = 0.3, Fz = 1.

Run: python examples/fig34_spheres.py [picture.png]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import varcontact as vc
from varcontact.plotting.fields import draw_areas
from varcontact.plotting.style import TRACTION_COLOUR

MOTIONS = {
    "(a) spin": vc.Steady(spin=0.12),
    "(b) vx and spin": vc.Steady(vx=0.05, spin=0.12),
    "(c) vy and spin": vc.Steady(vy=0.05, spin=0.12),
    "(d) vx": vc.Steady(vx=0.07),
    "(e) large spin": vc.Steady(spin=0.8),
}


def solved(motion: vc.Steady, cells: int) -> vc.Solution:
    """One case, so many elements across; an odd number has a row on the line y = 0."""
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=1.0, b=1.0),
        normal_force=1.0,
        friction=0.3,
        motion=motion,
        grid=vc.Grid(nx=cells, ny=cells),
    )
    return vc.solve(scene)


def main(picture: str = "fig34_spheres.png", cells: int = 25) -> dict[str, vc.Solution]:
    """Solve and draw the five cases."""
    cases = {title: solved(motion, cells) for title, motion in MOTIONS.items()}
    figure, axes = plt.subplots(2, 4, figsize=(17, 8.4), layout="constrained")
    order = [axes[0, 0], axes[0, 2], axes[0, 3], axes[1, 0], axes[1, 2]]
    for ax, (title, sol) in zip(order, cases.items(), strict=True):
        draw_areas(ax, sol)
        ax.set_title(f"{title}: $F$ = ({sol.force[0]:.3f}, {sol.force[1]:.3f})")
        print(
            f"{title:<16} F = ({sol.force[0]:.4f}, {sol.force[1]:.4f}), "
            f"sticking {sol.elements['stick']} elements"
        )
    for ax, title in ((axes[0, 1], "(a) spin"), (axes[1, 1], "(d) vx")):
        sol = cases[title]
        row = sol.grid.ny // 2
        ax.plot(sol.grid.x, sol.traction_bound[row], color="0.5", linewidth=1)
        ax.plot(
            sol.grid.x, np.hypot(*sol.traction[:, row]), "o-", color=TRACTION_COLOUR, markersize=3
        )
        ax.set_title(f"{title[:3]}' |p| on y = 0")
        ax.set_xlabel("x, rolling to the right")
    axes[1, 3].axis("off")
    figure.savefig(picture, dpi=90)
    plt.close(figure)
    return cases


if __name__ == "__main__":
    main(*sys.argv[1:2])
