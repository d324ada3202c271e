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
from varcontact.results.solution import Solution
from varcontact.solving.options import CertifyName
from varcontact.solving.solve import solve
from varcontact.wheel_rail.result import PatchSolution, WheelRailSolution
from varcontact.wheel_rail.rough import check_smooth
from varcontact.wheel_rail.seams import weakened
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
OF_GRIDS = ("accuracy", "time_budget", "refine", "store")
"""Arguments of `varcontact.solve` that are not for a patch, whose grid follows from dx and dy."""


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
    for name in OF_GRIDS:
        if methods.get(name) is not None:
            reason = f"{name} must be left out: dx and dy of a wheel on a rail make the grid of its patches"
            raise SceneError(name, methods[name], message=reason)

    @lru_cache(maxsize=1)  # the height that bears the load is often the last that was tried
    def solved(z: float, certify: CertifyName | None) -> tuple[PatchSolution, ...]:
        return tuple(PatchSolution(patch, _solved(patch, certify, methods)) for patch in case.patches(z, warn=False))

    def vertical(z: float) -> float:
        if case.with_friction or case.bodies.K != 0:  # tractions bear a part, or change the pressure
            return _vertical(case, solved(z, None))
        return _pressed(case, z, methods)

    z, rounds = (case.z, 0) if case.z is not None else bearing_height(case, tol, vertical)
    found = solved(z, certify)
    _check_load(case, found)
    for each in found:
        check_smooth(each.patch, stacklevel=4)
        _check_elements(each)
        _check_half_space(case, each)
    return WheelRailSolution(case, z, found, rounds)


def bearing_height(case: WheelOnRail, tol: float, vertical: Callable[[float], float]) -> tuple[float, int]:
    """The height at which the forces bear the load, by the secant of force^(2/3), which is nearly straight.

    Parameters
    ----------
    case : WheelOnRail
        With a vertical force.
    tol : float
        Relative.
    vertical : callable
        From the height to the vertical force on the rail.

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
    z = low + (load / stiffness) ** (2 / 3)
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
    normal = {name: value for name, value in methods.items() if name in ("normal", "method")}
    at = case.patches(z, warn=False)
    patches = [replace(patch, scene=replace(patch.scene, motion=None, friction=None)) for patch in at]
    return _vertical(case, tuple(PatchSolution(patch, _solved(patch, None, normal)) for patch in patches))


def _solved(patch: ContactPatch, certify: CertifyName | None, methods: dict[str, Any]) -> Solution:
    """A patch; one in parts by what each feels of the others."""
    scene = weakened(patch.scene, patch.seams) if patch.seams else patch.scene
    return solve(scene, certify=certify, **methods)


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
