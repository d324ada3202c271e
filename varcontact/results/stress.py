"""Displacements and stresses below the surface of a solution's bodies (paper, section 6.3.2)."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol, cast

import numpy as np

from varcontact import checks
from varcontact.discrete.contact_grid import on_parts
from varcontact.elasticity.layered import Stack
from varcontact.elasticity.layered_field import (
    layered_element_stresses,
    layered_field_at,
    layered_field_below,
)
from varcontact.elasticity.subsurface import ElasticField, element_stresses, field_at, field_below
from varcontact.errors import SceneError
from varcontact.io.labelled import Labelled
from varcontact.io.stress import VTK_FORMATS, stress_dataset
from varcontact.results.solution import Solution
from varcontact.scene.bodies import Bodies, Layered
from varcontact.scene.given_bodies import GivenBodies
from varcontact.scene.grid import Grid
from varcontact.scene.pin import PinInHole
from varcontact.scene.units import IN_WORDS, Units
from varcontact.system.process import SMALLER, need

if TYPE_CHECKING:
    import xarray as xr

Body = Literal["upper", "lower", "rail", "wheel"] | int
STRIPS = 16
"""Strips of constant traction in an element of linear tractions, for stresses below."""
NAMES = ("upper", "lower")
"""Names of the bodies of a scene, the first with z >= 0; patches of wheels name theirs."""

ONE = "; of a History, one of its steps"

CENTRE_TOL = 1e-9
"""Distance of a point from an element centre, divided by the sides, up to which it counts as below
it."""

FARTHEST = 1e60
"""Largest coordinate of a point: the potentials contain fifth powers of distances."""

BYTES_PER_ELEMENT = 2200.0
"""Memory of `stress_below` for one layer in progress, per element [bytes], measured on 4096 to 262
144 elements."""
BYTES_PER_ELEMENT_AND_DEPTH = 450.0
"""Memory of its results per element and depth [bytes], measured likewise."""


class Patch(Protocol):
    """Protocol of objects with a solution and names for its bodies: a patch of a wheel on a
    rail.
    """

    @property
    def solution(self) -> Solution: ...

    @property
    def body_names(self) -> tuple[str, str]: ...


@dataclass(frozen=True, eq=False)
class SubsurfaceStress(Labelled):
    """The elastic field at points of one body, in the scene's units and axes (z up into body 1).

    Attributes
    ----------
    body : int
        1, the upper, or 2, the lower.
    points : ndarray, shape (3, ...)
        x, y, z [length]; the trailing shape is that of all fields.
    displacement : ndarray, shape (3, ...)
        Displacement of the particles [length]; zero in a rigid body, NaN in line contact
        without a reference depth or with layers, and on a smooth base.
    gradient : ndarray, shape (3, 3, ...)
        ``du_i/dx_j`` at ``[i, j]`` [-].
    stress : ndarray, shape (3, 3, ...)
        Tension positive [force/area].
    units : Units
        Units of the scene.
    """

    more_formats = VTK_FORMATS
    body: int
    points: np.ndarray
    displacement: np.ndarray
    gradient: np.ndarray
    stress: np.ndarray
    units: Units = IN_WORDS

    __repr__ = checks.short_entries

    def to_xarray(self) -> xr.Dataset:
        """Displacements, stresses and equivalent stresses, by component, with units.

        Over z, y and x, if the points are a grid, as those of `stress_below`; else over "point",
        in the order of the points.
        """
        return stress_dataset(self)

    @checks.named_options()
    def save(self, path: str | Path, overwrite: bool = False) -> None:
        """Write a file in the format of its ending, whole or not at all.

        ``.nc`` (netCDF) is `to_xarray`, ``.csv`` the table `to_dataframe`, ``.vtu`` is for
        ParaView: hexahedra between the points of a grid in three dimensions, else points. A file
        at `path` that holds such a result is replaced, any other only with `overwrite`; OutputError
        where that is missing, or the file cannot be written.
        """
        super().save(path, overwrite)

    @property
    def first_invariant(self) -> np.ndarray:
        """sigma_ii (252): three times the mean tension."""
        return np.asarray(np.trace(self.stress))

    @property
    def deviator(self) -> np.ndarray:
        """``s_ij = sigma_ij - sigma_hh delta_ij / 3`` (253), shape (3, 3, ...)."""
        unit = np.eye(3).reshape(3, 3, *(1,) * (self.stress.ndim - 2))
        return self.stress - unit * self.first_invariant / 3

    @property
    def ideal_stress(self) -> np.ndarray:
        """``sigma_I = sqrt(s_ij s_ij)`` (254)."""
        return np.sqrt(np.sum(self.deviator**2, axis=(0, 1)))

    @property
    def von_mises(self) -> np.ndarray:
        """``sqrt(3/2) sigma_I``: the equivalent uniaxial tension."""
        return np.sqrt(1.5) * self.ideal_stress

    @property
    def principal(self) -> np.ndarray:
        """Principal stresses, the largest first, shape (3, ...)."""
        increasing = np.linalg.eigvalsh(np.moveaxis(self.stress, (0, 1), (-2, -1)))
        return np.moveaxis(increasing[..., ::-1], -1, 0)

    @property
    def tresca(self) -> np.ndarray:
        """Difference of the largest and the smallest principal stress: twice the largest shear
        stress.
        """
        principal = self.principal
        return np.asarray(principal[0] - principal[2])


@checks.named_options()
def stress(solution: Solution | Patch, points: Any, body: Body = 1) -> SubsurfaceStress:
    """The elastic field at any points in or on one body, from a solution's surface tractions.

    Parameters
    ----------
    solution : Solution or PatchSolution
    points : array_like, shape (3, ...)
        x, y, z [length]; ``z >= 0`` in the upper body, ``z <= 0`` in the lower.
        In line contact y does not matter.
    body : 1, 2, "upper" or "lower"
        Body; under a wheel 1, 2, "rail" or "wheel", with ``z >= 0`` in the rail.

    Returns
    -------
    SubsurfaceStress

    Raises
    ------
    SceneError
        For what is no Solution, a rigid or viscoelastic body of a pair, and
        points that are not finite, beyond `FARTHEST` or outside the body.

    Notes
    -----
    Boussinesq's and Cerruti's integrals over every loaded element in closed form. At ``z = 0``
    within an element the field is the limit from inside: the tractions themselves come out. On an
    edge between elements constant tractions jump: what jumps with them has the mean of both sides.
    Where a stress has no limit there (it grows as ``ln z``; sigma_xx by a jump of px), its mean
    over a width of one element is given. Stresses do not depend on G; in a rigid body they are the
    limit of a stiff one with its nu. In layers fields are transforms by wave number, exact to
    1e-11; on their surface those at a depth of 1e-6 of an element, at an interface those of the
    lower layer. Linear tractions of line contact count as 16 strips an element.

    Examples
    --------
    The largest shear stress below a Hertzian circle is 0.31 of the peak pressure, at a depth of
    0.48 a (nu = 0.3).

    >>> import numpy as np
    >>> import varcontact as vc
    >>> scene = vc.Scene(bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(a=1.0, b=1.0),
    ...                  normal_force=2.0, grid=vc.Grid(nx=24, ny=24))
    >>> depths = np.linspace(0.3, 0.7, 41)
    >>> below = vc.stress(vc.solve(scene), [0 * depths, 0 * depths, depths])
    >>> largest = below.tresca.max() / 2 / scene.hertz.peak_pressure
    >>> print(f"{largest:.2f} at {depths[below.tresca.argmax()]:.2f}")
    0.31 at 0.48
    """
    names = body_names(solution)
    side = side_of(body, names)
    solution = solution_of(solution)
    coordinates = _coordinates(points)
    x, y, z = coordinates
    depth = z if side == 1 else -z
    outside = np.flatnonzero(depth < 0)
    if outside.size:
        first = ", ".join([":", *map(str, np.unravel_index(outside[0], depth.shape))])
        name = names[side - 1]
        if names == NAMES:
            name += " body"
        half = "z >= 0" if side == 1 else "z <= 0"
        count = f"{outside.size} of {depth.size} points are outside"
        point = coordinates.reshape(3, -1)[:, outside[0]].tolist()
        raise SceneError(f"points[{first}]", point, f"in the {name}, {half} ({count})")
    flat = np.stack([x.ravel(), y.ravel(), depth.ravel()])
    field = BodyField(solution, side)
    return field.on_scene(coordinates, field.at(flat))


def _coordinates(points: Any) -> np.ndarray:
    """Points as an array (3, ...), checked."""
    coordinates = checks.numbers("points", points, most=FARTHEST)
    if coordinates.ndim == 0 or coordinates.shape[0] != 3:
        allowed = "of shape (3, ...): x, y and z"
        if coordinates.ndim == 2 and coordinates.shape[1] == 3:
            allowed += " (did you mean its transpose?)"
        raise checks.wrong_shape("points", coordinates.shape, allowed)
    return coordinates


@checks.named_options()
def stress_below(solution: Solution | Patch, depths: Any, body: Body = 1) -> SubsurfaceStress:
    """The elastic field below all element centres at some depths: by FFT, much
    faster than point by point.

    Parameters
    ----------
    solution : Solution or PatchSolution
    depths : array_like, shape (n,), or a number
        Distances from the surface, ``>= 0`` [length], in either body.
    body : 1, 2, "upper" or "lower"
        Body; under a wheel 1, 2, "rail" or "wheel".

    Returns
    -------
    SubsurfaceStress
        Its arrays have the trailing shape (n, ny, nx).

    Raises
    ------
    SceneError
        For what is no Solution, and depths that are negative, not finite or
        beyond `FARTHEST`.
    TooLarge
        If the memory does not suffice.

    Examples
    --------
    >>> import numpy as np
    >>> import varcontact as vc
    >>> scene = vc.Scene(bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(a=1.0, b=1.0),
    ...                  normal_force=1.0, grid=vc.Grid(nx=16, ny=16))
    >>> sol = vc.solve(scene)
    >>> layers = vc.stress_below(sol, [0.0, 0.5])
    >>> layers.von_mises.shape
    (2, 18, 18)
    >>> bool(np.allclose(layers.stress[2, 2, 0], -sol.pressure, rtol=0, atol=1e-14))
    True
    """
    side = side_of(body, body_names(solution))
    solution = solution_of(solution)
    below = np.atleast_1d(checks.numbers("depths", depths, most=FARTHEST))
    if below.ndim != 1 or below.size == 0:
        raise checks.wrong_shape("depths", below.shape, "a number or several")
    if np.any(below < 0):
        raise SceneError(
            "depths", float(below.min()), "zero or positive: distances from the surface"
        )
    smaller = SMALLER
    if below.size > 1:
        smaller = "fewer depths at a time would fit"
    need(
        "the stress below the surface",
        solution.grid.size * (BYTES_PER_ELEMENT + BYTES_PER_ELEMENT_AND_DEPTH * below.size),
        smaller,
    )
    heights = below if side == 1 else -below
    z, y, x = np.meshgrid(heights, solution.grid.y, solution.grid.x, indexing="ij")
    field = BodyField(solution, side)
    return field.on_scene(np.stack([x, y, z]), field.below(below))


def body_names(solved: Any) -> tuple[str, str]:
    """Names of the bodies of a scene's solution, or of a patch of a wheel."""
    return getattr(solved, "body_names", NAMES)


def solution_of(solved: Any) -> Solution:
    """Solution of a scene, or of a patch of a wheel, checked."""
    solution: Any = solved.solution if hasattr(solved, "body_names") else solved
    checks.kind("solution", solution, Solution, more=ONE)
    return cast(Solution, solution)


def side_of(body: Any, names: tuple[str, str]) -> int:
    """The number of a body, checked: 1 or 2."""
    numbers: dict[Any, int] = {1: 1, names[0]: 1, 2: 2, names[1]: 2}
    if not isinstance(body, bool) and isinstance(body, Integral | str) and body in numbers:
        return numbers[body if isinstance(body, str) else int(body)]
    allowed = f'one of 1 or "{names[0]}", 2 or "{names[1]}"'
    if names == NAMES and isinstance(body, str) and body in ("rail", "wheel"):
        allowed += f'; "{body}" is one of a patch of a wheel: give the patch, not its solution'
    raise SceneError("body", body, allowed)


class BodyField:
    """Elastic field of one body of a solution, in axes with z into the body: a half-space or
    layers.
    """

    def __init__(self, solution: Solution, side: int) -> None:
        self.solution = solution
        self.side = side
        tangential = solution.traction if side == 1 else -solution.traction
        self.tractions = np.concatenate([tangential, solution.pressure[None]])
        surface = solution.scene.surface
        if isinstance(surface, PinInHole):
            allowed = "one of half-spaces or layers: stresses in a pin and round a hole are others"
            raise SceneError("surface", surface, allowed)
        if solution.scene.periodic:
            allowed = "False: stresses below a surface that repeats are not known"
            raise SceneError("grid.periodic", solution.scene.periodic, allowed)
        bodies = solution.scene.bodies
        body: Any
        if isinstance(bodies, Bodies):
            body = bodies
            surfaces = bodies
        elif isinstance(bodies, GivenBodies):
            body = None
        else:
            body = bodies.upper if side == 1 else bodies.lower
            surfaces = bodies.surfaces
        self.layered = isinstance(body, Layered)
        self.constants: dict[str, Any]
        if isinstance(body, Bodies):
            G, nu = surfaces.pairs
            reference = solution.scene.reference_depth or 1.0
            self.constants = {"G": G[side - 1], "nu": nu[side - 1], "reference": reference}
        elif isinstance(body, Layered):
            base = body.base if isinstance(body.base, str) else body.base[:2]
            layers = tuple((layer.h, layer.G, layer.nu) for layer in body.layers)
            self.constants = {"stack": Stack(layers, base)}
        else:
            allowed = "a half-space, Bodies(G, nu), or Layered"
            raise SceneError("body", side, f"{allowed}: of others these stresses are not known")

    def at(self, points: np.ndarray) -> Any:
        """Field at points (3, n): by FFT below element centres, where that is faster."""
        field = self._below_centres(points)
        if field is None:
            field = self._at(points, *self._strips)
        return self._with_loads_beside(field, points)

    def _below_centres(self, points: np.ndarray) -> ElasticField | None:
        """Field at points (3, n) by FFT; None if they are not below element centres, or if sums
        over the loaded elements are faster.
        """
        grid = self.solution.grid
        if self.layered or grid.linear or grid.line:
            return None
        depths, layer = np.unique(points[2], return_inverse=True)
        loaded = np.count_nonzero(np.any(self.tractions != 0, axis=0))
        distances = 4 * grid.size * depths.size
        if points.size == 0 or points.shape[1] * loaded < distances:
            return None
        column = (points[0] - grid.x[0]) / grid.sides[0]
        row = (points[1] - grid.y[0]) / grid.sides[1]
        i = np.rint(column).astype(int)
        j = np.rint(row).astype(int)
        inside = (0 <= i) & (i < grid.nx) & (0 <= j) & (j < grid.rows)
        away = np.maximum(np.abs(column - i), np.abs(row - j))
        if not inside.all() or away.max() > CENTRE_TOL:
            return None
        need("the stress below the surface", self._bytes_below(depths.size), "fewer depths")
        field = field_below(depths, grid, self.tractions, **self.constants)
        at = (layer.ravel(), j, i)
        return ElasticField(
            displacement=field.displacement[:, *at],
            gradient=field.gradient[:, :, *at],
            stress=field.stress[:, :, *at],
        )

    def _bytes_below(self, depths: int) -> float:
        """Memory of fields below all elements at some depths."""
        return self.solution.grid.size * (BYTES_PER_ELEMENT + BYTES_PER_ELEMENT_AND_DEPTH * depths)

    def below(self, depths: np.ndarray) -> Any:
        """The field at depths (n,) below all elements."""
        grid = self.solution.grid
        compute = layered_field_below if self.layered else field_below
        z, y, x = np.meshgrid(depths, grid.y, grid.x, indexing="ij")
        points = np.stack([x.ravel(), y.ravel(), z.ravel()])
        if grid.linear:
            return self.at(points)
        field = compute(depths, grid, self.tractions, **self.constants)
        return self._with_loads_beside(field, points)

    @property
    def _strips(self) -> tuple[Grid, np.ndarray]:
        """Elements with constant tractions; strips where tractions are linear, with their means."""
        grid = self.solution.grid
        if not grid.linear:
            return grid, self.tractions
        wider = grid.extended()
        tractions = np.pad(self.tractions, [(0, 0), (0, 0), (1, 1)])
        cells = 1, STRIPS
        return wider.divided(cells), on_parts(tractions, cells)

    def _at(self, points: np.ndarray, grid: Grid, tractions: np.ndarray) -> ElasticField:
        """The field at points (3, n) by tractions on a grid."""
        compute = layered_field_at if self.layered else field_at
        return compute(points, grid, tractions, **self.constants)

    def _with_loads_beside(self, field: ElasticField, points: np.ndarray) -> ElasticField:
        """A field at points (3, n) with that of loads beside the contact."""
        displacement = field.displacement
        gradient = field.gradient
        stress = field.stress
        for load in self.solution.loads_beside:
            if load.body not in ("both", NAMES[self.side - 1]):
                continue
            signs = {1: [1.0, 1.0, 1.0], 2: [-1.0, -1.0, 1.0]}
            tractions = load.parts * np.array(signs[self.side])[:, None, None]
            added = self._at(points, load.grid, tractions)
            displacement = displacement + added.displacement.reshape(displacement.shape)
            gradient = gradient + added.gradient.reshape(gradient.shape)
            stress = stress + added.stress.reshape(stress.shape)
        return ElasticField(displacement, gradient, stress)

    def of_element(self, x: np.ndarray, y: np.ndarray, depth: float, grid: Grid) -> np.ndarray:
        """Stresses (3 tractions, 3, 3, y, x) by unit tractions on one element of a grid, at
        distances that ascend by its sides.
        """
        if self.layered:
            return layered_element_stresses(x, y, depth, grid, self.constants["stack"])
        nu = self.constants["nu"]
        if grid.line:
            return element_stresses(x, y, depth, None, nu)
        return element_stresses(x, y, depth, grid.sides, nu)

    def on_scene(self, points: np.ndarray, field: Any) -> SubsurfaceStress:
        """A field in the scene's axes: that of the lower body is mirrored."""
        scene = self.solution.scene
        trailing = points.shape[1:]
        into_body = 1.0 if self.side == 1 else -1.0
        vector = np.array([1.0, 1.0, into_body]).reshape(3, *(1,) * len(trailing))
        tensor = vector[:, None] * vector
        displacement = field.displacement.reshape(points.shape) * vector
        layered_line = scene.line and not isinstance(scene.bodies, Bodies)
        if scene.shift_undetermined or layered_line:
            displacement = np.full_like(displacement, np.nan)
        return SubsurfaceStress(
            body=self.side,
            points=points,
            displacement=displacement,
            gradient=field.gradient.reshape(3, 3, *trailing) * tensor,
            stress=field.stress.reshape(3, 3, *trailing) * tensor,
            units=scene.units or IN_WORDS,
        )
