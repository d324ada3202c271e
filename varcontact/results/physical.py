"""Solution in physical units, from the contact state that solvers found."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np

from varcontact.discrete.certificate import Certificate
from varcontact.discrete.discretisation import Discretisation, discretise, undeformed_distance
from varcontact.discrete.state import ContactState
from varcontact.discrete.stick_slip import (
    SLIP,
    STICK,
    ContactResponse,
    left_fields,
    unit_slip,
)
from varcontact.interfaces.heat import Heat
from varcontact.interfaces.interface import Fields, StepBefore
from varcontact.results.plan import Plan
from varcontact.results.quantities_of_interest import friction_limit, semi_axes
from varcontact.results.solution import Solution
from varcontact.results.trace import trace_dataset
from varcontact.scene.motion import Shift, Steady, TimeStep
from varcontact.scene.scene import Scene
from varcontact.solvers.interface import SolveStats
from varcontact.transports import SteadyRolling, mirrored


def computed_when_read(response: ContactResponse, plan: Plan) -> bool:
    """True for theories with Hertz's pressure, whose fields are computed on reading, except in time
    steps, which would keep the data of all steps.
    """
    return plan.is_formula and not isinstance(response.disc.loading.motion, TimeStep)


def solution_of(
    scene: Scene,
    response: ContactResponse,
    plan: Plan,
    certificate: Certificate | Callable[[], Certificate],
    converged: bool,
    stats: SolveStats,
) -> Solution:
    """The response of a contact state in physical units, with slip, distances and areas.

    Fields that neither the forces of a theory nor its next step need are computed when they are
    read: the solution then keeps the response.
    """
    disc = response.disc
    state = response.state
    approach = state.approach * disc.scales.displacement + disc.base
    if scene.approach_undetermined and scene.approach is None:
        approach = math.nan
    areas = response.areas
    fields: dict[str, Any]
    if computed_when_read(response, plan):
        fields = {name: partial(field, response, plan) for name, field in FIELDS.items()}
    else:
        fields = {name: field(response, plan) for name, field in FIELDS.items()}
    on_parts = None
    if disc.subgrid is not None:
        on_parts = disc.subgrid.pressure * disc.scales.pressure
    return Solution(
        scene=scene,
        grid=disc.grid,
        plan=plan,
        pressure=state.pressure * disc.scales.pressure,
        traction=state.traction * disc.scales.pressure,
        **fields,
        state=areas,
        approach=approach,
        creepage=_creepage(scene, disc, state, response.unit_slip),
        certificate=certificate,
        converged=converged,
        iterations=state.iterations,
        status=state.status,
        timing=stats.timing,
        passes=state.passes,
        branch=state.branch,
        solved_by=state.solved_by,
        calls=stats.calls,
        carried=_carried(disc, left_fields(response)),
        pressure_on_parts=on_parts,
        trace=_trace(scene, disc, stats),
    )


def _slip(response: ContactResponse, plan: Plan) -> np.ndarray:
    return response.slip_shift / response.unit_slip


def _power_density(response: ContactResponse, plan: Plan) -> np.ndarray:
    """Frictional work per area; NaN with spin where the method gives no moment."""
    motion = response.disc.loading.motion
    if not plan.has_moment and motion is not None and motion.rigid[2]:
        return np.full(response.pressure.shape, math.nan)
    return response.work() * response.disc.scales.pressure / response.unit_slip


def _distance(response: ContactResponse, plan: Plan) -> np.ndarray:
    """Deformed distance, with that of the tractions where the bodies differ."""
    disc = response.disc
    scale = disc.scales.displacement
    distance = response.distance * scale + (disc.distance - disc.base)
    distance = distance + disc.known_distance * scale
    traction = response.traction
    if disc.K != 0 and np.any(traction):
        distance = distance + disc.operators.traction_to_distance.apply(traction)[0] * scale
    return np.asarray(distance - response.state.approach * scale)


FIELDS: dict[str, Callable[[ContactResponse, Plan], np.ndarray]] = {
    "slip": _slip,
    "power_density": _power_density,
    "distance": _distance,
}
"""Fields of a solution that follow from its pressure and tractions, by their names."""


def approach_on_grid(sol: Solution) -> float:
    """Approach of the fields of a solution, before it was extrapolated [length]."""
    if sol.error_estimate is None:
        return sol.approach
    return sol.error_estimate.on_grid.get("approach", sol.approach)


def _carried(disc: Discretisation, left: Fields) -> dict[str, np.ndarray]:
    """Fields that particles carry, in physical units."""
    sizes = {each.name: each.scale(disc.scales) for each in disc.interface.carried}
    return {name: field * sizes[name] for name, field in left.items()}


def step_before(sol: Solution, disc: Discretisation, heat: Sequence[Heat] = ()) -> StepBefore:
    """Solution as the previous step of the next one, dimensionless; `heat` is that of all steps so
    far.
    """
    quantities = disc.interface.carried
    return StepBefore(
        pressure=sol.pressure / disc.scales.pressure,
        traction=sol.traction / disc.scales.pressure,
        slip=np.where(sol.state == SLIP, np.hypot(*sol.slip), 0.0),
        slips=sol.state == SLIP,
        sticks=sol.state == STICK,
        carried={
            each.name: sol.carried[each.name] / each.scale(disc.scales)
            for each in quantities
            if each.name in sol.carried
        },
        heat=heat,
    )


def _trace(scene: Scene, disc: Discretisation, stats: SolveStats) -> Any:
    """Trace of the solvers, if it was recorded."""
    if stats.trace is None:
        return None
    energy = disc.scales.force * disc.scales.displacement
    return trace_dataset(stats.trace.records, energy, scene.units)


def _creepage(
    scene: Scene, disc: Discretisation, state: ContactState, rolled: float
) -> tuple[float, float, float]:
    """Prescribed creepages, and those found for prescribed forces; NaN where they are not
    unique.
    """
    motion = disc.loading.motion
    if motion is None:
        return 0.0, 0.0, 0.0
    along_x, along_y, about_z = motion.rigid
    additional = state.rigid / rolled
    forced = [motion.Fx is not None, motion.Fy is not None]
    if any(forced):
        undetermined = _undetermined_creepage(scene, disc, state)
        additional = np.where(forced & undetermined, math.nan, additional)
    return along_x + float(additional[0]), along_y + float(additional[1]), about_z


def _undetermined_creepage(scene: Scene, disc: Discretisation, state: ContactState) -> np.ndarray:
    """True for the directions (2,) in which a force determines no creepage."""
    motion = disc.loading.motion
    if disc.frictionless or not state.pressure.any():
        return np.array([True, True])
    if not scene.shift_undetermined or isinstance(motion, Steady):
        return np.array([False, False])
    # without a reference for the rigid shift, a change of force leaves its shift undetermined
    if isinstance(motion, Shift):
        return np.array([True, True])
    force = state.traction.sum(axis=(1, 2)) * disc.lattice.area
    change = force
    if disc.loading.previous_step is not None:
        change = force - disc.loading.previous_step.force
    # a force of zero is zero to that
    rounding = 1e-14 * state.pressure.sum() * disc.lattice.area
    return np.asarray(np.abs(change) > 1e-9 * np.abs(force) + rounding)


def rolling_resistance(sol: Solution) -> float:
    """Work of the pressure per distance rolled [force].

    Of elastic bodies on what tractions do to the distance: by Betti that of tractions on its slip.
    Viscoelastic ones push forward more than they push back: it is that on the slope of the
    undeformed distance.
    """
    rolls = 0 if sol.motion is None else sol.motion.rolls
    if sol.scene.bodies.relaxes:
        distance = undeformed_distance(sol.scene.surface, None, sol.grid)
        order: Literal[1, 2] = 2 if sol.grid.nx > 2 else 1
        slope = np.gradient(distance, sol.grid.sides[0], axis=1, edge_order=order)
        return rolls * float(np.sum(sol.pressure * slope) * sol.grid.area)
    if rolls == 0 or not sol.scene.coupled or not sol.traction.any():
        return 0.0
    disc = discretise(sol.scene, sol.grid)
    transport = disc.transport
    steady = SteadyRolling(abs(transport.distance), transport.dx, transport.difference)
    operator = disc.operators.pressure_to_shift(steady.stencil)
    pressure = sol.pressure[None]
    # the mean of the shifts in rolling forward and backward: backward by a mirror
    if not disc.mirrors:
        rolling_back = disc.operators.pressure_to_shift(mirrored(steady.stencil))
        twice = operator.apply(pressure) - rolling_back.apply(pressure)
    else:  # across x
        backward = operator.apply(pressure[..., ::-1])[..., ::-1]
        twice = operator.apply(pressure) + [[[1.0]], [[-1.0]]] * backward
    slip = 0.5 * twice / (disc.scales.pressure * unit_slip(disc))
    return 0.0 - float(rolls * np.sum(sol.traction * slip) * sol.grid.area)


def power_of_held_parts(sol: Solution) -> float:
    """Work per distance rolled [force] of the tractions that hold prescribed displacements and
    follow those of the contact.

    By Betti that of tractions on the slip that they give themselves, which vanishes without held
    parts.
    """
    if sol.motion is None or sol.motion.rolls == 0 or not sol.scene.displacements:
        return 0.0
    disc = discretise(sol.scene, sol.grid)
    stencil = disc.transport.stencil
    ahead = disc.operators.tangential(stencil).apply(sol.traction)
    back = disc.operators.tangential(mirrored(stencil)).apply(sol.traction)
    slip = 0.5 * (ahead - back) / (disc.scales.pressure * unit_slip(disc))
    return 0.0 - float(sol.motion.rolls * np.sum(sol.traction * slip) * sol.grid.area)


@dataclass(frozen=True)
class Normalised:
    """Values of a solution without dimension: contacts of all sizes and loads fall
    on the same curves.

    With the friction limit ``L = sum(f pz) dx dy`` (of bodies that do not slip,
    or without friction, the normal force), ``c = sqrt(a b)`` of Hertz's ellipse
    (of other contacts ``c^2`` is their area / pi; in line contact c is half
    their width), and the combined modulus of rigidity G.

    Attributes
    ----------
    Fx, Fy : float
        Tangential force / L.
    Mz : float
        Twisting moment / (L c).
    vx, vy : float
        Creepage * G c^2 / L (line contact: G c / L). Small ones give
        ``Fx = -C11 vx``, with Kalker's coefficient of the creepage. Of a shift:
        u G c / L (line contact: u G / L).
    spin : float
        Spin * G c^3 / L (line contact: G c^2 / L); small ones give
        ``Fy = -C23 spin``. Of a shift: rotation * G c^2 / L (line contact: G c
        / L).
    max_pressure : float
        Largest / mean pressure in the contact: 3/2 of an ellipse of Hertz, 4/pi
        of a line.
    """

    Fx: float
    Fy: float
    Mz: float
    vx: float
    vy: float
    spin: float
    max_pressure: float


def normalised(sol: Solution) -> Normalised:
    """See `Solution.normalised`."""
    limit = friction_limit(sol)
    if not 0 < limit < math.inf:
        limit = sol.normal_force
    if limit == 0:  # no contact
        return Normalised(*7 * (math.nan,))
    a, b = semi_axes(sol)
    size = math.sqrt(a * b)
    area = math.pi * a * b
    powers = 2
    if sol.scene.line:
        size = a
        area = 2 * a
        powers = 1
    if sol.motion is not None and sol.motion.rolls == 0:  # a shift is a length
        powers -= 1
    stiffness = sol.scene.bodies.combined_G * size**powers / limit
    return Normalised(
        Fx=sol.Fx / limit,
        Fy=sol.Fy / limit,
        Mz=sol.Mz / (limit * size),
        vx=sol.vx * stiffness,
        vy=sol.vy * stiffness,
        spin=sol.spin * size * stiffness,
        max_pressure=sol.max_pressure * area / sol.normal_force,
    )
