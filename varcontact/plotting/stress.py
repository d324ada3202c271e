"""Pictures of the stress below the surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.plotting import style
from varcontact.plotting.unit_labels import Measure, measure
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
SECTION_DEPTHS = 25
"""Depths of a section in each body."""
POINTS_ACROSS = 40
"""Largest number of points across the contact."""


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
        Place of the section across the other axis [length]; where the pressure is
        largest if not given.
    depth : float, optional
        Depth of a section that is shown in either body [length]; three quarters of the
        contact's length in it if not given. Of the plane "xy": its distance
        from the surface [length]; a quarter of the contact's length along x if
        not given.
    body : 1, 2, "upper" or "lower"
        Body of the plane "xy"; under a wheel 1, 2, "rail" or "wheel".
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
        if checks.choice("plane", plane, PLANES) == "xy":
            section = _parallel_plane(sol, x, y, depth, side)
        else:
            section = _cut(sol, plane, x, y, depth)
        values = np.stack([_values(field, quantity) for field in section.fields])
        places = np.stack([[field.points[i] for field in section.fields] for i in section.axes])
        lengths = measure(sol.scene, "length", places)
        stresses = measure(sol.scene, "pressure", values)
        name = STRESSES.get(quantity, f"$\\sigma_{{{quantity}}}$")
        image = _draw_contours(drawn, lengths(places), stresses(values), quantity in COMPONENTS)
        style.colour_bar(drawn, image, stresses.label(name))
        if plane == "xy":
            _draw_contact_area(drawn, sol, lengths)
        else:
            _draw_contact_line(drawn, sol, section.axes[0], lengths)
        _mark_largest(drawn, section, values, places, lengths, stresses)
        x_label, y_label = (lengths.label(_axis_name(i, names)) for i in section.axes)
        title = name
        if section.third:
            title += f" at {section.third} = {lengths.text(section.at)}"
        drawn.set(xlabel=x_label, ylabel=y_label, title=title, aspect="equal")
        style.legend_below(drawn, columns=1)
        figure.draw_without_rendering()
    return figure


def _values(field: SubsurfaceStress, quantity: str) -> np.ndarray:
    if quantity in COMPONENTS:
        i, j = ("xyz".index(letter) for letter in quantity)
        return field.stress[i, j]
    return np.asarray(getattr(field, quantity))


def _axis_name(axis: int, names: tuple[str, str]) -> str:
    """Name of an axis of the picture; of z with its direction."""
    if axis < 2:
        return "xy"[axis]
    direction = "up into body 1"
    if names != NAMES:
        direction = f"down into the {names[0]}"
    return f"z, {direction}"


def _draw_contours(ax: Axes, places: np.ndarray, shown: np.ndarray, signed: bool) -> Any:
    """Filled contours of each field and lines on every second level; the last is returned."""
    locator = MaxNLocator(20, symmetric=signed)
    levels = locator.tick_values(float(shown.min()), float(shown.max()))
    colours = "RdBu_r" if signed else "viridis"
    lines: dict[str, Any] = {"colors": "k", "linewidths": 0.3, "linestyles": "solid"}
    for first, second, value in zip(*places, shown, strict=True):
        image = ax.contourf(first, second, value, levels, cmap=colours)
        ax.contour(first, second, value, levels[::2], **lines)
    return image


def _draw_contact_area(ax: Axes, sol: Solution, lengths: Measure) -> None:
    """Contact edge, black on white: visible on all colours."""
    x = lengths(sol.grid.x)
    y = lengths(sol.grid.y)
    inside = (sol.pressure > 0).astype(float)
    ax.contour(x, y, inside, [0.5], colors="w", linewidths=1.8, linestyles="solid")
    ax.contour(x, y, inside, [0.5], colors="k", linewidths=0.9, linestyles="dashed")
    ax.plot([], [], color="k", linewidth=0.9, linestyle="dashed", label="contact")


def _draw_contact_line(ax: Axes, sol: Solution, axis: int, lengths: Measure) -> None:
    """The surface, and the contact on it."""
    cells = _cells(sol, axis)
    ends = lengths(sol.grid.lines[axis][[cells[0], cells[-1] + 1]])
    ax.axhline(0, color="0.35", linewidth=0.6)
    ax.plot(ends, [0, 0], color="k", linewidth=2.5, solid_capstyle="butt", label="contact")


def _mark_largest(
    ax: Axes,
    section: Section,
    values: np.ndarray,
    places: np.ndarray,
    lengths: Measure,
    stresses: Measure,
) -> None:
    """A cross where the stress is largest in size."""
    largest = int(np.abs(values).argmax())
    value = float(values.flat[largest])
    first, second = (float(lengths(each.flat[largest])) + 0.0 for each in places)
    axes = ", ".join("xyz"[i] for i in section.axes)
    place = f"({axes}) = ({first:.3g}, {second:.3g}) {lengths.unit}".rstrip()
    words = "largest"
    if value < 0:
        words += " in size"
    label = f"{words}: {stresses.text(value, 4)} at {place}"
    look: dict[str, Any] = {"marker": "+", "markersize": 8, "ls": "", "clip_on": False}
    ax.plot(first, second, color="w", markeredgewidth=2.6, **look)
    ax.plot(first, second, color="k", markeredgewidth=1.2, label=label, **look)


@dataclass(frozen=True)
class Section:
    """Fields where a stress is shown, the two axes of the picture, and the place on the third axis
    with its name.
    """

    fields: list[SubsurfaceStress]
    axes: tuple[int, int]
    at: float
    third: str


def _left_out(name: str, value: Any, plane: str) -> None:
    """Refuse a place that belongs to another plane."""
    if value is not None:
        raise SceneError(name, value, f'left out, or with plane = "{plane}"')


def _depth(sol: Solution, depth: Any, axis: int, part: float) -> float:
    """Depth given, or a part of the contact's length along an axis."""
    if depth is None:
        return part * (_cells(sol, axis).size * sol.grid.sides[axis])
    return checks.number("depth", checks.positive("depth", depth), most=FARTHEST)


def _parallel_plane(sol: Solution, x: Any, y: Any, depth: Any, side: int) -> Section:
    """Plane parallel to the surface, at a depth of one body."""
    _check_line_contact(sol, "xy")
    _left_out("x", x, "yz")
    _left_out("y", y, "xz")
    depth = _depth(sol, depth, 0, 0.25)
    z = depth if side == 1 else -depth
    first, second = np.meshgrid(_abscissae(sol, 0), _abscissae(sol, 1))
    field = stress(sol, [first, second, np.full_like(first, z)], side)
    return Section([field], (0, 1), z, "z")


def _check_line_contact(sol: Solution, plane: str) -> None:
    if sol.scene.line and plane != "xz":
        raise SceneError("plane", plane, '"xz" in line contact, which is the same in all sections')


def _cut(sol: Solution, plane: str, x: Any, y: Any, depth: Any) -> Section:
    """Section across the surface in both bodies, along x ("xz") or y ("yz")."""
    _check_line_contact(sol, plane)
    axis = PLANES.index(plane)
    if axis == 0:
        _left_out("x", x, "yz")
        third = "y"
        given = y
    else:
        _left_out("y", y, "xz")
        third = "x"
        given = x
    depth = _depth(sol, depth, axis, 0.75)
    if given is None:  # where the pressure is largest; zero where that is so to rounding
        largest = int(np.argmax(sol.pressure.max(axis=1 - axis)))
        at = float((sol.grid.y, sol.grid.x)[axis][largest])
        if abs(at) < 1e-9 * sol.grid.sides[1 - axis]:
            at = 0.0
    else:
        at = checks.number(third, given, most=FARTHEST)
    depths = depth * np.linspace(0, 1, SECTION_DEPTHS) ** 1.5
    fields = []
    for side, heights in ((1, depths), (2, -depths)):
        z, along = np.meshgrid(heights, _abscissae(sol, axis), indexing="ij")
        across = np.full_like(z, at)
        points = [along, across, z] if axis == 0 else [across, along, z]
        fields.append(stress(sol, points, side))
    if sol.scene.line:
        third = ""
    return Section(fields, (axis, 2), at, third)


def _cells(sol: Solution, axis: int) -> np.ndarray:
    """Numbers of the columns (`axis` 0) or rows (1) from the first to the last with contact."""
    contact = np.flatnonzero((sol.pressure > 0).any(axis=axis))
    return np.arange(contact[0], contact[-1] + 1)


def _abscissae(sol: Solution, axis: int) -> np.ndarray:
    """Coordinates below element centres, half a contact's length beyond it on both sides; `axis` as
    of `_cells`.
    """
    side = sol.grid.sides[axis]
    first = (sol.grid.x, sol.grid.y)[axis][0]
    cells = _cells(sol, axis)
    every = max(1, int(np.ceil(cells.size / POINTS_ACROSS)))
    beyond = (cells.size // 2 + 1) // every * every
    return np.asarray(first + np.arange(cells[0] - beyond, cells[-1] + beyond + 1, every) * side)
