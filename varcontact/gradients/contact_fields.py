"""Fields of a contact in a scene: its own scene, or a neighbouring one in which they leave
residuals.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.results.linearised import unit_shifts
from varcontact.scene.friction import bound_under
from varcontact.scene.motion import TimeStep
from varcontact.scene.scene import Scene
from varcontact.system.process import lazy_property

CREEPAGES = "vx", "vy", "spin"
SHIFTS = "ux", "uy", "rotation"
BOUND_STEP = 1e-5
"""Relative step of the central differences of a traction bound by pressure and by slip."""


def creepages_of(motion: Any) -> tuple[str, str, str]:
    """Names of the creepages of a motion, or of the components of a shift."""
    if motion is None or motion.rolls:
        return CREEPAGES
    return SHIFTS


@dataclass(frozen=True, eq=False)
class ContactFields:
    """Pressure (ny, nx), traction (2, ny, nx), creepages (3,) and approach of a contact, physical.

    Creepages are those that are prescribed, and those found for a force; of a shift its components.
    Of a step of a history `brought` (2, ny, nx) is the local shift by what particles bring along.
    In a scene nearby, `of_solution` are the fields in the scene of the solution.
    """

    scene: Scene
    disc: Discretisation
    pressure: np.ndarray
    traction: np.ndarray
    creepage: np.ndarray
    approach: float
    brought: np.ndarray | float = 0.0
    of_solution: ContactFields | None = None

    @property
    def area(self) -> float:
        """Area of an element."""
        return self.disc.grid.area

    @property
    def rolled(self) -> float:
        """Rigid shift in a step by a unit creepage: the distance rolled; 1 in a shift."""
        if self.disc.step is None:
            return 1.0
        return self.disc.step * self.disc.scales.length

    @property
    def names(self) -> tuple[str, str, str]:
        """Names of the creepages, or of the components of the shift."""
        return creepages_of(self.scene.motion)

    @lazy_property
    def compliance(self) -> float:
        """Unit of displacement divided by the unit of traction."""
        return self.disc.scales.displacement / self.disc.scales.pressure

    @lazy_property
    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """x and y of the centres, (ny, nx) each."""
        solved = self._on_same_grid
        if solved is not None:
            return solved.places
        x, y = np.meshgrid(self.disc.grid.x, self.disc.grid.y)
        return x, y

    @lazy_property
    def deformed_distance(self) -> np.ndarray:
        """e = h + A_zz p + A_zt q - approach, (ny, nx)."""
        return self.elastic_distance * self.compliance + self.disc.distance - self.approach

    @lazy_property
    def elastic_distance(self) -> np.ndarray:
        """A_zz p + A_zt q of dimensionless influence numbers, (ny, nx)."""
        operators = self.disc.operators
        of_solution = self.of_solution
        if of_solution is not None and operators is of_solution.disc.operators:
            return of_solution.elastic_distance
        elastic = operators.normal.apply(self.pressure[None])[0]
        if self._has_tractions and self.disc.K != 0:
            elastic = elastic + operators.traction_to_distance.apply(self.traction)[0]
        return elastic

    @lazy_property
    def local_shift(self) -> np.ndarray:
        """E = W + M q + B p, (2, ny, nx): the slip times the distance rolled; in a shift it is the
        local shift.
        """
        elastic = self.elastic_shift
        if self.disc.edge_compliance is not None:
            elastic = elastic + self.disc.edge_compliance * self.traction
        return elastic * self.compliance + self.rigid_shift + self.brought

    @lazy_property
    def elastic_shift(self) -> np.ndarray:
        """M q + B p of dimensionless influence numbers, (2, ny, nx)."""
        disc = self.disc
        operator = disc.tangential_operator
        of_solution = self.of_solution
        if of_solution is not None and operator is of_solution.disc.tangential_operator:
            return of_solution.elastic_shift
        elastic = operator.apply(self.traction)
        if disc.K != 0:
            elastic = elastic + disc.pressure_to_shift.apply(self.pressure[None])
        return elastic

    @lazy_property
    def rigid_shift(self) -> np.ndarray:
        """Rigid shift W, with the creepages that follow from prescribed forces, (2, ny, nx)."""
        solved = self._on_same_grid
        if solved is not None and self._moves_like(solved):
            return solved.rigid_shift
        motion = self.disc.loading.motion
        rigid: dict[str, Any] = dict(zip(self.names, map(float, self.creepage), strict=True))
        if self.disc.grid.line:
            del rigid[self.names[2]]
        assert motion is not None
        if isinstance(motion, TimeStep):  # creepages of a step include its shifts
            rigid = dict.fromkeys(SHIFTS, 0.0) | rigid
        known = replace(motion, Fx=None, Fy=None, **rigid)
        return self.disc.with_loading(motion=known).rigid_shift * self.disc.scales.displacement

    @lazy_property
    def unit_shifts(self) -> np.ndarray:
        """Rigid shifts by unit creepages, (3, 2, N); 2 of them in line contact."""
        return unit_shifts(self.disc) * self.disc.scales.displacement

    @lazy_property
    def slip(self) -> np.ndarray:
        """Relative slip |s|: local shift divided by the distance rolled, (ny, nx)."""
        return np.hypot(*self.local_shift) / self.rolled

    @lazy_property
    def bound(self) -> np.ndarray:
        """Traction bound g of slipping elements, (ny, nx); zero without slip, where nothing is at
        its bound.
        """
        solved = self._on_same_grid
        friction = self.scene.friction
        coulomb = isinstance(friction, float | np.ndarray)
        if solved is not None and friction is solved.scene.friction and coulomb:
            return solved.bound
        return self._bound(self.pressure, self.slip)

    @lazy_property
    def bound_by_pressure(self) -> np.ndarray:
        """dg/dp, (ny, nx)."""
        step = BOUND_STEP * self.pressure
        return self._slope(self._bound(self.pressure + step, self.slip), -step, 0.0, step)

    @lazy_property
    def bound_by_slip(self) -> np.ndarray:
        """dg/ds, (ny, nx)."""
        step = BOUND_STEP * self.slip
        return self._slope(self._bound(self.pressure, self.slip + step), 0.0, -step, step)

    def _slope(
        self,
        above: np.ndarray,
        pressure_step: np.ndarray | float,
        slip_step: np.ndarray | float,
        step: np.ndarray,
    ) -> np.ndarray:
        """Central difference of the bound; zero where there is no step."""
        below = self._bound(self.pressure + pressure_step, self.slip + slip_step)
        found: np.ndarray = (above - below) / np.where(step > 0, 2 * step, 1.0)
        return found

    def _bound(self, pressure: np.ndarray, slip: np.ndarray) -> np.ndarray:
        return bound_under(self.scene.friction, pressure, slip, *self.places)

    @property
    def _on_same_grid(self) -> ContactFields | None:
        """The fields in the scene of the solution, if this is another one on the same grid."""
        if self.of_solution is None or self.of_solution.disc.grid is not self.disc.grid:
            return None
        return self.of_solution

    def _moves_like(self, solved: ContactFields) -> bool:
        """True where the rigid shift of both scenes is the same; loads beside the contact
        contribute to it.
        """
        same_motion = self.disc.loading.motion is solved.disc.loading.motion
        beside = self.disc.loading.beside is not None
        return same_motion and not beside and np.array_equal(self.creepage, solved.creepage)

    @property
    def _has_tractions(self) -> bool:
        return self.disc.loading.motion is not None
