"""The transposed linear problem about a solved contact, with its areas held.

Contact C, stick S and slip T are those of the solution; n is along the traction that
slips, t across it. With q the tractions, p the pressure, A, M and B influence numbers::

    C: e = h + A_zz p + A_zt q - d = 0          load: sum p dA = N, or d is given
    S: E = W + M q + B p = 0                    forces: sum q dA = F, creepages unknown
    T: t.E = 0, linearised t.dE + (|E|/g) t.dq = 0, and n.q = g(p, s)

The traction bound g may change with the relative slip s = |E|/dq: then n.dE changes n.q by
-g_s/dq, and the multipliers of E have a part along n as well.

Multipliers of these equations solve the transposed problem. Its operators are block-Toeplitz
with mirrored tables, so that Newton's preconditioner serves: it sees from the kernel that
particles come from the other side.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.elasticity.operators import GridOperator
from varcontact.errors import NotConverged
from varcontact.gradients.contact_fields import ContactFields
from varcontact.gradients.held_areas import HeldAreas, MovingEdge, Part, with_moving_edge
from varcontact.results.solution import Solution
from varcontact.scene.motion import Steady
from varcontact.solvers.newton.gcr import Forces
from varcontact.solvers.newton.kernel import kernel, unit
from varcontact.solvers.newton.normal import NormalConditions
from varcontact.solvers.newton.tangential import TangentialConditions, TangentialSystem
from varcontact.system.process import lazy_property

TOL = 1e-9
"""Residual of the transposed problem, relative to its right-hand side."""
ROOM = 32
"""Directions for which memory is allocated at a time."""
DIRECTIONS_MAX = 400
"""Directions of one transposed solve at most; 14 to 30 are usual."""

LEAST_ROW = 0.1
"""Least own part of a row whose bound falls with slip, in the preconditioner: beyond about 0 the
contact itself is unstable."""

Inverse = Callable[[np.ndarray], np.ndarray]
Edge = Literal["held", "moving"]


@dataclass(frozen=True, eq=False)
class Multipliers:
    """Multipliers of the linearised equations, in half-dimensionless form: `shift` (2, ny, nx) of
    E, `distance` (ny, nx) of e, `forces` (k,) and `load` of the prescribed sums.

    `by_tractions` (2, ny, nx): derivatives of what they weight by the tractions in contact.
    """

    shift: np.ndarray
    distance: np.ndarray
    forces: np.ndarray
    load: float
    by_tractions: np.ndarray | float = 0.0


@dataclass(frozen=True, eq=False)
class LinearisedContact:
    """A contact about its solution: held areas, and the transposed operators between them.

    `free` are the directions whose forces are prescribed; areas and edge are those of a part of the
    grid, the whole one if there is none.
    """

    fields: ContactFields
    areas: HeldAreas
    edge: MovingEdge
    free: tuple[int, ...]
    part: Part | None = None

    @classmethod
    def about(cls, solution: Solution, fields: ContactFields, edge: Edge) -> LinearisedContact:
        areas = HeldAreas.of(solution, fields)
        motion = solution.scene.motion
        free: tuple[int, ...] = ()
        if motion is not None and not solution.scene.frictionless:
            free = tuple(i for i, F in enumerate((motion.Fx, motion.Fy)) if F is not None)
        like = fields.disc.K == 0
        moving = MovingEdge(np.zeros_like(areas.along))
        if edge == "moving" and like and isinstance(motion, Steady) and areas.slip.any():
            areas, moving = with_moving_edge(solution, fields, areas)
        return cls(fields, areas, moving, free)

    @property
    def disc(self) -> Discretisation:
        return self.fields.disc

    @property
    def has_load(self) -> bool:
        """True where the normal force is prescribed: the approach is unknown."""
        return self.fields.scene.normal_force is not None

    @property
    def moves(self) -> bool:
        """True where tangential tractions are unknown."""
        return bool((self.areas.stick | self.areas.slip).any())

    @property
    def coupled(self) -> bool:
        """True where tractions change the pressure: both problems are solved together."""
        return self.disc.K != 0 and self.moves

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape (ny, nx) of its part of the grid."""
        return self.areas.contact.shape

    @lazy_property
    def _on_box(self) -> LinearisedContact:
        """Linearised contact on the box around the contact area, which has all unknowns; unchanged
        where influence numbers are periodic or depend on more than the offset.
        """
        operator = self.disc.operators.normal
        if not operator.toeplitz or any(operator.period):
            return self
        rows = np.flatnonzero(self.areas.contact.any(axis=1))
        columns = np.flatnonzero(self.areas.contact.any(axis=0))
        part = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
        return replace(self, areas=self.areas.on(part), edge=self.edge.on(part), part=part)

    # ------------------------------------------------------------------- transposed operators

    def _transposed(self, operator: GridOperator) -> GridOperator:
        """The transpose of an operator on the part of the grid, of whose offsets it has the
        first.
        """
        if self.part is None:
            return operator.transposed
        rows, columns = operator.shape
        ny, nx = self.shape
        table = operator.table[:, :, rows - ny : rows + ny - 1, columns - nx : columns + nx - 1]
        return GridOperator((ny, nx), table).transposed

    @lazy_property
    def _tangential(self) -> GridOperator:
        return self._transposed(self.disc.tangential_operator)

    @lazy_property
    def normal_operator(self) -> GridOperator:
        return self._transposed(self.disc.operators.normal)

    @lazy_property
    def _traction_to_distance(self) -> GridOperator:
        return self._transposed(self.disc.operators.traction_to_distance)

    @lazy_property
    def _pressure_to_shift(self) -> GridOperator:
        return self._transposed(self.disc.pressure_to_shift)

    @lazy_property
    def _edge_compliance(self) -> np.ndarray | None:
        compliance = self.disc.edge_compliance
        if compliance is None or self.part is None:
            return compliance
        return compliance[..., *self.part]

    def by_tractions(self, found: Multipliers) -> np.ndarray:
        """Derivatives by tractions (2, ny, nx) of what the multipliers weight: M' of the shift's,
        A_zt' of the distance's, and the forces'.
        """
        total = self._tangential.apply(found.shift)
        if self._edge_compliance is not None:
            total = total + self._edge_compliance * found.shift
        if self.disc.K != 0:
            total = total + self._traction_to_distance.apply(found.distance[None])
        for row, component in enumerate(self.free):
            total[component] += found.forces[row]
        return total

    def by_pressure(self, shift: np.ndarray, by_tractions: np.ndarray | float) -> np.ndarray:
        """Derivatives by pressures (ny, nx) of what multipliers of the shift weight: by tractions
        that grow with the pressure, by those that enter at a moving edge, and of unlike bodies.
        """
        total = (self.areas.growing * by_tractions).sum(axis=0)
        if self.edge.reaching:
            moved = self._tangential.apply(self.edge.passed(shift))
            total = total + (self.edge.entering * moved).sum(axis=0)
        if self.disc.K != 0:
            total = total + self._pressure_to_shift.apply(shift)[0]
        return self.areas.contact * total

    # ------------------------------------------------------------------- preconditioners

    @lazy_property
    def tangential_inverse(self) -> Inverse:
        """Newton's preconditioner with the mirrored kernel."""
        areas = self.areas
        own = unit(self._tangential)
        held = 1 / (1 + areas.turning / own)
        plain = kernel(self._tangential, self._tangential.shape)
        bound = (areas.stick | areas.slip).astype(float)
        conditions = TangentialConditions(plain, areas.along, _no_forces(), bound, plain)
        system = TangentialSystem(
            areas.along, conditions, areas.stick, areas.along, areas.across, held
        )

        def inverse(right: np.ndarray) -> np.ndarray:
            free = areas.within(right).astype(np.float32)
            found = areas.within(system.blended(free)) / own
            if areas.bound_follows_slip:
                found += areas.outward(right) / np.maximum(1 + own * areas.falling, LEAST_ROW)
            return found

        return inverse

    @lazy_property
    def normal_inverse(self) -> Inverse:
        """Newton's preconditioner for pressures, all elements in contact being treated as
        sticking.
        """
        contact = self.areas.contact
        own = unit(self.normal_operator)
        plain = kernel(self.normal_operator, self.normal_operator.shape)
        zero = np.zeros((1, *contact.shape))
        bound = contact.astype(float)
        conditions = NormalConditions(plain, zero, _no_forces(), bound, plain)
        one = np.ones(contact.shape)
        outside = zero + ~contact
        system = TangentialSystem(zero, conditions, contact, outside, zero, one)

        def inverse(right: np.ndarray) -> np.ndarray:
            found = system.blended((contact * right).astype(np.float32)[None])[0]
            return contact * found / own

        return inverse

    # ------------------------------------------------------------------- multipliers

    def tangential_multipliers(self, by_tractions: np.ndarray, by_rigid: np.ndarray) -> Multipliers:
        """Multipliers of the tangential problem alone, by derivatives of an output by tractions
        (2, ny, nx) and by unknown rigid shifts (k,).
        """
        inner = self._on_box
        system = _TransposedSystem(inner, tangential=True, normal=False)
        own = inner.of_part(by_tractions)
        return self._whole(system.solved(own, np.zeros(inner.shape), by_rigid, 0.0))

    def normal_multipliers(self, by_pressure: np.ndarray, by_approach: float) -> Multipliers:
        """Multipliers of the normal problem alone."""
        inner = self._on_box
        system = _TransposedSystem(inner, tangential=False, normal=True)
        zero = np.zeros((2, *inner.shape))
        unknown = np.zeros(len(self.free))
        return self._whole(system.solved(zero, inner.of_part(by_pressure), unknown, by_approach))

    def joint_multipliers(
        self,
        by_tractions: np.ndarray,
        by_pressure: np.ndarray,
        by_rigid: np.ndarray,
        by_approach: float,
    ) -> Multipliers:
        """Multipliers of both problems together, of unlike bodies."""
        inner = self._on_box
        system = _TransposedSystem(inner, tangential=True, normal=True)
        tractions = inner.of_part(by_tractions)
        pressure = inner.of_part(by_pressure)
        return self._whole(system.solved(tractions, pressure, by_rigid, by_approach))

    def of_part(self, field: np.ndarray) -> np.ndarray:
        """A field of the whole grid on this part."""
        if self.part is None:
            return field
        return field[..., *self.part]

    def _whole(self, found: Multipliers) -> Multipliers:
        """Multipliers of the box around the contact on the whole grid, zero beside it."""
        part = self._on_box.part
        if part is None:
            return found
        shift = np.zeros((2, *self.shape))
        by_tractions = np.zeros((2, *self.shape))
        distance = np.zeros(self.shape)
        shift[..., *part] = found.shift
        by_tractions[..., *part] = found.by_tractions
        distance[part] = found.distance
        return replace(found, shift=shift, distance=distance, by_tractions=by_tractions)


def _no_forces() -> Forces:
    return Forces((), np.array([]), 1.0)


class _TransposedSystem:
    """The transposed equations as one vector: shifts (2, ny, nx), distances (ny, nx), forces (k,)
    and the load; of shifts and distances those of the problems that are solved.

    Prescribed sums border the system, weighted so that their rows are as long as others; they are
    taken out of the preconditioner by their Schur complement.
    """

    def __init__(self, contact: LinearisedContact, *, tangential: bool, normal: bool) -> None:
        self._contact = contact
        self._tangential = tangential
        self._normal = normal
        self._load = normal and contact.has_load
        self._no_shift = np.zeros((2, *contact.shape))
        self._no_distance = np.zeros(contact.shape)
        areas = contact.areas
        self._weight = 1 / np.sqrt(max(int(np.count_nonzero(areas.contact)), 1))

        # places in the vector
        size = areas.contact.size
        self._shifts = slice(0, 2 * size * tangential)
        self._distances = slice(self._shifts.stop, self._shifts.stop + size * normal)
        self._forces = slice(self._distances.stop, self._distances.stop + len(contact.free))

        # borders: uniform rigid shifts, and the approach
        self._sums = np.zeros((len(contact.free), *self._no_shift.shape))
        for row, component in enumerate(contact.free):
            self._sums[row, component] = self._weight
        self._level = areas.contact * self._weight

        # their responses, for the Schur complements
        self._responses = np.zeros_like(self._sums)
        shifts = np.zeros_like(self._sums)
        if tangential:
            for row, uniform in enumerate(self._sums):
                self._responses[row] = contact.tangential_inverse(areas.rows(uniform))
                shifts[row] = areas.shifts(self._responses[row])
        self._schur = np.tensordot(self._sums, shifts, ([1, 2, 3], [1, 2, 3]))
        self._level_response = self._no_distance
        if self._load:
            self._level_response = contact.normal_inverse(self._level)
        self._level_schur = float((self._level * self._level_response).sum())

    def solved(
        self,
        by_tractions: np.ndarray,
        by_pressure: np.ndarray,
        by_rigid: np.ndarray,
        by_approach: float,
    ) -> Multipliers:
        """Multipliers by the derivatives of an output; `NotConverged` where GCR stalls."""
        areas = self._contact.areas
        right = Multipliers(
            areas.rows(by_tractions),
            areas.contact * by_pressure,
            by_rigid * self._weight * self._tangential,
            by_approach * self._weight * self._load,
        )
        found = self._split(gcr(self._product, self._precondition, self._joined(right)))
        multipliers = Multipliers(
            areas.shifts(found.shift),
            found.distance,
            found.forces * self._weight,
            found.load * self._weight,
        )
        if not self._tangential:
            return multipliers
        return replace(multipliers, by_tractions=self._contact.by_tractions(multipliers))

    def _joined(self, parts: Multipliers) -> np.ndarray:
        """The vector of the problems that are solved."""
        vector = np.empty(self._forces.stop + 1)
        if self._tangential:
            vector[self._shifts] = parts.shift.ravel()
        if self._normal:
            vector[self._distances] = parts.distance.ravel()
        vector[self._forces] = parts.forces
        vector[-1] = parts.load
        return vector

    def _split(self, vector: np.ndarray) -> Multipliers:
        """Multipliers of a vector; zero in the problem that is not solved."""
        shift = self._no_shift
        if self._tangential:
            shift = vector[self._shifts].reshape(shift.shape)
        distance = self._no_distance
        if self._normal:
            distance = vector[self._distances].reshape(distance.shape)
        return Multipliers(shift, distance, vector[self._forces], float(vector[-1]))

    def _product(self, vector: np.ndarray) -> np.ndarray:
        """Left-hand sides."""
        contact = self._contact
        areas = contact.areas
        given = self._split(vector)
        rows = self._no_shift
        of_pressure = self._no_distance
        sums = given.forces
        total = 0.0
        if self._tangential:
            rows, of_pressure = self._tangential_rows(given)
        if contact.free:
            sums = np.tensordot(self._sums, areas.shifts(given.shift), 3)
        if self._normal:
            distances = contact.normal_operator.apply(given.distance[None])[0]
            of_pressure = of_pressure + areas.contact * distances
        if self._load:
            of_pressure = of_pressure + given.load * self._level
            total = float((self._level * given.distance).sum())
        return self._joined(Multipliers(rows, of_pressure, sums, total))

    def _tangential_rows(self, given: Multipliers) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the tractions, and what those of the pressures have by multipliers of the
        shift.
        """
        contact = self._contact
        areas = contact.areas
        shift = areas.shifts(given.shift)
        weighted = Multipliers(shift, given.distance, given.forces * self._weight, 0.0)
        by_tractions = contact.by_tractions(weighted)
        rows = areas.rows(by_tractions) + areas.diagonal(given.shift)
        if not self._normal:
            return rows, self._no_distance
        return rows, contact.by_pressure(shift, by_tractions)

    def _precondition(self, vector: np.ndarray) -> np.ndarray:
        """Preconditioner: the tangential inverse, then the normal inverse of the remainder."""
        contact = self._contact
        right = self._split(vector)
        shift = self._no_shift
        distance = self._no_distance
        forces = right.forces
        load = 0.0
        left = right.distance
        if self._tangential:
            shift = contact.tangential_inverse(right.shift)
            if contact.free:
                lacking = np.tensordot(self._sums, contact.areas.shifts(shift), 3) - right.forces
                forces = np.linalg.solve(self._schur, lacking)
                shift = shift - np.tensordot(forces, self._responses, 1)
        if self._tangential and self._normal:
            partly = Multipliers(shift, distance, forces, 0.0)
            left = left - self._tangential_rows(partly)[1]
        if self._normal:
            distance = contact.normal_inverse(left)
        if self._load:
            load = (float((self._level * distance).sum()) - right.load) / self._level_schur
            distance = distance - load * self._level_response
        return self._joined(Multipliers(shift, distance, forces, load))


def gcr(product: Inverse, precondition: Inverse, right: np.ndarray, tol: float = TOL) -> np.ndarray:
    """Generalised conjugate residuals in double precision, preconditioned in single precision."""
    residual = right.copy()
    length = float(np.linalg.norm(right))
    steps = np.empty((ROOM, right.size))
    images = np.empty((ROOM, right.size))
    # images before they are orthogonalised are `factor` times the orthogonal ones
    factor = np.zeros((ROOM, ROOM))
    removed = np.zeros(ROOM)
    for count in range(DIRECTIONS_MAX):
        if float(np.linalg.norm(residual)) <= tol * length:
            shares = np.linalg.solve(factor[:count, :count], removed[:count])
            return shares @ steps[:count]
        if count == len(steps):
            steps = np.concatenate([steps, np.empty_like(steps)])
            images = np.concatenate([images, np.empty_like(images)])
            factor = np.pad(factor, (0, count))
            removed = np.pad(removed, (0, count))
        # a preconditioned direction, its image orthogonal to those before
        steps[count] = precondition(residual)
        image = product(steps[count])
        parts = images[:count] @ image
        image -= parts @ images[:count]
        size = float(np.linalg.norm(image))
        if not size > 0:
            break
        factor[:count, count] = parts
        factor[count, count] = size
        np.divide(image, size, out=images[count])
        # the part of the residual that it removes
        removed[count] = images[count] @ residual
        residual -= removed[count] * images[count]
    left = float(np.linalg.norm(residual)) / max(length, 1e-300)
    message = f"the gradient was not found in {DIRECTIONS_MAX} directions"
    raise NotConverged(message, left)
