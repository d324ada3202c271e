"""Search for the balance of a wheel set, by the fast way.

Wherever a wheel set is held sideways and in yaw, height, roll and pitch rate
follow from the other loads. Left over there are a lateral force and a yaw
moment, whose root is bracketed, see `bracketing`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from varcontact.errors import NoContact, NotConverged, SceneError, warn
from varcontact.scene.friction import Law
from varcontact.theories.creep_forces import TheoryName
from varcontact.wheel_rail.bracketing import Lattice
from varcontact.wheel_rail.equilibrium import (
    CREEPAGE,
    BroydenIterate,
    LoadBalance,
    Solver,
    broyden,
    equations,
)
from varcontact.wheel_rail.position import Velocity
from varcontact.wheel_rail.result import WheelForces
from varcontact.wheel_rail.track import SIGN
from varcontact.wheel_rail.virtual_penetration import FastWheel, estimated, rolling
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail
from varcontact.wheel_rail.wheel_set_loads import BALANCED, LoadedWheelSet

ROUGH = 0.02
"""Largest imbalance of an estimate where forces of the fast theory jump, as patches merge."""
BEGINNING = 0.5
"""Largest imbalance at which exact solutions start, whose forces do not jump."""
SMOOTH = 1e-6
"""Largest imbalance where forces do not jump."""
HELD_TOL = 1e-4
"""Tolerance of the other loads where a wheel set is held."""
TOL = 1e-10
"""Tolerance of the imbalance at the end of the search."""
FAST_JUMPS = "forces of the fast way jump where patches join"
"""Why the fast way does not balance the loads."""
ROUNDS = 30
ATTEMPTS = 3
"""Largest number of times that the pitch rate is bracketed and the other unknowns are solved from
there."""
WIDER = 4.0
"""Growth factor of the steps to either side of rolling, until the torque changes sign."""
MOST_CREEP = 0.9
"""Largest relative difference from rolling: nearly locked, or spinning nearly twice as fast."""
SPACING_Y = 0.5
"""Spacing of the positions that are tried [mm]."""
SPACING_YAW = 5e-4
"""Spacing of the yaws that are tried [rad], and so of velocities relative to the speed."""
GROWTH = 6.0
"""Scale of the growth of the yaw spacing, in steps: ``GROWTH sinh(steps / GROWTH)``."""
FARTHEST_YAW = 0.06
"""Largest yaw that is tried [rad], and so velocity relative to the speed."""
LATTICES = (1.0, 400), (0.25, 20), (0.0625, 5)
"""Relative spacing of the lattices, and their reach in points: each is around the point with the
least imbalance of the one before."""
OFFSETS = (0.0, 0.05, -0.05)
"""Offsets from a point, in spacings, at which a wheel set is held where patches merge or separate,
and no height and roll balance the loads at the point itself."""
NEARBY = 3.0
"""Largest distance between the balance and the point where it was expected, in spacings."""
FIRST_STEP = 0.25
"""First step of height or roll to a sign change of its load, in the units of the unknowns."""
STEPS_MAX = 8
"""Largest number of such steps, each twice the one before."""
BRACKET = 1e-6
"""Length of the bracket around a sign change at which it ends, in the same units."""
PRESSED = 0.02
"""Increase of depth, relative to the depth, with which the force of a wheel on the rail must
grow."""


@dataclass(frozen=True)
class FastTheories:
    """Normal and tangential fast theory; a friction law may be replaced by its kinetic
    coefficient.
    """

    normal: str = "virtual-penetration"
    tangential: TheoryName = "fastsim"
    options: tuple[tuple[str, Any], ...] = ()
    kinetic: bool = False

    def __call__(self, wheel: WheelOnRail) -> FastWheel:
        law = wheel.friction
        if self.kinetic and isinstance(law, Law):
            wheel = replace(wheel, friction=law.kinetic or law.static)
        return estimated(wheel, self.normal, self.tangential, options=dict(self.options))

    def at_velocity(self, wheel: WheelForces, velocity: Velocity) -> WheelForces:
        """Wheel at the same place with another velocity; unchanged if it is above its rail."""
        if not isinstance(wheel, FastWheel):
            return wheel
        return rolling(wheel, self.tangential, dict(self.options), velocity)


@dataclass(frozen=True, eq=False)
class Held:
    """A wheel set held sideways and in yaw: values of what is free there, wheels that balance all
    other loads, and the loads left over.
    """

    values: dict[str, float]
    wheels: tuple[WheelForces, WheelForces]
    left_over: dict[str, float]


class Search:
    """Search for the balance of a case by fast theories, to an imbalance `rough` where their forces
    jump.
    """

    def __init__(self, case: LoadedWheelSet, theories: FastTheories, rough: float) -> None:
        self._case = case
        self._theories = theories
        self._rough = rough
        sideways = [name for name in case.free if name in ("y", "lateral")]
        turning = [name for name in case.free if name in ("yaw", "yaw_rate")]
        self._held_names = (*sideways, *turning)
        speed = case.velocity.speed
        self._spacing = {
            "y": SPACING_Y,
            "yaw": SPACING_YAW,
            "lateral": SPACING_YAW * speed,
            "yaw_rate": SPACING_YAW * speed / case.wheelset.middle,
        }
        places = {"y": case.position.y, "yaw": case.position.yaw}
        places |= {"lateral": case.velocity.lateral, "yaw_rate": case.velocity.yaw_rate}
        self._begin = {name: places[name] for name in self._held_names}
        # unknowns and derivatives of the wheel set held last, with which the next one begins
        self._last: np.ndarray | None = None
        self._derivatives: np.ndarray | None = None

    def found(self) -> tuple[LoadBalance, np.ndarray]:
        """Equations of all free quantities, and their root."""
        origin = np.zeros(len(self._held_names))
        begin = self._hold(origin)  # errors at the initial position are raised here
        if not self._held_names:
            whole = equations(self._case)
            return whole, self._root(whole, whole.unknowns(begin.values), TOL).x
        nearest = None
        balances: list[tuple[LoadBalance, BroydenIterate]] = []
        for spacing, reach in LATTICES:
            lattice = self._lattice(origin, spacing, reach)
            balances += self._on_lattice(lattice, origin, spacing)
            smooth = any(at.largest <= SMOOTH for _, at in balances)
            if smooth or lattice.nearest is None:
                break
            # a finer lattice around the point with the least imbalance
            number, point, missing = lattice.nearest
            origin = origin + spacing * point
            nearest = number, missing, self._values(origin)
        if not balances:
            raise self._refusal(nearest)
        whole, at = min(balances, key=lambda balance: balance[1].largest)
        return whole, at.x

    def _lattice(self, origin: np.ndarray, spacing: float, reach: int) -> Lattice:
        return Lattice(lambda point: self._left_over(origin + spacing * np.array(point)), reach)

    def _on_lattice(
        self, lattice: Lattice, origin: np.ndarray, spacing: float
    ) -> list[tuple[LoadBalance, BroydenIterate]]:
        """Balances on a lattice around an origin: those with jumping loads, until one without a
        jump is found.
        """
        balances: list[tuple[LoadBalance, BroydenIterate]] = []
        for point, last in lattice.brackets(len(self._held_names)):
            tol = self._rough if last else SMOOTH
            balanced = self._balanced(origin + spacing * point, tol)
            if balanced is None:
                continue
            balances.append(balanced)
            if balanced[1].largest <= SMOOTH:
                break
        return balances

    def _values(self, point: np.ndarray) -> dict[str, float]:
        """Values that the wheel set is held at, by the coordinates of a point on the lattice."""
        values = dict(self._begin)
        for name, steps in zip(self._held_names, point.tolist(), strict=True):
            if name != "y":  # spacing grows where friction is saturated
                steps = GROWTH * math.sinh(steps / GROWTH)
            values[name] += self._spacing[name] * steps
        return values

    def _left_over(self, point: np.ndarray) -> np.ndarray | None:
        """Unbalanced loads where the wheel set is held; None where it cannot be held."""
        values = self._values(point)
        most = FARTHEST_YAW / SPACING_YAW
        for name in self._held_names:
            if name != "y" and abs(values[name]) > most * self._spacing[name]:
                return None
        held = self._held_near(point)
        if held is None or any(map(_on_flange_alone, held.wheels)):
            return None
        return np.array([held.left_over[BALANCED[name]] for name in self._held_names])

    def _held_near(self, point: np.ndarray) -> Held | None:
        """Wheel set held at a point, or beside it if forces jump there; None where it
        cannot be held.
        """
        for offset in OFFSETS:
            try:
                return self._hold(point + offset)
            except NotConverged:
                continue
            except (NoContact, SceneError):
                return None
        return None

    def _hold(self, point: np.ndarray) -> Held:
        """Wheel set held at a point, from the last one held or else from rolling wheels."""
        balance = equations(self._case.moved(self._values(point)), self._held_names)
        spun = next((name for name in ("pitch_rate", "speed") if name in balance.names), None)
        # start from the last held wheel set
        at: BroydenIterate | None = None
        if self._last is not None:
            at = self._root(balance, self._last, HELD_TOL, self._derivatives)
        # start from rolling wheels
        if at is None or at.largest > HELD_TOL:
            x = np.zeros(len(balance.names))
            for _ in range(ATTEMPTS):
                x = self._rolling(balance, x, spun)
                at = self._root(balance, x, HELD_TOL)
                if at.largest <= HELD_TOL:
                    break
                x = at.x
        assert at is not None
        # from the height and the roll at which their loads change sign
        if at.largest > HELD_TOL:
            with suppress(NoContact, SceneError):  # a wheel beside its rail, or turned too far
                x = self._rolling(balance, self._bracketed(balance, at.x), spun)
                bracketed = self._root(balance, x, HELD_TOL)
                at = min(at, bracketed, key=lambda iterate: iterate.largest)
        if at.largest > self._rough:
            raise NotConverged(unbalanced(balance, at.imbalance), at.largest)
        self._last = at.x
        self._derivatives = at.derivatives
        wheels = balance.wheels(at.x, self._theories)
        return Held(balance.values(at.x), wheels, balance.left_over(wheels))

    def _root(
        self, balance: LoadBalance, x: np.ndarray, tol: float, derivatives: np.ndarray | None = None
    ) -> BroydenIterate:
        return broyden(
            lambda x: balance.imbalance(balance.wheels(x, self._theories)),
            x,
            tol,
            ROUNDS,
            derivatives,
        )

    def _rolling(self, balance: LoadBalance, x: np.ndarray, name: str | None) -> np.ndarray:
        """Unknowns with the pitch rate, or speed, that balances its load while both wheels keep
        their places.

        From locked to spinning wheels the torque falls all the way.
        """
        from scipy.optimize import brentq

        if name is None:
            return x
        pair = balance.wheels(x, self._theories)
        pure = balance.values(balance.unknowns({}))[name]

        def left_over(creep: float) -> float:
            velocity = replace(balance.case.velocity, **{name: pure * (1 + creep)})
            left, right = (self._theories.at_velocity(wheel, velocity) for wheel in pair)
            return balance.left_over((left, right))[BALANCED[name]]

        # a bracket, moved away from the end with the larger imbalance
        step = CREEPAGE
        low = -step
        high = step
        below = left_over(low)
        above = left_over(high)
        while below * above > 0 and step < MOST_CREEP:
            step = min(WIDER * step, MOST_CREEP)
            if abs(below) < abs(above):
                high = low
                above = below
                low = -step
                below = left_over(low)
            else:
                low = high
                below = above
                high = step
                above = left_over(high)
        # the root in it, or else the end with the smaller imbalance
        if below * above <= 0:
            creep = float(brentq(left_over, low, high, xtol=1e-7))
        elif abs(below) < abs(above):
            creep = low
        else:
            creep = high
        return balance.unknowns(balance.values(x) | {name: pure * (1 + creep)})

    def _bracketed(self, balance: LoadBalance, x: np.ndarray) -> np.ndarray:
        """Unknowns with the roll at which the roll moment changes sign, and at each roll the height
        at which the vertical force does; unchanged where these are not free.
        """

        def missing(x: np.ndarray, load: str) -> float:
            return balance.left_over(balance.wheels(x, self._theories))[load]

        def with_height(x: np.ndarray) -> np.ndarray:
            if "z" not in balance.names:
                return x
            return _with_sign_change(
                x, balance.names.index("z"), lambda moved: missing(moved, "vertical_force")
            )

        if "roll" not in balance.names:
            return with_height(x)
        rolled = _with_sign_change(
            x, balance.names.index("roll"), lambda x: missing(with_height(x), "roll_moment")
        )
        return with_height(rolled)

    def _balanced(self, point: np.ndarray, tol: float) -> tuple[LoadBalance, BroydenIterate] | None:
        """Equations with all loads balanced near a point to a `tol`, and their solution; None if
        there is none.
        """
        try:
            held = self._hold(point)
            values = self._values(point)
            whole = equations(self._case.moved(values))
            at = self._root(whole, whole.unknowns(values | held.values), TOL)
        except (NoContact, NotConverged, SceneError):
            return None
        if not at.largest <= tol:
            return None
        balanced = whole.values(at.x)
        for name in self._held_names:
            if not abs(balanced[name] - values[name]) <= NEARBY * self._spacing[name]:
                return None
        return whole, at

    def _refusal(self, nearest: tuple[int, float, dict[str, float]] | None) -> SceneError:
        """Error where no position balances the loads, with the imbalance of the nearest one."""
        load = BALANCED[self._held_names[0]]
        words = "no position balances the loads"
        if nearest is not None:
            number, missing, values = nearest
            load = BALANCED[self._held_names[number]]
            places = ", ".join(f"{name} = {value:.4g}" for name, value in values.items())
            remainder = short(equations(self._case), load, missing)
            words += f": at the nearest one, {places}, {remainder}"
        return SceneError(load, getattr(self._case, load), message=words)


def _with_sign_change(x: np.ndarray, k: int, missing: Callable[[np.ndarray], float]) -> np.ndarray:
    """Unknowns with the k-th one where a missing load, which falls as that grows, changes sign, as
    at a jump; unchanged where it does not.
    """
    from scipy.optimize import brentq

    def at(value: float) -> float:
        moved = x.copy()
        moved[k] = value
        return missing(moved)

    value = float(x[k])
    load = at(value)
    step = math.copysign(FIRST_STEP, load)
    for _ in range(STEPS_MAX):
        after = at(value + step)
        if load * after <= 0:
            moved = x.copy()
            moved[k] = brentq(at, value, value + step, xtol=BRACKET)
            return moved
        value += step
        load = after
        step *= 2
    return x


def on_flange(wheel: WheelOnRail) -> bool:
    """True if a wheel stands on its rail with the lower half of its flange."""
    radius = wheel.locus.radii[wheel.locus.gap.argmin()]
    return bool(radius > wheel.wheelset.radius + wheel.wheelset.profile.z.max() / 2)


def _on_flange_alone(wheel: WheelForces) -> bool:
    """True if the lower half of a wheel's flange carries all of its load."""
    half = wheel.case.wheelset.profile.z.max() / 2
    return all(patch.on_wheel[1] > half for patch in wheel.patches)


def unbalanced(balance: LoadBalance, imbalance: np.ndarray) -> str:
    """Sentence on the largest imbalance of a wheel set without balance, and on its cause if
    known.
    """
    case = balance.case
    words = f"no balance was found at y = {case.position.y:.4g} mm, where"
    wheels = [case.wheel(side, 0.0) for side in SIGN]
    # loads beyond the friction limit
    limit = (case.vertical_force or np.inf) * max(_static_friction(each) for each in wheels)
    limits = {"torque": limit * case.wheelset.radius, "longitudinal_force": limit * 1.0}
    for name, largest in limits.items():
        load = getattr(case, name)
        if abs(load) > largest:
            return f"{words} {name} = {load:.4g} exceeds the friction limit, about {largest:.4g}"
    # the load with the largest imbalance; flexible rails come after the loads
    k = int(np.abs(imbalance).argmax())
    missing = "a rail yields"
    if k < len(balance.loads):
        missing = short(balance, balance.loads[k], float(imbalance[k]))
    for wheel in wheels:
        if on_flange(wheel):
            return f"{words} {missing}: the {wheel.side} wheel stands on its rail with its flange"
    return f"{words} {missing}"


def _static_friction(wheel: WheelOnRail) -> float:
    if isinstance(wheel.friction, Law):
        return wheel.friction.static
    return wheel.friction_at(0.0)


def short(balance: LoadBalance, load: str, missing: float) -> str:
    """Sentence on the missing part of a load; `missing` is relative to the axle load, and for a
    moment also to its arm.
    """
    middle = balance.case.wheelset.middle
    arms = {"roll_moment": middle, "yaw_moment": middle, "torque": balance.case.wheelset.radius}
    if load not in arms:
        return f"the {load} is short by {missing * balance.load:.4g} N"
    return f"the {load} is short by {missing * balance.load * arms[load]:.4g} N mm"


def balanced_wheels(
    balance: LoadBalance, x: np.ndarray, solver: Solver
) -> tuple[WheelForces, WheelForces]:
    """The left and the right wheel at the balance; refused where one is above its rail, or
    wedged.
    """
    wheels = balance.wheels(x, solver)
    for each in wheels:
        if each.case.touching >= each.z:
            raise _above_rail(balance.case, each.case)
        _check_pressed(each, PRESSED * balance.depth)
    left, right = wheels
    return left, right


def warn_unbalanced(imbalance: float, tol: float, cause: str = FAST_JUMPS) -> None:
    """Warn of loads that are not balanced to a `tol`."""
    if imbalance > tol:
        warn(f"loads are balanced to {imbalance:.2g} only: {cause}")


def _above_rail(case: LoadedWheelSet, wheel: WheelOnRail) -> SceneError:
    """The error of a wheel that does not touch its rail at the balance."""
    if "roll" not in case.free:
        roll = case.position.roll
        reason = (
            f"with roll = {roll:.4g} the {wheel.side} wheel is above its rail; add roll to free"
        )
        return SceneError("position.roll", roll, message=reason)
    reason = f"the loads lift the {wheel.side} wheel off its rail: no position balances them"
    return SceneError("roll_moment", case.roll_moment, message=reason)


def _check_pressed(wheel: WheelForces, step: float) -> None:
    """Refuse a wheel whose vertical force falls when it is pressed in by a step [mm]."""
    deeper = replace(wheel.case, z=wheel.z + step)
    fast = FastTheories(kinetic=True)
    if fast(deeper).force[2] < fast(wheel.case).force[2]:
        reason = (
            f"the {wheel.case.side} wheel is wedged: friction lifts it when pressed in; "
            "give another position"
        )
        raise SceneError("position.y", wheel.case.position.y, message=reason)
