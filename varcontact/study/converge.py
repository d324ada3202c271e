"""One scene on finer and finer grids: limits of its forces and areas, order of convergence,
cost.
"""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.discrete.contact_grid import Box, contact_box, within
from varcontact.errors import SceneError, SolverUnavailable, TooLarge
from varcontact.scene.grid import Grid, usual_grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.solving.pipeline import check_fits
from varcontact.solving.solve import solve
from varcontact.study.convergence import COLUMNS, WORDS, Convergence
from varcontact.study.csv_table import Table, identity, of_another
from varcontact.study.methods import BOUNDS, Method, attempted, figures
from varcontact.study.parallel import Execution, traced
from varcontact.system.process import imported
from varcontact.system.progress import Progress

DEFAULT_METHOD = "tang-safeguarded"
TANGENTIAL = (
    "Fx",
    "Fy",
    "Mz",
    "vx",
    "vy",
    "spin",
    "traction_norm",
    "stick_area",
    "slip_area",
    *BOUNDS,
)
"""Columns for scenes with a motion alone."""
MOST_OFFSETS = 1000
"""Largest number of offsets of one grid: their mean has no significant noise left."""


@checks.named_options()
def converge(
    scene: Scene,
    cells: Iterable[int],
    method: str | Iterable[str] = DEFAULT_METHOD,
    *,
    offsets: int = 4,
    tol: float = 1e-6,
    store: str | Path | None = None,
    progress: Progress = None,
    executor: Executor | None = None,
    workers: int = 1,
) -> Convergence:
    """Solve a scene on a sequence of grids, fit the order of convergence, and extrapolate.

    Parameters
    ----------
    scene : Scene
        Its grid is replaced, but for margin, edge and course of tractions. Friction must be a
        number, a sampled distance have coordinates.
    cells : iterable of int
        Elements across the contact in both directions, increasing; three grids
        at least for an order.
    method : str or iterable of str
        One method or several, as `compare` names them.
    offsets : int
        Solves of each grid, with the lattice moved by different fractions of an
        element: their mean has less of the noise of the contact's staircase
        edge, their spread measures it. 1: the plain grid alone.
    tol : float
        Natural-map residual at which an answer counts as solved.
    store : str or Path, optional
        A CSV file, written after each solve. Solves that it holds are not
        repeated. More grids, methods or offsets may be added.
    progress : callable or true, optional
        Called with what is solved next.
    executor, workers
        As in `sweep`. Solves are then finished in any order, and their seconds
        are of shared processors.

    Returns
    -------
    Convergence
        All solves, means over the offsets, orders and extrapolated values. A
        method that fails on a grid is recorded there with the reason, and the
        rest go on.

    Raises
    ------
    SceneError
        For cells that do not refine, methods that do not exist, scenes that are
        tied to one grid, or a store of another study, before any work starts.
    Interrupted
        On Ctrl-C: its `partial` is the Convergence of what was finished.
    TooLarge
        If a method is known to need more memory than there is on one of the
        grids, before any work starts.
    OutputError
        If the store cannot be written, or another process writes to it; it is
        left as it was.

    Notes
    -----
    The bounding box of the contact is the same for all grids: of Hertz's ellipse, or of the
    frictionless contact on the automatic grid. Steps ``dq`` of steady rolling that are not given
    are the element's side, and shrink with it.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Paraboloids(Rx=1.0, Ry=1.0),
    ...     normal_force=1e-3)
    >>> study = vc.converge(scene, [8, 12, 16], method="norm")
    >>> limit = study.limit("approach")
    >>> abs(limit["value"] - scene.hertz.approach) < limit["error"] < 1e-2 * scene.hertz.approach
    True
    """
    checks.kind("scene", scene, Scene)
    numbers = _finer_and_finer(cells)
    methods = _methods(method)
    offsets = checks.whole("offsets", offsets, most=MOST_OFFSETS)
    tol = checks.positive("tol", tol)
    execution = Execution(executor, workers, checks.progress(progress))
    _check_refinable(scene)
    key = identity(replace(scene, grid=_spec(scene, 1)), tol)
    total = len(numbers) * len(methods) * offsets
    study = partial(
        Convergence.of,
        cells=numbers,
        methods=[each.name for each in methods],
        offsets=offsets,
        shift=isinstance(scene.motion, Shift),
    )
    imported("pandas")  # imported now: after Ctrl-C the import would have to be waited for
    with Table.opened(store, COLUMNS, WORDS, "a table of an earlier study of convergence") as table:
        if any(row["identity"] != key for row in table.rows):
            raise of_another(store, "holds a study of another scene or tol")
        finished = {(row["cells"], row["method"], row["offset"]) for row in table.rows}
        for n, each in product(numbers, methods):
            if (n, each.name, 0) not in finished:
                _check_memory(replace(scene, grid=_spec(scene, n + (offsets > 1))), each, n)
        tasks: dict[str, tuple[Any, ...]] = {}
        box = contact_of(scene)
        for k, (n, each, i) in enumerate(product(numbers, methods, range(offsets)), 1):
            if (n, each.name, i) in finished:
                continue
            place = (0.0, 0.0) if offsets == 1 else offset(n, i)
            on_grid = replace(scene, grid=lattice(scene, box, n, place))
            name = f"{k} of {total}: {each.name}, {n} cells, offset {i + 1} of {offsets}"
            tasks[name] = (on_grid, each, tol, n, i, key)
        return table.fill(_rows, tasks, execution, study, total, "solves")


def _finer_and_finer(cells: Iterable[int]) -> list[int]:
    numbers = checks.wholes("cells", cells, least=2)
    if not numbers or any(after <= before for before, after in pairwise(numbers)):
        raise SceneError("cells", numbers, "a sequence of grids, each finer than the one before")
    return numbers


def _methods(names: Any) -> list[Method]:
    if not isinstance(names, Iterable):
        raise SceneError("method", names, "a name, or a list of names")
    if isinstance(names, str):
        names = [names]
    methods = [Method.named(name) for name in names]
    if not methods:
        raise SceneError("method", names, "at least one name")
    return methods


def _check_refinable(scene: Scene) -> None:
    """Refuse histories, and scenes that are tied to one grid."""
    if not isinstance(scene.motion, Steady | Shift | None):
        raise SceneError(
            "motion", scene.motion, "Steady, Shift or none: convergence is studied on one problem"
        )
    if checks.is_array(scene.friction):
        raise SceneError("friction", "an array", "a number or a law: an array fits one grid only")
    if isinstance(scene.surface, SampledDistance) and scene.surface.x is None:
        raise SceneError("surface.x", None, "given: samples without coordinates fit one grid only")


def _check_memory(scene: Scene, method: Method, cells: int) -> None:
    """Refuse a method that needs more memory than there is; other errors are for the table."""
    try:
        check_fits(scene, method.plan(scene))
    except TooLarge as error:
        what = f"cells = {cells}: {method.name}"
        remedy = "leave these cells out, or the method"
        raise TooLarge(what, error.needed, error.available, remedy) from None
    except (SceneError, SolverUnavailable):
        pass


def _rows(
    scene: Scene, method: Method, tol: float, cells: int, offset: int, key: str
) -> list[dict[str, Any]]:
    """The one row of a solve; the first of each grid is traced for its memory."""
    solving = partial(attempted, scene, method, tol, [scene.motion])
    memory = np.nan
    if offset == 0:
        (outcome, reason, solutions), memory = traced(solving)
    else:
        outcome, reason, solutions = solving()
    row: dict[str, Any] = {}
    for sol in solutions:
        row |= {
            **figures(sol),
            "pressure_norm": float(np.sqrt(np.sum(sol.pressure**2) * sol.grid.area)),
            "traction_norm": float(np.sqrt(np.sum(sol.traction**2) * sol.grid.area)),
            "elements": sol.elements["contact"],
            "seconds": sol.timing["total"],
            **dict(zip(BOUNDS, map(float, sol.certificate.force_bound), strict=True)),
        }
    if scene.motion is None:
        row = {name: value for name, value in row.items() if name not in TANGENTIAL}
    row |= {
        "method": method.name,
        "cells": cells,
        "offset": offset,
        "identity": key,
        "memory": memory,
    }
    return [row | {"outcome": outcome, "reason": reason} | _staircase(scene)]


def _spec(scene: Scene, elements: int) -> Grid:
    """A grid with the scene's margin, edge and course of tractions, one more where the contact is
    not known exactly.
    """
    own = scene.grid if isinstance(scene.grid, Grid) else Grid(nx=1)
    margin = own.margin
    if scene.hertz is None or scene.coupled:
        margin = margin + 1
    grid = Grid(nx=elements, margin=margin, edge=own.edge, tractions=own.tractions)
    if scene.line:
        return grid
    return replace(grid, ny=elements)


def contact_of(scene: Scene) -> Box:
    """Bounding box of the contact: Hertz's, or that of the frictionless contact on the automatic
    grid.
    """
    if scene.hertz is not None:
        return -scene.hertz.a, scene.hertz.a, -scene.hertz.b, scene.hertz.b
    frictionless = solve(
        replace(scene, motion=None, friction=None, grid=usual_grid(scene.line)), normal="norm"
    )
    return contact_box(frictionless.grid, frictionless.pressure)


def offset(cells: int, i: int) -> tuple[float, float]:
    """The i-th displacement of a lattice along x and y, in fractions of an element.

    Evenly spread points of the plane (an additive recurrence with powers of the plastic number),
    begun elsewhere on each grid, so that the noise of one grid does not repeat on the next.
    """
    x = (i * 0.7548776662466927 + cells * 0.6180339887498949) % 1
    return x, (i * 0.5698402909980532 + cells * 0.4142135623730951) % 1


def lattice(scene: Scene, box: Box, cells: int, place: tuple[float, float]) -> Grid:
    """A lattice with `cells` elements across a box, and the margin, moved left and down by
    fractions of an element.
    """
    left, right, bottom, top = box
    dx = (right - left) / cells
    dy = (top - bottom) / cells
    left = left - place[0] * dx
    bottom = bottom - place[1] * dy
    elements = cells + 1 if any(place) else cells
    covered = (left, left + elements * dx, bottom, bottom + elements * dy)
    grid = _spec(scene, elements).spread(covered)
    if isinstance(scene.surface, SampledDistance):
        return within(grid, scene.surface)
    return grid


def _staircase(scene: Scene) -> dict[str, float]:
    """Error of the elements in Hertz's ellipse: area, first and second moments, less the exact
    ones; dimensionless.

    Averaged over all positions of the lattice each is zero, and nearly all the noise of forces is
    proportional to them. Nothing, where every element that the ellipse touches is in contact.
    """
    hertz = scene.hertz
    grid = scene.own_grid
    if hertz is None or grid.edge != "centres":
        return {}
    x, y = np.meshgrid(grid.x / hertz.a, grid.y / hertz.b)
    inside = x**2 + y**2 < 1
    area = grid.sides[0] / hertz.a
    exact: dict[str, tuple[np.ndarray, float]]
    if scene.line:
        exact = {"": (inside, 2.0), "_x": (x, 0.0)}
    else:
        area = area * (grid.sides[1] / hertz.b)
        exact = {
            "": (inside, np.pi),
            "_x": (x, 0.0),
            "_y": (y, 0.0),
            "_xx": (x**2, np.pi / 4),
            "_yy": (y**2, np.pi / 4),
        }
    return {
        f"staircase{name}": float(np.sum(values[inside]) * area - integral)
        for name, (values, integral) in exact.items()
    }
