"""Geometry of a wheel set on straight track: contacts tabulated over lateral
displacement and yaw, with the forces of fast theories.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import NoContact, NotConverged, SceneError, VarcontactError, warn
from varcontact.io.labelled import Labelled
from varcontact.reference.creepage_coefficients import no_slip_coefficients
from varcontact.scene.bodies import Bodies
from varcontact.system.progress import Progress
from varcontact.theories.creep_forces import TheoryName, elastic, formula_of, theory_options
from varcontact.theories.linear import Contact
from varcontact.wheel_rail.conicity import equivalent_conicity as equivalent_conicity
from varcontact.wheel_rail.conicity import rolling_radius_difference as rolling_radius_difference
from varcontact.wheel_rail.position import Position, Velocity, check_forward
from varcontact.wheel_rail.track import SIGN, Irregularity, Side, Track, WheelSet
from varcontact.wheel_rail.virtual_penetration import estimated
from varcontact.wheel_rail.wheel_geometry import STEEL
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

SLOTS = 3
"""Largest number of patches of a wheel that are tabulated."""
COLUMNS = 8
"""Number of figures of a patch, see `WheelSetForces`."""
GROWTH = np.array([1 / 3, 1 / 3, 1.0, 2 / 3])
"""Exponents of the force in a, b, the force itself and the approach of Hertz's contact."""
MIRRORED = np.array([1.0, -1.0, 1.0, -1.0, 1.0, 1.0, 1.0, 1.0])


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
        Contacts, from the left wheel's to the right's: x, y, z [mm],
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
class GeometryTable(Labelled):
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
    track : Track
    """

    y: np.ndarray
    yaw: np.ndarray
    z: np.ndarray
    count: np.ndarray
    patches: np.ndarray
    wheelset: WheelSet
    bodies: Bodies
    friction: float
    track: Track

    __repr__ = checks.short_entries

    def to_xarray(self) -> xr.Dataset:
        """Contacts of the right wheel over y, yaw and patch, with names and units; rolling radius
        difference and equivalent conicity over y.
        """
        from varcontact.wheel_rail.geometry_data import table_dataset

        return table_dataset(self)

    @checks.named_options()
    def save_columns(self, path: str | Path, *, yaw: float = 0.0, overwrite: bool = False) -> None:
        """Write the columns that vehicle codes read to a `path` (.csv), a row for each lateral
        displacement at a node of `yaw` [rad]; see docs/vehicle_codes.md. A file is replaced as by
        `save`, with `overwrite` any.

        SceneError if there is no such node.
        """
        from varcontact.wheel_rail.vehicle_table import save_columns

        save_columns(self, path, yaw, overwrite)

    @checks.named_options()
    def plot(self, *, figsize: tuple[float, float] | None = None) -> Figure:
        """Rolling radius difference, contact angle, conicity, and contacts on both profiles, over
        the lateral displacement at the middle node of yaw; `figsize` is in inches.
        """
        from varcontact.wheel_rail.plots import plot_geometry

        return plot_geometry(self, figsize)

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
        i, s = _cell("y", self.y, y, sign)
        j, t = _cell("yaw", self.yaw, yaw, sign)
        # the four nodes around the position, or the nearest where their numbers of patches differ
        four = slice(i, i + 2), slice(j, j + 2)
        z = self.z[four].ravel()
        counts = self.count[four].ravel()
        nodes = self.patches[four].reshape(4, SLOTS, COLUMNS)
        weights = np.array([(1 - s) * (1 - t), (1 - s) * t, s * (1 - t), s * t])
        if np.ptp(counts) > 0:
            nearest = [2 * round(s) + round(t)]
            z = z[nearest]
            counts = counts[nearest]
            nodes = nodes[nearest]
            weights = np.ones(1)
        if counts[0] == 0:
            reason = (
                f"y = {y:g} mm, yaw = {yaw:g}: the {side} wheel has no contact there, "
                "see the warning of the table"
            )
            raise NoContact("y", y, message=reason)
        # linear in between, but for forces and sizes, which are scaled to the load
        load = weights @ (nodes[..., 6] * np.cos(nodes[..., 3])).sum(axis=-1)
        patches = np.tensordot(weights, nodes[:, : counts[0]], 1)
        patches[:, 4:] *= (load / float(patches[:, 6] @ np.cos(patches[:, 3]))) ** GROWTH
        if side == "left":
            patches = patches * MIRRORED
        return float(weights @ z), patches

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
            Theory of `varcontact.creep_forces` that has a moment.
        **options
            Options of the theory: ``outside="clamp"`` of "table", as in
            `WheelOnRail.estimate`.

        Raises
        ------
        SceneError
            See `contacts`; for a wheel that does not roll forwards, a theory
            without a moment, and for what the theory refuses.
        """
        checks.kind("velocity", velocity, Velocity)
        sides = [self.contacts(y, yaw, side) for side in ("left", "right")]
        patches = np.concatenate([contacts for _, contacts in sides])
        # arms from the middle of the axle; each wheel is at its own height: of the roll of the
        # wheel set, this is what counts in the creepages
        radius = self.wheelset.radius
        axle = [[0.0, y, z - radius] for z, contacts in sides for _ in contacts]
        arms = patches[:, :3] - axle
        cosine = np.cos(patches[:, 3])
        sine = np.sin(patches[:, 3])
        nothing = np.zeros(len(patches))
        lateral = np.array([nothing, cosine, sine]).T
        inwards = np.array([nothing, -sine, cosine]).T
        # velocities of the particles at the depth of the approach, as in `WheelOnRail.creepage`
        deep = arms + patches[:, 7:] * inwards
        pitch = velocity.pitch_rate
        if pitch is None:
            pitch = -velocity.speed / radius
        turning = np.array(
            [velocity.roll_rate - pitch * np.sin(yaw), pitch * np.cos(yaw), velocity.yaw_rate]
        )
        moving = np.array([velocity.speed, velocity.lateral, velocity.vertical])
        particle = moving + np.cross(turning, deep)
        # creepages
        speed = velocity.speed - velocity.yaw_rate * deep[:, 1] - particle[:, 0] / 2
        check_forward(float(speed.min()))
        slip = [particle[:, 0], (particle * lateral).sum(axis=1), inwards @ turning]
        creepage = -np.array(slip) / speed
        vx, vy, spin = creepage
        # forces of the theory, in the frames of the patches
        formula = formula_of(theory, options)
        G, nu = elastic(self.bodies, None, None)
        a, b, normal = patches[:, 4:7].T
        coefficients = no_slip_coefficients(a / b, nu)
        limit = self.friction * normal
        contact = Contact(a, b, G, nu, limit, vx, vy, spin, 1.0, coefficients)
        Fx, Fy, Mz = formula(contact, **options)
        if np.isnan(Mz).any():
            raise SceneError("theory", theory, "a theory with a moment, such as fastsim or table")
        # on the wheel set, along the axes of the track
        on_wheel = -(normal[:, None] * inwards + Fy[:, None] * lateral)
        on_wheel[:, 0] = -Fx
        moment = np.cross(arms, on_wheel) - Mz[:, None] * inwards
        tangential = np.array([Fx, Fy]).T
        return WheelSetForces(
            on_wheel.sum(axis=0), moment.sum(axis=0), patches, creepage.T, tangential
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
    progress: Progress = None,
) -> GeometryTable:
    """Tabulate the contacts of a wheel set by `WheelOnRail.estimate`.

    Parameters
    ----------
    track : Track
    wheelset : WheelSet
    y, yaw : array_like
        Nodes, two or more, ascending and symmetric about 0 [mm] and [rad].
    vertical_force : float
        Vertical part of the normal forces on each wheel [N]: creep forces, which depend on
        the velocity, come on top of it.
    friction : float
    bodies : Bodies
    normal : {"virtual-penetration", "analyn", "hertz"}
        Which ellipse stands for a patch, see `WheelOnRail.estimate`.
    progress : callable or true, optional
        Called with the progress.

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
        reason = (
            "track: a table is of straight, even track; "
            "in a curve add speed / curve_radius to the yaw rate"
        )
        raise SceneError("track", track.curve_radius, message=reason)
    y = _nodes("y", y)
    yaw = _nodes("yaw", yaw)
    coefficient = checks.positive("friction", friction)
    report = checks.progress(progress)
    shape = y.size, yaw.size
    z = np.full(shape, np.nan)
    count = np.zeros(shape, dtype=int)
    patches = np.full((*shape, SLOTS, COLUMNS), np.nan)
    without: list[tuple[float, float, VarcontactError]] = []
    for i, j in np.ndindex(shape):
        report(f"{i * shape[1] + j} of {shape[0] * shape[1]} positions")
        case = WheelOnRail(
            track=track,
            wheelset=wheelset,
            position=Position(y=float(y[i]), yaw=float(yaw[j])),
            vertical_force=vertical_force,
            with_friction=False,
            friction=friction,
            bodies=bodies,
        )
        try:
            wheel = estimated(case, normal)
        except (SceneError, NotConverged) as error:
            without.append((float(y[i]), float(yaw[j]), error))
            continue
        if len(wheel.patches) > SLOTS:
            warn(f"of {len(wheel.patches)} patches, the {SLOTS} with the largest force count")
        largest = sorted(wheel.patches, key=lambda each: -each.force[2])[:SLOTS]
        kept = sorted(largest, key=lambda each: each.frame.origin[1])
        z[i, j] = wheel.z
        count[i, j] = len(kept)
        patches[i, j] = 0.0
        for k, each in enumerate(kept):
            ellipse = each.ellipse
            sizes = ellipse.a, ellipse.b, ellipse.normal_force, each.approach
            patches[i, j, k] = [*each.frame.origin, each.angle, *sizes]
    # nodes without contact
    if len(without) == count.size:
        raise without[0][-1]
    if without:
        first_y, first_yaw, first = without[0]
        where = f"the first at y = {first_y:g} mm, yaw = {first_yaw:g}"
        warn(f"{len(without)} of {count.size} nodes have no contact, {where}: {first}")
    return GeometryTable(y, yaw, z, count, patches, wheelset, bodies, coefficient, track)


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
