"""Pictures of the stress below the surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.plotting.quantities import Measure, measure_of
from varcontact.plotting.style import COLUMN, colour_bar, figure_of, legend_below, new_figure, settle, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from varcontact.results.solution import Solution
    from varcontact.results.stress import SubsurfaceStress

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


def plot_stress(
    sol: Solution,
    quantity: str = "von_mises",
    *,
    plane: str = "xz",
    x: float | None = None,
    y: float | None = None,
    depth: float | None = None,
    body: int | str = 1,
    ax: Axes | None = None,
    figsize: tuple[float, float] | None = None,
) -> Figure:
    """Contours of a stress in a section of both bodies, the upper above the surface, or at one depth of one body.

    The largest is marked, of a component the largest in size.

    Parameters
    ----------
    sol : Solution
    quantity : str
        "von_mises", "tresca", "ideal_stress", "first_invariant", or a component: "xx", "yy", "zz", "xy", "xz", "yz".
    plane : str
        "xz": a section along x; "yz": a section across it; "xy": a plane parallel to the surface.
    x, y : float, optional
        Of the section across the other axis [length]; where the pressure is largest if not given.
    depth : float, optional
        Of a section: shown in either body [length]; three quarters of the contact's length in it if not given. Of the
        plane "xy": its distance from the surface [length]; a quarter of the contact's length along x if not given.
    body : 1, 2, "upper" or "lower"
        Of the plane "xy".
    ax : matplotlib Axes, optional
        Where to draw; a new figure if not given.
    figsize : pair of float, optional
        Of a new figure [inch].

    Returns
    -------
    matplotlib Figure
        Outside pyplot: a notebook shows it, ``savefig`` writes it; for a window give an `ax` of pyplot.

    Raises
    ------
    SceneError
        For what is no Solution with contact, a quantity or a plane that does not exist, a depth that is not positive,
        a place that does not belong to the plane, or another plane than "xz" in line contact.
    """
    from matplotlib.ticker import MaxNLocator

    from varcontact.plotting.solution import check_axes, figure_size
    from varcontact.plotting.ticks import readable_ticks
    from varcontact.results.stress import one_solution

    if not one_solution(sol).pressure.any():
        raise SceneError(
            "solution", sol, "with contact", message="solution: there is no contact, so nothing is stressed"
        )
    checks.choice("quantity", quantity, [*STRESSES, *COMPONENTS])
    check_axes(ax)
    size = (COLUMN * 1.25, COLUMN) if figsize is None else figure_size(figsize)
    cut = _cut(sol, plane, x, y, depth, body)
    signed = quantity in COMPONENTS
    values = [_stress_value(part, quantity) for part in cut.parts]
    everything = np.concatenate([part.ravel() for part in values])
    lengths = measure_of(sol.scene, "length", np.concatenate([cut.parts[0].points[i].ravel() for i in cut.axes]))
    stresses = measure_of(sol.scene, "pressure", everything)
    shown = stresses(everything)
    levels = MaxNLocator(20, symmetric=signed).tick_values(shown.min(), shown.max())
    with styled():
        if ax is None:
            _, (ax,) = new_figure(1, 1, size)
        for part, value in zip(cut.parts, values, strict=True):
            first, second = (lengths(part.points[i]) for i in cut.axes)
            image = ax.contourf(first, second, stresses(value), levels, cmap="RdBu_r" if signed else "viridis")
            ax.contour(first, second, stresses(value), levels[::2], colors="k", linewidths=0.3, linestyles="solid")
        colour_bar(ax, image, stresses.label(_stress_name(quantity)))
        if plane == "xy":
            _draw_outline(ax, sol, lengths)
        else:
            _draw_surface(ax, sol, cut.axes[0], lengths)
        _mark_largest(ax, cut, values, lengths, stresses)
        names = ("x", "y", "z, up into body 1")
        ax.set_xlabel(lengths.label(names[cut.axes[0]]))
        ax.set_ylabel(lengths.label(names[cut.axes[1]]))
        ax.set_title(_stress_name(quantity) + cut.place(lengths))
        readable_ticks(ax)
        ax.set_aspect("equal")
        legend_below(ax, columns=1)
        settle(figure_of(ax))
    return figure_of(ax)


@dataclass(frozen=True)
class _Cut:
    """Where a stress is shown: the fields there, the two axes of the picture, and the words for the third."""

    parts: tuple[SubsurfaceStress, ...]
    axes: tuple[int, int]
    at: float
    words: str

    def place(self, lengths: Measure) -> str:
        """For a title."""
        return f"{self.words}{lengths.text(self.at)}" if self.words else ""


def _cut(sol: Solution, plane: Any, x: Any, y: Any, depth: Any, body: Any) -> _Cut:
    """The stresses in a plane."""
    from varcontact.results.stress import BODIES, stress

    plane = checks.choice("plane", plane, PLANES)
    if sol.scene.line and plane != "xz":
        raise SceneError("plane", plane, '"xz" in line contact, which is the same in all sections')
    for name, value, others in (("x", x, "yz"), ("y", y, "xz")):
        if value is not None and plane != others:
            raise SceneError(name, value, f'left out, or with plane = "{others}"')
    along, across = _abscissae(sol, 1), _abscissae(sol, 0)
    (dx, dy) = sol.grid.sides
    if plane == "xy":
        if isinstance(body, bool) or not isinstance(body, (int, str)) or body not in BODIES:
            raise SceneError("body", body, 'one of 1 or "upper", 2 or "lower"')
        length = _cells(sol, 1).size * dx
        below = 0.25 * length if depth is None else _coordinate("depth", checks.positive("depth", depth))
        first, second = np.meshgrid(along, across)
        side = BODIES[body]
        z = below if side == 1 else -below
        field = stress(sol, [first, second, np.full_like(first, z)], side)
        return _Cut((field,), (0, 1), z, " at z = ")
    places, length, axis = (
        (along, _cells(sol, 1).size * dx, 0) if plane == "xz" else (across, _cells(sol, 0).size * dy, 1)
    )
    depth = 0.75 * length if depth is None else _coordinate("depth", checks.positive("depth", depth))
    given = (x, y)[1 - axis]
    at = _largest_place(sol)[1 - axis] if given is None else _coordinate("xy"[1 - axis], given)
    fields = []
    for side, sign in ((1, 1.0), (2, -1.0)):
        z, place = np.meshgrid(sign * depth * np.linspace(0, 1, LAYERS) ** 1.5, places, indexing="ij")
        points = [place, np.full_like(z, at), z] if axis == 0 else [np.full_like(z, at), place, z]
        fields.append(stress(sol, points, side))
    words = "" if sol.scene.line else f" at {'xy'[1 - axis]} = "
    return _Cut(tuple(fields), (axis, 2), at, words)


def _coordinate(name: str, value: Any) -> float:
    """Of points at which there are stresses."""
    from varcontact.results.stress import FARTHEST

    return checks.moderate(name, value, most=FARTHEST)


def _largest_place(sol: Solution) -> tuple[float, float]:
    """x and y of the element with the largest pressure; zero where it is so to rounding."""
    column = int(np.argmax(sol.pressure.max(axis=0)))
    row = int(np.argmax(sol.pressure.max(axis=1)))
    places = (float(sol.grid.x[column]), float(sol.grid.y[row]))
    x, y = (0.0 if abs(place) < 1e-9 * side else place for place, side in zip(places, sol.grid.sides, strict=True))
    return x, y


def _cells(sol: Solution, axis: int) -> np.ndarray:
    """Numbers of the columns (`axis` 1) or rows (0) from the first to the last with contact."""
    contact = np.flatnonzero((sol.pressure > 0).any(axis=1 - axis))
    return np.arange(contact[0], contact[-1] + 1)


def _abscissae(sol: Solution, axis: int) -> np.ndarray:
    """Coordinates below element centres, half a contact's length beyond it on both sides; `axis` as of `_cells`."""
    side, first = (sol.grid.sides[0], sol.grid.x[0]) if axis == 1 else (sol.grid.sides[1], sol.grid.y[0])
    cells = _cells(sol, axis)
    every = max(1, int(np.ceil(cells.size / ACROSS)))
    beyond = (cells.size // 2 + 1) // every * every
    return np.asarray(first + np.arange(cells[0] - beyond, cells[-1] + beyond + 1, every) * side)


def _draw_surface(ax: Axes, sol: Solution, axis: int, lengths: Measure) -> None:
    """The surface, and the contact on it as a bar."""
    places = (sol.grid.x, sol.grid.y)[axis][_cells(sol, 1 - axis)]
    half = sol.grid.sides[axis] / 2
    ax.axhline(0, color="0.35", linewidth=0.6)
    ends = lengths([places[0] - half, places[-1] + half])
    ax.plot(ends, [0, 0], color="k", linewidth=2.5, solid_capstyle="butt", label="contact")


def _draw_outline(ax: Axes, sol: Solution, lengths: Measure) -> None:
    """The contact above or below."""
    shape = sol.pressure > 0
    x, y = lengths(sol.grid.x), lengths(sol.grid.y)
    for colour, width, style in (("w", 1.8, "solid"), ("k", 0.9, "dashed")):  # black on white: seen on all colours
        ax.contour(x, y, shape.astype(float), [0.5], colors=colour, linewidths=width, linestyles=style)
    ax.plot([], [], color="k", linewidth=0.9, linestyle="dashed", label="contact")


def _mark_largest(ax: Axes, cut: _Cut, values: list[np.ndarray], lengths: Measure, stresses: Measure) -> None:
    """A cross where the stress is largest in size, with its value and place in the legend."""
    part = max(range(len(values)), key=lambda k: float(np.abs(values[k]).max()))
    place = int(np.abs(values[part]).argmax())
    points = [float(each.flat[place]) for each in cut.parts[part].points]
    value = float(values[part].flat[place])
    first, second = (points[i] for i in cut.axes)
    names = ["xyz"[i] for i in cut.axes]
    where = (
        f"({names[0]}, {names[1]}) = ({lengths(first) + 0.0:.3g}, {lengths(second) + 0.0:.3g}) {lengths.unit}".rstrip()
    )
    words = "largest" if value > 0 or value == 0 else "largest in size"
    label = f"{words}: {stresses.text(value, 4)} at {where}"
    look: dict[str, Any] = {"color": "w", "marker": "+", "markersize": 8, "markeredgewidth": 2.6, "ls": ""}
    ax.plot(lengths(first), lengths(second), **look, clip_on=False)
    ax.plot(
        lengths(first), lengths(second), **look | {"color": "k", "markeredgewidth": 1.2}, label=label, clip_on=False
    )


def _stress_value(field: SubsurfaceStress, quantity: str) -> np.ndarray:
    if quantity in STRESSES:
        return np.asarray(getattr(field, quantity))
    i, j = ("xyz".index(letter) for letter in quantity)
    return np.asarray(field.stress[i, j])


def _stress_name(quantity: str) -> str:
    return STRESSES.get(quantity, f"$\\sigma_{{{quantity}}}$")
