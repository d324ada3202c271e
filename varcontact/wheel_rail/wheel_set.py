"""Wheel set on a track: loads, what is prescribed and what is free, and the balance of forces that
it reaches.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.scene.friction import Law
from varcontact.solving.selection import by_name
from varcontact.wheel_rail.regions import FrictionByAngle
from varcontact.wheel_rail.track import SIGN, Side
from varcontact.wheel_rail.wheel_geometry import OnTrack
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

if TYPE_CHECKING:
    from varcontact.solving.options import CertifyName
    from varcontact.theories.creep_forces import TheoryName
    from varcontact.wheel_rail.wheel_set_solution import WheelSetSolution

Friction = float | Law | FrictionByAngle
BALANCED = {
    "y": "lateral_force",
    "lateral": "lateral_force",
    "z": "vertical_force",
    "roll": "roll_moment",
    "yaw": "yaw_moment",
    "yaw_rate": "yaw_moment",
    "pitch_rate": "torque",
    "speed": "longitudinal_force",
}
"""The load that each free quantity comes to balance."""
LOADS = ("lateral_force", "longitudinal_force", "roll_moment", "yaw_moment", "torque")


@dataclass(frozen=True, eq=False, kw_only=True)
class WheelSetOnTrack(OnTrack, **dict.fromkeys(LOADS, checks.number)):
    """Both wheels of a wheel set on a track, under loads that the rails bear.

    Parameters
    ----------
    track : Track
    wheelset : WheelSet
    position, velocity : Position, Velocity, optional
        Those of the middle of the axle; where y is free, the search begins
        there.
    vertical_force, z : float
        Exactly one of the two: the load of the axle [N], or its height,
        downwards [mm].
    free : tuple of str
        Quantities found from the balance of loads: "y" or "lateral" (velocity) by
        the lateral force, "roll" by the roll moment, "yaw" or "yaw_rate" by the
        yaw moment, "pitch_rate" by the torque, or "speed" by the longitudinal
        force. All others are prescribed. "roll" and "pitch_rate" if not given:
        free rolling.
    lateral_force, longitudinal_force : float
        On the axle, to the right and forwards [N].
    roll_moment, yaw_moment, torque : float
        On the axle, along the axes of the wheel set: right side down, to the
        right, and about the axle [N mm]. As the pitch rate, the torque is
        negative where it drives the wheels forwards.
    friction : float, law, FrictionByAngle, or pair of them
        Of both rails, or of the left and the right one.
    bodies, dx, dy, join, separate, turn, conformal
        See `WheelOnRail`.

    Raises
    ------
    SceneError
        Naming the entry, its value and what is allowed.

    Examples
    --------
    >>> from varcontact.wheel_rail import Position, Profile, Track, WheelSet, WheelSetOnTrack
    >>> case = WheelSetOnTrack(
    ...     track=Track(rail=Profile.rail_60e1(), cant=1 / 40),
    ...     wheelset=WheelSet(wheel=Profile.s1002()),
    ...     position=Position(y=3.0), vertical_force=160e3)
    >>> found = case.estimate()
    >>> print(f"{found.left.force[2]:.0f} + {found.right.force[2]:.0f} N")
    78266 + 81734 N
    >>> print(f"roll {1e6 * found.position.roll:.0f} urad")
    roll -168 urad
    """

    free: tuple[str, ...] = ("roll", "pitch_rate")
    lateral_force: float = 0.0
    longitudinal_force: float = 0.0
    roll_moment: float = 0.0
    yaw_moment: float = 0.0
    torque: float = 0.0
    friction: Friction | tuple[Friction, Friction] = 0.3

    def __post_init__(self) -> None:
        checks.exactly_one(vertical_force=self.vertical_force, z=self.z)
        super().__post_init__()
        allowed = [name for name in BALANCED if name != "z"]
        given: Any = self.free
        if not isinstance(given, tuple | list):
            raise SceneError("free", given, f"a tuple of names: {', '.join(allowed)}")
        object.__setattr__(
            self, "free", tuple(checks.choice("free", each, allowed) for each in given)
        )
        loads = [BALANCED[name] for name in self.free]
        for name, load in zip(self.free, loads, strict=True):
            if loads.count(load) > 1:
                raise SceneError(
                    "free",
                    self.free,
                    f"one quantity for each load: {name} is not alone with {load}",
                )
        if {"pitch_rate", "speed"} <= set(self.free):
            raise SceneError("free", self.free, "pitch_rate or speed: only their ratio counts")
        for name in LOADS:
            if getattr(self, name) != 0 and name not in loads:
                balancing = [each for each, load in BALANCED.items() if load == name]
                reason = (
                    f"{name}: nothing is free to balance it; add {' or '.join(balancing)} to free"
                )
                raise SceneError(name, getattr(self, name), message=reason)
        self._check_frictionless()

    def _check_frictionless(self) -> None:
        """Without friction any pitch rate is that of free rolling; of the rest, y and roll alone
        are determined.
        """
        # their entries are checked
        without = [self.wheel(side, 0.0).friction == 0 for side in SIGN]
        if any(without) and not set(self.free) <= {"y", "roll", "pitch_rate"}:
            allowed = "y, roll or pitch_rate: nothing else is determined where friction = 0"
            raise SceneError("free", self.free, allowed)
        if all(without):
            if self.torque != 0:
                raise SceneError(
                    "torque", self.torque, "0 where friction = 0: nothing else balances it"
                )
            object.__setattr__(
                self, "free", tuple(name for name in self.free if name != "pitch_rate")
            )

    @checks.named_options()
    def wheel(self, side: Side, z: float) -> WheelOnRail:
        """The wheel on a `side`, with the axle at a height `z` [mm]."""
        friction: Any = self.friction
        if isinstance(friction, tuple | list):
            if len(friction) != 2:
                raise SceneError(
                    "friction",
                    friction,
                    "one for both rails, or a pair for the left and the right one",
                )
            friction = friction[side == "right"]
        same: dict[str, Any] = {each.name: getattr(self, each.name) for each in fields(OnTrack)}
        return WheelOnRail(side=side, friction=friction, **{**same, "vertical_force": None, "z": z})

    def moved(self, values: dict[str, float]) -> WheelSetOnTrack:
        """The case with other `values` of positions and velocities, and of rails moved sideways and
        down, by name.
        """
        at = {name: values[name] for name in ("y", "roll", "yaw") if name in values}
        moving = {
            name: values[name]
            for name in ("lateral", "yaw_rate", "pitch_rate", "speed")
            if name in values
        }
        track = self.track
        for side in SIGN:
            if f"{side}_y" in values:
                rail = getattr(track, side)
                y = rail.y + values[f"{side}_y"]
                z = rail.z + values[f"{side}_z"]
                track = replace(track, **{side: replace(rail, y=y, z=z)})
        position = replace(self.position, **at)
        velocity = replace(self.velocity, **moving)
        return replace(self, track=track, position=position, velocity=velocity)

    @checks.named_options(lambda given: checks.options_of(WheelOnRail.solve))
    def solve(
        self, *, tol: float = 1e-6, certify: CertifyName | None = None, **methods: Any
    ) -> WheelSetSolution:
        """Solve all patches of both wheels, with the positions and velocities
        that balance the loads.

        The search begins with the fast way, see `estimate`; from there a few
        exact solutions lead to the balance.

        Parameters
        ----------
        tol : float
            Largest imbalance: of forces by the load, of moments by the load and
            half the distance of the nominal circles, of the torque by the load
            and the radius. With grids chosen for an accuracy 1e-4 at least.
        certify : str, optional
            See `varcontact.solve`.
        **methods
            See `WheelOnRail.solve`: the default accuracy and its error bars
            are those of wheels, too. A `time_budget` is refused, as wheels are
            solved as often as the balance asks for.

        Raises
        ------
        NoContact, SceneError
            See `WheelOnRail.patches`; where the wheel set falls between the
            rails, a wheel leaves its rail, or no position bears the loads.
        NotConverged
            If a patch is not solved, or the balance is not found.
        """
        from varcontact.wheel_rail.wheel_set_balance import solve_wheel_set

        budget = methods.get("time_budget")
        if budget is not None:
            allowed = (
                "left out: wheels are solved as often as the balance asks for; "
                "give accuracy, or dx and dy"
            )
            raise SceneError("time_budget", budget, allowed)
        tol = checks.positive("tol", tol)
        return solve_wheel_set(self, tol, certify, by_name(methods))

    @checks.named_options(lambda given: checks.options_of(WheelOnRail.estimate))
    def estimate(
        self,
        normal: str = "virtual-penetration",
        tangential: TheoryName = "fastsim",
        *,
        tol: float = 1e-6,
        **options: Any,
    ) -> WheelSetSolution:
        """The balance by a fast theory on an ellipse for each patch.

        Parameters
        ----------
        normal, tangential, **options
            See `WheelOnRail.estimate`.
        tol : float
            Imbalance above which a warning is given.

        Raises
        ------
        NoContact, SceneError, NotConverged
            See `solve` and `WheelOnRail.estimate`.
        """
        from varcontact.wheel_rail.wheel_set_balance import estimate_wheel_set

        return estimate_wheel_set(self, normal, tangential, checks.positive("tol", tol), options)
