"""Balance of the loads on a wheel set: found with the fast way, and then with a
few exact solutions.

Unknown are the free positions and velocities, and how far rails yield. With
each wheel's height of the axle prescribed, forces are functions of them without
a search. Their derivatives are the fast way's; Broyden's method corrects these
from one exact solution to the next.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from varcontact.errors import NoContact, NotConverged, SceneError
from varcontact.kinematics import Creepages, Frame
from varcontact.scene.friction import Law
from varcontact.solving.options import CertifyName
from varcontact.theories.creep_forces import TheoryName
from varcontact.wheel_rail.result import WheelForces, WheelRailSolution
from varcontact.wheel_rail.solve import TARGETS
from varcontact.wheel_rail.track import SIGN
from varcontact.wheel_rail.virtual_penetration import Ellipse, FastPatch
from varcontact.wheel_rail.wheel_on_rail import ELEMENT, WheelOnRail
from varcontact.wheel_rail.wheel_set import BALANCED, WheelSetOnTrack
from varcontact.wheel_rail.wheel_set_solution import WheelSetSolution

STEP = 1e-3
"""Of the differences for derivatives, by the unit of an unknown."""
CREEPAGE = 1e-3
"""Unit of velocities, by the speed, and of the yaw."""
SIDEWAYS = 0.1
"""Unit of the lateral displacement [mm]."""
WALK = 1.0
"""Step of the lateral displacement in the search for two positions with the balance between them [mm]."""
ROUGH = 0.02
"""Largest imbalance of the fast way."""
NEAR = 1e-4
"""Least imbalance where grids are chosen for an accuracy, whose forces jump by a part of their error bars."""
PRESSED = 0.02
"""Step to a greater depth, by the depth, at which a wheel must be borne by more."""
EDGE = 10.0
"""Distance from the outer end of a wheel at which it falls between the rails [mm]."""
FLAT = 1e10
"""Condition of derivatives above which loads are not balanced by the unknowns."""
ROUNDS = 20
"""Exact solutions with the derivatives of the fast way."""

Solver = Callable[[WheelOnRail], WheelForces]


@dataclass(frozen=True, eq=False)
class _Balance:
    """The equations of a case: unknowns by their names, and the units of both."""

    case: WheelSetOnTrack
    names: tuple[str, ...]
    loads: tuple[str, ...]
    load: float
    depth: float
    origin: np.ndarray
    units: np.ndarray

    def values(self, x: np.ndarray) -> dict[str, float]:
        return dict(zip(self.names, (self.origin + self.units * x).tolist(), strict=True))

    def wheels(self, x: np.ndarray, solver: Solver) -> tuple[WheelForces, WheelForces]:
        values = self.values(x)
        moved = self.case.moved(values)
        z = values["z"] if self.case.z is None else self.case.z
        found: list[WheelForces] = []
        for side in SIGN:
            wheel = moved.wheel(side, z)
            above = wheel.touching - z
            if above < 0:
                found.append(solver(wheel))
                continue
            # above its rail, in the search pulled down as by a spring
            arm = wheel.position.rotation @ [0.0, SIGN[side] * self.case.wheelset.middle, 0.0]
            centre = np.array([0.0, wheel.position.y, z - self.case.wheelset.radius])
            place = Frame(centre + arm, np.eye(3))
            pull = np.array([0.0, 0.0, -self.load / 2 * above / self.depth])
            found.append(WheelForces(wheel, z, (_patch_with(place, pull),)))
        return found[0], found[1]

    def left_over(self, wheels: tuple[WheelForces, WheelForces]) -> dict[str, float]:
        """Of each load, what the rails do not bear; by the load of the axle."""
        case, (left, right) = self.case, wheels
        force, moment = left.force + right.force, left.moment_on_wheelset + right.moment_on_wheelset
        half = case.wheelset.middle
        missing = {
            "longitudinal_force": case.longitudinal_force - force[0],
            "lateral_force": case.lateral_force - force[1],
            "vertical_force": (case.vertical_force or 0.0) - force[2],
            "roll_moment": (case.roll_moment + moment[0]) / half,
            "torque": (case.torque + moment[1]) / case.wheelset.radius,
            "yaw_moment": (case.yaw_moment + moment[2]) / half,
        }
        return {name: float(value / self.load) for name, value in missing.items()}

    def imbalance(self, wheels: tuple[WheelForces, WheelForces]) -> np.ndarray:
        """Of the loads, and then of the rails that yield."""
        missing, case = self.left_over(wheels), self.case
        rest = [missing[name] for name in self.loads]
        for each in wheels if case.track.stiffness is not None else ():
            given, now = (getattr(track, each.case.side) for track in (case.track, each.case.track))
            moved = np.array([now.y - given.y, now.z - given.z])
            rest += list((case.track.stiffness * moved - each.force[1:]) / self.load)
        return np.array(rest)

    def errors(self, left: WheelForces, right: WheelForces, inverse: np.ndarray) -> dict[str, float]:
        """Of the unknowns, from the errors of the forces of each patch."""
        felt = np.zeros(len(self.names))
        for wheel in (left, right):
            for patch in wheel.patches:
                for pushed in np.diag(patch.error):
                    changed = WheelForces(wheel.case, wheel.z, (*wheel.patches, _patch_with(patch.frame, pushed)))
                    pair = (changed, right) if wheel is left else (left, changed)
                    felt += np.abs(inverse @ (self.imbalance(pair) - self.imbalance((left, right))))
        return dict(zip(self.names, (self.units * felt).tolist(), strict=True))


def _patch_with(frame: Frame, force: np.ndarray) -> FastPatch:
    """A patch with a force in its frame."""
    return FastPatch(frame, 0.0, Creepages(0.0, 0.0, 0.0, 1.0), 0.0, Ellipse(0.0, 0.0, 0.0, 0.0), force, 0.0)


def solve_wheel_set(
    case: WheelSetOnTrack, tol: float, certify: CertifyName | None, methods: dict[str, Any]
) -> WheelSetSolution:
    """See `WheelSetOnTrack.solve`."""
    from scipy.optimize import NoConvergence, broyden1, root

    balance, x = _balanced(case, _near)
    solved = 0
    derivatives = np.zeros((x.size, x.size))
    for k, step in enumerate(STEP * np.eye(x.size)):
        behind, ahead = (balance.imbalance(balance.wheels(place, _near)) for place in (x - step, x + step))
        derivatives[:, k] = (ahead - behind) / (2 * STEP)
    if x.size and np.linalg.cond(derivatives) > FLAT:  # as where friction is saturated
        missed = np.abs(balance.imbalance(balance.wheels(x, _near))).max()
        raise NotConverged(_unbalanced(balance.case), float(missed))
    inverse = np.linalg.inv(derivatives)

    def corrected(x: np.ndarray, solver: Solver, tol: float) -> np.ndarray:
        def imbalance(step: np.ndarray) -> np.ndarray:
            nonlocal solved
            solved += 1
            return balance.imbalance(balance.wheels(x + inverse @ step, solver))

        begin = np.zeros(x.size)
        try:
            step = broyden1(imbalance, begin, f_tol=tol, maxiter=ROUNDS, alpha=-1, line_search=None)
        except NoConvergence:  # the fast way's derivatives are too far off: with those of exact solutions
            found = root(imbalance, begin, options={"factor": 0.1, "xtol": 1e-12, "eps": STEP**2})
            step, missed = found.x, float(np.abs(found.fun).max())
            if missed > tol:
                raise NotConverged("the balance of the wheel set was not found", missed) from None
        return np.asarray(x + inverse @ step)

    last: dict[str, WheelRailSolution] = {}

    def found(wheel: WheelOnRail, entries: dict[str, Any], methods: dict[str, Any]) -> WheelForces:
        before = last.get(wheel.side)
        if before is not None and wheel.conformal == "auto":  # chosen once: forces jump where that changes
            wheel = replace(wheel, conformal=before.case.conformal is True)
        last[wheel.side] = replace(wheel, **entries).solve(**{"start": before, **methods})
        return last[wheel.side]

    usual = {name: value for name, value in methods.items() if name not in TARGETS}
    solver = partial(found, entries={}, methods=methods | {"certify": certify})
    on_elements = partial(found, entries={"dx": case.dx or ELEMENT, "dy": case.dy or ELEMENT}, methods=usual)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if x.size and case.dx is None and case.dy is None:
            tol = max(tol, NEAR)
            x = corrected(x, on_elements, tol)
        if x.size:
            x = corrected(x, solver, tol)
    return _solution(balance, x, solver, solved, inverse)


def estimate_wheel_set(
    case: WheelSetOnTrack, normal: str, tangential: TheoryName, tol: float, options: dict[str, Any]
) -> WheelSetSolution:
    """See `WheelSetOnTrack.estimate`."""
    solver = partial(WheelOnRail.estimate, normal=normal, tangential=tangential, **options)
    balance, x = _balanced(case, solver)
    found = _solution(balance, x, solver, 0, None)
    if found.imbalance > tol:
        words = f"loads are balanced to {found.imbalance:.2g} only: forces of the fast way jump where patches join"
        warnings.warn(words, stacklevel=4)
    return found


def _near(wheel: WheelOnRail) -> WheelForces:
    """The fast way where exact solutions begin: under a law with its kinetic coefficient."""
    law = wheel.friction
    return (replace(wheel, friction=law.kinetic or law.static) if isinstance(law, Law) else wheel).estimate()


def _solution(
    balance: _Balance, x: np.ndarray, solver: Solver, solved: int, inverse: np.ndarray | None
) -> WheelSetSolution:
    """The wheels at the balance; errors of forces there are errors of what was found."""
    case, wheels = balance.case, balance.wheels(x, solver)
    for each in wheels:
        if each.case.touching >= each.z:
            if "roll" not in case.free:
                roll = case.position.roll
                reason = f"with roll = {roll:.4g} the {each.case.side} wheel is above its rail; add roll to free"
                raise SceneError("position.roll", roll, message=reason)
            reason = f"the loads lift the {each.case.side} wheel off its rail: no position bears them"
            raise SceneError("roll_moment", case.roll_moment, message=reason)
        deeper = replace(each.case, z=each.z + PRESSED * balance.depth)
        if _near(deeper).force[2] < _near(each.case).force[2]:
            reason = f"the {each.case.side} wheel is wedged: friction lifts it when pressed in; give another position"
            raise SceneError("position.y", each.case.position.y, message=reason)
    missed = float(np.abs(balance.imbalance(wheels)).max(initial=0.0))
    errors = balance.errors(*wheels, inverse) if inverse is not None else dict.fromkeys(balance.names, math.nan)
    left, right = wheels
    return WheelSetSolution(case, left.z, left.patches + right.patches, left, right, missed, solved, errors)


def _balanced(case: WheelSetOnTrack, solver: Solver) -> tuple[_Balance, np.ndarray]:
    """The balance by the fast way, with the lateral displacement between two from which the wheel set is pushed back.

    Where the wheel set is free to yaw, too, its yaw balances the lateral force, and the displacement, from which the
    difference of the radii comes, the yaw moment.
    """
    from scipy.optimize import brentq

    if "y" not in case.free:
        balance = _equations(case)
        return balance, _root(balance, solver)
    load = "yaw_moment" if "yaw" in case.free else "lateral_force"
    near: np.ndarray | None = None

    def at(y: float) -> tuple[_Balance, np.ndarray]:
        nonlocal near
        balance = _equations(replace(case, position=replace(case.position, y=y)), ("y", load))
        near = _root(balance, solver, near)
        return balance, near

    def net(y: float) -> float:
        """What moves the wheel set to the side, by the load."""
        balance, x = at(y)
        return balance.left_over(balance.wheels(x, solver))[load]

    y, pushed = case.position.y, net(case.position.y)
    sign = np.sign(pushed)
    while pushed * sign > 0:
        before, y = y, y + sign * WALK
        try:
            pushed = net(float(y))
        except (NoContact, SceneError, NotConverged):
            reason = f"{load}: no position bears the loads; beyond y = {before:.4g} mm a wheel climbs or falls"
            raise SceneError(load, getattr(case, load), message=reason) from None
    if pushed != 0:
        y = brentq(net, y - sign * WALK, y, xtol=1e-3 * SIDEWAYS)
    part, x = at(float(y))
    whole = _equations(replace(case, position=replace(case.position, y=float(y))))
    found = part.values(x) | {"y": float(y)}
    start = np.array([found[name] for name in whole.names])
    return whole, _root(whole, solver, (start - whole.origin) / whole.units)


def _root(balance: _Balance, solver: Solver, start: np.ndarray | None = None) -> np.ndarray:
    """Of the equations by the fast way; forces may jump a little where patches join."""
    from scipy.optimize import root

    own = np.zeros(len(balance.names))
    if not own.size:
        return own
    missed, why = math.inf, ""
    for begin, factor in ((start, 1.0), (own, 1.0), (own, 0.1)):  # until one succeeds
        if begin is None:
            continue
        options = {"factor": factor, "xtol": 1e-7, "eps": STEP**2}
        try:
            found = root(lambda x: balance.imbalance(balance.wheels(x, solver)), begin, options=options)
            missed = float(np.abs(found.fun).max())
        except (NoContact, SceneError) as error:
            why = f": {error}"
        if missed <= ROUGH:
            return np.asarray(found.x)
    words = _unbalanced(balance.case)
    raise NotConverged(words if np.isfinite(missed) else words + why, missed)


def _unbalanced(case: WheelSetOnTrack) -> str:
    """That a wheel set has no balance, and why that may be."""
    words = f"no balance was found at y = {case.position.y:.4g} mm, where"
    wheels = [case.wheel(side, 0.0) for side in SIGN]
    laws = [each.friction.static if isinstance(each.friction, Law) else each.friction_at(0.0) for each in wheels]
    bearable = (case.vertical_force or np.inf) * max(laws)
    for name, arm in (("torque", case.wheelset.radius), ("longitudinal_force", 1.0)):
        if abs(getattr(case, name)) > bearable * arm:
            return f"{words} {name} = {getattr(case, name):.4g} is more than friction bears, about {bearable * arm:.4g}"
    for wheel in wheels:
        radius, flange = wheel.locus.radii[wheel.locus.gap.argmin()], float(case.wheelset.profile.z.max())
        if radius > case.wheelset.radius + flange / 2:
            return f"{words} the {wheel.side} wheel stands on its rail with its flange"
    return f"{words} a wheel may climb, fall or be wedged"


def _equations(case: WheelSetOnTrack, without: tuple[str, str] = ("", "")) -> _Balance:
    """The unknowns and loads, without one of each if named; wheels are as deep in their rails as by Hertz."""
    radius, half, speed = case.wheelset.radius, case.wheelset.middle, case.velocity.speed
    stiffness = 4 / 3 * case.bodies.combined_G / (1 - case.bodies.combined_nu) * np.sqrt(radius)
    load, roll = case.vertical_force, case.position.roll
    if "roll" in case.free:
        level = case.moved({"roll": 0.0})
        left, right = (level.wheel(side, 0.0).touching for side in SIGN)
        roll = (right - left) / (2 * half)
    at = case.moved({"roll": roll})
    wheels = [at.wheel(side, 0.0) for side in SIGN]
    touching = [wheel.touching for wheel in wheels]
    rolling = float(np.mean([wheel.locus.radii[wheel.locus.gap.argmin()] for wheel in wheels]))
    for wheel in wheels:
        outwards, nearest = SIGN[wheel.side] * wheel.locus.points[:, 1], int(wheel.locus.gap.argmin())
        y = SIGN[wheel.side] * float(outwards[nearest])
        if outwards.max() - outwards[nearest] < EDGE:
            reason = f"the {wheel.side} wheel is on its outer end, at y = {y:.4g} mm, and falls between the rails"
            raise SceneError("position.y", case.position.y, message=reason)
    if load is None:
        assert case.z is not None
        load = 2 * stiffness * max(case.z - max(touching), 1e-3) ** 1.5
    depth = (load / 2 / stiffness) ** (2 / 3)
    slow = CREEPAGE * speed
    unknown = {  # where the search begins, and the unit
        "z": (float(np.mean(touching)) + depth, depth),
        "roll": (roll, depth / half),
        "y": (case.position.y, SIDEWAYS),
        "yaw": (case.position.yaw, CREEPAGE),
        "lateral": (case.velocity.lateral, slow),
        "yaw_rate": (case.velocity.yaw_rate, slow / half),
        "pitch_rate": (-speed / rolling, slow / radius),  # not what is given: creep forces may be saturated there
        "speed": (speed, slow),
    }
    names = (*(["z"] if case.z is None else []), *case.free)
    loads = tuple(BALANCED[name] for name in names if BALANCED[name] != without[1])
    names = tuple(name for name in names if name != without[0])
    if case.track.stiffness is not None:
        for side in SIGN:
            for name, each, pushed in zip("yz", case.track.stiffness, (0.0, load / 2), strict=True):
                names = (*names, f"{side}_{name}")
                unknown[f"{side}_{name}"] = pushed / each, depth
        unknown["z"] = unknown["z"][0] + load / 2 / case.track.stiffness[1], depth
    origin, units = np.array([unknown[name] for name in names]).reshape(-1, 2).T
    return _Balance(case, names, loads, load, float(depth), origin, units)
