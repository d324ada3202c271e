"""Where a wheel touches a rail: the contact locus of the rotated wheel over the rail.

On each circle of the wheel one point can touch a rail that is straight along x: the one whose normal has no component
along x (Wang 1984, "The track of wheel contact points and the calculation of wheel/rail geometric contact parameters").
These points are the contact locus. It depends on roll and yaw, and is moved up and down by the height of the axle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.errors import NoContact, SceneError
from varcontact.system.threads import one_blas_thread
from varcontact.wheel_rail.curve import Curve

STEP = 0.05
"""Between the circles of the wheel [mm]."""
ACROSS = np.array([1.0, 0.0])


@dataclass(frozen=True, eq=False)
class Locus:
    """The points of a wheel that come nearest to a rail, with the axle at the height 0.

    Attributes
    ----------
    s : ndarray, shape (n,)
        Parameters of the circles on the wheel's curve [mm].
    theta : ndarray, shape (n,)
        Their angles on the circles, forward from the bottom [rad].
    points : ndarray, shape (n, 3)
        In track coordinates [mm].
    radii : ndarray, shape (n,)
        Of the circles [mm].
    gap : ndarray, shape (n,)
        Height above the rail [mm]; infinite beside it.
    angles : ndarray, shape (n,)
        Inclination of the rail below [rad].
    height : float
        Of the middle of the axle in track coordinates, where its height z is 0 [mm].
    """

    s: np.ndarray
    theta: np.ndarray
    points: np.ndarray
    radii: np.ndarray
    gap: np.ndarray
    angles: np.ndarray
    height: float

    @property
    def touching(self) -> float:
        """The height of the axle, z down, at which the wheel just touches the rail [mm]."""
        return float(self.gap.min())

    def overlaps(self, z: float) -> list[Overlap]:
        """Runs of circles that are below the rail's surface.

        Parameters
        ----------
        z : float
            Height of the axle, downwards [mm].

        Returns
        -------
        list of Overlap
            From left to right.

        Raises
        ------
        NoContact
            If the wheel is above the rail.
        SceneError
            If the contact reaches the end of a profile.
        """
        if z <= self.touching:
            raise NoContact(
                "z",
                z,
                message=f"no contact: with z = {z:.6g} mm the wheel is {self.touching - z:.3g} mm above the rail; it "
                f"touches at z = {self.touching:.6g} mm",
            )
        inside = np.concatenate([[False], self.gap < z, [False]])
        edges = np.flatnonzero(np.diff(inside.astype(int)))
        return [self._overlap(int(a), int(b), z) for a, b in zip(edges[::2], edges[1::2], strict=True)]

    def _overlap(self, first: int, stop: int, z: float) -> Overlap:
        ends = [i for i, beside in ((first, first - 1), (stop - 1, stop)) if not self._known(beside)]
        if ends:
            y, depth = self.points[ends[0], 1], z - self.gap[ends[0]]
            raise SceneError(
                "z",
                z,
                message=f"the contact reaches the end of a profile near y = {y:.4g} mm, where the wheel is "
                f"{depth:.3g} mm below the rail's surface: a profile is too narrow or too rough, or the load too large",
            )
        return Overlap(slice(first, stop), self, z)

    def _known(self, i: int) -> bool:
        return 0 <= i < self.gap.size and bool(np.isfinite(self.gap[i]))


@dataclass(frozen=True, eq=False)
class Overlap:
    """A run of circles of the wheel that are below the rail's surface.

    Attributes
    ----------
    run : slice
        Of the locus.
    locus : Locus
    z : float
        Height of the axle, downwards [mm].
    """

    run: slice
    locus: Locus
    z: float

    @property
    def points(self) -> np.ndarray:
        """The locus with the axle at this height, shape (n, 3)."""
        return np.asarray(self.locus.points[self.run] + [0.0, 0.0, self.z])

    @property
    def depth(self) -> np.ndarray:
        """How deep the circles are below the rail's surface, shape (n,)."""
        return np.asarray(self.z - self.locus.gap[self.run])

    @property
    def surface(self) -> np.ndarray:
        """(y, z) of the rail above the points, shape (n, 2)."""
        points = self.points
        return np.stack([points[:, 1], points[:, 2] - self.depth], axis=1)

    @property
    def half_lengths(self) -> np.ndarray:
        """Half lengths along x over which the circles are below the surface, shape (n,)."""
        return np.sqrt(2 * self.locus.radii[self.run] * self.depth)

    @property
    def weights(self) -> np.ndarray:
        """The squared depth, summed up along x and over the width of each circle, shape (n,).

        The weighted centre of the squared depth is where CONTACT has the origin of a patch.
        """
        width = np.abs(np.gradient(self.points[:, 1])) if self.depth.size > 1 else np.ones(1)
        return self.depth**2 * self.half_lengths * width


@one_blas_thread()
def contact_locus(wheel: Curve, rail: Curve, rotation: np.ndarray, centre: np.ndarray) -> Locus:
    """The contact locus of a wheel over a rail.

    Parameters
    ----------
    wheel : Curve
        (y along the axle, radius), y growing.
    rail : Curve
        (y, z) in track coordinates, y growing.
    rotation : ndarray, shape (3, 3)
        The axle's axes in track coordinates.
    centre : ndarray, shape (3,)
        The middle of the axle in track coordinates, at the height 0.

    Returns
    -------
    Locus

    Raises
    ------
    NoContact
        If no point of it is above the rail.

    Notes
    -----
    The normal of a surface of revolution of radius ``r(y)`` is along ``(sin(theta), -r', cos(theta))`` in the frame of
    the axle. That its component along the track is zero makes one equation for theta, solved in closed form.
    """
    s = wheel.sampled(STEP)
    y, r = wheel.points(s).T
    along = wheel.directions(s)
    a, b, c = rotation[0]
    reach = np.hypot(a, c)
    slope = b * along[:, 1] / (along[:, 0] * reach)
    possible = np.abs(slope) < 1
    s, y, r, slope = (each[possible] for each in (s, y, r, slope))
    theta = np.arcsin(slope) - np.arctan2(c, a)
    points = np.stack([r * np.sin(theta), y, r * np.cos(theta)], axis=1) @ rotation.T + centre
    below = rail.at(points[:, 1], ACROSS)
    over = np.isfinite(below)
    if not over.any():
        ends = rail.points(rail.s[[0, -1]])[:, 0]
        raise NoContact(
            "position.y",
            float(centre[1]),
            message=f"the wheel is beside the rail: it spans y from {points[:, 1].min():.5g} to "
            f"{points[:, 1].max():.5g} mm, the rail from {ends[0]:.5g} to {ends[1]:.5g} mm",
        )
    gap, angles = np.full(s.size, np.inf), np.zeros(s.size)
    gap[over] = rail.points(below[over])[:, 1] - points[over, 2]
    angles[over] = rail.angles(below[over])
    return Locus(s, theta, points, r, gap, angles, float(centre[2]))
