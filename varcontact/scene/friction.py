"""Laws of friction by slip: a static and a kinetic coefficient (37),
coefficients that fall with slip, and memory.

With a memory distance d a particle's coefficient goes over to that of the law
by the distance it slides: ``df/dt = (law(s) - f) max(s, s0)/d``. Source: E.
Vollebregt, H. Schuttelaars, J. Sound Vib. 331 (2012) 2141-2155.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar, Literal, get_args

import numpy as np

from varcontact import checks
from varcontact.checks import Checked
from varcontact.errors import SceneError
from varcontact.scene.grid import Grid

COEFFICIENT_MIN = 1e-20
COEFFICIENT_MAX = 1e20
"""Range of finite nonzero coefficients, `COEFFICIENT_MIN` to this: products stay in the range of
floating point."""


MemoryStep = Literal["exact", "implicit"]
MEMORY_STEPS = get_args(MemoryStep)


@dataclass(frozen=True)
class Law(
    Checked,
    ABC,
    path="friction",
    static=checks.positive,
    kinetic=checks.number,
    memory_distance=checks.at_least_zero,
    memory_velocity=checks.at_least_zero,
    memory_step=partial(checks.choice, options=MEMORY_STEPS),
):
    """Law for the coefficient of friction by slip, between a kinetic and a static value."""

    static: float
    kinetic: float
    memory_distance: float = field(default=0.0, kw_only=True)
    memory_velocity: float = field(default=0.0, kw_only=True)
    memory_step: MemoryStep = field(default="exact", kw_only=True)
    local: ClassVar[bool] = False  # whether it depends on more than slip
    warm: ClassVar[bool] = False  # whether it depends on the temperature of the surface
    jumps: ClassVar[bool] = False  # whether the coefficient without memory does, as slip begins

    def __post_init__(self) -> None:
        super().__post_init__()
        if not COEFFICIENT_MIN <= self.static <= COEFFICIENT_MAX:
            raise SceneError(
                "friction.static",
                self.static,
                f"between {COEFFICIENT_MIN:g} and {COEFFICIENT_MAX:g}",
            )
        if not 0 <= self.kinetic <= self.static:
            raise SceneError(
                "friction.kinetic", self.kinetic, f"in [0, static] = [0, {self.static:g}]"
            )
        if self.memory_velocity > 0 and self.memory_distance == 0:
            raise SceneError(
                "friction.memory_velocity", self.memory_velocity, "0 without a memory_distance"
            )

    def on(
        self, slip: Any, temperature: Any = None, pressure: Any = None, x: Any = None, y: Any = None
    ) -> np.ndarray:
        """Coefficient at `slip`, and of other laws at `temperature`, `pressure`, `x` and `y`."""
        return self(slip)

    @property
    def continuous(self) -> bool:
        """True where the coefficient of a particle changes continuously with its slip: also with a
        memory.
        """
        return self.memory_distance > 0 or not self.jumps

    @abstractmethod
    def __call__(self, slip: Any) -> np.ndarray:
        """Coefficient at the size of a relative slip (any shape), without memory."""

    def slope(self, slip: Any) -> np.ndarray:
        """Derivative of the coefficient with respect to relative slip (any shape), in the slip
        area; in a shift per [length].
        """
        return np.zeros_like(slip_sizes(slip))

    def after(self, before: Any, own: Any, slip: np.ndarray, travel: float) -> np.ndarray:
        """Coefficient of particles that had the coefficient `before`, after sliding ``slip *
        travel`` where the law without memory gives `own`.
        """
        least = self.memory_velocity / getattr(self, "velocity", 1.0)
        slid = np.maximum(slip, least) * travel / self.memory_distance
        if self.memory_step == "implicit":
            part = 1 / (1 + slid)
        else:
            part = np.exp(-slid)
        return np.asarray(own + (before - own) * part)


@dataclass(frozen=True)
class StaticKinetic(Law):
    """Two coefficients of friction (37): ``|p| <= static pz`` where it sticks,
    ``|p| = kinetic pz`` where it slips.

    Parameters
    ----------
    static : float
        Coefficient where it sticks, positive.
    kinetic : float
        Coefficient where it slips, in [0, static].
    memory_distance : float
        Distance of sliding d in which a particle's coefficient goes over to the
        law's, by a part of 1 - 1/e [length], zero (default: at once) or
        positive.
    memory_velocity : float
        Least slip velocity s0 by which it does: at this rate particles that
        stick regain the static coefficient, zero (default) or positive; by the
        rolling velocity [-].
    memory_step : {"exact", "implicit"}
        Whether what a particle keeps in a step is exp(-slid/d), or that of one
        implicit step, 1/(1 + slid/d), as in CONTACT.

    Raises
    ------
    SceneError
        For coefficients out of range.

    Examples
    --------
    >>> StaticKinetic(static=0.4, kinetic=0.3)([0.0, 1e-6, 1e-3])
    array([0.4, 0.3, 0.3])
    """

    jumps: ClassVar[bool] = True

    def __call__(self, slip: Any) -> np.ndarray:
        """Coefficient at the size of a relative slip (any shape), `Solution.slip`."""
        return np.where(slip_sizes(slip) > 0, self.kinetic, self.static)


@dataclass(frozen=True)
class _Falling(Law, half_velocity=checks.positive, velocity=checks.positive):
    """Coefficient that falls from static to kinetic; subclasses give the form of the fall."""

    half_velocity: float
    velocity: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 1 / checks.LARGE <= self.half_velocity / self.velocity <= checks.LARGE:
            allowed = f"within {checks.LARGE:g} times friction.velocity"
            raise SceneError("friction.half_velocity", self.half_velocity, allowed)

    def __call__(self, slip: Any) -> np.ndarray:
        """Coefficient at the size of a relative slip (any shape), `Solution.slip`."""
        part, _ = self._fall(self._scaled(slip))
        return np.asarray(self.kinetic + (self.static - self.kinetic) * part)

    def slope(self, slip: Any) -> np.ndarray:
        """Derivative of the coefficient with respect to relative slip; for the linear law the left
        derivative at the end of the fall.
        """
        _, slope = self._fall(self._scaled(slip))
        return np.asarray(
            (self.static - self.kinetic) * slope * (self.velocity / self.half_velocity)
        )

    def _scaled(self, slip: Any) -> np.ndarray:
        """Slip velocity divided by the velocity at which half of the fall is reached."""
        return np.minimum(slip_sizes(slip) * (self.velocity / self.half_velocity), checks.LARGE)

    @abstractmethod
    def _fall(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Remaining part of ``static - kinetic`` at t, 1/2 at t = 1; and its derivative."""


class LinearFalling(_Falling):
    """A coefficient that falls linearly:
    ``max(kinetic, static - (static - kinetic) s/(2 h))`` at the slip velocity
    s.

    Parameters
    ----------
    static : float
        Coefficient without slip, positive.
    kinetic : float
        Coefficient at high slip velocity, in [0, static].
    half_velocity : float
        h, slip velocity at which half of ``static - kinetic`` is lost
        [length/time], positive; of the linear law all is lost at 2 h.
    velocity : float
        Rolling velocity V in the same unit, positive: the slip velocity is V
        times the relative slip `Solution.slip`. 1 if not given: then
        `half_velocity` is a relative slip [-]. In a shift slip is a length, and
        V one by its duration; if that is not given, `half_velocity` is a
        length.
    memory_distance : float
        Distance of sliding d in which a particle's coefficient goes over to the
        law's, by a part of 1 - 1/e [length], zero (default: at once) or
        positive.
    memory_velocity : float
        Least slip velocity s0 by which it does: at this rate particles that
        stick regain the static coefficient, zero (default) or positive; in the
        unit of `half_velocity`.
    memory_step : {"exact", "implicit"}
        As of `StaticKinetic`.

    Raises
    ------
    SceneError
        For entries out of range.

    Examples
    --------
    >>> law = LinearFalling(static=0.4, kinetic=0.2, half_velocity=0.05, velocity=20.0)
    >>> law([0.0, 0.0025, 0.005, 0.05])
    array([0.4, 0.3, 0.2, 0.2])
    """

    def _fall(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.maximum(1 - t / 2, 0.0), np.where(t <= 2, -0.5, 0.0)


class RationalFalling(_Falling):
    """A coefficient that falls as ``kinetic + (static - kinetic)/(1 + s/h)``
    with the slip velocity s.

    Parameters
    ----------
    static, kinetic, half_velocity, velocity, memory_distance, memory_velocity, memory_step
        As of `LinearFalling`.

    Raises
    ------
    SceneError
        For entries out of range.

    Examples
    --------
    >>> law = RationalFalling(static=0.4, kinetic=0.2, half_velocity=0.05, velocity=20.0)
    >>> law([0.0, 0.0025, 0.0225])
    array([0.4 , 0.3 , 0.22])
    """

    def _fall(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return 1 / (1 + t), -1 / (1 + t) ** 2


class ExponentialFalling(_Falling):
    """A coefficient that falls as
    ``kinetic + (static - kinetic) exp(-ln 2 s/h)`` with the slip velocity s.

    Parameters
    ----------
    static, kinetic, half_velocity, velocity, memory_distance, memory_velocity, memory_step
        As of `LinearFalling`. For ``exp(-s/s0)`` give h = s0 ln 2.

    Raises
    ------
    SceneError
        For entries out of range.

    Examples
    --------
    >>> law = ExponentialFalling(static=0.4, kinetic=0.2, half_velocity=0.05, velocity=20.0)
    >>> law([0.0, 0.0025, 0.005])
    array([0.4 , 0.3 , 0.25])
    """

    def _fall(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        part = np.exp2(-t)
        return part, -np.log(2) * part


class FrictionBound(ABC):
    """Friction whose traction bound is known by pressure and place: it needs no passes."""

    rolls_along: ClassVar[bool] = False
    """True where the friction moves with the particles, in histories only."""

    @abstractmethod
    def bound(self, pressure: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The traction bound g under a pressure at places (ny, nx), physical; zero without
        contact.
        """

    def at_step(self, grid: Grid, rolled: float) -> float | np.ndarray | FrictionBound:
        """The friction of a step of a history, after a distance rolled towards positive x
        [length].
        """
        return self


Coefficient = float | Law
"""Coefficient of friction, or a law for it."""
Friction = Coefficient | FrictionBound | np.ndarray
"""Everything that the friction of a scene may be."""


def coefficient(field: str, value: Any) -> float | Law | FrictionBound:
    """A coefficient of friction, a law of it, or a traction bound."""
    if type(value) is float and COEFFICIENT_MIN <= value <= COEFFICIENT_MAX:  # the usual case
        return value
    if isinstance(value, Law | FrictionBound):
        return value
    allowed = "zero or positive (inf: no slip), or a law"
    number = checks.real(field, value, allowed)
    if number < 0:
        raise SceneError(field, value, allowed)
    if not (number in (0, np.inf) or COEFFICIENT_MIN <= number <= COEFFICIENT_MAX):
        raise SceneError(
            field,
            number,
            f"0, between {COEFFICIENT_MIN:g} and {COEFFICIENT_MAX:g}, or inf (no slip)",
        )
    return number


BRANCHES = {
    "stick": "stick everywhere",
    "slip": "slip everywhere",
    "solution": "a solution",
    "history": "the step before",
}
"""Starting points of the search for a solution under a friction law, in words."""


def slip_sizes(slip: Any) -> np.ndarray:
    """Sizes of slips, checked; infinite ones are allowed."""
    allowed = "numbers, zero or positive: sizes of slip"
    sizes = checks.numbers("slip", slip, allowed, most=np.inf)
    checks.require_all("slip", sizes, sizes >= 0, allowed)
    return sizes


def bound_under(
    friction: Any, pressure: np.ndarray, slip: np.ndarray, x: np.ndarray, y: np.ndarray
) -> np.ndarray:
    """The traction bound of a scene's friction under pressures and slips at points (ny, nx)."""
    if isinstance(friction, FrictionBound):
        return friction.bound(pressure, x, y)
    if isinstance(friction, Law):
        return np.asarray(friction.on(slip, None, pressure, x, y) * pressure)
    coefficient = np.broadcast_to(np.asarray(friction, float), pressure.shape)
    return np.asarray(np.nan_to_num(coefficient, posinf=0.0) * pressure)
