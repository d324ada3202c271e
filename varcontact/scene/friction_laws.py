"""Laws of friction by more than slip: by temperature, pressure, place, and products with functions
of the user.
"""

from __future__ import annotations

import inspect
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.scene.friction import (
    ExponentialFalling,
    Law,
    LinearFalling,
    RationalFalling,
    StaticKinetic,
    slip_sizes,
)

ARGUMENTS = ("slip_velocity", "temperature", "pressure", "x", "y")
"""Arguments that a function for `FrictionLaw` may take, by name."""
ROUNDING = 1e-9
"""Excess of a product of factors over its limits that counts as rounding."""


class LocalLaw(Law):
    """Coefficient that depends on more than slip."""

    local: ClassVar[bool] = True
    at: ClassVar[Any]  # coefficient by temperature or by pressure, where it depends on nothing else

    def __call__(self, slip: Any) -> np.ndarray:
        """Largest coefficient, at any `slip`: nothing else is known here."""
        return np.full_like(slip_sizes(slip), self.static)

    def on(
        self, slip: Any, temperature: Any = None, pressure: Any = None, x: Any = None, y: Any = None
    ) -> np.ndarray:
        """Coefficient at a `temperature`, or at a `pressure`, whatever `slip`, `x` and `y`."""
        if self.warm:
            return np.asarray(self.at(temperature))
        return np.asarray(self.at(pressure))


@dataclass(frozen=True)
class TemperatureFalling(LocalLaw, reference=checks.number, over=checks.positive):
    """A coefficient that falls linearly with the temperature of the surface, in
    steady rolling and histories.

    Parameters
    ----------
    static, kinetic : float
        Coefficients of cold surfaces, positive, and of hot ones, in [0,
        static].
    reference, over : float
        It falls from the temperature `reference` on, over a range `over`
        (positive).
    memory_distance, memory_velocity : float
        As of `StaticKinetic`.
    memory_step : {"exact", "implicit"}
        As of `StaticKinetic`.

    Raises
    ------
    SceneError
        For entries out of range.

    Examples
    --------
    >>> law = TemperatureFalling(static=0.4, kinetic=0.2, reference=20.0, over=400.0)
    >>> law.at([0.0, 220.0, 900.0])
    array([0.4, 0.3, 0.2])
    """

    reference: float = 0.0
    over: float = 1.0
    warm: ClassVar[bool] = True

    def at(self, temperature: Any) -> np.ndarray:
        """Coefficient at a `temperature` (any shape)."""
        part = np.clip(
            (np.asarray(temperature, dtype=float) - self.reference) / self.over, 0.0, 1.0
        )
        return np.asarray(self.static + part * (self.kinetic - self.static))


@dataclass(frozen=True)
class PressureFalling(LocalLaw, strength=checks.positive):
    """A coefficient that falls with the pressure: the surfaces shear at a
    stress ``strength + kinetic p``.

    It is ``min(static, kinetic + strength/p)``. Source: B. J. Briscoe, D.
    Tabor, J. Adhesion 9 (1978) 145-155, of films between surfaces.

    Parameters
    ----------
    static, kinetic : float
        Coefficients at low pressure, positive, and at high pressure, in [0,
        static].
    strength : float
        Shear strength without pressure, positive [stress].
    memory_distance, memory_velocity : float
        As of `StaticKinetic`.
    memory_step : {"exact", "implicit"}
        As of `StaticKinetic`.

    Raises
    ------
    SceneError
        For entries out of range.

    Examples
    --------
    >>> PressureFalling(static=0.4, kinetic=0.1, strength=50.0).at([0.0, 100.0, 250.0, 1000.0])
    array([0.4 , 0.4 , 0.3 , 0.15])
    """

    strength: float = 1.0

    def at(self, pressure: Any) -> np.ndarray:
        """Coefficient at a `pressure` (any shape)."""
        rest = self.strength / np.maximum(
            np.asarray(pressure, dtype=float), self.strength / self.static
        )
        return np.minimum(self.static, self.kinetic + rest)


@dataclass(frozen=True, eq=False)
class FrictionLaw(LocalLaw, velocity=checks.positive):
    """A product of laws, of coefficients by place and of functions of your own.

    Parameters
    ----------
    static, kinetic : float
        The largest and the least coefficient that the product has: searches
        begin there, from stick and from slip.
    factors : law, array_like of shape (ny, nx), array (nx,) in line contact, callable, or sequence
    of these
        Laws that change continuously, without memory; coefficients by place;
        functions ``f(slip_velocity=, temperature=, pressure=, x=, y=)`` of
        those of these arguments that they name, all arrays (ny, nx), which
        return a number or such an array. Where it sticks the slip velocity is
        zero.
    velocity : float
        Rolling velocity for the functions, positive: slip velocity by relative
        slip, 1 (default) as of `LinearFalling`.
    memory_distance, memory_velocity : float
        As of `LinearFalling`; for the product.
    memory_step : {"exact", "implicit"}
        As of `StaticKinetic`.

    Raises
    ------
    SceneError
        For entries out of range; for factors that give no number or a negative
        one, in another shape; from `solve` for a product outside of [kinetic,
        static].

    Examples
    --------
    >>> wet = np.array([[1.0, 0.5]])
    >>> falling = lambda slip_velocity: 0.4 / (1 + slip_velocity / 0.1)
    >>> law = FrictionLaw(0.4, 0.0, [falling, wet], velocity=20.0)
    >>> law.on(slip=np.array([[0.0, 0.005]]))
    array([[0.4, 0.1]])
    """

    factors: Any = ()
    velocity: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        factors = _listed(self.factors)
        if not factors:
            raise SceneError("friction.factors", self.factors, "one factor at least")
        object.__setattr__(self, "factors", tuple(_factor(each) for each in factors))
        object.__setattr__(
            self, "warm", any(_depends_on_temperature(each) for each in self.factors)
        )
        # each function is called once, as a trial
        example = {
            name: np.full((2, 3), value)
            for name, value in zip(ARGUMENTS, (0.0, 20.0, 1.0, 0.0, 0.0), strict=True)
        }
        for each in self.factors:
            if callable(each) and not isinstance(each, Law):
                _called(each, example)

    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def on(
        self, slip: Any, temperature: Any = None, pressure: Any = None, x: Any = None, y: Any = None
    ) -> np.ndarray:
        """Coefficient at `slip`, `temperature`, `pressure`, `x` and `y`, arrays of one shape."""
        fields = temperature, pressure, x, y
        arguments = dict(zip(ARGUMENTS, (slip_sizes(slip) * self.velocity, *fields), strict=True))
        product = np.ones(np.shape(slip))
        for factor in self.factors:
            if isinstance(factor, Law):
                product = product * factor.on(slip, *fields)
            elif isinstance(factor, np.ndarray):
                product = product * factor
            else:
                product = product * _called(factor, arguments)
        self._check_range(product)
        return product

    def _check_range(self, product: np.ndarray) -> None:
        """Refuse a product outside of [kinetic, static]."""
        least = float(product.min(initial=self.static))
        most = float(product.max(initial=self.kinetic))
        if not (least < self.kinetic - ROUNDING or most > self.static * (1 + ROUNDING)):
            return
        outside = least
        if most > self.static:
            outside = most
        allowed = f"a product in [kinetic, static] = [{self.kinetic:g}, {self.static:g}]"
        raise SceneError("friction.factors", outside, allowed)


LAWS: dict[str, type[Law]] = {
    "static-kinetic": StaticKinetic,
    "linear": LinearFalling,
    "rational": RationalFalling,
    "exponential": ExponentialFalling,
    "temperature": TemperatureFalling,
    "pressure": PressureFalling,
    "product": FrictionLaw,
}
"""The laws by their kind in a scene file."""


def kind_of(friction: Any) -> str:
    """The kind of a law of friction, "given" of numbers and known bounds."""
    return next((kind for kind, law in LAWS.items() if isinstance(friction, law)), "given")


def _listed(factors: Any) -> tuple[Any, ...]:
    """The factors one by one; rows of numbers are one field."""
    if not isinstance(factors, list | tuple):
        return (factors,)
    rows = all(isinstance(each, list | tuple) for each in factors)
    if factors and rows and np.ndim(factors[0][0]) == 0:
        return (factors,)
    return tuple(factors)


def _depends_on_temperature(factor: Any) -> bool:
    if isinstance(factor, Law):
        return factor.warm
    return "temperature" in _names(factor)


def _factor(given: Any) -> Any:
    """A factor of a friction law, checked."""
    if isinstance(given, Law):
        if given.memory_distance > 0 or not given.continuous:
            raise SceneError(
                "friction.factors", given, "laws that fall continuously, without memory"
            )
        return given
    if callable(given):
        _names(given)
        return given
    if not isinstance(given, np.ndarray | list | tuple):
        raise SceneError(
            "friction.factors", given, "laws, arrays of numbers by place, or functions"
        )
    if np.ndim(given) == 1:
        given = np.asarray(given)[None]
    field = checks.array("friction.factors", given, 2)
    checks.require_all("friction.factors", field, field >= 0, "zero or positive everywhere")
    return field


def _names(function: Any) -> tuple[str, ...]:
    """The arguments that a function takes; an array takes none."""
    if not callable(function):
        return ()
    parameters = inspect.signature(function).parameters.values()
    if any(each.kind is each.VAR_KEYWORD for each in parameters):
        return ARGUMENTS
    unknown = [
        each.name
        for each in parameters
        if each.name not in ARGUMENTS and each.default is each.empty
    ]
    if unknown:
        name = getattr(function, "__name__", function)
        raise SceneError(
            "friction.factors", f"{name}({unknown[0]})", f"of {', '.join(ARGUMENTS)} by name"
        )
    return tuple(each.name for each in parameters if each.name in ARGUMENTS)


def _called(function: Any, arguments: dict[str, Any]) -> np.ndarray:
    """The values of a function for the elements, checked."""
    shape = arguments[ARGUMENTS[0]].shape
    name = getattr(function, "__name__", function)
    try:
        values = np.asarray(function(**{each: arguments[each] for each in _names(function)}))
    except Exception as error:  # the user's own code runs here
        failed = f"{name} failed: {type(error).__name__}: {error}"
        raise SceneError(
            "friction.factors", failed, f"functions of arrays of shape {shape}"
        ) from error
    if values.shape not in ((), shape):
        raise checks.wrong_shape(
            f"friction.factors: {name}", values.shape, f"a number or of shape {shape}"
        )
    allowed = np.zeros(values.shape, bool)
    if values.dtype.kind in "fiu":
        allowed = (values >= 0) & (values < np.inf)
    if not np.all(allowed):
        raise SceneError(
            "friction.factors", f"{name} = {values[~allowed][0]}", "numbers, zero or positive"
        )
    return np.broadcast_to(values.astype(float), shape)
