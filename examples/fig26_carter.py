"""Kalker's Fig. 26: steady rolling of like cylinders, by Carter's closed form (1926) and by the
package.

The paper gives no numbers but the shapes: a stick area at the leading edge, in which the traction
grows to its bound, and a slip area behind it. Here three quarters of f Fz are transmitted, for
which the areas are equally wide. All is dimensionless: lengths by the half-width a, tractions by f
times the largest pressure, slip by f a/R, the creepage from which on everything slides. The slip of
an element is the mean over a step, in which its particles come from x + dq to x: it is compared
with Carter's, and drawn, in the middle.

Run: python examples/fig26_carter.py [picture.png]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import varcontact as vc
from varcontact.plotting.style import SLIP_COLOUR, STICK_COLOUR, TRACTION_COLOUR
from varcontact.reference import Carter, carter, line_contact

BODIES, R, FRICTION, PART = vc.Bodies(G=1.0, nu=0.28), 100.0, 0.3, 0.75
HERTZ = line_contact(R, BODIES, a=1.0)


def solved(elements: int) -> vc.Solution:
    """The solution with so many elements across the contact; the pressure is solved for as well."""
    scene = vc.Scene(
        bodies=BODIES,
        surface=vc.Cylinders(R=R),
        normal_force=HERTZ.force,
        friction=FRICTION,
        motion=vc.Steady(Fx=PART * FRICTION * HERTZ.force),
        grid=vc.Grid(nx=elements),
    )
    return vc.solve(scene, normal="clarabel")


def errors(sol: vc.Solution, exact: Carter) -> dict[str, float]:
    """Relative distances from the closed form: fields in L2, creepage, and width of the stick
    area.
    """
    contact = sol.state[0] > 0
    x, middle = sol.grid.x, sol.grid.x[contact] + sol.grid.sides[0] / 2
    fields = {
        "pressure": (sol.pressure[0], exact.contact.pressure(x)),
        "traction": (sol.traction[0, 0], exact.traction(x)),
        "slip": (sol.slip[0, 0, contact], np.nan_to_num(exact.slip(middle))),
        "creepage": (np.array([sol.creepage[0]]), np.array([exact.creepage])),
        "stick area": (np.array([sol.areas["stick"]]), np.array([2 * exact.stick_half_width])),
    }
    return {
        name: float(np.linalg.norm(ours - his) / np.linalg.norm(his))
        for name, (ours, his) in fields.items()
    }


def draw(
    ax: Axes, x: np.ndarray, ours: np.ndarray, fine: np.ndarray, his: np.ndarray, edge: float
) -> None:
    """Our values as dots on the closed form's line, over its slip and stick areas."""
    ax.axvspan(-1, edge, color=SLIP_COLOUR, linewidth=0, zorder=0, label="slip")
    ax.axvspan(edge, 1, color=STICK_COLOUR, linewidth=0, zorder=0, label="stick")
    ax.plot(fine, his, color=TRACTION_COLOUR, linewidth=1, label="Carter")
    ax.plot(x, ours, "o", color=TRACTION_COLOUR, markersize=3.5, label="varcontact")
    ax.axhline(0, color="k", linewidth=0.5)
    ax.set_xlabel("x/a, rolling to the right")
    ax.set_xlim(-1.1, 1.1)


def main(picture: str = "fig26_carter.png", elements: int = 40) -> dict[str, float]:
    """Solve, compare, draw."""
    exact, sol = carter(HERTZ, FRICTION, force=PART * FRICTION * HERTZ.force), solved(elements)
    numbers = errors(sol, exact)
    print(
        f"creepage {sol.creepage[0]:.6f}, Carter {exact.creepage:.6f}; "
        f"{elements} elements across the contact"
    )
    for name, error in numbers.items():
        print(f"{name:<12} off by {100 * error:.2f} %")

    contact, fine = sol.state[0] > 0, np.linspace(-1, 1, 1001)
    x, edge = sol.grid.x[contact], HERTZ.a - 2 * exact.stick_half_width
    bound, full = FRICTION * HERTZ.peak_pressure, exact.full_sliding_creepage
    figure, axes = plt.subplots(1, 2, figsize=(10.0, 4.4), layout="constrained")
    axes[0].plot(fine, FRICTION * HERTZ.pressure(fine) / bound, "0.35", linewidth=1, linestyle="--")
    axes[0].plot(
        x, sol.traction_bound[0, contact] / bound, ".", color="0.35", label="traction bound"
    )
    draw(axes[0], x, sol.traction[0, 0, contact] / bound, fine, exact.traction(fine) / bound, edge)
    axes[0].set_ylabel("$p_x\\,/\\,(f p_0)$")
    axes[0].set_title(f"Traction on body 1, $F_x = {PART}\\,f F_z$")
    draw(
        axes[1],
        x + sol.grid.sides[0] / 2,
        sol.slip[0, 0, contact] / full,
        fine,
        exact.slip(fine) / full,
        edge,
    )
    axes[1].set_ylabel("relative slip / $(f a/R)$")
    axes[1].set_title("Slip of body 1 over body 2")
    figure.legend(
        *axes[0].get_legend_handles_labels(), ncols=5, loc="outside lower center", frameon=False
    )
    figure.savefig(picture, dpi=150)
    plt.close(figure)
    print(f"picture: {Path(picture).resolve()}")
    return numbers


if __name__ == "__main__":
    main(*sys.argv[1:2])
