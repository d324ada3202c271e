"""The maker of table books: exact solutions of all entries, by sweeps."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError, VarcontactError
from varcontact.reference.creepage_coefficients import (
    CreepageCoefficients,
    no_slip_coefficients,
    splines_at_knots,
)
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse
from varcontact.solving.solve import solve
from varcontact.study.sweep import Standing, sweep
from varcontact.system.files import check_replaceable, write_whole
from varcontact.system.process import one_blas_thread
from varcontact.theories.table_book import (
    HALFWAY,
    TableBook,
    linear_part,
    packed,
    places,
    reduced_scales,
    unpacked,
)

GRIDS = Grid(nx=12, ny=8), Grid(nx=27, ny=18), Grid(nx=48, ny=32)
"""Grids from which an entry is extrapolated: the first two, or the last two where it is in
doubt."""
DOUBT = 0.002
"""Change by extrapolating from the first two grids, divided by f Fz, above which an entry is in
doubt."""
ORDER = 2
"""Order of the discretisation."""
HOW = (
    "exact solutions by the discretisation of second order, extrapolated from 12 x 8 and "
    "27 x 18 elements, or from 27 x 18 and 48 x 32 where the former changes them by more than "
    "0.2 % of f Fz"
)
TOL = 1e-3
"""Residual of the entries on their grids: it changes forces by at most 1e-4 of f Fz, far less than
the grid error."""
LEAST_ERROR = 0.004
"""Least estimated error of an entry, divided by f Fz; the change by extrapolation if that is
larger."""
PRESSURE = 1e-3
"""Normal force divided by G ab: without influence, as everything is proportional to it."""
POLAR = 16
"""Intervals of the splines in the angle from vx, up to pi/2."""
ANGLES = 32
"""Intervals of the splines in the angle of (vy, spin), up to pi."""
PARITY = np.array([[-1.0, 1.0, 1.0], [1.0, -1.0, -1.0]])
"""Signs of Fx, Fy and Mz when vx changes sign, and when vy and spin do."""
REACH = 1.0
"""Correlation length between directions, as a distance of unit vectors."""
NUGGET = 1e-6
"""Addition to the diagonal of the correlation."""
FULL = 1e9
"""Magnitude of creepage that counts as full slip."""
TINY = 1e-300
RAYS = 16
"""Rays of entries that are solved in one batch."""


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
    progress: Callable[[Standing], None] | bool | None = None,
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
        Degree of the polynomials that the directions determine, odd; 17 takes 145
        directions.
    executor, workers
        Where the entries are solved, as for `sweep`.
    out : str or Path, optional
        File of the book (.nc). While it is made, stores of sweeps stand beside
        it, from which the same call resumes.
    overwrite : bool
        Whether to replace a file that is no table book.
    progress : callable or true, optional
        Called with the `Standing` of each sweep, of which there is one for each
        grid.

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
        As in `sweep`.

    Examples
    --------
    >>> book = make_table_book(0.3, least=0.9, greatest=1.1, ratios=2, steps=2, degree=3)
    >>> book.entries, book.values.shape
    (76, (2, 2, 19, 3))
    """
    nu = checks.number("nu", nu, "a number")
    kinds = Bodies(G=1.0, nu=nu)  # which checks it
    least = checks.positive("least", least)
    greatest = checks.positive("greatest", greatest)
    if least >= greatest:
        raise SceneError("greatest", greatest, f"more than least = {least:g}")
    ratios = checks.whole("ratios", ratios, least=2, most=100)
    steps = checks.whole("steps", steps, least=2, most=100)
    degree = checks.whole("degree", degree, least=3, most=25)
    if degree % 2 == 0:
        raise SceneError("degree", degree, "odd")
    middle = math.log(least * greatest) / 2
    half = math.log(greatest / least) / 2
    angles = math.pi * np.arange(ratios) / (ratios - 1)
    nodes = np.exp(middle - half * np.cos(angles))  # Chebyshev's, both ends included
    directions = direction_nodes(degree)
    t = magnitudes(steps)
    path = None if out is None else checks.file_name("out", out)
    if path is not None:
        check_out("out", path, overwrite)
    creepages = directions[:, None, :] * (HALFWAY * t / (1 - t))[:, None]  # reduced (d, m, 3)
    files = (None, None, None) if path is None else stores(path)

    def beyond_law(k: int, chosen: np.ndarray) -> np.ndarray:
        """Forces of some entries minus the local law, both on the elements of a grid; NaN for the
        others.
        """
        scenes = list(_scenes(kinds, nodes, creepages, chosen, GRIDS[k]))
        # a chunk has those of some rays
        solved = partial(sweep, scenes, chunk=RAYS * steps, tol=TOL, certify=None)
        swept = solved(store=files[k], progress=progress, executor=executor, workers=workers)
        failed = np.flatnonzero(swept["outcome"].values != "solved")
        if failed.size:
            first = int(failed[0])
            words = f"{failed.size} of {len(scenes)} entries are not solved; the first is {first}: "
            raise VarcontactError(words + str(swept["reason"].values[first]))
        forces = np.full((*chosen.shape, 3), np.nan)
        resultants = np.stack([swept[name].values for name in ("Fx", "Fy", "Mz")], axis=-1)
        forces[chosen] = resultants / PRESSURE
        return forces - _law(kinds, nodes, creepages, GRIDS[k])

    # all entries on two grids, those in doubt on a third
    every = np.ones((ratios, len(directions), steps), dtype=bool)
    coarse = beyond_law(0, every)
    fine = beyond_law(1, every)
    left = extrapolated(coarse, fine, *GRIDS[:2])
    change = np.abs(left - fine).max(axis=-1)
    doubtful = change > DOUBT
    if doubtful.any():
        finest = beyond_law(2, doubtful)
        better = extrapolated(fine, finest, *GRIDS[1:])
        left = np.where(doubtful[..., None], better, left)
        change = np.where(doubtful, np.abs(better - finest).max(axis=-1), change)
    values = np.moveaxis(left + _law(kinds, nodes, creepages, None), 1, 2)
    accuracy = np.moveaxis(np.maximum(LEAST_ERROR, change), 1, 2)
    left = np.moveaxis(left, 1, 2)
    provenance = (
        f"{HOW}, to a residual of {TOL:g}: varcontact table make --nu {nu:g} --least {least:g} "
        f"--greatest {greatest:g} --ratios {ratios} --steps {steps} --degree {degree}"
    )
    book = TableBook(
        nu=nu,
        ratios=nodes,
        directions=directions,
        values=values.astype(np.float32),
        accuracy=accuracy.astype(np.float32),
        splines=unpacked(**packed(splines_through(nu, nodes, directions, left))),
        provenance=provenance,
    )
    if path is not None:
        write_whole("out", path, book.to_bytes())
        for store in stores(path):
            store.unlink(missing_ok=True)
    return book


def check_out(field: str, path: Path, overwrite: bool) -> None:
    """Refuse a path to which a book cannot be written, or a file that is something else."""
    check_replaceable(field, path, (".nc",), "table book", b"CDF.*varcontact table ", overwrite)


def stores(out: Path) -> tuple[Path, ...]:
    """Stores of the sweeps, one per grid, kept beside a book while it is made."""
    return tuple(out.with_name(f"{out.stem}.{grid.ny}-cells.nc") for grid in GRIDS)


def _scenes(
    bodies: Bodies, ratios: np.ndarray, creepages: np.ndarray, chosen: np.ndarray, grid: Grid
) -> Iterator[Scene]:
    """Scenes of the chosen entries (r, d, m) on a grid: ellipses with ab = 1, creepages in units of
    f Fz / (G ab).
    """
    for ratio, some in zip(ratios.tolist(), chosen, strict=True):
        still = _still(bodies, ratio, grid)
        scales = np.array(reduced_scales(no_slip_coefficients(ratio, bodies.combined_nu), ratio))
        for vx, vy, spin in (creepages[some] * (PRESSURE / scales)).tolist():
            yield replace(still, motion=replace(still.motion, vx=vx, vy=vy, spin=spin))


def _law(
    bodies: Bodies, ratios: np.ndarray, creepages: np.ndarray, grid: Grid | None
) -> np.ndarray:
    """The local law (r, d, m, 3), on the elements of a grid, or of the continuum."""
    found = []
    for ratio in ratios.tolist():
        if grid is None:
            points, load = quadrature(ratio, 40)
        else:
            sol = solve(_still(bodies, ratio, grid), certify=None)
            points = np.stack(np.meshgrid(sol.grid.x, sol.grid.y)).reshape(2, -1)
            load = sol.traction_bound.ravel() * (sol.grid.area / PRESSURE)
        coefficients = no_slip_coefficients(ratio, bodies.combined_nu)
        found.append(local_law(creepages.reshape(-1, 3), ratio, coefficients, points, load))
    return np.array(found).reshape(-1, *creepages.shape)


def _still(bodies: Bodies, ratio: float, grid: Grid) -> Scene[Steady]:
    ellipse = Ellipse(a=math.sqrt(ratio), b=1 / math.sqrt(ratio))
    scene = Scene(
        bodies=bodies,
        surface=ellipse,
        normal_force=PRESSURE,
        friction=1.0,
        motion=Steady(),
        grid=grid,
    )
    return scene.second_order()


def extrapolated(coarse: np.ndarray, fine: np.ndarray, *grids: Grid) -> np.ndarray:
    """Forces extrapolated from two grids to elements of size zero (Richardson, order `ORDER`)."""
    return fine + (fine - coarse) / ((grids[1].nx / grids[0].nx) ** ORDER - 1)


def magnitudes(count: int) -> np.ndarray:
    """Points t of the magnitudes ``1.5 t/(1 - t)`` of the entries, without 0 and 1: equal steps of
    `places`.
    """
    from scipy.optimize import brentq

    wanted = np.arange(1, count + 1) / (count + 1)
    return np.array(
        [brentq(lambda t, place=place: places(t) - place, 0.0, 1.0, xtol=1e-16) for place in wanted]
    )


def direction_nodes(degree: int) -> np.ndarray:
    """Directions (d, 3) that determine polynomials of the direction: circles of (vy, spin), half of
    each.
    """
    circles = (degree + 3) // 2
    found = [np.array([[1.0, 0.0, 0.0]])]
    for k in range(1, circles + 1):
        count = min(4 + 2 * k, degree + 3)
        angle = math.pi * np.arange(count) / count
        radius = math.sin(math.pi * k / (2 * circles))
        height = math.cos(math.pi * k / (2 * circles)) if k < circles else 0.0
        found.append(
            np.stack(
                [np.full(count, height), radius * np.cos(angle), radius * np.sin(angle)], axis=1
            )
        )
    return np.concatenate(found)


def local_law(
    reduced: np.ndarray,
    ratio: float,
    coefficients: CreepageCoefficients,
    points: np.ndarray,
    load: np.ndarray,
) -> np.ndarray:
    """Normalised forces (n, 3) if traction follows rigid slip at each point, as in Vermeulen and
    Johnson's formula.

    With s = C11 |w| in the units of the reduced creepage, it has the parts ``1 - (1 - s/3)^3`` of
    the traction bound, and all of it from s = 3. Points (2, p) are x and y by sqrt(ab), `load` the
    parts of f Fz that they carry.
    """
    x, y = points
    sums = np.stack([np.ones_like(x), x, y, x**2 + y**2], axis=1) * load[:, None]
    scale = np.array(reduced_scales(coefficients, ratio))
    found = np.empty_like(reduced)
    at_once = max(1, 20_000 // len(load))
    for k in range(0, len(reduced), at_once):
        vx, vy, spin = (reduced[k : k + at_once] / scale).T
        wx = vx[:, None] - spin[:, None] * y
        wy = vy[:, None] + spin[:, None] * x
        third = np.sqrt(wx * wx + wy * wy) * (scale[0] / 3)
        inside = np.minimum(third, 1.0)
        by_slip = ((inside - 3) * inside + 3) * inside / np.maximum(third, TINY)
        by_slip[third < TINY] = 3.0
        zeroth, by_x, by_y, second = (by_slip @ sums).T * (-scale[0] / 3)
        found[k : k + at_once, 0] = vx * zeroth - spin * by_y
        found[k : k + at_once, 1] = vy * zeroth + spin * by_x
        found[k : k + at_once, 2] = vy * by_x - vx * by_y + spin * second
    return found


def quadrature(ratio: float, count: int = 24) -> tuple[np.ndarray, np.ndarray]:
    """Points (2, p) of an ellipse with ab = 1, and parts of Hertz's load: Gauss's rule outwards,
    trapezoidal around.
    """
    height, weight = np.polynomial.legendre.leggauss(count)
    height = (height + 1) / 2
    weight = weight / 2
    angle = math.pi / count * (np.arange(2 * count) + 0.5)
    radius = np.sqrt(1 - height**2)[:, None]
    x = math.sqrt(ratio) * radius * np.cos(angle)
    y = radius * np.sin(angle) / math.sqrt(ratio)
    load = np.broadcast_to((1.5 * height**2 * weight)[:, None] / count, x.shape)
    return np.stack([x.ravel(), y.ravel()]), load.ravel()


def splines_through(
    nu: float, ratios: np.ndarray, directions: np.ndarray, left: np.ndarray
) -> np.ndarray:
    """The coefficients (h, i, j, k, 3) of a book's splines, from its entries (r, m, d, 3) less the
    local law.

    Entries are few, and near full slip forces turn quickly with the direction. The local law turns
    alike: what is left is interpolated between the entries, and the law is added again at the knots
    of the splines, which are many.
    """
    from scipy.interpolate import BarycentricInterpolator

    polar = np.linspace(0.0, math.pi / 2, POLAR + 1)[:, None]
    angle = np.linspace(0.0, math.pi, ANGLES + 1)[:-1]
    parts = np.cos(polar), np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle)
    knots = np.stack(np.broadcast_arrays(*parts), axis=-1)
    flat = knots.reshape(-1, 3)
    nugget = NUGGET * np.eye(len(directions))
    between = np.empty((3, len(flat), len(directions)))
    for i in range(3):
        among = _correlation(directions, directions, i) + nugget
        between[i] = _correlation(flat, directions, i) @ np.linalg.inv(among)
    least, greatest = np.log(ratios[[0, -1]])
    places = np.linspace(least, greatest, max(3, 5 * (len(ratios) - 1) // 4) + 1)
    by_ratio = BarycentricInterpolator(np.log(ratios), left)(places)
    each = np.einsum("ikd,htdi->htki", between, by_ratio, optimize=True)
    S = np.stack(
        [_at_knots(nu, ratio, flat, rest) for ratio, rest in zip(np.exp(places), each, strict=True)]
    )
    return splines_at_knots(_around(splines_at_knots(S.reshape(*S.shape[:2], *knots.shape), 1)))


def _at_knots(nu: float, ratio: float, knots: np.ndarray, left: np.ndarray) -> np.ndarray:
    """S of one ratio at the knots (t, knot, 3), from the remainders `left` of the entries there."""
    from scipy.interpolate import BarycentricInterpolator

    coefficients = no_slip_coefficients(float(ratio), nu)
    rough = quadrature(ratio)
    fine = quadrature(ratio, 80)
    t = magnitudes(len(left))
    finite = [
        local_law(HALFWAY * each / (1 - each) * knots, ratio, coefficients, *rough) + rest
        for each, rest in zip(t, left, strict=True)
    ]
    full = local_law(FULL * knots, ratio, coefficients, *fine)
    forces = np.stack([*finite, full])
    creepages = knots / np.array(reduced_scales(coefficients, ratio))
    # with monotone influence of tractions on slip, resistance rises along a ray of creepages up to
    # full slip
    unit = creepages / np.linalg.norm(creepages, axis=1)[:, None]
    resistance = -(forces * unit).sum(axis=-1)
    capped = np.minimum(resistance, resistance[-1])
    above = np.maximum.accumulate(capped)
    below = np.minimum.accumulate(capped[::-1])[::-1]
    found = forces - ((above + below) / 2 - resistance)[..., None] * unit
    t = np.append(t, 1.0)[:, None, None]
    x, y, z = knots.T
    linear = np.stack(linear_part(x, y, z, ratio, coefficients), axis=-1)
    S = (found - (HALFWAY * t * (1 - t)) * linear) / t**2
    first = min(4, len(S))
    return np.concatenate(
        [BarycentricInterpolator(np.arange(1.0, first + 1), S[:first])(0.0)[None], S]
    )


def _correlation(one: np.ndarray, other: np.ndarray, component: int) -> np.ndarray:
    """Matern's correlation of order 5/2 between directions on the sphere, with the symmetries of a
    component.
    """
    found = np.zeros((len(one), len(other)))
    for along, across in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        sign = 1.0
        if along < 0:
            sign *= PARITY[0, component]
        if across < 0:
            sign *= PARITY[1, component]
        distance = np.linalg.norm(one[:, None] - other * (along, across, across), axis=-1)
        s = math.sqrt(5) / REACH * distance
        found += sign * (1 + s + s**2 / 3) * np.exp(-s)
    return found


def _around(values: np.ndarray) -> np.ndarray:
    """Coefficients of cubic B-splines in both angles, through values (..., polar, angle, 3) that
    are continued by symmetry.
    """
    from scipy.ndimage import spline_filter1d

    polar, angle = values.shape[-3] - 1, values.shape[-2]
    around = np.concatenate([values, PARITY[1] * values], axis=-2)
    half = np.concatenate([around, PARITY[0] * around[..., -2::-1, :, :]], axis=-3)  # to pi
    whole = np.concatenate([half, np.roll(half[..., -2:0:-1, :, :], angle, axis=-2)], axis=-3)
    for axis in (-3, -2):
        whole = spline_filter1d(whole, axis=axis, mode="grid-wrap")
    whole = whole.take(np.arange(-1, polar + 2), axis=-3, mode="wrap")
    return whole.take(np.arange(-1, angle + 2), axis=-2, mode="wrap")
