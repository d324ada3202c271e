"""Friction that heats its surfaces, and falls with their temperature: creep forces of a wheel at 30
m/s.

Three laws: a constant coefficient, one that falls with the temperature of the surface, and that
times a film which thins out with the slip velocity, a function of our own. Hot friction caps the
force, and with it the temperature.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import varcontact as vc

SPEED = 3e4
STEEL = vc.Thermal(conductivity=50.0, density=7.85e-9, heat_capacity=4.5e8, temperature=20.0)
"""In N, mm, s and K."""


def film(slip_velocity):
    """From 1 in stick to 0.7, half of the way at 0.1 m/s."""
    return 0.7 + 0.3 / (1 + slip_velocity / 100.0)


HOT = vc.TemperatureFalling(static=0.4, kinetic=0.15, reference=20.0, over=500.0)
LAWS = {
    "constant": 0.4,
    "by temperature": HOT,
    "by temperature and slip": vc.FrictionLaw(0.4, 0.1, [HOT, film], velocity=SPEED),
}


def scene(friction, vx, cells):
    """A wheel on a rail that pulls with 100 kN on it, and the way behind their contact."""
    side = 16.0 / cells
    return vc.Scene(
        bodies=vc.Bodies(G=82e3, nu=0.28),
        surface=vc.Paraboloids(Rx=460.0, Ry=300.0),
        normal_force=1e5,
        friction=friction,
        thermal=STEEL,
        motion=vc.Steady(vx=-vx, speed=SPEED),
        grid=vc.Grid(nx=2 * cells, ny=cells, dx=side, dy=side, x0=-24.0, y0=-8.0),
        units=vc.MM_N,
    )


def main(picture="temperature.png", cells=36, points=14):
    """Forces and largest temperatures over the creepage; and the temperatures at the largest."""
    creepages = 0.03 * np.linspace(0.15, 1, points) ** 2
    solved = {
        name: [vc.solve(scene(law, vx, cells)) for vx in creepages] for name, law in LAWS.items()
    }
    for name, (*_, last) in solved.items():
        print(
            f"{name:24} Fx/Fz = {last.Fx / 1e5:.4f}, at most {last.temperature.max():.1f} degrees"
        )
    with plt.rc_context({"font.size": 9}):
        figure, (left, middle, right) = plt.subplots(1, 3, figsize=(13, 4), layout="constrained")
        for name, each in solved.items():
            left.plot(
                100 * creepages, [sol.Fx / sol.normal_force for sol in each], ".-", label=name
            )
            middle.plot(100 * creepages, [sol.temperature.max() for sol in each], ".-", label=name)
        left.set(xlabel="creepage [%]", ylabel="$F_x/F_z$", title="Creep force", ylim=(0, None))
        middle.set(
            xlabel="creepage [%]", ylabel="degrees", title="Largest temperature", ylim=(0, None)
        )
        left.legend()
        solved["by temperature"][-1].plot("temperature", ax=right)
        figure.savefig(picture, dpi=150)
    plt.close(figure)
    return creepages, solved


if __name__ == "__main__":
    main(*sys.argv[1:])
