"""Derivatives of forces by creepages: the problem linearised at a solution."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.state import with_subgrid
from varcontact.discrete.stick_slip import SLIP, STICK
from varcontact.errors import SceneError
from varcontact.results.solution import Solution
from varcontact.scene.friction import Law
from varcontact.scene.motion import Steady
from varcontact.system.process import one_blas_thread


@one_blas_thread()
def sensitivity(sol: Solution) -> np.ndarray:
    """Derivatives of the forces by the creepages, see `Solution.sensitivity`, with given areas at their solution.

    Unknowns are those of `Directions` and, for unlike bodies, the pressures and the approach.
    """
    scene = sol.scene
    check_linear(sol)
    if scene.shift_undetermined and not isinstance(scene.motion, Steady):
        if scene.bodies.slides:
            raise SceneError("bodies.base", "smooth", '"rigid" or a half-space: the stiffness of a step needs it')
        raise SceneError("surface.reference_depth", None, "given: in line contact the stiffness of a step needs it")
    contact = np.flatnonzero(sol.pressure.ravel() > 0)
    bearing = with_friction(sol)
    if bearing.size == 0:
        return np.zeros((2, 3))
    disc = with_subgrid(discretise(scene, sol.grid), sol.pressure_on_parts)
    with_pressure = contact if disc.K != 0 else np.zeros(0, dtype=int)
    shifts = unit_shifts(disc)[:, :, bearing]
    may = directions(disc, sol, bearing)
    slip, scales = may.slip, disc.scales
    n, m, first = bearing.size, with_pressure.size, may.size
    slips, pressures = np.arange(first - slip.size, first), slice(first, first + m)
    bears = np.searchsorted(with_pressure, bearing)
    columns = np.pad(may.tractions(np.eye(first)), ((0, 0), (0, m + (m > 0))))
    if m:  # where it slips the traction grows with the pressure
        columns[slip, first + bears[slip]], columns[n + slip, first + bears[slip]] = may.by_pressure

    elastic = disc.tangential_on(bearing).matrix @ columns
    if m:
        by_pressures = disc.pressure_to_shift.dense(with_pressure).reshape(2, m, m)
        elastic[:, pressures] += by_pressures[:, bears].reshape(2 * n, m)
    system, right = may.equations(elastic), -may.equations(shifts.reshape(len(shifts), -1).T)
    system[slips, slips] += may.turning  # it turns with the traction it opposes: |E| by the change of direction
    if m:  # contact stays closed, and the force or the approach stays what it is
        normal = np.zeros((m + 1, first + m + 1))
        by_tractions = disc.operators.traction_to_distance.dense(with_pressure).reshape(m, 2, m)
        normal[:m] = by_tractions[:, :, bears].reshape(m, -1) @ columns
        normal[:m, pressures] += disc.operators.normal.dense(with_pressure)
        normal[:m, -1] = -1.0
        normal[-1, pressures if disc.loading.normal_force is not None else -1] = 1.0
        system, right = np.concatenate([system, normal]), np.concatenate([right, np.zeros((m + 1, len(shifts)))])
    change = columns @ np.linalg.solve(system, right)
    totals = np.array([change[:n].sum(axis=0), change[n:].sum(axis=0)])
    slopes = totals * disc.lattice.area * scales.force
    return np.pad(slopes, ((0, 0), (0, 3 - slopes.shape[1])))  # line contact has no spin


def check_linear(sol: Solution) -> None:
    """Refuse solutions about which the problem cannot be linearised."""
    scene, plan = sol.scene, sol.plan
    if scene.motion is None:
        raise SceneError("motion", None, "given: without it there is no creepage")
    if plan.theory is not None or plan.one_pass:
        approximate = plan.tangential if plan.theory is not None else plan.coupling
        raise SceneError("solution", approximate, "by an exact method: this one is approximate")
    if isinstance(scene.friction, Law) and scene.friction.continuous:
        allowed = "a number or StaticKinetic: it must not fall with slip velocity"
        raise SceneError("friction", scene.friction, allowed)
    if scene.third_body is not None and scene.third_body.yields:
        allowed = "inf: sensitivities are for layers that do not yield"
        raise SceneError("third_body.tau_c0", scene.third_body.tau_c0, allowed)
    if scene.conformal:
        raise SceneError("surface.inclination", "given", "left out: sensitivities are for bodies that meet on a plane")


def with_friction(sol: Solution) -> np.ndarray:
    """Elements of a solution that can bear tractions, by their flat indices."""
    return np.flatnonzero((sol.state.ravel() != 0) & (np.nan_to_num(sol.traction_bound, posinf=1.0).ravel() > 0))


def unit_shifts(disc: Discretisation) -> np.ndarray:
    """Rigid shifts by unit creepages, (3, 2, elements of the grid) (2 of them in line contact), dimensionless."""
    motion, every = disc.loading.motion, ("vx", "vy", "spin", "ux", "uy", "rotation")
    assert motion is not None
    still: dict[str, Any] = {**{name: 0.0 for name in every if hasattr(motion, name)}, "Fx": None, "Fy": None}
    still |= {"rigid_slip": None} if hasattr(motion, "rigid_slip") else {}
    names = (every[:3] if motion.rolls else every[3:])[: 2 if disc.grid.line else 3]
    units = [replace(motion, **{**still, name: 1.0}) for name in names]
    return np.array([disc.with_loading(motion=unit).rigid_shift.reshape(2, -1) for unit in units])


@dataclass(frozen=True, eq=False)
class Directions:
    """How tractions of n elements may change: freely where they stick, by turning and with the pressure in slip.

    Unknowns: changes along x and along y of what sticks, those `across` the traction (2, s) of what slips. Equations:
    no slip along both where it sticks; across it where it slips, with the change times the `turning` (s,). By pressure
    the tractions of `slip`, places among the n, grow `by_pressure`.
    """

    stick: np.ndarray
    slip: np.ndarray
    across: np.ndarray
    turning: np.ndarray
    by_pressure: np.ndarray

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return 2 * self.stick.size + self.slip.size

    def tractions(self, unknowns: np.ndarray) -> np.ndarray:
        """Tractions (2 n, k) by unknowns (size, k)."""
        turned, k = 2 * self.stick.size, unknowns.shape[1]
        found = np.empty((2, self.stick.size + self.slip.size, k), unknowns.dtype)
        found[:, self.stick] = unknowns[:turned].reshape(2, self.stick.size, k)
        found[:, self.slip] = self.across[:, :, None] * unknowns[turned:]
        return found.reshape(-1, k)

    def equations(self, shifts: np.ndarray) -> np.ndarray:
        """Left-hand sides (size, k) by shifts (2 n, k), but for the turning."""
        both = shifts.reshape(2, -1, shifts.shape[1])
        turned = self.across[0][:, None] * both[0, self.slip] + self.across[1][:, None] * both[1, self.slip]
        return np.concatenate([both[0, self.stick], both[1, self.stick], turned])


def directions(disc: Discretisation, sol: Solution, bearing: np.ndarray) -> Directions:
    """Those of the elements of a solution that bear tractions."""
    state, scales = sol.state.ravel()[bearing], disc.scales
    stick, slip = np.flatnonzero(state == STICK), np.flatnonzero(state == SLIP)
    traction = sol.traction.reshape(2, -1)[:, bearing[slip]] / scales.pressure
    size = np.hypot(*traction)
    rolled = disc.step * scales.length if disc.step is not None else 1.0
    shift = sol.slip.reshape(2, -1)[:, bearing[slip]] * rolled / scales.displacement
    by_pressure = traction / (sol.pressure.ravel()[bearing[slip]] / scales.pressure)
    return Directions(stick, slip, np.array([-traction[1], traction[0]]) / size, np.hypot(*shift) / size, by_pressure)
