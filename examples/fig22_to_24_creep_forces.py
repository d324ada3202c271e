"""Kalker's Figs. 22 to 24: total force against creepage and spin, by the exact theory and by its
rivals.

A circle of radius 1, G = 1, nu = 0.25, f = 1, Fz = 1, as below the paper's Fig. 24. Its variables
(3.2.7) are

    xi' = -ab G C11 vx / (3 f Fz),   eta' = -ab G C22 vy / (3 f Fz),
    psi = -(ab)^1.5 G C23 spin / (f Fz),

so that the linear theory is F = f Fz (3 xi', 3 eta' + psi). Fig. 22 is pure creepage, Fig. 23 pure
spin, and Fig. 24 has (1) xi' = eta', psi = 0, (2) xi' = psi, eta' = 0 and (3) eta' = -psi, xi' = 0.
A further case, called (3*), is 3 eta' = -psi, xi' = 0: creepage and spin that cancel in the linear
theory.

As in the paper, "the curves have been scaled so that in each figure the slope in the origin is the
same": creepages follow from these variables by the creepage coefficients of each theory. Those of
the exact theory are its grid's own (from `Solution.sensitivity`; 2 % above the continuum's with 20
elements across), the others have the continuum's. FASTSIM with separate flexibilities then has the
right slope in all cases. With the single flexibility (164) that the paper prints it has it in Figs.
22 and 23, where one creepage acts alone and both are the same. In Fig. 24 it has not, as the
weights in (164) add up to more than one; it is drawn dashed.

Run: python examples/fig22_to_24_creep_forces.py [picture.png]
"""

import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import varcontact as vc
from varcontact.reference import CreepageCoefficients, creepage_coefficients
from varcontact.theories import fastsim, vermeulen_johnson, vermeulen_johnson_coefficients

CIRCLE = (1.0, 1.0, 1.0)  # a, b, G
LIMIT = 1.0  # f Fz
NU = 0.25
KALKER = creepage_coefficients(1.0, 1.0, NU)
ROOT = np.sqrt(0.5)

# Directions (xi', eta', psi), and how far along them.
CASES = {
    "Fig. 22, vx": ((1, 0, 0), 1.5),
    "Fig. 22, vy": ((0, 1, 0), 1.5),
    "Fig. 23": ((0, 0, 1), 4.0),
    "Fig. 24 (1)": ((ROOT, ROOT, 0), 1.5),
    "Fig. 24 (2)": ((1, 0, 1), 1.5),
    "Fig. 24 (3)": ((0, -1, 1), 2.0),
    "Fig. 24 (3*)": ((0, -1, 3), 2.0),
}
Theory = Callable[[np.ndarray], np.ndarray]
EXACT = {"color": "k", "linestyle": "none", "markersize": 4.5, "fillstyle": "none"}
FASTSIM = {"color": "#c0392b", "linewidth": 1.6}
WEIGHTED = {"color": "#c0392b", "linewidth": 1.3, "linestyle": (0, (4, 2))}
LINE = {"color": "#1f5fa8", "linewidth": 1.6, "linestyle": "-."}
OWN = {"color": "#3d8b5f", "linewidth": 1.2, "linestyle": ":"}
LINEAR = {"color": "0.55", "linewidth": 1.0}


def scene(cells: int) -> vc.Scene:
    """The circle, so many elements across, in rolling with any creepages."""
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=NU),
        surface=vc.Ellipse(a=1.0, b=1.0),
        normal_force=LIMIT,
        friction=1.0,
        motion=vc.Steady(vx=1e-6),
        grid=vc.Grid(nx=cells, ny=cells),
    )


def creepages(variables: np.ndarray, table: CreepageCoefficients) -> np.ndarray:
    """(vx, vy, spin) of (xi', eta', psi), on a circle of radius 1 with G = f Fz = 1."""
    return variables * np.array([-3 / table.C11, -3 / table.C22, -1 / table.C23])


def linear(variables: np.ndarray) -> np.ndarray:
    """Forces of the linear theory."""
    return variables @ np.array([[3.0, 0.0], [0.0, 3.0], [0.0, 1.0]])


def simplified(variables: np.ndarray, elements: int, flexibility: str = "separate") -> np.ndarray:
    """Forces by FASTSIM, with so many strips and intervals in each."""
    options = {"m": elements, "n": elements, "flexibility": flexibility}
    return fastsim(*CIRCLE, LIMIT, creepages(variables, KALKER), KALKER, **options).force


def line(variables: np.ndarray, own: bool = False) -> np.ndarray:
    """Forces by Kalker's line, or by Vermeulen and Johnson's own."""
    table = vermeulen_johnson_coefficients(1.0, 1.0, NU) if own else KALKER
    return vermeulen_johnson(*CIRCLE, LIMIT, creepages(variables, KALKER), table)


def exact(cells: int, points: int) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """For each case the places along it, and the forces there: one curve through all of them."""
    # everything sticks: the linear theory of this grid
    slopes = -vc.solve(scene(cells)).sensitivity()
    table = CreepageCoefficients(slopes[0, 0], slopes[1, 1], slopes[1, 2], np.nan)
    # closer where the curves bend
    places = {
        name: far * (np.arange(1, points + 1) / points) ** 1.3 for name, (_, far) in CASES.items()
    }
    variables = [np.outer(places[name], CASES[name][0]) for name in CASES]
    vx, vy, spin = creepages(np.concatenate(variables), table).T
    curve = vc.creep_curve(scene(cells), ["auto"], vx=vx, vy=vy, spin=spin).isel(theory=0)
    forces = np.stack([curve.Fx, curve.Fy], axis=-1)
    return dict(
        zip(CASES, zip(places.values(), np.split(forces, len(CASES)), strict=True), strict=True)
    )


def distances(
    found: dict[str, tuple[np.ndarray, np.ndarray]], elements: int
) -> dict[str, dict[str, float]]:
    """Largest distances |F - F_exact| / (f Fz) of the rivals, by case and rival."""
    result = {}
    for name, (places, forces) in found.items():
        direction = np.array(CASES[name][0], dtype=float)
        variables = np.outer(places, direction)
        rivals = {
            f"{label} {count} x {count}": simplified(variables, count, flexibility)
            for label, flexibility in (("FASTSIM", "separate"), ("weighted", "weighted"))
            for count in (10, elements)
        }
        if direction[2] == 0:
            rivals["Kalker's line"] = line(variables)
            rivals["Vermeulen-Johnson"] = line(variables, own=True)
        result[name] = {
            rival: float(np.hypot(*(other - forces).T).max()) for rival, other in rivals.items()
        }
    return result


def table_of(numbers: dict[str, dict[str, float]]) -> str:
    """The distances in percent of f Fz, as text."""
    rivals = list(dict.fromkeys(rival for row in numbers.values() for rival in row))
    lines = ["Largest distance from the exact theory, in % of f Fz:", ""]
    lines += [" " * 14 + "".join(f"{rival:>24}" for rival in rivals)]
    for name, row in numbers.items():
        cells = [f"{100 * row[rival]:.1f}" if rival in row else "" for rival in rivals]
        lines.append(f"{name:<14}" + "".join(f"{cell:>24}" for cell in cells).rstrip())
    return "\n".join(lines)


def draw(found: dict[str, tuple[np.ndarray, np.ndarray]], elements: int, picture: str) -> None:
    """The three figures, Fig. 24 in three panels, and the distances of both FASTSIMs along all
    curves.
    """
    figure, axes = plt.subplots(2, 3, figsize=(13.0, 8.2), layout="constrained")
    draw_creepage(axes[0, 0], found, elements)
    draw_spin(axes[0, 1], found, elements)
    draw_distances(axes[0, 2], found, elements)
    draw_case(
        axes[1, 0],
        found,
        elements,
        "Fig. 24 (1)",
        r"Fig. 24 (1): $\xi' = \eta'$, $\psi = 0$",
        r"$w'$",
    )
    draw_case(
        axes[1, 1],
        found,
        elements,
        "Fig. 24 (2)",
        r"Fig. 24 (2): $\xi' = \psi$, $\eta' = 0$",
        r"$\xi' = \psi$",
    )
    draw_opposed(axes[1, 2], found, elements)
    for ax in axes.ravel():
        ax.set_xlim(0, None)
        ax.grid(True, color="0.9", linewidth=0.7)
        ax.set_axisbelow(True)
    figure.savefig(picture, dpi=150)
    plt.close(figure)


def draw_creepage(ax: Axes, found: dict, elements: int) -> None:
    """Fig. 22. In its variables FASTSIM (both), Kalker's line and the linear theory are the same
    for vx and vy.
    """
    cases = ("Fig. 22, vx", "o", r"$v_x$", ":"), ("Fig. 22, vy", "^", r"$v_y$", (0, (1, 3)))
    for name, marker, label, _ in cases:
        ax.plot(found[name][0], _size(found[name][1]), marker, **EXACT, label=f"exact, {label}")
    _curve(ax, "Fig. 22, vx", lambda v: simplified(v, elements), FASTSIM, "FASTSIM")
    _curve(ax, "Fig. 22, vx", line, LINE, "Kalker's line")
    for name, _, label, dots in cases:
        _curve(
            ax,
            name,
            lambda v: line(v, own=True),
            OWN | {"linestyle": dots},
            f"Vermeulen-Johnson, {label}",
        )
    _curve(ax, "Fig. 22, vx", linear, LINEAR, "linear theory")
    _finish(ax, "Fig. 22: pure creepage", r"$w'$")


def draw_spin(ax: Axes, found: dict, elements: int) -> None:
    """Fig. 23."""
    ax.plot(found["Fig. 23"][0], _lateral(found["Fig. 23"][1]), "o", **EXACT, label="exact")
    _curve(ax, "Fig. 23", lambda v: simplified(v, elements), FASTSIM, "FASTSIM", _lateral)
    _curve(ax, "Fig. 23", linear, LINEAR, "linear theory", _lateral)
    _finish(ax, "Fig. 23: pure spin", r"$\psi$")
    ax.set_ylabel(r"$F_y$ / $fF_z$")


def draw_case(
    ax: Axes,
    found: dict,
    elements: int,
    name: str,
    title: str,
    label: str,
    part: Theory | None = None,
) -> None:
    """A case of Fig. 24, by FASTSIM with separate and with the weighted flexibility."""
    direction, part = np.array(CASES[name][0], dtype=float), part or _size
    ax.plot(found[name][0], part(found[name][1]), "o", **EXACT, label="exact")
    _curve(ax, name, lambda v: simplified(v, elements), FASTSIM, "FASTSIM", part)
    _curve(
        ax, name, lambda v: simplified(v, elements, "weighted"), WEIGHTED, "FASTSIM, weighted", part
    )
    if direction[2] == 0:
        _curve(ax, name, line, LINE, "Kalker's line", part)
    _curve(ax, name, linear, LINEAR, "linear theory", part)
    _finish(ax, title, label)


def draw_opposed(ax: Axes, found: dict, elements: int) -> None:
    """Case (3) of Fig. 24, and (3*)."""
    title = r"Fig. 24 (3): $\eta' = -\psi$, (3*): $3\eta' = -\psi$; $\xi' = 0$"
    draw_case(ax, found, elements, "Fig. 24 (3)", title, r"$-\eta'$", _opposed)
    ax.plot(found["Fig. 24 (3*)"][0], _opposed(found["Fig. 24 (3*)"][1]), "s", **EXACT)
    _curve(ax, "Fig. 24 (3*)", lambda v: simplified(v, elements), FASTSIM, "_", _opposed)
    _curve(
        ax, "Fig. 24 (3*)", lambda v: simplified(v, elements, "weighted"), WEIGHTED, "_", _opposed
    )
    ax.axhline(0, color="k", linewidth=0.6)
    ax.text(1.0, 0.83, "(3)", ha="center")
    ax.text(1.0, 0.2, "(3*)", ha="center")
    ax.set_ylabel(r"$-F_y$ / $fF_z$")
    ax.set_ylim(-0.22, 1.08)
    ax.legend(
        fontsize="small",
        framealpha=0.9,
        edgecolor="0.8",
        loc="center right",
        bbox_to_anchor=(1.0, 0.54),
    )


def draw_distances(ax: Axes, found: dict, elements: int) -> None:
    """How far FASTSIM is from the exact theory, along all curves; dashed with the weighted
    flexibility.
    """
    for (name, (places, forces)), marker in zip(found.items(), "o^svDPX", strict=True):
        direction, far = CASES[name]
        label, colour = name.replace("vx", "$v_x$").replace("vy", "$v_y$"), None
        for flexibility, dashes in (("separate", "-"), ("weighted", "--"))[
            : np.count_nonzero(direction)
        ]:
            forces_there = simplified(np.outer(places, direction), elements, flexibility)
            away = 100 * np.hypot(*(forces_there - forces).T)
            style = {
                "marker": marker,
                "linestyle": dashes,
                "color": colour,
                "markersize": 3.5,
                "linewidth": 1.0,
            }
            (curve,) = ax.plot(places / far, away, **style, label=label)
            label, colour = "_", curve.get_color()
    ax.plot([], [], "--", color="0.4", linewidth=1.0, label="weighted")
    _finish(
        ax,
        "Distance of FASTSIM from the exact theory",
        "abscissa of the curve, divided by its last",
    )
    ax.set_ylabel(r"$|\mathbf{F} - \mathbf{F}_{\rm exact}|$ / $fF_z$  [%]")
    ax.set_ylim(0, 27)
    ax.set_xlim(0, 1)
    ax.legend(fontsize="small", framealpha=0.9, edgecolor="0.8", ncols=2, loc="upper right")


def _finish(ax: Axes, title: str, label: str) -> None:
    ax.set_title(title)
    ax.set_xlabel(label)
    ax.set_ylabel(r"$|\mathbf{F}|$ / $fF_z$")
    ax.set_ylim(0, 1.08)
    ax.legend(fontsize="small", framealpha=0.9, edgecolor="0.8")


def _size(forces: np.ndarray) -> np.ndarray:
    return np.hypot(*forces.T)


def _lateral(forces: np.ndarray) -> np.ndarray:
    return forces[:, 1]


def _opposed(forces: np.ndarray) -> np.ndarray:
    return -forces[:, 1]


def _curve(
    ax: Axes, name: str, theory: Theory, style: dict, label: str, part: Theory = _size
) -> None:
    """A theory along a case, at many points."""
    direction, far = CASES[name]
    places = np.linspace(0.0, far, 301)
    ax.plot(places, part(theory(np.outer(places, direction))), **style, label=label)


def main(
    picture: str = "fig22_to_24_creep_forces.png",
    cells: int = 20,
    points: int = 14,
    elements: int = 100,
) -> dict[str, dict[str, float]]:
    """Scan, draw, print the largest distances; `cells` across and `points` a curve of the exact
    theory.
    """
    found = exact(cells, points)
    numbers = distances(found, elements)
    print(table_of(numbers))
    draw(found, elements, picture)
    print(f"\npicture: {Path(picture).resolve()}")
    return numbers


if __name__ == "__main__":
    main(*sys.argv[1:2])
