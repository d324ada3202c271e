"""All patches of a wheel on a rail, and the height of its axle that bears the load."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import NotConverged, SceneError
from varcontact.results.error_estimate import ErrorEstimate
from varcontact.results.quantities_of_interest import units
from varcontact.results.solution import Solution
from varcontact.scene.friction import Law
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse, SampledDistance
from varcontact.solving.options import BY_DEFAULT, CertifyName
from varcontact.solving.solve import solve
from varcontact.theories.on_grid import THEORIES
from varcontact.wheel_rail.result import PatchSolution, WheelRailSolution
from varcontact.wheel_rail.rough import check_smooth
from varcontact.wheel_rail.seams import weakened
from varcontact.wheel_rail.track import check_sides
from varcontact.wheel_rail.wheel_on_rail import ContactPatch, WheelOnRail

ROUNDS = 30
"""Heights that are tried."""
GROWTH = 10.0
"""How many times deeper the next height may be."""
ROUNDING = 1e-15
"""Of heights, by the radius of the wheel, from which they are reckoned."""
CONFORMAL = 3.0
"""Half widths that the radius of curvature of each profile should have at least, for half-spaces."""
STEEP = 2.0
"""Normal forces by the load above which a wheel on its flange is warned of: those of an angle of 60 degrees."""
FEWEST = 4
"""Elements of a patch either way, with fewer of which its pressures are rough."""
ON_ELLIPSE = 32
"""Elements either way across the ellipse on which a theory is evaluated: as many at all heights, so that forces do not
jump."""
TRIED = 4
"""Heights for which a time budget is divided: so many are usual."""
TARGETS = ("accuracy", "time_budget")
START = 0.5, 0.125
"""Sides of elements [mm] on which the height is found first where grids are chosen for an accuracy."""
ROUGHLY = 1e-3
"""Relative error of the load at that height."""
MOVED = 0.02
"""Change of the height, by the least approach, from which contacts are looked for again."""


class CoarseElements(UserWarning):
    """A patch of so few elements that its pressures are rough; its forces hardly are."""


class ConformalContact(UserWarning):
    """A patch so wide, by the curvature of a profile, that half-spaces and a tangent plane do not describe it well."""


def solve_wheel_on_rail(
    case: WheelOnRail, tol: float, certify: CertifyName | None, methods: dict[str, Any]
) -> WheelRailSolution:
    """The solution of a wheel on a rail: see `WheelOnRail.solve`.

    Parameters
    ----------
    case : WheelOnRail
    tol : float
        Of the vertical force, relative.
    certify : str or None
    methods : dict
        Arguments of `varcontact.solve`.

    Returns
    -------
    WheelRailSolution
    """
    tol = checks.positive("tol", tol)
    if methods.get("store") is not None:
        raise SceneError("store", methods["store"], message="store must be left out: it is for histories of steps")
    target = _target(case, methods)
    methods = {name: value for name, value in methods.items() if name not in TARGETS}
    if target:
        z, rounds, found = _to_accuracy(case, None, tol, certify, methods | target)
    elif _by_default(case, methods):
        try:
            z, rounds, found = _to_accuracy(case, None, tol, certify, methods | {"accuracy": BY_DEFAULT})
        except NotConverged:  # with the usual elements there is an answer without an error bar
            z, rounds, found = _on_elements(case, tol, certify, methods)
    else:
        z, rounds, found = _on_elements(case, tol, certify, methods)
    check_sides(case.track, stacklevel=4)
    _check_load(case, found)
    for each in found:
        check_smooth(each.patch, stacklevel=4)
        _check_elements(each)
        _check_half_space(case, each)
    return WheelRailSolution(case, z, found, rounds)


def _target(case: WheelOnRail, methods: dict[str, Any]) -> dict[str, Any]:
    """The accuracy or time budget that grids are chosen for, if one is given."""
    target = {name: methods[name] for name in TARGETS if methods.get(name) is not None}
    for name, value in target.items():
        checks.positive(name, value)
        for other in (*(set(target) - {name}), "refine"):
            if methods.get(other) is not None:
                raise SceneError(other, methods[other], message=f"{name} and {other} are both given: leave one out")
        for side in ("dx", "dy"):
            if getattr(case, side) is not None:
                reason = f"{side}: the grids are chosen for the {name}; leave dx and dy out, or {name}"
                raise SceneError(side, getattr(case, side), message=reason)
        if methods.get("tangential") in THEORIES:
            reason = f"tangential: a theory has an error that no grid removes; leave it out, or {name}"
            raise SceneError("tangential", methods["tangential"], message=reason)
    return target


def _by_default(case: WheelOnRail, methods: dict[str, Any]) -> bool:
    """Whether nothing that is given decides on the grid, and the answer of a grid has an error: that of `solve`."""
    given = (case.dx, case.dy, methods.get("refine"), methods.get("start"))
    exact = methods.get("tangential") not in THEORIES and methods.get("formulation") != "marching"
    rubs = isinstance(case.friction, Law) or 0 < case.friction < np.inf
    return exact and all(each is None for each in given) and rubs


Solved = tuple[float, int, tuple[PatchSolution, ...]]
"""The height of the axle, how many were tried, and the patches."""


def _on_elements(case: WheelOnRail, tol: float, certify: CertifyName | None, methods: dict[str, Any]) -> Solved:
    """On elements of dx and dy."""

    @lru_cache(maxsize=1)  # the height that bears the load is often the last that was tried
    def solved(z: float, certify: CertifyName | None) -> tuple[PatchSolution, ...]:
        found = [(patch, _solved(patch, certify, methods)) for patch in _with_elements(case, z, methods)]
        return tuple(PatchSolution(*each, _determined(case, found)) for each in found)

    def vertical(z: float) -> float:
        if case.with_friction or case.bodies.K != 0:  # tractions bear a part, or change the pressure
            return _vertical(case, solved(z, None))
        return _pressed(case, z, methods)

    z, rounds = (case.z, 0) if case.z is not None else bearing_height(case, tol, vertical)
    return z, rounds, solved(z, certify)


def _to_accuracy(
    case: WheelOnRail, near: float | None, tol: float, certify: CertifyName | None, methods: dict[str, Any]
) -> Solved:
    """On grids chosen for an accuracy: half of it for normal forces, half for tangential ones.

    Distances and frames are those of a height near that which bears the load. From there the normal forces grow by
    the power 3/2 of the depth; grids stay, so that forces do not jump.
    """
    if case.z is not None:
        near = case.z
    elif near is None:
        exact = {name: value for name, value in methods.items() if name not in TARGETS}
        near = _on_elements(replace(case, dx=START[0], dy=START[1]), max(tol, ROUGHLY), None, exact)[0]
    patches = [replace(each, scene=_sampled(each)) for each in case.patches(near, warn=False, with_grid=False)]
    if methods.get("time_budget") is not None:
        part = methods["time_budget"] / (TRIED * len(patches))
        tried = [_estimate(solve(each.scene, certify=None, **methods | {"time_budget": part})) for each in patches]
        methods = methods | {"time_budget": None, "accuracy": max(each.largest for each in tried)}
    else:
        methods = methods | {"accuracy": methods["accuracy"] / 2}
    normals = [_normal_force(patch, methods) for patch in patches]

    @lru_cache(maxsize=1)
    def solved(z: float, certify: CertifyName | None) -> tuple[PatchSolution, ...]:
        found = []
        for patch, (force, _) in zip(patches, normals, strict=True):
            deeper = max(1 + (z - near) * np.cos(patch.angle) / patch.approach, 0.0)
            scene = replace(patch.scene, approach=None, normal_force=force * deeper**1.5)
            found.append((patch, solve(scene, certify=certify, **methods)))
        known = _determined(case, found)
        errors = [error if known is None else known for _, error in normals]
        return tuple(PatchSolution(*each, error) for each, error in zip(found, errors, strict=True))

    if case.z is not None:
        return near, 0, solved(near, certify)
    z, rounds = bearing_height(case, tol, lambda z: _vertical(case, solved(z, None)), near)
    if abs(z - near) > MOVED * min(each.approach for each in patches):
        return _to_accuracy(case, z, tol, certify, methods | {"accuracy": 2 * methods["accuracy"]})
    return z, rounds, solved(z, certify)


def _estimate(solution: Solution) -> ErrorEstimate:
    assert solution.error_estimate is not None
    return solution.error_estimate


def _normal_force(patch: ContactPatch, methods: dict[str, Any]) -> tuple[float, float]:
    """That of a patch at its approach, and its relative error; of unlike bodies with tractions, which change it."""
    if patch.scene.bodies.K != 0:
        found = solve(patch.scene, certify=None, **methods)
        return found.normal_force, _estimate(found).largest
    found = solve(_frictionless(patch).scene, certify=None, **_of_pressure(methods))
    return found.normal_force, _estimate(found).errors["normal_force"]


def _determined(case: WheelOnRail, found: list[tuple[ContactPatch, Solution]]) -> float | None:
    """The relative error of a normal force that follows from the load and the tangential force, of a single patch."""
    (patch, solution), estimate = found[0], found[0][1].error_estimate
    if case.z is not None or len(found) > 1 or estimate is None:
        return None
    if not case.with_friction or "Fy" not in estimate.errors:
        return 0.0
    # tangential forces grow with the normal force: it changes until all of the load is borne again
    lifting = abs(np.sin(patch.angle)) * estimate.errors["Fy"] * units(solution)["Fy"]
    return float(lifting / abs(patch.frame.axes[2] @ [*solution.force, solution.normal_force]))


def _with_elements(case: WheelOnRail, z: float, methods: dict[str, Any]) -> tuple[ContactPatch, ...]:
    """The patches on elements of dx and dy; to be refined with samples that are known between their centres, too."""
    patches = case.patches(z, warn=False)
    if methods.get("refine") is None:
        return patches
    sampled = case.patches(z, warn=False, with_grid=False)
    return tuple(
        replace(each, scene=replace(_sampled(each), grid=patch.scene.grid), seams=()) if _covers(each, patch) else patch
        for each, patch in zip(sampled, patches, strict=True)
    )


def _covers(sampled: ContactPatch, patch: ContactPatch) -> bool:
    """Whether the samples reach over the elements: they do unless these are too few to be refined."""
    assert isinstance(sampled.scene.surface, SampledDistance)
    assert isinstance(patch.scene.grid, Grid)
    inner, outer = np.array(patch.scene.grid.box), np.array(sampled.scene.surface.box)
    return bool(np.all((inner - outer) * [1, -1, 1, -1] >= 0))


def _sampled(patch: ContactPatch) -> Scene:
    """The scene of a patch without a grid; of one in parts with what each feels of the others."""
    scene = patch.scene
    if not patch.seams:
        return scene
    assert isinstance(scene.surface, SampledDistance)
    x, y = scene.surface.coordinates
    dx, dy = x[1] - x[0], y[1] - y[0]
    grid = Grid(nx=x.size, ny=y.size, dx=dx, dy=dy, x0=x[0] - dx / 2, y0=y[0] - dy / 2)
    weak = weakened(replace(scene, surface=SampledDistance(scene.surface.h), grid=grid), patch.seams).surface
    assert isinstance(weak, SampledDistance)
    return replace(scene, surface=replace(scene.surface, h=weak.h))


def bearing_height(
    case: WheelOnRail, tol: float, vertical: Callable[[float], float], start: float | None = None
) -> tuple[float, int]:
    """The height at which the forces bear the load, by the secant of force^(2/3), which is nearly straight.

    Parameters
    ----------
    case : WheelOnRail
        With a vertical force.
    tol : float
        Relative.
    vertical : callable
        From the height to the vertical force on the rail.
    start : float, optional
        The height that is tried first [mm].

    Returns
    -------
    z : float
        [mm]
    rounds : int
        Heights that were tried.

    Raises
    ------
    SceneError
        If friction lifts the wheel, so that no height bears the load.
    NotConverged
        If none was found.
    """
    load = case.vertical_force
    assert load is not None
    low, high = case.touching, np.inf
    last, last_value = low, -(load ** (2 / 3))  # no force
    stiffness = 4 / 3 * case.bodies.combined_G / (1 - case.bodies.combined_nu) * np.sqrt(case.wheelset.radius)
    z = low + (load / stiffness) ** (2 / 3) if start is None else start
    for rounds in range(1, ROUNDS + 1):
        force = vertical(z)
        if abs(force - load) <= tol * load:
            return z, rounds
        if force <= 0:
            raise _lifted(case, z, force)
        value = float(np.sign(force) * abs(force) ** (2 / 3) - load ** (2 / 3))
        low, high = (z, high) if value < 0 else (low, z)
        slope = (value - last_value) / (z - last)
        step = z - value / slope if slope > 0 else np.inf
        last, last_value = z, value
        if np.isinf(high):
            z = min(step, case.touching + GROWTH * (z - case.touching))
        else:
            z = step if low < step < high else (low + high) / 2
        if z == last:
            break
    missed = f"the height of the axle that bears {load:g} N was not found"
    if tol * (z - case.touching) < ROUNDING * case.wheelset.radius:
        missed += f" to within tol = {tol:g}: heights are rounded more coarsely than that; give a larger load, or tol"
    raise NotConverged(missed, abs(force - load) / load)


def _lifted(case: WheelOnRail, z: float, force: float) -> SceneError:
    """What to raise where friction presses the wheel up by more than the pressures press it down."""
    reason = (
        f"vertical_force = {case.vertical_force:g} N: no height of the axle bears it. {z - case.touching:.3g} mm below "
        "the height where the wheel touches, friction lifts it by more than its normal force presses it down (together "
        f"{force:.4g} N): it climbs on the rail. Give another position, velocity or coefficient of friction, z instead "
        "of the force, or with_friction = False for a force of normal forces alone"
    )
    return SceneError("vertical_force", case.vertical_force, message=reason)


def _vertical(case: WheelOnRail, solved: tuple[PatchSolution, ...]) -> float:
    """The vertical force on the rail; without friction that of the normal forces."""
    if case.with_friction:
        return float(sum(each.force_on_track[2] for each in solved))
    return float(sum(each.normal_force * np.cos(each.patch.angle) for each in solved))


def _pressed(case: WheelOnRail, z: float, methods: dict[str, Any]) -> float:
    """The vertical force of the pressures at a height of the axle, which tractions do not change."""
    patches = [_frictionless(patch) for patch in case.patches(z, warn=False)]
    return _vertical(case, tuple(PatchSolution(each, _solved(each, None, _of_pressure(methods))) for each in patches))


def _frictionless(patch: ContactPatch) -> ContactPatch:
    return replace(patch, scene=replace(patch.scene, motion=None, friction=None))


def _of_pressure(methods: dict[str, Any]) -> dict[str, Any]:
    """The arguments that are for a normal problem, too."""
    return {name: value for name, value in methods.items() if name in ("normal", "method", "accuracy")}


def _solved(patch: ContactPatch, certify: CertifyName | None, methods: dict[str, Any]) -> Solution:
    """A patch on its grid; one in parts by what each feels of the others; by a theory on an ellipse in its place."""
    scene = weakened(patch.scene, patch.seams) if patch.seams else patch.scene
    if methods.get("tangential") in THEORIES:
        normal = solve(replace(scene, motion=None, friction=None), certify=None, **_of_pressure(methods))
        scene = _on_ellipse(scene, normal)
        methods = {name: value for name, value in methods.items() if name != "normal"}
    return solve(scene, certify=certify, **methods)


def _on_ellipse(scene: Scene, normal: Solution) -> Scene:
    """Hertz's contact with the force of a pressure and its second moments, a^2/5 and b^2/5."""
    grid, weights = normal.grid, normal.pressure / normal.pressure.sum()
    a, b = (
        float(np.sqrt(5 * (along @ (at - along @ at) ** 2 + side**2 / 12)))
        for along, at, side in (
            (weights.sum(axis=0), grid.x, grid.sides[0]),
            (weights.sum(axis=1), grid.y, grid.sides[1]),
        )
    )
    ellipse = Grid(nx=ON_ELLIPSE, ny=ON_ELLIPSE)
    return replace(scene, surface=Ellipse(a, b), approach=None, normal_force=normal.normal_force, grid=ellipse)


def _check_load(case: WheelOnRail, solved: tuple[PatchSolution, ...]) -> None:
    """Warn where the normal forces are far larger than the load: on a steep flange."""
    pressed = sum(each.normal_force for each in solved)
    if case.vertical_force is not None and pressed > STEEP * case.vertical_force:
        warnings.warn(
            f"normal forces of {pressed:.4g} N bear the load of {case.vertical_force:.4g} N, on a flange as steep as "
            f"{np.degrees(max(abs(each.patch.angle) for each in solved)):.3g} degrees: a wheel with this load hardly "
            "comes to this position",
            stacklevel=4,
        )


def _check_elements(solved: PatchSolution) -> None:
    """Warn where a patch has few elements."""
    contact, sides = solved.solution.pressure > 0, solved.solution.grid.sides
    for axis, (side, what) in enumerate(zip(sides, ("dx", "dy"), strict=True)):
        count = int(np.count_nonzero(contact.any(axis=axis)))
        if 0 < count < FEWEST:
            warnings.warn(
                f"with {what} = {side:g} mm the patch at y = {solved.patch.location[1]:.4g} mm is {count} "
                f"element{'s' * (count > 1)} {('long', 'wide')[axis]}: too few for its pressures; give a smaller "
                f"{what}, for {FEWEST} elements or more",
                CoarseElements,
                stacklevel=4,
            )


def _check_half_space(case: WheelOnRail, solved: PatchSolution) -> None:
    """Warn where a profile is curved too much for the width of the patch."""
    patch, half = solved.patch, solved.half_width
    across = half * np.cos(patch.angle) * np.array([-1.0, 1.0])
    for profile, point in ((case.track.rail, patch.on_rail), (case.wheelset.wheel, patch.on_wheel)):
        turned = profile.angle_at(point[0] + across)  # on average over the patch: noise does not count
        curvature = abs(np.sin(float(turned[1] - turned[0]) / 2)) / half
        if curvature * half * CONFORMAL > 1:
            warnings.warn(
                f"conformal contact: the patch at y = {patch.location[1]:.4g} mm is {half:.3g} mm wide to either side, "
                f"and the {profile.kind}'s radius of curvature there is {1 / curvature:.3g} mm, less than "
                f"{CONFORMAL:g} times as much; half-spaces are too soft for that, and the tangent plane too flat",
                ConformalContact,
                stacklevel=4,
            )
