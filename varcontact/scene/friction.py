"""Laws of friction: a static and a kinetic coefficient (37), coefficients that fall with slip velocity, and memory.

With a memory distance d a particle's coefficient goes over to that of the law by the distance it slides:
``df/dt = (law(s) - f) max(s, s0)/d``. Source: E. Vollebregt, H. Schuttelaars, J. Sound Vib. 331 (2012) 2141-2155.
"""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError

LEAST, MOST = 1e-20, 1e20
"""Between these are finite coefficients that are not zero: beyond, products leave the range of floating point."""
ROUNDING = 1e-9
"""What a product of factors may miss of its limits."""


@dataclass(frozen=True)
class Law(ABC):
    """A coefficient of friction by the slip, between a kinetic and a static one."""

    static: float
    kinetic: float
    memory_distance: float = field(default=0.0, kw_only=True)
    memory_velocity: float = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        checks.entries(self, "friction", checks.positive, "static")
        if not LEAST <= self.static <= MOST:
            raise SceneError("friction.static", self.static, f"between {LEAST:g} and {MOST:g}")
        checks.entries(self, "friction", checks.number, "kinetic")
        if not 0 <= self.kinetic <= self.static:
            raise SceneError("friction.kinetic", self.kinetic, f"in [0, static] = [0, {self.static:g}]")
        for name in ("memory_distance", "memory_velocity"):
            if not 0 <= checks.moderate(f"friction.{name}", getattr(self, name)):
                raise SceneError(f"friction.{name}", getattr(self, name), "zero (no memory) or positive")
        if self.memory_velocity > 0 and self.memory_distance == 0:
            raise SceneError("friction.memory_velocity", self.memory_velocity, "0 without a memory_distance")
        if self.local and self.memory_distance > 0:
            raise SceneError("friction.memory_distance", self.memory_distance, "0: only laws by slip have a memory")

    @property
    def local(self) -> bool:
        """Whether it depends on more than slip."""
        return False

    @property
    def warm(self) -> bool:
        """Whether it depends on the temperature of the surface."""
        return False

    def on(self, slip: Any, temperature: Any = None, pressure: Any = None, x: Any = None, y: Any = None) -> np.ndarray:
        """Coefficient at `slip`, and of other laws at `temperature`, `pressure`, `x` and `y`."""
        return self(slip)

    @property
    def velocity_of_slip(self) -> float:
        """Slip velocity by relative slip."""
        return 1.0

    @property
    @abstractmethod
    def continuous(self) -> bool:
        """Whether the coefficient of a particle changes continuously with its slip."""

    @abstractmethod
    def __call__(self, slip: Any) -> np.ndarray:
        """Coefficient at the size of a relative slip (any shape), without memory."""

    @abstractmethod
    def slope(self, slip: Any) -> np.ndarray:
        """Its derivative by the relative slip, where it slips."""

    def after(self, before: Any, slip: np.ndarray, travel: float) -> np.ndarray:
        """The coefficient of particles that had another one and slid ``slip * travel``."""
        least = self.memory_velocity / self.velocity_of_slip
        part = np.exp(-np.maximum(slip, least) * travel / self.memory_distance)
        return self(slip) + (before - self(slip)) * part


@dataclass(frozen=True)
class StaticKinetic(Law):
    """Two coefficients of friction (37): ``|p| <= static pz`` where it sticks, ``|p| = kinetic pz`` where it slips.

    Parameters
    ----------
    static : float
        Coefficient where it sticks, positive.
    kinetic : float
        Coefficient where it slips, in [0, static].
    memory_distance : float
        Distance of sliding d in which a particle's coefficient goes over to the law's, by a part of 1 - 1/e [length],
        zero (default: at once) or positive.
    memory_velocity : float
        Least slip velocity s0 by which it does: at this rate particles that stick regain the static coefficient,
        zero (default) or positive; by the rolling velocity [-].

    Raises
    ------
    SceneError
        For coefficients out of range.

    Examples
    --------
    >>> StaticKinetic(static=0.4, kinetic=0.3)([0.0, 1e-6, 1e-3])
    array([0.4, 0.3, 0.3])
    """

    @property
    def continuous(self) -> bool:
        """Whether the coefficient of a particle changes continuously with its slip: with a memory."""
        return self.memory_distance > 0

    def __call__(self, slip: Any) -> np.ndarray:
        """Coefficient at the size of a relative slip (any shape), `Solution.slip`."""
        return np.where(_sizes(slip) > 0, self.kinetic, self.static)

    def slope(self, slip: Any) -> np.ndarray:
        """Its derivative by the relative `slip` where it slips, in the shape of that; in a shift by [length]."""
        return np.zeros_like(_sizes(slip))


@dataclass(frozen=True)
class _Falling(Law):
    """A coefficient that falls from static to kinetic; see the laws for the form of the fall."""

    half_velocity: float
    velocity: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
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

    @property
    def continuous(self) -> bool:
        """Whether the coefficient of a particle changes continuously with its slip."""
        return True

    @property
    def velocity_of_slip(self) -> float:
        """Slip velocity by relative slip."""
        return self.velocity

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
    memory_distance : float
        Distance of sliding d in which a particle's coefficient goes over to the law's, by a part of 1 - 1/e [length],
        zero (default: at once) or positive.
    memory_velocity : float
        Least slip velocity s0 by which it does: at this rate particles that stick regain the static coefficient,
        zero (default) or positive; in the unit of `half_velocity`.

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
    static, kinetic, half_velocity, velocity, memory_distance, memory_velocity
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
    static, kinetic, half_velocity, velocity, memory_distance, memory_velocity
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


class _Local(Law):
    """A coefficient by more than slip."""

    @property
    def local(self) -> bool:
        """Whether it depends on more than slip."""
        return True

    @property
    def continuous(self) -> bool:
        """Whether the coefficient of a particle changes continuously with its slip."""
        return True

    def __call__(self, slip: Any) -> np.ndarray:
        """The largest coefficient, at any `slip`: nothing else is known."""
        return np.full_like(_sizes(slip), self.static)

    def slope(self, slip: Any) -> np.ndarray:
        """Its derivative by the relative `slip`: zero."""
        return np.zeros_like(_sizes(slip))


@dataclass(frozen=True)
class TemperatureFalling(_Local):
    """A coefficient that falls linearly with the temperature of the surface, in steady rolling.

    Parameters
    ----------
    static, kinetic : float
        Coefficients of cold surfaces, positive, and of hot ones, in [0, static].
    reference, over : float
        It falls from the temperature `reference` on, over a range `over` (positive).

    Raises
    ------
    SceneError
        For entries out of range.

    Examples
    --------
    >>> TemperatureFalling(static=0.4, kinetic=0.2, reference=20.0, over=400.0).at([0.0, 220.0, 900.0])
    array([0.4, 0.3, 0.2])
    """

    reference: float = 0.0
    over: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.entries(self, "friction", checks.moderate, "reference")
        checks.entries(self, "friction", checks.positive, "over")

    @property
    def warm(self) -> bool:
        """Whether it depends on the temperature of the surface."""
        return True

    def on(self, slip: Any, temperature: Any = None, pressure: Any = None, x: Any = None, y: Any = None) -> np.ndarray:
        """Coefficient at a `temperature`, whatever `slip`, `pressure`, `x` and `y`."""
        return self.at(temperature)

    def at(self, temperature: Any) -> np.ndarray:
        """Coefficient at a `temperature` (any shape)."""
        part = np.clip((np.asarray(temperature, dtype=float) - self.reference) / self.over, 0.0, 1.0)
        return np.asarray(self.static + part * (self.kinetic - self.static))


ARGUMENTS = ("slip_velocity", "temperature", "pressure", "x", "y")
"""What a function for `FrictionLaw` may take, by name."""


@dataclass(frozen=True, eq=False)
class FrictionLaw(_Local):
    """A product of laws, of coefficients by place and of functions of your own, in steady rolling and shifts.

    Parameters
    ----------
    static, kinetic : float
        The largest and the least coefficient that the product has: searches begin there, from stick and from slip.
    factors : law, array_like of shape (ny, nx), callable, or sequence of these
        Laws by slip that fall continuously, without memory; `TemperatureFalling`; coefficients by place; functions
        ``f(slip_velocity=, temperature=, pressure=, x=, y=)`` of those of these arguments that they name, all arrays
        (ny, nx), which return a number or such an array. Where it sticks the slip velocity is zero.
    velocity : float
        Rolling velocity for the functions, positive: slip velocity by relative slip, 1 (default) as of `LinearFalling`.

    Raises
    ------
    SceneError
        For entries out of range; for factors that give no number or a negative one, in another shape; from `solve` for
        a product outside of [kinetic, static].

    Examples
    --------
    >>> wet = np.array([[1.0, 0.5]])
    >>> law = FrictionLaw(0.4, 0.0, [lambda slip_velocity: 0.4 / (1 + slip_velocity / 0.1), wet], velocity=20.0)
    >>> law.on(slip=np.array([[0.0, 0.005]]))
    array([[0.4, 0.1]])
    """

    factors: Any = ()
    velocity: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.entries(self, "friction", checks.positive, "velocity")
        several = isinstance(self.factors, list | tuple) and not _is_field(self.factors)
        factors = tuple(self.factors) if several else (self.factors,)
        if not factors:
            raise SceneError("friction.factors", self.factors, "one factor at least")
        object.__setattr__(self, "factors", tuple(_factor(each) for each in factors))
        known = {name: np.full((2, 3), each) for name, each in zip(ARGUMENTS, (0.0, 20.0, 1.0, 0.0, 0.0), strict=True)}
        for each in self.factors:
            if callable(each) and not isinstance(each, Law):
                _called(each, known)

    __eq__ = object.__eq__
    __hash__ = object.__hash__

    @property
    def warm(self) -> bool:
        """Whether it depends on the temperature of the surface."""
        return any(each.warm if isinstance(each, Law) else "temperature" in _names(each) for each in self.factors)

    @property
    def velocity_of_slip(self) -> float:
        """Slip velocity by relative slip."""
        return self.velocity

    def on(self, slip: Any, temperature: Any = None, pressure: Any = None, x: Any = None, y: Any = None) -> np.ndarray:
        """Coefficient at `slip`, `temperature`, `pressure`, `x` and `y`, arrays of one shape."""
        around = temperature, pressure, x, y
        known = dict(zip(ARGUMENTS, (_sizes(slip) * self.velocity, *around), strict=True))
        found = np.ones(np.shape(slip))
        for each in self.factors:
            own = each.on(slip, *around) if isinstance(each, Law) else each
            found = found * (own if isinstance(own, np.ndarray) else _called(own, known))
        least, most = float(found.min(initial=self.static)), float(found.max(initial=self.kinetic))
        if least < self.kinetic - ROUNDING or most > self.static * (1 + ROUNDING):
            allowed = f"a product in [kinetic, static] = [{self.kinetic:g}, {self.static:g}]"
            raise SceneError("friction.factors", most if most > self.static else least, allowed)
        return found


def _factor(given: Any) -> Any:
    """A factor of a friction law, checked."""
    if isinstance(given, Law):
        if given.memory_distance > 0 or not given.continuous:
            raise SceneError("friction.factors", given, "laws that fall continuously, without memory")
        return given
    if callable(given):
        _names(given)
        return given
    field = checks.array("friction.factors", given, 2)
    if np.any(field < 0):
        raise SceneError("friction.factors", float(field.min()), "zero or positive everywhere")
    return field


def _is_field(factors: Any) -> bool:
    """Whether a sequence is one field of numbers, not several factors."""
    return len(factors) > 0 and all(isinstance(row, list | tuple) for row in factors) and np.ndim(factors[0][0]) == 0


def _names(function: Any) -> tuple[str, ...]:
    """The arguments that a function takes; an array takes none."""
    if not callable(function):
        return ()
    parameters = inspect.signature(function).parameters.values()
    if any(each.kind is each.VAR_KEYWORD for each in parameters):
        return ARGUMENTS
    unknown = [each.name for each in parameters if each.name not in ARGUMENTS and each.default is each.empty]
    if unknown:
        raise SceneError("friction.factors", f"{_name(function)}({unknown[0]})", f"of {', '.join(ARGUMENTS)} by name")
    return tuple(each.name for each in parameters if each.name in ARGUMENTS)


def _name(function: Any) -> str:
    return str(getattr(function, "__name__", function))


def _called(function: Any, known: dict[str, Any]) -> np.ndarray:
    """The values of a function for the elements, checked."""
    found, shape = np.asarray(function(**{name: known[name] for name in _names(function)})), known[ARGUMENTS[0]].shape
    if found.shape not in ((), shape):
        raise checks.wrong_shape(f"friction.factors: {_name(function)}", found.shape, f"a number or of shape {shape}")
    good = (found >= 0) & (found < np.inf) if found.dtype.kind in "fiu" else np.zeros(found.shape, bool)
    if not np.all(good):
        raise SceneError("friction.factors", f"{_name(function)} = {found[~good][0]}", "numbers, zero or positive")
    return np.broadcast_to(found.astype(float), shape)


LAWS: dict[str, type[Law]] = {
    "static-kinetic": StaticKinetic,
    "linear": LinearFalling,
    "rational": RationalFalling,
    "exponential": ExponentialFalling,
    "temperature": TemperatureFalling,
    "product": FrictionLaw,
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
