"""Wheel set on a track, which is solved, or estimated by a fast theory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.solving.methods import by_name
from varcontact.solving.options import CertifyName
from varcontact.theories.creep_forces import TheoryName
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail
from varcontact.wheel_rail.wheel_set_balance import estimate_wheel_set, solve_wheel_set
from varcontact.wheel_rail.wheel_set_loads import LoadedWheelSet
from varcontact.wheel_rail.wheel_set_solution import WheelSetSolution


@dataclass(frozen=True, eq=False, kw_only=True)
class WheelSetOnTrack(LoadedWheelSet):
    """Both wheels of a wheel set on a track, under loads that the rails bear.

    Parameters
    ----------
    track : Track
    wheelset : WheelSet
    position, velocity : Position, Velocity, optional
        Position and velocity of the middle of the axle; where y is free, the search begins
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
        Friction on both rails, or on the left and the right one.
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
            Where forces jump, as elements come into contact, up to 1e-3 is
            accepted, with a warning.
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
            rails, a wheel leaves its rail, or no position balances the loads.
        NotConverged
            If a patch is not solved, or the balance is not found.
        """
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
        return estimate_wheel_set(self, normal, tangential, checks.positive("tol", tol), options)
