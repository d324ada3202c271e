"""Unlike bodies, corrected with their pressure: errors from the references.

Not part of the package, see docs/refinement.md. The pressure on parts of the parts is solved for under the field of
each pass, and the continuum's slip has a share by that pressure beside that by the tractions.
"""

from dataclasses import replace

import numpy as np

import varcontact as vc
from varcontact.discrete.discretisation import Discretisation, PreviousStep, discretise
from varcontact.discrete.state import ContactState, unloaded
from varcontact.discrete.subgrid import means
from varcontact.elasticity.operators import influence_operator
from varcontact.solvers.statistics import SolveStats
from varcontact.solving.contact_solver import ContactSolver, contact
from varcontact.solving.defect_correction.field import held_behind, reconstructed
from varcontact.solving.defect_correction.parts import Parts
from varcontact.solving.defect_correction.pressed import within_parts
from varcontact.solving.defect_correction.sublattice import Sublattice, loads
from varcontact.study.converge import contact_of

PARTS, PASSES = (2, 2), 3


def corrected(scene: vc.Scene, cells: int, again: bool) -> np.ndarray:
    """Fx, Fy and Mz: of the grid, and after each pass; the pressure on parts solved for `again` in each of them."""
    grid = vc.Grid(nx=cells, ny=cells).spread(contact_of(scene))
    posed = replace(scene, grid=grid)
    steps = ContactSolver(
        vc.plan(posed, normal="newton", tangential="newton"), 1e-8, False, SolveStats(), refined=False
    )
    disc = discretise(posed, grid)
    state = contact(disc, steps, steps.pressure(disc, unloaded(grid)))
    within = within_parts(disc)
    finest = grid.divided((PARTS[0] * within[0], PARTS[1] * within[1]))
    on_finest = discretise(replace(scene, grid=finest), finest)
    pressure = steps.pressure(on_finest, unloaded(finest))
    fine, by_pressure = _parts(disc, state, pressure.pressure * (on_finest.scales.pressure / disc.scales.pressure))
    field = reconstructed(state.traction, *fine.shapes, PARTS)
    forces = [loads(state.traction * disc.scales.pressure, grid)]
    for _ in range(PASSES):
        own = disc.known_shift + disc.tangential_operator.apply(state.traction)
        own += disc.pressure_to_shift.apply(state.pressure[None])
        lacking = fine.on_elements(fine.shift(field, np.zeros(2)) + by_pressure) - own
        bound = fine.coefficient * state.pressure
        inside = (bound > 0) & (means(fine.bound, PARTS) > 0)
        correction = held_behind(lacking, state.traction, bound) * inside
        state = contact(disc.with_loading(previous_step=PreviousStep(-correction, np.zeros(2))), steps, state)
        if again:
            spread = field.repeat(within[0], axis=1).repeat(within[1], axis=2) * (
                disc.scales.pressure / on_finest.scales.pressure
            )
            pressure = steps.pressure(on_finest, replace(pressure, traction=spread))
        fine, by_pressure = _parts(disc, state, pressure.pressure * (on_finest.scales.pressure / disc.scales.pressure))
        field = reconstructed(state.traction, *fine.shapes, PARTS)
        forces.append(fine.forces(field))
    return np.array(forces)


def _parts(disc: Discretisation, state: ContactState, finer: np.ndarray) -> tuple[Sublattice, np.ndarray]:
    """The parts with their bound, and the shift by the pressure on parts of the parts."""
    parts, within = Parts(disc, PARTS, state.pressure, finer), within_parts(disc)
    lattice = parts.lattice.divided(within)
    side, operators = lattice.sides[0], disc.operators
    slopes = influence_operator(lattice, "xy", "z", nu=operators.nu, K=disc.K, lag=side, offset=-side / 2)
    by_pressure = means(slopes.apply(finer[None]), within) * within[1] * parts.steps
    return Sublattice(parts, np.full(disc.grid.shape, disc.loading.coefficient)), by_pressure


def table() -> None:
    """Plain, and after three passes, with the pressure solved for again in each and as it is without tractions."""
    for name, known in vc.references().items():
        motion = known.scene.motion
        if known.scene.bodies.K == 0 or known.scene.line or not isinstance(motion, vc.Steady) or motion.Fx is not None:
            continue
        truth, units = (np.array([of[each] for each in ("Fx", "Fy", "Mz")]) for of in (known.values, known.units))
        row = []
        for cells in (16, 32):
            found = [corrected(known.scene, cells, again) for again in (True, False)]
            passes = (found[0][0], found[0][-1], found[1][-1])
            row += [np.abs((forces - truth) / units).max() for forces in passes]
        print(f"{name:42s} " + " ".join(f"{value:.1e}" for value in row), flush=True)
