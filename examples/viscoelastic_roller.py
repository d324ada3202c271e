"""Rolling resistance of viscoelastic rollers over the speed: a maximum about where contacts last a
relaxation time.

Two like rollers of a standard linear solid in line contact: with one relaxation, for which Hunter's
closed form (1961) is the dashed line, and with two. Slow rolling is elastic with the relaxed
modulus, fast rolling with the glassy one; both lose nothing.

Run: python examples/viscoelastic_roller.py [picture.png]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import varcontact as vc

G, NU, PART, TAU, R, FORCE = 1.0, 0.3, 1.0, 1.0, 1.0, 0.05
ONE = vc.Viscoelastic(G, NU, [(PART, TAU)])
TWO = vc.Viscoelastic(G, NU, [(PART / 2, TAU / 10), (PART / 2, 10 * TAU)])


def resistance(solid: vc.Viscoelastic, speed: float, cells: int) -> float:
    """Rolling resistance by load."""
    scene = vc.Scene(
        bodies=solid,
        surface=vc.Cylinders(R=R),
        normal_force=FORCE,
        friction=0.0,
        motion=vc.Steady(speed=speed),
        grid=vc.Grid(nx=cells),
    )
    return vc.solve(scene).rolling_resistance / FORCE


def by_hunter(speed: float) -> float:
    """The same in closed form, for the half length that bears the load."""

    def solution(a: float) -> vc.reference.Hunter:
        return vc.reference.hunter(a, R, G, NU, PART, speed * TAU)

    a = brentq(lambda a: solution(a).force - FORCE, 1e-3, 10.0)
    return solution(a).moment / (R * FORCE)


def main(
    picture: str = "viscoelastic_roller.png", cells: int = 120, speeds: int = 25
) -> tuple[np.ndarray, np.ndarray]:
    """Solve and draw; the resistance with one relaxation, and Hunter's."""
    rolled = np.geomspace(1e-3, 1e2, speeds)
    one, two = ([resistance(solid, v, cells) for v in rolled] for solid in (ONE, TWO))
    exact = [by_hunter(v) for v in rolled]
    figure, ax = plt.subplots(figsize=(6.2, 4.2), layout="constrained")
    ax.semilogx(rolled, one, "o", markersize=4, label="one relaxation time")
    ax.semilogx(rolled, exact, "k--", linewidth=0.8, label="the same by Hunter (1961)")
    ax.semilogx(
        rolled, two, "s-", markersize=4, linewidth=0.8, label="two, a tenth and ten times as long"
    )
    ax.set_xlabel("speed x relaxation time / radius")
    ax.set_ylabel("rolling resistance / load")
    ax.set_ylim(0, 1.35 * max(exact))
    ax.legend(frameon=False, loc="upper right")
    figure.savefig(picture, dpi=110)
    plt.close(figure)
    peak = int(np.argmax(exact))
    print(f"largest at {rolled[peak]:.3g}: {one[peak]:.5f} by solving, {exact[peak]:.5f} by Hunter")
    return np.array(one), np.array(exact)


if __name__ == "__main__":
    main(*sys.argv[1:2])
