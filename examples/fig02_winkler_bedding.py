"""Kalker's Fig. 2: compression of a Winkler bedding, in normal contact.

Two flat plates carry springs side by side, of the compliance k on each. Where the undeformed
distance h less the approach is negative the springs touch: the deformed distance e is zero and the
pressure is -h/(2k). Elsewhere e = h and nothing presses. Each spring feels its own pressure alone;
half-spaces of the same modulus, at the same approach, touch in smaller areas, as pressures beside
a place push it away too.

Lengths in units of the width shown. Run: python examples/fig02_winkler_bedding.py [picture.png]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import varcontact as vc

BED = vc.Winkler(h=0.2, E=1.0, G=1.0)
COMPLIANCE = BED.h / BED.E  # k of each plate
APPROACH = 0.03
CELLS = 120


def profile(x: np.ndarray) -> np.ndarray:
    """Undeformed distance: two humps of the upper plate, one lower than the other."""
    return 0.02 + 0.02 * np.cos(4 * np.pi * x) + 0.012 * np.sin(2 * np.pi * x)


def pressed(bodies: object, depth: float | None = None) -> vc.Solution:
    """The plates at the approach; half-spaces need a depth from which it counts."""
    grid = vc.Grid(nx=CELLS, dx=1 / CELLS, x0=-0.5)
    surface = vc.SampledDistance(profile(grid.x), reference_depth=depth)
    return vc.solve(vc.Scene(bodies=bodies, surface=surface, approach=APPROACH, grid=grid))


def draw_plates(ax: Axes, sol: vc.Solution) -> None:
    """Both surfaces before (dashed) and after, with springs."""
    x = sol.grid.x
    before = profile(x) - APPROACH
    shift = COMPLIANCE * sol.pressure[0]
    for side, colour in ((1, "C0"), (-1, "C1")):
        rest = np.where(side > 0, before, 0.0)
        ax.plot(x, rest, "--", color=colour, linewidth=1)
        ax.plot(x, rest + side * shift, color=colour, linewidth=2)
        for k in range(2, CELLS, 5):
            ends = [side * 0.06 - 0.01, rest[k] + side * shift[k]]
            ax.plot([x[k], x[k]], ends, color=colour, linewidth=0.6, alpha=0.6)
    ax.set_ylabel("height")
    ax.set_title("Surfaces before (dashed) and after compression, with springs")


def draw_pressures(ax: Axes, bedding: vc.Solution, halfspaces: vc.Solution) -> None:
    """Pressures and deformed distance."""
    x = bedding.grid.x
    ax.plot(x, bedding.pressure[0], "C3", label="pressure, Winkler bedding")
    ax.plot(x, halfspaces.pressure[0], "C3:", label="pressure, half-spaces")
    ax.plot(x, bedding.distance[0], "k", linewidth=1, label="deformed distance e")
    ax.set_xlabel("x")
    ax.legend()


def main(picture: str = "fig02_winkler_bedding.png") -> dict[str, vc.Solution]:
    """Both bodies at the same approach, and the picture."""
    found = {
        "Winkler bedding": pressed(BED),
        "half-spaces": pressed(vc.Bodies(G=0.5, nu=0.0), depth=1.0),
    }
    for name, sol in found.items():
        print(
            f"{name:<16} touch on {100 * np.mean(sol.pressure > 0):.0f} % of the width, "
            f"peak pressure {sol.max_pressure:.4f}"
        )
    figure, axes = plt.subplots(2, sharex=True, figsize=(7.5, 6.5), layout="constrained")
    draw_plates(axes[0], found["Winkler bedding"])
    draw_pressures(axes[1], *found.values())
    figure.savefig(picture, dpi=130)
    plt.close(figure)
    print(f"picture: {Path(picture).resolve()}")
    return found


if __name__ == "__main__":
    main(*sys.argv[1:2])
