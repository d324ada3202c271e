"""A measured creep curve is explained by a third body and a law of friction, fitted by gradients.

The points are taken from lines of regression through 4200 samples of the roller rig of Virginia
Tech and the FRA, dry, with wear debris (N. S. M. Hosseini, A Statistical Approach to Modeling
Wheel-Rail Contact Dynamics, MSc thesis, Virginia Tech, 2020); samples scatter about the lines by
219 N. Bodies alone are too stiff for them. With an elastic layer of debris the curve is within the
scatter. A law by which friction falls with slip, with its kinetic coefficient fitted, comes no
nearer. Each curve comes with its derivatives by all parameters, so that a step of the fit takes one
curve.

Lengths in m, forces in N. Run: python examples/fitted_creep_curve.py [picture.png]
"""

import sys
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import varcontact as vc

VX = np.array([1, 2, 3, 4, 5, 7, 9, 11, 13, 15, 17, 19]) * 1e-3
FORCE = -np.array([735, 1352, 1969, 2586, 3203, 4011, 4184, 4357, 4529, 4702, 4875, 5047.0])
SCATTER = 219.1
LOAD = 9.3e3
STATIC = 0.55
LAYER = (1e-5, 1e-7, 1e-3)  # first guess, least and largest thickness
SLOW = 5e-3  # relative slip that loses half of the excess


def rig(cells: int) -> vc.Scene:
    """A wheel of 116.5 mm radius on a roller of 506.23 mm, of steel."""
    return vc.Scene(
        bodies=vc.Bodies(G=205e9 / 2.58, nu=0.29),
        surface=vc.Paraboloids(Rx=1 / (1 / 0.1165 + 1 / 0.50623), Ry=0.29),
        normal_force=LOAD,
        friction=0.5,
        motion=vc.Steady(),
        grid=vc.Grid(nx=cells, ny=cells),
        units=vc.SI,
    )


def main(
    picture: str = "fitted_creep_curve.png", cells: int = 10, points: int = VX.size
) -> dict[str, vc.CreepCurveFit]:
    """The fits by name, to a number of the points."""
    bare = rig(cells)
    layered = replace(bare, third_body=vc.ThirdBody(h=LAYER[0], G=1e9))
    law = vc.RationalFalling(STATIC, 0.5, half_velocity=SLOW)
    coefficient = {"friction": (0.5, 0.1, 1.0)}
    models = {
        "bodies alone": (bare, coefficient),
        "elastic layer": (layered, coefficient | {"third_body.h": LAYER}),
        "layer, falling friction": (
            replace(layered, friction=law),
            {"friction.kinetic": (0.45, 0.1, STATIC), "third_body.h": LAYER},
        ),
    }
    used = np.linspace(0, VX.size - 1, points).round().astype(int)
    fits = {}
    for name, (scene, parameters) in models.items():
        curves: list[str] = []
        fits[name] = vc.fit_creep_curve(
            scene, parameters, vx=VX[used], Fx=FORCE[used], sigma=SCATTER, progress=curves.append
        )
        print(f"{name}, {len(curves)} curves:", *fits[name].report().splitlines(), sep="\n  ")

    figure, axis = plt.subplots(figsize=(6.4, 4.2), layout="constrained")
    axis.errorbar(1e3 * VX, -FORCE / 1e3, SCATTER / 1e3, fmt="k.", label="measured, with scatter")
    for name, fit in fits.items():
        axis.plot(1e3 * VX[used], -fit.curve.Fx[0] / 1e3, label=name)
    axis.set(xlabel="creepage [10⁻³]", ylabel="force [kN]", ylim=(0, None))
    axis.legend()
    figure.savefig(picture, dpi=150)
    return fits


if __name__ == "__main__":
    main(*sys.argv[1:])
