"""Kalker's Figs. 36 and 37: spheres begin to roll, after a shift (like ones) and after compression (unlike ones).

Fig. 36: two spheres with R = 337.5, G = 1, nu = 0.28, Fz = 0.4705, contact radius 3.5, f = 0.4013; Cattaneo's shift by
Fx = -0.657 f Fz (stick radius 0.7 a = 2.45), then rolling under it in steps of 0.5; elements of side 1, 9 x 9 of them.
Fig. 37: a sphere with R = 243, G = 2, nu = 0 on a rigid slab, f = 0.4013, pressed until the contact radius is 3.5
(Spence's compression), then rolled without creepage in steps of 0.2; steady after almost two contact widths.
`cells` elements are as long as one of the paper's.

Run: python examples/fig36_37_rolling_spheres.py [picture.png]
"""

import math
import sys
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import varcontact as vc
from varcontact.plotting.solution import draw_areas

RADIUS, FRICTION = 3.5, 0.4013
LIKE = vc.Bodies(G=1.0, nu=0.28)
ON_RIGID = vc.Bodies(G=(2.0, math.inf), nu=(0.0, 0.0))
SHOWN = {"like": (0, 1, 3, 5, 7), "unlike": (0, 1, 3, 5, 13)}


def square(cells: int) -> vc.Grid:
    """9 x 9 of the paper's elements, each divided."""
    n = 9 * cells
    return vc.Grid(nx=n, ny=n, dx=9 / n, dy=9 / n, x0=-4.5, y0=-4.5)


def like_spheres(cells: int) -> vc.History:
    """Fig. 36: the shift, and 7 units of rolling in steps of 0.5."""
    load = 0.470508  # (7/9)^3, rounded by the paper to 0.4705
    motion = vc.Transient(steps=15, dq=[0.0] + [0.5] * 14, Fx=-0.657 * FRICTION * load)
    scene = vc.Scene(
        bodies=LIKE,
        surface=vc.Paraboloids(Rx=337.5 / 2, Ry=337.5 / 2),
        normal_force=load,
        friction=FRICTION,
        motion=motion,
        grid=square(cells),
    )
    return vc.solve(scene, tangential="tang-safeguarded")


def unlike_spheres(cells: int, presses: int = 7) -> vc.History:
    """Fig. 37: pressed in steps of equal growth of the contact, then 13 units of rolling in steps of 0.2."""
    load = (RADIUS / vc.reference.hertz(243.0, 243.0, ON_RIGID, force=1.0).a) ** 3
    loads = [load * ((k + 1) / presses) ** 3 for k in range(presses)] + [load] * 65
    motion = vc.Transient(steps=presses + 65, dq=[0.0] * presses + [0.2] * 65, normal_force=loads)
    scene = vc.Scene(
        bodies=ON_RIGID,
        surface=vc.Paraboloids(Rx=243.0, Ry=243.0),
        normal_force=load,
        friction=FRICTION,
        motion=motion,
        grid=square(cells),
    )
    return vc.solve(scene, normal="norm", tangential="tang-safeguarded")


def draw(axes: list[Axes], history: vc.History, distances: tuple[int, ...]) -> None:
    """Tractions over stick and slip areas after so much rolling."""
    for ax, distance in zip(axes, distances, strict=True):
        sol = history[int(np.flatnonzero(np.isclose(history.rolled, distance))[-1])]
        draw_areas(ax, sol)
        ax.set_title(f"Vt = {distance}, $F_x$ = {sol.force[0]:.3f}")


def off(one: vc.Solution, other: vc.Solution) -> float:
    """Mean difference of tractions by the mean traction bound."""
    return float(np.hypot(*(one.traction - other.traction)).sum() / one.traction_bound.sum())


def main(picture: str = "fig36_37_rolling_spheres.png", cells: int = 2) -> dict[str, float]:
    """Solve and draw both; the paper's numbers."""
    like, unlike = like_spheres(cells), unlike_spheres(cells)
    methods = {"tangential": "tang-safeguarded"}
    carter = vc.solve(replace(like.scene, motion=vc.Steady(Fx=like.force[0, 0], dq=0.5)), **methods)
    steady = vc.solve(replace(unlike.scene, motion=vc.Steady(dq=0.2)), normal="norm", **methods)
    first = like[0]
    numbers = {
        "Fig. 36, Fz (0.4705)": first.normal_force,
        "Fig. 36, Fx (-0.1240)": float(first.force[0]),
        "Fig. 36, contact radius (3.5)": first.scene.hertz.a,
        "Fig. 36, stick radius of the shift (2.45)": math.sqrt(first.areas["stick"] / math.pi),
        "Fig. 36, Vt = 7 off the steady state (0)": off(like[-1], carter),
        "Fig. 37, Vt = 13 off the steady state (0)": off(unlike[-1], steady),
        "Fig. 37, Vt = 0 off the steady state": off(unlike[6], steady),
    }
    for name, value in numbers.items():
        print(f"{name:<45}{value:8.4f}")
    figure, axes = plt.subplots(2, 5, figsize=(20, 9.6), layout="constrained")
    draw(list(axes[0]), like, SHOWN["like"])
    draw(list(axes[1]), unlike, SHOWN["unlike"])
    figure.savefig(picture, dpi=80)
    plt.close(figure)
    return numbers


if __name__ == "__main__":
    main(*sys.argv[1:2])
