"""Areas of a solution that its linearised problem keeps fixed, and the leading edge of rolling if
it moves.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from varcontact.discrete.stick_slip import SLIP, STICK
from varcontact.gradients.contact_fields import ContactFields
from varcontact.interfaces.potential import dot
from varcontact.results.linearised import moving_edge
from varcontact.results.solution import Solution
from varcontact.system.process import lazy_property

Part = tuple[slice, slice]
"""Rows and columns of a grid."""


@dataclass(frozen=True, eq=False)
class HeldAreas:
    """Areas and directions of a solution, which the linearised problem holds."""

    contact: np.ndarray
    stick: np.ndarray
    slip: np.ndarray
    along: np.ndarray  # (2, ny, nx) n where it slips, else zero
    turning: np.ndarray  # |E|/g where it slips, dimensionless
    growing: np.ndarray  # (2, ny, nx) change of tractions by pressure
    falling: np.ndarray  # change of the bound by local shift, dimensionless; zero without slip

    @classmethod
    def of(cls, solution: Solution, fields: ContactFields) -> HeldAreas:
        shape = solution.grid.shape
        nothing = np.zeros(shape, bool)
        zero = np.zeros((2, *shape))
        contact = solution.pressure > 0
        scene = solution.scene
        if scene.motion is None or scene.frictionless:
            return cls(contact, nothing, nothing, zero, zero[0], zero, zero[0])
        bounded = solution.traction_bound > 0
        stick = bounded & (solution.state == STICK)
        slip = bounded & (solution.state == SLIP)
        size = np.where(slip, np.hypot(*solution.traction), 1.0)
        along = np.where(slip, solution.traction / size, 0.0)
        turning = np.hypot(*fields.local_shift) * slip / size / fields.compliance
        growing = along * fields.bound_by_pressure
        falling = slip * fields.bound_by_slip / fields.rolled * fields.compliance
        return cls(contact, stick, slip, along, turning, growing, falling)

    def on(self, part: Part) -> HeldAreas:
        """Areas and directions on a part of the grid."""
        of_part = {each.name: getattr(self, each.name)[..., *part] for each in fields(self)}
        return HeldAreas(**of_part)

    @lazy_property
    def across(self) -> np.ndarray:
        """Unit vectors t across the slipping tractions, (2, ny, nx)."""
        return np.array([-self.along[1], self.along[0]])

    @lazy_property
    def bound_follows_slip(self) -> bool:
        """True where the friction law depends on slip."""
        return bool(self.falling.any())

    def within(self, fields: np.ndarray) -> np.ndarray:
        """Components of fields (2, ny, nx) in the free directions: both where an element sticks,
        across the traction where it slips.
        """
        free: np.ndarray = self.stick * fields + self.across * dot(self.across, fields)
        return free

    def outward(self, fields: np.ndarray) -> np.ndarray:
        """Parts of fields (2, ny, nx) along the traction where its bound follows the slip."""
        return self.along * (dot(self.along, fields) * (self.falling != 0))

    def rows(self, fields: np.ndarray) -> np.ndarray:
        """Fields (2, ny, nx) in the space of the unknown multipliers."""
        if not self.bound_follows_slip:
            return self.within(fields)
        return self.within(fields) + self.outward(fields)

    def shifts(self, unknowns: np.ndarray) -> np.ndarray:
        """Multipliers of the shift (2, ny, nx) by the unknown ones: along the traction those of its
        bound, times the change of the bound by the shift.
        """
        if not self.bound_follows_slip:
            return unknowns
        outward = self.outward(unknowns)
        return unknowns - outward + self.falling * outward

    def diagonal(self, unknowns: np.ndarray) -> np.ndarray:
        """Diagonal parts of the rows without elasticity: from tractions that turn, and from their
        bound.
        """
        if not self.bound_follows_slip:
            return self.turning * unknowns
        outward = self.outward(unknowns)
        return self.turning * (unknowns - outward) + outward


@dataclass(frozen=True, eq=False)
class MovingEdge:
    """Tractions that particles bring in where load or shape move the leading edge of rolling.

    There pressure and traction change as 1/sqrt of the distance from the edge, in the ratio
    `entering` (2, ny, nx). Elements whose slip difference reaches over the edge take the shift by
    these tractions as many columns further on: `reaching` has the elements and the columns.
    """

    entering: np.ndarray
    reaching: tuple[tuple[np.ndarray, int], ...] = ()

    def on(self, part: Part) -> MovingEdge:
        """Moving edge on a part of the grid."""
        reaching = tuple((elements[part], columns) for elements, columns in self.reaching)
        return MovingEdge(self.entering[..., *part], reaching)

    def passed(self, multipliers: np.ndarray) -> np.ndarray:
        """Multipliers moved to where the shift by entering tractions is taken, less themselves."""
        moved = np.zeros_like(multipliers)
        for elements, columns in self.reaching:
            own = multipliers * elements
            moved += np.roll(own, -columns, axis=2) - own
        return moved


def with_moving_edge(
    solution: Solution, fields: ContactFields, areas: HeldAreas
) -> tuple[HeldAreas, MovingEdge]:
    """Areas and edge with the tractions that particles bring in at a moving leading edge."""
    shape = solution.grid.shape
    entering, reaching, thin = moving_edge(solution, fields.disc, areas.stick | areas.slip)
    entering = entering.reshape(2, *shape)
    thin = thin.reshape(shape)
    columns = tuple((elements.reshape(shape), count) for elements, count in reaching)
    growing = np.where(thin, entering, areas.growing)
    return replace(areas, growing=growing), MovingEdge(entering, columns)
