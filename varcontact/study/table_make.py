"""Making a table book: exact solutions of all its entries, by a sweep."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError, VarcontactError
from varcontact.io.outputs import check_ending, check_replaceable, check_writable, write_whole
from varcontact.reference.creepage_coefficients import creepage_coefficients
from varcontact.scene.bodies import Bodies
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse
from varcontact.solving.ways import Way
from varcontact.study.sweep import Standing, sweep
from varcontact.theories.table_book import (
    HALFWAY,
    NAMES,
    TableBook,
    direction_nodes,
    full_slip,
    magnitudes,
    ratio_nodes,
    spin_scale,
)

ENTRY = Way(
    cells=12, along=1.5, coarser=6, order=1.5, edge="softened",
    motion=(("slip_difference", "second-order"), ("spin_offset", 0.0)),
)  # fmt: skip
"""How an entry is computed."""
HOW = "exact solutions by the discretisation of second order, extrapolated from 9 x 6 and 18 x 12 elements"
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
    ratios: int = 10,
    steps: int = 10,
    degree: int = 13,
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
        Of the polynomials of the direction, odd; 13 takes 99 directions.
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
    coefficients = np.array([_coefficients(ratio, nu) for ratio in nodes])
    scales = [spin_scale(C, ratio) for C, ratio in zip(coefficients, nodes, strict=True)]
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
    for cells, store in zip((ENTRY.coarser, ENTRY.cells), (None, None) if path is None else stores(path), strict=True):
        found.append(_solved([ENTRY.of(each, cells) for each in scenes], steps, executor, workers, store, progress))
    shape = ratios, len(directions), steps
    coarse, fine = (np.moveaxis(forces.reshape(*shape, 3), 1, 2) for forces in found)
    ratio = (ENTRY.cells / ENTRY.coarser) ** ENTRY.order
    values = fine + (fine - coarse) / (ratio - 1)
    accuracy = np.maximum(LEAST_ERROR, np.abs(values - fine).max(axis=-1))
    full = np.stack([full_slip(directions, scale, each) for scale, each in zip(scales, nodes, strict=True)])
    size = f"--least {least:g} --greatest {greatest:g} --ratios {ratios} --steps {steps} --degree {degree}"
    provenance = f"{HOW}, to a residual of {TOL:g}: varcontact table make --nu {nu:g} {size}"
    book = TableBook(nu, nodes, coefficients, directions, values, accuracy, full, provenance)
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
    coarse, fine = (out.with_name(f"{out.stem}.{cells}-cells.nc") for cells in (ENTRY.coarser, ENTRY.cells))
    return coarse, fine


def _scene(bodies: Bodies, ratio: float, creepage: np.ndarray) -> Scene:
    """An entry: an ellipse with ab = 1 under a creepage that is in parts of f Fz / (G ab)."""
    vx, vy, spin = (float(value) for value in PRESSURE * creepage)
    ellipse = Ellipse(a=math.sqrt(ratio), b=1 / math.sqrt(ratio))
    return Scene(
        bodies=bodies, surface=ellipse, normal_force=PRESSURE, friction=1.0, motion=Steady(vx=vx, vy=vy, spin=spin)
    )


def _coefficients(ratio: float, nu: float) -> list[float]:
    """Creepage coefficients of an ellipse."""
    found = creepage_coefficients(ratio, 1.0, nu)
    return [float(getattr(found, name)) for name in NAMES]


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
