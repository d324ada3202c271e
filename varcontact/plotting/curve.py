"""Creep-force curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.plotting.quantities import Measure, measure, measure_of
from varcontact.plotting.style import COLUMN, MARKERS, colour, figure_of, legend_below, new_figure, settle, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from varcontact.results.solution import Solution

CREEPAGES = {"vx": ("longitudinal creepage", "1"), "vy": ("lateral creepage", "1"), "spin": ("spin", "spin")}
SHIFTS = {"vx": ("shift along x", "length"), "vy": ("shift along y", "length"), "spin": ("rotation", "1")}
STYLES = ("-", "--", ":")


def plot_curve(
    solutions: Sequence[Solution] | Mapping[str, Sequence[Solution]] | xr.Dataset,
    *,
    against: str = "auto",
    normalised: bool = True,
    ax: Axes | None = None,
    figsize: tuple[float, float] | None = None,
) -> Figure:
    """Creep-force curves: the tangential forces, with the sign turned, against a creepage.

    Parameters
    ----------
    solutions : sequence of Solution, or dict of str to such, or xarray.Dataset
        As `scan` gives them; several curves by name; or as `creep_curve` gives them, whose values are plain numbers
        without units.
    against : str
        "vx", "vy" or "spin" (of a shift ux, uy or the rotation); "auto": the one that changes most.
    normalised : bool
        Whether forces are shown as parts of what friction can carry, ``sum(f pz) dx dy`` (without slip: of the normal
        force).
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
        For what are no solutions with a motion, or not all rolling or all shifts, or a creepage that there is not.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30), normal_force=106.7e3,
    ...     friction=0.33, motion=vc.Steady(), grid=vc.Grid(nx=10, ny=10), units=vc.SI)
    >>> curve = vc.scan(scene, [(vx, 0.0, 0.0) for vx in (0.0, 1e-3, 2e-3, 6e-3)])
    >>> figure = vc.plot_curve(curve)
    >>> figure.axes[0].get_xlabel()
    'longitudinal creepage [$10^{-3}$]'
    """
    from varcontact.plotting.solution import check_axes, figure_size
    from varcontact.plotting.ticks import readable_ticks

    normalised = checks.flag("normalised", normalised)
    check_axes(ax)
    size = (COLUMN * 1.15, 2.9) if figsize is None else figure_size(figsize)
    if hasattr(solutions, "data_vars"):
        return _plot_dataset(solutions, against, normalised, ax, size)
    curves = _curves(solutions)
    every = [sol for curve in curves.values() for sol in curve]
    name = _abscissa(every, checks.choice("against", against, ("auto", *CREEPAGES)))
    shown = _components(every)
    shift = _shift(every[0])
    words, quantity = (SHIFTS if shift else CREEPAGES)[name]
    scene = every[0].scene
    values = [getattr(sol, name) for sol in every]
    along = measure("1", None, values) if quantity == "1" else measure_of(scene, quantity, values)
    force = Measure(1.0, "") if normalised else measure_of(scene, "force", [sol.force for sol in every])
    with styled():
        if ax is None:
            _, (ax,) = new_figure(1, 1, size)
        for i, (label, curve) in enumerate(curves.items()):
            x = along([getattr(sol, name) for sol in curve])
            forces = np.array([-sol.force / (_limit(sol) if normalised else 1.0) for sol in curve])
            _draw(ax, x, force(forces), label, i, shown, len(curves) > 1)
        if normalised:
            ax.axhline(1.0, color="0.45", linewidth=0.8, linestyle=(0, (1, 2)))
            ax.set_ylabel(f"tangential force / {_limit_in_words(every[0])}")
        else:
            ax.set_ylabel(force.label("tangential force"))
        ax.axhline(0.0, color="k", linewidth=0.5)
        ax.set_xlabel(along.label(words))
        readable_ticks(ax)
        legend_below(ax, columns=2)
        settle(figure_of(ax))
    return figure_of(ax)


def _curves(solutions: Any) -> dict[str, list[Solution]]:
    """Curves by name, checked, each in the order in which it was given."""
    from varcontact.results.solution import Solution

    curves = dict(solutions) if isinstance(solutions, Mapping) else {"": solutions}
    allowed = "a list of solutions that all roll or all shift, as scan gives them, or a dict of such by name"
    for curve in curves.values():
        if not isinstance(curve, Sequence) or not curve or not all(isinstance(sol, Solution) for sol in curve):
            raise SceneError("solutions", solutions, allowed)
    motions = [sol.motion for curve in curves.values() for sol in curve]
    if not motions or any(motion is None for motion in motions) or len({motion.rolls == 0 for motion in motions}) > 1:
        raise SceneError("solutions", solutions, allowed)
    return {str(label): list(curve) for label, curve in curves.items()}


def _shift(sol: Solution) -> bool:
    return sol.motion is not None and sol.motion.rolls == 0


def _abscissa(every: list[Solution], against: str) -> str:
    """The creepage that changes most, spin by what it does at the edge of the contact."""
    if against != "auto":
        return against
    reach = max(max(abs(end) for end in sol.grid.box[:2]) for sol in every)
    values = np.array([sol.creepage for sol in every]) * (1.0, 1.0, reach)
    spread = np.nan_to_num(np.nanmax(values, axis=0) - np.nanmin(values, axis=0))
    return list(CREEPAGES)[int(np.argmax(spread))]


def _components(every: list[Solution]) -> tuple[int, ...]:
    """The directions in which there are forces."""
    forces = np.abs([sol.force for sol in every]).max(axis=0)
    return tuple(i for i in (0, 1) if forces[i] > 1e-6 * forces.max()) or (0,)


def _limit(sol: Solution) -> float:
    limit = float(np.sum(sol.traction_bound) * sol.grid.area)
    return limit if 0 < limit < np.inf else sol.normal_force


def _limit_in_words(sol: Solution) -> str:
    return "normal force" if sol.scene.no_slip or sol.scene.frictionless else "friction's limit"


def _plot_dataset(found: Any, against: str, normalised: bool, ax: Axes | None, size: tuple[float, float]) -> Figure:
    """The curves of `creep_curve`: a line for each method, and each direction in which there are forces."""
    from varcontact.plotting.ticks import readable_ticks

    if not {"Fx", "Fy", *CREEPAGES} <= {str(name) for name in found.variables} or found.Fx.dims != ("theory", "point"):
        raise SceneError("solutions", type(found), message="solutions: not a dataset of creep_curve")
    limit = float(found.attrs.get("limit", np.nan))
    if normalised and not limit > 0:
        message = "normalised: these curves have no single limit of friction; give normalised=False"
        raise SceneError("normalised", normalised, message=message)
    spread = {name: float(np.ptp(found[name].values)) for name in CREEPAGES}
    # lengths are unknown here: creepages come before the spin
    moving = [name for name in ("vx", "vy") if spread[name] > 0] or ["spin"]
    name = against if against != "auto" else max(moving, key=lambda key: spread[key])
    along = measure("1", None, found[name].values)
    forces = -np.stack([found.Fx.values, found.Fy.values], axis=-1) / (limit if normalised else 1.0)
    largest = np.nanmax(np.abs(forces), axis=(0, 1))
    shown = tuple(i for i in (0, 1) if largest[i] > 1e-6 * largest.max()) or (0,)
    labels = [str(label) for label in found.theory.values]
    with styled():
        if ax is None:
            _, (ax,) = new_figure(1, 1, size)
        for i, label in enumerate(labels):
            _draw(ax, along(found[name].values), forces[i], label, i, shown, len(labels) > 1)
        if normalised:
            ax.axhline(1.0, color="0.45", linewidth=0.8, linestyle=(0, (1, 2)))
        force = "tangential force" if len(shown) == 2 else f"$-F_{'xy'[shown[0]]}$"
        ax.set_ylabel(f"{force} / friction's limit" if normalised else force)
        ax.axhline(0.0, color="k", linewidth=0.5)
        ax.set_xlabel(along.label(CREEPAGES[name][0]))
        readable_ticks(ax)
        legend_below(ax, columns=2)
        settle(figure_of(ax))
    return figure_of(ax)


def _draw(
    ax: Axes, x: np.ndarray, forces: np.ndarray, label: str, number: int, components: tuple[int, ...], several: bool
) -> None:
    """One curve: a line for each direction in which there are forces, and for both together."""
    lines = [(f"$-F_{'xy'[i]}$", forces[:, i]) for i in components]
    if len(components) == 2:
        lines.append(("$|F|$", np.hypot(*forces.T)))
    for j, (part, values) in enumerate(lines):
        marker = MARKERS[(number if several else j) % len(MARKERS)]
        words = f"{label}: {part}" if label and len(lines) > 1 else label or part
        style: dict[str, Any] = {"marker": marker, "linestyle": STYLES[j], "color": colour(number if several else j)}
        ax.plot(x, values, markevery=max(1, len(x) // 12), label=words, **style)
