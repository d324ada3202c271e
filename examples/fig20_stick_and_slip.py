"""Kalker's Fig. 20: areas of stick and slip by FASTSIM in six kinds of rolling, and by the exact
theory below.

(a) pure creepage, (b) small spin, (c) lateral creepage and spin, (d) longitudinal creepage and
spin, (e) all three, (f) large spin. The paper calls the areas of FASTSIM, under a parabolic bound,
quite close to the exact ones, and those under Hertz's bound bad. Printed is the part of the contact
with the same state in both theories, under either bound: it differs by 4 % at most.

The radius of the contact is 1, G = 1, nu = 0.28, f = 0.3, Fz = 1.
Run: python examples/fig20_stick_and_slip.py [picture.png]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

import varcontact as vc
from varcontact.plotting.fields import draw_areas

MOTIONS = {
    "(a) vx, vy": vc.Steady(vx=0.06, vy=0.03),
    "(b) small spin": vc.Steady(spin=0.12),
    "(c) vy and spin": vc.Steady(vy=0.05, spin=0.12),
    "(d) vx and spin": vc.Steady(vx=0.05, spin=0.12),
    "(e) vx, vy and spin": vc.Steady(vx=0.04, vy=-0.04, spin=0.15),
    "(f) large spin": vc.Steady(spin=0.5),
}
METHODS = ("fastsim", "fastsim-elliptic", "auto")


def solved(motion: vc.Steady, cells: int) -> dict[str, vc.Solution]:
    """One case by each method, so many elements across."""
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=1.0, b=1.0),
        normal_force=1.0,
        friction=0.3,
        motion=motion,
        grid=vc.Grid(nx=cells, ny=cells),
    )
    return {method: vc.solve(scene, tangential=method, certify=None) for method in METHODS}


def alike(found: vc.Solution, exact: vc.Solution) -> float:
    """Part of the elements in contact that stick in both solutions, or slip in both."""
    return float(np.mean((found.state == exact.state)[exact.state > 0]))


def draw(ax: Axes, sol: vc.Solution) -> None:
    """Areas and tractions."""
    draw_areas(ax, sol)
    ax.get_legend().remove()
    ax.add_patch(Circle((0, 0), 1.0, fill=False, edgecolor="k"))
    ax.set_xlabel("")
    ax.set_ylabel("")
    ax.set_title("")


def main(
    picture: str = "fig20_stick_and_slip.png", cells: int = 21
) -> dict[str, dict[str, vc.Solution]]:
    """Solve and draw the six cases."""
    cases = {title: solved(motion, cells) for title, motion in MOTIONS.items()}
    margins = {"left": 0.03, "right": 0.99, "bottom": 0.1, "top": 0.94, "wspace": 0.06}
    figure, axes = plt.subplots(
        2, 6, figsize=(17, 6.4), sharex=True, sharey=True, gridspec_kw=margins
    )
    print("alike with the exact theory: parabolic bound, Hertz's bound")
    for column, (title, found) in zip(axes.T, cases.items(), strict=True):
        parts = [alike(found[method], found["auto"]) for method in METHODS[:2]]
        print(f"{title:<20} {100 * parts[0]:5.1f} % {100 * parts[1]:5.1f} %")
        draw(column[0], found["fastsim"])
        draw(column[1], found["auto"])
        column[0].set_title(f"{title}, FASTSIM")
        column[1].set_title("exact theory")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles[:2], labels[:2], ncols=2, loc="lower center", frameon=False)
    figure.savefig(picture, dpi=90)
    plt.close(figure)
    print(f"picture: {Path(picture).resolve()}")
    return cases


if __name__ == "__main__":
    main(*sys.argv[1:2])
