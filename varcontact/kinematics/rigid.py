"""Rigid bodies and frames, their distance, rigid slip and creepages (paper, sections 1.1 to
1.5).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import partial
from typing import ClassVar

import numpy as np

from varcontact import checks
from varcontact.checks import Checked
from varcontact.errors import SceneError

UNIT = 1e-9
"""Largest entry of ``A A' - I`` with which a matrix A counts as a rotation."""


def rotation(roll: float = 0.0, yaw: float = 0.0, pitch: float = 0.0) -> np.ndarray:
    """The matrix of a body that is pitched about y, then yawed about z, then
    rolled about x, axes at rest.

    Parameters
    ----------
    roll, yaw, pitch : float
        About x, z and y [rad], by the right-hand rule.

    Returns
    -------
    ndarray, shape (3, 3)
        ``Rx(roll) Rz(yaw) Ry(pitch)``; its columns are the body's axes in the
        global frame.

    Examples
    --------
    >>> rotation(yaw=np.pi / 2).round(6) @ [1.0, 0.0, 0.0]
    array([0., 1., 0.])
    """
    given = (("roll", roll), ("yaw", yaw), ("pitch", pitch))
    return turned(*(checks.number(name, value) for name, value in given))


def turned(*angles: float) -> np.ndarray:
    """The matrix of `rotation` for roll, yaw and pitch, unchecked."""
    a, b, c = map(math.cos, angles)
    sa, sb, sc = map(math.sin, angles)
    # the product, written out
    return np.array(
        [
            [b * c, -sb, b * sc],
            [a * sb * c + sa * sc, a * b, a * sb * sc - sa * c],
            [sa * sb * c - a * sc, sa * b, sa * sb * sc + a * c],
        ]
    )


_vector = partial(checks.array, shape=(3,), meant="three numbers")


def _rotation(field: str, value: object) -> np.ndarray:
    matrix = checks.array(field, value, shape=(3, 3), meant="a matrix of 3 x 3")
    if np.abs(matrix @ matrix.T - np.eye(3)).max() > UNIT or np.linalg.det(matrix) < 0:
        raise SceneError(
            field, value, message=f"{field} must be a rotation: orthonormal columns, right-handed"
        )
    return matrix


class _Placed(Checked):
    """Base class of objects with a place and axes in the global frame."""

    # names of the place and of the matrix whose columns are the axes
    _place: ClassVar[tuple[str, str]]

    def globally(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) of the body's or frame's own axes, in the global frame."""
        place, axes = (getattr(self, name) for name in self._place)
        return np.asarray(points) @ axes.T + place

    def locally(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) of the global frame, in the body's or frame's own axes."""
        place, axes = (getattr(self, name) for name in self._place)
        return np.asarray((np.asarray(points) - place) @ axes)


@dataclass(frozen=True, eq=False, kw_only=True)
class RigidBody(
    _Placed,
    path="body",
    position=_vector,
    rotation=_rotation,
    velocity=_vector,
    angular_velocity=_vector,
):
    """Position and motion of a rigid body: ``x = A y + R``, (5).

    Parameters
    ----------
    position : array_like, shape (3,)
        R, its origin in the global frame [length].
    rotation : array_like, shape (3, 3), optional
        A, see `rotation`; the identity if not given.
    velocity : array_like, shape (3,), optional
        Velocity of its origin [length/time]; at rest if not given.
    angular_velocity : array_like, shape (3,), optional
        In the global frame [rad/time]; none if not given.

    Raises
    ------
    SceneError
        If a shape is wrong, a number is not finite, or the matrix is no
        rotation.

    Examples
    --------
    A wheel of radius 0.5 that rolls along x at 10, z down: the particle at the bottom is at rest.

    >>> wheel = RigidBody(
    ...     position=[0.0, 0.0, -0.5], velocity=[10.0, 0.0, 0.0],
    ...     angular_velocity=[0.0, -20.0, 0.0])
    >>> wheel.velocity_at([0.0, 0.0, 0.0])
    array([0., 0., 0.])
    """

    position: np.ndarray
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    angular_velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    _place = ("position", "rotation")

    def velocity_at(self, points: np.ndarray) -> np.ndarray:
        """Velocity (..., 3) of the particles that are at `points` (..., 3) of the global frame."""
        a, b, c = self.angular_velocity
        # np.cross takes ten times as long
        turning = np.array([[0.0, c, -b], [-c, 0.0, a], [b, -a, 0.0]])
        return np.asarray(self.velocity + (np.asarray(points) - self.position) @ turning)

    def after(self, time: float) -> RigidBody:
        """The body after a `time`, its velocities kept."""
        from scipy.spatial.transform import Rotation

        turn = Rotation.from_rotvec(self.angular_velocity * time).as_matrix()
        return replace(
            self, position=self.position + time * self.velocity, rotation=turn @ self.rotation
        )


@dataclass(frozen=True, eq=False)
class Frame(_Placed, path="frame", origin=_vector, axes=_rotation):
    """A contact frame: x the rolling direction, z the normal into body 1.

    Parameters
    ----------
    origin : array_like, shape (3,)
        In the global frame [length].
    axes : array_like, shape (3, 3)
        Its columns are x, y and z in the global frame.

    Raises
    ------
    SceneError
        If a shape is wrong, or the axes are not orthonormal and right-handed.

    Examples
    --------
    >>> Frame([0.0, 0.0, 0.0], rotation(roll=0.1)).normal.round(4)
    array([ 0.    , -0.0998,  0.995 ])
    """

    origin: np.ndarray
    axes: np.ndarray
    _place = ("origin", "axes")

    @property
    def normal(self) -> np.ndarray:
        """The z-axis, shape (3,)."""
        return np.asarray(self.axes[:, 2])


@dataclass(frozen=True)
class Creepages:
    """Rigid slip of body 1 over body 2 by rolling velocity:
    ``(vx - spin y, vy + spin x)`` near the origin, (75).

    Attributes
    ----------
    vx, vy : float
        Longitudinal and lateral creepage [-].
    spin : float
        [1/length]
    speed : float
        The rolling velocity they are divided by, positive [length/time].
    """

    vx: float
    vy: float
    spin: float
    speed: float


def distance(point1: np.ndarray, point2: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Distance from body 2 to body 1 along the outer normal of body 2, (10);
    negative where they penetrate.

    Parameters
    ----------
    point1, point2 : array_like, shape (..., 3)
        Opposite points of the bodies' surfaces.
    normal : array_like, shape (3,) or (..., 3)
        Outer unit normal of body 2: the z-axis of the contact frame.

    Returns
    -------
    ndarray, shape (...)

    Examples
    --------
    >>> float(distance([0.0, 0.0, 2.0], [0.0, 0.0, 0.5], [0.0, 0.0, 1.0]))
    1.5
    """
    return np.asarray(
        np.sum((np.asarray(point1) - np.asarray(point2)) * np.asarray(normal), axis=-1)
    )


def rigid_slip(body1: RigidBody, body2: RigidBody, points: np.ndarray) -> np.ndarray:
    """Creep (22): velocity (..., 3) of `body1` over `body2` at `points` (..., 3) of the global
    frame [length/time].
    """
    return body1.velocity_at(points) - body2.velocity_at(points)


def creepages(
    body1: RigidBody,
    body2: RigidBody,
    frame: Frame,
    *,
    frame_velocity: np.ndarray | None = None,
    at1: np.ndarray | None = None,
    at2: np.ndarray | None = None,
) -> Creepages:
    """Creepages and spin of two rigid bodies in a contact frame.

    The rolling velocity (23) is the speed at which the material of both, on
    average, runs through the frame against its x-axis.

    Parameters
    ----------
    body1, body2 : RigidBody
    frame : Frame
        Its z-axis points into body 1.
    frame_velocity : array_like, shape (3,), optional
        Velocity of the contact, which moves along with the frame; at rest if
        not given.
    at1, at2 : array_like, shape (3,), optional
        The undeformed surface points of the two bodies that meet there; the
        frame's origin if not given. They are some hundredths of a millimetre
        apart, which counts where creepages are as small as that by the radius.

    Returns
    -------
    Creepages

    Raises
    ------
    SceneError
        If nothing rolls along the frame's x-axis.

    Examples
    --------
    The simplified wheel of section 1.5, z up: radius 0.5, angular velocity 19, the rail drawn
    backwards at 10.

    >>> wheel = RigidBody(position=[0.0, 0.0, 0.5], angular_velocity=[0.0, 19.0, 0.0])
    >>> rail = RigidBody(position=[0.0, 0.0, 0.0], velocity=[-10.0, 0.0, 0.0])
    >>> found = creepages(wheel, rail, Frame([0.0, 0.0, 0.0], np.eye(3)))
    >>> print(f"{found.vx:.6f} at {found.speed}")
    0.051282 at 9.75
    """
    moving = np.zeros(3)
    if frame_velocity is not None:
        moving = _vector("frame_velocity", frame_velocity)
    point1 = frame.origin if at1 is None else _vector("at1", at1)
    point2 = frame.origin if at2 is None else _vector("at2", at2)
    return creepages_of((body1, body2), (point1, point2), frame, moving)


def creepages_of(
    bodies: tuple[RigidBody, RigidBody],
    particles: tuple[np.ndarray, np.ndarray],
    frame: Frame,
    moving: np.ndarray,
) -> Creepages:
    """Creepages as by `creepages`, from one particle of each body and the velocity `moving` of the
    frame, without checks of these.
    """
    body1, body2 = bodies
    first, second = (
        (body.velocity_at(particle) - moving) @ frame.axes
        for body, particle in zip(bodies, particles, strict=True)
    )
    speed = -float(first[0] + second[0]) / 2
    if speed <= 0:
        message = (
            "the bodies do not roll along x of the contact frame: "
            f"the rolling velocity is {speed + 0.0:.6g}, and must be positive; "
            "turn the frame, or give the contact's frame_velocity"
        )
        raise SceneError("frame", speed, message=message)
    slip = (first - second) / speed
    spin = frame.normal @ (body1.angular_velocity - body2.angular_velocity) / speed
    return Creepages(float(slip[0]), float(slip[1]), float(spin), speed)


def spin_pole(vx: float, vy: float, spin: float) -> tuple[float, float]:
    """The point of the contact plane where the rigid slip vanishes (section 6.3.1).

    Parameters
    ----------
    vx, vy : float
        Creepages [-].
    spin : float
        [1/length], not zero.

    Returns
    -------
    tuple of float
        ``(-vy/spin, vx/spin)`` [length]; the paper prints the opposite sign.

    Raises
    ------
    SceneError
        If a number is not finite, or the spin is zero.

    Examples
    --------
    >>> spin_pole(0.001, 0.002, 0.5)
    (-0.004, 0.002)
    """
    vx = checks.number("vx", vx)
    vy = checks.number("vy", vy)
    if checks.number("spin", spin) == 0:
        raise SceneError(
            "spin", spin, "not zero: without spin the rigid slip is the same everywhere"
        )
    return -vy / spin, vx / spin
