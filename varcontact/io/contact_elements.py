"""Elements, undeformed distance, load and fields of CONTACT's basic contacts (module 3)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from varcontact.checks import positive
from varcontact.discrete.discretisation import discretise
from varcontact.io.contact_cases import CaseInput
from varcontact.io.contact_words import Group, lattice, located
from varcontact.reference.hertz import hertz_ellipse
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse, Paraboloids, SampledDistance

ELLIPTIC = 2
PARABOLIC = 3
TWO_HALVES = 4
"""Values of the digit B."""
RECTANGLES = (-4, -5)
"""Values of IPOTCN."""


def elements_of(case: CaseInput) -> Grid:
    """The elements of IPOTCN = 1 to 4."""
    kind, group = case.entries["elements"]
    (ipotcn,) = kind.integers()
    nx, ny = (group.count(k) for k in (0, 1))
    x, y, dx, dy = (group.number(k) for k in range(2, 6))
    # the other end is given: of the elements, or of their centres
    if ipotcn == 2:
        dx = (dx - x) / nx
        dy = (dy - y) / ny
    if ipotcn == 4:
        dx = (dx - x) / max(nx - 1, 1)
        dy = (dy - y) / max(ny - 1, 1)
    if ipotcn in (3, 4):  # from centre to centre
        x = x - dx / 2
        y = y - dy / 2
    return lattice(group, nx, ny, (dx, dy), (x, y))


def distance_of(case: CaseInput, grid: Grid) -> np.ndarray:
    """The undeformed distance at the centres of the elements, infinite outside of the planform."""
    kind, *groups = case.entries["distance"]
    ibase, iplan = kind.integers()
    x = grid.x[None, :] + np.zeros(grid.shape)
    y = grid.y[:, None] + np.zeros(grid.shape)
    values = groups[0].numbers()
    with np.errstate(all="ignore"):  # distances that are not finite are refused by the surface
        if ibase == 1:
            h = _quadratic(values, x, y)
        elif ibase == 2:
            h = _of_profile(groups[0], groups[1].numbers(), x, y)
        elif ibase == 3:
            b1, b2, b3, b4, b5, b6, b7, b8 = values
            waves = b1 * np.sin(b2 * (x - b3)) - b4 * np.sin(b5 * (x - b6))
            h = waves + x**2 / b7 + y**2 / b8
        else:
            if len(values) != grid.size:
                case.controls.complain("RZNORM", "keeps the undeformed distance of other elements")
            h = np.reshape(values, grid.shape)
    if iplan == 4:
        kind.refuse("IPLAN", 4, "is not supported: patches that feel each other in part")
    if iplan == 1:
        return h
    return np.where(_in_planform(iplan, groups[-1].numbers(), x, y), h, np.inf)


def _quadratic(values: list[float], x: np.ndarray, y: np.ndarray) -> np.ndarray:
    b1, b2, b3, b4, b5, b6 = values
    return np.asarray(b1 * x**2 + b2 * x * y + b3 * y**2 + b4 * x + b5 * y + b6)


def _of_profile(head: Group, heights: list[float], x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Distance of a profile: circular along x; along y linear between points, and extrapolated
    beyond.
    """
    _, axle, radius, first, step = head.numbers()
    if radius == 0 or step <= 0:
        head.refuse("RM, DY1", (radius, step), "must be a radius and a positive distance")
    at = (y - first) / step
    profile = np.array(heights)
    # the outermost pieces are extrapolated
    k = np.clip(np.floor(at).astype(int), 0, len(heights) - 2)
    between = profile[k] + (at - k) * (profile[k + 1] - profile[k])
    return np.asarray(between + (x - axle) ** 2 / (2 * radius))


def _in_planform(iplan: int, values: list[float], x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """True where the planform, an ellipse or two rectangles, has material."""
    if iplan == 2:
        return np.asarray(_quadratic(values, x, y) < 0)
    inside = np.zeros(x.shape, dtype=bool)
    for left, right, bottom, top in (values[:4], values[4:]):
        inside |= (left <= x) & (x <= right) & (bottom <= y) & (y <= top)
    return inside


def sampled(distance: np.ndarray, grid: Grid, **fields: Any) -> SampledDistance:
    """Samples on the elements; infinite distances become ones that no contact reaches."""
    far = ~np.isfinite(distance) & ~np.isnan(distance)
    if np.any(far):
        distance = np.where(far, _far(distance[~far], grid), distance)
    return SampledDistance(distance, **fields)


def _far(distance: np.ndarray, grid: Grid) -> float:
    """Distance that the bodies cannot approach over."""
    dx, dy = grid.sides
    return float(np.max(np.abs(distance), initial=0.0) + grid.nx * dx + grid.rows * dy)


def load_of(case: CaseInput) -> dict[str, Any]:
    """The normal force, or the approach."""
    load = case.entries["kinematics"].number(0)
    if case.controls["NORM"] == 0:
        return {"approach": load}
    return {"normal_force": load}


def hertzian(case: CaseInput, bodies: Bodies) -> tuple[Any, Grid]:
    """Surface and elements of a Hertzian contact, IPOTCN = -1 to -3."""
    kind: Group
    group: Group
    kind, group = case.entries["elements"]
    (ipotcn,) = kind.integers()
    nx, ny = (group.count(k) for k in (0, 1))
    first, second, scale = (group.number(k) for k in range(2, 5))
    with located(group):
        surface = _hertzian_surface(ipotcn, first, second, bodies)
        scene: Scene[None] = Scene(bodies=bodies, surface=surface, **load_of(case))
    contact = scene.hertz
    if contact is None or scale <= 0:
        group.refuse("SCALE", scale, "with this load gives no potential contact")
    a = contact.a * scale
    b = contact.b * scale
    return surface, lattice(group, nx, ny, (2 * a / nx, 2 * b / ny), (-a, -b))


def _hertzian_surface(
    ipotcn: int, first: float, second: float, bodies: Bodies
) -> Ellipse | Paraboloids:
    """Surface for IPOTCN = -1 from two curvatures, for -2 from one and the ratio of the semi-axes,
    for -3 from the semi-axes.
    """
    if ipotcn == -3:
        return Ellipse(a=first, b=second)
    if ipotcn == -2:
        shape = hertz_ellipse(second, 1.0, bodies, force=1.0)
        second = first * shape.Rx / shape.Ry
    return Paraboloids(Rx=1 / (2 * positive("A1", first)), Ry=1 / (2 * positive("B1", second)))


def prescribed_pressure(case: CaseInput, bodies: Bodies) -> tuple[SampledDistance, Grid, float]:
    """The distance under which contact has the pressure that B = 2, 3 or 4 prescribes, the elements
    of IPOTCN < 0, and the approach.

    Elements beyond that contact are out of reach.
    """
    kind: Group
    group: Group
    kind, group = case.entries["elements"]
    (ipotcn,) = kind.integers()
    nx, ny = (group.count(k) for k in (0, 1))
    force = case.entries["kinematics"].number(0)
    scale = group.number(len(group.values) - 1)
    a, *widths = _semi_axes(ipotcn, group, bodies, force)
    b = sum(widths) / len(widths)
    if min(a, *widths, scale, force) <= 0:
        group.refuse("SCALE", scale, "with these sizes and this load gives no potential contact")
    sides = (2 * a * scale / nx, 2 * b * scale / ny)
    grid = lattice(group, nx, ny, sides, (-a * scale, -b * scale))
    pressure = _prescribed(ipotcn, case.controls["BOUND"], grid, (a, *widths), force)
    if not pressure.any():
        group.refuse("MX MY", (nx, ny), "are so few that no element is in contact")
    displacement = _displacement(bodies, grid, pressure)
    approach = float(displacement[pressure > 0].max())
    distance = np.where(pressure > 0, approach - displacement, np.inf)
    return sampled(distance, grid), grid, approach


def _semi_axes(ipotcn: int, group: Group, bodies: Bodies, force: float) -> list[float]:
    """The half-length, and the half-width or those of both sides."""
    first = group.number(2)
    second = group.number(3)
    if ipotcn == -6:
        return [first, second, group.number(4)]
    if ipotcn in (-3, -5):
        return [first, second]
    if ipotcn == -4:  # of cylinders, by the load per length
        modulus = bodies.combined_G / (1 - bodies.combined_nu)
        squared = force / (np.pi * modulus * positive("A1", first) * positive("BB", second))
        return [float(np.sqrt(max(squared, 0.0))), second]
    surface = _hertzian_surface(ipotcn, first, second, bodies)
    contact = Scene(bodies=bodies, surface=surface, normal_force=force).hertz
    assert contact is not None
    return [contact.a, contact.b]


def _prescribed(
    ipotcn: int, bound: int, grid: Grid, axes: tuple[float, ...], force: float
) -> np.ndarray:
    """The pressure at the centres of the elements: elliptic or parabolic, over an ellipse, a
    rectangle or two half-ellipses.
    """
    a, *widths = axes
    b = sum(widths) / len(widths)
    x = grid.x[None, :] / a
    y = grid.y[:, None]
    if ipotcn in RECTANGLES:
        inside = np.where(np.abs(y) < b, np.maximum(1 - x**2, 0.0), 0.0)
        means = {PARABOLIC: 2 / 3, ELLIPTIC: np.pi / 4}
        largest = force / (4 * a * b * means[bound])
    else:
        if ipotcn == -6:  # the half-ellipses meet off the middle
            y = y - (widths[0] - widths[1]) / 2
            y = np.where(y > 0, y / widths[1], y / widths[0])
        else:
            y = y / b
        inside = np.maximum(1 - x**2 - y**2, 0.0)
        means = {PARABOLIC: 1 / 2, ELLIPTIC: 2 / 3, TWO_HALVES: 2 / 3}
        largest = force / (np.pi * a * b * means[bound])
    if bound == PARABOLIC:
        return np.asarray(largest * inside)
    return np.asarray(largest * np.sqrt(inside))


def _displacement(bodies: Bodies, grid: Grid, pressure: np.ndarray) -> np.ndarray:
    """Normal displacement of both bodies together by a pressure."""
    plane = SampledDistance(np.zeros(grid.shape))
    disc = discretise(Scene(bodies=bodies, surface=plane, approach=1.0, grid=grid), grid)
    scaled = pressure[None] / disc.scales.pressure
    return np.asarray(disc.operators.normal.apply(scaled)[0] * disc.scales.displacement)


def ringed(scene: Scene) -> Scene:
    """Scene with one more ring of elements, in which the bodies do not touch: a contact may then
    reach the last of the given elements.
    """
    grid = scene.grid
    assert isinstance(grid, Grid)
    wider = grid.extended()
    surface = scene.surface
    if isinstance(surface, Ellipse):
        load = scene.hertz
        assert load is not None
        surface = Paraboloids(Rx=load.Rx, Ry=load.Ry)
    distance = np.pad(surface.distance(grid), 1, constant_values=np.inf)
    fields: dict[str, Any] = {}
    angles = getattr(surface, "inclination", None)
    if angles is not None:
        fields["inclination"] = np.pad(angles, 1, mode="edge")
    changes: dict[str, Any] = {"grid": wider, "surface": sampled(distance, wider, **fields)}
    if isinstance(scene.friction, np.ndarray):
        changes["friction"] = np.pad(scene.friction, 1, mode="edge")
    motion = scene.motion
    if isinstance(motion, Steady) and motion.rigid_slip is not None:
        slip = np.pad(motion.rigid_slip, [(0, 0), (1, 1), (1, 1)])
        changes["motion"] = replace(motion, rigid_slip=slip)
    return replace(scene, **changes)


def mirrored(scene: Scene) -> Scene:
    """Steady rolling towards negative x, seen from the other side: x to -x.

    Of a steady motion that was made with the numbers of rolling towards negative x.
    """
    grid = scene.grid
    assert isinstance(grid, Grid)
    motion = scene.motion
    assert isinstance(motion, Steady)
    changes: dict[str, Any] = {"grid": replace(grid, x0=-grid.box[1])}
    if isinstance(scene.surface, SampledDistance):
        changes["surface"] = replace(scene.surface, h=scene.surface.h[:, ::-1])
    if isinstance(scene.friction, np.ndarray):
        changes["friction"] = scene.friction[:, ::-1]
    turned: dict[str, Any] = {"vx": -motion.vx, "spin": -motion.spin}
    if motion.Fx is not None:
        turned["Fx"] = -motion.Fx
    if motion.rigid_slip is not None:
        turned["rigid_slip"] = motion.rigid_slip[:, :, ::-1] * np.array([-1, 1])[:, None, None]
    return replace(scene, **changes, motion=replace(motion, **turned))
