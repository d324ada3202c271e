"""`load`: the certificate of a solution from a file is computed again from its fields, and compared
with the stored. Contents that no solution can have are refused before, in `io/solution.py`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import cast

import numpy as np

from varcontact import checks
from varcontact.discrete.certificate import certificate_of
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.state import ContactState, with_subgrid
from varcontact.discrete.stick_slip import ContactResponse, unit_slip, with_implied_fields
from varcontact.errors import SceneError
from varcontact.interfaces.laws import FRICTION
from varcontact.io.history import Stored
from varcontact.io.solution import read
from varcontact.results.history import History, heat_of, heat_so_far
from varcontact.results.physical import approach_on_grid
from varcontact.results.quantities_of_interest import creepage_names
from varcontact.results.solution import Solution
from varcontact.scene.motion import TimeStep
from varcontact.solvers.interface import SolveStats
from varcontact.solving.contact_solver import ContactSolver
from varcontact.solving.time_step import TimeStepping, time_stepping, without_load
from varcontact.system.files import reading
from varcontact.system.process import one_blas_thread

ROUNDED = 1e-11
"""Residual that rounding in unit conversions may leave, where nothing magnifies it."""
MEASURES = (
    "residual",
    "normal_residual",
    "tangential_residual",
    "relative_gap",
    "normal_relative_gap",
)

ALONE = (
    "the certificate is as stored in the file: a step by itself cannot be measured again without "
    "the step before"
)
ANEW = "the certificate that came with the file is not that of its fields: it is made anew"


@checks.named_options()
def load(path: str | Path, certify: bool = True) -> Solution | History:
    """Read a solution or a history back that `Solution.save`, `History.save` or `solve` wrote.

    The residuals and gaps are computed again by FFT from pressures, tractions,
    approach and creepages; of a history step by step as they are asked for, its
    series are as stored. Where they are more than twice what the stored
    certificate says, and than rounding, it is replaced by that of the fields,
    the solution does not count as converged, and its `note` says so. A step of
    a history that was saved alone is not measured; its `note` says that.

    Parameters
    ----------
    path : str or Path
    certify : bool
        Whether to compute the certificate again. Otherwise it is as stored, and
        report and `note` say so.

    Returns
    -------
    Solution or History
        A history reads its steps from the file when they are asked for.

    Raises
    ------
    OutputError
        If there is no such file, it was not written by varcontact, or its
        contents cannot be a solution.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import varcontact as vc
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = pathlib.Path(folder.name) / "ball.nc"
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    ...     grid=vc.Grid(nx=8, ny=8))
    >>> vc.solve(scene).save(path)
    >>> vc.load(path).note, vc.load(path, certify=False).note
    ('', 'the certificate is as stored in the file, not measured again')
    """
    certify = checks.flag("certify", certify)
    found = read(path)
    if not certify:
        return found
    if isinstance(found, History):
        return replace(found, solutions=with_verified_steps(cast(Stored, found.solutions)))
    with reading(path, errors=(ValueError, SceneError)):
        sol = replace(found, note="")
        if isinstance(sol.scene.motion, TimeStep):
            return replace(sol, note=ALONE)
        disc = discretise(sol.scene, sol.grid)
        if not sol.scene.force_is_sum:
            disc = disc.held_at(approach_on_grid(sol))
        return _verified(disc, sol)


def with_verified_steps(stored: Stored) -> Stored:
    """A history's file whose steps are verified when they are read."""

    @cache
    def stepping() -> TimeStepping:
        solver = ContactSolver(
            stored.plan, stored.settings["tol"], stored.settings["polish"], SolveStats()
        )
        return time_stepping(stored.scene, stored.grid, solver)

    heat = cache(lambda k: heat_of(stored[k]))

    def verified(k: int, before: Solution | None, sol: Solution) -> Solution:
        start = stepping().start()
        if before is None:
            before = start
        heated = heat_so_far(stored.scene, start, map(heat, range(k)))
        _, disc = stepping().problem(k, before, heated)
        return _verified(disc, sol)

    return replace(stored, measured=verified)


@one_blas_thread()
def _verified(disc: Discretisation, sol: Solution) -> Solution:
    """A solution from a file, verified by the discretisation of its scene, or of its step of a
    history.
    """
    if not sol.pressure.any():
        if not without_load(disc, closed_form=sol.plan.closed_form):
            raise ValueError("no pressure, under a load")
        return sol
    disc = with_subgrid(disc, sol.pressure_on_parts)
    state = _state(disc, sol)
    if np.isnan(sol.power_density).any() and sol.plan.has_moment:  # an earlier file's
        density = np.zeros(sol.grid.shape)
        if sol.plan.has_friction:
            density = ContactResponse(disc, state).work() * disc.scales.pressure / unit_slip(disc)
        sol = replace(sol, power_density=density)
    if sol.plan.has_friction:
        disc = with_implied_fields(disc, state, by_slip=True)
    response = ContactResponse(disc, state)
    certificate = certificate_of(response, sol.plan.closed_form, "gap")
    rounding = _rounding(disc, state)
    # NaN: not measured
    if not any(
        getattr(certificate, n) > 2 * getattr(sol.certificate, n) + rounding for n in MEASURES
    ):
        return sol
    certificate = certificate_of(response, sol.plan.closed_form, sol.certificate.level)
    if not sol.plan.has_moment:
        certificate = certificate.without_moment()
    return replace(sol, certificate=certificate, converged=False, note=ANEW)


def _rounding(disc: Discretisation, state: ContactState) -> float:
    """Residual that conversions of units may leave; unlike bodies with little friction magnify it,
    and distances from far away.
    """
    coefficient = disc.coefficient
    coefficients = np.ravel(1.0 if coefficient is None else coefficient)
    least = float(np.min(coefficients[coefficients > 0], initial=1.0))
    far = 10 * float(np.spacing(abs(disc.base))) / disc.scales.displacement
    own = disc.operators.normal.diagonal * float(state.pressure.max())
    return ROUNDED * (1 + abs(disc.K) / least) + far / own


def _state(disc: Discretisation, sol: Solution) -> ContactState:
    """The dimensionless state of a solution, with creepages and approach as they were before they
    were extrapolated.

    Values that are undetermined in line contact follow from slip and distance.
    """
    on_grid: dict[str, float] = {}
    if sol.error_estimate is not None:
        on_grid = sol.error_estimate.on_grid
    pressure = sol.pressure / disc.scales.pressure
    traction = sol.traction / disc.scales.pressure
    approach = (approach_on_grid(sol) - disc.base) / disc.scales.displacement
    state = ContactState(pressure, 0.0, traction, np.zeros(2))
    rigid = np.zeros(2)
    if np.isnan(approach):
        problem = disc.normal_problem(traction if disc.K != 0 and np.any(traction) else None)
        distance = problem.distance + problem.operator.apply(pressure.reshape(1, -1))[0]
        approach = float(np.mean(distance - sol.distance.ravel() / disc.scales.displacement))
    if disc.loading.motion is not None and not disc.frictionless:
        creepages = [
            on_grid.get(name, own)
            for name, own in zip(creepage_names(sol), sol.creepage, strict=True)
        ]
        rigid = (np.array(creepages) - disc.loading.motion.rigid)[:2] * unit_slip(disc)
        if np.isnan(rigid).any():
            shift = ContactResponse(disc, state).slip_shift
            difference = (sol.slip * unit_slip(disc) - shift)[:, pressure > 0]
            rigid = np.where(np.isnan(rigid), difference.mean(axis=1), rigid)
    if sol.friction is not None:
        state = state.under({FRICTION: sol.friction})
    return replace(state, approach=approach, rigid=rigid)
