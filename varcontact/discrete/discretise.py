"""From a scene and an explicit grid to its discretisation: distance, scales, influence numbers."""

from __future__ import annotations

import math

import numpy as np

from varcontact.discrete.discretisation import FREE_DEPTH, Discretisation, posed
from varcontact.discrete.operators import Operators
from varcontact.discrete.out_of_reach import check_range, out_of_reach
from varcontact.errors import SceneError, TooCoarse
from varcontact.reference.hertz import HertzContact
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse, Paraboloids, SampledDistance, Surface


def discretise(scene: Scene, grid: Grid, known: Operators | None = None, coupled: bool = True) -> Discretisation:
    """A scene on an explicit grid, with the operators that are `known` where they are those of its lattice.

    Unless `coupled`, pressure and tractions are independent, whatever K is.

    Parameters
    ----------
    scene : Scene
        Of one problem: not a history.
    grid : Grid
        Explicit, physical.
    known : Operators, optional
        Those of a scene before.
    coupled : bool

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
            "surface.reference_depth", depth, f"at least the length of the potential contact, {along_x:.6g}"
        )
    if hertz is not None and (dx > 2.000001 * hertz.a or dy > 2.000001 * hertz.b):
        size, element = f"{2 * hertz.a:.6g}", f"{dx:.6g}"
        if not scene.line:
            size, element = f"{size} by {2 * hertz.b:.6g}", f"{element} by {dy:.6g}"
        raise TooCoarse(
            "grid",
            dx if scene.line else (dx, dy),
            "fine enough to hold one contact element",
            message=f"grid is too coarse to hold one contact element: the contact is {size}, an element {element}",
        )
    distance = undeformed_distance(scene.surface, hertz, grid)
    length = along_x if scene.line else math.sqrt(along_x * grid.rows * dy)
    if hertz is not None:
        pressure = hertz.peak_pressure
    elif scene.normal_force is not None:
        pressure = scene.normal_force / (length if scene.line else length**2)
    else:
        assert scene.approach is not None
        overlap = scene.approach - float(distance.min())
        if overlap <= 0:
            raise out_of_reach(scene.surface, scene.approach, grid)
        pressure = scene.bodies.combined_G * overlap / length
    check_range(scene, length, pressure)
    operators = _operators(scene, grid.scaled(length), length, scene.bodies.K if coupled else 0.0, known)
    return Discretisation(
        bodies=scene.bodies,
        surface=scene.surface,
        grid=grid,
        hertz=hertz,
        distance=distance,
        length=length,
        pressure=pressure,
        operators=operators,
        **posed(scene),
    )


def undeformed_distance(surface: Surface, hertz: HertzContact | None, grid: Grid, beyond: float = 0.0) -> np.ndarray:
    """Undeformed distance at the element centres; that of an ellipse has its Hertzian radii.

    Parameters
    ----------
    surface : Surface
    hertz : HertzContact or None
        Needed for an ellipse.
    grid : Grid
        Explicit, physical.
    beyond : float
        As of `SampledDistance.distance` [length].

    Returns
    -------
    ndarray, shape (ny, nx)
        [length]
    """
    if isinstance(surface, SampledDistance):
        return surface.distance(grid, beyond)
    if isinstance(surface, Ellipse):
        assert hertz is not None
        return Paraboloids(hertz.Rx, hertz.Ry).distance(grid)
    return surface.distance(grid)


def _operators(scene: Scene, lattice: Grid, length: float, K: float, known: Operators | None) -> Operators:
    """The operators of a lattice, those already known where they are the same."""
    nu, depth = scene.bodies.combined_nu, FREE_DEPTH
    if scene.reference_depth is not None:
        depth = scene.reference_depth / length
    if known is not None and known.same(lattice, nu, K, depth):
        return known
    return Operators(lattice, nu, K, depth)
