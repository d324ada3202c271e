"""The protocol of interfaces: potentials of the traction, and the quantities that particles carry.

An interface gives the potential of the traction under the fields that it needs.
Fields that particles bring along from the step before have arrived; those that
the contact itself determines are implicit, and are sought by passes. Without
implicit fields the problem is convex, and a certificate may bound forces. All
fields are dimensionless and on the grid, (ny, nx) or (2, ny, nx).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from varcontact.errors import SceneError
from varcontact.interfaces.potential import Potential
from varcontact.transports import Transport

Fields = Mapping[str, np.ndarray]
"""Fields by the name of their quantity."""


@dataclass(frozen=True)
class Quantity:
    """A quantity that particles carry, or that the contact itself determines."""

    name: str
    kind: str  # its unit: "coefficient", "stress", "length", "temperature"
    fresh: float  # of particles that have not been in contact


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Surroundings of an interface: the transport, the fields that have arrived, and the implicit
    ones of this pass.
    """

    transport: Transport
    arrived: Fields = field(default_factory=dict)
    implicit: Fields = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Response:
    """Response of a contact: pressure, tractions, local shift E, and the bound of friction."""

    pressure: np.ndarray
    traction: np.ndarray
    shift: np.ndarray
    friction_bound: np.ndarray


class Interface(ABC):
    """An interface without memory; each kind says what is different."""

    @property
    def carried(self) -> tuple[Quantity, ...]:
        """The quantities that particles carry from step to step."""
        return ()

    def implicit(self, transport: Transport) -> tuple[Quantity, ...]:
        """The quantities that the contact itself determines."""
        return ()

    @abstractmethod
    def potential(self, pressure: np.ndarray, at: Surroundings) -> Potential:
        """The potential on the grid under a pressure (ny, nx)."""

    def implied(self, response: Response, at: Surroundings) -> Fields:
        """The implicit fields that go with a response, from any source."""
        return {}

    def leave(self, response: Response, flowed: np.ndarray, at: Surroundings) -> Fields:
        """Quantities of the particles at the end of a step in which the shift `flowed`
        (2, ny, nx).
        """
        return {}


def refuse_shared(parts: tuple[Interface, ...]) -> None:
    """Two interfaces must not own the same carried quantity."""
    names = [quantity.name for part in parts for quantity in part.carried]
    shared = sorted({name for name in names if names.count(name) > 1})
    if shared:
        owners = ", ".join(type(part).__name__ for part in parts)
        raise SceneError("interfaces", shared[0], f"carried by one of {owners} only")


@dataclass(frozen=True, eq=False)
class Several(Interface):
    """Interfaces at once: the smallest bound holds, and one may flow."""

    parts: tuple[Interface, ...]

    def __post_init__(self) -> None:
        refuse_shared(self.parts)

    @property
    def carried(self) -> tuple[Quantity, ...]:
        return tuple(each for part in self.parts for each in part.carried)

    def implicit(self, transport: Transport) -> tuple[Quantity, ...]:
        return tuple(each for part in self.parts for each in part.implicit(transport))

    def potential(self, pressure: np.ndarray, at: Surroundings) -> Potential:
        combined = self.parts[0].potential(pressure, at)
        for part in self.parts[1:]:
            combined = combined & part.potential(pressure, at)
        return combined

    def implied(self, response: Response, at: Surroundings) -> Fields:
        fields: dict[str, np.ndarray] = {}
        for part in self.parts:
            fields.update(part.implied(response, at))
        return fields

    def leave(self, response: Response, flowed: np.ndarray, at: Surroundings) -> Fields:
        fields: dict[str, np.ndarray] = {}
        for part in self.parts:
            fields.update(part.leave(response, flowed, at))
        return fields
