"""Outputs of a contact as functions of its fields, with their partial derivatives."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.elasticity.operators import GridOperator
from varcontact.errors import SceneError
from varcontact.gradients.contact_fields import ContactFields

Weight = float | np.ndarray | Callable[[np.ndarray, np.ndarray], np.ndarray]


def no_creepages() -> np.ndarray:
    return np.zeros(3)


@dataclass(frozen=True, eq=False)
class Partial:
    """Partial derivatives of an output by fields, physical: of unknowns, and of prescribed
    creepages alike.
    """

    pressure: np.ndarray | float = 0.0
    traction: np.ndarray | float = 0.0
    creepage: np.ndarray = field(default_factory=no_creepages)
    approach: float = 0.0


class Output(ABC):
    """A scalar function of the fields of a contact."""

    unit: str = ""
    """Quantity whose unit it has, as `Units.of` names it."""

    @property
    def needs_motion(self) -> bool:
        """True for outputs that depend on tractions."""
        return True

    @abstractmethod
    def value(self, fields: ContactFields) -> float:
        """The output by `fields`."""

    @abstractmethod
    def partial(self, fields: ContactFields) -> Partial:
        """Partial derivatives of the output with respect to `fields`."""


@dataclass(frozen=True, eq=False)
class Weighted(Output):
    """Integral ``sum(w p + w_x q_x + w_y q_y) dA`` over pressure and tractions: forces, moments,
    any linear functional.

    Parameters
    ----------
    pressure : float, array_like (ny, nx) or callable
        Weight of the pressure; a function of x and y (arrays of places).
    traction : pair of the same
        Weights of the tractions on body 1 along x and y.
    name : str
        Name of the output in the answer.
    unit : str
        Quantity whose unit it has, as `Units.of` names it: "force", "moment".

    Examples
    --------
    >>> import varcontact as vc
    >>> right_half = vc.Weighted(pressure=lambda x, y: x > 0, name="right_half")
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Paraboloids(100.0, 100.0),
    ...     normal_force=1e-3, grid=vc.Grid(nx=12, ny=12))
    >>> answer = vc.solve(scene).gradient(right_half, by="normal_force")
    >>> print(f"{float(answer.normal_force):.3f}")
    0.500
    """

    pressure: Weight = 0.0
    traction: tuple[Weight, Weight] = (0.0, 0.0)
    name: str = "weighted"
    unit: str = ""

    @property
    def needs_motion(self) -> bool:
        return any(callable(weight) or np.any(weight) for weight in self.traction)

    def value(self, fields: ContactFields) -> float:
        total = 0.0
        weights = (self.pressure, *self.traction)
        stresses = (fields.pressure, *fields.traction)
        for weight, stress in zip(weights, stresses, strict=True):
            if callable(weight) or np.any(weight):
                total += float(np.sum(_on_elements(weight, fields) * stress))
        return total * fields.area

    def partial(self, fields: ContactFields) -> Partial:
        pressure, along_x, along_y = (
            _on_elements(weight, fields) * fields.area for weight in (self.pressure, *self.traction)
        )
        return Partial(pressure=pressure, traction=np.array([along_x, along_y]))


def _on_elements(weight: Weight, fields: ContactFields) -> np.ndarray:
    """A weight on the elements, (ny, nx)."""
    value: Any = weight
    if callable(weight):
        value = weight(*fields.places)
    shape = fields.disc.grid.shape
    try:
        return np.broadcast_to(np.asarray(value, float), shape)
    except ValueError:
        raise checks.wrong_shape("output", np.shape(value), str(shape)) from None


class Approach(Output):
    """Approach of the bodies."""

    unit = "length"

    @property
    def needs_motion(self) -> bool:
        return False

    def value(self, fields: ContactFields) -> float:
        return fields.approach

    def partial(self, fields: ContactFields) -> Partial:
        return Partial(approach=1.0)


@dataclass(frozen=True, eq=False)
class Creepage(Output):
    """Creepage, or component of a shift, that follows from a prescribed force."""

    component: int
    unit = "creepage"

    def value(self, fields: ContactFields) -> float:
        return float(fields.creepage[self.component])

    def partial(self, fields: ContactFields) -> Partial:
        return Partial(creepage=np.eye(3)[self.component])


@dataclass(frozen=True, eq=False)
class PeakPressure(Output):
    """Largest pressure, or a smooth stand-in for optimisation: the k-norm ``(sum p^k)^(1/k)`` of
    the pressures of all elements.

    Parameters
    ----------
    power : float
        k, at least 1; infinite for the largest pressure itself.

    Raises
    ------
    SceneError
        For a power below 1.

    Examples
    --------
    >>> PeakPressure(power=8).power
    8
    """

    power: float = np.inf
    unit = "pressure"

    @property
    def needs_motion(self) -> bool:
        return False

    def __post_init__(self) -> None:
        if not checks.real("power", self.power) >= 1:
            raise SceneError("power", self.power, "at least 1")

    @property
    def name(self) -> str:
        return "peak_pressure"

    def value(self, fields: ContactFields) -> float:
        largest = float(fields.pressure.max())
        if np.isinf(self.power):
            return largest
        return largest * float(((fields.pressure / largest) ** self.power).sum()) ** (
            1 / self.power
        )

    def partial(self, fields: ContactFields) -> Partial:
        pressure = fields.pressure
        if np.isinf(self.power):
            # elements that tie by symmetry share it, which inputs that keep the symmetry need
            ties = pressure >= pressure.max() * (1 - 1e-10)
            return Partial(pressure=ties / ties.sum())
        return Partial(pressure=(pressure / self.value(fields)) ** (self.power - 1))


class ContactArea(Output):
    """Area of contact, by the dispersion of the pressure: of an elliptic pressure distribution its
    ellipse.

    The number of elements in contact is a step function, without a derivative.
    """

    unit = "area"

    @property
    def needs_motion(self) -> bool:
        return False

    def value(self, fields: ContactFields) -> float:
        return float(np.sqrt(self._extents(fields)[0].prod()))

    def partial(self, fields: ContactFields) -> Partial:
        squared, slopes = self._extents(fields)
        value = float(np.sqrt(squared.prod()))
        relative = np.tensordot(1 / squared, slopes, 1)
        return Partial(pressure=value / 2 * relative)

    @staticmethod
    def _extents(fields: ContactFields) -> tuple[np.ndarray, np.ndarray]:
        """Squares of the extents whose product is the squared area, and their derivatives by
        pressures.

        Hertz's pressure has the variances a^2/5 and b^2/5; in line contact a^2/4.
        """
        pressure = fields.pressure
        total = pressure.sum()
        factors = [5.0 * np.pi, 5.0 * np.pi]
        if fields.disc.grid.line:
            factors = [4.0 * 4.0]
        squared = []
        slopes = []
        for factor, along in zip(factors, fields.places, strict=False):
            middle = (pressure * along).sum() / total
            variance = (pressure * (along - middle) ** 2).sum() / total
            squared.append(factor * variance)
            slopes.append(factor * ((along - middle) ** 2 - variance) / total)
        return np.array(squared), np.array(slopes)


class FrictionWork(Output):
    """Work lost by friction: per distance rolled, or of a shift ``-sum q.E dA``."""

    unit = "work"

    def value(self, fields: ContactFields) -> float:
        slip = fields.local_shift
        if fields.disc.step is not None:
            slip = self._slip(fields)
        return -float((fields.traction * slip).sum() * fields.area)

    def partial(self, fields: ContactFields) -> Partial:
        if fields.disc.step is None:
            return self._partial_of_shift(fields)
        pressure: np.ndarray | float = 0.0
        if fields.disc.K != 0:
            back = self._mean_by_pressure(fields).transposed.apply(fields.traction)[0]
            pressure = -back * fields.compliance / fields.rolled * fields.area
        return Partial(pressure, -self._slip(fields) * fields.area, self._by_creepage(fields))

    def _partial_of_shift(self, fields: ContactFields) -> Partial:
        disc = fields.disc
        back = disc.tangential_operator.transposed.apply(fields.traction)
        if disc.edge_compliance is not None:
            back = back + disc.edge_compliance * fields.traction
        traction = -(fields.local_shift + back * fields.compliance) * fields.area
        pressure: np.ndarray | float = 0.0
        if disc.K != 0:
            by_pressure = disc.pressure_to_shift.transposed.apply(fields.traction)[0]
            pressure = -by_pressure * fields.compliance * fields.area
        return Partial(pressure, traction, self._by_creepage(fields))

    def _slip(self, fields: ContactFields) -> np.ndarray:
        """Slip at the centres, the mean over a path: rigid, and by pressures of unlike bodies."""
        x, y = fields.places
        vx, vy, spin = fields.creepage
        slip = np.array([vx - spin * y, vy + spin * x])
        slip = slip + fields.disc.slip_of_elements / fields.rolled
        if fields.disc.K != 0:
            by_pressure = self._mean_by_pressure(fields).apply(fields.pressure[None])
            slip = slip + by_pressure * fields.compliance / fields.rolled
        return slip

    @staticmethod
    def _mean_by_pressure(fields: ContactFields) -> GridOperator:
        """The even part of the shifts by pressures, which does work over a path."""
        operator = fields.disc.pressure_to_shift
        if not operator.toeplitz:
            allowed = "another one: friction work of unlike bodies by numbers of their own places"
            raise SceneError("output", "friction_work", allowed)
        return GridOperator(operator.shape, (operator.table + operator.table[..., ::-1, ::-1]) / 2)

    @staticmethod
    def _by_creepage(fields: ContactFields) -> np.ndarray:
        x, y = fields.places
        along_x, along_y = fields.traction
        moment = (x * along_y - y * along_x).sum()
        return -np.array([along_x.sum(), along_y.sum(), moment]) * fields.area


OUTPUTS: dict[str, Output] = {
    "Fx": Weighted(traction=(1.0, 0.0), unit="force"),
    "Fy": Weighted(traction=(0.0, 1.0), unit="force"),
    "Mz": Weighted(traction=(lambda x, y: -y, lambda x, y: x), unit="moment"),
    "normal_force": Weighted(pressure=1.0, unit="force"),
    "approach": Approach(),
    "vx": Creepage(0),
    "vy": Creepage(1),
    "ux": Creepage(0),
    "uy": Creepage(1),
    "peak_pressure": PeakPressure(),
    "contact_area": ContactArea(),
    "friction_work": FrictionWork(),
}
"""Outputs by name."""


def output_of(named: str | Output) -> tuple[str, Output]:
    """An output with its name."""
    if isinstance(named, Output):
        return getattr(named, "name", type(named).__name__), named
    name = checks.choice("output", named, OUTPUTS)
    return name, OUTPUTS[name]
