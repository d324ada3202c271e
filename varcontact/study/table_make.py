"""Making a table book: exact solutions of all its entries, by a sweep."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError, VarcontactError
from varcontact.io.outputs import check_ending, check_replaceable, check_writable, write_whole
from varcontact.reference.creepage_coefficients import CreepageCoefficients, no_slip_coefficients
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse
from varcontact.solving.solve import solve
from varcontact.study.sweep import Standing, sweep
from varcontact.theories.table_book import (
    HALFWAY,
    TableBook,
    direction_nodes,
    magnitudes,
    ratio_nodes,
    spin_scale,
)
from varcontact.theories.table_splines import local_law, quadrature, splines_through

GRIDS = Grid(nx=12, ny=8), Grid(nx=24, ny=16)
"""Those an entry is extrapolated from."""
ORDER = 2
"""Order of the discretisation."""
HOW = "exact solutions by the discretisation of second order, extrapolated from 12 x 8 and 24 x 16 elements"
TOL = 1e-6
"""Residual of the entries on their grids: far below the grids' own error."""
LEAST_ERROR = 0.004
"""Estimated error of an entry in parts of f Fz: what the extrapolation changes, and at least this."""
PRESSURE = 1e-3
"""Normal force by G ab: of no influence, as all is in proportion to it."""


def make_table_book(
    nu: float,
    *,
    least: float = 0.2,
    greatest: float = 5.0,
    ratios: int = 9,
    steps: int = 11,
    degree: int = 17,
    executor: Executor | None = None,
    workers: int = 1,
    out: str | Path | None = None,
    overwrite: bool = False,
    progress: Callable[[Standing], None] | None = None,
) -> TableBook:
    """Compute a table book.

    Parameters
    ----------
    nu : float
        Combined Poisson's ratio.
    least, greatest : float
        Range of a/b.
    ratios, steps : int
        Ellipses, and magnitudes of creepage in each direction.
    degree : int
        Of polynomials that the directions could determine, odd; 17 takes 145 directions.
    executor, workers
        Where the entries are solved, as for `sweep`.
    out : str or Path, optional
        File of the book (.nc). While it is made, two stores of sweeps stand beside it, from which the same call goes
        on.
    overwrite : bool
        Whether to replace a file that is no table book.
    progress : callable, optional
        Told how far each of the two sweeps is.

    Returns
    -------
    TableBook

    Raises
    ------
    SceneError
        If a number is not allowed.
    OutputError
        If the file cannot be written.
    Interrupted, WorkersLost
        As `sweep`.

    Examples
    --------
    >>> book = make_table_book(0.3, least=0.9, greatest=1.1, ratios=2, steps=2, degree=3)
    >>> book.entries, book.values.shape
    (76, (2, 2, 19, 3))
    """
    nu = checks.number("nu", nu, "a number")
    kinds = Bodies(G=1.0, nu=nu)  # which checks it
    least, greatest = checks.positive("least", least), checks.positive("greatest", greatest)
    if least >= greatest:
        raise SceneError("greatest", greatest, f"more than least = {least:g}")
    ratios, steps = checks.whole("ratios", ratios, least=2, most=100), checks.whole("steps", steps, least=2, most=100)
    degree = checks.whole("degree", degree, least=3, most=25)
    if degree % 2 == 0:
        raise SceneError("degree", degree, "odd")
    nodes, directions, t = ratio_nodes(least, greatest, ratios), direction_nodes(degree), magnitudes(steps)
    coefficients = [no_slip_coefficients(float(ratio), nu) for ratio in nodes]
    scales = [spin_scale(C, float(ratio)) for C, ratio in zip(coefficients, nodes, strict=True)]
    scenes = [
        _scene(kinds, ratio, HALFWAY * each / (1 - each) * direction / scale)
        for ratio, scale in zip(nodes, scales, strict=True)
        for direction in directions
        for each in t
    ]
    path = None if out is None else checks.file_name("out", out)
    found = []
    if path is not None:
        check_ending("out", path, ".nc")
        check_writable("out", path)
        check_replaceable("out", path, "table book", _is_book, overwrite)
    for grid, store in zip(GRIDS, (None, None) if path is None else stores(path), strict=True):
        on_grid = [replace(each, grid=grid).second_order() for each in scenes]
        found.append(_solved(on_grid, steps, executor, workers, store, progress))
    shape = ratios, len(directions), steps
    creepages = HALFWAY * (t / (1 - t))[:, None, None] * directions
    simple = [
        [_local_law(kinds, float(ratio), C, creepages, grid) for ratio, C in zip(nodes, coefficients, strict=True)]
        for grid in (*GRIDS, None)
    ]
    coarse, fine = (np.moveaxis(forces.reshape(*shape, 3), 1, 2) for forces in found)
    law = np.array(simple)
    left = _extrapolated(coarse - law[0], fine - law[1])
    values = left + law[2]
    accuracy = np.maximum(LEAST_ERROR, np.abs(left - (fine - law[1])).max(axis=-1))
    size = f"--least {least:g} --greatest {greatest:g} --ratios {ratios} --steps {steps} --degree {degree}"
    provenance = f"{HOW}, to a residual of {TOL:g}: varcontact table make --nu {nu:g} {size}"
    splines = splines_through(coefficients, nodes, directions, left)
    values, accuracy = values.astype(np.float32), accuracy.astype(np.float32)
    book = TableBook(nu, nodes, directions, values, accuracy, splines, provenance)
    if path is not None:
        write_whole("out", path, book.to_bytes())
        for store in stores(path):
            store.unlink(missing_ok=True)
    return book


def stores(out: Path) -> tuple[Path, Path]:
    """The stores of the two sweeps, coarse and fine, that stand beside a book while it is made.

    Parameters
    ----------
    out : Path
        The book's file.
    """
    coarse, fine = (out.with_name(f"{out.stem}.{grid.ny}-cells.nc") for grid in GRIDS)
    return coarse, fine


def _scene(bodies: Bodies, ratio: float, creepage: np.ndarray) -> Scene:
    """An entry: an ellipse with ab = 1 under a creepage that is in parts of f Fz / (G ab)."""
    vx, vy, spin = (float(value) for value in PRESSURE * creepage)
    ellipse = Ellipse(a=math.sqrt(ratio), b=1 / math.sqrt(ratio))
    return Scene(
        bodies=bodies, surface=ellipse, normal_force=PRESSURE, friction=1.0, motion=Steady(vx=vx, vy=vy, spin=spin)
    )


def _local_law(
    bodies: Bodies, ratio: float, coefficients: CreepageCoefficients, creepages: np.ndarray, grid: Grid | None
) -> np.ndarray:
    """The local law for reduced creepages (m, d, 3) of one ratio: on the elements of a grid, or of the continuum."""
    if grid is None:
        points, load = quadrature(ratio, 64)
    else:
        scene = replace(_scene(bodies, ratio, np.zeros(3)), grid=grid).second_order()
        sol = solve(scene, certify=None)
        points = np.stack(np.meshgrid(sol.grid.x, sol.grid.y)).reshape(2, -1)
        load = sol.traction_bound.ravel() * (sol.grid.area / PRESSURE)
    return local_law(creepages.reshape(-1, 3), ratio, coefficients, points, load).reshape(creepages.shape)


def _extrapolated(coarse: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """From the two grids."""
    return fine + (fine - coarse) / ((GRIDS[1].nx / GRIDS[0].nx) ** ORDER - 1)


def _solved(
    scenes: list[Scene],
    chunk: int,
    executor: Executor | None,
    workers: int,
    store: Path | None,
    progress: Callable[[Standing], None] | None,
) -> np.ndarray:
    """Normalised forces of all entries on one grid: a chunk is a ray of magnitudes in one direction."""
    settings = {"tol": TOL, "certify": None, "chunk": chunk, "executor": executor, "workers": workers}
    swept = sweep(scenes, store=store, progress=progress, **settings)  # type: ignore[arg-type]
    failed = np.flatnonzero(swept["outcome"].values != "solved")
    if failed.size:
        k = int(failed[0])
        reason = str(swept["reason"].values[k])
        raise VarcontactError(f"{failed.size} of {len(scenes)} entries are not solved; the first is {k}: {reason}")
    return np.stack([swept[name].values for name in ("Fx", "Fy", "Mz")], axis=-1) / PRESSURE


def _is_book(path: Path) -> bool:
    """Whether a file is a table book."""
    try:
        TableBook.read(path)
    except VarcontactError:
        return False
    return True
