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
    """Derivatives of the forces by the creepages, see `Solution.sensitivity`."""
    scene, plan = sol.scene, sol.plan
    if scene.motion is None:
        raise SceneError("motion", None, "given: without it there is no creepage")
    if plan.theory is not None or plan.one_pass:
        approximate = plan.tangential if plan.theory is not None else plan.coupling
        raise SceneError(
            "solution",
            approximate,
            "by an exact method",
            message=f"solution is by {approximate}, which is approximate; sensitivities need one by an exact method",
        )
    if isinstance(scene.friction, Law) and scene.friction.continuous:
        raise SceneError(
            "friction",
            scene.friction,
            "a coefficient that does not fall with slip velocity",
            message="friction: sensitivities are for a coefficient that does not fall with slip velocity; "
            "use a number or StaticKinetic",
        )
    if scene.conformal:
        message = "surface.inclination: sensitivities are for bodies that meet on a plane"
        raise SceneError("surface.inclination", "given", "left out", message=message)
    if scene.shift_undetermined and not isinstance(scene.motion, Steady):
        if scene.bodies.slides:
            raise SceneError("bodies.base", "smooth", '"rigid" or a half-space: the stiffness of a step needs it')
        raise SceneError("surface.reference_depth", None, "given: in line contact the stiffness of a step needs it")
    contact = np.flatnonzero(sol.pressure.ravel() > 0)
    bearing = np.flatnonzero((sol.state.ravel() != 0) & (np.nan_to_num(sol.traction_bound, posinf=1.0).ravel() > 0))
    if bearing.size == 0:
        return np.zeros((2, 3))
    disc = with_subgrid(discretise(scene, sol.grid, coupled=not plan.left_out), sol.pressure_on_parts)
    linear = _Linearised(disc, sol, bearing, contact if disc.K != 0 else np.zeros(0, dtype=int))
    slopes = linear.forces(_unit_shifts(disc)[:, :, bearing])
    return np.pad(slopes, ((0, 0), (0, 3 - slopes.shape[1])))  # line contact has no spin


def _unit_shifts(disc: Discretisation) -> np.ndarray:
    """Rigid shifts by unit creepages, (3, 2, elements of the grid) (2 of them in line contact), dimensionless."""
    motion, every = disc.loading.motion, ("vx", "vy", "spin", "ux", "uy", "rotation")
    assert motion is not None
    still: dict[str, Any] = {**{name: 0.0 for name in every if hasattr(motion, name)}, "Fx": None, "Fy": None}
    still |= {"rigid_slip": None} if hasattr(motion, "rigid_slip") else {}
    names = (every[:3] if motion.rolls else every[3:])[: 2 if disc.line else 3]
    units = [replace(motion, **{**still, name: 1.0}) for name in names]
    return np.array([disc.with_loading(motion=unit).rigid_shift.reshape(2, -1) for unit in units])


@dataclass(frozen=True, eq=False)
class _Linearised:
    """The equations of given areas, at their solution.

    Unknowns: changes of both traction components where it sticks (x, then y), of the traction's direction where
    it slips, and, for unlike bodies, of the pressures and the approach.
    """

    disc: Discretisation
    sol: Solution
    bearing: np.ndarray
    pressed: np.ndarray

    def forces(self, shifts: np.ndarray) -> np.ndarray:
        """Change of (Fx, Fy) by each rigid shift (k, 2, n), physical: (2, k)."""
        rows, columns = self._rows(), self._tractions()
        elastic = self._tangential() @ columns + self._by_pressures()
        system = rows @ elastic + self._turned()
        right = -(rows @ shifts.reshape(len(shifts), -1).T)
        if self.pressed.size:
            normal, given = self._normal(columns)
            system, right = np.concatenate([system, normal]), np.concatenate([right, np.zeros((given, len(shifts)))])
        change = columns @ np.linalg.solve(system, right)
        n = self.bearing.size
        totals = np.array([change[:n].sum(axis=0), change[n:].sum(axis=0)])
        return np.asarray(totals * self.disc.lattice.area * self.disc.scales.force)

    @property
    def _sticks(self) -> np.ndarray:
        return np.flatnonzero(self.sol.state.ravel()[self.bearing] == STICK)

    @property
    def _slips(self) -> np.ndarray:
        return np.flatnonzero(self.sol.state.ravel()[self.bearing] == SLIP)

    @property
    def _traction(self) -> np.ndarray:
        return np.asarray(self.sol.traction.reshape(2, -1)[:, self.bearing] / self.disc.scales.pressure)

    def _tangential(self) -> np.ndarray:
        return self.disc.tangential_on(self.bearing).matrix

    def _tractions(self) -> np.ndarray:
        """From the unknowns to the changes of tractions, (2 n, unknowns)."""
        n, stick, slip = self.bearing.size, self._sticks, self._slips
        h, pressed = stick.size, self.pressed.size
        columns = np.zeros((2 * n, 2 * h + slip.size + pressed + (pressed > 0)))
        columns[stick, np.arange(h)] = columns[n + stick, h + np.arange(h)] = 1.0
        along_x, along_y = self._traction[:, slip]
        columns[slip, 2 * h + np.arange(slip.size)] = -along_y
        columns[n + slip, 2 * h + np.arange(slip.size)] = along_x
        if pressed:  # where it slips the traction grows with the pressure
            place = 2 * h + slip.size + np.searchsorted(self.pressed, self.bearing[slip])
            pressure = self.sol.pressure.ravel()[self.bearing[slip]] / self.disc.scales.pressure
            columns[slip, place], columns[n + slip, place] = along_x / pressure, along_y / pressure
        return columns

    def _rows(self) -> np.ndarray:
        """From local shifts to the equations: both components where it sticks, that across where it slips."""
        n, stick, slip = self.bearing.size, self._sticks, self._slips
        h = stick.size
        rows = np.zeros((2 * h + slip.size, 2 * n))
        rows[np.arange(h), stick] = rows[h + np.arange(h), n + stick] = 1.0
        along_x, along_y = self._traction[:, slip] / np.hypot(*self._traction[:, slip])
        rows[2 * h + np.arange(slip.size), slip] = -along_y
        rows[2 * h + np.arange(slip.size), n + slip] = along_x
        return rows

    def _turned(self) -> np.ndarray:
        """The shift that turns with the traction it opposes: |E| by the change of direction."""
        h, slip = self._sticks.size, self._slips
        turned = np.zeros((2 * h + slip.size, 2 * h + slip.size + self.pressed.size + (self.pressed.size > 0)))
        rolled = self.disc.step * self.disc.scales.length if self.disc.step is not None else 1.0
        shift = self.sol.slip.reshape(2, -1)[:, self.bearing[slip]] * rolled / self.disc.scales.displacement
        place = 2 * h + np.arange(slip.size)
        turned[place, place] = np.hypot(*shift)
        return turned

    def _by_pressures(self) -> np.ndarray:
        """Local shift by changes of the pressures, (2 n, unknowns)."""
        n, pressed = self.bearing.size, self.pressed.size
        shift = np.zeros((2 * n, 2 * self._sticks.size + self._slips.size + pressed + (pressed > 0)))
        if pressed:
            every = self.disc.pressure_to_shift.dense(self.pressed).reshape(2, pressed, pressed)
            bears = np.searchsorted(self.pressed, self.bearing)
            first = 2 * self._sticks.size + self._slips.size
            shift[:, first : first + pressed] = every[:, bears].reshape(2 * n, pressed)
        return shift

    def _normal(self, columns: np.ndarray) -> tuple[np.ndarray, int]:
        """Contact stays closed, and the force or the approach stays what it is: rows, and how many."""
        pressed, first = self.pressed.size, 2 * self._sticks.size + self._slips.size
        rows = np.zeros((pressed + 1, first + pressed + 1))
        every = self.disc.operators.traction_to_distance.dense(self.pressed).reshape(pressed, 2, pressed)
        bears = np.searchsorted(self.pressed, self.bearing)
        rows[:pressed] = every[:, :, bears].reshape(pressed, -1) @ columns
        rows[:pressed, first : first + pressed] += self.disc.operators.normal.dense(self.pressed)
        rows[:pressed, -1] = -1.0
        if self.disc.loading.normal_force is not None:
            rows[-1, first : first + pressed] = 1.0
        else:
            rows[-1, -1] = 1.0
        return rows, pressed + 1
