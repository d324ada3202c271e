"""From the contact state that solvers found to the solution in physical units."""

from __future__ import annotations

import math

import numpy as np

from varcontact.discrete.certificate import Certificate
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.state import ContactState
from varcontact.discrete.stick_slip import friction_work, shift_and_areas, unit_slip
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.solvers.statistics import Calls


def solution_of(
    scene: Scene,
    disc: Discretisation,
    plan: Plan,
    state: ContactState,
    certificate: Certificate,
    converged: bool,
    timing: dict[str, float],
    calls: dict[str, dict[str, Calls]],
) -> Solution:
    """A contact state in physical units, with slip, distances and areas."""
    scale = disc.scales.displacement
    distance = disc.operators.normal.apply(state.pressure[None])[0] * scale + (disc.distance - disc.base)
    if disc.K != 0 and np.any(state.traction):
        distance = distance + disc.operators.traction_to_distance.apply(state.traction)[0] * scale
    shift, areas = shift_and_areas(disc, state)
    rolled = unit_slip(disc)
    unknown = disc.undetermined_constant and scene.approach is None
    density = friction_work(disc, state, shift) * disc.scales.pressure / rolled
    if not plan.has_moment and disc.loading.motion is not None and disc.loading.motion.rigid[2]:
        density = np.full_like(density, math.nan)
    return Solution(
        scene=scene,
        grid=disc.grid,
        plan=plan,
        pressure=state.pressure * disc.scales.pressure,
        traction=state.traction * disc.scales.pressure,
        slip=shift / rolled,
        power_density=density,
        distance=distance - state.approach * disc.scales.displacement,
        state=areas,
        approach=math.nan if unknown else state.approach * disc.scales.displacement + disc.base,
        creepage=_creepage(disc, state, rolled),
        certificate=certificate,
        converged=converged,
        iterations=state.iterations,
        status=state.status,
        timing=timing,
        passes=state.passes,
        branch=state.branch,
        solved_by=state.solved_by,
        calls=calls,
        pressure_on_parts=None if disc.subgrid is None else disc.subgrid.pressure * disc.scales.pressure,
    )


def _creepage(disc: Discretisation, state: ContactState, rolled: float) -> tuple[float, float, float]:
    """Prescribed creepages, and those found for prescribed forces; NaN where they are not unique."""
    if disc.loading.motion is None:
        return 0.0, 0.0, 0.0
    motion, found = disc.loading.motion, state.rigid / rolled
    along_x, along_y, about_z = motion.rigid
    prescribed = np.array([motion.Fx is not None, motion.Fy is not None])
    unknown = np.full(2, disc.loading.frictionless or not state.pressure.any())
    if disc.undetermined_constant and not isinstance(motion, Steady):
        before = np.zeros(2) if disc.loading.previous_step is None else disc.loading.previous_step.force
        force = state.traction.sum(axis=(1, 2)) * disc.lattice.area
        rounding = 1e-14 * state.pressure.sum() * disc.lattice.area  # a force of zero is zero to that
        unknown |= isinstance(motion, Shift) | (np.abs(force - before) > 1e-9 * np.abs(force) + rounding)
    found = np.where(prescribed & unknown, math.nan, found)
    return along_x + float(found[0]), along_y + float(found[1]), about_z


def rolling_resistance(sol: Solution) -> float:
    """Work of the pressure on what tractions do to the distance [force]: by Betti that of tractions on its slip."""
    rolls = 0 if sol.motion is None else sol.motion.rolls
    if rolls == 0 or sol.scene.bodies.K == 0 or sol.plan.left_out or not sol.traction.any():
        return 0.0
    disc = discretise(sol.scene, sol.grid)
    operator, pressure = (
        disc.operators.pressure_to_shift(disc.step, disc.loading.slip_difference),
        sol.pressure[None],
    )
    twice = operator.apply(pressure) + operator.apply(pressure[..., ::-1, ::-1])[..., ::-1, ::-1]
    slip = 0.5 * twice / (disc.scales.pressure * unit_slip(disc))
    return 0.0 - float(rolls * np.sum(sol.traction * slip) * sol.grid.area)
