"""A pin in a hole: the contact goes round with the load, up to 84.8 degrees either way.

The third class of contact areas in section 1.3 of the paper, curved along the rolling direction. A
steel pin of radius 10 mm lies in a hole with 5 micrometres of clearance. Left: pressures around the
pin under growing loads, and Persson's closed form (dots). Middle: angle of the contact by load;
half-spaces with the combined radius (Hertz) overrate it, as the hole closes in on the pin. Right:
tractions of a pin that turns in its hole and slips: pressures move to the side that the pin climbs.

Lengths in mm, forces in N. Run: python examples/pin_in_hole.py [picture.png]
"""

import sys
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import varcontact as vc
from varcontact.plotting.style import legend_below
from varcontact.reference import line_contact, pin_in_hole

STEEL = vc.Bodies(G=80e3, nu=0.3)
RADIUS = 10.0
CLEARANCE = 5e-3
LOADS = (100.0, 300.0, 1000.0, 3000.0)  # per millimetre of width
FRICTION = 0.2


def scene(force: float) -> vc.Scene:
    """The pin under a load, without friction."""
    surface = vc.PinInHole(R=RADIUS, clearance=CLEARANCE)
    return vc.Scene(bodies=STEEL, surface=surface, normal_force=force, units=vc.MM_N)


def degrees(sol: vc.Solution) -> float:
    """Angle of a contact either way, half of that of its elements."""
    return float(np.degrees(np.count_nonzero(sol.pressure) * sol.grid.dx / 2 / RADIUS))


def turning(force: float) -> vc.Solution:
    """The same pin as it turns in the hole at rest: all slips."""
    grid = vc.Grid(nx=120, dx=2.4 * RADIUS / 120, x0=-1.2 * RADIUS)
    motion = vc.Steady(vx=0.1)
    return vc.solve(replace(scene(force), friction=FRICTION, motion=motion, grid=grid))


def main(picture: str | None = None) -> dict[float, vc.Solution]:
    """Pressures under several loads, and a pin that turns."""
    sols = {force: vc.solve(scene(force), accuracy=1e-3) for force in LOADS}
    for force, sol in sols.items():
        persson = pin_in_hole(RADIUS, CLEARANCE, STEEL, force=force)
        print(
            f"{force:.0f} N/mm: {degrees(sol):.1f} degrees, {sol.max_pressure:.2f} N/mm2; "
            f"Persson {np.degrees(persson.half_angle):.1f}, {persson.peak_pressure:.2f}"
        )
    slipping = turning(LOADS[2])
    print(f"turning under {LOADS[2]:.0f} N/mm: largest pressure {slipping.max_pressure:.1f} N/mm2")
    draw(sols, slipping, picture)
    return {**sols, 0.0: slipping}


def draw(sols: dict[float, vc.Solution], slipping: vc.Solution, picture: str | None) -> None:
    """Pressures by angle, angles by load, tractions of the pin that turns."""
    figure, axes = plt.subplots(1, 3, figsize=(10, 4.2), layout="constrained")
    for force, sol in sols.items():
        persson = pin_in_hole(RADIUS, CLEARANCE, STEEL, force=force)
        angles = sol.grid.x / RADIUS
        axes[0].plot(np.degrees(angles), sol.pressure[0], label=f"{force:.0f} N/mm")
        some = np.linspace(-0.95, 0.95, 9) * persson.half_angle
        axes[0].plot(np.degrees(some), persson.pressure(some), "k.", markersize=4)
    axes[0].set(xlabel="angle [degrees]", ylabel="pressure [N/mm2]", title="no friction")
    legend_below(axes[0], columns=2)
    forces = np.geomspace(20.0, 2e4, 60)
    exact = [pin_in_hole(RADIUS, CLEARANCE, STEEL, force=each).half_angle for each in forces]
    combined = RADIUS * (RADIUS + CLEARANCE) / CLEARANCE
    hertz = [line_contact(combined, STEEL, force=each).a / RADIUS for each in forces]
    axes[1].semilogx(forces, np.degrees(exact), label="Persson")
    axes[1].semilogx(forces, np.degrees(hertz), "--", label="half-spaces")
    axes[1].plot(list(sols), [degrees(each) for each in sols.values()], "k.", label="here")
    axes[1].set(xlabel="load [N/mm]", ylabel="half angle [degrees]", ylim=(0, 95))
    axes[1].set_title("angle of the contact")
    legend_below(axes[1], columns=3)
    angles = np.degrees(slipping.grid.x / RADIUS)
    axes[2].plot(angles, slipping.pressure[0], label="pressure")
    axes[2].plot(angles, slipping.traction[0, 0], label="traction")
    axes[2].set(xlabel="angle [degrees]", title=f"turning, friction {FRICTION:g}")
    legend_below(axes[2], columns=2)
    if picture:
        figure.savefig(picture)
    else:
        plt.show()
    plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:2])
