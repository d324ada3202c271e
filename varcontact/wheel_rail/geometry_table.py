"""Geometry of a wheel set on straight track: contacts tabulated over lateral
displacement and yaw, with the forces of fast theories; rolling radius
difference and equivalent conicity as in EN 15302.

For the conicity wheels and rails are rigid, and the axle is level and square to
the track. Displaced by y, the wheel set turns towards the smaller radius, so
that along the distance rolled

    y'' = -(r_right(y) - r_left(y)) / (e R),

with the distance e of the nominal circles and their radius R. The equivalent
conicity for an amplitude is that of the cones whose motion, Klingel's, is as
long a wave: ``2 e R (pi / wavelength)^2``.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import NoContact, NotConverged, SceneError, VarcontactError
from varcontact.reference.creepage_coefficients import no_slip_coefficients
from varcontact.scene.bodies import Bodies
from varcontact.theories.creep_forces import TheoryName, elastic, formula_of, theory_options
from varcontact.theories.linear import Contact
from varcontact.wheel_rail.locus import contact_locus
from varcontact.wheel_rail.position import Position, Velocity, check_forward
from varcontact.wheel_rail.track import SIGN, Irregularity, Side, Track, WheelSet
from varcontact.wheel_rail.wheel_geometry import STEEL
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

SLOTS = 3
"""Patches of a wheel that are tabulated at most."""
COLUMNS = 8
"""Figures of a patch, see `WheelSetForces`."""
GROWTH = np.array([1 / 3, 1 / 3, 1.0, 2 / 3])
"""Powers of the force with which a, b, the force itself and the approach of Hertz's contact
grow."""
MIRRORED = np.array([1.0, -1.0, 1.0, -1.0, 1.0, 1.0, 1.0, 1.0])
STEP = 0.05
"""Distance of displacements whose rolling radius difference is computed [mm]; between them it is
linear."""
PHASES = 400
"""Points of a quarter of a wave."""


@dataclass(frozen=True, eq=False)
class WheelSetForces:
    """Forces of the rails on a wheel set.

    Attributes
    ----------
    force : ndarray, shape (3,)
        Along x, y, z of the track [N].
    moment : ndarray, shape (3,)
        About the middle of the axle, along x, y, z of the track [N mm].
    patches : ndarray, shape (n, 8)
        Of the contacts, from the left wheel's to the right's: x, y, z [mm],
        angle [rad], a, b [mm], normal force [N], approach [mm].
    creepages : ndarray, shape (n, 3)
        vx, vy [-] and spin [1/mm] of each.
    creep_forces : ndarray, shape (n, 2)
        Fx, Fs on the rail in the contact frame [N].
    """

    force: np.ndarray
    moment: np.ndarray
    patches: np.ndarray
    creepages: np.ndarray
    creep_forces: np.ndarray


@dataclass(frozen=True, eq=False)
class GeometryTable:
    """Contacts of the right wheel over lateral displacement and yaw; those of
    the left are mirror images.

    Between the nodes all is linear in both, and then the forces grow or shrink,
    and their ellipses as Hertz's, until the normal forces of each wheel bear
    the load; where the nodes around a position have different numbers of
    patches, the nearest node counts; at nodes without contact z and patches are
    NaN, and their count is 0. The roll about x that this takes counts in
    the height of each wheel, not in the shape of its contact.

    Attributes
    ----------
    y, yaw : ndarray
        Nodes, ascending [mm] and [rad].
    z : ndarray, shape (ny, nyaw)
        Height of the axle at the nodes [mm].
    count : ndarray of int, shape (ny, nyaw)
        Patches.
    patches : ndarray, shape (ny, nyaw, 3, 8)
        As of `WheelSetForces`.
    wheelset : WheelSet
    bodies : Bodies
    friction : float
    """

    y: np.ndarray
    yaw: np.ndarray
    z: np.ndarray
    count: np.ndarray
    patches: np.ndarray
    wheelset: WheelSet
    bodies: Bodies
    friction: float

    __repr__ = checks.short_entries

    @checks.named_options()
    def contacts(self, y: float, yaw: float, side: Side) -> tuple[float, np.ndarray]:
        """Height of the axle and the contacts of a wheel.

        Parameters
        ----------
        y, yaw : float
            [mm] and [rad]
        side : {"left", "right"}

        Returns
        -------
        z : float
            [mm]
        patches : ndarray, shape (n, 8)

        Raises
        ------
        SceneError
            If the position is not within the table.
        NoContact
            If the wheel has no contact at the nodes that count there.
        """
        checks.choice("side", side, tuple(SIGN))
        sign = SIGN[side]
        (i, s), (j, t) = _cell("y", self.y, y, sign), _cell("yaw", self.yaw, yaw, sign)
        four = slice(i, i + 2), slice(j, j + 2)
        z, counts, nodes = (
            self.z[four].ravel(),
            self.count[four].ravel(),
            self.patches[four].reshape(4, SLOTS, COLUMNS),
        )
        weights = np.array([(1 - s) * (1 - t), (1 - s) * t, s * (1 - t), s * t])
        if np.ptp(counts) > 0:
            nearest = [2 * round(s) + round(t)]
            z, counts, nodes, weights = z[nearest], counts[nearest], nodes[nearest], np.ones(1)
        if counts[0] == 0:
            reason = f"y = {y:g} mm, yaw = {yaw:g}: the {side} wheel has no contact there, see the warning of the table"
            raise NoContact("y", y, message=reason)
        load = weights @ (nodes[..., 6] * np.cos(nodes[..., 3])).sum(axis=-1)
        found = np.tensordot(weights, nodes[:, : counts[0]], 1)
        found[:, 4:] *= (load / float(found[:, 6] @ np.cos(found[:, 3]))) ** GROWTH
        return float(weights @ z), found * MIRRORED if side == "left" else found

    @checks.named_options(lambda given: theory_options())
    def forces(
        self,
        y: float,
        yaw: float,
        velocity: Velocity,
        theory: TheoryName = "fastsim",
        **options: Any,
    ) -> WheelSetForces:
        """Forces of both rails on the wheel set.

        Parameters
        ----------
        y, yaw : float
            [mm] and [rad]
        velocity : Velocity
        theory : str
            Of `varcontact.creep_forces`, with a moment.
        **options
            Of the theory: ``outside="clamp"`` of "table", as for
            `WheelOnRail.estimate`.

        Raises
        ------
        SceneError
            See `contacts`; for a wheel that does not roll forwards, a theory
            without a moment, and for what the theory refuses.
        """
        checks.kind("velocity", velocity, Velocity)
        sides = [self.contacts(y, yaw, side) for side in ("left", "right")]
        patches, radius = np.concatenate([found for _, found in sides]), self.wheelset.radius
        # each wheel at its own height: of the roll that takes, this is what counts in the creepages
        axle = [[0.0, y, z - radius] for z, found in sides for _ in found]
        cosine, sine, nothing = np.cos(patches[:, 3]), np.sin(patches[:, 3]), np.zeros(len(patches))
        lateral, inwards = np.array([nothing, cosine, sine]).T, np.array([nothing, -sine, cosine]).T
        arms = patches[:, :3] - axle
        # as `WheelOnRail.creepage`, of the particles at the depth of the approach
        deep = arms + patches[:, 7:] * inwards
        pitch = -velocity.speed / radius if velocity.pitch_rate is None else velocity.pitch_rate
        turning = np.array(
            [velocity.roll_rate - pitch * np.sin(yaw), pitch * np.cos(yaw), velocity.yaw_rate]
        )
        particle = np.array([velocity.speed, velocity.lateral, velocity.vertical]) + np.cross(
            turning, deep
        )
        speed = velocity.speed - velocity.yaw_rate * deep[:, 1] - particle[:, 0] / 2
        check_forward(float(speed.min()))
        vx, vy, spin = rolled = (
            -np.array([particle[:, 0], (particle * lateral).sum(axis=1), inwards @ turning]) / speed
        )
        formula, (G, nu) = formula_of(theory, options), elastic(self.bodies, None, None)
        a, b, normal = patches[:, 4:7].T
        coefficients = no_slip_coefficients(a / b, nu)
        Fx, Fy, Mz = formula(
            Contact(a, b, G, nu, self.friction * normal, vx, vy, spin, 1.0, coefficients), **options
        )
        if np.isnan(Mz).any():
            raise SceneError("theory", theory, "a theory with a moment, such as fastsim or table")
        on_wheel = -(normal[:, None] * inwards + Fy[:, None] * lateral)
        on_wheel[:, 0] = -Fx
        moment = np.cross(arms, on_wheel) - Mz[:, None] * inwards
        return WheelSetForces(
            on_wheel.sum(axis=0), moment.sum(axis=0), patches, rolled.T, np.array([Fx, Fy]).T
        )


@checks.named_options()
def geometry_table(
    track: Track,
    wheelset: WheelSet,
    *,
    y: Any,
    yaw: Any,
    vertical_force: float,
    friction: float = 0.3,
    bodies: Bodies = STEEL,
    normal: str = "virtual-penetration",
    progress: Callable[[str], None] | None = None,
) -> GeometryTable:
    """Tabulate the contacts of a wheel set by `WheelOnRail.estimate`.

    Parameters
    ----------
    track : Track
    wheelset : WheelSet
    y, yaw : array_like
        Nodes, two or more, ascending and symmetric about 0 [mm] and [rad].
    vertical_force : float
        Of the normal forces on each wheel [N]: creep forces, which depend on
        the velocity, come on top of it.
    friction : float
    bodies : Bodies
    normal : {"virtual-penetration", "analyn", "hertz"}
        Which ellipse stands for a patch, see `WheelOnRail.estimate`.
    progress : callable, optional
        Told how far it is.

    Raises
    ------
    SceneError
        For nodes that are not so, and where `WheelOnRail` refuses all of them;
        of those that it refuses a warning says how many, and the first.

    Examples
    --------
    >>> from varcontact.wheel_rail import Profile
    >>> table = geometry_table(
    ...     Track(rail=Profile.rail_60e1(), cant=1 / 40), WheelSet(wheel=Profile.s1002()),
    ...     y=[-2.0, -1.0, 0.0, 1.0, 2.0], yaw=[-0.01, 0.0, 0.01], vertical_force=50e3)
    >>> pushed = table.forces(1.5, 0.0, Velocity(speed=20e3))
    >>> print(f"{pushed.force[1]:.0f} N, {pushed.moment[2] / 1e3:.0f} N m")
    -771 N, -7749 N m
    """
    checks.kind("track", track, Track)
    if not track.constant or not wheelset.constant:
        raise SceneError("track", track, "one profile along the track, and a round wheel")
    if np.isfinite(track.curve_radius) or not track.left == track.right == Irregularity():
        reason = "track: a table is of straight, even track; in a curve add speed / curve_radius to the yaw rate"
        raise SceneError("track", track.curve_radius, message=reason)
    nodes, coefficient = [_nodes("y", y), _nodes("yaw", yaw)], checks.positive("friction", friction)
    report = checks.progress(progress)
    shape = nodes[0].size, nodes[1].size
    z, count, patches = (
        np.full(shape, np.nan),
        np.zeros(shape, dtype=int),
        np.full((*shape, SLOTS, COLUMNS), np.nan),
    )
    without: list[tuple[float, float, VarcontactError]] = []
    for i, j in np.ndindex(shape):
        report(f"{i * shape[1] + j} of {shape[0] * shape[1]} positions")
        at = float(nodes[0][i]), float(nodes[1][j])
        case = WheelOnRail(
            track=track,
            wheelset=wheelset,
            position=Position(y=at[0], yaw=at[1]),
            vertical_force=vertical_force,
            with_friction=False,
            friction=friction,
            bodies=bodies,
        )
        try:
            found = case.estimate(normal)
        except (SceneError, NotConverged) as error:
            without.append((*at, error))
            continue
        if len(found.patches) > SLOTS:
            warnings.warn(
                f"of {len(found.patches)} patches, the {SLOTS} with the largest force count",
                stacklevel=3,
            )
        largest = sorted(found.patches, key=lambda each: -each.force[2])[:SLOTS]
        kept = sorted(largest, key=lambda each: each.frame.origin[1])
        z[i, j], count[i, j], patches[i, j] = found.z, len(kept), 0.0
        for k, each in enumerate(kept):
            ellipse = each.ellipse
            sizes = ellipse.a, ellipse.b, ellipse.normal_force, each.approach
            patches[i, j, k] = [*each.frame.origin, each.angle, *sizes]
    if len(without) == count.size:
        raise without[0][-1]
    if without:
        first_y, first_yaw, first = without[0]
        where = f"the first at y = {first_y:g} mm, yaw = {first_yaw:g}"
        warnings.warn(
            f"{len(without)} of {count.size} nodes have no contact, {where}: {first}", stacklevel=3
        )
    return GeometryTable(nodes[0], nodes[1], z, count, patches, wheelset, bodies, coefficient)


def _nodes(field: str, value: Any) -> np.ndarray:
    nodes = checks.array(field, value, 1)
    if (
        nodes.size < 2
        or (np.diff(nodes) <= 0).any()
        or not np.allclose(nodes, -nodes[::-1], atol=1e-12)
    ):
        raise SceneError(field, value, "two nodes or more, ascending, and symmetric about 0")
    return nodes


def _cell(field: str, nodes: np.ndarray, given: float, sign: float) -> tuple[int, float]:
    """The interval of a value, mirrored for the left wheel, and where in it the value is, from 0 to
    1.
    """
    value = sign * checks.number(field, given)
    if not nodes[0] <= value <= nodes[-1]:
        raise SceneError(field, given, f"within the table, {nodes[0]:g} to {nodes[-1]:g}")
    i = min(int(nodes.searchsorted(value, side="right")) - 1, nodes.size - 2)
    return i, float((value - nodes[i]) / (nodes[i + 1] - nodes[i]))


@checks.named_options()
def rolling_radius_difference(track: Track, wheelset: WheelSet, y: Any) -> Any:
    """Rolling radius of the right wheel less that of the left, both where they touch first.

    Parameters
    ----------
    track : Track
    wheelset : WheelSet
    y : float or array_like
        Lateral displacements, to the right [mm].

    Returns
    -------
    float or ndarray
        In the shape of y [mm].

    Raises
    ------
    SceneError
        If a displacement is not finite, or the wheels touch at the end of a
        profile.
    NoContact
        If a wheel is beside the rail.

    Examples
    --------
    >>> from varcontact.wheel_rail import Profile
    >>> track, wheelset = Track(rail=Profile.rail_60e1(), cant=1 / 40), WheelSet(wheel=Profile.s1002())
    >>> print(rolling_radius_difference(track, wheelset, [0.0, 1.0, 3.0, 5.0]).round(2))
    [0.   0.61 0.94 1.45]
    """
    checks.kind("track", track, Track)
    checks.kind("wheelset", wheelset, WheelSet)
    places = checks.numbers("y", y)
    wheel, rail, radii = wheelset.placed("right"), track.placed("right"), {}
    for each in {*places.flat, *(-places).flat}:
        locus = contact_locus(wheel, rail, np.eye(3), np.array([0.0, each, -wheelset.radius]))
        gap, nearest = np.pad(locus.gap, 1, constant_values=np.inf), int(locus.gap.argmin())
        before, least, after = gap[nearest : nearest + 3]
        if not np.isfinite(before + after):
            raise SceneError(
                "y", each, message=f"y = {each:g} mm: the wheel touches at the end of a profile"
            )
        # at the lowest point of a parabola through the nearest circles
        step, bend = locus.s[nearest] - locus.s[nearest - 1], before - 2 * least + after
        beside = step * (before - after) / (2 * bend) if bend > 0 else 0.0
        radii[each] = float(wheel.points(locus.s[nearest] + beside)[1])
    found = np.array([radii[each] - radii[-each] for each in places.flat]).reshape(places.shape)
    return found if found.ndim else float(found)


@checks.named_options()
def equivalent_conicity(track: Track, wheelset: WheelSet, amplitude: Any) -> Any:
    """The conicity of the wheel set whose motion is as long a wave, by EN 15302.

    Parameters
    ----------
    track : Track
    wheelset : WheelSet
    amplitude : float or array_like
        Of the lateral motion; 3 mm is the usual one [mm].

    Returns
    -------
    float or ndarray
        In the shape of the amplitude [-]: 0 where nothing turns the wheel set
        back. Negative where it is turned away from the middle, as with hollow
        wheels: minus the conicity of the opposite difference of the radii.
        Where it is turned away on part of the way, so that it does not come
        back to the middle from there, that of harmonic linearisation,
        ``2/(pi a)`` times the integral of ``difference(a sin(t)) sin(t)`` over
        a quarter of the wave.

    Raises
    ------
    SceneError, NoContact
        See `rolling_radius_difference`; for an amplitude that is not positive.

    Examples
    --------
    >>> from varcontact.wheel_rail import Profile
    >>> track, wheelset = Track(rail=Profile.rail_60e1(), cant=1 / 40), WheelSet(wheel=Profile.s1002())
    >>> print(f"{equivalent_conicity(track, wheelset, 3.0):.2f}")
    0.17
    """
    from scipy.interpolate import make_interp_spline

    wanted = checks.positives("amplitude", amplitude)
    if not wanted.size:
        return wanted
    nodes = np.linspace(0.0, wanted.max(), int(np.ceil(wanted.max() / STEP)) + 1)
    difference = rolling_radius_difference(track, wheelset, nodes)
    between = make_interp_spline(nodes, difference, k=1)
    work = between.antiderivative()
    phase = (np.arange(PHASES) + 0.5) / PHASES * np.pi / 2
    y, quickest = wanted[..., None] * np.sin(phase), wanted[..., None] * np.cos(phase)
    left = work(wanted)[..., None] - work(y)
    turned_away = -_of_wave(-left, quickest)
    linearised = np.mean(between(y) * np.sin(phase), axis=-1) / wanted
    found = _of_wave(left, quickest)
    found = np.where(np.isnan(found), turned_away, found)
    found = np.where(np.isnan(found), linearised, found)
    return found if found.ndim else float(found)


def _of_wave(left: np.ndarray, quickest: np.ndarray) -> np.ndarray:
    """The conicity whose motion is as long a wave; NaN where there is none.

    The wave is 4 times the integral of dy/y' with y'^2 = 2 left / (e R); and e R drops out of the
    conicity.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        quarter = np.pi / 2 * np.mean(quickest / np.sqrt(2 * left), axis=-1)
    return np.asarray(2 * (np.pi / (4 * quarter)) ** 2)
