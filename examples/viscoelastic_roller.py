"""Rolling resistance of viscoelastic rollers over the speed: a maximum where the contact is rolled in the relaxation time.

Two like rollers of a standard linear solid in line contact, without friction and with a traction of 60 % of the friction
limit. Slow rolling is elastic with the relaxed modulus, fast rolling with the glassy one; both lose nothing. Hunter's
closed form (1961) is the dashed line.

Run: python examples/viscoelastic_roller.py [picture.png]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import varcontact as vc

G, NU, PART, TAU, R, FORCE = 1.0, 0.3, 1.0, 1.0, 1.0, 0.05
SOLID = vc.Viscoelastic(G, NU, [(PART, TAU)])


def resistance(speed: float, traction: float, cells: int) -> float:
    """Rolling resistance by load."""
    scene = vc.Scene(
        bodies=SOLID,
        surface=vc.Cylinders(R=R),
        normal_force=FORCE,
        friction=0.3,
        motion=vc.Steady(Fx=-0.3 * FORCE * traction, speed=speed),
        grid=vc.Grid(nx=cells),
    )
    return vc.solve(scene).rolling_resistance / FORCE


def by_hunter(speed: float) -> float:
    """The same in closed form, for the half length that bears the load."""

    def solution(a: float) -> vc.reference.Hunter:
        return vc.reference.hunter(a, R, G, NU, PART, speed * TAU)

    a = brentq(lambda a: solution(a).force - FORCE, 1e-3, 10.0)
    return solution(a).moment / (R * FORCE)


def main(picture: str = "viscoelastic_roller.png", cells: int = 120, speeds: int = 25) -> tuple[np.ndarray, np.ndarray]:
    """Solve and draw; the resistance without traction, and Hunter's."""
    rolled = np.geomspace(1e-3, 1e2, speeds)
    free, pulled = ([resistance(v, part, cells) for v in rolled] for part in (0.0, 0.6))
    exact = [by_hunter(v) for v in rolled]
    figure, ax = plt.subplots(figsize=(6.2, 4.2), layout="constrained")
    ax.semilogx(rolled, free, "o", markersize=4, label="no traction")
    ax.semilogx(rolled, pulled, "x", markersize=5, label="traction of 60 % of the friction limit")
    ax.semilogx(rolled, exact, "k--", linewidth=0.8, label="Hunter (1961)")
    ax.set_xlabel("speed times relaxation time by radius")
    ax.set_ylabel("rolling resistance by load")
    ax.set_ylim(0)
    ax.legend(frameon=False)
    figure.savefig(picture, dpi=110)
    plt.close(figure)
    peak = int(np.argmax(exact))
    print(f"largest at {rolled[peak]:.3g}: {free[peak]:.5f} by solving, {exact[peak]:.5f} by Hunter")
    return np.array(free), np.array(exact)


if __name__ == "__main__":
    main(*sys.argv[1:2])
