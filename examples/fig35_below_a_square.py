"""Kalker's Fig. 35: stresses on the axis below a uniformly loaded square, by pressure and by a
traction along a side.

Ideal stress sigma_I = sqrt(s_ij s_ij) and first invariant -sigma_ii; nu = 0.28, unit tractions,
depths in side lengths. The paper reads off: the largest sigma_I is 0.55, at a depth of about 0.4;
-sigma_ii = 2.6 on the surface; the curves meet at 1.40. By the traction sigma_I = 1.42 on the
surface, and virtually nothing at 1.67. All of this comes out but for the meeting point: at 1.40 the
curves are 0.014 apart, half a percent of the figure's height, and they cross at 2.92. The crossing
is badly conditioned, as far away both fall like 1/z^2 and differ by 3 %: with nu = 0.2 it is at
1.32, with nu = 0.3 there is none.

Run: python examples/fig35_below_a_square.py [picture.png]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import varcontact as vc
from varcontact.elasticity.subsurface import field_at

NU = 0.28
SQUARE = vc.Grid(nx=1, ny=1, dx=1.0, dy=1.0, x0=-0.5, y0=-0.5)
DEPTHS = np.linspace(0.0, 4.0, 4001)
PRESSURE, TRACTION = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)


def on_the_axis(load: tuple[float, float, float]) -> vc.SubsurfaceStress:
    """The field on the axis below the square under a uniform load."""
    points = np.array([0 * DEPTHS, 0 * DEPTHS, DEPTHS])
    field = field_at(points, SQUARE, np.reshape(load, (3, 1, 1)), G=1.0, nu=NU)
    return vc.SubsurfaceStress(1, points, field.displacement, field.gradient, field.stress)


def main(picture: str = "fig35_below_a_square.png") -> dict[str, float]:
    """The paper's numbers, and the picture."""
    pressed, sheared = on_the_axis(PRESSURE), on_the_axis(TRACTION)
    ideal, invariant = pressed.ideal_stress, -pressed.first_invariant
    crossing = np.flatnonzero(np.diff(np.sign(invariant - ideal)))[0]
    numbers = {
        "sigma_I, largest (0.55)": ideal.max(),
        "at the depth (0.4)": DEPTHS[ideal.argmax()],
        "-sigma_ii on the surface (2.6)": invariant[0],
        "-sigma_ii less sigma_I at 1.40 (0)": np.interp(1.40, DEPTHS, invariant - ideal),
        "they cross at (1.40)": DEPTHS[crossing],
        "by traction: sigma_I on the surface (1.42)": sheared.ideal_stress[0],
        "by traction: sigma_I at 1.67 (0)": np.interp(1.67, DEPTHS, sheared.ideal_stress),
        "by traction: largest sigma_ii (0)": np.abs(sheared.first_invariant).max(),
    }
    for name, value in numbers.items():
        print(f"{name:<45}{value:8.4f}")

    figure, ax = plt.subplots(figsize=(6.4, 5.2), layout="constrained")
    ax.plot(DEPTHS, ideal, "k", label=r"pressure: $\sigma_I$")
    ax.plot(DEPTHS, invariant, "k", linewidth=2.2, label=r"pressure: $-\sigma_{ii}$")
    ax.plot(DEPTHS, sheared.ideal_stress, "k--", label=r"traction along a side: $\sigma_I$")
    ax.set_xlabel("depth below the centre, in side lengths")
    ax.set_ylabel("stress / uniform traction")
    ax.set_xlim(0, 4)
    ax.set_ylim(0, 2.7)
    ax.set_title(r"Below a uniformly loaded square, $\nu$ = 0.28")
    ax.legend(frameon=False)
    figure.savefig(picture, dpi=150)
    plt.close(figure)
    print(f"picture: {Path(picture).resolve()}")
    return numbers


if __name__ == "__main__":
    main(*sys.argv[1:2])
