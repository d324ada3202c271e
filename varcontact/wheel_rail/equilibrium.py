"""Equations of the balance of loads on a wheel set, and Broyden's method for them.

Unknown are the free positions and velocities, and how far rails yield. With
each wheel's height of the axle prescribed, forces are functions of them without
a search.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from varcontact.errors import NoContact, SceneError
from varcontact.kinematics import Creepages, Frame
from varcontact.wheel_rail.position import STEEPEST
from varcontact.wheel_rail.result import WheelForces
from varcontact.wheel_rail.track import SIGN
from varcontact.wheel_rail.virtual_penetration import Ellipse, FastPatch
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail
from varcontact.wheel_rail.wheel_set import BALANCED, WheelSetOnTrack

STEP = 1e-3
"""Of the differences for derivatives, by the unit of an unknown."""
CREEPAGE = 1e-3
"""Unit of velocities, by the speed, and of the yaw."""
SIDEWAYS = 0.1
"""Unit of the lateral displacement [mm]."""
EDGE = 10.0
"""Distance from the outer end of a wheel at which it falls between the rails [mm]."""
LEVEL, LEVELLED = 1e-6, 8
"""Error of the roll at which both wheels touch [rad], and steps to it."""
LONGEST = 10.0
"""Longest step of an unknown, by its unit."""
SHORTER = (1.0, 0.5, 0.1)
"""Parts of a step that are tried until the imbalance falls."""
SLOW = 0.5
"""Fall of the imbalance by a step from which on derivatives are computed anew."""

Solver = Callable[[WheelOnRail], WheelForces]


@dataclass(frozen=True, eq=False)
class Balance:
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

    def unknowns(self, values: dict[str, float]) -> np.ndarray:
        """The unknowns that have these values, the others as they begin."""
        found = [
            values.get(name, begin) for name, begin in zip(self.names, self.origin, strict=True)
        ]
        return (np.array(found) - self.origin) / self.units

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

    def errors(
        self, left: WheelForces, right: WheelForces, inverse: np.ndarray
    ) -> dict[str, float]:
        """Of the unknowns, from the errors of the forces of each patch."""
        felt = np.zeros(len(self.names))
        for wheel in (left, right):
            for patch in wheel.patches:
                for pushed in np.diag(patch.error):
                    changed = WheelForces(
                        wheel.case, wheel.z, (*wheel.patches, _patch_with(patch.frame, pushed))
                    )
                    pair = (changed, right) if wheel is left else (left, changed)
                    felt += np.abs(inverse @ (self.imbalance(pair) - self.imbalance((left, right))))
        return dict(zip(self.names, (self.units * felt).tolist(), strict=True))


def _patch_with(frame: Frame, force: np.ndarray) -> FastPatch:
    """A patch with a force in its frame."""
    return FastPatch(
        frame, 0.0, Creepages(0.0, 0.0, 0.0, 1.0), 0.0, Ellipse(0.0, 0.0, 0.0, 0.0), force, 0.0
    )


def equations(case: WheelSetOnTrack, held: tuple[str, ...] = ()) -> Balance:
    """Unknowns and loads, without free quantities that are `held`; wheels are as deep as by
    Hertz.
    """
    radius, half, speed = case.wheelset.radius, case.wheelset.middle, case.velocity.speed
    stiffness = 4 / 3 * case.bodies.combined_G / (1 - case.bodies.combined_nu) * np.sqrt(radius)
    load, roll = case.vertical_force, case.position.roll
    if "roll" in case.free:
        roll = _level(case)
    at = case.moved({"roll": roll})
    wheels = [at.wheel(side, 0.0) for side in SIGN]
    touching = [wheel.touching for wheel in wheels]
    rolling = float(np.mean([wheel.locus.radii[wheel.locus.gap.argmin()] for wheel in wheels]))
    for wheel in wheels:
        outwards, nearest = (
            SIGN[wheel.side] * wheel.locus.points[:, 1],
            int(wheel.locus.gap.argmin()),
        )
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
        # not what is given: creep forces may be saturated there
        "pitch_rate": (-speed / rolling, slow / radius),
        "speed": (speed, slow),
    }
    names = (*(["z"] if case.z is None else []), *case.free)
    names = tuple(name for name in names if name not in held)
    loads = tuple(BALANCED[name] for name in names)
    if case.track.stiffness is not None:
        for side in SIGN:
            for name, each, pushed in zip("yz", case.track.stiffness, (0.0, load / 2), strict=True):
                names = (*names, f"{side}_{name}")
                unknown[f"{side}_{name}"] = pushed / each, depth
        unknown["z"] = unknown["z"][0] + load / 2 / case.track.stiffness[1], depth
    origin, units = np.array([unknown[name] for name in names]).reshape(-1, 2).T
    return Balance(case, names, loads, load, float(depth), origin, units)


def _level(case: WheelSetOnTrack) -> float:
    """The roll at which both wheels touch their rails."""
    from scipy.optimize import root_scalar

    def higher(roll: float) -> float:
        level = case.moved({"roll": roll})
        left, right = (level.wheel(side, 0.0).touching for side in SIGN)
        return left - right

    first = -higher(0.0) / (2 * case.wheelset.middle)
    if abs(first) < LEVEL:
        return first
    found = root_scalar(higher, x0=0.0, x1=first, method="secant", xtol=LEVEL, maxiter=LEVELLED)
    return float(found.root) if abs(found.root) < STEEPEST else first


@dataclass(frozen=True, eq=False)
class Iterate:
    """Unknowns with what they leave out of balance, and derivatives of that."""

    x: np.ndarray
    imbalance: np.ndarray
    derivatives: np.ndarray | None

    @property
    def largest(self) -> float:
        return float(np.abs(self.imbalance).max(initial=0.0))


def broyden(
    imbalance: Callable[[np.ndarray], np.ndarray],
    start: np.ndarray,
    tol: float,
    rounds: int,
    derivatives: np.ndarray | None = None,
) -> Iterate:
    """The iterate at which a root is found to `tol`, or from which no step leads on.

    Broyden's method with steps that are shortened until the imbalance falls; derivatives are
    computed anew, by differences, where it falls too slowly.
    """
    at, fresh = Iterate(start, imbalance(start), derivatives), False
    for _ in range(rounds):
        if at.largest <= tol:
            break
        if at.derivatives is None:
            at, fresh = Iterate(at.x, at.imbalance, _differences(imbalance, at)), True
        after = _step(imbalance, at)
        if after is None and fresh:
            break
        if after is None or (not fresh and after.largest > SLOW * at.largest):
            at, fresh = Iterate((after or at).x, (after or at).imbalance, None), False
        else:
            at, fresh = after, False
    return at


def _differences(imbalance: Callable[[np.ndarray], np.ndarray], at: Iterate) -> np.ndarray:
    steps = STEP * np.eye(at.x.size)
    return np.array([(imbalance(at.x + step) - at.imbalance) / STEP for step in steps]).T


def _step(imbalance: Callable[[np.ndarray], np.ndarray], at: Iterate) -> Iterate | None:
    """The iterate after one step, None if the imbalance does not fall."""
    assert at.derivatives is not None
    step = -np.linalg.lstsq(at.derivatives, at.imbalance, rcond=1e-12)[0]
    step *= min(1.0, LONGEST / np.abs(step).max(initial=1e-300))
    for part in SHORTER:
        moved = part * step
        try:
            after = imbalance(at.x + moved)
        except (NoContact, SceneError):  # beside the rail, or turned too far
            continue
        if np.linalg.norm(after) < np.linalg.norm(at.imbalance):
            off = after - at.imbalance - at.derivatives @ moved
            changed = at.derivatives + np.outer(off, moved) / (moved @ moved)
            return Iterate(at.x + moved, after, changed)
    return None
