"""Pictures of the stress below the surface."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.plotting import style
from varcontact.plotting.unit_labels import measure
from varcontact.results.solution import Solution
from varcontact.results.stress import (
    FARTHEST,
    NAMES,
    Body,
    Patch,
    SubsurfaceStress,
    body_names,
    side_of,
    solution_of,
    stress,
)

STRESSES = {
    "von_mises": "Von Mises stress",
    "tresca": "Tresca stress",
    "ideal_stress": "Ideal stress $\\sigma_I$",
    "first_invariant": "First invariant $\\sigma_{ii}$",
}
COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")
PLANES = ("xz", "yz", "xy")
LAYERS, ACROSS = 25, 40
"""Depths of a section in each body, and points at most across the contact."""


@checks.named_options()
def plot_stress(
    sol: Solution | Patch,
    quantity: str = "von_mises",
    *,
    plane: str = "xz",
    x: float | None = None,
    y: float | None = None,
    depth: float | None = None,
    body: Body = 1,
    ax: Axes | None = None,
    figsize: tuple[float, float] | None = None,
) -> Figure:
    """Contours of a stress in a section of both bodies, the upper above the
    surface, or at one depth of one body.

    The largest is marked, of a component the largest in size.

    Parameters
    ----------
    sol : Solution or PatchSolution
    quantity : str
        "von_mises", "tresca", "ideal_stress", "first_invariant", or a
        component: "xx", "yy", "zz", "xy", "xz", "yz".
    plane : str
        "xz": a section along x; "yz": a section across it; "xy": a plane
        parallel to the surface.
    x, y : float, optional
        Of the section across the other axis [length]; where the pressure is
        largest if not given.
    depth : float, optional
        Of a section: shown in either body [length]; three quarters of the
        contact's length in it if not given. Of the plane "xy": its distance
        from the surface [length]; a quarter of the contact's length along x if
        not given.
    body : 1, 2, "upper" or "lower"
        Of the plane "xy"; of a patch of a wheel 1, 2, "rail" or "wheel".
    ax, figsize
        As for `Solution.plot`.

    Returns
    -------
    matplotlib Figure

    Raises
    ------
    SceneError
        For what is no Solution with contact, a quantity or a plane that does
        not exist, a depth that is not positive, a place that does not belong to
        the plane, or another plane than "xz" in line contact.
    """
    names = body_names(sol)
    side = side_of(body, names)
    sol = solution_of(sol)
    if not sol.pressure.any():
        raise SceneError("solution", sol, "with contact: else nothing is stressed")
    checks.choice("quantity", quantity, [*STRESSES, *COMPONENTS])
    with style.panel(ax, figsize, (style.COLUMN * 1.25, style.COLUMN)) as (figure, drawn):
        fields, axes, at, words = _cut(sol, plane, x, y, depth, side)
        signed, name = quantity in COMPONENTS, STRESSES.get(quantity, f"$\\sigma_{{{quantity}}}$")
        if signed:
            i, j = ("xyz".index(letter) for letter in quantity)
            values = np.stack([each.stress[i, j] for each in fields])
        else:
            values = np.stack([getattr(each, quantity) for each in fields])
        places = np.stack([[each.points[i] for each in fields] for i in axes])
        lengths, stresses = (
            measure(sol.scene, "length", places),
            measure(sol.scene, "pressure", values),
        )
        shown = stresses(values)
        levels = MaxNLocator(20, symmetric=signed).tick_values(
            float(shown.min()), float(shown.max())
        )
        for first, second, value in zip(*lengths(places), shown, strict=True):
            image = drawn.contourf(
                first, second, value, levels, cmap="RdBu_r" if signed else "viridis"
            )
            drawn.contour(
                first, second, value, levels[::2], colors="k", linewidths=0.3, linestyles="solid"
            )
        style.colour_bar(drawn, image, stresses.label(name))
        if plane == "xy":
            x_lines, y_lines = lengths(sol.grid.x), lengths(sol.grid.y)
            inside = (sol.pressure > 0).astype(float)
            # black on white: seen on all colours
            for ink, width, line in (("w", 1.8, "solid"), ("k", 0.9, "dashed")):
                drawn.contour(
                    x_lines, y_lines, inside, [0.5], colors=ink, linewidths=width, linestyles=line
                )
            drawn.plot([], [], color="k", linewidth=0.9, linestyle="dashed", label="contact")
        else:
            cells = _cells(sol, axes[0])
            ends = lengths(sol.grid.lines[axes[0]][[cells[0], cells[-1] + 1]])
            drawn.axhline(0, color="0.35", linewidth=0.6)
            drawn.plot(
                ends, [0, 0], color="k", linewidth=2.5, solid_capstyle="butt", label="contact"
            )
        most = int(np.abs(values).argmax())  # a cross where the stress is largest in size
        value = float(values.flat[most])
        first, second = (float(lengths(each.flat[most])) + 0.0 for each in places)
        where = f"({', '.join('xyz'[i] for i in axes)}) = ({first:.3g}, {second:.3g}) {lengths.unit}".rstrip()
        label = f"{'largest' if value >= 0 else 'largest in size'}: {stresses.text(value, 4)} at {where}"
        look: dict[str, Any] = {"marker": "+", "markersize": 8, "ls": "", "clip_on": False}
        drawn.plot(first, second, color="w", markeredgewidth=2.6, **look)
        drawn.plot(first, second, color="k", markeredgewidth=1.2, label=label, **look)
        into = "up into body 1" if names == NAMES else f"down into the {names[0]}"
        labels = [lengths.label(("x", "y", f"z, {into}")[i]) for i in axes]
        title = name + (f" at {words} = {lengths.text(at)}" if words else "")
        drawn.set(xlabel=labels[0], ylabel=labels[1], title=title, aspect="equal")
        style.legend_below(drawn, columns=1)
        figure.draw_without_rendering()
    return figure


def _cut(
    sol: Solution, plane: Any, x: Any, y: Any, depth: Any, side: int
) -> tuple[list[SubsurfaceStress], tuple[int, int], float, str]:
    """Fields where a stress is shown, the two axes of the picture, and the place on the third with
    its name.
    """
    plane = checks.choice("plane", plane, PLANES)
    if sol.scene.line and plane != "xz":
        raise SceneError("plane", plane, '"xz" in line contact, which is the same in all sections')
    for name, value, others in (("x", x, "yz"), ("y", y, "xz")):
        if value is not None and plane != others:
            raise SceneError(name, value, f'left out, or with plane = "{others}"')
    axis = 1 if plane == "yz" else 0
    along = _abscissae(sol, axis)
    length = _cells(sol, axis).size * sol.grid.sides[axis]
    if depth is None:
        depth = (0.25 if plane == "xy" else 0.75) * length
    else:
        depth = checks.number("depth", checks.positive("depth", depth), most=FARTHEST)
    if plane == "xy":
        z = depth if side == 1 else -depth
        first, second = np.meshgrid(along, _abscissae(sol, 1))
        return [stress(sol, [first, second, np.full_like(first, z)], side)], (0, 1), z, "z"
    third, given = "yx"[axis], (y, x)[axis]
    if given is None:  # where the pressure is largest; zero where that is so to rounding
        largest = int(np.argmax(sol.pressure.max(axis=1 - axis)))
        at = float((sol.grid.y, sol.grid.x)[axis][largest])
        at = 0.0 if abs(at) < 1e-9 * sol.grid.sides[1 - axis] else at
    else:
        at = checks.number(third, given, most=FARTHEST)
    fields = []
    for half, sign in ((1, 1.0), (2, -1.0)):
        z, place = np.meshgrid(
            sign * depth * np.linspace(0, 1, LAYERS) ** 1.5, along, indexing="ij"
        )
        points = [place, np.full_like(z, at), z] if axis == 0 else [np.full_like(z, at), place, z]
        fields.append(stress(sol, points, half))
    return fields, (axis, 2), at, "" if sol.scene.line else third


def _cells(sol: Solution, axis: int) -> np.ndarray:
    """Numbers of the columns (`axis` 0) or rows (1) from the first to the last with contact."""
    contact = np.flatnonzero((sol.pressure > 0).any(axis=axis))
    return np.arange(contact[0], contact[-1] + 1)


def _abscissae(sol: Solution, axis: int) -> np.ndarray:
    """Coordinates below element centres, half a contact's length beyond it on both sides; `axis` as
    of `_cells`.
    """
    side, first = sol.grid.sides[axis], (sol.grid.x, sol.grid.y)[axis][0]
    cells = _cells(sol, axis)
    every = max(1, int(np.ceil(cells.size / ACROSS)))
    beyond = (cells.size // 2 + 1) // every * every
    return np.asarray(first + np.arange(cells[0] - beyond, cells[-1] + beyond + 1, every) * side)
