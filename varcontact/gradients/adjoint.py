"""An output with the multipliers of the contact's equations: derivatives by any input.

With multipliers that make the Lagrangian ``L = J - l_n.e - l_N (sum p dA - N) - l_t.E -
l_g.(n.q - g) - l_F.(sum q dA - F)`` stationary in all unknowns, the derivative of the output J
by an input is the partial one of L, without a further solve.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from varcontact.discrete.discretisation import discretise
from varcontact.discrete.state import hertz_pressure, unloaded, with_subgrid
from varcontact.errors import SceneError
from varcontact.gradients.contact_fields import ContactFields
from varcontact.gradients.linearised_contact import Edge, LinearisedContact, Multipliers
from varcontact.gradients.outputs import Output, Partial
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import TimeStep
from varcontact.scene.scene import Scene
from varcontact.system.process import lazy_property

RELATIVE_STEP = 1e-5
"""Step of the central difference of the Lagrangian by an input without a formula of its own: two
residuals, no solve."""

SceneOf = Callable[[float], Scene]


@dataclass(frozen=True, eq=False)
class LinearisedSolution:
    """A solution with its linearised contact. `hertz`: its pressure is Hertz's closed form, which
    takes the place of e = 0.
    """

    solution: Solution
    contact: LinearisedContact
    hertz: bool

    @classmethod
    def of(cls, solution: Solution, edge: Edge) -> LinearisedSolution:
        """Linearisation about a solution."""
        scene = solution.scene
        disc = with_subgrid(discretise(scene, solution.grid), solution.pressure_on_parts)
        fields = ContactFields(
            scene,
            disc,
            solution.pressure,
            solution.traction,
            np.nan_to_num(np.array(solution.creepage, float)),
            float(np.nan_to_num(solution.approach)),
        )
        if isinstance(scene.motion, TimeStep):
            shift = solution.slip * fields.rolled
            fields = replace(fields, brought=shift - fields.local_shift)
        hertz = solution.plan.normal == "hertz"
        return cls(solution, LinearisedContact.about(solution, fields, edge), hertz)

    @property
    def fields(self) -> ContactFields:
        return self.contact.fields

    def adjoint(self, output: Output) -> Adjoint:
        """The output with its multipliers."""
        fields = self.fields
        contact = self.contact
        shape = fields.disc.grid.shape
        partial = output.partial(fields)
        by_tractions = np.zeros((2, *shape)) + partial.traction / fields.compliance
        by_pressure = np.zeros(shape) + partial.pressure / fields.compliance
        by_rigid = np.array([partial.creepage[i] / fields.rolled for i in contact.free])
        by_approach = -partial.approach * contact.has_load
        if contact.coupled:
            grown = (contact.areas.growing * by_tractions).sum(axis=0)
            found = contact.joint_multipliers(
                by_tractions, by_pressure + grown, by_rigid, by_approach
            )
            of_bound = self._of_bound(by_tractions, found)
            return Adjoint(self, output, self._physical(found), of_bound, np.zeros(shape))
        found = Multipliers(np.zeros((2, *shape)), np.zeros(shape), np.zeros(len(contact.free)), 0)

        # the tangential problem, and what it weights by pressures
        of_bound = np.zeros(shape)
        if contact.moves and (by_tractions.any() or by_rigid.any()):
            found = contact.tangential_multipliers(by_tractions, by_rigid)
            of_bound = self._of_bound(by_tractions, found)
            grown = (contact.areas.growing * by_tractions).sum(axis=0)
            weighted = contact.by_pressure(found.shift, found.by_tractions)
            by_pressure = by_pressure + grown - weighted

        # the normal problem, unless its pressure is known in closed form
        if self.hertz:
            of_pressure = by_pressure * fields.compliance
            return Adjoint(self, output, self._physical(found), of_bound, of_pressure)
        if by_pressure.any() or by_approach:
            normal = contact.normal_multipliers(by_pressure, by_approach)
            found = replace(found, distance=normal.distance, load=normal.load)
        return Adjoint(self, output, self._physical(found), of_bound, np.zeros(shape))

    def _of_bound(self, by_tractions: np.ndarray, found: Multipliers) -> np.ndarray:
        """Multipliers of n.q = g, physical, (ny, nx)."""
        left = by_tractions - found.by_tractions
        of_bound: np.ndarray = (self.contact.areas.along * left).sum(axis=0)
        return of_bound * self.fields.compliance

    def _physical(self, found: Multipliers) -> Multipliers:
        per_area = self.fields.compliance / self.fields.area
        return replace(found, forces=found.forces * per_area, load=found.load * per_area)


@dataclass(frozen=True, eq=False)
class Adjoint:
    """An output with its multipliers, physical: `of_bound` (ny, nx) of n.q = g, `of_pressure`
    (ny, nx) of a pressure in closed form.
    """

    about: LinearisedSolution
    output: Output
    multipliers: Multipliers
    of_bound: np.ndarray
    of_pressure: np.ndarray

    @property
    def value(self) -> float:
        return self.output.value(self.about.fields)

    @lazy_property
    def _partial(self) -> Partial:
        return self.output.partial(self.about.fields)

    # ------------------------------------------------------------------- by formulas

    def by_creepage(self, component: int) -> float:
        """Derivative with respect to a prescribed creepage, or to a component of a shift."""
        fields = self.about.fields
        explicit = float(self._partial.creepage[component])
        shifts = fields.unit_shifts
        if component >= len(shifts):
            return explicit
        own = self.multipliers.shift.reshape(2, -1)
        return explicit - float((own * shifts[component]).sum())

    def by_force(self, component: int) -> float:
        """Derivative with respect to a prescribed tangential force."""
        row = self.about.contact.free.index(component)
        return float(self.multipliers.forces[row])

    @property
    def by_friction(self) -> np.ndarray:
        """Derivatives with respect to the coefficient of friction of each element, (ny, nx)."""
        found: np.ndarray = (
            self.of_bound * self.about.contact.areas.slip * self.about.fields.pressure
        )
        return found

    @property
    def by_distance(self) -> np.ndarray:
        """Derivatives with respect to the undeformed distance of each element, (ny, nx)."""
        return -self._of_distance

    @property
    def by_load(self) -> float:
        """Derivative with respect to the prescribed normal force or approach, where the pressure
        solves the grid's equations.
        """
        if self.about.contact.has_load:
            return self.multipliers.load
        return self._partial.approach + float(self.multipliers.distance.sum())

    @lazy_property
    def _of_distance(self) -> np.ndarray:
        """Multipliers of e; for a pressure in closed form those of the discrete problem."""
        about = self.about
        if not about.hertz:
            return self.multipliers.distance
        if about.solution.grid.edge != "centres":
            allowed = 'on a grid whose edge is "centres"'
            raise SceneError("by", "distance", allowed)
        by_approach = -self._partial.approach * about.contact.has_load
        by_pressure = self.of_pressure / about.fields.compliance
        return about.contact.normal_multipliers(by_pressure, by_approach).distance

    # ------------------------------------------------------------------- by differences of L

    def along(self, scene_of: SceneOf, value: float) -> float:
        """Derivative with respect to any number of the scene, by a central difference of L at its
        value.
        """
        step = RELATIVE_STEP * (abs(value) or 1.0)
        return self.between(scene_of(value + step), scene_of(value - step)) / (2 * step)

    def between(self, above: Scene, below: Scene) -> float:
        """Difference of L between two scenes, one on either side of the present one."""
        return self.lagrangian(above) - self.lagrangian(below)

    def lagrangian(self, scene: Scene, grid: Grid | None = None) -> float:
        """Lagrangian L of the solution's fields in another scene, on the solution's grid or
        another.
        """
        about = self.about
        fields = self._in_scene(scene, grid or about.solution.grid)
        total = self.output.value(fields)
        if about.hertz:
            total += self._pressure_moved(fields)
        else:
            total -= float((self.multipliers.distance * fields.deformed_distance).sum())
            if scene.normal_force is not None:
                missing = fields.pressure.sum() * fields.area - scene.normal_force
                total -= self.multipliers.load * float(missing)
        if about.contact.moves:
            total -= self._tangential_residuals(fields)
        return total

    def _in_scene(self, scene: Scene, grid: Grid) -> ContactFields:
        """The fields of the solution in another scene."""
        about = self.about
        base = about.fields
        disc = discretise(scene, grid, base.disc.operators)
        disc = with_subgrid(disc, about.solution.pressure_on_parts)
        creepage = base.creepage
        if scene.motion is not None:
            unknown = np.isin(np.arange(3), about.contact.free)
            creepage = np.where(unknown, creepage, scene.motion.rigid)
        approach = base.approach
        if scene.approach is not None:
            approach = scene.approach
        return replace(
            base, scene=scene, disc=disc, creepage=creepage, approach=approach, of_solution=base
        )

    @lazy_property
    def _of_free_shift(self) -> np.ndarray:
        """Multipliers of E; along the traction the shift counts by the bound alone."""
        return self.about.contact.areas.within(self.multipliers.shift)

    @lazy_property
    def _slipping_traction(self) -> np.ndarray:
        """n.q in the slip area, (ny, nx): size of the tractions that slip."""
        along = self.about.contact.areas.along
        slipping: np.ndarray = (along * self.about.fields.traction).sum(axis=0)
        return slipping

    def _pressure_moved(self, fields: ContactFields) -> float:
        """Change of L by a change of Hertz's pressure and approach."""
        base = self.about.fields
        disc = fields.disc
        state = hertz_pressure(disc, unloaded(disc.grid))
        moved = state.pressure * disc.scales.pressure - base.pressure
        total = float((self.of_pressure * moved * self.about.contact.areas.contact).sum())
        explicit = self._partial.approach
        if explicit and self.about.contact.has_load:
            approach = state.approach * disc.scales.displacement + disc.base
            total += explicit * (approach - base.approach)
        return total

    def _tangential_residuals(self, fields: ContactFields) -> float:
        """Residuals of the tangential problem, weighted by their multipliers."""
        scene = fields.scene
        total = float((self._of_free_shift * fields.local_shift).sum())
        total += float((self.of_bound * (self._slipping_traction - fields.bound)).sum())
        for row, component in enumerate(self.about.contact.free):
            force = (scene.motion.Fx, scene.motion.Fy)[component]
            missing = fields.traction[component].sum() * fields.area - force
            total += self.multipliers.forces[row] * float(missing)
        return total
