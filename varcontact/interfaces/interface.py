"""The protocol of interfaces: potentials of the traction, and the quantities that particles carry.

An interface gives the potential of the traction under the fields that it needs.
Fields that particles bring along from the step before have arrived; those that
the contact itself determines are implicit, and are sought by passes. Without
implicit fields the problem is convex, and a certificate may bound forces. All
fields are dimensionless and on the grid, (ny, nx) or (2, ny, nx).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from varcontact.errors import SceneError
from varcontact.interfaces.potential import Potential
from varcontact.scene.friction import Friction
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Motion
from varcontact.scene.scene import Scene
from varcontact.scene.units import Scales
from varcontact.system.process import lazy_property
from varcontact.transports import Transport, further_along

Fields = Mapping[str, np.ndarray]
"""Fields by the name of their quantity."""

ANY_WAY = "any"
FROM_ONE_SIDE = "one side"
JUMPS = "jumps"
"""Kinds of passes over an implicit quantity: they lead to one solution, and may be accelerated; to
one of several, each reached from its own side; likewise, with a quantity that jumps."""


@dataclass(frozen=True)
class Quantity:
    """A quantity that particles carry, or that the contact itself determines.

    Its unit is that of a `kind`, as `Units.of` has it; particles that have not been in contact have
    the `fresh` value. Implicit ones lie between `least` and `most`.
    """

    name: str
    kind: str
    fresh: float
    words: str = ""
    dims: tuple[str, ...] = ("y", "x")
    least: float = -np.inf
    most: float = np.inf
    passes: str = ANY_WAY

    def scale(self, scales: Scales) -> float:
        """Physical value of a dimensionless 1."""
        sizes = {"pressure": scales.pressure, "length": scales.displacement}
        return sizes.get(self.kind, 1.0)


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Surroundings of an interface: the transport, the fields that have arrived, and the implicit
    ones of this pass.

    `passed` gives the elements that particles pass in a step, and the weight of the next one in
    displacements at the point that they come from.
    """

    transport: Transport
    arrived: Fields = field(default_factory=dict)
    implicit: Fields = field(default_factory=dict)
    passed: Callable[[], tuple[int, float]] = lambda: (0, 0.0)

    def under(self, fields: Fields) -> Surroundings:
        """Copy with these implicit fields added."""
        return replace(self, implicit={**self.implicit, **fields})


class Response(Protocol):
    """Response of a contact, as interfaces read it."""

    @property
    def pressure(self) -> np.ndarray: ...

    @property
    def traction(self) -> np.ndarray: ...

    @property
    def fields(self) -> Fields:
        """Implicit fields under which the response was found; none if it comes from elsewhere."""

    @property
    def shift(self) -> np.ndarray:
        """Local shift E."""

    @property
    def slip_shift(self) -> np.ndarray:
        """Shift by slip: E less what flows within the bound."""

    @property
    def slips(self) -> np.ndarray:
        """Mask of the elements that slip."""

    @property
    def sticks(self) -> np.ndarray:
        """Mask of the elements that stick."""

    @property
    def slip(self) -> np.ndarray:
        """Sizes of relative slip, zero where nothing slips."""

    @property
    def unit_slip(self) -> float:
        """The shift that is a relative slip of 1."""

    @property
    def flowed(self) -> np.ndarray:
        """Shift that flowed within the bound."""

    @property
    def slip_bound(self) -> np.ndarray:
        """The traction from which the surfaces slip over each other."""

    @property
    def own_influence(self) -> float:
        """Influence of an element on itself."""

    def work(self) -> np.ndarray:
        """Work of friction in the step, per area."""

    def elastic_shift(self, traction: np.ndarray) -> np.ndarray:
        """Shift by tractions."""

    def under(self, fields: Fields) -> Response:
        """Response of the same contact, judged with these implicit fields in place of its own."""


@dataclass(frozen=True, eq=False)
class StepBefore:
    """End of the previous step: pressure, tractions, relative slip, masks of slip and stick, the
    quantities that its particles carry, and the heat of all steps so far.
    """

    pressure: np.ndarray
    traction: np.ndarray
    slip: np.ndarray
    slips: np.ndarray
    sticks: np.ndarray
    carried: Fields = field(default_factory=dict)
    heat: Sequence[Any] = ()


Start = str | StepBefore | None
"""Start of the search among several solutions: "stick" or "slip" everywhere, or another solution;
None: the fields that have arrived, else stick."""


@dataclass(frozen=True, eq=False)
class BetweenBodies:
    """Data from which interfaces are built: scene, current friction and motion, grid and scales."""

    scene: Scene
    friction: Friction | None
    motion: Motion | None
    grid: Grid
    scales: Scales


class Interface(ABC):
    """Interface without memory; each kind overrides what differs."""

    frictionless: bool = False
    """True for an interface that carries no tangential traction."""
    unbounded: bool = False
    """True for an interface that carries every traction."""
    flows: bool = False
    """True for an interface that can flow, in addition to slip of the surfaces."""
    by_slip: bool = False
    """True if its implicit fields follow from slip; else they follow from tractions alone."""

    def those(self, *, by_slip: bool) -> Interface | None:
        """Interfaces whose implicit fields follow from slip, or from tractions alone."""
        if self.by_slip != by_slip:
            return None
        return self

    @property
    def needs(self) -> tuple[str, ...]:
        """Names of the fields of other interfaces that this one reads."""
        return ()

    @property
    def gives(self) -> tuple[str, ...]:
        """Names of the fields that this interface provides to others, besides its implicit ones."""
        return ()

    @property
    def carried(self) -> tuple[Quantity, ...]:
        """The quantities that particles carry from step to step."""
        return ()

    def coefficient(self, at: Surroundings) -> float | np.ndarray | None:
        """Ratio of the traction bound to the pressure; None if there is none."""
        return None

    def implicit(self, transport: Transport) -> tuple[Quantity, ...]:
        """The quantities that the contact itself determines."""
        return ()

    @abstractmethod
    def potential(self, pressure: np.ndarray, at: Surroundings) -> Potential:
        """The potential on the grid under a pressure (ny, nx)."""

    def slip_bound(self, pressure: np.ndarray, at: Surroundings) -> np.ndarray:
        """The traction from which the surfaces slip over each other (ny, nx)."""
        return self.potential(pressure, at).bound

    def first(self, start: Start, at: Surroundings, shape: tuple[int, int]) -> Fields:
        """Implicit fields of the first pass: those carried by arriving particles, else those of
        fresh ones; `start` may choose between several solutions.
        """
        return {
            each.name: at.arrived.get(each.name, np.full(shape, each.fresh))
            for each in self.implicit(at.transport)
        }

    def implied(self, response: Response, at: Surroundings) -> Fields:
        """Implicit fields implied by a response, whatever its origin."""
        return {}

    def after(self, response: Response, at: Surroundings) -> Fields:
        """Implicit fields of the next pass, after a pass under those of `at`."""
        return self.implied(response, at)

    def leave(self, response: Response, at: Surroundings) -> Fields:
        """Quantities that particles carry at the end of a step."""
        return {}

    def arrive(self, before: StepBefore, at: Surroundings) -> Fields:
        """Quantities that particles carry into the next step, at their new places."""
        return {
            each.name: further_along(before.carried[each.name], at.transport.columns, each.fresh)
            for each in self.carried
            if each.name in before.carried
        }

    def warnings(self, response: Response, at: Surroundings) -> tuple[str, ...]:
        """Warnings of the interface about a doubtful step, as sentences."""
        return ()


def together(parts: tuple[Interface, ...]) -> Interface | None:
    """Several interfaces as one, None for none; refused if one reads a field that no earlier one
    provides, or if two own the same quantity.
    """
    if not parts:
        return None
    if len(parts) > 1:
        return Several(parts)
    _refuse_missing(parts)
    return parts[0]


def _refuse_shared(parts: tuple[Interface, ...]) -> None:
    names = [quantity.name for part in parts for quantity in part.carried]
    shared = sorted({name for name in names if names.count(name) > 1})
    if shared:
        owners = ", ".join(type(part).__name__ for part in parts)
        raise SceneError("interfaces", shared[0], f"carried by one of {owners} only")


def _refuse_missing(parts: tuple[Interface, ...]) -> None:
    given: set[str] = set()
    for part in parts:
        missing = sorted(set(part.needs) - given)
        if missing:
            reader = type(part).__name__
            allowed = f"given by an interface before {reader}, which reads it"
            raise SceneError("interfaces", missing[0], allowed)
        given.update(part.gives)


@dataclass(frozen=True, eq=False)
class Several(Interface):
    """Several interfaces acting together: the smallest bound holds, one of them may flow, and each
    reads the fields of the earlier ones.
    """

    parts: tuple[Interface, ...]

    def __post_init__(self) -> None:
        _refuse_shared(self.parts)
        _refuse_missing(self.parts)

    @property
    def frictionless(self) -> bool:  # type: ignore[override]
        return any(part.frictionless for part in self.parts)

    @property
    def unbounded(self) -> bool:  # type: ignore[override]
        return all(part.unbounded for part in self.parts)

    @property
    def flows(self) -> bool:  # type: ignore[override]
        return any(part.flows for part in self.parts)

    @property
    def gives(self) -> tuple[str, ...]:
        return tuple(name for part in self.parts for name in part.gives)

    @property
    def carried(self) -> tuple[Quantity, ...]:
        return tuple(each for part in self.parts for each in part.carried)

    def coefficient(self, at: Surroundings) -> float | np.ndarray | None:
        known = (part.coefficient(at) for part in self.parts)
        return next((each for each in known if each is not None), None)

    def implicit(self, transport: Transport) -> tuple[Quantity, ...]:
        return tuple(each for part in self.parts for each in part.implicit(transport))

    def potential(self, pressure: np.ndarray, at: Surroundings) -> Potential:
        combined = self.parts[0].potential(pressure, at)
        for part in self.parts[1:]:
            combined = combined & part.potential(pressure, at)
        return combined

    def slip_bound(self, pressure: np.ndarray, at: Surroundings) -> np.ndarray:
        bounds = [part.slip_bound(pressure, at) for part in self.parts]
        return np.asarray(np.minimum.reduce(bounds))

    def first(self, start: Start, at: Surroundings, shape: tuple[int, int]) -> Fields:
        return _collected(part.first(start, at, shape) for part in self.parts)

    def implied(self, response: Response, at: Surroundings) -> Fields:
        found: dict[str, np.ndarray] = {}
        for part in self._asked():
            found.update(part.implied(response, at.under(found)))
        return found

    def after(self, response: Response, at: Surroundings) -> Fields:
        found: dict[str, np.ndarray] = {}
        for part in self._asked():
            found.update(part.after(response, at.under(found)))
        return found

    def leave(self, response: Response, at: Surroundings) -> Fields:
        return _collected(part.leave(response, at) for part in self.parts)

    def arrive(self, before: StepBefore, at: Surroundings) -> Fields:
        found: dict[str, np.ndarray] = {}
        for part in self.parts:
            found.update(part.arrive(before, replace(at, arrived=found)))
        return found

    def warnings(self, response: Response, at: Surroundings) -> tuple[str, ...]:
        given: dict[str, np.ndarray] = {}
        for part in self._asked():
            if part.gives:
                given.update(part.implied(response, at.under(given)))
        at = at.under(given)
        return tuple(each for part in self.parts for each in part.warnings(response, at))

    def those(self, *, by_slip: bool) -> Interface | None:
        if by_slip:
            return self._by_slip
        return self._by_traction

    @lazy_property
    def _by_slip(self) -> Interface | None:
        return together(tuple(part for part in self.parts if part.by_slip))

    @lazy_property
    def _by_traction(self) -> Interface | None:
        return together(tuple(part for part in self.parts if not part.by_slip))

    def _asked(self) -> Iterator[Interface]:
        """Interfaces without those whose fields no other interface reads."""
        read = {name for part in self.parts for name in part.needs}
        return (part for part in self.parts if not part.gives or read.intersection(part.gives))


def _collected(fields: Iterable[Fields]) -> Fields:
    return {name: field for each in fields for name, field in each.items()}
