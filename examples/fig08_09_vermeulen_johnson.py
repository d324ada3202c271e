"""Kalker's Figs. 8 and 9: Vermeulen and Johnson's stick area and forces beside the exact ones.

Left, Fig. 8: the ellipse of stick that Vermeulen and Johnson assume touches the contact at its
foremost point; the exact stick area reaches the whole leading edge. Right, Fig. 9: their own line,
Kalker's line with the same form and the exact slope at the origin, FASTSIM and the exact theory.
Their measured points stand in the paper's picture only, not in its text, and are not shown here.

The semi-axes are 1.5 and 1, G = 1, nu = 0.25, f = 1, Fz = 1.
Run: python examples/fig08_09_vermeulen_johnson.py [picture.png]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse

import varcontact as vc
from varcontact.plotting.fields import draw_areas
from varcontact.theories import vermeulen_johnson, vermeulen_johnson_coefficients

A, B, G, NU, LIMIT = 1.5, 1.0, 1.0, 0.25, 1.0
KALKER = vc.no_slip_coefficients(A / B, NU)
OWN = vermeulen_johnson_coefficients(A, B, NU)
UNIT = 3 * LIMIT / (A * B * G * KALKER.C11)  # the creepage vx with w' = 1
SHOWN = 0.4  # w' of Fig. 8


def scene(cells: int, w: float) -> vc.Scene:
    """The contact with so many elements across, in rolling by vx."""
    return vc.Scene(
        bodies=vc.Bodies(G=G, nu=NU),
        surface=vc.Ellipse(a=A, b=B),
        normal_force=LIMIT,
        friction=1.0,
        motion=vc.Steady(vx=-UNIT * w),
        grid=vc.Grid(nx=cells, ny=cells),
    )


def stick_ellipse(part: float) -> tuple[float, float]:
    """Middle on the x-axis, and size relative to the contact, where F = part * f Fz."""
    size = (1 - part) ** (1 / 3)
    return A * (1 - size), size


def lines(w: np.ndarray) -> dict[str, np.ndarray]:
    """Fx / (f Fz) of both lines and of FASTSIM."""
    creepages = np.outer(w, [-UNIT, 0.0, 0.0])
    contact = {"a": A, "b": B, "G": G, "nu": NU, "normal_force": LIMIT, "friction": 1.0}
    fastsim = vc.creep_forces("fastsim", **contact, vx=creepages[:, 0], m=50, n=50)
    return {
        "Vermeulen-Johnson": vermeulen_johnson(A, B, G, LIMIT, creepages, OWN)[:, 0],
        "Kalker's line": vermeulen_johnson(A, B, G, LIMIT, creepages, KALKER)[:, 0],
        "FASTSIM": fastsim.Fx,
    }


def draw_stick(ax: Axes, sol: vc.Solution) -> None:
    """The exact areas, and the ellipse of stick by the force of Kalker's line."""
    draw_areas(ax, sol)
    middle, size = stick_ellipse(lines(np.array([SHOWN]))["Kalker's line"][0])
    ax.add_patch(Ellipse((0, 0), 2 * A, 2 * B, fill=False, edgecolor="k"))
    ax.add_patch(
        Ellipse(
            (middle, 0),
            2 * A * size,
            2 * B * size,
            fill=False,
            edgecolor="#c0392b",
            linestyle="--",
            linewidth=1.8,
            label="stick by Vermeulen-Johnson",
        )
    )
    ax.set_title(f"Fig. 8: stick and slip, $w' = {SHOWN}$")
    ax.set_xlabel("x, rolling to the right")
    ax.get_legend().remove()


def draw_forces(ax: Axes, places: np.ndarray, exact: np.ndarray) -> None:
    """Lines and points."""
    w = np.linspace(0.0, 1.5, 151)
    styles = {"Vermeulen-Johnson": "k--", "Kalker's line": "k-", "FASTSIM": "C0-."}
    for name, forces in lines(w).items():
        ax.plot(w, forces, styles[name], label=name)
    ax.plot(places, exact, "o", color="C3", fillstyle="none", label="exact theory")
    ax.set_xlabel("$w'$")
    ax.set_ylabel("$F_x / (f F_z)$")
    ax.set_title("Fig. 9: creep force")
    ax.set_xlim(0, 1.5)
    ax.set_ylim(0, 1.05)
    ax.legend()


def main(
    picture: str = "fig08_09_vermeulen_johnson.png", cells: int = 24, points: int = 8
) -> dict[str, float]:
    """Largest distances from the exact theory along the curve [f Fz], and parts of the contact that
    stick.
    """
    places = np.linspace(0.0, 1.4, points + 1)[1:]
    curve = vc.creep_curve(scene(cells, 1.0).second_order(), ["auto"], vx=-UNIT * places)
    exact = curve.Fx.values[0] / LIMIT
    numbers = {name: float(np.abs(forces - exact).max()) for name, forces in lines(places).items()}
    sol = vc.solve(scene(cells, SHOWN))
    force = lines(np.array([SHOWN]))["Kalker's line"][0]
    numbers["stick, exact"] = sol.areas["stick"] / sol.areas["contact"]
    numbers["stick, ellipse"] = stick_ellipse(force)[1] ** 2
    for name, value in numbers.items():
        print(f"{name:<20} {100 * value:5.1f} %")
    figure, axes = plt.subplots(1, 2, figsize=(11.5, 4.8), layout="constrained")
    draw_stick(axes[0], sol)
    draw_forces(axes[1], places, exact)
    figure.legend(
        *axes[0].get_legend_handles_labels(), ncols=4, loc="outside lower left", frameon=False
    )
    figure.savefig(picture, dpi=150)
    plt.close(figure)
    print(f"picture: {Path(picture).resolve()}")
    return numbers


if __name__ == "__main__":
    main(*sys.argv[1:2])
