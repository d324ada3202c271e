"""Pictures of the stress below the surface."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from varcontact.checks import choice, moderate, positive
from varcontact.errors import SceneError
from varcontact.plotting.solution import label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from varcontact.results.solution import Solution
    from varcontact.results.stress import SubsurfaceStress

STRESSES = {
    "von_mises": "von Mises stress",
    "tresca": "Tresca stress",
    "ideal_stress": "Ideal stress $\\sigma_I$",
    "first_invariant": "First invariant $\\sigma_{ii}$",
}
COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")


def plot_stress(
    sol: Solution, quantity: str = "von_mises", *, y: float | None = None, depth: float | None = None
) -> Figure:
    """Contours of a stress in a section of both bodies along x, the upper body above the surface.

    Parameters
    ----------
    sol : Solution
    quantity : str
        "von_mises", "tresca", "ideal_stress", "first_invariant", or a component: "xx", "yy", "zz", "xy", "xz", "yz".
    y : float, optional
        Of the section [length]; that of the row with the largest pressure if not given.
    depth : float, optional
        Shown in either body [length]; three quarters of the contact's length along x if not given.

    Returns
    -------
    matplotlib Figure
        Not shown: call its ``savefig``, or ``plt.show()``.

    Raises
    ------
    SceneError
        For what is no Solution with contact, a quantity that does not exist, or a depth that is not positive.
    """
    from matplotlib import pyplot as plt
    from matplotlib.ticker import MaxNLocator

    from varcontact.plotting.ticks import readable_numbers, readable_ticks
    from varcontact.results.stress import one_solution, stress

    if not one_solution(sol).pressure.any():
        raise SceneError(
            "solution", sol, "with contact", message="solution: there is no contact, so nothing is stressed"
        )
    choice("quantity", quantity, [*STRESSES, *COMPONENTS])
    row = int(np.argmax(sol.pressure.max(axis=1)))
    y = float(sol.grid.y[row]) if y is None else moderate("y", y)
    x, length = _along_section(sol)
    depth = 0.75 * length if depth is None else positive("depth", depth)
    depths = depth * np.linspace(0, 1, 25) ** 1.5
    fields = {}
    for body, sign in ((1, 1.0), (2, -1.0)):
        z, across = np.meshgrid(sign * depths, x, indexing="ij")
        fields[body] = stress(sol, [across, np.full_like(z, y), z], body)
    values = {body: _stress_value(field, quantity) for body, field in fields.items()}
    both = np.stack(list(values.values()))
    signed = quantity in COMPONENTS
    levels = MaxNLocator(20, symmetric=signed).tick_values(both.min(), both.max())

    figure, ax = plt.subplots(figsize=(8.0, 6.4), layout="constrained")
    for body, part in values.items():
        place = fields[body].points
        image = ax.contourf(place[0], place[2], part, levels, cmap="RdBu_r" if signed else "viridis")
        ax.contour(place[0], place[2], part, levels[::2], colors="k", linewidths=0.4, negative_linestyles="solid")
    stresses = label(_stress_name(quantity), "pressure", sol)
    figure.colorbar(image, ax=ax, shrink=0.85, label=stresses, format=readable_numbers())
    ax.axhline(0, color="0.35", linewidth=0.8)
    contact = sol.grid.x[(sol.pressure > 0).any(axis=0)]
    half = sol.grid.sides[0] / 2
    ax.plot([contact[0] - half, contact[-1] + half], [0, 0], color="k", linewidth=2.5, solid_capstyle="butt")
    ax.set_xlabel(label("x", "length", sol))
    ax.set_ylabel(label("z, up into body 1", "length", sol))
    where = "" if sol.scene.line else label(f" at y = {y:.3g}", "length", sol, brackets=False)
    ax.set_title(f"{_stress_name(quantity)}{where}; the bar is the contact")
    readable_ticks(ax)
    ax.set_aspect("equal")
    return figure


def _along_section(sol: Solution) -> tuple[np.ndarray, float]:
    """Abscissae below element centres, half a contact's length beyond it on both sides, and that length."""
    dx = sol.grid.sides[0]
    contact = np.flatnonzero((sol.pressure > 0).any(axis=0))
    cells = contact[-1] - contact[0] + 1
    every = max(1, int(np.ceil(cells / 40)))
    beyond = (cells // 2 + 1) // every * every
    columns = np.arange(contact[0] - beyond, contact[-1] + beyond + 1, every)
    return sol.grid.x[0] + columns * dx, cells * dx


def _stress_value(field: SubsurfaceStress, quantity: str) -> np.ndarray:
    if quantity in STRESSES:
        return np.asarray(getattr(field, quantity))
    i, j = ("xyz".index(letter) for letter in quantity)
    return np.asarray(field.stress[i, j])


def _stress_name(quantity: str) -> str:
    return STRESSES.get(quantity, f"$\\sigma_{{{quantity}}}$")
