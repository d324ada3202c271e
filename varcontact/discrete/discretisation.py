"""From a scene to dimensionless problems: discretisation and scaling.

Lengths are scaled by the size of the potential contact, tractions by a typical pressure, displacements by
``pressure * length / G``: the influence numbers then have G = 1 and everything a solver meets is of order one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from varcontact.discrete.operators import Operators
from varcontact.discrete.out_of_reach import check_shift
from varcontact.discrete.parts import means
from varcontact.discrete.problem import NormalProblem, TangentialProblem
from varcontact.discrete.softening import softening
from varcontact.elasticity.operators import GridOperator, RestrictedOperator
from varcontact.errors import SceneError
from varcontact.reference.hertz import HertzContact
from varcontact.reference.line_contact import line_contact
from varcontact.scene.bodies import Bodies
from varcontact.scene.friction import Law
from varcontact.scene.grid import Cells, Grid
from varcontact.scene.motion import Motion, Steady, Transient
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse, Surface

LEAST_STEP = 1e-6
"""Least step of steady rolling in elements: below, A - C has fewer than ten digits left."""

LARGEST_STEP = 1e9
"""Greatest step in elements: by then particles have long left the influence of the contact."""

FREE_DEPTH = 4.0
"""Depth of line contact in lengths of the potential contact where the scene gives none: then no answer shows it.

From one length on all influence numbers are positive, and A_zz is positive definite.
"""


@dataclass(frozen=True, eq=False)
class Carried:
    """What a step of a history finds, dimensionless.

    Attributes
    ----------
    displacement : ndarray, shape (2, ny, nx)
        The displacement differences u' that the particles bring along.
    force : ndarray, shape (2,)
        The tangential force of the step before.
    traction : ndarray, shape (2, ny, nx), or (3, ny, nx) where the bodies differ, optional
        The tractions of the step before, the pressure last; None in a corrected step, which carries a finer field.
    """

    displacement: np.ndarray
    force: np.ndarray
    traction: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Discretisation:
    """A contact on an explicit grid, with its scales and the operators it turns out to need.

    Attributes
    ----------
    bodies : Bodies
    surface : Surface
    grid : Grid
        Explicit, physical.
    hertz : HertzContact or None
    distance : ndarray, shape (ny, nx)
        Undeformed distance, physical.
    normal_force, approach : float or None
        One of the two, physical.
    motion : Steady, Shift, TimeStep or None
        How the bodies move; None: normal contact only.
    law : Law or None
        Of friction.
    coefficient : float or ndarray, shape (ny, nx), or None
        Coefficient of friction: under a law that taken at the moment, the static one where nothing is known of slip.
    length, pressure : float
        The scales; `displacement` follows.
    operators : Operators
        Influence numbers on the dimensionless grid.
    carried : Carried, optional
        In a step of a history: what the step before left.
    pressure_on_parts : ndarray, shape (ny rows, nx columns), optional
        The pressure on equal parts of the elements, dimensionless, where it was solved for there; the elements then
        bear the means. See `varcontact.discrete.on_parts`.
    parts : Discretisation, optional
        The same contact on those parts, for its normal problem.
    """

    bodies: Bodies
    surface: Surface
    grid: Grid
    hertz: HertzContact | None
    distance: np.ndarray
    normal_force: float | None
    approach: float | None
    motion: Motion | None
    law: Law | None
    coefficient: float | np.ndarray | None
    length: float
    pressure: float
    operators: Operators
    carried: Carried | None = None
    pressure_on_parts: np.ndarray | None = None
    parts: Discretisation | None = None

    @property
    def K(self) -> float:
        """The constant (60) by which the problems couple; 0: like bodies, or almost like ones that count as such."""
        return self.operators.K

    @property
    def line(self) -> bool:
        """Whether it is a line contact."""
        return self.grid.line

    @property
    def steady(self) -> bool:
        """Whether the bodies roll steadily."""
        return isinstance(self.motion, Steady)

    @property
    def frictionless(self) -> bool:
        """Whether no tangential traction can arise."""
        return self.motion is None or (self.law is None and not np.any(self.coefficient))

    @property
    def no_slip(self) -> bool:
        """Whether friction is infinite."""
        return isinstance(self.coefficient, float) and math.isinf(self.coefficient)

    @property
    def displacement(self) -> float:
        """Scale of displacements."""
        return self.pressure * self.length / self.bodies.combined_G

    @property
    def force(self) -> float:
        """Scale of forces; in line contact per unit length."""
        return self.pressure * (self.length if self.line else self.length**2)

    @property
    def afloat(self) -> bool:
        """Whether displacements are known but for a constant: in line contact without a reference depth."""
        return self.line and getattr(self.surface, "reference_depth", None) is None

    @property
    def hertz_approach(self) -> float:
        """Hertz's approach [length]; of a line contact from the depth that its influence numbers have."""
        assert self.hertz is not None
        if not self.line:
            return self.hertz.approach
        return line_contact(self.hertz.Rx, self.bodies, a=self.hertz.a).approach(self.operators.depth * self.length)

    @property
    def base(self) -> float:
        """Least undeformed distance on the grid: dimensionless distances and approaches count from there."""
        return float(self.distance.min())

    @property
    def lattice(self) -> Grid:
        """The dimensionless grid."""
        return self.operators.lattice

    @property
    def step(self) -> float | None:
        """Dimensionless distance rolled in a step, None where nothing rolls; a `SceneError` refuses too short ones."""
        motion = self.motion
        if motion is None or motion.rolls == 0:
            return None
        dx = self.grid.sides[0]
        dq = getattr(motion, "dq", None)
        if dq is not None and dq > LARGEST_STEP * dx:
            raise SceneError("motion.dq", dq, f"at most {LARGEST_STEP:g} times the element's dx, {dx:.6g}")
        if self.steady and dq is not None and dq < LEAST_STEP * dx:
            raise SceneError("motion.dq", dq, f"at least {LEAST_STEP:g} of the element's dx, {dx:.6g}")
        return (dx if dq is None else dq) / self.length

    @property
    def lag(self) -> float | None:
        """Dimensionless distance dq of C in the operators A - C of steady rolling, else None."""
        return self.step if self.steady else None

    @property
    def difference(self) -> str:
        """Which difference over a step of rolling the elastic slip is."""
        return self.motion.slip_difference if isinstance(self.motion, Steady) else "first-order"

    @cached_property
    def softening(self) -> np.ndarray | None:
        """What elements that the contact covers in part have on the diagonal beside M, (2, ny, nx), or None."""
        if self.grid.edge != "softened" or self.covered is None:
            return None
        (ny, nx), table = self.grid.shape, self.tangential_operator.table
        own = np.array([table[i, i, ny - 1, nx - 1] for i in (0, 1)])
        return own[:, None, None] * softening(self.covered)

    @cached_property
    def covered(self) -> np.ndarray | None:
        """Parts of the elements that the contact covers, (ny, nx), as far as that is known: between 0 and 1."""
        if self.pressure_on_parts is not None:
            return means((self.pressure_on_parts > 0).astype(float), self.cells)
        return None if self.hertz is None else self.hertz.covered(*self.grid.lines)

    @property
    def cells(self) -> Cells:
        """(rows, columns): the parts of an element on which the pressure was solved for; (1, 1) for elements alone."""
        rows, columns = self.grid.shape if self.pressure_on_parts is None else self.pressure_on_parts.shape
        return rows // self.grid.rows, columns // self.grid.nx

    @property
    def normal_operator(self) -> GridOperator:
        """A_zz."""
        return self.operators.normal

    @property
    def tangential_operator(self) -> GridOperator:
        """A_tt, or A_tt - C_tt in steady rolling."""
        return self.operators.tangential(self.lag, self.difference)

    @property
    def pressure_to_shift(self) -> GridOperator:
        """A_tz, or A_tz - C_tz in steady rolling; needed for K != 0."""
        return self.operators.pressure_to_shift(self.lag, self.difference)

    @property
    def traction_to_distance(self) -> GridOperator:
        """A_zt; needed for K != 0."""
        return self.operators.traction_to_distance

    def moved(self, motion: Motion) -> Discretisation:
        """The same bodies on the same grid with another `motion`, but the same step."""
        return replace(self, motion=motion)

    def at_step(self, scene: Scene, carried: Carried | None) -> Discretisation:
        """The same bodies in the `scene` of a step, on the same grid and in the same scales, with what is `carried`."""
        surface = scene.surface
        assert not isinstance(surface, Ellipse)
        distance = self.distance if surface is self.surface else surface.distance(self.grid)
        return replace(self, surface=surface, hertz=scene.hertz, distance=distance, carried=carried, **posed(scene))

    def rubbing(self, coefficient: np.ndarray) -> Discretisation:
        """The same with a `coefficient` of friction (ny, nx) for each element, as a law has it."""
        return replace(self, coefficient=coefficient)

    def extended(self, distance: np.ndarray) -> Discretisation:
        """The same with one more element on every side, and the `distance` (ny + 2, nx + 2) [length] there too."""
        return replace(self, grid=self.grid.extended(), distance=distance, operators=self.operators.around)

    def normal_problem(self, traction: np.ndarray | None = None) -> NormalProblem:
        """The normal problem; where the bodies differ, with their dimensionless `traction` (2, ny, nx)."""
        distance = ((self.distance - self.base) / self.displacement).ravel()
        if traction is not None:
            distance = distance + self.traction_to_distance.apply(traction).ravel()
        force, approach = self.normal_force, self.approach
        return NormalProblem(
            operator=self.normal_operator.on(np.arange(distance.size)),
            distance=distance,
            area=self.lattice.area,
            force=None if force is None else force / self.force,
            approach=None if approach is None else (approach - self.base) / self.displacement,
        )

    def tangential_problem(
        self,
        pressure: np.ndarray,
        bearing: np.ndarray | None = None,
        marching: bool = False,
        acting: np.ndarray | None = None,
        possible: np.ndarray | None = None,
    ) -> TangentialProblem:
        """The tangential problem on the elements with a traction bound, for a dimensionless `pressure` (ny, nx).

        The bound is friction times that pressure, or times that of `bearing` where it is given. The tractions `acting`
        (2, ny, nx), where given, are to be judged: the problem then has all directions in which they act. Elements with
        friction that are `possible` (ny, nx) enter with a bound of 0 without pressure. For `marching` it keeps A too.
        """
        motion = self.motion
        assert motion is not None
        pressed = (pressure if bearing is None else bearing).ravel()
        contact = pressed > 0
        with np.errstate(invalid="ignore"):  # inf * 0 outside the contact
            friction = np.broadcast_to(np.asarray(self.coefficient), pressure.shape).ravel()
            bound = friction * np.maximum(pressed, 0.0)
        bears = contact & (bound > 0)
        if possible is not None:
            bears |= possible.ravel() & (friction > 0)
        elements = np.flatnonzero(bears)
        shift = self.known_shift.reshape(2, -1)[:, elements]
        if self.K != 0:
            shift = shift + self.pressure_to_shift.apply(pressure[None]).reshape(2, -1)[:, elements]
        forces = [None if F is None else F / self.force for F in (motion.Fx, motion.Fy)]
        directions = self._directions(shift, forces, acting)
        operator = self.tangential_on(elements, directions)
        return TangentialProblem(
            operator=operator,
            rigid_shift=shift[list(directions)],
            bound=bound[elements],
            points=self.points.reshape(2, -1)[:, elements],
            area=self.lattice.area,
            force=tuple(forces[i] for i in directions),
            symmetric=not self.steady,
            instant=self.operators.tangential().between(directions, directions).on(elements, operator.softening)
            if marching
            else None,
            directions=directions,
        )

    def tangential_on(self, elements: np.ndarray, directions: tuple[int, ...] = (0, 1)) -> RestrictedOperator:
        """The operator between tractions and shifts of some elements, with their softening.

        Parameters
        ----------
        elements : int ndarray, shape (n,)
            Places of the elements on the grid, row by row.
        directions : tuple of int
        """
        soft = None if self.softening is None else self.softening.reshape(2, -1)[list(directions)][:, elements]
        return self.tangential_operator.between(directions, directions).on(elements, soft)

    def shift_by_tractions(self, traction: np.ndarray) -> np.ndarray:
        """M p, dimensionless, with the softening.

        Parameters
        ----------
        traction : ndarray, shape (2, ny, nx)
            Dimensionless.

        Returns
        -------
        ndarray, shape (2, ny, nx)
        """
        shift = self.tangential_operator.apply(traction)
        return shift if self.softening is None else shift + self.softening * traction

    def _directions(self, shift: np.ndarray, forces: list[float | None], acting: np.ndarray | None) -> tuple[int, ...]:
        """Directions in which tractions can arise: both, or, where elasticity couples them not, those that move."""
        if self.tangential_operator.table[0, 1].any():
            return (0, 1)
        moves = [shift[i].any() or forces[i] is not None or (acting is not None and acting[i].any()) for i in (0, 1)]
        return tuple(i for i in (0, 1) if moves[i]) or (0,)  # where nothing moves, one is enough to say so

    @cached_property
    def points(self) -> np.ndarray:
        """Dimensionless x and y of the element centres, (2, ny, nx)."""
        return np.array(np.meshgrid(self.lattice.x, self.lattice.y))

    @cached_property
    def rigid_shift(self) -> np.ndarray:
        """Rigid shift W of body 1 over body 2 in a step (75), (2, ny, nx), dimensionless."""
        assert self.motion is not None
        x, y = self.points
        with np.errstate(over="ignore"):
            shift = self.motion.step((self.step or 0.0) * self.length).shift(x, y, self.length) / self.displacement
        check_shift(self.motion, shift)
        return shift

    @cached_property
    def known_shift(self) -> np.ndarray:
        """What of the local shift the tractions do not change: W, or W - u' in a step of a history; (2, ny, nx)."""
        return self.rigid_shift if self.carried is None else self.rigid_shift - self.carried.displacement


def posed(scene: Scene) -> dict[str, Any]:
    """Load, motion and friction of a `scene`."""
    motion, friction = scene.motion, scene.friction
    law = friction if isinstance(friction, Law) else None
    return {
        "normal_force": scene.normal_force,
        "approach": scene.approach,
        "motion": None if isinstance(motion, Transient) else motion,
        "law": law,
        "coefficient": friction if law is None else law.static,
    }
