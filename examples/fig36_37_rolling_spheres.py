"""Kalker's Figs. 36 and 37: spheres begin to roll, after a shift (like ones) and after compression
(unlike ones).

Fig. 36: two spheres with R = 337.5, G = 1, nu = 0.28, Fz = 0.4705, contact radius 3.5, f = 0.4013;
Cattaneo's shift by Fx = -0.657 f Fz (stick radius 0.7 a = 2.45), then rolling under it in steps of
0.5; elements of side 1, 9 x 9 of them. Fig. 37: a sphere with R = 243, G = 2, nu = 0 on a rigid
slab, f = 0.4013, pressed until the contact radius is 3.5 (Spence's compression), then rolled
without creepage in steps of 0.2; steady after almost two contact widths. `cells` elements are as
long as one of the paper's.

For each distance rolled two panels. Above, tractions along rows of elements at y = 0, 1, 2, 3 (they
are mirror images in y), px in Fig. 36 and |p| in Fig. 37, within the bound (dotted). Below,
stick and slip areas with the direction of the tractions. The paper prints 3 twice among the
distances of Fig. 36; here the first is 2.

The paper's stick radius 2.45 is Cattaneo's formula, a (1 - 0.657)^(1/3). Nine by nine elements
cannot tell it: they stick where their centres are within it, and 21 centres are within any radius
from 2.24 to 2.82. Their area is that of a circle of 2.59.

Run: python examples/fig36_37_rolling_spheres.py [folder]
"""

import math
import sys
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

import varcontact as vc
from varcontact.plotting.fields import draw_areas
from varcontact.plotting.style import SLIP_COLOUR, STICK_COLOUR

RADIUS, FRICTION = 3.5, 0.4013
LOAD = 0.470508  # (7/9)^3, rounded by the paper to 0.4705
FORCE = -0.657 * FRICTION * LOAD
LIKE = vc.Bodies(G=1.0, nu=0.28)
ON_RIGID = vc.Bodies(G=(2.0, math.inf), nu=(0.0, 0.0))
SHOWN = {"like": (0, 1, 2, 3, 5, 7), "unlike": (0, 1, 2, 3, 4, 5, 7, 10, 13)}
ROWS = (0, 1, 2, 3)
COLOURS = ("#1b1b3a", "#2f6f9f", "#3aa17e", "#c9a227")
COLUMNS = 3


def square(cells: int) -> vc.Grid:
    """9 x 9 of the paper's elements, each divided."""
    n = 9 * cells
    return vc.Grid(nx=n, ny=n, dx=9 / n, dy=9 / n, x0=-4.5, y0=-4.5)


def like_scene(cells: int) -> vc.Scene:
    """Fig. 36: the shift, and 7 units of rolling in steps of 0.5."""
    return vc.Scene(
        bodies=LIKE,
        surface=vc.Paraboloids(Rx=337.5 / 2, Ry=337.5 / 2),
        normal_force=LOAD,
        friction=FRICTION,
        motion=vc.Transient(steps=15, dq=[0.0] + [0.5] * 14, Fx=FORCE),
        grid=square(cells),
    )


def like_spheres(cells: int) -> vc.History:
    """Fig. 36 solved."""
    return vc.solve(like_scene(cells), tangential="tang-safeguarded")


def unlike_spheres(cells: int, presses: int = 7) -> vc.History:
    """Fig. 37: pressed in steps of equal growth of the contact, then 13 units of rolling in steps
    of 0.2.
    """
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


def after(history: vc.History, distance: float) -> vc.Solution:
    """The last step at which so much has been rolled."""
    return history[int(np.flatnonzero(np.isclose(history.rolled, distance))[-1])]


def draw_rows(ax: Axes, sol: vc.Solution, sign: bool) -> None:
    """Traction and its bound along the rows of elements at `ROWS`: px with its sign, or |p|."""
    side = -1.0 if sign else 1.0  # px opposes the creepage that the force makes
    for y, colour in zip(ROWS, COLOURS, strict=True):
        row = int(np.argmin(np.abs(sol.grid.y - y)))
        inside = sol.state[row] > 0
        x = sol.grid.x[inside]
        px, py = sol.traction[:, row, inside]
        drawn = px if sign else np.hypot(px, py)
        ax.plot(x, side * sol.traction_bound[row, inside], ":", color=colour, linewidth=1.2)
        ax.plot(x, drawn, "o-", color=colour, markersize=3, linewidth=1.2, label=f"y = {y}")
    ax.axhline(0, color="k", linewidth=0.5)


def draw(history: vc.History, distances: tuple[int, ...], sign: bool) -> Figure:
    """A block for each distance rolled, three in a line: tractions, and below them the areas."""
    lines = math.ceil(len(distances) / COLUMNS)
    figure = plt.figure(figsize=(9.6, 5.6 * lines + 0.5), layout="constrained")
    grid = figure.add_gridspec(2 * lines, COLUMNS, height_ratios=(1.0, 1.15) * lines)
    places = [(2 * (k // COLUMNS), k % COLUMNS) for k in range(len(distances))]
    panels = [figure.add_subplot(grid[place]) for place in places]
    maps = [figure.add_subplot(grid[line + 1, column]) for line, column in places]
    shown = [after(history, distance) for distance in distances]
    most = 1.08 * max(float(sol.traction_bound.max()) for sol in shown)
    for ax, areas, sol, distance in zip(panels, maps, shown, distances, strict=True):
        draw_rows(ax, sol, sign)
        ax.set(
            xlim=(-4.5, 4.5),
            ylim=(-most, 0.1 * most) if sign else (-0.1 * most, most),
            title=f"Vt = {distance}",
        )
        draw_areas(areas, sol)
        areas.set(
            title=f"$F_x$ = {sol.force[0]:z.4f}",
            xlabel="x",
            ylabel="",
            xlim=(-4.5, 4.5),
            ylim=(-4.5, 4.5),
        )
        areas.get_legend().remove()
    for ax in panels[::COLUMNS]:
        ax.set_ylabel("$p_x$" if sign else "$|p|$")
    for ax in maps[::COLUMNS]:
        ax.set_ylabel("y")
    handles, labels = panels[0].get_legend_handles_labels()
    handles += [
        Patch(color=STICK_COLOUR, label="stick (A)"),
        Patch(color=SLIP_COLOUR, label="slip (S)"),
    ]
    labels += ["stick (A)", "slip (S)"]
    figure.legend(handles, labels, loc="outside lower center", ncols=6, frameon=False)
    return figure


def off(one: vc.Solution, other: vc.Solution) -> float:
    """Mean difference of tractions by the mean traction bound."""
    return float(np.hypot(*(one.traction - other.traction)).sum() / one.traction_bound.sum())


def shift(cells: int) -> vc.Solution:
    """Cattaneo's shift alone, the first step of Fig. 36."""
    return vc.solve(replace(like_scene(cells), motion=vc.Shift(Fx=FORCE)))


def stick_radii(sol: vc.Solution) -> dict[str, float]:
    """Cattaneo's radius, that of a circle of the stick elements' area, and what the formula makes
    of this grid.
    """
    formula = vc.reference.cattaneo_mindlin(
        sol.scene.hertz, sol.scene.bodies, FRICTION, float(sol.force[0])
    )
    radius = formula.stick_radius
    within = np.hypot(*np.meshgrid(sol.grid.x, sol.grid.y)) < radius
    return {
        "Fig. 36, stick radius by Cattaneo (2.45)": radius,
        "Fig. 36, by the area of stick elements": math.sqrt(sol.areas["stick"] / math.pi),
        "Fig. 36, by that of centres within Cattaneo's": math.sqrt(
            within.sum() * sol.grid.area / math.pi
        ),
        "Fig. 36, elements that are in one and not both": float(np.sum(within != (sol.state == 1))),
    }


def main(folder: str = ".", cells: int = 3) -> dict[str, float]:
    """Solve and draw both; the paper's numbers."""
    like, unlike = like_spheres(cells), unlike_spheres(cells)
    methods = {"tangential": "tang-safeguarded"}
    carter = vc.solve(replace(like.scene, motion=vc.Steady(Fx=like.force[0, 0], dq=0.5)), **methods)
    steady = vc.solve(replace(unlike.scene, motion=vc.Steady(dq=0.2)), normal="norm", **methods)
    numbers = {
        "Fig. 36, Fz (0.4705)": like[0].normal_force,
        "Fig. 36, Fx (-0.1240)": float(like[0].force[0]),
        "Fig. 36, contact radius (3.5)": like[0].scene.hertz.a,
        **stick_radii(like[0]),
        "Fig. 36, Vt = 7 off the steady state (0)": off(like[-1], carter),
        "Fig. 37, Vt = 13 off the steady state (0)": off(unlike[-1], steady),
        "Fig. 37, Vt = 0 off the steady state": off(unlike[6], steady),
    }
    for name, value in numbers.items():
        print(f"{name:<50}{value:8.4f}")
    draw(like, SHOWN["like"], sign=True).savefig(Path(folder) / "fig36.png", dpi=110)
    draw(unlike, SHOWN["unlike"], sign=False).savefig(Path(folder) / "fig37.png", dpi=110)
    plt.close("all")
    return numbers


if __name__ == "__main__":
    main(*sys.argv[1:2])
