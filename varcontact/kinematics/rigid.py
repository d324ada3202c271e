"""Rigid bodies and frames: positions, rotations, and their rates."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError

UNIT = 1e-9
"""How far a matrix may be from a rotation."""


def rotation(roll: float = 0.0, yaw: float = 0.0, pitch: float = 0.0) -> np.ndarray:
    """The matrix of a body that is pitched about y, then yawed about z, then rolled about x, axes at rest.

    Parameters
    ----------
    roll, yaw, pitch : float
        About x, z and y [rad], by the right-hand rule.

    Returns
    -------
    ndarray, shape (3, 3)
        ``Rx(roll) Rz(yaw) Ry(pitch)``; its columns are the body's axes in the global frame.

    Examples
    --------
    >>> rotation(yaw=np.pi / 2).round(6) @ [1.0, 0.0, 0.0]
    array([0., 1., 0.])
    """
    angles = [checks.moderate(name, value) for name, value in (("roll", roll), ("yaw", yaw), ("pitch", pitch))]
    (a, b, c), (sa, sb, sc) = np.cos(angles), np.sin(angles)
    about_x = np.array([[1, 0, 0], [0, a, -sa], [0, sa, a]])
    about_z = np.array([[b, -sb, 0], [sb, b, 0], [0, 0, 1]])
    about_y = np.array([[c, 0, sc], [0, 1, 0], [-sc, 0, c]])
    return np.asarray(about_x @ about_z @ about_y)


@dataclass(frozen=True, eq=False, kw_only=True)
class RigidBody:
    """Where a rigid body is, and how it moves: ``x = A y + R``, (5).

    Parameters
    ----------
    position : array_like, shape (3,)
        R, its origin in the global frame [length].
    rotation : array_like, shape (3, 3), optional
        A, see `rotation`; the identity if not given.
    velocity : array_like, shape (3,), optional
        Of its origin [length/time]; at rest if not given.
    angular_velocity : array_like, shape (3,), optional
        In the global frame [rad/time]; none if not given.

    Raises
    ------
    SceneError
        If a shape is wrong, a number is not finite, or the matrix is no rotation.

    Examples
    --------
    A wheel of radius 0.5 that rolls along x at 10, z down: the particle at the bottom is at rest.

    >>> wheel = RigidBody(position=[0.0, 0.0, -0.5], velocity=[10.0, 0.0, 0.0], angular_velocity=[0.0, -20.0, 0.0])
    >>> wheel.velocity_at([0.0, 0.0, 0.0])
    array([0., 0., 0.])
    """

    position: np.ndarray
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    angular_velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        for name in ("position", "velocity", "angular_velocity"):
            set_(self, name, vector(f"body.{name}", getattr(self, name)))
        set_(self, "rotation", _rotation("body.rotation", self.rotation))

    def globally(self, points: np.ndarray) -> np.ndarray:
        """The body's `points` (..., 3) in the global frame."""
        return np.asarray(points) @ self.rotation.T + self.position

    def locally(self, points: np.ndarray) -> np.ndarray:
        """The global frame's `points` (..., 3) in the body's own."""
        return (np.asarray(points) - self.position) @ self.rotation

    def velocity_at(self, points: np.ndarray) -> np.ndarray:
        """Velocity (..., 3) of the particles that are at `points` (..., 3) of the global frame."""
        return self.velocity + np.cross(self.angular_velocity, np.asarray(points) - self.position)

    def after(self, time: float) -> RigidBody:
        """The body after a `time`, its velocities kept."""
        from scipy.spatial.transform import Rotation

        turn = Rotation.from_rotvec(self.angular_velocity * time).as_matrix()
        return RigidBody(
            position=self.position + time * self.velocity,
            rotation=turn @ self.rotation,
            velocity=self.velocity,
            angular_velocity=self.angular_velocity,
        )


@dataclass(frozen=True, eq=False)
class Frame:
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

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", vector("frame.origin", self.origin))
        object.__setattr__(self, "axes", _rotation("frame.axes", self.axes))

    @property
    def normal(self) -> np.ndarray:
        """The z-axis, shape (3,)."""
        return np.asarray(self.axes[:, 2])

    def globally(self, points: np.ndarray) -> np.ndarray:
        """The frame's `points` (..., 3) in the global one."""
        return np.asarray(points) @ self.axes.T + self.origin

    def locally(self, points: np.ndarray) -> np.ndarray:
        """The global frame's `points` (..., 3) in this one."""
        return (np.asarray(points) - self.origin) @ self.axes


def vector(field: str, value: object) -> np.ndarray:
    """Three finite numbers, the `value` of a `field`."""
    array = checks.array(field, value, 1)
    if array.shape != (3,):
        raise checks.wrong_shape(field, array.shape, "three numbers")
    return array


def _rotation(field: str, value: object) -> np.ndarray:
    """A rotation matrix."""
    matrix = checks.array(field, value, 2)
    if matrix.shape != (3, 3):
        raise checks.wrong_shape(field, matrix.shape, "a matrix of 3 x 3")
    if np.abs(matrix @ matrix.T - np.eye(3)).max() > UNIT or np.linalg.det(matrix) < 0:
        raise SceneError(field, value, message=f"{field} must be a rotation: orthonormal columns, right-handed")
    return matrix
