"""Laws of friction: a static and a kinetic coefficient (37), and coefficients that fall with slip velocity."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError

LEAST, MOST = 1e-20, 1e20
"""Between these are finite coefficients that are not zero: beyond, products leave the range of floating point."""


@dataclass(frozen=True)
class StaticKinetic:
    """Two coefficients of friction (37): ``|p| <= static pz`` where it sticks, ``|p| = kinetic pz`` where it slips.

    Parameters
    ----------
    static : float
        Coefficient where it sticks, positive.
    kinetic : float
        Coefficient where it slips, in [0, static].

    Raises
    ------
    SceneError
        For coefficients out of range.

    Examples
    --------
    >>> StaticKinetic(static=0.4, kinetic=0.3)([0.0, 1e-6, 1e-3])
    array([0.4, 0.3, 0.3])
    """

    continuous: ClassVar[bool] = False

    static: float
    kinetic: float

    def __post_init__(self) -> None:
        _check_coefficients(self)

    def __call__(self, slip: Any) -> np.ndarray:
        """Coefficient at the size of a relative slip (any shape), `Solution.slip`."""
        return np.where(_sizes(slip) > 0, self.kinetic, self.static)

    def slope(self, slip: Any) -> np.ndarray:
        """Its derivative by the relative slip, where it slips.

        Parameters
        ----------
        slip : array_like
            Relative slip [-], or in a shift the slip itself [length].

        Returns
        -------
        ndarray
            Of the shape of `slip`, by its unit.
        """
        return np.zeros_like(_sizes(slip))


@dataclass(frozen=True)
class _Falling(ABC):
    """A coefficient that falls from static to kinetic; see the laws for the form of the fall."""

    continuous: ClassVar[bool] = True

    static: float
    kinetic: float
    half_velocity: float
    velocity: float = 1.0

    def __post_init__(self) -> None:
        _check_coefficients(self)
        checks.entries(self, "friction", checks.positive, "half_velocity", "velocity")
        if not 1 / checks.LARGE <= self.half_velocity / self.velocity <= checks.LARGE:
            raise SceneError(
                "friction.half_velocity", self.half_velocity, f"within {checks.LARGE:g} times friction.velocity"
            )

    def __call__(self, slip: Any) -> np.ndarray:
        """Coefficient at the size of a relative slip (any shape), `Solution.slip`."""
        part, _ = self._fall(self._scaled(slip))
        return np.asarray(self.kinetic + (self.static - self.kinetic) * part)

    def slope(self, slip: Any) -> np.ndarray:
        """Its derivative by the relative slip; of the linear law that from the left at the end of the fall."""
        _, slope = self._fall(self._scaled(slip))
        return np.asarray((self.static - self.kinetic) * slope * (self.velocity / self.half_velocity))

    def _scaled(self, slip: Any) -> np.ndarray:
        """Slip velocity by the one at which half is lost."""
        return np.minimum(_sizes(slip) * (self.velocity / self.half_velocity), checks.LARGE)

    @abstractmethod
    def _fall(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What is left of ``static - kinetic`` at t, 1/2 at t = 1; and its derivative."""


class LinearFalling(_Falling):
    """A coefficient that falls linearly: ``max(kinetic, static - (static - kinetic) s/(2 h))`` at the slip velocity s.

    Parameters
    ----------
    static : float
        Coefficient without slip, positive.
    kinetic : float
        Coefficient at high slip velocity, in [0, static].
    half_velocity : float
        h, slip velocity at which half of ``static - kinetic`` is lost [length/time], positive; of the linear law
        all is lost at 2 h.
    velocity : float
        Rolling velocity V in the same unit, positive: the slip velocity is V times the relative slip
        `Solution.slip`. 1 if not given: then `half_velocity` is a relative slip [-]. In a shift slip is a length,
        and V one by its duration; if that is not given, `half_velocity` is a length.

    Raises
    ------
    SceneError
        For entries out of range.

    Examples
    --------
    >>> LinearFalling(static=0.4, kinetic=0.2, half_velocity=0.05, velocity=20.0)([0.0, 0.0025, 0.005, 0.05])
    array([0.4, 0.3, 0.2, 0.2])
    """

    def _fall(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.maximum(1 - t / 2, 0.0), np.where(t <= 2, -0.5, 0.0)


class RationalFalling(_Falling):
    """A coefficient that falls as ``kinetic + (static - kinetic)/(1 + s/h)`` with the slip velocity s.

    Parameters
    ----------
    static, kinetic, half_velocity, velocity
        As of `LinearFalling`.

    Raises
    ------
    SceneError
        For entries out of range.

    Examples
    --------
    >>> RationalFalling(static=0.4, kinetic=0.2, half_velocity=0.05, velocity=20.0)([0.0, 0.0025, 0.0225])
    array([0.4 , 0.3 , 0.22])
    """

    def _fall(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return 1 / (1 + t), -1 / (1 + t) ** 2


class ExponentialFalling(_Falling):
    """A coefficient that falls as ``kinetic + (static - kinetic) exp(-ln 2 s/h)`` with the slip velocity s.

    Parameters
    ----------
    static, kinetic, half_velocity, velocity
        As of `LinearFalling`. For ``exp(-s/s0)`` give h = s0 ln 2.

    Raises
    ------
    SceneError
        For entries out of range.

    Examples
    --------
    >>> ExponentialFalling(static=0.4, kinetic=0.2, half_velocity=0.05, velocity=20.0)([0.0, 0.0025, 0.005])
    array([0.4 , 0.3 , 0.25])
    """

    def _fall(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        part = np.exp2(-t)
        return part, -np.log(2) * part


Law = StaticKinetic | LinearFalling | RationalFalling | ExponentialFalling

LAWS: dict[str, type[Law]] = {
    "static-kinetic": StaticKinetic,
    "linear": LinearFalling,
    "rational": RationalFalling,
    "exponential": ExponentialFalling,
}
"""The laws by their kind in a scene file."""


def coefficient(field: str, value: Any) -> float | Law:
    """A coefficient of friction, or a law of it."""
    if isinstance(value, Law):
        return value
    allowed = "zero or positive (inf: no slip), or a law"
    number = checks.real(field, value, allowed)
    if number < 0:
        raise SceneError(field, value, allowed)
    if not (number in (0, np.inf) or LEAST <= number <= MOST):
        raise SceneError(field, number, f"0, between {LEAST:g} and {MOST:g}, or inf (no slip)")
    return number


def kind_of(law: Law) -> str:
    """The kind of a law."""
    return next(kind for kind, cls in LAWS.items() if isinstance(law, cls))


BRANCHES = {
    "stick": "stick everywhere",
    "slip": "slip everywhere",
    "solution": "a solution",
    "history": "the step before",
}
"""From where a solution under a law is sought, in words."""


def _sizes(slip: Any) -> np.ndarray:
    """Sizes of slips, checked; infinite ones are allowed."""
    allowed = "numbers, zero or positive: sizes of slip"
    sizes = checks.numbers("slip", slip, allowed, most=np.inf)
    if np.any(sizes < 0):
        raise SceneError("slip", float(sizes.min()), allowed)
    return sizes


def _check_coefficients(law: StaticKinetic | _Falling) -> None:
    checks.entries(law, "friction", checks.positive, "static")
    if not LEAST <= law.static <= MOST:
        raise SceneError("friction.static", law.static, f"between {LEAST:g} and {MOST:g}")
    checks.entries(law, "friction", checks.number, "kinetic")
    if not 0 <= law.kinetic <= law.static:
        raise SceneError("friction.kinetic", law.kinetic, f"in [0, static] = [0, {law.static:g}]")
