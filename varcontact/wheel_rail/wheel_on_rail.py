"""A wheel of a moving wheel set on a rail, which is solved, or estimated by a fast theory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from varcontact import checks
from varcontact.solving.methods import by_name
from varcontact.solving.options import CertifyName
from varcontact.solving.solve import solve
from varcontact.system.process import one_blas_thread
from varcontact.theories.creep_forces import TheoryName, theory_options
from varcontact.wheel_rail.result import WheelRailSolution
from varcontact.wheel_rail.solve import solve_wheel_on_rail
from varcontact.wheel_rail.virtual_penetration import FastWheel, estimate_wheel_on_rail
from varcontact.wheel_rail.wheel_geometry import WheelGeometry


def _of_solve(given: Mapping[str, Any]) -> tuple[str, ...]:
    return checks.options_of(solve)


def _of_theories(given: Mapping[str, Any]) -> list[str]:
    return ["slope", *theory_options()]


@dataclass(frozen=True, eq=False, kw_only=True)
class WheelOnRail(WheelGeometry):
    """A wheel of a wheel set on its rail.

    Parameters
    ----------
    track : Track
        Kept is that with the rails of the wheel's side, see `Track.of`.
    wheelset : WheelSet
    side : {"left", "right"}
        Which wheel, seen in the direction of travel.
    position : Position, optional
        In the middle of the track if not given.
    velocity : Velocity, optional
        Rolling along the track if not given.
    vertical_force, z : float
        Exactly one of the two: the load on this wheel [N], or the height of the
        axle, downwards, 0 where the nominal circles are at the height of the
        rail tops [mm].
    with_friction : bool
        Whether the vertical force is that of all forces on the wheel,
        tangential forces included, as in CONTACT. If False, it is that of the
        normal forces alone.
    bodies : Bodies, Viscoelastic, or a pair of them, optional
        In N/mm^2; a pair is (rail, wheel). Steel, G = 82 000 N/mm^2 and nu =
        0.28, if not given.
    friction : float, law or FrictionByAngle
        See `Scene`; by the inclination of the rail.
    slip_by_element : bool
        Whether patches in planes have the rigid slip of each element, and not
        the creepages at their origin; those on curved surfaces always have.
    third_body : ThirdBody, optional
        A layer between rail and wheel, see `Scene`.
    thermal : Thermal or pair (rail, wheel), optional
        Thermal data in N, mm, s and degrees, see `Scene`.
    dx, dy : float, optional
        Sides of an element [mm]: 0.5 mm if not given, unless `solve` chooses a
        grid for an accuracy.
    join, separate : float
        Overlaps of wheel and rail that are nearer to each other than `separate`
        make one patch, in one plane; others are patches of their own, which do
        not feel each other. Those nearer than `join` feel each other as parts
        of one half-space, and those between by a weight that falls from 1 to 0
        [mm].
    turn : float, optional
        The angles of patches that are nearer than this are turned towards each
        other, up to the angle of one patch at `separate`; ``2 separate - join``
        if not given [mm].
    conformal : "auto" or bool
        Whether patches are solved on a curved reference surface, halfway
        between the profiles, and not on planes, and those nearer than `turn` as
        one. "auto": where a plane is too flat for one of them, see
        `ConformalContact`.

    Raises
    ------
    SceneError
        Naming the entry, its value and what is allowed.

    Examples
    --------
    >>> from varcontact.wheel_rail import Position, Profile, Track, WheelOnRail, WheelSet
    >>> case = WheelOnRail(
    ...     track=Track(rail=Profile.rail_60e1(), cant=1 / 40),
    ...     wheelset=WheelSet(wheel=Profile.s1002()),
    ...     position=Position(y=3.0), vertical_force=80e3)
    >>> patch, = case.patches(case.touching + 0.05)
    >>> print(f"y = {patch.on_rail[0]:.1f} mm on the rail, {patch.on_wheel[0]:.1f} mm on the wheel")
    y = -12.6 mm on the rail, -12.6 mm on the wheel
    """

    @checks.named_options(_of_solve)
    @one_blas_thread()
    def solve(
        self, *, tol: float = 1e-6, certify: CertifyName | None = None, **methods: Any
    ) -> WheelRailSolution:
        """Solve all patches, with the height of the axle that carries the
        vertical force, where that is given.

        Parameters
        ----------
        tol : float
            Largest difference of the vertical force from the one that is given,
            relative. Where forces jump over it, as elements come into contact,
            up to 1e-3 is accepted.
        certify : str, optional
            See `varcontact.solve`: residuals alone if not given.
        **methods
            Other arguments of `varcontact.solve`, for all patches; `start` may
            be the solution of another position, near which this one is found
            sooner where there is a grid. With `accuracy` or `time_budget`, for
            which `dx` and `dy` are left out, grids are chosen, and the solution
            has errors. A theory as `tangential` is evaluated on Hertz's ellipse
            with the normal force of a patch and the second moments of its
            pressure.

        Raises
        ------
        NoContact, SceneError
            See `patches`, and if no equilibrium height exists: on a steep
            flange friction may carry more than the load.
        NotConverged
            If a patch is not solved, see `varcontact.solve`.
        """
        return solve_wheel_on_rail(self, tol, certify, by_name(methods))

    @checks.named_options(_of_theories)
    def estimate(
        self,
        normal: str = "virtual-penetration",
        tangential: TheoryName = "fastsim",
        *,
        tol: float = 1e-6,
        **options: Any,
    ) -> FastWheel:
        """Forces of a fast theory on an ellipse for each patch, see
        `varcontact.wheel_rail.virtual_penetration`.

        Parameters
        ----------
        normal : {"virtual-penetration", "analyn", "hertz"}
            Kik and Piotrowski's virtual penetration; after ANALYN, with the
            pressures of Hertz's problem of each strip; or Hertz's contact with
            the curvatures where the profiles touch.
        tangential : str
            A theory of `varcontact.creep_forces`.
        tol : float
            Largest difference of the vertical force from the one that is given,
            relative.
        **options
            Options of the theory, see `varcontact.creep_forces`. Patches at the flange
            are longer than the ellipses of "table": ``outside="clamp"`` takes
            the nearest it has.

        Raises
        ------
        NoContact, SceneError
            See `patches`; where a profile has no curvature for Hertz; for
            friction that is no number; for what the theory refuses.
        """
        return estimate_wheel_on_rail(self, normal, tangential, tol, options)
