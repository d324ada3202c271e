"""Pictures of how solvers converge: residuals, gaps or objectives by iteration and by second."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.plotting import style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FigureName = Literal["residual", "gap", "objective", "changes"]
"""Figures of an iterate."""
FIGURES = {
    "residual": "residual of the natural map",
    "gap": "duality gap",
    "objective": "objective of the program",
    "changes": "elements that changed area",
}
SHOWN_MIN = 1e-17
"""Residuals and gaps below this are rounding; they are drawn at it."""


@checks.named_options()
def plot_traces(
    trace: Any,
    what: FigureName = "residual",
    *,
    problem: str | None = None,
    figsize: tuple[float, float] | None = None,
) -> Figure:
    """Plot the convergence of solvers: their iterates by iteration, and by second.

    Parameters
    ----------
    trace : Solution, Comparison, xarray.Dataset, or dict of str to Dataset
        Solved, or compared, with ``trace=True``; or traces by name.
    what : {"residual", "gap", "objective", "changes"}
    problem : str, optional
        "normal", "tangential" or "both"; the last that was solved if not given.
    figsize : (float, float), optional
        [inch]

    Returns
    -------
    matplotlib Figure
        One line for each call of a solver that has the figure.

    Raises
    ------
    SceneError
        For what has no trace, another figure, or a problem without iterates.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    ...     friction=0.3, motion=vc.Steady(vx=0.05), grid=vc.Grid(nx=10, ny=10))
    >>> sol = vc.solve(scene, tangential="newton", trace=True)
    >>> figure = vc.plot_traces(sol)
    >>> len(figure.axes), bool(sol.trace.residual[-1] < 1e-8)
    (2, True)
    """
    checks.choice("what", what, FIGURES)
    traces = _traces(trace)
    if problem is None:
        problem = str(list(traces.values())[-1]["problem"].values[-1])
    lines = [line for name, each in traces.items() for line in _lines(name, each, what, problem)]
    if not lines:
        found = sorted({str(each) for data in traces.values() for each in data["problem"].values})
        raise SceneError("problem", problem, f"one with this figure: {', '.join(found)}")
    abscissas = ("iteration", "second")
    with style.styled():
        figure, axes = style.new_panels(2, 3.4, figsize, abscissas)
        for ax, by in zip(axes, abscissas, strict=False):
            _draw(ax, lines, by, what)
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, ncols=min(len(lines), 4), loc="outside lower center")
    return figure


def _traces(trace: Any) -> Mapping[str, xr.Dataset]:
    """Traces by name, of what has some."""
    import xarray as xr

    found = trace
    if not isinstance(found, xr.Dataset | Mapping):
        found = getattr(trace, "traces", None)
        if found is None:
            found = getattr(trace, "trace", None)
    if isinstance(found, xr.Dataset):
        found = {"": found}
    if isinstance(found, Mapping):
        found = {str(name): each for name, each in found.items() if _has_iterates(each)}
    if not isinstance(found, Mapping) or not found:
        allowed = "what was solved or compared with trace=True, and has iterates"
        raise SceneError("trace", type(trace).__name__, allowed)
    return cast("Mapping[str, xr.Dataset]", found)


def _has_iterates(each: Any) -> bool:
    import xarray as xr

    return isinstance(each, xr.Dataset) and each.sizes.get("iterate", 0) > 0


def _lines(
    name: str, trace: xr.Dataset, what: str, problem: str
) -> Iterator[tuple[str, dict[str, np.ndarray]]]:
    """A label and the values of each call of a solver that has the figure."""
    chosen = trace.isel(iterate=np.flatnonzero(trace["problem"].values == problem))
    for number in np.unique(chosen["call"].values):
        call = chosen.isel(iterate=np.flatnonzero(chosen["call"].values == number))
        values = call[what].values
        seen = np.isfinite(values)
        if not seen.any():
            continue
        label = str(call["solver"].values[0])
        if name and name != label:
            label = f"{name}: {label}"
        columns = {each: call[each].values[seen] for each in ("iteration", "second")}
        yield label, {**columns, what: values[seen]}


def _draw(ax: Axes, lines: list[tuple[str, dict[str, np.ndarray]]], by: str, what: str) -> None:
    for label, columns in lines:
        values = columns[what]
        if what in ("residual", "gap"):
            values = np.maximum(values, SHOWN_MIN)
        ax.plot(columns[by], values, marker=".", label=label)
    if what in ("residual", "gap"):
        ax.set_yscale("log")
    ax.set_xlabel({"iteration": "iteration", "second": "time [s]"}[by])
    ax.set_ylabel(FIGURES[what])
