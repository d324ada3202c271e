"""Discretisation: dimensionless problems from a scene and an explicit grid.

Lengths are scaled by the size of the potential contact, tractions by a typical
pressure, displacements by ``pressure * length / G``: the influence numbers then
have G = 1 and everything a solver meets is of order one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from varcontact.discrete.contact_grid import (
    check_depth,
    check_element_size,
    check_range,
    scales_of,
)
from varcontact.discrete.edge_compliance import edge_compliance
from varcontact.discrete.loading import Loading
from varcontact.discrete.operators import Operators
from varcontact.discrete.problems import NormalProblem, TangentialProblem
from varcontact.elasticity.beside import loads_beside
from varcontact.elasticity.held import HeldMedium, held_parts
from varcontact.elasticity.of_scenes import medium_on
from varcontact.elasticity.operators import GridOperator
from varcontact.errors import SceneError
from varcontact.interfaces.interface import BetweenBodies, Fields, Interface, Quantity, Surroundings
from varcontact.interfaces.kinds import interface_of
from varcontact.interfaces.potential import Potential
from varcontact.reference.hertz import HertzContact
from varcontact.scene.bodies import Bodies, BodyPair
from varcontact.scene.given_bodies import GivenBodies
from varcontact.scene.grid import Cells, Grid
from varcontact.scene.motion import Motion, Shift, Steady, TimeStep
from varcontact.scene.pin import PinInHole
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import (
    Ellipse,
    Paraboloids,
    SampledDistance,
    Surface,
    frames_of,
    is_curved,
    is_curved_along_x,
)
from varcontact.scene.transient import Transient
from varcontact.scene.units import Scales
from varcontact.system.process import changed, lazy_property
from varcontact.transports import SteadyRolling, Step, Transport

STEP_MIN = 1e-6
"""Least step of steady rolling [elements]: below it, A - C has fewer than ten correct digits."""

STEP_MAX = 1e9
"""Greatest step [elements]: particles have then long left the influence of the contact."""


SHIFT_MAX = 1e100
"""Greatest dimensionless rigid shift: squares of its products stay in the floating-point range."""


@dataclass(frozen=True, eq=False)
class Subgrid:
    """Contact on elements divided into equal parts, and the pressure that was solved on these.

    The elements carry the means of their parts' pressures (ny rows, nx columns), which are
    dimensionless.
    """

    disc: Discretisation
    pressure: np.ndarray


@dataclass(frozen=True, eq=False)
class Discretisation:
    """A contact on an explicit grid, with its scales and the operators it turns out to need.

    The grid and the undeformed distance (ny, nx) are physical, the lattice of the operators is
    dimensionless.
    """

    bodies: Bodies | BodyPair | GivenBodies
    surface: Surface
    grid: Grid
    hertz: HertzContact | None
    distance: np.ndarray
    scales: Scales
    loading: Loading
    operators: Operators
    subgrid: Subgrid | None = None

    @property
    def K(self) -> float:
        """The constant (60) by which the problems couple; 0: like bodies."""
        return self.operators.medium.K

    @property
    def conformal(self) -> bool:
        return is_curved(self.surface)

    @property
    def mirrors(self) -> bool:
        """True where influence numbers are even or odd in x: elastic bodies on a surface that is
        straight along x.
        """
        return self.operators.medium.even and not is_curved_along_x(self.surface)

    @property
    def lattice(self) -> Grid:
        return self.operators.lattice

    @lazy_property
    def base(self) -> float:
        """Least undeformed distance on the grid: dimensionless distances and approaches count from
        there.
        """
        if isinstance(self.surface, PinInHole):
            return 0.0
        return float(self.distance.min())

    @lazy_property
    def step(self) -> float | None:
        """Dimensionless distance rolled in a step, None where nothing rolls; a `SceneError` refuses
        too short ones.
        """
        motion = self.loading.motion
        if motion is None or isinstance(motion, Shift) or motion.rolls == 0:
            return None
        dx = self.grid.sides[0]
        dq = motion.dq
        if dq is None:
            return dx / self.scales.length
        if dq > STEP_MAX * dx:
            raise SceneError(
                "motion.dq", dq, f"at most {STEP_MAX:g} times the element's dx, {dx:.6g}"
            )
        if isinstance(motion, Steady) and dq < STEP_MIN * dx:
            raise SceneError(
                "motion.dq", dq, f"at least {STEP_MIN:g} of the element's dx, {dx:.6g}"
            )
        return dq / self.scales.length

    @lazy_property
    def transport(self) -> Transport:
        """The motion on the lattice; without one, a step in place."""
        motion = self.loading.motion
        distance = 0.0
        if motion is not None and self.step is not None:
            distance = motion.rolls * self.step
        dx = self.lattice.sides[0]
        if isinstance(motion, Steady):
            return SteadyRolling(distance, dx, motion.slip_difference)
        return Step(distance, dx)

    @property
    def tangential_operator(self) -> GridOperator:
        """A_tt, or A_tt - C_tt in steady rolling."""
        return self.operators.tangential(self.transport.stencil)

    @property
    def pressure_to_shift(self) -> GridOperator:
        """A_tz, or A_tz - C_tz in steady rolling; needed for K != 0."""
        return self.operators.pressure_to_shift(self.transport.stencil)

    @property
    def cells(self) -> Cells:
        """(rows, columns): the parts of an element on which the pressure was solved for; (1, 1) for
        elements alone.
        """
        if self.subgrid is None:
            return 1, 1
        rows, columns = self.subgrid.pressure.shape
        return rows // self.grid.rows, columns // self.grid.nx

    @lazy_property
    def edge_compliance(self) -> np.ndarray | None:
        """Addition to the diagonal of M for elements that the contact covers in part, (2, ny, nx),
        or None.
        """
        if self.grid.edge != "softened":
            return None
        ny, nx = self.grid.shape
        if self.subgrid is not None:
            rows, columns = self.cells
            covered = (self.subgrid.pressure > 0).reshape(ny, rows, nx, columns).mean(axis=(1, 3))
        elif self.hertz is not None:
            covered = self.hertz.covered(*self.grid.lines)
        else:
            return None
        table = self.tangential_operator.table
        own = np.array([table[i, i, ny - 1, nx - 1] for i in (0, 1)])
        return own[:, None, None] * edge_compliance(covered)

    @property
    def points(self) -> np.ndarray:
        """Dimensionless x and y of the element centres, (2, ny, nx)."""
        return self.operators.points

    @property
    def surroundings(self) -> Surroundings:
        """Surroundings of the interfaces: transport, fields carried by particles, implicit fields
        of this pass.
        """
        # created on each call: if kept, it would refer back to this object and keep its matrices
        loading = self.loading
        return Surroundings(self.transport, loading.arrived, loading.implicit, self.passed)

    @lazy_property
    def interface(self) -> Interface:
        """Interface between the bodies, made from the present friction and motion."""
        given = self.loading
        between = BetweenBodies(given.scene, given.friction, given.motion, self.grid, self.scales)
        return interface_of(between)

    @property
    def frictionless(self) -> bool:
        """True where no tangential traction can arise."""
        return self.loading.motion is None or self.interface.frictionless

    @property
    def coefficient(self) -> float | np.ndarray | None:
        """Ratio of the traction bound to the pressure in this pass; None if the interface has
        none.
        """
        return self.interface.coefficient(self.surroundings)

    @property
    def implicit(self) -> tuple[Quantity, ...]:
        """The fields of the interfaces that the contact itself determines; none: its problem is
        convex.
        """
        if self.frictionless:
            return ()
        return self.interface.implicit(self.transport)

    def sought(self, *, by_slip: bool) -> tuple[Quantity, ...]:
        """Implicit fields to be solved for: those that follow from slip, or from tractions
        alone.
        """
        those = self.interface.those(by_slip=by_slip)
        if those is None or self.frictionless:
            return ()
        return those.implicit(self.transport)

    def passed(self) -> tuple[int, float]:
        """Elements that particles pass in a step, and the weight of the next one at the point that
        they come from.

        A displacement at a point between two centres is the sum of those at the centres, with
        weights that are exact for tractions on these two elements.
        """
        if self.step is None:
            return 0, 0.0
        dx = self.lattice.sides[0]
        whole, rest = divmod(round(self.step / dx, 9), 1.0)
        if rest == 0:
            return int(whole), 0.0
        rows: int | None = 1
        if self.grid.line:
            rows = None
        two_elements = replace(self.lattice, nx=2, ny=rows)
        pair = Operators(two_elements, self.operators.medium)
        at_centres = pair.tangential()
        between = pair.carrying(rest * dx)
        _, own, other = np.mean([at_centres.table[i, i, 0] for i in (0, 1)], axis=0)
        beyond, near, _ = np.mean([between.table[i, i, 0] for i in (0, 1)], axis=0)
        return int(whole), float((beyond * own - near * other) / ((near + beyond) * (own - other)))

    def potential(self, pressure: np.ndarray) -> Potential:
        """The potential of the tractions on the grid, under a dimensionless pressure (ny, nx)."""
        return self.interface.potential(pressure, self.surroundings)

    def under(self, fields: Fields) -> Discretisation:
        """Copy with these implicit fields added to the loading."""
        return self.with_loading(implicit={**self.loading.implicit, **fields})

    @lazy_property
    def rigid_shift(self) -> np.ndarray:
        """Rigid shift W of body 1 over body 2 in a step (75), (2, ny, nx), dimensionless."""
        motion = self.loading.motion
        scales = self.scales
        x, y = self.points
        assert motion is not None
        with np.errstate(over="ignore", invalid="ignore"):
            shift = motion.step((self.step or 0.0) * scales.length).shift(x, y, scales.length)
            shift = (shift + self.slip_of_elements) / scales.displacement
        if not np.abs(shift).max() <= SHIFT_MAX:  # also for NaN
            raise _shift_too_large(motion)
        return shift

    @property
    def slip_of_elements(self) -> np.ndarray | float:
        """Shift in a step that is known element by element, beside creepages, (2, ny, nx)
        [length].
        """
        motion = self.loading.motion
        shift = self._shift_by_loads
        if not isinstance(motion, Steady) or motion.rigid_slip is None:
            return shift
        return shift + (self.step or 0.0) * self.scales.length * motion.rigid_slip

    @property
    def _shift_by_loads(self) -> np.ndarray | float:
        """Shift in a step by loads beside the contact: their displacement difference less that
        which particles bring along [length].
        """
        shift: np.ndarray | float = 0.0
        beside = self.loading.beside
        if beside is not None:
            shift = beside.shift(self.grid, self.transport.stencil)
        before = self.loading.beside_before
        if before is not None:
            shift = shift - before.shift(self.grid, ((self.transport.distance, 1.0),))
        return shift

    @lazy_property
    def known_shift(self) -> np.ndarray:
        """Part of the local shift that the tractions do not change: W, or W - u' in a step of a
        history; (2, ny, nx).
        """
        previous = self.loading.previous_step
        if previous is None:
            return self.rigid_shift
        return self.rigid_shift - previous.displacement

    @property
    def known_distance(self) -> np.ndarray | float:
        """Distance added by past tractions, dimensionless (ny, nx): of viscoelastic bodies."""
        previous = self.loading.previous_step
        if previous is None or previous.distance is None:
            return 0.0
        # without the elements around the grid
        if self.grid.line:
            return previous.distance[:, 1:-1]
        return previous.distance[1:-1, 1:-1]

    def undeformed_distance(self, grid: Grid, beyond: float = 0.0) -> np.ndarray:
        """Undeformed distance (ny, nx) with that of loads beside the contact, at the element
        centres of another grid [length].
        """
        distance = undeformed_distance(self.surface, self.hertz, grid, beyond)
        return self.with_loads_beside(distance, grid)

    def with_loads_beside(self, distance: np.ndarray, grid: Grid) -> np.ndarray:
        """A distance (ny, nx) on a grid with that of loads beside the contact [length]."""
        beside = self.loading.beside
        if beside is None:
            return distance
        return distance + beside.distance(grid)

    def without_matrices(self) -> Discretisation:
        """Copy without the matrices that solvers assembled, to be kept after a solve."""
        subgrid = self.subgrid
        if subgrid is not None:
            subgrid = changed(subgrid, disc=subgrid.disc.without_matrices())
        return changed(self, operators=self.operators.without_matrices(), subgrid=subgrid)

    def with_loading(self, **changes: Any) -> Discretisation:
        """Copy with changes of the loading, as `motion` or `friction`; bodies and grid stay."""
        return changed(self, loading=changed(self.loading, **changes))

    def with_motion(self, motion: Motion | None) -> Discretisation:
        """Copy under another motion; a rigid slip given at samples is evaluated in the elements."""
        if isinstance(motion, Steady) and motion.rigid_slip is not None:
            assert isinstance(self.surface, SampledDistance)
            slip = self.surface.sampled(motion.rigid_slip, self.grid)
            motion = replace(motion, rigid_slip=slip)
        if motion is self.loading.motion:
            return self
        return self.with_loading(motion=motion)

    def at_approach(self, approach: float) -> Discretisation:
        """Copy with the approach prescribed [dimensionless]."""
        return self.held_at(approach * self.scales.displacement + self.base)

    def held_at(self, approach: float) -> Discretisation:
        """Copy with the approach prescribed [length]; a pin is lowered along z by it."""
        held = self.with_loading(normal_force=None, approach=approach)
        if not isinstance(self.surface, PinInHole):
            return held
        lowered = self.surface.lowered(approach)
        return replace(held, surface=lowered, distance=lowered.distance(self.grid))

    @lazy_property
    def in_normal_force(self) -> np.ndarray | None:
        """Factors of tractions along x and y, and of pressures, in the force along the normal of
        the plane, (3, ny, nx); None where pressures alone give it.
        """
        frames = frames_of(self.surface, self.grid)
        if frames is None:
            return None
        return frames[2]

    def excess_force(self, traction: np.ndarray, pressure: np.ndarray) -> float:
        """Force along the normal of the plane in conformal contact, divided by the prescribed one,
        less 1.
        """
        assert self.loading.normal_force is not None
        assert self.in_normal_force is not None
        force = float(np.sum(self.in_normal_force * [*traction, pressure])) * self.lattice.area
        return force * self.scales.force / self.loading.normal_force - 1

    def at_step(self, scene: Scene) -> Discretisation:
        """Copy for the scene of a time step, with the same bodies, grid and scales."""
        surface = scene.surface
        assert not isinstance(surface, Ellipse)
        beside = self.loading.beside
        if scene.loaded and not scene.loads_as(self.loading.scene):
            beside = loads_beside(scene, self.scales.length)
        hertz = self.hertz
        if not scene.same_normal_contact(self.loading.scene):
            hertz = scene.hertz
        operators = self.operators
        if isinstance(scene.motion, TimeStep):
            operators = operators.at_end(scene.motion.dt)
        loading = changed(_loading_of(scene), beside=beside)
        at_step = changed(self, loading=loading, operators=operators, surface=surface, hertz=hertz)
        if surface is self.surface and beside is self.loading.beside:
            return at_step
        return replace(at_step, distance=at_step.undeformed_distance(self.grid))

    def normal_problem(self, traction: np.ndarray | None = None) -> NormalProblem:
        """The normal problem; where the bodies differ, with their dimensionless traction (2, ny,
        nx).
        """
        displacement = self.scales.displacement
        distance = ((self.distance - self.base) / displacement + self.known_distance).ravel()
        if traction is not None:
            distance = distance + self.operators.traction_to_distance.apply(traction).ravel()
        force = self.loading.normal_force
        if force is not None:
            force = force / self.scales.force
        approach = self.loading.approach
        if approach is not None:
            approach = (approach - self.base) / displacement
        return NormalProblem(
            operator=self.operators.normal.on(np.arange(distance.size)),
            distance=distance,
            area=self.lattice.area,
            force=force,
            approach=approach,
            symmetric=self.operators.medium.reciprocal,
        )

    def tangential_problem(
        self,
        pressure: np.ndarray,
        bound_pressure: np.ndarray | None = None,
        marching: bool = False,
        acting: np.ndarray | None = None,
        possible: np.ndarray | None = None,
    ) -> TangentialProblem:
        """The tangential problem on the elements with a traction bound, for a dimensionless
        pressure (ny, nx).

        The bound is friction times that pressure, or times `bound_pressure`. The tractions `acting`
        (2, ny, nx), where given, are to be judged: the problem then has all directions in which
        they act. Elements with friction that are `possible` (ny, nx) enter with a bound of 0
        without pressure. For `marching` it keeps A too.
        """
        # elements with a traction bound
        if bound_pressure is None:
            bound_pressure = pressure
        potential = self.potential(bound_pressure)
        has_bound = (bound_pressure > 0) & (potential.bound > 0)
        if possible is not None:
            has_bound |= possible & (self.potential(np.ones(pressure.shape)).bound > 0)
        elements = has_bound.ravel().nonzero()[0]
        # shift that the tractions do not change
        shift = self.known_shift.reshape(2, -1).take(elements, axis=1)
        if self.K != 0:
            by_pressure = self.pressure_to_shift.apply(pressure[None]).reshape(2, -1)
            shift = shift + by_pressure.take(elements, axis=1)
        # directions in which anything moves, and the operators between them
        forces = self.tangential_forces
        directions = self._directions(shift, forces, acting)
        softening = None
        if self.edge_compliance is not None:
            softening = self.edge_compliance.reshape(2, -1)[list(directions)][:, elements]
        table = self.tangential_operator.between(directions, directions)
        instant = None
        if marching:
            at_once = self.operators.tangential().between(directions, directions)
            instant = at_once.on(elements, softening)
        return TangentialProblem(
            operator=table.on(elements, softening),
            rigid_shift=shift[list(directions)],
            potential=potential.on(elements),
            points=self.points.reshape(2, -1).take(elements, axis=1),
            area=self.lattice.area,
            force=tuple(forces[i] for i in directions),
            symmetric=not self.transport.repeats,
            instant=instant,
            directions=directions,
        )

    @property
    def tangential_forces(self) -> list[float | None]:
        """Prescribed Fx and Fy, dimensionless; None for a force that is not prescribed."""
        motion = self.loading.motion
        assert motion is not None
        return [None if F is None else F / self.scales.force for F in (motion.Fx, motion.Fy)]

    def _directions(
        self, shift: np.ndarray, forces: list[float | None], acting: np.ndarray | None
    ) -> tuple[int, ...]:
        """Directions of a tangential problem: both where elasticity couples them, else those in
        which anything moves.
        """
        if self.tangential_operator.couples(0, 1):
            return 0, 1
        moving = [
            i
            for i in (0, 1)
            if forces[i] is not None or shift[i].any() or (acting is not None and acting[i].any())
        ]
        # where nothing moves, one direction is enough
        return tuple(moving) or (0,)


def _shift_too_large(motion: Motion) -> SceneError:
    """The error for a rigid shift beyond `SHIFT_MAX`: names its largest entry."""
    names = ("vx", "vy", "spin", "ux", "uy", "rotation")
    entries = {name: getattr(motion, name) for name in names if getattr(motion, name, 0.0)}
    largest = max(entries, key=lambda name: abs(entries[name]), default="dq")
    allowed = (
        f"smaller: the shift in a step may be {SHIFT_MAX:g} times the elastic displacements at most"
    )
    return SceneError(
        f"motion.{largest}", entries.get(largest, getattr(motion, "dq", None)), allowed
    )


def discretise(scene: Scene, grid: Grid, built: Operators | None = None) -> Discretisation:
    """A scene of one problem on an explicit grid, with operators that are `built` already where
    they are those of its lattice.

    A `SceneError` is raised if the grid cannot hold the contact (elements larger than it, or a
    distance beyond the approach all over), or for a reference depth within the potential contact.
    """
    hertz = scene.hertz
    check_depth(scene, grid)
    check_element_size(scene, grid)
    distance = undeformed_distance(scene.surface, hertz, grid)
    scales = scales_of(scene, grid, distance)
    check_range(scales)
    depth = scene.reference_depth
    if depth is not None:
        depth = depth / scales.length
    medium = medium_on(scene, grid, scales.length, depth, scene.speed)
    if scene.displacements:
        medium = HeldMedium(medium, held_parts(scene, scales.length))
    operators = Operators(grid.scaled(scales.length), medium)
    if built == operators:
        operators = built
    loading = _loading_of(scene)
    disc = Discretisation(
        scene.bodies,
        scene.surface,
        grid,
        hertz,
        distance,
        scales,
        loading,
        operators,
    )
    if scene.loaded:
        disc = disc.with_loading(beside=loads_beside(scene, scales.length))
        disc = replace(disc, distance=disc.with_loads_beside(distance, grid))
    return disc.with_motion(loading.motion)


def _loading_of(scene: Scene) -> Loading:
    """The loading of a scene; of a history without its motion."""
    motion = None
    if not isinstance(scene.motion, Transient):
        motion = scene.motion
    return Loading(scene, scene.friction, scene.normal_force, scene.approach, motion)


def undeformed_distance(
    surface: Surface, hertz: HertzContact | None, grid: Grid, beyond: float = 0.0
) -> np.ndarray:
    """Undeformed distance at the element centres; that of an ellipse has its Hertzian radii.

    Samples are extrapolated as far as `beyond` [length], as by `SampledDistance.distance`.
    """
    if isinstance(surface, SampledDistance):
        return surface.distance(grid, beyond)
    if isinstance(surface, Ellipse):
        assert hertz is not None  # of half-spaces
        return Paraboloids(hertz.Rx, hertz.Ry).distance(grid)
    return surface.distance(grid)
