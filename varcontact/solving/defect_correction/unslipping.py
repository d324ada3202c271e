"""The field of a contact in which nothing slips: exact weights, first moments, and slip half an element ahead."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from varcontact.discrete.subgrid import means
from varcontact.elasticity.ellipsoidal import rooted_gradients
from varcontact.solving.defect_correction.moments import Spread, Weight, over_ellipse
from varcontact.solving.defect_correction.parts import Parts
from varcontact.solving.defect_correction.rooted import Rooted, mean_gradients, rooted
from varcontact.solving.defect_correction.slopes import Around
from varcontact.solving.defect_correction.sublattice import Sublattice, loads

ENOUGH = 4
"""Elements in a row from which factors are found in the rows around: of fewer, their errors would be continued."""


@dataclass(frozen=True, eq=False)
class Still:
    """Parts of the elements of Hertz's contact, and the fields on them of which nothing slips.

    The ratio of such a field to the weight ``sqrt((e - x)/(e + x))`` is cubic between the elements, and beyond the
    outermost ones, along x/e and y. Parts have the force and the first moments of that field. What they miss of its
    derivative is known for a linear function over the root of the distance from the edge, and for one times that root:
    the one is taken behind the middle, the other ahead of it.

    Attributes
    ----------
    parts : Parts
    """

    parts: Parts

    @cached_property
    def integrals(self) -> tuple[Weight, Spread, Spread]:
        """The weight, and the tractions of known derivative: over the root, and times the root."""
        return over_ellipse(self.parts.lattice, *self.parts.axes)

    @property
    def weight(self) -> Weight:
        """What fields are a smooth factor of."""
        return self.integrals[0]

    @cached_property
    def known(self) -> tuple[Rooted, Rooted]:
        """What the parts miss of tractions over the root, and of tractions times the root."""
        (a, b), lattice, nu = self.parts.axes, self.parts.lattice, self.parts.disc.operators.nu
        _, over, times = self.integrals
        return (
            rooted(over.mean, rooted_gradients(a, b, nu=nu), lattice.sides[0], self.parts.derivative, over.placed),
            rooted(
                times.mean, mean_gradients(lattice, a, b, nu), lattice.sides[0], self.parts.derivative, times.placed
            ),
        )

    @cached_property
    def around(self) -> Around:
        """Derivatives around the places where the weight in the parts is centred."""
        return Around.at(self.weight.x, self.weight.y, self.weight.mean > 0)

    @cached_property
    def rows(self) -> np.ndarray:
        """Whether a row of elements has enough of them for factors to be found from it, (ny,)."""
        many = np.count_nonzero(self.parts.elements > 0, axis=1)
        return np.asarray(many >= min(ENOUGH, many.max()))

    @cached_property
    def neighbours(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows and columns of the elements from which each part's factor is found, and shares, (16, ...)."""
        grid, contact, weight, (a, b) = self.parts.disc.lattice, self.parts.elements > 0, self.weight, self.parts.axes
        inside = np.flatnonzero(self.rows)
        first, last = contact.argmax(axis=1), contact.shape[1] - 1 - contact[:, ::-1].argmax(axis=1)
        place, found = weight.x / _half(weight.y, a, b), []
        for row, part in _cubic(weight.y, grid.y, inside[0], inside[-1]):
            along = _cubic(place * _half(grid.y[row], a, b), grid.x, first[row], last[row])
            found += [(row, column, part * share) for column, share in along]
        rows, columns, shares = (np.array(each) for each in zip(*found, strict=True))
        return rows, columns, shares

    def spread(self, traction: np.ndarray) -> Spread:
        """A traction of which the factor of the weight is linear around each part.

        Parameters
        ----------
        traction : ndarray, shape (2, ny rows, nx columns)
            Dimensionless; as `field` has it.
        """
        weight, (dx, dy) = self.weight, self.parts.lattice.sides
        inside = weight.mean > 0
        factor = np.where(inside, traction / np.where(inside, weight.mean, 1.0), 0.0)
        x, y = np.meshgrid(self.parts.lattice.x, self.parts.lattice.y)
        rises = self.around.gradients(factor)
        along = traction * (weight.x - x) / dx + rises[0] * weight.along
        across = traction * (weight.y - y) / dy + rises[1] * weight.across
        return Spread(traction, along, across)

    def elastic_shift(self, traction: np.ndarray) -> np.ndarray:
        """What a traction adds to the continuum's local shift in a step of the coarse grid, means over the parts.

        Parameters
        ----------
        traction : ndarray, shape (2, ny rows, nx columns)
            Dimensionless; as `field` has it.

        Returns
        -------
        ndarray, shape (2, ny rows, nx columns)
            Dimensionless.
        """
        parts, (behind, ahead) = self.parts, self.known
        lacking = np.where(parts.lattice.x < 0, behind.lacking(traction), ahead.lacking(traction))
        return np.asarray(parts.derivative.apply(self.spread(traction).placed) + lacking) * parts.steps

    def on_elements(self, field: np.ndarray) -> np.ndarray:
        """Means from the middle of each element to the middle of the one ahead.

        The slip of the coarse elements, too, is that half an element ahead: so passes settle. Behind the middle parts
        count by their share in the contact. Ahead of it all that are touched count alike: else an element whose middle
        is next to the edge would have hardly any slip.

        Parameters
        ----------
        field : ndarray, shape (..., ny rows, nx columns)

        Returns
        -------
        ndarray, shape (..., ny, nx)
            Zero where nothing is in contact.
        """
        half = self.parts.cells[1] // 2
        pad = [(0, 0)] * (field.ndim - 1) + [(0, half)]
        sums = means(np.pad(field * self.counts, pad)[..., half:], self.parts.cells)
        share = means(np.pad(self.counts, pad[-2:])[..., half:], self.parts.cells)
        return sums / np.where(share > 0, share, 1.0)

    @cached_property
    def counts(self) -> np.ndarray:
        """How much each part counts in the slip of the elements."""
        hertz, lines = self.parts.disc.hertz, self.parts.grid.lines
        assert hertz is not None
        touched = self.weight.mean > 0
        return np.where(self.parts.lattice.x < 0, hertz.covered(*lines), 1.0) * touched


@dataclass(frozen=True, eq=False)
class Unslipping(Sublattice):
    """Tractions on parts of elements of which none slips.

    Attributes
    ----------
    still : Still
    elements : ndarray, shape (2, ny, nx)
        Tractions along x and y of the coarse elements where the factor is one; not zero where there is a bound.
    """

    still: Still
    elements: np.ndarray

    def field(self, traction: np.ndarray) -> np.ndarray:
        """The traction on the parts, from that on the elements.

        Parameters
        ----------
        traction : ndarray, shape (2, ny, nx)
            In the unit of the bounds.

        Returns
        -------
        ndarray, shape (2, ny rows, nx columns)
            Within the bound.
        """
        factor = np.where(self.parts.elements > 0, traction / np.where(self.elements > 0, self.elements, 1.0), 0.0)
        rows, columns, shares = self.still.neighbours
        found = np.sum(factor[:, rows, columns] * shares, axis=1) * self.still.weight.mean
        size = np.hypot(*found)
        return np.asarray(found * np.minimum(1.0, self.bound / np.where(size > 0, size, 1.0)))

    def elastic_shift(self, traction: np.ndarray) -> np.ndarray:
        """As of `Still`."""
        return self.still.elastic_shift(traction)

    def on_elements(self, field: np.ndarray) -> np.ndarray:
        """As of `Still`."""
        return self.still.on_elements(field)

    def forces(self, traction: np.ndarray) -> np.ndarray:
        """Fx, Fy and Mz of tractions on the parts, physical; Mz with their moments within these.

        Parameters
        ----------
        traction : ndarray, shape (2, ny rows, nx columns)
            Dimensionless; as `field` has it.

        Returns
        -------
        ndarray, shape (3,)
        """
        grid, pressure, spread = self.parts.grid, self.parts.disc.scales.pressure, self.still.spread(traction)
        dx, dy = grid.sides
        within = np.sum(dx * spread.along[1] - dy * spread.across[0]) * grid.area * pressure
        return loads(traction * pressure, grid) + np.array([0.0, 0.0, within])


def _half(y: np.ndarray, a: float, b: float) -> np.ndarray:
    """Half length of the ellipse at y; outside it that of a place next to its end."""
    return np.asarray(a * np.sqrt(np.maximum(1 - (y / b) ** 2, 1e-12)))


def _cubic(
    place: np.ndarray, centres: np.ndarray, first: np.ndarray, last: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray]]:
    """The four elements in line from `first` to `last` that are nearest to each place, and their shares.

    Shares are those of Lagrange's interpolation, and beyond the outermost elements of its continuation. Where the line
    has fewer elements the degree is less, and those that are named twice have no share.
    """
    side = centres[1] - centres[0] if centres.size > 1 else 1.0
    at = (place - centres[0]) / side
    start = np.clip(np.floor(at).astype(int) - 1, first, np.maximum(last - 3, first))
    elements = [start + k for k in range(4)]
    found = []
    for one in elements:
        share = np.where(one <= last, 1.0, 0.0)
        for other in elements:
            if other is not one:
                share = share * np.where(other <= last, (at - other) / (one - other), 1.0)
        found.append((np.minimum(one, last), share))
    return found
