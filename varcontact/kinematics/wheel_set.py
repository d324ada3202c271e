"""The linearised wheel set, and a ball between two planes."""

from __future__ import annotations

import math
from dataclasses import dataclass

from varcontact.checks import Checked, array, number, positive, positives
from varcontact.kinematics.rigid import Creepages
from varcontact.reference.creepage_coefficients import creepage_coefficients


def _pair(field: str, value: object) -> tuple[float, ...]:
    return tuple(
        array(
            field, value, shape=(2,), meant="two numbers, of the left and the right wheel"
        ).tolist()
    )


@dataclass(frozen=True, kw_only=True)
class WheelSetMotion(
    Checked,
    path="motion",
    **dict.fromkeys(("speed", "half_gauge"), positive),
    **dict.fromkeys(("angular_velocity", "yaw", "yaw_rate", "lateral_velocity"), number),
    radii=lambda field, value: _pair(field, positives(field, value)),
    angles=_pair,
):
    """The linearised motion of a wheel set on straight rails (section 2.2.3): z
    up, x forward, y to the left.

    Parameters
    ----------
    speed : float
        V, along the track [length/time].
    angular_velocity : float
        omega, about the axle [rad/time]; `speed` by the mean radius in pure
        rolling.
    radii : tuple of float
        Rolling radii of the left and the right wheel [length].
    half_gauge : float
        b, half the distance of the contacts [length].
    angles : tuple of float
        gamma, contact angles of the left and the right wheel [rad].
    yaw, yaw_rate : float
        alpha and its rate [rad, rad/time].
    lateral_velocity : float
        Lateral velocity of the centre [length/time].

    Raises
    ------
    SceneError
        If a number is not finite, a length or the speed is not positive, or
        radii or angles are not two.

    Examples
    --------
    Klingel's rolling has no creep:

    >>> V, gamma, R, b, y = 27.8, 1 / 40, 0.5, 0.715, 0.003
    >>> motion = WheelSetMotion(
    ...     speed=V, angular_velocity=V / R, radii=(R + gamma * y, R - gamma * y), half_gauge=b,
    ...     yaw_rate=-V * gamma * y / (R * b), angles=(gamma, gamma))
    >>> left, right = motion.creepages
    >>> print(f"{abs(left.vx):.6f} {abs(right.vx):.6f} {left.spin:.4f} {right.spin:.4f}")
    0.000000 0.000000 -0.0502 0.0498
    """

    speed: float
    angular_velocity: float
    radii: tuple[float, float]
    half_gauge: float
    angles: tuple[float, float] = (0.0, 0.0)
    yaw: float = 0.0
    yaw_rate: float = 0.0
    lateral_velocity: float = 0.0

    @property
    def creepages(self) -> tuple[Creepages, Creepages]:
        """Creepages of the left and the right wheel over the rails, (135) to (139).

        Corrected: (136) and (137) have no factor 1/2 before the difference of the radii, without
        which Klingel's rolling would have the creep ``-omega gamma y / V`` where it has none.
        """
        mean = sum(self.radii) / 2
        difference = (self.radii[0] - self.radii[1]) / 2
        driven = 1 - self.angular_velocity * mean / self.speed
        turned = (self.angular_velocity * difference + self.yaw_rate * self.half_gauge) / self.speed
        lateral = self.lateral_velocity / self.speed - self.yaw
        geometric = [angle * self.angular_velocity / self.speed for angle in self.angles]
        kinematic = self.yaw_rate / self.speed
        left = Creepages(driven - turned, lateral, kinematic - geometric[0], self.speed)
        return left, Creepages(driven + turned, lateral, kinematic + geometric[1], self.speed)


def klingel_wavelength(conicity: float, radius: float, half_gauge: float) -> float:
    """Wavelength of Klingel's motion of a conical wheel set (section 2.2.1),
    ``2 pi sqrt(R b / gamma)``.

    Parameters
    ----------
    conicity : float
        gamma, slope of the cones (or the equivalent conicity) [-].
    radius : float
        R, of the wheels in mid-position [length].
    half_gauge : float
        b [length].

    Returns
    -------
    float
        [length]; the frequency is the speed divided by it.

    Raises
    ------
    SceneError
        If one is not positive and finite.

    Examples
    --------
    >>> print(f"{klingel_wavelength(1 / 40, 0.5, 0.715):.1f} m")
    23.8 m
    """
    gamma = positive("conicity", conicity)
    R = positive("radius", radius)
    b = positive("half_gauge", half_gauge)
    return 2 * math.pi * math.sqrt(R * b / gamma)


def ball_between_planes(force: float, angle: float, nu: float) -> float:
    """Lateral force on a ball that rolls between two planes at an angle
    (section 2.2.2, Johnson 1959).

    The sum of the components of the two normal forces and of what spin makes by
    the linear theory, with the lateral creepage held at zero.

    Parameters
    ----------
    force : float
        N, normal force at each contact [force].
    angle : float
        gamma, half the angle between the planes [rad].
    nu : float
        Poisson's ratio.

    Returns
    -------
    float
        ``2 N gamma (1 - 3 (1 - nu) C23 / 4)`` [force].

    Raises
    ------
    SceneError
        If the force is not positive, the angle not finite, or nu out of range.

    Notes
    -----
    Hertz's circle has ``a^3 = 3 N R (1 - nu)/(4 G)``, spin is ``gamma/R``, and the linear theory's
    force by it ``G a^3 C23 gamma/R``. The paper prints 16 in place of 4.

    Examples
    --------
    >>> print(f"{ball_between_planes(1.0, 1.0, 0.25):.2f} N gamma")
    0.35 N gamma
    """
    N = positive("force", force)
    gamma = number("angle", angle)
    C23 = float(creepage_coefficients(1.0, 1.0, nu).C23)
    return 2 * N * gamma * (1 - 3 * (1 - nu) * C23 / 4)
