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
from varcontact.wheel_rail.virtual_penetration import FastEllipse, FastPatch
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail
from varcontact.wheel_rail.wheel_set_loads import BALANCED, LoadedWheelSet

STEP = 1e-3
"""Step of the differences for derivatives, relative to the unit of an unknown."""
CREEPAGE = 1e-3
"""Unit of velocities, divided by the speed, and of the yaw [rad]."""
SIDEWAYS = 0.1
"""Unit of the lateral displacement [mm]."""
EDGE = 10.0
"""Distance from the outer end of a wheel at which it counts as falling between the rails [mm]."""
ROLL_TOL = 1e-6
"""Tolerance of the roll at which both wheels touch [rad]."""
ROLL_STEPS = 8
"""Secant steps in the search for this roll."""
LONGEST_STEP = 10.0
"""Longest step of an unknown, relative to its unit."""
STEP_PARTS = (1.0, 0.5, 0.1)
"""Parts of a step that are tried in turn until the imbalance decreases."""
SLOW_FALL = 0.5
"""Ratio of imbalances in a step above which derivatives are computed again."""

Solver = Callable[[WheelOnRail], WheelForces]


@dataclass(frozen=True, eq=False)
class LoadBalance:
    """The equations of a case: unknowns by their names, and the units of both."""

    case: LoadedWheelSet
    names: tuple[str, ...]
    loads: tuple[str, ...]
    load: float
    depth: float
    origin: np.ndarray
    units: np.ndarray

    def values(self, x: np.ndarray) -> dict[str, float]:
        return dict(zip(self.names, (self.origin + self.units * x).tolist(), strict=True))

    def unknowns(self, values: dict[str, float]) -> np.ndarray:
        """Unknowns with these values, the others at their initial values."""
        begins = dict(zip(self.names, self.origin, strict=True))
        at = [values.get(name, begin) for name, begin in begins.items()]
        return (np.array(at) - self.origin) / self.units

    def wheels(self, x: np.ndarray, solver: Solver) -> tuple[WheelForces, WheelForces]:
        values = self.values(x)
        moved = self.case.moved(values)
        z = self.case.z
        if z is None:
            z = values["z"]
        wheels: list[WheelForces] = []
        for side in SIGN:
            wheel = moved.wheel(side, z)
            if wheel.touching < z:
                wheels.append(solver(wheel))
            else:
                wheels.append(self._above_rail(wheel, z))
        left, right = wheels
        return left, right

    def _above_rail(self, wheel: WheelOnRail, z: float) -> WheelForces:
        """Forces on a wheel above its rail: in the search a spring pulls it down."""
        arm = wheel.position.rotation @ [0.0, SIGN[wheel.side] * self.case.wheelset.middle, 0.0]
        centre = np.array([0.0, wheel.position.y, z - self.case.wheelset.radius])
        above = wheel.touching - z
        pull = np.array([0.0, 0.0, -self.load / 2 * above / self.depth])
        return WheelForces(wheel, z, (_patch_with(Frame(centre + arm, np.eye(3)), pull),))

    def left_over(self, wheels: tuple[WheelForces, WheelForces]) -> dict[str, float]:
        """Part of each load that the rails do not carry, relative to the axle load."""
        case = self.case
        left, right = wheels
        force = left.force + right.force
        moment = left.moment_on_wheelset + right.moment_on_wheelset
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
        """Imbalances of the loads, followed by those of flexible rails."""
        missing = self.left_over(wheels)
        imbalances = [missing[name] for name in self.loads]
        track = self.case.track
        if track.stiffness is not None:
            for each in wheels:
                at_rest = getattr(track, each.case.side)
                pushed = getattr(each.case.track, each.case.side)
                moved = np.array([pushed.y - at_rest.y, pushed.z - at_rest.z])
                imbalances += list((track.stiffness * moved - each.force[1:]) / self.load)
        return np.array(imbalances)

    def errors(
        self, left: WheelForces, right: WheelForces, inverse: np.ndarray
    ) -> dict[str, float]:
        """Errors of the unknowns, from the errors of the forces of each patch."""
        balanced = self.imbalance((left, right))
        total = np.zeros(len(self.names))
        for wheel in (left, right):
            for patch in wheel.patches:
                for error in np.diag(patch.error):
                    pushed = (*wheel.patches, _patch_with(patch.frame, error))
                    changed = WheelForces(wheel.case, wheel.z, pushed)
                    pair = (changed, right) if wheel is left else (left, changed)
                    total += np.abs(inverse @ (self.imbalance(pair) - balanced))
        return dict(zip(self.names, (self.units * total).tolist(), strict=True))


def _patch_with(frame: Frame, force: np.ndarray) -> FastPatch:
    """A patch with a force in its frame."""
    at_rest = Creepages(0.0, 0.0, 0.0, 1.0)
    point = FastEllipse(0.0, 0.0, 0.0, 0.0)
    nowhere = np.full(2, np.nan)
    return FastPatch(frame, 0.0, at_rest, 0.0, point, force, 0.0, nowhere, nowhere, np.nan)


def equations(case: LoadedWheelSet, held: tuple[str, ...] = ()) -> LoadBalance:
    """Unknowns and loads, without free quantities that are `held`; wheels are as deep as by
    Hertz.
    """
    radius = case.wheelset.radius
    half = case.wheelset.middle
    speed = case.velocity.speed
    stiffness = 4 / 3 * case.bodies.combined_G / (1 - case.bodies.combined_nu) * np.sqrt(radius)
    # both wheels on their rails
    roll = case.position.roll
    if "roll" in case.free:
        roll = _level(case)
    at = case.moved({"roll": roll})
    wheels = [at.wheel(side, 0.0) for side in SIGN]
    touching = [wheel.touching for wheel in wheels]
    rolling = float(np.mean([wheel.locus.radii[wheel.locus.gap.argmin()] for wheel in wheels]))
    _check_outer_ends(wheels)
    # the load of the axle, and the depth to which it presses wheels
    load = case.vertical_force
    if load is None:
        load = _load_at(case, max(touching), stiffness)
    depth = (load / 2 / stiffness) ** (2 / 3)
    # the unknowns
    slow = CREEPAGE * speed
    unknown = {  # where the search begins, and the unit
        "z": (float(np.mean(touching)) + depth, depth),
        "roll": (roll, depth / half),
        "y": (case.position.y, SIDEWAYS),
        "yaw": (case.position.yaw, CREEPAGE),
        "lateral": (case.velocity.lateral, slow),
        "yaw_rate": (case.velocity.yaw_rate, slow / half),
        # not that of the case: creep forces may be saturated there
        "pitch_rate": (-speed / rolling, slow / radius),
        "speed": (speed, slow),
    }
    names = [name for name in case.free if name not in held]
    if case.z is None:
        names.insert(0, "z")
    loads = tuple(BALANCED[name] for name in names)
    # rails that yield, and lower the axle
    if case.track.stiffness is not None:
        sideways, downwards = case.track.stiffness
        for side in SIGN:
            names += [f"{side}_y", f"{side}_z"]
            unknown[f"{side}_y"] = 0.0 / sideways, depth
            unknown[f"{side}_z"] = load / 2 / downwards, depth
        unknown["z"] = unknown["z"][0] + load / 2 / downwards, depth
    origin, units = np.array([unknown[name] for name in names]).reshape(-1, 2).T
    return LoadBalance(case, tuple(names), loads, load, float(depth), origin, units)


def _load_at(case: LoadedWheelSet, touching: float, stiffness: float) -> float:
    """Axle load at the height of the case, by Hertz's `stiffness` of both wheels below the height
    `touching`.
    """
    assert case.z is not None
    return 2 * stiffness * max(case.z - touching, 1e-3) ** 1.5


def _check_outer_ends(wheels: list[WheelOnRail]) -> None:
    """Refuse wheels of which one stands on its outer end and would fall between the rails."""
    for wheel in wheels:
        outwards = SIGN[wheel.side] * wheel.locus.points[:, 1]
        nearest = int(wheel.locus.gap.argmin())
        if outwards.max() - outwards[nearest] < EDGE:
            y = SIGN[wheel.side] * float(outwards[nearest])
            reason = (
                f"the {wheel.side} wheel is on its outer end, at y = {y:.4g} mm, "
                "and falls between the rails"
            )
            raise SceneError("position.y", wheel.position.y, message=reason)


def _level(case: LoadedWheelSet) -> float:
    """The roll at which both wheels touch their rails."""
    from scipy.optimize import root_scalar

    def higher(roll: float) -> float:
        level = case.moved({"roll": roll})
        left, right = (level.wheel(side, 0.0).touching for side in SIGN)
        return left - right

    first = -higher(0.0) / (2 * case.wheelset.middle)
    if abs(first) < ROLL_TOL:
        return first
    root = root_scalar(
        higher, x0=0.0, x1=first, method="secant", xtol=ROLL_TOL, maxiter=ROLL_STEPS
    ).root
    if abs(root) < STEEPEST:
        return float(root)
    return first


@dataclass(frozen=True, eq=False)
class BroydenIterate:
    """Unknowns with their imbalance and its derivatives."""

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
) -> BroydenIterate:
    """Iterate at which a root is found to `tol`, or from which no step decreases the imbalance.

    Broyden's method with steps that are shortened until the imbalance falls; derivatives are
    computed anew, by differences, where it falls too slowly.
    """
    at = BroydenIterate(start, imbalance(start), derivatives)
    for _ in range(rounds):
        if at.largest <= tol:
            break
        # derivatives by differences, where there are none that are good enough
        by_differences = at.derivatives is None
        if by_differences:
            at = BroydenIterate(at.x, at.imbalance, _differences(imbalance, at))
        # a step, which corrects them
        after = _step(imbalance, at)
        if after is None:
            if by_differences:
                break
            at = BroydenIterate(at.x, at.imbalance, None)
        elif not by_differences and after.largest > SLOW_FALL * at.largest:
            at = BroydenIterate(after.x, after.imbalance, None)
        else:
            at = after
    return at


def _differences(imbalance: Callable[[np.ndarray], np.ndarray], at: BroydenIterate) -> np.ndarray:
    steps = STEP * np.eye(at.x.size)
    return np.array([(imbalance(at.x + step) - at.imbalance) / STEP for step in steps]).T


def _step(
    imbalance: Callable[[np.ndarray], np.ndarray], at: BroydenIterate
) -> BroydenIterate | None:
    """The iterate after one step, None if the imbalance does not fall."""
    assert at.derivatives is not None
    step = -np.linalg.lstsq(at.derivatives, at.imbalance, rcond=1e-12)[0]
    step *= min(1.0, LONGEST_STEP / np.abs(step).max(initial=1e-300))
    for part in STEP_PARTS:
        moved = part * step
        try:
            after = imbalance(at.x + moved)
        except (NoContact, SceneError):  # beside the rail, or turned too far
            continue
        if np.linalg.norm(after) < np.linalg.norm(at.imbalance):
            off = after - at.imbalance - at.derivatives @ moved
            changed = at.derivatives + np.outer(off, moved) / (moved @ moved)
            return BroydenIterate(at.x + moved, after, changed)
    return None
