"""Two discs that roll on each other: twin-disc machines."""

from __future__ import annotations

import numpy as np

from varcontact.checks import number, positive
from varcontact.kinematics.rigid import Creepages, Frame, RigidBody, creepages


def twin_discs(R1: float, R2: float, omega1: float, omega2: float, skew: float = 0.0) -> Creepages:
    """Creepages of two discs that roll on each other with given speeds.

    Parameters
    ----------
    R1, R2 : float
        Radii of disc 1, above, and of disc 2 [length].
    omega1, omega2 : float
        Speeds of rotation [rad/time], positive where both surfaces run against
        x through the contact.
    skew : float, optional
        Angle by which the axis of disc 1 is turned about the normal from that
        of disc 2, from y to -x [rad]. It makes a lateral creepage.

    Returns
    -------
    Creepages
        ``vx = (omega2 R2 - omega1 R1)/speed`` without skew, the speed the mean
        of both; the slip of disc 1 in per cent of it is ``-100 vx``.

    Raises
    ------
    SceneError
        If a radius is not positive, a number not finite, or nothing rolls.

    Examples
    --------
    Disc 1 runs 1 % faster than disc 2.

    >>> motion = twin_discs(R1=0.0235, R2=0.0235, omega1=41.9, omega2=41.5)
    >>> print(f"{motion.vx:.4%} at {motion.speed:.3f} m/s")
    -0.9592% at 0.980 m/s
    """
    radius1 = positive("R1", R1)
    radius2 = positive("R2", R2)
    angle = number("skew", skew)
    axis1 = np.array([-np.sin(angle), np.cos(angle), 0.0])
    disc1 = RigidBody(
        position=np.array([0.0, 0.0, radius1]), angular_velocity=number("omega1", omega1) * axis1
    )
    disc2 = RigidBody(
        position=np.array([0.0, 0.0, -radius2]),
        angular_velocity=np.array([0.0, -number("omega2", omega2), 0.0]),
    )
    return creepages(disc1, disc2, Frame(np.zeros(3), np.eye(3)))
