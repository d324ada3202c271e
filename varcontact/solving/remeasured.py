"""A solution from a file is measured again, to see whether its fields deserve the stored certificate.

What is cheap by FFT: slips and distances, the residuals and the gaps. Where they agree with what the file says, that
stands, the bound on forces with it; where not, a new certificate is made.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import cast

import numpy as np

from varcontact import checks
from varcontact.discrete.certificate import certificate_of
from varcontact.discrete.discretisation import Discretisation, PreviousStep, discretise
from varcontact.discrete.residuals import gap, normal_gap, normal_residual, project, residuals
from varcontact.discrete.state import ContactState, hertz_pressure
from varcontact.discrete.stick_slip import SLIP, STICK, friction_work, shift_and_areas, unit_slip
from varcontact.discrete.subgrid import means, normal_as_solved, with_subgrid
from varcontact.io.history import Stored
from varcontact.io.solution import read
from varcontact.results.history import History
from varcontact.results.quantities_of_interest import creepage_names
from varcontact.results.refinement import Refinement
from varcontact.results.solution import Solution
from varcontact.scene.motion import TimeStep
from varcontact.solvers.statistics import SolveStats
from varcontact.solving.contact_solver import ContactSolver
from varcontact.solving.friction_law import coefficient
from varcontact.solving.march import March, marching_on, without_load
from varcontact.solving.transient import largest_contacts
from varcontact.system.files import reading
from varcontact.system.threads import one_blas_thread

ROUNDED = 1e-11
"""Residual that rounding in unit conversions may leave, where nothing magnifies it."""
SAME = 1e-8
"""Largest difference of slips and distances, by the largest displacement, that counts as rounding."""

ALONE = "the certificate is as stored in the file: a step by itself cannot be measured again without the step before"
ANEW = "the certificate that came with the file is not that of its fields: it is made anew"


def load(path: str | Path, certify: bool = True) -> Solution | History:
    """Read a solution or a history back that `Solution.save`, `History.save` or `solve` wrote.

    Fields that no solution can have are refused. Beyond that a file is not believed: slips, distances, residuals and
    gaps are measured again by FFT; of a history step by step as they are asked for, its series are as stored. Where
    the fields are not those that the file's certificate was made for, it is made anew, the solution does not count as
    converged, and its `note` says so.

    Parameters
    ----------
    path : str or Path
    certify : bool
        Whether to measure again. Otherwise the certificate is as stored, and report and `note` say so.

    Returns
    -------
    Solution or History
        A history reads its steps from the file when they are asked for.

    Raises
    ------
    OutputError
        If there is no such file, it was not written by varcontact, or its contents cannot be a solution.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import varcontact as vc
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = pathlib.Path(folder.name) / "ball.nc"
    >>> vc.solve(vc.Scene(bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    ...                   grid=vc.Grid(nx=8, ny=8))).save(path)
    >>> vc.load(path).note, vc.load(path, certify=False).note
    ('', 'the certificate is as stored in the file, not measured again')
    """
    certify, found = checks.flag("certify", certify), read(path)
    if not certify:
        return found
    if isinstance(found, History):
        return replace(found, solutions=with_measured_steps(cast(Stored, found.solutions)))
    with reading(path):
        return _remeasured(replace(found, note=""))


def with_measured_steps(stored: Stored) -> Stored:
    """A history's file whose steps are measured again when they are read.

    Parameters
    ----------
    stored : Stored
    """

    @cache
    def march() -> March:
        steps = ContactSolver(stored.plan, stored.settings["tol"], stored.settings["polish"], SolveStats())
        return marching_on(stored.scene, largest_contacts(stored.scene)[0], stored.grid, steps)

    def measured(k: int, before: Solution | None, sol: Solution) -> Solution:
        if sol.refinement is not None and sol.pressure.any():
            return _measured_on(_as_corrected(march().problem(k, None)[1], sol, sol.refinement), sol)
        return _measured_on(march().problem(k, march().start() if before is None else before)[1], sol)

    return replace(stored, measured=measured)


def _remeasured(sol: Solution) -> Solution:
    """A solution from a file by itself, with a certificate that its fields deserve.

    Raises
    ------
    ValueError
        If slips, distances or Hertz's pressure are not those of the scene and its tractions.
    """
    if isinstance(sol.scene.motion, TimeStep) and (sol.refinement is None or not sol.pressure.any()):
        return replace(sol, note=ALONE)
    disc = discretise(sol.scene, sol.grid, coupled=not sol.plan.left_out)
    return _measured_on(disc if sol.refinement is None else _as_corrected(disc, sol, sol.refinement), sol)


def _as_corrected(disc: Discretisation, sol: Solution, found: Refinement) -> Discretisation:
    """The problem on the elements as it was corrected; in a step of a history with what the particles bring along."""
    motion, coefficient = disc.loading.motion, disc.loading.coefficient
    assert motion is not None
    prescribed = zip((motion.Fx, motion.Fy), sol.traction.sum(axis=(1, 2)) * sol.grid.area, strict=True)
    Fx, Fy = (None if given is None else float(force) for given, force in prescribed)
    carried = PreviousStep(-found.correction * unit_slip(disc), np.zeros(2))
    disc = disc.with_loading(motion=replace(motion, Fx=Fx, Fy=Fy), previous_step=carried)
    if np.all(found.share == 1):
        return disc
    return disc.with_loading(coefficient=np.broadcast_to(np.asarray(coefficient), disc.grid.shape) * found.share)


@one_blas_thread()
def _measured_on(disc: Discretisation, stored: Solution) -> Solution:
    """A solution from a file, with the discretisation of its scene, or of its step of a history."""
    sol, disc = _on_its_grid(stored), with_subgrid(disc, stored.pressure_on_parts)
    if not sol.pressure.any():
        if not without_load(disc, closed_form=sol.plan.closed_form):
            raise ValueError("no pressure, under a load")
        return stored
    state = _state(disc, sol)
    density = _check_fields(disc, sol, state)
    stored = replace(stored, power_density=density) if np.isnan(sol.power_density).any() else stored
    if disc.loading.law is not None and sol.plan.has_friction:
        disc = disc.with_loading(coefficient=coefficient(disc, state))
    if _deserved(disc, sol, state):
        return stored
    closed_form = sol.plan.closed_form
    certificate = certificate_of(disc, state, closed_form, sol.certificate.level)
    if not sol.plan.has_moment:
        certificate = certificate.without_moment()
    return replace(stored, certificate=certificate, converged=False, note=ANEW)


def _on_its_grid(sol: Solution) -> Solution:
    """The solution with the creepages and the approach that its fields have, before they were extrapolated."""
    known = {} if sol.error_estimate is None else sol.error_estimate.on_grid
    creepages = zip(creepage_names(sol), sol.creepage, strict=True)
    first, second, third = (known.get(name, own) for name, own in creepages)
    return replace(sol, creepage=(first, second, third), approach=known.get("approach", sol.approach))


def _state(disc: Discretisation, sol: Solution) -> ContactState:
    """The state that a solution has, dimensionless; what it does not tell in line contact, its other fields do."""
    pressure, traction = sol.pressure / disc.scales.pressure, sol.traction / disc.scales.pressure
    approach = (sol.approach - disc.base) / disc.scales.displacement
    state = ContactState(pressure, 0.0, traction, np.zeros(2))
    if np.isnan(approach):
        approach = float(np.mean(_distance(disc, state) - sol.distance / disc.scales.displacement))
    rigid = np.zeros(2)
    if disc.loading.motion is not None and not disc.loading.frictionless:
        rigid = (np.array(sol.creepage) - disc.loading.motion.rigid)[:2] * unit_slip(disc)
        if np.isnan(rigid).any():
            contact = pressure > 0
            moved = (sol.slip * unit_slip(disc) - shift_and_areas(disc, state)[0])[:, contact].mean(axis=1)
            rigid = np.where(np.isnan(rigid), moved, rigid)
    return replace(state, approach=approach, rigid=rigid)


def _distance(disc: Discretisation, state: ContactState) -> np.ndarray:
    """Deformed distance, dimensionless, (ny, nx)."""
    distance = (disc.distance - disc.base) / disc.scales.displacement + disc.operators.normal.apply(
        state.pressure[None]
    )[0]
    if disc.K != 0 and np.any(state.traction):
        distance = distance + disc.operators.traction_to_distance.apply(state.traction)[0]
    return np.asarray(distance - state.approach)


def _check_fields(disc: Discretisation, sol: Solution, state: ContactState) -> np.ndarray:
    """Refuse fields that are not those of the tractions; the power density of these."""
    if sol.plan.closed_form:
        closed_form = hertz_pressure(disc, state).pressure
        if np.abs(state.pressure - closed_form).max() > SAME * closed_form.max():
            raise ValueError("a pressure that is not Hertz's, as which it is declared")
    distance = _distance(disc, state)
    largest = max(float(np.abs(distance).max()), abs(state.approach))
    if np.abs(distance - sol.distance / disc.scales.displacement).max() > SAME * largest:
        raise ValueError("distances that are not those under its tractions")
    if disc.loading.motion is None or disc.loading.frictionless:
        return np.zeros(sol.grid.shape)
    shift, _ = shift_and_areas(disc, state)
    moved = disc.shift_by_tractions(state.traction)
    largest = max(float(np.abs(field).max()) for field in (moved, disc.known_shift, state.rigid, shift))
    if np.abs(shift - sol.slip * unit_slip(disc)).max() > SAME * largest:
        raise ValueError("slips that are not those under its tractions")
    density, found = friction_work(disc, state, shift) * disc.scales.pressure / unit_slip(disc), sol.refinement
    if found is not None:
        density = means(found.power_density, found.cells)
    if not sol.plan.has_moment and sol.spin:
        density = np.full_like(density, np.nan)
    allowed = SAME * largest / unit_slip(disc) * float(np.abs(sol.traction).max())
    if np.any(np.abs(density - sol.power_density) > allowed):
        raise ValueError("a power density that is not that of its tractions")
    if not (sol.plan.solves and sol.converged) or disc.loading.no_slip:
        return density
    allowed = SAME + 10 * sol.certificate.tangential_residual
    if np.abs(shift[:, sol.state == STICK]).max(initial=0.0) > allowed * largest:
        raise ValueError("a state of stick where there is slip")
    size, slips = np.hypot(*state.traction), sol.state == SLIP
    if np.any(size[slips] < (sol.traction_bound[slips] / disc.scales.pressure) - allowed * size.max()):
        raise ValueError("a state of slip where friction is not exhausted")
    return density


def _deserved(disc: Discretisation, sol: Solution, state: ContactState) -> bool:
    """Whether residuals and gaps are no larger than the certificate says, but for rounding."""
    told, traction = sol.certificate, state.traction
    normal, flat, level = normal_as_solved(disc, state.pressure, state.approach, traction)
    found = {"normal_residual": normal_residual(normal, flat, level), "residual": 0.0}
    gaps = {"normal_relative_gap": normal_gap(normal, flat, level)[1]}
    if disc.loading.frictionless:
        found["residual"] = found["normal_residual"]
    else:
        whole = residuals(disc, replace(state, traction=traction))
        found["tangential_residual"] = whole[1]
        found["residual"] = whole[1] if sol.plan.closed_form else max(whole)
        tangential = disc.tangential_problem(state.pressure, acting=traction)
        if tangential.size and not tangential.no_slip:
            own, rigid = tangential.of_grid(traction, state.rigid)
            gaps["relative_gap"] = gap(tangential, project(own, tangential.bound), rigid)[1]
    noise = _rounding(disc, state)
    known = {name: value for name, value in (found | gaps).items() if not np.isnan(getattr(told, name))}
    return all(value <= 2 * getattr(told, name) + noise for name, value in known.items())


def _rounding(disc: Discretisation, state: ContactState) -> float:
    """What the way through units and back can do to a residual.

    Unlike bodies with little friction magnify it, and so do distances that count from far away.
    """
    coefficients = np.ravel(1.0 if disc.loading.coefficient is None else disc.loading.coefficient)
    least = float(np.min(coefficients[coefficients > 0], initial=1.0))
    far = 10 * float(np.spacing(abs(disc.base))) / disc.scales.displacement
    own = disc.operators.normal.on(np.arange(1)).diagonal * float(state.pressure.max())
    return ROUNDED * (1 + abs(disc.K) / least) + far / own
