"""Kalker's Figs. 30 to 33: transient rolling of cylinders, all with half-width 1, force pi/2 and
largest pressure 1.

Fig. 30, from Cattaneo to Carter: like cylinders are shifted by Fx = 0.75 f Fz, then roll under it.
The paper reads off: the stick area breaks in two at t = 0.4, its left part has gone at t = 0.58,
the vertical tangent at the particle that enters first is lost at t = 1, all is as good as steady at
t = 2. Fig. 31, varying normal force: a(t) = 1 + 0.4/pi sin(2 pi t), Fx = 0.255 pi, f = 1; periodic
from t = 1 on. Begun in a steady state it nearly is, though at t = 1 half of the particles of the
start are still in contact. Fig. 32, harmonic velocity pi cos(pi t) and force -0.355 pi sin(pi t);
from t = 1 on half a period later everything is turned by 180 degrees about the origin. Begun from
nothing at t = 0 it is so but for a tenth of the tractions at t = 1, whose start the particles in
the middle still remember, and but for 0.6 % from t = 2 on: the picture begins there. Fig. 33,
frictional compression of unlike cylinders (G = 1 on rigid, nu = 0.286, f = 0.15), then free
rolling; the paper does not say what holds the force: here it is Fx = 0. Nearly steady at t = 1.8.

Run: python examples/fig30_to_33_rolling_cylinders.py [folder]
"""

import math
import sys
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import varcontact as vc
from varcontact.plotting.style import SLIP_COLOUR, STICK_COLOUR, TRACTION_COLOUR

LOAD = math.pi / 2
LIKE, UNLIKE = vc.Bodies(G=1.0, nu=0.25), vc.Bodies(G=(1.0, math.inf), nu=(0.286, 0.286))
METHODS = {"normal": "auto", "tangential": "tang-safeguarded"}


def scene(
    bodies: vc.Bodies, friction: float, motion: vc.Transient | vc.Steady, cells: int
) -> vc.Scene:
    """Cylinders with half-width 1 under the load pi/2, on a grid that holds half-widths up to
    1.2.
    """
    radius = bodies.combined_G / (2 * (1 - bodies.combined_nu))
    grid = vc.Grid(nx=round(1.2 * cells), dx=2 / cells, x0=-1.2)
    return vc.Scene(
        bodies=bodies,
        surface=vc.Cylinders(R=radius),
        normal_force=LOAD,
        friction=friction,
        motion=motion,
        grid=grid,
    )


def cattaneo_to_carter(cells: int) -> vc.History:
    """Fig. 30: the shift, and two half-widths of rolling, an element a step."""
    motion = vc.Transient(steps=cells + 1, dq=[0.0] + [2 / cells] * cells, Fx=-0.75 * LOAD)
    return vc.solve(scene(LIKE, 1.0, motion, cells), **METHODS)


def varying_load(cells: int) -> vc.History:
    """Fig. 31: three periods, begun in the steady state of the mean load."""
    steady = vc.solve(scene(LIKE, 1.0, vc.Steady(Fx=0.255 * math.pi), cells), **METHODS)
    steps = 3 * cells // 2
    t = 2 / cells * (np.arange(steps) + 1)
    loads = LOAD * (1 + 0.4 / math.pi * np.sin(2 * math.pi * t)) ** 2
    motion = vc.Transient(
        steps=steps, Fx=0.255 * math.pi, normal_force=loads.tolist(), start=steady
    )
    return vc.solve(scene(LIKE, 1.0, motion, cells), **METHODS)


def harmonic(cells: int) -> vc.History:
    """Fig. 32: three half periods from nothing, velocity of the middle of a step, an element a step
    at most.
    """
    steps = 6 * cells
    middle, end = (np.arange(steps) + 0.5) * 3 / steps, (np.arange(steps) + 1) * 3 / steps
    velocity = math.pi * np.cos(math.pi * middle)
    motion = vc.Transient(
        steps=steps,
        dq=(np.abs(velocity) * 3 / steps).tolist(),
        direction=np.sign(velocity).astype(int).tolist(),
        Fx=(-0.355 * math.pi * np.sin(math.pi * end)).tolist(),
    )
    return vc.solve(scene(LIKE, 1.0, motion, cells), **METHODS)


def compression_then_rolling(cells: int, presses: int = 20) -> vc.History:
    """Fig. 33: pressed in steps of equal growth of the contact, then rolled for 1.8 half-widths."""
    rolls = round(0.9 * cells)
    loads = [LOAD * ((k + 1) / presses) ** 2 for k in range(presses)] + [LOAD] * rolls
    motion = vc.Transient(
        steps=presses + rolls, dq=[0.0] * presses + [2 / cells] * rolls, Fx=0.0, normal_force=loads
    )
    return vc.solve(scene(UNLIKE, 0.15, motion, cells), **METHODS)


def stick_parts(sol: vc.Solution) -> list[tuple[float, float]]:
    """The intervals that stick, from left to right, but those of a single element."""
    changes = np.diff(np.concatenate([[False], sol.state[0] == 1, [False]]).astype(int))
    ends = zip(np.flatnonzero(changes == 1), np.flatnonzero(changes == -1), strict=True)
    left, dx = sol.grid.box[0], sol.grid.sides[0]
    return [(left + i * dx, left + j * dx) for i, j in ends if j - i > 1]


def draw(path: Path, frames: dict[str, vc.Solution]) -> None:
    """Tractions between their bounds, over stick and slip areas, frame by frame."""
    figure, axes = plt.subplots(
        1, len(frames), figsize=(2.6 * len(frames), 2.9), layout="constrained", sharey=True
    )
    for ax, (title, sol) in zip(axes, frames.items(), strict=True):
        x, bound = sol.grid.x, sol.traction_bound[0]
        for state, colour in ((1, STICK_COLOUR), (2, SLIP_COLOUR)):
            ax.fill_between(
                x, -bound, bound, where=sol.state[0] == state, step="mid", color=colour, linewidth=0
            )
        ax.plot(x, bound, "0.5", x, -bound, "0.5", linewidth=1)
        ax.plot(x, sol.traction[0, 0], color=TRACTION_COLOUR)
        ax.axhline(0, color="k", linewidth=0.5)
        ax.set_title(title)
        ax.set_xlabel("x")
    axes[0].set_ylabel("$p_x$")
    figure.savefig(path, dpi=100)
    plt.close(figure)


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Mean difference of two fields by the mean of the first."""
    return float(np.abs(one - other).sum() / np.abs(one).sum())


def main(folder: str = ".", cells: int = 100) -> dict[str, float]:
    """Solve and draw the four; what the paper reads off them."""
    first, load, swing, press = (
        figure(cells)
        for figure in (cattaneo_to_carter, varying_load, harmonic, compression_then_rolling)
    )
    t, parts = first.rolled, [stick_parts(sol) for sol in first]
    broken = [k for k in range(len(first)) if len(parts[k]) == 2]
    inside = np.array([1 - t[k] > parts[k][-1][0] for k in range(len(first))])
    half = len(swing) // 3
    turned = [swing[k * half - 1].traction * (-1) ** k for k in (1, 2, 3)]
    carter = vc.solve(replace(first.scene, motion=vc.Steady(Fx=-0.75 * LOAD)), **METHODS)
    steady = vc.solve(replace(press.scene, motion=vc.Steady(Fx=0.0)), **METHODS)
    numbers = {
        "Fig. 30, stick area breaks at t = (0.4)": float(t[broken[0]]),
        "Fig. 30, its left part has gone at t = (0.58)": float(t[broken[-1] + 1]),
        "Fig. 30, first particle leaves it at t = (1)": float(t[np.argmin(inside)]),
        "Fig. 30, t = 2 off the steady state (0)": apart(carter.traction, first[-1].traction),
        "Fig. 31, t = 2 off t = 1 (0)": apart(
            load[cells - 1].traction, load[cells // 2 - 1].traction
        ),
        "Fig. 31, t = 3 off t = 2 (0)": apart(load[-1].traction, load[cells - 1].traction),
        "Fig. 32, t = 2 off t = 1 turned (0)": apart(turned[0], turned[1][:, :, ::-1]),
        "Fig. 32, t = 3 off t = 2 turned (0)": apart(turned[1], turned[2][:, :, ::-1]),
        "Fig. 33, t = 1.8 off the steady state (0)": apart(steady.traction, press[-1].traction),
    }
    for name, value in numbers.items():
        print(f"{name:<50}{value:7.3f}")
    at = [0, *(round(time * cells / 2) for time in (0.2, 0.4, 0.5, 0.6, 1.0, 2.0))]
    draw(Path(folder) / "fig30.png", {f"t = {t[k]:.2g}": first[k] for k in at})
    at = [round(time * cells / 2) - 1 for time in (1.0, 2.0, 2.2, 2.4, 2.6, 2.8, 3.0)]
    draw(Path(folder) / "fig31.png", {f"t = {load.rolled[k]:.2g}": load[k] for k in at})
    at = [round(time * half) - 1 for time in (2.0, 2.2, 2.4, 2.5, 2.6, 2.8, 3.0)]
    draw(Path(folder) / "fig32.png", {f"t = {(k + 1) / half:.2g}": swing[k] for k in at})
    at = [19, *(19 + round(time * cells / 2) for time in (0.2, 0.6, 1.0, 1.8))]
    draw(Path(folder) / "fig33.png", {f"t = {press.rolled[k]:.2g}": press[k] for k in at})
    return numbers


if __name__ == "__main__":
    main(*sys.argv[1:2])
