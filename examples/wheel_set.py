"""A wheel set on straight track: contacts and forces over its displacement, and the speed above
which it hunts.

First part: the Manchester benchmark's case A (Shackleton and Iwnicki 2008), S1002 wheels on 60E1
rails inclined 1:40, 20 kN. The set is displaced by 0 to 10 mm, and yawed in proportion up to 24
mrad. Forces are the exact ones and those of the fast way, virtual penetration with FASTSIM.

Second part: the same set with 100 kN, elastically held by a frame that moves at a constant speed.
The contacts are tabulated, and lateral displacement and yaw follow from

    m y'' = Fy - k y,    I yaw'' = Mz - c yaw,

with force and moment of the rails. Below the critical speed of the linearised equations a
displacement dies away; above it the set hunts: Klingel's motion, of some 9 m, grows until it comes
to the flanges.

Lengths in mm, forces in N, masses in t. Run: python examples/wheel_set.py [folder]
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from varcontact.wheel_rail import (
    Position,
    Profile,
    Track,
    Velocity,
    WheelOnRail,
    WheelSet,
    geometry_table,
)

TRACK = Track(rail=Profile.rail_60e1(), cant=1 / 40)
WHEELSET = WheelSet(wheel=Profile.s1002())
YAW = 24e-3 / 10.0  # by lateral displacement [rad/mm]
MASS, INERTIA = 1.8, 1.0e6  # t, t mm^2
LATERAL, TURNING = 400.0, 1.0e9  # N/mm, N mm
LOAD = 50e3  # on each wheel
START = 1.5  # mm


def wheel(side: str, y: float) -> WheelOnRail:
    """One wheel of case A."""
    position = Position(y=y, yaw=YAW * y)
    return WheelOnRail(
        track=TRACK,
        wheelset=WHEELSET,
        side=side,
        position=position,
        velocity=Velocity(speed=2e3),
        vertical_force=10e3,
        dx=0.5,
        dy=0.2,  # the flange's patches are 1 mm wide
    )


def case_a(picture: Path, exact_at: np.ndarray, fast_at: np.ndarray) -> dict[str, np.ndarray]:
    """Draw contact points, creepages and forces; return (Fx, Fs) by both ways where the exact ones
    are.
    """
    names = ("Contact on the rail, y [mm]", "Contact angle [mrad]", "Longitudinal creepage [10⁻³]")
    names += ("Longitudinal force [kN]", "Lateral force [kN]", "Rolling radius, right - left [mm]")
    figure, axes = plt.subplots(2, 3, figsize=(11, 6.5), layout="constrained")
    panels = dict(zip(names, axes.flat, strict=True))
    compared, radii = {}, {}
    for side, colour in (("left", "C0"), ("right", "C1")):
        fast = [wheel(side, y).estimate() for y in fast_at]
        main = [max(each.patches, key=lambda patch: patch.force[2]) for each in fast]
        exact = [wheel(side, y).solve() for y in exact_at]
        bearing = [max(each.patches, key=lambda patch: patch.normal_force) for each in exact]
        radii[side] = [
            np.array([each.rolling_radius for each in main]),
            np.array([each.patch.rolling_radius for each in bearing]),
        ]
        lines = [
            [TRACK.on_rail(each.frame.origin[1:], side)[0] for each in main],
            [1e3 * each.angle for each in main],
            [1e3 * each.creepage.vx for each in main],
            [each.force[0] / 1e3 for each in main],
            [each.force[1] / 1e3 for each in main],
        ]
        points = [
            [each.patch.on_rail[0] for each in bearing],
            [1e3 * each.patch.angle for each in bearing],
            [1e3 * each.patch.creepage.vx for each in bearing],
            [each.force[0] / 1e3 for each in bearing],
            [each.force[1] / 1e3 for each in bearing],
        ]
        for name, line, dots in zip(names, lines, points, strict=False):
            panels[name].plot(fast_at, line, colour, label=f"{side} wheel, fast")
            panels[name].plot(
                exact_at, dots, "o", color=colour, markersize=4, label=f"{side} wheel, exact"
            )
        both = np.array(
            [
                [each.force[:2] for each in bearing],
                [main[np.abs(fast_at - y).argmin()].force[:2] for y in exact_at],
            ]
        )
        compared[side] = np.hypot(*(both[0] - both[1]).T) / (
            0.3 * np.array([each.normal_force for each in bearing])
        )
    difference = [right - left for left, right in zip(radii["left"], radii["right"], strict=True)]
    panels[names[5]].plot(fast_at, difference[0], "k")
    panels[names[5]].plot(exact_at, difference[1], "ko", markersize=4)
    for name, ax in panels.items():
        ax.set(ylabel=name, xlabel="Lateral displacement [mm]")
    handles, labels = panels[names[0]].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    figure.savefig(picture, dpi=150)
    return compared


class Hunting:
    """The nonlinear wheel set between its springs."""

    def __init__(self, reach: float = 8.0, nodes: int = 33) -> None:
        y = np.linspace(-reach, reach, nodes)
        self.table = geometry_table(
            TRACK, WHEELSET, y=y, yaw=[-0.012, 0.0, 0.012], vertical_force=LOAD
        )

    def rates(self, speed: float, state: np.ndarray) -> np.ndarray:
        """Of displacement, yaw and their velocities."""
        y, yaw, lateral, yaw_rate = state
        found = self.table.forces(y, yaw, Velocity(speed=speed, lateral=lateral, yaw_rate=yaw_rate))
        pushed, turned = found.force[1] - LATERAL * y, found.moment[2] - TURNING * yaw
        return np.array([lateral, yaw_rate, pushed / MASS, turned / INERTIA])

    def growth(self, speed: float) -> float:
        """The largest real part of the eigenvalues of the linearised equations [1/s]."""
        steps = np.array([0.5, 2e-4, 2e-4 * speed, 2e-4 * speed / 750.0])
        columns = [
            (self.rates(speed, step) - self.rates(speed, -step)) / (2 * step.sum())
            for step in np.diag(steps)
        ]
        return float(np.linalg.eigvals(np.array(columns).T).real.max())

    def critical_speed(self) -> float:
        """Where it changes its sign [mm/s]."""
        return float(brentq(self.growth, 5e3, 150e3, rtol=1e-4))

    def motion(self, speed: float, distance: float) -> np.ndarray:
        """Distance [m] and displacement [mm], from a small displacement."""
        times = np.linspace(0.0, distance / speed, 400)
        start = np.array([START, 0.0, 0.0, 0.0])
        found = solve_ivp(
            lambda _, s: self.rates(speed, s),
            times[[0, -1]],
            start,
            t_eval=times,
            rtol=1e-3,
            atol=1e-5,
        )
        return np.array([found.t * speed / 1e3, found.y[0]])


def main(
    folder: str = ".", exact_at: tuple[float, ...] = (0, 2, 4, 6, 8, 10), distance: float = 200e3
) -> dict[str, float]:
    """Draw both pictures and print the numbers."""
    compared = case_a(
        Path(folder) / "case_a.png", np.array(exact_at, dtype=float), np.arange(0.0, 10.1, 0.5)
    )
    hunting = Hunting()
    critical = hunting.critical_speed()
    figure, ax = plt.subplots(figsize=(8, 4), layout="constrained")
    reached, waves = {}, 0.0
    for part in (0.8, 1.2):
        along, y = hunting.motion(part * critical, distance)
        reached[part] = float(np.abs(y[-100:]).max())
        crossed = along[1:][(y[1:] > 0) & (y[:-1] <= 0)]
        waves = float(np.diff(crossed).mean())
        ax.plot(
            along,
            y,
            label=f"{part * critical * 3.6e-3:.0f} km/h, {part:g} times the critical speed",
        )
    ax.set(xlabel="Distance [m]", ylabel="Lateral displacement [mm]")
    figure.legend(loc="outside lower center", ncols=2, frameon=False)
    figure.savefig(Path(folder) / "hunting.png", dpi=150)
    numbers = {
        "fast against exact forces, largest, by f Fn": float(
            max(each.max() for each in compared.values())
        ),
        "critical speed [km/h]": critical * 3.6e-3,
        "wavelength at 1.2 of it [m]": waves,
        "displacement at 0.8 of it, end [mm]": reached[0.8],
        "displacement at 1.2 of it, end [mm]": reached[1.2],
    }
    for name, value in numbers.items():
        print(f"{name:45} {value:8.3f}")
    return numbers


if __name__ == "__main__":
    main(*sys.argv[1:2])
