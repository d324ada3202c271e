"""Making a table book: exact solutions of all its entries, by a sweep."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError, VarcontactError
from varcontact.reference.creepage_coefficients import CreepageCoefficients, no_slip_coefficients
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse
from varcontact.solving.solve import solve
from varcontact.study.sweep import Standing, sweep
from varcontact.system.files import check_ending, check_replaceable, check_writable, write_whole
from varcontact.system.threads import one_blas_thread
from varcontact.theories.table_book import TableBook, packed, unpacked
from varcontact.theories.table_nodes import HALFWAY, direction_nodes, magnitudes, ratio_nodes, spin_scale
from varcontact.theories.table_splines import local_law, quadrature, splines_through

GRIDS = Grid(nx=12, ny=8), Grid(nx=24, ny=16), Grid(nx=48, ny=32)
"""Those an entry is extrapolated from: the first two, or the last two where it is in doubt."""
DOUBT = 0.001
"""In doubt is what the extrapolation from the first two changes by more than this, in parts of f Fz."""
ORDER = 2
"""Order of the discretisation."""
HOW = (
    "exact solutions by the discretisation of second order, extrapolated from 12 x 8 and 24 x 16 elements, or from "
    "24 x 16 and 48 x 32 where the former changes them by more than 0.1 % of f Fz"
)
TOL = 1e-6
"""Residual of the entries on their grids: far below the grids' own error."""
LEAST_ERROR = 0.004
"""Estimated error of an entry in parts of f Fz: what the extrapolation changes, and at least this."""
PRESSURE = 1e-3
"""Normal force by G ab: of no influence, as all is in proportion to it."""


@one_blas_thread()
def make_table_book(
    nu: float,
    *,
    least: float = 0.2,
    greatest: float = 5.0,
    ratios: int = 9,
    steps: int = 21,
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
        File of the book (.nc). While it is made, stores of sweeps stand beside it, from which the same call goes on.
    overwrite : bool
        Whether to replace a file that is no table book.
    progress : callable, optional
        Told how far each of the sweeps is, of which there is one for each grid.

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
    path = None if out is None else checks.file_name("out", out)
    if path is not None:
        check_out("out", path, overwrite)
    rays = _Rays(kinds, nodes, directions, t)
    files = (None, None, None) if path is None else stores(path)

    def beyond_law(k: int, chosen: np.ndarray) -> np.ndarray:
        """What some entries have more than the local law, both on the elements of a grid; nan in the others."""
        scenes = [replace(scene, grid=GRIDS[k]).second_order() for scene in rays.scenes(chosen)]
        found = np.full((*chosen.shape, 3), np.nan)
        found[chosen] = _solved(scenes, steps, executor, workers, files[k], progress)
        return found - rays.law(GRIDS[k])

    coarse, fine = (beyond_law(k, np.ones((ratios, len(directions), steps), dtype=bool)) for k in (0, 1))
    left = _extrapolated(coarse, fine)
    change = np.abs(left - fine).max(axis=-1)
    doubtful = change > DOUBT
    if doubtful.any():
        finest = beyond_law(2, doubtful)
        better = _extrapolated(fine, finest)
        left = np.where(doubtful[..., None], better, left)
        change = np.where(doubtful, np.abs(better - finest).max(axis=-1), change)
    values, accuracy = left + rays.law(None), np.maximum(LEAST_ERROR, change)
    left, values, accuracy = (np.moveaxis(array, 1, 2) for array in (left, values, accuracy))
    size = f"--least {least:g} --greatest {greatest:g} --ratios {ratios} --steps {steps} --degree {degree}"
    provenance = f"{HOW}, to a residual of {TOL:g}: varcontact table make --nu {nu:g} {size}"
    splines = unpacked(**packed(splines_through(nu, nodes, directions, left)))
    values, accuracy = values.astype(np.float32), accuracy.astype(np.float32)
    book = TableBook(nu, nodes, directions, values, accuracy, splines, provenance)
    if path is not None:
        write_whole("out", path, book.to_bytes())
        for store in stores(path):
            store.unlink(missing_ok=True)
    return book


def check_out(field: str, path: Path, overwrite: bool) -> None:
    """Refuse a file that a book cannot be written to, or that is something else.

    Parameters
    ----------
    field : str
        Its name, for the message.
    path : Path
    overwrite : bool
        Whether a file that is no table book may be replaced.

    Raises
    ------
    OutputError
    """
    check_ending(field, path, ".nc")
    check_writable(field, path)
    check_replaceable(field, path, "table book", _is_book, overwrite)


def stores(out: Path) -> tuple[Path, ...]:
    """The stores of the sweeps, one for each grid, that stand beside a book while it is made.

    Parameters
    ----------
    out : Path
        The book's file.
    """
    return tuple(out.with_name(f"{out.stem}.{grid.ny}-cells.nc") for grid in GRIDS)


@dataclass(frozen=True, eq=False)
class _Rays:
    """The entries that are asked for: by ratio, direction and magnitude, which is a point t."""

    bodies: Bodies
    ratios: np.ndarray
    directions: np.ndarray
    t: np.ndarray

    @cached_property
    def creepages(self) -> np.ndarray:
        """Reduced creepages (d, m, 3)."""
        return np.asarray(self.directions[:, None, :] * (HALFWAY * self.t / (1 - self.t))[:, None])

    @cached_property
    def coefficients(self) -> list[CreepageCoefficients]:
        return [no_slip_coefficients(float(ratio), self.bodies.combined_nu) for ratio in self.ratios]

    def scenes(self, chosen: np.ndarray) -> Iterator[Scene]:
        """Those of some entries (r, d, m)."""
        scales = [spin_scale(C, float(ratio)) for C, ratio in zip(self.coefficients, self.ratios, strict=True)]
        for r, d, m in np.argwhere(chosen):
            yield _scene(self.bodies, float(self.ratios[r]), self.creepages[d, m] / scales[r])

    def law(self, grid: Grid | None) -> np.ndarray:
        """The local law (r, d, m, 3), on the elements of a grid, or of the continuum."""
        pairs = zip(self.ratios, self.coefficients, strict=True)
        return np.array([_local_law(self.bodies, float(ratio), C, self.creepages, grid) for ratio, C in pairs])


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
    """The local law for reduced creepages (..., 3) of one ratio: on the elements of a grid, or of the continuum."""
    if grid is None:
        points, load = quadrature(ratio, 64)
    else:
        scene = replace(_scene(bodies, ratio, np.zeros(3)), grid=grid).second_order()
        sol = solve(scene, certify=None)
        points = np.stack(np.meshgrid(sol.grid.x, sol.grid.y)).reshape(2, -1)
        load = sol.traction_bound.ravel() * (sol.grid.area / PRESSURE)
    return local_law(creepages.reshape(-1, 3), ratio, coefficients, points, load).reshape(creepages.shape)


def _extrapolated(coarse: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """From two grids, of which one has twice the elements in each direction."""
    return fine + (fine - coarse) / (2**ORDER - 1)


def _solved(
    scenes: list[Scene],
    chunk: int,
    executor: Executor | None,
    workers: int,
    store: Path | None,
    progress: Callable[[Standing], None] | None,
) -> np.ndarray:
    """Normalised forces of entries on one grid: a chunk has as many as a ray has magnitudes."""
    swept = sweep(
        scenes, store=store, progress=progress, tol=TOL, certify=None, chunk=chunk, executor=executor, workers=workers
    )
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
