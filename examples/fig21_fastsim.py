"""Kalker's Fig. 21: FASTSIM on a wheel-rail ellipse in pure spin, and the exact theory beside it.

The paper gives a = 6.8 mm, b = 6.5 mm, f Fz = 45000 N, spin = 0.00054 /mm and Fy = -18.12 kN, by 10
x 10 elements. It does not give the elastic constants: E = 200 GPa and nu = 0.25 lead to just that
force with the C23 of Kalker's table, and to -18.10 kN with the computed one, which is taken here.
The flexibility is the printed one, (164); as only spin is there, separate ones give the same. The
exact theory solves the scene of fig21_spin.toml with these constants.

An element of FASTSIM is an interval of a strip. Its colour tells whether the particles slip in it,
its traction is that of its rear end. At the trailing edge the bound, and with it the traction, is
zero.

Lengths in mm, forces in N. Run: python examples/fig21_fastsim.py [picture.png]
"""

import sys
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patches import Ellipse, Patch
from matplotlib.quiver import Quiver

import varcontact as vc
from varcontact.plotting.style import SLIP_COLOUR, STICK_COLOUR, TRACTION_COLOUR
from varcontact.reference import creepage_coefficients
from varcontact.theories import FastsimField, fastsim_field

A, B, FRICTION_FORCE, SPIN = 6.8, 6.5, 45e3, 0.00054
BODIES = vc.Bodies.from_young(E=2e5, nu=0.25)
COLOURS = np.array(["white", STICK_COLOUR, SLIP_COLOUR])


def simplified() -> FastsimField:
    """The field by FASTSIM."""
    table = creepage_coefficients(A, B, BODIES.combined_nu)
    contact = (A, B, BODIES.combined_G, FRICTION_FORCE)
    return fastsim_field(*contact, (0.0, 0.0, SPIN), table, m=10, n=10, flexibility="weighted")


def exact(cells: int) -> vc.Solution:
    """The solution by the exact theory, so many elements across."""
    scene, options = vc.read_scene(Path(__file__).with_name("fig21_spin.toml"))
    return vc.solve(replace(scene, bodies=BODIES, grid=vc.Grid(nx=cells, ny=cells)), **options)


def draw_simplified(ax: Axes, field: FastsimField) -> None:
    """Elements, coloured by stick and slip, with the traction at their rear ends."""
    # the interval ahead of each point, and the last one, at whose end the bound is zero: it slips
    rear = np.concatenate([field.x[:, :1] - field.dx[:, None], field.x], axis=1)
    state = np.concatenate([np.full((field.y.size, 1), 2), field.state], axis=1)
    low, high = field.y - field.dy / 2, field.y + field.dy / 2
    corners = [
        [(x, low[i]), (x + field.dx[i], low[i]), (x + field.dx[i], high[i]), (x, high[i])]
        for i in range(field.y.size)
        for x in rear[i]
    ]
    ax.add_collection(
        PolyCollection(corners, facecolors=COLOURS[state.ravel()], edgecolors="0.6", linewidths=0.5)
    )
    arrows(ax, field.x, np.broadcast_to(field.y[:, None], field.x.shape), field.traction)
    ax.set_title(
        f"FASTSIM, {rear.shape[1]} x {field.y.size}:  $F_y = {field.force[1] / 1e3:.2f}$ kN"
    )


def draw_exact(ax: Axes, sol: vc.Solution) -> None:
    """Elements, coloured by stick and slip, with the traction at some of them."""
    sol.plot("traction", ax=ax)
    ax.get_legend().remove()
    ax.set_title(
        f"Exact theory, {sol.elements['contact']} elements:  $F_y = {sol.force[1] / 1e3:.2f}$ kN"
    )


def arrows(ax: Axes, x: np.ndarray, y: np.ndarray, traction: np.ndarray) -> Quiver:
    """Tractions on body 1, in the same scale in both pictures."""
    scale = {"angles": "xy", "scale_units": "xy", "scale": 330.0}  # N/mm2 for an arrow of 1 mm
    return ax.quiver(x, y, *traction, color=TRACTION_COLOUR, width=0.0045, zorder=3, **scale)


def main(picture: str = "fig21_fastsim.png", cells: int = 21) -> tuple[FastsimField, vc.Solution]:
    """Both theories, their forces, and the picture."""
    field, sol = simplified(), exact(cells)
    print(f"FASTSIM      Fy = {field.force[1] / 1e3:.2f} kN (the paper: -18.12)")
    print(f"exact theory Fy = {sol.force[1] / 1e3:.2f} kN, {sol.elements['contact']} elements")
    print(f"difference   {100 * abs(field.force[1] - sol.force[1]) / FRICTION_FORCE:.1f} % of f Fz")

    figure, axes = plt.subplots(1, 2, figsize=(11.0, 6.4), layout="compressed", sharey=True)
    draw_simplified(axes[0], field)
    draw_exact(axes[1], sol)
    for ax in axes:
        ax.add_patch(Ellipse((0, 0), 2 * A, 2 * B, fill=False, edgecolor="k", linewidth=1.0))
        ax.set_xlabel("x [mm], rolling to the right")
        ax.set_xlim(-7.6, 7.6)
        ax.set_ylim(-7.6, 7.6)
        ax.set_aspect("equal")
    axes[0].set_ylabel("y [mm]")
    handles = [Patch(facecolor=STICK_COLOUR, edgecolor="0.6", label="stick")]
    handles += [Patch(facecolor=SLIP_COLOUR, edgecolor="0.6", label="slip")]
    figure.legend(handles=handles, ncols=2, loc="outside lower center", frameon=False)
    figure.savefig(picture, dpi=150)
    plt.close(figure)
    print(f"picture: {Path(picture).resolve()}")
    return field, sol


if __name__ == "__main__":
    main(*sys.argv[1:2])
