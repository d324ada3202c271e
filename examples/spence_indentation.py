"""Spence's frictional indentation in three dimensions: the ratio of stick to contact radius does
not depend on load.

An elastic sphere (nu = 0.4) is pressed onto a rigid plane in steps of equal growth of the contact.
In every step the particles already in contact carry their tractions along. Spence's ratio neglects
what the tractions do to the pressure; the solution does not.

Run: python examples/spence_indentation.py [picture.png]
"""

import math
import sys

import matplotlib.pyplot as plt
import numpy as np

import varcontact as vc

BODIES = vc.Bodies(G=(1.0, math.inf), nu=(0.4, 0.4))
FRICTION = (0.08, 0.13, 0.2, 0.3)


def ratios(friction: float, cells: int, presses: int) -> tuple[np.ndarray, np.ndarray]:
    """Contact radius by that of the full load, and stick radius by contact radius, in every
    step.
    """
    full = vc.reference.hertz(1.0, 1.0, BODIES, force=1e-3)
    loads = [full.force * ((k + 1) / presses) ** 3 for k in range(presses)]
    half = 1.2 * full.a
    grid = vc.Grid(nx=cells, ny=cells, dx=2 * half / cells, dy=2 * half / cells, x0=-half, y0=-half)
    scene = vc.Scene(
        bodies=BODIES,
        surface=vc.Paraboloids(Rx=1.0, Ry=1.0),
        normal_force=full.force,
        friction=friction,
        motion=vc.Transient(steps=presses, dq=0.0, normal_force=loads),
        grid=grid,
    )
    history = vc.solve(scene, normal="norm", tangential="tang-safeguarded")
    contact = np.array([sol.areas["contact"] for sol in history])
    stick = np.array([sol.areas["stick"] for sol in history])
    return np.sqrt(contact / math.pi) / full.a, np.sqrt(stick / contact)


def main(
    picture: str = "spence_indentation.png", cells: int = 30, presses: int = 20
) -> dict[float, np.ndarray]:
    """Solve and draw; the ratios by friction in the steps of the upper half of the growth."""
    figure, ax = plt.subplots(figsize=(6.2, 4.6), layout="constrained")
    found = {}
    for friction in FRICTION:
        radius, ratio = ratios(friction, cells, presses)
        spence = vc.reference.spence_ratio(BODIES, friction)
        found[friction] = ratio[presses // 2 :]
        (line,) = ax.plot(radius, ratio, "o-", markersize=4, label=f"f = {friction:g}")
        ax.axhline(spence, color=line.get_color(), linewidth=0.8, linestyle="--")
        low, high = found[friction].min(), found[friction].max()
        print(f"f = {friction:g}: c/a from {low:.3f} to {high:.3f}, Spence {spence:.3f}")
    ax.set_xlabel("contact radius / that of the full load")
    ax.set_ylabel("stick radius / contact radius (dashed: Spence)")
    ax.set_ylim(0, 1.02)
    ax.legend(frameon=False)
    figure.savefig(picture, dpi=110)
    plt.close(figure)
    return found


if __name__ == "__main__":
    main(*sys.argv[1:2])
