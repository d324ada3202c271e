"""Distance, rigid slip and creepages of two moving bodies (paper, sections 1.1 to 1.5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.kinematics.rigid import Frame, RigidBody, vector


@dataclass(frozen=True)
class Creepages:
    """Rigid slip of body 1 over body 2 by rolling velocity: ``(vx - spin y, vy + spin x)`` near the origin, (75).

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
    """Distance from body 2 to body 1 along the outer normal of body 2, (10); negative where they penetrate.

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
    return np.asarray(np.sum((np.asarray(point1) - np.asarray(point2)) * np.asarray(normal), axis=-1))


def rigid_slip(body1: RigidBody, body2: RigidBody, points: np.ndarray) -> np.ndarray:
    """Creep (22): the velocity of body 1 over body 2 at points of the global frame.

    Parameters
    ----------
    body1, body2 : RigidBody
    points : array_like, shape (..., 3)

    Returns
    -------
    ndarray, shape (..., 3)
        [length/time]
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

    The rolling velocity (23) is the speed at which the material of both, on average, runs through the frame against
    its x-axis.

    Parameters
    ----------
    body1, body2 : RigidBody
    frame : Frame
        Its z-axis points into body 1.
    frame_velocity : array_like, shape (3,), optional
        Velocity of the contact, which moves along with the frame; at rest if not given.
    at1, at2 : array_like, shape (3,), optional
        The undeformed surface points of the two bodies that meet there; the frame's origin if not given. They are
        some hundredths of a millimetre apart, which counts where creepages are as small as that by the radius.

    Returns
    -------
    Creepages

    Raises
    ------
    SceneError
        If nothing rolls along the frame's x-axis.

    Examples
    --------
    The simplified wheel of section 1.5, z up: radius 0.5, angular velocity 19, the rail drawn backwards at 10.

    >>> wheel = RigidBody(position=[0.0, 0.0, 0.5], angular_velocity=[0.0, 19.0, 0.0])
    >>> rail = RigidBody(position=[0.0, 0.0, 0.0], velocity=[-10.0, 0.0, 0.0])
    >>> found = creepages(wheel, rail, Frame([0.0, 0.0, 0.0], np.eye(3)))
    >>> print(f"{found.vx:.6f} at {found.speed}")
    0.051282 at 9.75
    """
    moving = np.zeros(3) if frame_velocity is None else vector("frame_velocity", frame_velocity)
    first = frame.axes.T @ (body1.velocity_at(frame.origin if at1 is None else vector("at1", at1)) - moving)
    second = frame.axes.T @ (body2.velocity_at(frame.origin if at2 is None else vector("at2", at2)) - moving)
    speed = -float(first[0] + second[0]) / 2
    if speed <= 0:
        raise SceneError(
            "frame",
            speed,
            message=f"the bodies do not roll along x of the contact frame: the rolling velocity is {speed + 0.0:.6g}, "
            "and must be positive; turn the frame, or give the velocity of the contact as frame_velocity",
        )
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
    vx, vy = checks.moderate("vx", vx), checks.moderate("vy", vy)
    if checks.moderate("spin", spin) == 0:
        raise SceneError("spin", spin, "not zero: without spin the rigid slip is the same everywhere")
    return -vy / spin, vx / spin
