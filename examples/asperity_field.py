"""Asperities roll over asperities: twenty at a time in the contact, in steady rolling and in time.

Nielsen's problem (paper, section 7, 6), for like bodies. Left: a turned roller has twenty ridges
around its circumference, which touch side by side; the pattern stands still, so that rolling is
steady. Each ridge has a leading edge, a stick area behind it and slip at the rear. Middle: two
rollers in line contact carry an asperity field each, under a constant load and a constant creep
force, half of what friction carries. Pressures move with the asperities. Right: the creepage
swings about that of smooth rollers, which is Carter's.

Lengths in mm, forces in N. Run: python examples/asperity_field.py [picture.png]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import varcontact as vc
from varcontact.plotting.fields import draw_areas
from varcontact.plotting.style import legend_below

BODIES = vc.Bodies(G=82e3, nu=0.28)
RADIUS, CROWN = 50.0, 200.0  # of the rollers, along and across
HALF_LENGTH, FRICTION = 2.0, 0.3
SMOOTH = vc.reference.line_contact(RADIUS, BODIES, a=HALF_LENGTH)
CARTER = vc.reference.carter(SMOOTH, FRICTION, force=0.5 * FRICTION * SMOOTH.force)
ASPERITIES = 20
SPACING = 2 * HALF_LENGTH / ASPERITIES
PERIOD = ASPERITIES * SPACING
HEIGHT = 1.5e-3  # of an asperity in the mean


def field(x: np.ndarray, seed: int) -> np.ndarray:
    """Heights of twenty asperities of a body, at random about equal places, with a period."""
    rng = np.random.default_rng(seed)
    places = SPACING * (np.arange(ASPERITIES) + rng.uniform(-0.2, 0.2, ASPERITIES))
    heights = HEIGHT * rng.uniform(0.7, 1.3, ASPERITIES)
    away = (x - places[:, None] + PERIOD / 2) % PERIOD - PERIOD / 2
    caps = np.maximum(np.cos(np.pi * away / SPACING), 0.0) * (np.abs(away) < SPACING / 2)
    return heights @ caps**2


def carried(dx: float) -> vc.Carried:
    """Both fields: bodies that roll over the same distance carry the sum."""
    x = dx * np.arange(round(PERIOD / dx))
    return vc.Carried(field(x, 1) + field(x, 2), x, period=PERIOD)


def in_time(cells: int) -> vc.History:
    """Rolling over 1.2 periods, with so many elements to an asperity, in steps of an element."""
    dx = SPACING / cells
    steps = round(1.2 * ASPERITIES * cells)
    count = round(1.1 * ASPERITIES * cells)
    scene = vc.Scene(
        bodies=BODIES,
        surface=vc.Cylinders(R=RADIUS, reference_depth=RADIUS),
        normal_force=SMOOTH.force,
        friction=FRICTION,
        motion=vc.Transient(steps=steps, dq=dx, Fx=CARTER.force, carried=carried(dx)),
        grid=vc.Grid(nx=count, dx=dx, x0=-count * dx / 2),
    )
    return vc.solve(scene, certify="none")


def ridges(cells: int) -> vc.Solution:
    """Steady rolling on twenty ridges, with so many elements to a ridge."""
    dy = SPACING / cells
    ny = (ASPERITIES + 4) * cells
    grid = vc.Grid(nx=24, ny=ny, dx=0.1, dy=dy, x0=-1.2, y0=-ny * dy / 2)
    x, y = np.meshgrid(grid.x, grid.y)
    distance = x**2 / (2 * RADIUS) + y**2 / (2 * CROWN) + HEIGHT * np.cos(np.pi * y / SPACING) ** 2
    scene = vc.Scene(
        bodies=BODIES,
        surface=vc.SampledDistance(distance),
        normal_force=3200.0,
        friction=FRICTION,
        motion=vc.Steady(vx=2e-3),
        grid=grid,
    )
    return vc.solve(scene, certify="none")


def contacts(touches: np.ndarray) -> int:
    """Number of separate contacts along a row of elements."""
    return int(np.count_nonzero(np.diff(touches.astype(int), prepend=0) == 1))


def draw_ridges(ax: Axes, sol: vc.Solution) -> None:
    """Stick, slip, tractions, and where particles enter."""
    draw_areas(ax, sol)
    leading = sol.edges["leading"]
    x, y = np.meshgrid(sol.grid.x + sol.grid.sides[0] / 2, sol.grid.y)
    ax.plot(x[leading], y[leading], "|", color="C3", markersize=5, label="leading edge")
    ax.set_title("Steady: ridges")
    ax.set_xlabel("x [mm], rolling to the right")
    ax.set_ylabel("y [mm]")
    legend_below(ax, columns=2)


def draw_pressures(ax: Axes, history: vc.History) -> None:
    """Pressures in the contact, by the distance rolled."""
    pressures = np.array([step.pressure[0] for step in history])
    touching = np.ma.masked_equal(pressures, 0.0)
    ax.pcolormesh(history.grid.x, history.rolled, touching, shading="nearest", rasterized=True)
    ax.set_xlabel("x [mm], rolling to the right")
    ax.set_ylabel("distance rolled [mm]")
    ax.set_title("In time: pressures of asperities")


def draw_creepage(ax: Axes, history: vc.History) -> None:
    """Creepage over Carter's."""
    ax.plot(history.creepage[1:, 0] / CARTER.creepage, history.rolled[1:], label="asperities")
    ax.axvline(1.0, color="k", linestyle="--", label="smooth, Carter")
    ax.set_xlabel("creepage / Carter's")
    ax.set_title("In time: creepage")
    legend_below(ax, columns=1)


def main(picture: str = "asperity_field.png", cells: int = 8) -> tuple[vc.Solution, vc.History]:
    """Both, with the numbers of contacts, and the picture."""
    sol = ridges(cells)
    history = in_time(cells)
    numbers = [contacts(step.pressure[0] > 0) for step in history]
    middle = contacts(sol.pressure[:, sol.grid.nx // 2] > 0)
    later = history.creepage[len(history) // 3 :, 0] / CARTER.creepage
    print(f"ridges: {middle} contacts, Fx = {sol.Fx / (FRICTION * sol.normal_force):.3f} f Fz")
    print(f"in time: {min(numbers)} to {max(numbers)} contacts")
    print(f"creepage {later.min():.2f} to {later.max():.2f} times Carter's")
    figure, axes = plt.subplots(
        1, 3, figsize=(13.0, 6.0), width_ratios=(1.0, 1.8, 0.9), layout="constrained"
    )
    draw_ridges(axes[0], sol)
    draw_pressures(axes[1], history)
    draw_creepage(axes[2], history)
    axes[2].sharey(axes[1])
    figure.savefig(picture, dpi=110)
    plt.close(figure)
    print(f"picture: {Path(picture).resolve()}")
    return sol, history


if __name__ == "__main__":
    main(*sys.argv[1:2])
