"""From a scene to dimensionless problems: discretisation and scaling.

Lengths are scaled by the size of the potential contact, tractions by a typical pressure, displacements by
``pressure * length / G``: the influence numbers then have G = 1 and everything a solver meets is of order one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from varcontact.elasticity.operators import GridOperator, RestrictedOperator, influence_operator, strip_operator
from varcontact.errors import NoContact, SceneError
from varcontact.grid import Grid
from varcontact.reference.hertz import HertzContact
from varcontact.reference.line_contact import line_contact
from varcontact.scene import Scene, Shift, Steady
from varcontact.surfaces import Ellipse, Paraboloids, SampledDistance

if TYPE_CHECKING:
    from varcontact.conic.setups import Setups

_SHARED = (
    "lattice",
    "normal_operator",
    "tangential_operator",
    "instant_operator",
    "pressure_to_shift",
    "traction_to_distance",
)

LEAST_STEP = 1e-6
"""Least step of steady rolling in elements: below, A - C has fewer than ten digits left."""

FREE_DEPTH = 4.0
"""Depth of line contact in lengths of the potential contact where the scene gives none: then no answer shows it.

From one length on all influence numbers are positive, and A_zz is positive definite.
"""


@dataclass(frozen=True, eq=False)
class NormalProblem:
    """Find ``p >= 0`` with ``e = h + A p - d >= 0`` and ``p e = 0``, on the potential contact.

    Attributes
    ----------
    operator : RestrictedOperator
        A, the influence numbers zz.
    distance : ndarray, shape (n,)
        h, the undeformed distance, with the displacement by tangential tractions where the bodies differ.
    area : float
        Of an element.
    force, approach : float or None
        Exactly one: prescribed ``area * sum(p)``, the approach d is then unknown; or prescribed d.
    """

    operator: RestrictedOperator
    distance: np.ndarray
    area: float
    force: float | None
    approach: float | None

    def reachable(self) -> NormalProblem:
        """The problem on the elements that can come into contact at all.

        Pressures only push surfaces apart (A > 0): there is no contact where h exceeds the approach. With the
        force prescribed, the approach is at most that with all of it on the lowest element.
        """
        highest = self.approach
        if highest is None:
            assert self.force is not None
            highest = self.distance.min() + self.operator.diagonal * self.force / self.area
        inside = self.distance < highest
        return replace(
            self,
            operator=self.operator.grid_operator.on(self.operator.elements[inside]),
            distance=self.distance[inside],
        )


@dataclass(frozen=True, eq=False)
class TangentialProblem:
    """Find ``|p_i| <= g_i`` with ``p_i = -g_i E_i/|E_i|`` where it slips, ``E = W + M p``, on the contact.

    Tractions have c components: two, or one where elasticity does not couple them and nothing moves along the other.

    Attributes
    ----------
    operator : RestrictedOperator
        M: the influence numbers A of a shift, or A - C of steady rolling (230)-(231).
    rigid_shift : ndarray, shape (c, n)
        W, with the shift by pressures where the bodies differ.
    bound : ndarray, shape (n,)
        g, the traction bound, positive; ``inf`` all over: no slip.
    points : ndarray, shape (2, n)
        x and y of the elements.
    area : float
        Of an element.
    force : tuple of c (float or None)
        Prescribed ``area * sum(p)`` by component; a uniform rigid shift along it is then unknown.
    symmetric : bool
        Whether M is symmetric (a shift, or one step of a march).
    instant : RestrictedOperator, optional
        A of steady rolling, for a march; then ``A - M`` is C.
    directions : tuple of c int
        Which direction (0: x, 1: y) each component has.
    """

    operator: RestrictedOperator
    rigid_shift: np.ndarray
    bound: np.ndarray
    points: np.ndarray
    area: float
    force: tuple[float | None, ...] = (None, None)
    symmetric: bool = False
    instant: RestrictedOperator | None = None
    directions: tuple[int, ...] = (0, 1)

    @property
    def size(self) -> int:
        """Number of elements."""
        return self.bound.size

    @property
    def components(self) -> int:
        """Number c of traction components."""
        return len(self.directions)

    @property
    def free(self) -> list[int]:
        """The components whose force is prescribed and whose rigid shift is unknown."""
        return [i for i, force in enumerate(self.force) if force is not None]

    @property
    def no_slip(self) -> bool:
        """Whether the traction bound is infinite."""
        return bool(np.isinf(self.bound).all())

    @property
    def monotone(self) -> bool:
        """Whether the symmetric part of M is positive definite: then the solution is the only one.

        It always is in a shift. In steady rolling it was in every mesh measured (docs/theory.md) with steps of 0.7
        elements or more; with shorter ones it may not be, the less so the larger nu, the longer the elements along
        x, and the more of them there are.
        """
        from scipy.linalg import LinAlgError, cholesky

        try:
            cholesky(self.operator.matrix + self.operator.matrix.T, overwrite_a=True, check_finite=False)
        except LinAlgError:
            return False
        return True

    def shift(self, traction: np.ndarray, free_shift: np.ndarray) -> np.ndarray:
        """Local shift E = W + M p, (c, n), by FFT; `free_shift` (c,) is the unknown part of W."""
        return self.operator.apply(traction) + self.rigid_shift + free_shift[:, None]

    def of_grid(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What of tractions (2, ny, nx) and rigid shifts (2,) is of this problem: (c, n) and (c,)."""
        chosen = list(self.directions)
        return traction.reshape(2, -1)[chosen][:, self.operator.elements], rigid[chosen]

    def on_grid(self, traction: np.ndarray, rigid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tractions (c, n) and rigid shifts (c,) as (2, ny, nx) and (2,), zero elsewhere and in other directions."""
        ny, nx = self.operator.grid_operator.shape
        field, shifts, chosen = np.zeros((2, ny * nx)), np.zeros(2), np.array(self.directions)
        field[np.ix_(chosen, self.operator.elements)], shifts[chosen] = traction, rigid
        return field.reshape(2, ny, nx), shifts


@dataclass(frozen=True)
class Settings:
    """What every solver is told.

    Attributes
    ----------
    tol : float
        Accuracy wanted of the tractions, relative; `varcontact.conic.accuracy` says what that means to each.
    formulation : str
        The program to be solved: "complementary", "potential" or "gap"; "auto" for the one that suits.
    setups : Setups, optional
        Where solvers keep their set-ups for the next problem of the same structure.
    """

    tol: float = 1e-8
    formulation: str = "auto"
    setups: Setups | None = None


@dataclass(frozen=True, eq=False)
class RawSolution:
    """What a solver returns: dimensionless, as it is, not yet judged.

    Attributes
    ----------
    traction : ndarray, shape (n,) or (c, n)
        Pressures, or tangential tractions.
    rigid : ndarray, shape (1,) or (c,)
        The approach, or the uniform rigid shift where the force is prescribed (0 where not).
    iterations : int
    status : str
        The solver's own word.
    solved : bool
        What that word means: whether the solver says that it reached all it was asked for.
    """

    traction: np.ndarray
    rigid: np.ndarray
    iterations: int
    status: str
    solved: bool = True


@dataclass(frozen=True, eq=False)
class Discretisation:
    """A scene on an explicit grid, with its scales and the operators it turns out to need.

    Attributes
    ----------
    scene : Scene
    grid : Grid
        Explicit, physical.
    hertz : HertzContact or None
    distance : ndarray, shape (ny, nx)
        Undeformed distance, physical.
    length, pressure : float
        The scales; `displacement` follows.
    """

    scene: Scene
    grid: Grid
    hertz: HertzContact | None
    distance: np.ndarray
    length: float
    pressure: float

    @property
    def displacement(self) -> float:
        """Scale of displacements."""
        return self.pressure * self.length / self.scene.bodies.combined_G

    @property
    def force(self) -> float:
        """Scale of forces; in line contact per unit length."""
        return self.pressure * (self.length if self.scene.line else self.length**2)

    @property
    def depth(self) -> float:
        """Dimensionless depth from which displacements count in line contact."""
        given = self.scene.reference_depth
        return FREE_DEPTH if given is None else given / self.length

    @property
    def hertz_approach(self) -> float:
        """Hertz's approach [length]; of a line contact from the depth that its influence numbers have."""
        assert self.hertz is not None
        if not self.scene.line:
            return self.hertz.approach
        return line_contact(self.hertz.Rx, self.scene.bodies, a=self.hertz.a).approach(self.depth * self.length)

    @property
    def base(self) -> float:
        """Least undeformed distance on the grid: dimensionless distances and approaches count from there."""
        return float(self.distance.min())

    @cached_property
    def lattice(self) -> Grid:
        """The dimensionless grid."""
        return self.grid.scaled(self.length)

    @property
    def step(self) -> float | None:
        """Dimensionless distance rolled in a step of steady rolling, else None."""
        motion = self.scene.motion
        if not isinstance(motion, Steady):
            return None
        dx = self.grid.sides[0]
        if motion.dq is not None and motion.dq < LEAST_STEP * dx:
            raise SceneError("motion.dq", motion.dq, f"at least {LEAST_STEP:g} of the element's dx, {dx:.6g}")
        return (motion.dq if motion.dq is not None else dx) / self.length

    @cached_property
    def normal_operator(self) -> GridOperator:
        """A_zz."""
        return self._operator("z", "z")

    @cached_property
    def tangential_operator(self) -> GridOperator:
        """A_tt, or A_tt - C_tt in steady rolling."""
        return self._operator("xy", "xy", self.step)

    @cached_property
    def instant_operator(self) -> GridOperator:
        """A_tt of steady rolling, which only a march needs by itself."""
        return self._operator("xy", "xy")

    @cached_property
    def pressure_to_shift(self) -> GridOperator:
        """A_tz, or A_tz - C_tz in steady rolling; needed for K != 0."""
        return self._operator("xy", "z", self.step)

    @cached_property
    def traction_to_distance(self) -> GridOperator:
        """A_zt; needed for K != 0."""
        return self._operator("z", "xy")

    def _operator(self, rows: str, columns: str, lag: float | None = None) -> GridOperator:
        bodies = self.scene.bodies
        if self.scene.line:
            return strip_operator(
                self.lattice, rows, columns, nu=bodies.combined_nu, K=bodies.K, depth=self.depth, lag=lag
            )
        return influence_operator(self.lattice, rows, columns, nu=bodies.combined_nu, K=bodies.K, lag=lag)

    def moved(self, motion: Steady | Shift) -> Discretisation:
        """The same bodies on the same grid with another motion, but the same step: operators are shared."""
        other = replace(self, scene=replace(self.scene, motion=motion))
        other.__dict__.update({name: value for name, value in self.__dict__.items() if name in _SHARED})
        return other

    def normal_problem(self, traction: np.ndarray | None = None) -> NormalProblem:
        """The normal problem, with tangential tractions (2, ny, nx) where the bodies differ."""
        distance = ((self.distance - self.base) / self.displacement).ravel()
        if traction is not None:
            distance = distance + self.traction_to_distance.apply(traction).ravel()
        force, approach = self.scene.normal_force, self.scene.approach
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
    ) -> TangentialProblem:
        """The tangential problem on the elements with a traction bound, for a pressure (ny, nx).

        The bound is friction times that pressure, or times that of `bearing` where it is given. The tractions
        `acting` (2, ny, nx), where given, are to be judged: the problem then has all directions in which they act.
        """
        scene, motion = self.scene, self.scene.motion
        assert motion is not None
        pressed = (pressure if bearing is None else bearing).ravel()
        contact = pressed > 0
        with np.errstate(invalid="ignore"):  # inf * 0 outside the contact
            bound = np.broadcast_to(np.asarray(scene.friction), pressure.shape).ravel() * pressed
        elements = np.flatnonzero(contact & (bound > 0))
        shift = self.rigid_shift().reshape(2, -1)[:, elements]
        if scene.bodies.K != 0:
            shift = shift + self.pressure_to_shift.apply(pressure[None]).reshape(2, -1)[:, elements]
        forces = [None if F is None else F / self.force for F in (motion.Fx, motion.Fy)]
        directions = self._directions(shift, forces, acting)
        return TangentialProblem(
            operator=self.tangential_operator.between(directions, directions).on(elements),
            rigid_shift=shift[list(directions)],
            bound=bound[elements],
            points=self.points.reshape(2, -1)[:, elements],
            area=self.lattice.area,
            force=tuple(forces[i] for i in directions),
            symmetric=not isinstance(motion, Steady),
            instant=self.instant_operator.between(directions, directions).on(elements) if marching else None,
            directions=directions,
        )

    def _directions(self, shift: np.ndarray, forces: list[float | None], acting: np.ndarray | None) -> tuple[int, ...]:
        """Directions in which tractions can arise: both, or, where elasticity couples them not, those that move."""
        if self.tangential_operator.table[0, 1].any():
            return (0, 1)
        moves = [shift[i].any() or forces[i] is not None or (acting is not None and acting[i].any()) for i in (0, 1)]
        return tuple(i for i in (0, 1) if moves[i]) or (0,)  # where nothing moves, one is enough to say so

    @property
    def points(self) -> np.ndarray:
        """Dimensionless x and y of the element centres, (2, ny, nx)."""
        return np.array(np.meshgrid(self.lattice.x, self.lattice.y))

    def rigid_shift(self) -> np.ndarray:
        """Rigid shift W of body 1 over body 2 in a step (75), (2, ny, nx), dimensionless."""
        motion = self.scene.motion
        assert motion is not None
        x, y = self.points
        along_x, along_y, about_z = motion.rigid
        if isinstance(motion, Steady):
            assert self.step is not None
            x = x + motion.spin_offset * self.step
            scale = self.step * self.length / self.displacement
            return np.array([along_x - about_z * self.length * y, along_y + about_z * self.length * x]) * scale
        turn = about_z * self.length
        return np.array([along_x - turn * y, along_y + turn * x]) / self.displacement


def out_of_reach(scene: Scene, grid: Grid) -> SceneError:
    """Why no element of a grid is in contact: the bodies are apart, the contact is elsewhere, or falls between."""
    left, right, bottom, top = grid.box
    x = y = 0.0
    surface = scene.surface
    if isinstance(surface, SampledDistance):
        iy, ix = np.unravel_index(np.argmin(surface.samples), surface.samples.shape)
        least = float(surface.samples[iy, ix])
        if scene.approach is not None and scene.approach <= least:
            return NoContact("approach", scene.approach, f"above the least undeformed distance, {least:.6g}")
        if surface.placed:
            x, y = (float(points[i]) for points, i in zip(surface.coordinates, (ix, iy), strict=True))
        else:
            x, y = left, bottom
    if not (left <= x <= right and bottom <= y <= top):
        return SceneError(
            "grid", grid.box, f"a potential contact that contains the contact, which is at ({x:.6g}, {y:.6g})"
        )
    return SceneError("grid", grid, "fine enough to hold one contact element (no element's centre is in contact)")


def discretise(scene: Scene, grid: Grid) -> Discretisation:
    """A scene on an explicit grid.

    Raises
    ------
    SceneError
        If the grid cannot hold the contact: elements larger than it, or a distance beyond the approach all over;
        or a reference depth within the potential contact.
    """
    hertz, (dx, dy) = scene.hertz, grid.sides
    along_x, depth = grid.nx * dx, scene.reference_depth
    if depth is not None and depth < along_x:
        raise SceneError(
            "surface.reference_depth", depth, f"no less than the length of the potential contact, {along_x:.6g}"
        )
    if hertz is not None and (dx > 2.000001 * hertz.a or dy > 2.000001 * hertz.b):
        size = f"{2 * hertz.a:.6g}" + ("" if scene.line else f" by {2 * hertz.b:.6g}")
        raise SceneError(
            "grid", dx if scene.line else (dx, dy), f"fine enough to hold one contact element: the contact is {size}"
        )
    surface = scene.surface
    if isinstance(surface, Ellipse):
        assert hertz is not None
        surface = Paraboloids(hertz.Rx, hertz.Ry)
    distance = surface.distance(grid)
    length = along_x if scene.line else math.sqrt(along_x * grid.rows * dy)
    if hertz is not None:
        pressure = hertz.peak_pressure
    elif scene.normal_force is not None:
        pressure = scene.normal_force / (length if scene.line else length**2)
    else:
        assert scene.approach is not None
        overlap = scene.approach - float(distance.min())
        if overlap <= 0:
            raise out_of_reach(scene, grid)
        pressure = scene.bodies.combined_G * overlap / length
    return Discretisation(scene, grid, hertz, distance, length, pressure)
